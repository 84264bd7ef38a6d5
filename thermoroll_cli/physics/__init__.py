"""Physics of one half-space or of two: each package answers one question on one grid and knows neither files nor results."""

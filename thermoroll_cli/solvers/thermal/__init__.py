"""Temperature and thermal expansion from heat: Eqs. 17–20."""

"""From coarse grids to fine ones: the plan, the starts, the error estimates."""

"""Stresses and temperatures below the surface of each body."""

"""Algorithms that know nothing of contacts: mixing of fixed points, Krylov iterations, interpolation between grids."""

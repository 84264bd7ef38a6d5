"""Grids, FFT convolutions, Krylov and fixed-point iterations: mathematics that knows no physics."""

"""Numerical tools that know no physics.

`grid` is the uniform grid, the interpolation from one grid to another, and formulas on the elements around each one.
`convolution` convolves fields with influence tables by FFT, in free space, and with half the elements where fields are even or
odd. `krylov` solves linear systems by GMRES, one or many at once, and accelerates fixed points.
"""

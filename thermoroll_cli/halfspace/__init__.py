"""Influence coefficients: the response of one half-space to load and heat on one rectangular element.

`elastic`: displacements of the surface by pressure and tractions. `thermal`: temperature and expansion of the
surface by heat, for material that moves at one speed; `variable_peclet`: at a speed that differs from element to element.
`subsurface_elastic` and `subsurface_thermal`: stresses and temperatures below the surface.
"""

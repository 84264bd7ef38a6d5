"""Influence coefficients: the response of one half-space to load and heat on one rectangular element.

`elastic` computes displacements of the surface by pressure and tractions. `thermal` computes temperature and expansion of the
surface by heat, for material that moves at one speed, and `variable_peclet` at a speed that differs from element to element.
`subsurface_elastic` and `subsurface_thermal` compute stresses and temperatures below the surface. `layered`, `layered_stress`
and `layered_thermal` do the same for coated bodies, and `coatings` joins both bodies of a contact.
"""

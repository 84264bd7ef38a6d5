"""Influence coefficients: the response of bodies to load and heat on one rectangular element.

`elastic` computes displacements of the surface by pressure and tractions. `thermal` computes temperature and expansion of the
surface by heat, for material that moves at one speed, and `variable_peclet` at a speed that differs from element to element.
`subsurface_elastic` and `subsurface_thermal` compute stresses and temperatures below the surface. `layered`, `layered_stress`
and `layered_thermal` do the same for coated bodies, `relaxing` and `relaxing_layers` for bodies that relax. `bodies` joins
both bodies of a contact.
"""

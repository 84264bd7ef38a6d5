"""Exact and classical solutions of rolling contact, for checking the program and for hand calculations.

Every module is one solution; import what you need from it (this package itself imports nothing):

    heated_sphere      round contact that slides and heats itself, sources at rest: the coupled thermo-elastic state
    hertz              elliptic normal contact: semi-axes, pressure, displacement and gap everywhere on the surface
    cattaneo_mindlin   tangential loading of a Hertz contact: full slip and partial slip, no rolling
    carter             tractive rolling of cylinders (2-D): creepage, force, traction, slip, heat
    kalker             creepage coefficients, linear creep forces, saturation, FASTSIM flexibilities
    simplified_theories  creep forces by FASTSIM and by Polach's formulas
    rotating_cylinder  temperature of a cylinder that turns under a heat source and cools by convection
    moving_sources     temperature under moving point and rectangular heat sources on a half-space
    moving_ellipse     temperature under moving circles and ellipses: uniform, Hertz-shaped, paraboloid; means
    source_limits      fast bands, sources at rest, Tian & Kennedy's closed forms
    spence             normal indentation with friction between different materials: the stick circle
    bentall_johnson    free rolling of cylinders of different materials at low friction

Quantities are in any one consistent set of units (SI within this program). Material flows towards +x: the leading
edge of a contact is at −x.
"""

"""Exact and classical solutions of rolling contact, for checking the program and for hand calculations.

Import what you need from the modules (this package itself imports nothing):

    heated_sphere      round contact that slides and heats itself, sources at rest: the coupled thermo-elastic state
    hertz              elliptic normal contact: semi-axes, pressure, displacement and gap everywhere on the surface
    cattaneo_mindlin   tangential loading of a Hertz contact: full slip and partial slip, no rolling
    rolling_cylinders  2-D: tractive rolling (Carter), free rolling of different materials (Bentall & Johnson)
    kalker             creepage coefficients, creep forces: linear, by FASTSIM and by Polach's formulas
    moving_sources     temperature under moving rectangles, circles and ellipses, fast bands, handbook formulas; of a
                       cylinder that turns under a source and cools by convection
    shakedown_limits   elastic and shakedown limits of rolling and sliding contacts
    spence             normal indentation with friction between different materials: the stick circle

Quantities are in any one consistent set of units (SI within this program). Material flows towards +x: the leading
edge of a contact is at −x.
"""

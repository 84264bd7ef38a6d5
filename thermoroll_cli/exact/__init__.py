"""Exact and classical solutions of rolling contact, for checking the program and for hand calculations.

Every module is one solution; import what you need from it (this package itself imports nothing):

    hertz              elliptic normal contact: semi-axes, pressure, displacement and gap everywhere on the surface
    cattaneo_mindlin   tangential loading of a Hertz contact: full slip and partial slip, no rolling
    carter             tractive rolling of cylinders (2-D): creepage, force, traction, slip, heat
    kalker             creepage coefficients, linear creep forces, saturation, FASTSIM flexibilities
    moving_sources     temperature of moving heat sources on a half-space, exact and in the fast and slow limits
    spence             frictional indentation with stick (Spence's self-similar contact)
    bentall_johnson    free rolling of cylinders of different materials: the creepage without traction

Quantities are in any one consistent set of units (SI within this program). Material flows towards +x: the leading
edge of a contact is at −x.
"""

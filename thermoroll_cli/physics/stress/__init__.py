"""Stresses and temperatures below the surface of each body, depth by depth.

`superposition` convolves the loads of the surface with the coefficients of one depth; `body_stresses` collects the depths of a
body: fields and the places of the largest values. `strength` has equivalent stresses, shakedown and fatigue, with the
`smallest_ball` around stress states. Histories along x at fixed y and z are rows of these fields.
"""

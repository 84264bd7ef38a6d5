"""Stresses and temperatures below the surface of each body, layer by layer.

`superposition` convolves the loads of the surface with the coefficients of one depth; `body_stresses` collects the layers of a
body: fields, invariants and the places of the largest values (`invariants`, `peaks`). Histories along x at fixed y and z are
rows of these fields.
"""

"""Tangential contact: creepages and pressure in, tractions, slip and its heat out (Eqs. 7–15).

`rolling_gradient` is the displacement by tractions and its discrete ∂u/∂x, `element_borders` its corrections where a border
cuts elements. `newton` and `rolling_solver` solve Coulomb's law with them, `slip_friction` is friction that depends on slip,
`stick_inverse` is the preconditioner. `differential_slip` is the creepage that varies across the contact, `slip_heat` the heat
of slip in each element.
"""

"""Frictional heat: heat flux in, its division between the bodies, temperature and thermal expansion out (Eqs. 16–20).

`heat_response` responds to heat at one speed of the material, `sliding_heat` at the local slip speed. `recirculation` adds the
recirculating heat of bodies that turn. `frictional_heat` divides the heat of a state between the bodies, in given shares or so
that both surfaces are equally warm, and computes temperatures and expansion.
"""

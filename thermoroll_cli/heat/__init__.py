"""Frictional heat: heat flux in, its division between the bodies, temperature and thermal expansion out (Eqs. 16–20).

`heat_response` responds to heat at one speed of the material, `sliding_heat` at the local slip speed. `recirculation` adds the
heat that bodies bring back after a revolution. `frictional_heat` is the heat of a state with all its consequences, divided in
given shares or so that both surfaces are equally warm.
"""

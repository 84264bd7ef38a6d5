"""The steady state on one grid: press, roll, heat, expand, until nothing changes any more (Fig. 2).

`derived` are quantities of the problem alone: Hertz's contact, compliances, slip without traction, speeds of the bodies.
`discretisation` holds the solvers of one grid. `iteration` is one pass through the article's Fig. 2, `fixed_point` iterates it
with mixing; `heated_pressure` finds the pressure that is in balance with its own heat, `friction` follows the temperature.
"""

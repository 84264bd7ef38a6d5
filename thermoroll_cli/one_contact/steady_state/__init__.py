"""The steady state on one grid: press, roll, heat, expand, until nothing changes any more (Fig. 2).

`derived` are quantities of the problem alone: Hertz's contact, compliances, slip without traction. `heated_bodies` are the
bodies as their thermal responses need them. `solvable` refuses what has no solution, `doubts` are of what is allowed and yet
doubtful. `discretisation` holds the solvers of one grid, `pressure` and `traction` for its two contact problems. `iteration` is
one pass through the article's Fig. 2, with friction that depends on the temperature; `fixed_point` iterates it with mixing,
where heat is strong from a pressure in balance with it. `scalars` makes fields and scalars of a state.
"""

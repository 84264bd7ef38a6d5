"""From coarse grids to fine ones, and from states to a result.

`plan` decides which stages run on which grids. `solve` goes through the grids (`refine`), first without thermal deformation;
`limit` follows the creep curve to its maximum if friction falls with slip. `checks` examines the states, `error_estimates`
estimates their errors, `warnings` says what is doubtful, `outcome` assembles the result. `subsurface_plan` and
`subsurface_stage` do the same below the surface.
"""

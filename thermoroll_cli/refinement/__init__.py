"""From coarse grids to fine ones, and from fields to a result.

`plan` decides which stages run on which grids, `warnings` judges a problem before it is solved and its result afterwards.
`solve` goes through the grids: `starts` are first guesses, which also move the domain along with a heated contact; `limit`
follows the creep curve to its maximum if friction falls with slip. `scalars` makes reported states of fields, `checks`
examines them, `error_estimates` estimates their errors, `outcome` assembles the result. `subsurface_plan` and
`subsurface_stage` do the same below the surface.
"""

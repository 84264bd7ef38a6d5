"""Stresses below the surface of the state that is reported: a stage whose code is imported only where a case asks for it."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.plan import Plan
from thermoroll_cli.refinement.refinement_level import RefinementLevel
from thermoroll_cli.refinement.subsurface_stage import SolvedGrid, below_the_surface

GRIDS = 3
"""The finest grids that are solved tell the error."""


def with_subsurface(result: Result, plan: Plan, levels: list[RefinementLevel]) -> Result:
    """`result` with the stresses inside the bodies, where its problem asks for them and its state is one."""
    request = result.problem.subsurface
    if request is None or not all(np.isfinite(values).all() for values in result.coupled.fields.values()):
        return result

    start = time.perf_counter()
    grids = [SolvedGrid(level.home, level.contact) for level in levels[-GRIDS:]]
    reference = {**result.coupled.scalars, **result.hertz}
    subsurface = below_the_surface(request, grids, reference, heated=plan.runs("heat"))
    seconds = {**result.work["seconds"], "below the surface": round(time.perf_counter() - start, 6)}
    return replace(result, subsurface=subsurface, work={**result.work, "seconds": seconds},
                   warnings=(*result.warnings, *subsurface.warnings))

"""Solve a problem: coarse grids first, each the start of the next, isothermal and coupled state side by side."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from thermoroll_cli.pipeline.checks import overheated
from thermoroll_cli.pipeline.coupling import Tolerances, couple, on_finer_grid
from thermoroll_cli.pipeline.estimate import ERROR_SCALARS, estimates
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.pipeline.limit import last_steady_state
from thermoroll_cli.pipeline.mechanical import mechanical
from thermoroll_cli.pipeline.outcome import result_of, scalars_by_level
from thermoroll_cli.pipeline.plan import Plan, make_plan
from thermoroll_cli.pipeline.problem import Problem
from thermoroll_cli.pipeline.result import Result
from thermoroll_cli.pipeline.rung import Neighbours, Rung, rung
from thermoroll_cli.pipeline.scene import Scene

Report = Callable[[str, Mapping[str, Any]], None]

GROWTH = 1.25
"""Factor by which the domain grows when the contact reaches its rim."""
LARGEST_EXTENT = 12.0


@dataclass
class _Stopwatch:
    """Wall seconds by stage."""

    seconds: dict[str, float] = field(default_factory=dict)

    def __call__(self, stage: str) -> _Lap:
        return _Lap(self.seconds, stage)


@dataclass
class _Lap:
    seconds: dict[str, float]
    stage: str
    start: float = 0.0

    def __enter__(self) -> None:
        self.start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.seconds[self.stage] = self.seconds.get(self.stage, 0.0) + time.perf_counter() - self.start


def solve(problem: Problem, *, threads: int = 1, report: Report | None = None) -> Result:
    """Solve `problem` and return its coupled and isothermal states.

    `threads` > 1 transforms the two traction components side by side (the result does not depend on it). `report` is
    called with a stage name and a mapping (grid, iteration, residual, …) as the work goes on. Raises ValueError where
    no steady state can exist; everything else that goes wrong is told in `Result.converged` and `Result.reason`.
    """
    return Solver(threads).solve(problem, report=report)


class Solver:
    """Solves problem after problem: each starts from the one before it where kernels and grids are the same.

    Neighbouring points of a sweep share their kernels and need a fraction of the iterations."""

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._neighbours = Neighbours()

    def solve(self, problem: Problem, *, report: Report | None = None) -> Result:
        """As the function `solve`."""
        result, too_hot = self._solve(problem, report)
        if too_hot:
            # Lower speeds have kernels of their own: a fresh solver each, and nothing of them is remembered.
            result = last_steady_state(problem, result, lambda p: Solver(self.threads)._solve(p, report)[0])
        return result

    def _solve(self, problem: Problem, report: Report | None) -> tuple[Result, bool]:
        """One attempt, and whether it failed for too much heat."""
        plan = make_plan(problem)
        while True:
            rungs, stopwatch = self._climb(problem, plan, report or (lambda stage, info: None))
            last = rungs[-1]
            if not last.touches_rim or plan.extent > LARGEST_EXTENT:
                break
            grown = plan.extent * GROWTH
            plan = replace(plan, extent=grown, warnings=[
                *plan.warnings, f"the contact reached the rim of the domain: extent grown to {grown:g}"])
        result = result_of(problem, plan, rungs, stopwatch.seconds)
        if result.converged:
            self._neighbours.remember(rungs)
        return result, last.isothermal.tangential.converged and overheated(last.isothermal, last.coupled)

    def _climb(self, problem: Problem, plan: Plan, report: Report) -> tuple[list[Rung], _Stopwatch]:
        scene = Scene(problem)
        stopwatch = _Stopwatch()
        rungs: list[Rung] = []
        neighbour: Rung | None = None
        for shape in plan.grids:
            below, below_last = (rungs[-1] if rungs else None), neighbour
            neighbour = self._neighbours.find(scene, shape, plan.extent)
            if neighbour is not None:
                level = neighbour.level
                level.show(scene)
            else:
                level = Level(scene, shape, plan.extent, self.threads)
            tolerances = Tolerances()
            # Pressure and shear that act on each other cost more turns from a looser start than it saves.
            if shape != plan.grids[-1] and not scene.feeds_back:
                tolerances = tolerances.on_the_way(problem.numerics.accuracy)
            with stopwatch("isothermal"):
                if neighbour is not None:
                    starts = [self._neighbours.predict(neighbour, below, below_last)]
                elif below is not None:
                    starts = [level.continue_from(below.level, below.isothermal, level.hertz)]
                else:
                    starts = []
                before = neighbour or below
                iso, feedback = mechanical(level, starts, tolerances,
                                           None if before is None else (before.level, before.isothermal))
            report("tangential", {"grid": list(shape), "applications": (feedback or iso.tangential).applications,
                                  "residual": iso.tangential.residual})
            coupled = None
            if plan.runs("deformation"):
                with stopwatch("coupling"):
                    # The coarser grid of the same problem starts a coupled state better than the neighbour on this grid.
                    if below is not None and below.coupled is not None:
                        start, offset = on_finer_grid(level, below.level, below.coupled.contact)
                    elif neighbour is not None and neighbour.coupled is not None:
                        start = neighbour.coupled.contact
                        offset = start.offset
                    else:
                        start, offset = iso, iso.offset
                    coupled = couple(level, start, offset, tolerances)
                report("coupling", {"grid": list(shape), "iteration": coupled.iterations, "residual": coupled.residual})
            with stopwatch("temperature"):
                rungs.append(rung(level, iso, coupled, plan, feedback))
            if rungs[-1].touches_rim:
                break
            if shape != plan.grids[-1] and _accurate_enough(problem, rungs):
                break
        return rungs, stopwatch


def _accurate_enough(problem: Problem, rungs: list[Rung]) -> bool:
    wanted = problem.numerics.accuracy
    if wanted is None or len(rungs) < 3:
        return False
    scene, elements = rungs[-1].level.scene, min(rungs[-1].level.grid.shape)
    # Of the state that is asked for; the isothermal one beside it has its own estimates.
    levels, _ = scalars_by_level(rungs)
    errors = estimates(levels, scene, elements)
    return all(errors[k] <= wanted for k in ERROR_SCALARS if not math.isnan(errors[k]))

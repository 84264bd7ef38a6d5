"""Solve a problem: coarse grids first, each the start of the next, isothermal and coupled state side by side."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from thermoroll_cli.pipeline.checks import failures
from thermoroll_cli.pipeline.contact import Contact
from thermoroll_cli.pipeline.coupling import Coupled, Tolerances, couple, expansion_of, isothermal, on_finer_grid
from thermoroll_cli.pipeline.estimate import ERROR_SCALARS, estimates
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.pipeline.plan import Plan, make_plan
from thermoroll_cli.pipeline.problem import Problem
from thermoroll_cli.pipeline.result import Result, State
from thermoroll_cli.pipeline.scene import Scene
from thermoroll_cli.pipeline.states import state_of

Report = Callable[[str, Mapping[str, Any]], None]

GROWTH = 1.25
"""Factor by which the domain grows when the contact reaches its rim."""


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


@dataclass(frozen=True)
class _Rung:
    """Both states on one grid, with their reported form."""

    level: Level
    isothermal: Contact
    coupled: Coupled | None
    isothermal_state: State
    coupled_state: State

    @property
    def contact(self) -> Contact:
        return self.isothermal if self.coupled is None else self.coupled.contact


def solve(problem: Problem, *, threads: int = 1, report: Report | None = None) -> Result:
    """Solve `problem` and return its coupled and isothermal states.

    `threads` > 1 transforms the two traction components side by side (the result does not depend on it). `report` is
    called with a stage name and a mapping (grid, iteration, residual, …) as the work goes on. Raises ValueError where
    no steady state can exist; everything else that goes wrong is told in `Result.converged` and `Result.reason`.
    """
    plan = make_plan(problem)
    while True:
        rungs, stopwatch = _climb(problem, plan, threads, report or (lambda stage, info: None))
        last = rungs[-1]
        if last.coupled is None or not last.coupled.touches_rim or plan.extent > 12.0:
            break
        grown = plan.extent * GROWTH
        plan = Plan(plan.grids, grown, plan.run, plan.skipped,
                    [*plan.warnings, f"the contact reached the rim of the domain: extent grown to {grown:g}"],
                    plan.facts, plan.memory_bytes, plan.seconds)
    return _result(problem, plan, rungs, stopwatch)


def _climb(problem: Problem, plan: Plan, threads: int, report: Report) -> tuple[list[_Rung], _Stopwatch]:
    scene = Scene(problem)
    stopwatch = _Stopwatch()
    rungs: list[_Rung] = []
    tolerances = Tolerances()
    for shape in plan.grids:
        finest = shape == plan.grids[-1]
        below = rungs[-1] if rungs else None
        level = Level(scene, shape, plan.extent, threads)
        with stopwatch("isothermal"):
            iso = isothermal(level, below.isothermal if below else None, below.level if below else None,
                             tolerances.tangential)
        report("tangential", {"grid": list(shape), "applications": iso.tangential.applications,
                              "residual": iso.tangential.residual})
        coupled = None
        if plan.runs("deformation"):
            with stopwatch("coupling"):
                if below is None or below.coupled is None:
                    start, expansion = iso, np.zeros(level.grid.shape)
                else:
                    start, expansion = on_finer_grid(level, below.level, below.coupled.contact)
                coupled = couple(level, start, expansion, tolerances)
            report("coupling", {"grid": list(shape), "iteration": coupled.iterations, "residual": coupled.residual})
        with stopwatch("temperature"):
            rungs.append(_rung(level, iso, coupled, plan))
        if coupled is not None and coupled.touches_rim:
            break
        if not finest and _accurate_enough(problem, rungs):
            break
    return rungs, stopwatch


def _rung(level: Level, iso: Contact, coupled: Coupled | None, plan: Plan) -> _Rung:
    heat = plan.runs("heat")
    # Without heat everything stays cold: known without asking a kernel.
    cold = not heat and level.scene.problem.heating.heat
    expansion = expansion_of(level, iso) if heat and level.scene.problem.heating.deformation else None
    if cold:
        expansion = np.zeros(level.grid.shape)
    iso_state = state_of(level, iso, temperatures=heat or cold, expansion=expansion)
    if coupled is None:
        return _Rung(level, iso, None, iso_state, iso_state)
    return _Rung(level, iso, coupled, iso_state,
                 state_of(level, coupled.contact, temperatures=True, expansion=coupled.contact.expansion))


def _accurate_enough(problem: Problem, rungs: list[_Rung]) -> bool:
    wanted = problem.numerics.accuracy
    if wanted is None or len(rungs) < 3:
        return False
    errors = estimates([r.coupled_state.scalars for r in rungs], problem)
    errors_iso = estimates([r.isothermal_state.scalars for r in rungs], problem)
    return all(e[k] <= wanted for e in (errors, errors_iso) for k in ERROR_SCALARS if not math.isnan(e[k]))


def _result(problem: Problem, plan: Plan, rungs: list[_Rung], stopwatch: _Stopwatch) -> Result:
    last = rungs[-1]
    scene = last.level.scene
    coupled_scalars = [r.coupled_state.scalars for r in rungs]
    errors = estimates(coupled_scalars, problem)
    reasons = failures(scene, last.level, last.isothermal, last.coupled)
    warnings = list(plan.warnings)
    wanted = problem.numerics.accuracy
    if wanted is not None:
        missed = [k for k in ERROR_SCALARS if errors[k] > wanted]
        if missed:
            worst = max(missed, key=lambda k: errors[k])
            reasons.append(f"accuracy {wanted:g} not reached on the finest grid tried ({last.level.grid.nx} elements per side): "
                           f"{worst} is good to {errors[worst]:.1e}; ask for less or set numerics.grid")
    hertz = {k: plan.facts[k] for k in ("hertz_a_mm", "hertz_b_mm", "hertz_p0_MPa", "peclet_lower", "peclet_upper")}
    history: dict[str, Any] = {}
    if last.coupled is not None:
        history["coupling_residual"] = np.array(last.coupled.history)
    return Result(
        problem=problem,
        x=last.level.grid.x,
        y=last.level.grid.y,
        coupled=last.coupled_state,
        isothermal=last.isothermal_state,
        hertz=hertz,
        converged=not reasons,
        reason="; ".join(reasons),
        error=errors,
        work=_work(plan, rungs, stopwatch),
        history=history,
        warnings=tuple(warnings),
    )


def _work(plan: Plan, rungs: list[_Rung], stopwatch: _Stopwatch) -> dict[str, Any]:
    levels = []
    for r in rungs:
        entry: dict[str, Any] = {
            "grid": list(r.level.grid.shape),
            "newton_steps": r.isothermal.tangential.newton_steps,
            "applications": r.isothermal.tangential.applications,
            "transforms": r.level.transforms,
        }
        if r.coupled is not None:
            entry |= {
                "coupling_iterations": r.coupled.iterations,
                "coupled_normal_iterations": r.coupled.normal_iterations,
                "coupled_newton_steps": r.coupled.newton_steps,
                "coupled_applications": r.coupled.tangential_applications,
            }
        levels.append(entry)
    last = rungs[-1].level.grid
    return {
        "grid": list(last.shape),
        "extent": plan.extent,
        "iterations": {k: levels[-1][k] for k in levels[-1] if k.endswith(("iterations", "steps"))},
        "applications": levels[-1]["applications"] + levels[-1].get("coupled_applications", 0),
        "levels": levels,
        "seconds": {k: round(v, 6) for k, v in stopwatch.seconds.items()},
        "skipped": dict(plan.skipped),
    }

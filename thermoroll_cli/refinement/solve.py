"""Solve a problem: coarse grids first, each the start of the next, isothermal and coupled state side by side."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from thermoroll_cli.numerics.convolution import counted
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.error_estimates import estimates, missed_accuracy
from thermoroll_cli.refinement.limit import beyond_maximum, creep_maximum, has_maximum, with_maximum
from thermoroll_cli.refinement.neighbours import SolvedBefore
from thermoroll_cli.refinement.outcome import (
    RefinementLevel,
    refinement_level,
    refining_both,
    result_of,
    scalars_by_level,
)
from thermoroll_cli.refinement.plan import Plan, make_plan
from thermoroll_cli.refinement.starts import Starts, followed_state, next_discretisation
from thermoroll_cli.refinement.subsurface_stage import with_subsurface
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation, SolverOptions, Tolerances
from thermoroll_cli.steady_state.fixed_point import fixed_point

LARGEST_EXTENT = 12.0
GROWTH = 1.25
"""Factor by which the domain grows when the contact reaches its rim."""
COARSE_TOLERANCE = 3.0
"""Factor by which coarser grids are solved less closely; neither finest grid nor estimates notice. Without: 2 to 4 % more work,
2.2 times as much at worst."""

Report = Callable[[str, Mapping[str, Any]], None]


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Adds the wall seconds of what is inside to those of a `stage`."""
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - start


def solve(
    problem: Problem, *, threads: int = 1, report: Report | None = None, options: SolverOptions | None = None
) -> Result:
    """Solve `problem` and return its coupled and isothermal states.

    `threads` > 1 transforms the two traction components side by side (the result does not depend on it). `report` is
    called with a stage name and a mapping (grid, iteration, residual, …) as the work goes on. `options` are for experiments
    with the solvers. Raises ValueError where no steady state can exist; everything else that goes wrong is reported in
    `Result.converged` and `Result.reason`.
    """
    return Solver(threads, options).solve(problem, report=report)


class Solver:
    """Solves problem after problem: each starts from what the last two predict, and uses the kernels of the last where grids
    are the same. Neighbouring points of a sweep, or steps of wear, take half of the work of a first one."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        self.threads = threads
        self.options = options or SolverOptions()
        self._solved: list[tuple[Problem, list[RefinementLevel]]] = []  # the last two, newest first
        self._followed: dict[Problem, float] = {}  # creep forces where friction falls with slip

    def solve(self, problem: Problem, *, report: Report | None = None) -> Result:
        """As the function `solve`."""
        return (self._on_falling_curve if has_maximum(problem) else self._solve)(problem, report)

    def _on_falling_curve(self, problem: Problem, report: Report | None) -> Result:
        """A prescribed force where friction falls with slip: the maximum of the creep curve is found first."""
        coarse = Solver(self.threads, self.options)
        try:
            maximum = creep_maximum(problem, coarse.solve, self._followed)
        except ArithmeticError as cause:
            result = self._solve(problem, report)
            return replace(result, warnings=(*result.warnings, f"the maximum of the creep curve was not found: {cause}"))
        if problem.prescribed_force > maximum.force:
            return beyond_maximum(problem, maximum, lambda point: self._solve(point, report))
        return with_maximum(self._solve(problem, report), maximum)

    def _solve(self, problem: Problem, report: Report | None) -> Result:
        """The result begun with neighbours, if there are any; if that fails, without them: no problem does worse than alone."""
        result = self._attempt(problem, report)
        if not result.converged and self._solved:
            self._solved = []
            result = self._attempt(problem, report)
        return result

    def _attempt(self, problem: Problem, report: Report | None) -> Result:
        plan = make_plan(problem, alone=not self.options.sequence)
        while True:
            levels, seconds = self._grid_sequence(problem, plan, report or (lambda stage, info: None))
            last = levels[-1]
            if not last.touches_rim or plan.extent > LARGEST_EXTENT:
                break
            grown = plan.extent * GROWTH
            plan = replace(plan, extent=grown, warnings=[
                *plan.warnings, f"the contact reached the rim of the domain: extent grown to {grown:g}"])
        # A coarser grid on which no steady state was found says nothing about the order in which errors fall.
        all_converged = all(level.coupled is None or level.coupled.converged for level in refining_both(levels)[-3:])
        result = result_of(problem, plan, levels, seconds, extrapolated=self.options.extrapolated and all_converged)
        result = with_subsurface(result, plan, levels)
        if result.converged:
            self._solved = [(problem, levels), *self._solved[:1]]
        return result

    def _grid_sequence(self, problem: Problem, plan: Plan, report: Report) -> tuple[list[RefinementLevel], dict[str, float]]:
        """Both states on each grid of the plan, coarse to fine, until one is accurate enough or too small; seconds by stage."""
        derived = plan.derived
        seconds: dict[str, float] = {}
        levels: list[RefinementLevel] = []
        coarser = neighbours = None
        before_this = SolvedBefore(problem, self._solved)
        for shape in plan.grids:
            before = counted.transforms
            neighbours = before_this.neighbours(shape, plan.extent, coarser, neighbours)
            shared = None if neighbours is None else neighbours.last.discretisation
            predicted = (None if neighbours is None
                         else neighbours.predicted(derived, derived.grid(shape, plan.extent), coupled=False))
            discretisation = (Discretisation(derived, shape, plan.extent, self.threads, self.options,
                                             coarser=None if coarser is None else coarser.discretisation,
                                             start=None if predicted is None else predicted.pressure(),
                                             tables=None if shared is None else shared.responses.tables)
                              if shared is None or not shared.has_kernels_of(derived, shape, plan.extent)
                              else shared.for_problem(derived))
            starts = Starts(discretisation, coarser, neighbours, predicted)
            tolerances = tolerances_on(shape, plan, derived, self.options)
            with timed(seconds, "isothermal"):
                isothermal = fixed_point(discretisation, starts.isothermal(), tolerances,
                                         learnt=starts.learnt(discretisation, coupled=False))
            report("tangential", {"grid": list(shape), "applications": isothermal.applications,
                                  "residual": isothermal.contact.tangential.residual})
            followed = None
            if plan.runs("deformation"):
                with timed(seconds, "coupling"):
                    followed = followed_state(starts, next_discretisation(starts), isothermal, tolerances)
                report("coupling", {"grid": list(shape), "iteration": followed.state.iterations,
                                    "residual": followed.state.residual})
            with timed(seconds, "temperature"):
                levels.append(refinement_level(discretisation, isothermal, followed, plan, before))
            if levels[-1].touches_rim or (shape != plan.grids[-1] and _accurate_enough(problem, levels, plan)):
                break
            coarser = levels[-1]
        return levels, seconds


def tolerances_on(
    shape: tuple[int, int], plan: Plan, derived: DerivedQuantities, options: SolverOptions
) -> Tolerances:
    """How closely the fixed point is solved on one grid of the plan: looser on grids that only lead to a finer one, and to its
    error estimates. If an accuracy is asked for, any grid may turn out to be the last, and its residual must not show in
    the estimates."""
    # Pressure and shear that act on each other cost more iterations from a looser start than it saves.
    closely = shape == plan.grids[-1] or derived.problem.numerics.accuracy is not None or derived.kinematics.feeds_back
    return options.tolerances if closely else options.tolerances.times(COARSE_TOLERANCE)


def _accurate_enough(problem: Problem, levels: list[RefinementLevel], plan: Plan) -> bool:
    wanted = problem.numerics.accuracy
    # Estimates of the state that is asked for; the isothermal one beside it has its own.
    scalars, _ = scalars_by_level(levels)
    if wanted is None or len(scalars) < 3:
        return False
    errors = estimates(scalars, levels[-1].discretisation.derived, levels[-1].elements_across, plan)
    return not missed_accuracy(errors, scalars[-1], wanted)

"""Solve a problem: coarse grids first, each the start of the next, isothermal and coupled state side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from thermoroll_cli.one_contact.refinement.error_estimates import Resolution, estimates, missed_accuracy
from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.refinement.limit import beyond_maximum, creep_maximum, has_maximum, with_maximum
from thermoroll_cli.one_contact.refinement.neighbours import at_place
from thermoroll_cli.one_contact.refinement.outcome import of_line, refining_both, result_of, scalars_by_level
from thermoroll_cli.one_contact.refinement.plan import Plan, make_plan
from thermoroll_cli.one_contact.refinement.refine import refine
from thermoroll_cli.one_contact.refinement.subsurface_stage import with_subsurface
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result

Report = Callable[[str, Mapping[str, Any]], None]

VERTICAL_ROUNDS = 8
"""Normal loads that are tried where a vertical force is given: three are usual."""
VERTICAL_MET = 1e-5
"""Departure of the vertical force, relative, with which a load is found: the solvers leave a tenth of that."""


class ContactSolver:
    """Solves problem after problem: each starts from what the last one predicts, and uses the kernels of the last where grids
    are the same. Neighbouring points of a sweep, or steps of wear, take half of the work of a first one. `threads` > 1
    transforms both traction components side by side, with the same result; `options` are for experiments."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        self.threads = threads
        self.options = options or SolverOptions()
        self.last: tuple[list[Level], list[Level]] = ([], [])
        """Levels of the last problem that was solved, without and with thermal deformation."""
        self._followed: dict[Problem, float] = {}  # creep forces where friction falls with slip

    def solve(self, problem: Problem, *, report: Report | None = None) -> Result:
        """The result of `problem`, with its coupled and its isothermal state. `report` is called with the name of a stage and a
        mapping (grid, iteration, residual, …) as the work goes on. Raises Unsolvable where no steady state can exist;
        everything else that goes wrong is in `Result.converged` and `Result.reason`."""
        if problem.vertical is not None:
            return _under_vertical(problem, lambda loaded: self.solve(loaded, report=report))
        result = self._to_maximum(problem, report) if has_maximum(problem) else self._solve(problem, report)
        return of_line(result) if problem.line else result

    def _to_maximum(self, problem: Problem, report: Report | None) -> Result:
        """The result for a prescribed force where friction falls with slip: the maximum of the creep curve is found first."""
        coarse = ContactSolver(self.threads, self.options)
        try:
            maximum = creep_maximum(problem, lambda point: coarse._solve(point, None), self._followed)
        except ArithmeticError as cause:
            result = self._solve(problem, report)
            return replace(result, warnings=(*result.warnings, f"the maximum of the creep curve was not found: {cause}"))
        if problem.prescribed_force > maximum.force:
            return beyond_maximum(problem, maximum, lambda point: self._solve(point, report))
        return with_maximum(self._solve(problem, report), maximum)

    def _solve(self, problem: Problem, report: Report | None) -> Result:
        """The result of a solution that begins with the neighbours, if there are any. If it fails, one without them follows."""
        result = self._attempt(problem, report or (lambda stage, info: None))
        if not result.converged and self.last[0]:
            self.last = [], []
            result = self._attempt(problem, report or (lambda stage, info: None))
        return result

    def _attempt(self, problem: Problem, report: Report) -> Result:
        plan = make_plan(problem, alone=not self.options.sequence)
        cold, hot = self._levels(plan, report)
        while not plan.widest and (cold[-1].touches_rim or hot[-1].touches_rim):
            plan = plan.wider()
            cold, hot = self._levels(plan, report)
        # A coarser grid on which no steady state was found says nothing about the order in which errors fall.
        all_converged = hot is cold or all(level.state.converged for level in refining_both(hot)[-3:])
        result = result_of(plan, cold, hot, extrapolated=self.options.extrapolated and all_converged)
        result = with_subsurface(result, plan, hot)
        if result.converged:
            self.last = cold, hot
        return result

    def _levels(self, plan: Plan, report: Report) -> tuple[list[Level], list[Level]]:
        """The states without and with thermal deformation, which may be the same, on each grid of the plan, coarse to fine,
        until one is accurate enough or its domain too small."""
        cold: list[Level] = []
        hot: list[Level] = [] if plan.runs("deformation") else cold
        last_cold, last_hot = self.last
        for shape in plan.grids:
            # Kernels and tables of the last problem, where they serve.
            before = at_place(last_cold, (shape, plan.extent))
            here = Discretisation(plan.derived, shape, plan.extent, self.threads, self.options,
                                  coarser=cold[-1].here if cold else None, before=before.here if before else None)
            cold.append(refine(plan, here, cold, last_cold))
            report("tangential", {"grid": list(here.grid.sides), "applications": cold[-1].state.applications,
                                  "residual": cold[-1].contact.tangential.residual})
            if hot is not cold:
                hot.append(refine(plan, here, hot, last_hot, cold[-1]))
                report("coupling", {"grid": list(here.grid.sides), "iteration": hot[-1].state.iterations,
                                    "residual": hot[-1].state.residual})
            if cold[-1].touches_rim or hot[-1].touches_rim:
                break
            scalars, problem = scalars_by_level(hot), plan.derived.problem
            if problem.numerics.accuracy is not None and shape != plan.grid and len(scalars) >= 3:
                errors = estimates(Resolution.of(hot[-1], scalars, plan.derived, plan))
                if not missed_accuracy(errors, scalars[-1], problem):
                    break
        return cold, hot


def _under_vertical(problem: Problem, solve: Callable[[Problem], Result]) -> Result:
    """The result of a conformal contact under the load with which pressure and traction carry its `vertical` force (N) along z,
    by the secant method on their sum. `solve` solves one problem whose load is given.

    The error of the vertical force is one of the load, and of whatever grows with it: no scalar grows faster."""
    wanted = problem.vertical
    assert wanted is not None
    load, before = wanted, (0.0, 0.0)
    for _ in range(VERTICAL_ROUNDS):
        result = solve(replace(problem, vertical=None, normal_force=load))
        force = result.coupled.scalars["contact_force_z_N"]
        departure = abs(force / wanted - 1.0)
        if not result.converged or not departure > VERTICAL_MET:
            break
        slope = (force - before[1]) / (load - before[0])
        before = load, force
        load += (wanted - force) / slope if slope > 0.0 else wanted - force
    found = replace(result, problem=replace(result.problem, vertical=wanted))
    if not result.converged:
        return found
    if departure > VERTICAL_MET:
        return replace(found, converged=False, uncertainty={}, reason=(
            f"no normal load gives the vertical force of {wanted:.6g} N: {before[0]:.6g} N gives {force:.6g} N"))
    error = result.uncertainty["contact_force_z_N"] + departure * wanted
    share = error / result.problem.normal_force
    uncertainty = {name: known + share * abs(result.numbers[name]) for name, known in result.uncertainty.items()}
    return replace(found, uncertainty=uncertainty | {"normal_N": error, "contact_force_z_N": departure * wanted})

"""Solve cases and problems of every kind: what notebooks, sweeps and the command line call. A kind is a line of `KINDS`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.bearing.bearing_problem import BearingProblem
from thermoroll_cli.many_contacts.bearing.bearing_result import BearingPlan, BearingSolver, bearing_warnings
from thermoroll_cli.many_contacts.bearing.bearing_result import facts_of as facts_of_bearing
from thermoroll_cli.many_contacts.bearing.bearing_result import plan_of as plan_of_bearing
from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.many_contacts.history.history_plan import HistoryPlan, plan_of, warnings_of
from thermoroll_cli.many_contacts.history.solve import HistorySolver
from thermoroll_cli.many_contacts.history.wheelset_over_time import WheelsetHistory, WheelsetHistorySolver, warnings_over_time
from thermoroll_cli.many_contacts.wheelset.conicity import Conicity, conicity_of
from thermoroll_cli.many_contacts.wheelset.first_contact import facts_of, wheelset_warnings
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import WheelsetSolver
from thermoroll_cli.one_contact.refinement import solve as refinement
from thermoroll_cli.one_contact.refinement.expected_heat import expected_temperature_warning
from thermoroll_cli.one_contact.refinement.plan import Plan, make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.one_contact.steady_state.doubts import warnings_before
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result

Task = Problem | WheelsetProblem | BearingProblem | History | WheelsetHistory
Report = Callable[[str, Mapping[str, Any]], None]


@dataclass(frozen=True)
class Kind:
    """What can be done with problems of one kind: a contact, or an assembly of contacts.

    - `solver`: an object whose `solve(problem, report=…)` returns results, each begun from those before;
    - `warnings`: those that need no solution;
    - `facts`: numbers known before solving, in the units of their names;
    - `plan`: of a contact, which stages run, and over time its steps; of a bearing, how many contacts are solved."""

    solver: Callable[[int, SolverOptions | None], Any]
    warnings: Callable[[Any], Iterable[str]]
    facts: Callable[[Any], Mapping[str, float]]
    plan: Callable[[Any], Plan | HistoryPlan | BearingPlan | None] | None = None


def _contact_warnings(problem: Problem) -> Iterable[str]:
    derived = DerivedQuantities(problem)
    return *warnings_before(derived), *expected_temperature_warning(derived)


def _history_facts(history: History) -> Mapping[str, float]:
    """Numbers of the plan at the largest load."""
    return {name: value for name, value in make_plan(history.largest).facts.items() if value == value}


KINDS: dict[type[Task], Kind] = {
    Problem: Kind(refinement.Solver, _contact_warnings, lambda problem: make_plan(problem).facts, make_plan),
    WheelsetProblem: Kind(lambda threads, options: WheelsetSolver(threads), wheelset_warnings, facts_of),
    BearingProblem: Kind(lambda threads, options: BearingSolver(threads), bearing_warnings, facts_of_bearing, plan_of_bearing),
    History: Kind(HistorySolver, warnings_of, _history_facts, plan_of),
    WheelsetHistory: Kind(WheelsetHistorySolver, warnings_over_time, lambda history: facts_of(history.start)),
}
"""The kinds of problems that a case may describe."""


class Solver:
    """Solves case after case: each starts from the one before it of its kind, if kernels and grids are the same.

    Parameters:

    - `threads`: threads of the transforms, 1 or more; the result does not depend on it;
    - `options`: numbers that steer the solvers of a contact, for experiments (docs/developing.md).

    Raises ValueError for `threads` below 1."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        if threads < 1:
            raise ValueError(f"threads must be 1 or more, not {threads!r}")
        self._solvers = {kind: known.solver(threads, options) for kind, known in KINDS.items()}

    def solve(self, case: Case | Mapping[str, Any] | str | os.PathLike[str] | Task, *, report: Report | None = None) -> Result:
        """The result of `case`, in the sense of the function `solve`.

        Parameters:

        - `case`, `report`: as of `solve`.

        Raises CaseError for an invalid case, ValueError if no steady state can exist or a wheel misses its rail."""
        if not isinstance(case, Task):
            given = Case.of(case)
            return self.solve(given.task, report=report).with_case(given.text, given.to_json())
        result: Result = self._solvers[type(case)].solve(case, report=report)
        return result


def solve(
    case: Case | Mapping[str, Any] | str | os.PathLike[str] | Task, *, threads: int = 1, report: Report | None = None
) -> Result:
    """Solve a case: pressure, tractions, heat and temperatures in the steady state, with and without thermal deformation.

    Parameters:

    - `case`: a `Case`, the path of a case file, or a mapping of its tables (`{"load": {"normal_N": 65.0, …}, …}`, in the units
      of the keys); or a `Problem` in SI units;
    - `threads`: 1 or more; above 1 both traction components are transformed side by side, with the same result;
    - `report`: called with the name of a stage and a mapping (grid, iteration, residual, …) during the solve; an exception that
      it raises ends the solve.

    Returns a `Result`; one that did not converge says so in `converged` and `reason`. That of an assembly has `patches`, each a
    `Result`.

    Raises CaseError for an invalid case; ValueError if no steady state can exist or a wheel misses its rail.
    """
    return Solver(threads).solve(case, report=report)


def conicity(
    case: Case | Mapping[str, Any] | str | os.PathLike[str],
    amplitudes_mm: Sequence[float] = tuple(np.linspace(1.0, 7.5, 66).tolist()),
) -> Conicity:
    """Equivalent conicity after EN 15302 of the wheelset of a case, whose load, position and motion do not count.

    Parameters:

    - `case`: as of `solve`;
    - `amplitudes_mm`: amplitudes in mm, above 0.

    Returns the conicity with `conicity`, `wavelength`, `amplitudes`, `shifts`, `radius_difference` (arrays in SI units),
    `conicity_at(amplitude)`, `nonlinearity`, `warnings` and `record()`, the units of which its names say. Numbers are nan where
    an amplitude is beyond the profiles.

    Raises CaseError for an invalid case; ValueError for a case without two wheels on a track, and for other amplitudes."""
    # No gauge has more room than 50 mm.
    if not len(amplitudes_mm) or not all(isinstance(value, int | float) and 0.0 < value <= 50.0 for value in amplitudes_mm):
        raise ValueError("amplitudes are numbers above 0 up to 50 mm")
    task = Case.of(case).task
    if isinstance(task, WheelsetHistory):
        task = task.problem
    if not isinstance(task, WheelsetProblem):
        what, key = ("a ball bearing", "bearing") if isinstance(task, BearingProblem) else ("a single contact", "geometry")
        raise Unsolvable(f"{what} has no equivalent conicity", key, "[track] and [wheelset] in place of it")
    return conicity_of(task, 1e-3 * np.array(amplitudes_mm, dtype=float))

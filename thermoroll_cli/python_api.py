"""Solve cases and problems of every kind: what notebooks, sweeps and the command line call. `kind_of` has the kinds."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.bearing.bearing_problem import BearingProblem
from thermoroll_cli.many_contacts.history.course import History, WheelsetHistory
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.one_contact.refinement import solve as refinement
from thermoroll_cli.one_contact.refinement.expected_heat import expected_temperature_warning
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.one_contact.steady_state.doubts import warnings_before
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result

if TYPE_CHECKING:
    from thermoroll_cli.many_contacts.bearing.bearing_result import BearingPlan
    from thermoroll_cli.many_contacts.history.history_plan import HistoryPlan
    from thermoroll_cli.many_contacts.wheelset.conicity import Conicity
    from thermoroll_cli.one_contact.refinement.plan import Plan

Task = Problem | WheelsetProblem | BearingProblem | History | WheelsetHistory
Report = Callable[[str, Mapping[str, Any]], None]


class Kind(NamedTuple):
    """What can be done with problems of one kind: a contact, or an assembly of contacts.

    - `solver`: an object whose `solve(problem, report=…)` returns results, each begun from those before;
    - `warnings`: those that need no solution;
    - `facts`: numbers known before solving, in the units of their names;
    - `plan`: of a contact, which stages run, and over time its steps; of a bearing, how many contacts are solved."""

    solver: Callable[[int, SolverOptions | None], Any]
    warnings: Callable[[Any], Iterable[str]]
    facts: Callable[[Any], Mapping[str, float]]
    plan: Callable[[Any], Plan | HistoryPlan | BearingPlan | None] | None = None


def kind_of(problem: type[Task]) -> Kind:
    """The kind of problems of a class. Assemblies and histories are imported with the first of them: for a single contact that
    would be a tenth of the start."""
    if problem is WheelsetProblem:
        from thermoroll_cli.many_contacts.wheelset.first_contact import facts_of, wheelset_warnings
        from thermoroll_cli.many_contacts.wheelset.wheelset_result import WheelsetSolver

        return Kind(lambda threads, options: WheelsetSolver(threads), wheelset_warnings, facts_of)
    if problem is BearingProblem:
        from thermoroll_cli.many_contacts.bearing import bearing_result as bearing

        return Kind(lambda threads, options: bearing.BearingSolver(threads), bearing.bearing_warnings, bearing.facts_of,
                    bearing.plan_of)
    if problem is History:
        from thermoroll_cli.many_contacts.history.history_plan import plan_of, warnings_of
        from thermoroll_cli.many_contacts.history.solve import HistorySolver

        # Facts are those at the largest load.
        return Kind(HistorySolver, warnings_of, lambda history: {
            name: value for name, value in make_plan(history.largest).facts.items() if value == value}, plan_of)
    if problem is WheelsetHistory:
        from thermoroll_cli.many_contacts.history.wheelset_over_time import WheelsetHistorySolver, warnings_over_time

        of_wheelsets = kind_of(WheelsetProblem)
        return Kind(WheelsetHistorySolver, warnings_over_time, lambda history: of_wheelsets.facts(history.start))

    def warnings(contact: Problem) -> Iterable[str]:
        derived = DerivedQuantities(contact)
        return *warnings_before(derived), *expected_temperature_warning(derived)

    return Kind(refinement.Solver, warnings, lambda contact: make_plan(contact).facts, make_plan)


class Solver:
    """Solves case after case: each starts from the one before it of its kind, if kernels and grids are the same.

    Parameters:

    - `threads`: threads of the transforms, 1 or more; the result does not depend on it;
    - `options`: numbers that steer the solvers of a contact, for experiments (docs/developing.md).

    Raises ValueError for `threads` below 1."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        if threads < 1:
            raise ValueError(f"threads must be 1 or more, not {threads!r}")
        self._threads, self._options, self._solvers = threads, options, dict[type[Task], Any]()

    def solve(self, case: Case | Mapping[str, Any] | str | os.PathLike[str] | Task, *, report: Report | None = None) -> Result:
        """The result of `case`, in the sense of the function `solve`.

        Parameters:

        - `case`, `report`: as of `solve`.

        Raises CaseError for an invalid case, ValueError if no steady state can exist or a wheel misses its rail."""
        if not isinstance(case, Task):
            given = Case.of(case)
            return self.solve(given.task, report=report).with_case(given.text, given.to_json())
        kind = type(case)
        if kind not in self._solvers:
            self._solvers[kind] = kind_of(kind).solver(self._threads, self._options)
        result: Result = self._solvers[kind].solve(case, report=report)
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
    from thermoroll_cli.many_contacts.wheelset.conicity import conicity_of

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

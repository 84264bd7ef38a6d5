"""Solve cases and problems of every kind: what notebooks, sweeps and the command line call."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.problem.kinds import Task, kind_of
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.process import on_one_thread

if TYPE_CHECKING:
    from thermoroll_cli.many_contacts.wheelset.conicity import Conicity

Report = Callable[[str, Mapping[str, Any]], None]


class Solver:
    """Solves case after case: each starts from the one before it of its kind, if kernels and grids are the same. While it
    works, NumPy's linear algebra has one thread: several wait for each other longer than they work.

    Parameters:

    - `threads`: threads of the transforms, 1 or more; the result does not depend on it;
    - `options`: numbers that steer the solvers of a contact, for experiments (docs/developing.md).

    Raises ValueError for `threads` below 1."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        if threads < 1:
            raise ValueError(f"threads must be 1 or more, not {threads!r}")
        self._threads, self._options, self._solvers = threads, options, dict[str, Any]()

    def solve(self, case: Case | Mapping[str, Any] | str | os.PathLike[str] | Task, *, report: Report | None = None) -> Result:
        """The result of `case`, in the sense of the function `solve`.

        Parameters:

        - `case`, `report`: as of `solve`.

        Raises CaseError for an invalid case, ValueError if no steady state can exist or a wheel misses its rail."""
        if not isinstance(case, Task):
            given = Case.of(case)
            return self.solve(given.task, report=report).with_case(given.text, given.to_json())
        if case.kind not in self._solvers:
            self._solvers[case.kind] = kind_of(case).solver(self._threads, self._options)
        with on_one_thread():
            result: Result = self._solvers[case.kind].solve(case, report=report)
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
    return conicity_of(kind_of(task).wheelset(task), 1e-3 * np.array(amplitudes_mm, dtype=float))

"""Solve cases and problems of every kind: what notebooks, sweeps and the command line call."""

from __future__ import annotations

import contextlib
import os
import pathlib
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
Solvable = Case | Mapping[str, Any] | str | os.PathLike[str] | Task
"""A `Case`, the path of a case file, a mapping of its tables, or a problem of any kind in SI units."""


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

    def solve(
        self, case: Solvable, *, report: Report | None = None, journal: str | os.PathLike[str] | None = None,
        resume: bool = False,
    ) -> Result:
        """The result of `case`, in the sense of the function `solve`.

        Parameters:

        - `case`, `report`, `journal`, `resume`: as of `solve`.

        Raises CaseError for an invalid case, ValueError if no steady state can exist or a wheel misses its rail."""
        given = None if isinstance(case, Task) else Case.of(case)
        task: Task = case if given is None else given.task  # type: ignore[assignment]
        kind = kind_of(task)
        if kind.name not in self._solvers:
            self._solvers[kind.name] = kind.solver(self._threads, self._options)
        solver = self._solvers[kind.name]
        with contextlib.ExitStack() as stack:
            stack.enter_context(on_one_thread())
            kept: dict[str, Any] = {}
            if journal is not None and kind.journal is not None:
                if given is None:
                    raise TypeError("a journal says which case its steps are of: give a case with it, not its problem")
                opened = kind.journal(pathlib.Path(journal), task, given.to_json(), resume=resume)
                kept = {"journal": stack.enter_context(opened)}
            result: Result = solver.solve(task, report=report, **kept)
        return result if given is None else result.with_case(given.text, given.to_json())


def solve(
    case: Solvable, *, threads: int = 1, options: SolverOptions | None = None, report: Report | None = None,
    journal: str | os.PathLike[str] | None = None, resume: bool = False,
) -> Result:
    """Solve a case: pressure, tractions, heat and temperatures in the steady state, with and without thermal deformation.

    Parameters:

    - `case`: a `Case`, the path of a case file, or a mapping of its tables (`{"load": {"normal_N": 65.0, …}, …}`, in the units
      of the keys); or a `Problem` in SI units;
    - `threads`: 1 or more; above 1 both traction components are transformed side by side, with the same result;
    - `options`: as of `Solver`;
    - `report`: called with the name of a stage and a mapping (grid, iteration, residual, …) during the solve; an exception that
      it raises ends the solve;
    - `journal`: a file in which a contact over time keeps each step as soon as it is solved; other kinds keep none;
    - `resume`: goes on with the steps that the journal of the same case has.

    Returns a `Result`; one that did not converge says so in `converged` and `reason`. That of an assembly has `patches`, each a
    `Result`.

    Raises CaseError for an invalid case; ValueError if no steady state can exist or a wheel misses its rail; OSError if the
    journal cannot be written, or is one of another case.
    """
    return Solver(threads, options).solve(case, report=report, journal=journal, resume=resume)


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

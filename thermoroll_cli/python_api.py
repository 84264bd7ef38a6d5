"""Solve cases and problems: what notebooks call, sweeps and the command line."""

from __future__ import annotations

import dataclasses
import html
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.hdf5 import read_result
from thermoroll_cli.plots import pictures, style
from thermoroll_cli.plots.wheelset_figures import patches_figure, section_figure
from thermoroll_cli.problem.names import ALL_SCALARS
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import scalar_text
from thermoroll_cli.refinement import solve as refinement
from thermoroll_cli.steady_state.discretisation import SolverOptions
from thermoroll_cli.wheelset import wheelset_result
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem

__all__ = ["Result", "Solver", "read_result", "solve"]

AnyCase = Case | Mapping[str, Any] | str | os.PathLike[str]
Report = Callable[[str, Mapping[str, Any]], None]


class WheelsetResult(wheelset_result.WheelsetResult):
    """Outcome of a wheelset, which can show itself in a notebook: `scalars` in the units of their names, `error`, `summary()`,
    `converged`, `reason`, `warnings`, and `patches`, each with its `record` in the axes of the track and a `result`, which is a
    `Result`."""

    def __repr__(self) -> str:
        patches = f"{len(self.patches)} patch{'' if len(self.patches) == 1 else 'es'}"
        return f"<wheelset with {patches}, {self.status.replace('_', ' ')}>"

    def plot(self, kind: Literal["section", "patches"] = "section") -> pictures.Figure:
        """A picture as a matplotlib figure: the "section" across the track, or the pressure of all "patches" from above.

        Raises ValueError for another kind, and for a map of patches where there are none."""
        figures = {"section": section_figure, "patches": patches_figure}
        if kind not in figures:
            raise ValueError(f"the picture {kind!r} is none of {', '.join(figures)}")
        if kind == "patches" and not self.patches:
            raise ValueError("no wheel touches its rail: there are no patches to show")
        with style.applied():
            return figures[kind](self, self.problem.title)

    def _repr_html_(self) -> str:
        """A table of the scalars that `thermoroll run` prints, for notebooks."""
        summary = self.summary()
        rows = [[ALL_SCALARS[name].meaning, scalar_text(name, summary), ALL_SCALARS[name].unit] for name in self.scalars]
        return _table(repr(self)[1:-1], [["scalar", "value", "unit"], *rows])


def _table(caption: str, rows: Iterable[Iterable[str]]) -> str:
    lines = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
    return f"<table><caption>{html.escape(caption)}</caption><tr>{'</tr><tr>'.join(lines)}</tr></table>"


class Solver(refinement.Solver):
    """Solves problem after problem: each starts from the one before it if kernels and grids are the same.

    Parameters:

    - `threads`: threads of the transforms, 1 or more; the result does not depend on it;
    - `options`: numbers that steer the solvers, for experiments (docs/developing.md).

    Raises ValueError for `threads` below 1."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        if threads < 1:
            raise ValueError(f"threads must be 1 or more, not {threads!r}")
        super().__init__(threads, options)

    def solve(self, case: AnyCase | Problem, *, report: Report | None = None) -> Result:
        """The result of `case`, in the sense of the function `solve`; a wheelset is refused.

        Parameters:

        - `case`, `report`: as of `solve`.

        Raises CaseError for an invalid case, ValueError if no steady state can exist."""
        if isinstance(case, Problem):
            return super().solve(case, report=report)
        case = Case.of(case)
        result = super().solve(case.problem, report=report)
        return dataclasses.replace(result, case_text=case.text, case_json=case.to_json())


def solve(case: AnyCase | Problem, *, threads: int = 1, report: Report | None = None) -> Result | WheelsetResult:
    """Solve a case: pressure, tractions, heat and temperatures in the steady state, with and without thermal deformation.

    Parameters:

    - `case`: a `Case`, the path of a case file, or a mapping of its tables (`{"load": {"normal_N": 65.0, …}, …}`, in the units
      of the keys); or a `Problem` in SI units;
    - `threads`: 1 or more; above 1 both traction components are transformed side by side, with the same result;
    - `report`: called with the name of a stage and a mapping (grid, iteration, residual, …) during the solve; an exception that
      it raises ends the solve.

    Returns a `Result`, or a `WheelsetResult` for a case of a wheelset; one that did not converge says so in `converged` and
    `reason`.

    Raises CaseError for an invalid case; ValueError if no steady state can exist or a wheel misses its rail.
    """
    if isinstance(case, Problem):
        return Solver(threads).solve(case, report=report)
    given = Case.of(case)
    task = given.task
    if not isinstance(task, WheelsetProblem):
        return Solver(threads).solve(given, report=report)
    whole = wheelset_result.solve_wheelset(task, threads=threads, report=report)
    text, resolved = given.text, given.to_json()
    patches = (dataclasses.replace(patch, result=dataclasses.replace(patch.result, case_text=text, case_json=resolved))
               for patch in whole.patches)
    given_back = {field.name: getattr(whole, field.name) for field in dataclasses.fields(whole)}
    return WheelsetResult(**given_back | {"patches": tuple(patches), "case_text": text, "case_json": resolved})

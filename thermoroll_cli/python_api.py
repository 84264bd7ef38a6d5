"""Functions and classes for notebooks and scripts: `thermoroll_cli` offers these names, and loads them when they are asked for.

It stands above all packages, so a `Result` can have the methods that write and draw it here."""

from __future__ import annotations

import dataclasses
import html
import os
import pathlib
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, Self

from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result import hdf5
from thermoroll_cli.plots import pictures, style
from thermoroll_cli.plots.wheelset_figures import patches_figure, section_figure
from thermoroll_cli.problem import result as results
from thermoroll_cli.problem.names import ALL_SCALARS, FIELDS
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.scalar_errors import isothermal_text, listed_scalars, scalar_text
from thermoroll_cli.refinement import solve as refinement
from thermoroll_cli.steady_state.discretisation import SolverOptions
from thermoroll_cli.sweeps.sweep import solve_sweep as sweep
from thermoroll_cli.wheelset import wheelset_result
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.worn.follow import Evolution, follow

__all__ = ["Result", "Solver", "read_result", "solve", "sweep", "wear"]

if TYPE_CHECKING:
    import xarray

AnyCase = Case | Mapping[str, Any] | str | os.PathLike[str]
Report = Callable[[str, Mapping[str, Any]], None]
COMMAND_LINE = "Python"
"""Stands in files written from Python in place of a command line."""


class Result(results.Result):
    """Outcome of one solve, which can write itself to a file and show itself in a notebook.

    The most used attributes:

    - `coupled`, `isothermal`: the states with and without thermal deformation, each with `fields` (nx, ny) in SI units,
      `scalars` in the units of their names, and element centres `x`, `y` in m;
    - `error`: estimated relative error of each scalar, over the scale that docs/cases_and_files.md names;
    - `converged`, `reason`, `warnings`, `work`;
    - `patches`: of bodies with profiles; `unbounded`: scalars that have no limit on finer grids;
    - `subsurface`: stresses inside the bodies, None if not asked for.
    """

    @classmethod
    def of(cls, result: results.Result) -> Self:
        return cls(**{field.name: getattr(result, field.name) for field in dataclasses.fields(result)})

    @property
    def scalars(self) -> Mapping[str, float]:
        """All numbers of the coupled state, of Hertz's contact and below the surface by their public names, in the units of
        these names; nan if not computed."""
        return {name: value for name, value in self.summary().items() if isinstance(value, float)}

    def save(self, path: str | os.PathLike[str]) -> pathlib.Path:
        """Write this result as `thermoroll run` does (docs/cases_and_files.md), complete or not at all.

        Parameters:

        - `path`: of the HDF5 file, which is replaced if it exists; its folder must exist.

        Returns the path. The file of a result of a `Case` contains that case, which `thermoroll run --from` solves again.

        Raises OSError, with a plain message, if the file cannot be written."""
        hdf5.write_result(path, self, case_text=self.case_text, case_json=self.case_json, command_line=COMMAND_LINE)
        return pathlib.Path(path)

    def to_xarray(self, state: str = "coupled") -> xarray.Dataset:
        """The fields of one state as an `xarray.Dataset` with SI units, as opening its file gives; scalars are attributes.

        Parameters:

        - `state`: "coupled" or "isothermal" (without thermal deformation).

        Fields have the dimensions (x, y), element centres in m.

        Raises ImportError, which names the package to install, if xarray is missing; ValueError for another state."""
        try:
            import xarray
        except ImportError:
            raise ImportError("to_xarray needs the package xarray, which is not installed: pip install xarray") from None
        if state not in ("coupled", "isothermal"):
            raise ValueError(f'a result has the states "coupled" and "isothermal", not {state!r}')
        chosen = self.coupled if state == "coupled" else self.isothermal
        variables = {}
        for name, values in chosen.fields.items():
            variables[name] = (("x", "y"), values, {"units": FIELDS[name].unit, "long_name": FIELDS[name].meaning})
        coordinates = {"x": ("x", chosen.x, {"units": "m"}), "y": ("y", chosen.y, {"units": "m"})}
        return xarray.Dataset(variables, coordinates, {**chosen.scalars, **self.hertz, "converged": int(self.converged)})

    def plot(self, kind: str = "summary", *, normalised: bool = False, cut_y: float | None = None) -> pictures.Figure:
        """A picture as a matplotlib figure; `figure.savefig` writes it. Maps are seen from below (docs/frames.md). For axes
        of your own: `result.to_xarray()["pressure"].plot(ax=axes)`.

        Parameters:

        - `kind`: "pressure", "traction", "heat_flux", "temperature", "centreline", "summary", … as `thermoroll run` draws them,
          or any field, as a map;
        - `normalised`: the article's dimensionless quantities (p/p0, x/a0, …);
        - `cut_y`: the line y of the picture "centreline", in m.

        Raises ValueError for an unknown kind (the message lists them), for a cut outside the domain, and if there is nothing to
        show, as the temperature of a problem without heat."""
        figure = pictures.figure(self, kind, normalised=normalised, cut_y=cut_y)
        if figure is None:
            raise ValueError(f"there is nothing to show in a picture {kind!r} of this result")
        return figure

    def _repr_html_(self) -> str:
        """A table of the scalars that `thermoroll run` prints, for notebooks."""
        summary, both = self.summary(), self.isothermal is not self.coupled
        rows = [["scalar", "coupled", "isothermal", "unit"] if both else ["scalar", "value", "unit"]]
        for name in listed_scalars(self):
            beside = [isothermal_text(name, summary)] if both else []
            meaning = ALL_SCALARS[name].meaning_of(hertz=self.problem.has_hertz_solution)
            rows.append([meaning, scalar_text(name, summary), *beside, ALL_SCALARS[name].unit])
        return _table(repr(self)[1:-1], rows)


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
            return Result.of(super().solve(case, report=report))
        case = Case.of(case)
        result = Result.of(super().solve(case.problem, report=report))
        return dataclasses.replace(result, case_text=case.text, case_json=case.to_json())


def read_result(path: str | os.PathLike[str], *, with_fields: bool = True) -> Result:
    """The result in the file that `thermoroll run` or `Result.save` wrote.

    Parameters:

    - `path`: the HDF5 file;
    - `with_fields`: False leaves fields and histories out, if only the scalars and the case matter.

    Raises OSError, with a plain message, for a file that is missing, unreadable, foreign, truncated, damaged or of another
    version."""
    return Result.of(hdf5.read_result(path, with_fields=with_fields))


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
    patches = (dataclasses.replace(patch, result=Result.of(
        dataclasses.replace(patch.result, case_text=text, case_json=resolved))) for patch in whole.patches)
    given_back = {field.name: getattr(whole, field.name) for field in dataclasses.fields(whole)}
    return WheelsetResult(**given_back | {"patches": tuple(patches), "case_text": text, "case_json": resolved})


def wear(
    case: AnyCase, folder: str | os.PathLike[str] | None = None, *,
    resume: bool = False, threads: int = 1, report: Callable[[int, Mapping[str, Any]], None] | None = None,
) -> Evolution:
    """Follow the profiles of both bodies as they wear, as `thermoroll wear` does, over the distance or to the depth that
    `[wear]` of a case gives.

    Parameters:

    - `case`: as of `solve`, with the table `[wear]`;
    - `folder`: receives the files of the command but for pictures, and is made if necessary; without it nothing is kept;
    - `resume`: goes on from the steps in `folder`;
    - `threads`: as of `solve`;
    - `report`: called with the number of each step and its row as soon as it is solved.

    Returns an `Evolution`: `rows` with a mapping per step, under the names of NAME_wear.csv and with the relative errors in
    `error`; `snapshots` with the profiles and loads over y in SI units; `result`, that of the last step, whose case has the
    worn profiles; and the `reason` why it ended early, "" if it did not.

    Raises CaseError for an invalid case; ValueError if the case gives neither distance nor depth, or has no steady state;
    OSError if a file cannot be written.
    """
    done = follow(Case.of(case), folder, resume=resume, threads=threads, report=report)
    return dataclasses.replace(done, result=Result.of(done.result))

"""A history on its grid and on the next coarser one with twice the steps: rows with estimated errors, and the last state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d

from thermoroll_cli.arrays import Array
from thermoroll_cli.history.course import VARIED, History
from thermoroll_cli.history.steps import Moment, Steps
from thermoroll_cli.problem.columns import CONVERGED, Columns
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.names import PLACES, over_limit
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.plan import GROWTH, LARGEST_EXTENT, SMALLEST_EXTENT
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import SolverOptions
from thermoroll_cli.steady_state.scalars import patches_of, problem_scalars
from thermoroll_cli.steady_state.solvable import reasons_against

COARSEST = 8
"""Elements per side of a coarser grid that gives error estimates."""


class HistorySolver:
    """Solves history after history."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        self._threads, self._options = threads, options

    def solve(self, history: History, *, report: Callable[[str, Mapping[str, Any]], None] | None = None) -> Result:
        """The result of the last state, with the columns of all. Raises Unsolvable where friction cannot carry a force."""
        _check(history)
        rows, shape = history.course.rows, history.problem.numerics.grid
        assert shape is not None
        few = np.unique([*rows[::2], rows[-1]])
        runs = [(shape, rows)]
        if min(shape) >= 2 * COARSEST:
            runs.append((((shape[0] + 1) // 2, (shape[1] + 1) // 2), few))
        extent, warnings = max(history.problem.numerics.extent, SMALLEST_EXTENT), list[str]()
        while True:
            found = [self._moments(history, places, grid, extent, report) for grid, places in runs]
            if extent > LARGEST_EXTENT or not any(moments[-1].state.touches_rim for moments in found):
                break
            extent *= GROWTH
            warnings = [f"the contact reached the rim of the domain: extent grown to {extent:g}"]
        moments, coarser = found[0], found[1] if len(found) > 1 else []
        columns = {name: np.array([moment.reported.scalars[name] for moment in moments])
                   for name in moments[0].reported.scalars}
        return replace(_result(history, moments, _errors(rows, columns, few, coarser)), warnings=tuple(warnings))

    def _moments(
        self, history: History, rows: Array, shape: tuple[int, int], extent: float,
        report: Callable[[str, Mapping[str, Any]], None] | None,
    ) -> list[Moment]:
        """The states at `rows`, up to one that touches the rim of a domain that may grow."""
        moments: list[Moment] = []
        for moment in Steps(history, shape, self._options, self._threads, extent).moments(rows):
            moments.append(moment)
            if report is not None:
                report("tangential", {"grid": list(shape), "applications": moment.applications,
                                      "residual": moment.state.contact.tangential.residual})
            if moment.state.touches_rim and extent <= LARGEST_EXTENT:
                break
        return moments


def _check(history: History) -> None:
    """Raises Unsolvable for the first reason against the problem at any place of the course."""
    for place in history.course.places:
        for after in (False, True):
            for reason in reasons_against(DerivedQuantities(history.problem_at(place, after=after))):
                key = "history.values" if reason.key in history.course.values else reason.key
                where = f"at {1e3 * place:g} mm" if history.course.by_distance else f"at {place:g} s"
                raise Unsolvable(f"{where}: {reason}", key, reason.allowed)


def _errors(
    rows: Array, columns: Mapping[str, Array], few: Array, coarser: Sequence[Moment]
) -> dict[str, Array]:
    """Estimated errors of the columns at all `rows`, from the same history on a coarser grid and the `few` rows of twice the
    steps. The difference counts whole, as for errors of first order, which jumps and kinks of inputs have. It changes its sign:
    an error is no less than that of the rows beside it, and than the mean of all. Those of work and heat are no less than what
    is missing between both and the stored energy."""
    found: dict[str, Array] = {}
    both = np.searchsorted(rows, few)
    for name, column in columns.items() if coarser else ():
        difference = np.abs(column[both] - np.array([moment.reported.scalars[name] for moment in coarser]))
        known = ~np.isnan(difference)
        if known.any() and difference[known].any():
            beside = maximum_filter1d(difference[known], 3)
            error = np.maximum(np.interp(rows, few[known], beside), np.sqrt((difference[known] ** 2).mean()))
            found[name] = np.where(np.isnan(column), math.nan, error)
    energy = columns["elastic_energy_J"]
    missing = np.abs(columns["work_J"] - columns["heat_J"] - (energy - energy[0]))
    return found | {name: np.maximum(found.get(name, 0.0), np.maximum.accumulate(missing)) for name in ("work_J", "heat_J")}


def _result(
    history: History, moments: Sequence[Moment], errors: Mapping[str, Array]
) -> Result:
    """The last state with all columns; it has converged if every step was solved."""
    last, rows = moments[-1], history.course.rows
    failed = [moment for moment in moments if not moment.converged]
    first = failed[0] if failed else None
    reason = "" if first is None else (
        f"{len(failed)} of {len(moments)} steps were not solved, the first one at {first.time:g} s after "
        f"{1e3 * first.distance:g} mm: smaller steps help where inputs change much in one")
    problems = [history.problem_at(float(row)) for row in rows]
    of_problem = [problem_scalars(DerivedQuantities(problem)) for problem in problems]
    numbers = [{**moment.reported.scalars, **known} for moment, known in zip(moments, of_problem, strict=True)]
    cells = [row | over_limit(row) for row in numbers]
    inputs = {key: history.course.at(key, rows).tolist() for key in VARIED if key in history.course.values}
    table = Columns({
        "distance_mm": [1e3 * moment.distance for moment in moments], "time_s": [moment.time for moment in moments],
        **inputs, "status": [CONVERGED if moment.converged else f"not_{CONVERGED}" for moment in moments],
        "reason": ["" if moment.converged else "the step was not solved" for moment in moments],
        **{name: [row[name] for row in cells] for name in cells[0] if any(row[name] == row[name] for row in cells)},
        **{f"uncertainty.{name}": error.tolist() for name, error in errors.items()}},
        varied=(*PLACES, *inputs), over=("time_s",), title=history.problem.title)
    problem = replace(problems[-1], normal_force=last.reported.scalars["normal_N"])
    state, known = last.reported, {name: float(error[-1]) for name, error in errors.items()}
    return Result(
        problem=problem, coupled=state, isothermal=state, of_problem=problem_scalars(DerivedQuantities(problem)),
        converged=not failed, reason=reason, uncertainty=known,
        work={"grid": list(last.here.grid.shape), "extent": last.here.extent, "steps": len(moments) - 1,
              "applications": sum(moment.applications for moment in moments), "skipped": {}},
        patches=tuple(patches_of(last.here, last.state.contact)), history=table)

"""A history on its grid and on the next coarser one with twice the steps: rows with estimated errors, and the last state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.history.course import History, OverTime, When
from thermoroll_cli.many_contacts.history.history_plan import MOST_STEPS, check, grids_of, places_of, warnings_of
from thermoroll_cli.many_contacts.history.kept_steps import KeptSteps
from thermoroll_cli.many_contacts.history.row_errors import ReportedMoment, errors_of_rows, scalars_of_problem
from thermoroll_cli.many_contacts.history.steps import Moment, Steps
from thermoroll_cli.many_contacts.history.surface_maps import maps_of_contact
from thermoroll_cli.one_contact.refinement.error_estimates import missed_accuracy
from thermoroll_cli.one_contact.refinement.outcome import state_of_line
from thermoroll_cli.one_contact.refinement.plan import extent_of, grown, may_grow
from thermoroll_cli.one_contact.refinement.subsurface_stage import scalars_below
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.one_contact.steady_state.scalars import patches_of
from thermoroll_cli.problem.columns import CONVERGED, Columns
from thermoroll_cli.problem.names import PLACES, SCALARS, SUBSURFACE_SCALARS, UNCERTAINTY, known_as, over_limit, per_length
from thermoroll_cli.problem.result import Result, State, Subsurface
from thermoroll_cli.problem.scalar_errors import error_scale, not_reached, worst
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.journal import Journal

NOT_SOLVED = "the step was not solved: smaller ones help where inputs change much in one"
WORTH = 0.7
"""What four times as many steps have to leave of the error at most, so that still more of them are tried."""
LOST = 1e-3
"""Share of the force that a state from a file loses between two grids, above which a warning says so."""

Report = Callable[[str, Mapping[str, Any]], None]


class HistorySolver:
    """Solves history after history."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        self._threads, self._options = threads, options

    def solve(self, history: History, *, report: Report | None = None, journal: Journal | None = None) -> Result:
        """The result of the last state, with the columns of all. What is reported of a step may have `so_far`, a function that
        makes the result up to there. Steps go into the `journal`, if there is one, and those that it has are not solved again.
        Raises Unsolvable where friction cannot carry a force, JournalError."""
        check(history)
        return on_domain(history, warnings_of(history), lambda extent, warnings: self._refined(
            history, extent, warnings, report, journal))

    def _refined(
        self, history: History, extent: float, warnings: Sequence[str], report: Report | None, journal: Journal | None
    ) -> Result | None:
        """The result on grids with ever more elements and steps, until it is as accurate as asked; None where the contact
        reaches the rim of a domain that may grow."""
        accuracy = history.problem.numerics.accuracy
        level, grids = None, list(grids_of(history, 1 if accuracy is None else self._steps(history, extent)))
        for shape, runs in grids:
            level = _Level(history, [] if level is None else level.rows, warnings)
            for run, places in enumerate(runs):
                steps = Steps(history, shape, self._options, self._threads, extent)
                for moment in steps.moments(places, KeptSteps(journal, f"{extent:g}/{shape[0]}x{shape[1]}/{run}")):
                    level.interpolated = steps.stepper.interpolated
                    level.add(moment)
                    if report is not None:
                        report("tangential", {
                            "grid": list(shape), "applications": moment.applications,
                            "residual": moment.state.contact.tangential.residual,
                            **({"so_far": level.result} if level.coarser or len(grids) == 1 else {})})
                    if moment.state.touches_rim and may_grow(extent):
                        return None
            if accuracy is not None and level.coarser and not _missed(level.result(), history):
                break
        assert level is not None
        found = level.result()
        if accuracy is not None and (missed := _missed(found, history)):
            tried = " × ".join(map(str, found.work["grid"]))
            reason = not_reached(accuracy, missed, f"on the finest grid tried, {tried} elements",
                                 "ask for less, or for others in numerics.accuracy_of, or set numerics.grid and history.steps")
            found = replace(found, converged=False, reason=found.reason or reason)
        return replace(found, surfaces=maps_of_contact(history))


    def _steps(self, history: History, extent: float) -> int:
        """How many times as many steps as the course has an accuracy takes. Steps that are long beside the contact err more
        than few elements do, and cost little on them: they are doubled there as long as that helps."""
        shape, rows = next(grids_of(history))[0], history.course.rows
        level, times, left = None, 1, [math.inf]
        while times < MOST_STEPS:
            level = _Level(history, [] if level is None else level.rows, ())
            for moment in Steps(history, shape, self._options, self._threads, extent).moments(places_of(rows, times)):
                level.add(moment)
            left.append(worst(_missed(level.result(), history).values()) if level.coarser else math.inf)
            if left[-1] == 0.0:
                return times
            if not left[-1] <= WORTH * left[max(0, len(left) - 3)]:
                return max(1, times // 4)
            times *= 2
        return times


def on_domain(history: OverTime, warnings: Sequence[str], solved: Callable[[float, Sequence[str]], Result | None],
              least: float = 0.0) -> Result:
    """What is `solved` on a domain of some half-lengths of the contact, at `least` so many, with `warnings`; the domain grows,
    and a warning says so, as long as that is None."""
    extent = max(extent_of(history.contact.numerics)[0], least)
    while (found := solved(extent, warnings)) is None:
        extent, warnings = grown(extent, warnings)
    return found


def table_of(
    history: OverTime, rows: Sequence[When], reasons: Sequence[str], columns: Mapping[str, Array], errors: Mapping[str, Array],
    states: Mapping[int, State] | None = None
) -> tuple[Columns, str]:
    """The table of `rows` with their `columns` and `errors`, the `states` of some, and the `reasons` why some were not solved
    (empty: solved), and why the whole was not."""
    course, places = history.course, np.array([row.place for row in rows])
    inputs = {key: course.at(key, places).tolist() for key in course.values}
    table = Columns({
        "distance_mm": [1e3 * row.distance for row in rows], "time_s": [row.time for row in rows],
        **inputs, "status": [f"not_{CONVERGED}" if reason else CONVERGED for reason in reasons], "reason": reasons,
        **{name: column.tolist() for name, column in columns.items() if not np.isnan(column).all()},
        **{f"{UNCERTAINTY}{name}": error.tolist() for name, error in errors.items()}},
        varied=(*PLACES, *inputs), over=("time_s",), title=history.contact.title, states=states or {})
    failed = [number for number, reason in enumerate(reasons) if reason]
    if not failed:
        return table, ""
    first = rows[failed[0]]
    return table, (f"{len(failed)} of {len(rows)} rows were not solved, the first one at {first.time:g} s after "
                   f"{1e3 * first.distance:g} mm: {reasons[failed[0]]}")


@dataclass
class _Level:
    """A history on one grid: its `rows` up to now, beside those on a `coarser` one. The state that it begins with has lost the
    share `interpolated` of its force between the grids."""

    history: History
    coarser: Sequence[ReportedMoment]
    warnings: Sequence[str]
    rows: list[ReportedMoment] = field(default_factory=list)
    interpolated: float = 0.0
    _last: Moment | None = None
    _work: int = 0
    _solved: bool = True
    _step: float = 0.0

    def add(self, moment: Moment) -> None:
        """The end of a step, which is a row where the course has one."""
        self._step = max(self._step, 0.0 if self._last is None else moment.distance - self._last.distance)
        self._last, self._work, self._solved = moment, self._work + moment.applications, self._solved and moment.converged
        if moment.place in self.history.course.rows:
            reported = _reported(moment)
            scalars = {**reported.scalars, **self._below(moment)}
            self.rows.append(ReportedMoment(moment.place, moment.time, moment.distance, scalars, self._work, self._solved,
                                 reported if moment.place in self.history.course.places_of_fields else None, self._step))
            self._work, self._solved, self._step = 0, True, 0.0

    def _below(self, moment: Moment) -> dict[str, float]:
        """The stresses below the surface of a row that keeps its fields; nan of the others."""
        if self.history.problem.subsurface is None or not len(self.history.course.places_of_fields):
            return {}
        if moment.place not in self.history.course.places_of_fields:
            return {name: math.nan for name in self.rows[0].scalars if name in SUBSURFACE_SCALARS}
        found = scalars_below(moment.here, moment.state.contact, DerivedQuantities(self.history.largest))
        return per_length(found) if self.history.problem.line else found

    def result(self) -> Result:
        """The result up to now."""
        assert self._last is not None
        lost = [] if self.interpolated <= LOST else [
            f"the state to begin with is interpolated from another grid: {100 * self.interpolated:.2g} % of its force was lost "
            "on the way and put back, and counts in the errors; take its grid and numerics.extent"]
        grid = self._last.here.grid
        errors = errors_of_rows(self.history, self.rows, self.coarser, (grid.dx, grid.dy), self.interpolated)
        return _result(self.history, self.rows, self._last, errors, [*self.warnings, *lost])


def _missed(result: Result, history: History) -> dict[str, float]:
    """The scalars whose estimated error in some row the accuracy that is asked for does not bound, over the largest scale of
    all."""
    table = result.history
    assert table is not None
    largest = {name: float(np.nanmax(np.abs(column))) for name, column in table.numbers.items()
               if not name.startswith(UNCERTAINTY)}
    errors = dict.fromkeys(SCALARS, 0.0)
    for name, column in ((name, UNCERTAINTY + known_as(name, largest)) for name in SCALARS):
        scale = error_scale(name, largest) if column in table else 0.0
        if scale:
            there = ~np.isnan(np.array(table[column.removeprefix(UNCERTAINTY)]))
            errors[name] = worst(np.array(table[column])[there]) / scale
    return missed_accuracy(errors, largest, history.problem)


def _reported(moment: Moment) -> State:
    """What is reported of a moment; of a line contact per length."""
    return state_of_line(moment.reported) if moment.here.derived.problem.line else moment.reported


def _result(
    history: History, rows: Sequence[ReportedMoment], last: Moment, errors: Mapping[str, Array], warnings: Sequence[str]
) -> Result:
    """The state of the `last` moment with the columns of all `rows`; it has converged if every step was solved."""
    problems = [history.problem_at(row.place) for row in rows]
    of_problem = [scalars_of_problem(problem) for problem in problems]
    numbers = [{**row.scalars, **known} for row, known in zip(rows, of_problem, strict=True)]
    cells = [each | over_limit(each) for each in numbers]
    # Without friction nothing is relative to what it carries.
    names = dict.fromkeys(name for each in cells for name in each)
    columns = {name: np.array([each.get(name, math.nan) for each in cells]) for name in names}
    table, reason = table_of(history, rows, ["" if row.converged else NOT_SOLVED for row in rows], columns, errors,
                             {number: row.state for number, row in enumerate(rows) if row.state is not None})
    problem = replace(problems[-1], normal_force=last.reported.scalars["normal_N"])
    state, known = _reported(last), {name: float(error[-1]) for name, error in errors.items()}
    below, errors_below = _largest_below(columns, errors)
    known = {**{name: error for name, error in known.items() if name not in below}, **errors_below}
    return Result(
        problem=problem, coupled=state, isothermal=state, of_problem=of_problem[-1],
        converged=not reason, reason=reason, uncertainty=known,
        work={"grid": list(last.here.grid.sides), "extent": last.here.extent, "steps": len(rows) - 1,
              "applications": sum(row.applications for row in rows), "skipped": {}},
        patches=tuple(patches_of(last.here, last.state.contact)), history=table, warnings=tuple(warnings),
        subsurface=Subsurface({}, below) if below else None)


def _largest_below(columns: Mapping[str, Array], errors: Mapping[str, Array]) -> tuple[dict[str, float], dict[str, float]]:
    """The largest stresses below the surface of all rows, their places at that row, and the errors of both."""
    below, uncertainty = dict[str, float](), dict[str, float]()
    for name in (name for name in columns if name in SUBSURFACE_SCALARS and "_max_" in name):
        stress, body = name.removesuffix("_MPa").split("_max_")
        row = int(np.nanargmax(columns[name]))
        of_peak = [each for each in columns if each.startswith(f"{stress}_") and each.removesuffix("_mm").endswith(f"_{body}")]
        for each in (name, *of_peak):
            below[each] = float(columns[each][row])
            if each in errors:
                uncertainty[each] = float(errors[each][row])
    return below, uncertainty

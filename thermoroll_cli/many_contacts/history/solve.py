"""A history on its grid and on the next coarser one, or on ever more elements and steps until it is accurate: rows with
estimated errors, and the last state."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.history.course import History, OverTime, When
from thermoroll_cli.many_contacts.history.history_plan import (
    FINER,
    MOST_SECONDS,
    MOST_STEPS,
    check,
    grids_of,
    seconds_of,
    shape_of,
    steps_of,
    warnings_of,
)
from thermoroll_cli.many_contacts.history.kept_steps import KeptSteps
from thermoroll_cli.many_contacts.history.row_errors import (
    FASTEST,
    Errors,
    Pair,
    ReportedMoment,
    errors_of_rows,
    mean_powers,
    scalars_of_problem,
    with_rounding,
)
from thermoroll_cli.many_contacts.history.steps import Moment, Steps
from thermoroll_cli.many_contacts.history.surface_maps import maps_of_contact
from thermoroll_cli.one_contact.refinement.error_estimates import missed_accuracy
from thermoroll_cli.one_contact.refinement.outcome import state_of_line
from thermoroll_cli.one_contact.refinement.plan import extent_of, grown, may_grow
from thermoroll_cli.one_contact.refinement.sharp_places import unseen_stick
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
"""What twice the elements or steps have to leave of their error at most, so that they are doubled again before the others."""
LOST = 1e-3
"""Share of the force that a state from a file loses between two grids, above which a warning says so."""

MOST = {"steps": MOST_STEPS, "elements": FINER}
"""How many times as many are tried at most."""

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
        solves = _Solves(history, self._threads, self._options, report, journal)
        way = solves.on_its_grid if history.problem.numerics.accuracy is None else solves.until_accurate
        return replace(on_domain(history, warnings_of(history), way), surfaces=maps_of_contact(history))


class AtRim(Exception):
    """The contact reaches the rim of a domain that may grow."""


@dataclass(frozen=True)
class _Solves:
    """Solves a `history`, as the solver was asked to."""

    history: History
    threads: int
    options: SolverOptions | None
    report: Report | None
    journal: Journal | None

    def on_its_grid(self, extent: float, warnings: Sequence[str]) -> Result:
        """The result on the grid that is asked for. Raises AtRim."""
        level, grids = _Level(self.history, warnings), grids_of(self.history)
        for number, (shape, runs) in enumerate(grids):
            before, rows = level.rows, list[ReportedMoment]()
            level = _Level(self.history, warnings, rows, {"both": [(rows, before)]} if number else {})
            self._solve(level, extent, shape, runs, so_far=shape == grids[-1][0])
        return level.result()

    def until_accurate(self, extent: float, warnings: Sequence[str]) -> Result:
        """The result on twice the elements, or with twice the steps, again and again, until all rows are as accurate as asked,
        or not even errors of second order would become so on the finest that are tried, or in `MOST_SECONDS`: what costs least
        first, until its own difference is half of the accuracy, or no longer falls. Raises AtRim."""
        accuracy, spent = self.history.problem.numerics.accuracy or 0.0, 0.0
        cheapest = ["elements", "steps"] if self.history.problem.line else ["steps", "elements"]
        at, way, level, largest = dict.fromkeys(MOST, 1), "", _Level(self.history, warnings), dict[str, float]()
        while True:
            shape, places = shape_of(self.history, at["elements"]), steps_of(self.history, at["steps"])
            self._solve(level, extent, shape, [places], so_far=way == "elements")
            spent += seconds_of(self.history, shape, len(places), level.applications)
            if len(level.pairs) < len(MOST):
                way = next(each for each in MOST if each not in level.pairs)
            else:
                missed, by_way, before = level.missed(), {each: level.missed(each) for each in MOST}, largest
                largest = {each: worst(by_way[each].get(name, 0.0) for name in missed) for each in MOST}
                per_step, left = level.applications / len(places), MOST_SECONDS - spent
                further = [each for each in cheapest if self._may_reach(at, each, largest, per_step, left)] if missed else []
                if not further:
                    break
                worth = [each for each in further if largest[each] > 0.5 * accuracy
                         and not (each == way and largest[each] > WORTH * before.get(each, math.inf))]
                way = worth[0] if worth else max(further, key=lambda each: largest[each])
            at[way] *= 2
            rows = list[ReportedMoment]()
            pairs = [(rows, level.rows), *level.pairs.get(way, [])[:1]]
            level = _Level(self.history, warnings, rows, level.pairs | {way: pairs})
        found = level.result()
        if missed:
            tried = f"{' × '.join(map(str, found.work['grid']))} elements with {at['steps']} times the steps"
            reason = not_reached(
                accuracy, missed, f"on {tried}, nor at best on the finest that are tried and that take less than "
                f"{MOST_SECONDS:g} s",
                "ask for less, or for others in numerics.accuracy_of, or set numerics.grid and history.steps")
            found = replace(found, converged=False, reason=found.reason or reason)
        return found

    def _may_reach(
        self, at: Mapping[str, int], way: str, largest: Mapping[str, float], per_step: float, left: float
    ) -> bool:
        """Whether with twice as much of one `way`, and as much as needed of the other, the errors that are the `largest` with
        what there is now (`at`) would meet the accuracy if they fell as the `FASTEST` do, by one more run that takes no more
        than the seconds `left` with so many applications `per_step`."""
        doubled = {each: range(each == way, int(math.log2(most / at[each])) + 1) for each, most in MOST.items()}
        for finer, shorter in itertools.product(doubled["elements"], doubled["steps"]):
            shape = shape_of(self.history, at["elements"] * 2**finer)
            steps = len(steps_of(self.history, at["steps"] * 2**shorter))
            error = largest["elements"] / FASTEST**finer + largest["steps"] / FASTEST**shorter
            if error <= (self.history.problem.numerics.accuracy or 0.0) and (
                    seconds_of(self.history, shape, steps, round(per_step * steps)) <= left):
                return True
        return False

    def _solve(self, level: _Level, extent: float, shape: tuple[int, int], runs: Sequence[Array], *, so_far: bool) -> None:
        """Let the `level` have the steps of all `runs` over the course; reports have its result `so_far`. Raises AtRim."""
        for run, places in enumerate(runs):
            steps = Steps(self.history, shape, self.options, self.threads, extent)
            kept = KeptSteps(self.journal, f"{extent:g}/{shape[0]}x{shape[1]}/{len(places)}/{run}")
            for moment in steps.moments(places, kept):
                level.interpolated = steps.stepper.interpolated
                level.add(moment)
                if self.report is not None:
                    self.report("tangential", {
                        "grid": list(shape), "applications": moment.applications,
                        "residual": moment.state.contact.tangential.residual, **({"so_far": level.result} if so_far else {})})
                if moment.state.touches_rim and may_grow(extent):
                    raise AtRim


def on_domain(history: OverTime, warnings: Sequence[str], solved: Callable[[float, Sequence[str]], Result],
              least: float = 0.0) -> Result:
    """What is `solved` on a domain of some half-lengths of the contact, at `least` so many, with `warnings`; the domain grows,
    and a warning says so, as long as that raises AtRim."""
    extent = max(extent_of(history.contact.numerics)[0], least)
    while True:
        try:
            return solved(extent, warnings)
        except AtRim:
            extent, warnings = grown(extent, warnings)


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
    """A history on one grid: its `rows` up to now, and the `pairs` of finer and coarser rows, the finest first, by what these
    differ in. The state that it begins with has lost the share `interpolated` of its force between the grids."""

    history: History
    warnings: Sequence[str]
    rows: list[ReportedMoment] = field(default_factory=list)
    pairs: dict[str, list[Pair]] = field(default_factory=dict)
    interpolated: float = 0.0
    _last: Moment | None = None
    _row: Moment | None = None
    _work: int = 0
    _solved: bool = True
    _step: float = 0.0

    def add(self, moment: Moment) -> None:
        """The end of a step, which is a row where the course has one."""
        self._step = max(self._step, 0.0 if self._last is None else moment.distance - self._last.distance)
        is_row, before = moment.place in self.history.course.rows, self._row
        at_rest = before is not None and before.time < moment.time and before.distance == moment.distance
        if is_row:
            moment = self._row = self._with_means(before, moment) if before is not None and at_rest else moment
        self._last, self._work, self._solved = moment, self._work + moment.applications, self._solved and moment.converged
        if is_row:
            reported = _reported(moment)
            scalars = {**reported.scalars, **self._below(moment)}
            self.rows.append(ReportedMoment(moment.place, moment.time, moment.distance, scalars, self._work, self._solved,
                                 reported if moment.place in self.history.course.places_of_fields else None, self._step,
                                 unseen_stick(moment.here, moment.state.contact, scalars["gamma_st"]),
                                 before.place if before is not None and at_rest else None))
            self._work, self._solved, self._step = 0, True, 0.0

    def _with_means(self, before: Moment, moment: Moment) -> Moment:
        """A row whose powers, as nothing has rolled since the row `before`, are the means since then: those of single steps
        would be other quantities with other steps, as where a shift turns back and all sticks for a while."""
        reported = moment.reported
        rubbed, lasted = reported.scalars["heat_J"] - before.reported.scalars["heat_J"], moment.time - before.time
        powers = {name: power for name, power in mean_powers(self.history.problem, rubbed, lasted).items()
                  if not math.isnan(reported.scalars[name])}
        return replace(moment, reported=replace(reported, scalars={**reported.scalars, **powers}))

    def _below(self, moment: Moment) -> dict[str, float]:
        """The stresses below the surface of a row that keeps its fields; nan of the others."""
        if self.history.problem.subsurface is None or not len(self.history.course.places_of_fields):
            return {}
        if moment.place not in self.history.course.places_of_fields:
            return {name: math.nan for name in self.rows[0].scalars if name in SUBSURFACE_SCALARS}
        found = scalars_below(moment.here, moment.state.contact, DerivedQuantities(self.history.largest))
        return per_length(found) if self.history.problem.line else found

    @property
    def applications(self) -> int:
        """Those of all rows."""
        return sum(row.applications for row in self.rows)

    def result(self) -> Result:
        """The result up to now."""
        assert self._last is not None
        lost = [] if self.interpolated <= LOST else [
            f"the state to begin with is interpolated from another grid: {100 * self.interpolated:.2g} % of its force was lost "
            "on the way and put back, and counts in the errors; take its grid and numerics.extent"]
        # No grid betters these errors: they do not count for the accuracy.
        errors = with_rounding(self.history, self.rows, self._errors(self.pairs))
        return _result(self.history, self.rows, self._last, errors, [*self.warnings, *lost])

    def missed(self, way: str = "") -> dict[str, float]:
        """Estimated errors of scalars in the row that errs most, over their largest scales: of those that the accuracy that is
        asked for does not bound, or of all by one way alone."""
        columns = _columns(self.history, self.rows)
        largest = {name: float(np.nan_to_num(np.abs(column)).max()) for name, column in columns.items()}
        found, errors = dict.fromkeys(SCALARS, 0.0), self._errors({way: self.pairs[way]} if way else self.pairs)
        for name, own in ((name, known_as(name, largest)) for name in SCALARS):
            if own in errors and (scale := error_scale(name, largest)):
                found[name] = worst(errors[own][~np.isnan(columns[own])]) / scale
        return found if way else missed_accuracy(found, largest, self.history.problem)

    def _errors(self, ways: Mapping[str, Sequence[Pair]]) -> Errors:
        assert self._last is not None
        grid = self._last.here.grid
        return errors_of_rows(self.history, self.rows, ways, (grid.dx, grid.dy), self.interpolated)


def _reported(moment: Moment) -> State:
    """What is reported of a moment; of a line contact per length."""
    return state_of_line(moment.reported) if moment.here.derived.problem.line else moment.reported


def _result(
    history: History, rows: Sequence[ReportedMoment], last: Moment, errors: Mapping[str, Array], warnings: Sequence[str]
) -> Result:
    """The state of the `last` moment with the columns of all `rows`; it has converged if every step was solved."""
    columns = _columns(history, rows)
    table, reason = table_of(history, rows, ["" if row.converged else NOT_SOLVED for row in rows], columns, errors,
                             {number: row.state for number, row in enumerate(rows) if row.state is not None})
    problem = history.problem_at(rows[-1].place)
    of_problem = scalars_of_problem(problem)
    problem = replace(problem, normal_force=last.reported.scalars["normal_N"])
    state, known = _reported(last), {name: float(error[-1]) for name, error in errors.items()}
    below, errors_below = _largest_below(columns, errors)
    known = {**{name: error for name, error in known.items() if name not in below}, **errors_below}
    return Result(
        problem=problem, coupled=state, isothermal=state, of_problem=of_problem,
        converged=not reason, reason=reason, uncertainty=known,
        work={"grid": list(last.here.grid.sides), "extent": last.here.extent, "steps": len(rows) - 1,
              "applications": sum(row.applications for row in rows), "skipped": {}},
        patches=tuple(patches_of(last.here, last.state.contact)), history=table, warnings=tuple(warnings),
        subsurface=Subsurface({}, below) if below else None)


def _columns(history: History, rows: Sequence[ReportedMoment]) -> dict[str, Array]:
    """The scalars of all rows, those of their problems among them."""
    numbers = [{**row.scalars, **scalars_of_problem(history.problem_at(row.place))} for row in rows]
    cells = [each | over_limit(each) for each in numbers]
    # Without friction nothing is relative to what it carries.
    names = dict.fromkeys(name for each in cells for name in each)
    return {name: np.array([each.get(name, math.nan) for each in cells]) for name in names}


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

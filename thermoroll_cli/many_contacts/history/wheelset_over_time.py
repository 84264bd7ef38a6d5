"""A wheelset over time: it moves on a given path, and its patches remember their tractions.

At each row the wheelset is in balance as in the steady state (`wheelset.solve_wheelset`), but its patches are contacts over
time (`steps`). There is no inertia: forces that are given, or the missing torque about the axle, hold at each moment. Where a
position changes, its velocity is that of the path.

A patch has one grid for all rows. It stays with the material of the rail across, by the arc length of the outline; so a patch
that wanders keeps its tractions where they are. That the material of the wheel lies elsewhere by then, and that tractions turn
with the surface, is left out: both are as small as the ratio of the velocities across and along. A patch that appears begins
without tractions, and where patches of a side come, go, join or part, all of them go on from the tractions that were there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from thermoroll_cli.many_contacts.history.course import Beginning, WheelsetHistory, When
from thermoroll_cli.many_contacts.history.history_plan import FIRST, grids_of, surface_warnings, warnings_of, wave_warnings
from thermoroll_cli.many_contacts.history.row_errors import OF_TRACTIONS, over_rows, safety_of, unseen_pressure, within_reach
from thermoroll_cli.many_contacts.history.solve import AtRim, on_domain, table_of
from thermoroll_cli.many_contacts.history.steps import Reached, Stepper
from thermoroll_cli.many_contacts.history.surface_maps import maps_of_wheelset
from thermoroll_cli.many_contacts.wheelset.first_contact import (
    ROUNDED,
    facts_of,
    roll_of,
    touching,
    touching_points,
    wheelset_warnings,
)
from thermoroll_cli.many_contacts.wheelset.one_wheel import NoHeight, same_patch
from thermoroll_cli.many_contacts.wheelset.patch_problem import SolvedPatch, problem_of_patch
from thermoroll_cli.many_contacts.wheelset.patch_surface import PatchSurface, nearest
from thermoroll_cli.many_contacts.wheelset.placement import RailSide, Side
from thermoroll_cli.many_contacts.wheelset.solve_wheelset import Loaded, Report, SolvedWheelset, balanced
from thermoroll_cli.many_contacts.wheelset.standing import Standing, stand, wheels_of
from thermoroll_cli.many_contacts.wheelset.varying import AROUND
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName, sign_of
from thermoroll_cli.many_contacts.wheelset.wheelset_result import result_of
from thermoroll_cli.one_contact.refinement.error_estimates import FLOOR
from thermoroll_cli.one_contact.refinement.outcome import rounded
from thermoroll_cli.one_contact.refinement.plan import extent_of, may_grow
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.one_contact.steady_state.fixed_point import SteadyState
from thermoroll_cli.one_contact.steady_state.scalars import problem_scalars
from thermoroll_cli.physics.heat.heat_over_time import End
from thermoroll_cli.physics.numerics.grid import Domain, interpolation_matrix
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.problem.surface import Heights, Shifted, Texture
from thermoroll_cli.tools.arrays import Array

PLACES_OF_SLICES = 64, 2000
"""Fewest and most places along at which the surface between slices is looked at."""


@dataclass(frozen=True)
class _Solved(When):
    """A row with the wheelset as it stands there (`solved`), its `result`, and the `applications` since the row before."""

    solved: SolvedWheelset
    result: Result
    applications: int


@dataclass
class _PatchOverTime:
    """A patch whose contacts at all rows take the rail's outline from `low` to `high`, and `length` along (all in m), on one
    grid of the run. It appears at the place `appears`, and lies at `y`, with the `shift` from its own places across to those of
    the rail. It is `used` in the round that is being solved, and did bear the wheelset (`bears`) at the row before."""

    side: SideName
    appears: float
    run: _Patches
    length: float = 0.0
    low: float = math.inf
    high: float = -math.inf
    y: float = math.nan
    shift: float = 0.0
    used: bool = False
    bears: bool = False
    _stepper: Stepper | None = None
    _reached: tuple[Reached | None, Reached | None] = (None, None)
    _trial: tuple[Discretisation, SteadyState, End] | None = None

    def hold(self, derived: DerivedQuantities) -> None:
        """Let the patch take the place of the contact of a problem, too."""
        domain = derived.scales.domain(2.0)  # without room around the contact
        self.length = max(self.length, domain.side_x + 2.0 * abs(domain.centre_x))
        self.low = min(self.low, domain.centre - 0.5 * domain.side_y)
        self.high = max(self.high, domain.centre + 0.5 * domain.side_y)

    def solve(self, problem: Problem) -> Result:
        """The step to the row that is being solved, with the `problem` of the patch there."""
        run, moved = self.run, _moved(problem, self.shift)
        derived = DerivedQuantities(moved)
        if self._stepper is None:
            if self.length == 0.0:
                # Friction brings it to bear where no patch was expected.
                self.hold(derived)
            room = 0.5 * run.extent
            domain = Domain(room * self.length, room * (self.high - self.low), 0.5 * (self.low + self.high))
            self._stepper = Stepper(Discretisation(
                derived, run.shape, run.extent, run.threads, run.options, followed=domain), None)
        stepper, row, before = self._stepper, run.row, run.before
        stepper.last, stepper.before = self._reached
        if before is None:
            begin = run.history.course.begin
            here, state = stepper.begin(moved, self._carried() if isinstance(begin, Result) else begin)
            now = End(row.time)
        else:
            if stepper.last is None or run.regrouped(self.side):
                here, state = stepper.begin(moved, self._carried())
                stepper.before = stepper.last = None
                stepper.reach(here, state.contact, before.place, End(before.time), before.distance)
                if stepper.memory is not None and not stepper.memory.begun:
                    stepper.remember(here, state.contact, End(before.time))  # a patch that appears is cold
            here, now = stepper.step(moved, row.time, row.distance, jumps=run.jumps)
            state = stepper.solved(here)
        stepper.reach(here, state.contact, row.place, now, row.distance)
        self._trial = here, state, now
        reported = stepper.reported(here, state)
        run.applications += state.applications
        converged = state.converged and state.contact.tangential.converged
        shown = State(reported.fields, reported.scalars, reported.x, reported.y - self.shift)
        return Result(
            problem=replace(problem, normal_force=reported.scalars["normal_N"]), coupled=shown, isothermal=shown,
            of_problem=problem_scalars(derived), converged=converged, reason="" if converged else "a step was not solved",
            uncertainty=dict.fromkeys(reported.scalars, 0.0),
            work={"grid": list(here.grid.sides), "extent": run.extent, "applications": state.applications, "skipped": {}})

    def _carried(self) -> Beginning | State:
        """The tractions that all patches of this side had last, on this grid; without any, none yet."""
        assert self._stepper is not None
        grid, found = self._stepper.base.grid, dict.fromkeys(("pressure", "shear_x", "shear_y"), np.zeros(self.run.shape))
        states = [state for state in self.run.remembered.get(self.side, ())
                  if state.y[0] < grid.y[-1] and state.y[-1] > grid.y[0]]
        for state in states:
            along, across = interpolation_matrix(state.x, grid.x), interpolation_matrix(state.y, grid.y)
            found = {name: field + along @ np.asarray(state.fields[name]) @ across.T for name, field in found.items()}
        return State(found, {}, grid.x, grid.y) if states else "pressed"

    def accept(self) -> State | None:
        """Go on from the last trial, whose state is returned, with places on the rail; without one, from nothing."""
        self.bears = self.used
        if not self.used or self._stepper is None or self._trial is None:
            self._stepper, self._reached, self._trial = None, (None, None), None
            return None
        here, state, now = self._trial
        self.hold(here.derived)
        self.run.touches_rim = self.run.touches_rim or state.touches_rim
        self._reached = self._stepper.last, self._stepper.before
        self._stepper.remember(here, state.contact, now, always=self.run.before is None
                               and self.run.history.course.begin == "steady")
        self._trial = None
        shear_x, shear_y = state.contact.tangential.traction
        return State({"pressure": state.contact.normal.pressure, "shear_x": shear_x, "shear_y": shear_y}, {},
                     here.grid.x, here.grid.y)


def _moved(problem: Problem, shift: float) -> Problem:
    """The problem of a patch with all places across moved by `shift` (m)."""
    geometry, friction = problem.geometry, problem.friction
    assert isinstance(geometry, CurvedPatch)
    across = tuple((y + shift, share) for y, share in friction.across)
    heights = None if geometry.heights is None else Shifted(geometry.heights, shift)
    return replace(problem, friction=replace(friction, across=across),
                   geometry=replace(geometry, y=tuple((np.array(geometry.y) + shift).tolist()), heights=heights))


def _on_rail(patch: Result, rail: RailSide) -> State:
    """The state of a patch in a result, with places on its rail across."""
    middle = len(patch.y) // 2
    y, z, _ = patch.lines["surface"][:, middle]
    place = sign_of(patch.record["side"]) * y
    shift = -(_arc(rail.samples, place, z) if rail.slices is None else place) - patch.y[middle]
    return State(patch.coupled.fields, patch.coupled.scalars, patch.x, patch.y + shift)


def _arc(rail: Array, y: float, z: float) -> float:
    """The arc length on a rail (rows y, z, dy/ds, dz/ds) at the point (y, z), in m."""
    at = nearest(rail, y, z)
    length = float(np.hypot(*np.diff(rail[:2, : at + 1])).sum())
    along = rail[2:, at] / np.hypot(*rail[2:, at])
    return length + float(along @ (np.array([y, z]) - rail[:2, at]))


@dataclass
class _Patches:
    """All patches of a `history` on grids of one `shape` over `extent` half-lengths, at the `row` that is being solved after
    the one `before` (None: it is the first); at that inputs may have jumped (`jumps`)."""

    history: WheelsetHistory
    shape: tuple[int, int]
    extent: float
    threads: int
    options: SolverOptions
    rough_first: bool = False
    row: When = field(init=False)
    before: When | None = None
    jumps: bool = False
    applications: int = 0
    touches_rim: bool = False
    patches: list[_PatchOverTime] = field(default_factory=list)
    remembered: dict[SideName, list[State]] = field(default_factory=dict)

    def of(self, loaded: Loaded, *, rough: bool = False) -> Sequence[_PatchOverTime]:
        """Those of the patches that bear the wheelset."""
        for patch in self.patches:
            patch.used = False
        return [self._near(side, carrying.patch) for side, carrying in loaded]

    def _near(self, side: SideName, patch: PatchSurface) -> _PatchOverTime:
        """The patch nearest to a place on a side that is not in use already."""
        free = [each for each in self.patches if each.side == side and not each.used]
        near = same_patch(free, patch.y, lambda each: each.y)
        if near is None:
            near = _PatchOverTime(side, patch.y, self)
            self.patches.append(near)
        near.y, near.shift, near.used = patch.y, -self._place(side, patch, near.appears), True
        return near

    def _place(self, side: SideName, patch: PatchSurface, appears: float) -> float:
        """The place (m) of a patch across on the material of its rail: the arc length of the outline, and of a rail that
        changes, whose outlines are no longer alike, y where it `appears` and the way along its surface from there."""
        if self.history.problem.rails[side].slices is None:
            return _arc(patch.facing.rail.samples, patch.y, patch.z)
        return appears + (patch.y - appears) / math.cos(patch.angle)

    def regrouped(self, side: SideName) -> bool:
        """Whether other patches bear a side than at the row before: patches have come, gone, joined or parted."""
        return any(patch.used != patch.bears for patch in self.patches if patch.side == side)

    def look_ahead(self, rows: Array) -> None:
        """Find the domains of all patches: those of the contacts without friction at all rows."""
        wheels, standing = wheels_of(self.history.problem), None
        for place in rows.tolist():
            problem = self.history.problem_at(place)
            try:
                standing = stand(problem, wheels, {}, standing or Standing(roll_of(touching(problem)), 0.0, {}))
            except NoHeight:
                continue
            motion = replace(problem.motion, angular_velocity=0.0)
            loaded = [(side, carrying) for side, patches in standing.carrying.items() for carrying in patches]
            for patch, (side, carrying) in zip(self.of(loaded), loaded, strict=True):
                one = problem_of_patch(problem.contact, carrying, motion if side == "right" else motion.mirrored)
                patch.hold(DerivedQuantities(_moved(one, patch.shift)))

    def afresh(self, shape: tuple[int, int], extent: float) -> _Patches:
        """The same patches where they appear, on other grids, before the first row."""
        found = _Patches(self.history, shape, extent, self.threads, self.options)
        found.patches += [_PatchOverTime(each.side, each.appears, found, each.length, each.low, each.high, y=each.appears)
                          for each in self.patches]
        return found

    def rows(self, places: Array, report: Report) -> Iterator[_Solved]:
        """The wheelset at all `places`, with steps to the stops between them."""
        history, found = self.history, None
        stops = history.with_stops(places)
        if isinstance(history.course.begin, Result):
            self.remembered = {side: [_on_rail(patch, rail) for patch in history.course.begin.patches
                                      if isinstance(patch, Result) and patch.record["side"] == side]
                               for side, rail in history.problem.rails.items()}
        for stop, time, distance in zip(stops.tolist(), *(each.tolist() for each in history.clock(stops)), strict=True):
            self.before, self.row = (None if found is None else self.row), When(stop, time, distance)
            self.jumps = self.before is not None and self.before.place in history.course.jumps
            problem = history.problem_at(stop)
            # Where a velocity jumps the last balance is no guess of the next one.
            turned = self.before is not None and any(self.before.place <= each < stop for each in history.course.places)
            found = balanced(problem, roll_of(touching(problem)), None if turned else found, self, report)
            accepted = [(patch.side, patch.accept()) for patch in self.patches]
            self.remembered = {of: [state for side, state in accepted if side == of and state is not None] for of in SIDES}
            if stop in places:
                yield _Solved(stop, time, distance, found, result_of(found, ()), self.applications)
                self.applications = 0


def warnings_over_time(history: WheelsetHistory) -> Iterator[str]:
    """Warnings that need no solution. Raises Unsolvable where a wheel misses its rail at the beginning."""
    yield from warnings_of(history)
    yield from wheelset_warnings(history.start)
    problem, sides, warned = history.start, dict[int, float](), set[Heights]()
    if problem.vertical is not None:
        # Elements about as long as on a ball of the wheel's radius under its share of the load.
        numerics, load = problem.contact.numerics, problem.vertical / len(problem.sides)
        radius = next(iter(problem.wheels.values())).radius
        half = (0.75 * load * radius / problem.contact.contact_modulus) ** (1.0 / 3.0)
        count = (numerics.grid or (FIRST, FIRST))[0]
        sides[count] = extent_of(numerics)[0] * half / count
    for side, surfaces in problem.surfaces.items():
        for body, surface in zip(("rail", "wheel"), surfaces, strict=True):
            if surface is not None and surface not in warned:
                warned.add(surface)
                yield from surface_warnings(history, f"the {side} {body}", surface.texture, sides)
    for name, texture in textures_of_slices(history).items():
        yield from wave_warnings(history, name, texture.shortest, sides)


def textures_of_slices(history: WheelsetHistory) -> dict[str, Texture]:
    """How surfaces between slices depart from straight ones on the lines of first contact at the beginning, over what a history
    rolls over and patches see around it; those that no pressure notices are left out."""
    start, end, found = history.start, history.problem_at(history.course.places[-1]), dict[str, Texture]()
    for side, facing in touching(start).items() if start.varies else ():
        wheel, ahead = facing.wheel, float(facing.ahead[int(np.argmin(facing.gap))])
        bodies: tuple[tuple[str, Side, float, float, float], ...] = (
            ("rail", facing.rail, facing.rail.along, end.rails[side].along, 1.0),
            ("wheel", wheel, wheel.turned, end.wheels[side].turned, wheel.radius))
        for (body, own, first, last, scale), (_, point) in zip(bodies, touching_points(facing), strict=True):
            if own.slices is None:
                continue
            ends = scale * first - AROUND, scale * last + AROUND
            spacing = 0.5 * scale * min(np.diff(own.slices.at), default=math.inf)
            places = np.linspace(*ends, int(np.clip((ends[1] - ends[0]) / spacing, *PLACES_OF_SLICES)) + 1)
            heights = own.slices.along(places / scale, first + ahead / scale, point)
            departure = heights - np.polyval(np.polyfit(places - ends[0], heights, 1), places - ends[0])
            texture = Texture.of(departure[:, None], (float(places[1] - places[0]), 1.0))
            if 0.5 * texture.slope > ROUNDED:
                found[f"the {side} {body}"] = texture
    return found


def facts_over_time(history: WheelsetHistory) -> dict[str, float]:
    """Numbers known before solving, at the beginning."""
    return facts_of(history.start)


class WheelsetHistorySolver:
    """Solves wheelsets over time."""

    def __init__(self, threads: int = 1, options: SolverOptions | None = None) -> None:
        self._threads, self._options = threads, options or SolverOptions()

    def solve(self, history: WheelsetHistory, *, report: Report | None = None) -> Result:
        """The result of the last row, with the columns of all. Raises Unsolvable where a wheel misses its rail."""
        warnings = list(dict.fromkeys(warnings_over_time(history)))
        grids = grids_of(history)
        finest, (all_places,) = grids[-1]
        known = _Patches(history, finest, 0.0, self._threads, self._options)
        known.look_ahead(history.with_stops(all_places))

        def refined(extent: float, warnings: Sequence[str]) -> Result:
            """The result on grids with more and more elements and steps. Raises AtRim where a contact reaches the rim of a
            domain that may grow, which is then known to be there."""
            nonlocal known
            coarser, rows = dict[float, _Solved](), dict[float, _Solved]()
            for shape, runs in grids:
                coarser, rows = rows, {}
                for places in runs:
                    patches, grows = known.afresh(shape, extent), may_grow(extent)
                    for row in patches.rows(places, report or (lambda stage, info: None)):
                        if row.place in history.course.rows:
                            rows[row.place] = row
                        if grows and patches.touches_rim and shape == finest:
                            break
                    if grows and patches.touches_rim:
                        known = patches
                        raise AtRim
            return _result(history, rows, coarser, warnings)

        # The coarsest grid has an element beside the contacts of all rows at each end.
        coarsest = min(grids[0][0])
        return on_domain(history, warnings, refined, 2.0 * coarsest / (coarsest - 2.0) + 1e-9)


def _result(
    history: WheelsetHistory, rows: Mapping[float, _Solved], coarser: Mapping[float, _Solved], warnings: Sequence[str]
) -> Result:
    """The result of the last of the `rows` with the columns of all. Errors are the differences from `coarser` grids and steps,
    as those of contacts over time, and what the balance of each row has left."""
    results, places = [row.result for row in rows.values()], np.array([*rows])
    names = list(dict.fromkeys(name for result in results for name in result.coupled.scalars))
    columns = {name: np.array([result.coupled.scalars.get(name, math.nan) for result in results]) for name in names}
    largest = {name: float(np.nan_to_num(np.abs(column)).max()) for name, column in columns.items()}
    errors: dict[str, Array] = {}
    # What was not solved has no error, and says nothing about that of other rows.
    done = np.array([result.converged for result in results])
    solved = done & [place in coarser and coarser[place].result.converged for place in places.tolist()]
    for name, column in columns.items() if coarser else ():
        left = np.array([result.uncertainty.get(name, math.nan) for result in results])
        other = np.array([coarser[place].result.coupled.scalars.get(name, math.nan) for place in places.tolist()])
        known = ~np.isnan(column - other) & solved
        if known.any() and not np.isnan(left).all():
            safety = safety_of(name.replace("_left_", "_").replace("_right_", "_"))
            error = safety * over_rows(places, places[known], np.abs(column - other)[known])
            error = _within_friction(name, column, error + left + FLOOR * error_scale(name, largest), [*rows.values()])
            error = error + [max((_by_rounding(name, each) for each in row.solved.patches), default=0.0)
                             for row in rows.values()]
            if name == "pressure_max_MPa":
                error = error + [max(map(_unseen_pressure, row.solved.patches), default=0.0) for row in rows.values()]
            errors[name] = np.where(np.isnan(column) | ~done, math.nan, error)
    table, reason = table_of(history, [*rows.values()], [result.reason for result in results], columns, errors)
    last = rows[places.tolist()[-1]]
    before = coarser.get(last.place)
    patches = tuple(replace(patch, result=replace(patch.result, uncertainty=_errors_of_patch(patch, before)))
                    for patch in last.solved.patches)
    found = result_of(replace(last.solved, patches=patches), tuple(warnings))
    first = next(iter(rows.values()))
    return replace(found, converged=not reason, reason=reason, history=table,
                   surfaces=maps_of_wheelset(first.solved.patches, last.solved.patches),
                   uncertainty={**found.uncertainty, **{name: float(error[-1]) for name, error in errors.items()}},
                   work={**found.work, "steps": len(rows) - 1, "applications": sum(row.applications for row in rows.values())})


def _within_friction(name: str, column: Array, error: Array, rows: Sequence[_Solved]) -> Array:
    """The `error` of a scalar that is no larger than what friction lets the patches of its side have: the rails feel along the
    track no more than that, and tractions do nothing without it."""
    sides = [side for side in SIDES if f"_{side}_" in name] or SIDES
    limit = np.array([sum(patch.result.problem.friction.highest * patch.result["normal_N"] for patch in row.solved.patches
                          if patch.side in sides) for row in rows])
    if name.startswith("track_force_x"):
        return np.minimum(error, limit + np.abs(column))
    of_tractions = any(name.startswith(each.rpartition("_")[0]) for each in OF_TRACTIONS)
    return np.where(limit == 0.0, 0.0, error) if of_tractions else error


def _errors_of_patch(solved: SolvedPatch, before: _Solved | None) -> dict[str, float]:
    """Errors of the scalars of a patch at the last row, from the patch there on the coarser grid; nan without one."""
    mine = [patch for patch in before.solved.patches if patch.side == solved.side] if before else []
    near = same_patch(mine, solved.carrying.patch.y, lambda patch: patch.carrying.patch.y)
    scalars = solved.result.coupled.scalars
    other = near.result.coupled.scalars if near else dict.fromkeys(scalars, math.nan)
    errors = {name: safety_of(name) * abs(value - other[name]) + FLOOR * scale + _by_rounding(name, solved)
              for name, value in scalars.items() for scale in [error_scale(name, solved.result.numbers)]}
    errors["pressure_max_MPa"] += _unseen_pressure(solved)
    bounded = within_reach({name: np.array([error]) for name, error in errors.items()},
                           {name: np.array([value]) for name, value in scalars.items()},
                           np.array([solved.result.problem.friction.highest]))
    return {name: float(error[0]) for name, error in bounded.items()}


def _by_rounding(name: str, solved: SolvedPatch) -> float:
    """What the rounding of the profiles of a patch does to a scalar, in its unit."""
    result = solved.result
    geometry = result.problem.geometry
    if name not in result.numbers or not (isinstance(geometry, CurvedPatch) and geometry.rounded):
        return 0.0
    return rounded(name, DerivedQuantities(result.problem), result.coupled.scalars) * error_scale(name, result.numbers)


def _unseen_pressure(solved: SolvedPatch) -> float:
    """What the elements of a patch do not see of its surfaces, in MPa."""
    facing, state = solved.carrying.patch.facing, solved.result.coupled
    return unseen_pressure(solved.result.problem, (facing.rail.surface, facing.wheel.surface),
                           (float(state.x[1] - state.x[0]), float(state.y[1] - state.y[0])))

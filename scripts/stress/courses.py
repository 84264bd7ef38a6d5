"""Seeded contacts over time, and the check of each: what must not change, and estimates against finer grids and steps."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from scripts.stress.outcome import Outcome, Pair
from scripts.stress.random_contacts import random_contact
from scripts.stress.random_lines import random_line, random_line_of_bodies
from scripts.stress.random_profiles import random_profile_contact
from thermoroll_cli.many_contacts.history.course import Course, History
from thermoroll_cli.many_contacts.history.solve import HistorySolver
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.geometry import ContactGeometry, Geometry, Unsolvable
from thermoroll_cli.problem.names import UNCERTAINTY
from thermoroll_cli.problem.problem import Heating, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.problem.surface import Dent, Flat, Heights, MeasuredHeights, Wave

GRIDS = (16, 20, 24)
REFERENCE, SHOWN = 3, 5
"""Elements and steps of the reference over those of the case, and the rows of it whose errors are looked at."""
SMOOTH = "crown", "cubic", "off centre"
SAME = 1e-4
"""Of μW: two solutions that are the same but for the tolerances of the solver."""
ALONG, ACROSS, SPIN, LOAD = "creepage.longitudinal", "creepage.lateral", "creepage.spin_rad_mm", "load.normal_N"
FORCE, SPEED, SHIFT, SHIFT_ACROSS = "force.longitudinal_N", "rolling.speed_m_s", "shift.longitudinal_um", "shift.lateral_um"
PER_LENGTH = "_mm"
"""What names of loads and forces of line contacts end in besides."""
ODD = ACROSS, SPIN, "force.lateral_N", SHIFT_ACROSS
"""Keys that change their sign in the mirror."""


def random_course(seed: int) -> History:
    """The history of `seed` without heat, always the same."""
    return _course_of(seed, replace(random_contact(seed), heating=Heating(heat=False)))


def line_course(seed: int) -> History:
    """The history of `seed` of a line contact without heat: homogeneous bodies, every other one coated."""
    problem = random_line_of_bodies(3 * seed) if seed % 2 else random_line(4 * seed)
    problem = replace(problem, heating=Heating(heat=False), motion=replace(problem.motion, speed=1.0))
    rng, half = np.random.default_rng([73, seed]), DerivedQuantities(problem).scales.semi_axis_x
    history = _course_of(seed, replace(problem, length=half * 10.0 ** float(rng.uniform(1.0, 2.5))))
    # Loads and forces are per mm.
    course = _times(history.course, dict.fromkeys((LOAD, FORCE), 1e-3))
    values = {f"{key}{PER_LENGTH}" if key in (LOAD, FORCE) else key: column for key, column in course.values.items()}
    return replace(history, course=replace(course, values=values))


def warm_course(seed: int) -> History:
    """The history of `seed` with the heat of bodies that roll, some of which it deforms, or at rest."""
    for further in itertools.count():
        problem = random_contact(1000 * (seed + 1) + further)
        if problem.heating.heat and problem.heating.peclet == "rolling":
            break
    return _course_of(seed, problem)


def odd_course(seed: int) -> History:
    """The history of `seed` as no other one is drawn: one step, two, or a row for each place; jumps at the first and at the
    last place; profiles whose contact is not at y = 0; each with heat or without."""
    rng = np.random.default_rng([72, seed])
    history = warm_course(seed) if rng.random() < 0.4 else random_course(seed)
    if rng.random() < 0.4:
        profile = replace(random_profile_contact(seed, SMOOTH), heating=Heating(heat=False))
        history = _course_of(seed, replace(profile, motion=replace(profile.motion, at="contact")))
    course = history.course
    for at in (0, len(course.places) - 1):
        if rng.random() < 0.5 and course.places[at] not in course.jumps:
            values = {key: (*given[:at], -given[at] if key in ODD else 0.9 * given[at], *given[at:])
                      for key, given in course.values.items()}
            course = replace(course, places=(*course.places[:at], *course.places[at:][:1], *course.places[at:]), values=values)
    return replace(history, course=replace(course, steps=[1, 2, None][int(rng.integers(3))]))


def rough_course(seed: int) -> History:
    """The history of `seed`, every third one of a line contact, every third one with heat, whose bodies have surfaces: waves,
    dents, flats and random heights, as high as a part of the approach, on one body or on both."""
    rng = np.random.default_rng([74, seed])
    history = (random_course, line_course, warm_course)[seed % 3](seed)
    scales, line = DerivedQuantities(history.largest).scales, history.problem.line
    half = scales.semi_axis_x
    approach = half**2 * history.problem.geometry.curvature_x if line else scales.approach

    def surface() -> Heights:
        height, length = approach * 10.0 ** float(rng.uniform(-2.5, -0.8)), half * float(rng.uniform(0.4, 3.0))
        start = half * float(rng.uniform(0.0, 3.0))
        kind = int(rng.integers(0, 4))
        if kind == 0:
            return Wave(height, length, 0.0 if line else float(rng.uniform(-math.pi, math.pi)), start)
        if kind == 1 and not line:
            depth, shoulder = height * float(rng.choice([-1.0, 1.0, 3.0])), height * float(rng.uniform(0.0, 0.5))
            return Dent(depth, 0.5 * length, shoulder, start)
        if kind == 2:
            return Flat(length, length**2 / (8.0 * height), 0.2 * length, start)
        points = rng.normal(size=(24, 1 if line else 24))
        sides = 0.5 * half, half if line else 0.5 * scales.semi_axis_y
        return MeasuredHeights(height * points, sides, start, -12.0 * sides[1], (True, not line))

    bodies = int(rng.integers(1, 4))
    return replace(history, surfaces=(surface() if bodies & 1 else None, surface() if bodies & 2 else None))


def _course_of(seed: int, problem: Problem) -> History:
    """The contact of `problem` over time: rolling that starts, cycles and shifts without rolling, a stop between, loads that
    change, kinks, jumps and zeros, a few long steps or many short ones, square and slender grids."""
    rng = np.random.default_rng([71, seed])
    n = int(rng.choice(GRIDS))
    grid = (n, n) if rng.random() < 0.8 else (n, 2 * n) if rng.random() < 0.5 else (2 * n, n)
    grid = (n, 1) if problem.line else grid
    derived = DerivedQuantities(problem)
    motion, length = problem.motion, 2.0 * derived.scales.semi_axis_x
    problem = replace(problem, numerics=Numerics(grid, extent=float(rng.choice([2.2, 2.6]))))
    knots, begin = int(rng.integers(2, 6)), "pressed" if rng.random() < 0.4 else "steady"
    places = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.5, knots - 1))]) * length
    if rng.random() < 0.4:  # a jump
        at = int(rng.integers(0, knots))
        places = np.insert(places, at, places[at])
    steps, count = int(rng.choice([3, 6, 12, 24])), len(places)

    def course(size: float, *, zeros: bool = True) -> tuple[float, ...]:
        values = size * rng.uniform(-1.0, 1.0, count) if zeros else size * rng.uniform(0.4, 1.0, count)
        if zeros and rng.random() < 0.3:
            values[int(rng.integers(0, count))] = 0.0
        return tuple(values.tolist())

    values = {}
    if rng.random() < 0.4:
        values[LOAD] = course(problem.normal_force, zeros=False)
    kind = rng.random()
    if kind < 0.3:  # nothing rolls
        problem = replace(problem, motion=replace(motion, speed=0.0, creepage_x=0.0, creepage_y=0.0, spin=0.0, force_x=None))
        slide = derived.saturation_creepage * length * 1e6
        values[SHIFT] = course(slide * float(rng.uniform(0.1, 1.2)))
        if rng.random() < 0.5:
            values[SHIFT_ACROSS] = course(0.5 * slide)
        if rng.random() < 0.4:
            least = min(values.get(LOAD, (problem.normal_force,)))
            values = {name: column for name, column in values.items() if name != SHIFT}
            values[FORCE] = course(0.8 * problem.friction.coefficient * least)
            values.pop(SHIFT_ACROSS, None)
            problem = replace(problem, motion=replace(problem.motion, creepage_x=None, force_x=0.0))
        return History(problem, Course(tuple(places.tolist()), values, False, steps, "pressed"))
    sizes = {ALONG: motion.creepage_x, ACROSS: motion.creepage_y, SPIN: 1e-3 * motion.spin}
    values |= {name: course(abs(size)) for name, size in sizes.items() if size and rng.random() < 0.8}
    if kind < 0.4 and motion.force_x is None:  # it stops, and rolls on
        speeds = np.where(rng.random(count) < 0.5, 0.0, 1.0)
        speeds[0], speeds[-1] = 1.0, 1.0
        values[SPEED] = tuple(np.maximum(speeds, 0.05).tolist())
    if not values:
        values = {FORCE: course(0.5 * motion.force_x)} if motion.force_x is not None else {
            ALONG: course(derived.saturation_creepage)}
    return History(problem, Course(tuple(places.tolist()), values, True, steps, begin))


def check(history: History) -> Outcome:
    """Solve it; friction and heat have limits, and other places, units, a speed and the mirror change nothing."""
    result = _solved(history)
    if isinstance(result, Outcome):
        return result
    outcome = Outcome(result.converged, result.reason, work=int(result.work["applications"] / max(1, result.work["steps"])))
    return replace(outcome, broken=tuple(_faults(history, result))) if result.converged else outcome


def _solved(history: History) -> Result | Outcome:
    try:
        return HistorySolver().solve(history)
    except Unsolvable as reason:  # a given force above what friction carries under the least load
        return Outcome(reason=str(reason), excused="reaches or exceeds what friction can carry" in str(reason))


def _faults(history: History, result: Result) -> Iterator[str]:
    table = _table(result)
    end = PER_LENGTH if history.problem.line else ""
    limit = np.array(table[f"friction_limit_N{end}"])
    force = np.hypot(table[f"force_x_N{end}"], table[f"force_y_N{end}"]) / limit
    if force.max() > 1.0 + SAME:
        yield f"a force of {force.max():.6g} μW"
    # Where nothing slips heat is the rounding of work.
    heat, work = np.array(table[f"heat_J{end}"]), np.abs(table[f"work_J{end}"])
    if (np.diff(heat) < -SAME * max(heat.max(), work.max())).any():
        yield "heat that comes back"
    for name, other, signs in _same(history):
        found = _table(HistorySolver().solve(other))
        for column, sign in zip((f"force_x_N{end}", f"force_y_N{end}"), signs, strict=True):
            # One that begins later has the last rows.
            own, last = np.array(table[column])[-found.count:], limit[-found.count:]
            away = np.abs(sign * np.array(found[column]) - own) / last
            errors = np.array(table.get(UNCERTAINTY + column, np.zeros(table.count)))[-found.count:] / last
            if (away > SAME + 0.1 * errors).any():
                yield f"{name}: {column} differs by {away.max():.2g} μW"


def _same(history: History) -> Iterator[tuple[str, History, tuple[float, float]]]:
    """Histories that are the same but for factors of their forces."""
    course, problem, motion = history.course, history.problem, history.problem.motion
    away = course.places[-1] - course.places[0]
    yield "other places", replace(history, course=replace(course, places=tuple(p + away for p in course.places))), (1.0, 1.0)
    yield "exchange", _exchanged(history), (-1.0, -1.0)
    if not problem.geometry.elliptic:
        yield "elsewhere", replace(history, problem=replace(problem, geometry=_shifted(problem.geometry))), (1.0, 1.0)
    elif problem.geometry.symmetric:
        mirrored = replace(problem, motion=_with(motion, across=-1.0))
        yield "mirror", History(mirrored, _times(course, dict.fromkeys(ODD, -1.0))), (1.0, -1.0)
    factor = 8.0
    # Heat is more, too, and warms as before.
    stiffer = [replace(body, youngs_modulus=factor * body.youngs_modulus,
                       conductivity=body.conductivity and factor * body.conductivity,
                       layers=tuple(replace(layer, youngs_modulus=factor * layer.youngs_modulus) for layer in body.layers))
               for body in (problem.lower, problem.upper)]
    forces = {key: factor for key in course.values if key.endswith(("_N", "_N_mm"))}
    yield "units of force", History(replace(
        problem, lower=stiffer[0], upper=stiffer[1], normal_force=factor * problem.normal_force,
        motion=_with(motion, force=factor)), _times(course, forces)), (1.0 / factor, 1.0 / factor)
    if not problem.heating.heat and course.by_distance and SPEED not in course.values:
        yield "twice the speed", replace(history, problem=replace(problem, motion=replace(motion, speed=2.0))), (1.0, 1.0)
    # Another load has another grid, and a file does not tell the heat that it has seen.
    loaded = {LOAD, LOAD + PER_LENGTH} & {*course.values}
    if not problem.heating.heat and motion.speed == 0.0 and len(course.rows) > 2 and not loaded:
        yield from _later(history)


def _times(course: Course, factors: Mapping[str, float]) -> Course:
    """A course with values times factors by key."""
    return replace(course, values={key: tuple(factors.get(key, 1.0) * value for value in values)
                                   for key, values in course.values.items()})


def _with(motion: Motion, *, along: float = 1.0, across: float = 1.0, force: float = 1.0) -> Motion:
    """A motion with factors of what is along, of what is across and of the spin, and of all forces."""

    def times(factor: float, value: float | None) -> float | None:
        return None if value is None else factor * value

    return replace(motion, creepage_x=times(along, motion.creepage_x), creepage_y=times(across, motion.creepage_y),
                   spin=across * motion.spin, force_x=times(along * force, motion.force_x),
                   force_y=times(across * force, motion.force_y))


def _exchanged(history: History) -> History:
    """The same seen from the other side: all that one body does against the other changes its sign."""
    problem, geometry, heating = history.problem, history.problem.geometry, history.problem.heating
    assert isinstance(geometry, Geometry)
    swapped = Geometry(geometry.upper_radius_x, geometry.upper_radius_y, geometry.lower_radius_x, geometry.lower_radius_y,
                       geometry.upper_profile, geometry.lower_profile)
    share = heating.partition if heating.partition == "matched" else 1.0 - heating.partition
    heat = replace(heating, partition=share, bulk_lower=heating.bulk_upper, bulk_upper=heating.bulk_lower)
    flipped = dict.fromkeys((ALONG, ACROSS, SPIN, FORCE, FORCE + PER_LENGTH, "force.lateral_N", SHIFT, SHIFT_ACROSS), -1.0)
    return History(replace(problem, lower=problem.upper, upper=problem.lower, geometry=swapped, heating=heat,
                           motion=_with(problem.motion, along=-1.0, across=-1.0)), _times(history.course, flipped))


def _shifted(geometry: ContactGeometry) -> Geometry:
    """The same profiles at another place across rolling, where they still have material at y = 0."""
    assert isinstance(geometry, Geometry)
    shift = -0.4 * geometry.limits[0]
    return replace(geometry, **{f"{body}_profile": replace(profile, offset=profile.offset + shift)  # type: ignore[arg-type]
                                for body, profile in geometry.profiles})


def _later(history: History) -> Iterator[tuple[str, History, tuple[float, float]]]:
    """The second half of the rows alone, which begins with the state at the end of the first half."""
    course = history.course
    middle = len(course.rows) // 2
    place, places = float(course.rows[middle]), np.array(course.places)
    if place in course.jumps or len(set(course.places)) < len(course.places):
        return
    if np.any((places > place) & (places < course.rows[middle + 1])):
        return  # inputs turn within the first step: it is halved there, and has no step before it to be of second order
    values = {key: float(course.at(key, np.array([place]))[0]) for key in course.values}
    halves = []
    for inside, steps in ((places < place, middle), (places > place, len(course.rows) - 1 - middle)):
        kept = {key: [value for value, here in zip(given, inside, strict=True) if here] for key, given in course.values.items()}
        first = bool(inside[0])
        halves.append(replace(
            course, places=(*places[inside], place) if first else (place, *places[inside]),
            values={key: (*given, values[key]) if first else (values[key], *given) for key, given in kept.items()},
            steps=steps if course.steps else None))
    begin = HistorySolver().solve(replace(history, course=halves[0]))
    yield "in two cases", replace(history, course=replace(halves[1], begin=begin)), (1.0, 1.0)


def covered(history: History, *_: int) -> Outcome:
    """Solve it, with the estimated and true errors of the scalars of some rows."""
    result = _solved(history)
    if isinstance(result, Outcome):
        return result
    course, grid = history.course, history.problem.numerics.grid
    assert course.steps is not None and grid is not None
    sides = REFERENCE * grid[0], REFERENCE * grid[1] if grid[1] > 1 else 1
    finer = replace(history.problem, numerics=replace(
        history.problem.numerics, grid=sides, extent=float(result.work["extent"])))
    fine = HistorySolver().solve(replace(history, problem=finer, course=replace(course, steps=REFERENCE * course.steps)))
    outcome = Outcome(result.converged, result.reason, work=int(result.work["applications"] / result.work["steps"]))
    if not (result.converged and fine.converged):
        return outcome
    elements = grid[0] if grid[1] == 1 else round(math.sqrt(grid[0] * grid[1]))
    return replace(outcome, pairs=tuple(pairs(_table(result), _table(fine), elements)))


def pairs(table: Columns, fine: Columns, grid: int) -> Iterator[Pair]:
    """Estimated and true errors of the scalars of some rows, by those of `REFERENCE` times the elements and steps. Rows before
    which nothing rolls have means over their steps, which are other ones: heat tells those of power."""
    rows = np.unique(np.linspace(0, table.count - 1, SHOWN).round().astype(int)).tolist()
    largest = {name: float(np.abs(np.nan_to_num(column)).max()) for name, column in table.numbers.items()}
    for column in table:
        name = column.removeprefix(UNCERTAINTY)
        scale = error_scale(name, largest) if name != column else 0.0
        for row in rows if scale > 0.0 and name in fine else ():
            known = fine[name][REFERENCE * row]
            if row and table["distance_mm"][row] == table["distance_mm"][row - 1]:
                if name.startswith(("heat_flux", "heat_into")):
                    continue
                if name.startswith("Q_F_W"):
                    heat, times = (np.diff(np.array(fine[each])[[REFERENCE * (row - 1), REFERENCE * row]])[0]
                                   for each in (name.replace("Q_F_W", "heat_J"), "time_s"))
                    known = heat / times
            error, true = table[column][row], abs(table[name][row] - known)
            if math.isfinite(error) and math.isfinite(true):
                yield Pair(grid, name, error / scale, true / scale)


def _table(result: Result) -> Columns:
    assert result.history is not None
    return result.history



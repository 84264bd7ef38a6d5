"""What is asked of a history: which inputs change, when, and how it begins."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.one_contact.steady_state.derived import pressed_to
from thermoroll_cli.problem.kinds import Task
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.surface import Heights
from thermoroll_cli.tools.arrays import Array

Beginning = Literal["steady", "pressed"]
Begin = Beginning | Result
SPEED = "rolling.speed_m_s"
SHIFTS = "shift.longitudinal_um", "shift.lateral_um"
AT_ONCE = 1e-4
"""Length of a step after a jump where nothing rolls, over the distance to the next place of the course."""


def _of(part: str, name: str) -> Callable[[Problem, float], Problem]:
    def changed(problem: Problem, value: float) -> Problem:
        inner: Any = getattr(problem, part)
        return replace(problem, **{part: replace(inner, **{name: value})})

    return changed


VARIED: dict[str, tuple[float, Callable[[Problem, float], Problem]]] = {
    "load.normal_N": (1.0, lambda problem, value: replace(problem, normal_force=value)),
    "load.normal_N_mm": (1e3, lambda problem, value: replace(problem, normal_force=value)),
    "load.approach_um": (1e-6, pressed_to),
    "load.friction_coefficient": (1.0, _of("friction", "coefficient")),
    SPEED: (1.0, _of("motion", "speed")),
    "creepage.longitudinal": (1.0, _of("motion", "creepage_x")),
    "creepage.lateral": (1.0, _of("motion", "creepage_y")),
    "creepage.spin_rad_mm": (1e3, _of("motion", "spin")),
    "force.longitudinal_N": (1.0, _of("motion", "force_x")),
    "force.lateral_N": (1.0, _of("motion", "force_y")),
    "force.longitudinal_N_mm": (1e3, _of("motion", "force_x")),
    "force.lateral_N_mm": (1e3, _of("motion", "force_y")),
    "thermal.bulk_temperature_lower_K": (1.0, _of("heating", "bulk_lower")),
    "thermal.bulk_temperature_upper_K": (1.0, _of("heating", "bulk_upper")),
    **dict.fromkeys(SHIFTS, (1e-6, lambda problem, value: problem)),
}
"""Keys that may change, each with the SI value of its unit and what it changes. Shifts change no problem: the step that they
happen in does (`steps`)."""


def extreme_rows(columns: Mapping[str, Sequence[float] | Array]) -> list[int]:
    """The rows (from 0) in which one of the `columns` is least or largest, the first of several, in order."""
    return sorted({int(most(column)) for column in columns.values() if len(column) for most in (np.argmin, np.argmax)})


@dataclass(frozen=True)
class Course:
    """Inputs over time: `values` by key of `VARIED`, in the units of the keys, at the `places`, linear between them; the same
    place twice is a jump. Places are times in s, or with `by_distance` distances rolled in m. `steps` equal steps are reported,
    or without it a row for each place; every `fields_every`-th row keeps its fields (0: none)."""

    places: tuple[float, ...]
    values: Mapping[str, tuple[float, ...]]
    by_distance: bool = False
    steps: int | None = None
    begin: Begin = "steady"
    fields_every: int = 0

    @cached_property
    def rows(self) -> Array:
        """The places that are reported."""
        if self.steps is None:
            return np.unique(self.places)
        return np.linspace(self.places[0], self.places[-1], self.steps + 1)

    @property
    def places_of_fields(self) -> Array:
        """The rows that keep their fields."""
        return self.rows[:: self.fields_every] if self.fields_every else self.rows[:0]

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Places at which inputs jump."""
        return tuple(one for one, other in zip(self.places, self.places[1:], strict=False) if one == other)

    @cached_property
    def turns(self) -> tuple[float, ...]:
        """Places at which an input turns back."""
        changes = [np.diff(values) for values in self.values.values()]
        back = [i + 1 for i in range(len(self.places) - 2) if any(change[i] * change[i + 1] < 0.0 for change in changes)]
        return tuple(self.places[i] for i in back)

    def at(self, key: str, places: Array, *, after: bool = False) -> Array:
        """Values of `key` in its unit at `places`; at a jump those before it, or `after` it."""
        known, given = self._arrays[0], self._arrays[1][key]
        if after:
            known, given, places = -known[::-1], given[::-1], -places
        # Linear interpolation that takes the first of several values at one place.
        right = np.clip(np.searchsorted(known, places, side="left"), 1, len(known) - 1)
        width = known[right] - known[right - 1]
        share = np.where(width > 0.0, (places - known[right - 1]) / np.where(width > 0.0, width, 1.0), 0.0)
        return np.asarray(given[right - 1] + np.clip(share, 0.0, 1.0) * (given[right] - given[right - 1]))

    def slope(self, key: str, place: float) -> float:
        """The change of `key` in its unit per s or m before a place; at the first place that after it."""
        known, given = self._arrays[0], self._arrays[1][key]
        right = max(int(np.searchsorted(known, place, side="left")), int(np.argmax(known > known[0])))
        return float((given[right] - given[right - 1]) / (known[right] - known[right - 1]))

    @cached_property
    def _arrays(self) -> tuple[Array, dict[str, Array]]:
        """`places` and `values`: records have tens of thousands."""
        return np.array(self.places), {key: np.array(given) for key, given in self.values.items()}


@dataclass(frozen=True)
class When:
    """Where a state lies in a history: its `place` in the course, `time` in s, `distance` rolled in m."""

    place: float
    time: float
    distance: float


@dataclass(frozen=True)
class OverTime(Task):
    """Anything that rolls over time: its `problem` with the values that do not change, and the `course` of those that do."""

    problem: Any
    course: Course

    @property
    def contact(self) -> Problem:
        """The problem of a contact that all steps share."""
        found: Problem = self.problem.contact
        return found

    @property
    def _still(self) -> bool:
        """Whether nothing ever rolls."""
        return SPEED not in self.course.values and bool(self.problem.motion.speed == 0.0)

    @property
    def stops(self) -> tuple[float, ...]:
        """Places that no step may pass over: jumps, and where nothing rolls, since the path alone counts there, turns, and
        those just behind a jump or a start from nothing: a longer step would not reach what the inputs jump to."""
        if not self._still:
            return self.course.jumps
        behind = (one + AT_ONCE * (other - one) for one, other in itertools.pairwise(self.course.places)
                  if one < other and one in (*self._start, *self.course.jumps))
        return (*self.course.jumps, *self.course.turns, *behind)

    @property
    def _start(self) -> tuple[float, ...]:
        """The first place, where it is a start from nothing."""
        return self.course.places[:1] if self.course.begin == "pressed" else ()

    def with_stops(self, places: Array) -> Array:
        """`places` in order, and the `stops` between the first and the last of them."""
        return np.union1d(places, [stop for stop in self.stops if places[0] < stop < places[-1]])

    @property
    def restarts(self) -> tuple[float, ...]:
        """Places from which a step knows one state alone, and is of first order: a start from nothing, jumps, and where nothing
        rolls turns. A state from a file goes on as one of the same history does."""
        return (*self._start, *self.course.jumps, *(self.course.turns if self._still else ()))

    def clock(self, places: Array) -> tuple[Array, Array]:
        """Time in s and distance rolled in m at `places`. The one that is not given begins at 0 and is the integral of the
        speed, which varies linearly between the places of the course, or of one over it."""
        knots = np.unique(np.concatenate([places, self.course.places]))
        if SPEED in self.course.values:
            one, other = self.course.at(SPEED, knots, after=True)[:-1], self.course.at(SPEED, knots)[1:]
        else:
            one = other = np.full(len(knots) - 1, self.problem.motion.speed)
        rates = 0.5 * (one + other)
        if self.course.by_distance:
            change = other - one
            varies = np.abs(change) > 1e-6 * rates
            rates = np.where(varies, np.log(other / one) / np.where(varies, change, 1.0), 1.0 / rates)
        total = np.concatenate([[0.0], np.cumsum(np.diff(knots) * rates)])
        found = total[np.searchsorted(knots, places)]
        return (found, places) if self.course.by_distance else (places, found)


@dataclass(frozen=True)
class History(OverTime):
    """A contact over time, and the `surfaces` of the lower and of the upper body that roll through it (None: smooth)."""

    kind: ClassVar[str] = "contact over time"

    problem: Problem
    surfaces: tuple[Heights | None, Heights | None] = (None, None)

    @property
    def contact(self) -> Problem:
        return self.problem

    def begins_at(self, distance: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """How far the material of the lower and of the upper body has moved (m) at the beginning, after a `distance` (m): as
        far as in the result that it goes on from, if that had surfaces."""
        if not any(self.surfaces):
            return (0.0, 0.0), (0.0, 0.0)
        known = self.course.begin.numbers if isinstance(self.course.begin, Result) else {}
        lower, upper = (tuple(1e-3 * known.get(f"surface_{body}_{axis}_mm", 1e3 * start)
                              for axis, start in (("x", distance), ("y", 0.0))) for body in BODIES)
        return (lower[0], lower[1]), (upper[0], upper[1])

    def problem_at(self, place: float, *, after: bool = False) -> Problem:
        """The problem at one place of the course; at a jump the one before it, or `after` it."""
        problem = self.problem
        for key in self.course.values:
            factor, changed = VARIED[key]
            problem = changed(problem, factor * float(self.course.at(key, np.array([place]), after=after)[0]))
        return problem

    def shift_at(self, place: float) -> tuple[float, float]:
        """Total shift along x and y in m."""
        along, across = (VARIED[key][0] * float(self.course.at(key, np.array([place]))[0]) if key in self.course.values else 0.0
                         for key in SHIFTS)
        return along, across

    @cached_property
    def extremes(self) -> list[tuple[float, Problem]]:
        """The places of the course, each with its problem, at which one of the values, or the force over what friction carries,
        is least or largest, and the first: no problem of another place has more of anything."""
        found, course = [], self.course
        for after, places in ((False, np.unique(course.places)), (True, np.array(course.jumps))):
            columns = {key: course.at(key, places, after=after) for key in course.values}
            force, load, friction = ([columns[key] for key in columns if key.startswith(start)] or [np.ones(len(places))]
                                     for start in ("force.", "load.normal_", "load.friction_"))
            columns["force over friction"] = force[0] / np.maximum(load[0] * friction[0], 1e-300)
            found += [(place, self.problem_at(place, after=after))
                      for place in places[sorted({*range(len(places[:1])), *extreme_rows(columns)})].tolist()]
        return found

    @cached_property
    def largest(self) -> Problem:
        """The problem of the largest load or approach: its contact holds those of all others."""
        problems = [problem for _, problem in self.extremes]
        return max(problems, key=lambda problem: (problem.approach or 0.0, problem.normal_force))

    @cached_property
    def most(self) -> Problem:
        """A problem that moves wherever the history does, for its symmetry."""
        motions = [problem.motion for _, problem in self.extremes]

        def largest(name: str) -> Any:
            values = [getattr(motion, name) for motion in motions]
            return max(values, key=lambda value: math.inf if value is None else abs(value))

        along, across = (any(self.course.values.get(key, ())) for key in SHIFTS)
        motion = replace(motions[0], creepage_x=None if along else largest("creepage_x"), spin=largest("spin"),
                         creepage_y=None if across else largest("creepage_y"))
        return replace(self.largest, motion=motion)


PATH = {"wheelset.lateral_shift_mm": ("y", "lateral"), "wheelset.height_mm": ("z", "vertical"),
        "wheelset.roll_mrad": ("roll", "roll_rate"), "wheelset.yaw_mrad": ("yaw", "yaw_rate")}
"""Keys of the path, in thousandths of SI units: what they are of the position, and which velocity follows from them."""


def _moving(name: str, factor: float = 1.0, **also: Any) -> Callable[[WheelsetProblem, float], WheelsetProblem]:
    def moved(problem: WheelsetProblem, value: float) -> WheelsetProblem:
        change: dict[str, Any] = {name: factor * value, **also}
        return replace(problem, motion=replace(problem.motion, **change))

    return moved


def _rolling(problem: WheelsetProblem, speed: float) -> WheelsetProblem:
    contact = replace(problem.contact, motion=replace(problem.contact.motion, speed=speed))
    return replace(problem, contact=contact, motion=replace(problem.motion, speed=speed))


def _rubbing(problem: WheelsetProblem, coefficient: float) -> WheelsetProblem:
    friction = replace(problem.contact.friction, coefficient=coefficient)
    return replace(problem, contact=replace(problem.contact, friction=friction))


OF_WHEELSETS: dict[str, Callable[[WheelsetProblem, float], WheelsetProblem]] = {
    **{key: lambda problem, value, name=name: replace(  # type: ignore[misc]
        problem, position=replace(problem.position, **{name: 1e-3 * value})) for key, (name, _) in PATH.items()},
    "wheelset.vertical_N": lambda problem, value: replace(problem, vertical=value),
    "wheelset.traction_N": lambda problem, value: replace(problem, traction=value),
    "wheelset.angular_velocity_rad_s": _moving("angular_velocity", -1.0),
    "wheelset.lateral_velocity_mm_s": _moving("lateral", 1e-3),
    "wheelset.vertical_velocity_mm_s": _moving("vertical", 1e-3, follows=False),
    "wheelset.roll_rate_mrad_s": _moving("roll_rate", 1e-3), "wheelset.yaw_rate_mrad_s": _moving("yaw_rate", 1e-3),
    SPEED: _rolling,
    "load.friction_coefficient": _rubbing,
}
"""Keys of a wheelset that may change over time, with what they change."""


@dataclass(frozen=True)
class WheelsetHistory(OverTime):
    """A wheelset over time."""

    kind: ClassVar[str] = "wheelset over time"

    problem: WheelsetProblem

    @property
    def start(self) -> WheelsetProblem:
        """The problem at the beginning."""
        return self.problem_at(self.course.places[0])

    def problem_at(self, place: float) -> WheelsetProblem:
        """The problem at one place of the course."""
        problem, course = self.problem, self.course
        for key in course.values:
            problem = OF_WHEELSETS[key](problem, float(course.at(key, np.array([place]))[0]))
        speed = problem.motion.speed if course.by_distance else 1.0
        rates: dict[str, Any] = {rate: 1e-3 * speed * course.slope(key, place) for key, (_, rate) in PATH.items()
                                 if key in course.values}
        problem = replace(problem, motion=replace(problem.motion, **rates))
        return problem.rolled(*self._way(place)) if problem.varies else problem

    def _way(self, place: float) -> tuple[float, float]:
        """The distance rolled at one place (m), and the angle (rad) by which the wheels have turned: by their angular velocity
        if that is given, else as wheels of the nominal radius roll. Both go on from the result that the history begins with."""
        places = np.unique([each for each in self.course.places if each < place] + [place])
        times, distances = self.clock(places)
        radius = next(iter(self.problem.wheels.values())).radius
        given, key = self.problem.motion.angular_velocity, "wheelset.angular_velocity_rad_s"
        velocities = self.course.at(key, places) if key in self.course.values else np.full(len(places), -(given or math.nan))
        turned = 0.5 * float(np.sum((velocities[1:] + velocities[:-1]) * np.diff(times)))
        rolled = float(distances[-1] - distances[0])
        if math.isnan(turned):
            turned = rolled / radius
        start, angle = float(distances[0]), float(distances[0]) / radius
        if isinstance(self.course.begin, Result) and "position_mm" in self.course.begin.numbers:
            start = 1e-3 * self.course.begin["position_mm"] - self.problem.along
            angle = math.radians(self.course.begin["rotation_deg"]) - self.problem.turned
        return start + rolled, angle + turned

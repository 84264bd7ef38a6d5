"""Decided before a history is solved: its grids and steps, what is against it, and what it takes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.many_contacts.history.course import SPEED, History, OverTime
from thermoroll_cli.one_contact.refinement.plan import extent_of
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import heated_bodies
from thermoroll_cli.one_contact.steady_state.solvable import reasons_against
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import InWords
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.surface import Texture, length_words
from thermoroll_cli.tools.arrays import Array

COARSEST = 8
"""Elements per side of a coarser grid that gives error estimates."""
FIRST = 32
"""Elements per side of a grid that is not given, and of the least one for an accuracy, which begins with half of them."""
FINER, MOST_STEPS = 16, 64
"""How many times as many elements per side and as many steps are tried for an accuracy as it begins with."""
SHORTEST = 10.0
"""Least length of a line contact, in half-widths: its displacements are those in its middle."""
PER_ELEMENT, PER_STEP = 0.25, 0.5
"""Largest elements and steps over the shortest wavelength of a surface that counts."""
STEEP = 0.1
"""Slope (rad, rms) from which surfaces are steep."""
MUCH_FILLED = 0.05
"""Share of the points of a surface without a height above which it was not measured well."""
FEW = 6
"""Steps below which errors are doubtful."""
OF_BEGINNING, OF_STEP = 50, 14
"""Applications of the steady state at the beginning and of a step, as measured on 16 to 64 elements."""
MOST_SECONDS = 40.0
"""Estimated seconds on one core up to which elements and steps are doubled for an accuracy."""
APPLICATION_SECONDS = 8e-4, 4.5e-7
"""Seconds of an application of the tangential operator with its share of a step, and more of them for each element."""
TABLE_SECONDS, EXPANSION_SECONDS = (4e-4, 2e-7), (1e-4, 3e-7)
"""The same for a table of temperatures and of thermal expansion over time."""
FELT = 8.0
"""Half-lengths of the contact over which heat is carried on a grid until it has left it."""
FIELDS = 60
"""Padded fields of the solvers on a grid."""
CHANGE_SPEEDS = {SPEED, "creepage.longitudinal", "creepage.lateral"}
"""Keys that change how far the material drifts in a step."""
NEW_TABLES = 6
"""Ages of heat whose tables are new in a step of equal ones; that of all heat before the history takes as long as five."""

Runs = tuple[tuple[int, int], list[Array]]
"""A grid, and the places of the steps of each run on it."""


def grids_of(history: OverTime) -> list[Runs]:
    """The coarser grid, if there is one, and the one that is asked for, with the places of the steps of each run: half the
    elements and steps (every second row, and all others in another run), and all of them."""
    rows, sides = history.course.rows, shape_of(history, 1)
    if min(side for side in sides if side > 1) < 2 * COARSEST:
        return [(sides, [steps_of(history, 1)])]
    every_second = [np.union1d(rows[::2], rows[-1]), np.union1d(rows[:1], rows[1::2])][: len(rows) - 1]
    along, across = ((side + 1) // 2 for side in sides)
    return [((along, across), every_second), (sides, [steps_of(history, 1)])]


def most_grids(history: History) -> list[Runs]:
    """What an accuracy takes at most: elements are doubled as often as they are at all, and then steps."""
    shapes, times = ([2**power for power in range(int(math.log2(most)) + 1)] for most in (FINER, MOST_STEPS))
    runs = [(finer, times[:2] if finer == 1 else times[1:] if finer == FINER else times[1:2]) for finer in shapes]
    return [(shape_of(history, finer), [steps_of(history, each) for each in some]) for finer, some in runs]


def shape_of(history: OverTime, finer: int) -> tuple[int, int]:
    """Elements along and across, of which a line contact has one, `finer` times as many as those of the case, or on the first
    grid for an accuracy."""
    along, across = history.contact.numerics.grid or (FIRST // 2, FIRST // 2)
    return finer * along, 1 if history.contact.line else finer * across


def steps_of(history: OverTime, times: int) -> Array:
    """Places with `times` as many equal steps between each of the rows and the next. Steps after a restart, of first order, are
    halved, and compared with whole ones."""
    rows, restarts = history.course.rows, np.array(history.restarts)
    places = np.interp(np.arange((len(rows) - 1) * times + 1) / times, np.arange(len(rows)), rows)
    restarts = restarts[restarts < rows[-1]]
    after = places[np.searchsorted(places, restarts, side="right")]
    return np.union1d(places, 0.5 * (restarts + after))


def check(history: History) -> None:
    """Raises Unsolvable for the first reason against the problem at a place of the course with most of anything."""
    half, length = DerivedQuantities(history.largest).scales.semi_axis_x, history.problem.length
    if length < SHORTEST * half:
        raise Unsolvable(f"a length of {1e3 * length:g} mm is short beside a contact that is {2e3 * half:.3g} mm wide",
                         "history.length_mm", f"{1e3 * SHORTEST * half:.3g} mm or more, or a profile and load.normal_N")
    for place, problem in history.extremes:
        for reason in reasons_against(DerivedQuantities(problem)):
            key = "history.values" if reason.key in history.course.values else reason.key
            where = f"at {1e3 * place:g} mm" if history.course.by_distance else f"at {place:g} s"
            raise Unsolvable(f"{where}: {reason}", key, reason.allowed)


def warnings_of(history: OverTime) -> list[str]:
    """Warnings that need no solution."""
    count = len(history.course.rows) - 1
    doubtful = count < FEW and history.problem.motion.speed > 0.0 and history.contact.numerics.accuracy is None
    few = [f"few steps ({count}): errors may be larger than estimated; set history.steps"] if doubtful else []
    return [*few, *extent_of(history.contact.numerics)[1], *(_rough(history) if isinstance(history, History) else ())]


def _rough(history: History) -> Iterator[str]:
    """Warnings of the surfaces of a contact."""
    numerics = history.contact.numerics
    grid = DerivedQuantities(history.largest).grid(numerics.grid or (FIRST, FIRST), extent_of(numerics)[0])
    sides = {grid.nx: grid.dx} if history.problem.line else {grid.nx: grid.dx, grid.ny: grid.dy}
    for body, surface in zip(BODIES, history.surfaces, strict=True):
        if surface is not None:
            yield from surface_warnings(history, f"the {body} surface", surface.texture, sides)


def surface_warnings(history: OverTime, name: str, texture: Texture, sides: Mapping[int, float]) -> Iterator[str]:
    """Warnings of a surface whose waves, or slopes, the elements and steps of a history do not resolve; `sides` has the lengths
    of elements (m) by their numbers along the sides of the grid."""
    yield from wave_warnings(history, name, texture.shortest, sides)
    if texture.slope > STEEP:
        yield (f"slopes of {name} are {texture.slope:.2g} rad (rms): tractions act in the plane of the "
               "contact, and the slip of slopes over each other is left out")
    if texture.filled > MUCH_FILLED:
        yield (f"{100.0 * texture.filled:.3g} % of the points of {name} had no height and were filled in: there it is "
               "smoother than it was, and the largest pressure may be too low")


def wave_warnings(history: OverTime, name: str, shortest: float, sides: Mapping[int, float]) -> Iterator[str]:
    """Those of waves alone, the `shortest` of which has this length (m)."""
    rows = history.course.rows
    rolled = float(np.diff(history.clock(history.with_stops(rows))[1]).max(initial=0.0))
    size = max(sides.values(), default=0.0)
    if history.contact.numerics.accuracy is None and size > PER_ELEMENT * shortest:
        enough = math.ceil(max(count * side for count, side in sides.items()) / (PER_ELEMENT * shortest))
        yield (f"elements of {length_words(size)} are large beside waves of {length_words(shortest)} of {name}, "
               f"whose means they see: numerics.grid = {enough} resolves them")
    if rolled > PER_STEP * shortest:
        enough = math.ceil((len(rows) - 1) * rolled / (PER_STEP * shortest))
        yield (f"steps of {length_words(rolled)} are long beside waves of {length_words(shortest)} of {name}: "
               f"history.steps = {enough} follows them")


@dataclass(frozen=True)
class HistoryPlan:
    """The number of steps on each of the `grids`, from coarse to fine, and what they take: `applications` of the tangential
    operator on all grids, `memory_bytes`, of which `past_bytes` remember the heat of all steps, and `seconds`, each roughly: at
    most, where an accuracy is asked for, which takes `least` seconds at least (None: no accuracy is)."""

    grids: Sequence[tuple[tuple[int, int], Sequence[int]]]
    applications: int
    memory_bytes: int
    past_bytes: int
    seconds: float
    least: float | None = None

    @property
    def sides(self) -> list[tuple[tuple[int, ...], Sequence[int]]]:
        """`grids`; those of a line contact have elements along rolling alone."""
        return [(tuple(side for side in shape if side > 1), counts) for shape, counts in self.grids]

    @property
    def steps(self) -> list[tuple[str, tuple[int, ...]]]:
        """What is reported of each state, in this order."""
        return [("tangential", shape) for shape, runs in self.grids for count in runs for _ in range(count + 1)]

    @property
    def in_words(self) -> InWords:
        """One picture is that of the course."""
        sizes = [(f"grid {'×'.join(map(str, shape))}: "
                  f"{f'{counts[0]} to {counts[-1]}' if len(counts) > 2 else ' and '.join(map(str, counts))} steps")
                 for shape, counts in self.sides]
        past = f"; {self.past_bytes / 2**20:.2g} MiB remember the heat of all steps" if self.past_bytes else ""
        more = [] if self.least is None else [
            f"elements or steps are doubled as they err: {self.least:.2g} s if {FIRST} elements a side are enough"]
        return InWords((), sizes, [*more, f"about {self.applications} applications of the tangential operator{past}"], {
            "grids": [{"grid": shape, "steps": counts} for shape, counts in self.sides],
            "applications": self.applications, "heat_memory_bytes": self.past_bytes}, 3 if self.past_bytes else 1)


def plan_of(history: History) -> HistoryPlan:
    """The plan of a history. Raises Unsolvable as `check`."""
    check(history)
    accurate = history.problem.numerics.accuracy is not None
    planned = most_grids(history) if accurate else grids_of(history)
    grids = [(shape, [len(history.with_stops(places)) - 1 for places in runs]) for shape, runs in planned]
    (nx, ny), counts = grids[-1]
    # Transforms of the heat of all steps, and of the tables of their ages, half of which differ from those of the last step.
    tables, _ = _effects(history)
    exchanged = history.problem.heating.partition == "matched"
    past = (2 + exchanged + tables + tables // 2) * max(counts) * 32 * nx * (ny + 1) if tables else 0
    applications, seconds = zip(*(_cost(history, shape, count) for shape, counts in grids for count in counts), strict=True)
    most = min(sum(seconds), MOST_SECONDS) if accurate else sum(seconds)
    return HistoryPlan(grids, sum(applications), 8 * 4 * nx * ny * FIELDS + past, past, most,
                       min(sum(seconds[:3]), most) if accurate else None)


def _effects(history: History) -> tuple[int, bool]:
    """The number of tables of each age of heat, of both bodies, and whether those of thermal expansion are among them."""
    problem = history.problem
    if not problem.heating.heat:
        return 0, False
    hot = bool(problem.heating.deformation) and any(body.free_expansion for body in heated_bodies(problem, 0.0, 0.0))
    return 6 if hot else 4, hot


def _cost(history: History, shape: tuple[int, int], steps: int) -> tuple[int, float]:
    """Applications and seconds of one run."""
    applications = OF_BEGINNING + OF_STEP * steps * (2 if _effects(history)[1] else 1)
    return applications, seconds_of(history, shape, steps, applications)


def seconds_of(history: History, shape: tuple[int, int], steps: int, applications: int) -> float:
    """Estimated seconds of a run with so many `applications` in all of its `steps`."""
    elements, (tables, hot) = shape[0] * shape[1], _effects(history)

    def each(seconds: tuple[float, float]) -> float:
        return seconds[0] + seconds[1] * elements

    seconds = applications * each(APPLICATION_SECONDS)
    if tables:
        # Heat of each age has drifted to other places with each step where speeds change.
        ages = 0.5 * steps if CHANGE_SPEEDS.intersection(history.course.values) else NEW_TABLES
        seconds += 2 * steps * ages * (2 * each(TABLE_SECONDS) + hot * each(EXPANSION_SECONDS))
        # Temperatures are felt until the heat has left the grid.
        rolled = float(np.ptp(history.clock(history.course.rows)[1]))
        felt = steps if hot or not rolled else min(steps, FELT * DerivedQuantities(history.largest).scales.semi_axis_x
                                                   / rolled * steps)
        seconds += 0.5 * steps * felt * tables * 4 * elements * 5e-9
    return seconds

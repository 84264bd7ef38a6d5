"""Evolution of both profiles: explicit steps of a bounded worn depth, each solution started from the one before.

Explicit steps are stable while n κ ξ < dy/(E* a): the pressure follows the profile within an element, and a step that wears
more than the pressure's own compliance over an element makes rows wear in turn. In terms of the worn depth d of a step that is
d < (π/2)(p₀/E*) dy; a share of it is taken, and no more than a tenth of the approach. The depth is remapped to the points of
the profiles by its running integral, which conserves the worn area, and never smoothed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import BODIES, BodyName, Geometry, Problem
from thermoroll_cli.problem.profile import Profile
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.surface import surfaces
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.wear.passage import sliding_work

STABLE_SHARE = 0.7
"""Share of the largest stable worn depth that a step takes."""
POINTS_PER_ELEMENT = 1.0
"""Points of the profile over an element of the first solution."""
ROOM = 1.3
"""Half-length of the profile that replaces a lateral radius, over the half-width expected in the end."""
REACHED = 1e-6
"""Part of the wanted depth that may be missing in the end: the largest depth is known after a step, not before."""
LEAST_POINTS = 200
"""Points of the profile that replaces a lateral radius."""


@dataclass(frozen=True)
class WornBody:
    """One body's wear: specific wear `rate` κ (1/Pa), `track_length` (m) that rolls by between two passages of a point."""

    rate: float = 0.0
    track_length: float = math.inf

    @property
    def wear_per_distance(self) -> float:
        """κ over the track length: worn depth per distance rolled and per ∫ p|s|/V dx."""
        return self.rate / self.track_length


@dataclass(frozen=True)
class WearCourse:
    """What is to happen: both bodies, until `distance` (m) is rolled or one body is worn by `depth` (m); a step wears at most
    `step_fraction` of the approach."""

    lower: WornBody
    upper: WornBody
    distance: float = math.inf
    depth: float = math.inf
    step_fraction: float = 0.1


@dataclass(frozen=True)
class WearState:
    """A moment of the evolution: `distance` rolled (m), `y` (m) and the `worn` depth of each body there (m), and the `result`
    of the contact with these profiles with its `line_load` over the result's y (N/m); None before it is solved."""

    distance: float
    y: Array
    worn: dict[BodyName, Array]
    result: Result | None = None
    line_load: Array | None = None

    def worn_area(self, body: BodyName) -> float:
        """Worn cross-section in m², from the spline that the contact sees."""
        return float(CubicSpline(self.y, self.worn[body]).integrate(self.y[0], self.y[-1]))


class BeyondProfile(ArithmeticError):
    """The contact has reached the end of a profile."""


def expected_half_width(problem: Problem, course: WearCourse, work: float, half_width: float) -> float:
    """Half-width (m) of the contact in the end, by the law of rigid wear: the worn area 2w³/(3R), with the lateral radius R of
    both bodies, is what `work` (∬ p|s|/V dx dy, N) wears off; on top of the present `half_width`."""
    curvature = problem.geometry.curvature_y
    if not curvature > 0.0:
        return half_width
    area = (course.lower.wear_per_distance + course.upper.wear_per_distance) * work * course.distance
    worn = math.sqrt(2.0 * course.depth / curvature) if math.isinf(area) else (1.5 * area / curvature) ** (1.0 / 3.0)
    return half_width + worn


def wearing_points(problem: Problem, course: WearCourse, first: Result) -> Array:
    """The y (m) at which the profiles are worn: across both profiles, or as far as the contact is expected to grow."""
    dy = float(first.y[1] - first.y[0]) / POINTS_PER_ELEMENT
    half_width = 0.5 * float(np.ptp(first.y[first.coupled.fields["pressure"].any(axis=0)])) + dy
    reach = ROOM * expected_half_width(problem, course, float(sliding_work(problem, first.coupled).sum() * dy), half_width)
    lower, upper = surfaces(problem.geometry)
    low, high = max(-reach, lower.ends[0], upper.ends[0]), min(reach, lower.ends[1], upper.ends[1])
    return np.linspace(low, high, max(LEAST_POINTS, math.ceil((high - low) / dy)) + 1)


def worn_geometry(geometry: Geometry, y: Array, worn: dict[BodyName, Array]) -> Geometry:
    """`geometry` with the profiles of worn bodies at the points `y` less what is worn off."""
    changes: dict[str, object] = {}
    for body, surface in zip(BODIES, surfaces(geometry), strict=True):
        if worn[body].any():
            heights = surface.height(y) - worn[body]
            changes |= {f"{body}_profile": Profile(tuple(zip(y.tolist(), heights.tolist(), strict=True))),
                        f"{body}_radius_y": math.inf}
    return replace(geometry, **changes)  # type: ignore[arg-type]


def remapped(y: Array, centres: Array, depth: Array) -> Array:
    """`depth` (m), constant on elements about `centres`, at the points `y`: the area between neighbouring points is kept."""
    dy = float(centres[1] - centres[0])
    edges = np.append(centres - 0.5 * dy, centres[-1] + 0.5 * dy)
    running = PchipInterpolator(edges, np.append(0.0, np.cumsum(depth) * dy))
    middles = np.concatenate([y[:1], 0.5 * (y[1:] + y[:-1]), y[-1:]])
    return np.asarray(np.diff(running(np.clip(middles, edges[0], edges[-1]))) / np.diff(middles))


def evolution(
    problem: Problem, course: WearCourse, start: WearState | None = None, *, solver: Solver | None = None,
    report: Callable[[str, dict[str, object]], None] | None = None,
) -> Iterator[WearState]:
    """The states of the evolution, from the unworn profiles (or from `start`) to the end of the `course`.

    Each state is yielded with its result. Raises BeyondProfile where the contact reaches the end of a profile."""
    solver = solver or Solver()
    state = start
    if state is None:
        first = solver.solve(problem)
        y = wearing_points(problem, course, first)
        state = WearState(0.0, y, {body: np.zeros_like(y) for body in BODIES})
    rates = {body: getattr(course, body).wear_per_distance for body in BODIES}
    while True:
        worn = replace(problem, geometry=worn_geometry(problem.geometry, state.y, state.worn))
        result = solver.solve(worn)
        fields, x = result.coupled.fields, result.coupled.x
        state = replace(state, result=result, line_load=fields["pressure"].sum(axis=0) * float(x[1] - x[0]))
        yield state
        deepest = max(float(depth.max()) for depth in state.worn.values())
        if not result.converged or state.distance >= course.distance or deepest >= (1.0 - REACHED) * course.depth:
            return
        touched = result.y[fields["pressure"].any(axis=0)]
        dy = float(result.y[1] - result.y[0])
        if touched[0] - dy < state.y[0] or touched[-1] + dy > state.y[-1]:
            raise BeyondProfile(f"the contact has reached the end of a profile after {state.distance:g} m")
        work = sliding_work(worn, result.coupled)
        wear = {body: rate * work for body, rate in rates.items()}
        step = _step(course, state, result, wear, deepest)
        if step == 0.0:
            return
        state = WearState(state.distance + step, state.y, {
            body: state.worn[body] + step * remapped(state.y, result.y, wear[body]) for body in BODIES})


def _step(course: WearCourse, state: WearState, result: Result, wear: dict[BodyName, Array], deepest: float) -> float:
    """Distance (m) of the next step; 0 where nothing wears."""
    fastest = float(sum(wear.values()).max())  # type: ignore[union-attr]
    if not fastest > 0.0:
        return 0.0
    scalars = result.coupled.scalars
    stable = STABLE_SHARE * 0.5 * math.pi * scalars["pressure_max_MPa"] * 1e6 / result.problem.contact_modulus
    depth = min(stable * float(result.y[1] - result.y[0]), course.step_fraction * scalars["approach_um"] * 1e-6)
    left = (course.depth - deepest) / max(float(w.max()) for w in wear.values())
    return min(depth / fastest, course.distance - state.distance, left * (1.0 + REACHED))

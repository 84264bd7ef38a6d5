"""Evolution of both profiles: explicit steps of a bounded worn depth, each solution started from the one before.

Explicit steps are stable while n κ ξ < dy/(E* a): the pressure follows the profile within an element, and a step that wears
more than the pressure's own compliance over an element makes rows wear in turn. In terms of the worn depth d of a step that is
d < (π/2)(p₀/E*) dy; a share of it is taken, and no more than a tenth of the approach. A step's depth is remapped to the points
of the profiles as the sum of quadratic B-splines of the elements, which conserves the worn area. Depths that are constant on
elements would make a staircase of the profile at the border of the contact, which moves by less than an element per step: the
next grids sample it as ridges, and the ridges limit the steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import BODIES, BodyName, Geometry, Problem, Profile, Wear
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.surface import surfaces
from thermoroll_cli.refinement.scalars import sliding_work
from thermoroll_cli.refinement.solve import Solver

STABLE_SHARE = 0.8
"""Share of the largest stable worn depth that a step takes."""
ROOM = 1.3
"""Half-length of the profile that replaces a lateral radius, over the half-width expected in the end."""
LEAST_POINTS = 200
"""Points of the profile that replaces a lateral radius."""
REACHED = 1e-6
"""Part of the wanted depth that may be missing in the end: rounding must not ask for one more step."""
REACH = 1.5
"""Half of the width of the B-spline of an element, in elements."""
STRETCH = 20
"""Steps after which the solver starts cold: an evolution that is resumed at such a step goes on exactly as if undisturbed."""


@dataclass(frozen=True)
class WearState:
    """A moment of the evolution after so many `steps`: `distance` rolled (m), `y` (m) and the `worn` depth of each body there
    (m), and the `result` of the contact with these profiles; None before it is solved."""

    steps: int
    distance: float
    y: Array
    worn: dict[BodyName, Array]
    result: Result | None = None

    @property
    def deepest(self) -> float:
        """Largest worn depth in m."""
        return max(float(depth.max()) for depth in self.worn.values())

    def worn_area(self, body: BodyName) -> float:
        """Worn cross-section in m²."""
        return float((self.worn[body] * _widths(self.y)).sum())


def line_load(result: Result) -> Array:
    """∫ p dx in N/m over the y of the result, (ny,)."""
    x = result.coupled.x
    return np.asarray(result.coupled.fields["pressure"].sum(axis=0) * float(x[1] - x[0]))


def half_width(result: Result) -> float:
    """Half of what the contact spans across rolling, in m."""
    covered = result.coupled.fields["covered"].max(axis=0)
    return 0.5 * float(covered.sum()) * float(result.y[1] - result.y[0])


class BeyondProfile(ArithmeticError):
    """The contact has reached the end of a profile."""


def wearing_points(problem: Problem, wear: Wear, first: Result) -> Array:
    """The y (m) at which the profiles are worn: across both profiles, or as far as the contact is expected to grow.

    By the law of rigid wear the worn area is 2w³/(3R), with the half-width w and the lateral radius R of both bodies."""
    dy = float(first.y[1] - first.y[0])
    reach, curvature = half_width(first) + dy, problem.geometry.curvature_y
    if curvature > 0.0 and math.isfinite(wear.depth):
        reach += math.sqrt(2.0 * wear.depth / curvature)
    elif curvature > 0.0 and math.isfinite(wear.distance):
        rate = wear.lower.wear_per_distance + wear.upper.wear_per_distance
        area = rate * float(_work(problem, first).sum()) * dy * wear.distance
        reach += (1.5 * area / curvature) ** (1.0 / 3.0)
    lower, upper = surfaces(problem.geometry)
    low, high = max(-ROOM * reach, lower.ends[0], upper.ends[0]), min(ROOM * reach, lower.ends[1], upper.ends[1])
    return np.linspace(low, high, max(LEAST_POINTS, math.ceil((high - low) / dy)) + 1)


def worn_geometry(geometry: Geometry, y: Array, worn: dict[BodyName, Array]) -> Geometry:
    """`geometry` with the profiles of worn bodies at the points `y` less the depth that is worn off."""
    changes: dict[str, object] = {}
    for body, surface in zip(BODIES, surfaces(geometry), strict=True):
        if worn[body].any():
            heights = surface.height(y) - worn[body]
            changes |= {f"{body}_profile": Profile(tuple(zip(y.tolist(), heights.tolist(), strict=True))),
                        f"{body}_radius_y": math.inf}
    return replace(geometry, **changes)  # type: ignore[arg-type]


def remapped(y: Array, centres: Array, depth: Array) -> Array:
    """`depth` (m), averages over elements about `centres`, at the points `y`: a sum of quadratic B-splines, each three elements
    wide, averaged over the width of a point, so that the area is kept."""
    dy = float(centres[1] - centres[0])
    knots = centres[0] + dy * (np.arange(len(centres) + 7) - 3.5)
    running = BSpline(knots, np.pad(depth, 2), 2).antiderivative()
    found = np.diff(running(np.clip(_middles(y), knots[2], knots[-3]))) / _widths(y)
    return np.maximum(found, 0.0)  # beside the contact there is rounding


def _middles(y: Array) -> Array:
    return np.concatenate([y[:1], 0.5 * (y[1:] + y[:-1]), y[-1:]])


def _widths(y: Array) -> Array:
    """Length in m that each point stands for."""
    return np.asarray(np.diff(_middles(y)))


def evolution(problem: Problem, start: WearState | None = None, *, threads: int = 1) -> Iterator[WearState]:
    """The states of the evolution that `problem.wear` describes, each with its result, from the unworn profiles or `start`.

    It ends where the distance is rolled or the depth is worn, where nothing slips, and after a result that did not converge.
    Raises BeyondProfile where the contact reaches the end of a profile."""
    wear = problem.wear
    assert wear is not None
    rates = {body: getattr(wear, body).wear_per_distance for body in BODIES}
    solver = Solver(threads)
    state = start
    if state is None:
        y = wearing_points(problem, wear, solver.solve(problem))
        state = WearState(0, 0.0, y, {body: np.zeros_like(y) for body in BODIES})
    while True:
        if state.steps % STRETCH == 0:
            solver = Solver(threads)
        worn = replace(problem, geometry=worn_geometry(problem.geometry, state.y, state.worn))
        result = solver.solve(worn)
        state = replace(state, result=result)
        yield state
        if not result.converged or state.distance >= wear.distance or state.deepest >= (1.0 - REACHED) * wear.depth:
            return
        touched, dy = result.y[result.coupled.fields["pressure"].any(axis=0)], float(result.y[1] - result.y[0])
        if touched[0] - REACH * dy < state.y[0] or touched[-1] + REACH * dy > state.y[-1]:
            raise BeyondProfile(f"the contact has reached the end of a profile, at y from {1e3 * state.y[0]:.4g} to "
                                f"{1e3 * state.y[-1]:.4g} mm, after {1e-3 * state.distance:.4g} km")
        work = _work(worn, result)
        depths = {body: remapped(state.y, result.y, rate * work) for body, rate in rates.items()}
        step = _step(wear, state, result, depths)
        if step == 0.0:
            return
        state = WearState(state.steps + 1, state.distance + step, state.y, {
            body: state.worn[body] + step * depths[body] for body in BODIES})


def _work(problem: Problem, result: Result) -> Array:
    return sliding_work(problem, result.coupled.fields, float(result.x[1] - result.x[0]))


def _step(wear: Wear, state: WearState, result: Result, depths: dict[BodyName, Array]) -> float:
    """Distance (m) of the next step, with the `depths` (m) worn per metre rolled; 0 where nothing wears."""
    fastest = float(sum(depths.values()).max())  # type: ignore[union-attr]
    if not fastest > 0.0:
        return 0.0
    scalars = result.coupled.scalars
    stable = STABLE_SHARE * 0.5 * math.pi * scalars["pressure_max_MPa"] * 1e6 / result.problem.contact_modulus
    depth = min(stable * float(result.y[1] - result.y[0]), wear.step_fraction * scalars["approach_um"] * 1e-6)
    with np.errstate(divide="ignore"):
        left = min(float(((wear.depth - state.worn[body]) / depths[body]).min()) for body in BODIES)
    return min(depth / fastest, wear.distance - state.distance, left * (1.0 + REACHED))

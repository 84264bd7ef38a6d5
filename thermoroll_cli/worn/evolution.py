"""Evolution of both profiles: explicit steps of a bounded worn depth, each solution started from the one before.

Explicit steps are stable while n κ ξ < dy/(E* a): the pressure follows the profile within an element, and a step that wears
more than the pressure's own compliance over an element makes rows wear in turn. In terms of the worn depth d of a step that is
d < (π/4)(p/E*) dy with the pressure p of its row; a share of it is taken, less where the wear rises faster than the pressure,
and no more than a tenth of the approach. Depths are kept on rows that do not move (`rows`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.grid import peak_value
from thermoroll_cli.problem.geometry import Geometry, facing, smallest_gap, surfaces
from thermoroll_cli.problem.problem import BODIES, BodyName, Numerics, Problem, Wear, planar
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.plan import SMALLEST_EXTENT
from thermoroll_cli.refinement.scalars import wear_steepness, worn_per_passage
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.steady_state.derived import DerivedQuantities, pressed_to
from thermoroll_cli.worn.rows import FixedRows, worn_profile

STABLE_SHARE = 0.8
"""Share of the largest stable worn depth that a step takes."""
LIGHT = 0.02
"""Pressure over the largest one below which a row does not limit the steps."""
ROOM = 0.04
"""Part of the contact's domain that is added on either side when the contact has outgrown it."""
MOST_ROWS = 1.5
"""Rows across the domain, over those wanted, from which on rows of twice the width take their place."""
REACHED = 1e-6
"""Part of the wanted depth that may be missing in the end: rounding must not ask for one more step."""
APART = 0.05
"""Share of a given approach below which the bodies have worn apart: a hundredth of the load or less is left."""
STEPS_FROM_COLD = 20
"""Steps after which the solver starts cold: an evolution that is resumed at such a step goes on exactly as if undisturbed."""


@dataclass(frozen=True)
class WearState:
    """A moment of the evolution after so many `steps`: `distance` rolled (m), the `rows` with the `worn` depth of each body
    (m), those of them, `domain`, on which the contact is solved, with `grid` elements wanted along and across rolling, and the
    `result` of the contact with these profiles; None before it is solved. `rates` are the depths worn per metre rolled on each
    row then. `error_shares` of each body are the shares of the errors of its largest depth (m) and worn cross-section (m²),
    (3, 2): by the grid, by the steps, their difference to the trapezoidal rule, and by the shape of one passage's wear."""

    steps: int
    distance: float
    rows: FixedRows
    worn: dict[BodyName, Array]
    domain: FixedRows
    grid: tuple[int, int]
    error_shares: dict[BodyName, Array]
    result: Result | None = None
    rates: dict[BodyName, Array] = field(default_factory=dict)

    @property
    def deepest(self) -> float:
        """Largest worn depth of both bodies in m."""
        return max(self.worn_depth(body) for body in BODIES)

    def worn_depth(self, body: BodyName) -> float:
        """Largest worn depth in m; rows have averages."""
        return peak_value(self.worn[body][None])

    def worn_area(self, body: BodyName) -> float:
        """Worn cross-section in m²."""
        return float(self.worn[body].sum()) * self.rows.size

    def errors(self, body: BodyName) -> tuple[float, float]:
        """Estimated errors of the largest depth (m) and of the worn cross-section (m²)."""
        depth, area = np.abs(self.error_shares[body]).sum(axis=0)
        return float(depth), float(area)

    def moved(self, step: float) -> WearState:
        """The same `step` (m) further."""
        worn = {body: self.worn[body] + step * self.rates[body] for body in BODIES}
        return replace(self, distance=self.distance + step, worn=worn)

    def on(self, rows: FixedRows) -> WearState:
        """The same on other rows."""
        return replace(self, rows=rows, worn={body: rows.averages(self.rows.edges, depth) for body, depth in self.worn.items()})


def worn_apart(problem: Problem, state: WearState) -> bool:
    """Whether bodies at a given distance carry almost no load."""
    assert state.result is not None
    given, left = problem.approach, state.result.problem.approach
    return given is not None and left is not None and left < APART * given


def line_load(result: Result) -> Array:
    """∫ p dx in N/m over the y of the result, (ny,)."""
    x = result.coupled.x
    return np.asarray(result.coupled.fields["pressure"].sum(axis=0) * float(x[1] - x[0]))


def half_width(result: Result) -> float:
    """Half of what the contact spans across rolling, in m."""
    covered = result.coupled.fields["covered"].max(axis=0)
    return 0.5 * float(covered.sum()) * float(result.y[1] - result.y[0])


def worn_geometry(geometry: Geometry, rows: FixedRows, worn: dict[BodyName, Array]) -> Geometry:
    """`geometry` with the profiles of worn bodies less the depth that is worn off on `rows`."""
    changes: dict[str, object] = {}
    for body, surface in zip(BODIES, surfaces(geometry), strict=True):
        if worn[body].any():
            profile = worn_profile(surface, getattr(geometry, f"{body}_profile"), rows, worn[body])
            changes |= {f"{body}_profile": profile, f"{body}_radius_y": math.inf}
    return replace(geometry, **changes)  # type: ignore[arg-type]


def evolution(problem: Problem, start: WearState | None = None, *, threads: int = 1) -> Iterator[WearState]:
    """The states of the evolution that `problem.wear` describes, each with its result, from the unworn profiles or `start`.

    It ends where the distance is rolled or the depth is worn, where nothing slips, and after a result that did not converge.
    A given approach keeps the distance of the axles, so that the load falls; the evolution also ends where little load is left.
    With `numerics.accuracy`, all states have the grid that the unworn profiles need. Raises Unsolvable as `solve` does."""
    wear = problem.wear
    assert wear is not None
    solver = Solver(threads)
    state, before = start or _unworn(problem, solver), None
    while True:
        if state.steps % STEPS_FROM_COLD == 0:
            solver = Solver(threads)
        worn, state = _followed(problem, state)
        result = solver.solve(worn)
        state = replace(state, result=result, rates=_rates(wear, state.rows, result))
        if before is not None:
            state = replace(state, error_shares=_error_shares(before, state))
        yield state
        if not result.converged or state.distance >= wear.distance or state.deepest >= (1.0 - REACHED) * wear.depth:
            return
        before, step = state, _step(wear, state, result)
        if step == 0.0 or worn_apart(problem, state):
            return
        state = replace(state.moved(step), steps=state.steps + 1, result=None, rates={})


def _unworn(problem: Problem, solver: Solver) -> WearState:
    grid = problem.numerics.grid
    if grid is None:
        result = solver.solve(problem)
        grid = len(result.x), len(result.y)
    rows = FixedRows.over(*_across(problem), facing(planar(problem)), grid[1])
    return WearState(0, 0.0, rows, {body: np.zeros(rows.count) for body in BODIES}, rows, grid,
                     {body: np.zeros((3, 2)) for body in BODIES})


def _across(problem: Problem) -> tuple[float, float]:
    """Lowest and highest y (m) of the domain that a solution of `problem` would have."""
    domain = DerivedQuantities(problem).scales.domain(max(problem.numerics.extent, SMALLEST_EXTENT))
    return domain.centre - 0.5 * domain.side_y, domain.centre + 0.5 * domain.side_y


def _followed(problem: Problem, state: WearState) -> tuple[Problem, WearState]:
    """The problem with the profiles of `state`, and the state on rows that its contact fits on."""
    worn = _worn(problem, state)
    low, high = _across(worn)
    if not state.domain.covers(low, high):
        room = ROOM * (high - low)
        domain, rows = state.domain.covering(low - room, high + room), state.rows
        if domain.count >= MOST_ROWS * state.grid[1]:
            domain, rows = domain.coarser().covering(low - room, high + room), rows.coarser()
        state = replace(state.on(rows.joined(domain)), domain=domain)
        worn = _worn(problem, state)
    numerics = Numerics((state.grid[0], state.domain.count), extent=problem.numerics.extent, across=state.domain.ends)
    return replace(worn, numerics=numerics), state


def _worn(problem: Problem, state: WearState) -> Problem:
    """`problem` with the profiles of `state`. A given approach counts from where the worn bodies touch first: at the same
    distance of the axles it is smaller by what is worn off there."""
    geometry = worn_geometry(planar(problem), state.rows, state.worn)
    worn = replace(problem, geometry=geometry)
    if problem.approach is None:
        return worn
    return pressed_to(worn, problem.approach + smallest_gap(planar(problem)) - smallest_gap(geometry))


def _rates(wear: Wear, rows: FixedRows, result: Result) -> dict[BodyName, Array]:
    """Depths worn per metre rolled (1) on each row."""
    half, dx = 0.5 * float(result.y[1] - result.y[0]), float(result.x[1] - result.x[0])
    edges = np.append(result.y - half, result.y[-1] + half)
    return {body: rows.averages(edges, worn_per_passage(result.problem, worn, result.coupled.fields, dx) / worn.track_length)
            for body, worn in zip(BODIES, (wear.lower, wear.upper), strict=True)}


def _error_shares(before: WearState, state: WearState) -> dict[BodyName, Array]:
    """The shares of the errors of `state`, one step after `before`. Errors of the worn area add up. A row that wears too much
    carries less from then on, so that the depth has the error of the area and of one passage's shape, at most as deep as one
    step wears."""
    assert before.result is not None
    step, errors = state.distance - before.distance, {}
    for body in BODIES:
        old, new = (np.array([rates.max(), rates.sum() * rows.size])
                    for rates, rows in ((before.rates[body], before.rows), (state.rates[body], state.rows)))
        shape, area = (before.result.error.get(name, math.nan) if old[0] else 0.0
                       for name in (f"wear_depth_max_{body}_nm", f"wear_area_{body}_um2"))
        shares = before.error_shares[body] + np.array([step * old * area, 0.5 * step * (new - old), [0.0, 0.0]])
        shares[2, 0] = max(shares[2, 0], step * old[0] * shape)
        errors[body] = shares
    return errors


def _step(wear: Wear, state: WearState, result: Result) -> float:
    """Distance (m) of the next step; 0 where nothing wears."""
    rates = np.asarray(sum(state.rates.values()))
    if not rates.any():
        return 0.0
    fields, dy = result.coupled.fields, float(result.y[1] - result.y[0])
    steepest = max(wear_steepness(result.problem, worn, fields) for worn in (wear.lower, wear.upper))
    pressure = np.interp(state.rows.y, result.y, fields["pressure"].max(axis=0), left=0.0, right=0.0)
    loaded = pressure > LIGHT * pressure.max()
    fastest = float((rates[loaded] / pressure[loaded]).max())
    stable = STABLE_SHARE * 0.25 * math.pi * dy / (result.problem.contact_modulus * fastest)
    depth = wear.step_fraction * result.coupled.scalars["approach_um"] * 1e-6
    step = min(stable / steepest, depth / float(rates.max()), wear.distance - state.distance)
    if state.moved(step).deepest <= wear.depth:
        return step
    return float(scipy.optimize.brentq(lambda part: state.moved(part).deepest - wear.depth, 0.0, step, rtol=1e-9))

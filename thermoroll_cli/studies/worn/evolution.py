"""Evolution of both profiles: explicit steps of a bounded worn depth, each solution started from the one before.

Explicit steps are stable while n κ ξ < dy/(E* a): the pressure follows the profile within an element, and a step that wears
more than the pressure's own compliance over an element makes rows wear in turn. In terms of the worn depth d of a step that is
d < (π/4)(p/E*) dy with the pressure p of its row; a share of it is taken, less where the wear rises faster than the pressure,
and no more than a tenth of the approach. Depths are kept on rows that do not move (`rows`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.one_contact.refinement.plan import extent_of
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, pressed_to
from thermoroll_cli.one_contact.steady_state.scalars import wear_steepness, worn_per_passage
from thermoroll_cli.problem.geometry import Geometry, surfaces
from thermoroll_cli.problem.problem import BODIES, BodyName, Numerics, Problem, Wear, planar
from thermoroll_cli.problem.result import Result
from thermoroll_cli.studies.worn.rows import FixedRows, worn_profile
from thermoroll_cli.studies.worn.steps import Columns, WearState, reached, steps_of
from thermoroll_cli.tools.arrays import Array

STABLE_SHARE = 0.8
"""Share of the largest stable worn depth that a step takes."""
LIGHT = 0.02
"""Pressure over the largest one below which a row does not limit the steps."""
ROOM = 0.04
"""Part of the contact's domain that is added on either side when the contact has outgrown it."""
MOST_ROWS = 1.5
"""Rows across the domain, over those wanted, from which on rows of twice the width take their place."""
OF_RESULT = ("pressure_max_MPa", "temperature_rise_max_lower_K", "temperature_rise_max_upper_K", "Q_F_W", "T_gamma_N",
             "approach_um", "normal_N")
"""Scalars of each step's result that become columns."""
APART = 0.05
"""Share of a given approach below which the bodies have worn apart: a hundredth of the load or less is left."""
STEPS_FROM_COLD = 20
"""Steps after which the solver starts cold: an evolution that is resumed at such a step goes on exactly as if undisturbed."""


@dataclass(frozen=True, kw_only=True)
class ContactState(WearState):
    """A moment of the evolution of both bodies: the `rows` of their worn depths, those of them, `domain`, on which the contact
    is solved, with `grid` elements wanted along and across rolling, and once it is solved the `result` of the contact with
    these profiles."""

    rows: FixedRows
    domain: FixedRows
    grid: tuple[int, int]
    result: Result | None = None

    def on(self, rows: FixedRows) -> ContactState:
        """The same on other rows."""
        worn = {body: rows.averages(self.rows.edges, depth) for body, depth in self.worn.items()}
        return replace(self, rows=rows, worn=worn, sizes=dict.fromkeys(BODIES, rows.size))


def line_load(result: Result) -> Array:
    """∫ p dx in N/m over the y of the result, (ny,)."""
    x = result.coupled.x
    return np.asarray(result.coupled.fields["pressure"].sum(axis=0) * float(x[1] - x[0]))


def half_width(result: Result) -> float:
    """Half of what the contact spans across rolling, in m."""
    covered = result.coupled.fields["covered"].max(axis=0)
    return 0.5 * float(covered.sum()) * float(result.y[1] - result.y[0])


def worn_geometry(geometry: Geometry, rows: FixedRows, worn: Mapping[str, Array]) -> Geometry:
    """`geometry` with the profiles of worn bodies less the depth that is worn off on `rows`."""
    changes: dict[str, object] = {}
    for body, surface in zip(BODIES, surfaces(geometry), strict=True):
        if worn[body].any():
            profile = worn_profile(surface, getattr(geometry, f"{body}_profile"), rows, worn[body])
            changes |= {f"{body}_profile": profile, f"{body}_radius_y": math.inf}
    return replace(geometry, **changes)  # type: ignore[arg-type]


def evolution(problem: Problem, start: ContactState | None = None, *, threads: int = 1) -> Iterator[ContactState]:
    """The states of the evolution that `problem.wear` describes, each with its result, from the unworn profiles or `start`,
    which may have had another grid.

    It ends where the distance is rolled or the depth is worn, where nothing slips, and after a result that did not converge.
    A given approach keeps the distance of the axles, so that the load falls; the evolution also ends where little load is left.
    With `numerics.accuracy`, all states have the grid that the unworn profiles need. Raises Unsolvable as `solve` does."""
    wear = problem.wear
    assert wear is not None
    solver = ContactSolver(threads)
    load = problem.normal_force if problem.approach is None else DerivedQuantities(problem).scales.normal_force

    def solved(state: ContactState) -> ContactState:
        nonlocal solver
        if state.steps % STEPS_FROM_COLD == 0:
            solver = ContactSolver(threads)
        worn, state = _followed(problem, state)
        return _solved(problem, load, state, solver.solve(worn))

    grid = problem.numerics.grid
    if grid is None:
        result = solver.solve(problem)
        grid = len(result.x), len(result.y)
    rows = FixedRows.over(*_across(problem), planar(problem).limits, grid[1])
    if start is None:
        start = ContactState.unworn(dict.fromkeys(BODIES, rows.count), dict.fromkeys(BODIES, rows.size), rows=rows, domain=rows,
                                    grid=grid)
    elif start.grid != grid:
        domain = rows.covering(*start.domain.ends)
        while domain.count >= MOST_ROWS * grid[1]:
            domain = domain.coarser()
        start = replace(start.on(domain.joined(domain.covering(*start.rows.ends))), domain=domain, grid=grid)
    return steps_of(wear, start, solved, lambda state: _columns(problem, wear, state))


def _solved(problem: Problem, load: float, state: ContactState, result: Result) -> ContactState:
    """`state` with its result and what follows from it; the unworn bodies carry `load` (N)."""
    wear = result.problem.wear
    assert wear is not None
    half, dx = 0.5 * float(result.y[1] - result.y[0]), float(result.x[1] - result.x[0])
    edges = np.append(result.y - half, result.y[-1] + half)
    rates: dict[str, Array] = {
        body: state.rows.averages(edges, worn_per_passage(result.problem, worn, result.coupled.fields, dx) / worn.track_length)
        for body, worn in wear.bodies.items()}
    known = {str(body): rate_errors(result, body) if rates[body].any() else (0.0, 0.0) for body in BODIES}
    largest = float(line_load(result).max())
    state = replace(state, result=result, rates=rates, rate_errors=known, columns={
        "half_width_mm": (1e3 * half_width(result), None), "line_load_max_N_mm": (1e-3 * largest, None),
        **{name: (result[name], result.uncertainty[name]) for name in OF_RESULT if name in result.scalars}})
    if not result.converged:
        return replace(state, reason=f"step {state.steps} did not converge: {result.reason}")
    # Approaches count from where worn bodies touch first, which may be a ridge between two rows.
    left, given, approach = result.coupled.scalars["normal_N"], problem.approach, result.problem.approach
    apart = given is not None and approach is not None and (approach < APART * given or left < APART**1.5 * load)
    if apart and not reached(wear, state):
        return replace(state, reason=f"the bodies wear apart at the given distance: {left:.3g} N are left")
    return replace(state, longest=_longest(wear, state, result))


def rate_errors(result: Result, body: BodyName) -> tuple[float, float]:
    """Relative errors of the largest depth and of the cross-section that one passage wears off a body; nan if unknown."""
    depth, area = f"wear_depth_max_{body}_nm", f"wear_area_{body}_um2"
    return result.uncertainty[depth] / result[depth], result.uncertainty[area] / result[area]


def _across(problem: Problem) -> tuple[float, float]:
    """Lowest and highest y (m) of the domain that a solution of `problem` would have."""
    domain = DerivedQuantities(problem).scales.domain(extent_of(problem.numerics)[0])
    return domain.centre - 0.5 * domain.side_y, domain.centre + 0.5 * domain.side_y


def _followed(problem: Problem, state: ContactState) -> tuple[Problem, ContactState]:
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


def _worn(problem: Problem, state: ContactState) -> Problem:
    """`problem` with the profiles of `state`. A given approach counts from where the worn bodies touch first: at the same
    distance of the axles it is smaller by what is worn off there."""
    geometry = worn_geometry(planar(problem), state.rows, state.worn)
    worn = replace(problem, geometry=geometry)
    if problem.approach is None:
        return worn
    return pressed_to(worn, problem.approach + planar(problem).first_touch[1] - geometry.first_touch[1])


def _longest(wear: Wear, state: ContactState, result: Result) -> float:
    """Distance (m) of the next step at most; 0 where nothing wears."""
    rates = np.asarray(sum(state.rates.values()))
    if not rates.any():
        return 0.0
    fields, dy = result.coupled.fields, float(result.y[1] - result.y[0])
    steepest = max(wear_steepness(result.problem, worn, fields) for worn in wear.bodies.values())
    pressure = np.interp(state.rows.y, result.y, fields["pressure"].max(axis=0), left=0.0, right=0.0)
    loaded = pressure > LIGHT * pressure.max()
    fastest = float((rates[loaded] / pressure[loaded]).max())
    stable = STABLE_SHARE * 0.25 * math.pi * dy / (result.problem.contact_modulus * fastest)
    depth = wear.step_fraction * result.coupled.scalars["approach_um"] * 1e-6
    return float(min(stable / steepest, depth / float(rates.max())))


def _columns(problem: Problem, wear: Wear, state: ContactState) -> Columns:
    """Passages and what is worn off each body; the volume is what this contact has worn off."""
    found: Columns = {}
    for body, worn in wear.bodies.items():
        if math.isfinite(worn.track_length):
            found[f"cycles_{body}"] = state.distance / worn.track_length, None
        density = (problem.lower if body == "lower" else problem.upper).density or wear.density
        found |= state.wear_columns(body, density, worn.track_length)
    return found

"""Seeded profiles, off-centre, offset and tilted, of one body or both, that wear; and the check of each evolution."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.outcome import Outcome
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Profile, surfaces
from thermoroll_cli.problem.problem import BODIES, Heating, Material, Motion, Numerics, Problem, Wear, WornBody
from thermoroll_cli.studies.worn.evolution import ContactState, evolution, line_load, worn_geometry
from thermoroll_cli.studies.worn.steps import REACHED

KINDS = ("cubic", "linear", "arcs", "crown", "radius")
GRIDS = ((16, 16), (24, 24), (32, 32), (20, 33))
MOST_STEPS = 150
FALLS = 1.001
"""A load at a given approach over that of the step before, at most: grids differ by as much."""
AREA, ROUGHNESS, PEAK = 2e-3, 0.1, 40.0
"""Relative error of the worn area in full sliding; second difference of the line load inside the contact, over the largest, and
the same times the square of the number of rows: few rows hardly resolve a peak."""


def worn_contact(seed: int) -> Problem:
    """The contact of `seed`, always the same: its profile is of `KINDS[seed % 5]`."""
    rng = np.random.default_rng([29, seed])
    steel, half, kind = Material(210e9, 0.28), 10.0 ** rng.uniform(-3.0, -1.7), KINDS[seed % len(KINDS)]
    radius_y = half * 10.0 ** rng.uniform(0.5, 1.5)
    y = np.linspace(-1.0, 1.0, int(rng.integers(15, 120))) * half
    shape = -(y**2) / (2.0 * radius_y)
    if kind == "arcs":
        shape -= np.maximum(y - 0.2 * half, 0.0) ** 2 / radius_y
    points = tuple(zip(y.tolist(), shape.tolist(), strict=True))
    offset, tilt = rng.uniform(-0.7, 0.7) * half, rng.uniform(-0.4, 0.4) * half / radius_y
    profile = Profile(points, "linear" if kind == "linear" else "cubic", offset=offset, tilt=tilt)
    if kind == "crown":
        profile = Profile(length=2.0 * half, drop=half**2 / (2.0 * radius_y), offset=offset, tilt=0.3 * tilt)
    radius_x, flat = half * 10.0 ** rng.uniform(0.0, 1.0), math.inf
    geometry = Geometry(flat, flat, radius_x, flat, upper_profile=profile)
    if kind == "radius":
        geometry = Geometry(flat, flat, radius_x, radius_y)
    elif rng.random() < 0.4:
        geometry = Geometry(radius_x, flat, radius_x, -5.0 * radius_y if rng.random() < 0.5 else flat, lower_profile=profile)
    motion = Motion(1.0, 0.05, differential_slip=False)
    if rng.random() < 0.5:
        lateral, curved = float(rng.choice([0.0, 1e-3])), bool(rng.random() < 0.5)
        motion = Motion(1.0, 10.0 ** rng.uniform(-3.5, -2.0), lateral, differential_slip=curved)
    load = steel.youngs_modulus * half**2 * 10.0 ** rng.uniform(-6.0, -4.5)
    problem = Problem(steel, steel, geometry, load, Friction(float(rng.uniform(0.1, 0.5))), motion, Heating(heat=False),
                      Numerics(GRIDS[int(rng.integers(len(GRIDS)))]))
    depth = DerivedQuantities(problem).scales.approach * 10.0 ** rng.uniform(-0.7, 0.5)
    lower, upper = ((1e-14, 1e-14), (0.0, 1e-14), (3e-15, 1e-14), (1e-14, 0.0))[int(rng.integers(4))]
    return replace(problem, wear=Wear(WornBody(lower, 1.0), WornBody(upper, 2.0), depth=depth))


def violations(problem: Problem, last: ContactState) -> list[str]:
    """Faults of the last state of an evolution."""
    wear, result, found = problem.wear, last.result, []
    assert wear is not None and result is not None
    apart = "wear apart" in last.reason
    if last.steps < MOST_STEPS and not apart and not last.deepest >= (1.0 - 2.0 * REACHED) * wear.depth:
        found.append(f"worn by {last.deepest:g} m, not {wear.depth:g} m")
    geometry = worn_geometry(problem.geometry, last.rows, last.worn)
    for body, before, after in zip(BODIES, surfaces(problem.geometry), surfaces(geometry), strict=True):
        worn, rate = last.worn[body], getattr(wear, body).rate / getattr(wear, body).track_length
        if worn.min() < 0.0 or worn.any() != (rate > 0.0):
            found.append(f"{body}: depths from {worn.min():g} m")
        sliding = 0.05 * problem.normal_force * rate * last.distance
        slides = problem.motion.creepage_x == 0.05 and problem.approach is None
        if slides and abs(last.worn_area(body) - sliding) > AREA * sliding:
            found.append(f"{body}: worn area {last.worn_area(body):g}, in full sliding {sliding:g} m²")
        if math.isfinite(before.ends[1]) and not np.allclose(before.ends, after.ends, atol=1e-8 * np.ptp(before.ends)):
            found.append(f"{body}: profile from {after.ends[0]:g} to {after.ends[1]:g} m")
        depths = before.height(last.rows.y) - after.height(last.rows.y)
        if np.abs(depths - worn).max() > 1e-6 * wear.depth:
            found.append(f"{body}: worn profile off by {np.abs(depths - worn).max():g} m")
    load = line_load(result)
    inside, loaded = load[load > 0.0][3:-3], int((load > 0.01 * load.max()).sum())
    allowed = max(ROUGHNESS, PEAK / loaded**2) * load.max()
    kinked = any(profile.interpolation == "linear" for _, profile in problem.geometry.profiles)
    if not (result.unbounded or kinked) and len(inside) > 4 and np.abs(np.diff(inside, 2)).max() > allowed:
        found.append(f"line load rough by {np.abs(np.diff(inside, 2)).max() / load.max():.2g}")
    return found


def worn_at_an_approach(seed: int) -> Problem:
    """The contact of `worn_contact` with its axles at a given distance; some wear apart."""
    problem = worn_contact(1000 + seed)
    return replace(problem, approach=DerivedQuantities(problem).scales.approach)


def check_approach(problem: Problem) -> Outcome:
    """Wear at a given approach: the axles keep their distance, and the load falls."""
    found, before = [], None
    for last in evolution(problem):
        assert last.result is not None
        given, load = last.result.problem.approach, last.result.coupled.scalars["normal_N"]
        assert given is not None and problem.approach is not None
        rise = worn_geometry(problem.geometry, last.rows, last.worn).first_touch[1] - problem.geometry.first_touch[1]
        if not math.isclose(given + rise, problem.approach, rel_tol=1e-9):
            found.append(f"step {last.steps}: the axles moved by {given + rise - problem.approach:g} m")
        if before is not None and last.result.converged and not load < FALLS * before:
            found.append(f"step {last.steps}: the load rises from {before:g} to {load:g} N")
        before = load
        if last.steps >= MOST_STEPS:
            break
    if last.result.converged:
        found += violations(problem, last)
    return Outcome(last.result.converged, last.result.reason, broken=tuple(found),
                   work=last.result.work["levels"][-1]["applications"])


def check(problem: Problem) -> Outcome:
    """Wear the contact, for a bounded number of steps, and check the last state."""
    for last in evolution(problem):
        if last.steps >= MOST_STEPS:
            break
    result = last.result
    assert result is not None
    broken = tuple(violations(problem, last)) if result.converged else ()
    return Outcome(result.converged, result.reason, broken=broken, work=result.work["levels"][-1]["applications"])

"""Seeded pairs of radii of any kind and ratio on their curved common surface: at small angles they agree with the plane."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.checks import solved
from scripts.stress.outcome import Outcome
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.curved_patch import conformal_patch
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result

RATIOS = 0.1, 30.0
"""Smallest and largest R_y over R_x of a body."""
ANGLES = 1e-3, 0.3
"""Smallest and largest half-width of the contact over the smallest radius of a body."""
FLAT_SHARE, CONCAVE_SHARE, FOLLOWING_SHARE = 0.15, 0.3, 0.25
SLENDER = 0.005
"""Smallest ratio of the relative curvatures along and across, and of its inverse."""
COARSE = 2e-3
"""Difference of Hertz's contact from one that is found on a grid, besides the square of the angle."""
FORCE, CANCELLED = 0.03, 0.1
"""Difference of forces over the force, or over this share of the friction limit where opposite slip makes the force small."""
SAME_LOAD = 1e-4
"""Difference of the load that is found for a vertical force."""


def random_pair(seed: int) -> Problem:
    """The planar contact of `seed`: radii along and across from 1 mm to 30 m, flat or concave as well."""
    rng = np.random.default_rng([41, seed])
    while True:
        geometry = Geometry(*(radius for _ in range(2) for radius in _body(rng)))
        if rng.random() < FOLLOWING_SHARE:
            # A groove that follows the other body.
            geometry = replace(geometry, lower_radius_y=-abs(geometry.upper_radius_y) * (1.0 + _log(rng, 0.01, 1.0)),
                               upper_radius_y=abs(geometry.upper_radius_y))
        if min(geometry.curvature_x, geometry.curvature_y) <= 0.0 or not SLENDER < _ratio(geometry) < 1.0 / SLENDER:
            continue
        body = Material(float(10.0 ** rng.uniform(9.0, 11.5)), float(rng.uniform(0.0, 0.45)))
        upper = replace(body, youngs_modulus=body.youngs_modulus * float(rng.choice([1.0, rng.uniform(0.2, 5.0)])))
        problem = Problem(body, upper, geometry, 1.0, Friction(0.3), Motion(1.0), Heating(heat=False), Numerics((32, 32)))
        load = (_log(rng, *ANGLES) / _angle(problem)) ** 3
        problem = replace(problem, normal_force=load)
        creepage = DerivedQuantities(problem).saturation_creepage * _log(rng, 0.1, 2.0)
        return replace(problem, motion=Motion(1.0, creepage, 0.0))


def agrees(problem: Problem) -> Outcome:
    """Load, peak, approach and force on the plane and on the common surface, which differ by the square of the angle; and the
    load that is found for the vertical force of that."""
    outcomes: list[Outcome] = []
    results: list[Result] = []
    patch = conformal_patch(problem.geometry, problem.compliance_shares)  # type: ignore[arg-type]
    for each in (problem, replace(problem, geometry=patch) if any(patch.angle) else problem):
        outcomes.append(solved(each, lambda result: results.append(result) or ()))  # type: ignore[func-returns-value]
    plane, curved = (result.coupled.scalars for result in results)
    square = _angle(problem) ** 2
    broken = [fault for outcome in outcomes for fault in outcome.broken]
    for name, allowed in (("pressure_max_MPa", COARSE), ("approach_um", COARSE), ("force_x_N", FORCE)):
        scale = max(abs(plane[name]), CANCELLED * problem.traction_limit if name == "force_x_N" else 0.0)
        if not abs(curved[name] - plane[name]) <= (allowed + 2.0 * square) * scale:
            broken.append(f"{name}: {curved[name]:.6g} on the common surface, {plane[name]:.6g} on the plane, "
                          f"angle {math.sqrt(square):.3g}")
    if any(patch.angle):
        under = replace(problem, geometry=patch, vertical=curved["contact_force_z_N"])
        outcomes.append(solved(under, lambda result: results.append(result) or ()))  # type: ignore[func-returns-value]
        broken += outcomes[2].broken
        load = results[2].coupled.scalars["normal_N"]
        if not abs(load - problem.normal_force) <= SAME_LOAD * problem.normal_force:
            broken.append(f"the vertical force of {problem.normal_force:.6g} N is that of {load:.6g} N")
    return replace(outcomes[1], broken=tuple(broken), converged=all(outcome.converged for outcome in outcomes))


def _body(rng: np.random.Generator) -> tuple[float, float]:
    size = _log(rng, 1e-3, 1.0)
    along, across = (math.inf if rng.random() < FLAT_SHARE else radius for radius in (size, size * _log(rng, *RATIOS)))
    signs = rng.choice([1.0, -1.0], 2, p=[1.0 - CONCAVE_SHARE, CONCAVE_SHARE])
    return float(signs[0]) * along, float(signs[1]) * across


def _ratio(geometry: Geometry) -> float:
    return geometry.curvature_x / geometry.curvature_y


def _angle(problem: Problem) -> float:
    """Largest half-width of the contact over a radius in its direction."""
    scales, geometry = DerivedQuantities(problem).scales, problem.geometry
    assert isinstance(geometry, Geometry)
    return max(scales.semi_axis_x / min(abs(geometry.lower_radius_x), abs(geometry.upper_radius_x)),
               scales.semi_axis_y / min(abs(geometry.lower_radius_y), abs(geometry.upper_radius_y)))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))

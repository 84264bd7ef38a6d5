"""Seeded contacts of bodies with bonded layers: one to three layers on one body or both, 0.01 to 100 times as stiff as the body
below them all, from a quarter of an element to a hundred contact radii thick."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import _geometry, _log, _motion
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Problem
from thermoroll_cli.steady_state.derived import DerivedQuantities

BOTH_SHARE, ALIKE_SHARE, INCOMPRESSIBLE_SHARE = 0.5, 0.5, 0.1
THINNEST, THICKEST = 0.25 * 2.2 / 32, 100.0
"""Thickness of a stack over the mean radius of the contact: a quarter of an element of 32, and far beyond the contact."""
THICKEST_RADIUS = 0.3
"""Thickness over the smallest radius of curvature, at most."""
STIFFEST = 250.0
"""Modulus of a layer over that below it, at most: case files allow 300."""
ADJUSTMENTS = 4


def random_layers(seed: int) -> Problem:
    """The contact of `seed`, always the same: mechanical, creepage from 0.02 to 20 times saturation."""
    rng = np.random.default_rng([17, seed])
    geometry = _geometry(rng)
    smallest = min(abs(r) for r in (geometry.lower_radius_x, geometry.lower_radius_y))
    lower = _body(rng)
    upper = Material(_log(rng, 0.0, 2.5) * 1e9, float(rng.uniform(0.0, 0.48)))
    if rng.random() < BOTH_SHARE:
        upper = lower if rng.random() < ALIKE_SHARE else _body(rng)
    elif rng.random() < ALIKE_SHARE:
        lower, upper = upper, lower
    # The contact stays small beside the radii.
    load = min(lower.youngs_modulus, upper.youngs_modulus) * smallest**2 * _log(rng, -12.0, -8.0)
    problem = Problem(lower, upper, geometry, load, float(rng.uniform(0.05, 0.6)), Motion(1.0, differential_slip=False),
                      Heating(heat=False))
    wanted = _log(rng, math.log10(THINNEST), math.log10(THICKEST))
    for _ in range(ADJUSTMENTS):
        # Stacks are drawn with a thickness of one, and the contact's size depends on them.
        thickness = min(wanted * DerivedQuantities(problem).scales.mean_radius, THICKEST_RADIUS * smallest)
        problem = replace(problem, lower=_as_thick(problem.lower, thickness), upper=_as_thick(problem.upper, thickness))
    motion = _motion(rng, problem)
    return replace(problem, motion=motion)


def _body(rng: np.random.Generator) -> Material:
    modulus = _log(rng, 0.0, 2.5) * 1e9
    layers: list[Layer] = []
    below = modulus
    for _ in range(rng.integers(1, 4)):
        below = min(modulus * _log(rng, -2.0, 2.0), STIFFEST * below)
        layers.insert(0, Layer(_log(rng, -0.5, 0.5), below, _ratio(rng)))
    return Material(modulus, float(rng.uniform(0.0, 0.48)), layers=tuple(layers))


def _ratio(rng: np.random.Generator) -> float:
    return 0.5 if rng.random() < INCOMPRESSIBLE_SHARE else float(rng.uniform(0.0, 0.5))


def _as_thick(body: Material, thickness: float) -> Material:
    """`body` with layers of `thickness` (m) altogether."""
    whole = sum(layer.thickness for layer in body.layers)
    return replace(body, layers=tuple(replace(layer, thickness=layer.thickness * thickness / whole) for layer in body.layers))

"""Seeded contacts of bodies with bonded layers: one to three layers on one body or both, 0.01 to 100 times as stiff as the body
below them all, from a quarter of an element to a hundred contact radii thick."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import LARGEST_BULGE, _geometry, _heating, _log, random_motion
from thermoroll_cli.one_contact.refinement.expected_heat import bulge_bound
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Problem

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
    problem = Problem(lower, upper, geometry, load, Friction(float(rng.uniform(0.05, 0.6))),
                      Motion(1.0, differential_slip=False), Heating(heat=False))
    wanted = _log(rng, math.log10(THINNEST), math.log10(THICKEST))
    for _ in range(ADJUSTMENTS):
        # Stacks are drawn with a thickness of one, and the contact's size depends on them.
        thickness = min(wanted * DerivedQuantities(problem).scales.mean_radius, THICKEST_RADIUS * smallest)
        problem = replace(problem, lower=_as_thick(problem.lower, thickness), upper=_as_thick(problem.upper, thickness))
    motion = random_motion(rng, problem)
    return replace(problem, motion=motion)


def random_hot_layers(seed: int) -> Problem:
    """The contact of `random_layers` with heat: Péclet numbers from 0.1 to 1000, conductivities of 0.01 to 10 times that of the
    body below, expansions that bulge it by up to `LARGEST_BULGE` of the approach."""
    rng, problem = np.random.default_rng([19, seed]), random_layers(seed)
    heating = _heating(rng)
    problem = replace(problem, heating=replace(heating, peclet="rolling" if heating.peclet == "sliding" else heating.peclet))
    derived = DerivedQuantities(problem)
    diffusivity = problem.motion.speed * derived.scales.semi_axis_x / _log(rng, -1.0, 3.0)
    lower = _warm(rng, problem.lower, diffusivity)
    problem = replace(problem, lower=lower,
                      upper=lower if problem.upper == problem.lower else _warm(rng, problem.upper, diffusivity))
    wanted = _log(rng, -4.0, math.log10(LARGEST_BULGE))
    bound = bulge_bound(DerivedQuantities(problem)) if problem.heating.deformation else 0.0
    factor = wanted * derived.scales.approach / bound if bound else 1.0
    return replace(problem, lower=_expanding(problem.lower, factor), upper=_expanding(problem.upper, factor))


def _warm(rng: np.random.Generator, body: Material, diffusivity: float) -> Material:
    conductivity = _log(rng, 0.5, 2.5)
    layers = tuple(replace(layer, conductivity=conductivity * _log(rng, -2.0, 1.0), expansion=_log(rng, 0.0, 2.0) * 1e-6,
                           diffusivity=diffusivity * _log(rng, -1.5, 1.0)) for layer in body.layers)
    return replace(body, conductivity=conductivity, expansion=1e-5, diffusivity=diffusivity, layers=layers)


def _expanding(body: Material, factor: float) -> Material:
    layers = tuple(replace(layer, expansion=(layer.expansion or 0.0) * factor) for layer in body.layers)
    return replace(body, expansion=(body.expansion or 0.0) * factor, layers=layers)


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

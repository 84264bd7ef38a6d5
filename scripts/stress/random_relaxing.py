"""Seeded contacts of bodies that relax: one body or both, alike or not, with one to four times, rolled through in 0.01 to 100
half-widths; to 30 times the instantaneous compliance. Some relax in a layer on an elastic body, some have heat."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import _geometry, _log, random_motion
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Problem

BOTH_SHARE, ALIKE_SHARE, LAYERED_SHARE, HOT_SHARE, FRICTIONLESS_SHARE = 0.4, 0.5, 0.3, 0.3, 0.1
SOFTEST = 30.0
"""Relaxed over instantaneous compliance, at most."""
THICKNESS = -0.7, 1.0
"""Range of the decimal logarithm of a layer's thickness over the mean radius of the contact."""


def random_relaxing(seed: int) -> Problem:
    """The contact of `seed`, always the same: creepage from 0.02 to 20 times saturation, spin, forces."""
    rng = np.random.default_rng([43, seed])
    geometry = _geometry(rng)
    smallest = min(abs(r) for r in (geometry.lower_radius_x, geometry.lower_radius_y))
    lower = Material(_log(rng, -2.0, 1.0) * 1e9, float(rng.uniform(0.2, 0.5)))
    stiff = Material(_log(rng, 0.0, 2.5) * 1e9, float(rng.uniform(0.1, 0.4)))
    load = lower.youngs_modulus * smallest**2 * _log(rng, -9.0, -6.0)
    friction = 0.0 if rng.random() < FRICTIONLESS_SHARE else float(rng.uniform(0.05, 0.6))
    motion = Motion(1.0, differential_slip=False)
    problem = Problem(lower, stiff, geometry, load, Friction(friction), motion, Heating(heat=False))
    size = DerivedQuantities(problem).hertz
    lower = _with_series(rng, lower, size.semi_axis_x)
    upper = stiff
    if rng.random() < LAYERED_SHARE:
        thickness = min(size.mean_radius * _log(rng, *THICKNESS), 0.2 * smallest)
        layer = Layer(thickness, lower.youngs_modulus, lower.poisson_ratio, relaxation=lower.relaxation)
        lower = Material(lower.youngs_modulus * _log(rng, 1.0, 4.0), 0.3, layers=(layer,))
    if rng.random() < BOTH_SHARE:
        upper = lower if rng.random() < ALIKE_SHARE else _with_series(rng, stiff, size.semi_axis_x)
    if rng.random() < 0.5:
        lower, upper = upper, lower
    problem = replace(problem, lower=lower, upper=upper)
    problem = replace(problem, motion=random_motion(rng, problem))
    if rng.random() < HOT_SHARE:
        warm = [_warm(rng, body) for body in (lower, upper)]
        problem = replace(problem, lower=warm[0], upper=warm[0] if upper == lower else warm[1],
                          heating=Heating(True, not (lower.layers or upper.layers)))
    return problem


def _with_series(rng: np.random.Generator, body: Material, half: float) -> Material:
    """`body` with times that are rolled through at 1 m/s in 0.01 to 100 times `half` (m)."""
    count = int(rng.integers(1, 5))
    relaxed = 1.0 / _log(rng, math.log10(1.2), math.log10(SOFTEST))
    shares = rng.dirichlet(np.ones(count)) * (1.0 - relaxed)
    return replace(body, relaxation=tuple((max(float(share), 1e-4), half * _log(rng, -2.0, 2.0)) for share in shares))


def _warm(rng: np.random.Generator, body: Material) -> Material:
    constants = {"conductivity": _log(rng, -0.7, 1.7), "expansion": _log(rng, -6.0, -4.0), "diffusivity": _log(rng, -7.0, -5.0)}
    return replace(body, **constants, layers=tuple(replace(layer, **constants) for layer in body.layers))

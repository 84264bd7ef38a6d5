"""Seeded contacts as they occur: ellipses from 1:10 to 10:1, creepage around saturation, ordinary materials and heat."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.special import elliprd

from thermoroll_cli.one_contact.refinement.expected_heat import bulge_bound
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Problem

HEATED_SHARE, DEFORMED_SHARE, DISSIMILAR_SHARE, FORCED_SHARE, SPIN_SHARE = 0.7, 0.4, 0.2, 0.15, 0.3
LARGEST_BULGE = 0.2
"""Largest bulge over the approach: moderate heat (the stress generator draws what lies beyond)."""


def random_contact(seed: int) -> Problem:
    """The contact of `seed`, always the same: a/b from 0.1 to 10, creepage from 0.02 to 20 times saturation."""
    rng = np.random.default_rng([7, seed])
    heated = bool(rng.random() < HEATED_SHARE)
    lower = _material(rng, heated)
    upper = lower
    if rng.random() < DISSIMILAR_SHARE:
        upper = replace(_material(rng, heated), youngs_modulus=lower.youngs_modulus * _log(rng, -1.0, 1.0))
    problem = Problem(lower, upper, _geometry(rng), _log(rng, 1.0, 5.0), Friction(float(rng.uniform(0.05, 0.6))),
                      Motion(1.0, differential_slip=False))
    problem = replace(problem, heating=_heating(rng) if heated else Heating(heat=False))
    problem = replace(problem, motion=random_motion(rng, problem))
    return warmed(rng, problem) if heated else problem


def _material(rng: np.random.Generator, heated: bool) -> Material:
    thermal = (_log(rng, 0.5, 2.5), _log(rng, 0.5, 1.5) * 1e-6, 1e-5) if heated else (None, None, None)
    return Material(_log(rng, 0.0, 2.5) * 1e9, float(rng.uniform(0.0, 0.48)), *thermal)


def _geometry(rng: np.random.Generator) -> Geometry:
    aspect, radius = (_log(rng, -1.0, 1.0) if rng.random() < 0.8 else 1.0), _log(rng, -2.0, 0.0)
    ratio = float(elliprd(0.0, 1.0 / aspect, aspect) / elliprd(0.0, aspect, 1.0 / aspect))  # of the curvatures (Hertz)
    return Geometry(radius / math.sqrt(ratio), radius * math.sqrt(ratio), math.inf, math.inf)


def random_motion(rng: np.random.Generator, problem: Problem) -> Motion:
    """Creepages from 0.02 to 20 times saturation along, across or in any direction, some with spin, some with a force."""
    derived = DerivedQuantities(problem)
    size = derived.saturation_creepage * _log(rng, math.log10(0.02), math.log10(20.0))
    angle = float(rng.choice([0.0, math.pi / 2.0, rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.0, 2.0 * math.pi)]))
    spin = size * float(rng.choice([-1.0, 1.0])) * _log(rng, -0.5, 0.5) / derived.scales.mean_radius
    motion = Motion(1.0, size * math.cos(angle), size * math.sin(angle), spin if rng.random() < SPIN_SHARE else 0.0,
                    differential_slip=False)
    if rng.random() < FORCED_SHARE:
        # Spin leaves no room for a force close to the limit.
        share = rng.uniform(0.05, 0.9) if motion.spin == 0.0 else rng.uniform(0.05, 0.3)
        motion = replace(motion, creepage_x=None, creepage_y=0.0, force_x=float(share) * problem.traction_limit)
    return motion


def _heating(rng: np.random.Generator) -> Heating:
    peclet = ("rolling", "rolling", "sliding", "stationary")[int(rng.integers(4))]
    partition = "matched" if rng.random() < 0.3 else float(rng.choice([0.5, rng.uniform()]))
    bulk = float(rng.choice([-1.0, 1.0])) * _log(rng, 0.0, 2.0) if partition == "matched" and rng.random() < 0.3 else 0.0
    return Heating(True, bool(rng.random() < DEFORMED_SHARE), peclet, partition, 0.0, bulk)


def warmed(rng: np.random.Generator, problem: Problem) -> Problem:
    """The contact at Péclet numbers from 0.1 to 1000, with an expansion that bulges it by up to `LARGEST_BULGE`."""
    number, spread = _log(rng, -1.0, 3.0), _log(rng, -0.5, 0.5)
    length, speed = DerivedQuantities(problem).hertz.semi_axis_x, problem.motion.speed
    lower = replace(problem.lower, diffusivity=speed * length / number)
    upper = lower if problem.upper is problem.lower else replace(problem.upper, diffusivity=speed * length / (number * spread))
    problem = replace(problem, lower=lower, upper=upper)
    derived = DerivedQuantities(problem)
    bound = bulge_bound(derived)
    wanted = _log(rng, -4.0, math.log10(LARGEST_BULGE))
    if bound == 0.0 or not problem.heating.deformation:
        return problem
    factor = wanted * derived.scales.approach / bound
    lower, upper = (replace(body, expansion=(body.expansion or 0.0) * factor) for body in (problem.lower, problem.upper))
    return replace(problem, lower=lower, upper=upper)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    """10 to a power between `low` and `high`, each as likely."""
    return float(10.0 ** rng.uniform(low, high))

"""Seeded line contacts: cylinders alike and unlike, coated or relaxing, with friction that depends on slip and interlayers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import random_contact, random_motion, warmed
from scripts.stress.random_friction import random_friction, random_rising, random_yield
from scripts.stress.random_layers import random_hot_layers, random_layers
from scripts.stress.random_relaxing import random_relaxing
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Problem

LENGTH = 0.01
"""Length (m) over which the load of a contact is spread."""
CONVEX_SHARE = 0.5
"""Share of line contacts of two convex cylinders; the others have a flat or a concave body."""


def random_line(seed: int) -> Problem:
    """The line contact of `seed`: a quarter each with plain friction, friction that falls or rises with slip, and a yielding
    interlayer."""
    of_friction = (None, random_friction, random_rising, random_yield)[seed % 4]
    return _plain(seed) if of_friction is None else of_friction(seed, _plain)


def _plain(seed: int) -> Problem:
    """The materials, friction, load and heat of a random contact, between cylinders."""
    rng, contact = np.random.default_rng([47, seed]), random_contact(170000 + seed)
    radius = contact.geometry.lower_radius_x
    other = radius * 10.0 ** float(rng.uniform(0.1, 1.0)) if rng.random() < CONVEX_SHARE else float(
        rng.choice([math.inf, -radius * 10.0 ** float(rng.uniform(0.1, 1.0))]))
    problem = replace(contact, geometry=Geometry(radius, math.inf, other, math.inf), normal_force=contact.normal_force / LENGTH,
                      heating=replace(contact.heating, peclet="rolling"))
    problem = replace(problem, motion=replace(random_motion(rng, problem), spin=0.0))
    return warmed(rng, problem) if problem.heating.heat else problem


def random_line_of_bodies(seed: int) -> Problem:
    """The line contact of `seed` of coated bodies, of coated ones with heat, or of bodies that relax: those of a random
    contact with its longitudinal radius, under the load of its middle."""
    rng, draw = np.random.default_rng([53, seed]), (random_layers, random_hot_layers, random_relaxing)[seed % 3]
    contact = draw(180000 + seed)
    scales, given = DerivedQuantities(contact).scales, contact.geometry
    load = 0.5 * math.pi * scales.peak_pressure * scales.semi_axis_x
    geometry = Geometry(1.0 / given.curvature_x, math.inf, math.inf, math.inf)
    problem = replace(contact, geometry=geometry, normal_force=load, heating=replace(contact.heating, peclet="rolling"))
    return replace(problem, motion=replace(random_motion(rng, problem), spin=0.0, speed=contact.motion.speed))

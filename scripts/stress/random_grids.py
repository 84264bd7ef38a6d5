"""Seeded contacts on grids and depths as few would choose them: slender grids, few depths below the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import random_contact
from scripts.stress.random_friction import random_strength
from thermoroll_cli.problem.problem import Numerics, Problem

SIDE, MOST_SLENDER = 32, 8.0
DEPTHS = (6, 12)


def slender_grid(seed: int) -> Problem:
    """The contact of `seed` with about `SIDE`² elements, along rolling up to eight times as many or as few as across it."""
    rng = np.random.default_rng([31, seed])
    ratio = MOST_SLENDER ** float(rng.uniform(-0.5, 0.5))
    return replace(random_contact(150000 + seed), numerics=Numerics((round(SIDE * ratio), round(SIDE / ratio))))


def few_depths(seed: int) -> Problem:
    """The contact of `seed` with strength and stresses at four to twelve depths."""
    rng, problem = np.random.default_rng([37, seed]), random_strength(170000 + seed)
    assert problem.subsurface is not None
    below = replace(problem.subsurface, layers=int(rng.integers(*DEPTHS, endpoint=True)))
    return replace(problem, wear=None, subsurface=below)

"""The scaling laws of rolling contact, and the coordinates of a table: direction and magnitude of the creepages.

For bodies of the same elasticity the forces depend on a/b, ν and

    ξ' = ξ G a b/(μW),   η' = η G a b/(μW),   φ' = φ G (a b)^(3/2)/(μW)

alone (G the combined shear modulus). With X = ξ' C11/3, Y = η' C22/3, Z = φ' sqrt(C23² + C33²)/2.5 and Kalker's coefficients,
contacts of any shape begin to slide as a whole near m = |(X, Y, Z)| = 1. Coordinates are the magnitude u in 0 … 1,
m = u/(1 − u), and the direction α = atan2(Y, X), sin β = Z/m. Reversing all creepages reverses all forces, and the mirror image
in y = 0 reverses η, φ, F_y and M_z: so X ≥ 0 and Y ≥ 0 tell the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermoroll_cli.exact.kalker import CreepageCoefficients, creepage_coefficients
from thermoroll_cli.kernels.arrays import Array

LAW = "1"
"""Raised whenever a table of another scaling would be misread."""
NEAR_PURE_SPIN = 0.05
"""How much closer than on the average the directions lie to pure spin: 1 − π times this."""
SATURATION, SATURATION_SPIN = 3.0, 2.5


@dataclass(frozen=True)
class TableCoordinates:
    """Magnitude `u` (0 … 1), and directions `v` (0 … 1 for α = 0 … 90°) and `w` (−1 … 1 for β = −90° … 90°)."""

    u: Array
    v: Array
    w: Array


def slopes(aspect_ratio: float, poisson_ratio: float) -> CreepageCoefficients:
    """The forces' slopes at zero creepage."""
    return creepage_coefficients(aspect_ratio, poisson_ratio)


def scales(coefficients: CreepageCoefficients) -> tuple[float, float, float]:
    """X/ξ', Y/η', Z/φ'."""
    c = coefficients
    return c.c11 / SATURATION, c.c22 / SATURATION, float(np.hypot(c.c23, c.c33)) / SATURATION_SPIN


def magnitude(u: Array | float) -> Array:
    """m of u < 1."""
    return np.asarray(u / (1.0 - u))


def spin_angle(w: Array | float) -> Array:
    """β in rad of w: odd about w = ±1, too, so that directions go smoothly over the pole."""
    return np.asarray(0.5 * np.pi * (w + NEAR_PURE_SPIN * np.sin(np.pi * w)))


def spin_coordinate(beta: Array) -> Array:
    """w of β in rad, by Newton's method."""
    wanted = np.asarray(beta) / (0.5 * np.pi)
    w = wanted.copy()
    for _ in range(6):
        w -= (w + NEAR_PURE_SPIN * np.sin(np.pi * w) - wanted) / (1.0 + np.pi * NEAR_PURE_SPIN * np.cos(np.pi * w))
    return np.clip(w, -1.0, 1.0)


def directions(v: Array | float, w: Array | float) -> Array:
    """Unit vectors (X, Y, Z)/m as (3, …)."""
    alpha, beta = 0.5 * np.pi * np.asarray(v), spin_angle(np.asarray(w))
    return np.stack(np.broadcast_arrays(np.cos(beta) * np.cos(alpha), np.cos(beta) * np.sin(alpha), np.sin(beta)))


def coordinates(x: Array, y: Array, z: Array) -> TableCoordinates:
    """Of X ≥ 0, Y ≥ 0 and Z. Zero creepage gets the direction of pure longitudinal creepage."""
    plane = np.hypot(x, y)
    m = np.hypot(plane, z)
    return TableCoordinates(m / (1.0 + m), np.arctan2(y, x) / (0.5 * np.pi), spin_coordinate(np.arctan2(z, plane)))

"""The scaling laws of rolling contact, and the coordinates of a table: direction and magnitude of the creepages.

For bodies of the same elasticity the forces depend on a/b, ν and

    ξ' = ξ G a b/(μW),   η' = η G a b/(μW),   φ' = φ G (a b)^(3/2)/(μW)

alone (G the combined shear modulus). With X = ξ' C11/3, Y = η' C22/3, Z = φ' sqrt(C23² + C33²)/2.5 and Kalker's coefficients,
contacts of any shape begin to slide as a whole near m = |(X, Y, Z)| = 1. Coordinates are the magnitude u(m) in 0 … 1 and the
direction α = atan2(Y, X), sin β = Z/m. Reversing all creepages reverses all forces, and the mirror image in y = 0 reverses
η, φ, F_y and M_z: so X ≥ 0 and Y ≥ 0 determine the rest.

Even steps of u, v and w are small where forces bend: where full sliding begins, towards α = 0 and 90°, and between pure
creepage and pure spin.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from thermoroll_cli.exact.kalker import CreepageCoefficients
from thermoroll_cli.tools.arrays import Array

LAW = "2"
"""Raised whenever a table of another scaling would be misread."""
ONSET, ONSET_SHARE = 0.55, 0.25
"""Full sliding begins around this m, and this share of u is spent there."""
STEEPNESS_AT_ZERO = 1.0 - ONSET_SHARE
"""du/dm at m = 0."""
PLANE_WAVE = 0.3
"""Amplitude of the wave by which directions are denser towards α = 0 and 90°: where a slender contact has its pivot inside it,
forces across change within a few degrees."""
SPIN_WAVES = (0.1, 0.12)
"""Amplitudes of the waves of once and twice a turn by which directions are sparser towards no spin: with this density at β."""
SATURATION, SATURATION_SPIN = 3.0, 2.5


def scales(coefficients: CreepageCoefficients) -> tuple[float, float, float]:
    """X/ξ', Y/η', Z/φ'."""
    c = coefficients
    return c.c11 / SATURATION, c.c22 / SATURATION, float(np.hypot(c.c23, c.c33)) / SATURATION_SPIN


def magnitude_coordinate(m: Array) -> Array:
    """u of m: (1 − s) m/(1 + m) + s m³/(m³ + c³), with s and c the `ONSET_SHARE` and `ONSET`."""
    cube = (m / ONSET) ** 3
    return np.asarray(STEEPNESS_AT_ZERO * (m / (1.0 + m)) + ONSET_SHARE * (cube / (1.0 + cube)))


def magnitude(u: Array | float) -> Array:
    """m of u < 1."""
    share = _inverse(lambda q: magnitude_coordinate(q / (1.0 - q)), np.asarray(u, dtype=float), 1.0)
    return np.asarray(share / (1.0 - share))


def plane_coordinate(alpha: Array) -> Array:
    """v of α in rad: odd about α = 0 and 90°."""
    return np.asarray(alpha / (0.5 * np.pi) + PLANE_WAVE / (2.0 * np.pi) * np.sin(4.0 * alpha))


def plane_angle(v: Array | float) -> Array:
    """α in rad of v."""
    return _inverse(plane_coordinate, np.asarray(v, dtype=float), 0.5 * np.pi)


def spin_coordinate(beta: Array) -> Array:
    """w of β in rad: odd about β = 0 and ±90°, so that directions go smoothly over the pole."""
    turns, (once, twice) = beta / (0.5 * np.pi), SPIN_WAVES
    sine = np.sin(2.0 * beta)
    # sin 4β = 2 sin 2β cos 2β
    return np.asarray(turns - sine * ((once + twice * np.cos(2.0 * beta)) / np.pi))


def spin_angle(w: Array | float) -> Array:
    """β in rad of w."""
    return np.asarray(np.sign(w) * _inverse(spin_coordinate, np.abs(w), 0.5 * np.pi))


def _inverse(rising: Callable[[Array], Array], wanted: Array, high: float) -> Array:
    """Where the `rising` function, 0 at 0, has the values `wanted`: by bisection between 0 and `high`."""
    below, above = np.zeros_like(wanted), np.full_like(wanted, high)
    for _ in range(60):
        middle = 0.5 * (below + above)
        less = rising(middle) < wanted
        below, above = np.where(less, middle, below), np.where(less, above, middle)
    return below


def directions(v: Array | float, w: Array | float) -> Array:
    """Unit vectors (X, Y, Z)/m as (3, …)."""
    alpha, beta = plane_angle(v), spin_angle(w)
    return np.stack(np.broadcast_arrays(np.cos(beta) * np.cos(alpha), np.cos(beta) * np.sin(alpha), np.sin(beta)))


def coordinates(x: Array, y: Array, z: Array) -> Array:
    """(u, v, w) as (3, n): u in 0 … 1, v in 0 … 1 for α = 0 … 90°, w in −1 … 1 for β = −90° … 90°, at X ≥ 0, Y ≥ 0 and Z. Zero
    creepage gets the direction of pure longitudinal creepage."""
    plane = np.hypot(x, y)
    size = magnitude_coordinate(np.hypot(plane, z))
    return np.stack([size, plane_coordinate(np.arctan2(y, x)), spin_coordinate(np.arctan2(z, plane))])

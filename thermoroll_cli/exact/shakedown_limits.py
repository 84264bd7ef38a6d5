"""Elastic and shakedown limits of rolling and sliding contacts: the curves of shakedown maps.

A contact with the largest pressure p₀ and tractions μp in the direction of rolling all over it, ν = 0.3; limits are p₀ over the
shear yield stress k. Those of the circular contact are by von Mises' criterion, with residual stresses that depend on
depth alone (quadratures of Boussinesq's and Cerruti's stresses). Those of the line contact are Johnson's, by Tresca's criterion
(Contact Mechanics 1985, Sec. 9.2): the orthogonal shear, which no residual stress changes, governs until the surface yields at
p₀/k = 1/μ.
"""

from __future__ import annotations

import math

import numpy as np
import scipy

from thermoroll_cli.tools.arrays import Array

FRICTION = np.array([0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6])
"""|F|/W of the curves of the circular contact."""
CIRCLE_ELASTIC = np.array([2.7937, 2.7886, 2.7739, 2.7496, 2.7164, 2.6747, 2.6255, 2.5352, 2.2829, 1.8885, 1.5984])
"""p₀/k up to which a circular contact stays elastic, by von Mises."""
CIRCLE_SHAKEDOWN = np.array([4.6321, 4.3874, 4.1292, 3.8954, 3.6838, 3.4911, 3.3152, 2.8574, 2.5002, 2.0002, 1.6668])
"""p₀/k up to which it shakes down, by von Mises."""


def line_shakedown(friction: float) -> float:
    """p₀/k up to which a line contact shakes down, by Tresca: the least of 1/max |σ_xz|/p₀ below and 1/μ at the surface."""

    def shear(place: Array) -> float:
        stress = line_shear(float(place[0]), abs(float(place[1])), friction)
        return -abs(stress)

    smallest = min(scipy.optimize.minimize(shear, start, method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-12}).fun
                for start in ((-0.85, 0.5), (0.85, 0.5)))
    return float(min(-1.0 / smallest, 1.0 / friction if friction > 0.0 else math.inf))


def line_shear(x: float, z: float, friction: float) -> float:
    """σ_xz/p₀ at (x, z) below a line contact of half-width 1 with the pressure √(1 − x²) and `friction` times it along x.

    McEwen's closed form (Johnson, Eq. 4.49, and 8.3 for the traction)."""
    t = 1.0 - x * x + z * z
    root = math.hypot(t, 2.0 * x * z)
    m = math.sqrt(max(0.5 * (root + t), 1e-300))
    n = math.copysign(math.sqrt(max(0.5 * (root - t), 0.0)), x)
    ratio = (m * m - z * z) / (m * m + n * n)
    normal = -n * ratio
    # The traction's σ_xz is the pressure's σ_xx, over μ.
    tangential = -(m * (1.0 + (z * z + n * n) / (m * m + n * n)) - 2.0 * z)
    return normal + friction * tangential

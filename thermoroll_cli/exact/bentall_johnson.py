"""Free rolling of cylinders of different materials (Bentall & Johnson, Int. J. Mech. Sci. 9, 1967), low friction.

Pressure shrinks the two surfaces differently: ∂u_x/∂x = K p with K = ½[(1−2ν₁)/G₁ − (1−2ν₂)/G₂]. Where the friction
is too small to resist (μ ≪ κ), the contact slips everywhere, with the Hertz pressure, at

    ṡ/V = ξ − K p,     K p = κ a/(2R) sqrt(1 − x²/a²),     κ = [(1−2ν₁)/G₁ − (1−2ν₂)/G₂] / [(1−ν₁)/G₁ + (1−ν₂)/G₂],

and the traction is τ = μp sign(ṡ). It changes sign at x = ±x₁; no net force (free rolling) asks for
asin(x₁/a) + (x₁/a) sqrt(1 − x₁²/a²) = π/4, x₁ = 0.40397 a, so that

    ξ = ½ sqrt(1 − x₁²/a²) κ a/R = 0.4574 κ a/R.

1/R is the relative curvature; κ is twice Dundurs' β. Body 1 is the lower one and ξ its creepage over body 2, as
everywhere in this program: the softer body (κ > 0 if it is body 1) creeps ahead.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

SLIP_REVERSAL = 0.4039727532995173
"""x₁/a, where the slip changes sign in free rolling."""

FREE_ROLLING_COEFFICIENT = 0.5 * math.sqrt(1.0 - SLIP_REVERSAL**2)
"""0.4574: free-rolling creepage in κ a/R."""


def material_mismatch(
    shear_modulus_1: float, poisson_ratio_1: float, shear_modulus_2: float, poisson_ratio_2: float
) -> float:
    """Bentall & Johnson's κ of the module's docstring, dimensionless, in (−1, 1); positive if body 1 is the softer one.

    Aluminium on steel (G = 23 and 82 GPa, ν = 0.31 and 0.28): 0.2877.
    """
    difference = (1.0 - 2.0 * poisson_ratio_1) / shear_modulus_1 - (1.0 - 2.0 * poisson_ratio_2) / shear_modulus_2
    return difference / ((1.0 - poisson_ratio_1) / shear_modulus_1 + (1.0 - poisson_ratio_2) / shear_modulus_2)


def free_rolling_creepage(mismatch: float, half_width: float, relative_curvature: float) -> float:
    """Creepage ξ = 0.4574 κ a/R of free rolling in the limit of low friction.

    Parameters: κ of `material_mismatch`, contact half-width a (m), relative curvature 1/R (1/m).
    """
    return FREE_ROLLING_COEFFICIENT * mismatch * half_width * relative_curvature


def low_friction_slip(
    x: ArrayLike, creepage: float, mismatch: float, half_width: float, relative_curvature: float
) -> NDArray[np.float64]:
    """Slip velocity over rolling speed ṡ/V = ξ − κ a/(2R) sqrt(1 − x²/a²) in the limit of low friction; shape of x.

    The traction is μp times its sign. Zero outside the contact.
    """
    x = np.asarray(x, dtype=float) / half_width
    shrinkage = 0.5 * mismatch * half_width * relative_curvature * np.sqrt(np.maximum(1.0 - x**2, 0.0))
    return np.asarray(np.where(np.abs(x) <= 1.0, creepage - shrinkage, 0.0))

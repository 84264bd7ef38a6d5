"""Rolling of two cylinders, plane strain: tractive rolling of similar bodies, free rolling of different materials.

Conventions of this program: material flows towards +x, body 1 is the lower one and ξ its creepage over body 2; 1/R is the
relative curvature.

**Tractive rolling** (Carter 1926; Johnson, Contact Mechanics 1985, Sec. 8.3). The stick zone of half-width a' begins at the
leading edge x = −a and is centred on x = −d, d = a − a'. With N the load per length, ξ > 0:

    ξ        = μ(a − a')/R                                                              creepage
    F/(μN)   = 1 − (a'/a)²                                                              force
    τ(x)     = μp0 [sqrt(1 − x²/a²) − (a'/a) sqrt(1 − (x + d)²/a'²)]                    traction
    ṡ(x)/V   = (μ/R) sqrt((x + d)² − a'²)  in the slip zone, 0 in the stick zone        slip velocity
    Q        = ∫ τ ṡ dx = V ξ F                                                         heat per length

The slip follows from ṡ/V = ξ − ∂u/∂x, ∂u/∂x = −2/(πE*) PV∫ τ(x')/(x − x') dx'. If ξ ≥ μa/R everything slips:
τ = μp and ṡ/V = ξ + μx/R. A negative creepage changes the sign of τ, ṡ and F.

**Free rolling of different materials** (Bentall & Johnson, Int. J. Mech. Sci. 9, 1967), low friction. Pressure shrinks the two
surfaces differently: ∂u_x/∂x = K p with K = ½[(1−2ν₁)/G₁ − (1−2ν₂)/G₂]. Where the friction is too small to resist (μ ≪ κ), the
contact slips everywhere, with the Hertz pressure, at

    ṡ/V = ξ − K p,     K p = κ a/(2R) sqrt(1 − x²/a²),     κ = [(1−2ν₁)/G₁ − (1−2ν₂)/G₂] / [(1−ν₁)/G₁ + (1−ν₂)/G₂],

and the traction is τ = μp sign(ṡ). It changes sign at x = ±x₁; no net force (free rolling) asks for
asin(x₁/a) + (x₁/a) sqrt(1 − x₁²/a²) = π/4, x₁ = 0.40397 a, so that

    ξ = ½ sqrt(1 − x₁²/a²) κ a/R = 0.4574 κ a/R.

κ is twice Dundurs' β. The softer body (κ > 0 if it is body 1) creeps ahead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from thermoroll_cli.exact.hertz import LineContact, check_positive
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class CarterContact:
    """Steady tractive rolling of cylinders: the Hertz `contact`, the `friction` coefficient μ and the `creepage` ξ.

    Made by `carter` (from a creepage) or `carter_from_force`.
    """

    contact: LineContact
    friction: float
    creepage: float

    @property
    def stick_half_width(self) -> float:
        """Half-width a' of the stick zone (m), zero in full sliding."""
        return max(self.contact.half_width - abs(self.creepage) / (self.friction * self.contact.curvature), 0.0)

    @property
    def stick_zone(self) -> tuple[float, float]:
        """Ends (m) of the stick zone: it begins at the leading edge −a."""
        return -self.contact.half_width, -self.contact.half_width + 2.0 * self.stick_half_width

    @property
    def force(self) -> float:
        """Tangential force per length F = ∫ τ dx (N/m), of the sign of the creepage."""
        limit = self.friction * self.contact.load_per_length
        return math.copysign(limit * (1.0 - (self.stick_half_width / self.contact.half_width) ** 2), self.creepage)

    def traction(self, x: ArrayLike) -> Array:
        """Traction τ(x) along the slip of body 1 relative to body 2 (Pa), zero outside the contact."""
        x = np.asarray(x, dtype=float)
        a, stick = self.contact.half_width, self.stick_half_width
        # both roots have the factor sqrt(x + a): taken out, they do not cancel at the leading edge
        roots = np.sqrt(np.maximum(a - x, 0.0)) - np.sqrt(np.maximum(2.0 * stick - x - a, 0.0))
        roots *= np.sqrt(np.maximum(x + a, 0.0))
        return np.asarray(math.copysign(self.friction * self.contact.peak_pressure / a, self.creepage) * roots)

    def slip(self, x: ArrayLike) -> Array:
        """Slip velocity over rolling speed ṡ/V of body 1 relative to body 2 in the contact, zero outside of it."""
        x = np.asarray(x, dtype=float)
        a, stick = self.contact.half_width, self.stick_half_width
        steepness = self.friction * self.contact.curvature
        if stick > 0.0:
            slip = steepness * np.sqrt(np.maximum(x + a, 0.0) * np.maximum(x + a - 2.0 * stick, 0.0))
        else:
            slip = abs(self.creepage) + steepness * x
        return np.asarray(math.copysign(1.0, self.creepage) * np.where(np.abs(x) <= a, slip, 0.0))

    def heat_flux(self, x: ArrayLike, speed: float) -> Array:
        """Frictional heat q = τ ṡ (W/m²) at the rolling speed V (m/s), into both bodies together."""
        return np.asarray(speed * self.traction(x) * self.slip(x))

    def heat(self, speed: float) -> float:
        """Total heat per length Q = V ξ F (W/m)."""
        return speed * self.creepage * self.force


def carter(contact: LineContact, friction: float, creepage: float) -> CarterContact:
    """Tractive rolling at a given creepage ξ (equations in the module's docstring).

    Raises ValueError if the friction coefficient is not positive or the creepage is not finite.
    """
    check_positive(friction=friction)
    if not math.isfinite(creepage):
        raise ValueError(f"creepage must be finite, got {creepage!r}")
    return CarterContact(contact, friction, creepage)


def saturation_creepage(contact: LineContact, friction: float) -> float:
    """Creepage μa/R from which on the whole contact slips."""
    return friction * contact.half_width * contact.curvature


SLIP_REVERSAL = 0.4039727532995173
"""x₁/a, where the slip changes sign in free rolling."""

FREE_ROLLING_COEFFICIENT = 0.5 * math.sqrt(1.0 - SLIP_REVERSAL**2)
"""0.4574: free-rolling creepage in κ a/R."""


def material_mismatch(shear_modulus_1: float, poisson_ratio_1: float, shear_modulus_2: float, poisson_ratio_2: float) -> float:
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


def low_friction_slip(x: ArrayLike, creepage: float, mismatch: float, half_width: float, relative_curvature: float) -> Array:
    """Slip velocity over rolling speed ṡ/V = ξ − κ a/(2R) sqrt(1 − x²/a²) in the limit of low friction; shape of x.

    The traction is μp times its sign. Zero outside the contact.
    """
    x = np.asarray(x, dtype=float) / half_width
    shrinkage = 0.5 * mismatch * half_width * relative_curvature * np.sqrt(np.maximum(1.0 - x**2, 0.0))
    return np.asarray(np.where(np.abs(x) <= 1.0, creepage - shrinkage, 0.0))

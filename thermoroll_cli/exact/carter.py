"""Tractive rolling of two similar cylinders, plane strain (Carter 1926; Johnson, Contact Mechanics 1985, Sec. 8.3).

Conventions of this program: material flows towards +x, so the stick zone of half-width a' begins at the leading edge
x = −a and is centred on x = −d, d = a − a'. With 1/R the relative curvature, N the load per length, ξ > 0:

    ξ        = μ(a − a')/R                                                              creepage
    F/(μN)   = 1 − (a'/a)²                                                              force
    τ(x)     = μp0 [sqrt(1 − x²/a²) − (a'/a) sqrt(1 − (x + d)²/a'²)]                    traction
    ṡ(x)/V   = (μ/R) sqrt((x + d)² − a'²)  in the slip zone, 0 in the stick zone        slip velocity
    Q        = ∫ τ ṡ dx = V ξ F                                                         heat per length

The slip follows from ṡ/V = ξ − ∂u/∂x, ∂u/∂x = −2/(πE*) PV∫ τ(x')/(x − x') dx'. If ξ ≥ μa/R everything slips:
τ = μp and ṡ/V = ξ + μx/R. A negative creepage changes the sign of τ, ṡ and F.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thermoroll_cli.exact.hertz import LineContact

FloatArray = NDArray[np.float64]


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

    def traction(self, x: ArrayLike) -> FloatArray:
        """Traction τ(x) along the slip of body 1 relative to body 2 (Pa), zero outside the contact."""
        x = np.asarray(x, dtype=float)
        a, stick = self.contact.half_width, self.stick_half_width
        # both roots have the factor sqrt(x + a): taken out, they do not cancel at the leading edge
        roots = np.sqrt(np.maximum(a - x, 0.0)) - np.sqrt(np.maximum(2.0 * stick - x - a, 0.0))
        roots *= np.sqrt(np.maximum(x + a, 0.0))
        return np.asarray(math.copysign(self.friction * self.contact.peak_pressure / a, self.creepage) * roots)

    def slip(self, x: ArrayLike) -> FloatArray:
        """Slip velocity over rolling speed ṡ/V of body 1 relative to body 2 in the contact, zero outside of it."""
        x = np.asarray(x, dtype=float)
        a, stick = self.contact.half_width, self.stick_half_width
        steepness = self.friction * self.contact.curvature
        if stick > 0.0:
            slip = steepness * np.sqrt(np.maximum(x + a, 0.0) * np.maximum(x + a - 2.0 * stick, 0.0))
        else:
            slip = abs(self.creepage) + steepness * x
        return np.asarray(math.copysign(1.0, self.creepage) * np.where(np.abs(x) <= a, slip, 0.0))

    def heat_flux(self, x: ArrayLike, speed: float) -> FloatArray:
        """Frictional heat q = τ ṡ (W/m²) at the rolling speed V (m/s), into both bodies together."""
        return np.asarray(speed * self.traction(x) * self.slip(x))

    def heat(self, speed: float) -> float:
        """Total heat per length Q = V ξ F (W/m)."""
        return speed * self.creepage * self.force


def carter(contact: LineContact, friction: float, creepage: float) -> CarterContact:
    """Tractive rolling at a given creepage ξ (equations in the module's docstring).

    Raises ValueError if the friction coefficient is not positive or the creepage is not finite.
    """
    _require_friction(friction)
    if not math.isfinite(creepage):
        raise ValueError(f"creepage must be finite, got {creepage!r}")
    return CarterContact(contact, friction, creepage)


def carter_from_force(contact: LineContact, friction: float, force: float) -> CarterContact:
    """Tractive rolling under a given tangential force per length (N/m): ξ = (μa/R) [1 − sqrt(1 − |F|/(μN))].

    Raises ValueError if the friction coefficient is not positive or |F| exceeds μN.
    """
    _require_friction(friction)
    limit = friction * contact.load_per_length
    if not abs(force) <= limit:
        raise ValueError(f"force = {force!r} exceeds the friction limit {limit!r}: the cylinders slide")
    share = abs(force) / limit
    # 1 − sqrt(1 − share) without cancellation for small forces
    creepage = saturation_creepage(contact, friction) * share / (1.0 + math.sqrt(1.0 - share))
    return CarterContact(contact, friction, math.copysign(creepage, force))


def saturation_creepage(contact: LineContact, friction: float) -> float:
    """Creepage μa/R from which on the whole contact slips."""
    return friction * contact.half_width * contact.curvature


def _require_friction(friction: float) -> None:
    if not (math.isfinite(friction) and friction > 0.0):
        raise ValueError(f"friction must be positive and finite, got {friction!r}")

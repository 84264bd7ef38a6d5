"""Tangential loading of a circular Hertz contact without rolling (Cattaneo 1938, Mindlin 1949).

Johnson, Contact Mechanics (1985), Secs. 3.7 and 7.2(d). A traction τ = τ0 sqrt(1 − r²/a²) along x on a half-space
(G, ν) moves the surface inside r ≤ a by

    u_x = πτ0/(32Ga) [4(2−ν)a² − (4−3ν)x² − (4−ν)y²],     u_y = πτ0/(32Ga) 2ν x y,

and outside, with s = asin(a/r), t = (a/r) sqrt(1 − a²/r²),

    u_x = τ0/(8Ga) {(2−ν)[(2a²−r²)s + r²t] + (ν/2) [r²s + (2a²−r²)t] (x²−y²)/r²}
    u_y = τ0/(8Ga)  ν [r²s + (2a²−r²)t] x y/r².

Partial slip is the difference of two such tractions, of radius a and of the stick radius c. The bodies are taken as
elastically similar (pressure and traction do not interact) and the lateral displacement, of order ν, is not opposed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from thermoroll_cli.exact.hertz import check_positive
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class CattaneoMindlin:
    """A circular Hertz contact under a tangential force along x below the friction limit.

    Fields: `radius` = a and `stick_radius` = c of the contact and of the stick circle (m), `peak_traction` = μp0 (Pa),
    `force_x` (N), `force_limit` = μW (N). Made by `cattaneo_mindlin`. With force_x < 0 everything changes sign.
    """

    radius: float
    stick_radius: float
    peak_traction: float
    force_x: float
    force_limit: float

    def traction(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Traction τ_x = μp0 [sqrt(1 − r²/a²) − (c/a) sqrt(1 − r²/c²)], each root zero beyond its radius (Pa)."""
        rr = np.asarray(x, dtype=float) ** 2 + np.asarray(y, dtype=float) ** 2
        roots = np.sqrt(np.maximum(self.radius**2 - rr, 0.0)) - np.sqrt(np.maximum(self.stick_radius**2 - rr, 0.0))
        return np.asarray(math.copysign(self.peak_traction / self.radius, self.force_x) * roots)

    def displacement(self, x: ArrayLike, y: ArrayLike, shear_modulus: float, poisson_ratio: float) -> tuple[Array, Array]:
        """Surface displacements (u_x, u_y) of one body of the given constants (m), anywhere on the surface.

        Inside the stick circle u_x is uniform and u_y vanishes. Broadcasts x and y.
        """
        sign = math.copysign(1.0, self.force_x)
        u_x, u_y = full_slip_displacement(x, y, self.radius, sign * self.peak_traction, shear_modulus, poisson_ratio)
        if self.stick_radius > 0.0:
            inner_peak = -sign * self.peak_traction * self.stick_radius / self.radius
            v_x, v_y = full_slip_displacement(x, y, self.stick_radius, inner_peak, shear_modulus, poisson_ratio)
            u_x, u_y = u_x + v_x, u_y + v_y
        return u_x, u_y

    def shift(self, shear_modulus: float, poisson_ratio: float) -> float:
        """Displacement of the stick circle relative to the remote part of one body (m): the contribution
        3μW(2−ν)/(16Ga) [1 − (c/a)²] of that body to the rigid shift."""
        compliance = 3.0 * (2.0 - poisson_ratio) / (16.0 * shear_modulus * self.radius)
        ratio = self.stick_radius / self.radius
        return math.copysign(self.force_limit * compliance * (1.0 - ratio**2), self.force_x)


def cattaneo_mindlin(radius: float, peak_pressure: float, friction: float, force_x: float) -> CattaneoMindlin:
    """Solve partial slip: c/a = (1 − |F_x|/(μW))^(1/3) with W = (2/3)πa²p0.

    Parameters: contact radius a (m), Hertz peak pressure p0 (Pa), friction coefficient μ, tangential force (N).

    Raises ValueError if a, p0 or μ is not positive, or if |F_x| exceeds μW.
    """
    check_positive(radius=radius, peak_pressure=peak_pressure, friction=friction)
    limit = friction * 2.0 / 3.0 * math.pi * radius**2 * peak_pressure
    if not abs(force_x) <= limit:
        raise ValueError(f"force_x = {force_x!r} exceeds the friction limit {limit!r}: the contact slides")
    stick_radius = radius * math.cbrt(1.0 - abs(force_x) / limit)
    return CattaneoMindlin(radius, stick_radius, friction * peak_pressure, force_x, force_limit=limit)


def full_slip_displacement(
    x: ArrayLike, y: ArrayLike, radius: float, peak_traction: float, shear_modulus: float, poisson_ratio: float
) -> tuple[Array, Array]:
    """Displacements (u_x, u_y) of one half-space under τ_x = τ0 sqrt(1 − r²/a²) (equations in the module's docstring).

    Parameters: positions (m, broadcast against each other), radius a (m), peak traction τ0 (Pa), shear modulus G (Pa)
    and Poisson's ratio ν of that body. The relative displacement of two bodies is the sum of both.
    """
    px, py = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    nu, aa = poisson_ratio, radius**2
    scale = math.pi * peak_traction / (32.0 * shear_modulus * radius)
    u_x = np.asarray(scale * (4.0 * (2.0 - nu) * aa - (4.0 - 3.0 * nu) * px**2 - (4.0 - nu) * py**2))
    u_y = np.asarray(scale * 2.0 * nu * px * py)
    outside = px**2 + py**2 > aa
    if outside.any():
        px, py = px[outside], py[outside]
        rr = px**2 + py**2
        s = np.arcsin(np.sqrt(aa / rr))
        t = np.sqrt(aa / rr * (1.0 - aa / rr))
        scale = peak_traction / (8.0 * shear_modulus * radius)
        isotropic = (2.0 * aa - rr) * s + rr * t
        directed = (rr * s + (2.0 * aa - rr) * t) / rr
        u_x[outside] = scale * ((2.0 - nu) * isotropic + 0.5 * nu * directed * (px**2 - py**2))
        u_y[outside] = scale * nu * directed * px * py
    return u_x, u_y

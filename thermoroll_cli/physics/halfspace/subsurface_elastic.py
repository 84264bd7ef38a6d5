"""Stresses inside an elastic half-space under one uniformly loaded rectangular element, in closed form (Boussinesq, Cerruti).

The element of dx × dy carries a pressure p, or a traction t_x or t_y (force per area on the body). The observation point lies
at depth z ≥ 0 (into the body), x and y are its offsets from an element corner in dx, r² = x² + y² + z². Stresses are
1/2π times the differences between the four corners of

    pressure:  σ_xx = −[A_x + 2ν A_y − xyz/(r(x²+z²))]        σ_zz = −[S + (xyz/r)(1/(x²+z²) + 1/(y²+z²))]
               σ_xy = −[(1−2ν) ln(r+z) + z/r]                 σ_xz = y z²/(r(x²+z²))
    t_x:       σ_xx = 2L_x + 2νy/(r+z) − zy(zr − x²)/(r(x²+z²)(r+z))        σ_zz = y z²/(r(x²+z²))
               σ_yy = 2ν(L_x − y/(r+z)) − zy/(r(r+z))                       σ_yz = −z/r
               σ_xy = L_y − 2νx/(r+z) − zx/(r(r+z))                         σ_xz = −S + xyz/(r(x²+z²))

    S = atan(xy/(zr)),   A_x = atan(xy(x²+y²)/((r+z)(x²r + y²z))),   L_x = asinh(y/√(x²+z²)),

and the others by x ↔ y. These are the integrals of Boussinesq's and Cerruti's point loads over the element (Johnson, Contact
Mechanics, Sec. 3.2, 3.6). The stresses of a surface element are logarithmic on its edges; centres of elements do not lie there.
Signs: tension positive, σ_zz = −p and σ_xz = −t_x at the surface.

An element with dy/dx = inf is a strip without ends, of a line contact, in plane strain and anti-plane shear (Flamant; Johnson,
Sec. 2.5). Its stresses are 1/π times the differences between both edges, with φ = atan(x/z) and ρ² = x² + z², of

    pressure:  σ_xx = xz/ρ² − φ         σ_zz = −xz/ρ² − φ       σ_xz = z²/ρ²
    t_x:       σ_xx = −ln ρ² − z²/ρ²    σ_zz = z²/ρ²            σ_xz = xz/ρ² − φ        σ_yy = ν(σ_xx + σ_zz)
    t_y:       σ_xy = −½ ln ρ²          σ_yz = −φ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from thermoroll_cli.tools.arrays import Array

EXCHANGED_AXES = (1, 0, 2, 3, 5, 4)
"""Indices of the stresses xx yy zz xy xz yz, in this order everywhere, after exchanging x and y."""


def pressure_stress(x: Array, y: Array, z: float, aspect: float, poisson_ratio: float) -> Array:
    """Stresses at depth `z` under an element that carries unit pressure, at the grid of offsets x × y from its centre.

    Lengths are in dx, `aspect` is dy/dx; with inf y is one line. Returns (6, len(x), len(y)), stresses xx yy zz xy xz yz.
    Raises ValueError for a depth that is not finite and ≥ 0 or an aspect that is not positive.
    """
    if math.isinf(aspect):
        return _below_strip(x, z, poisson_ratio, "pressure")
    return between_corners(x, y, z, aspect, lambda corner: corner.of_pressure(poisson_ratio))


def traction_x_stress(x: Array, y: Array, z: float, aspect: float, poisson_ratio: float) -> Array:
    """Stresses at depth `z` under unit traction along x on the body; arguments, result and errors as `pressure_stress`."""
    if math.isinf(aspect):
        return _below_strip(x, z, poisson_ratio, "along")
    return between_corners(x, y, z, aspect, lambda corner: corner.of_traction(poisson_ratio))


def traction_y_stress(x: Array, y: Array, z: float, aspect: float, poisson_ratio: float) -> Array:
    """Stresses at depth `z` under unit traction along y on the body; arguments, result and errors as `pressure_stress`."""
    if math.isinf(aspect):
        return _below_strip(x, z, poisson_ratio, "across")
    return between_corners(x, y, z, aspect, lambda corner: corner.twisted.of_traction(poisson_ratio)[list(EXCHANGED_AXES)])


def _below_strip(x: Array, z: float, poisson_ratio: float, load: Literal["pressure", "along", "across"]) -> Array:
    """Stresses (6, len(x), 1) at depth `z` below a strip with a unit `load`."""
    _check_depth(z)
    edges = np.stack([x - 0.5, x + 0.5])
    square = edges**2 + z**2
    angle, lever, depth, log, zero = (np.diff(part, axis=0)[0] / math.pi for part in (
        np.arctan2(edges, z), edges * z / square, z**2 / square, np.log(square), np.zeros_like(edges)))
    xx, zz, xy, xz, yz = {
        "pressure": (lever - angle, -lever - angle, zero, depth, zero),
        "along": (-log - depth, depth, zero, lever - angle, zero),
        "across": (zero, zero, -0.5 * log, zero, -angle)}[load]
    return np.stack([xx, poisson_ratio * (xx + zz), zz, xy, xz, yz])[:, :, None]


@dataclass(frozen=True)
class Corner:
    """The primitive functions at offsets x (n, 1), y (1, m) from a corner and depth z."""

    x: Array
    y: Array
    z: float

    @property
    def twisted(self) -> Corner:
        """With x and y exchanged; arrays keep their shapes."""
        return Corner(self.y, self.x, self.z)

    @cached_property
    def r(self) -> Array:
        return np.asarray(np.sqrt(self.x**2 + self.y**2 + self.z**2))

    def angle(self) -> Array:
        """A_x, odd in x and in y."""
        x2, y2, r, z = self.x**2, self.y**2, self.r, self.z
        # atan2 takes the magnitudes: the quotient itself is 0/0 only in a corner, where both arguments vanish.
        product = np.abs(self.x) * np.abs(self.y)
        magnitude = np.arctan2(product * (x2 + y2), (r + z) * (x2 * r + y2 * z))
        return np.asarray(np.sign(self.x) * np.sign(self.y) * magnitude)

    def solid_angle(self) -> Array:
        """S, odd in x and in y."""
        product = np.abs(self.x) * np.abs(self.y)
        return np.asarray(np.sign(self.x) * np.sign(self.y) * np.arctan2(product, self.z * self.r))

    def inverse_sine(self) -> Array:
        """L_x, even in x and odd in y."""
        return np.arcsinh(self.y / np.sqrt(self.x**2 + self.z**2))

    def of_pressure(self, nu: float) -> Array:
        x, y, z, r = self.x, self.y, self.z, self.r
        along, across = self.angle(), self.twisted.angle()
        over_x, over_y = 1.0 / (x**2 + z**2), 1.0 / (y**2 + z**2)
        lever = x * y * z / r
        return np.stack([
            lever * over_x - along - 2.0 * nu * across,
            lever * over_y - across - 2.0 * nu * along,
            -self.solid_angle() - lever * (over_x + over_y),
            -(1.0 - 2.0 * nu) * np.log(r + z) - z / r,
            y * z**2 / r * over_x,
            x * z**2 / r * over_y,
        ])

    def of_traction(self, nu: float) -> Array:
        x, y, z, r = self.x, self.y, self.z, self.r
        sine_x, sine_y = self.inverse_sine(), self.twisted.inverse_sine()
        over_x, over_r, over_sum = 1.0 / (x**2 + z**2), 1.0 / r, 1.0 / (r + z)
        return np.stack([
            2.0 * sine_x + 2.0 * nu * y * over_sum - z * y * (z * r - x**2) * over_r * over_x * over_sum,
            2.0 * nu * (sine_x - y * over_sum) - z * y * over_r * over_sum,
            y * z**2 * over_r * over_x,
            sine_y - 2.0 * nu * x * over_sum - z * x * over_r * over_sum,
            x * y * z * over_r * over_x - self.solid_angle(),
            np.broadcast_to(-z * over_r, r.shape),
        ])


def between_corners(x: Array, y: Array, z: float, aspect: float, primitive: Callable[[Corner], Array]) -> Array:
    """1/2π times the differences of `primitive` (6, …) between the corners of the element, at the grid of offsets x × y."""
    _check_depth(z)
    if not (math.isfinite(aspect) and aspect > 0.0):
        raise ValueError(f"the aspect dy/dx must be positive and finite, not {aspect}")
    x_edges, left, right = _edges(x, 1.0)
    y_edges, low, high = _edges(y, aspect)
    at_corner = primitive(Corner(x_edges[:, None], y_edges[None, :], z))
    along = at_corner[:, right] - at_corner[:, left]
    return np.asarray((along[:, :, high] - along[:, :, low]) / (2.0 * math.pi))


def _check_depth(z: float) -> None:
    if not (math.isfinite(z) and z >= 0.0):
        raise ValueError(f"the depth must be finite and not negative, not {z}")


def _edges(centres: Array, length: float) -> tuple[Array, slice | Array, slice | Array]:
    """Offsets from both edges of the source element without repetitions, and the indices of both edges for every point."""
    if len(centres) > 1 and np.allclose(np.diff(centres), length, rtol=0.0, atol=1e-9 * length):
        edges = np.append(centres - 0.5 * length, centres[-1] + 0.5 * length)
        return edges, slice(0, -1), slice(1, None)
    return np.concatenate([centres - 0.5 * length, centres + 0.5 * length]), slice(0, len(centres)), slice(len(centres), None)

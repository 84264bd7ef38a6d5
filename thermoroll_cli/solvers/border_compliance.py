"""What a traction on a partly covered element does beyond the uniform element of the influence coefficients.

Where the contact border cuts an element, the traction acts on the covered part φ only and is that much denser. Near a straight
border with inward normal n the half-space is in plane strain along n and in anti-plane strain along the border, so the missing
gradient of the displacement along the rolling direction is

    K τ = |n_x| [ Σ(1−ν)/G · n nᵀ + Σ 1/G · (I − n nᵀ) ] (1 − φ)/φ · τ

For n along x these are the constants of numerics.md; without the turn of n lateral forces keep an error of first order.
"""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.elastic import ShearCompliance

Array = NDArray[Any]
Mask = NDArray[np.bool_]

SMALLEST_COVER = 1e-3
"""Thinner slivers carry less than 1e-4 of an element's load; a larger compliance would only lose digits."""


class BorderCompliance:
    """K on a bounding box (n, m): `partial` marks partly covered elements, `diagonal` (2, n, m) is that of K.

    `mirrored` tells that the box is the half y > 0 of a contact that is its own mirror image."""

    def __init__(
        self, covered: Array, contact: Mask, dx: float, dy: float, compliance: ShearCompliance, mirrored: bool = False
    ) -> None:
        share = np.clip(np.where(contact, covered, 1.0), SMALLEST_COVER, 1.0)
        self.partial: Mask = share < 1.0
        i, j = self._index = np.nonzero(self.partial)
        around = np.pad(np.where(contact, covered, 0.0), 1)
        if mirrored:
            around[:, 0] = around[:, 1]
        nx, ny = _border_normal(around, i, j, dx, dy)
        scale = np.abs(nx) * (1.0 - share[i, j]) / share[i, j]
        along, across = compliance.along, compliance.across
        self.xx = scale * (along * nx * nx + across * ny * ny)
        self.yy = scale * (along * ny * ny + across * nx * nx)
        self.xy = scale * (along - across) * nx * ny
        self._trailing = nx < 0.0
        self.diagonal = np.zeros((2, *covered.shape))
        self.diagonal[0, i, j], self.diagonal[1, i, j] = self.xx, self.yy

    def in_precision(self, precision: Any) -> BorderCompliance:
        """The same with coefficients of another type."""
        other = copy(self)
        other.xx, other.yy, other.xy = (k.astype(precision) for k in (self.xx, self.yy, self.xy))
        return other

    def add(self, out: Array, traction: Array) -> Array:
        """`out` + K `traction`, in place, both (2, n, m)."""
        i, j = self._index
        tx, ty = traction[0, i, j], traction[1, i, j]
        out[0, i, j] += self.xx * tx + self.xy * ty
        out[1, i, j] += self.xy * tx + self.yy * ty
        return out

    def trailing(self, traction: Array) -> Array:
        """K `traction` of the trailing border only, (2, n, m).

        Where that slips, the traction is at the bound whatever the gradient, and K would only take power from the slip."""
        i, j = (index[self._trailing] for index in self._index)
        xx, yy, xy = (k[self._trailing] for k in (self.xx, self.yy, self.xy))
        tx, ty = traction[0, i, j], traction[1, i, j]
        out = np.zeros_like(traction)
        out[0, i, j], out[1, i, j] = xx * tx + xy * ty, xy * tx + yy * ty
        return out

    def apply(self, traction: Array) -> Array:
        """K `traction`, (2, n, m)."""
        return self.add(np.zeros_like(traction), traction)


def _border_normal(
    c: Array, i: NDArray[np.intp], j: NDArray[np.intp], dx: float, dy: float
) -> tuple[Array, Array]:
    """Unit vector along the steepest change of the covered fraction (Sobel differences) at elements (i, j); `c` holds the
    fractions with one more row and column on all sides."""
    i, j = i + 1, j + 1
    along_x = sum(w * (c[i + 1, j + k] - c[i - 1, j + k]) for k, w in ((-1, 1.0), (0, 2.0), (1, 1.0))) / dx
    along_y = sum(w * (c[i + k, j + 1] - c[i + k, j - 1]) for k, w in ((-1, 1.0), (0, 2.0), (1, 1.0))) / dy
    size = np.hypot(along_x, along_y)
    known = size > 0.0
    safe = np.where(known, size, 1.0)
    # An isolated element has no direction: taken as cut across the rolling direction.
    return np.where(known, along_x / safe, 1.0), np.where(known, along_y / safe, 0.0)

"""What a traction on a partly covered element does beyond the uniform element of the influence coefficients.

Where the contact border cuts an element, the traction acts on the covered part φ only and is that much denser. Near a straight
border with inward normal n the half-space is in plane strain along n and in anti-plane strain along the border, so the missing
gradient of the displacement along the rolling direction is

    K τ = |n_x| [ Σ(1−ν)/G · n nᵀ + Σ 1/G · (I − n nᵀ) ] (1 − φ)/φ · τ

For n along x these are the constants of docs/numerics.md; without the turn of n lateral forces keep an error of first order.
"""

from __future__ import annotations

import math
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import AnyArray, Mask
from thermoroll_cli.halfspace.elastic import ShearCompliance
from thermoroll_cli.numerics.solver_options import RollingOptions
from thermoroll_cli.numerics.stencils import sobel

SOFTEST = 1e20
"""Compliance in 1/Pa beyond which an element carries nothing, whatever its number: products still fit single precision."""


class EdgeCompliance:
    """K on a bounding box (n, m): `partial` marks partly covered elements, `diagonal` (2, n, m) is that of K.

    Where `leading` (3, n, m) is given, what it holds takes the place of K on its elements, which it gives more closely.
    `softest` is then what the operator leaves of an element's own compliance where tractions alternate across (x and y): on
    elements that are long along x that is little, and more must not be taken from it, or rows slip against each other.
    `mirrored` tells that the box is the half y > 0 of a contact that is its own mirror image. `neutral` (n, m) is the
    compliance of elements that a neutral line may cross (`neutral_line`), the same in all directions, and added to K."""

    def __init__(
        self,
        covered: AnyArray,
        contact: Mask,
        dx: float,
        dy: float,
        compliance: ShearCompliance,
        leading: AnyArray | None = None,
        softest: tuple[float, float] = (math.inf, math.inf),
        mirrored: bool = False,
        neutral: AnyArray | None = None,
        options: RollingOptions | None = None,
    ) -> None:
        options = options or RollingOptions()
        share = np.clip(np.where(contact, covered, 1.0), options.smallest_cover, 1.0)
        self.partial: Mask = share < 1.0
        i, j = np.nonzero(self.partial)
        around = np.pad(np.where(contact, covered, 0.0), 1)
        if mirrored:
            around[:, 0] = around[:, 1]
        nx, ny = _border_normal(around, i, j, dx, dy)
        scale = np.abs(nx) * (1.0 - share[i, j]) / share[i, j]
        along, across = compliance.along, compliance.across
        k = np.zeros((3, *covered.shape))
        k[:, i, j] = scale * np.stack([along * nx * nx + across * ny * ny, along * ny * ny + across * nx * nx,
                                       (along - across) * nx * ny])
        trailing = np.zeros(covered.shape, dtype=bool)
        trailing[i, j] = nx < 0.0
        if leading is not None:
            known = leading.any(axis=0) & contact
            trust = min(1.0, softest[0] / (options.deepest * along), softest[1] / (options.deepest * across))
            k[:, known] = (1.0 - trust) * k[:, known] + trust * _limited(leading[:, known], along, across, options)
            trailing &= ~known
        if neutral is not None:
            k[:2] += neutral
        i, j = self._index = np.nonzero(k.any(axis=0))
        self.xx, self.yy, self.xy = k[:, i, j]
        self._trailing = trailing[i, j]
        self.diagonal = k[:2]

    def in_precision(self, precision: Any) -> EdgeCompliance:
        """The same with coefficients of another type."""
        other = copy(self)
        other.xx, other.yy, other.xy = (np.clip(k, -SOFTEST, SOFTEST).astype(precision) for k in (self.xx, self.yy, self.xy))
        return other

    def add(self, out: AnyArray, traction: AnyArray) -> AnyArray:
        """`out` + K `traction`, in place, both (2, n, m)."""
        i, j = self._index
        tx, ty = traction[0, i, j], traction[1, i, j]
        out[0, i, j] += self.xx * tx + self.xy * ty
        out[1, i, j] += self.xy * tx + self.yy * ty
        return out

    def trailing(self, traction: AnyArray) -> AnyArray:
        """K `traction` of the trailing border only, (2, n, m).

        Where that slips, the traction is at the bound whatever the gradient, and K would only take power from the slip."""
        i, j = (index[self._trailing] for index in self._index)
        xx, yy, xy = (k[self._trailing] for k in (self.xx, self.yy, self.xy))
        tx, ty = traction[0, i, j], traction[1, i, j]
        out = np.zeros_like(traction)
        out[0, i, j], out[1, i, j] = xx * tx + xy * ty, xy * tx + yy * ty
        return out

    def apply(self, traction: AnyArray) -> AnyArray:
        """K `traction`, (2, n, m)."""
        return self.add(np.zeros_like(traction), traction)


def _limited(k: AnyArray, along: float, across: float, options: RollingOptions) -> AnyArray:
    """Components xx, yy, xy (3, …) scaled down to what occurs below Hertz pressures, so that slivers do not lose digits."""
    x, y = k[0] / along, k[1] / across
    excess = np.maximum(np.maximum(x, y) * options.smallest_cover, -np.minimum(x, y) / options.deepest)
    return np.asarray(k / np.maximum(1.0, excess))


def _border_normal(
    c: AnyArray, i: NDArray[np.intp], j: NDArray[np.intp], dx: float, dy: float
) -> tuple[AnyArray, AnyArray]:
    """Unit vector along the steepest change of the covered fraction (Sobel differences) at elements (i, j); `c` holds the
    fractions with one more row and column on all sides."""
    along_x, along_y = (d[i, j] for d in sobel(c, dx, dy))
    size = np.hypot(along_x, along_y)
    known = size > 0.0
    safe = np.where(known, size, 1.0)
    # An isolated element has no direction: taken as cut across the rolling direction.
    return np.where(known, along_x / safe, 1.0), np.where(known, along_y / safe, 0.0)

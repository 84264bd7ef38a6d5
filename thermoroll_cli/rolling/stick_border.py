"""Where the border between stick and slip runs inside the elements on which slip begins.

At the downstream border of a stick area, at a distance d from it, the half-space is in plane strain along the border's normal n
and in anti-plane strain along the border, and what the friction has in reserve and the slip have one common factor A:

    μp − |τ| = A sqrt(d)  inside,      |s| = |n_x| c A sqrt(d)  outside,      c = Σ(1−ν)/G (n·τ)²/τ² + Σ1/G (1 − (n·τ)²/τ²)

(for n along x this is Carter's contact, with its shear modulus along and across). Measured along x, both are A sqrt(|n_x| d_x).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.halfspace.elastic import ShearCompliance
from thermoroll_cli.numerics.stencils import sobel

FLATTEST = 1e-3
"""Least |n_x| c, over Σ(1−ν)/G: where the border runs along the rolling direction, slip does not tell its distance."""


def stick_surplus(
    traction: Array, slip: Array, bound: Array, stick: Mask, covered: Array, dx: float, dy: float, compliance: ShearCompliance
) -> float:
    """Stick area beyond that of the elements marked `stick`, in elements: what the border leaves or takes inside elements.

    Arguments are those of `stick_ends`. A border where stick begins behind slip has no such law and stays between elements."""
    i, j, place = stick_ends(traction, slip, bound, stick, covered, dx, dy, compliance)
    # Between the centres, but no further than the contact goes.
    return float(np.clip(place - 0.5, -covered[i, j], covered[i + 1, j]).sum())


def stick_ends(
    traction: Array, slip: Array, bound: Array, stick: Mask, covered: Array, dx: float, dy: float, compliance: ShearCompliance
) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Elements (i, j) that stick while (i + 1, j) slips, and how far the border is beyond their centres, from 0 to 1 elements.

    `traction` (Pa) and relative `slip` s/V are (2, n, m), `bound` μp (Pa) and the `covered` fractions (n, m). What friction has
    in reserve on the last element that sticks, and the slip on the first one behind it, both root-like, place the border
    between their centres by linear interpolation: on Carter's contact to 0.005 elements wherever it lies (0.3 when whole
    elements are counted)."""
    inside = covered > 0.0
    i, j = np.nonzero(stick[:-1] & ~stick[1:] & inside[1:])
    if not i.size:
        return i, j, np.zeros(0)
    size = np.hypot(traction[0], traction[1])
    reserve = np.maximum(bound - size, 0.0) * stick
    speed = np.hypot(slip[0], slip[1]) * (inside & ~stick)
    normal = sobel(np.pad(reserve - speed / compliance.along, 1, mode="edge"), dx, dy)
    nx, ny = normal[0][i, j] + normal[0][i + 1, j], normal[1][i, j] + normal[1][i + 1, j]
    length = np.hypot(nx, ny)
    length[length == 0.0] = 1.0
    nx, ny = nx / length, ny / length
    tx, ty, force = traction[0, i + 1, j], traction[1, i + 1, j], size[i + 1, j]
    along = ((nx * tx + ny * ty) / np.where(force > 0.0, force, 1.0)) ** 2
    c = compliance.along * along + compliance.across * (1.0 - along)
    outside = speed[i + 1, j] / np.maximum(c * np.abs(nx), FLATTEST * compliance.along)
    total = reserve[i, j] + outside
    return i, j, np.where(total > 0.0, reserve[i, j] / np.where(total > 0.0, total, 1.0), 0.5)

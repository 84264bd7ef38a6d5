"""Where the contact border runs inside an element, read off the pressure: p² vanishes linearly at the border."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Elements narrower than this share of an element carry (1/20)^1.5 ≈ 1 % of a border element's load.
SMALLEST_COVER = 0.05


def covered_fraction(pressure: Array, contact: Mask) -> Array:
    """Fraction of each element's length along x that is in contact, (nx, ny) in [SMALLEST_COVER, 1], 0 outside.

    For an element at the start or end of a run along x, p² of the next three elements inside is continued as a parabola
    to its zero. The border element's own pressure is the least certain one and is not used where others are there.
    """
    square = np.where(contact, pressure, 0.0) ** 2
    covered = contact.astype(np.float64)
    for flip in (False, True):
        view = slice(None, None, -1) if flip else slice(None)
        covered[view] = np.minimum(covered[view], _leading_fraction(square[view], contact[view]))
    return np.where(contact, np.clip(covered, SMALLEST_COVER, 1.0), 0.0)


def _leading_fraction(square: Array, contact: Mask) -> Array:
    """Covered fraction of the first element of each run, 1 elsewhere."""
    before = np.zeros_like(contact)
    before[1:] = contact[:-1]
    i, j = np.nonzero(contact & ~before)
    n = len(square)

    def inside(k: int) -> tuple[Array, Mask]:
        row = np.minimum(i + k, n - 1)
        return square[row, j], contact[row, j] & (i + k < n)

    (s0, _), (s1, c1), (s2, c2), (s3, c3) = (inside(k) for k in range(4))
    c2 &= c1
    c3 &= c2
    # Parabola through elements 1, 2, 3 in t = distance from element 2's centre towards the border, in elements.
    slope, bend = 0.5 * (s1 - s3), 0.5 * (s1 - 2.0 * s2 + s3)
    # Zero of s2 + slope t + bend t²; slope < 0 towards the border. Stable form of the smaller root.
    root = np.sqrt(np.maximum(slope**2 - 4.0 * bend * s2, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        parabola = 2.0 * s2 / (-slope + root) - 1.5  # from element 0's inner edge to the border
        line = s1 / (s2 - s1) - 0.5
        own = np.where(c1, s0 / (s0 + s1), 1.0)
    fraction = np.where(c3 & (slope < 0.0) & np.isfinite(parabola), parabola, np.where(c2 & (s2 > s1), line, own))
    out = np.ones_like(square)
    out[i, j] = np.clip(fraction, SMALLEST_COVER, 1.0)
    return out


def stick_cover(traction: Array, stick: Mask, bound: Array, covered: Array) -> Array:
    """Fraction of each element that sticks, (nx, ny): like `covered_fraction`, but for the border of stick and slip.

    The reserve μp − |τ| falls to zero like a square root at that border (Carter), so its square is continued as a parabola;
    the border may lie up to one element into the first slipping one."""
    reserve = np.where(stick, np.maximum(bound - np.hypot(traction[0], traction[1]), 0.0), 0.0)
    square = reserve**2
    slip = (covered > 0.0) & ~stick
    share = covered * stick
    for flip in (False, True):
        view = slice(None, None, -1) if flip else slice(None)
        share[view] += _beyond_run(square[view], stick[view], slip[view])
    return np.maximum(share, 0.0)


def _beyond_run(square: Array, stick: Mask, slip: Mask) -> Array:
    """What the first element of each stick run has too much (< 0) or the slipping element before it gains (> 0)."""
    behind = np.zeros_like(stick)
    behind[1:] = slip[:-1]
    i, j = np.nonzero(stick & behind)
    n = len(square)

    def inside(k: int) -> tuple[Array, Mask]:
        row = np.minimum(i + k, n - 1)
        return square[row, j], stick[row, j] & (i + k < n)

    (s1, _), (s2, c2), (s3, c3) = (inside(k) for k in range(1, 4))
    slope, bend = 0.5 * (s1 - s3), 0.5 * (s1 - 2.0 * s2 + s3)
    root = np.sqrt(np.maximum(slope**2 - 4.0 * bend * s2, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = 2.0 * s2 / (-slope + root) - 1.5
    usable = c2 & c3 & (slope < 0.0) & np.isfinite(fraction)
    out = np.zeros(square.shape)
    out[i, j] = np.where(usable, np.clip(fraction - 1.0, -1.0, 1.0), -0.5)
    return out

"""Outlines of rails and wheels that wear: depths on rows along the arc length of the new outline, moved along its normals."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from thermoroll_cli.many_contacts.wheelset.curves import Points, curve
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

ROW = 0.25e-3
"""Width of the rows in m: that of the finest elements."""
MOST_ROWS = 1500
"""Rows of an outline at most: a case file takes 2000 points."""
HALF_AMPLITUDE = math.sqrt(math.log(2.0) / 2.0) / math.pi
"""Standard deviation of the Gaussian over the wavelength of which it leaves half of the amplitude."""
AROUND = 3
"""Samples on either side that give the direction of the outline: those of a corner and of a knot coincide."""
FLANGE_BACK_TO_DATUM, ABOVE_DATUM, BELOW_TIP = 70e-3, 10e-3, 2e-3
"""Places of EN 15313: the datum of the tread 70 mm from the flange back, the thickness 10 mm above it, and the point of qR 2 mm
below the tip (m)."""


@dataclass(frozen=True)
class WornOutline:
    """The outline `points` (y to the field side, z down, m) of a wheel or a rail, less the `depth` (m) on rows of equal width
    along its length, (n,)."""

    points: Points
    wheel: bool
    depth: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def new(cls, points: Points, *, wheel: bool) -> WornOutline:
        """An unworn outline."""
        length = float(curve(points).knots[-1])
        return cls(points, wheel, np.zeros(min(MOST_ROWS, math.ceil(length / ROW))))

    @property
    def length(self) -> float:
        return float(curve(self.points).knots[-1])

    @property
    def size(self) -> float:
        """Width of a row in m."""
        return self.length / len(self.depth)

    @cached_property
    def _index(self) -> Array:
        """Numbers of the samples of the new outline that become points of the worn one: next to the middles of rows, corners
        and both ends."""
        own = curve(self.points)
        corners = np.concatenate(([0.0], own.knots[own.corners + 1], [own.knots[-1]]))
        rows = (np.arange(len(self.depth)) + 0.5) * self.size
        beside = np.abs(rows[:, None] - corners).min(axis=1) > 0.4 * self.size
        return np.unique(np.searchsorted(own.lengths, np.union1d(rows[beside], corners)).clip(0, len(own.lengths) - 1))

    @property
    def _places(self) -> Array:
        """Lengths (m) along the new outline of the points of the worn one."""
        return curve(self.points).lengths[self._index]

    @cached_property
    def worn(self) -> Points:
        """The points of the worn outline in m; those given while nothing is worn."""
        if not self.depth.any():
            return self.points
        y, z, dy, dz = curve(self.points).samples[:, self._index]
        rows = (np.arange(len(self.depth)) + 0.5) * self.size
        depth = np.interp(self._places, rows, self.depth)
        inwards = np.sign(self.points[-1][0] - self.points[0][0]) * (-1.0 if self.wheel else 1.0) / np.hypot(dy, dz)
        return tuple(zip((y - inwards * dz * depth).tolist(), (z + inwards * dy * depth).tolist(), strict=True))

    @cached_property
    def _lengths(self) -> Array:
        """Lengths along the new outline of the samples of the worn one."""
        own = curve(self.worn)
        return np.interp(own.lengths, own.knots, self._places) if self.depth.any() else own.lengths

    def deposited(self, line: Array, places: Array, areas: Array) -> Array:
        """`areas` (m²) between `places` (y, z in m, (2, n + 1)) that lie near the outline as depths (m) on its rows. `line` has
        the samples of the worn outline (y, z) where the wheel or the rail stands."""
        nearest = np.array([int(np.nanargmin(np.hypot(*(line - place[:, None])))) for place in places.T])
        low, high = (nearest - AROUND).clip(0), (nearest + AROUND).clip(None, line.shape[1] - 1)
        tangent = line[:, high] - line[:, low]
        beyond = ((places - line[:, nearest]) * tangent).sum(axis=0) / np.hypot(*tangent)
        edges = self._lengths[nearest] + beyond
        if edges[-1] < edges[0]:
            edges, areas = edges[::-1], areas[::-1]
        total = np.concatenate(([0.0], np.cumsum(areas)))
        rows = np.arange(len(self.depth) + 1) * self.size
        rows[0], rows[-1] = -math.inf, math.inf  # what lies beyond an end wears the last row
        return np.asarray(np.diff(np.interp(rows, np.maximum.accumulate(edges), total)) / self.size)

    def smoothed(self, depth: Array, wavelength: float) -> Array:
        """`depth` on rows with the same sum, of which half of the amplitude is left at a `wavelength` (m)."""
        if wavelength == 0.0:
            return depth
        return np.asarray(scipy.ndimage.gaussian_filter1d(depth, HALF_AMPLITUDE * wavelength / self.size, mode="reflect"))


def worn_off(outline: WornOutline, line: Array, patch: Result, depth: Array) -> Array:
    """`depth` (m) on the lines of rolling of a patch of a wheelset as a depth on the rows of its `outline`, of which `line` has
    the samples."""
    loaded = np.flatnonzero(depth)
    if not len(loaded):
        return np.zeros(len(outline.depth))
    first, last, y = loaded[0], loaded[-1] + 1, patch.y
    half = 0.5 * float(y[1] - y[0])
    edges = np.append(y - half, y[-1] + half)[first : last + 1]
    # Straight on beyond the first and the last y.
    places = scipy.interpolate.make_interp_spline(y, patch.lines["surface"][:2], k=1, axis=1)(edges)
    return outline.deposited(line, places, depth[first:last] * 2.0 * half)


def flange(points: Points, back: float) -> tuple[float, float, float]:
    """Height Sh, thickness Sd and gradient qR (m) of the flange of a wheel's outline after EN 15313, whose flange back is at
    y = `back`: from the datum 70 mm from the back to the tip, from the back to the flange 10 mm above the datum, and from there
    to the flange 2 mm below the tip, across. nan where the outline does not reach there."""
    y, z = curve(points).to_the_field_side
    tip = int(np.argmax(z))
    tread = y[tip:], z[tip:]
    if not tread[0][0] < back + FLANGE_BACK_TO_DATUM <= tread[0][-1]:
        return math.nan, math.nan, math.nan
    datum = float(np.interp(back + FLANGE_BACK_TO_DATUM, *tread))

    def at(height: float) -> float:
        below = np.flatnonzero(tread[1] <= height)
        if not len(below) or below[0] == 0:
            return math.nan
        k = below[0]
        return float(np.interp(-height, -tread[1][k - 1 : k + 1], tread[0][k - 1 : k + 1]))

    thick = at(datum + ABOVE_DATUM)
    return float(z[tip]) - datum, thick - back, thick - at(float(z[tip]) - BELOW_TIP)


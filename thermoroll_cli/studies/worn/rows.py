"""Rows: strips of one width across the profiles, at places that do not move, on which worn depths are kept.

The elements of every solution are rows, so that an element wears exactly the material whose height it feels. A grid that is
fitted to each contact moves its elements through the material by a part of their width per step: an element at the border,
which carries load of its partly covered neighbour, too, then wears a ridge that travels with the border and leaves a ripple.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy

from thermoroll_cli.problem.geometry import Profile, Surface
from thermoroll_cli.tools.arrays import Array

ALIGNED = 1e-6
"""Part of a row by which rounding may move its edge."""
OUTSIDE = 400
"""Points of a worn profile beyond its rows where the shape is given by a formula or by straight lines."""
BEFORE_THE_END = 1e-9
"""Part of its length that a profile loses at either end: there a logarithmic crown has no height."""


@dataclass(frozen=True)
class FixedRows:
    """`count` rows of width `size` (m): row k, from number `first` on, begins at `middle` + k `size`. Both bodies have material
    from row −`half` to row `half` − 1; None where neither ends."""

    middle: float
    size: float
    first: int
    count: int
    half: int | None = None

    @classmethod
    def over(cls, low: float, high: float, facing: tuple[float, float], count: int) -> FixedRows:
        """About `count` rows, an even number, from `low` to `high` (m), of bodies that are `facing` each other between two
        places: whole rows fill what both have."""
        low, high = float(low), float(high)
        size = (high - low) / (count + count % 2)
        if not math.isfinite(facing[1] - facing[0]):
            return cls(0.5 * (low + high), size, 0, 0).covering(low, high)
        span = float(facing[1] - facing[0])
        half = max(1, round(0.5 * span / size))
        return cls(0.5 * float(facing[0] + facing[1]), 0.5 * span / half, 0, 0, half).covering(low, high)

    @property
    def edges(self) -> Array:
        """Edges of the rows in m, (count + 1,)."""
        return np.asarray(self.middle + (self.first + np.arange(self.count + 1)) * self.size)

    @property
    def y(self) -> Array:
        """Centres of the rows in m, (count,)."""
        return np.asarray(self.middle + (self.first + 0.5 + np.arange(self.count)) * self.size)

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest y in m."""
        return self.middle + self.first * self.size, self.middle + (self.first + self.count) * self.size

    def covering(self, low: float, high: float) -> Self:
        """Rows of the same places, an even number, that cover `low` to `high` (m) as far as there is material."""
        most = self.half or 10**9
        first = max(math.floor((low - self.middle) / self.size + ALIGNED), -most)
        stop = min(math.ceil((high - self.middle) / self.size - ALIGNED), most)
        if (stop - first) % 2:
            first, stop = (first, stop + 1) if stop < most else (first - 1, stop)
        return replace(self, first=first, count=stop - first)

    def covers(self, low: float, high: float) -> bool:
        """Whether there are rows from `low` to `high` (m), as far as there is material."""
        return self.joined(self.covering(low, high)) == self

    def joined(self, other: Self) -> Self:
        """These rows and `other` ones of the same places, and those between."""
        first = min(self.first, other.first)
        return replace(self, first=first, count=max(self.first + self.count, other.first + other.count) - first)

    def coarser(self) -> Self:
        """Rows about twice as wide that cover these."""
        if self.half is None:
            wide = replace(self, size=2.0 * self.size)
        else:
            half = max(1, round(0.5 * self.half))
            wide = replace(self, size=self.size * self.half / half, half=half)
        return wide.covering(*self.ends)

    def averages(self, edges: Array, values: Array) -> Array:
        """`values` ≥ 0 between `edges` (m), averages over whatever there is, as averages over the rows: their area is kept.
        Between edges it is a monotonous spline, for narrower rows must not make stairs of wider ones."""
        area = scipy.interpolate.PchipInterpolator(edges, np.concatenate([[0.0], np.cumsum(values * np.diff(edges))]))
        # The spline rises but for rounding.
        return np.maximum(np.diff(area(np.clip(self.edges, edges[0], edges[-1]))), 0.0) / self.size


def worn_profile(surface: Surface, profile: Profile | None, rows: FixedRows, depth: Array) -> Profile:
    """The whole `profile` of a `surface` (None: a radius) less the `depth` (m) worn off on `rows`: a point in the middle of
    each row; beyond them the points given, or enough of them for a shape that has none. A radius goes on as far as the rows on
    both sides."""
    low, high = rows.ends
    ends = surface.ends if math.isfinite(surface.ends[1]) else (2.0 * low - high, 2.0 * high - low)
    room = BEFORE_THE_END * (ends[1] - ends[0])
    places = np.linspace(ends[0] + room, ends[1] - room, OUTSIDE)
    if profile is not None and profile.points:
        given = np.array([y for y, _ in profile.points]) + profile.offset
        places = given if profile.interpolation == "cubic" else np.union1d(given, places[1:-1])
    beyond = [places[places < low], places[places > high]]
    worn = [np.zeros(len(part)) for part in beyond]
    for side, place, last in ((0, ends[0] + room, depth[0]), (1, ends[1] - room, depth[-1])):
        if not len(beyond[side]) and (place < rows.y[0] or place > rows.y[-1]):
            beyond[side], worn[side] = np.array([place]), np.array([last])
    y = np.concatenate([beyond[0], rows.y, beyond[1]])
    heights = surface.height(y) - np.concatenate([worn[0], depth, worn[1]])
    distinct = np.diff(y, prepend=-math.inf) > ALIGNED * rows.size
    return Profile(tuple(zip(y[distinct].tolist(), heights[distinct].tolist(), strict=True)))

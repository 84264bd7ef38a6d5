"""Profiles as plane curves of any shape: splines over arc length, their branches, and the outline that another body sees."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from thermoroll_cli.tools.arrays import Array

KINK = np.pi / 6.0
"""Turn between two neighbouring chords (rad) from which on a profile has a corner there and no continuous slope."""
STEP = 2e-5
"""Distance of samples in m. Between them an arc of 10 mm radius departs from its chord by 5 nm."""
SMOOTHABLE = 5
"""Points that a smoothing spline needs."""
SMALLEST_STEP = 1e-9
"""Points of a profile closer than this (m) are the same point."""

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class ProfileCurve:
    """The curve (y, z)(s) through `points` (m, in order) over the length s along their chords: C² but for corners."""

    points: Points

    @cached_property
    def _spline(self) -> scipy.interpolate.PPoly:
        places, chords = self._distinct
        knots = np.concatenate(([0.0], np.cumsum(np.hypot(*chords.T))))
        corners = [0, *(self.corners + 1), len(places) - 1]
        parts = [scipy.interpolate.CubicSpline(knots[a : b + 1], places[a : b + 1])
                 for a, b in itertools.pairwise(corners)]
        height = max(part.c.shape[0] for part in parts)
        padded = [np.pad(part.c, ((height - part.c.shape[0], 0), (0, 0), (0, 0))) for part in parts]
        return scipy.interpolate.PPoly(np.concatenate(padded, axis=1), knots)

    def at(self, lengths: Array) -> Array:
        """(y, z) in m at lengths along the chords (m), (n, 2)."""
        return np.asarray(self._spline(lengths))

    @cached_property
    def _distinct(self) -> tuple[Array, Array]:
        """Points that differ, and the chords between them."""
        places = np.array(self.points)
        apart = np.hypot(*np.diff(places, axis=0).T) > SMALLEST_STEP
        places = places[np.concatenate(([True], apart))]
        return places, np.diff(places, axis=0)

    @cached_property
    def corners(self) -> NDArray[np.intp]:
        """Numbers of the chords behind which the curve has a corner."""
        chords = self._distinct[1]
        direction = np.arctan2(chords[:, 1], chords[:, 0])
        turn = np.abs((np.diff(direction) + np.pi) % (2.0 * np.pi) - np.pi)
        return np.flatnonzero(turn > KINK)

    @property
    def corner_places(self) -> Array:
        """(y, z) of the corners in m, (n, 2)."""
        return self._distinct[0][self.corners + 1]

    @property
    def knots(self) -> Array:
        """Lengths along the chords (m) of the points that differ."""
        return np.asarray(self._spline.x)

    @cached_property
    def _pieces(self) -> tuple[NDArray[np.intp], Array]:
        """The chord that each sample belongs to, and the fraction of it before the sample."""
        counts = np.maximum(np.ceil(np.diff(self.knots) / STEP).astype(int), 1)
        return (np.repeat(np.arange(len(counts)), counts + 1),
                np.concatenate([np.linspace(0.0, 1.0, count + 1) for count in counts]))

    @property
    def lengths(self) -> Array:
        """Lengths along the chords (m) of the samples, (n,)."""
        inner, fraction = self._pieces
        return np.asarray(self.knots[inner] + fraction * np.diff(self.knots)[inner])

    @cached_property
    def samples(self) -> Array:
        """Rows y, z, dy/ds, dz/ds at places at most STEP apart; a corner is a place of both its sides. NaN-free, (4, n)."""
        spline, knots = self._spline, self.knots
        inner, fraction = self._pieces
        # Both ends of each piece are evaluated on that piece: slopes at a corner are those of both sides.
        ds = fraction * np.diff(knots)[inner]
        c = spline.c[:, inner]
        powers = ds[:, None]
        order = c.shape[0] - 1
        value = sum(c[k] * powers ** (order - k) for k in range(order + 1))
        slope = sum((order - k) * c[k] * powers ** (order - k - 1) for k in range(order))
        return np.ascontiguousarray(np.concatenate((value, slope), axis=1).T)

    @property
    def to_the_field_side(self) -> Array:
        """(y, z) of the samples from the smaller to the larger y of both ends, (2, n)."""
        places = self.samples[:2]
        return places if places[0, -1] >= places[0, 0] else places[:, ::-1]


@lru_cache(maxsize=16)
def curve(points: Points) -> ProfileCurve:
    """The curve through `points`, kept for the next that asks."""
    return ProfileCurve(points)


@dataclass(frozen=True)
class Outline:
    """The part of a curve that is seen along z: at each y the sample that lies nearest. `z` is the height at `y`, nan where
    there is nothing; `index` the (fractional) number of the sample."""

    y: Array
    z: Array
    index: Array

    def within(self, part: slice) -> Outline:
        return Outline(self.y[part], self.z[part], self.index[part])

    def of(self, values: Array) -> Array:
        """`values` of the samples at the places of the outline, interpolated within their branch."""
        filled = np.nan_to_num(self.index)
        low = np.minimum(filled.astype(int), len(values) - 2)
        part = filled - low
        return np.asarray(np.where(np.isnan(self.index), np.nan, (1.0 - part) * values[low] + part * values[low + 1]))


def outline(y: Array, z: Array, at: Array, *, lowest: bool) -> Outline:
    """The lowest (largest z, which points down) or highest z at the increasing places `at` of all branches on which `y` is
    monotone. Samples that are nan divide branches."""
    steps = np.diff(y)
    direction = np.where(np.isnan(steps), 2, np.sign(steps)).astype(int)
    # Samples at the same y, as both of a knot, continue the branch before them.
    moving = np.flatnonzero(direction)
    direction = direction[moving[np.maximum(np.cumsum(direction != 0) - 1, 0)]]
    bounds = np.concatenate(([0], np.flatnonzero(np.diff(direction)) + 1, [len(steps)]))
    first, behind = np.searchsorted(at, y[bounds]), np.searchsorted(at, y[bounds], "right")
    seen, number = np.full(len(at), np.nan), np.full(len(at), np.nan)
    for k, (a, b) in enumerate(itertools.pairwise(bounds.tolist())):
        rises = direction[a] == 1
        within = slice(first[k], behind[k + 1]) if rises else slice(first[k + 1], behind[k])
        if abs(direction[a]) != 1 or within.start >= within.stop:
            continue
        order = slice(a, b + 1) if rises else slice(b, a - 1 if a else None, -1)
        branch = y[order]
        index = np.interp(at[within], branch, np.arange(a, b + 1)[:: direction[a]])
        heights = np.interp(at[within], branch, z[order])
        nearer = np.isnan(seen[within]) | ((heights > seen[within]) if lowest else (heights < seen[within]))
        seen[within] = np.where(nearer, heights, seen[within])
        number[within] = np.where(nearer, index, number[within])
    return Outline(at, seen, number)


def smoothed(points: Points, wavelength: float) -> Points:
    """`points` with both coordinates smoothed over arc length, see `smooth`."""
    places, chords = ProfileCurve(points)._distinct
    length = np.concatenate(([0.0], np.cumsum(np.hypot(*chords.T))))
    return tuple(zip(*(smooth(length, column, wavelength).tolist() for column in places.T), strict=True))


def smooth(at: Array, values: Array, wavelength: float) -> Array:
    """`values` at increasing places on a smoothing spline that leaves half of the amplitude at a `wavelength` L (m):
    λ = (points per length) (L/2π)⁴ in Σ (f − values)² + λ ∫ f″². As they are where there are too few."""
    if len(at) < SMOOTHABLE:
        return values
    # The spacing of the points is one in the spline's own coordinate: powers of metres would lose digits.
    scale = (at[-1] - at[0]) / (len(at) - 1)
    stiffness = (wavelength / (2.0 * np.pi * scale)) ** 4
    spline = scipy.interpolate.make_smoothing_spline((at - at[0]) / scale, values, lam=stiffness)
    return np.asarray(spline((at - at[0]) / scale))

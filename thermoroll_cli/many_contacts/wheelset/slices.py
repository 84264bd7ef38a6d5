"""Outlines that change along the track or around the wheel: slices, and the surface through them.

Between features (the ends of each slice, where none are given) the outlines of all slices are divided at the same shares of
arc; what lies at the same share is joined by a cubic spline of continuous curvature over the places of the slices."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from thermoroll_cli.many_contacts.wheelset.curves import Points, ProfileCurve
from thermoroll_cli.problem.rounding import MeasuredOutline, Rounding, rounding_at
from thermoroll_cli.tools.arrays import Array

SPACING, MOST, AROUND = 5e-5, 4000, 6
"""Distance (m) of lines of the surface across the slices, how many a part has at most, and slices of other turns that a spline
around a wheel takes."""
JUMP = 1.25
"""Ratio of the lengths of a part in neighbouring slices from which on it is another part: an interruption without features."""


class _Part(NamedTuple):
    """Lines between two features: a spline of their (y, z) over the places of neighbouring slices that have the part, and the
    first and the last of these."""

    spline: scipy.interpolate.PPoly
    first: float
    last: float


@dataclass(frozen=True)
class Slices:
    """Outlines (m) at increasing places `at`, in m along the track or rad around the wheel. `features` are arc lengths (m) of
    each outline that belong together, increasing, none where its ends do; negative where a slice lacks the part before or
    behind it, which then ends where its last slice is. Slices all around a wheel follow each other after a turn (`turns`).
    Beyond the first and the last slice the outline stays as it is there. The surface goes through the slices, or, where they
    `control` it, has them as control points of cubic B-splines, which smooth what changes from slice to slice. How the points
    of each were `measured` has no effect on that; places times the `radius` (m; of rails 1) are lengths."""

    at: tuple[float, ...]
    outlines: tuple[Points, ...]
    features: tuple[tuple[float, ...], ...] = ()
    turns: bool = False
    control: bool = False
    measured: tuple[MeasuredOutline, ...] = ()
    radius: float = 1.0

    def __hash__(self) -> int:
        # A sample: hashing all points costs more than most cached results.
        return hash((self.at, self.outlines[0][:3], self.outlines[-1][:3]))

    @cached_property
    def _parts(self) -> tuple[_Part, ...]:
        curves = [ProfileCurve(points) for points in self.outlines]
        lengths = [float(each.knots[-1]) for each in curves]
        marks = np.array(self.features or [(0.0, length) for length in lengths])
        marks = np.minimum(marks, np.array(lengths)[:, None])
        parts = []
        for low, high in zip(marks.T[:-1], marks.T[1:], strict=True):
            there = np.flatnonzero((low >= 0.0) & (high >= 0.0))
            count = int(np.clip(float((high - low)[there].max(initial=0.0)) / SPACING, 2, MOST)) + 1
            for run in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1) if len(there) else ():
                lines = np.array([curves[k].at(np.linspace(low[k], high[k], count)) for k in run])
                at = np.array(self.at)[run]
                parts.append(_Part(self._joined(at, lines, (high - low)[run]), float(at[0]), float(at[-1])))
        return tuple(parts)

    def _joined(self, at: Array, lines: Array, lengths: Array) -> scipy.interpolate.PPoly:
        """The spline of the `lines` of a part with these `lengths` (m) in the slices `at`."""
        if self.turns:
            # As many slices of the turns before and behind as a spline notices.
            more = min(len(at), AROUND)
            at = np.concatenate((at[-more:] - 2.0 * math.pi, at, at[:more] + 2.0 * math.pi))
            lines, lengths = (np.concatenate((each[-more:], each, each[:more])) for each in (lines, lengths))
        if len(at) == 1:
            return scipy.interpolate.PPoly(lines[None], np.array([at[0] - 1.0, at[0] + 1.0]))
        steps = np.abs(np.diff(np.log(np.maximum(lengths, SPACING))))
        ends = [0, *(np.flatnonzero(steps > math.log(JUMP)) + 1).tolist(), len(at)]
        pieces = []
        for a, b in itertools.pairwise(ends):
            # Over a jump there is nothing to follow but a straight way.
            pieces += [scipy.interpolate.CubicSpline(at[a - 1 : a + 1], lines[a - 1 : a + 1])] if a else []
            pieces += [self._smooth(at[a:b], lines[a:b])] if b > a + 1 else []
        return scipy.interpolate.PPoly(np.concatenate([piece.c for piece in pieces], axis=1), at)

    def _smooth(self, at: Array, lines: Array) -> scipy.interpolate.PPoly:
        if not self.control:
            return scipy.interpolate.CubicSpline(at, lines)
        # Control points beyond the ends go on straight.
        way = np.arange(1.0, 4.0)
        knots = np.concatenate((at[0] - (at[1] - at[0]) * way[::-1], at, at[-1] + (at[-1] - at[-2]) * way))
        points = np.concatenate((2.0 * lines[:1] - lines[1:2], lines, 2.0 * lines[-1:] - lines[-2:-1]))
        spline = scipy.interpolate.BSpline(knots, points, 3)
        return scipy.interpolate.PPoly(np.stack([spline(at[:-1], nu) / math.factorial(nu) for nu in (3, 2, 1, 0)]), at)

    def lines_at(self, place: float) -> Array:
        """(y, z) in m of all lines at a place, (m, 2); nan for those of parts that are not there."""
        at = float(self._within(np.array(place)))
        return np.concatenate([np.asarray(part.spline(at)) if self.turns or part.first <= at <= part.last else
                               np.full(part.spline.c.shape[2:], np.nan) for part in self._parts])

    def at_each(self, places: Array, part: slice) -> Array:
        """(y, z) in m of a part of the lines of a wheel, each at an angle of its own, (m, 2), from `places` (m,)."""
        places, found, begin, done = self._within(places), [], 0, 0
        numbers = np.arange(sum(spline.c.shape[2] for spline, *_ in self._parts))[part]
        for spline, *_ in self._parts:
            number = numbers[(numbers >= begin) & (numbers < begin + spline.c.shape[2])] - begin
            own = places[done : done + len(number)]
            begin, done = begin + spline.c.shape[2], done + len(number)
            piece = np.clip(np.searchsorted(spline.x, own, side="right") - 1, 0, len(spline.x) - 2)
            away = (own - spline.x[piece])[:, None]
            value = np.zeros((len(own), 2))
            for coefficients in spline.c:
                value = value * away + coefficients[piece, number]
            found.append(value)
        return np.concatenate(found)

    def along(self, places: Array, place: float, point: Array) -> Array:
        """z in m at `places` (n,) of the line that is nearest to a `point` (y, z) in m at one `place`."""
        number = int(np.nanargmin(np.hypot(*(self.lines_at(place) - point).T)))
        counts = np.cumsum([part.spline.c.shape[2] for part in self._parts])
        k = int(np.searchsorted(counts, number, side="right"))
        part = self._parts[k]
        line = scipy.interpolate.PPoly(part.spline.c[:, :, number - counts[k], 1], part.spline.x)
        within = self._within(places)
        return np.asarray(line(within if self.turns else np.clip(within, part.first, part.last)))

    def roundings_at(self, place: float, point: tuple[float, float], reach: float) -> tuple[Rounding, ...]:
        """Roundings within the `reach` (m) of a `point` (y, z in m) at one `place`: of the points of the nearest slice, and
        from slice to slice, on the line through that point."""
        if not self.measured:
            return ()
        at = np.array(self.at)
        outline = self.measured[int(np.argmin(np.abs(at - self._within(np.array(place)))))]
        line = np.stack((self.radius * at, self.along(at, place, np.array(point))), axis=1)
        here = self.radius * float(self._within(np.array(place))), point[1]
        found = outline.rounding_at(point, reach), rounding_at(
            tuple(map(tuple, line.tolist())), (0.0, outline.steps[1]), here, reach, 0.0)
        return tuple(rounding for rounding in found if rounding)

    def outline_at(self, place: float) -> Points:
        """The outline at a place in m, of the parts that are there."""
        lines = self.lines_at(place)
        return tuple((float(y), float(z)) for y, z in lines[~np.isnan(lines[:, 0])])

    def _within(self, places: Array) -> Array:
        if self.turns:
            return np.asarray(np.mod(places - self.at[0], 2.0 * math.pi) + self.at[0])
        return np.clip(places, self.at[0], self.at[-1])

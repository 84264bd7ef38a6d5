"""The gap of one patch, exactly: from its reference surface along the normals to the rail and to the wheel of revolution."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from thermoroll_cli.many_contacts.wheelset.curves import SMALLEST_STEP, STEP
from thermoroll_cli.many_contacts.wheelset.kinematics import directions
from thermoroll_cli.many_contacts.wheelset.placement import Position, Side
from thermoroll_cli.many_contacts.wheelset.rolled_surfaces import OnPatch, Standing, standing
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.problem.geometry import Unsolvable, common_surface
from thermoroll_cli.problem.surface import Closing
from thermoroll_cli.tools.arrays import Array

NEWTON_SWEEPS = 6
"""Steps of Newton's method for the distance to a surface: from the start on the locus four reach rounding on treads, six on
flanges."""
CLOSE = 1e-9
"""Step of that method in m after which the next one is below rounding, for it converges quadratically. Places as close as this
are the same end of a surface."""
STEEPEST = 0.1
"""A surface is followed from a patch to where the cosine of its inclination to it falls below this."""
OVERLAP_SAMPLES = 801
"""Places across at which the largest overlap is looked for."""
PROBES = 201
"""Places at which normals are probed for the end of a surface: twice gives it to a part in 40,000."""
NEAR = 5e-4
"""The overlap is looked for within this distance (m) of the overlap of the outlines: further off the locus has other
branches."""

WEIGHT = 2.5
"""Exponent of the vertical overlap in the mean over y that gives the reference point of a plane and its inclination, that of
the rail: the integral over x of the squared overlap (Vollebregt 2020, Vehicle System Dynamics 60). Along normals and over arc
length the means differ, by 0.1 rad for a contact that reaches from the gauge corner to the flange."""
COLUMNS = 257
"""Places across at which a patch is handed to the solver, which takes cubic splines between them: 0.1 mm apart on a worn
tread."""
ROOM = 0.35
"""Room beside the overlap over its width. The elastic contact lies within the overlap."""
ALONG = np.linspace(-1.0, 1.0, 6)
"""Places along over the half-length of the overlap at which its gap is fitted; none in the middle, where the gap is given."""


def nearest(places: Array, y: float, z: float) -> int:
    """Number of the sample of `places` (rows y, z, … in m) that lies nearest to the point (y, z)."""
    return int(np.nanargmin(np.hypot(places[0] - y, places[1] - z)))


def section(
    at: Array, value: Array, d_at: Array, d_value: Array, start: int
) -> tuple[scipy.interpolate.CubicHermiteSpline, NDArray[np.intp]]:
    """A surface as a function of the place `at` through the samples around number `start` on which `at` moves on and the
    surface is not too steep, and their numbers. Raises Unsolvable if it is too steep at number `start`."""
    forward = np.sign(d_at[start])
    good = (d_at * forward > STEEPEST * np.hypot(d_at, d_value)) & ~np.isnan(value)
    if not good[start]:
        raise Unsolvable(f"the surfaces touch where one is steeper than {math.degrees(math.acos(STEEPEST)):.0f} degrees",
                         "wheelset.wheel_profile", "outlines, shifts and loads with contacts that are less steep")
    low, high = (int(start - np.argmax(~good[start::-1])) + 1 if not good[: start + 1].all() else 0,
                 int(start + np.argmax(~good[start:])) if not good[start:].all() else len(good))
    index = np.arange(low, high)[:: 1 if forward > 0 else -1]
    # A corner has two samples.
    index = index[np.concatenate(([True], np.diff(np.maximum.accumulate(at[index])) > SMALLEST_STEP))]
    return scipy.interpolate.CubicHermiteSpline(at[index], value[index], d_value[index] / d_at[index]), index


@dataclass(frozen=True)
class PatchSurface:
    """A patch of a right wheel on a right rail, around an overlap over `low` ≤ y ≤ `high` (m) of both outlines; beyond `ridges`
    (m) its neighbours or nothing lie. The reference point is at `x`, `y`, `z` (m, track axes), where the rail's inclination is
    `angle` (rad). The reference surface is that in which rail and locus touch, with the `shares` of rail and wheel in the
    compliance, if `curved`, else the plane of that point. x and s (m) are coordinates on it from the point: along the track,
    and arc length across, to the field side. Points are in the axes of the place, which is `x` ahead on the track or on the
    roller (`position`)."""

    facing: Facing
    low: float
    high: float
    ridges: tuple[float, float]
    x: float
    y: float
    z: float
    angle: float
    shares: tuple[float, float]
    curved: bool = True

    @property
    def place(self) -> Array:
        """The reference point, (3,)."""
        return np.array([0.0, self.y, self.z])

    @cached_property
    def position(self) -> Position:
        """The position of the wheelset in the axes of the place."""
        return replace(self.facing.position, ahead=self.x, roller=self.facing.rail.roller)

    @property
    def bodies(self) -> tuple[Side, Side]:
        """Rail and wheel, all along."""
        return self.facing.rail, self.facing.wheel

    @property
    def follows(self) -> bool:
        """Whether the axle follows surfaces that rise and fall along rolling."""
        return False

    @property
    def _lies(self) -> Position:
        """The position in which the wheel's surface lies in these axes."""
        return self.position

    @cached_property
    def _axes(self) -> tuple[Array, Array, Array]:
        """Origin, e_s and e_n of the place in (y, z)."""
        _, across, normal = directions(self.angle)
        return self.place[1:], across[1:], normal[1:]

    def _local(self, samples: Array) -> tuple[scipy.interpolate.CubicHermiteSpline, NDArray[np.intp]]:
        """Rows y, z, dy, dz as depth along the place's normal over the distance across."""
        origin, across, normal = self._axes
        offset, slope = samples[:2] - origin[:, None], samples[2:]
        distance = np.where(np.isnan(offset[1]), np.inf, np.hypot(*offset))
        return section(across @ offset, normal @ offset, across @ slope, normal @ slope, int(np.argmin(distance)))

    @cached_property
    def rail(self) -> scipy.interpolate.CubicHermiteSpline:
        """The rail in the axes of the place."""
        return self._local(self.facing.rail.samples)[0]

    @cached_property
    def _wheel(self) -> tuple[scipy.interpolate.CubicHermiteSpline, NDArray[np.intp]]:
        """The wheel's locus in the axes of the place, and the numbers of its samples."""
        return self._local(self.facing.locus[1:])

    @property
    def wheel(self) -> scipy.interpolate.CubicHermiteSpline:
        """The wheel's locus in the axes of the place."""
        return self._wheel[0]

    @cached_property
    def radius(self) -> scipy.interpolate.CubicHermiteSpline:
        """r(Y), the radius of the wheel in the axes of the wheelset, around the patch."""
        y, r, dy, dr = self.facing.wheel.samples
        return section(y, r, dy, dr, self._on_locus)[0]

    @property
    def _on_locus(self) -> int:
        """Number of the sample of the wheel whose locus is nearest to the place."""
        return nearest(self.facing.locus[1:3], self.y, self.z)

    @cached_property
    def _reference(self) -> tuple[Array, Array, Array, Array]:
        """Arc length, distance across and depth of the curved reference surface, and its inclination to the place."""
        low, high = self._ends
        across = np.linspace(low, high, max(int((high - low) / STEP), 50))
        depth, slope = (common_surface(self.rail(across, n), self.wheel(across, n), self.shares) for n in (0, 1))
        length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(across), np.diff(depth)))))
        return length - np.interp(0.0, across, length), across, depth, np.arctan(slope)

    def inclination(self, s: Array) -> Array:
        """α(s) in rad."""
        if not self.curved:
            return np.full(np.shape(s), self.angle)
        length, _, _, angle = self._reference
        return np.asarray(self.angle + np.interp(s, length, angle))

    def _base(self, s: Array) -> tuple[Array, Array, Array]:
        """Distance across, depth and inclination to the place of the reference surface at s."""
        if not self.curved:
            return np.asarray(s), np.zeros(np.shape(s)), np.zeros(np.shape(s))
        length, across, depth, angle = self._reference
        return np.interp(s, length, across), np.interp(s, length, depth), np.interp(s, length, angle)

    def _along(self, surface: scipy.interpolate.CubicHermiteSpline, s: Array, x: Array | float = 0.0) -> Array:
        """Distance (m) from the reference surface along its normal to a surface in the axes of the place, nan beyond its
        ends: to a rail at x along the track, where a roller has fallen away."""
        across, depth, angle = self._base(s)
        sine, cosine = np.sin(angle), np.cos(angle)
        roller, (origin, e_across, e_normal) = self.facing.rail.roller, self._axes
        t = np.zeros(np.broadcast_shapes(np.shape(s), np.shape(x)))
        fallen: Array | float = 0.0
        for _ in range(NEWTON_SWEEPS):
            at, down = across - t * sine, depth + t * cosine
            if roller:
                above = roller.radius - (origin[1] + e_across[1] * at + e_normal[1] * down)
                fallen = np.hypot(x, above) - above
            at = at - e_across[1] * fallen
            change = (down - e_normal[1] * fallen - surface(at)) / (cosine + sine * surface(at, 1))
            t = t - change
            if np.abs(change).max() < CLOSE:
                break
        return np.where((at >= surface.x[0] - CLOSE) & (at <= surface.x[-1] + CLOSE), t, np.nan)

    def gap_on_locus(self, s: Array) -> Array:
        """The smallest gap over x at each s in m, negative where the bodies overlap; nan where there is no material."""
        return np.asarray(self._along(self.rail, s) - self._along(self.wheel, s))

    def gap(self, x: Array, s: Array) -> Array:
        """Distance (m) between wheel and rail along the reference surface's normal at the places x (…, m) straight ahead of the
        point above s (m,): negative where they overlap, nan beyond the ends of the rail. Beyond its own ends the wheel goes on
        with the same radius, for a yawed edge crosses lines of rolling.

        Newton's method on |(X, Z)| − r(Y) in the axes of the wheelset."""
        base = self.places(s)
        angle = self.inclination(s)
        rotation, centre = self._lies.rotation, self._lies.origin(self.facing.wheel.radius)
        q0 = (base - centre) @ rotation + x[..., None] * rotation[0]
        step = np.stack((-np.sin(angle), np.cos(angle)), axis=-1) @ rotation[1:]
        t = np.broadcast_to(np.nan_to_num(self._along(self.wheel, s)), x.shape)
        ends = self.radius.x[[0, -1]]
        for _ in range(NEWTON_SWEEPS):
            q = q0 + t[..., None] * step
            r, slope = (self.radius(np.clip(q[..., 1], *ends), order) for order in (0, 1))
            reach = np.hypot(q[..., 0], q[..., 2])
            change = (reach - r) / ((q[..., 0] * step[:, 0] + q[..., 2] * step[:, 2]) / reach - slope * step[:, 1])
            t = t - change
            if np.abs(change).max() < CLOSE:
                break
        return np.asarray(self._along(self.rail, s, x if self.facing.rail.roller else 0.0) - t)

    def places(self, s: Array) -> Array:
        """Points of the reference surface above s at x = 0, (…, 3)."""
        origin, e_across, e_normal = self._axes
        across, depth, _ = self._base(s)
        y, z = (origin[k] + e_across[k] * across + e_normal[k] * depth for k in (0, 1))
        return np.stack((np.zeros(np.shape(s)), y, z), axis=-1)

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest s up to the ridges of the gap, to the ends of the surfaces, or to a width of the overlap
        beside it."""
        ridges, ends = self._at_ridges, self._ends
        low, high = self._arc((max(ridges[0], ends[0]), min(ridges[1], ends[1])))
        first, last = self._arc(self._across((self.low, self.high)))
        beside = last - first + 2.0 * NEAR
        here = 0.5 * (first + last)
        return self._met(here, max(low, first - beside)), self._met(here, min(high, last + beside))

    @property
    def _ends(self) -> tuple[float, float]:
        """Distances across of the places between which both surfaces have material."""
        rail, wheel = self.rail.x, self.wheel.x
        return float(max(rail[0], wheel[0])), float(min(rail[-1], wheel[-1]))

    def _met(self, here: float, end: float) -> float:
        """The last s on the way from `here` to `end` whose normal meets both surfaces, or a probe before it: iterated with
        other places the last one may miss by rounding."""
        for _ in range(2):
            s = np.linspace(here, end, PROBES)
            missed = np.flatnonzero(np.isnan(self.gap_on_locus(s)))
            if not len(missed):
                return end
            here, end = float(s[max(missed[0] - 2, 0)]), float(s[missed[0]])
        return here

    def _across(self, places: Sequence[float] | Array) -> Array:
        """Distances across of places y of the rail's outline from the place."""
        origin, across, _ = self._axes
        outline = self.facing.outlines[0]
        known = ~np.isnan(outline.z)
        return across @ (np.stack((places, np.interp(places, outline.y[known], outline.z[known]))) - origin[:, None])

    @property
    def _at_ridges(self) -> tuple[float, float]:
        """Distances across of the ridges, or the farthest on the way to them: over a deep groove the rail falls back behind the
        normal of a steep place."""
        y = self.facing.outlines[0].y
        low, high = (self._across(np.append(y[(y > a) & (y < b)], end)) for a, b, end in (
            (self.ridges[0], self.low, self.ridges[0]), (self.high, self.ridges[1], self.ridges[1])))
        return float(low.min()), float(high.max())

    def _arc(self, across: Sequence[float] | Array) -> tuple[float, float]:
        """s at two distances across."""
        low, high = np.interp(across, self._reference[1], self._reference[0]) if self.curved else across
        return float(low), float(high)

    @cached_property
    def overlapping(self) -> tuple[float, float]:
        """Lowest and highest s of the overlap, and a little more, within the limits."""
        low, high = self._arc(self._across((self.low, self.high)))
        return max(low - NEAR, self.limits[0]), min(high + NEAR, self.limits[1])

    @property
    def faces(self) -> bool:
        """Whether the bodies overlap along normals that meet both surfaces, and the gap opens along: not where the sharp end of
        one has just reached the other, or lies across it."""
        if not self.limits[1] > self.limits[0] or self.overlap[0] <= 0.0:
            return False
        _, lowest, _, fitted = self.table
        return bool(fitted[0, int(np.argmin(lowest))] > 0.25 * STEEPEST / self.facing.wheel.radius)

    @cached_property
    def overlap(self) -> tuple[float, float]:
        """Largest overlap along the normals (m), and its s."""
        s = np.linspace(*self.overlapping, OVERLAP_SAMPLES)
        gap = self.gap_on_locus(s)
        k = int(np.nanargmin(gap))
        return -float(gap[k]), float(s[k])

    def locus_x(self, s: Array) -> Array:
        """x (m) of the locus above the places s."""
        across, _, angle = self._base(s)
        spline, index = self._wheel
        at = across - self._along(spline, s) * np.sin(angle)
        x, roller = np.interp(at, spline.x, self.facing.locus[0][index]) - self.x, self.facing.rail.roller
        # An arc on the roller is as long as its radius there.
        return np.asarray(x * (1.0 - self.places(s)[:, 2] / roller.radius) if roller else x)

    def wheel_points(self, s: Array) -> Array:
        """Points (m) of the wheel above s at the x of the place, (n, 3), where it touches: it takes the shape of
        the reference surface, a plane or between both bodies, at the depth of its undeformed surface at the place."""
        depth = np.full(np.shape(s), float(self._along(self.wheel, np.zeros(1))[0]) if self.curved else self.overlap[0])
        angle = self.inclination(s)
        return np.asarray(self.places(s) + depth[:, None] * np.stack((0.0 * angle, -np.sin(angle), np.cos(angle)), axis=-1))

    def lateral(self, s: Array) -> Array:
        """Distance (m) across from the place, along its tangent."""
        return self._base(s)[0]

    @cached_property
    def table(self) -> tuple[Array, Array, Array, Array]:
        """Places s that are handed to the solver; the smallest gap on each line along rolling (m), its x, and the coefficients
        of its second to fourth power of the distance from there, (3, n)."""
        low, high = self.overlapping
        room = ROOM * (high - low)
        s = np.linspace(max(low - room, self.limits[0]), min(high + room, self.limits[1]), COLUMNS)
        x_lowest, lowest = self.locus_x(s), self.gap_on_locus(s)
        half = 1.2 * math.sqrt(2.0 * self.facing.wheel.radius * self.overlap[0])
        gap = self.gap(x_lowest + half * ALONG[:, None], s) - lowest
        fitted = np.linalg.lstsq(np.stack([ALONG**2, ALONG**3, ALONG**4], axis=1), gap, rcond=None)[0]
        return s, lowest, x_lowest, fitted / np.array([half**2, half**3, half**4])[:, None]

    @cached_property
    def heights(self) -> Closing | None:
        """What closes the gap beside the powers in the `table`, over the places −x and −s; None: nothing."""
        if not self.surfaces:
            return None
        s = self.table[0][::-1]
        return OnPatch((*self.surfaces.values(),), self.facing.rail.lifts, tuple((-s).tolist()),
                       tuple(np.cos(self.inclination(s)).tolist()))

    @cached_property
    def surfaces(self) -> Standing:
        """Those of rail and wheel that have one, where they stand at the place."""
        return standing(self.facing, self.x, nearest(self.facing.rail.samples, self.y, self.z), self._on_locus)

    @property
    def rolling_radius(self) -> float:
        """Radius of the wheel at the place in m."""
        return float(self.facing.wheel.samples[1][self._on_locus])

    @property
    def free_ends(self) -> tuple[bool, bool]:
        """Whether the lower and the upper limit are the end of a surface, and no ridge."""
        ridges = self._at_ridges
        low, high = self._arc(ridges)
        return (ridges[0] <= self._ends[0] + CLOSE or low < self.limits[0] - CLOSE,
                ridges[1] >= self._ends[1] - CLOSE or high > self.limits[1] + CLOSE)


def patches_of(
    facing: Facing, *, curved: bool, shares: tuple[float, float] = (0.5, 0.5), joined: float = 0.0,
    make: Callable[..., PatchSurface] = PatchSurface,
) -> list[PatchSurface]:
    """The patches of all overlaps in order of y; those between which the gap is at most `joined` (m) are one. `shares` are
    those of rail and wheel in the compliance."""
    gap, rail = facing.gap, facing.outlines[0]
    y, inside = rail.y, np.flatnonzero(gap < 0.0)
    if not len(inside):
        return []
    ends = np.flatnonzero(np.diff(inside) > 1) + 1
    runs = np.split(inside, [k for k in ends if gap[inside[k - 1] : inside[k]].max() > joined])
    bounds = [0, *(int(a[-1] + np.argmax(gap[a[-1] : b[0] + 1])) for a, b in itertools.pairwise(runs)), len(y) - 1]
    patches = []
    for k, run in enumerate(runs):
        share = (-gap[run]) ** WEIGHT
        share = share / share.sum()
        middle = float(share @ y[run])
        patches.append(make(
            facing, float(y[run[0]]), float(y[run[-1]]), (float(y[bounds[k]]), float(y[bounds[k + 1]])),
            x=float(share @ facing.ahead[run]), y=middle, z=float(np.interp(middle, y, rail.z)),
            angle=float(share @ facing.angle[run]), shares=shares, curved=curved))
    return patches

"""A wheel over a rail of which one changes along rolling: heights of both over the places ahead of the axle and across, and
patches in axes that are tilted as the surfaces are.

First contact is looked for at all places in reach: on each line y the bodies are nearest at the x where the gap is least,
whatever the height of the wheel. A patch there is that of a straight rail and a wheel of revolution, with the outlines of its
place, in axes whose x lies in both surfaces; by how much the real surfaces depart from these closes the gap beside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from thermoroll_cli.many_contacts.wheelset.curves import STEP, Outline, outline
from thermoroll_cli.many_contacts.wheelset.patch_surface import NEAR, PatchSurface
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.surface import Closing, Departure, Together
from thermoroll_cli.tools.arrays import Array

REACH, COARSE, FINE = 0.2, 2.5e-3, 2.5e-4
"""How far ahead the bodies may touch, as the sine of the angle around the wheel (rails that rise by 1:5), and distances (m) of
the places ahead that are looked at, everywhere and around first contact."""
CLOSE_BY, ROOM = 1e-3, 6e-3
"""Gap over that of first contact (m) of lines that are looked at more closely, up to this way (m) beyond where they are
nearest."""
AROUND, STATIONS, ACROSS = 0.04, 321, 161
"""Way (m) along rolling on either side of a patch on which its surfaces are known, and the places along and across there."""
SWEEPS = 4
"""Rounds for the angle of a wheel's line at a place ahead, as its radius changes with it: each adds a digit."""
SOFT = 1e-5
"""Gap (m) over the least one of a line up to which its places count for where the bodies are nearest: all along a flat."""
LINE, SHALLOW = 201, 1e-7
"""Places on each line of rolling at which the gap of a patch is looked at, over what an overlap (m) needs, this at least."""


class FacingHeights(NamedTuple):
    """z (m, track axes) of rail and wheel at the places `x` ahead of the axle and `y` across, (nx, ny); nan where there is
    none."""

    x: Array
    y: Array
    rail: Array
    wheel: Array

    @property
    def gap(self) -> Array:
        """Vertical gap in m, inf where a body is missing."""
        gap = self.rail - self.wheel
        return np.where(np.isnan(gap), np.inf, gap)


def rail_heights(rail: RailSide, x: Array, y: Array) -> Array:
    """The highest z of a rail at places ahead of the axle and across, (nx, ny)."""
    if rail.slices is None:
        return np.broadcast_to(outline(rail.samples[0], rail.samples[1], y, lowest=False).z, (len(x), len(y)))
    lines = (rail.lines(at) for at in x.tolist())
    return np.array([outline(across, z, y, lowest=False).z for across, z in lines])


def wheel_heights(wheel: WheelSide, position: Position, x: Array, y: Array) -> Array:
    """The lowest z of a wheel at places ahead of the axle and across, (nx, ny)."""
    rotation, origin = position.rotation, position.origin(wheel.radius)
    across, radius = wheel.lines(0.0)
    # x = R₀₀ r sin θ + R₀₁ y + O_x of each line; R₀₂ = 0 on a level track.
    rows = []
    for at in x.tolist():
        own, r = across, radius
        for _ in range(SWEEPS if wheel.slices else 1):
            sine = (at - origin[0] - rotation[0, 1] * own) / (rotation[0, 0] * r)
            angle = np.arcsin(np.clip(sine, -1.0, 1.0))
            if wheel.slices:
                own, r = wheel.lines(angle)
        local = np.array([r * sine, own, r * np.cos(angle)])
        rows.append(outline(rotation[1] @ local + origin[1], rotation[2] @ local + origin[2], y, lowest=True).z)
    return np.array(rows)


@dataclass(frozen=True)
class VaryingFacing(Facing):
    """A wheel over a rail of which one has slices. Its locus is that of the section below the axle."""

    @property
    def _span(self) -> Array:
        """Places y across of both bodies in reach, (n,). Raises Unsolvable if there are none."""
        reach = REACH * self.wheel.radius
        ahead = np.linspace(-reach, reach, 9)
        rails = [self.rail.samples[0]] if self.rail.slices is None else [self.rail.lines(x)[0] for x in ahead.tolist()]
        wheels = [self.position.rotation[1, 1] * self.wheel.lines(angle)[0] + self.position.y
                  for angle in ([0.0] if self.wheel.slices is None else np.linspace(-REACH, REACH, 9).tolist())]
        low = max(min(np.nanmin(y) for y in rails), min(y.min() for y in wheels))
        high = min(max(np.nanmax(y) for y in rails), max(y.max() for y in wheels))
        if not low < high:
            raise Unsolvable(f"the wheel misses its rail by {1e3 * (low - high):.3g} mm", "wheelset.lateral_shift_mm")
        return np.linspace(low, high, max(int((high - low) / STEP), 2))

    def heights(self, x: Array, y: Array) -> FacingHeights:
        """Both surfaces at places ahead of the axle and across."""
        return FacingHeights(x, y, _rail_heights(self.rail, tuple(x.tolist()), tuple(y.tolist())),
                       wheel_heights(self.wheel, self.position, x, y))

    @cached_property
    def _nearest(self) -> tuple[Array, Array, Array, Array]:
        """Over the places across: x where the bodies are nearest, z of the rail there, the gap, and the inclination of the
        rail."""
        if isinstance(self.other, VaryingFacing):
            x, z, gap, angle = self.other._nearest
            return x, z, gap - (self.position.z - self.other.position.z), angle
        y, reach = self._span, REACH * self.wheel.radius
        # The coarse look needs few places across.
        every = max(len(y) // 1200, 1)
        x, gap = _least(self.heights(np.arange(-reach, reach + COARSE, COARSE), y[::every]))
        near = gap < gap.min() + CLOSE_BY
        fine = np.arange(x[near].min() - ROOM, x[near].max() + ROOM, FINE)
        seen = self.heights(fine, y)
        x, gap = _least(seen)
        k = np.clip(np.rint((x - fine[0]) / FINE).astype(int), 0, len(fine) - 1)
        number = np.arange(len(y))
        k = np.where(np.isnan(seen.rail[k, number]), np.argmin(seen.gap, axis=0), k)
        slope = np.gradient(seen.rail, y, axis=1)[k, number]
        along = np.gradient(seen.rail, fine, axis=0)[k, number]
        z = seen.rail[k, number] + np.nan_to_num(along) * (x - fine[k])
        return x, z, gap, np.arctan(np.nan_to_num(slope))

    @cached_property
    def outlines(self) -> tuple[Outline, Outline]:
        """Rail and wheel where they are nearest on each line of rolling; numbers of samples are those of the sections below the
        axle."""
        y, (_, z, gap, _) = self._span, self._nearest
        of_rail, of_wheel = self.rail.samples[0], self.wheel.samples[0] + self.position.y
        there = np.isfinite(gap)
        rail, wheel = (np.where(there, _numbers(samples, y), np.nan) for samples in (of_rail, of_wheel))
        return Outline(y, np.where(there, z, np.nan), rail), Outline(y, np.where(there, z - gap, np.nan), wheel)

    @cached_property
    def ahead(self) -> Array:
        return self._nearest[0]

    @property
    def gap(self) -> Array:
        return self._nearest[2]

    @property
    def angle(self) -> Array:
        return self._nearest[3]

    def lowered(self, by: float) -> Facing:
        return replace(self, position=replace(self.position, z=self.position.z + by), other=self.other or self)


@lru_cache(maxsize=8)
def _rail_heights(rail: RailSide, x: tuple[float, ...], y: tuple[float, ...]) -> Array:
    return rail_heights(rail, np.array(x), np.array(y))


def _numbers(samples: Array, y: Array) -> Array:
    """Numbers of the samples nearest to places y, among those that y of an outline passes in one direction."""
    order = np.argsort(samples, kind="stable")
    return np.interp(y, samples[order], order.astype(float))


def _least(heights: FacingHeights) -> tuple[Array, Array]:
    """x (m) where the bodies are nearest on each line across, the mean over what is hardly less near, and the least gap (m), by
    the parabola through three places ahead."""
    gap, x, number = heights.gap, heights.x, np.arange(len(heights.y))
    k = np.clip(np.argmin(gap, axis=0), 1, len(x) - 2)
    before, here, after = (gap[k + step, number] for step in (-1, 0, 1))
    with np.errstate(invalid="ignore"):
        bend = before - 2.0 * here + after
        share = np.where(np.isfinite(bend) & (bend > 0.0), np.clip(0.5 * (before - after) / np.where(bend > 0.0, bend, 1.0),
                                                                   -1.0, 1.0), 0.0)
        value = here - np.where(share != 0.0, 0.25 * (before - after) * share, 0.0)
    least = gap.min(axis=0)
    near = np.maximum(np.where(np.isfinite(least), least, 0.0) + SOFT - gap, 0.0)
    total = near.sum(axis=0)
    middle = np.where((near > 0.0).sum(axis=0) > 2, x @ near / np.where(total > 0.0, total, 1.0), x[k] + share * (x[1] - x[0]))
    return middle, np.where(np.isfinite(here), np.minimum(value, gap.min(axis=0)), np.inf)


@dataclass(frozen=True)
class LocalRail(RailSide):
    """A straight rail in the axes of a patch, with the samples `own` (4, n)."""

    own: Array = field(default_factory=lambda: np.zeros((4, 0)), compare=False)

    @cached_property
    def samples(self) -> Array:
        return self.own


@dataclass(frozen=True)
class VaryingPatch(PatchSurface):
    """A patch on surfaces that change along rolling, in the axes of the wheelset's position `stands`; `departs`(x, y) (m, in
    these axes) is by how much they are closer, along the normal, than its straight rail and its wheel of revolution."""

    stands: Position = Position()  # noqa: RUF009 (it is frozen)
    departs: Callable[[Array, Array], Array] = field(default=lambda x, y: 0.0 * x, compare=False)

    @property
    def position(self) -> Position:
        return self.stands

    def _lines(self, s: Array, within: float) -> tuple[Array, Array, Array, Array]:
        """On lines of rolling above s: places x (n, m) around the least gap of the bare bodies, the gap there, and the x and
        the value of its least one."""
        middle = PatchSurface.locus_x(self, s) + self.x
        x = middle + within * np.linspace(-1.0, 1.0, LINE)[:, None]
        y = self.places(s)[:, 1]
        gap = PatchSurface.gap(self, x, s) - self.departs(x, np.broadcast_to(y, x.shape))
        place, least = _least(FacingHeights(np.linspace(-within, within, LINE), s, gap, np.zeros(gap.shape)))
        return x, gap, middle + place, least

    @property
    def follows(self) -> bool:
        return True

    @property
    def _lies(self) -> Position:
        return self.facing.position

    @cached_property
    def overlap(self) -> tuple[float, float]:
        s = np.linspace(*self.overlapping, 201)
        least = self._lines(s, AROUND)[3]
        k = int(np.nanargmin(least))
        return -float(least[k]), float(s[k])

    @cached_property
    def _known(self) -> tuple[tuple[Array, Array, Array, Array], Departure]:
        """`table` and `heights`."""
        s, *_ = super().table
        x, gap, place, least = self._lines(s, AROUND)
        # As far as the bodies would overlap three times as deep.
        deep = max(self.overlap[0], SHALLOW)
        reached = np.abs(x - place)[gap < np.minimum(least + 2.0 * deep, 2.0 * deep)]
        within = min(1.2 * max(float(reached.max(initial=0.0)), math.sqrt(2.0 * self.facing.wheel.radius * deep)), AROUND)
        away = within * np.linspace(-1.0, 1.0, LINE)[:, None]
        y = self.places(s)[:, 1]
        gap = PatchSurface.gap(self, place + away, s) - self.departs(place + away, np.broadcast_to(y, away.shape[:1] + y.shape))
        bend = 0.5 * np.cos(self.inclination(s)) / self.facing.wheel.radius
        closer = np.nan_to_num(least + bend * away**2 - gap, posinf=0.0, neginf=0.0)
        along, across, middle = (tuple((-places[::-1]).tolist()) for places in (away[:, 0], s, place))
        return ((s, least, place, np.stack((bend, 0.0 * s, 0.0 * s))),
                Departure(along, across, middle, tuple(map(tuple, closer[::-1, ::-1].tolist()))))

    @property
    def table(self) -> tuple[Array, Array, Array, Array]:
        """As of PatchSurface, with the curvature along rolling of a wheel on a straight rail alone."""
        return self._known[0]

    @cached_property
    def heights(self) -> Closing:
        rolled = super().heights
        return self._known[1] if rolled is None else Together((self._known[1], rolled))


def varying_patch(facing: Facing, low: float, high: float, ridges: tuple[float, float], *, x: float, y: float, z: float,
                  angle: float, shares: tuple[float, float], curved: bool) -> PatchSurface:
    """The patch of a `facing` at a place, as of PatchSurface; on surfaces that change, in axes of its own."""
    if not isinstance(facing, VaryingFacing):
        return PatchSurface(facing, low, high, ridges, x, y, z, angle, shares, curved)
    around = np.linspace(x - AROUND, x + AROUND, STATIONS)
    room = 0.5 * (high - low) + 4.0 * NEAR
    span = facing.outlines[0].y
    across = np.linspace(max(low - room, float(span[0])), min(high + room, float(span[-1])), ACROSS)
    real = facing.heights(around, across)
    middle, here = STATIONS // 2, int(np.argmin(np.abs(across - y)))
    slope = float(np.gradient(real.rail[:, here], around)[middle])
    tilt = math.atan(slope) if math.isfinite(slope) else 0.0
    stands = replace(facing.position, ahead=x, tilt=tilt, lift=z)
    c = math.cos(tilt)
    section = facing.rail.section(x)
    samples = section.samples * np.array([1.0, c, 1.0, c])[:, None] - np.array([0.0, c * z, 0.0, 0.0])[:, None]
    rail = LocalRail(**{name: getattr(section, name) for name in RailSide.__dataclass_fields__}, own=samples)
    # The wheel of revolution that has the outline of the place, moved to where the real one lies.
    origin = facing.position.origin(facing.wheel.radius)
    wheel = facing.wheel.section(math.atan2(x - origin[0], z - origin[2]))
    bare = Facing(rail, wheel, stands)
    locus = bare.locus
    k = int(np.nanargmin(np.abs(locus[1] - y) + 0.1 * np.abs(locus[2])))
    apart = c * (float(np.interp(y, across, real.wheel[middle])) - z) - float(locus[2, k])
    shift = stands.turn @ np.array([-float(locus[0, k]), 0.0, apart])
    moved = replace(stands, x=stands.x + float(shift[0]), z=stands.z + float(shift[2]))
    level = replace(moved, ahead=0.0, tilt=0.0, lift=0.0)
    assumed = wheel_heights(wheel, level, around, across)
    straight = real.rail[middle] + slope * (around - x)[:, None]
    inclined = np.cos(np.arctan(np.nan_to_num(np.gradient(real.rail[middle], across))))
    closer = np.nan_to_num(((real.wheel - assumed) - (real.rail - straight)) * c * inclined)
    spline = scipy.interpolate.RegularGridInterpolator((around - x, across), closer, bounds_error=False, fill_value=None)

    def departs(along: Array, at: Array) -> Array:
        return np.asarray(spline(np.stack((np.clip(c * along, -AROUND, AROUND), np.clip(at, across[0], across[-1])), axis=-1)))

    return VaryingPatch(replace(bare, position=moved), low, high, ridges, x, y, 0.0, math.atan(c * math.tan(angle)), shares,
                        curved, stands, departs)

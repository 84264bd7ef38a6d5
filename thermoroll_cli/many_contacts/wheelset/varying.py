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

from thermoroll_cli.many_contacts.wheelset.curves import STEP, Outline, outline
from thermoroll_cli.many_contacts.wheelset.patch_surface import CLOSE, NEAR, PatchSurface
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, Side, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.surface import Closing, Departure, Together, joined
from thermoroll_cli.tools.arrays import Array

REACH, COARSE, FINE = 0.2, 2.5e-3, 2.5e-4
"""How far ahead the bodies may touch, as the sine of the angle around the wheel (rails that rise by 1:5), and distances (m) of
the places ahead that are looked at, everywhere and around first contact."""
CLOSE_BY, ROOM = 1e-3, 6e-3
"""Gap over that of first contact (m) of lines that are looked at more closely, up to this way (m) beyond where they are
nearest."""
AROUND, SIDEWAYS = 0.04, 1e-4
"""Way (m) along rolling on either side of a patch on which its surfaces are known, `FINE` apart, and the distance (m) of the
places across there."""
ROUGH, ASIDE = 4, 0.01
"""Of so many lines one is looked at everywhere. Around first contact and patches, lines of the wheel this far (m) beside count,
as yaw moves them."""
FIRST_SWEEPS, SWEEPS = 4, 2
"""Rounds for the angle of a wheel's line at a place ahead, as its radius changes with it, at the first place and from that of
the place before: each adds a digit at least."""
MOST_ACROSS = 1200
"""Lines of rolling at most that are looked at everywhere."""
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


def rail_heights(rail: RailSide, x: Array, y: Array, every: int = 1) -> Array:
    """The highest z of a rail at places ahead of the axle and across, (nx, ny), by one of so many lines."""
    if rail.slices is None:
        return np.broadcast_to(_seen(rail.samples[:2], y, lowest=False), (len(x), len(y)))
    return np.array([_seen(rail.lines(at)[:, ::every], y, lowest=False) for at in x.tolist()])


def wheel_heights(wheel: WheelSide, position: Position, x: Array, y: Array, every: int = 1) -> Array:
    """The lowest z of a wheel at places ahead of the axle and across, (nx, ny), by one of so many lines."""
    rotation, origin = position.rotation, position.origin(wheel.radius)
    across, radius = wheel.lines(0.0)
    # Those that may be seen at these places.
    part = _within(rotation[1, 1] * across + rotation[1, 2] * radius + origin[1], y[0] - ASIDE, y[-1] + ASIDE, every)
    own, r = across[part], radius[part]
    rows: list[Array] = []
    for at in x.tolist():
        # x = R₀₀ r sin θ + R₀₁ y + O_x of each line; R₀₂ = 0 on a level track.
        for _ in range((SWEEPS if rows else FIRST_SWEEPS) if wheel.slices else 1):
            sine = (at - origin[0] - rotation[0, 1] * own) / (rotation[0, 0] * r)
            angle = np.arcsin(np.clip(sine, -1.0, 1.0))
            if wheel.slices:
                own, r = wheel.lines(angle, part)
        local = np.array([r * sine, own, r * np.cos(angle)])
        rows.append(_seen(rotation[1:] @ local + origin[1:, None], y, lowest=True))
    return np.array(rows)


def _within(places: Array, low: float, high: float, every: int = 1) -> slice:
    """The numbers of `places` from the first to the last one between two bounds, and one more on either side; one of so
    many."""
    inside = np.flatnonzero((places >= low) & (places <= high))
    return slice(max(int(inside[0]) - 1, 0), int(inside[-1]) + 2, every) if len(inside) else slice(0, 0)


def _seen(lines: Array, y: Array, *, lowest: bool) -> Array:
    """Heights at the places y of those of `lines` (y, z) that lie nearest to the other body."""
    across, z = lines[:, _within(lines[0], float(y[0]), float(y[-1]))]
    return outline(across, z, y, lowest=lowest).z if len(across) > 1 else np.full(len(y), np.nan)


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

    def heights(self, x: Array, y: Array, every: int = 1) -> FacingHeights:
        """Both surfaces at places ahead of the axle and across, by one of so many lines."""
        return FacingHeights(x, y, rail_heights(self.rail, x, y, every), wheel_heights(self.wheel, self.position, x, y, every))

    @cached_property
    def _nearest(self) -> tuple[Array, Array, Array, Array]:
        """Over the places across: x where the bodies are nearest, z of the rail there, the gap, and the inclination of the
        rail."""
        x, z, gap, angle = _nearest_of(replace(self, position=replace(self.position, z=0.0), other=None))
        return x, z, gap - self.position.z, angle

    def around(self, x: float, low: float, high: float) -> FacingHeights:
        """Both surfaces around a place x (m) and between places across (m), which are kept for the next one near by."""
        place, ends = round(x / ROOM), (math.floor(1e3 * low), math.ceil(1e3 * high))
        found = _around(replace(self, position=replace(self.position, z=0.0), other=None), place, ends)
        return found._replace(wheel=found.wheel + self.position.z)

    def nearest_at(self, y: Array, x: Array, every: int = 1) -> tuple[Array, Array, Array, Array]:
        """As `_nearest` at the places y, by what is seen at the equally spaced places x and by one of so many lines."""
        seen = self.heights(x, y, every)
        place, gap = _least(seen)
        k, number = np.clip(np.rint((place - x[0]) / (x[1] - x[0])).astype(int), 0, len(x) - 1), np.arange(len(y))
        k = np.where(np.isnan(seen.rail[k, number]), np.argmin(seen.gap, axis=0), k)
        slope, along = (np.nan_to_num(np.gradient(seen.rail, at, axis=axis)[k, number]) for at, axis in ((y, 1), (x, 0)))
        return place, seen.rail[k, number] + along * (place - x[k]), gap, np.arctan(slope)

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


@lru_cache(maxsize=64)
def _nearest_of(facing: VaryingFacing) -> tuple[Array, Array, Array, Array]:
    """`_nearest` of a wheel at z = 0: all places ahead are looked at on a few lines, those around first contact closely."""
    y, reach = facing._span, REACH * facing.wheel.radius
    every = max(len(y) // MOST_ACROSS, 1)
    coarse = facing.nearest_at(y[::every], _multiples(COARSE, -reach, reach), ROUGH)
    found = np.array(coarse)[:, np.minimum(np.rint(np.arange(len(y)) / every).astype(int), len(coarse[0]) - 1)]
    close = np.convolve(found[2] < found[2].min() + CLOSE_BY, np.ones(2 * every + 5), "same") > 0.5
    x = found[0, close]
    found[:, close] = facing.nearest_at(y[close], _multiples(FINE, x.min() - ROOM, x.max() + ROOM))
    return found[0], found[1], found[2], found[3]


def _multiples(step: float, low: float, high: float) -> Array:
    """Those of a `step` between two bounds: what is symmetric about x = 0 stays so."""
    return np.asarray(step * np.arange(math.floor(low / step), math.ceil(high / step) + 1), float)


@lru_cache(maxsize=8)
def _around(facing: VaryingFacing, place: int, ends: tuple[int, int]) -> FacingHeights:
    """Both surfaces, of a wheel at z = 0, around a place in `ROOM` and between places across in mm."""
    span, reach = facing._span, AROUND + 0.5 * ROOM
    # At its very end a line may miss its surface by rounding.
    low, high = max(1e-3 * ends[0], float(span[0]) + CLOSE), min(1e-3 * ends[1], float(span[-1]) - CLOSE)
    return facing.heights(_multiples(FINE, place * ROOM - reach, place * ROOM + reach),
                          np.linspace(low, high, max(math.ceil((high - low) / SIDEWAYS), 2) + 1))


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
    these axes) is by how much they are closer, along the normal, than its straight rail and its wheel of revolution; nan where
    one is missing. It is a patch `of` the real wheel over the real rail."""

    of: VaryingFacing | None = field(default=None, compare=False)
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
    def bodies(self) -> tuple[Side, Side]:
        assert self.of is not None
        return self.of.rail, self.of.wheel

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
        # A line on which a body is missing all along has its neighbour's; `heights` lack it.
        there = np.isfinite(least)
        place, least = (np.interp(s, s[there], values[there]) for values in (place, least))
        # As far as the bodies would overlap three times as deep.
        deep = max(self.overlap[0], SHALLOW)
        reached = np.abs(x - place)[gap < np.minimum(least + 2.0 * deep, 2.0 * deep)]
        within = min(1.2 * max(float(reached.max(initial=0.0)), math.sqrt(2.0 * self.facing.wheel.radius * deep)), AROUND)
        away = within * np.linspace(-1.0, 1.0, LINE)[:, None]
        y = self.places(s)[:, 1]
        gap = PatchSurface.gap(self, place + away, s) - self.departs(place + away, np.broadcast_to(y, away.shape[:1] + y.shape))
        bend = 0.5 * np.cos(self.inclination(s)) / self.facing.wheel.radius
        closer = least + bend * away**2 - gap
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
    room = 0.5 * (high - low) + 4.0 * NEAR
    real = facing.around(x, low - room, high + room)
    across, here = real.y, int(np.argmin(np.abs(real.y - y)))
    rail_here = rail_heights(facing.rail, x + FINE * np.array([-1.0, 0.0, 1.0]), across)
    slope = float(rail_here[2, here] - rail_here[0, here]) / (2.0 * FINE)
    if not math.isfinite(slope):
        slope = 0.0
    tilt = math.atan(slope)
    stands = replace(facing.position, ahead=x, tilt=tilt, lift=z)
    c = math.cos(tilt)
    section = facing.rail.section(x)
    samples = section.samples * np.array([1.0, c, 1.0, c])[:, None] - np.array([0.0, c * z, 0.0, 0.0])[:, None]
    rail = LocalRail(**{name: getattr(section, name) for name in RailSide.__dataclass_fields__}, own=samples)
    wheel, moved, assumed = facing.wheel, stands, real.wheel
    if wheel.slices is not None:
        # The wheel of revolution that has the outline of the place, moved to where the real one lies.
        origin = facing.position.origin(wheel.radius)
        wheel = wheel.section(math.atan2(x - origin[0], z - origin[2]))
        locus = Facing(rail, wheel, stands).locus
        k = int(np.nanargmin(np.abs(locus[1] - y) + 0.1 * np.abs(locus[2])))
        wheel_here = wheel_heights(facing.wheel, facing.position, np.array([x]), across)[0]
        apart = c * (float(np.interp(y, across, wheel_here)) - z) - float(locus[2, k])
        shift = stands.turn @ np.array([-float(locus[0, k]), 0.0, apart])
        moved = replace(stands, x=stands.x + float(shift[0]), z=stands.z + float(shift[2]))
        assumed = wheel_heights(wheel, replace(moved, ahead=0.0, tilt=0.0, lift=0.0), real.x, across)
    straight = rail_here[1] + slope * (real.x - x)[:, None]
    inclined = np.cos(np.arctan(np.nan_to_num(np.gradient(rail_here[1], across))))
    closer = joined(real.x - x, across, ((real.wheel - assumed) - (real.rail - straight)) * c * inclined)

    def departs(along: Array, at: Array) -> Array:
        return closer(c * along, at)

    return VaryingPatch(Facing(rail, wheel, moved), low, high, ridges, x, y, 0.0, math.atan(c * math.tan(angle)), shares,
                        curved, facing, stands, departs)

"""What closes a gap beside smooth shapes: heights of a body over its own, roughness, waves, dents, flats, and by how much the
surfaces of a patch depart from its wheel of revolution on a straight rail.

Heights are positive out of the body, in m, and functions of u, the distance along the surface in the order in which its points
come into the contact, and of y across rolling. The material of a body that has moved by s stands in the contact's frame at
x = s − u. Each element of a grid sees its mean height: coarse grids then see a smoother surface, and errors fall with the
square of the elements.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy

from thermoroll_cli.tools.arrays import AnyArray, Array

DEGREE = 3
"""Of the splines through measured heights."""
COUNTS = 0.01
"""Share of the squared slope below which waves do not count."""
BIN = 1.05
"""Ratio of wave numbers that are told apart."""
MISSING = 1.0
"""Gap (m) where a surface is missing."""
AROUND, SAMPLES = 3.0, 192
"""Sides of the surroundings of a dent or a flat in its radii or half-lengths, and points along them, of its texture."""


@dataclass(frozen=True, eq=False)
class Texture:
    """How rough heights are: root mean squares of height (m) and slope, their `range` (m), and the squared slopes `power` of
    waves with the wave numbers `waves` (2, n) in rad/m along and across. `filled` is the share of points that had no height and
    got that of those around: there the surface is smoother than it was."""

    rms: float
    range: float
    waves: Array
    power: Array
    filled: float = 0.0

    @classmethod
    def of(cls, heights: Array, spacing: tuple[float, float], *, repeats: bool = False) -> Texture:
        """The texture of `heights` (n, m) in m at points `spacing` (m) apart; if they `repeat`, in both directions."""
        level = heights - heights.mean()
        if not repeats:
            # Ends that do not fit would look like short waves.
            windows = [np.hanning(count + 2)[1:-1] if count > 2 else np.ones(count) for count in heights.shape]
            level = level * np.multiply.outer(*(window / math.sqrt(np.mean(window**2)) for window in windows))
        size = np.abs(np.fft.rfft2(level)) ** 2
        size *= 2.0 / level.size**2
        size[:, 0] *= 0.5
        if heights.shape[1] % 2 == 0:
            size[:, -1] *= 0.5
        along = 2.0 * math.pi * np.abs(np.fft.fftfreq(heights.shape[0], spacing[0]))
        across = 2.0 * math.pi * np.fft.rfftfreq(heights.shape[1], spacing[1])
        size *= along[:, None] ** 2 + across**2
        # Waves of nearly the same wave numbers are one, with their mean.
        bins = [_bins(np.asarray(k)) for k in (along, across)]
        power = _sums(size, *bins)
        places = [_sums(size * k, *bins) for k in (along[:, None], across)]
        there = power > 0.0
        return cls(float(np.sqrt(np.mean((heights - heights.mean()) ** 2))), float(np.ptp(heights)),
                   np.array([place[there] / power[there] for place in places]), power[there])

    @property
    def slope(self) -> float:
        """Root mean square of the slope."""
        return math.sqrt(float(self.power.sum()))

    @property
    def shortest(self) -> float:
        """The wavelength (m) below which there is a hundredth of the squared slope; inf of a level surface."""
        lengths = np.hypot(*self.waves)
        order = np.argsort(-lengths)
        share = np.cumsum(self.power[order])
        if not share.size or lengths[order[0]] == 0.0:
            return math.inf
        return 2.0 * math.pi / float(lengths[order[np.searchsorted(share, COUNTS * share[-1])]])

    def unseen(self, dx: float, dy: float) -> float:
        """Root mean square of the slopes that means over elements of dx × dy (m) do not see."""
        width = (dx, 0.0 if math.isinf(dy) else dy)
        seen = math.prod(np.sinc(k * size / (2.0 * math.pi)) ** 2 for k, size in zip(self.waves, width, strict=True))
        return math.sqrt(float((self.power * (1.0 - seen)).sum()))


def _bins(waves: AnyArray) -> AnyArray:
    """The number of the bin of each wave number, whose bins grow by `BIN`."""
    least = float(waves[waves > 0.0].min(initial=math.inf))
    if math.isinf(least):
        return np.zeros(waves.size, dtype=int)
    return np.where(waves > 0.0, np.round(np.log(np.maximum(waves, least) / least) / math.log(BIN)).astype(int) + 1, 0)


def _sums(values: Array, along: AnyArray, across: AnyArray) -> Array:
    """Sums of `values` (n, m) over the bins of rows and columns."""
    rows = np.zeros((int(along.max()) + 1, values.shape[1]))
    np.add.at(rows, along, values)
    found = np.zeros((int(across.max()) + 1, rows.shape[0]))
    np.add.at(found, across, rows.T)
    return found


class Closing(Protocol):
    """What closes a gap, known everywhere: of a `Problem` what rolls through its contact, of a `CurvedPatch` a part of its
    shape."""

    def over(self, along: Array, across: Array) -> Array:
        """Mean heights in m, (n, m), over the rectangles between rising places in m: `along` (n + 1,), `across` (m + 1,). The
        one rectangle of a line contact goes from −inf to inf across."""
        ...


class Heights(Closing, Protocol):
    """Heights of a body, over u in place of x."""

    @property
    def texture(self) -> Texture:
        """How rough they are."""
        ...


@dataclass(frozen=True)
class Departure:
    """By how much surfaces are `closer` (n, m) in m than those of the shape, at the distances `along` (n,) from the place
    `middle` (m,) of each line `across` (m,), all in m, `joined`; nan where a surface is missing. Elements see it at their
    centres, as they see the shape."""

    along: tuple[float, ...]
    across: tuple[float, ...]
    middle: tuple[float, ...]
    closer: tuple[tuple[float, ...], ...]

    def __hash__(self) -> int:
        # A sample: hashing all costs more than most cached results.
        return hash((self.along[0], self.across[0], self.middle[:: 1 + len(self.middle) // 16]))

    @cached_property
    def _splines(self) -> tuple[scipy.interpolate.CubicSpline, Callable[[Array, Array], Array]]:
        return (scipy.interpolate.CubicSpline(self.across, self.middle),
                joined(np.array(self.along), np.array(self.across), np.array(self.closer)))

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        middle, closer = self._splines
        x, y = (0.5 * (ends[1:] + ends[:-1]) for ends in (along, across))
        y = np.clip(y, self.across[0], self.across[-1])
        return np.nan_to_num(closer(x[:, None] - middle(y), np.broadcast_to(y, (len(x), len(y)))), nan=-MISSING)


def joined(along: Array, across: Array, values: Array) -> Callable[[Array, Array], Array]:
    """A function of places (…) along and across through `values` (n, m) at `along` (n,) and `across` (m,), a spline along and
    straight across; beyond their ends as there, nan where the nearest value is."""
    missing, filled = np.isnan(values), values.copy()
    for column in np.flatnonzero(missing.any(axis=0)):
        # So that splines do not swing at the end of a surface, it goes on straight.
        there = np.flatnonzero(~missing[:, column])
        first, last = (there[0], there[-1]) if len(there) else (0, 0)
        filled[:, column] = np.interp(along, along[there], values[there, column]) if len(there) else 0.0
        if len(there) > 1:
            for end, step, beyond in ((first, 1, slice(0, first)), (last, -1, slice(last + 1, None))):
                slope = (values[end, column] - values[end + step, column]) / (along[end] - along[end + step])
                filled[beyond, column] = values[end, column] + slope * (along[beyond] - along[end])
    spline = scipy.interpolate.RectBivariateSpline(along, across, filled, ky=1)

    def at(x: Array, y: Array) -> Array:
        x, y = np.clip(x, along[0], along[-1]), np.clip(y, across[0], across[-1])
        found = spline.ev(x, y)
        if missing.any():
            nearest = (np.searchsorted(0.5 * (places[1:] + places[:-1]), at) for places, at in ((along, x), (across, y)))
            found = np.where(missing[tuple(nearest)], np.nan, found)
        return np.asarray(found)

    return at


@dataclass(frozen=True)
class SurfacesInContact:
    """Surfaces of bodies in the contact, each with how far it has moved (m) along x and along y: heights along x instead of u,
    the sum of which closes the gap."""

    surfaces: tuple[tuple[Heights, tuple[float, float]], ...]

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        return np.sum([surface.over((moved - along)[::-1], across - sideways)[::-1]
                       for surface, (moved, sideways) in self.surfaces], axis=0)


@dataclass(frozen=True)
class Together:
    """The sum of several `parts`."""

    parts: tuple[Closing, ...]

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        return np.sum([part.over(along, across) for part in self.parts], axis=0)


@dataclass(frozen=True)
class Shifted:
    """What closes the gap `of` another frame, whose y = 0 lies at y = `by` (m)."""

    of: Closing
    by: float

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        return self.of.over(along, across - self.by)


@dataclass(frozen=True)
class Sum(Together):
    """The sum of several surfaces of one body."""

    parts: tuple[Heights, ...]

    @cached_property
    def texture(self) -> Texture:
        """That of independent surfaces together."""
        each = [part.texture for part in self.parts]
        return Texture(math.hypot(*(one.rms for one in each)), sum(one.range for one in each),
                       np.concatenate([one.waves for one in each], axis=1), np.concatenate([one.power for one in each]),
                       max(one.filled for one in each))


@dataclass(frozen=True, eq=False)
class MeasuredHeights:
    """`heights` (n, m) in m at points `spacing` (m) apart along u and y, joined by a spline. The first one lies at u = `start`,
    y = `side`. Where it `repeats` (along, across) it comes again and again; else the body is smooth beyond its ends. One column
    is the same at all y. The share `filled` of the points had no height."""

    heights: Array
    spacing: tuple[float, float]
    start: float = 0.0
    side: float = 0.0
    repeats: tuple[bool, bool] = (False, False)
    filled: float = 0.0
    _columns: dict[bytes, Callable[[Array], Array]] = field(default_factory=dict, repr=False)

    @cached_property
    def texture(self) -> Texture:
        """How rough they are."""
        repeats = self.repeats[0] and (self.repeats[1] or self.heights.shape[1] == 1)
        return replace(Texture.of(self.heights, self.spacing, repeats=repeats), filled=self.filled)

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        key = across.tobytes()
        if key not in self._columns:
            # Steps without lateral creepage ask for the same columns again.
            self._columns.clear()
            columns = self.heights if self._across is None else (
                np.diff(self._across(across - self.side), axis=0) / np.diff(across)[:, None]).T
            self._columns[key] = integral_of(columns, self.spacing[0], repeats=self.repeats[0])
        integral = self._columns[key](along - self.start)
        means = np.diff(integral, axis=0) / np.diff(along)[:, None]
        return np.asarray(np.broadcast_to(means, (len(along) - 1, len(across) - 1)))

    @cached_property
    def _across(self) -> Callable[[Array], Array] | None:
        if self.heights.shape[1] == 1:
            return None
        return integral_of(self.heights.T, self.spacing[1], repeats=self.repeats[1])


def integral_of(values: Array, spacing: float, *, repeats: bool) -> Callable[[Array], Array]:
    """The integral from 0 to any place (m), (k,) → (k, m), of the spline through `values` (n, m) at points `spacing` (m) apart
    from 0 on; beyond them they repeat, or are zero."""
    mean = values.mean(axis=0) if repeats else np.zeros(values.shape[1])
    values = np.concatenate([values, values[:1]]) - mean if repeats else values
    points, count = spacing * np.arange(len(values)), len(values)
    if count == 1:
        return lambda places: np.zeros((len(places), values.shape[1]))
    periodic = repeats and count > DEGREE
    spline = scipy.interpolate.make_interp_spline(
        points, values, k=min(DEGREE, count - 1) if periodic or not repeats else 1, bc_type="periodic" if periodic else None)
    integral = spline.antiderivative()

    def between(places: Array) -> Array:
        inside = places % points[-1] if repeats else np.clip(places, 0.0, points[-1])
        return np.asarray(integral(inside) + (mean * places[:, None] if repeats else 0.0))

    return between


@dataclass(frozen=True)
class Wave:
    """A wave of an `amplitude` and a `length` (m) whose crest lies at u = `start`, y = `side`; its direction is turned by an
    `angle` (rad) from u towards y."""

    amplitude: float
    length: float
    angle: float = 0.0
    start: float = 0.0
    side: float = 0.0

    @property
    def texture(self) -> Texture:
        """A single wave."""
        k = 2.0 * math.pi / self.length
        waves = np.abs([[k * math.cos(self.angle)], [k * math.sin(self.angle)]])
        return Texture(abs(self.amplitude) / math.sqrt(2.0), 2.0 * abs(self.amplitude), waves,
                       np.array([0.5 * (k * self.amplitude) ** 2]))

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`: the wave at the centre, less what its mean loses."""
        k = 2.0 * math.pi / self.length
        mean = self.amplitude * np.ones((len(along) - 1, len(across) - 1), dtype=complex)
        # Waves along or across have no other part: sin π is not 0, and the width of a line contact is infinite.
        parts = (round(math.cos(self.angle), 15), along - self.start), (round(math.sin(self.angle), 15), across - self.side)
        for axis, (share, ends) in enumerate(parts):
            if share:
                middle, width = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)
                factor = np.exp(1j * share * k * middle) * np.sinc(share * width / self.length)
                mean *= factor[:, None] if axis == 0 else factor
        return mean.real


@dataclass(frozen=True)
class Dent:
    """A round dent of a `depth` and a `radius` (m) with a `shoulder` (m) around it and the centre u = `start`, y = `side`,

        h = (c q − d) exp(−q),   q = r²/R²,

    with the c that makes the shoulder the largest height. A negative depth is a bump. It comes again after each `turn` (m; inf:
    once)."""

    depth: float
    radius: float
    shoulder: float = 0.0
    start: float = 0.0
    side: float = 0.0
    turn: float = math.inf

    @cached_property
    def texture(self) -> Texture:
        """That of its surroundings."""
        ends = AROUND * self.radius * np.linspace(-1.0, 1.0, SAMPLES + 1)
        around = self.over(ends + self.start, ends + self.side)
        return Texture.of(around, (float(ends[1] - ends[0]),) * 2, repeats=True)

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`; in closed form, since a Gaussian is a product of one along and one across."""
        if math.isfinite(self.turn):
            along = along - self.turn * round((0.5 * float(along[0] + along[-1]) - self.start) / self.turn)
        (one, square), (other, square_across) = (
            _gaussian_means((ends - centre) / self.radius) for ends, centre in ((along, self.start), (across, self.side)))
        rise = self._rise
        return np.asarray(np.outer(rise * square - self.depth * one, other) + rise * np.outer(one, square_across))

    @cached_property
    def _rise(self) -> float:
        """c in m: the largest height is c exp(−1 − d/c)."""
        if self.shoulder <= 0.0:
            return 0.0
        # d/c = W(e⁻¹ d/S)
        ratio = float(scipy.special.lambertw(self.depth / (math.e * self.shoulder)).real)
        return math.e * self.shoulder * math.exp(ratio)


def _gaussian_means(ends: Array) -> tuple[Array, Array]:
    """Means of exp(−t²) and t² exp(−t²) between the `ends`."""
    area, bell, width = 0.5 * math.sqrt(math.pi) * scipy.special.erf(ends), np.exp(-(ends**2)), np.diff(ends)
    return np.diff(area) / width, np.diff(0.5 * (area - ends * bell)) / width


@dataclass(frozen=True)
class Flat:
    """A flat of a `length` (m), of any width, on a body of the `radius` (m), with its middle at u = `start`: a chord in place
    of the arc, whose corners are rounded over `rounding` (m). It comes again after each `turn` (m; inf: once)."""

    length: float
    radius: float
    rounding: float
    start: float = 0.0
    turn: float = math.inf

    @property
    def depth(self) -> float:
        """Largest depth without rounding in m."""
        return self.length**2 / (8.0 * self.radius)

    @cached_property
    def texture(self) -> Texture:
        """That of its surroundings."""
        ends = 0.5 * AROUND * self.length * np.linspace(-1.0, 1.0, SAMPLES + 1)
        return Texture.of(replace(self, turn=math.inf).over(ends + self.start, np.array([0.0, 1.0])),
                          (float(ends[1] - ends[0]), 1.0), repeats=True)

    def over(self, along: Array, across: Array) -> Array:
        """As `Closing.over`."""
        places = along - self.start
        if math.isfinite(self.turn):
            turns = np.round(places / self.turn)
            integral = self._integral(places - turns * self.turn) - turns * self.length**3 / (12.0 * self.radius)
        else:
            integral = self._integral(places)
        return np.repeat((np.diff(integral) / np.diff(along))[:, None], len(across) - 1, axis=1)

    def _integral(self, places: Array) -> Array:
        """The integral of the mean of the sharp flat over `rounding` about each place, odd in the places."""
        half = 0.5 * self.rounding
        if half == 0.0:
            return self._sharp(places, 1)
        return np.asarray((self._sharp(places + half, 2) - self._sharp(places - half, 2)) / self.rounding)

    def _sharp(self, places: Array, order: int) -> Array:
        """The first or second integral from 0 of −(L²/4 − u²)/2R within the flat."""
        end = 0.5 * self.length
        inside, beyond = np.clip(places, -end, end), np.abs(places) - end
        once = (inside**3 / 3.0 - end**2 * inside) / (2.0 * self.radius)
        if order == 1:
            return np.asarray(once)
        twice = (inside**4 / 12.0 - end**2 * inside**2 / 2.0) / (2.0 * self.radius)
        return np.asarray(twice - np.maximum(beyond, 0.0) * np.abs(once))


def length_words(length: float) -> str:
    """A length (m) as people write it."""
    return f"{1e6 * length:.3g} µm" if length < 1e-3 else f"{1e3 * length:.3g} mm"


def edges(places: AnyArray, width: float) -> Array:
    """Borders of elements of a `width` (m) about the centres `places` (m); those of one that has no end lie at infinity."""
    if math.isinf(width):
        return np.array([-math.inf, math.inf])
    return np.append(places - 0.5 * width, places[-1] + 0.5 * width)

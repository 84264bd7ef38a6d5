"""The surfaces of both bodies and the gap between them: radii and transverse profiles.

`ContactGeometry` is what a contact asks of its geometry; `Geometry` answers for bodies whose common surface is a plane,
`curved_patch.CurvedPatch` if it is curved across rolling.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal, Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike

from thermoroll_cli.problem.rounding import Rounding, rounding_at
from thermoroll_cli.tools.arrays import Array

Interpolation = Literal["cubic", "linear"]

GAP_SAMPLES = 2001
"""Places at which the smallest gap of two profiles is searched for, before it is refined."""
ROUGH = 0.5
"""Share of neighbouring points between which the curvature changes sign, from which a measured profile is rough: as often as
signs at random. With noise that is independent from point to point it is 1/2 + arcsin(2/3)/π = 0.73 on average."""
FEWEST_ROUGH = 6
"""Points below which nothing is said about roughness."""
STRAIGHT = 1e-9
"""Smaller angles (rad) between neighbouring chords are rounding."""
SYMMETRY_TOLERANCE = 1e-9
"""A profile is symmetric if heights on both sides differ by less than this share of their range."""


class Unsolvable(ValueError):
    """A problem that has no contact, or no steady state. `key` is the dotted key of the case file that causes it, perhaps
    together with the key `other`; `allowed` says what would be solved."""

    def __init__(self, message: str, key: str, allowed: str = "", other: str = "") -> None:
        super().__init__(message)
        self.key, self.allowed, self.other = key, allowed, other


def rough_warning(name: str, points: ArrayLike) -> Iterator[str]:
    """A warning if the profile `name` is rough at these `points`, those near its contact."""
    chords = np.diff(np.reshape(points, (-1, 2)), axis=0)
    turns = np.diff(np.unwrap(np.arctan2(chords[:, 1], chords[:, 0])))
    if len(chords) >= FEWEST_ROUGH and (share := float(np.mean(turns[1:] * turns[:-1] < -(STRAIGHT**2)))) >= ROUGH:
        yield (f"the curvature of the profile of the {name} changes sign between {100.0 * share:.0f} % of the neighbouring "
               "points around the contact: it is rough, and so is the pressure; smoothing_mm takes short waves out of it")


@dataclass(frozen=True)
class Profile:
    """Height of a surface over the lateral coordinate, positive out of the body, in m; beyond its ends there is no material.

    Either `points` (y, height), y increasing, joined by a C² spline ("cubic") or by straight lines ("linear"); or, without
    points, a crown of `length` that is flat over `flat` in the middle and falls to both ends by

        drop · ln(1 − ((2|y| − flat)/(length − flat))²)

    (Lundberg's crown without a flat part). `measured` are the points as they were before `smoothing` with this wavelength (m),
    which have no effect; y and height of points are known in `steps` (m). The shape is tilted by `tilt` (rad, a rise towards
    +y) about its own origin and then shifted by `offset` along y. How it is evaluated: `surface`.
    """

    points: tuple[tuple[float, float], ...] = ()
    interpolation: Interpolation = "cubic"
    length: float = 0.0
    drop: float = 0.0
    flat: float = 0.0
    offset: float = 0.0
    tilt: float = 0.0
    measured: tuple[tuple[float, float], ...] = ()
    steps: tuple[float, float] = (0.0, 0.0)
    smoothing: float = 0.0

    def __hash__(self) -> int:
        # A sample of the points: hashing all of them costs more than most cached results.
        some = self.points[:: 1 + len(self.points) // 16]
        return hash((some, self.length, self.drop, self.flat, self.offset, self.tilt))

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest y with material, in m."""
        half = 0.5 * self.length
        low, high = (self.points[0][0], self.points[-1][0]) if self.points else (-half, half)
        return low + self.offset, high + self.offset

    def rounding_at(self, y: float, reach: float) -> Rounding | None:
        """The rounding of the points within the `reach` of a place y, if there is one."""
        points, own = self.measured or self.points, y - self.offset
        if not points or not any(self.steps):
            return None
        return rounding_at(points, self.steps, (own, float(np.interp(own, *np.array(points).T))), reach, self.smoothing)

    @property
    def kinks(self) -> tuple[tuple[float, float], ...]:
        """Place (m) and angle (rad) of each point at which straight lines meet in an edge that sticks out of the body."""
        if self.interpolation == "cubic" or len(self.points) < 3:
            return ()
        y, z = np.array(self.points).T
        turns = -np.diff(np.diff(z) / np.diff(y))
        return tuple((float(at) + self.offset, float(turn)) for at, turn in zip(y[1:-1], turns, strict=True) if turn > 0.0)


class ContactGeometry(Protocol):
    """What a contact asks of the surfaces in it. x is along rolling, y across it, along the common surface of both bodies
    (arc length if that is curved); lengths in m, angles in rad. Instances are immutable, hashable and comparable, because
    problems of equal geometry share solvers."""

    lower_radius_x: float
    upper_radius_x: float
    """Radii of both bodies along rolling; inf is flat, negative is concave."""

    @property
    def curvature_x(self) -> float:
        """Relative curvature 1/R'_x = 1/R_x1 + 1/R_x2 in 1/m."""

    @property
    def elliptic(self) -> bool:
        """Whether the gap is x²/2R'_x + y²/2R'_y, so that the contact of homogeneous bodies is Hertz's."""
        return False

    @property
    def curvature_y(self) -> float:
        """Relative curvature 1/R'_y in 1/m of an elliptic gap."""
        return math.nan

    @property
    def across_radii(self) -> tuple[float, float]:
        """Radii across rolling of the lower and the upper body; inf for other shapes."""
        return math.inf, math.inf

    @property
    def slopes(self) -> tuple[Callable[[Array], Array], ...]:
        """Slope of each body's surface against a plane common surface, as functions of y; empty where that is curved."""
        return ()

    @property
    def profiles(self) -> tuple[tuple[str, Profile], ...]:
        """Bodies with a profile, by name."""
        return ()

    def roundings(self, centre: float, half_width: float) -> tuple[Rounding, ...]:
        """Rounding of the profiles in a contact of this half-width around the place y = `centre`."""
        return ()

    def section(self, y: Array) -> tuple[Array, Array]:
        """Heights of the lower and the upper surface where they touch first, (m,)."""

    @property
    def leans(self) -> bool:
        """Whether the places of the smallest gap on the lines of rolling are not all at x = 0."""
        return False

    @property
    def free_ends(self) -> tuple[bool, bool]:
        """Whether material ends at the lower and the upper one of the `limits`, so that the pressure there has no bound."""

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest y at which both bodies have material. Raises Unsolvable if there is no such place."""

    @property
    def symmetric(self) -> bool:
        """Whether the surfaces are their own mirror image across y = 0."""

    def gap(self, x: Array, y: Array) -> Array:
        """Gap of the unloaded surfaces along the normals of the common surface, up to a constant, (n, m), at all places `x`
        (n,) and `y` (m,); inf where a body has no material."""

    def across(self, y: Array) -> Array:
        """Smallest gap on each line of rolling `y` (m,)."""

    def along(self, depth: float, y: Array) -> tuple[float, float]:
        """Lowest and highest x at which the gap on the lines `y` is below its smallest value plus `depth`."""

    def lateral_place(self, y: Array) -> Array:
        """Coordinate across in the frame, (m,): y itself if the common surface is a plane."""
        return y

    def inclination(self, y: Array) -> Array:
        """Angle α between the common surface and the plane of the frame, (m,): normals are (0, −sin α, cos α)."""
        return np.zeros(np.shape(y))

    def surface_angle(self, shares: tuple[float, float], y: Array) -> Array:
        """Inclination of the surface in which the bodies touch, (m,): `inclination`, or how far it leaves the plane. `shares`
        are those of both bodies in the compliance of the contact."""
        return self.inclination(y)

    def longitudinal_slip(self, shares: tuple[float, float], y: Array) -> Array:
        """Slip s_x/V of the bodies' shapes in addition to creepage and spin, (m,)."""

    def longitudinal_slope(self, shares: tuple[float, float], y: Array) -> Array:
        """Derivative of `longitudinal_slip` along y in 1/m."""

    def lateral_slip(self, shares: tuple[float, float], x: Array | float, y: Array) -> Array:
        """Slip s_y/V of the bodies' shapes beyond `rigid_slip`, at the places x, y, which are broadcast."""
        return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))

    def rigid_slip(self, creepage: tuple[float, float, float], x: Array, y: Array) -> Array:
        """Slip s/V by creepages (ξ_x, ξ_y) and spin ξ_φ (rad/m), and across rolling by a curved common surface: (2, ...) at
        the places x, y, which are broadcast."""


@dataclass(frozen=True)
class Geometry(ContactGeometry):
    """Radii of both bodies along rolling (x) and across (y) in m: inf is flat, negative is concave; or profiles across, whose
    radius is then inf. The common surface is the plane z = 0."""

    lower_radius_x: float
    lower_radius_y: float
    upper_radius_x: float
    upper_radius_y: float
    lower_profile: Profile | None = None
    upper_profile: Profile | None = None

    @property
    def elliptic(self) -> bool:
        return self.lower_profile is None and self.upper_profile is None

    @property
    def curvature_x(self) -> float:
        return 1.0 / self.lower_radius_x + 1.0 / self.upper_radius_x

    @property
    def curvature_y(self) -> float:
        """Relative curvature 1/R'_y = 1/R_y1 + 1/R_y2 in 1/m."""
        return 1.0 / self.lower_radius_y + 1.0 / self.upper_radius_y

    @property
    def limits(self) -> tuple[float, float]:
        lower, upper = surfaces(self)
        low, high = max(lower.ends[0], upper.ends[0]), min(lower.ends[1], upper.ends[1])
        if not low < high:
            raise Unsolvable(f"the profiles never face each other: one ends at y = {1e3 * high:g} mm, the other begins at "
                             f"{1e3 * low:g} mm", "geometry.upper_profile", "profiles that touch")
        return low, high

    @cached_property
    def symmetric(self) -> bool:
        if self.elliptic:
            return True
        low, high = self.limits
        if not math.isclose(-low, high, rel_tol=SYMMETRY_TOLERANCE):
            return False
        y = np.linspace(0.0, high, GAP_SAMPLES)[:-1]
        for surface in surfaces(self):
            there, here = surface.height(-y), surface.height(y)
            if not np.abs(here - there).max() <= SYMMETRY_TOLERANCE * max(float(np.ptp(here)), 1e-300):
                return False
        return True

    @cached_property
    def first_touch(self) -> tuple[float, float]:
        """The y (m) at which the unloaded bodies touch first, and z₂ − z₁ (m) there, of heights as they are given."""
        if self.elliptic:
            return 0.0, 0.0
        lower, upper = surfaces(self)
        low, high = self.limits
        knots = [y for _, profile in self.profiles
                 for y in (p[0] + profile.offset for p in profile.points) if low <= y <= high]
        y = np.union1d(np.linspace(low, high, GAP_SAMPLES), knots)
        for _ in range(4):
            gap = -(lower.height(y) + upper.height(y))
            k = int(np.argmin(gap))
            a, b = y[max(k - 1, 0)], y[min(k + 1, len(y) - 1)]
            place, value = float(y[k]), float(gap[k])
            y = np.union1d(np.linspace(a, b, GAP_SAMPLES // 10), [place])
        return place, value

    def across(self, y: Array) -> Array:
        if self.elliptic:
            return 0.5 * self.curvature_y * y**2
        lower, upper = surfaces(self)
        return np.asarray(-(lower.height(y) + upper.height(y)) - self.first_touch[1])

    def gap(self, x: Array, y: Array) -> Array:
        return np.asarray(0.5 * self.curvature_x * x[:, None] ** 2 + self.across(y)[None, :])

    @property
    def across_radii(self) -> tuple[float, float]:
        return self.lower_radius_y, self.upper_radius_y

    @property
    def slopes(self) -> tuple[Callable[[Array], Array], ...]:
        return tuple(surface.slope for surface in surfaces(self))

    @property
    def profiles(self) -> tuple[tuple[str, Profile], ...]:
        both = ("lower", self.lower_profile), ("upper", self.upper_profile)
        return tuple((body, profile) for body, profile in both if profile is not None)

    def roundings(self, centre: float, half_width: float) -> tuple[Rounding, ...]:
        found = (profile.rounding_at(centre, half_width) for _, profile in self.profiles)
        return tuple(rounding for rounding in found if rounding)

    def section(self, y: Array) -> tuple[Array, Array]:
        place = np.array([self.first_touch[0]])
        lower, upper = (surface.height(y) - surface.height(place) for surface in surfaces(self))
        return lower, -upper

    @property
    def free_ends(self) -> tuple[bool, bool]:
        low, high = np.isfinite(self.across(np.array(self.limits)))
        return bool(low), bool(high)

    def along(self, depth: float, y: Array) -> tuple[float, float]:
        half = math.sqrt(2.0 * depth / self.curvature_x)
        return -half, half

    def surface_angle(self, shares: tuple[float, float], y: Array) -> Array:
        bottom, top = surfaces(self)
        return np.arctan(common_surface(bottom.slope(y), -top.slope(y), shares))

    def longitudinal_slip(self, shares: tuple[float, float], y: Array) -> Array:
        """Differential slip d(y) (`rolling.differential_slip`)."""
        bottom, top = surfaces(self)
        # The lower surface is z₁, the upper one −z₂: both heights are measured out of their body.
        return common_surface(bottom.bend(y), -top.bend(y), shares) * self.curvature_x

    def longitudinal_slope(self, shares: tuple[float, float], y: Array) -> Array:
        bottom, top = surfaces(self)
        zero = np.zeros(1)
        return common_surface(bottom.slope(y) - bottom.slope(zero), top.slope(zero) - top.slope(y), shares) * self.curvature_x

    def lateral_slip(self, shares: tuple[float, float], x: Array | float, y: Array) -> Array:
        return -x * self.longitudinal_slope(shares, y)

    def rigid_slip(self, creepage: tuple[float, float, float], x: Array, y: Array) -> Array:
        """ξ_x − ξ_φ y and ξ_y + ξ_φ x (Eqs. 7, 11)."""
        along, across, spin = creepage
        return np.stack(np.broadcast_arrays(along - spin * y, across + spin * x))


@dataclass(frozen=True)
class Surface:
    """One body's surface over y (m): `shape(y, n)` is the height out of the body (n = 0) or its slope (1)."""

    shape: Callable[[Array, int], Array]
    ends: tuple[float, float] = (-math.inf, math.inf)

    def height(self, y: Array) -> Array:
        """Height out of the body in m; −inf where there is no material."""
        inside = np.clip(np.asarray(y, dtype=float), *self.ends)
        return np.where(inside == y, self.shape(inside, 0), -math.inf)

    def slope(self, y: Array) -> Array:
        """Slope of the height; that of the end beyond it."""
        return self.shape(np.clip(np.asarray(y, dtype=float), *self.ends), 1)

    def bend(self, y: Array) -> Array:
        """Height over the tangent at y = 0, in m; that of the end beyond it."""
        y = np.clip(np.asarray(y, dtype=float), *self.ends)
        zero = np.zeros(1)
        return np.asarray(self.shape(y, 0) - self.shape(zero, 0) - y * self.shape(zero, 1))


def common_surface(lower: Array, upper: Array, shares: tuple[float, float]) -> Array:
    """Height or slope of the surface in which two bodies touch, w₂ z₁ + w₁ z₂, from those of both undeformed surfaces in the
    same direction and the `shares` w of the bodies in the compliance: each body gives way by its share of the distance, so the
    stiffer one keeps more of its shape."""
    return np.asarray(shares[1] * lower + shares[0] * upper)


def surfaces(geometry: Geometry) -> tuple[Surface, Surface]:
    """The lower and the upper surface."""
    return (_surface(geometry.lower_radius_y, geometry.lower_profile),
            _surface(geometry.upper_radius_y, geometry.upper_profile))


@lru_cache(maxsize=64)
def _surface(radius: float, profile: Profile | None) -> Surface:
    if profile is None:
        return Surface(lambda y, n: np.asarray(-y / radius if n else -0.5 * y**2 / radius))
    shape = _interpolated(profile) if profile.points else _crown(profile)

    def placed(y: Array, n: int) -> Array:
        own = y - profile.offset
        return np.asarray(shape(own, n) + (profile.tilt if n else profile.tilt * own))

    return Surface(placed, profile.ends)


def _interpolated(profile: Profile) -> Callable[[Array, int], Array]:
    y, z = np.array(profile.points).T
    if profile.interpolation == "cubic":
        spline = scipy.interpolate.CubicSpline(y, z)
        return lambda at, n: np.asarray(spline(at, n))
    slopes = np.diff(z) / np.diff(y)

    def lines(at: Array, n: int) -> Array:
        if n == 0:
            return np.interp(at, y, z)
        # At a kink the mean of both sides, the limit of kinks that are rounded ever less.
        left, right = (np.clip(np.searchsorted(y, at, side) - 1, 0, len(slopes) - 1) for side in ("left", "right"))
        return np.asarray(0.5 * (slopes[left] + slopes[right]))

    return lines


def _crown(profile: Profile) -> Callable[[Array, int], Array]:
    side = 0.5 * (profile.length - profile.flat)

    def crown(y: Array, n: int) -> Array:
        # t: distance into the crowned part over its width; left: 1 − t², which must not vanish at the very end.
        t = np.maximum(np.abs(y) - 0.5 * profile.flat, 0.0) / side
        left = np.maximum((1.0 - t) * (1.0 + t), 1e-300)
        if n:
            return np.asarray(-2.0 * profile.drop * t * np.sign(y) / (left * side))
        # Infinitely deep at the very end: it never touches.
        return np.asarray(np.where(t < 1.0, profile.drop * np.log(left), -math.inf))

    return crown

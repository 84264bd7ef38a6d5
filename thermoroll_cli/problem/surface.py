"""Heights, slopes and curvatures of the two surfaces across the rolling direction, and the gap between them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import Geometry, Profile, Unsolvable

GAP_SAMPLES = 2001
"""Places at which the smallest gap of two profiles is searched for, before it is refined."""
SYMMETRY_TOLERANCE = 1e-9
"""A profile is symmetric if heights on both sides differ by less than this share of their range."""


@dataclass(frozen=True)
class Surface:
    """One body's surface over y (m): `shape(y, n)` is the height out of the body (n = 0) or its slope (1)."""

    shape: Callable[[Array, int], Array]
    ends: tuple[float, float] = (-math.inf, math.inf)

    def height(self, y: Array) -> Array:
        """Height out of the body in m; −inf where there is no material."""
        y = np.asarray(y, dtype=float)
        inside = self.holds(y)
        return np.where(inside, self.shape(np.clip(y, *self.ends), 0), -math.inf)

    def slope(self, y: Array) -> Array:
        """Slope of the height; that of the end beyond it."""
        return self.shape(np.clip(np.asarray(y, dtype=float), *self.ends), 1)

    def holds(self, y: Array) -> NDArray[np.bool_]:
        """Whether there is material at y."""
        return np.asarray((y >= self.ends[0]) & (y <= self.ends[1]))

    def bend(self, y: Array) -> Array:
        """Height over the tangent at y = 0, in m; that of the end beyond it."""
        y = np.clip(np.asarray(y, dtype=float), *self.ends)
        zero = np.zeros(1)
        return np.asarray(self.shape(y, 0) - self.shape(zero, 0) - y * self.shape(zero, 1))


def surfaces(geometry: Geometry) -> tuple[Surface, Surface]:
    """The lower and the upper surface."""
    return (_surface(geometry.lower_radius_y, geometry.lower_profile),
            _surface(geometry.upper_radius_y, geometry.upper_profile))


def facing(geometry: Geometry) -> tuple[float, float]:
    """Lowest and highest y (m) at which both bodies have material. Raises Unsolvable where there is no such place."""
    lower, upper = surfaces(geometry)
    low, high = max(lower.ends[0], upper.ends[0]), min(lower.ends[1], upper.ends[1])
    if not low < high:
        raise Unsolvable("the profiles never face each other: "
                         f"one ends at y = {1e3 * high:g} mm, the other begins at {1e3 * low:g} mm", "geometry.upper_profile")
    return low, high


def lateral_gap(geometry: Geometry, y: Array) -> Array:
    """z₂(y) − z₁(y) in m less its smallest value, inf where a body has no material."""
    lower, upper = surfaces(geometry)
    return np.asarray(-(lower.height(y) + upper.height(y)) - _closest(geometry)[1])


def closest_place(geometry: Geometry) -> float:
    """The y (m) at which the unloaded bodies touch first."""
    return _closest(geometry)[0]


@lru_cache(maxsize=32)
def _closest(geometry: Geometry) -> tuple[float, float]:
    """Place and value of the smallest z₂ − z₁."""
    lower, upper = surfaces(geometry)
    low, high = facing(geometry)
    knots = [y for profile in (geometry.lower_profile, geometry.upper_profile) if profile is not None
             for y in (p[0] + profile.offset for p in profile.points) if low <= y <= high]
    y = np.union1d(np.linspace(low, high, GAP_SAMPLES), knots)
    for _ in range(4):
        gap = -(lower.height(y) + upper.height(y))
        k = int(np.argmin(gap))
        a, b = y[max(k - 1, 0)], y[min(k + 1, len(y) - 1)]
        place, value = float(y[k]), float(gap[k])
        y = np.union1d(np.linspace(a, b, GAP_SAMPLES // 10), [place])
    return place, value


@lru_cache(maxsize=32)
def is_symmetric(geometry: Geometry) -> bool:
    """Whether the gap is its own mirror image across y = 0, and so is the common surface for any stiffness."""
    low, high = facing(geometry)
    if not math.isclose(-low, high, rel_tol=SYMMETRY_TOLERANCE):
        return False
    y = np.linspace(0.0, high, GAP_SAMPLES)[:-1]
    for surface in surfaces(geometry):
        there, here = surface.height(-y), surface.height(y)
        if not np.abs(here - there).max() <= SYMMETRY_TOLERANCE * max(float(np.ptp(here)), 1e-300):
            return False
    return True


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
    cubic = profile.interpolation == "cubic"
    spline = scipy.interpolate.CubicSpline(y, z) if cubic else scipy.interpolate.make_interp_spline(y, z, k=1)
    return lambda at, n: np.asarray(spline(at, n))


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

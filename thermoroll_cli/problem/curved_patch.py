"""A patch whose common surface is curved across rolling: conformal contact, and the patches of a wheel on a rail.

x is along rolling, y is the arc length across on the common surface, whose inclination to the plane of the frame is α(y); its
normals are e_n = (0, −sin α, cos α), its directions across e_s = (0, cos α, sin α). Pressure acts along e_n, traction and slip
along x and e_s. The bodies approach each other along the normal of the frame: an approach δ closes the gap by δ cos α, and the
load is ∬ p cos α. Influence coefficients stay those of a half-space in the arc length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from thermoroll_cli.problem.geometry import (
    SYMMETRY_TOLERANCE,
    ContactGeometry,
    Geometry,
    Surface,
    Unsolvable,
    common_surface,
    surfaces,
)
from thermoroll_cli.problem.rounding import Rounding
from thermoroll_cli.problem.surface import edges
from thermoroll_cli.tools.arrays import Array

SAMPLES = 401
"""Arc lengths at which the gap of `conformal_patch` is tabulated: splines between them are good to 1e-10 of the radius."""
WIDEST_ANGLE = 1.2
"""Inclination in rad at which a conformal surface ends: beyond it the bodies are not like half-spaces."""
THINNEST, DEEPEST = 0.5, 0.25
"""It also ends where less than this share of a rolling radius is left (normals miss a body near its axis), and beyond the last
places with a gap below this share of the smaller R', the approach of a contact that is no half-space either."""
GRADING = 4.0
"""Samples about the touch of two circles lie closer than at the ends by cosh of this: the contact may be as narrow as that."""
MOST_NARROWINGS = 8
"""Times that its ends are looked for again between neighbouring samples: the first ones may lie far apart."""
NEWTON_STEPS = 8
"""Steps along a normal of the common surface to a body: quadratic convergence reaches rounding after four to six."""

Row = tuple[float, ...]


@dataclass(frozen=True)
class CurvedPatch(ContactGeometry):
    """Tables over the arc length `y` (m, increasing), joined by cubic splines; there is no contact beyond its ends.

    `lateral`: coordinate across in the frame (m); `angle`: inclination α (rad). On each line of rolling the gap along the
    normal, from which an approach counts, is, with lengths in m,

        gap_lowest + ½ curvature d² + cubic d³ + quartic d⁴,      d = x − x_lowest.

    The shapes of the bodies slip over each other at (slip_x, slip_y + spin x) V, with `spin` in rad/m, in addition to the
    creepages and the spin of the frame. `free_ends` says at which end of the table material ends, and which of these is `cut`
    because the model ends there; at other ends the gap of a neighbouring patch begins. Radii are those along rolling (m).
    `rounded` is the rounding of the profiles that the tables come from. Where bodies change along rolling, `heights` close the
    gap beside these powers (`surface.Closing`, None: nothing).
    """

    y: Row
    lateral: Row
    angle: Row
    gap_lowest: Row
    x_lowest: Row
    curvature: Row
    cubic: Row
    quartic: Row
    slip_x: Row
    slip_y: Row
    spin: Row
    lower_radius_x: float = math.inf
    upper_radius_x: float = math.inf
    free_ends: tuple[bool, bool] = (False, False)
    cut: tuple[bool, bool] = (False, False)
    rounded: tuple[Rounding, ...] = ()
    heights: Any = None

    def __hash__(self) -> int:
        # Hash a sample of the tables; hashing all costs more than most cached results.
        step = 1 + len(self.y) // 16
        return hash((self.y[::step], self.gap_lowest[::step], self.slip_x[::step], self.upper_radius_x))

    @cached_property
    def _splines(self) -> scipy.interpolate.CubicSpline:
        columns = (self.lateral, self.angle, self.gap_lowest, self.x_lowest, self.curvature, self.cubic, self.quartic,
                   self.slip_x, self.slip_y, self.spin)
        return scipy.interpolate.CubicSpline(np.array(self.y), np.array(columns).T)

    def _at(self, y: Array) -> Array:
        """All columns at the arc lengths `y`, (10, ...); those of an end beyond it."""
        return np.moveaxis(self._splines(np.clip(y, *self.limits)), -1, 0)

    @property
    def curvature_x(self) -> float:
        return float(self.curvature[int(np.argmin(self.gap_lowest))])

    def roundings(self, centre: float, half_width: float) -> tuple[Rounding, ...]:
        return self.rounded

    def section(self, y: Array) -> tuple[Array, Array]:
        return np.zeros(np.shape(y)), self.across(y)

    @property
    def leans(self) -> bool:
        return any(self.x_lowest) or self.heights is not None

    @property
    def limits(self) -> tuple[float, float]:
        return self.y[0], self.y[-1]

    @cached_property
    def symmetric(self) -> bool:
        columns = np.array((self.gap_lowest, self.curvature, self.quartic, self.slip_x))
        odd = np.array((self.y, self.lateral, self.angle, self.slip_y, self.spin))
        skew = np.array((self.x_lowest, self.cubic))

        def small(rest: Array, of: Array) -> bool:
            return bool((np.abs(rest).max(axis=1) <= SYMMETRY_TOLERANCE * np.abs(of).max(axis=1)).all())

        if skew.any() or self.heights is not None:
            return False
        return small(columns - columns[:, ::-1], columns) and small(odd + odd[:, ::-1], odd)

    def across(self, y: Array) -> Array:
        inside = (y >= self.y[0]) & (y <= self.y[-1])
        return np.where(inside, self._at(y)[2], math.inf)

    def along(self, depth: float, y: Array) -> tuple[float, float]:
        columns = self._at(y)
        # The gap opens along as at an inclination of 75° at least: at the end of a profile its fit may not.
        curvature = np.maximum(columns[4], 0.25 * columns[4].max())
        half = np.sqrt(2.0 * np.maximum(depth - self.across(y), 0.0) / curvature)
        return float((columns[3] - half).min()), float((columns[3] + half).max())

    def gap(self, x: Array, y: Array) -> Array:
        _, _, _, lowest, curvature, cubic, quartic, *_ = self._at(y)
        d = x[:, None] - lowest
        gap = np.asarray(self.across(y) + d**2 * (0.5 * curvature + d * (cubic + d * quartic)))
        return gap if self.heights is None else gap - self.heights.over(*(edges(at, at[1] - at[0]) for at in (x, y)))

    def inclination(self, y: Array) -> Array:
        return np.asarray(self._at(y)[1])

    def lateral_place(self, y: Array) -> Array:
        return np.asarray(self._at(y)[0])

    def longitudinal_slip(self, shares: tuple[float, float], y: Array) -> Array:
        return np.asarray(self._at(y)[7])

    def longitudinal_slope(self, shares: tuple[float, float], y: Array) -> Array:
        return np.asarray(self._splines(np.clip(y, *self.limits), 1)[..., 7])

    def rigid_slip(self, creepage: tuple[float, float, float], x: Array, y: Array) -> Array:
        """(ξ_x − ξ_φ Y, (ξ_y + ξ_φ x) cos α + slip_y + spin x) with the lateral coordinate Y in the frame."""
        along, across, turning = creepage
        lateral, inclination, *_, slip_y, spin = self._at(y)
        return np.stack(np.broadcast_arrays(along - turning * lateral,
                                            (across + turning * x) * np.cos(inclination) + slip_y + spin * x))


def conformal_patch(geometry: Geometry, shares: tuple[float, float]) -> CurvedPatch:
    """The surfaces of `geometry` as bodies of revolution (axes along y, radii along rolling as given), on their common surface.

    That surface is z = w₂ z₁(y) + w₁ z₂(y) with the `shares` w of both bodies in the compliance: the stiffer body keeps more of
    its shape. Radii across rolling are circles here, not parabolas. The slip of the shapes is that of the rotations about both
    axes at the common surface, less creepage and spin at y = 0 (`rolling.differential_slip`, whose limit for small
    angles this is).
    """
    lower, upper = (_rounded(surface, radius) for surface, radius in zip(
        surfaces(geometry), (geometry.lower_radius_y, geometry.upper_radius_y), strict=True))
    y, closest, cut = _sampled(lower, upper, geometry, shares)

    def common(at: Array, n: int) -> Array:
        both = _common(lower, upper, shares, at, n)
        return both - shares[0] * closest if n == 0 else both

    # From arc length to y.
    slope = scipy.interpolate.CubicSpline(y, np.hypot(1.0, common(y, 1)))
    zero = float(np.clip(0.0, y[0], y[-1]))
    length = slope.antiderivative()(y) - float(slope.antiderivative()(zero)) + zero
    s = np.linspace(length[0], length[-1], SAMPLES)
    if geometry.elliptic:
        s = length[-1] * np.sinh(GRADING * s / length[-1]) / math.sinh(GRADING)
    lateral = scipy.interpolate.CubicSpline(length, y)(s)
    if geometry.symmetric:
        lateral = 0.5 * (lateral - lateral[::-1])
        s = 0.5 * (s - s[::-1])
    height, inclination = common(lateral, 0), np.arctan(common(lateral, 1))
    # Three gaps along each line of rolling give the even powers of x, at places where the gap is small against all radii.
    bent = max(geometry.curvature_x, *(1.0 / abs(radius) for radius in (geometry.lower_radius_x, geometry.upper_radius_x)))
    scale = 0.05 / math.sqrt(bent * max(bent, geometry.curvature_y))
    x = np.array([0.0, 1.0, 2.0])[:, None] * scale
    gap = (_along_normal(lower, geometry.lower_radius_x, x, lateral, height, inclination, 1.0, 0.0)
           + _along_normal(upper, geometry.upper_radius_x, x, lateral, height, inclination, -1.0, closest))
    first, second = (gap[1] - gap[0]) / scale**2, (gap[2] - gap[0]) / (4.0 * scale**2)
    conicity = float(common(np.array([zero]), 1)[0]) if y[0] < 0.0 < y[-1] else 0.0
    at_origin = float(common(np.array([zero]), 0)[0])
    curvature = geometry.curvature_x
    slip_x = curvature * (height - at_origin - (lateral - zero) * conicity)
    spin = curvature * (conicity * np.cos(inclination) - np.sin(inclination))
    nothing = np.zeros(SAMPLES)
    columns = {"y": s, "lateral": lateral, "angle": inclination, "gap_lowest": gap[0], "x_lowest": nothing,
               "curvature": 2.0 * (4.0 * first - second) / 3.0, "cubic": nothing,
               "quartic": (second - first) / (3.0 * scale**2), "slip_x": slip_x, "slip_y": nothing, "spin": spin}
    rows: dict[str, Any] = {name: tuple(column.tolist()) for name, column in columns.items()}
    return CurvedPatch(**rows, lower_radius_x=geometry.lower_radius_x, upper_radius_x=geometry.upper_radius_x,
                       free_ends=(True, True), cut=cut)


def _common(lower: Surface, upper: Surface, shares: tuple[float, float], y: Array, n: int) -> Array:
    """Height (n = 0; with any constant) or slope (1) of the common surface."""
    return common_surface(lower.shape(y, n), -upper.shape(y, n), shares)


def _sampled(
    lower: Surface, upper: Surface, geometry: Geometry, shares: tuple[float, float]
) -> tuple[Array, float, tuple[bool, bool]]:
    """Even samples y of the common surface, the smallest gap, and at which ends the surface ends before the material does.
    Raises Unsolvable where the model does not even hold where the bodies touch."""
    low, high = max(lower.ends[0], upper.ends[0]), min(lower.ends[1], upper.ends[1])
    for _ in range(MOST_NARROWINGS):
        y = np.linspace(low, high, 4 * SAMPLES + 1)
        gap = -(lower.height(y) + upper.height(y))
        touch, closest = int(np.argmin(gap)), float(gap.min())
        sound = np.abs(np.arctan(_common(lower, upper, shares, y, 1))) <= WIDEST_ANGLE
        for surface, radius in ((lower, geometry.lower_radius_x), (upper, geometry.upper_radius_x)):
            sound &= np.sign(radius) * surface.shape(y, 0) >= (THINNEST - 1.0) * abs(radius)
        near = np.flatnonzero(gap - closest <= DEEPEST / max(geometry.curvature_x, geometry.curvature_y))
        ends = np.concatenate([[near[0] - 1], np.flatnonzero(~sound), [near[-1] + 1]])
        first, last = int(ends[ends <= touch].max()) + 1, int(ends[ends >= touch].min()) - 1
        if first > last:
            raise Unsolvable(f"the surfaces touch at y = {1e3 * y[touch]:.4g} mm, where they are inclined by more than "
                             f"{WIDEST_ANGLE:g} rad or a body has less than half of its rolling radius",
                             "geometry.conformal", "false")
        if last - first > len(y) // 2:
            break
        low, high = float(y[max(first - 1, 0)]), float(y[min(last + 1, len(y) - 1)])
    lowest, highest = geometry.limits
    y = y[first : last + 1]
    return y, closest, (bool(y[0] > lowest), bool(y[-1] < highest))


def _rounded(surface: Surface, radius: float) -> Surface:
    """`surface`, but a circle where it has a `radius`."""
    if math.isinf(radius):
        return surface

    def circle(y: Array, n: int) -> Array:
        root = np.sqrt(1.0 - (y / radius) ** 2)
        return np.asarray(-y / (radius * root) if n else -(y**2) / (radius * (1.0 + root)))

    half = math.sin(WIDEST_ANGLE) * abs(radius)
    return Surface(circle, (max(-half, surface.ends[0]), min(half, surface.ends[1])))


def _along_normal(
    surface: Surface, radius: float, x: Array, lateral: Array, height: Array, inclination: Array, side: float, offset: float
) -> Array:
    """Distance (m, (n, m)) from the common surface at (x, lateral, height) to a body of revolution along its normal, positive
    where the body is below (`side` 1, lower body) or above (−1, the upper one, moved up by `offset`)."""
    sine, cosine = np.sin(inclination), np.cos(inclination)
    distance = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(lateral)))
    for _ in range(NEWTON_STEPS):
        # Points on the normal; heights out of the body.
        y, z = lateral + side * distance * sine, side * (height - side * distance * cosine) - (offset if side < 0.0 else 0.0)
        y = np.clip(y, *surface.ends)
        if math.isinf(radius):
            over, steepness = z, 1.0
        else:
            root = np.sign(radius) * np.hypot(x, z + radius)
            over, steepness = (x**2 + z * (z + 2.0 * radius)) / (root + radius), (z + radius) / root
        excess = over - surface.shape(y, 0)
        distance = distance + excess / (steepness * cosine + surface.shape(y, 1) * side * sine)
    return distance

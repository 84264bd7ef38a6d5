"""Rails and wheels in the axes of the track and of the wheelset, and the line along which a wheel can touch a rail that is
straight, or a roller.

A roller is a rail that is bent about an axle below it. In the coordinates x = ϑ R, y and z = R − ρ, with the radius R of its
top, the angle ϑ about the axle and the distance ρ from it, it is straight. A patch is described in axes that are turned about
the axle, or shifted along the track, to where it lies (`Position.ahead`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.wheelset.curves import Points, curve
from thermoroll_cli.many_contacts.wheelset.slices import Slices
from thermoroll_cli.problem.rounding import MeasuredOutline, Rounding
from thermoroll_cli.problem.surface import Heights
from thermoroll_cli.tools.arrays import Array

LOCUS_SWEEPS = 5
"""Steps of Newton's method to the place where a wheel touches a roller: from that on a straight rail, rounding after four."""


class Roller(NamedTuple):
    """The `radius` (m) of a roller, whose axle lies as deep below y = z = 0 of the track, and its angular velocity `turning`
    (rad/s, positive where its top moves backwards)."""

    radius: float
    turning: float


class Side:
    """What a rail and a wheel have in common: how their points were `measured`, which has no effect on where they lie."""

    profile: Points
    measured: MeasuredOutline | None
    slices: Slices | None
    surface: Heights | None

    @property
    def varies(self) -> bool:
        """Whether it changes along rolling."""
        return self.slices is not None or self.surface is not None

    def section_place(self, x: float) -> float:
        """The place of the slice `x` (m) ahead of the axle."""
        raise NotImplementedError

    def roundings_at(self, x: float, place: tuple[float, float], reach: float) -> tuple[Rounding, ...]:
        """Roundings within the `reach` (m) of a place of the outline (m) that is `x` (m) ahead of the axle."""
        if self.slices is not None:
            return self.slices.roundings_at(self.section_place(x), place, reach)
        rounding = None if self.measured is None else self.measured.rounding_at(place, reach)
        return (rounding,) if rounding else ()


@dataclass(frozen=True)
class RailSide(Side):
    """A right rail: its profile (y to the field side, z down, m), `cant` inwards (rad), half the gauge (m) measured
    `gauge_height` below the top, and shifts and a roll of its own.
    `friction` has points (inclination of its surface in rad, share of the coefficient of friction), the share constant outside
    them; none where friction is the same everywhere. `origin` is the place of y = z = 0 of the profile (y from the middle of
    the track to the field side, z down, m), in place of gauge and top. With a `roller` the rail is bent about its axle.
    With `slices` the profile is that below the axle, `along` the track (m) in their places, and of a `surface` with heights
    upwards; by `lifts` (m) surfaces lift a wheel that touches them. Gauge and top are those of the profile, or of its
    `reference` at another place."""

    profile: Points
    cant: float
    half_gauge: float
    gauge_height: float
    shift_y: float = 0.0
    shift_z: float = 0.0
    roll: float = 0.0
    friction: Points = ()
    origin: tuple[float, float] | None = None
    roller: Roller | None = None
    measured: MeasuredOutline | None = None
    slices: Slices | None = None
    along: float = 0.0
    surface: Heights | None = None
    lifts: float = 0.0
    reference: Points = ()

    @cached_property
    def samples(self) -> Array:
        """Rows y, z, dy/ds, dz/ds of the rail's surface in track axes, (4, n).

        The profile is turned by −cant about x; its highest point lies at z = 0, and the least y within the gauge height below
        it at half the gauge, unless `origin` places it. From there the rail rolls about the origin of its profile, as CONTACT's
        deviations of rails do."""
        return self.placed(curve(self.profile).samples)

    def placed(self, profile: Array) -> Array:
        """Rows y, z, dy/ds, dz/ds of an outline in track axes, placed as the profile of the rail is."""
        return _turned(profile, self.roll - self.cant) + self._moved

    @cached_property
    def _moved(self) -> Array:
        moved = np.array([self.shift_y, self.shift_z - self.lifts, 0.0, 0.0])[:, None]
        if self.origin is not None:
            return moved + np.array([*self.origin, 0.0, 0.0])[:, None]
        y, z = _turned(curve(self.reference or self.profile).samples, -self.cant)[:2]
        height = z.min() + self.gauge_height
        crossing = np.flatnonzero((z[:-1] - height) * (z[1:] - height) < 0.0)
        share = (height - z[crossing]) / (z[crossing + 1] - z[crossing])
        reached = np.concatenate((y[z <= height], (1.0 - share) * y[crossing] + share * y[crossing + 1]))
        return np.array([self.half_gauge - reached.min(), -z.min(), 0.0, 0.0])[:, None] + moved

    def lines(self, x: float) -> Array:
        """Rows y, z in track axes of the rail's lines `x` (m) ahead of the axle, (2, m)."""
        assert self.slices is not None
        profile = self.slices.lines_at(self.along + x).T
        return self.placed(np.concatenate((profile, 0.0 * profile)))[:2]

    def section_place(self, x: float) -> float:
        return self.along + x

    def rolled(self, distance: float) -> RailSide:
        """The same rail where it lies, with the axle a `distance` (m) further."""
        there = replace(self, along=self.along + distance)
        return there if self.slices is None else replace(there, profile=self.slices.outline_at(there.along),
                                                         reference=self.reference or self.profile)

    def section(self, x: float) -> RailSide:
        """This rail as it is `x` (m) ahead of the axle, all along."""
        if self.slices is None:
            return self
        y, z = self._moved[:2, 0].tolist()
        return replace(self, profile=self.slices.outline_at(self.along + x), slices=None, origin=(y, z + self.lifts),
                       shift_y=0.0, shift_z=0.0)


@dataclass(frozen=True)
class WheelSide(Side):
    """A right wheel: its profile (y to the field side, z down, m), nominal radius, half the distance of the flange backs and
    the profile's y of the flange back (m). With `slices`, and a `surface` with heights along the radius, the angle `turned`
    (rad) stands below the axle; what lies ahead has larger angles."""

    profile: Points
    radius: float
    half_flange_back_distance: float
    flange_back: float
    measured: MeasuredOutline | None = None
    slices: Slices | None = None
    turned: float = 0.0
    surface: Heights | None = None

    @property
    def shift(self) -> float:
        """y in wheelset axes less that of the profile."""
        return self.half_flange_back_distance - self.flange_back

    @cached_property
    def samples(self) -> Array:
        """Rows y, r, dy/ds, dr/ds in the axes of the wheelset, (4, n)."""
        return curve(self.profile).samples + np.array([[self.shift], [self.radius], [0.0], [0.0]])

    def lines(self, ahead: Array | float, part: slice = slice(None)) -> Array:
        """Rows y, r in the axes of the wheelset of the wheel's lines at the angles `ahead` (rad, of each of a `part` of them),
        (2, m)."""
        if self.slices is None:
            return self.samples[:2, part]
        lines = (self.slices.at_each(self.turned + ahead, part) if isinstance(ahead, np.ndarray) else
                 self.slices.lines_at(self.turned + ahead)[part])
        return np.asarray(lines.T + np.array([[self.shift], [self.radius]]))

    def section_place(self, x: float) -> float:
        return self.turned + x / self.radius

    def rolled(self, angle: float) -> WheelSide:
        """The same wheel after it has turned by an `angle` (rad)."""
        there = replace(self, turned=self.turned + angle)
        return there if self.slices is None else replace(there, profile=self.slices.outline_at(there.turned))

    def section(self, ahead: float) -> WheelSide:
        """The wheel of revolution with the profile at the angle `ahead` (rad)."""
        return self if self.slices is None else replace(self, profile=self.slices.outline_at(self.turned + ahead), slices=None)


@dataclass(frozen=True)
class Position:
    """Position of a wheelset: shift to the right and height below its place with the nominal radius on the rails (m, down),
    roll and yaw (rad), and its shift forward over rollers (`x`, m); in the axes of a place that is `ahead` (m, x) along the
    track, or on the `roller`; on a track that rises or falls they begin `lift` (m) below its top, and x goes down by `tilt`
    (rad)."""

    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0
    x: float = 0.0
    ahead: float = 0.0
    roller: Roller | None = None
    tilt: float = 0.0
    lift: float = 0.0

    @property
    def turn(self) -> Array:
        """From the axes of the place to those of the track, (3, 3)."""
        angle = self.ahead / self.roller.radius if self.roller else self.tilt
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    @property
    def rail_centre(self) -> Array:
        """The point about which the rail turns: on the axle of the roller, or the origin of the track."""
        if self.roller:
            return np.array([0.0, 0.0, self.roller.radius])
        return np.asarray(self.turn.T @ np.array([-self.ahead, 0.0, -self.lift]))

    def on_track(self, place: Array) -> Array:
        """Points (…, 3) in the axes of the place, in those of the track; on a roller its coordinates."""
        turned = place if self.roller or not self.tilt else place @ self.turn.T
        return np.asarray(turned + np.array([self.ahead, 0.0, self.lift]))

    @cached_property
    def rotation(self) -> Array:
        """R = R_x(roll) R_z(yaw), from wheelset axes to track axes, and on to those of the place."""
        (cr, sr), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (self.roll, self.yaw))
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(self.turn.T @ about_x @ about_z)

    def origin(self, radius: float) -> Array:
        """The wheelset's origin on its axle."""
        above = self.roller.radius if self.roller else 0.0
        return np.asarray(self.turn.T @ np.array([self.x, self.y, self.z - radius - above]) + self.rail_centre)

    @property
    def mirrored(self) -> Position:
        """The same position seen from the other side of the track."""
        return replace(self, y=-self.y, roll=-self.roll, yaw=-self.yaw)


def locus(wheel: WheelSide, position: Position, roller: Roller | None = None) -> Array:
    """Rows x, y, z (m, track axes, or coordinates of the `roller`), dy/ds, dz/ds of the places at which the wheel's normal has
    no component along the track, one for each sample of its profile, (5, n); nan where there is none.

    With the normal (y′ sin θ, −r′, y′ cos θ) of the surface of revolution: R₀₀ sin θ + R₀₂ cos θ = R₀₁ r′/y′.
    The slopes are those of the wheel's surface there. Normals to a roller meet its axle, n_x (z − R) = n_z x: Newton's method
    goes there from the place on a straight rail."""
    y, r, dy, dr = wheel.samples
    rotation = position.rotation
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = rotation[0, 1] * dr / (math.hypot(rotation[0, 0], rotation[0, 2]) * dy)
    sine = np.where(np.abs(sine) <= 1.0, sine, np.nan)
    angle = np.arcsin(sine) - math.atan2(rotation[0, 2], rotation[0, 0])
    origin, still = position.origin(wheel.radius)[:, None], np.zeros(len(y))

    def at(angle: Array) -> tuple[Array, Array]:
        sine, cosine = np.sin(angle), np.cos(angle)
        return rotation @ np.array([r * sine, y, r * cosine]) + origin, rotation @ np.array([dy * sine, -dr, dy * cosine])

    for _ in range(LOCUS_SWEEPS if roller else 0):
        assert roller is not None
        (x, _, z), (along, _, down) = at(angle)
        sine, cosine = np.sin(angle), np.cos(angle)
        (x_turned, _, z_turned), (along_turned, _, down_turned) = (
            rotation @ np.array([size * cosine, still, -size * sine]) for size in (r, dy))
        z = z - roller.radius
        angle = angle - (along * z - down * x) / (along_turned * z + along * z_turned - down_turned * x - down * x_turned)
    (x, y, z), (along, across, down) = at(angle)
    if roller:
        above = roller.radius - z
        away = np.hypot(x, above)
        down = (down * above - along * x) / away
        x, z = roller.radius * np.arctan2(x, above), roller.radius - away
    # The tangent across the track, perpendicular to the normal within the plane of y and z.
    return np.array([x, y, z, down, -across])


def _turned(samples: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    return np.concatenate((turn @ samples[:2], turn @ samples[2:]))

"""Rails and wheels in the axes of the track and of the wheelset, and the line along which a wheel can touch a straight rail."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.wheelset.curves import Points, curve


@dataclass(frozen=True)
class RailSide:
    """A right rail: its profile (y to the field side, z down, m), `cant` inwards (rad), half the gauge (m) measured
    `gauge_height` below the top, and shifts and a roll of its own.
    `friction` has points (inclination of its surface in rad, share of the coefficient of friction), the share constant outside
    them; none where friction is the same everywhere. `origin` is the place of y = z = 0 of the profile (y from the middle of
    the track to the field side, z down, m), in place of gauge and top."""

    profile: Points
    cant: float
    half_gauge: float
    gauge_height: float
    shift_y: float = 0.0
    shift_z: float = 0.0
    roll: float = 0.0
    friction: Points = ()
    origin: tuple[float, float] | None = None

    @cached_property
    def samples(self) -> Array:
        """Rows y, z, dy/ds, dz/ds of the rail's surface in track axes, (4, n).

        The profile is turned by −cant about x; its highest point lies at z = 0, and the least y within the gauge height below
        it at half the gauge, unless `origin` places it. From there the rail rolls about the origin of its profile, as CONTACT's
        deviations of rails do."""
        profile = curve(self.profile).samples
        moved = np.array([self.shift_y, self.shift_z, 0.0, 0.0])[:, None]
        if self.origin is not None:
            return _turned(profile, self.roll - self.cant) + moved + np.array([*self.origin, 0.0, 0.0])[:, None]
        y, z = _turned(profile, -self.cant)[:2]
        height = z.min() + self.gauge_height
        crossing = np.flatnonzero((z[:-1] - height) * (z[1:] - height) < 0.0)
        share = (height - z[crossing]) / (z[crossing + 1] - z[crossing])
        reached = np.concatenate((y[z <= height], (1.0 - share) * y[crossing] + share * y[crossing + 1]))
        placed = np.array([self.half_gauge - reached.min(), -z.min(), 0.0, 0.0])[:, None]
        return _turned(profile, self.roll - self.cant) + placed + moved


@dataclass(frozen=True)
class WheelSide:
    """A right wheel: its profile (y to the field side, z down, m), nominal radius, half the distance of the flange backs and
    the profile's y of the flange back (m)."""

    profile: Points
    radius: float
    half_flange_back_distance: float
    flange_back: float

    @property
    def shift(self) -> float:
        """y in wheelset axes less that of the profile."""
        return self.half_flange_back_distance - self.flange_back

    @cached_property
    def samples(self) -> Array:
        """Rows y, r, dy/ds, dr/ds in the axes of the wheelset, (4, n)."""
        return curve(self.profile).samples + np.array([[self.shift], [self.radius], [0.0], [0.0]])


@dataclass(frozen=True)
class Position:
    """Position of a wheelset: shift to the right and height below its place with the nominal radius on the rails (m, down),
    roll and yaw (rad)."""

    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0

    @cached_property
    def rotation(self) -> Array:
        """R = R_x(roll) R_z(yaw), from wheelset axes to track axes."""
        (cr, sr), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (self.roll, self.yaw))
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(about_x @ about_z)

    def origin(self, radius: float) -> Array:
        """The wheelset's origin on its axle in track axes."""
        return np.array([0.0, self.y, self.z - radius])

    @property
    def mirrored(self) -> Position:
        """The same position seen from the other side of the track."""
        return replace(self, y=-self.y, roll=-self.roll, yaw=-self.yaw)


def locus(wheel: WheelSide, position: Position) -> Array:
    """Rows x, y, z (m, track axes), dy/ds, dz/ds of the places at which the wheel's normal has no component along the track,
    one for each sample of its profile, (5, n); nan where there is none.

    With the normal (y′ sin θ, −r′, y′ cos θ) of the surface of revolution: sin θ = R₀₁ r′/(R₀₀ y′), exact because R₀₂ = 0.
    The slopes are those of the wheel's surface there."""
    y, r, dy, dr = wheel.samples
    rotation = position.rotation
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = rotation[0, 1] * dr / (rotation[0, 0] * dy)
    sine = np.where(np.abs(sine) <= 1.0, sine, np.nan)
    cosine = np.sqrt(1.0 - sine**2)
    places = rotation @ np.array([r * sine, y, r * cosine]) + position.origin(wheel.radius)[:, None]
    normal = rotation @ np.array([dy * sine, -dr, dy * cosine])
    # The tangent across the track, perpendicular to the normal within the plane of y and z.
    return np.concatenate((places, np.array([normal[2], -normal[1]])))


def _turned(samples: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    return np.concatenate((turn @ samples[:2], turn @ samples[2:]))

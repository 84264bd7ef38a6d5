"""Velocity of the rail relative to the wheel, over the mean of both speeds: creepages with all that a wheelset's motion
contains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.many_contacts.wheelset.placement import Position
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class MotionOfWheelset:
    """Velocities of the wheelset (m/s) along the track, to the right and down, rates of roll and yaw (rad/s), its angular
    velocity about the axle (rad/s, negative forward; None: to be found), the curvature of the track (1/m, to the right), and
    the velocity of the wheelset along the track over rollers, on which it does not travel (`ahead`, m/s). On surfaces that
    rise and fall along rolling it `follows` them in addition to its velocity down."""

    speed: float
    angular_velocity: float | None
    lateral: float = 0.0
    vertical: float = 0.0
    roll_rate: float = 0.0
    yaw_rate: float = 0.0
    curvature: float = 0.0
    ahead: float = 0.0
    follows: bool = False

    @property
    def mirrored(self) -> MotionOfWheelset:
        """The same motion seen from the other side of the track."""
        return replace(self, lateral=-self.lateral, roll_rate=-self.roll_rate, yaw_rate=-self.yaw_rate,
                       curvature=-self.curvature)


@dataclass(frozen=True)
class Slip:
    """The rigid motion of the rail relative to the wheel as a field over space: `velocity` w(P) over the rolling speed
    `speed` V (m/s) and `rotation` (ω_r − ω)/V (1/m).

        w(P) = [ω_r × (P − C) − v − ω × (P − O)]/V,   ω_r = (0, 0, −v k),   ω = R (roll rate, ω_axle, yaw rate)

    about the centre C of the track. A roller turns with ω_r = (0, ω_roller, 0) about its axle under a wheelset that does not
    travel. V is the mean of the speeds with which rail and wheel pass the contact at `place`, a point of the undeformed wheel,
    which is `deep` (m, a vector) in the undeformed rail. All is in the axes of the `position`."""

    motion: MotionOfWheelset
    position: Position
    radius: float
    place: tuple[float, float, float]
    deep: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def _rotations(self) -> tuple[Array, Array, Array]:
        """ω_r, and ω without and with the rotation about the axle alone."""
        m, rotation = self.motion, self.position.rotation
        assert m.angular_velocity is not None
        roller = self.position.roller
        rail = np.array([0.0, roller.turning, 0.0] if roller else [0.0, 0.0, -m.speed * m.curvature])
        return rail, rotation @ np.array([m.roll_rate, 0.0, m.yaw_rate]), rotation @ np.array([0.0, m.angular_velocity, 0.0])

    @property
    def _travel(self) -> Array:
        """v in m/s."""
        m, position = self.motion, self.position
        return np.asarray(position.turn.T @ np.array([m.ahead if position.roller else m.speed, m.lateral, m.vertical]))

    @property
    def _centre(self) -> Array:
        """C, for points of the wheel: those of the rail lie higher."""
        return self.position.rail_centre + np.array(self.deep)

    def _passing(self, places: Array) -> tuple[Array, Array]:
        """Velocity of the rail less that of a wheelset that does not turn, and what turning adds, (3, …) in m/s."""
        rail, others, axle = self._rotations
        arm = places - self.position.origin(self.radius)
        moving = np.cross(rail, places - self._centre)
        return moving - self._travel - np.cross(others, arm), -np.cross(axle, arm)

    @property
    def speed(self) -> float:
        """V in m/s."""
        rail, wheel = self._passing(np.array(self.place))
        return 0.5 * float(abs(rail[0]) + abs(wheel[0]))

    def velocity(self, places: Array) -> Array:
        """w at `places` (…, 3), dimensionless."""
        rail, wheel = self._passing(places)
        return np.asarray((rail + wheel) / self.speed)

    def power(self, force: Array, moment: Array) -> float:
        """Power (W) that a `force` and a `moment` about its origin give to the wheelset, relative to the rail."""
        rail, others, axle = self._rotations
        travel = self._travel - np.cross(rail, self.position.origin(self.radius) - self._centre)
        return float(force @ travel + moment @ (others + axle - rail))

    @property
    def rotation(self) -> Array:
        """(ω_r − ω)/V in rad/m, (3,)."""
        rail, others, axle = self._rotations
        return np.asarray((rail - others - axle) / self.speed)


def directions(angle: float) -> tuple[Array, Array, Array]:
    """e_x, e_s = (0, cos α, sin α), e_n = (0, −sin α, cos α), which points into the rail."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([1.0, 0.0, 0.0]), np.array([0.0, c, s]), np.array([0.0, -s, c])


def creepages(slip: Slip, place: Array, angle: float) -> tuple[float, float, float]:
    """c_x, c_s and c_φ (rad/m) of the rail relative to the wheel at a `place` with the inclination `angle` (rad)."""
    along, across, normal = directions(angle)
    w = slip.velocity(place)
    return float(w @ along), float(w @ across), float(slip.rotation @ normal)

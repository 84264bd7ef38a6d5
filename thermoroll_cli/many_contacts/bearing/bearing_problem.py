"""The question: a ball bearing in SI units, its geometry, and the motion of a ball in both of its contacts.

Axes of a ball: axial e_a, outwards e_r, and e_t = e_a × e_r, the way in which the inner ring turns at a positive speed. In each
contact the ring is the lower body and the ball the upper one. The axes of a contact are e_z = n, from the ball to the ring, and
e_x along the flow of both surfaces in the frame of the cage, so that its rolling speed is positive:

    outer:  n =  (sin α, cos α, 0),   e_x = −s e_t        inner:  n = −(sin α, cos α, 0),   e_x = s e_t,

with s = 1 if the inner ring turns faster than the outer one, else −1. α is the contact angle; n, e_x and e_y are written in the
order (e_a, e_r, e_t).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import ClassVar, Literal

import numpy as np
from numpy.polynomial import Chebyshev

from thermoroll_cli.exact.hertz import HertzContact, hertz_contact
from thermoroll_cli.problem.curved_patch import CurvedPatch, conformal_patch
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.kinds import Task
from thermoroll_cli.problem.problem import Motion, Problem
from thermoroll_cli.tools.arrays import Array

RingName = Literal["inner", "outer"]
RINGS: tuple[RingName, ...] = ("inner", "outer")
Control = Literal["tractions", "outer", "inner"]

AXIAL, RADIAL, TANGENTIAL = np.eye(3)
STANDARD_DENSITY = 7800.0
"""Density of a ball in kg/m³ if its material gives none."""
DEGREE = 20
"""Of the polynomial in cos α for Hertz's approach: exact to rounding, for the approach changes by a few percent."""


@dataclass(frozen=True)
class BearingProblem(Task):
    """A ball bearing. `contact` is a problem whose geometry, load, and motion each contact of a ball replaces.

    - `ball_diameter`, `pitch_diameter` (m), number of `balls`, `contact_angle` without load (rad);
    - `conformity`: groove radius over ball diameter, of the inner and the outer ring;
    - `speeds`: of both rings in rad/s;
    - `axial` (N), or the given `axial_displacement` (m) of the inner ring from the middle; `radial` (N) towards ball 1;
      `moments` (N m) about the axis across the radial load and about the radial load, None for a ring that is held straight;
    - `widening`: strain by which the inner ring is wider than the outer one, by its temperature;
    - `control`: what determines the axis of a ball; `common_cage`: all balls go round at one speed;
    - `curved`: contacts follow the groove, or lie in planes;
    - `capacity`: basic dynamic load rating (N), None if not known.
    """

    kind: ClassVar[str] = "bearing"

    contact: Problem
    ball_diameter: float
    pitch_diameter: float
    balls: int
    contact_angle: float
    conformity: tuple[float, float]
    speeds: tuple[float, float] = (0.0, 0.0)
    axial: float = 0.0
    axial_displacement: float | None = None
    radial: float = 0.0
    moments: tuple[float, float] | None = None
    widening: float = 0.0
    control: Control = "tractions"
    common_cage: bool = False
    curved: bool = True
    capacity: float | None = None

    @property
    def rolls(self) -> bool:
        """Whether the rings turn against each other."""
        return self.speeds[0] != self.speeds[1]

    @property
    def balances(self) -> bool:
        """Whether the axes of the balls follow from the tractions."""
        return self.rolls and self.control == "tractions"

    @property
    def controlling(self) -> RingName:
        """The ring at which a ball does not spin where tractions do not decide, and the first guess where they do."""
        return "inner" if self.control == "inner" else "outer"

    @property
    def direction(self) -> float:
        """1 if the inner ring turns faster than the outer one, else −1."""
        return 1.0 if self.speeds[0] >= self.speeds[1] else -1.0

    @property
    def groove_distance(self) -> float:
        """Distance A of the grooves' centres without load in m."""
        return (sum(self.conformity) - 1.0) * self.ball_diameter

    @property
    def lengths(self) -> tuple[float, float]:
        """Distance in m of a ball's centre from the centre of each groove that it touches without load."""
        inner, outer = self.conformity
        return (inner - 0.5) * self.ball_diameter, (outer - 0.5) * self.ball_diameter

    @property
    def arm(self) -> float:
        """Distance in m of the inner groove's centre from the bearing's axis, the arm of moments."""
        return 0.5 * self.pitch_diameter + self.lengths[0] * math.cos(self.contact_angle)

    @property
    def places(self) -> Array:
        """Angle ψ of each ball around the bearing in rad; ball 1 is at 0."""
        return np.asarray(2.0 * math.pi * np.arange(self.balls) / self.balls)

    @property
    def mass(self) -> float:
        """Mass of a ball in kg."""
        return (self.contact.upper.density or STANDARD_DENSITY) * math.pi / 6.0 * self.ball_diameter**3

    @property
    def inertia(self) -> float:
        """Moment of inertia of a ball in kg m²."""
        return self.mass * self.ball_diameter**2 / 10.0

    def centrifugal(self, cage_speed: Array | float) -> Array:
        """Centrifugal force of a ball in N, ½ m d_m ω²."""
        return np.asarray(0.5 * self.mass * self.pitch_diameter * np.square(cage_speed))

    def gyroscopic(self, motion: Array) -> Array:
        """Moment in N m that turns a ball's axis with the cage, J ω_m e_a × ω_b; `motion` as of `slip`."""
        return self.inertia * motion[0] * _cross(AXIAL, motion[1:])

    def geometry(self, ring: RingName, angle: float) -> Geometry:
        """Radii of a contact at a contact angle (rad): the ring rolls with the radius of its cone there."""
        outwards = 1.0 if ring == "outer" else -1.0
        distance = 0.5 * (self.pitch_diameter + outwards * self.ball_diameter * math.cos(angle))
        rolling = -outwards * distance / max(math.cos(angle), 1e-12)
        radius = 0.5 * self.ball_diameter
        return Geometry(rolling, -self.conformity[RINGS.index(ring)] * self.ball_diameter, radius, radius)

    def hertz(self, ring: RingName, angle: float, load: float = 1.0) -> HertzContact:
        """Hertz's contact of a ball and a ring, of a load in N."""
        geometry = self.geometry(ring, angle)
        return hertz_contact(geometry.curvature_x, geometry.curvature_y, self.contact.contact_modulus, load)

    def saturation(self, ring: RingName, angle: float, load: float) -> Array:
        """Creepages, and spin (rad/m), at which a contact of a load in N slides all over."""
        hertz = self.hertz(ring, angle, load)
        creepage = self.contact.friction.coefficient * hertz.semi_axis_x * hertz.curvature_x
        return np.array([creepage, creepage, creepage / hertz.semi_axis_y])

    @cached_property
    def _approaches(self) -> tuple[Chebyshev, ...]:
        return tuple(Chebyshev.interpolate(
            np.vectorize(lambda cosine, ring=ring: self.hertz(ring, math.acos(cosine)).approach), DEGREE, domain=[0.0, 1.0])
            for ring in RINGS)  # fmt: skip

    def unit_approaches(self, angles: Array) -> Array:
        """Hertz's approach under 1 N in m at contact angles (…, 2) at the inner and the outer ring; it grows as load^(2/3)."""
        cosines = np.clip(np.cos(angles), 0.0, 1.0)
        return np.stack([approach(cosines[..., k]) for k, approach in enumerate(self._approaches)], axis=-1)

    def frame(self, ring: RingName, angle: float) -> tuple[Array, Array, Array]:
        """e_z, e_x and e_y of a contact."""
        outwards = 1.0 if ring == "outer" else -1.0
        normal = outwards * np.array([math.sin(angle), math.cos(angle), 0.0])
        along = -outwards * self.direction * TANGENTIAL
        return normal, along, _cross(normal, along)

    def slip(self, ring: RingName, angle: float, motion: Array) -> tuple[float, Array, float]:
        """Rigid motion of a ring over a ball: the rolling speed (m/s), slip along and across (m/s) and spin (rad/s), and the
        rolling velocity of the ring over the ball (rad/s), about e_y; linear in `motion`.

        `motion` is the speed of the cage and the ball's angular velocity in the frame of the cage along e_a, e_r and e_t, in
        rad/s. The slip at the place P of a contact is (Ω − ω_m) e_a × P − ω_b × (P − O), O being the ball's centre."""
        normal, along, across = self.frame(ring, angle)
        turning = (self.speeds[RINGS.index(ring)] - motion[0]) * AXIAL
        of_ball = 0.5 * self.ball_diameter * normal
        on_ring = _cross(turning, 0.5 * self.pitch_diameter * RADIAL + of_ball)
        on_ball = _cross(motion[1:], of_ball)
        slip, relative = on_ring - on_ball, turning - motion[1:]
        return (0.5 * float((on_ring + on_ball) @ along), np.array([slip @ along, slip @ across, relative @ normal]),
                float(relative @ across))

    def creepages(self, ring: RingName, angle: float, motion: Array) -> Array:
        """Creepages along and across, and spin (rad/m)."""
        speed, slip, _ = self.slip(ring, angle, motion)
        return slip / speed

    def race_control(self, angles: Array, ring: RingName) -> Array:
        """The `motion` of a ball at both contact `angles` with no creepage along rolling in either contact, no spin at `ring`,
        and no turn about e_t (Jones 1960)."""
        return self._rolling(angles, lambda motion: self.slip(ring, float(angles[RINGS.index(ring)]), motion)[1][2])

    def along_the_bearing(self, angles: Array) -> Array:
        """The `motion` of a ball that rolls about an axis along that of the bearing, without a gyroscopic moment."""
        return self._rolling(angles, lambda motion: float(motion[2]))

    def _rolling(self, angles: Array, vanishes: Callable[[Array], float]) -> Array:
        """The `motion` without creepage along rolling and turn about e_t at which a linear function of it vanishes, too."""
        def conditions(motion: Array) -> Array:
            along = [self.slip(each, float(angle), motion)[1][0] for each, angle in zip(RINGS, angles, strict=True)]
            return np.array([*along, vanishes(motion) * self.ball_diameter, motion[3] * self.ball_diameter])

        at_rest = conditions(np.zeros(4))
        return np.linalg.solve(np.array([conditions(unit) - at_rest for unit in np.eye(4)]).T, -at_rest)

    def contact_problem(self, contact: Problem, ring: RingName, angle: float, load: float, motion: Array) -> Problem:
        """`contact` with geometry, load (N) and creepages of a ball's contact with a ring."""
        speed, slip, rolling = self.slip(ring, angle, motion)
        geometry: Geometry | CurvedPatch = self.geometry(ring, angle)
        # Shapes slip with the rolling velocity, which creepage makes another one than that of the mean speed.
        turning = abs(rolling) / (speed * geometry.curvature_x)
        if self.curved:
            patch = _curved(geometry, contact.compliance_shares)
            geometry = replace(patch, spin=tuple((turning * np.array(patch.spin)).tolist()))
        along, across, spin = (slip / speed).tolist()
        moving = Motion(speed, along, across, spin, differential_slip=contact.motion.differential_slip, turning=turning)
        return replace(contact, geometry=geometry, normal_force=load, motion=moving)


@lru_cache(maxsize=256)
def _curved(geometry: Geometry, shares: tuple[float, float]) -> CurvedPatch:
    return conformal_patch(geometry, shares)


def _cross(a: Array, b: Array) -> Array:
    """a × b of two single vectors, a tenth of the time of `np.cross`, of which a search needs thousands."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])

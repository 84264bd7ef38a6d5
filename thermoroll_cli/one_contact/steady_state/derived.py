"""Quantities of a problem before anything is solved on a grid: sizes and compliances of the contact, slip without traction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from thermoroll_cli.exact.hertz import HertzContact
from thermoroll_cli.physics.contact.active_set import Approach, Given
from thermoroll_cli.physics.contact.contact_scales import ContactScales, contact_scales, hertz_at
from thermoroll_cli.physics.halfspace.bodies import Bodies, bodies_of
from thermoroll_cli.physics.numerics.convolution import Parities
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.rolling.differential_slip import DifferentialSlip, resolved
from thermoroll_cli.problem.contact import Past
from thermoroll_cli.problem.problem import Material, Problem
from thermoroll_cli.tools.arrays import Array

SLIP_SAMPLES = 65
"""Places across the contact at which the largest differential slip is searched for."""


@dataclass(frozen=True)
class DerivedQuantities:
    """A problem with its derived constants (SI), and in a step over time with the `past` of its contact."""

    problem: Problem
    past: Past | None = None

    @property
    def given(self) -> Given:
        """What presses the bodies together: the normal force (N), or their approach."""
        return self.problem.normal_force if self.problem.approach is None else Approach(self.problem.approach)

    @cached_property
    def hertz(self) -> HertzContact | None:
        """Hertz's contact of homogeneous elastic bodies with radii; None of others, which have `scales` alone."""
        p = self.problem
        if not p.geometry.elliptic or self.bodies.relaxes or self.bodies.dispersive:
            return None
        return hertz_at(p.geometry, p.contact_modulus, self.given)

    @cached_property
    def scales(self) -> ContactScales:
        """Size, pressure and approach of the contact: Hertz's, or those of a coarse solution for profiles and coatings."""
        p = self.problem
        if self.hertz is not None:
            return ContactScales.of_hertz(self.hertz)
        return contact_scales(p.geometry, self.bodies, self.given)

    @cached_property
    def bodies(self) -> Bodies:
        """How both bodies respond to load."""
        p = self.problem
        return bodies_of(p.lower, p.upper, p.motion.speed, p.interlayer.compliance, p.length)

    @cached_property
    def compliance_shares(self) -> tuple[float, float]:
        """w₁ and w₂, the shares of the bodies in the compliance of this contact, of coated ones at its size."""
        if self.problem.line or not self.bodies.dispersive:
            return self.bodies.shares
        return self.bodies.shares_of(self.scales.semi_axis_x, self.scales.semi_axis_y)

    @property
    def dissimilar(self) -> bool:
        """True if pressure moves the surfaces tangentially and shear normally (Dundurs' second constant β ≠ 0 at any wave
        number)."""
        return self.dundurs_beta != 0.0

    @cached_property
    def dundurs_beta(self) -> float:
        """β = πE*K = ½E*·½[(1−2ν₁)/G₁ − (1−2ν₂)/G₂], between −½ and ½ (Johnson, Contact Mechanics, Eq. 5.3). With layers β
        depends on the wave number; this is then the largest one, with E* of the surfaces' materials."""
        return self.bodies.dundurs_beta

    def grid(self, shape: tuple[int, int], extent: float) -> Grid:
        """`shape` elements over `extent` semi-axes in each direction, or `numerics.across` across rolling; not beyond the ends
        of a profile. The one element across a line contact has no end."""
        numerics, domain = self.problem.numerics, self.scales.domain(extent)
        if self.problem.line:
            return Grid.over((shape[0], 1), *domain._replace(side_y=math.inf))
        if numerics.across is not None and extent == numerics.extent:  # a domain that has grown covers more
            low, high = numerics.across
            domain = domain._replace(side_y=high - low, centre=0.5 * (low + high))
        return Grid.over(shape, *domain)

    @cached_property
    def contact_angles(self) -> tuple[float, float]:
        """Lowest and highest inclination in rad of the surface in which the bodies touch, across the contact but for its very
        ends, where crowns are vertical."""
        scales = self.scales
        y = scales.centre + 0.98 * scales.semi_axis_y * np.linspace(-1.0, 1.0, SLIP_SAMPLES)
        angles = self.problem.geometry.surface_angle(self.compliance_shares, y)
        return float(angles.min()), float(angles.max())

    @property
    def lateral_curvature(self) -> float:
        """Relative curvature 1/R'_y in 1/m; with a profile about that of a parabolic gap with a contact of the same width."""
        geometry, scales = self.problem.geometry, self.scales
        return geometry.curvature_y if geometry.elliptic else scales.approach / scales.semi_axis_y**2

    @cached_property
    def saturation_creepage(self) -> float:
        """Longitudinal creepage beyond which a circular contact of the same mean radius slides as a whole (Johnson's
        estimate, 3μW/(C G a b) with C ≈ 4, and what the interlayer adds), or a line contact does (Carter's μp₀ Σ(1−ν)/G, which
        is μa/R): the scale of all creepages. Compliances of bodies with layers, or that relax, are those for waves as long as
        the contact."""
        scales = self.scales
        along, across = self.bodies.felt_shear(scales.mean_radius, scales.semi_axis_x)
        shear = self.interlayer_shear / scales.semi_axis_x
        if self.problem.line:
            return self.problem.friction.coefficient * scales.peak_pressure * along + shear
        modulus = 2.0 / across  # G of two equal bodies
        return 3.0 * self.problem.traction_limit / (4.0 * modulus * scales.mean_radius**2) + shear

    @property
    def interlayer_shear(self) -> float:
        """L μ₀p₀ in m: displacement by which the interlayer shears under the largest traction."""
        return self.problem.interlayer.compliance * self.problem.friction.coefficient * self.scales.peak_pressure

    def peclet(self, body: Material) -> float:
        """V a0/κ of one body, nan without a diffusivity."""
        if body.diffusivity is None:
            return math.nan
        return self.problem.motion.speed * self.scales.semi_axis_x / body.diffusivity

    @cached_property
    def kinematics(self) -> Kinematics:
        """Motion of the surfaces over each other."""
        return Kinematics(self)


@lru_cache(maxsize=2)
def derived_of(problem: Problem) -> DerivedQuantities:
    """The derived quantities of a problem, made once for whoever asks next: its reader, its plan, its solver."""
    return DerivedQuantities(problem)


def pressed_to(problem: Problem, approach: float) -> Problem:
    """`problem` at a given `approach` (m), with the normal force that it needs without heat and shear: exact for Hertz's
    contact, else from a coarse solution. Raises Unsolvable where there is no contact."""
    problem = replace(problem, approach=approach)
    return replace(problem, normal_force=DerivedQuantities(problem).scales.normal_force)


def pressed_with(problem: Problem, pressure: float) -> Problem:
    """`problem` with the normal force under which smooth elastic bodies have the peak `pressure` (Pa): Hertz's grows with the
    cube root of the load, in a line contact with its square root, p₀² = W'E*/(πR)."""
    of_one = DerivedQuantities(replace(problem, normal_force=1.0)).scales.peak_pressure
    return replace(problem, normal_force=(pressure / of_one) ** (2 if problem.line else 3), hertz_pressure=pressure)


def rubbed(problem: Problem, points: Sequence[tuple[float, float]]) -> Problem:
    """`problem` with shares of its friction at `points` (y in m, share) across rolling; the scale is their mean over an
    estimate of the pressure."""
    y, shares = np.array(points).T
    if np.ptp(shares) == 0.0:
        return replace(problem, friction=problem.friction.spread(y, shares, 1.0))
    scales = DerivedQuantities(problem).scales
    low, high = scales.centre - scales.semi_axis_y, scales.centre + scales.semi_axis_y
    places, loads = np.array(scales.loads).T if scales.loads else (np.empty(0), np.empty(0))
    # Shares and loads are linear between these places, so that two places of Gauss's rule on each piece are exact.
    pieces = np.unique(np.clip(np.concatenate((y, places, (low, high))), low, high))
    middle, half = 0.5 * (pieces[1:] + pieces[:-1]), 0.5 * np.diff(pieces)
    at, widths = np.concatenate((middle - half / math.sqrt(3.0), middle + half / math.sqrt(3.0))), np.tile(half, 2)
    line = np.interp(at, places, loads) if scales.loads else 1.0 - ((at - scales.centre) / scales.semi_axis_y) ** 2
    mean = np.average(np.interp(at, y, shares), weights=widths * line)
    return replace(problem, friction=problem.friction.spread(y, shares, float(mean)))


@dataclass(frozen=True)
class Kinematics:
    """The slip of a contact before any traction, and the symmetry of its motion."""

    derived: DerivedQuantities

    @property
    def problem(self) -> Problem:
        return self.derived.problem

    @property
    def moves(self) -> bool:
        """True if the contact can have tangential load: creepage, spin, a force, differential slip, bodies whose surfaces
        strain differently under pressure, or a past."""
        if self.derived.past is not None:
            return True
        m = self.problem.motion
        driven = any((m.creepage_x, m.creepage_y, m.spin, m.force_x, m.force_y))
        return driven or self.derived.dissimilar or self.differential_slip.active

    @cached_property
    def differential_slip(self) -> DifferentialSlip:
        """d(y), the variation of the longitudinal creepage across the contact; zero where its effect is negligible."""
        derived = self.derived
        if self.problem.line:
            why_not = "nothing varies across a line contact"
            return DifferentialSlip(self.problem.geometry, derived.compliance_shares, why_not=why_not)
        return resolved(self.problem, derived.compliance_shares, self._across,
                        (derived.scales.semi_axis_x, derived.scales.semi_axis_y), derived.saturation_creepage,
                        self.problem.numerics.negligible)

    @property
    def slip_varies(self) -> bool:
        """Whether the slip without traction changes over the contact."""
        return self.problem.motion.spin != 0.0 or self.differential_slip.active

    @property
    def _across(self) -> Array:
        """Places across the contact, in m."""
        return np.asarray(self.derived.scales.centre + self.derived.scales.semi_axis_y * np.linspace(-1.0, 1.0, SLIP_SAMPLES))

    @property
    def has_traction(self) -> bool:
        return self.moves and self.problem.friction.coefficient > 0.0

    @property
    def feeds_back(self) -> bool:
        """True if shear changes the pressure (without any heat): then Hertz's pressure is only a first guess."""
        return self.derived.dissimilar and self.has_traction

    @property
    def carter(self) -> bool:
        """True if the tractions are those of Carter (`exact.rolling_cylinders`) while the pressure is Hertz's: of a line
        contact of bodies alike whose slip without traction, or whose friction, nothing else changes."""
        derived, problem, motion = self.derived, self.problem, self.problem.motion
        plain = (problem.friction.law is None and not problem.friction_varies and problem.interlayer.yield_stress is None
                 and not problem.interlayer.compliance)
        return (problem.line and derived.hertz is not None and not derived.dissimilar and derived.past is None and plain
                and not ((motion.creepage_x or motion.creepage_y) and (motion.force_x, motion.force_y) != (None, None)))

    @cached_property
    def mirror(self) -> Parities | None:
        """Parities of τ_x and τ_y across y = 0 where bodies and motion make the tractions their own mirror image; else None.

        Purely longitudinal rolling is its own mirror image. Lateral creepage and spin change sign in the mirror, which reverses
        all tractions. This symmetry does not hold for bodies of unlike elasticity, since the pressure pulls surfaces inwards in
        the mirror, too, nor with differential slip, which is the same on both sides."""
        if self.problem.heights is not None:
            return None
        if self.derived.past is not None:
            return self.derived.past.mirror
        m = self.problem.motion
        if not (self.problem.geometry.symmetric and self.problem.friction.symmetric):
            return None
        if m.spin == 0.0 and m.creepage_y == 0.0:
            return 1, -1
        if m.creepage_x == 0.0 and not self.derived.dissimilar and not self.differential_slip.active:
            return -1, 1
        return None

    @property
    def heat_mirrors(self) -> bool:
        """True if heat spreads symmetrically: no body moves sideways."""
        return self.problem.motion.creepage_y == 0.0 or self.problem.heating.peclet != "rolling"

    @cached_property
    def vanishing(self) -> str:
        """Which scalars `Scalar.vanishes` makes zero: those of rolling "along", "across", or ""."""
        if self.mirror == (-1, 1):
            return "across" if self.heat_mirrors or not self.problem.heating.heat else ""
        return "along" if self.mirror == (1, -1) else ""

    def mirror_on(self, columns: int, *, heated: bool) -> Parities | None:
        """`mirror` if half a grid with this number of `columns` along y determines the other half, with the heat of the contact
        (`heated`) or without; else None. With an odd number the middle elements would lie on the mirror line."""
        return self.mirror if columns % 2 == 0 and (self.heat_mirrors or not heated) else None

    def rigid_slip(self, grid: Grid) -> Array:
        """ξ_x + d(y) − ξ_φ y and ξ_y + ξ_φ x − x d'(y), (2, nx, ny); creepages that are unknowns count as zero (Eqs. 7, 11)."""
        return self.slip_at(grid.x[:, None], grid.y)

    def slip_at(self, x: Array, y: Array) -> Array:
        """The same at the places x, y (m), which are broadcast: (2, ...)."""
        slip = self.problem.geometry.rigid_slip(self.at_origin, x, y)
        slip[0] += self.differential_slip(y)
        slip[1] += self.differential_slip.lateral(x, y)
        return slip

    @cached_property
    def at_origin(self) -> tuple[float, float, float]:
        """Creepages and spin (rad/m) of the frame's origin: those given there, or those with which the slip at the contact's
        centre of pressure, and the spin about its normal, are the given ones."""
        motion, geometry, slip_of_shapes = self.problem.motion, self.problem.geometry, self.differential_slip
        along, across, spin = motion.creepage_x or 0.0, motion.creepage_y or 0.0, motion.spin
        if motion.at == "origin":
            return along, across, spin
        place = np.array([self.derived.scales.pressure_centre])
        cosine = float(np.cos(geometry.inclination(place))[0])
        turning = (spin + float(slip_of_shapes.slope(place)[0])) / cosine
        along += turning * float(geometry.lateral_place(place)[0]) - float(slip_of_shapes(place)[0])
        still = geometry.rigid_slip((0.0, 0.0, 0.0), np.zeros(1), place)
        return along, (across - float(still[1][0])) / cosine, turning

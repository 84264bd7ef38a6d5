"""A loaded patch as a problem of the contact solver, and its forces back in the axes of the track.

The solver's axes have x backwards and y to the left, with the rail as the lower body and the origin at the reference place:
x_t = x_ref − x and s = −y. Creepages of the rail relative to the wheel are ξ_x = −c_x, ξ_y = −c_s, ξ_φ = c_φ; forces on the
rail are F_x and F_s as the solver gives them, and the moment about the normal is −M_z. """

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.wheelset.curves import STEP, curve
from thermoroll_cli.many_contacts.wheelset.kinematics import MotionOfWheelset, Slip, creepages, directions
from thermoroll_cli.many_contacts.wheelset.one_wheel import CarryingPatch
from thermoroll_cli.many_contacts.wheelset.patch_surface import CLOSE, PatchSurface, nearest
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SideName
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.rounding import Rounding
from thermoroll_cli.problem.scalar_errors import passed_on
from thermoroll_cli.tools.arrays import Array

LINEAR, SPIN = 3.3, 0.4
"""Force over E* a² and creepage, and creepage across over a and spin that causes the same force, in Kalker's linear theory of
circles at Poisson's ratio 0.28."""
VIRTUAL = 0.55
"""Overlap of the virtual patch over the approach."""


def slip_on(carrying: CarryingPatch, motion: MotionOfWheelset) -> Slip:
    """The rigid motion over a patch of a right wheel; its place lies on the wheel's undeformed surface."""
    patch = carrying.patch
    normal = directions(patch.angle)[2]
    deep = patch.overlap[0] * normal
    slip = Slip(motion, patch.position, patch.facing.wheel.radius, tuple((patch.place + deep).tolist()), tuple(deep.tolist()))
    if not (patch.follows and motion.follows):
        return slip
    # The axle rises and falls with the surfaces: their approach does not change.
    down = slip.position.turn.T @ np.array([0.0, 0.0, 1.0])
    closing = slip.speed * float(slip.velocity(np.array(slip.place)) @ normal) / float(down @ normal)
    return replace(slip, motion=replace(motion, vertical=motion.vertical + closing))


def problem_of_patch(contact: Problem, carrying: CarryingPatch, motion: MotionOfWheelset) -> Problem:
    """`contact` with the geometry, the load and the creepages of a patch of a right wheel."""
    patch = carrying.patch
    s, lowest, x_lowest, fitted = patch.table
    slip = slip_on(carrying, motion)
    c_x, c_s, c_phi = creepages(slip, np.array(slip.place), patch.angle)
    angle = patch.inclination(s)
    turned = angle - patch.angle
    lateral = patch.lateral(s)
    w = slip.velocity(patch.wheel_points(s))
    along_s = np.cos(angle) * w[:, 1] + np.sin(angle) * w[:, 2]
    spin = slip.rotation @ np.array([np.zeros(len(s)), -np.sin(angle), np.cos(angle)])
    # The departure of the slip from that of a plane with the creepages of the place.
    slips = -w[:, 0] + c_x - c_phi * lateral, -along_s + c_s * np.cos(turned), spin - c_phi * np.cos(turned)
    if not patch.curved:
        slips = (np.zeros(len(s)),) * 3
    # An approach closes the gap by its part along the normal: that of this patch must lead to the gap at its height.
    lowest = lowest + patch.overlap[0] - carrying.sunk * (1.0 - np.cos(turned))
    # Against the track: y = −s.
    columns = {"y": -s, "lateral": -lateral, "angle": turned, "gap_lowest": lowest, "x_lowest": -x_lowest,
               "curvature": 2.0 * fitted[0], "cubic": -fitted[1], "quartic": fitted[2],
               "slip_x": slips[0], "slip_y": slips[1], "spin": slips[2]}
    rows: dict[str, Any] = {name: tuple(column[::-1].tolist()) for name, column in columns.items()}
    low_free, high_free = patch.free_ends
    low, high = patch.limits
    roller = patch.facing.rail.roller
    geometry = CurvedPatch(**rows, heights=patch.heights, lower_radius_x=roller.radius if roller else math.inf,
                           upper_radius_x=patch.facing.wheel.radius,
                           free_ends=(bool(high_free and s[-1] >= high - CLOSE), bool(low_free and s[0] <= low + CLOSE)),
                           rounded=_rounded(patch))
    moving = replace(contact.motion, speed=slip.speed, creepage_x=-c_x, creepage_y=-c_s, spin=c_phi)
    friction = friction_of(contact, carrying)
    return replace(contact, geometry=geometry, normal_force=carrying.load, motion=moving, friction=friction)


def _rounded(patch: PatchSurface) -> tuple[Rounding, ...]:
    """The rounding of both outlines over the width of a patch."""
    facing, reach = patch.facing, 0.5 * (patch.overlapping[1] - patch.overlapping[0])
    found: tuple[Rounding, ...] = ()
    for side, own, places in zip(patch.bodies, (facing.rail, facing.wheel), (facing.rail.samples, facing.locus[1:3]),
                                 strict=True):
        y, z = curve(own.profile).samples[:2, nearest(places, patch.y, patch.z)]
        found += side.roundings_at(patch.x, (float(y), float(z)), reach)
    return found


def estimated_friction(contact: Problem, carrying: CarryingPatch, motion: MotionOfWheelset) -> tuple[float, float]:
    """Forces of friction on the rail over the load, along and across, of a patch of a right wheel before it is solved:

        (F_x, F_s) = −μ W (c_x, c_s + 0.4 a c_φ)/√(c_x² + c_s² + ½ a² c_φ² + c₀²),     c₀ = μ W/(3.3 E* a²)

    Friction acts against the mean slip, of which c₀ makes what it is at small creepages in the linear theory (Kalker 1990) of a
    circle of the radius a = 3 W/(4 E* δ)."""
    slip = slip_on(carrying, motion)
    along, across, spin = creepages(slip, np.array(slip.place), carrying.patch.angle)
    radius = 0.75 * carrying.load / (contact.contact_modulus * carrying.sunk)
    friction = friction_of(contact, carrying).coefficient
    linear = friction * carrying.load / (LINEAR * contact.contact_modulus * radius**2)
    size = math.hypot(along, across, math.sqrt(0.5) * radius * spin, linear)
    if size == 0.0:
        return 0.0, 0.0
    return -friction * along / size, -friction * (across + SPIN * radius * spin) / size


def friction_of(contact: Problem, carrying: CarryingPatch) -> Friction:
    """Friction of a patch, over the inclination of the rail. Its mean is that over the pressure of Piotrowski and Kik (2008),
    whose patch is where the surfaces overlap at `VIRTUAL` of the approach, each line of rolling loaded like its overlap."""
    patch = carrying.patch
    points = patch.facing.rail.friction
    if not points:
        return contact.friction
    s, lowest, *_ = patch.table
    # That of the surface in which both touch, also where a patch lies in a plane.
    shares = np.interp(replace(patch, curved=True).inclination(s), *np.array(points).T)
    gap = lowest - lowest.min()
    weights = np.maximum(VIRTUAL * carrying.sunk - gap, 0.0)
    return contact.friction.spread(-s[::-1], shares[::-1], float(np.average(shares, weights=weights)))


@dataclass(frozen=True)
class SolvedPatch:
    """A patch of a `side` where the wheelset stands, with its problem's `result`, and what it does, in track axes seen from its
    side (m, N): its centre of pressure (y and z in the axes of the patch), the inclination there (rad), the `force` on the
    rail, and the `torque` (N m) about the axle and the `power` (W) of its tractions on the wheelset, which turns and moves;
    c_x, c_s, c_φ at the centre of pressure, or at the reference place of a plane."""

    side: SideName
    carrying: CarryingPatch
    result: Result
    centre: tuple[float, float, float]
    angle: float
    force: tuple[float, float, float]
    torque: float
    power: float
    creepages: tuple[float, float, float]

    @property
    def on_track(self) -> tuple[float, float, float]:
        """The centre of pressure in track axes, also on surfaces that rise; on a roller in its coordinates."""
        position = self.carrying.patch.position
        x, y, z = position.on_track(np.array(self.centre) - np.array([position.ahead, 0.0, 0.0])).tolist()
        return x, y, z

    @property
    def local(self) -> tuple[float, float, float]:
        """Components of the force along the track, across and into the rail at the patch."""
        force = self.carrying.patch.position.turn.T @ np.array(self.force)
        along, across, normal = (float(direction @ force) for direction in directions(self.angle))
        return along, across, normal

    @property
    def solved(self) -> CarryingPatch:
        """The patch with the ratios that were found, for the next round."""
        approach = 1e-6 * self.result.coupled.scalars["approach_um"]
        return replace(self.carrying, vertical=self.force[2] / self.result.problem.normal_force,
                       over_coarse=approach / (self.carrying.sunk / self.carrying.over_coarse))

    @property
    def in_profiles(self) -> tuple[float, float]:
        """y of the centre of pressure in the profiles of the rail and of the wheel, in m."""
        facing = self.carrying.patch.facing
        rail, wheel = (nearest(places, *self.centre[1:]) for places in (facing.rail.samples, facing.locus[1:3]))
        return float(curve(facing.rail.profile).samples[0][rail]), float(curve(facing.wheel.profile).samples[0][wheel])

    @property
    def rolling_radius(self) -> float:
        """Distance of the centre of pressure from the axle in m, on the undeformed wheel."""
        facing = self.carrying.patch.facing
        return float(facing.wheel.samples[1][nearest(facing.locus[1:3], *self.centre[1:])])

    @property
    def rolling_radius_error(self) -> float:
        """Error of the rolling radius in m: along the wheel, that of the centre of pressure and half a step of samples."""
        return float(passed_on([1e-3 * self.error_of("contact_y_mm"), 0.5 * STEP], [math.sin(self.angle)] * 2))

    def error_of(self, name: str) -> float:
        """Estimated error of a scalar of the contact in its own unit, at the load it has."""
        return self.result.uncertainty[name]

    def force_errors(self, load: float) -> Array:
        """Estimated errors of the forces in N, (3,) in track axes, with the relative error of the `load`."""
        surface = self.carrying.patch
        across, normal = ((self.error_of("contact_force_y_N"), self.error_of("contact_force_z_N")) if surface.curved else
                          (self.error_of("force_y_N"), 0.0))
        return passed_on([self.error_of("force_x_N"), across, normal, load],
                         np.column_stack([*(surface.position.turn @ e for e in directions(surface.angle)), self.force]))


def solved_patch(side: SideName, carrying: CarryingPatch, motion: MotionOfWheelset, result: Result) -> SolvedPatch:
    """Forces of a patch from its `result`. Those of the solver are extrapolated; its fields say where they act."""
    patch, state = carrying.patch, result.coupled
    scalars, s = state.scalars, -state.y
    slip = slip_on(carrying, motion)
    area = float((state.x[1] - state.x[0]) * (state.y[1] - state.y[0]))
    pressure, shear_x, shear_y = (np.asarray(state.fields[name]) * area for name in ("pressure", "shear_x", "shear_y"))
    load = float(pressure.sum())
    x_centre, s_centre = float(pressure.sum(axis=1) @ state.x) / load, float(pressure.sum(axis=0) @ s) / load
    at = np.array([s_centre])
    angle = float(patch.inclination(at)[0])
    centre = patch.places(at)[0] + np.array([patch.x - x_centre, 0.0, 0.0])
    _, e_across, e_normal = directions(patch.angle)
    across, normal = ((scalars["contact_force_y_N"], scalars["contact_force_z_N"]) if patch.curved else
                      (scalars["force_y_N"], result.problem.normal_force))
    force = patch.position.turn @ (np.array([scalars["force_x_N"], 0.0, 0.0]) + across * e_across + normal * e_normal)
    # Tractions act where the bodies touch, as the slip does.
    inclined = patch.inclination(s)
    on_wheel = -np.stack((shear_x, shear_y * np.cos(inclined), shear_y * np.sin(inclined)), axis=-1)
    points = np.broadcast_to(patch.wheel_points(s), on_wheel.shape).copy()
    points[..., 0] -= state.x[:, None]
    arms = points - patch.position.origin(patch.facing.wheel.radius)
    # Pressure that leads, of unlike bodies, or lags, of hot ones, brakes the wheel or drives it.
    braked = 1e-3 * np.nan_to_num(scalars.get("rolling_resistance_moment_Nmm", 0.0))
    moment = np.cross(arms, on_wheel).sum(axis=(0, 1)) + braked * directions(angle)[1]
    axle = patch.position.rotation[:, 1]
    local = (creepages(slip, patch.wheel_points(at)[0] - np.array([x_centre, 0.0, 0.0]), angle) if patch.curved
             else creepages(slip, np.array(slip.place), patch.angle))
    return SolvedPatch(side, carrying, result, tuple(centre.tolist()), angle, tuple(force.tolist()), float(axle @ moment),
                       slip.power(on_wheel.sum(axis=(0, 1)), moment), local)

"""A loaded patch as a problem of the contact solver, and its forces back in the axes of the track.

The solver's axes have x backwards and y to the left, with the rail as the lower body and the origin at the reference place:
x_t = x_ref − x and s = −y. Creepages of the rail relative to the wheel are ξ_x = −c_x, ξ_y = −c_s, ξ_φ = c_φ; forces on the
rail are F_x and F_s as the solver gives them, and the moment about the normal is −M_z. """

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.wheelset.kinematics import MotionOfWheelset, Slip, creepages, directions
from thermoroll_cli.wheelset.one_wheel import Bearing
from thermoroll_cli.wheelset.patch_surface import CLOSE

VIRTUAL = 0.55
"""Overlap of the virtual patch over the approach."""


@dataclass(frozen=True)
class PatchMotion:
    """The rigid motion over a patch: `slip` as a field, and the creepages c_x, c_s, c_φ (rad/m) at its reference place."""

    slip: Slip
    creepages: tuple[float, float, float]
    points: Array
    """Points of the wheel's undeformed surface at the places asked for, (n, 3)."""


def motion_of(bearing: Bearing, motion: MotionOfWheelset, s: Array) -> PatchMotion:
    """The motion over a patch of a right wheel; slip counts from the wheel's own undeformed surface."""
    patch, facing = bearing.patch, bearing.patch.facing
    place = patch.region.place
    on_wheel = np.array([place.x, place.y, place.z]) + patch.overlap[0] * directions(place.angle)[2]
    slip = Slip(motion, facing.position, facing.wheel.radius, (float(on_wheel[0]), float(on_wheel[1]), float(on_wheel[2])))
    points = patch.wheel_points(s) + np.array([place.x, 0.0, 0.0])
    return PatchMotion(slip, creepages(slip, on_wheel, place.angle), points)


def problem_of_patch(contact: Problem, bearing: Bearing, motion: MotionOfWheelset, load: float) -> Problem:
    """`contact` with the geometry, the `load` (N) and the creepages of a patch of a right wheel."""
    patch = bearing.patch
    place = patch.region.place
    s, lowest, x_lowest, fitted = patch.table
    moves = motion_of(bearing, motion, s)
    c_x, c_s, c_phi = moves.creepages
    angle = patch.inclination(s)
    turned = angle - place.angle
    lateral = patch.lateral(s)
    w = moves.slip.velocity(moves.points)
    along_s = np.cos(angle) * w[:, 1] + np.sin(angle) * w[:, 2]
    spin = moves.slip.rotation @ np.array([np.zeros(len(s)), -np.sin(angle), np.cos(angle)])
    # The departure of the slip from that of a plane with the creepages of the place.
    slips = -w[:, 0] + c_x - c_phi * lateral, -along_s + c_s * np.cos(turned), spin - c_phi * np.cos(turned)
    if not patch.curved:
        slips = (np.zeros(len(s)),) * 3
    # An approach closes the gap by its part along the normal: that of the bearing must lead to the gap at its height.
    lowest = lowest + patch.overlap[0] - bearing.sunk * (1.0 - np.cos(turned))
    # Against the track: y = −s.
    columns = {"y": -s, "lateral": -lateral, "angle": turned, "gap_lowest": lowest, "x_lowest": place.x - x_lowest,
               "curvature": 2.0 * fitted[0], "cubic": -fitted[1], "quartic": fitted[2],
               "slip_x": slips[0], "slip_y": slips[1], "spin": slips[2]}
    rows: dict[str, Any] = {name: tuple(column[::-1].tolist()) for name, column in columns.items()}
    low_free, high_free = patch.free_ends
    low, high = patch.limits
    geometry = CurvedPatch(**rows, lower_radius_x=math.inf, upper_radius_x=patch.facing.wheel.radius,
                           free_ends=(bool(high_free and s[-1] >= high - CLOSE), bool(low_free and s[0] <= low + CLOSE)))
    moving = replace(contact.motion, speed=moves.slip.speed, creepage_x=-c_x, creepage_y=-c_s, spin=c_phi)
    return replace(contact, geometry=geometry, normal_force=load, motion=moving, friction=friction_of(contact, bearing))


def friction_of(contact: Problem, bearing: Bearing) -> Friction:
    """Friction of a patch, over the inclination of the rail. Its mean is that over the pressure of Piotrowski and Kik (2008),
    whose patch is where the surfaces overlap at `VIRTUAL` of the approach, each line of rolling loaded like its overlap."""
    patch = bearing.patch
    points = patch.facing.rail.friction
    if not points:
        return contact.friction
    s, lowest, *_ = patch.table
    # That of the surface in which both touch, also where a patch lies in a plane.
    shares = np.interp(replace(patch, curved=True).inclination(s), *np.array(points).T)
    gap = lowest - lowest.min()
    weights = np.maximum(VIRTUAL * bearing.sunk - gap, 0.0)
    return contact.friction.spread(-s[::-1], shares[::-1], float(np.average(shares, weights=weights)))


@dataclass(frozen=True)
class PatchForces:
    """What a patch of a right wheel does, in track axes seen from its side (m, N): its centre of pressure, the inclination
    there (rad), the `force` on the rail, and the `torque` (N m) about the axle and the `power` (W) of its tractions on the
    wheelset, which turns and moves; c_x, c_s, c_φ at the centre of pressure, or at the reference place of a plane."""

    centre: tuple[float, float, float]
    angle: float
    force: tuple[float, float, float]
    torque: float
    power: float
    creepages: tuple[float, float, float]

    @property
    def local(self) -> tuple[float, float, float]:
        """Components of the force along the track, across and into the rail at the patch."""
        across, normal = (np.array(e) for e in directions(self.angle)[1:])
        return self.force[0], float(across @ np.array(self.force)), float(normal @ np.array(self.force))


def forces_of(bearing: Bearing, motion: MotionOfWheelset, result: Result) -> PatchForces:
    """Forces of a patch from its `result`. Those of the solver are extrapolated; its fields say where they act."""
    patch, state = bearing.patch, result.coupled
    place, scalars = patch.region.place, state.scalars
    s = -state.y
    moves = motion_of(bearing, motion, s)
    area = float((state.x[1] - state.x[0]) * (state.y[1] - state.y[0]))
    pressure, along, across = (np.asarray(state.fields[name]) * area for name in ("pressure", "shear_x", "shear_y"))
    load = float(pressure.sum())
    x_centre, s_centre = float(pressure.sum(axis=1) @ state.x) / load, float(pressure.sum(axis=0) @ s) / load
    at = np.array([s_centre])
    angle = float(patch.inclination(at)[0])
    centre = patch.places(at)[0] + np.array([place.x - x_centre, 0.0, 0.0])
    _, e_across, e_normal = directions(place.angle)
    force = np.array([scalars["force_x_N"], 0.0, 0.0])
    if patch.curved:
        force = force + scalars["contact_force_y_N"] * e_across + scalars["contact_force_z_N"] * e_normal
    else:
        force = force + scalars["force_y_N"] * e_across + result.problem.normal_force * e_normal
    # Tractions on the wheel, which act at its undeformed surface, as the slip does.
    inclined = patch.inclination(s)
    on_wheel = -np.stack((along, across * np.cos(inclined), across * np.sin(inclined)), axis=-1)
    points = np.broadcast_to(moves.points, on_wheel.shape).copy()
    points[..., 0] -= state.x[:, None]
    arms = points - patch.facing.position.origin(patch.facing.wheel.radius)
    moment = np.cross(arms, on_wheel).sum(axis=(0, 1))
    axle = patch.facing.position.rotation[:, 1]
    local = moves.creepages
    if patch.curved:
        there = patch.wheel_points(at)[0] + np.array([place.x - x_centre, 0.0, 0.0])
        local = creepages(moves.slip, there, angle)
    (x, y, z), (f_x, f_y, f_z) = centre.tolist(), force.tolist()
    return PatchForces((x, y, z), angle, (f_x, f_y, f_z), float(axle @ moment),
                       moves.slip.power(on_wheel.sum(axis=(0, 1)), moment), local)

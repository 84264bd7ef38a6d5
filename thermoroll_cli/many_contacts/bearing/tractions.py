"""What the tractions and the pressure of a solved contact do to a ball."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.bearing.bearing_problem import RINGS, BearingProblem, RingName
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

WRENCH = ("force_x_N", "force_y_N", "spin_moment_Nmm", "rolling_resistance_moment_Nmm")
POWERS = "Q_F_W", "T_gamma_N", "expansion_power_W"
INTEGRALS = (*WRENCH, *POWERS)
"""Scalars of a contact that follow its creepages by the slopes of the wrench: those that act on its ball, and its powers."""


class SolvedContact(NamedTuple):
    """The `result` of a contact at `creepages` (3,); the `force` (N) and the `moment` about the ball's centre (N m) on the
    ball; and both, the moment over D/2, as a `wrench` (6,) over μW in the axes of the contact, e_z, e_x, e_y."""

    result: Result
    creepages: Array
    force: Array
    moment: Array
    wrench: Array

    @classmethod
    def of(cls, problem: BearingProblem, ring: RingName, angle: float, result: Result, friction: float) -> SolvedContact:
        """That of a `result` at a contact angle (rad), with the `friction` limit in N."""
        force, moment = tractions_on_ball(problem, ring, angle, result)
        frame, motion = np.array(problem.frame(ring, angle)), result.problem.motion
        wrench = np.concatenate([frame @ force, frame @ moment * (2.0 / problem.ball_diameter)])
        creepages = np.array([motion.creepage_x, motion.creepage_y, motion.spin])
        return cls(result, creepages, force, moment, wrench / friction)


def integrals_of(scalars: Mapping[str, float]) -> dict[str, float]:
    """The `INTEGRALS` of a contact; those that it does not have are 0."""
    return {name: 0.0 if math.isnan(scalars.get(name, math.nan)) else scalars[name] for name in INTEGRALS}


def tractions_on_ball(problem: BearingProblem, ring: RingName, angle: float, result: Result) -> tuple[Array, Array]:
    """Force (N) and moment about the ball's centre (N m) by the tractions of a ring, along e_a, e_r and e_t, and the moment of
    its pressure, which is not symmetric along rolling between unlike or hot bodies.

    Tractions act at (x, Y, D/2 − h) in the axes of the contact from the ball's centre, h being the height of the common surface
    over the plane of the contact, and are inclined by its angle β(y) across; of a patch in a plane to first order in β, as the
    slip is whose power they have."""
    normal, along, across = problem.frame(ring, angle)
    geometry, state = result.problem.geometry, result.coupled
    contact, conformity, diameter = result.problem, problem.conformity[RINGS.index(ring)], problem.ball_diameter
    share = contact.contact_modulus / contact.lower.plane_strain_modulus
    bent = ((1.0 - share) / conformity + 2.0 * share) / diameter
    curved, half = isinstance(geometry, CurvedPatch), 0.5 * diameter
    turned = geometry.inclination(state.y) if curved else bent * state.y
    sine, cosine = (np.sin(turned), np.cos(turned)) if curved else (turned, np.ones_like(turned))
    lateral, height = sine / bent, (1.0 - cosine) / bent if curved else 0.5 * bent * state.y**2
    area = float((state.x[1] - state.x[0]) * (state.y[1] - state.y[0]))
    shear_x, shear_y = (area * np.asarray(state.fields[name]) for name in ("shear_x", "shear_y"))
    scalars = integrals_of(state.scalars)
    force_x, force_y = scalars["force_x_N"], scalars["force_y_N"] + float((shear_y * (cosine - 1.0)).sum())
    # Extrapolated forces, which are more accurate than sums of the fields, times their arm; the rest is small.
    moment = (
        -half * scalars["force_y_N"] + (
            float((shear_y * (half - lateral * sine - (half - height) * cosine)).sum()) if curved else 0.0),
        half * force_x - 1e-3 * scalars["rolling_resistance_moment_Nmm"]
        + float((state.x[:, None] * sine * shear_y - height * shear_x).sum()),
        1e-3 * scalars["spin_moment_Nmm"],
    )
    return force_x * along + force_y * across, moment[0] * along + moment[1] * across + moment[2] * normal

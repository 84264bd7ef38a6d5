"""Wear of one passage of the contact."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import State


def sliding_work(problem: Problem, state: State) -> Array:
    """∫ p |s|/V dx of every line of rolling in N/m, (ny,): the depth worn per passage is κ times this (Archard).

    Where surfaces slide q = μ p |s|, so it is ∫ q/(μV) dx. The heat flux q balances the power of the creep forces, which leaves the
    integral over y exact; without friction slip itself is integrated."""
    dx = float(state.x[1] - state.x[0])
    fields = state.fields
    if problem.friction > 0.0:
        friction = fields.get("friction_coefficient", problem.friction)
        power = fields["heat_flux"] / np.where(np.asarray(friction) > 0.0, friction, problem.friction)
    else:
        power = fields["pressure"] * np.hypot(fields["slip_x"], fields["slip_y"])
    return np.asarray(power.sum(axis=0) * dx / problem.motion.speed)

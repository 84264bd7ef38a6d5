"""Wear of one passage of the contact."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import State


def sliding_work(problem: Problem, state: State) -> Array:
    """∫ p |s|/V dx of every line of rolling in N/m, (ny,): the depth worn per passage is κ times this (Archard).

    Where surfaces slide q = μ p |s|, and the heat flux q balances the power of the creep forces: its integral q/(μV) over the
    contact sets the total, and p |s| how it is distributed."""
    dx, fields = float(state.x[1] - state.x[0]), state.fields
    work = fields["pressure"] * np.hypot(fields["slip_x"], fields["slip_y"])
    if problem.friction > 0.0 and work.any():
        friction = fields.get("friction_coefficient", np.full_like(work, problem.friction))
        work *= float((fields["heat_flux"] / np.where(friction > 0.0, friction, problem.friction)).sum() / work.sum())
    return np.asarray(work.sum(axis=0) * dx / problem.motion.speed)

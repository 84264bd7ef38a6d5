"""Wear of one passage of the contact, by Archard's law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray, Array
from thermoroll_cli.numerics.grid import peak_value
from thermoroll_cli.problem.problem import BODIES, Problem

NAMES = ("wear_area_{}_um2", "wear_depth_max_{}_nm", "wear_rate_{}_mm3_m")


def sliding_work(problem: Problem, fields: Mapping[str, AnyArray], dx: float) -> Array:
    """∫ p |s|/V dx of every line of rolling in N/m, (ny,): the depth worn per passage is κ times this (Archard).

    Where surfaces slide q = μ p |s|, and the heat flux q balances the power of the creep forces: its integral q/(μV) over the
    contact sets the total, and p |s| how it is distributed."""
    work = fields["pressure"] * np.hypot(fields["slip_x"], fields["slip_y"])
    if problem.friction > 0.0 and work.any():
        friction = fields.get("friction_coefficient", np.full_like(work, problem.friction))
        work *= float((fields["heat_flux"] / np.where(friction > 0.0, friction, problem.friction)).sum() / work.sum())
    return np.asarray(work.sum(axis=0) * dx / problem.motion.speed)


def wear_scalars(problem: Problem, fields: Mapping[str, AnyArray], dx: float, dy: float) -> dict[str, Any]:
    """Area (µm²) and largest depth (nm) that each body loses per passage, and volume per distance rolled (mm³/m)."""
    if problem.wear is None:
        return {}
    work = sliding_work(problem, fields, dx)
    found: dict[str, Any] = {}
    for body in BODIES:
        depth = getattr(problem.wear, body).rate * work
        area = float(depth.sum()) * dy
        found |= dict(zip((name.format(body) for name in NAMES), (area * 1e12, peak_value(depth[None]) * 1e9, area * 1e9),
                          strict=True))
    return found

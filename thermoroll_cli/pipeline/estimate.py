"""Discretisation error of every scalar, from the grids that were solved on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from thermoroll_cli.pipeline.problem import Problem
from thermoroll_cli.pipeline.result import SCALARS

ERROR_SCALARS = ("Q_F_W", "force_x_N", "force_y_N", "gamma_c", "gamma_st", "gamma_p",
                 "temperature_rise_max_lower_K", "temperature_rise_max_upper_K")
"""Scalars whose error has to fall below `numerics.accuracy`."""

FLOOR = 2e-5
"""No estimate is smaller: rounding and solver tolerances are of this order."""


def estimates(levels: Sequence[Mapping[str, float]], problem: Problem) -> dict[str, float]:
    """Estimated relative error of each scalar on the last of `levels` (coarse to fine, each side doubled).

    The change over the last doubling, divided by 2^p − 1 with the order p that the last three grids show, at least 1 and
    at most 2; the coarser change, scaled likewise, is a lower bound, lest two values agree by accident. Forces are
    relative to μW where they are small, fractions of area to 1. nan for one grid alone.
    """
    return {name: _estimate(name, [level.get(name, math.nan) for level in levels], problem) for name in SCALARS}


def _scale(name: str, value: float, problem: Problem) -> float:
    if name in ("force_x_N", "force_y_N"):
        return max(abs(value), problem.traction_limit)
    if name in ("gamma_st", "power_balance_error"):
        return 1.0
    return abs(value)


def _estimate(name: str, values: list[float], problem: Problem) -> float:
    if len(values) < 2 or math.isnan(values[-1]):
        return math.nan
    scale = _scale(name, values[-1], problem)
    if scale == 0.0:
        return 0.0
    last = abs(values[-1] - values[-2])
    before = abs(values[-2] - values[-3]) if len(values) > 2 else 2.0 * last
    ratio = before / last if last > 0.0 else 4.0
    order = min(max(math.log2(ratio) if ratio > 0.0 else 1.0, 1.0), 2.0)
    error = max(last / (2.0**order - 1.0), before / 16.0)
    return max(error / scale, FLOOR)

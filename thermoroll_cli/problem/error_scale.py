"""Scale of the estimated error of each scalar: the one meaning of `error` in tables, JSON, HDF5 and pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from thermoroll_cli.problem.names import ALL_SCALARS, SCALARS

FORCES, CREEPAGES, TEMPERATURES = (
    tuple(name for name, scalar in SCALARS.items() if scalar.scale == scale) for scale in ("force", "creepage", "temperature")
)


def error_scale(name: str, summary: Mapping[str, Any]) -> float:
    """The unit of `error[name]`: the error in the scalar's own unit is `error[name]` times this (`absolute_error`).

    | scalar | its error is relative to |
    | --- | --- |
    | `force_x_N`, `force_y_N` | μW |
    | `spin_moment_Nmm` | μW sqrt(a0 b0) |
    | temperatures and their rises | the largest temperature difference of the problem: rises and bulk temperatures |
    | `creepage_longitudinal`, `creepage_lateral`, where found | the magnitude of the creepage, spin counted at sqrt(a0 b0) |
    | `gamma_st`; `stick_area_mm2` | 1 (absolute); the contact area |
    | stresses below the surface; their places and depths | the largest pressure; the smaller Hertz semi-axis |
    | anything else | its value |

    `summary` has the scalars of one state and those of the inputs (`SCALARS` and `HERTZ_SCALARS`), as in
    `Result.summary()`. nan if a scalar that the scale needs is missing.
    """
    match ALL_SCALARS[name].scale if name in ALL_SCALARS else "value":
        case "force":
            return _number(summary, "friction_limit_N")
        case "moment":
            return _number(summary, "friction_limit_N") * mean_semi_axis(summary)
        case "temperature":
            return temperature_difference(summary)
        case "creepage":
            spin = _number(summary, "creepage_spin_rad_mm") * mean_semi_axis(summary)
            return math.hypot(*(_number(summary, direction) for direction in CREEPAGES), spin)
        case "share":
            return 1.0
        case "stick area":
            return _number(summary, "contact_area_mm2")
        case "stress below":
            return _number(summary, "pressure_max_MPa")
        case "place below":
            return _smaller_semi_axis(summary)
    return abs(_number(summary, name))


def absolute_error(name: str, summary: Mapping[str, Any]) -> float:
    """Estimated discretisation error of a scalar in its own unit; nan for a given one, or without an estimate."""
    return _number(summary.get("error", {}), name) * error_scale(name, summary)


def temperature_difference(summary: Mapping[str, Any]) -> float:
    """The largest temperature difference of the problem in K: a rise, or that of both bodies far from the contact."""
    rises = [_number(summary, f"temperature_rise_max_{body}_K") for body in ("lower", "upper")]
    surfaces = [_number(summary, f"surface_temperature_max_{body}_K") for body in ("lower", "upper")]
    bulk = [surface - rise for surface, rise in zip(surfaces, rises, strict=True)]
    return max(*rises, abs(bulk[1] - bulk[0]))


def mean_semi_axis(summary: Mapping[str, Any]) -> float:
    """sqrt(a0 b0) in mm; for surfaces without a Hertz ellipse the radius of a circle of the same contact area."""
    axes = _number(summary, "hertz_a_mm") * _number(summary, "hertz_b_mm")
    return math.sqrt(_number(summary, "contact_area_mm2") / math.pi if math.isnan(axes) else axes)


def _smaller_semi_axis(summary: Mapping[str, Any]) -> float:
    """min(a0, b0) in mm; for surfaces without a Hertz ellipse as `mean_semi_axis`."""
    axes = min(_number(summary, "hertz_a_mm"), _number(summary, "hertz_b_mm"))
    return mean_semi_axis(summary) if math.isnan(axes) else axes


def _number(summary: Mapping[str, Any], name: str) -> float:
    """A scalar; nan where it is missing or, in JSON, null."""
    value = summary.get(name)
    return math.nan if value is None else float(value)

"""A soft wheel on a crowned rail over time, whose contact is that of spheres on a plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from thermoroll_cli.problem.result import Result

RADIUS = 100.0
Y = np.linspace(-30.0, 30.0, 241)
CROWN = [[float(y), float(RADIUS - math.sqrt(RADIUS**2 - y**2))] for y in Y]
FLAT = [[float(y), 0.0] for y in np.linspace(40.0, -40.0, 81)]
SOFT = {"youngs_modulus_GPa": 0.512, "poisson_ratio": 0.28}

WHEEL: dict[str, Any] = {
    "material": SOFT,
    "track": {"rail_profile": {"points_mm": CROWN}, "right": {"origin_mm": [0.0, 0.0]}},
    "wheelset": {"wheel_profile": {"points_mm": FLAT}, "nominal_radius_mm": RADIUS, "wheels": "right",
                 "flange_back_distance_mm": 100.0, "flange_back_mm": 50.0, "height_mm": 0.2201,
                 "angular_velocity_rad_s": 9.96},
    "load": {"friction_coefficient": 0.4},
    "rolling": {"speed_m_s": 1.0, "differential_slip": False},
    "numerics": {"grid": 16},
    "history": {"distance_mm": [0, 10], "steps": 5, "begin": "pressed"},
}
"""A flat wheel on a crowned rail, as close to each other as spheres of 100 mm on a plane, with a creepage of .004."""

def wheel(**tables: dict[str, Any]) -> dict[str, Any]:
    """The case of the wheel with other keys; None takes one out."""
    return {**WHEEL, **{name: {key: value for key, value in {**WHEEL.get(name, {}), **table}.items() if value is not None}
                        for name, table in tables.items()}}


def column(result: Result, name: str) -> np.ndarray[Any, Any]:
    """A column of the table of a history."""
    assert result.history is not None
    return np.array(result.history[name])

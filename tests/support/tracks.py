"""Rolling contacts whose bodies bring heat back: wheel on rail, twin disc."""

from __future__ import annotations

import math
from dataclasses import replace

from tests.support.scenes import on_grid, rolling
from thermoroll_cli.problem.problem import Geometry, Heating, Material, Motion, Problem, Recirculation

WHEEL = Recirculation(0.135, convection=30.0)
BODY = Material(210e9, 0.3, 50.0, 12e-6, 13e-6)


def wheel_on_rail(grid=32, **heating):
    """Upper body turns; 2 % longitudinal creepage, 18 kW."""
    geometry = Geometry(math.inf, 0.3, 0.46, math.inf)
    problem = Problem(BODY, BODY, geometry, 100e3, 0.3, Motion(30.0, 0.02),
                      Heating(**{"partition": "matched", "deformation": False, "upper_track": WHEEL, **heating}))
    return on_grid(problem, grid)


def twin_disc(grid=32, resistance=(1.0, 1.0), motion=None, **heating):
    tracks = [Recirculation(0.01, resistance=r) for r in resistance]
    settings = {"partition": "matched", "lower_track": tracks[0], "upper_track": tracks[1], **heating}
    problem = rolling(grid=grid, geometry=Geometry(0.035, 0.1, 0.035, 0.1), load=600.0, speed=2.0, heating=Heating(**settings))
    return replace(problem, motion=motion or Motion(2.0, 0.02))

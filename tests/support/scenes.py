"""Problems for tests: those that scripts build, too, and the cases solved by others."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.problems import (
    MECHANICAL,
    STEEL,
    Saturation,
    article_4_1,
    elastic,
    ellipse,
    on_grid,
    rolling,
    saturation,
    spheres,
    spin_ellipse,
)
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatResponse
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import (
    Heating,
    Material,
    Motion,
    Numerics,
    Problem,
    ReturningTrack,
    Strength,
    SubsurfaceRequest,
)
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

__all__ = [
    "CASES", "MECHANICAL", "REFERENCE", "STEEL", "Dimensionless", "Saturation", "accurate_to", "article_4_1", "divided_heats",
    "elastic",
    "ellipse", "on_grid", "order", "reference", "reference_problem", "rolled", "rolling", "saturation", "solved", "spheres",
    "spin_ellipse", "strong_circle", "twin_disc", "wheel_on_rail",
]  # fmt: skip

REFERENCE = Path(__file__).parents[1] / "reference"


def accurate_to(accuracy: float, problem: Problem, *asked: str) -> Problem:
    """`problem` with an accuracy, of scalars that are asked for, in place of a grid."""
    return replace(problem, numerics=Numerics(None, accuracy, accuracy_of=asked))


# --- cases solved by others --------------------------------------------------------------------------------------


@cache
def reference(name: str) -> dict:
    return json.loads((REFERENCE / f"{name}.json").read_text())


CASES = tuple(reference("rolling_fine")["cases"])


def reference_problem(case: str, grid: int | tuple[int, int]) -> Problem:
    """One of the seven rolling cases of contact_rolling.json and rolling_fine.json."""
    given = reference("rolling_fine")["cases"][case]["input"]
    return rolling(
        grid=grid, geometry=spheres(given["radius_mm"] * 1e-3),
        body=elastic(given["poisson_ratio"], given["youngs_modulus_GPa"] * 1e9), load=given["normal_N"],
        friction=given["friction_coefficient"], creepage=(given["creepage_longitudinal"], given["creepage_lateral"]),
        spin=given["spin_rad_mm"] * 1e3)


def order(sizes: np.ndarray | list[float], errors: np.ndarray | list[float]) -> float:
    """Order p of errors ~ h^p for h ~ 1/size: slope of the log-log line through the points."""
    return float(-np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])


@cache
def solved(problem: Problem) -> Result:
    """Result of a problem, solved once for all tests of a session."""
    return solve(problem)


def divided_heats(monkeypatch: pytest.MonkeyPatch) -> list[DividedHeat]:
    """All heats whose temperatures are asked for from now on, the last one last: fields do not tell how heat changes within
    elements."""
    seen: list[DividedHeat] = []
    temperatures = HeatResponse.temperatures

    def remembered(self: HeatResponse, heat: DividedHeat) -> tuple[np.ndarray, np.ndarray]:
        seen.append(heat)
        return temperatures(self, heat)

    monkeypatch.setattr(HeatResponse, "temperatures", remembered)
    return seen


@dataclass(frozen=True)
class Dimensionless:
    """Forces over μW, moment over μW sqrt(a0 b0), heat over μW V, stick fraction, applications on the finest grid."""

    force_x: float
    force_y: float
    moment: float
    heat: float
    stick: float
    power_balance_error: float
    applications: int

    @classmethod
    def of(cls, result: Result) -> Dimensionless:
        problem, s = result.problem, result.isothermal.scalars
        limit = problem.traction_limit
        mean_radius = math.sqrt(result.of_problem["hertz_a_mm"] * result.of_problem["hertz_b_mm"])
        return cls(
            s["force_x_N"] / limit, s["force_y_N"] / limit, s["spin_moment_Nmm"] / (limit * mean_radius),
            s["Q_F_W"] / (limit * problem.motion.speed), s["gamma_st"], s["power_balance_error"],
            result.work["levels"][-1]["applications"])


@cache
def rolled(case: str, grid: int) -> Dimensionless:
    """One of the seven reference cases on a grid."""
    return Dimensionless.of(solved(reference_problem(case, grid)))


# --- bodies that turn, and that are strong -----------------------------------------------------------------------------


WHEEL = ReturningTrack(0.135, convection=30.0)
BODY = Material(210e9, 0.3, 50.0, 12e-6, 13e-6)


def wheel_on_rail(grid=32, **heating):
    """Upper body turns; 2 % longitudinal creepage, 18 kW."""
    geometry = Geometry(math.inf, 0.3, 0.46, math.inf)
    problem = Problem(BODY, BODY, geometry, 100e3, Friction(0.3), Motion(30.0, 0.02),
                      Heating(**{"partition": "matched", "deformation": False, "upper_track": WHEEL, **heating}))
    return on_grid(problem, grid)


def twin_disc(grid=32, resistance=(1.0, 1.0), motion=None, **heating):
    tracks = [ReturningTrack(0.01, resistance=r) for r in resistance]
    settings = {"partition": "matched", "lower_track": tracks[0], "upper_track": tracks[1], **heating}
    problem = rolling(grid=grid, geometry=Geometry(0.035, 0.1, 0.035, 0.1), load=600.0, speed=2.0, heating=Heating(**settings))
    return replace(problem, motion=motion or Motion(2.0, 0.02))


def strong_circle(friction: float, grid: int = 64) -> Problem:
    """Two steel spheres that slide as a whole, with the strength of the lower one asked for."""
    problem = rolling(grid=grid, body=elastic(0.3), friction=friction, creepage=(0.1, 0.0), differential_slip=True)
    return replace(problem, subsurface=SubsurfaceRequest(("lower",), layers=28, lower_strength=Strength(200e6, 0.3)))

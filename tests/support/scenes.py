"""Problems for tests: those that scripts build, too, and the cases solved by others."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from scripts.problems import (
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
from thermoroll_cli.heat.heat_response import DividedHeat, HeatResponse
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import solve

__all__ = [
    "CASES", "MECHANICAL", "REFERENCE", "STEEL", "Dimensionless", "Saturation", "article_4_1", "divided_heats", "elastic",
    "ellipse", "on_grid", "order", "reference", "reference_problem", "rolled", "rolling", "saturation", "solved", "spheres",
    "spin_ellipse",
]  # fmt: skip

REFERENCE = Path(__file__).parents[1] / "reference"


# --- cases solved by others --------------------------------------------------------------------------------------


@cache
def reference(name: str) -> dict:
    return json.loads((REFERENCE / f"{name}.json").read_text())


CASES = tuple(reference("rolling_fine")["cases"])


def reference_problem(case: str, grid: int | tuple[int, int]) -> Problem:
    """One of the seven rolling cases of contact_rolling.json and rolling_fine.json."""
    given = reference("rolling_fine")["cases"][case]["input"]
    return rolling(
        grid=grid,
        geometry=spheres(given["radius_mm"] * 1e-3),
        body=elastic(given["poisson_ratio"], given["youngs_modulus_GPa"] * 1e9),
        load=given["normal_N"],
        friction=given["friction_coefficient"],
        creepage=(given["creepage_longitudinal"], given["creepage_lateral"]),
        spin=given["spin_rad_mm"] * 1e3,
    )


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
        mean_radius = math.sqrt(result.hertz["hertz_a_mm"] * result.hertz["hertz_b_mm"])
        return cls(
            s["force_x_N"] / limit,
            s["force_y_N"] / limit,
            s["spin_moment_Nmm"] / (limit * mean_radius),
            s["Q_F_W"] / (limit * problem.motion.speed),
            s["gamma_st"],
            s["power_balance_error"],
            result.work["levels"][-1]["applications"],
        )


@cache
def rolled(case: str, grid: int) -> Dimensionless:
    """One of the seven reference cases on a grid."""
    return Dimensionless.of(solved(reference_problem(case, grid)))

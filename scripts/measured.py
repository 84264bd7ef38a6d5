"""Measured creep forces of a roller rig and of a twin disc, and the models beside them: shared by figures and tests."""

from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from thermoroll_cli import Case
from thermoroll_cli.problem.friction import Friction, FrictionLaw, Interlayer
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.refinement.solve import Solver

Array = NDArray[np.float64]

ROOT = pathlib.Path(__file__).resolve().parents[1]
CREEPAGES = (5e-4, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 1e-2, 1.2e-2, 1.5e-2, 2e-2)
RIG_SMOOTH, DISC_SMOOTH = 0.48, 0.453
"""Coefficients of friction without an interlayer: of the rig the one that fits best, of the discs that of full sliding."""
RISING = 0.4621, 0.0305, 2.85e-15
"""Fitted to the roller rig: friction without slip, its rise per 1 % of slip over speed, interlayer in m/Pa."""


def measured(name: str) -> dict[str, Any]:
    """The data in tests/reference/measured/`name`.json, with their sources."""
    return dict(json.loads((ROOT / "tests" / "reference" / "measured" / f"{name}.json").read_text(encoding="utf-8")))


def model(name: str, grid: int) -> Problem:
    """The problem of cases/`name`.toml on a grid of so many elements per side, without heat."""
    problem = Case.read(ROOT / "cases" / f"{name}.toml").problem
    return replace(problem, numerics=Numerics(grid=(grid, grid)), heating=replace(
        problem.heating, heat=False, lower_track=None, upper_track=None))


def smooth(problem: Problem, coefficient: float) -> Problem:
    """The same bodies without an interlayer."""
    return replace(problem, friction=Friction(coefficient), interlayer=Interlayer())


def rising(problem: Problem) -> Problem:
    """The roller rig with friction that rises with slip, as its creep curve does, over a stiffer interlayer."""
    coefficient, rise, compliance = RISING
    law = FrictionLaw("table", table=((0.0, 1.0), (0.04 * problem.motion.speed, 1.0 + 4.0 * rise / coefficient)))
    return replace(problem, friction=Friction(coefficient, law), interlayer=Interlayer(compliance))


def forces(problem: Problem, creepages: Sequence[tuple[float, float]]) -> Array:
    """F_x/W at pairs of longitudinal and lateral creepage. Raises RuntimeError if one has no steady state."""
    solver, found = Solver(), []
    for along, across in creepages:
        result = solver.solve(replace(problem, motion=replace(problem.motion, creepage_x=along, creepage_y=across)))
        if not result.converged:
            raise RuntimeError(f"{problem.title}: {result.reason}")
        found.append(result.coupled.scalars["force_x_N"] / problem.normal_force)
    return np.array(found)


@dataclass(frozen=True)
class Comparison:
    """`points` (creepage or angle, value, half range) beside a curve `at` places; the first `compared` points count."""

    points: Array
    at: Array
    curve: Array
    compared: int

    def between(self, places: Array) -> Array:
        """The curve at other places, by cubics that keep what rises rising."""
        return np.asarray(PchipInterpolator(self.at, self.curve)(places))

    @property
    def rms(self) -> float:
        """Root of the mean square of the points less the curve."""
        place, value = self.points[: self.compared, :2].T
        return float(np.sqrt(np.mean((value - self.between(place)) ** 2)))


def roller_rig(problem: Problem) -> Comparison:
    """The creep curve up to 2 %, 40 points with their half range in time."""
    points = np.array(measured("vt_fra_roller_rig")["creep_curve"]["points"])
    at = np.array((0.0, *CREEPAGES))
    curve = np.append(0.0, forces(problem, [(c, 0.0) for c in CREEPAGES]))
    return Comparison(points * [1e-2, 1.0 / problem.normal_force, 1.0 / problem.normal_force], at, curve, len(points))


def roller_rig_angles(problem: Problem) -> Comparison:
    """F_x over that without an angle of attack, at 2 % creepage: mean of both signs of the angle in degrees, and half their
    difference."""
    sweep = np.array(measured("vt_fra_roller_rig")["angle_sweep"]["points"])
    middle = len(sweep) // 2
    both = np.stack([sweep[middle::-1, 1], sweep[middle:, 1]])
    straight = sweep[middle - 1 : middle + 2, 1].mean()  # up to 0.1°, where the force has not fallen yet
    angles = sweep[middle:, 0]
    curve = forces(problem, [(0.02, math.tan(math.radians(t))) for t in angles])
    points = np.stack([angles, both.mean(axis=0) / straight, 0.5 * np.abs(both[0] - both[1]) / straight], axis=1)
    return Comparison(points, angles, curve / curve[0], len(points))


def twin_disc(problem: Problem) -> Comparison:
    """Tractions over the load from 0.2 to 20 % slip, of which those up to 3 % are compared."""
    data = measured("twin_disc_lewis_2004")
    slip = 1e-2 * np.array(data["table_3"]["slip_percent"])
    at = np.array((2e-4, 5e-4, 1e-3, 2e-3, 3e-3, 5e-3, 7e-3, 1e-2, 1.5e-2, 2e-2, 0.0305, 0.25))
    traction = np.array(data["derived_traction_over_load"])
    points = np.stack([slip / (1.0 - 0.5 * slip), traction, np.full(len(slip), 0.01)], axis=1)
    return Comparison(points, np.append(0.0, at), np.append(0.0, forces(problem, [(c, 0.0) for c in at])), 4)

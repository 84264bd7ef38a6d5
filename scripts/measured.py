"""Three measured creep curves, and what `fit` finds for the cases that belong to them: shared by figures and tests."""

from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli import Case, fit, sweep
from thermoroll_cli.studies.sweeps.fit import Fit

Array = NDArray[np.float64]

REFERENCE = pathlib.Path(__file__).resolve().parents[1] / "tests" / "reference"
FRICTION, INTERLAYER = "load.friction_coefficient", "layer.compliance_um_GPa"
SMOOTH = {INTERLAYER: 1e-9}
"""So stiff an interlayer that the bodies touch as if there were none."""
RISING = {FRICTION: 0.462, "friction.law": "table", "friction.table": [[0.0, 0.462], [0.0333, 0.584]]}
"""Friction of the roller rig that rises by 0.031 per 1 % of slip speed over rolling speed."""


def measured(name: str) -> dict[str, Any]:
    """The data in tests/reference/`name`.json, with their sources."""
    return dict(json.loads((REFERENCE / f"{name}.json").read_text(encoding="utf-8")))


def case(name: str, grid: int) -> Case:
    """cases/`name`.toml on a grid of so many elements per side, without heat."""
    path = REFERENCE.parents[1] / "cases" / f"{name}.toml"
    return Case.read(path).with_values({"numerics.grid": grid, "thermal.heat": False})


def roller_rig() -> Array:
    """Creepage, F_x/W and its half range in time, (3, 40), up to 2 %."""
    points = np.array(measured("measured/vt_fra_roller_rig")["creep_curve"]["points"]).T
    return np.asarray(points / [[1e2], [9400.0], [9400.0]])


def roller_rig_angles() -> Array:
    """Angle of attack in degrees, F_x over that at 0°, mean of both signs of the angle, and half their difference, (3, n)."""
    angles, force = np.array(measured("measured/vt_fra_roller_rig")["angle_sweep"]["points"]).T[:2]
    middle = len(angles) // 2
    both = np.stack([force[middle::-1], force[middle:]])
    straight = force[middle - 1 : middle + 2].mean()  # up to 0.1°, where the force has not fallen yet
    return np.stack([angles[middle:], both.mean(axis=0) / straight, 0.5 * np.abs(both[0] - both[1]) / straight])


def twin_disc() -> Array:
    """Creepage, traction over W and its usual error, (3, 8): 0.2 to 20 % slip."""
    data = measured("measured/twin_disc_lewis_2004")
    slip = 1e-2 * np.array(data["table_3"]["slip_percent"])
    return np.stack([slip / (1.0 - 0.5 * slip), data["derived_traction_over_load"], np.full(len(slip), 0.01)])


def locomotive() -> Array:
    """Creepage and F_x/W, (2, 155)."""
    return np.array(measured("friction_eurosprinter_measured")["points"]).T


def fitted(case: Case, points: Array, *free: str) -> Fit:
    """The values of `free` for points of creepage and F_x/W. Raises RuntimeError if they are not found."""
    found = fit(case, {"creepage.longitudinal": points[0].tolist(), "force_x_over_load": points[1].tolist()}, free)
    if not found.converged:
        raise RuntimeError(f"{case.name}: {found.reason}")
    return found


def forces(case: Case, over: dict[str, Sequence[float]]) -> Array:
    """F_x/W over the values of a key. Raises RuntimeError if one has no steady state."""
    rows = sweep(case, over)
    if failed := next((row for row in rows if row["status"] != "converged"), None):
        raise RuntimeError(f"{case.name}: {failed['reason']}")
    return np.array([row["force_x_N"] for row in rows]) / case.problem.normal_force


def at_angles(case: Case, angles: Array) -> Array:
    """F_x at 2 % creepage over angles of attack in degrees, of which the first is 0, over that at 0°."""
    turned = case.with_values({"creepage.longitudinal": 0.02})
    found = forces(turned, {"creepage.lateral": [math.tan(math.radians(angle)) for angle in angles]})
    return found / found[0]

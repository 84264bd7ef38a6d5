"""Cost of a point: creepages of one ellipse solved together against one after the other, in turn in one process."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from thermoroll_cli.creep_table.point_solver import EllipseSolver
from thermoroll_cli.creep_table.values import Axes
from thermoroll_cli.problem.problem import Motion, Numerics
from thermoroll_cli.refinement.solve import Solver

AXES = Axes((1.0,), 8, 5, 9)
"""A coarse table: 315 points."""
ACCURACY = {16: 4e-3, 32: 1e-3}


def points(runs: int) -> list[dict[str, Any]]:
    """Milliseconds of CPU a point and their ratio, and how much forces of the finest grid differ."""
    return [_compare(side, accuracy, runs) for side, accuracy in ACCURACY.items()]


def _compare(side: int, accuracy: float, runs: int) -> dict[str, Any]:
    ellipse = EllipseSolver(AXES.aspect_ratios[0], 0.28, accuracy)
    creepages = AXES.scaled(0, AXES.points) / np.array(ellipse.scales)[:, None]
    # As a sweep goes: along the magnitude, each point starting from the one before it.
    order = np.arange(AXES.points).reshape(AXES.magnitudes - 1, -1).T[::3].ravel()
    problem = dataclasses.replace(ellipse.problem, numerics=Numerics((side, side)))
    unit, turn = ellipse.unit_creepages
    forces: list[list[float]] = []

    def one_by_one() -> None:
        solver = Solver()
        forces.clear()
        for x, y, z in creepages[:, order].T:
            motion = Motion(1.0, x * unit, y * unit, z * turn, differential_slip=False)
            fields = solver.solve(dataclasses.replace(problem, motion=motion)).isothermal.fields
            forces.append([float(fields[name].sum()) for name in ("shear_x", "shear_y")])

    pairs = [(_seconds(one_by_one) / len(order), _seconds(lambda: ellipse.solve(creepages)) / creepages.shape[1])
             for _ in range(runs)]
    found = ellipse.finest(creepages[:, order])[:2]
    miss = np.abs(np.array(forces).T * ellipse.finest_grid.element_area / problem.traction_limit - found).max()
    estimated = ellipse.solve(creepages).errors
    return {"N": side, "alone_ms": 1e3 * statistics.median(one for one, _ in pairs),
            "together_ms": 1e3 * statistics.median(many for _, many in pairs),
            "ratio": statistics.median(one / many for one, many in pairs), "largest_difference": float(miss),
            "estimated_error_rms": float(np.sqrt(np.mean(estimated**2)))}


def _seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start

"""Cost of a point: creepages of one ellipse solved together against one after the other, in one process.

    python -m scripts.benchmark.bench_points
"""

from __future__ import annotations

import dataclasses
import time

import numpy as np

from thermoroll_cli.creep_table.point_solver import EllipseSolver
from thermoroll_cli.creep_table.values import Axes
from thermoroll_cli.model.problem import Motion, Numerics
from thermoroll_cli.refinement.solve import Solver

AXES = Axes((1.0,), 8, 5, 9)
"""A coarse table: 315 points."""
ACCURACY = {16: 4e-3, 32: 1e-3}
REPEATS = 3


def main() -> None:
    print("| elements a side | one after another (ms) | together (ms) | times faster | largest difference over μW |")
    print("|---|---|---|---|---|")
    for side, accuracy in ACCURACY.items():
        print("| " + " | ".join(compare(side, accuracy)) + " |", flush=True)


def compare(side: int, accuracy: float) -> list[str]:
    """Milliseconds of CPU a point (the best of some repetitions), and how much forces of the finest grid differ."""
    ellipse = EllipseSolver(AXES.aspect_ratios[0], 0.28, accuracy)
    creepages = AXES.scaled(0, AXES.points) / np.array(ellipse.scales)[:, None]
    together = min(_seconds(lambda: ellipse.solve(creepages)) for _ in range(REPEATS)) / creepages.shape[1]
    # As a sweep goes: along the magnitude, each point starting from the one before it.
    order = np.arange(AXES.points).reshape(AXES.magnitudes - 1, -1).T[::3].ravel()
    problem = dataclasses.replace(ellipse.problem, numerics=Numerics((side, side)))
    unit, turn = ellipse.unit_creepages
    solver, forces = Solver(), []

    def one_by_one() -> None:
        for x, y, z in creepages[:, order].T:
            motion = Motion(1.0, x * unit, y * unit, z * turn, differential_slip=False)
            fields = solver.solve(dataclasses.replace(problem, motion=motion)).isothermal.fields
            forces.append([float(fields[name].sum()) for name in ("shear_x", "shear_y")])

    single = _seconds(one_by_one) / len(order)
    found = ellipse.finest(creepages[:, order])[:2]
    grid = ellipse.finest_grid
    miss = np.abs(np.array(forces).T * grid.element_area / problem.traction_limit - found).max()
    return [str(side), f"{1e3 * single:.2f}", f"{1e3 * together:.2f}", f"{single / together:.1f}", f"{miss:.0e}"]


def _seconds(work) -> float:  # type: ignore[no-untyped-def]
    start = time.process_time()
    work()
    return time.process_time() - start


if __name__ == "__main__":
    main()

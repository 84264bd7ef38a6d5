"""Run time against error of the kinds of problems beside a single contact: lines, histories, surfaces, wheelsets, tracks and
bearings, each as `thermoroll run` solves it, beside its own finer grid."""

from __future__ import annotations

import statistics
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from scripts.benchmark.cases import ROOT, log, seconds
from thermoroll_cli import Case
from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.problem.kinds import Task
from thermoroll_cli.problem.names import known_as
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.arrays import Array

POWER, PRESSURE = "Q_F_W", "pressure_max_MPa"


class Measured(NamedTuple):
    """A case with other `values`, on the `grids`; `fine` is the grid of the reference. A history has `steps` on the first grid,
    and as many more on others as there are more elements along rolling."""

    name: str
    file: str
    grids: tuple[int, ...]
    fine: int
    values: dict[str, Any]
    steps: int = 0

    def task(self, grid: int) -> Task:
        """What is solved, without stresses below the surface."""
        steps = {"history.steps": self.steps * grid // self.grids[0]} if self.steps else {}
        case = Case.read(ROOT / "cases" / f"{self.file}.toml")
        task = case.with_values({**self.values, "numerics.grid": grid, **steps}).task
        if isinstance(task, History):
            return replace(task, problem=replace(task.problem, subsurface=None))
        return task


MEASURED = (
    Measured("line contact, a pair of teeth", "gear_pair", (32, 64, 128), 512, {}),
    Measured("line contact over time, load and creepage that rise and fall", "gear_pair", (32, 64), 128, {"history": {
        "length_mm": 10.0, "distance_mm": [0.0, 0.8, 1.6], "values": {
            "load.normal_N_mm": [200.0, 400.0, 200.0], "creepage.longitudinal": [0.0, 0.01, 0.0]}}}, 48),
    Measured("contact over time with heat", "rolling_start", (16, 32), 64, {}, 36),
    Measured("a ball over a dent", "dent", (16, 32), 64, {}, 12),
    Measured("wheelset", "manchester", (16, 32, 64), 128, {}),
    Measured("wheelset over time, which turns by 1 mrad", "manchester", (12, 24), 48, {"history": {
        "distance_mm": [0.0, 40.0], "values": {"wheelset.yaw_mrad": [8.6, 9.6]}}}, 8),
    Measured("crossing, wing and nose", "crossing", (16, 32), 96, {}),
    Measured("wheel with a flat", "wheel_flat", (16, 32), 96, {}),
    Measured("bearing, 32 contacts", "angular_contact", (12, 24), 72, {}),
)


def measure(runs: int) -> list[dict[str, Any]]:
    """A row per case and grid: processor seconds, and of power and largest pressure the largest error of all rows over the
    largest value, with its estimate."""
    out = []
    for case in MEASURED:
        fine = solve(case.task(case.fine))
        for grid in case.grids:
            results: list[Result] = []
            times = [seconds(lambda: results.append(solve(case.task(grid)))) for _ in range(runs)]  # noqa: B023
            row = {"name": case.name, "N": grid, "seconds": statistics.median(times), "fine": case.fine}
            for name in (POWER, PRESSURE):
                values, errors = _rows(results[-1], name)
                best = _rows(fine, name)[0][:: case.fine // grid if len(values) > 1 else 1]
                row[name] = [_largest(each) / _largest(best) for each in (values - best, errors)]
            out.append(row)
            log(f"  {row}")
    return out


def _rows(result: Result, name: str) -> tuple[Array, Array]:
    """Values of a scalar and their estimated errors (0 where it is exact), of all rows of a history or of the one state."""
    name = known_as(name, result.numbers)
    if result.history is not None:
        values = np.array(result.history[name], float)
        return values, np.array(result.history.get(f"uncertainty.{name}", np.zeros(len(values))), float)
    return np.array([result[name]]), np.array([result.uncertainty[name]])


def _largest(values: Array) -> float:
    return float(np.nanmax(np.abs(values)))

"""Building a table: its points in tasks of some seconds, then as many at random to measure how good it is."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any, Self

import numpy as np

from thermoroll_cli.studies.creep_table.creep_force_table import Interpolant
from thermoroll_cli.studies.creep_table.point_solver import FORCES, QUANTITIES, STANDARD_ACCURACY, EllipseSolver
from thermoroll_cli.studies.creep_table.scaling import LAW
from thermoroll_cli.studies.creep_table.table_file import Quality, TableAxes, TableValues
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.journal import Journal, Record
from thermoroll_cli.tools.runner import Item, Workers, run

TASK_POINTS = 640
"""Points of one ellipse in a task, some seconds of work: what a process does between two entries of the journal."""
SEED = 20


@dataclass(frozen=True)
class TablePlan:
    """The table to be built, and the number of random points (`checks`) at which it is compared with the solver."""

    axes: TableAxes = field(default_factory=TableAxes)
    poisson_ratio: float = 0.28
    accuracy: float = STANDARD_ACCURACY
    checks: int = 1000

    @property
    def identity(self) -> dict[str, Any]:
        return {"kind": "table", **asdict(self), "law": LAW}

    @property
    def points(self) -> int:
        return len(self.axes.aspect_ratios) * self.axes.points + self.checks

    def grid_tasks(self) -> Iterator[TableTask]:
        """The points of the table, ellipse by ellipse."""
        count = self.axes.points
        for ratio in self.axes.aspect_ratios:
            for first in range(0, count, TASK_POINTS):
                scaled = self.axes.scaled(first, min(first + TASK_POINTS, count))
                yield TableTask(f"a/b {ratio!r}, from {first}", ratio, self.poisson_ratio, self.accuracy, scaled)

    def check_tasks(self) -> Iterator[TableTask]:
        """Random creepages, uniform in m/(1 + m) and over the directions, of random ellipses between the first and the last, 25
        of each (those of a table of one ellipse are all its own): the same ones for the same plan."""
        ratios = self.axes.aspect_ratios
        each = 25 if len(ratios) > 1 else TASK_POINTS
        ellipses = np.random.default_rng(SEED)
        for first in range(0, self.checks, each):
            ratio = float(np.exp(ellipses.uniform(np.log(ratios[0]), np.log(ratios[-1])))) if len(ratios) > 1 else ratios[0]
            random = np.random.default_rng((SEED, first))
            t, alpha, height = random.uniform(0.0, 1.0, (3, min(each, self.checks - first)))
            alpha, height, m = 0.5 * np.pi * alpha, 2.0 * height - 1.0, t / (1.0 - t)
            flat = m * np.sqrt(1.0 - height**2)
            scaled = np.stack([flat * np.cos(alpha), flat * np.sin(alpha), m * height])
            # More accurately (48 elements a side for 32), so that their difference from the table has the errors of both its
            # solver and its interpolation in it.
            yield TableTask(f"check from {first}", ratio, self.poisson_ratio, self.accuracy / 2.25, scaled)


@dataclass(frozen=True)
class TableTask:
    """Points of one ellipse, (X, Y, Z) of each in `scaled` (3, n). They have one record: values and errors (5, n)."""

    key: str
    ratio: float
    poisson_ratio: float
    accuracy: float
    scaled: Array

    @property
    def count(self) -> int:
        return self.scaled.shape[1]

    def items(self) -> Iterator[Item]:
        solver = _solver(self.ratio, self.poisson_ratio, self.accuracy)
        values, errors = solver.solve(self.scaled / np.array(solver.scales)[:, None])
        yield self._record(np.concatenate([values, errors[None]])), {}

    def _record(self, values: Array, *, solved: bool = True) -> Record:
        return {"key": self.key, "solved": solved, "values": np.round(values, 9).tolist()}

    def without(self, done: Callable[[str], bool]) -> Self | None:
        return None if done(self.key) else self

    def parts(self) -> list[Self]:
        return [self]

    def given_up(self, reason: str) -> Record:
        return self._record(np.full((len(QUANTITIES) + 1, self.count), np.nan), solved=False)


@lru_cache(maxsize=1)
def _solver(ratio: float, poisson_ratio: float, accuracy: float) -> EllipseSolver:
    return EllipseSolver(ratio, poisson_ratio, accuracy)


def build_table(
    plan: TablePlan, path: pathlib.Path, *, workers: Workers, resume: bool = False, force: bool = False,
    report: Callable[[int, bool], None] = lambda count, solved: None,
    note: Callable[[str], None] = lambda text: None,
) -> TableValues:
    """Solve all points of `plan` and measure the error of interpolation between them.

    Solved points are kept in a journal beside `path` which the caller removes, so that `resume` goes on where a killed program
    stopped; `force` begins anew where the journal is of another table. `report` is called with numbers of points as they are
    done, and whether they were solved now rather than found; `note` with remarks. Raises OSError (journal, cluster).
    """
    grid, checks = list(plan.grid_tasks()), list(plan.check_tasks())
    counts = {task.key: task.count for task in (*grid, *checks)}
    with Journal(journal_path(path), plan.identity, resume=resume, fields=("solved", "values"),
                 lost=None if force else lambda tasks: "") as journal:
        pending = [task for task in (*grid, *checks) if task.key not in journal or not journal[task.key]["solved"]]
        finished = plan.points - sum(task.count for task in pending)
        if finished:
            note(f"{finished} of {plan.points} points are solved already")
            report(finished, False)
        for key in run(pending, journal, workers, note):
            report(counts[key], True)
        found = [np.array(journal[task.key]["values"]) for task in grid]
        direct = [np.array(journal[task.key]["values"]) for task in checks]
    axes, count = plan.axes, len(plan.axes.aspect_ratios)
    flat = np.concatenate(found, axis=1).reshape(5, count, axes.magnitudes - 1, axes.directions, axes.spins)
    values, errors = np.zeros((count, len(QUANTITIES), *axes.shape)), np.zeros((count, *axes.shape))
    values[:, -1, 0] = 1.0  # without creepage everything sticks
    values[:, :, 1:] = np.moveaxis(flat[:4], 0, 1)
    errors[:, 1:] = flat[4]
    table = TableValues(axes, plan.poisson_ratio, plan.accuracy, values, errors)
    known = flat[4][~np.isnan(flat[4])]
    quality = Quality(float(np.sqrt(np.mean(known**2))), float(known.max()))
    if checks:
        # The table against the solver at the random points.
        interpolant = Interpolant(table)
        missed = np.concatenate([
            np.hypot(*(interpolant(np.array([task.ratio]), task.scaled) - exact[:4])[FORCES][:2])
            for task, exact in zip(checks, direct, strict=True)])
        missed = missed[~np.isnan(missed)]
        quality = replace(quality, points=len(missed), rms=float(np.sqrt(np.mean(missed**2))), largest=float(missed.max()))
    return replace(table, quality=quality)


def journal_path(path: pathlib.Path) -> pathlib.Path:
    return path.with_name(path.name + ".jsonl")

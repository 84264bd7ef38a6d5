"""Building a table: its points in tasks of some seconds, then as many at random to see how good it is."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.interpolation import Interpolant
from thermoroll_cli.creep_table.journal import Journal
from thermoroll_cli.creep_table.point_solver import FORCES, QUANTITIES
from thermoroll_cli.creep_table.table_plan import CheckTask, TablePlan, Task
from thermoroll_cli.creep_table.values import Quality, TableValues
from thermoroll_cli.creep_table.workers import solved_tasks


@dataclass
class BuildProgress:
    """How many of the `total` points have `rows`, how many of these were `found`, and how many have no solution: `holes`."""

    total: int
    rows: int = 0
    found: int = 0
    holes: int = 0


def build_table(
    plan: TablePlan, path: pathlib.Path, *, jobs: int = 1, dask: str = "", resume: bool = False,
    report: Callable[[BuildProgress], None] = lambda progress: None,
    note: Callable[[str], None] = lambda text: None,
) -> TableValues:
    """Solve all points of `plan` and measure what interpolation between them is worth.

    What is solved is kept in a journal beside `path` until `finish` is called, so that `resume` goes on where a killed program
    stopped. `report` is called with the progress, `note` with remarks. Raises OSError (journal, cluster).
    """
    grid, checks = plan.grid_tasks(), plan.check_tasks()
    tasks: list[Task] = [*grid, *checks]
    journal = Journal(journal_path(path), plan.identity, resume=resume)
    progress = BuildProgress(len(plan.axes.aspect_ratios) * plan.axes.points + plan.checks)
    for values in journal.found.values():
        progress.rows += values.shape[1]
        progress.holes += int(np.isnan(values[0]).sum())
    progress.found = progress.rows
    if progress.found:
        note(f"{progress.found} of {progress.total} points are solved already")
    report(progress)
    pending = {number: task for number, task in enumerate(tasks) if number not in journal.found}
    for number, values in solved_tasks(plan, pending, jobs, dask, note):
        journal.add(number, values)
        progress.rows += values.shape[1]
        progress.holes += int(np.isnan(values[0]).sum())
        report(progress)
    table = _assembled(plan, [journal.found[number] for number in range(len(grid))])
    return replace(table, quality=_quality(table, checks, [journal.found[len(grid) + i] for i in range(len(checks))]))


def journal_path(path: pathlib.Path) -> pathlib.Path:
    return path.with_name(path.name + ".building")


def finish(path: pathlib.Path) -> None:
    """Remove the journal: the table is written."""
    journal_path(path).unlink(missing_ok=True)


def _assembled(plan: TablePlan, parts: Sequence[Array]) -> TableValues:
    axes = plan.axes
    count = len(axes.aspect_ratios)
    flat = np.concatenate(parts, axis=1).reshape(5, count, axes.magnitudes - 1, axes.directions, axes.spins)
    values = np.zeros((count, len(QUANTITIES), *axes.shape))
    values[:, -1, 0] = 1.0  # without creepage everything sticks
    values[:, :, 1:] = np.moveaxis(flat[:4], 0, 1)
    errors = np.zeros((count, *axes.shape))
    errors[:, 1:] = flat[4]
    return TableValues(axes, plan.poisson_ratio, plan.accuracy, values, errors)


def _quality(table: TableValues, tasks: Sequence[CheckTask], parts: Sequence[Array]) -> Quality:
    """Errors of the solver over the whole table, and of the table against the solver at the random points."""
    errors = table.errors[:, 1:][~np.isnan(table.errors[:, 1:])]
    quality = Quality(float(np.sqrt(np.mean(errors**2))), float(errors.max()))
    if not tasks:
        return quality
    interpolant = Interpolant(table)
    misses = []
    for task, direct in zip(tasks, parts, strict=True):
        found = interpolant(np.array([task.ratio]), task.scaled(table.axes))
        misses.append(np.hypot(*(found - direct[:4])[FORCES][:2]))
    missed = np.concatenate(misses)
    missed = missed[~np.isnan(missed)]
    return replace(quality, points=len(missed), rms=float(np.sqrt(np.mean(missed**2))), largest=float(missed.max()))

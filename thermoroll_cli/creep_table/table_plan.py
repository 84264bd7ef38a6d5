"""What a table consists of, as tasks of some seconds that can be solved anywhere."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.point_solver import BATCH, STANDARD_ACCURACY
from thermoroll_cli.creep_table.scaling import LAW
from thermoroll_cli.creep_table.values import DEFAULT_POISSON, Axes

TASK_POINTS = 4 * BATCH
CHECK_POINTS = 25
"""Random points of one random ellipse; those of a table of one ellipse are all its own."""
SEED = 20


@dataclass(frozen=True)
class TablePlan:
    """What is to be built, and at how many random points (`checks`) it is compared with the solver."""

    axes: Axes = field(default_factory=Axes)
    poisson_ratio: float = DEFAULT_POISSON
    accuracy: float = STANDARD_ACCURACY
    checks: int = 1000

    @property
    def identity(self) -> dict[str, Any]:
        return {**asdict(self), "law": LAW}

    def grid_tasks(self) -> list[GridTask]:
        ranges = [(first, min(first + TASK_POINTS, self.axes.points)) for first in range(0, self.axes.points, TASK_POINTS)]
        return [GridTask(ratio, first, last) for ratio in self.axes.aspect_ratios for first, last in ranges]

    def check_tasks(self) -> list[CheckTask]:
        """Random creepages of random ellipses between the first and the last: the same ones for the same plan."""
        ratios = self.axes.aspect_ratios
        each = CHECK_POINTS if len(ratios) > 1 else TASK_POINTS
        random = np.random.default_rng(SEED)
        tasks = []
        for first in range(0, self.checks, each):
            ratio = float(np.exp(random.uniform(np.log(ratios[0]), np.log(ratios[-1]))))
            tasks.append(CheckTask(ratio if len(ratios) > 1 else ratios[0], first, min(each, self.checks - first)))
        return tasks


@dataclass(frozen=True)
class GridTask:
    """Points first … last − 1 of one ellipse of the table."""

    ratio: float
    first: int
    last: int
    finer: ClassVar[float] = 1.0

    def scaled(self, axes: Axes) -> Array:
        return axes.scaled(self.first, self.last)


@dataclass(frozen=True)
class CheckTask:
    """`count` random points, uniform in m/(1 + m) and over the directions.

    They are solved `finer` times more accurately (48 elements a side for 32), so that what the table misses them by has the
    errors of both its solver and its interpolation in it."""

    ratio: float
    seed: int
    count: int
    finer: ClassVar[float] = 2.25

    def scaled(self, axes: Axes) -> Array:
        random = np.random.default_rng((SEED, self.seed))
        t, alpha, height = random.uniform(0.0, 1.0, (3, self.count))
        alpha, height, m = 0.5 * np.pi * alpha, 2.0 * height - 1.0, t / (1.0 - t)
        flat = m * np.sqrt(1.0 - height**2)
        return np.stack([flat * np.cos(alpha), flat * np.sin(alpha), m * height])


Task = GridTask | CheckTask

"""Points solved for their scalars alone: what a worker does, and tasks of some seconds for several of them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from thermoroll_cli.files.result.scalar_file import TEXTS, ScalarRow
from thermoroll_cli.problem.names import HERTZ_SCALARS, SCALARS, scalars_below
from thermoroll_cli.problem.result import Result
from thermoroll_cli.sweeps.points import PointMaker, Stretch
from thermoroll_cli.sweeps.stretch import solved

TASK_SECONDS = 2.0
"""What a task should take: long against the way to another process and back, short against what is lost when it dies."""
LARGEST_TASK = 200


@dataclass(frozen=True)
class Part:
    """A stretch of points by their `numbers`; rows of `finished` ones exist, and are computed again only to start from.
    `alone` has points solved without neighbours, since one of the stretch kills the process that solves it."""

    numbers: range
    finished: frozenset[int] = frozenset()
    alone: bool = False

    @property
    def pending(self) -> list[int]:
        return [number for number in self.numbers if number not in self.finished]


@dataclass(frozen=True)
class Solved:
    """What a task gave, and the seconds it took."""

    rows: tuple[ScalarRow, ...]
    seconds: float


def solve_rows(maker: PointMaker, part: Part, threads: int = 1) -> Iterator[ScalarRow]:
    """The rows of the pending points of one stretch."""
    numbers = part.pending if part.alone else part.numbers
    stretch = Stretch(tuple(maker.point(number) for number in numbers), part.finished)
    for point, result, reason in solved(stretch, threads):
        yield failed_row(point.number, reason) if result is None else row_of(point.number, result)


def solve_task(maker: PointMaker, parts: Sequence[Part]) -> Solved:
    """All rows of several stretches, for a process of its own."""
    began = time.perf_counter()
    rows = tuple(row for part in parts for row in solve_rows(maker, part))
    return Solved(rows, time.perf_counter() - began)


def row_of(number: int, result: Result) -> ScalarRow:
    coupled, isothermal, work = result.coupled.scalars, result.isothermal.scalars, result.work
    numbers = [*(coupled.get(k, math.nan) for k in SCALARS), *(result.hertz.get(k, math.nan) for k in HERTZ_SCALARS),
               *(isothermal.get(k, math.nan) for k in SCALARS), *(result.error.get(k, math.nan) for k in SCALARS),
               float(work.get("applications", math.nan))]
    inside, errors = ({}, {}) if result.subsurface is None else (result.subsurface.scalars, result.subsurface.error)
    numbers += [values.get(k, math.nan) for values in (inside, errors) for k in scalars_below(result.problem.subsurface)]
    grid = "x".join(str(side) for side in work.get("grid", ()))
    return ScalarRow(number, tuple(float(n) for n in numbers), (result.status, result.reason, " ".join(result.unbounded), grid))


def failed_row(number: int, reason: str) -> ScalarRow:
    """The row of a point that has no result."""
    return ScalarRow(number, (), ("not_converged", reason, *[""] * (len(TEXTS) - 2)))


class TaskSize:
    """How many stretches make a task of `TASK_SECONDS`, learnt from the tasks that are done."""

    def __init__(self) -> None:
        self.stretches = 1

    def learn(self, stretches: int, seconds: float) -> None:
        # At most four times more: the next ones may be slower.
        wanted = TASK_SECONDS * stretches / max(seconds, 1e-6)
        self.stretches = max(1, min(int(wanted), 4 * self.stretches, LARGEST_TASK))

"""How long a single run will go on, from the stages that are done."""

from __future__ import annotations

import math
from collections.abc import Sequence

Step = tuple[str, tuple[int, int]]
"""A stage on a grid, as `Plan.steps` lists them."""


OVERHEAD = 3e5
"""Of an iteration, in operations of transforms: as much as those of 64 × 64 elements."""


class TimeLeft:
    """Expects each stage to take on the next grid what it took on this one, times the ratio of the transforms' cost.

    A stage that has not been done yet is expected to take as long as all before it on that grid: a guess that holds for one
    grid only. Times are those of `time.monotonic`.
    """

    def __init__(self, steps: Sequence[Step], start: float) -> None:
        self._steps = list(steps)
        self._last = start
        self._known: dict[str, tuple[float, float]] = {}
        self._left = math.nan

    def done(self, stage: str, grid: tuple[int, int], now: float) -> None:
        """Take note that `stage` on `grid` has been finished `now`."""
        took, self._last = now - self._last, now
        self._known[stage] = (took, relative_cost(grid))
        if (stage, grid) not in self._steps:
            self._left = math.nan
            return
        coming = self._steps[self._steps.index((stage, grid)) + 1 :]
        self._left = sum(self._expected(*step) for step in coming)

    def seconds(self, now: float) -> float:
        """Seconds left at the time `now`; nan where nothing can be said."""
        return max(self._left - (now - self._last), 0.0) if math.isfinite(self._left) else math.nan

    def _expected(self, stage: str, grid: tuple[int, int]) -> float:
        if stage in self._known:
            took, cost = self._known[stage]
            return took * relative_cost(grid) / cost
        return sum(took * relative_cost(grid) / cost for took, cost in self._known.values())


def relative_cost(grid: tuple[int, int]) -> float:
    """What an iteration on `grid` takes, in operations of its transforms, with what does not grow with them."""
    padded = 4 * grid[0] * grid[1]
    return OVERHEAD + padded * math.log2(padded)

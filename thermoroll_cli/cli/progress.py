"""Progress of the work: a bar that redraws itself on a terminal, the same words as plain lines elsewhere."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from thermoroll_cli.cli import streams

SECONDS_BETWEEN_LINES = 10.0
MOST_LINES = 200
"""Points that get a line each where there is no terminal; of more there is a line every few seconds."""
WORTH_SHOWING_SECONDS = 2.0
NARROW = 100
"""A terminal with fewer columns shows words without a bar."""
OVERHEAD = 3e5
"""Work of an iteration that does not grow with the grid, in operations: as much as the transforms of 64 × 64 elements."""

Step = tuple[str, tuple[int, int]]
"""A stage on a grid, as `Plan.steps` lists them."""


class Bar:
    """A line on a terminal with words, a bar and the time left, drawn by rich. It is gone when closed."""

    def __init__(self, words: str, total: float, before_time: str = "") -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
        from rich.table import Column
        from rich.text import Text

        class TimeLeft(ProgressColumn):
            def render(self, task: Task) -> Text:
                seconds = task.time_remaining
                known = seconds is not None and seconds >= WORTH_SHOWING_SECONDS and task.completed > 0
                return Text(f"{before_time}{duration(seconds)} left" if known and seconds is not None else "")

        console = Console(file=sys.stderr, highlight=False)
        words_column = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=False, overflow="fold"))
        bar = (BarColumn(bar_width=24),) if console.width >= NARROW else ()
        self._progress = Progress(words_column, *bar, TimeLeft(), console=console, transient=True, speed_estimate_period=600.0)
        self._task = self._progress.add_task(words, total=total)
        self._progress.start()

    def show(self, words: str, done: float, total: float) -> None:
        with contextlib.suppress(OSError):
            self._progress.update(self._task, description=words, completed=done, total=total)

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._progress.stop()


class Progress:
    """Shows the reports of one solve on standard error. Use as `solve(..., report=progress)`, then `close` it.

    On a terminal one line shows the latest report and the time left; `steps` are the reports to be expected (asked for only
    there), `at_most` says that there may be fewer. Elsewhere there is a line whenever stage or grid change, and with `verbose`
    one for every report. `quiet` shows nothing.
    """

    def __init__(self, title: str, *, quiet: bool = False, verbose: bool = False, steps: Callable[[], Sequence[Step]] = tuple,
                 at_most: bool = False) -> None:  # fmt: skip
        self._title, self._quiet, self._verbose = title, quiet, verbose
        self._last: tuple[Any, ...] = ()
        self._bar = None
        if streams.is_terminal(sys.stderr) and not verbose and not quiet:
            self._expected = {(stage, tuple(grid)): work(grid) for stage, grid in steps()}
            self._total, self._done = sum(self._expected.values()), 0.0
            self._bar = Bar(title, self._total, f"{'at most ' if at_most else ''}about ")

    def __call__(self, stage: str, info: Mapping[str, Any]) -> None:
        step = stage, tuple(info.get("grid", ()))
        if self._bar is not None:
            self._done += self._expected.pop(step, 0.0)
            self._bar.show(describe(self._title, stage, info), self._done, self._total)
        elif not self._quiet and (self._verbose or step != self._last):
            self._last = step
            streams.note(describe(self._title, stage, info))

    def close(self) -> None:
        """Clear the line."""
        if self._bar is not None:
            self._bar.close()


class PointsProgress:
    """Shows on standard error how many of `total` points are done: a bar on a terminal; elsewhere a line per point, or every
    few seconds where there are many. `quiet` shows nothing, `verbose` lines on a terminal, too."""

    def __init__(self, total: int, *, quiet: bool, verbose: bool = False, lines: bool = True) -> None:
        self._total, self._done, self._found = total, 0, 0
        self._quiet = quiet
        self._every_point = lines and total <= MOST_LINES
        self._start = self._last = time.monotonic()
        live = streams.is_terminal(sys.stderr) and not verbose and not quiet
        self._bar = Bar(f"0/{total} points", total) if live else None

    def step(self, words: str, count: int = 1, *, solved: bool = True) -> None:
        """`count` more points are done, `solved` now or found finished; `words` describe one of them."""
        self._done += count
        self._found += 0 if solved else count
        counted = f"{self._done}/{self._total}"
        if self._bar is not None:
            self._bar.show(f"{counted} points", self._done - self._found, self._total - self._found)
        elif self._quiet or not solved:
            return
        elif self._every_point:
            streams.note(f"{counted} {words}{self._left('; ')}")
        elif time.monotonic() - self._last >= SECONDS_BETWEEN_LINES:
            self._last = time.monotonic()
            streams.note(f"{counted} points{self._left(', ')}")

    def note(self, text: str) -> None:
        """Show a remark beside the bar."""
        if not self._quiet:
            streams.note(f"thermoroll: {text}")

    def close(self) -> None:
        """Clear the bar."""
        if self._bar is not None:
            self._bar.close()

    def _left(self, before: str) -> str:
        solved = self._done - self._found
        if solved == 0 or self._done == self._total:
            return ""
        return f"{before}{duration((time.monotonic() - self._start) / solved * (self._total - self._done))} left"


def duration(seconds: float) -> str:
    """`45 s`, `3 min 20 s`, `2 h 5 min`."""
    whole = max(1, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def work(grid: Sequence[int]) -> float:
    """Cost of an iteration on `grid`, in operations of its transforms."""
    padded = 4 * grid[0] * grid[1]
    return OVERHEAD + padded * math.log2(padded)


def describe(title: str, stage: str, info: Mapping[str, Any]) -> str:
    """One report as text: `case: coupling, grid 64×64, iteration 3, residual 1.0e-04`."""
    parts = [stage]
    for name, value in info.items():
        if isinstance(value, list | tuple):
            parts.append(f"{name} {'×'.join(str(item) for item in value)}")
        elif isinstance(value, float):
            parts.append(f"{name} {value:.1e}")
        else:
            parts.append(f"{name} {value}")
    return f"{title}: {', '.join(parts)}"

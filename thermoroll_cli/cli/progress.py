"""Progress of the work: a bar that redraws itself on a terminal, the same words as plain lines elsewhere."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

from thermoroll_cli.cli import streams
from thermoroll_cli.files.case_errors import printable

Step = tuple[str, tuple[int, ...]]
"""A stage on a grid, as `Plan.steps` lists them."""


class Bar:
    """A line on standard error with words, a bar and the time left, drawn by rich; it is gone at the end of its `with` block.
    There is none where standard error is no terminal, nor with `quiet` or `verbose`: `live` says so."""

    def __init__(self, words: str, total: float, *, quiet: bool, verbose: bool) -> None:
        self._start = time.monotonic()
        self.live = streams.is_terminal(sys.stderr) and not (quiet or verbose)
        if not self.live:
            return
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn
        from rich.table import Column

        console = Console(file=sys.stderr, highlight=False)
        words_column = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, overflow="ellipsis"))
        bar = (BarColumn(bar_width=16),) if console.width >= 60 else ()
        self._progress = Progress(words_column, *bar, TextColumn("{task.fields[left]}"), console=console, transient=True)
        self._task = self._progress.add_task(printable(words), total=total, left="")
        self._progress.start()

    def show(self, words: str, done: float, total: float, bound: str = "") -> None:
        """Redraw the line; `bound` stands before the time left."""
        left = self.seconds_left(done, total)
        with contextlib.suppress(OSError):
            self._progress.update(self._task, description=printable(words), completed=done, total=total,
                                  left=f"{bound}{duration(left)} left" if left >= 2.0 else "")

    def seconds_left(self, done: float, total: float) -> float:
        """Seconds until `total`, if the work goes on as it has; 0 where nothing is `done` yet."""
        return (time.monotonic() - self._start) / done * (total - done) if done else 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *cause: object) -> None:
        if self.live:
            with contextlib.suppress(OSError):
                self._progress.stop()


class Progress(Bar):
    """Shows the reports of one solve on standard error. Use as `with progress: solve(..., report=progress)`.

    On a terminal one line shows the latest report and the time left; `expected` gives the reports to be expected, and whether
    there may be fewer (asked for only there). Elsewhere there is a line whenever stage or grid change, and with `verbose`
    one for every report. `quiet` shows nothing.
    """

    def __init__(self, title: str, *, quiet: bool = False, verbose: bool = False,
                 expected: Callable[[], tuple[Sequence[Step], bool]] = lambda: ((), False)) -> None:  # fmt: skip
        super().__init__(title, 0.0, quiet=quiet, verbose=verbose)
        self._title, self._quiet, self._verbose = title, quiet, verbose
        steps, fewer = expected() if self.live else ((), False)
        self._bound = "at most about " if fewer else "about "
        self._last: tuple[Any, ...] = ()
        self._expected = Counter(steps)
        self._total, self._done = sum(_operations(step) * count for step, count in self._expected.items()), 0.0

    def __call__(self, stage: str, info: Mapping[str, Any]) -> None:
        step = stage, tuple(info.get("grid", ()))
        if self.live:
            if self._expected[step]:
                self._expected[step] -= 1
                self._done += _operations(step)
            self.show(describe(self._title, stage, info), self._done, self._total, self._bound)
        elif not self._quiet and (self._verbose or step != self._last):
            self._last = step
            streams.note(describe(self._title, stage, info))


def _operations(step: Step) -> float:
    """Operations of an iteration: its transforms, and 3e5 that do not grow with the grid."""
    elements = 4 * math.prod(step[1])
    return 3e5 + elements * math.log2(elements)


class PointsProgress(Bar):
    """Shows on standard error how many of `total` points are done: a bar on a terminal; elsewhere a line per point, or every
    10 s where there are more than 200. `quiet` shows nothing, `verbose` lines on a terminal, too."""

    def __init__(self, total: int, *, quiet: bool, verbose: bool = False, lines: bool = True) -> None:
        super().__init__(f"0/{total} points", total, quiet=quiet, verbose=verbose)
        self._total, self._done, self._solved = total, 0, 0
        self._quiet = quiet
        self._every_point = lines and total <= 200
        self._last = time.monotonic()

    def step(self, words: str, count: int = 1, *, solved: bool = True) -> None:
        """`count` more points are done, `solved` now or found finished; `words` describe one of them."""
        self._done += count
        self._solved += count if solved else 0
        counted, to_solve = f"{self._done}/{self._total}", self._total - self._done + self._solved
        if self.live:
            self.show(f"{counted} points", self._solved, to_solve)
        elif solved and not self._quiet:
            left = self.seconds_left(self._solved, to_solve)
            time_left = f"{duration(left)} left" if left else ""
            if self._every_point:
                streams.note("; ".join(filter(None, (f"{counted} {words}", time_left))))
            elif time.monotonic() - self._last >= 10.0:
                self._last = time.monotonic()
                streams.note(", ".join(filter(None, (f"{counted} points", time_left))))

    def note(self, text: str) -> None:
        """Show a remark beside the bar."""
        if not self._quiet:
            streams.note(f"thermoroll: {text}")


def duration(seconds: float) -> str:
    """`45 s`, `3 min 20 s`, `2 h 5 min`."""
    whole = max(1, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def describe(title: str, stage: str, info: Mapping[str, Any]) -> str:
    """One report as text: `case: coupling, grid 64×64, iteration 3, residual 1.0e-04`."""
    parts = [stage]
    for name, value in info.items():
        if isinstance(value, list | tuple):
            value = "×".join(map(str, value))
        parts.append(f"{name} {value:.1e}" if isinstance(value, float) else f"{name} {value}")
    return f"{title}: {', '.join(parts)}"

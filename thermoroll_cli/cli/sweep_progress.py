"""How far a sweep is: a bar with the time left on a terminal, a line per point elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

from thermoroll_cli.cli import streams
from thermoroll_cli.cli.progress import Progress, duration

_BAR_WIDTH = 24


class SweepProgress:
    """Shows on standard error how many of `total` points are done. `quiet` shows nothing, `verbose` lines on a terminal,
    too."""

    def __init__(self, total: int, *, quiet: bool = False, verbose: bool = False) -> None:
        self._total = total
        self._done = self._found = 0
        self._quiet, self._verbose = quiet, verbose
        self._live = streams.is_terminal(sys.stderr) and not verbose and not quiet
        self._start = time.monotonic()
        if self._live:
            self._redraw()

    def step(self, name: str, values: Mapping[str, Any], outcome: str, *, solved: bool) -> None:
        """One more point is done: `solved` now, or found finished."""
        self._done += 1
        self._found += not solved
        if self._live:
            self._redraw()
        elif not self._quiet and (solved or self._verbose):
            where = ", ".join(f"{key} = {value:.6g}" for key, value in values.items())
            done = "" if solved else " (finished before)"
            left = self._time_left()
            streams.note(f"{self._done}/{self._total} {name}: {where}: {outcome}{done}" + (f"; {left} left" if left else ""))

    def note(self, text: str) -> None:
        """Tell something without disturbing the bar."""
        if self._quiet:
            return
        if self._live:
            Progress._draw("")
        streams.note(f"thermoroll: {text}")
        if self._live:
            self._redraw()

    def close(self) -> None:
        """Clear the bar."""
        if self._live:
            Progress._draw("")

    def _redraw(self) -> None:
        full = _BAR_WIDTH * self._done // self._total
        left = self._time_left()
        bar = "#" * full + "." * (_BAR_WIDTH - full)
        Progress._draw(f"[{bar}] {self._done}/{self._total} points" + (f", {left} left" if left else ""))

    def _time_left(self) -> str:
        solved = self._done - self._found
        if solved == 0 or self._done == self._total:
            return ""
        return duration((time.monotonic() - self._start) / solved * (self._total - self._done))

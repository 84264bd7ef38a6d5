"""What the solver is doing: a line that redraws itself on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from thermoroll_cli.cli import streams
from thermoroll_cli.cli.time_left import Step, TimeLeft

_REDRAW_SECONDS = 0.1
_COUNT_SECONDS = 1.0
_WORTH_TELLING_SECONDS = 2.0


class Progress:
    """Shows the reports of one solve on standard error. Use as `solve(..., report=progress)`, then `close` it.

    On a terminal one line shows the latest report and, once a run takes seconds, how long it will go on, counted down while
    nothing is reported; `steps` tells what is to be reported (asked for only there), `at_most` that it may be less. Elsewhere
    there is a line whenever stage or grid change, and with `verbose` one for every report. `quiet` shows nothing.
    """

    def __init__(
        self,
        title: str,
        *,
        quiet: bool = False,
        verbose: bool = False,
        steps: Callable[[], Sequence[Step]] = tuple,
        at_most: bool = False,
    ) -> None:
        self._title = title
        self._quiet = quiet
        self._verbose = verbose
        self._live = streams.is_terminal(sys.stderr) and not verbose and not quiet
        self._last_drawn = 0.0
        self._last_step: tuple[str, str] | None = None
        self._at_most = "at most " if at_most else ""
        self._shown = ""
        self._drawing = threading.Lock()
        self._closed = threading.Event()
        if self._live:
            start = time.monotonic()
            self._time_left = TimeLeft(steps(), start)
            threading.Thread(target=self._count_down, daemon=True).start()

    def __call__(self, stage: str, info: Mapping[str, Any]) -> None:
        if self._quiet:
            return
        if self._live:
            self._shown = describe(self._title, stage, info)
            now = time.monotonic()
            nx, ny = info.get("grid", (0, 0))
            if nx and ny:
                self._time_left.done(stage, (nx, ny), now)
            if now - self._last_drawn >= _REDRAW_SECONDS:
                self._redraw(now)
            return
        step = (stage, str(info.get("grid")))
        if self._verbose or step != self._last_step:
            self._last_step = step
            streams.note(describe(self._title, stage, info))

    def close(self) -> None:
        """Clear the line."""
        self._closed.set()
        with self._drawing:
            if self._live and self._last_drawn:
                self._draw("")

    def _count_down(self) -> None:
        while not self._closed.wait(_COUNT_SECONDS):
            if self._shown:
                self._redraw(time.monotonic())

    def _redraw(self, now: float) -> None:
        left = self._time_left.seconds(now)
        told = f", {self._at_most}about {duration(left)} left" if left >= _WORTH_TELLING_SECONDS else ""
        with self._drawing:
            if not self._closed.is_set():
                self._last_drawn = now
                self._draw(self._shown, told)

    @staticmethod
    def _draw(text: str, end: str = "") -> None:
        """Replace the line on the terminal; where it is too narrow, `text` is cut and `end` stays."""
        import shutil

        room = shutil.get_terminal_size().columns - 1 - len(end)
        try:
            sys.stderr.write("\r\x1b[K" + text[: max(room, 0)] + end)
            sys.stderr.flush()
        except OSError:
            pass


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
            parts.append(f"{name} {'×'.join(str(item) for item in value)}")
        elif isinstance(value, float):
            parts.append(f"{name} {value:.1e}")
        else:
            parts.append(f"{name} {value}")
    return f"{title}: {', '.join(parts)}"

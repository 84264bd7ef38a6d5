"""What the solver is doing: a line that redraws itself on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

from thermoroll_cli.cli import streams

_REDRAW_SECONDS = 0.1


class Progress:
    """Shows the reports of one solve on standard error. Use as `solve(..., report=progress)`, then `close` it.

    On a terminal one line shows the latest report. Elsewhere there is a line whenever stage or grid change, and with
    `verbose` one for every report. `quiet` shows nothing.
    """

    def __init__(self, title: str, *, quiet: bool = False, verbose: bool = False) -> None:
        self._title = title
        self._quiet = quiet
        self._verbose = verbose
        self._live = streams.is_terminal(sys.stderr) and not verbose and not quiet
        self._last_drawn = 0.0
        self._last_step: tuple[str, str] | None = None

    def __call__(self, stage: str, info: Mapping[str, Any]) -> None:
        if self._quiet:
            return
        if self._live:
            now = time.monotonic()
            if now - self._last_drawn >= _REDRAW_SECONDS:
                self._last_drawn = now
                self._draw(describe(self._title, stage, info))
            return
        step = (stage, str(info.get("grid")))
        if self._verbose or step != self._last_step:
            self._last_step = step
            streams.note(describe(self._title, stage, info))

    def close(self) -> None:
        """Clear the line."""
        if self._live and self._last_drawn:
            self._draw("")

    @staticmethod
    def _draw(text: str) -> None:
        import shutil

        try:
            sys.stderr.write("\r\x1b[K" + text[: shutil.get_terminal_size().columns - 1])
            sys.stderr.flush()
        except OSError:
            pass


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

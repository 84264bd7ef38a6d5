"""Signals of the processes that tests and scripts start, however these were started themselves."""

from __future__ import annotations

import signal
from types import FrameType


def give_children_default_signals() -> None:
    """Let processes started from here hear the signals that `nohup` and background jobs have us ignore.

    A process inherits what is ignored, but not what is handled: where a signal is ignored it gets a handler that does
    nothing. We go on ignoring it, and our children start as from a terminal.
    """
    for name in ("SIGINT", "SIGHUP", "SIGTERM", "SIGQUIT"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, _nothing)


def _nothing(number: int, frame: FrameType | None) -> None:
    pass

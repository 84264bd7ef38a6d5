"""How the program ends: exit codes, and the exceptions that lead to them."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable
from enum import IntEnum
from types import FrameType
from typing import Any

from thermoroll_cli.interruption import note_signal


class ExitCode(IntEnum):
    """What each exit code means. Scripts depend on these."""

    FINE = 0
    BUG = 1
    USAGE = 2
    INVALID_CASE = 3
    NOT_CONVERGED = 4
    INPUT_OUTPUT = 5
    OUTSIDE_TOLERANCE = 6
    CLOSED_OUTPUT = 128 + 13
    """Nobody reads our output any more (`thermoroll … | head`): as if the pipe's signal had ended the program."""


def worst(codes: Iterable[int]) -> int:
    """The exit code of a command with several parts: a bug before anything else, then the largest."""
    codes = list(codes)
    return ExitCode.BUG if ExitCode.BUG in codes else max(codes, default=ExitCode.FINE)


class ClosedOutput(BaseException):
    """Standard output was closed by its reader."""


def catch_signals(handler: Callable[[int, FrameType | None], None] = note_signal) -> Callable[[], None]:
    """Have the signals that stop a program go to `handler`: as it is, the program stops at its next safe point, and temporary
    files are cleaned up on the way out.

    Returns what puts the previous handlers back. A signal that is being ignored (nohup, background jobs) stays so.
    """
    previous: dict[int, Any] = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is None or signal.getsignal(number) in (signal.SIG_IGN, None):
            continue
        try:
            previous[number] = signal.signal(number, handler)
        except ValueError:  # not the main thread: whoever embeds us handles signals
            break

    def restore() -> None:
        for number, handler in previous.items():
            signal.signal(number, handler)

    return restore

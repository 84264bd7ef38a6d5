"""How the program ends: exit codes, and the exception for output that nobody reads."""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum


class ExitCode(IntEnum):
    """Exit codes and their meanings. Scripts depend on these."""

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

"""Stopping in good order: a signal is noted when it comes, and acted upon where the program can be left.

A handler that raises an exception does so wherever the program happens to be: inside a callback whose exceptions are
dropped, or halfway through clearing something up. So the handler only takes a note, and long work calls `safe_point` at every
step. Where the program waits for the outside world (`waiting`) and nothing would be damaged, the handler may raise.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType

INSIST_SECONDS = 0.5
"""A second signal this much later means it: the process ends at once. Sooner ones belong to the first: a terminal that is
closed, or an impatient hand, sends several."""


class Interrupted(BaseException):
    """A signal asks the program to stop. Not an Exception, so that no handler of errors swallows it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number

    @property
    def exit_code(self) -> int:
        return 128 + self.number


class _Noted:
    """The signal that came first (0: none) and when, whether it was raised already, and whether a handler may raise it."""

    number = 0
    since = 0.0
    raised = False
    waits = False


def note_signal(number: int, frame: FrameType | None = None) -> None:
    """Handler of signals: ask for a stop at the next safe point."""
    if not _Noted.number:
        _Noted.number, _Noted.since = number, time.monotonic()
    elif time.monotonic() - _Noted.since > INSIST_SECONDS:
        end_at_once(number)
    if _Noted.waits and not _Noted.raised:
        _Noted.waits = False
        raise Interrupted(_Noted.number)


def end_at_once(number: int, frame: FrameType | None = None) -> None:
    """Handler of signals: end the process here and now, with nothing cleared up."""
    os._exit(128 + number)


def forget() -> None:
    """As if no signal had come yet."""
    _Noted.number, _Noted.raised, _Noted.waits = 0, False, False


def safe_point() -> None:
    """Raises Interrupted if a signal has come. Once: what is done on the way out is not disturbed."""
    if _Noted.number and not _Noted.raised:
        _Noted.raised = True
        raise Interrupted(_Noted.number)


def import_in_steps(*modules: str) -> None:
    """Import `modules` one after the other, with a safe point behind each: libraries take some tenths of a second."""
    safe_point()
    for module in modules:
        if module not in sys.modules:
            importlib.import_module(module)
            safe_point()


def last_point() -> None:
    """Raises Interrupted if a signal has come at all, even if it was raised before and dropped by somebody."""
    if _Noted.number:
        _Noted.raised = True
        raise Interrupted(_Noted.number)


def noted() -> int:
    """The signal that has come, 0 if none has."""
    return _Noted.number


@contextlib.contextmanager
def waiting() -> Iterator[None]:
    """Around calls of the operating system that may take long, and nothing else: a signal ends them. On the way out of the
    program they are not disturbed any more, and those of other threads never: handlers run in the first."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    try:
        _Noted.waits = True
        safe_point()
        yield
    except Interrupted:
        _Noted.raised = True
        raise
    finally:
        _Noted.waits = False
    safe_point()

"""The process that runs: linear algebra on one thread, and stopping in good order.

A signal is noted when it comes, and acted upon at the next safe point. A handler that raised an exception would do so wherever
the program happens to be: in a callback whose exceptions are dropped, or halfway through clearing up. So the handler only sets
a flag, and long work calls `safe_point` once per iteration. A second signal ends the process at once; so does a thread that
the first one starts, if no safe point comes because the program waits for a pipe or a terminal.
"""

from __future__ import annotations

import _thread
import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterator
from functools import lru_cache
from types import FrameType
from typing import Any

import threadpoolctl

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that stop the program, as far as the system has them."""


def one_thread() -> None:
    """Have linear algebra use one thread, here and in processes started from here, unless the user wants otherwise. It must be
    called before NumPy is loaded.

    Sums depend on the number of threads in their last digits, and results should not; and the vectors here are so short that
    several threads wait for each other longer than they work.
    """
    global _decided
    _decided = "numpy" not in sys.modules
    for name in THREADS:
        os.environ.setdefault(name, "1")


_decided = False
"""Whether `one_thread` came before NumPy."""


@lru_cache(maxsize=1)
def _linear_algebra() -> threadpoolctl.ThreadpoolController:
    """The libraries of linear algebra that are loaded: looking for them takes as long as a small solve."""
    return threadpoolctl.ThreadpoolController()


def on_one_thread() -> contextlib.AbstractContextManager[object]:
    """Inside, linear algebra uses one thread, for the same reasons, where `one_thread` has not decided it; afterwards as many
    as before. Transforms have threads of their own."""
    return contextlib.nullcontext() if _decided else _linear_algebra().limit(limits=1, user_api="blas")


class Interrupted(BaseException):
    """A signal asks the program to stop. Not an Exception, so that no handler of errors swallows it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


_noted = 0
_raised = False
_run = 0


def note_signal(number: int, frame: FrameType | None = None) -> None:
    """Handler of signals."""
    global _noted
    if _noted:
        os._exit(128 + _noted)
    _noted = number
    # Not threading.Thread, which takes locks that the interrupted code may hold.
    _thread.start_new_thread(_end_without_safe_point, (_run,))


def _end_without_safe_point(run: int) -> None:
    """End the process if no safe point comes within 2.5 s of a signal."""
    time.sleep(2.5)
    if run == _run and _noted and not _raised:
        os._exit(128 + _noted)


def noted() -> int:
    """The signal that has come since `stoppable` began; 0 if none has."""
    return _noted


def safe_point() -> None:
    """Raises Interrupted if a signal has come. Only once, so that cleaning up is not disturbed."""
    global _raised
    if _noted and not _raised:
        _raised = True
        raise Interrupted(_noted)


@contextlib.contextmanager
def stoppable() -> Iterator[None]:
    """Inside, the signals that stop a program are noted. One that is being ignored (nohup, background jobs) stays so."""
    global _noted, _raised, _run
    _noted, _raised, _run = 0, False, _run + 1
    previous: dict[signal.Signals, Any] = {}
    with contextlib.suppress(ValueError):  # not the main thread: the embedding program handles signals
        for number in SIGNALS:
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                previous[number] = signal.signal(number, note_signal)
    try:
        yield
    finally:
        _run += 1  # a thread that still waits for this run must not end the next one
        for number, handler in reversed(previous.items()):
            signal.signal(number, handler)

"""A process that solves for this one, and ends when this one does.

It imports little: a new process comes by here first, and until it has it cannot be told to end.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import Any

from thermoroll_cli.files.environment import one_thread

WRITING = threading.Lock()
"""Held while a file is written: a worker that has to stop at once stops before or after that."""


def one_process(leash: Connection) -> ProcessPoolExecutor:
    """A process that ends when the other side of `leash` is closed."""
    with fit_for_children():
        # Python's own helper, which it starts with the first process, must not die of what is sent to all, either.
        resource_tracker.ensure_running()
    return ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=_prepare, initargs=(leash,))


def submitted(
    idle: list[ProcessPoolExecutor], leash: Connection, function: Callable[..., Any], *arguments: object
) -> tuple[Future[Any], ProcessPoolExecutor]:
    """Have an `idle` process, which is taken from there, or else a new one call `function`. One that died while it had nothing
    to do is passed over."""
    while idle:
        pool = idle.pop()
        with contextlib.suppress(BrokenProcessPool), fit_for_children():
            return pool.submit(function, *arguments), pool
    pool = one_process(leash)
    with fit_for_children():
        return pool.submit(function, *arguments), pool


@contextlib.contextmanager
def fit_for_children() -> Iterator[None]:
    """What a process started inside inherits: one thread for linear algebra, and no ear for Ctrl-C and the like, which
    terminals and supervisors send to all: only this process decides what it means, and the others follow its end."""
    one_thread()
    masks = hasattr(signal, "pthread_sigmask")
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}) if masks else set()
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _prepare(leash: Connection) -> None:
    if not hasattr(signal, "pthread_sigmask"):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(leash,), daemon=True).start()


def _end_with_parent(leash: Connection) -> None:
    with contextlib.suppress(EOFError, OSError):
        leash.recv_bytes()
    with WRITING:
        os._exit(1)

"""Tasks worked off in this process, in several of this machine, or by a Dask cluster."""

from __future__ import annotations

import _thread
import contextlib
import importlib.util
import logging
import multiprocessing
import os
import pathlib
import signal
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Protocol, Self

from thermoroll_cli.tools.atomic import WriteError, remove_leftovers
from thermoroll_cli.tools.journal import Journal, Record, keep
from thermoroll_cli.tools.process import one_thread, safe_point

DEATHS = 3
"""A point is given up after so many of the processes that solved it have died. Processes killed from outside do not count."""
CONNECT_SECONDS = 10

Item = tuple[Record, Mapping[str, bytes]]
"""A record for the journal, and the contents of its files by their names."""


class Work(Protocol):
    """Work for one process: items that have no record yet. Plain enough to be sent there."""

    @property
    def key(self) -> str:
        """Key of the first item."""

    def items(self) -> Iterator[Item]:
        """Do the work, item by item. An OSError ends the whole run."""

    def without(self, done: Callable[[str], bool]) -> Self | None:
        """The task without the items whose keys are `done`; None if nothing is left."""

    def parts(self) -> list[Self]:
        """A task for each item."""

    def given_up(self, reason: str) -> Record:
        """The record of an item that kills the process that works at it."""


@dataclass(frozen=True)
class Workers:
    """Who works: `jobs` processes of this machine, or the Dask cluster whose scheduler is at `dask`, which may be without a
    worker for `patience` seconds."""

    jobs: int = 1
    dask: str = ""
    patience: float = 60.0


def check_dask() -> None:
    """Raises ImportError, which says what to install, if clusters cannot be used."""
    if importlib.util.find_spec("distributed") is None:
        raise ImportError("needs Dask's package distributed, which is not installed: pip install 'thermoroll[dask]'")


UNGUARDED = 70
"""Exit code of a process that runs into its parent's call, because the script's `__main__` is not guarded."""


def check_main_guard() -> None:
    """Raises RuntimeError if processes started from this script would start the same work again, as they import it."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        os._exit(UNGUARDED)
    if not hasattr(sys.modules["__main__"], "__file__"):  # a notebook, or an interpreter
        return
    probe = multiprocessing.get_context("spawn").Process(target=one_thread)
    probe.start()
    probe.join()
    if probe.exitcode == UNGUARDED:
        raise RuntimeError('several processes import this script: put its work behind if __name__ == "__main__":')


def run(tasks: Iterable[Work], journal: Journal, workers: Workers, note: Callable[[str], None]) -> Generator[str]:
    """Work off `tasks`, keep every item in `journal` as soon as it is done, and yield its key.

    Processes write into the journal themselves, so finished tasks are kept whatever happens to this one. Close the
    iterator to stop: the processes end, each after the item that it is writing; they also end when this process dies. When
    a process dies, the tasks in flight are tried again, one alone at a time. One that `DEATHS` processes died of is taken
    apart, and a single item given up after as many. `note` is called with remarks.

    Raises OSError: a file cannot be written; no cluster, or it went away. ImportError.
    """
    try:
        if workers.dask:
            with _Cluster(workers.dask, workers.patience, note) as cluster:
                yield from _run_elsewhere(iter(tasks), journal, cluster, note)
        elif workers.jobs > 1:
            with _Machine(workers.jobs, journal.path) as processes:
                yield from _run_elsewhere(iter(tasks), journal, processes, note)
        else:
            for task in tasks:
                for item in task.items():
                    journal.keep(*item)
                    yield from journal.update()
                    safe_point()
    finally:
        remove_leftovers(journal.path.parent)


def _run_elsewhere(
    tasks: Iterator[Work], journal: Journal, workers: _Machine | _Cluster, note: Callable[[str], None]
) -> Iterator[str]:
    suspects: deque[Work] = deque()
    deaths: Counter[str] = Counter()
    running: dict[Future[list[Item]], Work] = {}
    alone = False
    while True:
        if not running:
            alone = bool(suspects)
        while len(running) < (1 if alone else workers.places):
            task = (suspects.popleft() if suspects else None) if alone else next(tasks, None)
            if task is None:
                break
            running[workers.submit(task)] = task
        if not running:
            return
        done, _ = wait(running, 0.1, FIRST_COMPLETED)
        safe_point()
        if not done:
            workers.check()
        died = []
        for future in done:
            task = running.pop(future)
            try:
                for item in workers.result(future):
                    journal.keep(*item)
            except workers.died:
                died.append(task)
        if died:
            died += workers.renewed(running)
            note("a worker process died; its points are solved again")
        yield from journal.update()
        for task in died:
            left = task.without(journal.__contains__)
            if left is None:
                continue
            deaths[left.key] += alone
            if deaths[left.key] < DEATHS:
                suspects.append(left)
            elif len(parts := left.parts()) > 1:
                suspects.extend(parts)
            else:
                journal.keep(left.given_up(f"the process that solved it died {DEATHS} times (killed, or out of memory)"))
        yield from journal.update()


class Processes(ProcessPoolExecutor):
    """Processes of this machine that end with this one and ignore the signals that a terminal sends to all."""

    def __init__(self, jobs: int) -> None:
        # spawn: a forked process hangs after a transform that used threads.
        context = multiprocessing.get_context("spawn")
        # The processes wait for the end of this connection, which the kernel makes known whatever happens to this one.
        self._leash, self._hold = context.Pipe(duplex=False)
        with _deaf_children():
            super().__init__(jobs, context, initializer=_end_with_parent, initargs=(self._leash,))

    def submit(self, work: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        one_thread()
        try:
            with _deaf_children():
                return super().submit(work, *given, **named)
        except BrokenProcessPool as cause:  # a process died while it had nothing to do
            failed: Future[Any] = Future()
            failed.set_exception(cause)
            return failed

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._hold.close()
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._leash.close()


class _Machine:
    """Processes of this machine, which write into the journal at `path` themselves."""

    died = BrokenProcessPool

    def __init__(self, jobs: int, path: pathlib.Path) -> None:
        self.places, self._path, self._processes = jobs, path, Processes(jobs)

    def submit(self, task: Work) -> Future[list[Item]]:
        return self._processes.submit(_work_off, task, self._path)

    def check(self) -> None:
        """Does nothing: a process that dies breaks the pool, and its tasks fail."""

    @staticmethod
    def result(future: Future[list[Item]]) -> list[Item]:
        return future.result()

    def renewed(self, running: dict[Future[list[Item]], Work]) -> list[Work]:
        """Start new processes; the tasks that broke with the old ones."""
        broken = list(running.values())
        running.clear()
        self._processes.shutdown(cancel_futures=True)
        self._processes = Processes(self.places)
        return broken

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._processes.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _deaf_children() -> Iterator[None]:
    """Child processes ignore SIGINT and SIGHUP, which a terminal sends to all; the parent stops them. If the system can block
    signals, the children start with both blocked."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # Python's own helper, which it starts with the first semaphore, must not die of a signal to all, either.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        resource_tracker.ensure_running()
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


_writing = threading.Lock()
"""A process holds it while it keeps an item, and ends only when it is free."""


def _end_with_parent(leash: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on systems that cannot block it
    # A pool sends SIGTERM to its other processes as soon as one of them has ended.
    signal.signal(signal.SIGTERM, lambda *_: _thread.start_new_thread(_end, ()))

    def wait_for_the_end() -> None:
        with contextlib.suppress(EOFError, OSError):
            leash.recv_bytes()
        _end()

    threading.Thread(target=wait_for_the_end, daemon=True).start()


def _end() -> None:
    with _writing:
        os._exit(1)


def _work_off(task: Work, path: pathlib.Path) -> list[Item]:
    """Runs in a process of this machine. Nothing is returned: everything is in the journal."""
    try:
        for record, content in task.items():
            with _writing:
                keep(path, record, content)
    except OSError as cause:
        # Not every OSError survives the way between processes.
        raise OSError(str(cause)) from None
    return []


class _Cluster:
    """A Dask cluster, whose workers need not see our folder: items come back. Dask itself repeats what a dead worker was at,
    and gives a task up that several workers died of."""

    def __init__(self, address: str, patience: float, note: Callable[[str], None]) -> None:
        import distributed
        from distributed.comm import get_address_host_port

        self.died = distributed.KilledWorker
        self._address, self._patience, self._note = address, patience, note
        self._alone_since: float | None = None
        # What goes wrong is an error of ours. Each logger of Dask has a handler of its own.
        self._silent = [logger for name, logger in logging.root.manager.loggerDict.items()
                        if name.partition(".")[0] in ("asyncio", "distributed") and isinstance(logger, logging.Logger)]
        self._log(False)
        try:
            get_address_host_port(address)  # before a client, which takes long to go away
            self._client = distributed.Client(address, timeout=min(CONNECT_SECONDS, max(patience, 1.0)), set_as_default=False)
        except (OSError, ValueError, TypeError) as cause:
            self._log(True)
            raise OSError(f"no Dask scheduler at {address}: {cause or type(cause).__name__}") from None
        # Not pure: a task is not taken for one of an earlier sweep that Dask still remembers.
        self._executor = self._client.get_executor(pure=False)

    @property
    def places(self) -> int:
        """Two tasks for each worker, so that none is idle."""
        return 2 * max(1, self._workers)

    @property
    def _workers(self) -> int:
        return len(self._client.scheduler_info(n_workers=-1)["workers"])

    def check(self) -> None:
        """Report that there is no worker. Raises OSError if that lasts too long."""
        if self._workers:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
            self._note(f"waiting for a worker of the Dask cluster at {self._address}, {self._patience:g} s at most")
        elif time.monotonic() - self._alone_since > self._patience:
            raise OSError(f"the Dask cluster at {self._address} had no worker for {self._patience:g} s; "
                          "--dask-wait waits longer")

    def submit(self, task: Work) -> Future[list[Item]]:
        future: Future[list[Item]] = self._executor.submit(_collect, task)
        return future

    def result(self, future: Future[list[Item]]) -> list[Item]:
        try:
            return future.result()
        except ImportError as cause:
            raise OSError(f"the workers of the cluster lack a package of thermoroll: {cause}") from None

    @staticmethod
    def renewed(running: dict[Future[list[Item]], Work]) -> list[Work]:
        return []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        # Calls of a client without its scheduler fail in many ways.
        lost = isinstance(value, CancelledError) or (
            self._client.status != "running" and isinstance(value, Exception) and not isinstance(value, WriteError))
        with contextlib.suppress(Exception) if lost else contextlib.nullcontext():
            self._executor.shutdown(wait=False)
            self._client.close()
        self._log(True)
        if lost:
            raise OSError(f"the Dask scheduler at {self._address} went away; --resume continues") from None

    def _log(self, wanted: bool) -> None:
        for logger in self._silent:
            logger.disabled = not wanted


def _collect(task: Work) -> list[Item]:
    """Runs on a cluster."""
    return list(task.items())

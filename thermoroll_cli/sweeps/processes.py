"""Stretches solved by several processes of this machine."""

from __future__ import annotations

import multiprocessing
import pathlib
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from typing import Any

from thermoroll_cli.interruption import safe_point
from thermoroll_cli.sweeps.points import Stretch
from thermoroll_cli.sweeps.stretch import Outcome, Target, solve_all_into
from thermoroll_cli.sweeps.worker_process import submitted

POLL_SECONDS = 0.1
DEATHS_PER_POINT = 3
"""A point that three processes died of is given up; a process killed from outside costs nothing."""


def in_processes(stretches: Sequence[Stretch], target: Target, jobs: int, note: Callable[[str], None]) -> Iterator[Outcome]:
    """Solve `stretches` in `jobs` processes and yield what becomes of each pending point, in the order of completion.

    Each process is a pool of its own: when one dies, the others are not disturbed, and it is known which point it was at.
    That point is solved again by a new process. Close the generator to stop: processes end at once, files they have
    written stay. They end as well when this process is killed. Raises OSError if a file cannot be written.
    """
    # The processes wait for the end of this connection, which the kernel makes known whatever happens to us.
    leash, hold = multiprocessing.get_context("spawn").Pipe(duplex=False)
    pools: set[ProcessPoolExecutor] = set()
    idle: list[ProcessPoolExecutor] = []
    running: dict[Future[list[Outcome]], _Run] = {}
    waiting = deque(stretches)
    deaths: Counter[int] = Counter()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                stretch = waiting.popleft()
                before = {point.number: _mark(target.path(point)) for point in stretch.pending}
                future, pool = submitted(idle, leash, solve_all_into, stretch, target)
                running[future] = _Run(stretch, target, pool, before, set())
                pools.add(pool)
            for future in completed(running):
                run = running.pop(future)
                try:
                    outcomes = future.result()
                except BrokenProcessPool:
                    yield from run.arrivals()
                    stretch, given_up = _after_death(run, deaths)
                    note("a worker process died; " + ("its point is given up" if given_up else "its point is solved again"))
                    yield from given_up
                    if stretch.pending:
                        waiting.appendleft(stretch)
                    continue
                idle.append(run.pool)
                yield from (outcome for outcome in outcomes if outcome.number not in run.arrived)
            for run in running.values():
                yield from run.arrivals()
    finally:
        hold.close()
        for pool in pools:
            pool.shutdown(wait=True, cancel_futures=True)
        leash.close()


@dataclass(frozen=True)
class _Run:
    """A stretch being solved. Its files tell how far it is: `before` has what was there when it began."""

    stretch: Stretch
    target: Target
    pool: ProcessPoolExecutor
    before: dict[int, tuple[int, ...]]
    arrived: set[int]

    def arrivals(self) -> Iterator[Outcome]:
        """The points whose files have come since the last call."""
        for point in self.stretch.pending:
            if point.number not in self.arrived and _mark(self.target.path(point)) not in ((), self.before[point.number]):
                self.arrived.add(point.number)
                yield Outcome(point.number)


def _mark(path: pathlib.Path) -> tuple[int, ...]:
    """Changes whenever the file is replaced; empty without a file."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return (found.st_ino, found.st_mtime_ns, found.st_size)


def _after_death(run: _Run, deaths: Counter[int]) -> tuple[Stretch, list[Outcome]]:
    """What is left of a stretch whose process died, and the point that is given up if it was once too often."""
    stretch = replace(run.stretch, finished=run.stretch.finished | run.arrived)
    if not stretch.pending:
        return stretch, []
    number = stretch.pending[0].number
    deaths[number] += 1
    if deaths[number] < DEATHS_PER_POINT:
        return stretch, []
    reason = f"the process that solved it died {DEATHS_PER_POINT} times (killed, or out of memory)"
    return replace(stretch, given_up=stretch.given_up | {number}), [Outcome(number, reason)]


def completed(running: Iterable[Future[Any]]) -> set[Future[Any]]:
    """Those of `running` that are done; waits a little for the first. Raises Interrupted if a signal has come."""
    done, _ = wait(running, POLL_SECONDS, FIRST_COMPLETED)
    safe_point()
    return done

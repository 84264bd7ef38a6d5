"""Tasks of several stretches solved by processes of this machine or by a Dask cluster; rows come back, not files."""

from __future__ import annotations

import multiprocessing
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import islice

from thermoroll_cli.files.result.scalar_file import ScalarRow
from thermoroll_cli.sweeps.cluster import WorkersDied, answer_from, executor_at
from thermoroll_cli.sweeps.points import PointMaker
from thermoroll_cli.sweeps.processes import DEATHS_PER_POINT, completed
from thermoroll_cli.sweeps.scalar_tasks import Part, Solved, TaskSize, failed_row, solve_task
from thermoroll_cli.sweeps.worker_process import submitted

Task = tuple[Part, ...]
AHEAD = 2
"""Tasks that wait at a cluster for each of its workers, so that none of them waits for us."""


class Tasks:
    """What is still to be solved: tasks of the size that has proved right, first those that a dead process left over."""

    def __init__(self, parts: Iterable[Part]) -> None:
        self._parts = iter(parts)
        self._left_over: deque[Task] = deque()
        self._deaths: Counter[int] = Counter()
        self.size = TaskSize()

    def next(self) -> Task:
        """The next task, empty when there is none."""
        return self._left_over.popleft() if self._left_over else tuple(islice(self._parts, self.size.stretches))

    def after_death(self, task: Task) -> list[ScalarRow]:
        """Have the task of a dead process solved again, in smaller and smaller ones: rows of points that are given up."""
        if len(task) > 1:
            self._left_over.extend((part,) for part in task)
            return []
        part = task[0]
        self._deaths[part.numbers.start] += 1
        if self._deaths[part.numbers.start] < DEATHS_PER_POINT:
            self._left_over.append(task)
            return []
        if len(part.pending) > 1:
            # One of them is to blame: the others are solved without it.
            singles = [range(number, number + 1) for number in part.pending]
            self._deaths[part.numbers.start] = 0
            self._left_over.extend((Part(single, alone=True),) for single in singles)
            return []
        reason = f"the process that solved it died {DEATHS_PER_POINT} times (killed, or out of memory)"
        return [failed_row(number, reason) for number in part.pending]


def rows_in_processes(
    maker: PointMaker, parts: Iterable[Part], jobs: int, note: Callable[[str], None]
) -> Iterator[tuple[ScalarRow, ...]]:
    """The rows of every task in the order of completion. A process that dies is replaced and its task solved again. Close the
    generator to stop."""
    leash, hold = multiprocessing.get_context("spawn").Pipe(duplex=False)
    pools: set[ProcessPoolExecutor] = set()
    idle: list[ProcessPoolExecutor] = []
    running: dict[Future[Solved], tuple[Task, ProcessPoolExecutor]] = {}
    tasks = Tasks(parts)
    try:
        while True:
            while len(running) < jobs and (task := tasks.next()):
                future, pool = submitted(idle, leash, solve_task, maker, task)
                running[future] = task, pool
                pools.add(pool)
            if not running:
                return
            for future in completed(running):
                task, pool = running.pop(future)
                try:
                    solved = future.result()
                except BrokenProcessPool:
                    note("a worker process died; its points are solved again")
                    yield tuple(tasks.after_death(task))
                    continue
                idle.append(pool)
                tasks.size.learn(len(task), solved.seconds)
                yield solved.rows
    finally:
        hold.close()
        for pool in pools:
            pool.shutdown(wait=True, cancel_futures=True)
        leash.close()


def rows_on_cluster(maker: PointMaker, parts: Iterable[Part], address: str) -> Iterator[tuple[ScalarRow, ...]]:
    """As `rows_in_processes` by the Dask cluster whose scheduler is at `address`; Dask itself repeats what a dead worker was
    at. Raises NoDask, OSError (no scheduler there, or it went away; workers without this package)."""
    tasks = Tasks(parts)
    with executor_at(address) as (executor, client):
        running: dict[Future[Solved], Task] = {}
        while True:
            workers = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
            while len(running) < AHEAD * workers and (task := tasks.next()):
                running[executor.submit(solve_task, maker, task)] = task
            if not running:
                return
            for future in completed(running):
                task = running.pop(future)
                try:
                    with answer_from(address):
                        solved = future.result()
                except WorkersDied:
                    yield tuple(tasks.after_death(task))
                    continue
                tasks.size.learn(len(task), solved.seconds)
                yield solved.rows

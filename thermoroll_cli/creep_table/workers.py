"""Tasks of a table solved in this process, in several, or by a Dask cluster."""

from __future__ import annotations

import itertools
import multiprocessing
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.point_solver import EllipseSolver
from thermoroll_cli.creep_table.table_plan import TablePlan, Task
from thermoroll_cli.sweeps.cluster import answer_from, executor_at
from thermoroll_cli.sweeps.processes import DEATHS_PER_POINT, completed
from thermoroll_cli.sweeps.worker_process import submitted


@lru_cache(maxsize=1)
def _solver(ratio: float, poisson_ratio: float, accuracy: float) -> EllipseSolver:
    return EllipseSolver(ratio, poisson_ratio, accuracy)


def solve_task(plan: TablePlan, task: Task) -> Array:
    """Values and errors (5, n) of the points of a task."""
    solver = _solver(task.ratio, plan.poisson_ratio, plan.accuracy / task.finer)
    solved = solver.solve(task.scaled(plan.axes) / np.array(solver.scales)[:, None])
    return np.concatenate([solved.values, solved.errors[None]])


def solved_tasks(
    plan: TablePlan, pending: Mapping[int, Task], jobs: int, dask: str, note: Callable[[str], None]
) -> Iterator[tuple[int, Array]]:
    """Numbers and results of the tasks, in the order of completion."""
    if dask:
        yield from _on_cluster(plan, pending, dask)
    elif jobs > 1:
        yield from _in_processes(plan, pending, jobs, note)
    else:
        for number, task in pending.items():
            yield number, solve_task(plan, task)


def _in_processes(
    plan: TablePlan, pending: Mapping[int, Task], jobs: int, note: Callable[[str], None]
) -> Generator[tuple[int, Array]]:


    leash, hold = multiprocessing.get_context("spawn").Pipe(duplex=False)
    waiting, deaths = list(pending)[::-1], dict.fromkeys(pending, 0)
    idle: list[ProcessPoolExecutor] = []
    running: dict[Future[Array], tuple[int, ProcessPoolExecutor]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                number = waiting.pop()
                future, pool = submitted(idle, leash, solve_task, plan, pending[number])
                running[future] = number, pool
            for future in completed(running):
                number, pool = running.pop(future)
                try:
                    yield number, future.result()
                    idle.append(pool)
                except BrokenProcessPool:
                    deaths[number] += 1
                    if deaths[number] >= DEATHS_PER_POINT:
                        raise OSError(f"a worker process died {DEATHS_PER_POINT} times of the same points (killed, or out of "
                                      "memory); --resume continues") from None
                    note("a worker process died; its points are solved again")
                    waiting.append(number)
    finally:
        hold.close()
        for pool in itertools.chain(idle, (pool for _, pool in running.values())):
            pool.shutdown(wait=True, cancel_futures=True)
        leash.close()


def _on_cluster(plan: TablePlan, pending: Mapping[int, Task], address: str) -> Generator[tuple[int, Array]]:

    with executor_at(address) as (executor, _):
        running = {executor.submit(solve_task, plan, task): number for number, task in pending.items()}
        while running:
            for future in completed(running):
                with answer_from(address):
                    values = future.result()
                yield running.pop(future), values

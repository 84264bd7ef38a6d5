"""Stretches solved by a Dask cluster that is already running."""

from __future__ import annotations

import contextlib
import importlib.util
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any

from thermoroll_cli.sweeps.points import Stretch
from thermoroll_cli.sweeps.processes import completed
from thermoroll_cli.sweeps.stretch import Outcome, solve_away

CONNECT_SECONDS = 10


class NoDask(Exception):
    """The package `distributed` is not installed."""

    def __init__(self) -> None:
        super().__init__("needs Dask's package distributed, which is not installed: pip install 'thermoroll[dask]'")


class WorkersDied(OSError):
    """Dask gave a task up because several workers died of it."""

    def __init__(self) -> None:
        super().__init__("several workers of the cluster died of the same points (killed, or out of memory); "
                         "--resume continues")


def check_dask() -> None:
    """Raises NoDask if clusters cannot be used."""

    if importlib.util.find_spec("distributed") is None:
        raise NoDask


@contextlib.contextmanager
def executor_at(address: str) -> Iterator[tuple[Any, Any]]:
    """The executor of the cluster whose scheduler is at `address`, and its client. Raises NoDask, OSError (no scheduler)."""
    check_dask()
    import distributed

    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as cause:
        raise OSError(f"no Dask scheduler at {address}: {cause or type(cause).__name__}") from None
    with contextlib.ExitStack() as stack:
        stack.callback(client.close)
        # Not pure: a task is not taken for one of an earlier sweep that Dask still remembers.
        executor = client.get_executor(pure=False)
        stack.callback(executor.shutdown, wait=False)
        yield executor, client


@contextlib.contextmanager
def answer_from(address: str) -> Iterator[None]:
    """While the result of a task is taken: raises WorkersDied, OSError (no program there, no scheduler)."""
    import distributed

    try:
        yield
    except distributed.KilledWorker:
        raise WorkersDied from None
    except ImportError as cause:
        raise OSError(f"the workers of the cluster lack a package of thermoroll: {cause}") from None
    except CancelledError:
        raise OSError(f"the Dask scheduler at {address} went away; --resume continues") from None


def on_cluster(stretches: Sequence[Stretch], address: str, command_line: str) -> Iterator[Outcome]:
    """Have `stretches` solved by the cluster whose scheduler is at `address`, and yield what becomes of each point, with
    the content of its file: the workers need not see our folder, so a stretch comes back as a whole.

    Dask itself repeats what a dead worker was at, and gives a task up that several workers died of. Raises NoDask,
    OSError (no scheduler there, or it went away; workers without this package).
    """
    with executor_at(address) as (executor, _):
        running = {executor.submit(solve_away, stretch, command_line): stretch for stretch in stretches}
        while running:
            for future in completed(running):
                stretch = running.pop(future)
                try:
                    with answer_from(address):
                        outcomes = future.result()
                except WorkersDied:
                    reason = "several workers of the cluster died of its stretch (killed, or out of memory)"
                    outcomes = [Outcome(point.number, reason) for point in stretch.pending]
                yield from outcomes

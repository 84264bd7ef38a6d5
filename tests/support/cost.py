"""What something costs beside something else in the same process: no test may depend on how fast or busy a machine is."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence

ROUNDS = 4


def cost_ratio(work: Callable[[], object], yardstick: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Processor time of `work` over that of `yardstick`, of each the least of several rounds that alternate."""
    return _ratio(lambda: _processor_seconds(work), lambda: _processor_seconds(yardstick), rounds)


def process_cost_ratio(command: Sequence[str], program: str) -> float:
    """Processor time of the process `command` over that of a Python process that runs `program`."""
    return _ratio(lambda: _child_seconds(command), lambda: _child_seconds([sys.executable, "-c", program]))


def _ratio(seconds: Callable[[], float], yardstick_seconds: Callable[[], float], rounds: int = ROUNDS) -> float:
    pairs = [(seconds(), yardstick_seconds()) for _ in range(rounds)]
    return min(first for first, _ in pairs) / min(second for _, second in pairs)


def _processor_seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def _child_seconds(command: Sequence[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime + after.ru_stime) - (before.ru_utime + before.ru_stime)

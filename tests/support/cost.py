"""What something costs beside something else in the same process: no test may depend on how fast or busy a machine is."""

from __future__ import annotations

import time
from collections.abc import Callable

ROUNDS = 4


def cost_ratio(work: Callable[[], object], yardstick: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Processor time of `work` over that of `yardstick`, of each the least of several rounds that alternate."""
    pairs = [(_processor_seconds(work), _processor_seconds(yardstick)) for _ in range(rounds)]
    return min(first for first, _ in pairs) / min(second for _, second in pairs)


def _processor_seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start

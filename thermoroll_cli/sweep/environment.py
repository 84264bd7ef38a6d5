"""What has to be decided before NumPy is loaded."""

from __future__ import annotations

import os

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Have linear algebra use one thread, here and in processes started from here, unless the user wants otherwise.

    Its sums depend on the number of threads in their last digits, and points of a sweep should not; several processes
    with as many threads as there are processors each would only get in each other's way.
    """
    for name in _THREADS:
        os.environ.setdefault(name, "1")

"""Settings that have to be made before NumPy is loaded."""

from __future__ import annotations

import os

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Have linear algebra use one thread, here and in processes started from here, unless the user wants otherwise.

    Its sums depend on the number of threads in their last digits, and results should not; and the vectors here are so short
    that several threads wait for each other longer than they work.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")

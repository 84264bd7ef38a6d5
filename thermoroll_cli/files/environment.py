"""What has to be decided before anything large is loaded."""

from __future__ import annotations

import gc
import os

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Have linear algebra use one thread, here and in processes started from here, unless the user wants otherwise.

    Its sums depend on the number of threads in their last digits, and results should not; and the vectors here are so short
    that several threads wait for each other longer than they work.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")


def no_collections() -> None:
    """Hardly look for reference cycles while modules are imported: what they make lives on, and going through it again and
    again is a tenth of a short run."""
    gc.set_threshold(400_000, 20, 20)


def rare_collections() -> None:
    """From here on look for reference cycles among what is made, but for the first time not among what was imported. More
    rarely than Python does by itself: figures are made of very many objects."""
    if gc.get_freeze_count() == 0:
        gc.freeze()
    gc.set_threshold(20_000, 20, 20)


def no_plugins() -> None:
    """Spare pydantic the search for plugins among all installed packages: case files need none."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

"""Gauss's quadrature."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@cache
def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Nodes and weights (count,) on [−1, 1], by the eigenvectors of Legendre's recurrence (Golub and Welsch 1969).

    NumPy has them, too, in a package of which nothing else is needed and which takes a while to import."""
    k = np.arange(1.0, count)
    beside = k / np.sqrt(4.0 * k**2 - 1.0)
    nodes, vectors = np.linalg.eigh(np.diag(beside, 1) + np.diag(beside, -1))
    # The middle of an odd number is 0, and both halves are alike, to the last digit.
    nodes, weights = 0.5 * (nodes - nodes[::-1]), 2.0 * vectors[0] ** 2
    weights = 0.5 * (weights + weights[::-1])
    for fixed in (nodes, weights):
        fixed.setflags(write=False)
    return nodes, weights

"""Chebyshev polynomials on [0, 1]: nodes, values, and the series through values at the nodes."""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.arrays import Array


def node_positions(degree: int) -> Array:
    """The degree + 1 Chebyshev nodes of [0, 1], ends included."""
    return np.sin(0.5 * math.pi * np.arange(degree + 1) / degree) ** 2


def series_matrix(degree: int) -> Array:
    """Matrix from values at the nodes to the coefficients of the Chebyshev series through them."""
    order = np.arange(degree + 1)
    halved = np.where(order % degree == 0, 0.5, 1.0)
    # The polynomials at their own nodes, as cosines: the recurrence loses digits at the ends of the range.
    values = np.cos(math.pi / degree * (np.outer(order, degree - order) % (2 * degree)))
    return 2.0 / degree * halved[:, None] * values * halved


def chebyshev(position: Array, degree: int) -> Array:
    """Chebyshev polynomials 0..degree of 2·position − 1, shape (degree + 1, *shape of position)."""
    argument = 2.0 * position - 1.0
    values = np.empty((degree + 1, *position.shape))
    values[0], values[1] = 1.0, argument
    for order in range(2, degree + 1):
        values[order] = 2.0 * argument * values[order - 1] - values[order - 2]
    return values

"""Gauss's quadrature, whose points are asked for again and again."""

from __future__ import annotations

from functools import cache

import numpy as np

from thermoroll_cli.tools.arrays import Array


@cache
def gauss_points(count: int) -> tuple[Array, Array]:
    """Points in (−1, 1) and weights of Gauss–Legendre quadrature, (count,) each, not to be written to."""
    points, weights = np.polynomial.legendre.leggauss(count)
    points.flags.writeable = weights.flags.writeable = False
    return points, weights

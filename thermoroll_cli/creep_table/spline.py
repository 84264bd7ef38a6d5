"""Cubic splines on a grid of evenly spaced coordinates, evaluated for many points at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array

GHOSTS = 8
"""Values continued beyond an end: what the end of the continuation does wrong has fallen to 3e-5 at the last real one."""


def coefficients_free(values: Array) -> Array:
    """B-spline coefficients along the first axis, (n, …) -> (n + 2, …), with not-a-knot ends. n ≥ 4."""
    n = len(values)
    matrix = _values(n)
    matrix[0, :5] = matrix[-1, -5:] = (1.0, -4.0, 6.0, -4.0, 1.0)
    return _solve(matrix, np.concatenate([np.zeros_like(values[:1]), values, np.zeros_like(values[:1])]))


def coefficients_clamped(values: Array, slope: Array) -> Array:
    """The same with a given `slope` (…) per interval at the first value, and a not-a-knot end."""
    n = len(values)
    matrix = _values(n)
    matrix[0, :3] = (-0.5, 0.0, 0.5)
    matrix[-1, -5:] = (1.0, -4.0, 6.0, -4.0, 1.0)
    return _solve(matrix, np.concatenate([slope[None], values, np.zeros_like(values[:1])]))


def monotone_slopes(values: Array, coefficients: Array) -> Array:
    """Slopes per interval at `values` (n, …) of the spline with these `coefficients` (n + 2, …), no steeper than lets the
    interpolant be monotone where the values are (Fritsch & Carlson 1980): no overshoot where full sliding begins."""
    slopes = 0.5 * (coefficients[2:] - coefficients[:-2])
    rises = np.diff(values, axis=0)
    before, after = np.concatenate([rises[:1], rises]), np.concatenate([rises, rises[-1:]])
    sign = np.sign(before)
    limited = sign * np.clip(sign * slopes, 0.0, 3.0 * np.minimum(np.abs(before), np.abs(after)))
    return np.where(before * after > 0.0, limited, slopes)


def hermite_weights(position: Array, count: int) -> tuple[NDArray[np.intp], Array]:
    """As `weights`, for values and slopes in turn: value and slope at one node, and at the next."""
    first = np.clip(position.astype(np.intp), 0, count - 2)
    x = position - first
    y = 1.0 - x
    return 2 * first, np.stack([(1.0 + 2.0 * x) * y * y, x * y * y, x * x * (3.0 - 2.0 * x), -x * x * y])


def coefficients_continued(before: Array, values: Array, after: Array) -> Array:
    """The same for `values` (n, …) with their continuations (`GHOSTS`, …) at either end: (n + 2, …)."""
    inside = coefficients_free(np.concatenate([before, values, after]))
    return inside[GHOSTS : GHOSTS + len(values) + 2]


def _values(n: int) -> Array:
    matrix = np.zeros((n + 2, n + 2))
    rows = np.arange(1, n + 1)
    matrix[rows, rows - 1] = matrix[rows, rows + 1] = 1.0 / 6.0
    matrix[rows, rows] = 4.0 / 6.0
    return matrix


def _solve(matrix: Array, right: Array) -> Array:
    return np.asarray(np.linalg.solve(matrix, right.reshape(len(right), -1)).reshape(right.shape))


def weights(position: Array, count: int) -> tuple[NDArray[np.intp], Array]:
    """For positions 0 … count − 1 in units of the spacing: index of the first of four coefficients, and their weights
    (4, n)."""
    first = np.clip(position.astype(np.intp), 0, count - 2)
    x = position - first
    y = 1.0 - x
    x2, y2 = x * x, y * y
    return first, np.stack([y2 * y, 4.0 - 6.0 * x2 + 3.0 * x2 * x, 4.0 - 6.0 * y2 + 3.0 * y2 * y, x2 * x]) / 6.0

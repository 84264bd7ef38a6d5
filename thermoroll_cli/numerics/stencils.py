"""The highest value and the slope from the 3 × 3 elements around each one."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import AnyArray

DIFFERENCE_OFFSETS = (-2, -1, 0, 1)
"""Rows of u, from the one where ∂u/∂x is wanted, that `RollingOptions.difference_weights` belong to."""


def highest(field: AnyArray) -> AnyArray:
    """Highest value around each element; `field` ≥ 0, or a mask (nx, ny)."""
    padded = np.pad(field, 1)
    rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])


def sobel(padded: AnyArray, dx: float, dy: float) -> tuple[AnyArray, AnyArray]:
    """Sobel differences along x and y (eight times the slope), (nx, ny), of a field given with one more row and column on all
    sides, (nx+2, ny+2)."""
    rows = padded[:, :-2] + 2.0 * padded[:, 1:-1] + padded[:, 2:]
    columns = padded[:-2] + 2.0 * padded[1:-1] + padded[2:]
    return (rows[2:] - rows[:-2]) / dx, (columns[:, 2:] - columns[:, :-2]) / dy

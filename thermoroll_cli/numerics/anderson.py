"""Anderson acceleration of a fixed point x = g(x)."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array

DEPENDENT = 1e-8
"""Singular value over the largest one below which differences of residuals count as dependent: they have half of the digits."""


class Anderson:
    """Mixes the last `depth` iterates (Anderson 1965; Walker & Ni 2011, type II)."""

    def __init__(self, depth: int = 4, first_damping: float = 1.0) -> None:
        self.depth, self.first_damping = depth, first_damping
        self._values: list[Array] = []
        self._residuals: list[Array] = []

    def next(self, x: Array, value: Array) -> Array:
        """The next iterate from the current `x` and `value` = g(x), arrays of one shape."""
        residual = value - x
        self._values.append(value)
        self._residuals.append(residual)
        if len(self._values) > self.depth + 1:
            del self._values[0], self._residuals[0]
        if len(self._values) == 1:
            return x + self.first_damping * residual
        differences = np.stack([(r - residual).ravel() for r in self._residuals[:-1]], axis=1)
        weights, *_ = np.linalg.lstsq(differences, residual.ravel(), rcond=DEPENDENT)
        mixed = value.copy()
        for w, v in zip(weights, self._values[:-1], strict=True):
            mixed -= w * (v - value)
        return mixed

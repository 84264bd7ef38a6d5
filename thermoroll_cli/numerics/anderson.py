"""Anderson acceleration of a fixed point x = g(x)."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array

DEPENDENT = 1e-8
"""Singular value over the largest one below which differences of residuals count as dependent: they have half of the digits."""


Pairs = tuple[tuple[Array, Array], ...]


class Anderson:
    """Mixes the last `depth` iterates (Anderson 1965; Walker & Ni 2011, type II)."""

    def __init__(self, depth: int = 4, first_damping: float = 1.0, known: Pairs = ()) -> None:
        """`known` are pairs of changes of g(x) and of its residual in a neighbouring problem; own ones replace them."""
        self.depth, self.first_damping = depth, first_damping
        self._known = known
        self._values: list[Array] = []
        self._residuals: list[Array] = []

    def next(self, x: Array, value: Array) -> Array:
        """The next iterate from the current `x` and `value` = g(x), arrays of one shape."""
        residual = value - x
        self._values.append(value)
        self._residuals.append(residual)
        if len(self._values) > self.depth + 1:
            del self._values[0], self._residuals[0]
        pairs = self.pairs
        if not pairs:
            return x + self.first_damping * residual
        differences = np.stack([change.ravel() for _, change in pairs], axis=1)
        weights, *_ = np.linalg.lstsq(differences, residual.ravel(), rcond=DEPENDENT)
        mixed = value.copy()
        for w, (change, _) in zip(weights, pairs, strict=True):
            mixed -= w * change
        return mixed

    @property
    def pairs(self) -> Pairs:
        """Changes of g(x) and of its residual against the last iterate, up to `depth` of them."""
        own = tuple((v - self._values[-1], r - self._residuals[-1])
                    for v, r in zip(self._values[:-1], self._residuals[:-1], strict=True))
        return own + self._known[: self.depth - len(own)]

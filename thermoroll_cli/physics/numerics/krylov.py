"""GMRES for linear systems, and Anderson's acceleration for fixed points."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.tools.arrays import Array

Vector = NDArray[Any]

REPEATED_BELOW = 0.1
"""Gram–Schmidt is repeated if the length of a vector falls below this share (Daniel et al. 1976)."""


class KrylovSolution(NamedTuple):
    """`step` solves the system to relative residual `residual` in `iterations`; `image` is the expensive part of the
    operator applied to `step`, combined from the iterations and therefore free."""

    step: Vector
    image: Vector
    iterations: int
    residual: float


def gmres(
    expensive: Callable[[Vector], Vector], cheap: Callable[[Vector, Vector], Vector], precondition: Callable[[Vector], Vector],
    right_hand_side: Vector, tolerance: float, max_iterations: int
) -> KrylovSolution:
    """Solve J d = b for J d = cheap(d, expensive(d)), without restart (Saad & Schultz 1986).

    `expensive` is the linear convolution, `cheap` the element-wise rest, which must return a new array. Classical
    Gram–Schmidt needs two matrix products instead of k dot products; it is repeated where it has lost digits.
    """
    norm = length_of(right_hand_side)
    if norm == 0.0:
        zero = np.zeros_like(right_hand_side)
        return KrylovSolution(zero, zero.copy(), 0, 0.0)
    # Rows that are never reached are never touched, and so cost no memory.
    lost = 4.0 * float(np.finfo(np.float64).eps)
    basis = np.empty((max_iterations + 1, right_hand_side.size))
    np.divide(right_hand_side, norm, out=basis[0])
    steps: list[Vector] = []
    images: list[Vector] = []
    hessenberg = np.zeros((max_iterations + 1, max_iterations))
    rotations: list[tuple[float, float]] = []
    residuals = np.zeros(max_iterations + 1)
    residuals[0] = 1.0
    k = 0
    while k < max_iterations:
        step = precondition(basis[k])
        image = expensive(step)
        w = cheap(step, image)
        steps.append(step)
        images.append(image)
        column = _orthogonalised(w, basis[: k + 1])
        length = float(column[-1])
        for i, (c, s) in enumerate(rotations):
            column[i], column[i + 1] = c * column[i] + s * column[i + 1], -s * column[i] + c * column[i + 1]
        r = float(np.hypot(column[k], column[k + 1]))
        if r == 0.0:
            break  # the operator maps this direction to zero: the solution so far is the best there is
        c, s = column[k] / r, column[k + 1] / r
        rotations.append((c, s))
        column[k], column[k + 1] = r, 0.0
        hessenberg[: k + 2, k] = column
        residuals[k], residuals[k + 1] = c * residuals[k], -s * residuals[k]
        k += 1
        if abs(residuals[k]) <= tolerance or length <= lost * r:
            break
        np.divide(w, length, out=basis[k])
    if k == 0:
        return KrylovSolution(np.zeros_like(right_hand_side), np.zeros_like(images[0]), 0, 1.0)
    y = [float(v) for v in np.linalg.solve(hessenberg[:k, :k], residuals[:k] * norm)]
    return KrylovSolution(_combination(y, steps[:k]), _combination(y, images[:k]), k, float(abs(residuals[k])))


def _orthogonalised(w: Vector, basis: Vector) -> Vector:
    """Subtract from `w`, in place, its components along the orthonormal rows of `basis`. Returns them and the length left."""
    before = length_of(w)
    components = basis @ w
    w -= components @ basis
    length = length_of(w)
    if length < REPEATED_BELOW * before:
        correction = basis @ w
        w -= correction @ basis
        components += correction
        length = length_of(w)
    return np.append(components, length)


def length_of(vector: Vector) -> float:
    """2-norm; numpy's own takes more than twice as long for short vectors."""
    return math.sqrt(vector.dot(vector))


def _combination(coefficients: list[float], vectors: list[Vector]) -> Vector:
    total = coefficients[0] * vectors[0]
    term = np.empty_like(total)
    for c, v in zip(coefficients[1:], vectors[1:], strict=True):
        total += np.multiply(c, v, out=term)
    return np.asarray(total)


DEPENDENT_SINGULAR_VALUE = 1e-8
"""Singular value over the largest one below which differences of residuals count as dependent: they have half of the digits."""


Secants = tuple[Array, Array]
"""Pairs of changes of g(x) and of g(x) − x, from one x to another: two arrays (pairs, *shape of x)."""


class Anderson:
    """Mixes the last `depth` iterates (Anderson 1965; Walker & Ni 2011, type II), and `known` secants of the same or a similar
    problem."""

    def __init__(self, depth: int = 4, first_damping: float = 1.0, known: Secants | None = None) -> None:
        self.depth, self.first_damping = depth, first_damping
        self._known: Secants = ((), ()) if known is None else known  # type: ignore[assignment]
        self._values: list[Array] = []
        self._residuals: list[Array] = []

    @property
    def secants(self) -> Secants | None:
        """Those of the last iterates, newest first, and then the known ones, at most `depth`; None if there are none."""
        values, residuals = (
            [*reversed([b - a for a, b in pairwise(fields)]), *known]
            for fields, known in zip((self._values, self._residuals), self._known, strict=True))
        return (np.stack(values[:self.depth]), np.stack(residuals[:self.depth])) if values else None

    def next(self, x: Array, value: Array) -> Array:
        """The next iterate from the current `x` and `value` = g(x), arrays of one shape."""
        residual = value - x
        self._values.append(value)
        self._residuals.append(residual)
        if len(self._values) > self.depth + 1:
            del self._values[0], self._residuals[0]
        differences = [*(r - residual for r in self._residuals[:-1]), *self._known[1]]
        if not differences:
            return x + self.first_damping * residual
        columns = np.stack([d.ravel() for d in differences], axis=1)
        weights, *_ = np.linalg.lstsq(columns, residual.ravel(), rcond=DEPENDENT_SINGULAR_VALUE)
        mixed = value.copy()
        for w, change in zip(weights, [*(v - value for v in self._values[:-1]), *self._known[0]], strict=True):
            mixed -= w * change
        return mixed

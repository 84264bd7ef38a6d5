"""GMRES for one linear system, and for many small ones at once: Python's overhead then occurs once per iteration. Anderson's
acceleration does the same for fixed points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import AnyArray, Array

Vector = NDArray[Any]

REPEATED_BELOW = 0.1
"""Gram–Schmidt is repeated if the length of a vector falls below this share (Daniel et al. 1976)."""


@dataclass(frozen=True)
class KrylovSolution:
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
    norm = float(np.linalg.norm(right_hand_side))
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
        zero = np.zeros_like(right_hand_side)
        return KrylovSolution(zero, zero.copy(), 0, 1.0)
    y = [float(v) for v in np.linalg.solve(hessenberg[:k, :k], residuals[:k] * norm)]
    return KrylovSolution(_combination(y, steps[:k]), _combination(y, images[:k]), k, float(abs(residuals[k])))


def _orthogonalised(w: Vector, basis: Vector) -> Vector:
    """Subtract from `w`, in place, its components along the orthonormal rows of `basis`. Returns them and the length left."""
    before = float(np.linalg.norm(w))
    components = basis @ w
    w -= components @ basis
    length = float(np.linalg.norm(w))
    if length < REPEATED_BELOW * before:
        correction = basis @ w
        w -= correction @ basis
        components += correction
        length = float(np.linalg.norm(w))
    return np.append(components, length)


def _combination(coefficients: list[float], vectors: list[Vector]) -> Vector:
    total = coefficients[0] * vectors[0]
    term = np.empty_like(total)
    for c, v in zip(coefficients[1:], vectors[1:], strict=True):
        total += np.multiply(c, v, out=term)
    return np.asarray(total)


Indices = NDArray[np.intp]

DROPPED_SHARE = 0.25
"""Solved systems are dropped from the arrays once they are this share of all; dropping copies every array."""
FIRST_DIRECTIONS = 12
"""Directions allocated per system at first: most systems need no more, and touching new memory is slow."""


def batch_gmres(
    expensive: Callable[[AnyArray], AnyArray], cheap: Callable[[Indices, AnyArray, AnyArray], AnyArray],
    precondition: Callable[[Indices, AnyArray], AnyArray], right: AnyArray, tolerance: NDArray[np.float64], most: int
) -> tuple[AnyArray, AnyArray]:
    """Solve J_b d_b = r_b for all rows of `right` (B, P), each to its relative `tolerance` (B,): as `krylov.gmres` does.

    Returns the solutions d and expensive(d), both (B, P). The first argument of `cheap` and `precondition` holds the indices
    of the systems whose rows they get. Gram–Schmidt is done once: the systems are small and solved to a few digits."""
    size = right.shape[1]
    step, image = np.zeros_like(right), np.zeros_like(right)
    norm = np.linalg.norm(right, axis=1)
    who = np.flatnonzero(norm > 0.0)
    if not who.size:
        return step, image
    basis = np.empty((len(who), min(FIRST_DIRECTIONS, most + 1), size), dtype=right.dtype)
    steps: list[AnyArray] = []
    images: list[AnyArray] = []
    basis[:, 0] = right[who] / norm[who, None]
    hessenberg = np.zeros((len(who), most + 1, most))
    rotations = np.zeros((len(who), most, 2))
    residual = np.zeros((len(who), most + 1))
    residual[:, 0] = 1.0
    done_at = np.zeros(len(who), dtype=int)
    for k in range(most):
        vectors = precondition(who, basis[:, k])
        steps.append(vectors)
        images.append(expensive(vectors))
        w = cheap(who, vectors, images[k])
        spanned = basis[:, : k + 1]
        h = np.matmul(spanned, w[:, :, None])[:, :, 0]
        w -= np.matmul(h[:, None], spanned)[:, 0]
        length = np.linalg.norm(w, axis=1)
        safe = _rotate(k, np.concatenate([h, length[:, None]], axis=1), hessenberg, rotations, residual)
        if k + 2 > basis.shape[1]:
            basis = _room(basis, min(2 * (k + 2), most + 1))
        basis[:, k + 1] = w / np.where(length > 0.0, length, 1.0)[:, None]
        finished = (done_at == 0) & ((np.abs(residual[:, k + 1]) <= tolerance[who]) | (length <= 1e-6 * safe))
        done_at[finished] = k + 1
        if k + 1 == most:
            done_at[done_at == 0] = most
        solved = done_at > 0
        if solved.all() or k + 1 == most or solved.mean() > DROPPED_SHARE:
            _combine(who[solved], done_at[solved], hessenberg[solved], residual[solved], norm, solved, steps, images,
                     step, image)
            if solved.all():
                break
            rest = ~solved
            who, done_at = who[rest], done_at[rest]
            # Copy only the columns in use: most of the space has never been touched.
            basis = _room(basis[:, : k + 2], basis.shape[1], rest)
            steps, images = [v[rest] for v in steps], [v[rest] for v in images]
            hessenberg, rotations, residual = hessenberg[rest], rotations[rest], residual[rest]
    return step, image


def _room(basis: AnyArray, columns: int, rows: AnyArray | slice = slice(None)) -> AnyArray:
    """The `rows` of `basis` (B, k, P) in an array with place for `columns` vectors each."""
    kept = basis[rows]
    out = np.empty((len(kept), columns, basis.shape[2]), dtype=basis.dtype)
    out[:, : basis.shape[1]] = kept
    return out


def _rotate(k: int, column: AnyArray, hessenberg: AnyArray, rotations: AnyArray, residual: AnyArray) -> AnyArray:
    """Put a new column (B, k + 2) of the Hessenberg matrices into triangular form, and update the residuals (Givens). Returns
    the diagonal elements."""
    column = column.astype(float)
    for i in range(k):
        c, s = rotations[:, i, 0], rotations[:, i, 1]
        upper, lower = column[:, i].copy(), column[:, i + 1]
        column[:, i], column[:, i + 1] = c * upper + s * lower, c * lower - s * upper
    r = np.hypot(column[:, k], column[:, k + 1])
    safe = np.where(r > 0.0, r, 1.0)
    c, s = np.where(r > 0.0, column[:, k] / safe, 1.0), column[:, k + 1] / safe
    rotations[:, k, 0], rotations[:, k, 1] = c, s
    column[:, k], column[:, k + 1] = safe, 0.0
    hessenberg[:, : k + 2, k] = column
    residual[:, k], residual[:, k + 1] = c * residual[:, k], -s * residual[:, k]
    return safe


def _combine(
    who: Indices, sizes: Indices, hessenberg: AnyArray, residual: AnyArray, norm: AnyArray, solved: AnyArray,
    steps: list[AnyArray], images: list[AnyArray], step: AnyArray, image: AnyArray,
) -> None:
    """Write the solutions of the `solved` systems `who`, each from the first `sizes` of its directions."""
    most = int(sizes.max())
    own = np.arange(most) < sizes[:, None]
    triangle = np.where(own[:, :, None] & own[:, None, :], hessenberg[:, :most, :most], np.eye(most))
    known = np.where(own, residual[:, :most], 0.0) * norm[who, None]
    weights = np.linalg.solve(triangle, known[:, :, None])[:, :, 0].astype(step.dtype)
    for out, directions in ((step, steps), (image, images)):
        total = weights[:, :1] * directions[0][solved]
        for k in range(1, most):
            total += weights[:, k : k + 1] * directions[k][solved]
        out[who] = total


DEPENDENT_SINGULAR_VALUE = 1e-8
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
        weights, *_ = np.linalg.lstsq(differences, residual.ravel(), rcond=DEPENDENT_SINGULAR_VALUE)
        mixed = value.copy()
        for w, v in zip(weights, self._values[:-1], strict=True):
            mixed -= w * (v - value)
        return mixed

"""Influence tables for a Péclet number that differs from source to source, as a short sum of convolutions.

If every source element x' has its own P(x'), for example with the slip velocity, the response
Σ K_P(x')(x − x') q(x') is not a convolution. A low-rank expansion K_P(X) ≈ Σ_k L_k(X) φ_k(P) turns it into a few:

    response = Σ_k conv(L_k, φ_k(P) q) + Σ offset(P) q

The L_k are the first singular vectors of the tables at Chebyshev points of s = asinh(P^¼). Displacement tables contain P ln P,
which needs four times as many points in √P; for large P tables change with ln P. φ_k is the Chebyshev series in s through its
values at these points.

The displacement U is an average of Φ(P sech²y) over y (`thermal`), so tables of the cheaper Φ at the same points serve for it.
Its unbounded part −b ln(P)/2π, equal everywhere, is added in closed form; the expanded rest is bounded at P = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial.chebyshev import chebpts2, chebval, chebvander
from numpy.typing import ArrayLike

from thermoroll_cli.physics.halfspace import thermal
from thermoroll_cli.tools.arrays import Array

ThermalKind = Literal["temperature", "displacement"]

POINTS_PER_UNIT = 32
"""Chebyshev points per unit of s: between 33 and 161 tables represent all others to a tenth of 1e-5, for P up to 1e6."""


@dataclass(frozen=True)
class PecletWeights:
    """Weights φ_k(P) of the `terms` tables and the offset of an expansion for 0 ≤ P ≤ `peclet_max`.

    `series` (degree + 1, terms) and `offset_series` (degree + 1,) are Chebyshev coefficients. `error` is the larger of two, at
    all points and with an estimate of the error between them: the error of any coefficient relative to the largest coefficient
    at that P; and the sum of the errors of all coefficients relative to the sum of their magnitudes, which bounds the error of
    a response."""

    kind: ThermalKind
    aspect: float
    peclet_max: float
    error: float
    series: Array
    offset_series: Array

    @property
    def terms(self) -> int:
        """Number of convolutions that the response needs."""
        return self.series.shape[1]

    def __call__(self, peclet: ArrayLike) -> Array:
        """φ_k(P), shape (terms, *shape of peclet). Raises ValueError for P outside [0, peclet_max]."""
        return self._evaluate(self.series, peclet)

    def offset(self, peclet: ArrayLike) -> Array:
        """The mean of the table, zero for temperature; shape of `peclet`.

        The mean displacement rises without bound, as −b ln(P)/2π, when P → 0. With P = 0 exactly it is the mean of
        the table without motion, whose constant is arbitrary. If slip makes the heat, q ∝ P and q offset(P) → 0, so
        neither the growth nor the arbitrary value matters.
        Raises ValueError for P outside [0, peclet_max].
        """
        smooth = self._evaluate(self.offset_series, peclet)
        if self.kind == "temperature":
            return smooth
        # The average over y of the part of Φ that `_bounded` omits; ⟨ln sech²y⟩ = 1 − ln 4.
        values = np.asarray(peclet, dtype=np.float64)
        moving = np.where(values > 0.0, values, math.exp(math.log(16.0) - np.euler_gamma - 1.0))
        return np.asarray(smooth - self.aspect / (2.0 * math.pi) * (np.log(moving) + 1.0 - math.log(4.0)))

    def _evaluate(self, series: Array, peclet: ArrayLike) -> Array:
        values = np.asarray(peclet, dtype=np.float64)
        if values.size and not (values.min() >= 0.0 and values.max() <= self.peclet_max * (1.0 + 1e-9)):
            raise ValueError(f"Péclet numbers must be between 0 and {self.peclet_max:g}")
        return np.asarray(chebval(_position(values, self.peclet_max), series))


def variable_peclet_tables(
    nx: int, ny: int, aspect: float, peclet_max: float, kind: ThermalKind, tolerance: float = 1e-5
) -> tuple[Array, PecletWeights]:
    """Expand temperature (Eq. 19) or displacement (Eq. 20) tables of an nx × ny grid for P = V dx/κ in [0, peclet_max], the
    material moving to +x.

    `aspect` is dy/dx; `tolerance` is for both errors of `PecletWeights`. Returns tables (terms, 2nx−1, 2ny−1) in the layout of
    `thermal.temperature_table`, and their weights; the sum has the units of the table expanded (q dx/k, or (1+ν) α q dx²/k).
    Raises ValueError for an empty grid, an aspect that is not positive, or a range that is negative or not finite.
    """
    x, y = thermal.offsets(nx, ny, aspect, peclet_max, 0.0)
    if peclet_max < 0.0:
        raise ValueError(f"the largest Péclet number must not be negative, not {peclet_max}")
    degree = POINTS_PER_UNIT * math.ceil(0.5 + _root_scale(peclet_max)) if peclet_max else 0
    points = chebpts2(degree + 1) if degree else np.zeros(1)
    samples = np.stack([_bounded(kind, x, y, aspect, p).ravel() for p in _peclet(points, peclet_max)], axis=1)
    to_series = np.linalg.inv(chebvander(points, degree))
    means = np.zeros(degree + 1)
    if kind == "displacement":
        samples = samples @ (_angle_average(points, peclet_max) @ to_series).T
        each = np.tile(np.where(y > 0.0, 2.0, 1.0), len(x))
        means = each @ samples / each.sum()
        samples -= means
    scale = np.abs(samples).sum(axis=0)
    left, singular, right = np.linalg.svd(samples / scale, full_matrices=False)
    largest, rest, terms, error = np.abs(samples).max(axis=0), samples.copy(), 0, math.inf
    while terms < len(singular) and error > 0.6 * tolerance:
        rest -= np.outer(left[:, terms], singular[terms] * right[terms] * scale)
        terms += 1
        error = float(max((np.abs(rest).sum(axis=0) / scale).max(), (np.abs(rest).max(axis=0) / largest).max()))
    weights = right[:terms].T * scale[:, None] * singular[:terms]
    series = to_series @ weights
    if degree:
        # The last coefficients of the series have the size of those that are missing.
        tail = np.abs(left[:, :terms] @ series[-2:].T)
        error += float(max((tail.sum(axis=0) / scale.min()).max(), (tail.max(axis=0) / largest.min()).max()))
    tables = np.stack([thermal.mirrored(table.reshape(len(x), len(y)), ny) for table in left[:, :terms].T])
    return tables, PecletWeights(kind, aspect, peclet_max, error, series, to_series @ means)


def _root_scale(peclet: ArrayLike) -> Array:
    return np.asarray(np.arcsinh(np.asarray(peclet, dtype=np.float64) ** 0.25))


def _position(peclet: Array, peclet_max: float) -> Array:
    """Place of Péclet numbers in the interval [−1, 1] of the Chebyshev polynomials."""
    return np.minimum(2.0 * _root_scale(peclet) / _root_scale(peclet_max) - 1.0, 1.0) if peclet_max else np.zeros(peclet.shape)


def _peclet(position: Array, peclet_max: float) -> Array:
    """Inverse of `_position`."""
    return np.asarray(np.sinh(0.5 * (position + 1.0) * _root_scale(peclet_max)) ** 4)


def _bounded(kind: ThermalKind, x: Array, y: Array, aspect: float, peclet: float) -> Array:
    """The sampled function: T, or Φ without its unbounded part −b ln(P)/2π."""
    if kind == "temperature":
        return thermal.temperature_at(x, y, aspect, peclet)
    logarithm = aspect / (2.0 * math.pi)
    if peclet == 0.0:
        return thermal.stationary_displacement(x, y, aspect) + logarithm * (math.log(4.0) - np.euler_gamma)
    return thermal.advected_expansion(x, y, aspect, peclet) + logarithm * math.log(peclet)


def _angle_average(points: Array, peclet_max: float) -> Array:
    """Values at the points of U(P) = (4/π) ∫ sech³y Φ(P sech²y) dy for Φ = each Chebyshev polynomial."""
    angles, weights, _ = thermal.angle_rule(1.0, 0.5 * thermal.ANGLE_STEP)
    peclets = np.outer(_peclet(points, peclet_max), np.cosh(angles) ** -2.0)
    return np.asarray(np.tensordot(chebvander(_position(peclets, peclet_max), len(points) - 1), weights, axes=(1, 0)))

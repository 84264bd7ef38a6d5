"""Influence tables for a Péclet number that differs from source to source, as a short sum of convolutions.

If every source element x' has its own P(x'), as when P is made with the slip velocity, the response
Σ K_P(x')(x − x') q(x') is not a convolution. A low-rank expansion K_P(X) ≈ Σ_k L_k(X) φ_k(P) turns it into a few:

    response = Σ_k conv(L_k, φ_k(P) q) + Σ offset(P) q

The expansion is a singular value decomposition over samples of P, and φ_k is interpolated between them by its
Chebyshev series (the same polynomial as by the barycentric formula). Samples are Chebyshev points in the fourth
root of P: displacement tables contain P ln P, which in √P needs four times as many samples.

The decomposition needs no full tables: offsets are sampled as densely as the kernel varies, closely around the source
and ever more widely away from it. A pivoted QR factorisation of those samples then selects the few P ("skeleton") whose
full tables span all others.

The displacement U is an average of Φ(P sech²y) over y (`thermal`), so a skeleton of the cheaper Φ serves for it too.
Its unbounded part −b ln(P)/2π, equal everywhere, is added in closed form; the expanded rest is bounded at P = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy
from numpy.polynomial.chebyshev import chebpts2, chebvander
from numpy.typing import ArrayLike

from thermoroll_cli.arrays import Array
from thermoroll_cli.halfspace.thermal import (
    ANGLE_STEP,
    advected_expansion,
    angle_rule,
    displacement_at,
    stationary_displacement,
    temperature_at,
)

DENSE_OFFSETS = 12
"""Offsets up to this many elements are all sampled; beyond, each is `OFFSET_GROWTH` times the one before."""
OFFSET_GROWTH = 1.12


@dataclass(frozen=True)
class OffsetSamples:
    """Sampled offsets x × y, and the number of table entries that each stands for."""

    x: Array
    y: Array
    counts: Array

    def mean(self, columns: Array) -> Array:
        """Mean over the table of each column."""
        return self.counts @ columns / self.counts.sum()

    def relative_error(self, difference: Array, columns: Array) -> float:
        """Largest error of any column, in both norms described at `VariablePecletKernel`."""
        in_sum = (self.counts @ np.abs(difference)) / (self.counts @ np.abs(columns))
        in_peak = np.abs(difference).max(axis=0) / np.abs(columns).max(axis=0)
        return float(max(in_sum.max(), in_peak.max()))


def graded_offsets(nx: int, ny: int, aspect: float) -> OffsetSamples:
    along, along_counts = _graded(nx)
    across, across_counts = _graded(ny)
    x = np.concatenate((-along[:0:-1], along))
    x_counts = np.concatenate((along_counts[:0:-1], along_counts))
    y_counts = across_counts * np.where(across > 0.0, 2.0, 1.0)
    return OffsetSamples(x, aspect * across, np.outer(x_counts, y_counts).ravel())


def _graded(count: int) -> tuple[Array, Array]:
    """Offsets from 0 to count − 1, ever wider apart, and the number of whole offsets nearest to each."""
    chosen = [0]
    while chosen[-1] < count - 1:
        step = 1 if chosen[-1] < DENSE_OFFSETS else max(1, round(chosen[-1] * (OFFSET_GROWTH - 1.0)))
        chosen.append(min(count - 1, chosen[-1] + step))
    offsets = np.array(chosen, dtype=np.float64)
    borders = np.concatenate(([-0.5], 0.5 * (offsets[1:] + offsets[:-1]), [count - 0.5]))
    return offsets, np.diff(borders)


def spanning_columns(offsets: OffsetSamples, columns: Array, tolerance: float) -> tuple[list[int], Array, Array]:
    """Indices of a few columns that span all, an orthonormal basis, and the components of all columns in it.

    A pivoted QR factorisation, ended when the remainder of every column is small. Entries of the columns are weighted by the
    number of table entries that they stand for.
    """
    scaled = np.sqrt(offsets.counts)[:, None] * columns
    norms = np.sqrt((scaled**2).sum(axis=0))
    basis, triangle, order = scipy.linalg.qr(scaled / norms, mode="economic", pivoting=True)
    count = int(np.count_nonzero(np.abs(np.diag(triangle)) > tolerance))
    components = np.empty((count, len(norms)))
    components[:, order] = triangle[:count]
    return [int(k) for k in order[:count]], basis[:, :count], components * norms


def truncated(offsets: OffsetSamples, basis: Array, components: Array, tolerance: float) -> tuple[Array, Array, float]:
    """Fewest singular vectors within the tolerance: (samples, terms) matrices that make tables and weights, and the error.

    ``components`` are those of the kernel at all samples in ``basis``, as from `spanning_columns`. Samples of P count
    relative to their own magnitude.
    """
    difference = (basis @ components) / np.sqrt(offsets.counts)[:, None]
    kernel = difference.copy()
    scale = offsets.counts @ np.abs(kernel)
    left, singular, right = np.linalg.svd(components / scale, full_matrices=False)
    modes = (basis @ left) / np.sqrt(offsets.counts)[:, None]
    terms, error = 0, math.inf
    while terms < len(singular) and error > tolerance:
        difference -= np.outer(modes[:, terms], singular[terms] * right[terms] * scale)
        terms, error = terms + 1, offsets.relative_error(difference, kernel)
    return right[:terms].T / scale[:, None], right[:terms].T * scale[:, None], error


ThermalKind = Literal["temperature", "displacement"]

FIRST_DEGREE, LAST_DEGREE = 16, 512
"""Degrees of the polynomial in P^¼: doubled from the first until its error is small enough."""
CHECKED_PECLETS = 7
"""Péclet numbers between the samples at which the finished expansion is compared with the kernel."""
SOURCES_TOGETHER = 1 << 15
"""Sources whose weights are computed together, to bound memory."""


@dataclass(frozen=True)
class VariablePecletKernel:
    """Expansion K_P ≈ offset(P) + Σ_k tables[k] weights(P)[k] for 0 ≤ P ≤ peclet_max, with the material moving to +x.

    ``tables`` has the shape (terms, 2nx−1, 2ny−1) and the layout of `thermal.temperature_table`; the sum is in the
    units of the table expanded (q dx/k, or (1+ν) α q dx²/k). For a source on which the material moves to −x, mirror
    the tables in X.

    ``error`` is the larger of two, measured at all samples (``truncation``) and at some Péclet numbers between: the
    error of any coefficient relative to the largest coefficient at that P; and the sum of the errors of all coefficients
    relative to the sum of their magnitudes, which bounds the error of a response. It is computed on first access, from
    the tables' entries at the ``offsets``, because it costs more than the tables.
    """

    kind: ThermalKind
    aspect: float
    peclet_max: float
    tables: Array
    truncation: float
    offsets: OffsetSamples
    entries: Array
    weight_series: Array
    offset_series: Array

    @cached_property
    def error(self) -> float:
        """Largest error, with Péclet numbers between the samples against the kernel computed directly."""
        offsets = self.offsets
        peclets = self.peclet_max * ((np.arange(CHECKED_PECLETS) + 0.37) / CHECKED_PECLETS) ** 4
        computed = temperature_at if self.kind == "temperature" else displacement_at
        exact = np.stack([computed(offsets.x, offsets.y, self.aspect, float(p)).ravel() for p in peclets], axis=1)
        offset = self.offset(peclets)
        between = offsets.relative_error(self.entries.T @ self.weights(peclets) + offset - exact, exact - offset)
        return max(self.truncation, between)

    @property
    def terms(self) -> int:
        """Number of convolutions that the response needs."""
        return len(self.tables)

    def weights(self, peclet: ArrayLike) -> Array:
        """φ_k(P), shape (terms, *shape of peclet). Raises ValueError for P outside [0, peclet_max]."""
        values = np.asarray(peclet, dtype=np.float64)
        return _evaluate(self.weight_series, values, self.peclet_max).reshape(self.terms, *values.shape)

    def offset(self, peclet: ArrayLike) -> Array:
        """The mean of the table, the same at every point. Zero for temperature; shape of ``peclet``.

        The mean displacement rises without bound, as −b ln(P)/2π, when P → 0. With P = 0 exactly it is the mean of
        the table without motion, whose constant is arbitrary. Where slip makes the heat, q ∝ P and q offset(P) → 0, so
        neither the growth nor the arbitrary value matters.
        Raises ValueError for P outside [0, peclet_max].
        """
        values = np.asarray(peclet, dtype=np.float64)
        smooth = _evaluate(self.offset_series, values, self.peclet_max).reshape(values.shape)
        return smooth if self.kind == "temperature" else smooth - _unbounded_part(values, self.aspect)


def variable_peclet_kernel(
    nx: int, ny: int, aspect: float, peclet_max: float, kind: ThermalKind, tolerance: float = 1e-5
) -> VariablePecletKernel:
    """Expand temperature (Eq. 19) or displacement (Eq. 20) tables of an nx × ny grid for P = V dx/κ in [0, peclet_max].

    ``aspect`` is dy/dx; ``tolerance`` is for both errors described at `VariablePecletKernel`, whose ``error`` is the one
    reached. The numbers of samples, of full tables and of terms follow from it. Raises ValueError for fewer than
    two elements, an aspect that is not positive, a range that is negative or not finite, an unknown kind, and a
    tolerance outside [1e-7, 0.1].
    """
    if nx < 1 or ny < 1 or nx * ny < 2:
        raise ValueError(f"an expansion needs a grid of at least two elements, not {nx} × {ny}")
    if not (math.isfinite(aspect) and aspect > 0.0):
        raise ValueError(f"the aspect dy/dx must be positive and finite, not {aspect}")
    if not (math.isfinite(peclet_max) and peclet_max >= 0.0):
        raise ValueError(f"the largest Péclet number must be finite and not negative, not {peclet_max}")
    if kind not in ("temperature", "displacement"):
        raise ValueError(f"kind must be 'temperature' or 'displacement', not {kind!r}")
    if not 1e-7 <= tolerance <= 0.1:
        raise ValueError(f"the tolerance must be between 1e-7 and 0.1, not {tolerance}")

    offsets = graded_offsets(nx, ny, aspect)
    peclets, columns, means = _sample(offsets, aspect, peclet_max, kind, 0.1 * tolerance)
    degree = len(peclets) - 1
    skeleton, basis, components = spanning_columns(offsets, columns, 0.02 * tolerance)
    mixing = np.eye(degree + 1) if kind == "temperature" else _angle_average(degree)
    from_kernel, weights, truncation = truncated(offsets, basis, components @ mixing.T, 0.6 * tolerance)

    # Table k = Σ_i kernel(P_i) from_kernel[i, k], and kernel(P_i) is itself a combination of the skeleton.
    solved = np.linalg.solve(components[:, skeleton], components @ mixing.T @ from_kernel)
    from_skeleton = np.asarray(solved, dtype=np.float64)
    tables = np.zeros((from_skeleton.shape[1], 2 * nx - 1, 2 * ny - 1))
    half = tables[:, :, ny - 1 :]
    _combine(half, aspect, kind, peclets[skeleton], means[skeleton], from_skeleton)
    offset = mixing @ means
    if kind == "displacement":
        # Sampled offsets give the mean of a table only approximately: move the remainder into the offset.
        left = (half[:, :, 0].sum(axis=1) + 2.0 * half[:, :, 1:].sum(axis=(1, 2))) / ((2 * nx - 1) * (2 * ny - 1))
        half -= left[:, None, None]
        offset = offset + weights @ left
    tables[:, :, : ny - 1] = half[:, :, :0:-1]

    to_series = _to_series(degree)
    rows, places = (np.rint(offsets.x).astype(int) + nx - 1, np.rint(offsets.y / aspect).astype(int) + ny - 1)
    return VariablePecletKernel(
        kind, aspect, peclet_max, tables, truncation, offsets,
        entries=tables[:, rows[:, None], places].reshape(len(tables), -1),
        weight_series=to_series @ weights, offset_series=(to_series @ offset)[:, None])


def _nodes(degree: int) -> Array:
    """The degree + 1 Chebyshev points of [0, 1], ends included."""
    return np.asarray(0.5 + 0.5 * chebpts2(degree + 1))


def _to_series(degree: int) -> Array:
    """Matrix from values at the nodes to the coefficients of the Chebyshev series through them."""
    return np.asarray(np.linalg.inv(chebvander(chebpts2(degree + 1), degree)))


def _polynomials(position: Array, degree: int) -> Array:
    """Chebyshev polynomials 0..degree of 2·position − 1, shape (degree + 1, *shape of position)."""
    return np.moveaxis(np.asarray(chebvander(2.0 * position - 1.0, degree), dtype=np.float64), -1, 0)


def _bounded(kind: ThermalKind, x: Array, y: Array, aspect: float, peclet: float) -> Array:
    """The sampled function: T, or Φ without its unbounded part −b ln(P)/2π."""
    if kind == "temperature":
        return temperature_at(x, y, aspect, peclet)
    logarithm = aspect / (2.0 * math.pi)
    if peclet == 0.0:
        return stationary_displacement(x, y, aspect) + logarithm * (math.log(4.0) - np.euler_gamma)
    return advected_expansion(x, y, aspect, peclet) + logarithm * math.log(peclet)


def _unbounded_part(peclet: Array, aspect: float) -> Array:
    """(b/2π)(ln P + ⟨ln sech²y⟩): the average of the part of Φ that `_bounded` omits; ⟨ln sech²y⟩ = 1 − ln 4."""
    moving = np.where(peclet > 0.0, peclet, math.exp(math.log(16.0) - np.euler_gamma - 1.0))
    return aspect / (2.0 * math.pi) * (np.log(moving) + 1.0 - math.log(4.0))


def _sample(
    offsets: OffsetSamples, aspect: float, peclet_max: float, kind: ThermalKind, tolerance: float
) -> tuple[Array, Array, Array]:
    """Péclet numbers that resolve the dependence on P, the sampled offsets there (one column each), and their means.

    The degree is doubled until the polynomial through the samples so far predicts the new ones. The means are taken
    out of displacement columns, and are zero for temperature.
    """
    degree = FIRST_DEGREE
    peclets = peclet_max * _nodes(degree) ** 4
    columns = np.stack([_bounded(kind, offsets.x, offsets.y, aspect, p).ravel() for p in peclets], axis=1)
    error = math.inf
    while error > tolerance and degree < LAST_DEGREE:
        positions = _nodes(2 * degree)
        between = positions[1::2]
        new = [_bounded(kind, offsets.x, offsets.y, aspect, p).ravel() for p in peclet_max * between**4]
        finer = np.empty((len(columns), 2 * degree + 1))
        finer[:, ::2], finer[:, 1::2] = columns, np.stack(new, axis=1)
        predicted = columns @ (_polynomials(between, degree).T @ _to_series(degree)).T
        reference = finer[:, 1::2]
        if kind == "displacement":
            predicted, reference = predicted - offsets.mean(predicted), reference - offsets.mean(reference)
        error = offsets.relative_error(predicted - reference, reference)
        degree, columns, peclets = 2 * degree, finer, peclet_max * positions**4
    means = offsets.mean(columns) if kind == "displacement" else np.zeros(degree + 1)
    return peclets, columns - means, means


def _combine(half: Array, aspect: float, kind: ThermalKind, peclets: Array, means: Array, coefficients: Array) -> None:
    """Add combinations of the skeleton's full tables to ``half``, tables for Y ≥ 0 only."""
    nx, ny = (half.shape[1] + 1) // 2, half.shape[2]
    x, y = np.arange(1.0 - nx, nx), aspect * np.arange(float(ny))
    for peclet, mean, row in zip(peclets, means, coefficients, strict=True):
        table = _bounded(kind, x, y, aspect, float(peclet)) - mean
        for term, coefficient in zip(half, row, strict=True):
            term += coefficient * table


def _angle_average(degree: int) -> Array:
    """Matrix that makes U from Φ, both at the nodes: U(P) = (4/π) ∫ sech³y Φ(P sech²y) dy."""
    angles, weights, _ = angle_rule(1.0, 0.5 * ANGLE_STEP)
    positions = np.outer(_nodes(degree), np.cosh(angles) ** -0.5)
    blocks = np.array_split(positions, 1 + degree // 64)  # all at once would need degree² × angles numbers
    series = [np.tensordot(_polynomials(block, degree), weights, axes=(2, 0)) for block in blocks]
    return np.concatenate(series, axis=1).T @ _to_series(degree)


def _evaluate(series: Array, peclet: Array, peclet_max: float) -> Array:
    """Chebyshev series in P^¼ (one per column) at the Péclet numbers, shape (series, number of Péclet numbers)."""
    flat = peclet.ravel()
    if flat.size and not (flat.min() >= 0.0 and flat.max() <= peclet_max * (1.0 + 1e-9)):
        raise ValueError(f"Péclet numbers must be between 0 and {peclet_max:g}")
    result = np.empty((series.shape[1], flat.size))
    for start in range(0, flat.size, SOURCES_TOGETHER):
        block = flat[start : start + SOURCES_TOGETHER]
        position = (block / peclet_max) ** 0.25 if peclet_max > 0.0 else np.zeros(len(block))
        result[:, start : start + SOURCES_TOGETHER] = series.T @ _polynomials(np.minimum(position, 1.0), len(series) - 1)
    return result

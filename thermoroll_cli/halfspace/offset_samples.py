"""Offsets of an influence table, sampled as densely as its kernel varies, and the few samples of a parameter that span all."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.arrays import Array

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

    A pivoted QR factorisation by Gram-Schmidt steps, which ends when what remains of every column is small. Entries
    of the columns are scaled so that each counts by the number of table entries it stands for.
    """
    scaled = np.sqrt(offsets.counts)[:, None] * columns
    norms = np.sqrt((scaled**2).sum(axis=0))
    remaining = scaled / norms
    chosen: list[int] = []
    basis = np.empty((0, len(columns)))
    rows = []
    while len(chosen) < len(norms):
        sizes = np.sqrt((remaining**2).sum(axis=0))
        pivot = int(sizes.argmax())
        if sizes[pivot] <= tolerance:
            break
        direction = remaining[:, pivot] - basis.T @ (basis @ remaining[:, pivot])
        direction /= math.sqrt(direction @ direction)
        rows.append(direction @ remaining)
        remaining -= np.outer(direction, rows[-1])
        basis = np.vstack((basis, direction))
        chosen.append(pivot)
    return chosen, basis.T, np.array(rows) * norms


def truncated(
    offsets: OffsetSamples, basis: Array, components: Array, tolerance: float
) -> tuple[Array, Array, float]:
    """Fewest singular vectors that hold the tolerance: (samples, terms) matrices that make tables and weights, error.

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

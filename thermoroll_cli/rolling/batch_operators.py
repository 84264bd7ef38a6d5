"""The operators of the tangential solver for many tractions at once, as matrices: on grids of up to some thirty elements a
side one product of matrices is faster than many small transforms.

Kernels do not know y from −y, so tractions are split into two parts: τ_x even and τ_y odd across y = 0, and the other way
round. Each part needs half the elements, and both together half the work.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import AnyArray, Mask
from thermoroll_cli.halfspace.elastic import ShearCompliance, shear_tables
from thermoroll_cli.interruption import safe_point
from thermoroll_cli.numerics.convolution import even_length
from thermoroll_cli.numerics.solver_options import UPSTREAM_WEIGHTS
from thermoroll_cli.numerics.stencils import DIFFERENCE_OFFSETS
from thermoroll_cli.rolling.stick_inverse import inverse_symbols

Kernels = tuple[AnyArray, AnyArray, AnyArray]
"""Influence at offsets −(n−1)…n−1 by −(m−1)…m−1, (2n−1, 2m−1) each: x on x, y on y, each on the other."""


class PairMatrix:
    """Three kernels applied to pairs of fields, (B, 2, n, m) -> (B, 2, n, m), in the precision of these. m is even.

    Only what acts within `contact` (n, m) and is felt there counts, as far as it is symmetric in y: an ellipse has a fifth
    fewer elements than its rectangle, and a product of matrices two fifths less work."""

    def __init__(self, shape: tuple[int, int], kernels: Kernels, contact: Mask | None = None) -> None:
        n, m = self._shape = shape
        if m % 2:
            raise ValueError(f"an even number of columns is needed to split them at y = 0, got {m}")
        whole = contact is None or not np.array_equal(contact, contact[:, ::-1])
        above = np.ones((n, m // 2), dtype=bool) if whole or contact is None else contact[:, m // 2 :]
        self._cells = np.flatnonzero(above)
        self._everywhere = bool(above.all())
        rows, columns = np.nonzero(above)
        along = rows[:, None] - rows + n - 1
        same, mirrored = columns[:, None] - columns + m - 1, columns[:, None] + columns + m

        def block(kernel: AnyArray, parity: int) -> AnyArray:
            """What a field of a parity does to the elements y > 0."""
            return np.asarray(kernel[along, same] + parity * kernel[along, mirrored])

        xx, yy, xy = kernels
        self._matrices: dict[Any, list[AnyArray]] = {np.dtype(np.float64): [
            # Rows are what acts: fields are rows of a product.
            np.block([[block(xx, even), block(xy, -even)], [block(xy, even), block(yy, -even)]]).T.copy()
            for even in (1, -1)
        ]}

    def __call__(self, pairs: AnyArray) -> AnyArray:
        safe_point()  # every step of the batched solver comes by here
        if pairs.dtype not in self._matrices:
            double = self._matrices[np.dtype(np.float64)]
            self._matrices[pairs.dtype] = [matrix.astype(pairs.dtype) for matrix in double]
        count, m = len(pairs), self._shape[1]
        above, below = self._within(pairs[..., m // 2 :]), self._within(pairs[..., : m // 2][..., ::-1])
        even, odd = above + below, above - below
        halves = []
        for parts, matrix in zip(((even, odd), (odd, even)), self._matrices[pairs.dtype], strict=True):
            part = np.empty_like(even)
            part[:, 0], part[:, 1] = parts[0][:, 0], parts[1][:, 1]
            halves.append((part.reshape(count, -1) @ matrix).reshape(part.shape))
        first, second = halves
        out = np.empty_like(pairs)
        out[..., m // 2 :] = self._spread(0.5 * (first + second))
        # Below, the parity of each component decides.
        difference = self._spread(0.5 * (first - second))[..., ::-1]
        out[:, 0, :, : m // 2] = difference[:, 0]
        np.negative(difference[:, 1], out=out[:, 1, :, : m // 2])
        return out

    def _within(self, half: AnyArray) -> AnyArray:
        """(B, 2, n, m/2) -> (B, 2, cells)"""
        flat = half.reshape(*half.shape[:2], -1)
        return flat if self._everywhere else flat[..., self._cells]

    def _spread(self, values: AnyArray) -> AnyArray:
        """(B, 2, cells) -> (B, 2, n, m/2), 0 outside."""
        n, m = self._shape
        if self._everywhere:
            return values.reshape(*values.shape[:2], n, m // 2)
        out = np.zeros((*values.shape[:2], n * (m // 2)), dtype=values.dtype)
        out[..., self._cells] = values
        return out.reshape(*values.shape[:2], n, m // 2)


class BatchGradient:
    """D A of `RollingGradient` for (B, 2, n, m) tractions, where there is `contact`. `applications` counts points, so that it
    compares with that of `RollingGradient`."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS, contact: Mask | None = None,
    ) -> None:
        n, m = shape
        tables = shear_tables(n + 2, m, dx, dy, compliance)
        along, across = np.arange(-(n - 1), n), np.arange(-(m - 1), m)

        def kernel(table: AnyArray, parity: int) -> AnyArray:
            found = np.zeros((len(along), len(across)))
            for k, w in zip(DIFFERENCE_OFFSETS, weights, strict=True):
                sign = np.sign(along + k)[:, None] * np.sign(across) if parity < 0 else 1.0
                found += w / dx * sign * table[np.abs(along + k)][:, np.abs(across)]
            return found

        self._apply = PairMatrix(shape, (kernel(tables[0], 1), kernel(tables[1], 1), kernel(tables[2], -1)), contact)
        self.applications = 0

    def __call__(self, traction: AnyArray) -> AnyArray:
        self.applications += len(traction)
        return self._apply(traction)


class BatchInverse:
    """`StickInverse` for (B, 2, n, m) gradients."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS, contact: Mask | None = None,
    ) -> None:
        n, m = shape
        px, py = padded = (even_length(n + 4), even_length(m + 4))
        periodic = (np.fft.irfft2(symbol.T, s=padded) for symbol in inverse_symbols(padded, dx, dy, compliance, weights))
        rows, columns = np.arange(-(n - 1), n) % px, np.arange(-(m - 1), m) % py
        xx, yy, xy = (table[np.ix_(rows, columns)] for table in periodic)
        self._apply = PairMatrix(shape, (xx, yy, xy), contact)

    def __call__(self, gradient: AnyArray, mask: AnyArray, starts: AnyArray) -> AnyArray:
        """As `StickInverse`; `mask` (B, 1, n, m) as numbers, `starts` (B, 1, n, m) from `begins`."""
        count, _, n, m = gradient.shape
        sums = np.zeros((count, 2, n + 1, m), dtype=gradient.dtype)
        np.cumsum(gradient, axis=2, out=sums[:, :, 1:])
        base = np.take_along_axis(sums, starts, axis=2)
        np.subtract(sums[:, :, 1:], base, out=base)
        base *= mask
        traction = self._apply(base)
        traction *= mask
        return traction


def begins(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """The row where the run of True along x begins that each element of (B, n, m) belongs to, as (B, 1, n, m)."""
    first = mask.copy()
    first[:, 1:] &= ~mask[:, :-1]
    rows = np.arange(mask.shape[1])[:, None]
    return np.asarray(np.maximum.accumulate(np.where(first, rows, 0), axis=1)[:, None])

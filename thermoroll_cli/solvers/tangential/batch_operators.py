"""The operators of the tangential solver for many tractions at once, as matrices: on grids of up to some thirty elements a
side one product of matrices is faster than many small transforms.

Kernels do not know y from −y, so tractions are split into two parts: τ_x even and τ_y odd across y = 0, and the other way
round. Each part needs half the elements, and both together half the work.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.interruption import safe_point
from thermoroll_cli.kernels.arrays import AnyArray
from thermoroll_cli.kernels.convolution import even_length
from thermoroll_cli.kernels.elastic import ShearCompliance, shear_tables
from thermoroll_cli.solvers.solver_options import UPSTREAM_WEIGHTS
from thermoroll_cli.solvers.tangential.rolling_gradient import DIFFERENCE_OFFSETS
from thermoroll_cli.solvers.tangential.stick_inverse import inverse_symbols

Kernels = tuple[AnyArray, AnyArray, AnyArray]
"""Influence at offsets −(n−1)…n−1 by −(m−1)…m−1, (2n−1, 2m−1) each: x on x, y on y, each on the other."""


class PairMatrix:
    """Three kernels applied to pairs of fields, (B, 2, n, m) -> (B, 2, n, m), in the precision of these. m is even."""

    def __init__(self, shape: tuple[int, int], kernels: Kernels) -> None:
        n, m = self._shape = shape
        if m % 2:
            raise ValueError(f"an even number of columns is needed to split them at y = 0, got {m}")
        rows = np.arange(n)[:, None] - np.arange(n) + n - 1
        upper = np.arange(m // 2)
        same = upper[:, None] - upper + m - 1
        mirrored = upper[:, None] + upper + m
        size = n * (m // 2)

        def block(kernel: AnyArray, parity: int) -> AnyArray:
            """What a field of a parity does to the elements y > 0."""
            near = kernel[rows[:, None, :, None], same[None, :, None, :]]
            far = kernel[rows[:, None, :, None], mirrored[None, :, None, :]]
            return np.asarray((near + parity * far).reshape(size, size))

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
        count, (n, m) = len(pairs), self._shape
        above, below = pairs[..., m // 2 :], pairs[..., : m // 2][..., ::-1]
        even, odd = above + below, above - below
        out = np.empty_like(pairs)
        halves = []
        for parts, matrix in zip(((even, odd), (odd, even)), self._matrices[pairs.dtype], strict=True):
            part = np.empty((count, 2, n, m // 2), dtype=pairs.dtype)
            part[:, 0], part[:, 1] = parts[0][:, 0], parts[1][:, 1]
            halves.append((part.reshape(count, -1) @ matrix).reshape(part.shape))
        first, second = halves
        total, difference = first + second, first - second
        total *= 0.5
        difference *= 0.5
        out[..., m // 2 :] = total
        # Below, the parity of each component decides.
        out[:, 0, :, : m // 2] = difference[:, 0, :, ::-1]
        np.negative(difference[:, 1, :, ::-1], out=out[:, 1, :, : m // 2])
        return out


class BatchGradient:
    """D A of `RollingGradient` for (B, 2, n, m) tractions. `applications` counts points, so that it compares with that of
    `RollingGradient`."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS,
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

        self._apply = PairMatrix(shape, (kernel(tables[0], 1), kernel(tables[1], 1), kernel(tables[2], -1)))
        self.applications = 0

    def __call__(self, traction: AnyArray) -> AnyArray:
        self.applications += len(traction)
        return self._apply(traction)


class BatchInverse:
    """`StickInverse` for (B, 2, n, m) gradients."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS,
    ) -> None:
        n, m = shape
        px, py = padded = (even_length(n + 4), even_length(m + 4))
        periodic = (np.fft.irfft2(symbol.T, s=padded) for symbol in inverse_symbols(padded, dx, dy, compliance, weights))
        rows, columns = np.arange(-(n - 1), n) % px, np.arange(-(m - 1), m) % py
        xx, yy, xy = (table[np.ix_(rows, columns)] for table in periodic)
        self._apply = PairMatrix(shape, (xx, yy, xy))

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

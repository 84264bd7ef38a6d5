"""Approximate inverse of D A on the stick area: integrate along the rolling direction, then deconvolve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.halfspace.elastic import ShearCompliance, shear_tables
from thermoroll_cli.numerics.convolution import MirroredPlane, Parities, even_length, fftw, pair_symbols
from thermoroll_cli.numerics.grid import DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS
from thermoroll_cli.rolling.rolling_gradient import Symbols, shear_symbols


def run_starts(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each element, the flat index of the first element of its run of True along x, (n, m); of row 0 before any run."""
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    n, m = mask.shape
    row = np.maximum.accumulate(np.where(begins, np.arange(n)[:, None], 0), axis=0)
    return np.asarray(row * m + np.arange(m))


def inverse_symbols(
    padded: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance, weights: tuple[float, ...]
) -> Symbols:
    """Symbols (py//2+1, px) of the inverse of D A on a periodic plane, after a running sum along x."""
    px, py = padded
    if compliance.coatings is None:
        tables = shear_tables(px // 2 + 1, py // 2 + 1, dx, dy, compliance)
        xx, yy, xy = shear_symbols(tables, padded)
    else:
        _, xx, yy, xy = compliance.coatings.periodic_symbols(padded, dx, dy)
        xx, yy = xx + compliance.layer, yy + compliance.layer
    theta = 2.0 * np.pi * np.fft.fftfreq(px)
    step = -np.expm1(-1j * theta)
    difference = sum(w * np.exp(1j * k * theta) for k, w in zip(DIFFERENCE_OFFSETS, weights, strict=True))
    ratio = np.ones(px, dtype=np.complex128)
    ratio[1:] = difference[1:] / step[1:]
    # The step of the running sum belongs to the symbol.
    determinant = (xx * yy - xy**2) * ratio / dx
    return yy / determinant, xx / determinant, -xy / determinant


class StickInverse:
    """(D A)⁻¹ on stick runs, periodic over the bounding box: D⁻¹ is a running sum down each row from the start of its
    run, A⁻¹ a 2×2 matrix per wavenumber. The difference between D and a first difference is part of the symbol.

    Without D⁻¹ modes that vary slowly along x and fast along y are almost singular and the work grows with N. `mirror` as in
    `RollingGradient`."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance, mirror: Parities | None = None,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS,
    ) -> None:
        self.shape = shape
        n, m = shape
        # A few elements of padding: the wrap-around of a preconditioner does not affect the accuracy of the solution.
        px, py = (even_length(k + 4) for k in (n, m if mirror is None else 2 * m))
        inverse = inverse_symbols((px, py), dx, dy, compliance, weights)
        self._solve: _FreePeriodic | _MirroredPeriodic
        if mirror is None:
            self._solve = _FreePeriodic(shape, (px, py), inverse)
        else:
            self._solve = _MirroredPeriodic(shape, (px, py), inverse, mirror)
        self._sums = np.zeros((2, n + 1, m))
        self._base = np.empty((2, n, m))

    def __call__(self, gradient: AnyArray, mask: NDArray[np.bool_], starts: NDArray[np.intp]) -> AnyArray:
        """Traction (2, n, m) whose D A is approximately `gradient` on the stick elements `mask`; zero elsewhere.

        `gradient` is zero outside `mask`, `starts` is `run_starts(mask)`."""
        # Row k holds the sum of the rows above it: subtracting the row where the run began restarts the sum there.
        sums, base = self._sums, self._base
        np.cumsum(gradient, axis=1, out=sums[:, 1:])
        for i in range(2):
            # Any mode but "raise" writes into `out` directly.
            np.take(sums[i], starts, out=base[i], mode="clip")
        np.subtract(sums[:, 1:], base, out=base)
        base *= mask
        traction = self._solve(base)
        traction *= mask
        return traction


class _FreePeriodic:
    """2 × 2 symbol, (py//2+1, px) each, applied to pairs of fields on a periodic plane."""

    def __init__(self, shape: tuple[int, int], padded: tuple[int, int], symbol: Symbols) -> None:
        pyfftw = fftw()

        self._shape = shape
        px, py = padded
        # The scale of the transforms belongs to the symbol.
        self._symbol = tuple(np.ascontiguousarray((s / (px * py)).T, dtype=np.complex128) for s in symbol)
        self._fields = pyfftw.zeros_aligned((2, px, py))
        self._hats = pyfftw.zeros_aligned((2, px, py // 2 + 1), dtype=np.complex128)
        self._products = np.empty_like(self._hats)
        flags = ("FFTW_ESTIMATE",)
        self._forward = pyfftw.FFTW(self._fields, self._hats, axes=(1, 2), flags=flags)
        self._backward = pyfftw.FFTW(self._hats, self._fields, axes=(1, 2), direction="FFTW_BACKWARD",
                                     flags=(*flags, "FFTW_DESTROY_INPUT"))

    def __call__(self, pair: AnyArray) -> AnyArray:
        n, m = self._shape
        fields = self._fields
        fields[:, n:, :] = 0.0
        fields[:, :n, m:] = 0.0
        fields[:, :n, :m] = pair
        self._forward.execute()
        (x, y), (new_x, term) = self._hats, self._products
        xx, yy, xy = self._symbol
        np.multiply(xx, x, out=new_x)
        new_x += np.multiply(xy, y, out=term)
        y *= yy
        y += np.multiply(xy, x, out=term)
        x[...] = new_x
        self._backward.execute()
        return fields[:, :n, :m].copy()


class _MirroredPeriodic:
    """As `_FreePeriodic` for pairs of opposite parity, given on one half."""

    def __init__(self, shape: tuple[int, int], padded: tuple[int, int], symbol: Symbols, mirror: Parities) -> None:
        even = mirror.index(1)
        self._plane = MirroredPlane(*shape, padded, even)
        self._own, self._other = (s.astype(np.complex128) for s in pair_symbols(*symbol, even))

    def __call__(self, pair: AnyArray) -> AnyArray:
        self._plane.forward(pair)
        self._plane.apply(self._own, self._other)
        return self._plane.inverse()

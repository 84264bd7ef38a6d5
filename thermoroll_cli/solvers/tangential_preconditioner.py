"""Approximate inverse of D A on the stick area: integrate along the rolling direction, then deconvolve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import periodic_symbol
from thermoroll_cli.kernels.elastic import ShearCompliance, shear_tables
from thermoroll_cli.kernels.fftw import fftw
from thermoroll_cli.solvers.tangential_operator import DIFFERENCE_OFFSETS, DIFFERENCE_WEIGHTS

Array = NDArray[np.float64]


def run_starts(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each element, the flat index of the first element of its run of True along x, (n, m); of row 0 before any run."""
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    n, m = mask.shape
    row = np.maximum.accumulate(np.where(begins, np.arange(n)[:, None], 0), axis=0)
    return np.asarray(row * m + np.arange(m))


class StickInverse:
    """(D A)⁻¹ on stick runs, periodic over the bounding box: D⁻¹ is a running sum down each row from the start of its
    run, A⁻¹ a 2×2 matrix per wavenumber. What D is more than a first difference is folded into the symbol.

    Without D⁻¹ modes that vary slowly along x and fast along y are almost singular and the work grows with N."""

    def __init__(self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance) -> None:
        pyfftw = fftw()

        self.shape = shape
        # A few elements of padding: the wrap-around of a preconditioner costs accuracy of nothing.
        px, py = (pyfftw.next_fast_len(k + 4) for k in shape)
        self.padded = px, py
        tables = shear_tables(px // 2 + 1, py // 2 + 1, dx, dy, compliance)
        xx, yy, xy = (periodic_symbol(t, (px, py), parity) for t, parity in zip(tables, (1, 1, -1), strict=True))
        theta = 2.0 * np.pi * np.fft.fftfreq(px)
        step = -np.expm1(-1j * theta)
        difference = sum(w * np.exp(1j * k * theta) for k, w in zip(DIFFERENCE_OFFSETS, DIFFERENCE_WEIGHTS, strict=True))
        ratio = np.ones(px, dtype=np.complex128)
        ratio[1:] = difference[1:] / step[1:]
        determinant = (xx * yy - xy**2) * ratio[:, None]
        # The step of the running sum and the scale of the transforms belong to the symbol.
        determinant *= px * py / dx
        self._inverse = (yy / determinant, xx / determinant, -xy / determinant)
        self._sums = np.zeros((2, shape[0] + 1, shape[1]))
        self._base = np.empty(shape)
        self._plan(px, py)

    def _plan(self, px: int, py: int) -> None:
        pyfftw = fftw()

        self._fields = pyfftw.zeros_aligned((2, px, py))
        self._hats = pyfftw.zeros_aligned((2, px, py // 2 + 1), dtype=np.complex128)
        self._products = np.empty_like(self._hats)
        flags = ("FFTW_ESTIMATE",)
        self._forward = pyfftw.FFTW(self._fields, self._hats, axes=(1, 2), flags=flags)
        self._backward = pyfftw.FFTW(self._hats, self._fields, axes=(1, 2), direction="FFTW_BACKWARD",
                                     flags=(*flags, "FFTW_DESTROY_INPUT"))

    def __call__(self, gradient: Array, mask: NDArray[np.bool_], starts: NDArray[np.intp]) -> Array:
        """Traction (2, n, m) whose D A is about `gradient` on the stick elements `mask`; zero elsewhere.

        `gradient` is zero outside `mask`, `starts` is `run_starts(mask)`."""
        n, m = self.shape
        # Row k holds the sum of the rows above it, so that taking the row where the run began restarts the sum there.
        np.cumsum(gradient, axis=1, out=self._sums[:, 1:])
        fields, sums = self._fields, self._sums
        fields[:, n:, :] = 0.0
        fields[:, :n, m:] = 0.0
        for i in range(2):
            np.take(sums[i], starts, out=self._base)
            np.subtract(sums[i, 1:], self._base, out=self._base)
            np.multiply(self._base, mask, out=fields[i, :n, :m])
        self._forward.execute()
        (x, y), (new_x, term) = self._hats, self._products
        xx, yy, xy = self._inverse
        np.multiply(xx, x, out=new_x)
        new_x += np.multiply(xy, y, out=term)
        y *= yy
        y += np.multiply(xy, x, out=term)
        x[...] = new_x
        self._backward.execute()
        return np.asarray(fields[:, :n, :m] * mask)

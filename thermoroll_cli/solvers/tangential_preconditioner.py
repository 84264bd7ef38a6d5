"""Approximate inverse of D A on the stick area: integrate along the rolling direction, then deconvolve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import periodic_symbol
from thermoroll_cli.kernels.elastic import ShearCompliance, shear_tables
from thermoroll_cli.solvers.tangential_operator import DIFFERENCE_OFFSETS, DIFFERENCE_WEIGHTS

Array = NDArray[np.float64]


def run_starts(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each element, the row where its run of True along x began: (n, m) -> (n, m); 0 before the first run."""
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    return np.maximum.accumulate(np.where(begins, np.arange(len(mask))[:, None], 0), axis=0)


class StickInverse:
    """(D A)⁻¹ on stick runs, periodic over the bounding box: D⁻¹ is a running sum down each row from the start of its
    run, A⁻¹ a 2×2 matrix per wavenumber. What D is more than a first difference is folded into the symbol.

    Without D⁻¹ modes that vary slowly along x and fast along y are almost singular and the work grows with N."""

    def __init__(self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance) -> None:
        import pyfftw

        self.shape, self.dx = shape, dx
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
        self._inverse = (yy / determinant, xx / determinant, -xy / determinant)
        self._plan(px, py)

    def _plan(self, px: int, py: int) -> None:
        import pyfftw

        self._fields = pyfftw.zeros_aligned((2, px, py))
        self._hats = pyfftw.zeros_aligned((2, px, py // 2 + 1), dtype=np.complex128)
        flags = ("FFTW_ESTIMATE",)
        self._forward = pyfftw.FFTW(self._fields, self._hats, axes=(1, 2), flags=flags)
        self._backward = pyfftw.FFTW(self._hats, self._fields, axes=(1, 2), direction="FFTW_BACKWARD",
                                     flags=(*flags, "FFTW_DESTROY_INPUT"))

    def __call__(self, gradient: Array, mask: NDArray[np.bool_], starts: NDArray[np.intp]) -> Array:
        """Traction (2, n, m) whose D A is about `gradient` on the stick elements `mask`; zero elsewhere."""
        n, m = self.shape
        px, py = self.padded
        fields = self._fields
        fields[:, n:, :] = 0.0
        fields[:, :n, m:] = 0.0
        for i in range(2):
            masked = gradient[i] * mask
            total = np.cumsum(masked, axis=0)
            before = total - masked
            total -= np.take_along_axis(before, starts, axis=0)
            total *= mask
            fields[i, :n, :m] = total
        self._forward.execute()
        x, y = self._hats
        a, b, c = self._inverse
        new_x = a * x
        new_x += c * y
        y *= b
        x *= c
        y += x
        x[...] = new_x
        self._backward.execute()
        return self._fields[:, :n, :m] * (mask * (self.dx / (px * py)))



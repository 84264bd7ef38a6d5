"""Free-space discrete convolution by FFT (DC-FFT, Liu et al. 2000) with the passes over zeros left out.

A field of nx × ny elements is convolved with an influence table without wrap-around images. Only rows that hold
the field are transformed along y, and only rows that are asked for are transformed back: about two thirds of the
plain padded transform. Plans use FFTW_ESTIMATE, so results repeat bit by bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.fftw import fftw

Array = NDArray[np.float64]
Spectrum = NDArray[Any]


class Convolution:
    """Plans and buffers for convolving fields of shape (nx, ny) onto rows −before … nx−1+after.

    `transforms` counts the padded two-dimensional transforms done so far, the budget in which cost is measured.
    """

    def __init__(self, nx: int, ny: int, before: int = 0, after: int = 0) -> None:
        pyfftw = fftw()

        self.nx, self.ny, self.before, self.after = nx, ny, before, after
        self.rows = nx + before + after
        self.px = pyfftw.next_fast_len(2 * (nx + max(before, after)) - 1)
        self.py = pyfftw.next_fast_len(2 * ny - 1)
        self.half = self.py // 2 + 1
        self.transforms = 0
        n = max(self.nx, self.rows)
        self._line = pyfftw.zeros_aligned((n, self.py))
        self._line_hat = pyfftw.zeros_aligned((n, self.half), dtype=np.complex128)
        self._plane = pyfftw.zeros_aligned((self.half, self.px), dtype=np.complex128)
        flags = ("FFTW_ESTIMATE",)

        def plan(a: Any, b: Any, direction: str) -> Any:
            return pyfftw.FFTW(a, b, axes=(1,), direction=direction, flags=flags)

        self._forward_y = plan(self._line[:nx], self._line_hat[:nx], "FFTW_FORWARD")
        self._forward_x = plan(self._plane, self._plane, "FFTW_FORWARD")
        self._inverse_x = plan(self._plane, self._plane, "FFTW_BACKWARD")
        self._inverse_y = plan(self._line_hat[: self.rows], self._line[: self.rows], "FFTW_BACKWARD")
        self._scale = 1.0 / (self.px * self.py)

    def forward(self, field: Array, out: Spectrum | None = None) -> Spectrum:
        """Transform of a zero-padded field (nx, ny) -> (py//2+1, px): the layout of all spectra here."""
        self._line[: self.nx, : self.ny] = field
        self._line[: self.nx, self.ny :] = 0.0
        self._forward_y.execute()
        self._plane[:, : self.nx] = self._line_hat[: self.nx].T
        self._plane[:, self.nx :] = 0.0
        self._forward_x.execute()
        self.transforms += 1
        if out is None:
            return self._plane.copy()
        out[...] = self._plane
        return out

    @property
    def plane(self) -> Spectrum:
        """The buffer that `inverse` works in: a spectrum built here is not copied."""
        return self._plane

    def inverse(self, spectrum: Spectrum, out: Array | None = None) -> Array:
        """Rows −before … nx−1+after of the convolution whose spectrum is given, shape (rows, ny), into `out` if given."""
        if spectrum is not self._plane:
            self._plane[...] = spectrum
        self._inverse_x.execute()
        # Negative offsets sit at the end of the periodic row.
        b = self.before
        self._line_hat[b : self.rows] = self._plane[:, : self.rows - b].T
        if b:
            self._line_hat[:b] = self._plane[:, -b:].T
        self._inverse_y.execute()
        self.transforms += 1
        return np.multiply(self._line[: self.rows, : self.ny], self._scale, out=out)

    def _spectrum_of_padded(self, padded: Array) -> Spectrum:
        from scipy.fft import fft, rfft

        return fft(np.ascontiguousarray(rfft(padded, axis=1).T), axis=1)

    def spectrum(self, table: Array) -> Spectrum:
        """Spectrum of a kernel given at offsets −(nx−1)…nx−1 by −(ny−1)…ny−1, shape (2nx−1, 2ny−1).

        Raises ValueError where the convolution was planned with extra rows, which such a table does not reach."""
        nx, ny = self.nx, self.ny
        if self.before or self.after or table.shape != (2 * nx - 1, 2 * ny - 1):
            raise ValueError(f"a table of shape {(2 * nx - 1, 2 * ny - 1)} is needed, got {table.shape}")
        padded = np.zeros((self.px, self.py))
        ix = np.arange(-(nx - 1), nx)
        iy = np.arange(-(ny - 1), ny)
        padded[np.ix_(ix, iy)] = table
        return self._spectrum_of_padded(padded)

    def quadrant_spectrum(self, quadrant: Array, parity: int = 1) -> Array:
        """Real spectrum of a kernel that is even (`parity` 1) or odd (−1) in both offsets, given for offsets ≥ 0.

        `quadrant` has shape (≥ reach_x, ny) with reach_x = nx + max(before, after). Each value is stored twice, beside
        itself, so that it multiplies a complex spectrum viewed as floats: NumPy would otherwise convert it every time.
        """
        reach = self.nx + max(self.before, self.after)
        quadrant = quadrant[:reach, : self.ny]
        padded = np.zeros((self.px, self.py))
        mx, my = quadrant.shape
        padded[:mx, :my] = quadrant
        padded[:mx, self.py - my + 1 :] = parity * quadrant[:, :0:-1]
        padded[self.px - mx + 1 :, :my] = parity * quadrant[:0:-1]
        padded[self.px - mx + 1 :, self.py - my + 1 :] = quadrant[:0:-1, :0:-1]
        return np.repeat(self._spectrum_of_padded(padded).real, 2, axis=1)


def multiply(spectrum: Spectrum, real_pairs: Array, out: Spectrum) -> Spectrum:
    """`out` = complex spectrum times a real one stored in pairs (see `quadrant_spectrum`)."""
    np.multiply(spectrum.view(np.float64), real_pairs, out=out.view(np.float64))
    return out


def periodic_symbol(quadrant: Array, padded: tuple[int, int], parity: int = 1) -> Array:
    """Real symbol, (px, py//2+1), of a kernel wrapped around a period of `padded` = (px, py) elements.

    `quadrant` holds offsets ≥ 0, shape (≥ px//2+1, ≥ py//2+1), of a kernel even (`parity` 1) or odd (−1) in both. For
    preconditioners: the wrap-around costs them nothing that matters."""
    px, py = padded
    i, j = np.arange(px), np.arange(py)
    full = quadrant[np.ix_(np.minimum(i, px - i), np.minimum(j, py - j))]
    if parity < 0:
        # An odd kernel vanishes where its two images meet.
        full = full * (np.sign(px - 2 * i) * (i > 0))[:, None] * (np.sign(py - 2 * j) * (j > 0))[None, :]
    return np.fft.rfft2(full).real

"""Two-dimensional transforms of padded fields with the passes over zeros left out: the plans and buffers of one plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray, Spectrum
from thermoroll_cli.interruption import safe_point
from thermoroll_cli.numerics.fftw import complex_type, fftw


class PaddedPlane:
    """Transforms of real fields that occupy `nx` rows of a periodic plane of (px, py) = `padded` elements.

    A field is written into `field`, (nx, py), whose other elements stay zero; `forward` makes its spectrum, (py//2+1, px).
    `inverse` brings back rows −before … of a spectrum into `line`, (rows, py), px·py times too large. `transforms` counts
    both. Plans use FFTW_ESTIMATE, so results repeat bit by bit."""

    def __init__(self, nx: int, rows: int, before: int, padded: tuple[int, int], precision: Any) -> None:
        pyfftw = fftw()

        self._nx, self._rows, self._before = nx, rows, before
        px, py = padded
        self.half = py // 2 + 1
        self.transforms = 0
        self._shape = (self.half, px)
        self._kind = complex_type(precision)
        # What is read and what is written are kept apart: the zeros around a field are then written once.
        self.field = pyfftw.zeros_aligned((nx, py), dtype=precision)
        self.line = pyfftw.empty_aligned((rows, py), dtype=precision)
        self._line_hat = pyfftw.zeros_aligned((max(nx, rows), self.half), dtype=self._kind)
        self._columns = pyfftw.zeros_aligned(self._shape, dtype=self._kind)
        self.spectrum = self.empty_spectrum()
        self._back = self.empty_spectrum()

        def plan(a: Any, b: Any, direction: str) -> Any:
            return pyfftw.FFTW(a, b, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",))

        self._forward_y = plan(self.field, self._line_hat[:nx], "FFTW_FORWARD")
        self._forward_x = plan(self._columns, self.spectrum, "FFTW_FORWARD")
        self._inverse_x = plan(self.spectrum, self._back, "FFTW_BACKWARD")
        self._inverse_y = plan(self._line_hat[:rows], self.line, "FFTW_BACKWARD")

    def empty_spectrum(self) -> Spectrum:
        """An array for a spectrum that transforms can read and write directly."""
        return fftw().empty_aligned(self._shape, dtype=self._kind)

    def forward(self, out: Spectrum, phase: AnyArray | None = None) -> None:
        """Spectrum of what is in `field` into `out`, each wavenumber along y times `phase` (py//2+1) if given."""
        safe_point()  # every step of every solver comes by here
        hat = self._line_hat[: self._nx]
        self._forward_y.execute()
        if phase is not None:
            np.multiply(hat, phase, out=hat)
        self._columns[:, : self._nx] = hat.T
        plan = self._forward_x
        direct = fftw().is_byte_aligned(out, plan.output_alignment)
        plan.update_arrays(self._columns, out if direct else self.spectrum)
        plan.execute()
        self.transforms += 1
        if not direct:
            out[...] = self.spectrum

    def inverse(self, spectrum: Spectrum, phase: AnyArray | None = None) -> None:
        """Rows of what has the given spectrum into `line`; `phase` as in `forward`."""
        plan = self._inverse_x
        if not fftw().is_byte_aligned(spectrum, plan.input_alignment):
            self.spectrum[...] = spectrum
            spectrum = self.spectrum
        plan.update_arrays(spectrum, self._back)
        plan.execute()
        # Negative offsets sit at the end of the periodic row.
        b, hat = self._before, self._line_hat[: self._rows]
        hat[b:] = self._back[:, : self._rows - b].T
        if b:
            hat[:b] = self._back[:, -b:].T
        if phase is not None:
            np.multiply(hat, phase, out=hat)
        self._inverse_y.execute()
        self.transforms += 1

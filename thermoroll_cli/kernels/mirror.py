"""Pairs of fields of which one is even and one odd across y = 0, transformed together from half the elements.

The sum of both, a single real field, carries all there is: centred on the mirror line, the real part of its transform along
y is the even field's, the imaginary part the odd one's. One transform does the work of two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import blocks
from thermoroll_cli.kernels.fftw import complex_type, fftw

Array = NDArray[Any]
Parities = tuple[int, int]
"""1 (even) or −1 (odd across y = 0) of the x and the y component of a vector field; one each."""


class MirroredPlane:
    """Plans and buffers for pairs of fields (2, nx, ny) on the elements y > 0, in a plane of px × py elements.

    The plane is periodic: with px ≥ 2·(nx + extra rows) − 1 and py ≥ 4·ny − 1 convolutions are those of free space. `rows`
    are brought back, the first `before` of them from before the first. `transforms` counts padded transforms."""

    def __init__(
        self, nx: int, ny: int, padded: tuple[int, int], even: int, rows: int | None = None, before: int = 0,
        precision: Any = np.float64,
    ) -> None:
        pyfftw = fftw()

        self.nx, self.ny, self.before = nx, ny, before
        self.rows = nx if rows is None else rows
        self.px, self.py = padded
        self.transforms = 0
        self._even = even
        half = self.py // 2 + 1
        n = max(nx, self.rows)
        kind = complex_type(precision)
        # What is read and what is written are kept apart: the zeros around a field are then written once.
        self._field = pyfftw.zeros_aligned((nx, self.py), dtype=precision)
        self._line = pyfftw.empty_aligned((self.rows, self.py), dtype=precision)
        self._line_hat = pyfftw.zeros_aligned((n, half), dtype=kind)
        self._columns = pyfftw.zeros_aligned((half, self.px), dtype=kind)
        self._plane = pyfftw.empty_aligned((half, self.px), dtype=kind)
        self._back = pyfftw.empty_aligned((half, self.px), dtype=kind)
        self._blocks = blocks(half, self.px)
        self._mirrored = np.empty_like(self._plane[self._blocks[0]])
        self._word = {8: np.int64, 16: np.complex128}[self._plane.itemsize]
        # Elements lie half a step beside the mirror line.
        centre = np.exp(-1j * np.pi * np.arange(half) / self.py)
        self._to_centre = centre.astype(kind)
        self._from_centre = (centre.conj() / (2.0 * self.px * self.py)).astype(kind)

        def plan(a: Any, b: Any, direction: str) -> Any:
            return pyfftw.FFTW(a, b, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",))

        self._forward_y = plan(self._field, self._line_hat[:nx], "FFTW_FORWARD")
        self._forward_x = plan(self._columns, self._plane, "FFTW_FORWARD")
        self._inverse_x = plan(self._plane, self._back, "FFTW_BACKWARD")
        self._inverse_y = plan(self._line_hat[: self.rows], self._line, "FFTW_BACKWARD")

    def forward(self, pair: Array) -> Array:
        """Spectrum (py//2+1, px) of a pair (2, nx, ny), in the buffer that `apply` and `inverse` work in."""
        even, odd = pair[self._even], pair[1 - self._even]
        ny, hat = self.ny, self._line_hat[: self.nx]
        np.add(even, odd, out=self._field[:, :ny])
        np.subtract(even, odd, out=self._field[:, : -ny - 1 : -1])
        self._forward_y.execute()
        np.multiply(hat, self._to_centre, out=hat)
        self._columns[:, : self.nx] = hat.T
        self._forward_x.execute()
        self.transforms += 1
        return self._plane

    def apply(self, own: Array, other: Array | None) -> None:
        """Multiply the spectrum in the buffer with a 2 × 2 symbol (see `pair_symbols`), both parts complex, (py//2+1, px),
        or both real with every value twice, (py//2+1, 2·px)."""
        plane, mirrored = self._plane, self._mirrored
        kind = own.dtype
        for rows in self._blocks:
            part = plane[rows]
            if other is None:
                np.multiply(part.view(kind), own[rows], out=part.view(kind))
                continue
            reflected = mirrored[: len(part)]
            # As whole numbers of the same size, which are copied backwards much faster.
            source, target = part.view(self._word), reflected.view(self._word)
            target[:, 1:] = source[:, :0:-1]
            target[:, 0] = source[:, 0]
            np.conjugate(reflected, out=reflected)
            np.multiply(reflected.view(kind), other[rows], out=reflected.view(kind))
            np.multiply(part.view(kind), own[rows], out=part.view(kind))
            part += reflected

    def inverse(self, out: Array | None = None) -> Array:
        """Rows −before … of the pair whose spectrum is in the buffer: (2, rows, ny)."""
        rows, ny, b, hat = self.rows, self.ny, self.before, self._line_hat[: self.rows]
        if out is None:
            out = np.empty((2, rows, ny), dtype=self._line.dtype)
        self._inverse_x.execute()
        # Negative offsets sit at the end of the periodic row.
        hat[b:] = self._back[:, : rows - b].T
        if b:
            hat[:b] = self._back[:, -b:].T
        np.multiply(hat, self._from_centre, out=hat)
        self._inverse_y.execute()
        self.transforms += 1
        above, below = self._line[:, :ny], self._line[:, : -ny - 1 : -1]
        np.add(above, below, out=out[self._even])
        np.subtract(above, below, out=out[1 - self._even])
        return out


def pair_symbols(xx: Array, yy: Array, xy: Array, even: int) -> tuple[Array, Array]:
    """What a 2 × 2 symbol (xx, xy; xy, yy), even and odd along y, makes of a packed pair: the factor of its spectrum, and that
    of the spectrum of its mirror image. `even` is the index of the even component."""
    difference = 0.5 * (xx - yy)
    return 0.5 * (xx + yy) + xy, difference if even == 0 else -difference


def unfolded(field: Array, parity: int) -> Array:
    """(..., nx, ny) on y > 0 -> (..., nx, 2 ny) on both sides, even (`parity` 1) or odd (−1)."""
    return np.concatenate([parity * field[..., ::-1], field], axis=-1)

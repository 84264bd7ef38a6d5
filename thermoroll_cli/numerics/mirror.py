"""Pairs of fields of which one is even and one odd across y = 0, transformed together from half the elements.

The sum of both is a single real field that contains both: centred on the mirror line, the real part of its transform along
y belongs to the even field, the imaginary part to the odd one. One transform does the work of two.
"""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.numerics.convolution import PaddedPlane, blocks

Parities = tuple[int, int]
"""Parity across y = 0 of the x and the y component of a vector field, 1 (even) or −1 (odd); one of each."""


class MirroredPlane:
    """Plans and buffers for pairs of fields (2, nx, ny) on the elements y > 0, in a plane of px × py elements.

    The plane is periodic: with px ≥ 2·(nx + extra rows) − 1 and py ≥ 4·ny − 1 convolutions are those of free space. `rows`
    are transformed back, the first `before` of them upstream of the fields. `transforms` counts padded transforms."""

    def __init__(
        self, nx: int, ny: int, padded: tuple[int, int], even: int, rows: int | None = None, before: int = 0
    ) -> None:
        self._ny, self._even = ny, even
        px, py = padded
        self._padded = PaddedPlane(nx, nx if rows is None else rows, before, padded)
        plane = self._padded.spectrum
        self._blocks = blocks(*plane.shape)
        self._mirrored = np.empty_like(plane[self._blocks[0]])
        # Elements lie half a step beside the mirror line.
        centre = np.exp(-1j * np.pi * np.arange(self._padded.half) / py)
        self._to_centre = centre
        self._from_centre = centre.conj() / (2.0 * px * py)

    @property
    def transforms(self) -> int:
        return self._padded.transforms

    def forward(self, pair: AnyArray) -> None:
        """Spectrum (py//2+1, px) of a pair (2, nx, ny), into the buffer that `apply` and `inverse` work in."""
        even, odd, field = pair[self._even], pair[1 - self._even], self._padded.field
        np.add(even, odd, out=field[:, : self._ny])
        np.subtract(even, odd, out=field[:, : -self._ny - 1 : -1])
        self._padded.forward(self._padded.spectrum, self._to_centre)

    def apply(self, own: AnyArray, other: AnyArray | None) -> None:
        """Multiply the spectrum in the buffer with a 2 × 2 symbol (see `pair_symbols`), both parts complex, (py//2+1, px),
        or both real with every value twice, (py//2+1, 2·px)."""
        plane, mirrored = self._padded.spectrum, self._mirrored
        kind = own.dtype
        for rows in self._blocks:
            part = plane[rows]
            if other is None:
                np.multiply(part.view(kind), own[rows], out=part.view(kind))
                continue
            reflected = mirrored[: len(part)]
            reflected[:, 1:] = part[:, :0:-1]
            reflected[:, 0] = part[:, 0]
            np.conjugate(reflected, out=reflected)
            np.multiply(reflected.view(kind), other[rows], out=reflected.view(kind))
            np.multiply(part.view(kind), own[rows], out=part.view(kind))
            part += reflected

    def inverse(self) -> AnyArray:
        """Rows −before … of the pair whose spectrum is in the buffer: (2, rows, ny)."""
        self._padded.inverse(self._padded.spectrum, self._from_centre)
        line = self._padded.line
        above, below = line[:, : self._ny], line[:, : -self._ny - 1 : -1]
        out = np.empty((2, *above.shape), dtype=line.dtype)
        np.add(above, below, out=out[self._even])
        np.subtract(above, below, out=out[1 - self._even])
        return out


def pair_symbols(xx: AnyArray, yy: AnyArray, xy: AnyArray, even: int) -> tuple[AnyArray, AnyArray]:
    """A 2 × 2 symbol (xx, xy; xy, yy), even and odd along y, as it acts on a packed pair: the factors of the pair's spectrum
    and of the spectrum of its mirror image. `even` is the index of the even component."""
    difference = 0.5 * (xx - yy)
    return 0.5 * (xx + yy) + xy, difference if even == 0 else -difference


def unfolded(field: AnyArray, parity: int) -> AnyArray:
    """(..., nx, ny) on y > 0 -> (..., nx, 2 ny) on both sides, even (`parity` 1) or odd (−1)."""
    below = field[..., ::-1]
    return np.concatenate([below if parity > 0 else -below, field], axis=-1)

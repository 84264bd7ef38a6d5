"""Free-space discrete convolution by FFT (DC-FFT, Liu et al. 2000) with the passes over zeros left out.

A field of nx × ny elements is convolved with an influence table without wrap-around images. Only rows that hold
the field are transformed along y, and only rows that are asked for are transformed back: about two thirds of the
plain padded transform. Plans use FFTW_ESTIMATE, so results repeat bit by bit.

Pairs of fields of which one is even and one odd across y = 0 are transformed together from half the elements
(`MirroredPlane`). Their sum is a single real field that contains both: centred on the mirror line, the real part of its
transform along y belongs to the even field, the imaginary part to the odd one. One transform does the work of two.
"""

from __future__ import annotations

import sys
import threading
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.fft import fft, rfft

from thermoroll_cli.tools.arrays import AnyArray, Array, Spectrum
from thermoroll_cli.tools.process import safe_point


@cache
def fftw() -> ModuleType:
    """The module pyfftw. Its interfaces to Dask and SciPy are left out: where these are installed they cost 0.5 s of start-up
    (pandas included), more than most solves."""
    # A module name set to None makes `import` fail, which pyfftw handles.
    unwanted = ["dask", "scipy.fftpack" if "scipy" in sys.modules else "scipy"]
    hidden = [name for name in unwanted if name not in sys.modules and "pyfftw" not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        import pyfftw
    finally:
        for name in hidden:
            del sys.modules[name]
    return pyfftw


class _Counted(threading.local):
    transforms = 0


counted = _Counted()
"""`counted.transforms`: two-dimensional transforms this thread has done in free space, the budget in which cost is measured.
Those on the smaller planes of preconditioners do not count."""


class PaddedPlane:
    """Transforms of real fields that occupy `nx` rows of a periodic plane of (px, py) = `padded` elements.

    The caller writes a field into `field`, (nx, py), whose other elements stay zero; `forward` computes its spectrum,
    (py//2+1, px). `inverse` transforms a spectrum back and writes the rows from −`before` on into `line`, (rows, py), without
    the factor 1/(px·py). Plans use FFTW_ESTIMATE, so results repeat bit by bit."""

    def __init__(self, nx: int, rows: int, before: int, padded: tuple[int, int]) -> None:
        pyfftw = fftw()

        self._nx, self._rows, self._before = nx, rows, before
        px, py = padded
        self.half = py // 2 + 1
        self._counts = px >= 2 * nx - 1
        self._shape = (self.half, px)
        # Input and output have buffers of their own: the zeros around a field are then written once.
        self.field = pyfftw.zeros_aligned((nx, py))
        self.line = pyfftw.empty_aligned((rows, py))
        self._line_hat = pyfftw.zeros_aligned((max(nx, rows), self.half), dtype=np.complex128)
        self._columns = pyfftw.zeros_aligned(self._shape, dtype=np.complex128)
        self.spectrum = self.empty_spectrum()
        self._back = self.empty_spectrum()

        def plan(a: Any, b: Any, direction: str) -> Any:
            return pyfftw.FFTW(a, b, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",))

        self._forward_x = plan(self._columns, self.spectrum, "FFTW_FORWARD")
        self._inverse_x = plan(self.spectrum, self._back, "FFTW_BACKWARD")
        self._across = py > 1
        if self._across:
            self._forward_y = plan(self.field, self._line_hat[:nx], "FFTW_FORWARD")
            self._inverse_y = plan(self._line_hat[:rows], self.line, "FFTW_BACKWARD")

    def empty_spectrum(self) -> Spectrum:
        """An array for a spectrum that transforms can read and write directly."""
        return fftw().empty_aligned(self._shape, dtype=np.complex128)

    def forward(self, out: Spectrum, phase: AnyArray | None = None) -> None:
        """Write the spectrum of `field` into `out`, each wavenumber along y times `phase` (py//2+1) if given."""
        safe_point()  # every step of every solver passes here
        hat = self._line_hat[: self._nx] if self._across else self.field
        if self._across:
            self._forward_y.execute()
        if phase is not None:
            np.multiply(hat, phase, out=hat)
        self._columns[:, : self._nx] = hat.T
        plan = self._forward_x
        direct = fftw().is_byte_aligned(out, plan.output_alignment)
        plan.update_arrays(self._columns, out if direct else self.spectrum)
        plan.execute()
        counted.transforms += self._counts
        if not direct:
            out[...] = self.spectrum

    def inverse(self, spectrum: Spectrum, phase: AnyArray | None = None) -> None:
        """Write the rows of the field with the given spectrum into `line`; `phase` as in `forward`."""
        plan = self._inverse_x
        if not fftw().is_byte_aligned(spectrum, plan.input_alignment):
            self.spectrum[...] = spectrum
            spectrum = self.spectrum
        plan.update_arrays(spectrum, self._back)
        plan.execute()
        # Negative offsets sit at the end of the periodic row.
        b, back = self._before, self._back if self._across else self._back.real
        hat = self._line_hat[: self._rows] if self._across else self.line
        hat[b:] = back[:, : self._rows - b].T
        if b:
            hat[:b] = back[:, -b:].T
        if phase is not None:
            np.multiply(hat, phase, out=hat)
        if self._across:
            self._inverse_y.execute()
        counted.transforms += self._counts


class Convolution:
    """Plans and buffers for convolving fields of shape (nx, ny) onto rows −before … nx−1+after, in free space or periodically
    on a plane of `padded` elements."""

    def __init__(
        self, nx: int, ny: int, before: int = 0, after: int = 0, padded: tuple[int, int] | None = None
    ) -> None:
        self.nx, self.ny, self.before, self.after = nx, ny, before, after
        self.px, self.py = padded or free_space(nx + max(before, after), ny)
        self._padded = PaddedPlane(nx, nx + before + after, before, (self.px, self.py))
        self.half = self._padded.half
        self._scale = 1.0 / (self.px * self.py)

    def forward(self, field: Array, out: Spectrum | None = None) -> Spectrum:
        """Transform of a zero-padded field (nx, ny) -> (py//2+1, px): the layout of all spectra here.

        Transforms straight into `out` where that comes from `empty_spectrum`."""
        if out is None:
            out = self.empty_spectrum()
        self._padded.field[:, : self.ny] = field
        self._padded.forward(out)
        return out

    def empty_spectrum(self) -> Spectrum:
        """An array for a spectrum that transforms can read and write directly."""
        return self._padded.empty_spectrum()

    @property
    def plane(self) -> Spectrum:
        """A buffer in which to build the spectrum for `inverse`; the next transform may overwrite it."""
        return self._padded.spectrum

    def inverse(self, spectrum: Spectrum, out: Array | None = None) -> Array:
        """Rows −before … nx−1+after of the convolution whose spectrum is given, shape (rows, ny), into `out` if given."""
        self._padded.inverse(spectrum)
        return np.multiply(self._padded.line[:, : self.ny], self._scale, out=out)

    def drift(self, power: Array) -> float:
        """Σ ∂/∂(x/dx) of a product of two fields with the real spectrum `power` (py//2+1, px): by the central difference of
        fourth order, which conserves the power of symmetric kernels."""
        theta = 2.0 * np.pi * np.fft.fftfreq(self.px)
        return float(self._weight @ power @ ((8.0 * np.sin(theta) - np.sin(2.0 * theta)) / 6.0)) * self._scale

    def own(self, spectrum: Spectrum) -> float:
        """What the kernel of a `spectrum` (py//2+1, px) adds to an element by its own value."""
        return float((self._weight @ spectrum.real).sum()) * self._scale

    @property
    def _weight(self) -> Array:
        """How often each line of a spectrum occurs in the whole plane, (py//2+1)."""
        weight = np.full(self.half, 2.0)
        weight[0] = weight[-1] = 1.0
        return weight

    def spectrum(self, table: Array) -> Spectrum:
        """Spectrum of a kernel given at offsets −(nx−1)…nx−1 by −(ny−1)…ny−1, shape (2nx−1, 2ny−1), or of several in an array.

        Raises ValueError where the convolution was planned with extra rows, which such a table does not reach."""
        nx, ny = self.nx, self.ny
        if self.before or self.after or table.shape[-2:] != (2 * nx - 1, 2 * ny - 1):
            raise ValueError(f"a table of shape {(2 * nx - 1, 2 * ny - 1)} is needed, got {table.shape}")
        padded = np.zeros((*table.shape[:-2], self.px, self.py))
        ix = np.arange(-(nx - 1), nx)
        iy = np.arange(-(ny - 1), ny)
        padded[..., ix[:, None], iy] = table
        return np.asarray(fft(np.ascontiguousarray(np.swapaxes(rfft(padded, axis=-1), -2, -1)), axis=-1))

    def quadrant_spectrum(self, quadrant: Array, parity: int = 1) -> Array:
        """Real spectrum of a kernel that is even (`parity` 1) or odd (−1) in both offsets, given for offsets ≥ 0.

        `quadrant` has shape (≥ reach_x, ny) with reach_x = nx + max(before, after). Each value is stored twice, beside
        itself, so that it multiplies a complex spectrum viewed as floats: NumPy would otherwise convert it every time.
        """
        reach = self.nx + max(self.before, self.after)
        return in_pairs(quadrant_symbol(quadrant[:reach, : self.ny], (self.px, self.py), parity))


def even_length(n: int) -> int:
    """Length ≥ n that transforms fast and is even, as symmetric kernels need it; of a single element, which has no other beside
    it, 1."""
    return 1 if n == 1 else 2 * int(fftw().next_fast_len((n + 1) // 2))


def free_space(nx: int, ny: int) -> tuple[int, int]:
    """Sides (px, py) of the padded plane in which nx × ny elements do not see their periodic images."""
    return even_length(2 * nx - 1), even_length(2 * ny - 1)


def around(shape: tuple[int, int]) -> tuple[int, int]:
    """Sides (px, py) of the plane of a preconditioner: a few elements of padding suffice, because the wrap-around of a
    preconditioner does not affect the accuracy of the solution."""
    px, py = (even_length(n + 4 if n > 1 else 1) for n in shape)
    return px, py


def quadrant_symbol(quadrant: Array, padded: tuple[int, int], parity: int | tuple[int, int] = 1) -> Array:
    """Real spectrum (py//2+1, px) of a kernel given for offsets ≥ 0, zero beyond; even (`parity` 1) or odd (−1) in both, or
    with a pair of parities along x and y. The spectrum of a kernel odd in one of them is −i times the array returned.

    Offsets up to px/2 and py/2 count. A cosine or sine transform of the quadrant needs a quarter of the work of a transform of
    the whole plane. Raises ValueError if `padded` = (px, py) are not even."""
    px, py = padded
    if px % 2 * (px - 1) or py % 2 * (py - 1):
        raise ValueError(f"a symmetric kernel needs an even period, got {padded}")
    along, across = (parity, parity) if isinstance(parity, int) else parity
    hx, hy = px // 2, py // 2
    quarter = np.zeros((hy + 1, hx + 1))
    part = quadrant[: hx + 1, : hy + 1].T
    quarter[: part.shape[0], : part.shape[1]] = part
    quarter = _cosines_or_sines(quarter, along, across)
    symbol = np.empty((hy + 1, px))
    symbol[:, : hx + 1] = quarter
    np.multiply(quarter[:, -2:0:-1], along, out=symbol[:, hx + 1 :])
    return symbol


def half_plane_symbol(table: Array, padded: tuple[int, int], parity: int = 1) -> Spectrum:
    """Spectrum (…, py//2+1, px) of a kernel given at offsets −n … n along x and ≥ 0 along y, (…, 2n+1, rows), even (`parity` 1)
    or odd (−1) in y.

    Offsets up to py/2 count. Raises ValueError if the plane is too short along x, or py is not even."""
    px, py = padded
    n, hy = table.shape[-2] // 2, py // 2
    if py % 2 * (py - 1) or 2 * n + 1 > px:
        raise ValueError(f"a table of {2 * n + 1} rows needs as many elements, and an even period across, got {padded}")
    half = np.zeros((*table.shape[:-2], hy + 1, px))
    part = np.swapaxes(table[..., : hy + 1], -2, -1)
    half[..., : part.shape[-2], : n + 1], half[..., : part.shape[-2], -n:] = part[..., n:], part[..., :n]
    if parity > 0:
        return np.asarray(fft(real_transform(half, -2) if hy else half, axis=-1))
    half[..., [0, -1], :] = 0.0
    if hy > 1:
        half[..., 1:-1, :] = real_transform(half[..., 1:-1, :], -2, odd=True)
    return np.asarray(-1j * fft(half, axis=-1))


def real_transform(field: Array, axis: int, *, odd: bool = False) -> Array:
    """Cosine transform of type I of a real field along one axis, or with `odd` the sine transform, neither normalised: those of
    FFTW, since to load `scipy.fft` for them takes as long as a small contact."""
    pyfftw = fftw()
    before, after = pyfftw.byte_align(field), pyfftw.empty_aligned(field.shape)
    pyfftw.FFTW(before, after, (axis,), "FFTW_RODFT00" if odd else "FFTW_REDFT00", ("FFTW_ESTIMATE",)).execute()
    return np.asarray(after)


def _cosines_or_sines(quarter: Array, along: int, across: int) -> Array:
    """Cosine (parity 1) or sine (−1) transforms of type I of a quarter plane, axis 0 across and axis 1 along, not normalised.

    Odd kernels vanish on their axes and where two images meet. Two sines have the factor (−i)² = −1."""
    result, inner = np.zeros_like(quarter), tuple(slice(1, -1) if parity < 0 else slice(None) for parity in (across, along))
    part = quarter[inner]
    if part.size:
        for axis, parity in ((i, parity) for i, parity in enumerate((across, along)) if part.shape[i] > 1 or parity < 0):
            part = real_transform(part, axis, odd=parity < 0)
        result[inner] = -part if along < 0 and across < 0 else part
    return result


def blocks(rows: int, length: int) -> list[slice]:
    """Groups of rows of `length` numbers each, small enough to stay in the cache during several operations."""
    step = max(1, 2**14 // length)
    return [slice(i, min(i + step, rows)) for i in range(0, rows, step)]


def in_pairs(symbol: AnyArray) -> AnyArray:
    """Each value of a real symbol twice, beside itself (see `multiply`); a complex one as it is."""
    return symbol if np.iscomplexobj(symbol) else np.repeat(symbol, 2, axis=1)


def multiply(spectrum: Spectrum, symbol: AnyArray, out: Spectrum) -> Spectrum:
    """`out` = spectrum times a `symbol`, complex or real and stored in pairs (see `in_pairs`)."""
    np.multiply(spectrum.view(symbol.dtype), symbol, out=out.view(symbol.dtype))
    return out


Parities = tuple[int, int]
"""Parity across y = 0 of the x and the y component of a vector field, 1 (even) or −1 (odd); one of each."""


class MirroredPlane:
    """Plans and buffers for pairs of fields (2, nx, ny) on the elements y > 0, in a plane of px × py elements.

    The plane is periodic: with px ≥ 2·(nx + extra rows) − 1 and py ≥ 4·ny − 1 convolutions are those of free space. `rows`
    are transformed back, the first `before` of them upstream of the fields."""

    def __init__(self, nx: int, ny: int, padded: tuple[int, int], even: int, rows: int | None = None, before: int = 0) -> None:
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


def both_sides(table: AnyArray, parity: int) -> AnyArray:
    """(..., nx, n) at offsets ≥ 0 along y -> (..., nx, 2n−1) at all of them, of a kernel even (`parity` 1) or odd (−1)."""
    return np.concatenate([parity * table[..., :0:-1], table], axis=-1)


def unfolded(field: AnyArray, parity: int) -> AnyArray:
    """(..., nx, ny) on y > 0 -> (..., nx, 2 ny) on both sides, even (`parity` 1) or odd (−1)."""
    below = field[..., ::-1]
    return np.concatenate([below if parity > 0 else -below, field], axis=-1)

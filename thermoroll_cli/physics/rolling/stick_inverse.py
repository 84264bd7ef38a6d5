"""Approximate inverse of D A on the stick area: integrate along the rolling direction, then deconvolve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.convolution import Parities, around
from thermoroll_cli.physics.numerics.grid import DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS
from thermoroll_cli.physics.rolling.rolling_gradient import FreeShear, MirroredShear, Symbols
from thermoroll_cli.tools.arrays import AnyArray


def run_starts(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each element, the flat index of the first element of its run of True along x, (n, m); of row 0 before any run."""
    begins = mask.copy()
    begins[1:] &= ~mask[:-1]
    n, m = mask.shape
    row = np.maximum.accumulate(np.where(begins, np.arange(n)[:, None], 0), axis=0)
    return np.asarray(row * m + np.arange(m))


def inverse_symbols(
    padded: tuple[int, int], dx: float, dy: float, bodies: Bodies, weights: tuple[float, ...],
    rate: float = 0.0,
) -> Symbols:
    """Symbols (py//2+1, px) of the inverse of (D + `rate`) A on a periodic plane, after a running sum along x."""
    px = padded[0]
    xx, yy, xy = bodies.shear_symbols(padded, dx, dy)
    theta = 2.0 * np.pi * np.fft.fftfreq(px)
    step = -np.expm1(-1j * theta) * any(weights) + rate * dx
    terms = (w * np.exp(1j * k * theta) for k, w in zip(DIFFERENCE_OFFSETS, weights, strict=True))
    difference = sum(terms, np.full(px, rate * dx, dtype=np.complex128))
    ratio = np.ones(px, dtype=np.complex128)
    ratio[1:] = difference[1:] / step[1:]
    # The step of the running sum belongs to the symbol.
    determinant = (xx * yy - xy**2) * ratio / dx
    return yy / determinant, xx / determinant, -xy / determinant


class StickInverse:
    """(D A)⁻¹ on stick runs, periodic over the bounding box: D⁻¹ is a running sum down each row from the start of its
    run, A⁻¹ a 2×2 matrix per wavenumber. The difference between D and a first difference is part of the symbol.

    In a step over time D + c takes the place of D, c = `rate` in 1/m: the sum is then b_i = (g_i + b_{i−1})/(1 + c dx), or
    g_i/(c dx) where nothing rolls (all `weights` are zero).

    Without D⁻¹ modes that vary slowly along x and fast along y are almost singular and the work grows with N. `mirror` as in
    `RollingGradient`."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, bodies: Bodies, mirror: Parities | None = None,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS, rate: float = 0.0,
    ) -> None:
        self.shape = shape
        self._kept, self._decay = float(any(weights)), rate * dx
        n, m = shape
        padded = around((n, m if mirror is None else 2 * m))
        inverse = inverse_symbols(padded, dx, dy, bodies, weights, rate)
        self._solve = (FreeShear(shape, inverse, padded, coupled=bool(inverse[2].any())) if mirror is None
                       else MirroredShear(shape, inverse, padded, mirror))
        self._sums = np.zeros((2, n + 1, m))
        self._base = np.empty((2, n, m))

    def __call__(self, gradient: AnyArray, mask: NDArray[np.bool_], starts: NDArray[np.intp]) -> AnyArray:
        """Traction (2, n, m) whose D A is approximately `gradient` on the stick elements `mask`; zero elsewhere.

        `gradient` is zero outside `mask`, `starts` is `run_starts(mask)`."""
        sums, base = self._sums, self._base
        if self._decay:
            factor = mask / (self._kept + self._decay)
            for i, row in enumerate(gradient.swapaxes(0, 1)):
                sums[:, i + 1] = (row + self._kept * sums[:, i]) * factor[i]
            base[:] = sums[:, 1:]
        else:
            # Row k holds the sum of the rows above it, so the sum restarts if the row is subtracted at which the run began.
            np.cumsum(gradient, axis=1, out=sums[:, 1:])
            for i in range(2):
                # Any mode but "raise" writes into `out` directly.
                np.take(sums[i], starts, out=base[i], mode="clip")
            np.subtract(sums[:, 1:], base, out=base)
            base *= mask
        traction = self._solve(base)
        traction *= mask
        return traction

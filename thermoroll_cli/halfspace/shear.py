"""Tangential displacement of the surface under tangential tractions, on a free-space or on a mirrored plane (Eq. 15)."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.numerics.convolution import (
    Convolution,
    MirroredPlane,
    Parities,
    blocks,
    free_space,
    in_pairs,
    multiply,
    pair_symbols,
    quadrant_symbol,
)

Symbols = tuple[AnyArray, AnyArray, AnyArray]
"""Spectra (py//2+1, px) of the influence of τ_x on u_x, τ_y on u_y, and of each on the other."""


def shear_symbols(tables: tuple[AnyArray, AnyArray, AnyArray], padded: tuple[int, int]) -> Symbols:
    """Spectra of influence tables at offsets ≥ 0 (see `shear_tables`) in a plane of `padded` elements."""
    xx, yy, xy = tables
    return quadrant_symbol(xx, padded), quadrant_symbol(yy, padded), quadrant_symbol(xy, padded, -1)


class FreeShear:
    """u = A τ: (2, n, m) -> (2, n + 2·margin, m), `margin` more rows at either end; `symbols` on the plane
    `free_space(n + margin, m)`. `coupled` says whether the third symbol is different from zero."""

    def __init__(
        self, shape: tuple[int, int], margin: int, symbols: Symbols, coupled: bool, threads: int
    ) -> None:
        self._shape = (2, shape[0] + 2 * margin, shape[1])
        # One set of buffers per component: both spectra exist at the same time.
        self._convolutions = [Convolution(*shape, margin, margin) for _ in range(2)]
        self._xx, self._yy, self._xy = (in_pairs(s) for s in symbols)
        self._traction_hat = [c.empty_spectrum() for c in self._convolutions]
        self._blocks = blocks(*self._traction_hat[0].shape)
        self._cross_hat = [np.empty_like(hat[self._blocks[0]]) for hat in self._traction_hat]
        self._coupled = coupled
        self._pool = ThreadPoolExecutor(2) if threads > 1 else None

    @property
    def transforms(self) -> int:
        return sum(c.transforms for c in self._convolutions)

    def _both(self, task: Callable[[int], None]) -> None:
        if self._pool is not None:
            list(self._pool.map(task, (0, 1)))
        else:
            task(0)
            task(1)

    def __call__(self, traction: AnyArray) -> AnyArray:
        u = np.empty(self._shape)
        hat, convolutions = self._traction_hat, self._convolutions

        def there(i: int) -> None:
            convolutions[i].forward(traction[i], out=hat[i])

        self._both(there)

        def back(i: int) -> None:
            total, own = convolutions[i].plane, self._yy if i else self._xx
            for rows in self._blocks:
                part = multiply(hat[i][rows], own[rows], out=total[rows])
                if self._coupled:
                    part += multiply(hat[1 - i][rows], self._xy[rows], out=self._cross_hat[i][: len(part)])
            convolutions[i].inverse(total, out=u[i])

        self._both(back)
        return u

    def of_shape(self, shape: AnyArray) -> AnyArray:
        """u_x under tractions (f, 0), u_y under (0, f), and u_y under (f, 0), which is u_x under (0, f), on the rows of u:
        (n, m) -> (3, n + 2·margin, m), for the transforms of one application."""
        convolution, hat = self._convolutions[0], self._traction_hat[0]
        convolution.forward(shape, out=hat)
        u = np.zeros((3, *self._shape[1:]))
        for i, symbol in enumerate((self._xx, self._yy, self._xy)):
            if i < 2 or self._coupled:
                convolution.inverse(multiply(hat, symbol, out=convolution.plane), out=u[i])
        return u


class MirroredShear:
    """As `FreeShear` for tractions of opposite parity across y = 0, given on the m elements y > 0: half the work. `symbols`
    on the plane of both sides, `free_space(n + margin, 2 m)`."""

    def __init__(
        self, shape: tuple[int, int], margin: int, symbols: Symbols, coupled: bool, mirror: Parities
    ) -> None:
        n, m = shape
        self._even = even = mirror.index(1)
        self._plane = MirroredPlane(n, m, free_space(n + margin, 2 * m), even, n + 2 * margin, margin)
        own, other = pair_symbols(*symbols, even)
        self._own = in_pairs(own)
        self._other = in_pairs(other) if coupled else None

    @property
    def transforms(self) -> int:
        return self._plane.transforms

    def __call__(self, traction: AnyArray) -> AnyArray:
        self._plane.forward(traction)
        self._plane.apply(self._own, self._other)
        return self._plane.inverse()

    def of_shape(self, shape: AnyArray) -> AnyArray:
        """As `FreeShear.of_shape` for a shape even across y = 0, given on its half."""
        # `__call__` handles a shape along the even component; for one along the odd component the symbols of both components
        # change places.
        pair = np.zeros((2, *shape.shape))
        pair[self._even] = shape
        along = self(pair)
        self._plane.forward(pair)
        self._plane.apply(self._own, None if self._other is None else -self._other)
        across = self._plane.inverse()
        xx, yy = (along, across) if self._even == 0 else (across, along)
        return np.stack([xx[self._even], yy[self._even], along[1 - self._even]])

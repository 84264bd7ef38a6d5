"""Tangential displacement of the surface under tangential tractions, on a free-space or on a mirrored plane (Eq. 15)."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import Convolution, free_space, in_pairs, multiply, quadrant_symbol
from thermoroll_cli.kernels.mirror import MirroredPlane, Parities, conjugating_pairs, pair_symbols

Array = NDArray[Any]
Symbols = tuple[Array, Array, Array]
"""Spectra (py//2+1, px) of the influence of τ_x on u_x, τ_y on u_y, and of each on the other."""


def shear_symbols(tables: tuple[Array, Array, Array], padded: tuple[int, int]) -> Symbols:
    """Spectra of influence tables at offsets ≥ 0 (see `shear_tables`) in a plane of `padded` elements."""
    xx, yy, xy = tables
    return quadrant_symbol(xx, padded), quadrant_symbol(yy, padded), quadrant_symbol(xy, padded, -1)


class FreeShear:
    """u = A τ: (2, n, m) -> (2, n + 2·margin, m), `margin` more rows at either end; `symbols` on the plane that
    `free_space(n + margin, m)` names. `coupled` tells whether the third of them acts at all."""

    def __init__(
        self, shape: tuple[int, int], margin: int, symbols: Symbols, coupled: bool, threads: int, precision: Any
    ) -> None:
        self._shape = (2, shape[0] + 2 * margin, shape[1])
        self._precision = precision
        # One set of buffers per component: the two can then be transformed side by side, and the result does not
        # depend on whether they are.
        self._convolutions = [Convolution(*shape, margin, margin, precision) for _ in range(2)]
        self._xx, self._yy, self._xy = (in_pairs(s, precision) for s in symbols)
        self._traction_hat = [np.empty_like(c.plane) for c in self._convolutions]
        self._cross_hat = [np.empty_like(hat) for hat in self._traction_hat]
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

    def __call__(self, traction: Array) -> Array:
        u = np.empty(self._shape, dtype=self._precision)
        hat, convolutions = self._traction_hat, self._convolutions

        def there(i: int) -> None:
            convolutions[i].forward(traction[i], out=hat[i])

        self._both(there)

        def back(i: int) -> None:
            total = multiply(hat[i], self._xx if i == 0 else self._yy, out=convolutions[i].plane)
            if self._coupled:
                total += multiply(hat[1 - i], self._xy, out=self._cross_hat[i])
            convolutions[i].inverse(total, out=u[i])

        self._both(back)
        return u


class MirroredShear:
    """As `FreeShear` for tractions of opposite parity across y = 0, given on the m elements y > 0: half the work. `symbols`
    on the plane of both sides, `free_space(n + margin, 2 m)`."""

    def __init__(
        self, shape: tuple[int, int], margin: int, symbols: Symbols, coupled: bool, mirror: Parities, precision: Any
    ) -> None:
        n, m = shape
        even = mirror.index(1)
        self._plane = MirroredPlane(n, m, free_space(n + margin, 2 * m), even, n + 2 * margin, margin, precision)
        own, other = pair_symbols(*symbols, even)
        self._own = in_pairs(own, precision)
        self._other = conjugating_pairs(other, precision) if coupled else None

    @property
    def transforms(self) -> int:
        return self._plane.transforms

    def __call__(self, traction: Array) -> Array:
        plane = self._plane.forward(traction)
        if self._other is None:
            multiply(plane, self._own, out=plane)
            return self._plane.inverse()
        mirrored = self._plane.mirrored()
        multiply(mirrored, self._other, out=mirrored)
        multiply(plane, self._own, out=plane)
        plane += mirrored
        return self._plane.inverse()

"""Tangential displacement of the surface, A τ, and its gradient along the rolling direction, ∂u/∂x = D A τ, on the contact's
bounding box."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.convolution import (
    Convolution,
    MirroredPlane,
    Parities,
    blocks,
    counted,
    free_space,
    in_pairs,
    multiply,
    pair_symbols,
)
from thermoroll_cli.physics.numerics.grid import DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS
from thermoroll_cli.tools.arrays import AnyArray


@dataclass(frozen=True)
class RollingOptions:
    """Options of the tangential solver that experiments vary."""

    difference_weights: tuple[float, float, float, float] = UPSTREAM_WEIGHTS
    relaxation: float = 0.35
    """ρ is this fraction of the inverse of an element's own compliance. With a much larger ρ elements alternate between stick
    and slip without end: near the kink the natural residual then measures the slip and no longer the traction."""
    preconditioned: bool = True
    """Whether linear systems are preconditioned with the inverse of D A on the stick area."""
    smallest_cover: float = 1e-3
    """Least covered fraction that compliances use: thinner slivers carry less than 1e-4 of an element's load, and a larger
    compliance would only lose digits."""
    deepest: float = 0.117
    """Largest amount by which the known gradient at the leading edge is below the operator's, in units of Σ(1−ν)/G along x and
    Σ1/G along y; it occurs on elements that the border just touches. Infinite: the known gradient is not used."""
    leading_known: bool = True
    """Whether the known gradient at the leading edge is used."""


Symbols = tuple[AnyArray, AnyArray, AnyArray]
"""Spectra (py//2+1, px) of the influence of τ_x on u_x, τ_y on u_y, and of each on the other."""


class FreeShear:
    """`symbols`, on a periodic plane of `padded` elements, applied to pairs of fields: u = A τ and its inverse,
    (2, n, m) -> (2, n + 2·margin, m) with `margin` more rows at either end. `coupled` says whether the third symbol is
    different from zero."""

    def __init__(
        self, shape: tuple[int, int], symbols: Symbols, padded: tuple[int, int], margin: int = 0, *, coupled: bool = True,
        threads: int = 1,
    ) -> None:
        self._shape = (2, shape[0] + 2 * margin, shape[1])
        # Threads that work side by side need buffers of their own.
        own = [Convolution(*shape, margin, margin, padded) for _ in range(2 if threads > 1 else 1)]
        self._convolutions = own[0], own[-1]
        self._xx, self._yy, self._xy = (in_pairs(s) for s in symbols)
        self._traction_hat = [c.empty_spectrum() for c in self._convolutions]
        self._blocks = blocks(*self._traction_hat[0].shape)
        self._cross_hat = [np.empty_like(hat[self._blocks[0]]) for hat in self._traction_hat]
        self._coupled = coupled
        self._pool = ThreadPoolExecutor(2) if threads > 1 else None

    def _both(self, task: Callable[[int], None]) -> None:
        if self._pool is not None:
            list(self._pool.map(task, (0, 1)))
            counted.transforms += 2  # which the threads of the pool have counted as theirs
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
    """As `FreeShear` for fields of opposite parity across y = 0, given on the m elements y > 0: half the work. `symbols` on
    the plane of both sides."""

    def __init__(
        self, shape: tuple[int, int], symbols: Symbols, padded: tuple[int, int], mirror: Parities, margin: int = 0, *,
        coupled: bool = True,
    ) -> None:
        n, m = shape
        self._even = even = mirror.index(1)
        self._plane = MirroredPlane(n, m, padded, even, n + 2 * margin, margin)
        own, other = pair_symbols(*symbols, even)
        self._own = in_pairs(own)
        self._other = in_pairs(other) if coupled else None

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


MARGIN = 2
"""Rows beyond either end of the box that the difference formula needs."""


def dissipative_part(weights: tuple[float, ...]) -> tuple[float, ...]:
    """Half the sum of a difference formula and its mirror image, on rows −2 … 2: its dissipation. The other half is
    antisymmetric and conserves power."""
    a, b, c, d = weights
    return a / 2, (b + d) / 2, c, (b + d) / 2, a / 2


def difference(u: AnyArray, weights: tuple[float, ...], dx: float) -> AnyArray:
    """Weighted sum of rows i−2, i−1, … for i = 0…n−1, over dx, from u at rows −2…n+1: (…, n+4, ny) -> (…, n, ny)."""
    n = u.shape[-2] - 4
    out: AnyArray = u[..., :n, :] * float(weights[0] / dx)
    term = np.empty_like(out)
    for k, w in enumerate(weights[1:], start=1):
        np.multiply(u[..., k : n + k, :], float(w / dx), out=term)
        out += term
    return out


class RollingGradient:
    """D A: tractions (2, n, m) in Pa -> displacement gradients (2, n, m), by free-space convolution (Eqs. 7, 8, 15).

    If the problem is its own mirror image in y = 0, `mirror` holds the parities of τ_x and τ_y and all fields those of the
    m elements y > 0. `applications` counts calls: the unit in which the cost of the tangential solver is measured.

    In a step over time it is (D + c) A with `rate` = c in 1/m, or c A alone if nothing `rolls` (`over_time`).
    """

    rate = 0.0
    rolls = True

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, bodies: Bodies, threads: int = 1,
        mirror: Parities | None = None, weights: tuple[float, ...] = UPSTREAM_WEIGHTS
    ) -> None:
        n, m = shape
        self.weights, self._dissipative = weights, dissipative_part(weights)
        self.shape = shape
        self.dx, self.dy = dx, dy
        self.bodies, self.near_border = bodies, bodies.near_border(dx, dy).shear
        self.mirror = mirror
        self.applications = 0
        self._threads = threads
        width = m if mirror is None else 2 * m
        self._padded, tables = free_space(n + MARGIN, width), bodies.shear_tables(n + MARGIN, width, dx, dy)
        xx, yy, xy = (table.symbol(self._padded) for table in tables)
        self._symbols: Symbols = xx, yy, xy
        self._near = near = [table.rows(DIFFERENCE_OFFSETS) for table in tables]
        # Corrections at borders belong to D and use this also in steps over time.
        signs = np.where(np.arange(width) % 2, -2.0, 2.0)
        signs[0], signs[-1] = 1.0, 0.5 * signs[-1] if width > 1 else 1.0
        self.self_gradient = self._response([t[:, 0] for t in near])
        self.alternating_gradient = self._response([t @ signs for t in near])

    def _response(self, rows: list[AnyArray]) -> tuple[float, float]:
        """∂u_x/∂x to τ_x and ∂u_y/∂x to τ_y in 1/Pa if u at `DIFFERENCE_OFFSETS` from the loaded row is `rows`: of an element
        by its own traction (`self_gradient`), and of a row of elements by tractions ±1 in turn (`alternating_gradient`)."""
        along, across = (
            sum(w * float(u) for u, w in zip(t, self._step_weights, strict=True)) / self.dx
            for t in rows[:2]
        )
        return along, across

    @property
    def _step_weights(self) -> tuple[float, ...]:
        """`weights` of D + c: c adds to that of the element's own row."""
        a, b, own, d = self.weights
        return a, b, own + self.rate * self.dx, d

    def over_time(self, rate: float, *, rolls: bool = True) -> RollingGradient:
        """(D + c) A with c = `rate` in 1/m, for steps over time, or c A if nothing `rolls`, with the transforms of this one."""
        assert self._shear is not None  # made before it is shared
        step = copy.copy(self)
        step.rate, step.rolls = rate, rolls
        if not rolls:
            step.weights, step._dissipative = (0.0,) * 4, (0.0,) * 5
        step.self_gradient = step._response([table[:, 0] for table in self._near])
        return step

    @property
    def remembered(self) -> float:
        """c u of an element by its own traction, mean of both directions, in 1/Pa: the part of a step over time that is no
        gradient."""
        own = DIFFERENCE_OFFSETS.index(0)
        return self.rate * float(np.mean([table[own, 0] for table in self._near[:2]]))

    @cached_property
    def _shear(self) -> FreeShear | MirroredShear:
        coupled = self.bodies.sheared_across and math.isfinite(self.dy)
        if self.mirror is not None:
            return MirroredShear(self.shape, self._symbols, self._padded, self.mirror, MARGIN, coupled=coupled)
        return FreeShear(self.shape, self._symbols, self._padded, MARGIN, coupled=coupled, threads=self._threads)

    def displacement(self, traction: AnyArray) -> AnyArray:
        """u = A τ in m on rows −2…n+1: (2, n, m) -> (2, n+4, m)."""
        return self._shear(traction)

    def __call__(self, traction: AnyArray) -> AnyArray:
        """∂u/∂x of shape (2, n, m)."""
        self.applications += 1
        return difference(self.displacement(traction), self._step_weights, self.dx)

    def of_shape(self, shape: AnyArray) -> AnyArray:
        """∂u_x/∂x under tractions (f, 0), ∂u_y/∂x under (0, f), and ∂u_y/∂x under (f, 0), which is ∂u_x/∂x under (0, f), of the
        half-spaces alone, without the interlayer.

        `shape` is f in Pa, (n, m), even across y = 0 if there is a mirror; the result is (3, n, m), for the transforms
        of one application."""
        self.applications += 1
        u = self._shear.of_shape(shape)
        if interlayer := self.bodies.shear.interlayer:
            u[:2, MARGIN:-MARGIN] -= interlayer * shape
        return difference(u, self.weights, self.dx)

    def split(self, traction: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """∂u/∂x, the part of it by which the upstream formula dissipates power, and u in m, all (2, n, m).

        The sum of the second times the traction is the power of slip zones narrower than an element."""
        self.applications += 1
        u = self.displacement(traction)
        return difference(u, self._step_weights, self.dx), difference(u, self._dissipative, self.dx), u[:, MARGIN:-MARGIN]

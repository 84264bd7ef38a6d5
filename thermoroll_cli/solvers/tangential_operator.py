"""Gradient of the tangential displacement along the rolling direction, ∂u/∂x = D A τ, on the contact's bounding box."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import Convolution, multiply
from thermoroll_cli.kernels.elastic import ShearCompliance, shear_tables

Array = NDArray[np.float64]

DIFFERENCE_OFFSETS = (-2, -1, 0, 1)
# 0.7 of the third-order and 0.3 of the second-order upstream formula (numerics.md): their errors in the dissipated heat
# have opposite signs, and both damp odd–even modes: Re D̂ = 0.7·(1−cos θ)²/3 + 0.3·(1−cos θ)² ≥ 0, so D A is monotone.
DIFFERENCE_WEIGHTS = (
    0.7 / 6 + 0.3 / 2,
    -0.7 - 0.3 * 2,
    0.7 / 2 + 0.3 * 3 / 2,
    0.7 / 3,
)


# Half the sum of the formula and its mirror image: what it dissipates. The other half is antisymmetric and conserves power.
DISSIPATIVE_WEIGHTS = (
    DIFFERENCE_WEIGHTS[0] / 2,
    (DIFFERENCE_WEIGHTS[1] + DIFFERENCE_WEIGHTS[3]) / 2,
    DIFFERENCE_WEIGHTS[2],
    (DIFFERENCE_WEIGHTS[1] + DIFFERENCE_WEIGHTS[3]) / 2,
    DIFFERENCE_WEIGHTS[0] / 2,
)


def difference(u: Array, weights: tuple[float, ...], dx: float) -> Array:
    """Weighted sum of rows i−2, i−1, … for i = 0…n−1, over dx, from u at rows −2…n+1: (…, n+4, ny) -> (…, n, ny)."""
    n = u.shape[-2] - 4
    out: Array = u[..., :n, :] * (weights[0] / dx)
    term = np.empty_like(out)
    for k, w in enumerate(weights[1:], start=1):
        np.multiply(u[..., k : n + k, :], w / dx, out=term)
        out += term
    return out


class RollingGradient:
    """D A: tractions (2, n, m) in Pa -> displacement gradients (2, n, m), by free-space convolution (Eqs. 7, 8, 15).

    `applications` counts calls: the unit in which the cost of the tangential solver is measured.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        dx: float,
        dy: float,
        compliance: ShearCompliance,
        threads: int = 1,
    ) -> None:
        n, m = shape
        self.shape = shape
        self.dx, self.dy = dx, dy
        self.compliance = compliance
        self.applications = 0
        # One set of buffers per component: the two can then be transformed side by side, and the result does not
        # depend on whether they are.
        self._convolutions = [Convolution(n, m, before=2, after=2) for _ in range(2)]
        first = self._convolutions[0]
        tables = shear_tables(n + 2, m, dx, dy, compliance)
        self._xx, self._yy, self._xy = (
            first.quadrant_spectrum(t, parity) for t, parity in zip(tables, (1, 1, -1), strict=True)
        )
        self._traction_hat = [np.empty((first.half, first.px), dtype=np.complex128) for _ in range(2)]
        self._cross_hat = [np.empty_like(hat) for hat in self._traction_hat]
        self._coupled = bool(compliance.directional)  # ν = 0: no cross term
        self._pool = ThreadPoolExecutor(2) if threads > 1 else None
        signs = np.where(np.arange(m) % 2, -2.0, 2.0)
        signs[0], signs[-1] = 1.0, 0.5 * signs[-1] if m > 1 else 1.0
        self.self_gradient = self._response([t[:, 0] for t in tables])
        self.alternating_gradient = self._response([t @ signs for t in tables])

    def _response(self, rows: list[Array]) -> tuple[float, float]:
        """∂u_x/∂x to τ_x and ∂u_y/∂x to τ_y in 1/Pa where u at rows 0, 1, 2, … from the loaded one is `rows`: of an element by
        its own traction (`self_gradient`), and of a row of elements by tractions ±1 in turn (`alternating_gradient`)."""
        along, across = (
            sum(w * float(t[abs(k)]) for k, w in zip(DIFFERENCE_OFFSETS, DIFFERENCE_WEIGHTS, strict=True)) / self.dx
            for t in rows[:2]
        )
        return along, across

    @property
    def transforms(self) -> int:
        return sum(c.transforms for c in self._convolutions)

    def _both(self, task: Callable[[int], None]) -> None:
        if self._pool is not None:
            list(self._pool.map(task, (0, 1)))
        else:
            task(0)
            task(1)

    def displacement(self, traction: Array) -> Array:
        """u = A τ in m on rows −2…n+1: (2, n, m) -> (2, n+4, m)."""
        n, m = self.shape
        u = np.empty((2, n + 4, m))
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

    def __call__(self, traction: Array) -> Array:
        """∂u/∂x of shape (2, n, m)."""
        self.applications += 1
        return difference(self.displacement(traction), DIFFERENCE_WEIGHTS, self.dx)

    def of_shape(self, shape: Array) -> Array:
        """∂u_x/∂x under tractions (f, 0), ∂u_y/∂x under (0, f), and ∂u_y/∂x under (f, 0), which is ∂u_x/∂x under (0, f).

        `shape` is f in Pa, (n, m); the result is (3, n, m), for the transforms of one application."""
        self.applications += 1
        n, m = self.shape
        convolution, hat = self._convolutions[0], self._traction_hat[0]
        convolution.forward(shape, out=hat)
        u = np.zeros((3, n + 4, m))
        for i, spectrum in enumerate((self._xx, self._yy, self._xy)):
            if i < 2 or self._coupled:
                convolution.inverse(multiply(hat, spectrum, out=convolution.plane), out=u[i])
        return difference(u, DIFFERENCE_WEIGHTS, self.dx)

    def split(self, traction: Array) -> tuple[Array, Array]:
        """∂u/∂x, and the part of it by which the upstream formula dissipates power, both (2, n, m).

        Summed against the traction the latter is what slip zones narrower than an element ought to have dissipated."""
        self.applications += 1
        u = self.displacement(traction)
        return difference(u, DIFFERENCE_WEIGHTS, self.dx), difference(u, DISSIPATIVE_WEIGHTS, self.dx)

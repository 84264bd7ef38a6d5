"""What two different bodies do to each other's problem: pressure slides the surfaces, shear lifts them (Dundurs' β)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import Convolution, multiply, turn
from thermoroll_cli.kernels.elastic import coupling_gradient_tables, coupling_tables
from thermoroll_cli.kernels.grid import Grid

Array = NDArray[np.float64]


class NormalShearCoupling:
    """Both directions of the coupling on one grid, for K of `coupling_constant` (1/Pa).

    The tangential problem sees the pressure as a further part of the rigid slip, −∂u^p/∂x (`stretch`); the normal problem
    sees the tractions as an offset of its gap, like a thermal expansion (`lift`). Neither solver has to know more.
    Derivation of the signs: `coupling_tables`.
    """

    def __init__(self, grid: Grid, constant: float) -> None:
        self.grid, self.constant = grid, constant
        self._convolution = Convolution(*grid.shape)
        self._gradient: tuple[Array, Array] | None = None
        self._normal: tuple[Array, Array] | None = None

    @property
    def transforms(self) -> int:
        return self._convolution.transforms

    def stretch(self, pressure: Array) -> Array:
        """∂u^p/∂x, (2, nx, ny): gradient of the relative tangential displacement by the pressure (nx, ny) in Pa.

        The derivative of the closed form itself, not a difference: a smooth field is asked for here, and a difference
        would add its own error (it is first order at the border)."""
        grid, convolution = self.grid, self._convolution
        if self._gradient is None:
            along, across = coupling_gradient_tables(*grid.shape, grid.dx, grid.dy)
            self._gradient = convolution.quadrant_spectrum(along), convolution.quadrant_spectrum(across, -1)
        hat = convolution.forward(pressure)
        work = np.empty_like(hat)
        return self.constant * np.stack([convolution.inverse(multiply(hat, g, out=work)) for g in self._gradient])

    def lift(self, traction: Array) -> Array:
        """−u_z^τ in m, (nx, ny): by how much the tractions (2, nx, ny) in Pa bring the surfaces towards each other."""
        grid, convolution = self.grid, self._convolution
        if self._normal is None:
            tables = coupling_tables(*grid.shape, grid.dx, grid.dy)
            self._normal = (convolution.quadrant_spectrum(tables[0], (-1, 1)),
                            convolution.quadrant_spectrum(tables[1], (1, -1)))
        total = convolution.forward(traction[0])
        multiply(total, self._normal[0], out=total)
        if traction[1].any():
            hat = convolution.forward(traction[1])
            total += multiply(hat, self._normal[1], out=hat)
        return self.constant * convolution.inverse(turn(total))

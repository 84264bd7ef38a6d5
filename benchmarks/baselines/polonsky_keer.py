"""Polonsky & Keer's conjugate gradients for the normal problem (Wear 231, 1999, 206–219), on the same convolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.halfspace.elastic import normal_table
from thermoroll_cli.numerics.convolution import Convolution, multiply
from thermoroll_cli.numerics.grid import Grid

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PolonskyKeerSolution:
    """`pressure` in Pa on the grid; two `applications` of the convolution per iteration; `residual` as in `NormalSolution`."""

    pressure: Array
    iterations: int
    applications: int
    residual: float
    converged: bool


class PolonskyKeer:
    """Keeps the kernel and the plans for one grid."""

    def __init__(self, grid: Grid, contact_modulus: float) -> None:
        nx, ny = grid.shape
        self.grid = grid
        self.applications = 0
        self._convolution = Convolution(nx, ny)
        self._kernel = self._convolution.quadrant_spectrum(normal_table(nx, ny, grid.dx, grid.dy, contact_modulus))

    def displacement(self, pressure: Array) -> Array:
        self.applications += 1
        hat = self._convolution.forward(pressure)
        return self._convolution.inverse(multiply(hat, self._kernel, out=hat))

    def solve(self, gap: Array, normal_force: float, tolerance: float, max_iterations: int = 2000) -> PolonskyKeerSolution:
        """Contact pressure of surfaces `gap` apart (m, (nx, ny)) from a flat start."""
        before = self.applications
        load = normal_force / self.grid.element_area
        pressure = np.full(self.grid.shape, load / gap.size)
        direction = np.zeros(self.grid.shape)
        old, delta, residual, iterations = 1.0, 0.0, np.inf, 0
        for _ in range(max_iterations):
            iterations += 1
            displacement = self.displacement(pressure)
            opening = displacement + gap
            contact = pressure > 0.0
            opening -= opening[contact].mean()
            squares = float((opening[contact] ** 2).sum())
            residual = np.sqrt(squares / np.count_nonzero(contact)) / float(np.abs(displacement[contact]).mean())
            if residual <= tolerance and not (opening[~contact] < -tolerance * np.abs(displacement).max()).any():
                break
            direction = np.where(contact, opening + delta * (squares / old) * direction, 0.0)
            old = squares
            image = self.displacement(direction)
            image -= image[contact].mean()
            step = float((opening * direction)[contact].sum()) / float((image * direction)[contact].sum())
            pressure = np.where(contact, pressure - step * direction, 0.0)
            np.maximum(pressure, 0.0, out=pressure)
            overlap = (pressure == 0.0) & (opening < 0.0)
            delta = 0.0 if overlap.any() else 1.0
            pressure[overlap] -= step * opening[overlap]
            pressure *= load / float(pressure.sum())
        else:
            return PolonskyKeerSolution(pressure, iterations, self.applications - before, float(residual), False)
        return PolonskyKeerSolution(pressure, iterations, self.applications - before, float(residual), True)

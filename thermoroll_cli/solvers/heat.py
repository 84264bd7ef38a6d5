"""Temperature and thermal expansion of both surfaces from the heat flux between them (Eqs. 17–20)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.convolution import Convolution
from thermoroll_cli.kernels.grid import Grid
from thermoroll_cli.kernels.thermal import displacement_table, temperature_table

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]


@dataclass(frozen=True)
class HeatedBody:
    """One body as its surface sees the heat: conductivity k, (1 + ν)α, diffusivity κ, its share of the heat, and the
    velocity (m/s) at which its material passes through the contact."""

    conductivity: float
    free_expansion: float
    diffusivity: float
    share: float
    speed_x: float
    speed_y: float = 0.0


class HeatResponse:
    """Free-space kernels of both bodies on one grid, built when first asked for.

    `tables` counts influence tables built: equal bodies at equal speed share theirs.
    """

    def __init__(self, grid: Grid, lower: HeatedBody, upper: HeatedBody) -> None:
        self.grid = grid
        self.bodies = (lower, upper)
        self.tables = 0
        self._convolution: Convolution | None = None
        self._temperature: dict[tuple[float, float], Spectrum] = {}
        self._expansion: Spectrum | None = None

    def _peclets(self, body: HeatedBody) -> tuple[float, float]:
        """V dx/κ along x and y: what the tables are made for."""
        return body.speed_x * self.grid.dx / body.diffusivity, body.speed_y * self.grid.dx / body.diffusivity

    @property
    def convolution(self) -> Convolution:
        if self._convolution is None:
            self._convolution = Convolution(*self.grid.shape)
        return self._convolution

    @property
    def transforms(self) -> int:
        return self._convolution.transforms if self._convolution is not None else 0

    def _expansion_spectrum(self) -> Spectrum:
        """Both bodies in one kernel: the gap only feels the sum of their expansions, so one table product serves both."""
        if self._expansion is None:
            grid = self.grid
            weights: dict[tuple[float, float], float] = {}
            for body in self.bodies:
                factor = body.share * body.free_expansion * grid.dx**2 / body.conductivity
                key = self._peclets(body)
                weights[key] = weights.get(key, 0.0) + factor
            total = np.zeros((2 * grid.nx - 1, 2 * grid.ny - 1))
            for key, factor in weights.items():
                if factor:
                    self.tables += 1
                    total += factor * displacement_table(grid.nx, grid.ny, grid.dy / grid.dx, *key)
            self._expansion = self.convolution.spectrum(total)
        return self._expansion

    def displacement(self, heat_flux: Array) -> Array:
        """u_z^t > 0 in m: expansion of both bodies towards each other, up to a constant for stationary sources."""
        spectrum = self._expansion_spectrum()
        hat = self.convolution.forward(heat_flux)
        hat *= spectrum
        return self.convolution.inverse(hat)

    def temperatures(self, heat_flux: Array) -> tuple[Array, Array]:
        """Surface temperature rise in K of the lower and of the upper body, for the total `heat_flux` in W/m²."""
        grid = self.grid
        hat = self.convolution.forward(heat_flux)
        rises: list[Array] = []
        for body in self.bodies:
            key = self._peclets(body)
            if key not in self._temperature:
                self.tables += 1
                table = temperature_table(grid.nx, grid.ny, grid.dy / grid.dx, *key)
                self._temperature[key] = self.convolution.spectrum(table)
            rise = self.convolution.inverse(hat * self._temperature[key])
            rises.append(rise * (body.share * grid.dx / body.conductivity))
        return rises[0], rises[1]

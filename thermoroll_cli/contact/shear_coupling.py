"""How pressure and shear act on each other between different bodies (Dundurs' β)."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array, Spectrum
from thermoroll_cli.halfspace.elastic import coupling_tables
from thermoroll_cli.numerics.convolution import Convolution
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.numerics.stencils import DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS


class NormalShearCoupling:
    """Both directions of the coupling on one grid, for K of `coupling_constant` (1/Pa) and the difference formula `weights`.

    The tangential problem sees the pressure as a further part of its rigid slip, −∂u^p/∂x (`tangential_gradient`); the normal
    problem sees the tractions as an offset of its gap, like a thermal expansion (`normal_displacement`). Neither solver has to
    know more. Kernels and the derivation of their signs: `coupling_tables`.
    """

    def __init__(self, grid: Grid, constant: float, weights: tuple[float, ...] = UPSTREAM_WEIGHTS) -> None:
        self.grid, self.constant, self._weights = grid, constant, weights
        self._convolution = Convolution(*grid.shape)
        self._gradient_kernels: list[Spectrum] = []
        self._displacement_kernels: list[Spectrum] = []

    @property
    def transforms(self) -> int:
        return self._convolution.transforms

    def _tables(self) -> tuple[Array, Array]:
        """J_x and J_y in m at offsets −(nx+1)…nx+1 by −(ny−1)…ny−1."""
        grid = self.grid
        j_x, j_y = coupling_tables(grid.nx + 2, grid.ny, grid.dx, grid.dy)
        return _all_offsets(j_x, -1, 1), _all_offsets(j_y, 1, -1)

    def tangential_gradient(self, pressure: Array) -> Array:
        """∂u^p/∂x, (2, nx, ny): gradient of the relative tangential displacement by the pressure (nx, ny) in Pa.

        By the difference formula that the tractions' displacement is differentiated with: where the surfaces stick the two
        displacements add up to a straight line, and that formula has no error on straight lines. The exact derivative of
        u^p leaves ten times the error in the forces (docs/numerics.md)."""
        if not self._gradient_kernels:
            n = self.grid.nx
            scale = self.constant / self.grid.dx
            for table in self._tables():
                terms = (w * table[k + 2 : k + 2 + 2 * n - 1] for k, w in
                         zip(DIFFERENCE_OFFSETS, self._weights, strict=True))
                self._gradient_kernels.append(self._convolution.spectrum(scale * sum(terms, start=np.zeros(()))))
        hat = self._convolution.forward(pressure)
        return np.stack([self._convolution.inverse(hat * kernel) for kernel in self._gradient_kernels])

    def normal_displacement(self, traction: Array) -> Array:
        """−u_z^τ in m, (nx, ny): by how much the tractions (2, nx, ny) in Pa bring the surfaces towards each other."""
        if not self._displacement_kernels:
            self._displacement_kernels = [self._convolution.spectrum(self.constant * table[2:-2]) for table in self._tables()]
        total = self._convolution.forward(traction[0])
        total *= self._displacement_kernels[0]
        if traction[1].any():
            hat = self._convolution.forward(traction[1])
            hat *= self._displacement_kernels[1]
            total += hat
        return self._convolution.inverse(total)


def _all_offsets(quadrant: Array, parity_x: int, parity_y: int) -> Array:
    """(n, m) at offsets ≥ 0 -> (2n−1, 2m−1) at all offsets, for a kernel even (1) or odd (−1) along each axis."""
    half = np.concatenate([parity_x * quadrant[:0:-1], quadrant])
    return np.concatenate([parity_y * half[:, :0:-1], half], axis=1)

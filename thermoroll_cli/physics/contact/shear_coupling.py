"""Coupling of pressure and shear between bodies of unlike elasticity (Dundurs' β, or coatings)."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.physics.halfspace.bodies import Bodies, Coupling
from thermoroll_cli.physics.numerics.convolution import Convolution
from thermoroll_cli.physics.numerics.grid import DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS, Grid
from thermoroll_cli.tools.arrays import Array, Spectrum


class NormalShearCoupling:
    """Both directions of the coupling of two `bodies` on one grid, with the `weights` of the difference formula.

    In the tangential problem the pressure is a further part of the rigid slip, −∂u^p/∂x (`tangential_gradient`); in the normal
    problem the tractions are an offset of the gap, like a thermal expansion (`normal_displacement`). Kernels and the derivation
    of their signs: `coupling_tables`.
    """

    def __init__(self, grid: Grid, bodies: Bodies, weights: tuple[float, ...] = UPSTREAM_WEIGHTS) -> None:
        self.grid, self.bodies, self._weights = grid, bodies, weights
        self._convolution = Convolution(*grid.shape)
        self._gradient_kernels: list[Spectrum] = []
        self._displacement_kernels: list[Spectrum] = []

    def _tables(self) -> Coupling:
        """Those of the bodies, with two rows more at either end."""
        return self.bodies.coupling_tables(self.grid.nx + 2, self.grid.ny, self.grid.dx, self.grid.dy)

    def tangential_gradient(self, pressure: Array) -> Array:
        """∂u^p/∂x, (2, nx, ny): gradient of the relative tangential displacement by the pressure (nx, ny) in Pa.

        Uses the same difference formula as for the displacement by tractions: where the surfaces stick the two displacements
        add up to a straight line, on which that formula is exact. With the exact derivative of u^p the error of the forces is
        ten times larger (docs/numerics.md)."""
        if not self._gradient_kernels:
            n = self.grid.nx
            for parts in self._tables():
                kernel = np.zeros(())
                for factor, table in parts:
                    terms = (w * table[k + 2 : k + 2 + 2 * n - 1] for k, w in
                             zip(DIFFERENCE_OFFSETS, self._weights, strict=True))
                    kernel = kernel + factor / self.grid.dx * sum(terms, start=np.zeros(()))
                self._gradient_kernels.append(self._convolution.spectrum(kernel))
        hat = self._convolution.forward(pressure)
        return np.stack([self._convolution.inverse(hat * kernel) for kernel in self._gradient_kernels])

    def _with_displacement_kernels(self) -> None:
        if not self._displacement_kernels:
            self._displacement_kernels = [
                self._convolution.spectrum(sum((factor * table[2:-2] for factor, table in parts), start=np.zeros(())))
                for parts in self._tables()]

    def tangential_displacement(self, pressure: Array) -> Array:
        """u^p in m, (2, nx, ny): the relative tangential displacement by the pressure (nx, ny) in Pa."""
        self._with_displacement_kernels()
        hat = self._convolution.forward(pressure)
        return np.stack([self._convolution.inverse(hat * kernel) for kernel in self._displacement_kernels])

    def hysteresis(self, pressure: Array, traction: Array) -> float:
        """∬ (τ·∂u^p/∂x + p ∂u_z^τ/∂x) in N: what both lose by their coupling in bodies that relax, per distance rolled."""
        if not self.bodies.relaxes:
            return 0.0
        self._with_displacement_kernels()
        pressed = self._convolution.forward(pressure)
        return -2.0 * self.grid.element_area / self.grid.dx * sum(
            self._convolution.drift(kernel.real * np.imag(self._convolution.forward(part).conj() * pressed))
            for part, kernel in zip(traction, self._displacement_kernels, strict=True) if part.any())

    def normal_displacement(self, traction: Array) -> Array:
        """−u_z^τ in m, (nx, ny): displacement of the surfaces towards each other by the tractions (2, nx, ny) in Pa."""
        self._with_displacement_kernels()
        total = self._convolution.forward(traction[0])
        total *= self._displacement_kernels[0]
        if traction[1].any():
            hat = self._convolution.forward(traction[1])
            hat *= self._displacement_kernels[1]
            total += hat
        return self._convolution.inverse(total)

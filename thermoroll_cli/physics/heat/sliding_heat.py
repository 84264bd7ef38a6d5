"""Thermal response if every source has its own Péclet number, that of the local slip speed (after Eq. 20).

In the article heat travels with the sliding speed, which differs from point to point in rolling contact. Every source
element x' then has its own kernel of Pe(x') = |ṡ(x')| l/κ, and T(x) = Σ K_Pe(x')(x − x') q(x') becomes a short sum of
convolutions (`variable_peclet`).

**Direction.** The speed is that of the slip, the direction that of rolling: the material of both bodies moves along +x, as it
passes through the contact, whatever the direction of slip. Temperatures are therefore consistent if creepages are reversed,
bodies exchanged or the problem mirrored. With the article's Pe_x, Pe_y, the components of the slip, the wake of lateral slip
lies beside the contact and that of negative slip ahead of it, for both bodies. Both choices agree if slip is along +x or the
Péclet number is small.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from thermoroll_cli.physics.halfspace.thermal import temperature_table
from thermoroll_cli.physics.halfspace.variable_peclet import PecletWeights, ThermalKind, variable_peclet_tables
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, thermal_admittance
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array

Expansion = tuple[list[Spectrum], PecletWeights]


class SlidingKernels:
    """Expansions on one grid, kept from one state to the next.

    An expansion covers Péclet numbers up to a power of two: it serves states with half to all of that slip, and does not
    depend on the states before. The last eight are kept: two ranges for each body and each kind, because the slip speed may
    vary about the end of a range.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.convolution = Convolution(*grid.shape)
        self.expansion = lru_cache(maxsize=8)(self._expansion)

    def covering(self, kind: ThermalKind, peclet: float) -> Expansion:
        """The expansion for Péclet numbers V dx/κ up to `peclet`."""
        return self.expansion(kind, 2.0 ** math.ceil(math.log2(peclet)) if peclet > 0.0 else 0.0)

    def _expansion(self, kind: ThermalKind, limit: float) -> Expansion:
        grid = self.grid
        tables, weights = variable_peclet_tables(grid.nx, grid.ny, grid.dy / grid.dx, limit, kind)
        return [self.convolution.spectrum(table) for table in tables], weights


class SlidingHeatResponse:
    """Response of two bodies that slip at `slip_speed` (m/s, (nx, ny), ≥ 0) against each other.

    The speeds of the bodies themselves (`HeatedBody.speed_x`, `speed_y`) do not matter here.
    """

    def __init__(self, kernels: SlidingKernels, lower: HeatedBody, upper: HeatedBody, slip_speed: Array) -> None:
        self.grid = kernels.grid
        self.bodies = (lower, upper)
        self._kernels = kernels
        self._slip_speed = slip_speed
        self._fastest = float(slip_speed.max())
        self._used: dict[tuple[ThermalKind, float], tuple[Expansion, Array, Array]] = {}
        self._symbol: Spectrum | None = None

    @property
    def _alike(self) -> bool:
        """True if both bodies have the same kernels."""
        return self.bodies[0].diffusivity == self.bodies[1].diffusivity

    @property
    def matched_share(self) -> float | None:
        lower, upper = (body.conductivity for body in self.bodies)
        return lower / (lower + upper) if self._alike else None

    @property
    def likely_share(self) -> float:
        lower, upper = (thermal_admittance(self.grid, body, 0.5 * self._fastest) for body in self.bodies)
        return lower / (lower + upper)

    def displacement(self, heat: DividedHeat) -> Array:
        """As `ThermalResponse`; one expansion if the bodies are of one diffusivity."""
        lower, upper = self.bodies
        scaled = [
            flux * (body.free_expansion * self.grid.dx**2 / body.conductivity)
            for body, flux in zip(self.bodies, (heat.lower, heat.upper), strict=True)
        ]
        if self._alike:
            return self._respond("displacement", lower, scaled[0] + scaled[1])
        return self._respond("displacement", lower, scaled[0]) + self._respond("displacement", upper, scaled[1])

    def temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        lower, upper = self.bodies
        if self._alike and heat.exchanged is None:
            rise = self._respond("temperature", lower, heat.total) * self.grid.dx
            return (rise * (heat.share / lower.conductivity), rise * ((1.0 - heat.share) / upper.conductivity))
        return self._rise(lower, heat.lower), self._rise(upper, heat.upper)

    def temperature_difference(self, exchange: Array) -> Array:
        lower, upper = self.bodies
        if self._alike:
            rise = self._respond("temperature", lower, exchange)
            return rise * (self.grid.dx * (1.0 / lower.conductivity + 1.0 / upper.conductivity))
        return self._rise(lower, exchange) + self._rise(upper, exchange)

    def difference_symbol(self) -> tuple[Convolution, Spectrum]:
        """As `ThermalResponse`, for sources that all slip at the mean speed of those that slip."""
        if self._symbol is None:
            grid = self.grid
            slipping = self._slip_speed > 0.0
            speed = float(self._slip_speed[slipping].mean()) if slipping.any() else 0.0
            table = np.zeros((2 * grid.nx - 1, 2 * grid.ny - 1))
            for body in self.bodies:
                kernel = temperature_table(grid.nx, grid.ny, grid.dy / grid.dx, speed * grid.dx / body.diffusivity)
                table += kernel * (grid.dx / body.conductivity)
            self._symbol = self._kernels.convolution.spectrum(table)
        return self._kernels.convolution, self._symbol

    def mean_peclet(self, flux: Array) -> float:
        """Mean of |ṡ| l/κ, weighted with `flux`, of the body with the larger one; l is half the side of the grid."""
        size = 0.5 * self.grid.size
        slowest = min(body.diffusivity for body in self.bodies)
        return float((self._slip_speed * flux).sum() / flux.sum()) * size / slowest

    def report(self) -> dict[str, float]:
        """Terms and error of the expansions used so far: `terms_temperature`, `terms_displacement` (of the body that needs
        more) and `error`."""
        result: dict[str, float] = {}
        for (kind, _), ((_, weights), _, _) in self._used.items():
            name = f"terms_{kind}"
            result[name] = max(result.get(name, 0), weights.terms)
            result["error"] = max(result.get("error", 0.0), weights.error)
        return result

    def _rise(self, body: HeatedBody, flux: Array) -> Array:
        return self._respond("temperature", body, flux) * (self.grid.dx / body.conductivity)

    def _respond(self, kind: ThermalKind, body: HeatedBody, flux: Array) -> Array:
        """Σ K_P(x')(x − x') flux(x') in the units of the tables."""
        key = kind, body.diffusivity
        if key not in self._used:
            peclet = self._slip_speed * (self.grid.dx / body.diffusivity)
            expansion = self._kernels.covering(kind, float(peclet.max()))
            self._used[key] = expansion, expansion[1](peclet), expansion[1].offset(peclet)
        (spectra, _), weights, offset = self._used[key]
        convolution = self._kernels.convolution
        total = np.zeros((convolution.half, convolution.px), dtype=np.complex128)
        for weight, spectrum in zip(weights, spectra, strict=True):
            hat = convolution.forward(weight * flux)
            hat *= spectrum
            total += hat
        return convolution.inverse(total) + float((offset * flux).sum())

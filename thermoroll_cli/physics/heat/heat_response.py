"""Temperature and thermal expansion of both surfaces from the heat that enters them (Eqs. 17–20)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np

from thermoroll_cli.physics.halfspace.layered_thermal import LayeredHeat, LayeredQuantity
from thermoroll_cli.physics.halfspace.thermal import displacement_table, slopes, temperature_slope_table, temperature_table
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class HeatedBody:
    """Constants of one body's thermal response: conductivity k, (1 + ν)α, diffusivity κ, and the velocity (m/s) at which its
    material passes through the contact. Below `layers` the constants are those of the top material."""

    conductivity: float
    free_expansion: float
    diffusivity: float
    speed_x: float
    speed_y: float = 0.0
    layers: LayeredHeat | None = None

    def layered_table(self, quantity: LayeredQuantity, grid: Grid, *, slope: bool = False) -> Array:
        """Contribution of the coatings per flux (`LayeredHeat.table`)."""
        assert self.layers is not None
        return self.layers.table(quantity, grid.shape, (grid.dx, grid.dy), (self.speed_x, self.speed_y), slope=slope)


Likeness = tuple[float, float, LayeredHeat | None]
"""V dx/κ along x and y, and coatings: bodies with the same ones have proportional responses."""


@dataclass(frozen=True)
class DividedHeat:
    """Frictional heat flux `total` ≥ 0 in W/m², (nx, ny), of which the share `share` enters the lower body at every point, and
    the additional flux `exchanged` from the upper to the lower body, of either sign (None: none). `total` changes by `slope`
    along x through each element (None: by differences of its neighbours, `thermal.slopes`)."""

    total: Array
    share: float
    exchanged: Array | None = None
    slope: Array | None = None

    @property
    def lower(self) -> Array:
        """Heat flux into the lower body."""
        own = self.share * self.total
        return own if self.exchanged is None else np.asarray(own + self.exchanged)

    @property
    def upper(self) -> Array:
        """Heat flux into the upper body."""
        own = (1.0 - self.share) * self.total
        return own if self.exchanged is None else np.asarray(own - self.exchanged)


class ThermalResponse(Protocol):
    """Linear response of two surfaces to heat, for one state of motion."""

    @property
    def matched_share(self) -> float | None:
        """Share of the lower body for which both surfaces are equally warm everywhere; None if there is no such share."""

    @property
    def likely_share(self) -> float:
        """Approximate share of the lower body for which both surfaces are equally warm on average."""

    def displacement(self, heat: DividedHeat) -> Array:
        """u_z^t > 0 in m: expansion of both bodies towards each other, up to a constant for sources at rest."""

    def temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        """Surface temperature rise in K of the lower and of the upper body."""

    def temperature_difference(self, exchange: Array) -> Array:
        """Temperature of the lower less that of the upper surface under the flux `exchange` from the upper to the lower
        body."""

    def difference_symbol(self) -> tuple[Convolution, Spectrum]:
        """A convolution and the spectrum with which it equals or approximates `temperature_difference`."""


MOST_TABLES = 6
"""Number of tables that are kept: those built last."""
INTERPOLATION_NODES = 5, 4, 3
"""Numbers of tables that an interpolation tries to use."""
INTERPOLATION_TOLERANCE = 1e-6
"""Largest change of an interpolated table by its last node, over the largest coefficient; the error is a hundredth of it."""
SMALL, MOST_SMALL = 64, 128
"""Tables of grids with as many elements a side, and the number of them that are kept as long as the process lives, 16 MB at
most: a fit asks for the same ones with each value that it tries. Without: a fit of the twin disc takes 1.2 times as long."""
LARGEST_WEIGHTS = 16.0
"""Largest sum of the weights' magnitudes: they amplify the rounding and quadrature errors of tables."""


class KeptTables:
    """Influence tables of thermal expansion by Péclet numbers: those built last are kept, and a table between them, or slightly
    beyond, is interpolated in ln |P| if that is accurate enough. Neighbouring problems share them.

    If a force is prescribed every iteration has other speeds: this then saves a third of the CPU time of a point of a sweep,
    and a fifth of a single solve. Tables of temperature are built forty times as fast, and are not kept."""

    def __init__(self) -> None:
        self._known: list[tuple[tuple[int, int, float], tuple[float, float], Array]] = []

    def __call__(self, grid: Grid, peclets: tuple[float, float]) -> Array:
        """The table of `grid` at the Péclet numbers V dx/κ along x and y; callers must not change it."""
        shape = grid.nx, grid.ny, float(f"{grid.dy / grid.dx:.12g}")
        known = [(key, table) for like, key, table in self._known if like == shape]
        for key, table in known:
            if key == peclets:
                return table
        new = self._interpolated([(math.log(key[0] / peclets[0]), table) for key, table in known
                                  if key[1] == peclets[1] and key[0] * peclets[0] > 0.0])
        if new is None:
            build = small_table if max(grid.shape) <= SMALL else displacement_table
            new = build(grid.nx, grid.ny, grid.dy / grid.dx, *peclets)
            self._known = [*self._known[1 - MOST_TABLES :], (shape, peclets, new)]
        return new

    @staticmethod
    def _interpolated(nodes: list[tuple[float, Array]]) -> Array | None:
        """The table at 0 from the nearest ones at other places; None if it would not be accurate enough."""
        nodes = sorted(nodes, key=lambda node: abs(node[0]))
        for count in (n for n in INTERPOLATION_NODES if n <= len(nodes)):
            places, tables = np.array([place for place, _ in nodes[:count]]), [table for _, table in nodes[:count]]
            weights, without = _weights_at_zero(places), np.append(_weights_at_zero(places[:-1]), 0.0)
            if np.abs(weights).sum() > LARGEST_WEIGHTS:
                continue
            change = sum(w * table for w, table in zip(weights - without, tables, strict=True))
            if np.abs(change).max() <= INTERPOLATION_TOLERANCE * np.abs(tables[0]).max():
                return np.asarray(sum(w * table for w, table in zip(weights, tables, strict=True)))
        return None


@lru_cache(maxsize=MOST_SMALL)
def small_table(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float) -> Array:
    """A `displacement_table` that is kept; callers must not change it."""
    return displacement_table(nx, ny, aspect, peclet_x, peclet_y)


def _weights_at_zero(places: Array) -> Array:
    """Lagrange's weights at 0 of values at different `places`."""
    return np.array([np.prod([other / (other - place) for other in places if other != place]) for place in places])


class HeatResponse:
    """Bodies whose material passes at one velocity each: free-space kernels on one grid, built when first asked for.

    For temperatures frictional heat changes linearly along x within each element (`thermal.temperature_slope_table`): they are
    those at the elements' centres, at second order. Equal bodies at equal speed share their tables."""

    def __init__(self, grid: Grid, lower: HeatedBody, upper: HeatedBody, expansion: KeptTables | None = None) -> None:
        self.grid = grid
        self._expansion_tables = expansion or KeptTables()
        self.bodies = (lower, upper)
        self._temperature: dict[tuple[Likeness, bool], Spectrum] = {}
        self._expansion: dict[tuple[float, float], Spectrum] = {}

    @cached_property
    def convolution(self) -> Convolution:
        return Convolution(*self.grid.shape)

    @property
    def matched_share(self) -> float | None:
        lower, upper = self.bodies
        if _likeness(self.grid, lower) != _likeness(self.grid, upper):
            return None
        return lower.conductivity / (lower.conductivity + upper.conductivity)

    @property
    def likely_share(self) -> float:
        lower, upper = (thermal_admittance(self.grid, b, math.hypot(b.speed_x, b.speed_y)) for b in self.bodies)
        return lower / (lower + upper)

    def displacement(self, heat: DividedHeat) -> Array:
        """As `ThermalResponse`. The gap depends on the sum of both expansions, so heat with the same share everywhere needs
        one forward and one inverse transform for any bodies."""
        convolution = self.convolution
        if heat.exchanged is None:
            hat = convolution.forward(heat.total)
            hat *= self._joint_expansion(heat.share, 1.0 - heat.share)
            return convolution.inverse(hat)
        hat = convolution.forward(heat.lower)
        hat *= self._joint_expansion(1.0, 0.0)
        hat += convolution.forward(heat.upper) * self._joint_expansion(0.0, 1.0)
        return convolution.inverse(hat)

    def temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        """As `ThermalResponse`. Exchanged heat is constant in each element: it may change its sign from one element to the
        next, and slopes would make surfaces colder than their surroundings."""
        lower, upper = self.bodies
        flux, slope = (self.convolution.forward(field) for field in (heat.total, self.changes(heat)))
        exchanged = None if heat.exchanged is None else self.convolution.forward(heat.exchanged)
        return (self._rise(lower, flux, slope, heat.share, exchanged, 1.0),
                self._rise(upper, flux, slope, 1.0 - heat.share, exchanged, -1.0))

    def interface_temperatures(self, heat: DividedHeat) -> tuple[Array | None, Array | None]:
        """Temperature rise in K below the outermost coating of the lower and of the upper body, None without one."""
        changes = self.changes(heat)
        lower, upper = (None if body.layers is None else self._below(body, into, share * changes) for body, into, share in zip(
            self.bodies, (heat.lower, heat.upper), (heat.share, 1.0 - heat.share), strict=True))
        return lower, upper

    def changes(self, heat: DividedHeat) -> Array:
        """Change of the heat flux through each element along x."""
        # The laws of slip zones may give negative heat at one end of an element, but not at the one where material enters.
        entered_behind = min(body.speed_x for body in self.bodies) < 0.0
        return slopes(heat.total) if heat.slope is None or entered_behind else heat.slope

    def _below(self, body: HeatedBody, flux: Array, slope: Array) -> Array:
        convolution = self.convolution
        hat = convolution.forward(flux) * convolution.spectrum(body.layered_table("interface", self.grid))
        hat += convolution.forward(slope) * convolution.spectrum(body.layered_table("interface", self.grid, slope=True))
        return convolution.inverse(hat)

    def temperature_difference(self, exchange: Array) -> Array:
        convolution, spectrum = self.difference_symbol()
        hat = convolution.forward(exchange)
        hat *= spectrum
        return convolution.inverse(hat)

    def difference_symbol(self) -> tuple[Convolution, Spectrum]:
        return self.convolution, self._gap

    @cached_property
    def _gap(self) -> Spectrum:
        lower, upper = (self._temperature_spectrum(body) * (self.grid.dx / body.conductivity) for body in self.bodies)
        return np.asarray(lower + upper)

    def _rise(
        self, body: HeatedBody, flux: Spectrum, slope: Spectrum, share: float, exchanged: Spectrum | None, sign: float
    ) -> Array:
        """Temperature of a body that `share` of a flux and `sign` times the exchanged flux enter; all given as transforms."""
        own = share * flux
        if exchanged is not None:
            own += sign * exchanged
        own *= self._temperature_spectrum(body)
        own += share * slope * self._temperature_spectrum(body, slope=True)
        rise = self.convolution.inverse(own)
        rise *= self.grid.dx / body.conductivity
        return rise

    def _temperature_spectrum(self, body: HeatedBody, *, slope: bool = False) -> Spectrum:
        """Kernel of the temperature of a body, or of that by heat that changes along x within its element (`slope`)."""
        grid, likeness = self.grid, _likeness(self.grid, body)
        if (likeness, slope) not in self._temperature:
            build = temperature_slope_table if slope else temperature_table
            table = build(grid.nx, grid.ny, grid.dy / grid.dx, *likeness[:2])
            if body.layers is not None:
                table = table + body.layered_table("temperature", grid, slope=slope) * (body.conductivity / grid.dx)
            self._temperature[likeness, slope] = self.convolution.spectrum(table)
        return self._temperature[likeness, slope]

    def _joint_expansion(self, lower: float, upper: float) -> Spectrum:
        """Kernel of the sum of both expansions if these shares of a heat flux enter the bodies."""
        shares = lower, upper
        if shares not in self._expansion:
            grid = self.grid
            total = np.zeros((2 * grid.nx - 1, 2 * grid.ny - 1))
            for body, share in zip(self.bodies, shares, strict=True):
                if body.layers is not None and share:
                    total += share * body.layered_table("expansion", grid)
                if factor := share * body.free_expansion * grid.dx**2 / body.conductivity:
                    total += factor * self._expansion_tables(grid, _likeness(grid, body)[:2])
            self._expansion[shares] = self.convolution.spectrum(total)
        return self._expansion[shares]


def thermal_admittance(grid: Grid, body: HeatedBody, speed: float) -> float:
    """Relative thermal admittance of a body at the size of the grid: k for material at rest, k sqrt(P) for fast material."""
    size = 0.5 * grid.size
    return body.conductivity * math.sqrt(1.0 + abs(speed) * size / body.diffusivity)


def _likeness(grid: Grid, body: HeatedBody) -> Likeness:
    return body.speed_x * grid.dx / body.diffusivity, body.speed_y * grid.dx / body.diffusivity, body.layers

"""Stresses and temperatures on planes of one depth: the responses of single elements, convolved with the loads by FFT."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.physics.halfspace.layered import LayeredBody
from thermoroll_cli.physics.halfspace.layered_stress import element_stresses
from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress, traction_y_stress
from thermoroll_cli.physics.halfspace.subsurface_thermal import thermal_stress
from thermoroll_cli.physics.halfspace.thermal import temperature_at_depths
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum, both_sides, in_pairs, multiply, quadrant_symbol
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array, Mask

ODD_IN_Y = (False, False, False, True, False, True)
"""Which of the stresses xx yy zz xy xz yz change sign in the mirror y → −y."""
ODD_IN_X = (False, False, False, True, True, False)

TABLE_BYTES = 64 * 2**20
"""Memory of the thermal tables computed together: depths share most of the cost, but each needs its own memory."""


@dataclass(frozen=True)
class SurfaceLoad:
    """Loads on one body as element averages, and constants of its material (SI, arrays (nx, ny)).

    `pressure` pushes into the body; `traction` (2, nx, ny), times `sign`, is the force per area on the body (σ_xz = −t_x at
    the surface), None if there is none; `heat` is the flux into the body, None if thermal stresses are left out.
    `poisson_ratio` is that of the surface, `layered` the body if it is coated.
    `thermal_modulus` is Eα/(1−ν) in Pa/K, `speed` the velocity (m/s) of the material through the contact, `surface_rise` the
    temperature rise (K) of the surface if it is known better than from averages."""

    pressure: Array
    traction: Array | None
    heat: Array | None
    poisson_ratio: float
    sign: float = 1.0
    thermal_modulus: float = 0.0
    conductivity: float = 1.0
    diffusivity: float = 1.0
    speed: tuple[float, float] = (0.0, 0.0)
    surface_rise: Array | None = None
    layered: LayeredBody | None = None

    def elastic(self, by_pressure: Array, by_traction: Array | None) -> Array:
        """Stresses in this body from those of `ElasticStresses.at`."""
        return by_pressure if by_traction is None else by_pressure + self.sign * by_traction


BEYOND = 4
"""Length along x over which histories are followed, over that of the domain, and length of the elements outside over that of
the domain's."""


@dataclass(frozen=True)
class Beyond:
    """The loads of a domain on a `grid` that is some times as long, of elements as many times as long; `outside` are those
    outside the domain, (n,)."""

    grid: Grid
    load: SurfaceLoad
    outside: Mask

    @classmethod
    def of(cls, grid: Grid, load: SurfaceLoad, times: int = BEYOND, inside: float = 1.0) -> Beyond:
        """`times` as long as the domain `grid`; what counts as `inside` is so many domains long."""
        count = -(-grid.nx // times)
        missing, margin = count * times - grid.nx, -(-count * (times - 1) // 2)

        def lengthened(field: Array) -> Array:
            """Averages along x, with nothing on both sides."""
            whole = np.pad(field, ((0, missing), (0, 0)))
            return np.pad(whole.reshape(count, times, -1).mean(axis=1), ((margin, margin), (0, 0)))

        centre = grid.centre_x + 0.5 * missing * grid.dx
        wide = Grid(count + 2 * margin, grid.ny, times * grid.dx, grid.dy, grid.centre, centre)
        traction = None if load.traction is None else np.stack([lengthened(field) for field in load.traction])
        heat = None if load.heat is None else lengthened(load.heat)
        reach = 0.5 * (inside * grid.nx * grid.dx + wide.dx)
        return cls(wide, replace(load, pressure=lengthened(load.pressure), traction=traction, heat=heat, surface_rise=None),
                   np.abs(wide.x - grid.centre_x) >= reach * (1.0 - 1e-9))

    def history(self, elastic: Array, thermal: tuple[Array, Array] | None) -> tuple[Array, Array]:
        """Elastic and total stresses (6, n, columns) outside the domain, from those on the whole `grid`: at its elements and,
        by cubics, midway between them."""
        total = elastic if thermal is None else elastic + thermal[0]
        between = self.outside[1:-2] & self.outside[2:-1]

        def refined(stress: Array) -> Array:
            midway = (9.0 * (stress[:, 1:-2] + stress[:, 2:-1]) - stress[:, :-3] - stress[:, 3:]) / 16.0
            return np.concatenate([stress[:, self.outside], midway[:, between]], axis=1)

        outer = refined(elastic)
        return outer, outer if thermal is None else refined(total)


class StressTransforms:
    """Free-space convolutions of loads on one grid; results on the whole grid or, for mirror-symmetric states, for y > 0."""

    def __init__(self, grid: Grid, mirrored: bool) -> None:
        self.grid, self.mirrored = grid, mirrored
        self.plane = Convolution(grid.nx, grid.ny)
        self.columns = grid.ny // 2 if mirrored else grid.ny
        """Number of columns in the results: the last ones of the grid."""

    def back(self, spectra: list[Spectrum], odd: tuple[bool, ...]) -> Array:
        """Fields (n, nx, columns) of `spectra`, some of them `odd` in y.

        For mirror-symmetric states one transform of a sum gives an even and an odd field, from both halves of the result."""
        out = np.empty((len(spectra), self.grid.nx, self.columns))
        if not self.mirrored:
            for target, spectrum in zip(out, spectra, strict=True):
                self.plane.inverse(spectrum, target)
            return out
        evens = [i for i, is_odd in enumerate(odd) if not is_odd]
        odds = [i for i, is_odd in enumerate(odd) if is_odd]
        while evens or odds:
            even, other = evens.pop(0) if evens else None, odds.pop(0) if odds else None
            parts = [spectra[i] for i in (even, other) if i is not None]
            whole = self.plane.inverse(parts[0] if len(parts) == 1 else parts[0] + parts[1])
            near, far = whole[:, self.columns :], whole[:, self.columns - 1 :: -1]
            if even is not None:
                np.add(near, far, out=out[even])
                out[even] *= 0.5
            if other is not None:
                np.subtract(near, far, out=out[other])
                out[other] *= 0.5
        return out


JUMPS_GONE_BELOW = 3.0
"""Depth in elements below which the effect of jumps between elements is less than 1e-7."""
JUMP_HARMONICS = 40
"""Harmonics of the jumps between elements: the rest of the series at the surface is 1e-4 of its sum."""


def averaging(depth: float) -> float:
    """Weight of the second difference by which an evenly spread element average differs from the load, at a `depth` in
    elements: 1/24 at the surface, 1/12 far below.

    A wave cos kx given by averages and spread evenly has harmonics κ = 2πm/h ± k. Each pair adds (−1)^{m+1} (kh)²/(2π²m²) times
    r − κ r'(κ) of the response r(κ) at this depth to that of the wave, to second order in kh. That is (1 + κz) e^{−κz} where
    stresses follow e^{−κz}; parts that follow κz e^{−κz} have both signs and are not counted."""
    harmonic = np.arange(1.0, JUMP_HARMONICS + 1.0)
    decay = 2.0 * np.pi * depth * harmonic
    series = (-1.0) ** (harmonic + 1.0) * (1.0 + decay) * np.exp(-decay) / harmonic**2
    # Below JUMPS_GONE_BELOW the weight is constant, so that `Sharpened` keeps its spectrum from depth to depth.
    return 1.0 / 12.0 - float(series.sum()) / (2.0 * np.pi**2) if depth < JUMPS_GONE_BELOW else 1.0 / 12.0


class Sharpened:
    """The spectrum of a load given as averages over elements, as it acts below them.

    An average is the value plus 1/24 of the second difference. Spread evenly over the element again, the load acts as if
    averaged twice, except for its jumps between elements: these act down to a depth of about one element, and at the surface
    they restore the average. After subtracting that second difference (`averaging`) the error is of fourth order in the size
    of the elements; the resultant load does not change."""

    def __init__(self, transforms: StressTransforms, load: Array) -> None:
        self._transforms = transforms
        self._spectrum = transforms.plane.forward(load)
        self._weights: tuple[float, float] | None = None
        self._sharp = self._spectrum

    def below(self, depth: float) -> Spectrum:
        """For stresses at this depth in m."""
        grid, plane = self._transforms.grid, self._transforms.plane
        weights = averaging(depth / grid.dx), 0.0 if math.isinf(grid.dy) else averaging(depth / grid.dy)
        if weights != self._weights:
            along, across = self._weights = weights
            x, y = 2.0 * np.pi * np.arange(plane.px) / plane.px, 2.0 * np.pi * np.arange(plane.half) / plane.py
            second = 2.0 * along * (np.cos(x) - 1.0)[None, :] + 2.0 * across * (np.cos(y) - 1.0)[:, None]
            self._sharp = self._spectrum - self._spectrum * second
        return self._sharp


class ElasticStresses:
    """Elastic stresses of a pressure and of a traction, each on its own: (6, nx, columns) per depth and load; in a homogeneous
    body of `poisson_ratio`, or in a `layered` one."""

    def __init__(
        self, transforms: StressTransforms, pressure: Array, traction: Array | None, poisson_ratio: float,
        layered: LayeredBody | None = None,
    ) -> None:
        self._transforms, self._poisson_ratio, self._layered = transforms, poisson_ratio, layered
        self._loads = [Sharpened(transforms, load) for load in (pressure, *(() if traction is None else traction))]

    def at(self, depth: float) -> tuple[Array, Array | None]:
        """Stresses in Pa at `depth` (m) by the pressure, and by the traction as it was given (None without one)."""
        # Kernels odd along one axis have −i times a real spectrum.
        pressure, *traction = [(sharp := load.below(depth), sharp * -1j) for load in self._loads]
        tables = self._tables(depth)
        normal = self._sum([(pressure, tables[0], (False, False))])
        if not traction:
            return normal, None
        return normal, self._sum([(traction[0], tables[1], (True, False)), (traction[1], tables[2], (False, True))])

    def _tables(self, depth: float) -> list[Array]:
        """Stresses under one element with unit pressure and, where there is traction, along x and along y."""
        grid, traction = self._transforms.grid, len(self._loads) > 1
        if self._layered is not None:
            return element_stresses(self._layered, grid.shape, grid.dx, grid.dy, depth, traction=traction)
        aspect = grid.dy / grid.dx
        at = np.arange(float(grid.nx)), _across(grid), depth / grid.dx, aspect, self._poisson_ratio
        return [pressure_stress(*at), *([traction_x_stress(*at), traction_y_stress(*at)] if traction else [])]

    def _sum(self, parts: list[tuple[tuple[Spectrum, Spectrum], Array, tuple[bool, bool]]]) -> Array:
        """Stresses by loads with the given spectra and element tables; a load along an axis flips the parity along it."""
        plane = self._transforms.plane
        spectra = []
        for component in range(6):
            total: Spectrum | None = None
            for spectrum, tables, (flip_x, flip_y) in parts:
                parity = -1 if ODD_IN_X[component] != flip_x else 1, -1 if ODD_IN_Y[component] != flip_y else 1
                symbol = in_pairs(quadrant_symbol(tables[component], (plane.px, plane.py), parity))
                turned = spectrum[parity[0] != parity[1]]
                term = multiply(turned, symbol, out=np.empty_like(turned))
                total = term if total is None else np.add(total, term, out=total)
            assert total is not None
            spectra.append(total)
        return self._transforms.back(spectra, ODD_IN_Y)


class ThermalStresses:
    """Thermal stresses and temperatures of one body, depth by depth from the surface down."""

    def __init__(self, transforms: StressTransforms, load: SurfaceLoad) -> None:
        assert load.heat is not None
        self._transforms, self._load = transforms, load
        self._heat = Sharpened(transforms, load.heat)

    def at(self, depths: Array) -> Iterator[tuple[Array, Array]]:
        """Stresses (6, nx, columns) in Pa and temperature rise (nx, columns) in K at each of the ascending `depths` (m)."""
        grid = self._transforms.grid
        lateral = self._load.speed[1] != 0.0 and grid.ny > 1
        entries = 7 * 8 * (2 * grid.nx - 1) * (2 * grid.ny - 1 if lateral else grid.ny)
        together = max(1, TABLE_BYTES // entries)
        for start in range(0, len(depths), together):
            yield from self._group(depths[start : start + together], lateral)

    def _group(self, depths: Array, lateral: bool) -> Iterator[tuple[Array, Array]]:
        grid, load = self._transforms.grid, self._load
        aspect = grid.dy / grid.dx
        x, y = np.arange(1.0 - grid.nx, grid.nx), _across(grid)
        y = np.concatenate([-y[:0:-1], y]) if lateral else y
        peclet = [speed * grid.dx / load.diffusivity for speed in load.speed]
        z = depths / grid.dx
        stresses = thermal_stress(x, y, z, aspect, peclet[0], peclet[1], load.poisson_ratio)
        temperatures = temperature_at_depths(x, y, z, aspect, peclet[0], peclet[1])
        to_kelvin = grid.dx / load.conductivity
        for depth, stress, temperature in zip(depths, stresses, temperatures, strict=True):
            heat = self._heat.below(float(depth))
            responses = [*stress, temperature]
            odd = (*ODD_IN_Y, False)
            spectra = [
                self._transforms.plane.spectrum(table if lateral else both_sides(table, -1 if is_odd else 1)) * heat
                for table, is_odd in zip(responses, odd, strict=True)
            ]
            fields = self._transforms.back(spectra, odd)
            fields[:6] *= load.thermal_modulus * to_kelvin
            fields[6] *= to_kelvin
            if depth == 0.0 and load.surface_rise is not None:
                # Heat that changes within the elements: σ_xx and σ_yy depend on the local temperature.
                known = load.surface_rise[:, -self._transforms.columns :]
                fields[:2] -= load.thermal_modulus * (known - fields[6])
                fields[6] = known
            yield fields[:6], fields[6]


def _across(grid: Grid) -> Array:
    """Offsets across, in dx, from the element at 0 on; a line contact has no other."""
    return np.zeros(1) if grid.ny == 1 else np.arange(float(grid.ny)) * (grid.dy / grid.dx)

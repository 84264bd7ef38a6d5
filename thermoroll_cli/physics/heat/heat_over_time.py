"""Heat that builds up: what all heat of the steps before, and that of a step itself, does to both surfaces at its end.

Between the ends of two steps the flux at each place of the contact changes linearly with time; after a jump of the inputs it is
constant within the step. So the flux at the end of a step acts with a tent: it rises during that step and falls during the next
one. Both parts are tables of `thermal_lags`, in which the material has drifted as far as the body has moved since. A history
that begins with the steady state continues the heat of all times before it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from thermoroll_cli.physics.halfspace.thermal_lags import Effect, Interval, interval_tables
from thermoroll_cli.physics.heat.frictional_heat import Before
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array

FINEST_DRIFT, COARSEST_DRIFT = 1.0 / 2048.0, 1.0 / 128.0
"""Elements to which drifts up to one element, and of any length, are rounded, so that steps at creepages that hardly differ
share their tables. Steady temperatures change by 5e-5."""
TABLES = 16
"""Tables of single steps that are kept: tents of neighbouring steps share them."""
DIGITS = 9
"""Digits of ages: those of equal steps differ by rounding."""

Place = tuple[float, float]
Tent = tuple[Interval | None, bool, Interval | None]
"""How the heat at the end of a step acts: the interval in which it rises to its value, whether it is constant there instead,
and the interval in which it falls."""


@dataclass(frozen=True)
class End:
    """The end of a step: `time` in s, how far the material of the lower and of the upper body has `moved` through the frame in
    m, along x and y, and whether the heat of the step is `constant`."""

    time: float
    moved: tuple[Place, Place]
    constant: bool = False


@dataclass(frozen=True)
class _Released:
    """The heat at the `end` of a step: transforms of the flux, of its change along x and of the flux exchanged (None: none),
    and the `share` of the lower body."""

    end: End
    flux: Spectrum
    slope: Spectrum
    exchanged: Spectrum | None
    share: float


class HeatMemory:
    """All heat of a history on one grid, of bodies with the constants of `bodies`; if it `expands` surfaces, that too.

    Tables are kept by age and drift, those of the last step: of equal steps each needs one more."""

    def __init__(self, grid: Grid, bodies: tuple[HeatedBody, HeatedBody], *, expands: bool = False) -> None:
        self.grid, self.bodies, self._expands = grid, bodies, expands
        self.convolution = Convolution(*grid.shape)
        self._ever: tuple[HeatedBody, HeatedBody] | None = None
        self._released: list[_Released] = []
        self._used: dict[tuple[Effect, Tent], Spectrum | None] = {}
        self._kept = self._used
        self._tables = lru_cache(maxsize=TABLES)(self._tables_of)

    def add(self, heat: DividedHeat, end: End, ever: tuple[HeatedBody, HeatedBody] | None = None) -> None:
        """Remember the `heat` at the `end` of a step, with its slopes. If it has been the same at all times before, bodies have
        moved as in `ever`."""
        self._ever = ever or self._ever
        assert heat.slope is not None
        flux, slope = (self.convolution.forward(field) for field in (heat.total, heat.slope))
        exchanged = None if heat.exchanged is None else self.convolution.forward(heat.exchanged)
        self._released.append(_Released(end, flux, slope, exchanged, heat.share))

    def before(self, now: End) -> Before:
        """What all heat remembered does at the end of the next step."""
        self._kept, self._used = self._used, {}
        rises, expansion = list[Array](), np.zeros_like(self._released[0].flux)
        for i, body in enumerate(self.bodies):
            total, intervals = np.zeros_like(expansion), self._intervals(i, now)
            for j, released in enumerate(self._released):
                tent = self._tent(j, intervals, now)
                share, sign = (released.share, 1.0) if i == 0 else (1.0 - released.share, -1.0)
                flux = share * released.flux
                if released.exchanged is not None:
                    flux += sign * released.exchanged
                if (kernel := self.kernel("temperature", tent)) is not None:
                    total += flux * kernel
                if (kernel := self.kernel("slope", tent)) is not None:
                    total += share * (released.slope * kernel)
                if self._expands and (kernel := self.kernel("expansion", tent)) is not None:
                    flux *= kernel
                    expansion += flux * (body.free_expansion * self.grid.dx**2 / body.conductivity)
            rises.append(self.convolution.inverse(total) * (self.grid.dx / body.conductivity))
        return Before((rises[0], rises[1]), self.convolution.inverse(expansion) if self._expands else np.zeros(self.grid.shape))

    def own(self, now: End) -> StepResponse:
        """The response to the heat at the end of the next step."""
        last = self._released[-1].end
        speeds = np.subtract(now.moved, last.moved) / (now.time - last.time)
        lower, upper = (
            replace(body, speed_x=float(along), speed_y=float(across))
            for body, (along, across) in zip(self.bodies, speeds, strict=True)
        )
        tents = [self._tent(len(self._released), self._intervals(i, now), now) for i in range(2)]
        return StepResponse(self, lower, upper, (tents[0], tents[1]))

    def kernel(self, effect: Effect, tent: Tent) -> Spectrum | None:
        """Spectrum of the `effect` of heat with a `tent`, in units of the tables; None where it has left the grid."""
        key = effect, tent
        if key in self._kept and key not in self._used:
            self._used[key] = self._kept[key]
        elif key not in self._used:
            rises, constant, falls = tent
            table = np.zeros((2 * self.grid.nx - 1, 2 * self.grid.ny - 1))
            if rises is not None:
                falling_with_age, rising_with_age = self._tables(effect, rises)
                table += falling_with_age + rising_with_age if constant else falling_with_age
            if falls is not None:
                table += self._tables(effect, falls)[1]
            self._used[key] = self.convolution.spectrum(table) if table.any() else None
        return self._used[key]

    def _tables_of(self, effect: Effect, interval: Interval) -> Array:
        return interval_tables(effect, self.grid.nx, self.grid.ny, self.grid.dy / self.grid.dx, interval)

    def _tent(self, j: int, intervals: list[Interval | None], now: End) -> Tent:
        """The tent of the end of step `j`, among the `intervals` of one body."""
        ends = [*(released.end for released in self._released[j : j + 2]), now]
        last = j + 1 == len(intervals)
        return intervals[j], ends[0].constant, None if last or ends[1].constant else intervals[j + 1]

    def _intervals(self, i: int, now: End) -> list[Interval | None]:
        """Of body `i`: the steps before each end as seen at the end `now` of the next one; before the first end it is all time
        before, None without heat then."""
        ends = [*(released.end for released in self._released), now]
        ever = None
        if self._ever is not None:
            step = self.grid.dx / self.bodies[i].diffusivity
            ever = replace(
                self._between(i, ends[0], ends[0], now),
                oldest=math.inf,
                peclet=(self._ever[i].speed_x * step, self._ever[i].speed_y * step),
            )
        return [ever, *(self._between(i, start, end, now) for start, end in pairwise(ends))]

    def _between(self, i: int, start: End, end: End, now: End) -> Interval:
        """Heat released between two ends of steps."""
        unit = self.grid.dx**2 / self.bodies[i].diffusivity
        newest, oldest = (float(f"{(now.time - of.time) / unit:.{DIGITS}g}") for of in (end, start))
        drift, before = (
            [self._rounded((to - at) / self.grid.dx) for to, at in zip(now.moved[i], of.moved[i], strict=True)]
            for of in (end, start)
        )
        length = oldest - newest or 1.0
        return Interval(
            newest, oldest, (drift[0], drift[1]), ((before[0] - drift[0]) / length, (before[1] - drift[1]) / length)
        )

    @staticmethod
    def _rounded(drift: float) -> float:
        """A drift in elements."""
        unit = min(FINEST_DRIFT * 2.0 ** math.frexp(max(abs(drift), 0.5))[1], COARSEST_DRIFT)
        return unit * round(drift / unit)


class StepResponse(HeatResponse):
    """The response of both bodies to the heat at the end of a step alone, with its tent in each."""

    def __init__(self, memory: HeatMemory, lower: HeatedBody, upper: HeatedBody, tents: tuple[Tent, Tent]) -> None:
        super().__init__(memory.grid, lower, upper)
        self._memory, self._tents = memory, tents

    def _temperature_spectrum(self, body: HeatedBody, *, slope: bool = False) -> Spectrum:
        return self._kernel("slope" if slope else "temperature", 0 if body is self.bodies[0] else 1)

    def _joint_expansion(self, lower: float, upper: float) -> Spectrum:
        factors = (
            share * body.free_expansion * self.grid.dx**2 / body.conductivity
            for share, body in zip((lower, upper), self.bodies, strict=True)
        )
        return np.asarray(sum(factor * self._kernel("expansion", i) for i, factor in enumerate(factors) if factor))

    def _kernel(self, effect: Effect, i: int) -> Spectrum:
        kernel = self._memory.kernel(effect, self._tents[i])
        # In a step so short that heat stays in its element, slopes warm no centre.
        return np.zeros_like(self.convolution.plane) if kernel is None else kernel

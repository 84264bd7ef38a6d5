"""Heat that builds up: what all heat of the steps before, and that of a step itself, does to both surfaces at its end.

Between the ends of two steps the flux at each place of the contact changes linearly with time; after a jump of the inputs it is
constant within the step. So the flux at the end of a step acts with a tent: it rises during that step and falls during the next
one. Both parts are tables of `thermal_lags`, in which the material has drifted as far as the body has moved since. A history
that begins with the steady state continues the heat of all times before it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from thermoroll_cli.physics.halfspace.thermal import GAUSSIAN_CUTOFF
from thermoroll_cli.physics.halfspace.thermal_lags import Effect, Interval, interval_tables
from thermoroll_cli.physics.heat.frictional_heat import Before
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum, half_plane_symbol
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array

FINEST_DRIFT, COARSEST_DRIFT = 1.0 / 2048.0, 1.0 / 128.0
"""Elements to which drifts up to one element, and of any length, are rounded, so that steps at creepages that hardly differ
share their tables. Steady temperatures change by 5e-5."""
DIGITS = 9
"""Digits of ages: those of equal steps differ by rounding."""
TOGETHER = 2**18
"""Elements of a grid times the number of ends whose tables are computed together: they are small beside what is remembered."""
TABLES = 16
"""Tables of intervals that are kept for the next step: those of the oldest heat, which equal steps need again."""
TEMPERATURE, SLOPE, EXPANSION = range(3)
"""The order of `EFFECTS`."""
EFFECTS: tuple[Effect, ...] = "temperature", "slope", "expansion"

Place = tuple[float, float]
UNMOVED: tuple[Place, Place] = ((0.0, 0.0), (0.0, 0.0))
Kernels = Spectrum | None
"""Spectra of all effects of the heat at one end, in units of the tables; None where it has left the grid."""


class End(NamedTuple):
    """The end of a step: `time` in s, how far the material of the lower and of the upper body has `moved` through the frame in
    m, along x and y, and whether the heat of the step is `constant`."""

    time: float
    moved: tuple[Place, Place] = UNMOVED
    constant: bool = False


class HeatMemory:
    """All heat of a history on one grid, of bodies with the constants of `bodies`; if it `expands` surfaces, that too.

    Kernels are kept by ages and drifts, those of the last step: of equal steps each needs one more."""

    def __init__(self, grid: Grid, bodies: tuple[HeatedBody, HeatedBody], *, expands: bool = False) -> None:
        self.grid, self.bodies, self._effects = grid, bodies, EFFECTS if expands else EFFECTS[:EXPANSION]
        self.convolution = Convolution(*grid.shape)
        self._ever: tuple[HeatedBody, HeatedBody] | None = None
        self._released: list[tuple[End, DividedHeat]] = []  # of transforms in place of fields
        self._places = np.zeros((0, 5))
        self._kept: tuple[dict[tuple[object, ...], Kernels], dict[Interval, Array]] = {}, {}

    @property
    def begun(self) -> bool:
        """Whether it remembers the heat of any step."""
        return bool(self._released)

    def add(self, heat: DividedHeat, end: End, ever: tuple[HeatedBody, HeatedBody] | None = None) -> None:
        """Remember the `heat` at the `end` of a step, with its slopes. If it has been the same at all times before, bodies have
        moved as in `ever`."""
        self._ever = ever or self._ever
        assert heat.slope is not None
        total, slope = (self.convolution.forward(field) for field in (heat.total, heat.slope))
        exchanged = None if heat.exchanged is None else self.convolution.forward(heat.exchanged)
        self._released.append((end, DividedHeat(total, heat.share, exchanged, slope)))
        self._places = np.vstack([self._places, _row(end)])

    def pass_by(self, now: End) -> None:
        """The end of a step whose heat is known: later steps take its kernels, which depend on those that they were computed
        together with, in the last bits."""
        known, self._kept = self._kept, ({}, {})
        for i in range(len(self.bodies)):
            self._kernels(i, now, *known)

    def step(self, now: End) -> tuple[Before, StepResponse]:
        """What all heat remembered does at the end of the next step, and the response to the heat of that step."""
        (last, heat), expands = self._released[-1], EXPANSION < len(self._effects)
        speeds = np.subtract(now.moved, last.moved) / (now.time - last.time)
        rises, own = list[Array](), list[tuple[HeatedBody, Kernels]]()
        expansion, product = np.zeros_like(heat.total), np.empty_like(heat.total)
        known, self._kept = self._kept, ({}, {})
        for i, (body, (along, across)) in enumerate(zip(self.bodies, speeds.tolist(), strict=True)):
            total, remembered = np.zeros_like(expansion), self._kernels(i, now, *known)
            own.append((replace(body, speed_x=along, speed_y=across), remembered.pop(len(self._released), None)))
            for j, kernels in remembered.items():
                heat = self._released[j][1]
                assert heat.slope is not None
                share, sign = (heat.share, 1.0) if i == 0 else (1.0 - heat.share, -1.0)
                flux = share * heat.total
                if heat.exchanged is not None:
                    flux += np.multiply(sign, heat.exchanged, out=product)
                total += np.multiply(flux, kernels[TEMPERATURE], out=product)
                np.multiply(heat.slope, kernels[SLOPE], out=product)
                total += np.multiply(share, product, out=product)
                if expands:
                    flux *= kernels[EXPANSION]
                    expansion += np.multiply(body.free_expansion * self.grid.dx**2 / body.conductivity, flux, out=product)
            rises.append(self.convolution.inverse(total) * (self.grid.dx / body.conductivity))
        before = Before((rises[0], rises[1]), self.convolution.inverse(expansion) if expands else np.zeros(self.grid.shape))
        return before, StepResponse(self.grid, *own)

    def _kernels(
        self, i: int, now: End, known: dict[tuple[object, ...], Kernels], tables: dict[Interval, Array]
    ) -> dict[int, Spectrum]:
        """Kernels of body `i` for the heat at the ends of steps, by their numbers, the one that ends `now` included, as far as
        it is felt. Those `known` are not computed again, nor those from `tables` that are.

        The heat at an end rises to its value during the step before, or is constant there, and falls during the one after it,
        but where that one is constant. Before the first end is all time before, or nothing."""
        body, grid, last, aspect = self.bodies[i], self.grid, len(self._released), self.grid.dy / self.grid.dx
        since = _row(now) - np.vstack([self._places, _row(now)])
        ages = _rounded_ages(since[:, 0] * (body.diffusivity / grid.dx**2))
        drifts = _rounded_drifts(since[:, 1 + 2 * i : 3 + 2 * i] / grid.dx)
        before = None if self._ever is None else (
            self._ever[i].speed_x * grid.dx / body.diffusivity, self._ever[i].speed_y * grid.dx / body.diffusivity)
        aslant, states = bool(drifts[:, 1].any() or (before and before[1])), np.column_stack([ages, drifts])
        felt = np.arange(last + 1)
        if EXPANSION >= len(self._effects):
            # Expansion is felt everywhere, temperature where the Gaussians reach between the ends before and after.
            around = np.stack([drifts[np.clip(felt + step, 0, last)] for step in (-1, 0, 1)])
            spread = 2.0 * GAUSSIAN_CUTOFF * np.sqrt(ages[np.maximum(felt - 1, 0)])
            gone = np.zeros(last + 1, dtype=bool)
            for axis, (count, length) in enumerate(zip(grid.shape, (1.0, aspect), strict=True)):
                if math.isfinite(length):
                    reach = (count - 0.5) * length + spread
                    gone |= (around[:, :, axis].min(axis=0) > reach) | (around[:, :, axis].max(axis=0) < -reach)
            gone[0] &= before is None
            felt = felt[~gone]

        def constant(j: int) -> bool:
            return now.constant if j == last else self._released[j][0].constant

        def interval(j: int) -> Interval | None:
            """The step that ends with the end `j`, as seen now."""
            drift, newest, oldest = drifts[j].tolist(), float(ages[j]), float(ages[j - 1]) if j else math.inf
            peclet = ((drifts[j - 1] - drifts[j]) / (oldest - newest or 1.0)).tolist() if j else before
            return None if peclet is None else Interval(newest, oldest, (drift[0], drift[1]), (peclet[0], peclet[1]))

        kernels, (kept, kept_tables) = dict[int, Spectrum](), self._kept
        some = max(1, TOGETHER // (grid.nx * grid.ny))
        for first in range(0, len(felt), some):
            keys, key = dict[int, tuple[object, ...]](), tuple[object, ...]()
            parts = dict[tuple[object, ...], tuple[Interval | None, bool, Interval | None]]()
            for j in felt[first : first + some].tolist():
                goes_on = j < last and not constant(j + 1)
                keys[j] = key = (constant(j), goes_on, states[max(j - 1, 0) : j + 2].tobytes(), bool(j) or before)
                if key in known:
                    kept[key] = known[key]
                elif key not in kept:
                    parts[key] = interval(j), constant(j), interval(j + 1) if goes_on else None
            needed = list(dict.fromkeys(each for part in parts.values() for each in part[::2] if isinstance(each, Interval)))
            found = {each: tables[each] for each in needed if each in tables}
            new = [each for each in needed if each not in tables]
            found |= zip(new, interval_tables(self._effects, grid.nx, grid.ny, aspect, new), strict=True)
            for key, (rises, steadily, falls) in parts.items():
                table = np.zeros((len(self._effects), 2 * grid.nx - 1, 2 * grid.ny - 1))
                if rises is not None:
                    table += found[rises].sum(axis=0) if steadily else found[rises][0]
                if falls is not None:
                    table += found[falls][1]
                kept[key] = None if not table.any() else self.convolution.spectrum(table) if aslant else half_plane_symbol(
                    table[..., grid.ny - 1 :], (self.convolution.px, self.convolution.py))
            kept_tables |= {each: found[each] for each in needed[: max(0, TABLES - len(kept_tables))]}
            kernels |= {j: kernel for j, key in keys.items() if (kernel := kept[key]) is not None}
        return kernels


def _row(end: End) -> Array:
    """Time and places of an end, (5,)."""
    return np.array([end.time, *end.moved[0], *end.moved[1]])


def _rounded_ages(ages: Array) -> Array:
    """Ages ≥ 0, (n,), to `DIGITS` digits."""
    unit = 10.0 ** (np.floor(np.log10(np.where(ages > 0.0, ages, 1.0))) + 1.0 - DIGITS)
    return np.asarray(unit * np.round(ages / unit))


def _rounded_drifts(drifts: Array) -> Array:
    """Drifts in elements, of any shape, to parts of an element."""
    _, power = np.frexp(np.maximum(np.abs(drifts), 0.5))
    unit = np.minimum(FINEST_DRIFT * 2.0**power, COARSEST_DRIFT)
    return np.asarray(unit * np.round(drifts / unit))


class StepResponse(HeatResponse):
    """The response of both bodies to the heat at the end of a step alone, with the kernels of each."""

    def __init__(self, grid: Grid, lower: tuple[HeatedBody, Kernels], upper: tuple[HeatedBody, Kernels]) -> None:
        super().__init__(grid, lower[0], upper[0])
        # In a step so short that heat stays in its element, slopes warm no centre.
        nothing = np.zeros((len(EFFECTS), *self.convolution.plane.shape))
        self._kernels = [nothing if kernels is None else kernels for _, kernels in (lower, upper)]

    def _temperature_spectrum(self, body: HeatedBody, *, slope: bool = False) -> Spectrum:
        return self._kernels[0 if body is self.bodies[0] else 1][SLOPE if slope else TEMPERATURE]

    def _joint_expansion(self, lower: float, upper: float) -> Spectrum:
        factors = (share * body.free_expansion * self.grid.dx**2 / body.conductivity
                   for share, body in zip((lower, upper), self.bodies, strict=True))
        return np.asarray(sum(factor * kernels[EXPANSION] for factor, kernels in zip(factors, self._kernels, strict=True)
                              if factor))

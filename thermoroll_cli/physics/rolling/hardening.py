"""An interlayer that hardens, or softens, while it yields.

It yields where friction allows more than its yield stress c, and all slip is plastic there. With the slip σ over V, material
that passes through has

    c = c₀ + g,      dg/dx = k σ,      |τ| = min(μp, c),

up to where c reaches μp: from there on the surfaces slip. Material enters with c₀ and keeps what it has where it sticks, where
surfaces slip, and between contacts. On an element of length dx c has the mean c₀ + g + kσ dx/2 with the g that enters.

In a step over time dg/dx = kσ − r (g − φ), with the rate r and φ from the states before (`Past`). With e = exp(−r dx), E the
mean of exp(−r x) and the growth G = kσ dx an element turns the g that enters into

    e g + (1 − e) φ + (1 + e) G/2      at its end,      E g + (1 − E) φ + E G/2      in its mean,

which is exact for a steady state and for growth that is everywhere the same. Where nothing rolls g = φ + G at the end of the
step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from thermoroll_cli.physics.rolling.slip_friction import SERIES_BELOW, FrictionResponse
from thermoroll_cli.tools.arrays import Array

LEAST_SHARE = 0.1
"""Share of its first yield stress that an interlayer keeps when it softens (CONTACT's)."""


@dataclass(frozen=True)
class Hardening:
    """An interlayer on a box of elements of length `dx` (m) along x, fractions `covered` (n, m), that yields at `least` c₀ in
    Pa and hardens by `rate` k in Pa/m. `limit` is Coulomb's bound μp, (n, m), and `first` min(μp, c₀), both in the mean of each
    element: factors are relative to `first`. In a step over time `before`, (n, m), is φ in Pa, `fading` r in 1/m, and `rolls`
    says whether the contact does."""

    first: Array
    limit: Array
    least: float
    rate: float
    dx: float
    covered: Array
    before: Array | None = None
    fading: float = 0.0
    rolls: bool = True

    @cached_property
    def _unit(self) -> Array:
        return np.where(self.first > 0.0, self.first, 1.0)

    @cached_property
    def highest(self) -> Array:
        """The largest factor at any slip, (n, m)."""
        return np.maximum(self.limit / self._unit, 1.0)

    def about_neutral(self, slip: Array) -> Array:
        """The factor where `slip` is half its change across an element: the middle of it has not hardened."""
        return np.ones_like(slip)

    def expected(self, slip: Array) -> Array:
        """About the factor at the relative `slip` of the bodies, (n, m)."""
        return self.response(slip).factor

    @cached_property
    def _weights(self) -> tuple[float, float, float, float]:
        """e, E, and of the growth at the end and in the mean of an element."""
        if not self.rolls:
            return 0.0, 0.0, 1.0, 1.0
        exponent = self.fading * self.dx
        keeps = math.exp(-exponent)
        mean = (1.0 - keeps) / exponent if exponent > SERIES_BELOW else 1.0 - 0.5 * exponent + exponent**2 / 6.0
        return keeps, mean, 0.5 * (1.0 + keeps), 0.5 * mean

    @cached_property
    def _room(self) -> Array:
        """The g at which surfaces slip at Coulomb's bound, (n, m); what softens moves away from it."""
        return self.limit - self.least if self.rate > 0.0 else np.full_like(self.limit, math.inf)

    @property
    def _floor(self) -> float:
        """The least g."""
        return (LEAST_SHARE - 1.0) * self.least

    def response(self, slip: Array) -> FrictionResponse:
        """The factor, its derivative and the mean g at the relative `slip` σ ≥ 0, (n, m)."""
        _, mean, _, half = self._weights
        before = np.zeros_like(slip) if self.before is None else self.before
        rate = self.rate * self.dx * (self.covered if self.rolls else np.ones_like(slip))
        entering, kept, passed, yields = self._along(rate * slip, before)
        rest, own = mean * entering + (1.0 - mean) * before, half * yields * rate
        grown = np.maximum(rest + own * slip, self._floor)
        # What hardens reaches Coulomb's bound; what softens, less than the first one.
        base, top = (self.first, self.limit) if self.rate > 0.0 else (self.least, self.first)
        changes = np.where((base + grown < top) & (grown > self._floor), 1.0 / self._unit, 0.0)
        return FrictionResponse(
            factor=np.where(self.first > 0.0, np.minimum(base + grown, top) / self._unit, 1.0),
            local=changes * own,
            taken=changes * mean,
            passed=passed * rate,
            kept=kept,
            hardening=np.maximum(rest, np.minimum(grown, self._room)) if self.rate > 0.0 else grown,
        )

    def _along(self, growth: Array, before: Array) -> tuple[Array, Array, Array, Array]:
        """The g that enters each element (n, m), derivatives of the one that leaves it by that and by the `growth`, and the
        share of the element that yields where it softens: μp is above c there."""
        keeps, _, end, _ = self._weights
        room = self._room.copy()
        room[:-1] = 0.5 * (room[:-1] + room[1:])
        entering, kept, passed, share = (np.zeros_like(growth) for _ in range(4))
        around = np.pad(self.limit, ((1, 1), (0, 0)))
        change = 0.5 * np.abs(around[2:] - around[:-2]) + np.finfo(float).eps * self.least
        incoming = np.zeros(growth.shape[1])
        for i in range(len(growth)):
            entering[i] = incoming
            rest = keeps * incoming + (1.0 - keeps) * before[i]
            share[i] = 1.0 if self.rate > 0.0 else np.clip(0.5 + (self.limit[i] - self.least - rest) / change[i], 0.0, 1.0)
            whole = rest + end * share[i] * growth[i]
            slips, free = rest >= room[i], (whole > self._floor) & (whole < room[i])
            incoming = np.where(slips, rest, np.clip(whole, self._floor, room[i]))
            kept[i] = np.where(slips | free, keeps, 0.0)
            passed[i] = np.where(free, end * share[i], 0.0)
        return entering, kept, passed, share

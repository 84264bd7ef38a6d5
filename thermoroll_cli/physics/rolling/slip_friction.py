"""Friction that depends on slip, along the path of the material through the contact, and its derivative.

In steady rolling the memory of friction is a recursion along x: material enters with the factor f(0) and relaxes towards the
law's value f(s) while it slides. Over an element with relative slip σ, s = Vσ, the exponent is
a = dx·covered·max(s, s₀)/(V d_c), and

    f_out = f(s) + (f_in − f(s)) e^{−a},      mean over the element = f(s) + (f_in − f(s)) (1 − e^{−a})/a.

Without memory the mean is f(s) itself.

In a step over time the factor also keeps c of the mean φ of the states before (`Past`): with k = c dx·covered the exponent is
a + k, and (a f(s) + k φ)/(a + k) takes the place of f(s). Where nothing rolls f = f(s) + (φ − f(s)) e^{−a} at the end of the
step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermoroll_cli.problem.friction import FrictionLaw
from thermoroll_cli.tools.arrays import Array

SERIES_BELOW = 1e-3
"""Exponents a below which (1 − e^{−a})/a and its derivative are taken from their series."""

MOST_STEPS = 60
"""Steps of the scalar equations of friction; fewer than ten are usual."""
ROUNDING = 1e-13
"""Relative residual at which they are solved."""


@dataclass(frozen=True)
class FrictionResponse:
    """`factor` by which slip changes the coefficient of friction, (n, m), and derivatives. `local`: of an element's mean factor
    by its own slip. With memory of a state of the material, the factor or the growth of its yield stress, also `passed`: of the
    state at its outlet by its own slip; `kept`: of the state at its outlet by that at its inlet; `taken`: of its mean factor by
    the state at its inlet. `hardening` is the mean growth of a yield stress in Pa."""

    factor: Array
    local: Array
    taken: Array | None = None
    passed: Array | None = None
    kept: Array | None = None
    hardening: Array | None = None

    def change(self, slip: Array) -> Array:
        """Change of the factor with a change of relative `slip`, (n, m)."""
        out = self.local * slip
        if self.taken is None or self.passed is None or self.kept is None:
            return out
        incoming = np.zeros(slip.shape[1])
        for i in range(len(slip)):
            out[i] += self.taken[i] * incoming
            incoming = self.passed[i] * slip[i] + self.kept[i] * incoming
        return out


@dataclass(frozen=True)
class SlipFriction:
    """A friction law on a box of elements of length `dx` (m) along x, fractions `covered` (n, m), rolling `speed` V (m/s); in a
    step over time with memory the mean factor `before`, (n, m), its `rate` c in 1/m, and whether the contact `rolls`."""

    law: FrictionLaw
    speed: float
    dx: float
    covered: Array
    before: Array | None = None
    rate: float = 0.0
    rolls: bool = True

    @property
    def highest(self) -> float:
        """The largest factor at any slip."""
        return self.law.highest

    def about_neutral(self, slip: Array) -> Array:
        """The factor where `slip` is the mean relative slip of an element with a neutral line (`FrictionLaw`)."""
        return self.law.about_neutral(self.speed * slip)

    def expected(self, slip: Array) -> Array:
        """About the factor at the relative `slip` of the bodies, (n, m)."""
        return np.maximum(self.law.at_rest, self.law.factor(self.speed * slip)[0])

    def outweighed_by(self, stiffness: Array, bound: Array) -> bool:
        """Whether `resolvent` has one root in every element: friction has no memory and falls less than `stiffness` σ rises."""
        return self.law.memory == 0.0 and bool((bound * self.speed * self.law.steepest < stiffness).all())

    def resolvent(self, total: Array, stiffness: Array, bound: Array) -> Array:
        """The relative slip σ ≥ 0, (n, m), with `bound` f(σ) + `stiffness` σ = `total`, all in Pa; 0 if the bound at rest
        exceeds `total`. By Newton's method, halving the bracket of the root if a step does not stay inside."""
        low, high = np.zeros_like(total), np.maximum(total, 0.0) / stiffness
        slip = low
        for _ in range(MOST_STEPS):
            factor, slope = self.law.factor(self.speed * slip)
            excess = bound * factor + stiffness * slip - total
            low, high = np.where(excess < 0.0, slip, low), np.where(excess < 0.0, high, slip)
            if (np.abs(excess) <= ROUNDING * total)[high > low].all():
                break
            slip = slip - excess / (bound * self.speed * slope + stiffness)
            slip = np.where((slip <= low) | (slip >= high), 0.5 * (low + high), slip)
        return slip

    def response(self, slip: Array) -> FrictionResponse:
        """The factor and its derivative at the relative `slip` σ ≥ 0, (n, m)."""
        law, speed = self.law, self.speed * slip
        value, slope = law.factor(speed)
        slope = slope * self.speed
        if law.memory == 0.0:
            return FrictionResponse(value, slope)
        # Material passes through the covered part of an element; where nothing rolls all of it stays.
        length = self.dx * (self.covered if self.rolls else 1.0)
        rate = length / (self.speed * law.memory)
        exponent = rate * np.maximum(speed, law.memory_slip)
        exponent_slope = np.where(speed > law.memory_slip, rate * self.speed, 0.0)
        if self.before is not None and not self.rolls:
            kept = np.exp(-exponent)
            return FrictionResponse(value + (self.before - value) * kept,
                                    (1.0 - kept) * slope - (self.before - value) * kept * exponent_slope)
        if self.before is not None:
            changing = self.rate * self.dx * self.covered
            total = exponent + changing
            safe = np.where(total > 0.0, total, 1.0)
            settled = value + (self.before - value) * (changing / safe)
            slope = (exponent * slope + exponent_slope * (value - settled)) / safe
            value, exponent = settled, total
        kept = np.exp(-exponent)
        small = exponent < SERIES_BELOW
        safe = np.where(small, 1.0, exponent)
        mean = np.where(small, 1.0 - 0.5 * exponent + exponent**2 / 6.0, -np.expm1(-exponent) / safe)
        mean_slope = np.where(small, -0.5 + exponent / 3.0, (kept * (1.0 + exponent) - 1.0) / safe**2)
        incoming = np.full_like(slip, law.at_rest)
        for i in range(len(slip) - 1):
            # Material that has left the contact enters the next patch as new.
            incoming[i + 1] = np.where(self.covered[i] > 0.0, value[i] + (incoming[i] - value[i]) * kept[i], law.at_rest)
        excess = incoming - value
        inside = self.covered > 0.0
        return FrictionResponse(
            factor=value + excess * mean,
            local=(1.0 - mean) * slope + excess * mean_slope * exponent_slope,
            taken=mean,
            passed=np.where(inside, (1.0 - kept) * slope - excess * kept * exponent_slope, 0.0),
            kept=np.where(inside, kept, 0.0),
        )

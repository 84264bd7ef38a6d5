"""What the rounding of a profile's points does to the pressure of a contact.

Points that are written with a few decimals are off by up to half of their last step q, each by another amount: an error of
variance q²/12, whose waves are all as high up to the wave number k = π/h of points h apart. A wave of the amplitude Δ adds
E* k Δ/2 to the pressure where it is in contact all over (Westergaard 1939), and what it adds to the curvature of a contact of
the half-width b, E* b k² Δ/2, if it is longer than that. At the depth z the share (1 + kz) exp(−kz) of it is left, that of the
stress along z (Johnson 1985, 5.1)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from thermoroll_cli.tools.arrays import Array

Points = tuple[tuple[float, float], ...]

FEWEST, CUBIC = 8, 4
"""Points of which rounding is spoken, and coefficients of the cubic about which they scatter."""
DECIMALS = range(-1, 9)
"""Decimals of a mm that are tried: a ten-thousandth of a nanometre is no rounding any more."""
STEPS = (5.08, 5.0, 2.54, 2.0, 1.27, 1.0)
"""Steps of a decade, of mm and of inches, in mm."""
WAVES = 400
"""Waves in the sum over all of them."""
LIKELY = 2.0
"""The largest pressure of a contact over its mean over that part of it: so many standard deviations."""


CHOSEN = 2.5
"""Factor of what is allowed without a word where a profile is smoothed already: ± counts what is left."""


class Rounding(NamedTuple):
    """Points `spacing` (m) apart with errors of the standard deviation `error` (m), behind a spline that leaves half of the
    amplitude of a `wavelength` (m; 0: all)."""

    error: float
    spacing: float
    wavelength: float = 0.0

    def pressure(self, contact_modulus: float, half_width: float, depth: float = 0.0) -> float:
        """Standard deviation of the pressure of a contact of this half-width (m), or of the stress along z by it at a `depth`
        (m), in Pa."""
        k = (np.arange(WAVES) + 0.5) * math.pi / (self.spacing * WAVES)
        left = (1.0 + k * depth) * np.exp(-k * depth) / (1.0 + (k * self.wavelength / (2.0 * math.pi)) ** 4)
        return float(0.5 * contact_modulus * self.error * np.sqrt(np.mean((k * np.minimum(1.0, half_width * k) * left) ** 2)))


class MeasuredOutline(NamedTuple):
    """The `points` of an outline (m) before smoothing with a `wavelength` (m, 0: none), and the `steps` (m) of y and z."""

    points: Points
    steps: tuple[float, float]
    wavelength: float

    def rounding_at(self, place: tuple[float, float], reach: float) -> Rounding | None:
        """As `rounding_at`."""
        return rounding_at(self.points, self.steps, place, reach, self.wavelength)


def steps_of(points: list[list[float]]) -> tuple[float, float]:
    """The steps of the numbers in both columns of `points`: the largest 1, 2 or 5 times a power of ten, of mm or of inches,
    that all are multiples of; 0 where there is none."""
    found = [0.0, 0.0]
    for number, column in enumerate(np.array(points, dtype=float).reshape(-1, 2).T if len(points) >= FEWEST else ()):
        steps = (factor * 10.0**-decimals for decimals in DECIMALS for factor in STEPS)
        # Numbers in another unit than mm have been multiplied.
        found[number] = next((step for step in steps if np.abs(column / step - np.rint(column / step)).max() < 1e-5), 0.0)
    return found[0], found[1]


def rounding_at(points: Points, steps: tuple[float, float], place: tuple[float, float], reach: float,
                wavelength: float) -> Rounding | None:
    """The rounding of `points` (m) with these steps (m) within the `reach` of a place (m); None where they are too few, or lie
    on a cubic: numbers of a straight line may be exact with few decimals."""
    around = np.array(points)
    away = np.hypot(*(around - np.array(place)).T)
    near = np.flatnonzero(away <= max(reach, np.sort(away)[: FEWEST][-1]))
    part: Array = around[near[0] : near[-1] + 1] if len(near) else around[:0]
    if len(part) < FEWEST or not any(steps):
        return None
    chord = part[-1] - part[0]
    if not (length := float(np.hypot(*chord))):
        return None
    cosine, sine = chord / length
    along, across = ((part - part[0]) @ np.array([[cosine, -sine], [sine, cosine]])).T
    scatter = across - np.polyval(np.polyfit(along, across, CUBIC - 1), along)
    seen = math.sqrt(float(scatter @ scatter) / (len(part) - CUBIC))
    error = min(math.hypot(steps[1] * cosine, steps[0] * sine) / math.sqrt(12.0), seen)
    return Rounding(error, length / (len(part) - 1), wavelength) if error > 0.0 else None


def rounding_warning(name: str, rounding: Rounding | None, contact_modulus: float, half_width: float,
                     allowed: float) -> Iterator[str]:
    """A warning if the rounding of the profile `name` may change the largest pressure of a contact of this half-width (m) by
    more than is `allowed` (Pa)."""
    if rounding is None:
        return
    pressure, smoothed = by_rounding((rounding,), contact_modulus, half_width), rounding.wavelength > 0.0
    if pressure > allowed * (CHOSEN if smoothed else 1.0):
        yield (f"the profile of the {name} has points {1e3 * rounding.spacing:.2g} mm apart that are rounded to about "
               f"{1e3 * math.sqrt(12.0) * rounding.error:.1g} mm, which changes the largest pressure by up to "
               f"{float(f'{1e-6 * pressure:.1g}'):g} MPa: give more decimals, or {'a larger ' if smoothed else ''}smoothing_mm "
               "in its table")


def by_rounding(roundings: tuple[Rounding, ...], contact_modulus: float, half_width: float, depth: float = 0.0) -> float:
    """What all `roundings` together may add to the largest pressure of a contact of this half-width (m), or to the stresses at
    a `depth` (m) below it, in Pa."""
    return LIKELY * math.hypot(*(each.pressure(contact_modulus, half_width, depth) for each in roundings))

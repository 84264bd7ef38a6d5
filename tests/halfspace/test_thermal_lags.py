"""Tables of heat of single intervals of time: together they are those of steady heat."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_slope_table, temperature_table
from thermoroll_cli.physics.halfspace.thermal_lags import Effect, Interval, interval_tables
from thermoroll_cli.tools.arrays import Array

STEADY = {"temperature": temperature_table, "slope": temperature_slope_table, "expansion": displacement_table}
N = 8


def together(effect: Effect, aspect: float, peclet: tuple[float, float], ages: list[float]) -> Array:
    """The sum over all intervals between `ages`."""
    along, across = peclet
    intervals = [Interval(new, old, (along * new, across * new), peclet) for new, old in pairwise(ages)]
    return np.asarray(interval_tables([effect], N, N, aspect, intervals)[:, :, 0].sum(axis=(0, 1)))


@pytest.mark.parametrize("peclet", [(0.0, 0.0), (0.01, 0.0), (3.0, 0.5), (300.0, 0.0)])
@pytest.mark.parametrize("effect", STEADY)
def test_all_intervals_are_the_steady_table(effect: Effect, peclet: tuple[float, float]) -> None:
    steady = STEADY[effect](N, N, 0.7, *peclet)
    ages = [0.0, *(3.0 * np.arange(1, 12) / (1.0 + peclet[0])), math.inf]
    difference = together(effect, 0.7, peclet, ages) - steady
    if effect == "expansion" and not any(peclet):
        difference -= difference.mean()  # at rest it is known up to a constant
    assert np.abs(difference).max() < (1e-7 if effect == "slope" else 1e-8) * steady.max()


def test_heat_of_one_interval() -> None:
    """A speed of its own, after a drift at others; heat that rises and falls within it."""
    interval, x, y = Interval(0.5, 2.0, (1.3, 0.2), (2.0, -0.4)), 1.0, -2.0

    def green(age: float) -> float:
        width = 2.0 * math.sqrt(age)
        parts = [
            0.5
            * (
                erf((place - drift - speed * (age - 0.5) + 0.5) / width)
                - erf((place - drift - speed * (age - 0.5) - 0.5) / width)
            )
            for place, drift, speed in zip((x, y), interval.drift, interval.peclet, strict=True)
        ]
        return float(parts[0] * parts[1]) / math.sqrt(math.pi * age)

    falling, rising = interval_tables(["temperature"], N, N, 1.0, [interval])[0, :, 0, N - 1 + int(x), N - 1 + int(y)]
    assert rising == pytest.approx(quad(lambda age: green(age) * (age - 0.5) / 1.5, 0.5, 2.0)[0], rel=1e-7)
    assert falling + rising == pytest.approx(quad(green, 0.5, 2.0)[0], rel=1e-7)


def test_no_interval_and_one_that_has_left() -> None:
    """A step may need no table that is new, and heat that has drifted far away warms nothing."""
    assert interval_tables(list(STEADY), N, N, 1.0, []).shape == (0, 2, 3, 2 * N - 1, 2 * N - 1)
    assert not interval_tables(["temperature"], N, N, 1.0, [Interval(1.0, 2.0, (90.0, 0.0), (80.0, 0.0))]).any()

"""What heat that was released during one interval of time does to the surface afterwards.

The integrals of `thermal` over τ² = κt/dx² are integrals over the time t since heat was released. Heat of the interval of ages
[t₁, t₂] alone acts by the same integrands between the ends of the interval,

    T = (2/√π) ∫ gx gy dτ,                    τ from √t₁ to √t₂
    U = (4/π) ∫ sech³y 2 ∫ τ gx gy dτ dy,     τ from √t₁ cosh y to √t₂ cosh y

since a node y of U has the age t = τ² sech²y. The material drifts evenly within the interval, d = d₁ + P (t − t₁): the drift of
a speed P from a place d₁ − P t₁ beside, so that speeds may differ from one interval to the next. All intervals together are the
tables of steady heat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.special import wrightomega

from thermoroll_cli.physics.halfspace import thermal
from thermoroll_cli.physics.halfspace.thermal import STATIONARY_PECLET, STILL_INSIDE
from thermoroll_cli.tools.arrays import Array

Effect = Literal["temperature", "slope", "expansion"]
"""Temperature by heat that is the same in all of an element, temperature by heat that changes along x within its element, and
thermal expansion: with the units of `thermal.temperature_table`, `temperature_slope_table` and `displacement_table`."""

LONGEST_PANEL, LEAST_NODES, NODES_PER_LENGTH = 3.0, 4, 5.0
"""Length of panels in units of u = ln(sτ) + sτ (see `thermal`), and the number of Gauss's nodes on each."""
INSIDE = 4
"""Nodes while heat is inside its element: the integrand is a polynomial."""
SMALLEST_WEIGHT = 1e-9
"""Share of the expansion that may be left out beyond the last y."""


@dataclass(frozen=True)
class Interval:
    """Heat of the ages `newest` to `oldest` in dx²/κ (inf: of all that are older), from a point in the frame that its material
    has left by `drift` (along x and y, in dx) at the newest age, and at the Péclet numbers `peclet`, V dx/κ, before."""

    newest: float
    oldest: float
    drift: tuple[float, float]
    peclet: tuple[float, float]


def interval_tables(effect: Effect, nx: int, ny: int, aspect: float, interval: Interval) -> Array:
    """The `effect` around one element whose heat falls linearly with age over the `interval`, from 1 to 0, and around one whose
    heat rises from 0 to 1: (2, 2nx−1, 2ny−1), as tables of `thermal`. Of an interval without an end the first one is that of
    constant heat, and the other one is zero.

    For sources at rest the expansion by heat of all ages is that up to a constant. Good to 1e-8 of the steady coefficient of an
    element on itself."""
    shift = [d - p * interval.newest for d, p in zip(interval.drift, interval.peclet, strict=True)]
    x, y = thermal.offsets(nx, ny, aspect, shift[1], interval.peclet[1])
    if math.isinf(interval.oldest) and math.hypot(*interval.peclet) * thermal.extent(x, y, aspect) < STATIONARY_PECLET:
        return _ever_at_rest(effect, nx, ny, aspect, interval)
    x, y = x - shift[0], y - shift[1]
    reaches = float(np.abs(x).max()) + 0.5, float(np.abs(y).max()) + 0.5 * aspect
    if effect != "expansion":
        tau, weights = _nodes(effect, reaches, aspect, interval, 1.0)
        tables = 2.0 / math.sqrt(math.pi) * thermal.integrated(
            x, y, aspect, interval.peclet, tau, weights, thermal.cell_moment if effect == "slope" else thermal.cell_average)
    else:
        reach = math.hypot(*interval.peclet) * thermal.extent(x, y, aspect)
        last = max(-math.log(SMALLEST_WEIGHT) / 3.0, 0.5 * math.log(1.0 + 4.0 * reach) + 6.0)
        spreads = np.cosh(np.arange(0.0, last, thermal.ANGLE_STEP))
        shares = 8.0 / math.pi * thermal.ANGLE_STEP / spreads**3
        shares[0] *= 0.5
        rules = [_nodes(effect, reaches, aspect, interval, float(spread)) for spread in spreads]
        tau = np.concatenate([rule[0] for rule in rules])
        slowing = np.concatenate([np.full(len(rule[0]), spread**-2) for rule, spread in zip(rules, spreads, strict=True)])
        weights = np.concatenate([share * rule[1] for rule, share in zip(rules, shares, strict=True)], axis=1)
        order = np.argsort(tau)
        along, across = (peclet * slowing[order] for peclet in interval.peclet)
        tables = thermal.integrated(x, y, aspect, (along, across), tau[order], weights[:, order])
    return np.stack([thermal.mirrored(table, ny) for table in tables])


def _ever_at_rest(effect: Effect, nx: int, ny: int, aspect: float, interval: Interval) -> Array:
    """Constant heat of all ages from the newest on, of sources at rest: that since ever less that since then."""
    since_ever = {"temperature": thermal.temperature_table, "slope": thermal.temperature_slope_table,
                  "expansion": thermal.displacement_table}[effect](nx, ny, aspect, 0.0)
    if interval.newest > 0.0:
        since = Interval(0.0, interval.newest, (0.0, 0.0), (0.0, 0.0))
        since_ever -= interval_tables(effect, nx, ny, aspect, since).sum(axis=0)
    return np.stack([since_ever, np.zeros_like(since_ever)])


def _nodes(
    effect: Effect, reaches: tuple[float, float], aspect: float, interval: Interval, spread: float
) -> tuple[Array, Array]:
    """Nodes τ = √t `spread` in the interval, and weights of ∫ τ^power … dτ for heat that falls and for heat that rises, (2, n);
    none once it has left the `reaches` along x and y."""
    peclets = interval.peclet[0] / spread**2, interval.peclet[1] / spread**2
    begin = spread * math.sqrt(interval.newest)
    end = min(spread * math.sqrt(interval.oldest), thermal.last_time(reaches, peclets))
    if end <= begin:
        return np.zeros(0), np.zeros((2, 0))
    # Before the onset heat has not left its element: nodes differ by their weights alone.
    onset = min(end, thermal.first_time(aspect, peclets) * (STILL_INSIDE if effect == "slope" else 1.0))
    tau, weights = _gauss(0.0, onset, INSIDE) if begin == 0.0 else (np.zeros(0), np.zeros(0))
    scale = math.hypot(*peclets) * thermal.LOG_STEP / thermal.DRIFT_STEP
    low, high = (math.log(place) + scale * place for place in (begin or onset, end))
    for a, b in pairwise(np.linspace(low, high, math.ceil((high - low) / LONGEST_PANEL) + 1)):
        u, du = _gauss(a, b, math.ceil(LEAST_NODES + NODES_PER_LENGTH * (b - a)))
        later = np.exp(u) if scale == 0.0 else wrightomega(u + math.log(scale)) / scale
        tau, weights = np.append(tau, later), np.append(weights, du * later / (1.0 + scale * later))
    rising = np.zeros(len(tau))
    if math.isfinite(interval.oldest):
        rising = ((tau / spread) ** 2 - interval.newest) / (interval.oldest - interval.newest)
    both = weights * (tau if effect == "expansion" else 1.0) * np.stack([1.0 - rising, rising])
    if begin > 0.0:
        return tau, both
    return np.append(onset, tau[INSIDE:]), np.column_stack([both[:, :INSIDE].sum(axis=1), both[:, INSIDE:]])


def _gauss(low: float, high: float, count: int) -> tuple[Array, Array]:
    """Gauss's nodes and weights between two places."""
    places, weights = _rule(count)
    return 0.5 * (low + high) + 0.5 * (high - low) * places, 0.5 * (high - low) * weights


_rule = cache(leggauss)

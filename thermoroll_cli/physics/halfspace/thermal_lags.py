"""What heat that was released during one interval of time does to the surface afterwards.

The integrals of `thermal` over τ² = κt/dx² are integrals over the time t since heat was released. Heat of the interval of ages
[t₁, t₂] alone acts by the same integrands between the ends of the interval,

    T = (2/√π) ∫ gx gy dτ,                    τ from √t₁ to √t₂
    U = (4/π) ∫ sech³y 2 ∫ τ gx gy dτ dy,     τ from √t₁ cosh y to √t₂ cosh y

since a node y of U has the age t = τ² sech²y. The material drifts evenly within the interval, d = d₁ + P (t − t₁), so that
speeds may differ from one interval to the next. All intervals together are the tables of steady heat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.special import wrightomega

from thermoroll_cli.physics.halfspace import thermal
from thermoroll_cli.physics.halfspace.thermal import STATIONARY_PECLET, STILL_INSIDE
from thermoroll_cli.tools.arrays import AnyArray, Array

Effect = Literal["temperature", "slope", "expansion"]
"""Temperature by heat that is the same in all of an element, temperature by heat that changes along x within its element, and
thermal expansion: with the units of `thermal.temperature_table`, `temperature_slope_table` and `displacement_table`."""

LONGEST_PANEL, LEAST_NODES, NODES_PER_LENGTH = 3.0, 3.0, 5.0
"""Length of panels in units of u = ln(sτ) + sτ (see `thermal`), and the number of Gauss's nodes on each."""
FEWEST_DIGITS = 0.3
"""Least share of those nodes where the result counts little."""
LIKE = 2**14
"""Numbers of nodes times offsets that are computed together on small grids."""
SMALLEST_WEIGHT = 1e-9
"""Share of the expansion that may be left out beyond the last y."""


class Interval(NamedTuple):
    """Heat of the ages `newest` to `oldest` in dx²/κ (inf: of all that are older), from a point in the frame that its material
    has left by `drift` (along x and y, in dx) at the newest age, and at the Péclet numbers `peclet`, V dx/κ, before."""

    newest: float
    oldest: float
    drift: tuple[float, float]
    peclet: tuple[float, float]


def interval_tables(effects: Sequence[Effect], nx: int, ny: int, aspect: float, intervals: Sequence[Interval]) -> Array:
    """Each of the `effects` around one element whose heat falls linearly with age over an interval, from 1 to 0, and around one
    whose heat rises from 0 to 1: (intervals, 2, effects, 2nx−1, 2ny−1), as tables of `thermal`. Of an interval without an end
    the first one is that of constant heat, and the other one is zero.

    For sources at rest the expansion by heat of all ages is that up to a constant. Good to 1e-8 of the steady coefficient of an
    element on itself."""
    each = np.array([(one.newest, one.oldest, *one.drift, *one.peclet) for one in intervals]).reshape(len(intervals), 6)
    ages, drifts, peclets = each[:, :2], each[:, 2:4], each[:, 4:]
    aslant = bool(drifts[:, 1].any() or peclets[:, 1].any())
    x, y = thermal.offsets(nx, ny, aspect, 0.0, 1.0 if aslant else 0.0)
    ever_at_rest = np.isinf(ages[:, 1]) & (np.hypot(*peclets.T) * thermal.extent(x, y, aspect) < STATIONARY_PECLET)
    tables = np.zeros((len(intervals), 2, len(effects), len(x), len(y)))
    for together in ([effect for effect in effects if effect != "expansion"], [e for e in effects if e == "expansion"]):
        if together:
            of, age, tau, weights = _nodes(int("expansion" in together), x, y, aspect, ages, drifts, peclets, ~ever_at_rest)
            # The places that the heat of each node has drifted to, as speeds since its release.
            along, across = ((drifts[of] + peclets[of] * (age - ages[of, 0])[:, None]) / (tau**2)[:, None]).T
            lengthwise, crosswise = np.zeros((len(together), len(tau), len(x))), np.zeros((len(tau), len(y)))
            order = np.argsort(tau)
            for some, rows, columns in thermal.windows(
                    x, y, aspect, along[order], across[order], tau[order], max(thermal.NODES_TOGETHER, LIKE // len(x))):
                nodes = order[some]
                for g, effect in zip(lengthwise, together, strict=True):
                    spread = thermal.cell_moment if effect == "slope" else thermal.cell_average
                    g[nodes, rows] = spread(x[rows], 1.0, along[nodes], tau[nodes])
                crosswise[nodes, columns] = thermal.cell_average(y[columns], aspect, across[nodes], tau[nodes])
            crosswise = crosswise * weights[:, :, None]
            starts = np.searchsorted(of, np.arange(len(intervals) + 1))
            for number, (start, stop) in enumerate(pairwise(starts)):
                for g, effect in zip(lengthwise, together, strict=True):
                    tables[number, :, effects.index(effect)] = g[start:stop].T @ crosswise[:, start:stop]
    tables = tables if aslant else np.concatenate((tables[..., :0:-1], tables), axis=-1)
    for number in np.flatnonzero(ever_at_rest).tolist():
        tables[number, 0] = _ever_at_rest(effects, nx, ny, aspect, intervals[number].newest)
    return tables


def _ever_at_rest(effects: Sequence[Effect], nx: int, ny: int, aspect: float, newest: float) -> Array:
    """Constant heat of all ages from the `newest` on, of sources at rest: that since ever less that since then."""
    steady = {"temperature": thermal.temperature_table, "slope": thermal.temperature_slope_table,
              "expansion": thermal.displacement_table}
    since_ever = np.stack([steady[effect](nx, ny, aspect, 0.0) for effect in effects])
    if newest > 0.0:
        since_ever -= interval_tables(effects, nx, ny, aspect, [Interval(0.0, newest, (0.0, 0.0), (0.0, 0.0))])[0].sum(axis=0)
    return since_ever


def _nodes(
    power: int, x: Array, y: Array, aspect: float, ages: Array, drifts: Array, peclets: Array, wanted: Array
) -> tuple[AnyArray, Array, Array, Array]:
    """Nodes of the integrals of τ^power over the `wanted` intervals with these `ages`, (n, 2), `drifts` and `peclets`: the
    interval of each, in rising order, its age, its τ, and its weights for heat that falls and for heat that rises, (2, nodes).
    Heat has none once it has left the offsets."""
    reach = np.hypot(*peclets.T) * thermal.extent(x, y, aspect)
    if power:
        last = np.maximum(-math.log(SMALLEST_WEIGHT) / 3.0, 0.5 * np.log(1.0 + 4.0 * reach) + 6.0)
        angles = np.arange(0.0, float(last.max(initial=1.0)), thermal.ANGLE_STEP)
        spreads = np.cosh(angles)
        shares = 8.0 / math.pi * thermal.ANGLE_STEP / spreads**3
        shares[0] *= 0.5
        pairs = wanted[:, None] & (angles < last[:, None])
    else:
        spreads, shares, pairs = np.ones(1), np.array([2.0 / math.sqrt(math.pi)]), wanted[:, None]
    # An integral over τ for each pair of an interval and a spread, from `begin` to `end`.
    of, at = np.nonzero(pairs)
    spread, (newest, oldest) = spreads[at], np.sqrt(ages[of].T)
    slow = np.abs(peclets[of].T) / spread**2
    begin, end, onset = spread * newest, spread * oldest, np.full(len(of), math.inf)
    for speed, shift, places, length in zip(slow, (drifts - peclets * ages[:, :1]).T, (x, y), (1.0, aspect), strict=True):
        if math.isfinite(length):
            onset = np.minimum(onset, thermal.first_time(length, speed))
            reaches = np.maximum(places[-1] - shift, shift - places[0])[of] + 0.5 * length
            end = np.minimum(end, thermal.last_time(reaches, speed))
    kept = end > begin
    of, spread, begin, end, onset, share = (each[kept] for each in (of, spread, begin, end, onset, shares[at]))
    # Before the onset heat has not left its element: nodes differ by their weights alone.
    onset = np.minimum(end, onset * (1.0 if power else STILL_INSIDE))
    scale = np.hypot(*slow[:, kept]) * thermal.LOG_STEP / thermal.DRIFT_STEP
    low, high = (np.log(place) + scale * place for place in (np.where(begin > 0.0, begin, onset), end))
    panels = np.ceil((high - low) / LONGEST_PANEL).astype(int)
    width = (high - low) / np.maximum(panels, 1)
    # Of wide spreads fewer digits count: the integral has grown by up to spread² while heat is advected.
    digits = 8.0 + np.log10(np.minimum(spread**2, 1.0 + 4.0 * reach[of]) / spread**3)
    counts = np.ceil(LEAST_NODES + NODES_PER_LENGTH * width * np.clip(digits / 8.0, FEWEST_DIGITS, 1.0)).astype(int)
    pair = np.repeat(np.arange(len(of)), panels)
    starts = low[pair] + width[pair] * (np.arange(len(pair)) - np.repeat(np.cumsum(panels) - panels, panels))
    rules = [_rule(count) for count in counts[pair].tolist()]
    places, du = (np.concatenate([np.zeros(0), *(rule[i] for rule in rules)]) for i in range(2))
    starts, pair = np.repeat(starts, counts[pair]), np.repeat(pair, counts[pair])
    u, moving = starts + width[pair] * places, scale[pair] > 0.0
    stretch = np.where(moving, scale[pair], 1.0)
    tau = np.where(moving, wrightomega(u + np.log(stretch)) / stretch, np.exp(np.where(moving, 0.0, u)))
    weights = share[pair] * width[pair] * du * tau ** (1 + power) / (1.0 + scale[pair] * tau)
    newest, oldest = ages[of].T
    length = oldest - newest
    rising = weights * ((tau / spread[pair]) ** 2 - newest[pair]) / length[pair]
    # The integrals of τ^power up to the onset, and of those times its age.
    inside = np.flatnonzero(begin == 0.0)
    until, share = onset[inside], share[inside]
    early = share * until ** (power + 1) / (power + 1)
    early_rising = share * until ** (power + 3) / (power + 3) / spread[inside] ** 2 / length[inside]
    pair, tau = np.append(inside, pair), np.append(until, tau)
    weights, rising = np.append(early, weights), np.append(early_rising, rising)
    order = np.argsort(of[pair], kind="stable")
    pair, tau, weights, rising = (each[order] for each in (pair, tau, weights, rising))
    return of[pair], np.asarray((tau / spread[pair]) ** 2), np.asarray(tau), np.stack([weights - rising, rising])


@cache
def _rule(count: int) -> tuple[Array, Array]:
    """Gauss's nodes and weights between 0 and 1."""
    places, weights = leggauss(count)
    return 0.5 * (1.0 + places), 0.5 * weights

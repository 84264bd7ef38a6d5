"""Quadrature over Gaussians that spread and drift: nodes u of their variance, nodes t of the time since the heat was made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from thermoroll_cli.arrays import Array

TAIL = 5.4
"""Gaussians are cut off where their argument reaches this: exp(−5.4²) = 2e-13."""
TOLERANCE = 1e-10
"""What may be left beyond the last node and what may be lumped into the first, in Eα/(1−ν) · q dx/k."""


@dataclass(frozen=True)
class Steps:
    """Steps of the two rules: in the logarithm of u (`outer`), in that of t/(u−t) (`inner`), and the longest one in units of
    √u/P, where Gaussians of width √u pass by (`passing`). Errors fall exponentially with them."""

    outer: float
    inner: float
    passing: float
FAST = Steps(0.34, 0.42, 1.26)
"""Good to 1e-7 of the largest stress of the element (measured for P from 0 to 1e3)."""
EXACT = Steps(0.22, 0.32, 1.0)
"""Good to 1e-9 of it: for tests."""
Function = Callable[[Array], Array]


def outer_rule(
    reach: float, length: float, peclet: tuple[float, float], steps: Steps = FAST
) -> tuple[Array, Array]:
    """Nodes u and weights of ∫ … du: trapezoidal in v = ln u + c√π τ₁ erf(√u/τ₁), steps as short as the drift asks for.

    `reach` is the farthest offset downstream, `length` the shorter side of the element. Before the first node no heat has left
    the element; beyond the last, less than TOLERANCE follows."""

    along = math.hypot(*peclet)
    shortest = length / (2.0 * TAIL + math.sqrt(4.0 * TAIL**2 + 2.0 * along * length))
    edge = (2.0 * TAIL + math.sqrt(4.0 * TAIL**2 + 4.0 * along * reach)) / (2.0 * along)
    rim, density = 1.5 * edge, 1.5 * along * steps.outer / steps.passing
    first, last = 2.0 * math.log(shortest), max(-math.log(12.0 * along * TOLERANCE), 2.0 * math.log(edge) + 4.0)

    def mapped(log_u: Array) -> Array:
        tau = np.exp(0.5 * log_u)
        return np.asarray(log_u + density * math.sqrt(math.pi) * rim * erf(tau / rim))

    def slope(log_u: Array) -> Array:
        tau = np.exp(0.5 * log_u)
        return np.asarray(1.0 + density * tau * np.exp(-((tau / rim) ** 2)))

    log_u = _equal_steps(mapped, slope, first, last, steps.outer)
    u = np.exp(log_u)
    return u, steps.outer * u / slope(log_u)


def inner_rule(
    u: float, furthest: float, peclet: float, steps: Steps = FAST
) -> tuple[Array, Array, Array, int, int]:
    """Nodes of ∫ … dt from 0 to u: trapezoidal in v = ζ + c t/u with t/(u−t) = e^ζ and c ∝ P√u.

    Returns t/(u−t), t, weights, and the first and last node that need a Gaussian of their own. Nodes end at `furthest`."""
    drift = peclet * math.sqrt(u) * steps.inner / steps.passing

    def mapped(zeta: Array) -> Array:
        return np.asarray(zeta + drift / (1.0 + np.exp(-zeta)))

    def slope(zeta: Array) -> Array:
        return np.asarray(1.0 + drift / (2.0 + np.exp(zeta) + np.exp(-zeta)))

    share = furthest / u
    end = 36.0 if share >= 1.0 - 1e-15 else min(math.log(share) - math.log1p(-share), 36.0)
    zeta = _equal_steps(mapped, slope, -36.0, end, steps.inner)
    odds = np.exp(zeta)
    t = u * odds / (1.0 + odds)
    alone = math.log(math.sqrt(TOLERANCE / max(drift, 1.0)))
    first, last = int(np.searchsorted(zeta, alone)), int(np.searchsorted(zeta, -alone))
    first = min(first, len(zeta) - 1)
    return odds, t, steps.inner * t / (1.0 + odds) / slope(zeta), first, max(min(last, len(zeta) - 1), first)


def _equal_steps(mapped: Function, slope: Function, first: float, last: float, step: float) -> Array:
    """Arguments from `first` to `last` whose images under the monotonous `mapped`, of slope `slope`, are `step` apart."""
    rough = np.linspace(first, last, 400)
    image = mapped(rough)
    wanted = np.arange(image[0], image[-1] + step, step)
    found = np.interp(wanted, image, rough)
    for _ in range(4):
        found = found + (wanted - mapped(found)) / slope(found)
    return np.asarray(found)

"""Functions of one wavenumber: sums over all earlier passes, and what a cylinder or a bore makes of a wave along its axis.

A track receives an equal amount of heat at each pass, P apart. A wave across the track (wavenumber λ, ε = κλ²P) has decayed by
exp(−nε) n passes later, and its surface temperature falls like n^{−1/2}. The sums over all n ≥ 1 less the integrals that
stand for the mean in time,

    D(ε) = Σ n^{−1/2} e^{−nε} − √(π/ε) = Li_{1/2}(e^{−ε}) − √(π/ε),          D(0) = ζ(½) = −1.46035…
    S(ε) = Σ erfc √(nε) − 1/(2ε),                                             S(0) = −½

have, by their Mellin transforms, the series (|ε| < 2π)

    D = Σ_k ζ(½ − k) (−ε)^k/k!,      S = −½ − Σ_k (−1)^k ζ(−½ − k) ε^{k+½} / (√π k! (k + ½)).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfc, i0e, i1e, k0e, k1e, zeta

from thermoroll_cli.arrays import Array

SERIES_UP_TO = 1.0
"""ε below which the series is summed, above the passes themselves."""
TERMS = 24
"""Terms of either series: the last one is below 1e-17 at ε = 1."""
PASSES = 40
"""Passes summed for ε > 1: e^{−40}."""


def pass_sum(epsilon: ArrayLike) -> Array:
    """D(ε) for ε ≥ 0: surface temperature that earlier passes have left, less its mean in time; shape of ε."""
    eps = np.asarray(epsilon, dtype=float)
    k = np.arange(TERMS)
    coefficients = zeta(0.5 - k) * (-1.0) ** k / _factorials(TERMS)
    small = np.polynomial.polynomial.polyval(np.minimum(eps, SERIES_UP_TO), coefficients)
    n = np.arange(1, PASSES + 1)
    large = np.maximum(eps, SERIES_UP_TO)
    summed = np.exp(-large[..., None] * n) @ (1.0 / np.sqrt(n)) - np.sqrt(math.pi / large)
    return np.asarray(np.where(eps <= SERIES_UP_TO, small, summed))


def bulge_sum(epsilon: ArrayLike) -> Array:
    """S(ε) for ε ≥ 0: thermal expansion that earlier passes have left, less its mean in time; shape of ε."""
    eps = np.asarray(epsilon, dtype=float)
    k = np.arange(TERMS)
    coefficients = zeta(-0.5 - k) * (-1.0) ** k / (_factorials(TERMS) * math.sqrt(math.pi) * (k + 0.5))
    few = np.minimum(eps, SERIES_UP_TO)
    small = -0.5 - np.sqrt(few) * np.polynomial.polynomial.polyval(few, coefficients)
    large = np.maximum(eps, SERIES_UP_TO)
    summed = erfc(np.sqrt(large[..., None] * np.arange(1, PASSES + 1))).sum(axis=-1) - 0.5 / large
    return np.asarray(np.where(eps <= SERIES_UP_TO, small, summed))


def surface_slope(argument: ArrayLike, *, bore: bool = False) -> Array:
    """ρ = I₁(λR)/I₀(λR): slope over value of T = I₀(λr) at the rim, in λ; shape of λR ≥ 0. For the rim of a `bore`, around
    which T = K₀(λr), it is K₁(λR)/K₀(λR), λR > 0."""
    x = np.asarray(argument, dtype=float)
    return np.asarray(k1e(x) / k0e(x) if bore else i1e(x) / i0e(x))


def cylinder_factor(argument: ArrayLike, poisson_ratio: float, *, bore: bool = False) -> Array:
    """c(λR): radial displacement of a solid, traction-free cylinder with T = I₀(λr) cos λy, over that of a half-space with the
    same temperature at its surface, (1 + ν)αT/λ; shape of λR > 0.

    Goodier's potential m r I₁(λr)/2λ cos λy, m = (1 + ν)α/(1 − ν), plus Love's two solutions, which free the rim of stress:

        c = ρ x²(1 − ρ²) / [x²(1 − ρ²) − 2(1 − ν)ρ²],     x = λR,  ρ = I₁(x)/I₀(x)

    It is 1 + (3/2 − 2ν)/x for large x; for small x it is x/(1 + ν), the free expansion αRT of the whole cylinder.
    Around a `bore` I₀ and I₁ give way to K₀ and −K₁, and the surface moves the other way: the same with ρ = −K₁/K₀ and a minus
    sign, 1 − (3/2 − 2ν)/x for large x.
    """
    x = np.asarray(argument, dtype=float)
    rho = surface_slope(x, bore=bore)
    # 1 − ρ² cancels for large x, where it is ±(1/x + 1/(8x³)).
    far, sign = np.maximum(x, 1.0), -1.0 if bore else 1.0
    rest = x**2 * np.where(x > 1e3, sign * (1.0 / far + 0.125 / far**3), 1.0 - rho**2)
    return np.asarray(rho * rest / (rest - 2.0 * (1.0 - poisson_ratio) * rho**2))


def _factorials(count: int) -> Array:
    return np.array([float(math.factorial(k)) for k in range(count)])

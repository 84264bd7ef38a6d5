"""Relaxation of a modulus as a Prony series, and the creep compliance that belongs to it.

After a step of strain the modulus falls as E(t)/E₀ = 1 − Σ gᵢ (1 − e^{−t/τᵢ}), gᵢ > 0, Σ gᵢ < 1. After a step of stress the
compliance grows as J(t)/J₀ = 1 + Σ cⱼ (1 − e^{−t/θⱼ}), J₀ = 1/E₀, with as many retardation times θⱼ. Both are linked by
s Ē · s J̄ = 1 (Laplace transforms; Tschoegl 1989, The Phenomenological Theory of Linear Viscoelastic Behavior, 3.3): the rates
λ = 1/θ are the zeros of 1 − Σ gᵢ rᵢ/(rᵢ − λ), r = 1/τ, one below the smallest r and one between any two neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import scipy

Series = tuple[tuple[float, float], ...]
"""Pairs of a share (relative to the instantaneous value) and a time in s."""


ONE_TIME = 1e-6
"""Relative difference up to which two times count as one."""


def retardation(relaxation: Sequence[tuple[float, float]]) -> Series:
    """The pairs (cⱼ, θⱼ) of the compliance from the pairs (gᵢ, τᵢ) of the modulus; times rise."""
    modes: list[tuple[float, float]] = []
    for time, share in sorted((time, share) for share, time in relaxation):
        if modes and time - modes[-1][1] <= ONE_TIME * time:
            share, time = share + modes.pop()[0], time
        modes.append((share, time))
    pairs, slower = [], math.inf
    for own, time in reversed(modes):
        others = [(share, other) for share, other in modes if other != time]

        # The zero is at λ = (1 − gap)/τ: a small share leaves it close to the rate.
        def excess(gap: float, own: float = own, time: float = time, others: Series = tuple(others)) -> float:
            return gap * (1.0 - sum(share / (1.0 - (1.0 - gap) * other / time) for share, other in others)) - own

        # Up to just above the next slower rate, where the sum jumps.
        widest = (1.0 - time / slower) * (1.0 - 1e-9 * math.isfinite(slower))
        gap = float(scipy.optimize.brentq(excess, 0.0, widest, xtol=1e-300, rtol=1e-14)) if excess(widest) > 0.0 else widest
        slope = own / gap**2 + sum(share * other / time / (1.0 - (1.0 - gap) * other / time) ** 2 for share, other in others)
        pairs.append((1.0 / (slope * (1.0 - gap)), time / (1.0 - gap)))
        slower = time
    return tuple(reversed(pairs))


def modulus_at(relaxation: Sequence[tuple[float, float]], frequency: Any) -> Any:
    """Complex modulus over E₀ at an angular `frequency` (rad/s), or at several: 1 − Σ g/(1 + iωτ)."""
    return 1.0 - sum(share / (1.0 + 1j * frequency * time) for share, time in relaxation)

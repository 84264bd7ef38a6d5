"""Complete elliptic integrals by the arithmetic–geometric mean, without the half second that importing SciPy's takes."""

from __future__ import annotations

import math


def complete_elliprf(y: float, z: float) -> float:
    """Carlson's R_F(0, y, z) = π / (2 M(√y, √z)), exact to rounding for y, z > 0 (DLMF 19.22.1)."""
    return 0.5 * math.pi / _mean(math.sqrt(y), math.sqrt(z))[0]


def complete_elliprd(y: float, z: float) -> float:
    """Carlson's R_D(0, y, z), exact to rounding for y, z > 0 (DLMF 19.25.1 with 19.8.6, 19.8.7).

    With k'² the ratio of the two and S the sum of `_mean`, (K − E)/k² = K (1/2 + S) and (E − k'²K)/k² = K (1/2 − S): nothing
    cancels near the circle."""
    small, large = math.sqrt(min(y, z)), math.sqrt(max(y, z))
    mean, total = _mean(small / large, 1.0)
    complete = 0.5 * math.pi / mean
    if y <= z:
        return 3.0 * complete * (0.5 + total) / large**3
    return 3.0 * complete * (0.5 - total) / (small * small * large)


def _mean(a: float, b: float) -> tuple[float, float]:
    """The arithmetic–geometric mean M(a, b), and S = Σ 2^(n−1) c_n²/(b² − a²), n ≥ 1, where c_n is half the difference of the
    (n−1)-th pair; from c_(n+1) = c_n²/(4 a_(n+1)), so that no digits are lost where both are alike."""
    half = 0.5 * (b - a)
    share = 0.5 * half / (b + a)
    total, weight = 0.0, 1.0
    while True:
        total, weight = total + weight * share, 2.0 * weight
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        if abs(half) <= 1e-9 * a:
            return a, total
        following = 0.5 * (a + b)
        share *= (0.25 * half / following) ** 2
        half *= 0.25 * half / following

"""A rigid cylinder that rolls without friction on a half-plane that relaxes: one retardation time, plane strain.

Hunter, J. Appl. Mech. 28 (1961) 611. Material flows towards +x through the contact c − h < x < c + h under the load w per
length. With the compliances J_∞ = 1/E*_∞ and J₀ = 1/E*₀ and the length l = Vθ rolled in the retardation time, a pressure that
deforms an elastic half-plane as p deforms this one is

    q = J_∞ p + J₀ l p′ = [a₀ − A t − ½B (2t² − 1)]/√(1 − t²),    t = (x − c)/h,
    a₀ = J_∞ w/(πh),    A = (c + l)/2R,    B = h/2R.

h and c follow from p(1) = 0 and from the slope at the leading edge (λ = J_∞ h/(J₀ l), κ = h/l, a₁ = −A, a₂ = −B/2):

    a₀ I₀(λ) − A I₁(λ) − ½B I₂(λ) = 0,    2κ ∫₀^∞ e^{−κ(cosh ϑ − 1)} Σ aₙ (−1)ⁿ e^{−nϑ} dϑ = −(c − h)/R.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from thermoroll_cli.exact.hertz import check_positive
from thermoroll_cli.tools.arrays import Array

NODES = 400
"""Gauss points of the integrals."""


@dataclass(frozen=True)
class HunterContact:
    """Half-width h and `centre` c in units of the half-width a of the relaxed contact, a² = 4wR/(πE*_∞); `ratio` of the relaxed
    over the instantaneous compliance, `length` l/a."""

    ratio: float
    length: float
    half_width: float
    centre: float

    @property
    def _coefficients(self) -> tuple[float, float, float]:
        """a₀, A, B, all times 4R/a."""
        return 1.0 / self.half_width, 2.0 * (self.centre + self.length), 2.0 * self.half_width

    @property
    def moment(self) -> float:
        """Moment ∫ p x dx of the pressure over w a; negative, because the pressure leads."""
        a0, a, _ = self._coefficients
        first = math.pi * self.half_width * (a0 * self.centre - 0.5 * a * self.half_width)
        return first / math.pi + self.length / self.ratio

    def pressure(self, t: Array) -> Array:
        """p at t = (x − c)/h, from −1 to 1, over the largest pressure 2w/(πa) of the relaxed contact."""
        a0, a, b = self._coefficients
        rate = self.ratio * self.half_width / self.length
        # s = −cos φ takes the root out of ∫ e^{−λ(t − s)} q(s) ds from the leading edge.
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        end = np.arccos(-np.clip(np.asarray(t, dtype=np.float64), -1.0, 1.0))[..., None]
        s = -np.cos(0.5 * end * (1.0 + nodes))
        integrand = np.exp(-rate * (-np.cos(end) - s)) * (a0 - a * s - 0.5 * b * (2.0 * s * s - 1.0))
        return np.asarray(0.5 * rate * (integrand * weights * 0.5 * end).sum(axis=-1))


EASY = 0.02
"""Length up to which the search begins from the relaxed contact; from there on to longer ones."""


def hunter(ratio: float, length: float) -> HunterContact:
    """The contact at a `ratio` of compliances above 1 and a `length` l/a. Raises ValueError for others."""
    check_positive(length=length, ratio_above_one=ratio - 1.0)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)

    def residual(unknown: Array, length: float) -> list[float]:
        h, c = float(np.exp(unknown[0])), float(unknown[1])
        a0, a, b = HunterContact(ratio, length, h, c)._coefficients
        rate, kappa = ratio * h / length, h / length
        bessel = scipy.special.ive((0, 1, 2), rate) / scipy.special.ive(0, rate)
        reach = math.acosh(1.0 + 40.0 / kappa)
        angle = 0.5 * reach * (1.0 + nodes)
        bracket = a0 + a * np.exp(-angle) - 0.5 * b * np.exp(-2.0 * angle)
        slope = kappa * reach * float((np.exp(-kappa * (np.cosh(angle) - 1.0)) * bracket * weights).sum())
        return [a0 - a * bessel[1] - 0.5 * b * bessel[2], slope + 4.0 * (c - h)]

    lengths = np.geomspace(min(EASY, length), length, 2 + 8 * max(math.ceil(math.log10(length / EASY)), 0))
    unknown = np.zeros(2)
    for longer in lengths:
        found = scipy.optimize.root(residual, unknown, args=(float(longer),), tol=1e-12)
        unknown = found.x
    if not found.success:
        raise ValueError(f"no contact was found at a ratio of {ratio:g} and a length of {length:g} a")
    return HunterContact(ratio, length, float(np.exp(unknown[0])), float(unknown[1]))

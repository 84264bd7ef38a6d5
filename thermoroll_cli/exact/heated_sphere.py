"""A sphere that slides and heats itself: the coupled thermo-elastic contact with stationary heat, exact up to collocation.

Round contact, full sliding at a slip speed s that is the same everywhere, sources at rest in both bodies. The heat flux is
q = μ s p, and inside the contact of radius a (Dundurs & Comninou 1976; Barber 1980)

    A p = δ − r²/(2R') + u,      A p = 1/(πE*) ∬ p/|x − x'|,      ∇²u = −c q,     c = Σ (1 + ν)α η/k  (each body, its share η)

with u the thermal expansion of both towards each other: in steady conduction the curvature is proportional to the local flux.
With ρ = r/a the pressure is expanded in

    p = Σ_k c_k (1 − ρ²)^{k+1/2},     A of each term = (a/E*) B(½, k + 3/2) ₂F₁(½, −k − 1; 1; ρ²)     (a polynomial)
    u' of each term = −c μ s a²/r · [1 − (1 − ρ²)^{k+3/2}]/(2k + 3)

and the first equation is collocated. Terms k ≥ 0 vanish at the border, so the smooth border condition is built in, and the
load belongs to a: the radius is found from it. The unknown constant of u goes with the approach δ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import beta, hyp2f1

from thermoroll_cli.exact.hertz import check_positive, hertz_contact
from thermoroll_cli.tools.arrays import Array

TERMS = 12
"""γ_p is then good to 1e-6 and the radius to 3e-5 (its error falls like 1/terms⁴), also where the contact has shrunk to a
quarter; from 14 on rounding grows."""
NODES = 40
"""Gauss points of the expansion's integral."""
SMALLEST_RADIUS = 0.02
"""Radius over Hertz's below which no state is searched for."""


@dataclass(frozen=True)
class HeatedSphere:
    """`radius` of the contact (m), `radius_cold` without heat (m), `peak_cold` (Pa), pressure `coefficients` c_k (Pa),
    `normal_force` (N), `contact_modulus` E* (Pa)."""

    radius: float
    radius_cold: float
    peak_cold: float
    coefficients: Array
    normal_force: float
    contact_modulus: float

    @property
    def peak_ratio(self) -> float:
        """γ_p: pressure in the centre over Hertz's."""
        return float(self.coefficients.sum()) / self.peak_cold

    @property
    def area_ratio(self) -> float:
        """γ_c: contact area over Hertz's."""
        return (self.radius / self.radius_cold) ** 2

    def pressure(self, r: ArrayLike) -> Array:
        """p in Pa at the distances r (m) from the centre; shape of r."""
        s = np.sqrt(np.maximum(1.0 - (np.asarray(r, dtype=float) / self.radius) ** 2, 0.0))
        return np.asarray(sum(c * s ** (2 * k + 1) for k, c in enumerate(self.coefficients)))

    def centre_temperature(self, heat: float, conductivity: float) -> float:
        """Temperature rise in K in the centre of a body of `conductivity` (W/mK) that the share `heat` (W) of the heat enters,
        distributed like the pressure: 1/k ∫ q dr."""
        line = sum(c * 0.5 * beta(0.5, k + 1.5) for k, c in enumerate(self.coefficients)) * self.radius
        return float(line) * heat / self.normal_force / conductivity


def heated_sphere(
    contact_modulus: float, relative_curvature: float, normal_force: float, heating: float, terms: int = TERMS
) -> HeatedSphere:
    """The steady state of a round contact that slides everywhere at the same speed, with heat sources at rest.

    Parameters: E* (Pa), 1/R' (1/m), load W (N), and `heating` = c μ s in 1/(Pa m): curvature of the gap per pressure, with
    c = Σ (1 + ν)α η/k over both bodies (m/W), coefficient of friction μ and slip speed s (m/s). There is a state at any heat:
    the load of a given radius grows from 0 to infinity before it changes sign, and the first radius that carries W counts.

    Raises ValueError for constants that are not positive (`heating` may be 0), and for a contact smaller than
    `SMALLEST_RADIUS`.
    """
    check_positive(contact_modulus=contact_modulus, relative_curvature=relative_curvature, normal_force=normal_force)
    if not heating >= 0.0:
        raise ValueError(f"heating must not be negative, got {heating}")
    hertz = hertz_contact(relative_curvature, relative_curvature, contact_modulus, normal_force)

    def coefficients(radius: float) -> Array:
        return _collocated(radius, contact_modulus, relative_curvature, heating, terms)

    def excess(radius: float) -> float:
        # The load grows with the radius up to infinity, where its heat alone would hold the contact together: its inverse
        # passes smoothly through zero there.
        return 1.0 - normal_force / _load(coefficients(radius), radius)

    low = SMALLEST_RADIUS * hertz.semi_axis_x
    if excess(low) >= 0.0:
        raise ValueError(f"the contact at heating = {heating:g} is smaller than {SMALLEST_RADIUS:g} of Hertz's")
    high = low
    while excess(high) < 0.0:
        low, high = high, min(1.05 * high, (1.0 + 1e-9) * hertz.semi_axis_x)

    radius = float(brentq(excess, low, high, xtol=1e-15 * high, rtol=1e-14))
    return HeatedSphere(radius, hertz.semi_axis_x, hertz.peak_pressure, coefficients(radius), normal_force, contact_modulus)


def gap_residual(state: HeatedSphere, relative_curvature: float, heating: float, r: ArrayLike) -> Array:
    """δ − r²/2R' + u − A p in m at distances r (m) inside the contact, less its mean: 0 for an exact state."""
    rho = np.asarray(r, dtype=float) / state.radius
    columns = _indentation(rho, state.radius, state.contact_modulus, len(state.coefficients))
    columns -= heating * _expansion(rho, state.radius, len(state.coefficients))
    residual = -0.5 * relative_curvature * (rho * state.radius) ** 2 - columns @ state.coefficients
    return np.asarray(residual - residual.mean())


def _collocated(radius: float, modulus: float, curvature: float, heating: float, terms: int) -> Array:
    # Chebyshev points on (0, 1): as many as there are coefficients and the approach.
    rho = 0.5 - 0.5 * np.cos(np.pi * (np.arange(terms + 1) + 0.5) / (terms + 1))
    matrix = np.empty((terms + 1, terms + 1))
    matrix[:, :terms] = _indentation(rho, radius, modulus, terms) - heating * _expansion(rho, radius, terms)
    scale = radius / modulus
    matrix[:, terms] = -scale
    return np.asarray(np.linalg.solve(matrix / scale, -0.5 * curvature * (rho * radius) ** 2 / scale)[:terms])


def _indentation(rho: Array, radius: float, modulus: float, terms: int) -> Array:
    """A of each term in m/Pa, (len(rho), terms)."""
    k = np.arange(terms)
    return np.asarray(radius / modulus * beta(0.5, k + 1.5) * hyp2f1(0.5, -(k + 1.0), 1.0, rho[:, None] ** 2))


def _expansion(rho: Array, radius: float, terms: int) -> Array:
    """u of each term over the heating, zero in the centre, in m²: with s² = 1 − ρ² the integral of u' is
    −a²/(2k + 3) ∫_s^1 t (1 − t^{2k+3})/(1 − t²) dt, whose integrand is smooth."""
    nodes, weights = leggauss(NODES)
    s = np.sqrt(1.0 - rho**2)[:, None]
    t = s + (1.0 - s) * 0.5 * (nodes + 1.0)
    weights = 0.5 * weights * (1.0 - s) * t / (1.0 + t)
    # (1 − t^n)/(1 − t) = 1 + t + … + t^{n−1}
    powers = t[:, :, None] ** np.arange(2 * terms + 1)
    sums = np.cumsum(powers, axis=2)[:, :, 2::2]
    integral = np.einsum("rn,rnk->rk", weights, sums)
    return -(radius**2) / (2.0 * np.arange(terms) + 3.0) * integral


def _load(coefficients: Array, radius: float) -> float:
    """2π ∫ p r dr of all terms."""
    return float(sum(c / (2 * k + 3) for k, c in enumerate(coefficients))) * 2.0 * math.pi * radius**2

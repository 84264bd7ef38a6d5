"""Kalker's creepage coefficients, and creep forces by linear theory, saturation, FASTSIM and Polach's formulas.

Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), Secs. 2.2 and 3.7, App. E. In the limit of vanishing
creepage (no slip anywhere) an elliptic contact with semi-axes a (along rolling) and b transmits

    F_x = G a b C11 ξ_x
    F_y = G a b [C22 ξ_y − sqrt(ab) C23 ξ_φ]
    M_z = G (ab)^(3/2) [C23 ξ_y + sqrt(ab) C33 ξ_φ]

in the conventions of this program: traction along the slip of body 1 relative to body 2, ṡ_x/V = ξ_x − ξ_φ y,
ṡ_y/V = ξ_y + ξ_φ x, material flowing towards +x. Kalker has the leading edge at +x and the traction on body 1. His frame is
this one rotated by 180° about z (docs/frames.md): ξ_x and ξ_y change sign and ξ_φ does not, hence the minus sign beside C23.
(The mirror x → −x gives the same equations, since the ellipse is symmetric; profiles then must be mirrored, too.) G and ν are
the combined constants of both bodies.

The simplified theories that vehicle dynamics uses, FASTSIM (Kalker 1982) and Polach's formulas (1999), use the same
coefficients for the elastic part and neglect heat. Both differ from the complete theory by up to about 15 %, more with much
spin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from thermoroll_cli.exact.hertz import HertzContact, check_positive
from thermoroll_cli.tools.arrays import Array

THEORIES = {"linear": "Kalker's linear theory", "fastsim": "FASTSIM", "polach": "Polach"}
"""Theories of creep forces, and their words."""

TABLE_POISSON_RATIOS = (0.0, 0.25, 0.5)

Row = tuple[float, tuple[float, ...], tuple[float, ...], tuple[float, ...], tuple[float, ...]]
TABLE: tuple[Row, ...] = (
    (0.1, (2.51, 3.31, 4.85), (2.51, 2.52, 2.53), (0.334, 0.473, 0.731), (6.42, 8.28, 11.7)),
    (0.2, (2.59, 3.37, 4.81), (2.59, 2.63, 2.66), (0.483, 0.603, 0.809), (3.46, 4.27, 5.66)),
    (0.3, (2.68, 3.44, 4.8), (2.68, 2.75, 2.81), (0.607, 0.715, 0.889), (2.49, 2.96, 3.72)),
    (0.4, (2.78, 3.53, 4.82), (2.78, 2.88, 2.98), (0.72, 0.823, 0.977), (2.02, 2.32, 2.77)),
    (0.5, (2.88, 3.62, 4.83), (2.88, 3.01, 3.14), (0.827, 0.929, 1.07), (1.74, 1.93, 2.22)),
    (0.6, (2.98, 3.72, 4.91), (2.98, 3.14, 3.31), (0.93, 1.03, 1.18), (1.56, 1.68, 1.86)),
    (0.7, (3.09, 3.81, 4.97), (3.09, 3.28, 3.48), (1.03, 1.14, 1.29), (1.43, 1.5, 1.6)),
    (0.8, (3.19, 3.91, 5.05), (3.19, 3.41, 3.65), (1.13, 1.25, 1.4), (1.34, 1.37, 1.42)),
    (0.9, (3.29, 4.01, 5.12), (3.29, 3.54, 3.82), (1.23, 1.36, 1.51), (1.27, 1.27, 1.27)),
    (1.0, (3.4, 4.12, 5.2), (3.4, 3.67, 3.98), (1.33, 1.47, 1.63), (1.21, 1.19, 1.16)),
    (1 / 0.9, (3.51, 4.22, 5.3), (3.51, 3.81, 4.16), (1.44, 1.59, 1.77), (1.16, 1.11, 1.06)),
    (1 / 0.8, (3.65, 4.36, 5.42), (3.65, 3.99, 4.39), (1.58, 1.75, 1.94), (1.1, 1.04, 0.954)),
    (1 / 0.7, (3.82, 4.54, 5.58), (3.82, 4.21, 4.67), (1.76, 1.95, 2.18), (1.05, 0.965, 0.852)),
    (1 / 0.6, (4.06, 4.78, 5.8), (4.06, 4.5, 5.04), (2.01, 2.23, 2.5), (1.01, 0.892, 0.751)),
    (2.0, (4.37, 5.1, 6.11), (4.37, 4.9, 5.56), (2.35, 2.62, 2.96), (0.958, 0.819, 0.65)),
    (2.5, (4.84, 5.57, 6.57), (4.84, 5.48, 6.31), (2.88, 3.24, 3.7), (0.912, 0.747, 0.549)),
    (1 / 0.3, (5.57, 6.34, 7.34), (5.57, 6.4, 7.51), (3.79, 4.32, 5.01), (0.868, 0.674, 0.446)),
    (5.0, (6.96, 7.78, 8.82), (6.96, 8.14, 9.79), (5.72, 6.63, 7.89), (0.828, 0.601, 0.341)),
    (10.0, (10.7, 11.7, 12.9), (10.7, 12.8, 16.0), (12.2, 14.6, 18.0), (0.795, 0.526, 0.228)),
)
"""Kalker's printed table, three digits: a/b, then C11, C22, C23, C33, each for ν = 0, 0.25, 0.5."""


class CreepageCoefficients(NamedTuple):
    """Kalker's dimensionless creepage coefficients of one ellipse and Poisson's ratio (C32 = −C23)."""

    c11: float
    c22: float
    c23: float
    c33: float


class CreepForces(NamedTuple):
    """Creep forces `force_x`, `force_y` (N) and spin moment `moment_z` (N m)."""

    force_x: float
    force_y: float
    moment_z: float


class Flexibilities(NamedTuple):
    """Flexibilities of Kalker's simplified theory (displacement over traction, m/Pa)."""

    longitudinal: float
    lateral: float
    spin: float


def combined_constants(
    shear_modulus_1: float, poisson_ratio_1: float, shear_modulus_2: float, poisson_ratio_2: float
) -> tuple[float, float]:
    """Combined (G, ν) of two bodies: 1/G = ½(1/G₁ + 1/G₂), ν/G = ½(ν₁/G₁ + ν₂/G₂)."""
    shear_modulus = 2.0 / (1.0 / shear_modulus_1 + 1.0 / shear_modulus_2)
    poisson_ratio = 0.5 * shear_modulus * (poisson_ratio_1 / shear_modulus_1 + poisson_ratio_2 / shear_modulus_2)
    return shear_modulus, poisson_ratio


def creepage_coefficients(aspect_ratio: float, poisson_ratio: float) -> CreepageCoefficients:
    """Creepage coefficients for a/b = `aspect_ratio` (a along rolling) and ν = `poisson_ratio`.

    Between the printed values: cubic in ln C over ln(a/b), then quadratic in 1/C over ν. The table has three digits, C33 the
    least: good to about 0.5 % for moderate ellipses, to 0.9 % at a/b = 6.9. Outside 0.1 ≤ a/b ≤ 10 the asymptotes of
    `asymptotic_coefficients` continue the table, scaled to join it and approaching the pure asymptote: 1.6 % at a/b = 27.

    Raises ValueError if a/b is not positive and finite or ν is outside [0, 0.5].
    """
    check_positive(aspect_ratio=aspect_ratio)
    if not 0.0 <= poisson_ratio <= 0.5:
        raise ValueError(f"poisson_ratio must lie in [0, 0.5], got {poisson_ratio!r}")
    inside = min(max(aspect_ratio, TABLE[0][0]), TABLE[-1][0])
    values = _interpolated(inside, poisson_ratio)
    if inside != aspect_ratio:
        distance = min(aspect_ratio / inside, inside / aspect_ratio)
        at_end = _asymptotes(inside, poisson_ratio)
        values = _asymptotes(aspect_ratio, poisson_ratio) * (1.0 + (values / at_end - 1.0) * distance)
    return CreepageCoefficients(*(float(value) for value in values))


def asymptotic_coefficients(aspect_ratio: float, poisson_ratio: float) -> CreepageCoefficients:
    """Kalker's asymptotes for a/b → 0 (used below 1) and b/a → 0 (used above 1) (Kalker 1990, App. E).

    C11, C22, C33 for a/b → 0 are those of independent strips. At a/b = 0.1 or 10 the asymptotes are 1–7 % off.
    """
    return CreepageCoefficients(*(float(value) for value in _asymptotes(aspect_ratio, poisson_ratio)))


def linear_creep_forces(
    coefficients: CreepageCoefficients, semi_axis_x: float, semi_axis_y: float, shear_modulus: float, creepage_x: float = 0.0,
    creepage_y: float = 0.0, spin: float = 0.0
) -> CreepForces:
    """Creep forces of the linear theory (equations in the module's docstring), valid while |F| ≪ μW.

    Parameters: semi-axes a (rolling) and b (m), combined shear modulus G (Pa), creepages (1), spin ξ_φ (rad/m).
    """
    area = semi_axis_x * semi_axis_y
    mean = math.sqrt(area)
    c = coefficients
    return CreepForces(
        force_x=shear_modulus * area * c.c11 * creepage_x,
        force_y=shear_modulus * area * (c.c22 * creepage_y - mean * c.c23 * spin),
        moment_z=shear_modulus * area * mean * (c.c23 * creepage_y + mean * c.c33 * spin),
    )


def full_slip_creepages(
    contact: HertzContact, friction: float, shear_modulus: float, poisson_ratio: float
) -> tuple[float, float]:
    """Pure creepages (ξ_x, ξ_y) from which on the whole contact slips.

    The traction μp along the creepage must leave no stick at the leading edge: ξ = ∂u/∂x at (−a0, 0),

        ξ_x, ξ_y = μp0/(G a0 b0²) ∫_0^π f(θ) sin²θ (cos²θ/a0² + sin²θ/b0²)^(−3/2) dθ,
        f_x = 1 − ν sin²θ,   f_y = 1 − ν cos²θ;     circle: ξ_x = π(4 − 3ν)μp0/(8G), ξ_y = π(4 − ν)μp0/(8G).

    Exact for ν = 0, where the slip is parallel to the creepage everywhere, and between cylinders, where it is 2μp0(1−ν)/G and
    2μp0/G. G and ν are combined constants.
    """
    a, b = contact.semi_axis_x, contact.semi_axis_y
    if math.isinf(b):
        across = 2.0 * friction * contact.peak_pressure / shear_modulus
        return (1.0 - poisson_ratio) * across, across
    # the parametric angle ψ, tan θ = sqrt(b/a) tan ψ, leaves a smooth periodic integrand: trapezoidal sum
    count = 2000
    psi = (np.arange(count) + 0.5) * (math.pi / count)
    root = math.sqrt(b / a)
    norm = np.cos(psi) ** 2 + (root * np.sin(psi)) ** 2
    cos2, sin2 = np.cos(psi) ** 2 / norm, (root * np.sin(psi)) ** 2 / norm
    d_theta = root / norm * (math.pi / count)
    weight = sin2 * (cos2 / a**2 + sin2 / b**2) ** -1.5 * d_theta
    scale = friction * contact.peak_pressure / (shear_modulus * a * b**2)
    longitudinal = scale * float(np.sum((1.0 - poisson_ratio * sin2) * weight))
    lateral = scale * float(np.sum((1.0 - poisson_ratio * cos2) * weight))
    return longitudinal, lateral


def fastsim_flexibilities(
    coefficients: CreepageCoefficients, semi_axis_x: float, semi_axis_y: float, shear_modulus: float
) -> Flexibilities:
    """FASTSIM's flexibilities L1 = 8a/(3 C11 G), L2 = 8a/(3 C22 G), L3 = π a sqrt(a/b)/(4 C23 G) (Kalker 1982)."""
    a, b, c = semi_axis_x, semi_axis_y, coefficients
    return Flexibilities(
        longitudinal=8.0 * a / (3.0 * c.c11 * shear_modulus),
        lateral=8.0 * a / (3.0 * c.c22 * shear_modulus),
        spin=math.pi * a * math.sqrt(a / b) / (4.0 * c.c23 * shear_modulus),
    )


def _interpolated(aspect_ratio: float, poisson_ratio: float) -> Array:
    """C11, C22, C23, C33 inside the table."""
    abscissa, ordinate = np.log([row[0] for row in TABLE]), np.log([row[1:] for row in TABLE])
    slope = np.gradient(ordinate, abscissa, axis=0, edge_order=2)
    # Cubic Hermite interpolation. scipy.interpolate does it, too, but loading it takes a quarter of the start of a process.
    x = math.log(aspect_ratio)
    k = int(np.clip(np.searchsorted(abscissa, x) - 1, 0, len(abscissa) - 2))
    h = abscissa[k + 1] - abscissa[k]
    t = (x - abscissa[k]) / h
    columns = ((1.0 + 2.0 * t) * (1.0 - t) ** 2 * ordinate[k] + t * (1.0 - t) ** 2 * h * slope[k]
               + t**2 * (3.0 - 2.0 * t) * ordinate[k + 1] - t**2 * (1.0 - t) * h * slope[k + 1])
    # 1/C is very nearly a parabola in ν (1e-5 at ν = 0.28); C itself is not (1e-3)
    parabola = np.polyfit(TABLE_POISSON_RATIOS, np.exp(-columns).T, 2)
    return np.asarray(1.0 / np.polyval(parabola, poisson_ratio))


def _asymptotes(aspect_ratio: float, poisson_ratio: float) -> Array:
    """C11, C22, C23, C33 for a wide (a/b ≪ 1) or slender (a/b ≫ 1) contact."""
    nu, pi = poisson_ratio, math.pi
    g = min(aspect_ratio, 1.0 / aspect_ratio)
    ln = math.log(16.0 / g**2)
    if aspect_ratio < 1.0:
        spin = pi * math.sqrt(g) / (3.0 * (1.0 - nu)) * (1.0 + nu * (0.5 * ln + math.log(4.0) - 5.0))
        return np.array([pi**2 / (4.0 * (1.0 - nu)), pi**2 / 4.0, spin, pi**2 / (16.0 * (1.0 - nu) * g)])
    mixed = (1.0 - nu) * ln + 2.0 * nu
    coupled = (1.0 - nu) * ln - 2.0 + 4.0 * nu
    return np.array(
        [
            2.0 * pi / ((ln - 2.0 * nu) * g) * (1.0 + (3.0 - math.log(4.0)) / (ln - 2.0 * nu)),
            2.0 * pi / (mixed * g) * (1.0 + (1.0 - nu) * (3.0 - math.log(4.0)) / mixed),
            2.0 * pi / (3.0 * g**1.5 * coupled),
            pi / 4.0 * (1.0 - nu * (ln - 2.0) / coupled),
        ]
    )


STRIPS, STEPS = 40, 80
"""Strips along rolling and elements in each: creep forces to 0.2 % of μW."""


def fastsim(
    coefficients: CreepageCoefficients, semi_axis_x: float, semi_axis_y: float, shear_modulus: float, limit: float,
    creepage_x: float = 0.0, creepage_y: float = 0.0, spin: float = 0.0,
) -> CreepForces:
    """Creep forces of Kalker's simplified theory, u = L τ, on an elliptic contact.

    From the leading edge on the traction of a strip grows by the rigid slip,

        dτ_x/dx = ξ_x/L1 − ξ_φ y/L3,    dτ_y/dx = ξ_y/L2 + ξ_φ x/L3,

    and is cut back to the bound, which falls off like a paraboloid, 2 μW/(π a b) (1 − x²/a² − y²/b²). The flexibilities are
    those of `fastsim_flexibilities`: without slip, the forces are those of the linear theory.

    Parameters: semi-axes a (rolling) and b (m), combined shear modulus G (Pa), `limit` μW (N), creepages (1), spin ξ_φ (rad/m).
    Raises ValueError if `limit` is not positive.
    """
    check_positive(limit=limit)
    a, b = semi_axis_x, semi_axis_y
    flexibility = fastsim_flexibilities(coefficients, a, b, shear_modulus)
    y = b * ((np.arange(STRIPS) + 0.5) / STRIPS * 2.0 - 1.0)
    half = a * np.sqrt(1.0 - (y / b) ** 2)
    dx = 2.0 * half / STEPS
    element = dx * 2.0 * b / STRIPS
    x_all = -half + (np.arange(STEPS)[:, None] + 0.5) * dx
    # 2 μW/(π a b) times the paraboloid, whose sum is exactly μW on these elements.
    bounds = half**2 - x_all**2
    bounds *= limit / (bounds * element).sum()
    tau_x, tau_y = np.zeros(STRIPS), np.zeros(STRIPS)
    force_x = force_y = moment = 0.0
    grow_x = dx * (creepage_x / flexibility.longitudinal - spin * y / flexibility.spin)
    for step, (x, bound) in enumerate(zip(x_all, bounds, strict=True)):
        share = 0.5 if step == 0 else 1.0  # from the edge to the middle of the first element
        # If the centre moves from element to element, the spin term is taken half a step before it.
        grow_y = dx * (creepage_y / flexibility.lateral + spin * (x - 0.5 * dx * share) / flexibility.spin)
        tau_x, tau_y = tau_x + share * grow_x, tau_y + share * grow_y
        size = np.hypot(tau_x, tau_y)
        cut = np.where(size > bound, bound / np.where(size > 0.0, size, 1.0), 1.0)
        tau_x, tau_y = tau_x * cut, tau_y * cut
        force_x += float((tau_x * element).sum())
        force_y += float((tau_y * element).sum())
        moment += float(((x * tau_y - y * tau_x) * element).sum())
    return CreepForces(force_x, force_y, moment)


def polach(
    coefficients: CreepageCoefficients, semi_axis_x: float, semi_axis_y: float, shear_modulus: float, limit: float,
    creepage_x: float = 0.0, creepage_y: float = 0.0, spin: float = 0.0,
) -> CreepForces:
    """Creep forces by Polach's formulas (Vehicle System Dynamics 33 Suppl., 728–739, 1999); the spin moment is nan.

        F = (2 μW/π) [ε/(1 + ε²) + arctan ε],    ε = π G a b c s_c/(4 μW),    c = |(C11 ξ_x, C22 ξ_y)|/|(ξ_x, ξ_y)|
        F_x = F ξ_x/s_c,    F_y = F ξ_y/s_c + F_s,    s_c = |(ξ_x, ξ_yc)|,    ξ_yc = ξ_y − a ξ_φ if that is larger, or ξ_y
        F_s = (9/16) a μW K B ξ_φ/s_c,    B = 1 + 6.3 (1 − exp(−a/b))
        K = ε_s (δ³/3 − δ²/2 + 1/6) − (1 − δ²)^(3/2)/3,    δ = (ε_s² − 1)/(ε_s² + 1)
        ε_s = 8 G b sqrt(ab) C23 |ξ_yc|/(3 μW B)

    (K is negative; with the signs of this program spin acts against a positive lateral creepage.) Parameters as for `fastsim`.
    Raises ValueError if `limit` is not positive.
    """
    check_positive(limit=limit)
    a, b, c = semi_axis_x, semi_axis_y, coefficients
    with_spin = creepage_y - a * spin
    lateral = with_spin if abs(with_spin) > abs(creepage_y) else creepage_y
    total = math.hypot(creepage_x, lateral)
    if total == 0.0:
        return CreepForces(0.0, 0.0, math.nan)
    rigid = math.hypot(creepage_x, creepage_y)
    stiffness = math.hypot(c.c11 * creepage_x, c.c22 * creepage_y) / rigid if rigid > 0.0 else 0.0
    gradient = math.pi * shear_modulus * a * b * stiffness * total / (4.0 * limit)
    force = 2.0 * limit / math.pi * (gradient / (1.0 + gradient**2) + math.atan(gradient))
    shape = 1.0 + 6.3 * (1.0 - math.exp(-a / b))
    turned = 8.0 * shear_modulus * b * math.sqrt(a * b) * c.c23 * abs(lateral) / (3.0 * limit * shape)
    delta = (turned**2 - 1.0) / (turned**2 + 1.0)
    bend = turned * (delta**3 / 3.0 - delta**2 / 2.0 + 1.0 / 6.0) - (1.0 - delta**2) ** 1.5 / 3.0
    by_spin = 9.0 / 16.0 * a * limit * bend * shape * spin / total
    return CreepForces(force * creepage_x / total, force * creepage_y / total + by_spin, math.nan)

"""Creep forces of the simplified theories that vehicle dynamics uses: FASTSIM (Kalker 1982) and Polach's formulas (1999).

Both use Kalker's creepage coefficients for the elastic part and neglect heat, and both differ from the complete theory by
up to about 15 %, more with much spin. They use the conventions of `kalker`: traction along the slip
of body 1 relative to body 2, material flowing towards +x.
"""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.exact.kalker import CreepageCoefficients, CreepForces, fastsim_flexibilities

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
    _require(limit)
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
        # Where the centre moves from element to element, the spin term is taken half a step before it.
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
    _require(limit)
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


def _require(limit: float) -> None:
    if not limit > 0.0:
        raise ValueError(f"limit must be positive, got {limit!r}")

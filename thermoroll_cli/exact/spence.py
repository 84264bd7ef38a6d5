"""Normal indentation with friction between different materials: Spence's stick circle.

Spence (Proc. R. Soc. A 305, 1968; J. Elasticity 5, 1975). When a sphere is pressed on a body of another material, the
surfaces stretch differently, stick in a circle of radius c and slip towards the centre outside of it. Loading is
self-similar: c/a depends on the friction μ and on Dundurs' β only (rigid sphere: β = (1−2ν)/(2(1−ν))), and is the
same for a flat punch, whose solutions of growing radius add up to that of the sphere (Mossakovskii). For unit
penetration of a flat punch of unit radius, E* = 2 and the traction τ on the body outwards,

    u_z(r) = ∫ p I_0(r, s) s ds − β ∫_r^1 τ ds = 1                    r < 1
    u_r(r) = ∫ τ I_1(r, s) s ds − β/r ∫_0^r p s ds = 0                r < c,      τ = μp for r > c,
    I_n    = ∫_0^∞ J_n(kr) J_n(ks) dk,

with μ such that τ is bounded at c. There is no closed form; `spence_contact` solves these equations by collocation on
rings and extrapolates. There is a closed form if the effect of τ on p is neglected, `uncoupled_friction`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import newton
from scipy.special import ellipe, ellipk, ellipkm1

from thermoroll_cli.tools.arrays import Array

PUBLISHED_FRICTION = 0.2986
"""μ at which a rigid sphere on a body with ν = 0 (β = ½) sticks in c/a = ½ (Spence 1975; Kalker 1990, Fig. 5.25)."""

PUBLISHED_CENTRE_PRESSURE = 1.31
"""p(0) over the Hertz peak pressure of the same load in that case."""


class SpenceContact(NamedTuple):
    """Frictional indentation by a sphere; dimensionless.

    Fields: `stick_ratio` = c/a, `dundurs_beta` = β, `friction` = μ that goes with them, `centre_pressure` = p(0) over
    the Hertz peak pressure of the same load, `load` over the Hertz load of the same contact radius.
    """

    stick_ratio: float
    dundurs_beta: float
    friction: float
    centre_pressure: float
    load: float


def uncoupled_friction(stick_ratio: float, dundurs_beta: float) -> float:
    """μ = β ln[(a + c)/(a − c)] a / (2c K'(c/a)): friction for a given c/a if tractions did not change the pressure.

    K'(k) = K(sqrt(1 − k²)). The exact limit for β → 0; 15 % low at β = ½, c/a = ½.

    Raises ValueError unless 0 < c/a < 1 and 0 < β ≤ ½.
    """
    _check(stick_ratio, dundurs_beta)
    return dundurs_beta * math.atanh(stick_ratio) / (stick_ratio * float(ellipkm1(stick_ratio**2)))


def spence_contact(stick_ratio: float, dundurs_beta: float) -> SpenceContact:
    """Solve for the friction that gives the stick radius c = `stick_ratio`·a (about 3e-4 relative; 0.2 s).

    Raises ValueError unless 0.1 ≤ c/a ≤ 0.9 and 0 < β ≤ ½.
    """
    _check(stick_ratio, dundurs_beta)
    if not 0.1 <= stick_ratio <= 0.9:
        raise ValueError(f"stick_ratio must lie in [0.1, 0.9], got {stick_ratio!r}")
    # first order in the ring width, smoothly: two steps of Richardson extrapolation
    coarse, middle, fine = (_solve_rings(stick_ratio, dundurs_beta, refinement) for refinement in (1, 2, 4))
    first, second = 2.0 * middle - coarse, 2.0 * fine - middle
    friction, centre_pressure, load = (4.0 * second - first) / 3.0
    return SpenceContact(stick_ratio, dundurs_beta, float(friction), float(centre_pressure), float(load))


def _check(stick_ratio: float, dundurs_beta: float) -> None:
    if not 0.0 < stick_ratio < 1.0:
        raise ValueError(f"stick_ratio must lie between 0 and 1, got {stick_ratio!r}")
    if not 0.0 < dundurs_beta <= 0.5:
        raise ValueError(f"dundurs_beta must lie in (0, 0.5], got {dundurs_beta!r}")


def _solve_rings(stick_ratio: float, beta: float, refinement: int) -> Array:
    """Friction, centre pressure ratio and load ratio on one grid of rings (equations of the module's docstring)."""
    # rings equal in asin(r) follow the pressure's root singularity at the punch's edge; one ends at c
    angle = math.asin(stick_ratio)
    sticking = refinement * max(4, round(32 * angle / (0.5 * math.pi)))
    slipping = refinement * max(4, 32 - sticking // refinement)
    theta = np.concatenate([np.linspace(0.0, angle, sticking + 1), np.linspace(angle, 0.5 * math.pi, slipping + 1)[1:]])
    edge, r = np.sin(theta), np.sin(0.5 * (theta[1:] + theta[:-1]))
    count = r.size
    annulus = 0.5 * np.diff(edge**2)

    normal, radial = _ring_integrals(_kernel_0, r, edge), _ring_integrals(_kernel_1, r, edge)
    lower = np.tril(np.ones((count, count)), -1)
    inward = -beta * (lower * annulus + np.diag(0.5 * (r**2 - edge[:-1] ** 2))) / r[:, None]
    normal_by_shear = -beta * (lower.T * np.diff(edge) + np.diag(edge[1:] - r))

    def tractions(friction: float) -> tuple[Array, Array]:
        slip = np.diag(np.where(np.arange(count) < sticking, 0.0, friction))
        top = np.hstack([normal + normal_by_shear @ slip, normal_by_shear[:, :sticking]])
        bottom = np.hstack([inward + radial @ slip, radial[:, :sticking]])[:sticking]
        right = np.concatenate([np.ones(count), np.zeros(sticking)])
        solution = np.linalg.solve(np.vstack([top, bottom]), right)
        pressure = solution[:count]
        return pressure, np.concatenate([solution[count:], friction * pressure[sticking:]])

    def jump(friction: float) -> float:
        traction = tractions(friction)[1]
        return float(traction[sticking - 1] - traction[sticking])

    guess = uncoupled_friction(stick_ratio, beta)
    friction = float(newton(jump, guess, x1=1.1 * guess, tol=1e-12))  # without a derivative: the secant method
    pressure, _ = tractions(friction)

    # sphere of unit radius: the penetration grows by D b db with the radius b, and gap r²/2 closes as punches approach
    node, gauss = leggauss(20)
    q = 0.5 * (node + 1.0)
    outside = _ring_integrals(_kernel_0, 1.0 / (1.0 - q**2), edge) @ pressure
    rate = 0.5 / float(np.sum((1.0 - outside) * (1.0 - q**2) * q * gauss))
    # Hertz with E* = 2, a = R = 1: load 8/3 and p0 = 4/π; at equal load p0 varies with its cube root
    load = 2.0 * math.pi * float(pressure @ annulus) * rate / 3.0 / (8.0 / 3.0)
    # p is even in r: parabola through the first two rings
    centre = (pressure[0] * r[1] ** 2 - pressure[1] * r[0] ** 2) / (r[1] ** 2 - r[0] ** 2)
    centre_pressure = centre * rate / (4.0 / math.pi) / math.cbrt(load)
    return np.array([friction, centre_pressure, load])


def _kernel_0(r: Array, s: Array) -> Array:
    low, high = np.minimum(r, s), np.maximum(r, s)
    return np.asarray(2.0 / math.pi * s / high * ellipk((low / high) ** 2))


def _kernel_1(r: Array, s: Array) -> Array:
    low, high = np.minimum(r, s), np.maximum(r, s)
    m = (low / high) ** 2
    return np.asarray(2.0 / math.pi * s / low * (ellipk(m) - ellipe(m)))


def _ring_integrals(kernel: Callable[[Array, Array], Array], r: Array, edge: Array) -> Array:
    """∫ kernel(r_i, s) ds over each ring, shape (r, rings), with nodes graded towards the logarithm at s = r."""
    node, gauss = leggauss(10)
    t = 0.5 * (node + 1.0)
    # every ring in two parts, both measured from the point nearest to r
    nearest = np.clip(r[:, None], edge[:-1], edge[1:])
    total = np.zeros(nearest.shape)
    for end in (edge[:-1], edge[1:]):
        length = (end - nearest)[:, :, None]
        s = nearest[:, :, None] + length * t**4
        values = np.abs(length) * kernel(r[:, None, None], np.where(length == 0.0, 0.5 * edge[1], s))
        total += values @ (0.5 * gauss * 4.0 * t**3)
    return total

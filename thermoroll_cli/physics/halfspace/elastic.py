"""Influence coefficients of uniformly loaded rectangles on an elastic half-space (Boussinesq–Cerruti, Love).

All surface displacements of a half-space follow from three integrals over the loaded rectangle,
    I_xx = ∬ (x−x')²/r³,   I_yy = ∬ (y−y')²/r³,   I_xy = ∬ (x−x')(y−y')/r³,      I_xx + I_yy = ∬ 1/r,
and, for the coupling of pressure with tangential and of shear with normal displacement, from J_x = ∬ (x−x')/r² and
J_y = ∬ (y−y')/r².

A rectangle with dy = inf is a strip without ends, the element of a line contact: no element lies beside it, and the kernels are
those of plane strain and anti-plane shear. I_xx and I_yy are then known up to a constant, which moves both bodies as a whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class ShearCompliance:
    """Sum over both bodies of (1−ν)/(2πG) and ν/(2πG) in 1/Pa, and the tangential compliance h/G of an `interlayer`
    between them in m/Pa: the constants of the tangential kernel of two half-spaces.

    `trust`, 0 to 1, says how well these describe other bodies near a border (`bodies.Bodies.near_border`)."""

    isotropic: float
    directional: float
    interlayer: float = 0.0
    trust: float = 1.0

    @classmethod
    def of(cls, *bodies: tuple[float, float], interlayer: float = 0.0) -> ShearCompliance:
        """From (shear modulus in Pa, Poisson ratio) of each body, and the compliance of the interlayer in m/Pa."""
        isotropic = sum((1.0 - nu) / (2.0 * np.pi * g) for g, nu in bodies)
        return cls(isotropic, sum(nu / (2.0 * np.pi * g) for g, nu in bodies), interlayer)

    @property
    def along(self) -> float:
        """Plane-strain compliance Σ(1−ν)/(πG)·… of traction and gradient both along x: π(isotropic)·2 in 1/Pa.

        In a strip that is long in y, ∂u_x/∂x = −(along/π)·⨍ τ_x/(x'−x) dx' with along = Σ (1−ν)/G."""
        return 2.0 * np.pi * self.isotropic

    @property
    def contact_modulus(self) -> float:
        """E* in Pa, with 1/E* = Σ (1−ν)/2G."""
        return 2.0 / self.along

    @property
    def across(self) -> float:
        """Anti-plane compliance Σ 1/G in 1/Pa, for τ_y and ∂u_y/∂x in the same strip."""
        return 2.0 * np.pi * (self.isotropic + self.directional)


def coupling_constant(lower: tuple[float, float], upper: tuple[float, float]) -> float:
    """K = (1−2ν₁)/(4πG₁) − (1−2ν₂)/(4πG₂) in 1/Pa, from (shear modulus in Pa, Poisson ratio) of each body.

    It couples the normal and the tangential problem (signs: `coupling_tables`) and is proportional to Dundurs' second
    constant, β = πE*·K with 1/E* of both bodies together. Differences within rounding count as zero (no coupling)."""
    first, second = ((1.0 - 2.0 * nu) / (4.0 * np.pi * g) for g, nu in (lower, upper))
    difference = first - second
    stiffest = max(1.0 / (4.0 * np.pi * g) for g, _ in (lower, upper))
    return 0.0 if abs(difference) <= 1e-12 * stiffest else float(difference)


def _cell_difference(corner: Array) -> Array:
    """Integral over each cell from its antiderivative at the cell's corners."""
    return corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]


def rectangle_integrals(nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
    """I_xx, I_yy, I_xy of one dx × dy rectangle, seen from element centres at offsets (i·dx, j·dy).

    Returns three arrays of shape (nx, ny) in units of length, for i = 0..nx−1 and j = 0..ny−1; I_xx and I_yy are even in
    both offsets, I_xy is odd in both. Source: Johnson, Contact Mechanics, 3.2–3.3 (Love's closed form).

    y·ln(x+r) is written as y·asinh(x/|y|): the difference y·ln|y| drops out over a rectangle, and asinh does not cancel
    for x < 0. Of a strip I_xx = 2 dx is constant, and left out, and I_yy = −2 ∫ ln|x−x'| dx' is zero at the last offset, so
    that it is nowhere negative.
    """
    if math.isinf(dy):
        ends = np.abs(np.arange(nx + 1) - 0.5)
        strip = -2.0 * dx * np.diff(np.sign(np.arange(nx + 1) - 0.5) * ends * np.log(ends))
        i_yy = np.zeros((nx, ny))
        i_yy[:, 0] = strip - strip[-1]
        return np.zeros((nx, ny)), i_yy, np.zeros((nx, ny))
    x, y = _corners(nx, ny, dx, dy)
    i_xx = _cell_difference(y * np.arcsinh(x / np.abs(y)))
    i_yy = _cell_difference(x * np.arcsinh(y / np.abs(x)))
    i_xy = _cell_difference(-np.hypot(x, y))
    i_xy[0, :] = 0.0  # odd functions vanish on their axis exactly, not just to rounding
    i_xy[:, 0] = 0.0
    return i_xx, i_yy, i_xy


def normal_table(nx: int, ny: int, dx: float, dy: float, contact_modulus: float) -> Array:
    """Love's normal displacement per unit pressure, u_z/p = 1/(πE*)·∬1/r in m/Pa, shape (nx, ny), even in both offsets.

    `contact_modulus` is E* of both bodies together, so the table is the approach of the two surfaces (Eqs. 4–5)."""
    i_xx, i_yy, _ = rectangle_integrals(nx, ny, dx, dy)
    return (i_xx + i_yy) / (np.pi * contact_modulus)


def shear_tables(nx: int, ny: int, dx: float, dy: float, compliance: ShearCompliance) -> tuple[Array, Array, Array]:
    """Relative tangential displacement of both bodies per unit traction: u_x/τ_x, u_y/τ_y, u_x/τ_y = u_y/τ_x (m/Pa).

    Three arrays of shape (nx, ny); the first two are even in both offsets, the third is odd in both (Eq. 15)."""
    i_xx, i_yy, i_xy = rectangle_integrals(nx, ny, dx, dy)
    isotropic = compliance.isotropic * (i_xx + i_yy)
    isotropic[0, 0] += compliance.interlayer  # the interlayer shears where it is loaded
    return (isotropic + compliance.directional * i_xx, isotropic + compliance.directional * i_yy,
            compliance.directional * i_xy)


def coupling_tables(nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array]:
    """J_x = ∬ (x−x')/r² and J_y = ∬ (y−y')/r² over one dx × dy rectangle, seen from element centres at (i·dx, j·dy), in m.

    Two arrays of shape (nx, ny); J_x is odd along x and even along y, J_y even along x and odd along y. Closed form:
    J_x is the second difference of F = ½ y ln(x²+y²) + x atan(y/x) over the corners, since ∂F/∂x = atan(y/x).

    A point load P on a half-space moves the surface towards itself by (1−2ν)/(4πG)·P/r, a tangential point load Q along x
    moves it inwards by (1−2ν)/(4πG)·Q x/r² (Johnson, Contact Mechanics, Eqs. 3.18 and 3.75; Maxwell's reciprocity links the
    two). Write k = (1−2ν)/(4πG). The pressure acts alike on both bodies, −τ on body 1 and τ on body 2, and
    displacements u_i of body i, as seen in the common directions x and y, give the slip ṡ/V = ξ + ∂(u_1 − u_2)/∂x. So
    the relative displacement in ṡ/V = ξ − ∂u/∂x is u = u_2 − u_1, and with K = k_1 − k_2 (`coupling_constant`)

        u_x^p = −k_2 J_x p + k_1 J_x p  =  K J_x p            u_y^p = K J_y p
        u_z^τ = k_1 (−J·τ) + k_2 (J·τ)  = −K (J_x τ_x + J_y τ_y)      (inwards, both bodies: opens the gap like u_z^e).

    J is antisymmetric, so both blocks together are symmetric, as they must be. In a long strip along y J_x is π dx on either
    side, ∂u_x^p/∂x = 2πK p:
    Bentall & Johnson's ½[(1−2ν₁)/G₁ − (1−2ν₂)/G₂] p. A softer lower body (K > 0) slips backwards in free rolling, F_x < 0.
    """
    if math.isinf(dy):
        step = np.zeros((nx, ny))
        step[1:, 0] = math.pi * dx
        return step, np.zeros((nx, ny))
    x, y = _corners(nx, ny, dx, dy)
    length = math.sqrt(dx * dy)  # a common factor in the logarithm drops out; near 1 it costs the fewest digits
    log = np.log(np.hypot(x, y) / length)
    j_x = _cell_difference(y * log + x * np.arctan(y / x))
    j_y = _cell_difference(x * log + y * np.arctan(x / y))
    j_x[0, :] = 0.0  # odd functions vanish on their axis exactly, not just to rounding
    j_y[:, 0] = 0.0
    return j_x, j_y


def _corners(nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array]:
    """Corners of the elements at offsets 0…nx−1, 0…ny−1, as (nx+1, 1) and (1, ny+1)."""
    x = np.asarray((np.arange(nx + 1) - 0.5) * dx, dtype=np.float64)
    y = np.asarray((np.arange(ny + 1) - 0.5) * dy, dtype=np.float64)
    return x[:, None], y[None, :]

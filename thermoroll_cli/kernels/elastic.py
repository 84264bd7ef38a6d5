"""Influence coefficients of uniformly loaded rectangles on an elastic half-space (Boussinesq–Cerruti, Love).

All surface displacements of a half-space follow from three integrals over the loaded rectangle,
    I_xx = ∬ (x−x')²/r³,   I_yy = ∬ (y−y')²/r³,   I_xy = ∬ (x−x')(y−y')/r³,      I_xx + I_yy = ∬ 1/r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ShearCompliance:
    """Sum over both bodies of (1−ν)/(2πG) and ν/(2πG) in 1/Pa: all that the tangential kernel needs of the materials."""

    isotropic: float
    directional: float

    @classmethod
    def of(cls, *bodies: tuple[float, float]) -> ShearCompliance:
        """From (shear modulus in Pa, Poisson ratio) of each body."""
        return cls(
            sum((1.0 - nu) / (2.0 * np.pi * g) for g, nu in bodies),
            sum(nu / (2.0 * np.pi * g) for g, nu in bodies),
        )

    @property
    def along(self) -> float:
        """Plane-strain compliance Σ(1−ν)/(πG)·… of traction and gradient both along x: π(isotropic)·2 in 1/Pa.

        In a strip that is long in y, ∂u_x/∂x = −(along/π)·⨍ τ_x/(x'−x) dx' with along = Σ (1−ν)/G."""
        return 2.0 * np.pi * self.isotropic

    @property
    def across(self) -> float:
        """Anti-plane compliance Σ 1/G in 1/Pa, for τ_y and ∂u_y/∂x in the same strip."""
        return 2.0 * np.pi * (self.isotropic + self.directional)


def _cell_difference(corner: Array) -> Array:
    """Integral over each cell from its antiderivative at the cell's corners."""
    return corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]


def rectangle_integrals(nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
    """I_xx, I_yy, I_xy of one dx × dy rectangle, seen from element centres at offsets (i·dx, j·dy).

    Returns three arrays of shape (nx, ny) in units of length, for i = 0..nx−1 and j = 0..ny−1; I_xx and I_yy are even in
    both offsets, I_xy is odd in both. Source: model.md; Johnson, Contact Mechanics, 3.2–3.3 (Love's closed form).

    y·ln(x+r) is written as y·asinh(x/|y|): the difference y·ln|y| drops out over a rectangle, and asinh does not cancel
    for x < 0.
    """
    x = ((np.arange(nx + 1) - 0.5) * dx)[:, None]
    y = ((np.arange(ny + 1) - 0.5) * dy)[None, :]
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
    return (
        isotropic + compliance.directional * i_xx,
        isotropic + compliance.directional * i_yy,
        compliance.directional * i_xy,
    )

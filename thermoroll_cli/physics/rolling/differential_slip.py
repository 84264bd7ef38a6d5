"""Differential (Heathcote) slip: points of a rolling surface that lie further from the axis move faster.

The bodies touch in a common surface that is, up to constants, z_s = w₂ z₁ + w₁ z₂ with z₁(y) the top of the lower body, z₂(y)
the bottom of the upper one and w_i = E*(1 − ν_i²)/E_i, w₁ + w₂ = 1, so the stiffer body keeps more of its shape; of coated
bodies w_i are the shares in what the pressure takes from the gap (`coatings`). The rolling radius of the lower body grows with
z_s, that of the upper one shrinks, so the longitudinal creepage varies across the contact,

    ξ_x(y) = ξ_x + d(y),      d(y) = [z_s(y) − z_s(0) − y z_s'(0)] (1/R_x1 + 1/R_x2)

(Heathcote 1921; Johnson, Contact Mechanics, 8.5), times `Motion.turning`. The bodies turn over each other about an axis along
y, so where the common surface is inclined they also slip across, by

    −x d'(y).

Creepage and spin are those at y = 0; the slope z_s'(0), the conicity, is taken out because it is a spin and already counted
there. Both parts together do not depend on where y = 0 lies: about y₀ the creepage is ξ_x − ξ_φ y₀ + d(y₀), the spin
ξ_φ − d'(y₀). For radii d = c y², c = ½(w₁/R_y2 − w₂/R_y1)(1/R_x1 + 1/R_x2): zero for equal spheres, large for a ball in a
groove. Terms of the order of u_z/R are dropped, as everywhere in half-space theory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.problem.geometry import ContactGeometry
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.tools.arrays import Array

LARGEST_EFFECT = 1.0
"""Bound of the relative change of any scalar, over the largest |d| or |x d'| divided by the creepage without them: 0.6 at most
in 24 random ellipses with creepages and spin from a thirtieth of saturation to three times it."""

ROUNDING = 1e-12
"""Differential slip below this share of the saturation creepage comes from the rounding of radii."""


@dataclass(frozen=True)
class DifferentialSlip:
    """The functions d(y) and −x d'(y) of a geometry, the shares w of its bodies and the `turning` of their motion, or the
    reason why they are left out (`why_not`) with the bound of the relative change of any scalar by them (`left_out`)."""

    geometry: ContactGeometry
    shares: tuple[float, float]
    turning: float = 1.0
    why_not: str = ""
    left_out: float = 0.0

    @property
    def active(self) -> bool:
        return not self.why_not

    def __call__(self, y: Array) -> Array:
        """d at the places `y` (m), dimensionless; zero if it is left out."""
        return self.turning * self.geometry.longitudinal_slip(self.shares, y) if self.active else np.zeros(np.shape(y))

    def lateral(self, x: Array | float, y: Array) -> Array:
        """−x d'(y) at the places x, y (m), which are broadcast, unless the geometry has it otherwise."""
        return self.turning * self.geometry.lateral_slip(self.shares, x, y) if self.active else np.zeros(1)

    def slope(self, y: Array) -> Array:
        """d'(y) in 1/m."""
        return self.turning * self.geometry.longitudinal_slope(self.shares, y) if self.active else np.zeros(np.shape(y))


def resolved(
    problem: Problem, shares: tuple[float, float], y: Array, half_lengths: tuple[float, float], saturation: float,
    negligible: float,
) -> DifferentialSlip:
    """The differential slip of a contact that covers the places `y` (m), with the `shares` of its bodies, unless all scalars
    change by less than `negligible`.

    It is compared with the creepage that drives the contact without it, at most the `saturation` creepage, because heat and
    stick change with the ratio; spin counts with the larger of the contact's `half_lengths` (m), d' with that along x."""
    found = DifferentialSlip(problem.geometry, shares, problem.motion.turning)
    if not problem.motion.differential_slip:
        return replace(found, why_not="switched off")
    largest = float(np.abs((found(y), found.lateral(half_lengths[0], y))).max())
    if largest == 0.0:
        return replace(found, why_not="exactly zero: weighted by their stiffness, both surfaces curve alike")
    if largest <= ROUNDING * saturation:
        return replace(found, why_not=f"{largest:.1e} of the speed: rounding of the radii")
    driving = min(saturation, _driving(problem, max(half_lengths), saturation))
    if LARGEST_EFFECT * largest < negligible * driving:
        why = (f"{largest:.1e} of the speed at most, {largest / driving:.1e} of the creepage: "
               f"it changes nothing by more than {negligible:g}")
        return replace(found, why_not=why, left_out=LARGEST_EFFECT * largest / driving)
    return found


def _driving(problem: Problem, half_length: float, saturation: float) -> float:
    """Creepage of the contact without differential slip; for a prescribed force F about F/3μW of saturation."""
    motion = problem.motion
    limit = max(problem.traction_limit, 1e-300)
    x, y = (abs(force) / (3.0 * limit) * saturation if force is not None else abs(creepage or 0.0)
            for creepage, force in ((motion.creepage_x, motion.force_x), (motion.creepage_y, motion.force_y)))
    return math.hypot(x, y, motion.spin * half_length)

"""The contact at one moment of the computation: raw fields of all stages on one grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.tools.arrays import Array, Mask


@dataclass(frozen=True)
class Pressure:
    """Normal part: `pressure` (Pa), `covered` fraction of each element, `displacement` u_z^e, `gap` (m), `approach` (m), and
    the `offset` that closes the gap besides the load (m, up to a constant; None: none).

    `whole_elements` is the pressure before the contact border was resolved, from which the next solve starts (None: the
    pressure itself)."""

    pressure: Array
    covered: Array
    displacement: Array
    gap: Array
    approach: float
    peak: float
    offset: Array | None = None
    whole_elements: Array | None = None
    iterations: int = 0
    converged: bool = True
    touches_rim: bool = False

    @property
    def contact(self) -> Mask:
        return self.covered > 0.0

    @property
    def start(self) -> Array:
        """Pressure from which the next solve starts."""
        return self.pressure if self.whole_elements is None else self.whole_elements


@dataclass(frozen=True, eq=False)
class Traction:
    """Tangential part on the whole grid: `traction` (2, nx, ny) in Pa, `slip` s/V (2, nx, ny), `stick` mask, the given or found
    `creepage`, `heat` = heat flux over V (Pa), its change along x through each element `heat_slope`, `work` = ξ·F of all
    creepages (N) less the `hysteresis` (N) of shear inside bodies that relax, the coefficient of `friction` (nx, ny) where
    it depends on slip, the `hardening` (nx, ny) in Pa by which the yield stress of an interlayer has grown (None: it does not),
    and the relative `displacement` of the surfaces (2, nx, ny) by traction in m, zero outside the contact's
    window; None if it was not solved for. In a step over time `work` is what becomes heat: that of the creepages less what
    deforms the bodies."""

    traction: Array
    slip: Array
    stick: Mask
    creepage: tuple[float, float]
    heat: Array
    heat_slope: Array
    work: float
    residual: float = 0.0
    newton_steps: int = 0
    applications: int = 0
    converged: bool = True
    friction: Array | None = None
    hardening: Array | None = None
    hysteresis: float = 0.0
    displacement: Array | None = None

    @classmethod
    def guess(cls, traction: Array, creepage: tuple[float, float], residual: float = 0.0) -> Traction:
        """Tractions (2, nx, ny) only to start from."""
        nothing = np.zeros(traction.shape[1:])
        return cls(traction, np.zeros_like(traction), nothing > 0.0, creepage, nothing, nothing, work=0.0, residual=residual)

    @classmethod
    def unknown(cls, shape: tuple[int, int]) -> Traction:
        """Nothing to start from: the solver then begins from full stick."""
        return cls.guess(np.zeros((2, *shape)), (0.0, 0.0), math.inf)

    @property
    def is_unknown(self) -> bool:
        return math.isinf(self.residual)


@dataclass(frozen=True, eq=False)
class Past:
    """What a contact remembers in one step over time: the change of displacement, (∂u/∂t)/V, is `rate` u − `slip`, with `rate`
    in 1/m and `slip` (2, nx, ny) from the displacements of the states before. `mirror` are the parities that all states of the
    history have across y = 0 (None: none). Where nothing `rolls`, V stands for any length over the time of the step. For
    friction with memory (∂f/∂t)/V is `rate` (f − `friction`), (nx, ny), with the mean factors of the states before; so it is
    for the growth (Pa) of the yield stress of an interlayer."""

    rate: float
    slip: Array
    mirror: tuple[int, int] | None = None
    rolls: bool = True
    friction: Array | None = None


@dataclass(frozen=True)
class Contact:
    """A complete state, with the fields (nx, ny) that act back on the contact; None for one that is not active.

    `expansion` is the thermal expansion that the pressure was computed with, in m; `shear_displacement` the normal displacement
    −u_z^τ by which the shear of dissimilar bodies closes the gap, in m; `friction` the local coefficient, if it is not the same
    everywhere."""

    normal: Pressure
    tangential: Traction
    expansion: Array | None = None
    shear_displacement: Array | None = None
    friction: Array | None = None

    def traction_bound(self, friction: float) -> Array:
        """Largest traction in Pa, (nx, ny): `friction`, or the local coefficient, times pressure."""
        local = self.local_friction
        return (friction if local is None else local) * self.normal.pressure

    @property
    def local_friction(self) -> Array | None:
        """Coefficient of friction (nx, ny) at the local temperature and slip; None if it is the same everywhere."""
        return self.friction if self.tangential.friction is None else self.tangential.friction

    @property
    def offset(self) -> Array | None:
        """Thermal expansion and displacement by shear, which close the gap besides the load, in m, (nx, ny); None without."""
        if self.expansion is None or self.shear_displacement is None:
            return self.shear_displacement if self.expansion is None else self.expansion
        return self.expansion + self.shear_displacement

"""The contact at one moment of the computation: raw fields of all stages on one grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Pressure:
    """Normal part: `pressure` (Pa), `covered` fraction of each element, `displacement` u_z^e, `gap` (m), `approach` (m),
    and what had closed the gap beforehand, `offset` (m, up to a constant)."""

    pressure: Array
    covered: Array
    displacement: Array
    gap: Array
    approach: float
    peak: float
    offset: Array | None = None

    @property
    def contact(self) -> Mask:
        return self.covered > 0.0


@dataclass(frozen=True)
class Traction:
    """Tangential part on the whole grid: `traction` (2, nx, ny) in Pa, `slip` s/V (2, nx, ny), `stick` mask, the creepages
    in force, `heat` = heat flux over V (Pa), `work` = ξ·F of all creepages (N)."""

    traction: Array
    slip: Array
    stick: Mask
    creepage: tuple[float, float]
    heat: Array
    work: float
    residual: float
    newton_steps: int
    applications: int
    converged: bool


@dataclass(frozen=True)
class Contact:
    """A complete state; `expansion` is the thermal displacement that the pressure was computed with (None: none), `lift` that
    by the shear of dissimilar bodies, −u_z^τ (0: none), `friction` the local coefficient if it is not the same everywhere."""

    normal: Pressure
    tangential: Traction
    expansion: Array | None = None
    lift: Array | float = 0.0
    friction: Array | None = None

    def bound(self, friction: float) -> Array:
        """Coulomb bound of the traction in Pa, (nx, ny): `friction`, or the local coefficient, times pressure."""
        return (friction if self.friction is None else self.friction) * self.normal.pressure

    @property
    def offset(self) -> Array:
        """All that closes the gap besides load and elastic indentation, in m, (nx, ny)."""
        thermal = np.zeros(self.normal.pressure.shape) if self.expansion is None else self.expansion
        return thermal + self.lift

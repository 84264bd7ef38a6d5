"""The few numbers of the solvers that experiments and the refinement vary; all others are constants beside their use."""

from __future__ import annotations

from dataclasses import dataclass, field

from thermoroll_cli.rolling.rolling_gradient import RollingOptions


@dataclass(frozen=True)
class Tolerances:
    """Relative: residual of the tractions, residual gap over approach, change of the fields that act back on the contact.

    Far below the discretisation error of any grid: a residual r moves forces and heat by r/3 at most."""

    tangential: float = 1e-5
    normal: float = 1e-7
    coupling: float = 3e-6

    def times(self, factor: float) -> Tolerances:
        """All of them looser by `factor`."""
        return Tolerances(factor * self.tangential, factor * self.normal, factor * self.coupling)


@dataclass(frozen=True)
class SolverOptions:
    """Tolerances and variants of the solution of a problem."""

    tolerances: Tolerances = Tolerances()
    rolling: RollingOptions = field(default_factory=RollingOptions)
    sequence: bool = True
    """Solve coarser grids first. They give the start, the estimates and the extrapolation."""
    extrapolated: bool = True
    """Extrapolate integrals from the last three grids."""
    most_moves: int = 8
    """Domains tried on one grid to follow a heated contact; iterations on one that proves too small end early."""
    whole_elements: bool = False
    """Hertz's pressure at the centres of whole elements, as in CONTACT, instead of its averages over covered parts."""

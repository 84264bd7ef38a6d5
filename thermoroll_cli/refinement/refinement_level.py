"""One level of the ladder of grids: both states on one grid, and how the next problem of a sweep starts from them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.assessment.scalars import state_of
from thermoroll_cli.model.contact import Contact, Traction
from thermoroll_cli.model.derived import DerivedQuantities
from thermoroll_cli.model.result import State
from thermoroll_cli.refinement.plan import Plan
from thermoroll_cli.solvers.algorithms.prolongation import Prolongation
from thermoroll_cli.steady_state.coupling import Coupled, expansion_of
from thermoroll_cli.steady_state.discretisation import Discretisation


@dataclass(frozen=True)
class RefinementLevel:
    """Both states on one grid, with their reported form; `coupled` and `feedback` account for the iterations with heat, and
    for those of pressure and shear between dissimilar bodies without it (None: not needed)."""

    discretisation: Discretisation
    isothermal: Contact
    coupled: Coupled | None
    isothermal_state: State
    coupled_state: State
    feedback: Coupled | None = None

    @property
    def touches_rim(self) -> bool:
        """Whether a contact was found to reach the edge of the domain."""
        return any(c.touches_rim for c in (self.feedback, self.coupled) if c is not None)

    @property
    def contact(self) -> Contact:
        return self.isothermal if self.coupled is None else self.coupled.contact


def refinement_level(
    discretisation: Discretisation, iso: Contact, coupled: Coupled | None, plan: Plan, feedback: Coupled | None = None
) -> RefinementLevel:
    heat = plan.runs("heat")
    # Without heat everything stays cold: known without asking a kernel.
    cold = not heat and discretisation.derived.problem.heating.heat
    expansion = expansion_of(discretisation, iso) if heat and discretisation.derived.problem.heating.deformation else None
    if cold:
        expansion = np.zeros(discretisation.grid.shape)
    iso_state = state_of(discretisation, iso, temperatures=heat or cold, expansion=expansion)
    if coupled is None:
        return RefinementLevel(discretisation, iso, None, iso_state, iso_state, feedback)
    return RefinementLevel(discretisation, iso, coupled, iso_state,
                 state_of(discretisation, coupled.contact, temperatures=True, expansion=coupled.contact.expansion), feedback)


class Neighbours:
    """The levels of the last problem of a sweep, from which the next one starts."""

    def __init__(self) -> None:
        self._last: list[RefinementLevel] = []

    def remember(self, levels: list[RefinementLevel]) -> None:
        self._last = levels

    def find(self, derived: DerivedQuantities, shape: tuple[int, int], extent: float) -> RefinementLevel | None:
        """The last problem's level, if its kernels and its grid are those of `derived` (see `Discretisation.serves`)."""
        return next((r for r in self._last if r.discretisation.serves(derived, shape, extent)), None)

    def predict(self, last: RefinementLevel, below: RefinementLevel | None, below_last: RefinementLevel | None) -> Traction:
        """Tractions to start from: those of the last problem on this grid, plus what the next coarser grid has changed since
        (`below` against `below_last`). Shares of the Coulomb bound are carried, so that slip stays slip."""
        discretisation = last.discretisation
        traction = last.isothermal.tangential
        if below is None or below_last is None:
            return traction
        old, new = below_last.isothermal, below.isothermal
        bound, coarse_bound = discretisation.hertz.pressure, new.normal.pressure
        prolong = Prolongation(below.discretisation.grid, discretisation.grid)
        change = new.tangential.traction - old.tangential.traction * (coarse_bound / np.where(
            old.normal.pressure > 0.0, old.normal.pressure, 1.0))
        return replace(traction, traction=traction.traction + prolong.traction(change, coarse_bound, bound),
                       creepage=new.tangential.creepage)

"""One grid of the sequence: both states on it, with their reported form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.result import State
from thermoroll_cli.refinement.plan import Plan
from thermoroll_cli.refinement.scalars import state_of
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import SteadyState
from thermoroll_cli.steady_state.iteration import expansion_in


@dataclass(frozen=True)
class FollowedState:
    """A coupled state with the `discretisation` it lives on, and the transforms spent on domains that were left."""

    discretisation: Discretisation
    state: SteadyState
    left_behind: int


@dataclass(frozen=True)
class RefinementLevel:
    """The state without thermal deformation and, where there is any, the one with it; each with its reported form.

    The coupled state lives on `home`, which is `discretisation` unless its contact has become much smaller; `left_behind` are
    transforms spent on other domains."""

    discretisation: Discretisation
    isothermal: SteadyState
    coupled: SteadyState | None
    isothermal_state: State
    coupled_state: State
    home: Discretisation
    left_behind: int = 0

    @property
    def transforms(self) -> int:
        """Padded transforms done for both states."""
        return self.discretisation.transforms + self.left_behind + (
            0 if self.home is self.discretisation else self.home.transforms)

    @property
    def touches_rim(self) -> bool:
        """Whether a contact was found to reach the edge of a domain that a larger one may replace."""
        reached = self.coupled is not None and self.coupled.touches_rim and self.home.followed is None
        return self.isothermal.touches_rim or reached

    @property
    def elements_across(self) -> float:
        """Elements over 1.1 diameters of the contact, which is the side of the usual domain; of a grid that is not square those
        of its coarser direction."""
        grid = self.discretisation.grid
        inside = float(self.contact.normal.covered.sum())
        return max(1.0, 2.2 * math.sqrt(inside / math.pi * min(grid.shape) / max(grid.shape)))

    @property
    def contact(self) -> Contact:
        return (self.coupled or self.isothermal).contact


def refinement_level(
    discretisation: Discretisation, isothermal: SteadyState, followed: FollowedState | None, plan: Plan
) -> RefinementLevel:
    """Report both states of a grid. The isothermal one includes the expansion that its heat would cause."""
    heating, contact = discretisation.derived.problem.heating, isothermal.contact
    heat = plan.runs("heat")
    expansion = expansion_in(discretisation.heat(contact), contact) if heat and heating.deformation else None
    # Without heat everything stays cold: known without asking a kernel.
    cold = not heat and heating.heat
    if cold:
        expansion = np.zeros(discretisation.grid.shape)
    reported = state_of(discretisation, contact, temperatures=heat or cold, expansion=expansion)
    if followed is None:
        return RefinementLevel(discretisation, isothermal, None, reported, reported, discretisation)
    home, coupled = followed.discretisation, followed.state
    heated = state_of(home, coupled.contact, temperatures=True, expansion=coupled.contact.expansion)
    return RefinementLevel(discretisation, isothermal, coupled, reported, heated, home, followed.left_behind)

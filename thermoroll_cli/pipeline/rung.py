"""One rung of the ladder of grids: both states on one grid, and how the next problem of a sweep starts from them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.pipeline.contact import Contact, Traction
from thermoroll_cli.pipeline.coupling import Coupled, expansion_of
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.pipeline.plan import Plan
from thermoroll_cli.pipeline.result import State
from thermoroll_cli.pipeline.scene import Scene
from thermoroll_cli.pipeline.states import state_of
from thermoroll_cli.solvers.prolongation import Prolongation


@dataclass(frozen=True)
class Rung:
    """Both states on one grid, with their reported form; `coupled` and `feedback` account for the iterations with heat, and
    for those of pressure and shear between dissimilar bodies without it (None: not needed)."""

    level: Level
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


def rung(level: Level, iso: Contact, coupled: Coupled | None, plan: Plan, feedback: Coupled | None = None) -> Rung:
    heat = plan.runs("heat")
    # Without heat everything stays cold: known without asking a kernel.
    cold = not heat and level.scene.problem.heating.heat
    expansion = expansion_of(level, iso) if heat and level.scene.problem.heating.deformation else None
    if cold:
        expansion = np.zeros(level.grid.shape)
    iso_state = state_of(level, iso, temperatures=heat or cold, expansion=expansion)
    if coupled is None:
        return Rung(level, iso, None, iso_state, iso_state, feedback)
    return Rung(level, iso, coupled, iso_state,
                 state_of(level, coupled.contact, temperatures=True, expansion=coupled.contact.expansion), feedback)


class Neighbours:
    """The rungs of the last problem of a sweep, from which the next one starts."""

    def __init__(self) -> None:
        self._last: list[Rung] = []

    def remember(self, rungs: list[Rung]) -> None:
        self._last = rungs

    def find(self, scene: Scene, shape: tuple[int, int], extent: float) -> Rung | None:
        """The last problem's rung, if its kernels and its grid are those of `scene` (see `Level.serves`)."""
        return next((r for r in self._last if r.level.serves(scene, shape, extent)), None)

    def predict(self, last: Rung, below: Rung | None, below_last: Rung | None) -> Traction:
        """Tractions to start from: those of the last problem on this grid, plus what the next coarser grid has changed since
        (`below` against `below_last`). Shares of the Coulomb bound are carried, so that slip stays slip."""
        level = last.level
        traction = last.isothermal.tangential
        if below is None or below_last is None:
            return traction
        old, new = below_last.isothermal, below.isothermal
        bound, coarse_bound = level.hertz.pressure, new.normal.pressure
        prolong = Prolongation(below.level.grid, level.grid)
        change = new.tangential.traction - old.tangential.traction * (coarse_bound / np.where(
            old.normal.pressure > 0.0, old.normal.pressure, 1.0))
        return replace(traction, traction=traction.traction + prolong.traction(change, coarse_bound, bound),
                       creepage=new.tangential.creepage)

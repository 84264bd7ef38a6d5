"""Contact whose heat is proportional to its pressure: thermal expansion inside the normal problem, continuation in the heat.

Where the surfaces slide, the heat flux is proportional to the pressure, q = w p with w = μV|s|. With E the expansion by a unit
of heat, the pressure of a contact in balance with its own heat solves

    (A − E[w ·]) p = δ − h  on the active set,     p > 0 there and gap > 0 elsewhere,     ∬ p = W or δ given,

which is linear for a given active set and slip. Iterating pressure → heat → expansion → pressure instead diverges as soon as
E w outweighs A. The system is not symmetric; A alone preconditions it, since A⁻¹E is compact: a handful of GMRES steps on any
grid.

There are steady states at any heat, but heat concentrates a contact, and with an active set that is much too large the
solution of the linear system has pressures of both signs: the sets then do not settle. So heat is raised from a known state;
each step starts from the last active set, which only has to shrink.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from thermoroll_cli.physics.contact.active_set import Approach, Given, carrying, settle
from thermoroll_cli.physics.contact.normal_contact import MOST_ITERATIONS, NormalSolver
from thermoroll_cli.tools.arrays import Array, Mask

MOST_ACTIVE_SETS = 30
"""Active sets tried for one heat. A step that is not too large needs three to eight."""
WANDERING_SHARE = 0.3
"""A step is given up when an active set would gain this share of its elements while it also loses some: it began with a
contact that is too large for its heat."""
GAP_REDUCTION = 1e-3
"""Factor by which the gap on one active set is reduced before the set is updated."""
STEP_GROWTH = 1.5
"""Factor of the next step in heat after one that succeeded; a step that failed is halved."""
SMALLEST_STEP = 1.0 / 256.0
"""Share of the heat below which a step is not halved any more: no steady state is found beyond."""
MOST_APPLICATIONS = 1000
"""Applications of A − E after which the heat is not raised any further: 100 to 400 reach full heat or its limit."""
INTERMEDIATE_RESIDUAL = 1e-4
"""Residual of states on the way to the full heat, relative to the elastic displacement."""


@dataclass(frozen=True)
class HeatedContact:
    """`pressure` (Pa) and its own `expansion` E[w p] (m, up to a constant), (nx, ny); `residual` is the rms of what remains
    of the gap over the elastic displacement; `reached` is the share of the heat that this state has (1: all of it), `raised`
    says whether the heat was raised to it from zero."""

    pressure: Array
    expansion: Array
    residual: float
    active_sets: int
    reached: float
    converged: bool
    raised: bool = False


class HeatedContactSolver:
    """Contact under a normal force (N), or at an approach, of surfaces `gap` apart (m, (nx, ny); any constant if a load is
    `given`), which expand by `expand`(p, contact) (m, linear) under the heat of the pressure p. At an approach the expansion
    counts from its mean over the contact.

    `applications` counts those of A − E.
    """

    def __init__(self, normal: NormalSolver, expand: Callable[[Array, Mask], Array], gap: Array, given: Given) -> None:
        self.applications = 0
        self._normal, self._expand, self._gap = normal, expand, gap
        self._given = given if isinstance(given, Approach) else given / normal.grid.element_area

    def solve(self, pressure: Array, tolerance: float, heat: float = 1.0) -> HeatedContact:
        """The state at the share `heat` of the heat, from the active set and values of `pressure`. Not `converged` if the
        active sets do not settle."""
        start = carrying(self._given, pressure)
        scale = max(float(self._normal.displacement(start)[start > 0.0].mean()), 1e-300)
        respond = partial(self._closing, heat=heat)
        close = partial(self._normal.closed_by_gmres, respond, self._gap, self._given, scale)
        settled = settle(respond, close, self._gap, self._given, start,
                         tolerance, reduction=GAP_REDUCTION, most_sets=MOST_ACTIVE_SETS,
                         most_iterations=MOST_ACTIVE_SETS * MOST_ITERATIONS, wandering=WANDERING_SHARE)
        expansion = self._expand(settled.pressure, settled.contact) * heat
        return HeatedContact(settled.pressure, expansion, settled.error, settled.sets, heat, settled.converged)

    def _closing(self, pressure: Array, contact: Mask, heat: float) -> Array:
        """(A − E) p in m."""
        self.applications += 1
        indented = self._normal.displacement(pressure)
        return indented - heat * self._expand(pressure, contact) if heat else indented

    def continued(self, pressure: Array, tolerance: float) -> HeatedContact:
        """The state at full heat: tried at once from `pressure`, else by raising the heat from zero.

        A step that fails is halved. Returns the state at the highest heat reached; if that is below 1, no state was found
        `SMALLEST_STEP` beyond it, or `MOST_APPLICATIONS` were used up."""
        before = self.applications
        trial = self.solve(pressure, tolerance)
        if trial.converged:
            return trial
        if trial.residual <= INTERMEDIATE_RESIDUAL:
            # The gap is closed and only border elements keep changing: raising the heat would not help.
            trial = self.solve(pressure, INTERMEDIATE_RESIDUAL)
            if trial.converged:
                return trial
        reached = self.solve(pressure, INTERMEDIATE_RESIDUAL, 0.0)
        step = 0.25
        while (reached.reached < 1.0 and step >= SMALLEST_STEP and reached.converged
               and self.applications - before < MOST_APPLICATIONS):
            heat = min(1.0, reached.reached + step)
            trial = self.solve(reached.pressure, INTERMEDIATE_RESIDUAL, heat)
            if trial.converged:
                reached, step = trial, STEP_GROWTH * step
            else:
                step *= 0.5
        if reached.reached == 1.0:
            # The final tolerance is not part of the continuation: if it is missed, the heat has been reached all the same.
            trial = self.solve(reached.pressure, tolerance)
            reached = trial if trial.converged else reached
        return replace(reached, converged=reached.converged and reached.reached == 1.0, raised=True)

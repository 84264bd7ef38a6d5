"""The steady state: the fixed point of an iteration, for whatever acts back on the contact.

What acts back are fields x of the state (`UNKNOWNS`): an iteration begins with x and makes g(x), and x = g(x) is wanted.
Anderson's mixing finds it, every field counted in its own scale. Pressure and tractions inside an iteration are solved only as
closely as the residual g(x) − x has earned, and to the end in the iteration that is likely to be the last.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.anderson import Anderson
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.friction import admissible_friction, can_transmit
from thermoroll_cli.steady_state.heated_pressure import heated_step
from thermoroll_cli.steady_state.iteration import iterate
from thermoroll_cli.steady_state.solver_options import Tolerances

DEPTH = 8
"""Iterations that Anderson's mixing remembers: the iterations are not solved so closely that more would gain anything. Strong
heat of contacts that partly stick needs them: the article's case goes to twice the speed that it does with four."""
MOST_ITERATIONS = 60
"""The last state below the thermo-elastic limit took 44; beyond it no number of iterations would do."""
NORMAL_SHARE = 1e-3
"""The same of the gap. It is cheap, and an open gap at the border adds or drops elements there."""
NEARLY_CONVERGED = 10.0
"""From this many times the tolerance the next iteration is expected to reach it: its tractions are solved to the end."""
LOOSEST = 1e-2
"""No iteration solves its tractions less closely: stick and slip would not yet be those of a solution."""
CLOSE_PATIENCE = 4
"""The same number of iterations where the residual is below what is accepted then: nothing but elements of the border that come
and go is left."""
MOST_DAMPINGS = 5
"""How often falling friction may be damped to transmit a prescribed force, before there is no steady state: each time half of
what it has in reserve is lost."""
MOST_UNBALANCED = 2
"""How often an iteration may find no pressure in balance with its heat: the first iterations have the slip of another
contact."""
MOST_RAISED = 4
"""How often the heat may be raised from none for that: later iterations should begin with the pressure of the last."""
CLOSEST_BALANCE = 1e-8
"""Residual, over the elastic displacement, below which no pressure in balance with its heat is solved."""
INDIFFERENT = 10.0
"""Times the tolerance: the residual that is accepted where no further iteration reduces it, still below 1e-4 of the
approach."""
BORDER_ELEMENT = 0.3
"""The same for dissimilar bodies, over N²: an element of the border that comes and goes with the shear beneath it moves the
surfaces by less than its share of the contact, 4/(πN²)·(extent/2)²."""
HEATED_ELEMENT = 2.0
"""The same for heat, over the variation of the expansion and the elements of the contact: they come and go in pairs, one on
either side."""

@dataclass(frozen=True)
class Pace:
    """How fast an iteration is expected to converge, and so how it is mixed, how closely its problems are solved, and when it
    is given up."""

    first_damping: float
    """Part of the first change that is taken."""
    first_residual: float
    """Residual that the first iteration counts with."""
    tangential_share: float
    """Residual of the tractions over that of the fixed point."""
    possibly_last: int
    """From this iteration on each may be the last."""
    patience: int
    recent: int
    gain: float
    """An iteration stagnates if after `patience` steps the `recent` ones have not brought the residual below `gain` times the
    least one before them."""


HEAT = Pace(first_damping=0.7, first_residual=0.1, tangential_share=0.05, possibly_last=60, patience=20, recent=12, gain=0.5)
"""Heat may move the surfaces by half of the approach; a bulge and its pressure push each other further than they end up, so the
first change is damped. A start from a coarser grid is closer than a residual of 1, and mixing learns nothing from iterations
that are solved less closely than they change: with 1 the exact case at 11.28 W takes 276 transforms, with 0.1 it takes 173.
Heat follows the tractions one to one, and the mixing must not take what is left of their residual for a change. Close to the
thermo-elastic limit a dozen iterations may pass without any gain."""
PREDICTED = replace(HEAT, first_damping=1.0, first_residual=1e-3)
"""A start predicted from neighbouring problems is as close as this: a loose first iteration would throw it away."""
SHEAR = Pace(first_damping=1.0, first_residual=2e-4, tangential_share=2.0, possibly_last=6, patience=11, recent=6, gain=0.7)
"""Shear between dissimilar bodies moves the surfaces by a few per cent of the approach at most: an iteration gains a factor of
ten or more from the first on, its tractions matter to a few per cent, and what has not converged in a dozen iterations wavers
between elements of the border."""

Fields = dict[str, Any]
"""Arrays (nx, ny) by the names of `UNKNOWNS`."""


def _approach(derived: DerivedQuantities) -> float:
    return derived.scales.approach


def _coefficient(derived: DerivedQuantities) -> float:
    return derived.problem.friction


UNKNOWNS: dict[str, Callable[[DerivedQuantities], float]] = {
    "expansion": _approach,
    "shear_displacement": _approach,
    "friction": _coefficient,
}
"""Fields of `Contact` that an iteration makes anew, each with the scale in which its changes count. A further one is a field
there, a line in `iterate` and a line here."""


@dataclass(frozen=True)
class SteadyState:
    """The best state found, with the iterations that it took and what the inner solvers did in them; `residual` is what its
    iteration has changed of the unknowns, over their scales. `balanced` is whether pressures in balance with their heat led
    to it; `heat_reached` is 1, or the part of the heat to which it could be raised where there is no balance with all of it."""

    contact: Contact
    iterations: int
    residual: float
    converged: bool
    normal_iterations: int
    applications: int
    newton_steps: int
    touches_rim: bool
    history: tuple[float, ...]
    balanced: bool = False
    heat_reached: float = 1.0

    @property
    def acts_back(self) -> bool:
        """Whether there was anything to iterate; else one iteration is the solution."""
        return bool(unknowns_of(self.contact))


def unknowns_of(contact: Contact) -> Fields:
    """The fields of `contact` that act back on it."""
    return {name: field for name in UNKNOWNS if (field := getattr(contact, name)) is not None}


def fixed_point(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, *, balanced: bool = False,
    predicted: bool = False,
) -> SteadyState:
    """Iterate from `start` until what acts back no longer changes.

    The residual is the largest change of an unknown field over its scale, on the contact. Converged is an iteration whose
    residual is below the tolerance and whose own problems are solved. Where mixing alone does not get there because of the
    heat, the iteration begins again with iterations that start from a pressure in balance with its own heat
    (`heated_pressure`): it takes more work, but strong heat too, if the contact slides. With `balanced` it begins so at once.
    Where nothing converges the best state is returned. `predicted` is whether neighbouring problems predicted the start.
    """
    heated = start.expansion is not None or start.friction is not None
    pace = (PREDICTED if predicted else HEAT) if heated else SHEAR
    first = _iterated(discretisation, start, tolerances, pace, balanced)
    if first.converged or first.touches_rim or start.expansion is None:
        return first
    second = _iterated(discretisation, start, tolerances, HEAT, not balanced)
    best = second if second.converged or second.residual < first.residual else first
    # Both attempts contribute to the knowledge of the heat, and to the cost.
    reached = (first if balanced else second).heat_reached
    return replace(best, normal_iterations=first.normal_iterations + second.normal_iterations, heat_reached=reached,
                   applications=first.applications + second.applications, newton_steps=first.newton_steps + second.newton_steps)


def _iterated(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, pace: Pace, balanced: bool
) -> SteadyState:
    limit = tolerances.tangential if start.expansion is None else tolerances.coupling
    mixing = _Mixing(discretisation, pace, balanced)
    state = best = start
    residual = least = math.inf
    rim, history = False, list[float]()
    counts = np.zeros(3, dtype=int)
    while len(history) < MOST_ITERATIONS and mixing.dampings <= MOST_DAMPINGS and can_transmit(discretisation, state):
        after = iterate(discretisation, state, _inside(state, tolerances, limit, history, pace))
        normal, tangential = after.normal, after.tangential
        counts += (normal.iterations, tangential.applications, tangential.newton_steps)
        changes = _changes(state, after)
        history.append(_size(discretisation, after, changes))
        rim = normal.touches_rim
        solved = (normal.converged and tangential.converged and tangential.residual <= 2.0 * tolerances.tangential
                  and not rim)
        if least == math.inf or (solved and history[-1] < least):
            best, residual = replace(after, **unknowns_of(state)), history[-1]
            least = residual if solved else math.inf
        if not changes or least <= limit or rim:
            break
        enough = _indifferent(discretisation, best, limit, pace)
        if _stagnates(history, pace, close=least <= enough):
            limit = enough
            break
        state = mixing.next(state, after, changes, history[-1])
        if mixing.unbalanced > MOST_UNBALANCED or mixing.raised > MOST_RAISED:
            break
    return SteadyState(
        _without_mean(best), iterations=len(history), residual=residual, converged=least <= limit, touches_rim=rim,
        normal_iterations=int(counts[0]), applications=int(counts[1]), newton_steps=int(counts[2]), history=tuple(history),
        balanced=balanced, heat_reached=mixing.heat_reached)


def _inside(
    state: Contact, tolerances: Tolerances, limit: float, history: list[float], pace: Pace
) -> Tolerances:
    """How closely the problems of the next iteration are solved."""
    if not unknowns_of(state):
        return tolerances
    outer = history[-1] if history else pace.first_residual
    last = outer <= NEARLY_CONVERGED * limit or len(history) >= pace.possibly_last
    tangential = tolerances.tangential if last else max(pace.tangential_share * outer, tolerances.tangential)
    normal = max(NORMAL_SHARE * outer, tolerances.normal)
    return replace(tolerances, tangential=min(tangential, LOOSEST), normal=normal)


def _changes(before: Contact, after: Contact) -> Fields:
    """Change of the unknowns in an iteration; that of the expansion without its mean, which the approach absorbs."""
    changes = {name: getattr(after, name) - field for name, field in unknowns_of(before).items()}
    if "expansion" in changes:
        changes["expansion"] -= changes["expansion"][after.normal.contact].mean()
    return changes


def _size(discretisation: Discretisation, after: Contact, changes: Fields) -> float:
    """Largest change of an unknown over its scale, on the contact."""
    # Also where a shrunken contact no longer is: a state must be one of the whole gap.
    where = after.normal.contact | discretisation.isothermal_pressure.contact
    # The displacement by shear changes with every element that the border gains or loses: only its mean square settles.
    norm = _root_mean_square if after.shear_displacement is not None else _largest
    scales = {name: UNKNOWNS[name](discretisation.derived) for name in changes}
    if "expansion" in changes:
        # Heat that concentrates the contact presses the bodies deeper into each other than their cold approach.
        scales["expansion"] = max(scales["expansion"], _variation(after))
    return max((norm(change[where]) / scales[name] for name, change in changes.items()), default=0.0)


def _variation(state: Contact) -> float:
    """Variation of the thermal expansion over the contact in m."""
    assert state.expansion is not None
    return float(np.ptp(state.expansion[state.normal.contact]))


def _largest(values: Array) -> float:
    return float(np.abs(values).max())


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _stagnates(history: list[float], pace: Pace, *, close: bool) -> bool:
    """Whether the last iterations of a long iteration have gained too little to go on; `close` to what its grid allows it need
    not have been long."""
    patience, recent = (CLOSE_PATIENCE, CLOSE_PATIENCE) if close else (pace.patience, pace.recent)
    return len(history) > patience and min(history[-recent:]) > pace.gain * min(history[:-recent])


def _indifferent(discretisation: Discretisation, state: Contact, limit: float, pace: Pace) -> float:
    """Residual that is accepted where no further iteration reduces it: only a finer grid could."""
    border = BORDER_ELEMENT / min(discretisation.grid.shape) ** 2 if discretisation.derived.kinematics.feeds_back else 0.0
    if state.expansion is not None:
        approach = discretisation.derived.scales.approach
        moved = _variation(state) / max(_variation(state), approach)
        border = max(border, HEATED_ELEMENT * moved / int(np.count_nonzero(state.normal.contact)))
    return max(INDIFFERENT * limit, border)


def _without_mean(contact: Contact) -> Contact:
    """The same state with an expansion that is zero on average over the contact: the iteration leaves its constant, and with it
    the approach, where it happened to begin."""
    if contact.expansion is None:
        return contact
    mean = float(contact.expansion[contact.normal.contact].mean())
    normal = replace(contact.normal, approach=contact.normal.approach + mean)
    return replace(contact, normal=normal, expansion=contact.expansion - mean)


class _Mixing:
    """Anderson's mixing of all unknowns, each in its scale, within what a coefficient of friction can be."""

    def __init__(self, discretisation: Discretisation, pace: Pace, balanced: bool) -> None:
        self._discretisation, self._pace = discretisation, pace
        # Steps to a balance of pressure and heat need no damping.
        self._anderson = Anderson(DEPTH, 1.0 if balanced else pace.first_damping)
        self._balanced = balanced
        self.dampings = 0
        self.heat_reached = 1.0
        self.unbalanced = self.raised = 0

    def next(self, before: Contact, after: Contact, changes: Fields, residual: float) -> Contact:
        """State of the next iteration: mixed unknowns, and the pressure and tractions of the last."""
        unknowns = unknowns_of(before)
        if not unknowns:
            return after
        if self._balanced and before.expansion is not None:
            tolerance = max(NORMAL_SHARE * residual, CLOSEST_BALANCE)

            step = heated_step(self._discretisation, before, after, tolerance)
            self.heat_reached = step.reached
            self.unbalanced += not step.converged
            self.raised += step.raised
            if step.converged:
                changes = changes | {"expansion": step.expansion - before.expansion}
                after = replace(after, normal=replace(after.normal, whole_elements=step.pressure))
        # To the next power of two: scaling rounds nothing.
        scales = {name: 2.0 ** round(math.log2(UNKNOWNS[name](self._discretisation.derived))) for name in unknowns}
        x, change = (np.stack([fields[name] / scales[name] for name in unknowns]) for fields in (unknowns, changes))
        mixed = self._anderson.next(x, x + change)
        state = replace(after, **{name: field * scales[name] for name, field in zip(unknowns, mixed, strict=True)})
        if state.friction is None or before.friction is None:
            return state
        friction, damped = admissible_friction(self._discretisation, state, before.friction)
        self.dampings += damped
        return replace(state, friction=friction)

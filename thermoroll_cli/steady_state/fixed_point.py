"""The steady state: the fixed point of a turn, for whatever acts back on the contact.

What acts back are fields x of the state (`UNKNOWNS`): a turn begins with x and makes g(x), and x = g(x) is wanted. Anderson's
mixing finds it, every field counted in its own scale. Pressure and tractions inside a turn are solved only as closely as the
residual g(x) − x has earned, and to the end in the turn that is likely to be the last.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.anderson import Anderson
from thermoroll_cli.numerics.solver_options import FixedPointOptions, Tolerances
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.friction import admissible_friction, can_transmit
from thermoroll_cli.steady_state.heated_pressure import heated_step
from thermoroll_cli.steady_state.turn import turn

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
"""Fields of `Contact` that a turn makes anew, each with the scale in which its changes count. A further one is a field there, a
line in `turn` and a line here."""


@dataclass(frozen=True)
class SteadyState:
    """The best state found, with the turns that it took and what the inner solvers did in them; `residual` is what its
    turn has changed of the unknowns, over their scales. `balanced` tells whether pressures in balance with their heat led to
    it; `heat_reached` is 1, or the part of the heat to which it could be raised where there is no balance with all of it."""

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
        """Whether there was anything to iterate; else one turn is the solution."""
        return bool(unknowns_of(self.contact))


def unknowns_of(contact: Contact) -> Fields:
    """The fields of `contact` that act back on it."""
    return {name: field for name in UNKNOWNS if (field := getattr(contact, name)) is not None}


def fixed_point(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, *, balanced: bool = False
) -> SteadyState:
    """Iterate turns from `start` until what acts back no longer changes.

    The residual is the largest change of an unknown field over its scale, on the contact. Converged is a turn whose residual
    is below the tolerance and whose own problems are solved. Where mixing alone does not get there because of the heat, the
    iteration begins again with turns that start from a pressure in balance with its own heat (`heated_pressure`): it takes more
    work, but strong heat too, if the contact slides. With `balanced` it begins so at once. Where nothing converges the best
    state is returned.
    """
    heated = start.expansion is not None or start.friction is not None
    options = discretisation.options.heat if heated else discretisation.options.shear
    first = _iterated(discretisation, start, tolerances, options, balanced)
    if first.converged or first.touches_rim or start.expansion is None:
        return first
    second = _iterated(discretisation, start, tolerances, options, not balanced)
    best = second if second.converged or second.residual < first.residual else first
    # What both have found out about the heat, and what both have cost.
    reached = (first if balanced else second).heat_reached
    return replace(best, normal_iterations=first.normal_iterations + second.normal_iterations, heat_reached=reached,
                   applications=first.applications + second.applications, newton_steps=first.newton_steps + second.newton_steps)


def _iterated(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, options: FixedPointOptions, balanced: bool
) -> SteadyState:
    limit = tolerances.tangential if start.expansion is None else tolerances.coupling
    mixing = _Mixing(discretisation, options, balanced)
    state = best = start
    residual = least = math.inf
    rim, history = False, list[float]()
    counts = np.zeros(3, dtype=int)
    while len(history) < options.max_turns and mixing.dampings <= options.dampings and can_transmit(discretisation, state):
        after = turn(discretisation, state, _inside(state, tolerances, limit, history, options))
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
        enough = _indifferent(discretisation, best, limit, options)
        if _stagnates(history, options, close=least <= enough):
            limit = enough
            break
        state = mixing.next(state, after, changes, history[-1])
        if mixing.unbalanced > options.unbalanced or mixing.raised > options.raised:
            break
    return SteadyState(
        _without_mean(best), iterations=len(history), residual=residual, converged=least <= limit, touches_rim=rim,
        normal_iterations=int(counts[0]), applications=int(counts[1]), newton_steps=int(counts[2]), history=tuple(history),
        balanced=balanced, heat_reached=mixing.heat_reached)


def _inside(
    state: Contact, tolerances: Tolerances, limit: float, history: list[float], options: FixedPointOptions
) -> Tolerances:
    """How closely the problems of the next turn are solved."""
    if not unknowns_of(state):
        return tolerances
    outer = history[-1] if history else options.first_residual
    last = outer <= options.last_turn * limit or len(history) >= options.few_turns
    tangential = tolerances.tangential if last else max(options.tangential_share * outer, tolerances.tangential)
    normal = max(options.normal_share * outer, tolerances.normal)
    return replace(tolerances, tangential=min(tangential, options.loosest), normal=normal)


def _changes(before: Contact, after: Contact) -> Fields:
    """What a turn has changed of the unknowns; of the expansion without its mean, which the approach absorbs."""
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


def _stagnates(history: list[float], options: FixedPointOptions, *, close: bool) -> bool:
    """Whether the last turns of a long iteration have gained too little to go on; `close` to what its grid allows it need not
    have been long."""
    patience, recent = (options.close, options.close) if close else (options.patience, options.recent)
    return len(history) > patience and min(history[-recent:]) > options.gain * min(history[:-recent])


def _indifferent(discretisation: Discretisation, state: Contact, limit: float, options: FixedPointOptions) -> float:
    """Residual that is accepted where no further turn reduces it: only a finer grid could."""
    border = options.border_element / min(discretisation.grid.shape) ** 2 if discretisation.derived.feeds_back else 0.0
    if state.expansion is not None:
        approach = discretisation.derived.scales.approach
        moved = _variation(state) / max(_variation(state), approach)
        border = max(border, options.heated_element * moved / int(np.count_nonzero(state.normal.contact)))
    return max(options.indifferent * limit, border)


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

    def __init__(self, discretisation: Discretisation, options: FixedPointOptions, balanced: bool) -> None:
        self._discretisation, self._options = discretisation, options
        # Steps to a balance of pressure and heat need no damping.
        self._anderson = Anderson(options.depth, 1.0 if balanced else options.first_damping)
        self._balanced = balanced
        self.dampings = 0
        self.heat_reached = 1.0
        self.unbalanced = self.raised = 0

    def next(self, before: Contact, after: Contact, changes: Fields, residual: float) -> Contact:
        """State of the next turn: mixed unknowns, and the pressure and tractions of the last."""
        unknowns = unknowns_of(before)
        if not unknowns:
            return after
        if self._balanced and before.expansion is not None:
            tolerance = max(self._options.normal_share * residual, self._options.closest_balance)

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

"""The steady state: the fixed point of an iteration over the fields that act back on the contact.

The unknowns are these fields x of the state (`UNKNOWNS`), such as the thermal expansion. One iteration computes g(x) from x;
Anderson's mixing solves x = g(x), with each field relative to its own scale. The tolerance of the pressure and tractions inside
an iteration is a share of the residual g(x) − x, and the full tolerance in an iteration that is likely to be the last.

Strong heat needs a pressure in balance with its own heat (`heated_step`): heat is proportional to pressure, so both are solved
for together. The heat flux q and the pressure p of an iteration give the heat per pressure w = q/p on the contact, which
depends on slip and friction. Let E be the expansion by heat, and keep all parts that are not proportional to the pressure
(uneven shares of the bodies, conduction, shear of dissimilar bodies, the correction by the resolved border). The state after
the next iteration then solves

    (A − E[w ·]) p = δ − h + r,     r = E[q] − E[w p] + displacement by shear + (A p − δ + h − u on the contact)

where the last term is zero except in border elements. In the steady state this changes nothing: it is a step towards the same
fixed point that includes the dependence of the heat on the pressure, which mixing would only learn over many iterations.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.one_contact.steady_state.iteration import admissible_friction, iterate, reserve
from thermoroll_cli.physics.contact.active_set import Approach
from thermoroll_cli.physics.contact.heated_contact import HeatedContact, HeatedContactSolver
from thermoroll_cli.physics.heat.heat_response import DividedHeat
from thermoroll_cli.physics.numerics.krylov import Anderson, Secants
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.tools.arrays import Array, Mask

MIXING_DEPTH = 8
"""Iterations that Anderson's mixing uses: more gain nothing at the accuracy of the iterations. Strong heat in partial slip
needs them: the article's case converges up to twice the speed that it reaches with four."""
MOST_ITERATIONS = 60
"""The last state below the thermo-elastic limit needed 44; beyond it no number of iterations is enough."""
UNCHANGED = 1e-13
"""Residual of an iteration that begins and ends with the same fields. Two of them repeat each other."""
NORMAL_SHARE = 1e-3
"""Residual of the gap over that of the fixed point: small, because it is cheap, and a residual gap at the border adds or drops
elements there."""
NEARLY_CONVERGED = 10.0
"""Multiple of the tolerance below which the next iteration may be the last: its tractions are solved to full accuracy."""
LOOSEST_TRACTIONS = 1e-2
"""Largest tolerance of the tractions of any iteration: with a larger one stick and slip would be wrong."""
CLOSE_PATIENCE = 4
"""Iterations without progress after which a residual below the acceptable one ends the iteration: only border elements still
flip in and out."""
MOST_DAMPINGS = 5
"""Number of times that falling friction may be damped to transmit a prescribed force before the iteration is given up; each
time halves the reserve of friction."""
MOST_UNBALANCED = 2
"""Iterations allowed to miss the balance of pressure and heat; early ones use the slip of another contact."""
MOST_RAISED = 4
"""Number of times that the heat may be raised from zero for that: later iterations start from the pressure of the last."""
CLOSEST_BALANCE = 1e-8
"""Smallest tolerance of a pressure in balance with its heat, over the elastic displacement."""
ACCEPTED_STAGNATION = 10.0
"""Multiple of the tolerance that is accepted if no further iteration reduces the residual; still below 1e-4 of the approach."""
ACCEPTED_WITH_SHEAR = 0.3
"""The residual accepted for dissimilar bodies, times N²: a border element that flips in and out with its shear moves the
surfaces by less than its share of the contact, 4/(πN²)·(extent/2)²."""
ACCEPTED_WITH_HEAT = 2.0
"""The residual accepted for heat, over the variation of the expansion and times the number of elements of the contact: border
elements flip in pairs, one on either side."""

class Convergence(NamedTuple):
    """Expected convergence of an iteration, which determines its mixing, the tolerances of its problems, and when it is given
    up."""

    first_residual: float
    """Residual assumed for the tolerances of the first iteration if nothing is learnt."""
    tangential_share: float
    """Residual of the tractions over that of the fixed point."""
    possibly_last: int
    """From this iteration on each may be the last."""
    patience: int
    recent: int
    gain: float
    """An iteration stagnates if after `patience` steps the `recent` ones have not brought the residual below `gain` times the
    least one before them."""


FIRST_DAMPING = 0.7
"""Share of the first change of heat that is applied if nothing is learnt: bulge and pressure overshoot."""
HEAT = Convergence(first_residual=0.1, tangential_share=0.05, possibly_last=60, patience=36, recent=26, gain=0.5)
"""Heat may move the surfaces by half of the approach. Mixing needs iterations solved more accurately than they change: with a
first residual of 1 the exact case at 11.28 W needs 276 transforms, with 0.1 it needs 173. Heat is proportional to the
tractions, so their residual must be well below the change in an iteration. Close to the thermo-elastic limit a dozen and
more iterations may pass without any gain; those that go on for longer lose contacts that shrink to a tenth."""
SHEAR = Convergence(first_residual=2e-4, tangential_share=2.0, possibly_last=6, patience=16, recent=6, gain=0.7)
"""Shear between dissimilar bodies usually moves the surfaces by a few per cent of the approach: each iteration gains a factor
of ten or more, and its tractions are needed to a few per cent. With a coefficient of friction above one it gains a third, and
an iteration that has not converged after some sixteen steps alternates between border elements."""

Fields = dict[str, Any]
"""Arrays (nx, ny) by the names of `UNKNOWNS`."""

UNKNOWNS: dict[str, Callable[[DerivedQuantities], float]] = {
    "expansion": lambda derived: derived.scales.approach,
    "shear_displacement": lambda derived: derived.scales.approach,
    "friction": lambda derived: derived.problem.friction.coefficient,
}
"""Fields of `Contact` that an iteration computes, each with the scale of its changes. A further unknown is a field there, a
line in `iterate` and a line here."""


class Learnt(NamedTuple):
    """Knowledge about an iteration before it starts: the `residual` that its first tractions are solved for, and `secants` of
    a similar iteration on this grid, over the scales of the unknowns."""

    residual: float
    secants: Secants | None = None


@dataclass(frozen=True)
class SteadyState:
    """The best state found, the iterations needed and the work of the inner solvers in them; `residual` is the change of the
    unknowns in its last iteration, over their scales. `balanced` says whether its iterations used pressures in balance with
    their heat; `heat_reached` is 1, or the share of the heat that could be reached if there is no balance with all of it."""

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
    secants: Secants | None = None

    @property
    def acts_back(self) -> bool:
        """True if there are unknowns to iterate; else one iteration is the solution."""
        return bool(unknowns_of(self.contact))


def unknowns_of(contact: Contact) -> Fields:
    """The fields of `contact` that act back on it."""
    return {name: field for name in UNKNOWNS if (field := getattr(contact, name)) is not None}


def fixed_point(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, *, balanced: bool = False,
    learnt: Learnt | None = None,
) -> SteadyState:
    """Iterate from `start` until the fields that act back no longer change.

    The residual is the largest change of an unknown field over its scale, on the contact. An iteration has converged if its
    residual is below the tolerance and its own problems are solved. If mixing alone does not converge because of the heat, the
    fixed point is restarted with iterations that each begin from a pressure in balance with its own heat (`heated_step`):
    this is more work, but also solves strong heat, if the contact slides. With `balanced` it starts this way at once. If
    nothing converges the best state is returned. `learnt` comes from a coarser grid or from neighbouring problems.
    """
    heated = start.expansion is not None or start.friction is not None
    convergence = HEAT if heated else SHEAR
    first = _iterated(discretisation, start, tolerances, convergence, balanced, learnt if heated else None)
    if first.converged or first.touches_rim or start.expansion is None:
        return first
    second = _iterated(discretisation, start, tolerances, HEAT, not balanced)
    best = second if second.converged or second.residual < first.residual else first
    # Both attempts count for `heat_reached` and for the cost.
    reached = (first if balanced else second).heat_reached
    return replace(best, normal_iterations=first.normal_iterations + second.normal_iterations, heat_reached=reached,
                   applications=first.applications + second.applications, newton_steps=first.newton_steps + second.newton_steps)


def _iterated(
    discretisation: Discretisation, start: Contact, tolerances: Tolerances, convergence: Convergence, balanced: bool,
    learnt: Learnt | None = None,
) -> SteadyState:
    mixing = _Mixing(discretisation, balanced, learnt, damped=convergence is HEAT)
    done, state = _Iterations(discretisation, start, tolerances, convergence, learnt), start
    # Where nothing acts back, one iteration is the solution, also of a force that friction does not carry.
    while len(done.history) < MOST_ITERATIONS and not mixing.gives_up and not (
            unknowns_of(state) and reserve(discretisation, state) <= 0.0):
        after = iterate(discretisation, state, done.inside(state))
        changes, size = _change(discretisation, state, after)
        done.take(state, after, size)
        if not changes or done.end():
            break
        state = mixing.next(state, after, changes, size)
    return done.steady_state(mixing, balanced)


class _Iterations:
    """Those of one fixed point: the `best` state with its residual, `limit` of the residual, the `least` one that was solved,
    and the work in them. They say how closely the next one is solved, and when none is worth while."""

    def __init__(
        self, discretisation: Discretisation, start: Contact, tolerances: Tolerances, convergence: Convergence,
        learnt: Learnt | None,
    ) -> None:
        self._discretisation, self._tolerances = discretisation, tolerances
        self._convergence, self._learnt = convergence, learnt
        self.limit = tolerances.tangential if start.expansion is None else tolerances.coupling
        self.best, self.residual, self.least, self.history = start, math.inf, math.inf, list[float]()
        self.touches_rim = False
        self._work = np.zeros(3, dtype=int)

    def inside(self, state: Contact) -> Tolerances:
        """Tolerances of the problems inside the next iteration, from `state`."""
        tolerances, convergence = self._tolerances, self._convergence
        if not unknowns_of(state):
            return tolerances
        first = convergence.first_residual
        outer = self.history[-1] if self.history else first if self._learnt is None else min(self._learnt.residual, first)
        last = outer <= NEARLY_CONVERGED * self.limit or len(self.history) >= convergence.possibly_last
        tangential = tolerances.tangential if last else max(convergence.tangential_share * outer, tolerances.tangential)
        normal = max(NORMAL_SHARE * outer, tolerances.normal)
        return replace(tolerances, tangential=min(tangential, LOOSEST_TRACTIONS), normal=normal)

    def take(self, before: Contact, after: Contact, size: float) -> None:
        """One more, that has changed the unknowns by `size` over their scales."""
        normal, tangential = after.normal, after.tangential
        self._work += (normal.iterations, tangential.applications, tangential.newton_steps)
        self.history.append(size)
        self.touches_rim = normal.touches_rim
        solved = (normal.converged and tangential.converged
                  and tangential.residual <= 2.0 * self._tolerances.tangential and not self.touches_rim)
        if self.least == math.inf or (solved and size < self.least):
            self.best, self.residual = replace(after, **unknowns_of(before)), size
            self.least = size if solved else math.inf

    def end(self) -> bool:
        """Whether the last one is the last: it is good enough, its domain is too small, or another one would not be better. A
        residual that stagnates is then accepted where only a finer grid could reduce it, and becomes the limit."""
        if self.least <= self.limit or self.touches_rim:
            return True
        history, convergence = self.history, self._convergence
        if len(history) > 1 and max(history[-2:]) < UNCHANGED:
            return True  # the second was solved to full accuracy: what it did not solve another one does not solve either
        enough = self._accepted
        # Close to the accuracy that the grid allows fewer iterations without gain suffice.
        patience, recent = (CLOSE_PATIENCE, CLOSE_PATIENCE) if self.least <= enough else (
            convergence.patience, convergence.recent)
        stagnates = len(history) > patience and min(history[-recent:]) > convergence.gain * min(history[:-recent])
        if stagnates:
            self.limit = enough
        return stagnates

    @property
    def _accepted(self) -> float:
        """The residual that is accepted if further iterations do not reduce it."""
        derived, best = self._discretisation.derived, self.best
        border = ACCEPTED_WITH_SHEAR / min(self._discretisation.grid.shape) ** 2 if derived.kinematics.feeds_back else 0.0
        if best.expansion is not None:
            moved = _variation(best) / max(_variation(best), derived.scales.approach)
            border = max(border, ACCEPTED_WITH_HEAT * moved / int(np.count_nonzero(best.normal.contact)))
        return max(ACCEPTED_STAGNATION * self.limit, border)

    def steady_state(self, mixing: _Mixing, balanced: bool) -> SteadyState:
        """The best state. The iteration does not determine the mean expansion, which only shifts the approach, or for a given
        one nothing."""
        best = self.best
        if best.expansion is not None:
            expansion, approach = self._discretisation.pressure.without_approach(best.expansion, best.normal.covered)
            moved_by = approach if self._discretisation.derived.problem.approach is None else 0.0
            best = replace(best, normal=replace(best.normal, approach=best.normal.approach + moved_by), expansion=expansion)
        normal, applications, newton_steps = self._work.tolist()
        return SteadyState(
            best, len(self.history), self.residual, self.least <= self.limit, normal, applications, newton_steps,
            self.touches_rim, tuple(self.history), balanced, mixing.heat_reached, mixing.secants)


def _change(discretisation: Discretisation, before: Contact, after: Contact) -> tuple[Fields, float]:
    """Change of the unknowns in an iteration, that of the expansion without its mean, which the approach absorbs; and the
    largest of them over its scale, on the contact."""
    changes = {name: getattr(after, name) - field for name, field in unknowns_of(before).items()}
    scales = {name: UNKNOWNS[name](discretisation.derived) for name in changes}
    if "expansion" in changes:
        changes["expansion"], _ = discretisation.pressure.without_approach(changes["expansion"], after.normal.covered)
        # Heat that concentrates the contact presses the bodies deeper into each other than their cold approach.
        scales["expansion"] = max(scales["expansion"], _variation(after))
    # Includes elements that a shrunken contact has left: the gap must be converged there, too.
    where = after.normal.contact | discretisation.pressure.isothermal.contact
    on_contact = {name: change[where] for name, change in changes.items()}
    # The displacement by shear changes with every element that the border gains or loses: only its mean square converges.
    squared = after.shear_displacement is not None
    sizes = {name: np.sqrt(np.mean(field**2)) if squared else np.abs(field).max() for name, field in on_contact.items()}
    return changes, max((float(size) / scales[name] for name, size in sizes.items()), default=0.0)


def _variation(state: Contact) -> float:
    """Variation of the thermal expansion over the contact in m."""
    assert state.expansion is not None
    return float(np.ptp(state.expansion[state.normal.contact]))


class _Mixing:
    """Anderson's mixing of all unknowns, each relative to its scale; friction is kept within its limits."""

    def __init__(self, discretisation: Discretisation, balanced: bool, learnt: Learnt | None, *, damped: bool) -> None:
        self._discretisation = discretisation
        # Steps to a balance of pressure and heat need no damping, and neither do good starts.
        self._anderson = Anderson(MIXING_DEPTH, FIRST_DAMPING if damped and not balanced and learnt is None else 1.0,
                                  None if learnt is None else learnt.secants)
        self._balanced = balanced
        self.dampings = 0
        self.heat_reached = 1.0
        self.unbalanced = self.raised = 0

    @property
    def gives_up(self) -> bool:
        """Whether friction was damped, or the balance with the heat missed, more often than helps."""
        return self.dampings > MOST_DAMPINGS or self.unbalanced > MOST_UNBALANCED or self.raised > MOST_RAISED

    @property
    def secants(self) -> Secants | None:
        """Those of the last iterations, over the scales of the unknowns."""
        return self._anderson.secants

    def next(self, before: Contact, after: Contact, changes: Fields, residual: float) -> Contact:
        """State of the next iteration: mixed unknowns, and the pressure and tractions of the last."""
        unknowns = unknowns_of(before)
        if not unknowns:
            return after
        if self._balanced and before.expansion is not None:
            step = heated_step(self._discretisation, before, after, max(NORMAL_SHARE * residual, CLOSEST_BALANCE))
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


def heated_step(discretisation: Discretisation, before: Contact, after: Contact, tolerance: float) -> HeatedContact:
    """Pressure of whole elements and expansion in balance, the start of the next iteration, from the one that led from `before`
    to `after`; solved to `tolerance` of the elastic displacement."""
    assert before.expansion is not None and after.expansion is not None
    normal, heat = after.normal, discretisation.heat(after, LOOSEST_TRACTIONS)
    contact = normal.contact
    loaded = contact & (normal.pressure > 0.0)
    per_pressure = np.where(loaded, heat.flux / np.where(loaded, normal.pressure, 1.0), 0.0)
    share = heat.mean_share if np.isfinite(heat.mean_share) else 0.5
    cosine = discretisation.pressure.cosine

    given = discretisation.derived.given
    at_approach = isinstance(given, Approach)

    def expand(pressure: Array, contact: Mask) -> Array:
        expansion = heat.response.displacement(DividedHeat(per_pressure * pressure / cosine, share))
        return (discretisation.pressure.without_approach(expansion, contact)[0] if at_approach else expansion) / cosine

    rest = after.expansion - expand(normal.pressure * cosine, contact) * cosine
    offset = before.offset
    assert offset is not None
    undeformed = discretisation.pressure.undeformed_gap
    if discretisation.heights is not None:
        undeformed = undeformed - discretisation.heights
    defect = normal.displacement + undeformed - offset - normal.approach * cosine
    # The border apart it is the same everywhere: the approach is that of whole elements.
    middle = np.unravel_index(np.argmax(normal.pressure), contact.shape)
    defect = np.where(contact, defect, (defect / cosine)[middle] * cosine)
    by_shear = 0.0 if after.shear_displacement is None else after.shear_displacement
    gap = undeformed - rest - by_shear - defect
    solver = HeatedContactSolver(discretisation.pressure.solver, expand, gap / cosine, given)
    state = solver.continued(normal.pressure * cosine, tolerance)
    # If no contact is found even without heat, the result does not limit the heat.
    return replace(state, pressure=state.pressure / cosine, expansion=state.expansion * cosine + rest,
                   reached=state.reached if state.reached > 0.0 else 1.0)

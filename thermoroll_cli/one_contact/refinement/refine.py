"""One grid of a state, from the grid before it: the same step without thermal deformation and with it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.refinement.level import Level, begun_on, better_domain, returns
from thermoroll_cli.one_contact.refinement.neighbours import at_place, predicted
from thermoroll_cli.one_contact.refinement.plan import Plan
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.one_contact.steady_state.fixed_point import (
    HEAT,
    MIXING_DEPTH,
    Fields,
    Learnt,
    SteadyState,
    fixed_point,
    unknowns_of,
)
from thermoroll_cli.one_contact.steady_state.iteration import friction_before_heat
from thermoroll_cli.one_contact.steady_state.scalars import reported_state
from thermoroll_cli.physics.numerics.convolution import counted
from thermoroll_cli.physics.numerics.grid import Prolongation
from thermoroll_cli.problem.contact import Contact, Traction

COARSE_TOLERANCE = 3.0
"""Factor by which coarser grids are solved less closely; neither finest grid nor estimates notice. Without: 2 to 4 % more work,
2.2 times as much at worst."""
FIRST_GUESS = 1e-2
"""Residual at which tractions under the isothermal pressure are good enough for what acts back to start from. Forces that no
interlayer carries are refused here."""
PREDICTED = 1e-3
"""Residual of a start predicted from the last problem and a coarser grid: a loose first iteration would lose its accuracy. With
1e-2 the points of a sweep differ by up to a fifth of their estimates from those solved alone."""


def refine(
    plan: Plan, usual: Discretisation, levels: Sequence[Level], last: Sequence[Level], cold: Level | None = None
) -> Level:
    """The state on the next grid, that of `usual`, after the coarser ones in `levels`; `last` are those of the last problem.

    With thermal deformation, if the state without it is given (`cold`, on the same grid). The state starts from what the last
    problem predicts, else from the coarser grid, else from the `cold` one, else from Hertz's pressure and full stick."""
    begun, transforms = time.perf_counter(), counted.transforms
    coarse, tolerances, hot = levels[-1] if levels else None, tolerances_on(plan, usual), cold is not None

    def found(
        here: Discretisation, near: tuple[Discretisation, Contact] | None, source: Level | None, balanced: bool
    ) -> SteadyState:
        """The state on `here`, from what the last problem predicts there, else from the state of the grid `near` it and what
        `source` knows."""
        neighbour = predicted(here, coarse, last)
        if neighbour is not None:
            before, residual = at_place(last, here.place), None if coarse is None else PREDICTED
            start = first_guess(here, neighbour, hot=hot)
            state = fixed_point(here, start, tolerances, balanced=balanced,
                                learnt=learnt(before, here, start, balanced, residual))
            if not (hot and state.touches_rim):
                return state  # else the domain that follows would depend on neighbours
        start = first_guess(here, None if near is None else carried(here, *near), hot=hot)
        return fixed_point(here, start, tolerances, balanced=balanced, learnt=learnt(source, here, start, balanced, None))

    here = begun_on(usual, coarse)
    known = coarse or cold
    # Carter's tractions need no others to begin from.
    near = None if known is None or (plan.derived.kinematics.carter and not hot) else (known.here, known.contact)
    state = found(here, near, coarse, hot and coarse is not None and coarse.stays_balanced)
    shrunk = settled = False
    for _ in range(here.options.most_moves if hot else 0):
        # A contact that turns out larger than it seemed keeps the room that it then gets.
        settled = settled or (shrunk and state.touches_rim)
        moved = better_domain(here, state, smaller=not settled)
        if moved is None:
            break
        shrunk = not state.touches_rim
        here, state = moved, found(moved, (here, state.contact), None, state.balanced and state.converged)
    if returns(usual, here, state):
        guess = first_guess(usual, carried(usual, here, state.contact), hot=True)
        back = fixed_point(usual, guess, tolerances, balanced=state.balanced)
        here, state = (usual, back) if back.converged else (here, state)
    return Level(here, state, reported_state(here, state.contact, heated=plan.runs("heat")),
                 counted.transforms - transforms, time.perf_counter() - begun)


def first_guess(here: Discretisation, guess: Contact | None, *, hot: bool) -> Contact:
    """`guess` (None: Hertz's pressure and full stick) with just the fields that act back on `here`: its own where it has them,
    else what they are before anything is known of them."""
    fields: Fields = {}
    if here.derived.kinematics.feeds_back:
        fields["shear_displacement"] = np.zeros(here.grid.shape)
    if here.derived.problem.friction_varies:
        fields["friction"] = friction_before_heat(here)
    if hot:
        fields["expansion"] = np.zeros(here.grid.shape)
    if guess is None:
        normal, tangential = here.isothermal_pressure, Traction.unknown(here.grid.shape)
        return Contact(normal, here.roll(normal, tangential, FIRST_GUESS) if fields else tangential, **fields)
    known = unknowns_of(guess)
    return Contact(guess.normal, guess.tangential, **{name: known.get(name, field) for name, field in fields.items()})


def carried(here: Discretisation, source: Discretisation, contact: Contact) -> Contact:
    """`contact` on `here` as a first guess: fields by interpolation, tractions as shares of the traction bound."""
    if source.pressure is here.pressure:  # they share their grid
        return contact
    prolong = Prolongation(source.grid, here.grid)
    guess = here.isothermal_pressure
    if contact.normal is not source.isothermal_pressure:
        if contact.expansion is None:
            # Little has changed of the isothermal pressure: its steep border need not be interpolated.
            change = prolong(contact.normal.pressure - source.isothermal_pressure.pressure)
            pressure = np.where(guess.contact, np.maximum(guess.pressure + change, 0.0), 0.0)
        else:
            pressure = np.maximum(prolong.from_inside(contact.normal.pressure), 0.0)
            if not pressure.any():  # A small contact can lie between the elements of a larger domain.
                pressure = guess.pressure
        guess = replace(guess, pressure=pressure, covered=(pressure > 0.0).astype(float))
    traction = prolong.traction(contact.tangential.traction, contact.normal.pressure, guess.pressure)
    fields = {name: prolong(field) for name, field in unknowns_of(contact).items()}
    return Contact(guess, Traction.guess(traction, contact.tangential.creepage), **fields)


def learnt(source: Level | None, here: Discretisation, guess: Contact, balanced: bool, residual: float | None) -> Learnt | None:
    """What the level that `guess` comes from knows about the iteration from it on `here`; `residual` is that of the guess, if
    it is known."""
    if source is None or not source.state.converged or source.state.iterations > MIXING_DEPTH:
        return None
    state = source.state
    secants, alike = None, unknowns_of(state.contact).keys() == unknowns_of(guess).keys()
    if state.secants is not None and state.balanced == balanced and alike:
        prolong = Prolongation(source.here.grid, here.grid)
        secants = prolong(state.secants[0]), prolong(state.secants[1])
    return Learnt(residual or state.history[0] / HEAT.tangential_share, secants)


def tolerances_on(plan: Plan, here: Discretisation) -> Tolerances:
    """How closely the fixed point is solved on one grid of the plan: looser on grids that only lead to a finer one, and to its
    error estimates. If an accuracy is asked for, any grid may turn out to be the last, and its residual must not show in
    the estimates."""
    # Pressure and shear that act on each other cost more iterations from a looser start than it saves.
    derived = plan.derived
    closely = here.grid.shape == plan.grid or derived.problem.numerics.accuracy is not None or derived.kinematics.feeds_back
    return here.options.tolerances if closely else here.options.tolerances.times(COARSE_TOLERANCE)

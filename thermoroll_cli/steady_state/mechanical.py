"""The state without thermal deformation: Hertz pressure for similar bodies, a fixed point of pressure and shear for others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.model.contact import Contact, Pressure, Traction
from thermoroll_cli.solvers.algorithms.anderson import Anderson
from thermoroll_cli.solvers.algorithms.prolongation import Prolongation
from thermoroll_cli.steady_state.coupling import Coupled, Tolerances, couple, isothermal, lift_of, wavering
from thermoroll_cli.steady_state.discretisation import Discretisation

Array = NDArray[np.float64]

FIRST_GUESS = 1e-2
"""Residual at which the tractions under the Hertz pressure are good enough to start from."""

LAST_TURN = 10.0
"""From this many times the wanted residual the next turn is expected to reach it."""

FEW_TURNS = 6
"""Turns that weak coupling takes at most; from then on any may turn out to be the last."""


def mechanical(
    discretisation: Discretisation,
    starts: Sequence[Traction],
    tolerances: Tolerances,
    before: tuple[Discretisation, Contact] | None,
) -> tuple[Contact, Coupled | None]:
    """State without thermal deformation from the best of `starts`, and the account of its iterations.

    Shear between dissimilar bodies (Dundurs' β ≠ 0) changes the pressure; then, and only then, there are iterations: they
    start from the state on the discretisation `before` (a coarser grid, or this one in an earlier problem)."""
    if discretisation.derived.problem.friction_falls:
        return _with_warm_friction(discretisation, starts, tolerances, before)
    if not discretisation.derived.feeds_back:
        return isothermal(discretisation, starts, tolerances.tangential), None
    if before is None:
        guess, offset = isothermal(discretisation, starts, FIRST_GUESS), np.zeros(discretisation.grid.shape)
    else:
        coarse, contact = before
        guess = Contact(_pressure_guess(discretisation, coarse, contact), starts[0])
        offset = Prolongation(coarse.grid, discretisation.grid)(contact.offset)
    feedback = settle(discretisation, guess, offset, tolerances)
    return feedback.contact, feedback


def _with_warm_friction(
    discretisation: Discretisation,
    starts: Sequence[Traction],
    tolerances: Tolerances,
    before: tuple[Discretisation, Contact] | None,
) -> tuple[Contact, Coupled]:
    """As `mechanical`, with the coefficient of friction that goes with the temperature: heat acts on it, not on the shape."""
    tangential = starts[0] if starts else isothermal(discretisation, [], FIRST_GUESS).tangential
    offset, friction = np.zeros(discretisation.grid.shape), None
    if before is not None and before[1].friction is not None:
        prolong = Prolongation(before[0].grid, discretisation.grid)
        offset, friction = prolong(before[1].offset), prolong(before[1].friction)
    start = Contact(discretisation.hertz, tangential, friction=friction)
    state = couple(discretisation, start, offset, tolerances, deforms=False)
    return state.contact, state


def settle(
    discretisation: Discretisation, start: Contact, lift: Array, tolerances: Tolerances, max_iterations: int = 60
) -> Coupled:
    """Fixed point of pressure and shear between dissimilar bodies, from the tractions of `start` and a first guess of the
    `lift` (m), which is the unknown: press the lifted surfaces together, roll, and see how far that shear lifts them.

    Each turn gains a factor of ten or more. Tractions are solved for as closely as their lift has to be known, and to the
    end only in the turn that is likely to be the last. The residual is the rms change of the lift on the contact over the
    approach. Very strong coupling ends where the border wavers between elements, which a finer grid alone could decide.
    """
    scale = discretisation.derived.hertz.approach
    limit = tolerances.tangential
    mixer = Anderson(depth=4)
    contact, pressure = start, start.normal.pressure
    outer = 2.0 * LAST_TURN * limit
    best, history = (math.inf, start), list[float]()
    counts = np.zeros(3, dtype=int)
    rim = False
    while len(history) < max_iterations and best[0] > limit and not (rim or _wavers(history)):
        size = float(np.ptp(lift)) / scale
        last = outer <= LAST_TURN * limit or len(history) >= FEW_TURNS
        inner = limit if last else 0.1 * outer / size if size else 1.0
        normal, solution = discretisation.press(lift, pressure, max(1e-3 * outer, 0.1 * limit))
        tangential = discretisation.roll(normal, [contact.tangential], min(max(inner, limit), FIRST_GUESS))
        contact, pressure = Contact(normal, tangential, lift=lift), solution.pressure
        counts += (solution.iterations, tangential.applications, tangential.newton_steps)
        rim = solution.touches_rim
        value = lift_of(discretisation, contact)
        outer = float(np.sqrt(np.mean((value - lift)[normal.contact] ** 2))) / scale
        history.append(outer)
        if solution.converged and tangential.converged and tangential.residual <= 2.0 * limit and outer < best[0]:
            best = outer, contact
        lift = mixer.next(lift, np.asarray(value))
    if best[0] < math.inf:
        outer, contact = best
    converged = bool(best[0] <= (wavering(limit, discretisation) if _wavers(history) else limit))
    return Coupled(contact, len(history), outer, converged, int(counts[0]), int(counts[1]), int(counts[2]), rim,
                   tuple(history))


def _wavers(history: list[float]) -> bool:
    """Whether the last six turns have gained less than a third."""
    return len(history) >= 12 and min(history[-6:]) > 0.7 * min(history[:-6])


def _pressure_guess(discretisation: Discretisation, coarse: Discretisation, contact: Contact) -> Pressure:
    """Hertz pressure plus what shear has changed of it on another grid: the steep border need not be interpolated."""
    change = contact.normal.pressure - coarse.hertz.pressure
    pressure = np.maximum(discretisation.hertz.pressure + Prolongation(coarse.grid, discretisation.grid)(change), 0.0)
    return replace(discretisation.hertz, pressure=np.where(discretisation.hertz.covered > 0.3, pressure, 0.0))

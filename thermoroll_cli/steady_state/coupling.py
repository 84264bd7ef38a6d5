"""The steady state as a fixed point: pressure → traction and slip → heat → thermal expansion → pressure (Fig. 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.model.contact import Contact, Pressure, Traction
from thermoroll_cli.solvers.algorithms.anderson import Anderson
from thermoroll_cli.solvers.algorithms.prolongation import Prolongation
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.friction import carried, friction_before_heat, friction_of, held_back

Array = NDArray[np.float64]

SETBACKS = 5
"""How often falling friction may be held back to carry a prescribed force, before there is no steady state."""


COARSE_TOLERANCE = 3.0
"""Factor by which coarser grids are solved less closely: half of their work, and the finest grid does not notice."""


@dataclass(frozen=True)
class Tolerances:
    """Relative: residual of the tractions, residual gap over approach, change of the expansion over approach.

    Far below the discretisation error of any grid: a residual r moves forces and heat by r/3 at most."""

    tangential: float = 1e-5
    normal: float = 1e-7
    coupling: float = 3e-6

    def on_the_way(self, accuracy: float | None) -> Tolerances:
        """Those of grids that only lead to a finer one, and to its error estimates: looser. Where an `accuracy` is asked for
        any grid may turn out to be the last, and its residual must not show in the estimates."""
        factor = COARSE_TOLERANCE if accuracy is None else min(COARSE_TOLERANCE, max(1.0, 0.03 * accuracy / self.tangential))
        return Tolerances(factor * self.tangential, factor * self.normal, factor * self.coupling)


@dataclass(frozen=True)
class Coupled:
    """A converged (or last) coupled state with its outer iterations and what the inner solvers did."""

    contact: Contact
    iterations: int
    residual: float
    converged: bool
    normal_iterations: int
    applications: int
    newton_steps: int
    touches_rim: bool
    history: tuple[float, ...]


def isothermal(discretisation: Discretisation, starts: Sequence[Traction], tolerance: float) -> Contact:
    """State without thermal deformation: Hertz pressure and the tractions that go with it, from the best of `starts`."""
    normal = discretisation.hertz
    return Contact(normal, discretisation.roll(normal, starts, tolerance))


def expansion_of(discretisation: Discretisation, contact: Contact) -> Array:
    """Thermal expansion that the heat of `contact` makes, mean over the contact removed: the approach absorbs constants."""
    expansion = discretisation.heat(contact).expansion()
    inside = contact.normal.contact
    return np.asarray(expansion - expansion[inside].mean())


def lift_of(discretisation: Discretisation, contact: Contact) -> Array | float:
    """−u_z^τ by which the shear of `contact` closes the gap between dissimilar bodies, in m; 0 if it does not.

    Its mean stays in: unlike the expansion it vanishes far away, and so it counts in the approach."""
    return discretisation.normal_shear.lift(contact.tangential.traction) if discretisation.derived.feeds_back else 0.0


def couple(
    discretisation: Discretisation,
    start: Contact,
    offset: Array,
    tolerances: Tolerances,
    max_iterations: int = 60,
    deforms: bool = True,
) -> Coupled:
    """Iterate the circle of Fig. 2 from the tractions of `start` and a first guess of the normal `offset` (m).

    The unknowns of the fixed point are the offset (thermal expansion if the bodies are to deform, and for dissimilar bodies
    the lift by shear) and, if it falls with the temperature, the coefficient of friction. Anderson acceleration mixes their
    iterates. Inner problems are solved ten times more tightly than the outer residual stands.
    """
    problem, scale = discretisation.derived.problem, discretisation.derived.hertz.approach
    limit = tolerances.coupling if deforms else tolerances.tangential
    friction = None
    if problem.friction_falls:
        friction = friction_before_heat(discretisation) if start.friction is None else start.friction
    mixer = Anderson(depth=4, first_damping=0.7)
    contact = start
    pressure = start.normal.pressure
    outer = 1.0
    history: list[float] = []
    counts = np.zeros(3, dtype=int)
    converged = rim = False
    pressed = True
    setbacks = 0
    if friction is not None and carried(discretisation, friction, pressure) <= problem.prescribed_force:
        max_iterations = 0
    for _ in range(max_iterations):
        inner = max(0.05 * outer, 1.0 * tolerances.tangential)
        if deforms or discretisation.derived.feeds_back:
            normal, solution = discretisation.press(offset, pressure, max(1e-3 * outer, tolerances.normal))
            pressure, rim, pressed = solution.pressure, solution.touches_rim, solution.converged
            counts[0] += solution.iterations
        else:
            normal = discretisation.hertz
        tangential = discretisation.roll(normal, [contact.tangential], min(inner, 1e-2), friction)
        contact = Contact(normal, tangential, friction=friction)
        counts[1:] += (tangential.applications, tangential.newton_steps)
        lift = lift_of(discretisation, contact)
        change = (expansion_of(discretisation, contact) if deforms else 0.0) + lift - offset
        if not discretisation.derived.feeds_back:
            change -= change[normal.contact].mean()
        contact = replace(contact, expansion=offset - lift if deforms else None, lift=lift)
        # Also where a shrunken contact no longer is: a state must be one of the whole gap.
        where = change[normal.contact | discretisation.hertz.contact]
        # The lift by shear changes with every element that the border gains or loses: only its mean square settles.
        outer = float(np.sqrt(np.mean(where**2)) if discretisation.derived.feeds_back else np.abs(where).max()) / scale
        if friction is not None:
            warming = (friction_of(discretisation, contact) - friction) / problem.friction
            outer = max(outer, float(np.abs(warming[normal.contact]).max()))
        history.append(outer)
        stuck = _stuck(history)
        # Where an element of the border comes and goes, only a finer grid could gain more.
        wanted = wavering(limit, discretisation) if stuck else limit
        if outer <= wanted and tangential.residual <= 2.0 * tolerances.tangential and not rim:
            converged = pressed and tangential.converged
            break
        if rim or setbacks > SETBACKS or stuck:
            break
        if friction is None:
            offset = mixer.next(offset, offset + change)
        else:
            unknowns = np.stack((offset / scale, friction / problem.friction))
            offset, factor = mixer.next(unknowns, unknowns + np.stack((change / scale, warming)))
            factor = np.clip(factor, problem.friction_minimum, 1.0)
            offset = offset * scale
            friction, short = held_back(discretisation, problem.friction * factor, friction, normal.pressure)
            setbacks += short
    if not discretisation.derived.feeds_back:
        contact = _without_mean(contact)
    return Coupled(contact, len(history), outer, converged, int(counts[0]), int(counts[1]), int(counts[2]), rim,
                   tuple(history))


def wavering(limit: float, discretisation: Discretisation) -> float:
    """Residual that is accepted where no further turn improves it: an element of the border that comes and goes."""
    border = 0.3 / min(discretisation.grid.shape) ** 2 if discretisation.derived.feeds_back else 0.0
    return max(10.0 * limit, border)


def _without_mean(contact: Contact) -> Contact:
    """The same state with an expansion that is zero on average over the contact: the iteration leaves its constant, and with it
    the approach, where it happened to begin."""
    if contact.expansion is None:
        return contact
    mean = float(contact.expansion[contact.normal.contact].mean())
    normal = replace(contact.normal, approach=contact.normal.approach + mean)
    return replace(contact, normal=normal, expansion=contact.expansion - mean)


def _stuck(history: list[float]) -> bool:
    """Whether the last twelve turns of a long iteration have not halved what was reached before."""
    return len(history) > 20 and min(history[-12:]) > 0.5 * min(history[:-12])


def on_finer_grid(discretisation: Discretisation, coarse: Discretisation, contact: Contact) -> tuple[Contact, Array]:
    """Start of the coupled iteration on `discretisation`: offset, pressure and tractions of the coarser grid."""
    prolong = Prolongation(coarse.grid, discretisation.grid)
    pressure = np.maximum(prolong(contact.normal.pressure), 0.0)
    guess: Pressure = replace(discretisation.hertz, pressure=pressure, covered=(pressure > 0.0).astype(float))
    friction = None if contact.friction is None else prolong(contact.friction)
    return Contact(guess, discretisation.continue_from(coarse, contact, guess), friction=friction), prolong(contact.offset)

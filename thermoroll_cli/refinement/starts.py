"""The start of each state of a grid, and the domain on which it is solved.

The first of these that exists is taken:

    either state        1. what the last problems on this grid predict (`neighbours`)
                        2. the coarser grid
    isothermal state    3. nothing: Hertz's pressure and full stick
    coupled state       3. the previous problem on this grid, before a coarser grid that did not converge
                        4. the isothermal state

A coupled state may live on a domain that follows its contact (`followed_state`): strong heat concentrates the contact to a
fraction of Hertz's, and moves it to where the bodies are hot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.grid import Domain, Prolongation
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.refinement.neighbours import Neighbours, Prediction
from thermoroll_cli.refinement.outcome import FollowedState, RefinementLevel
from thermoroll_cli.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.steady_state.fixed_point import HEAT, MIXING_DEPTH, Fields, Learnt, SteadyState, fixed_point, unknowns_of
from thermoroll_cli.steady_state.iteration import friction_before_heat

FIRST_GUESS = 1e-2
"""Residual at which tractions under the isothermal pressure are good enough for what acts back to start from. Forces that no
interlayer carries are refused here."""
PREDICTED = 1e-3
"""Residual of a start predicted from neighbouring problems: a loose first iteration would lose its accuracy. With 1e-2 the
points of a sweep differ by up to a fifth of their estimates from those solved alone."""


@dataclass(frozen=True)
class Starts:
    """Sources of first guesses on one grid: the next `coarser` grid of the same problem, its `neighbours`, and the isothermal
    state that these have `predicted`."""

    discretisation: Discretisation
    coarser: RefinementLevel | None = None
    neighbours: Neighbours | None = None
    predicted: Prediction | None = None

    def isothermal(self) -> Contact:
        """First guess of the state without thermal deformation."""
        discretisation, source = self.discretisation, self.coarser
        fields = _unheated(discretisation)
        if self.predicted is not None:
            return _with_fields(self.predicted.contact(discretisation.isothermal_pressure, coupled=False), fields)
        if source is None:
            pressure, tangential = discretisation.isothermal_pressure, Traction.unknown(discretisation.grid.shape)
            if fields:
                tangential = discretisation.roll(pressure, tangential, FIRST_GUESS)
            return Contact(pressure, tangential, **fields)
        guess = _carried_over(discretisation, source.discretisation, source.isothermal.contact)
        return _with_fields(guess, fields)

    def coupled(self, isothermal: Contact, here: Discretisation) -> Contact:
        """First guess of the state with thermal deformation on `here`, which may have another domain than the `isothermal` one
        beside it."""
        source = self.of_coupled
        if self.predicted_coupled is not None:
            return self.moved(here, self.discretisation, self.predicted_coupled)
        if source is None or source.coupled is None:
            return self.moved(here, self.discretisation, isothermal)
        return self.moved(here, source.own_discretisation, source.coupled.contact)

    @cached_property
    def predicted_coupled(self) -> Contact | None:
        """The coupled state that neighbours predict, on the usual domain."""
        here = self.discretisation
        prediction = None if self.neighbours is None else self.neighbours.predicted(here.derived, here.grid, coupled=True)
        return None if prediction is None else prediction.contact(here.isothermal_pressure, coupled=True)

    @property
    def of_coupled(self) -> RefinementLevel | None:
        """The level that the coupled state is started from, if there is one: one that has converged before one that has not."""
        last = None if self.neighbours is None else self.neighbours.last
        known = [level for level in (self.coarser, last) if level is not None and level.coupled is not None]
        return min(known, key=lambda level: level.coupled is None or not level.coupled.converged, default=None)

    def learnt(self, here: Discretisation, *, coupled: bool, balanced: bool = False) -> Learnt | None:
        """Knowledge about the iteration of a state on `here` from the neighbours that predict its start, or else from the
        coarser grid if that has converged."""
        predicted = (self.predicted_coupled if coupled else self.predicted) is not None
        source = self.neighbours.last if predicted and self.neighbours is not None else self.coarser
        state = None if source is None else source.coupled if coupled else source.isothermal
        if source is None or state is None or not state.converged or state.iterations > MIXING_DEPTH:
            return None
        secants, unknowns = None, {*_unheated(here), *(["expansion"] if coupled else [])}
        if state.secants is not None and state.balanced == balanced and set(unknowns_of(state.contact)) == unknowns:
            prolong = Prolongation((source.own_discretisation if coupled else source.discretisation).grid, here.grid)
            secants = prolong(state.secants[0]), prolong(state.secants[1])
        return Learnt(PREDICTED if predicted else state.history[0] / HEAT.tangential_share, secants)

    @staticmethod
    def moved(here: Discretisation, source: Discretisation, contact: Contact) -> Contact:
        """First guess of the state with thermal deformation on `here` from a `contact` on another domain or grid."""
        fields = _unheated(here) | {"expansion": np.zeros(here.grid.shape)}
        return _with_fields(_carried_over(here, source, contact), fields)


def _unheated(discretisation: Discretisation) -> Fields:
    """The fields that act back without thermal deformation, before anything is known of them."""
    fields = {}
    if discretisation.derived.kinematics.feeds_back:
        fields["shear_displacement"] = np.zeros(discretisation.grid.shape)
    if discretisation.derived.problem.friction_varies:
        fields["friction"] = friction_before_heat(discretisation)
    return fields


def _with_fields(guess: Contact, fields: Fields) -> Contact:
    """`guess` with just the named `fields` acting back: its own where it has them."""
    known = unknowns_of(guess)
    return Contact(guess.normal, guess.tangential, **{name: known.get(name, field) for name, field in fields.items()})


def _carried_over(discretisation: Discretisation, source: Discretisation, contact: Contact) -> Contact:
    """`contact` on another grid as a first guess: fields by interpolation, tractions as shares of the traction bound."""
    if source.pressure is discretisation.pressure:  # they share their grid
        return contact
    prolong = Prolongation(source.grid, discretisation.grid)
    guess = discretisation.isothermal_pressure
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


ROOM = 0.125
"""Room on each side of a contact in a domain that follows it, over what it measures along that axis."""
WAY = 0.25
"""More of it on sides that the contact has touched: it is on its way there. Without: strong heat on coarse grids is not
balanced."""
WORTH = 0.5
"""A domain whose area is this much smaller, or less, is worth solving on again: as is one for half as many elements.
Without: scalars of small hot contacts change by up to 2.5 of their estimates."""
SMALLEST = 0.02
"""Side of a domain over Hertz's semi-axis, below which it does not follow: the iteration has lost its contact. Without: a hot
contact of 80 shrinks until the coordinates of its elements no longer differ, and the run does not end in minutes."""


def followed_state(starts: Starts, here: Discretisation, isothermal: SteadyState, tolerances: Tolerances) -> FollowedState:
    """The coupled state on `here`. If the contact leaves the domain, or fills too little of it, it is solved again
    on a domain fitted to the contact."""
    before = None if starts.coarser is None else starts.coarser.coupled
    # A contact that slides as a whole needs balancing on coarse grids alone: mixing goes on from there for a tenth of the work.
    balanced = (before is not None and before.balanced and before.converged
                and bool((before.contact.tangential.stick & before.contact.normal.contact).any()))
    state = fixed_point(here, starts.coupled(isothermal.contact, here), tolerances, balanced=balanced,
                        learnt=starts.learnt(here, coupled=True, balanced=balanced))
    smaller = settled = False
    for _ in range(here.options.most_moves):
        # A contact that turns out larger than it seemed keeps the room that it then gets.
        settled = settled or (smaller and state.touches_rim)
        domain = _around(here, state)
        if domain is None or not (state.touches_rim or (not settled and _is_worth(domain, here))):
            break
        smaller = not state.touches_rim
        moved = _on_domain(here, domain)
        state = fixed_point(moved, starts.moved(moved, here, state.contact), tolerances,
                            balanced=state.balanced and state.converged)
        here = moved
    return FollowedState(here, state)


def next_discretisation(starts: Starts) -> Discretisation:
    """Where the coupled state of a grid is begun: on its own domain, or around the contact that it is started from if that has
    been followed."""
    discretisation, source = starts.discretisation, starts.of_coupled
    if (source is None or source.coupled is None or source.own_discretisation is source.discretisation
            or starts.predicted_coupled is not None):
        return discretisation
    around = source.own_discretisation.followed
    if source is starts.coarser and source.coupled.converged:
        around = _around(source.own_discretisation, source.coupled)
    return discretisation if around is None else _on_domain(discretisation, around)


def _on_domain(like: Discretisation, domain: Domain) -> Discretisation:
    """A discretisation of the same problem with as many elements over another `domain`."""
    scales = like.derived.scales
    extent = max(domain.side_x / scales.semi_axis_x, domain.side_y / scales.semi_axis_y)
    return Discretisation(like.derived, like.grid.shape, extent, like.threads, like.options, domain)


def _is_worth(domain: Domain, here: Discretisation) -> bool:
    """Whether a smaller domain saves enough elements, or makes them small enough, to be solved on again."""
    return domain.side_x * domain.side_y <= WORTH * here.grid.element_area * here.grid.nx * here.grid.ny


def _around(here: Discretisation, state: SteadyState) -> Domain | None:
    """The domain around the contact of `state`; None where it does not follow."""
    derived, grid, inside = here.derived, here.grid, state.contact.normal.contact
    if not derived.problem.has_hertz_solution or not inside.any():
        # The pressure, with which that of the heated contact is compared, is known everywhere for Hertz's contact alone.
        return None
    low_x, high_x = _span(grid.x, grid.dx, np.flatnonzero(inside.any(axis=1)))
    low_y, high_y = _span(grid.y, grid.dy, np.flatnonzero(inside.any(axis=0)))
    if high_x - low_x < SMALLEST * derived.scales.semi_axis_x or high_y - low_y < SMALLEST * derived.scales.semi_axis_y:
        return None
    if derived.kinematics.mirror is not None and derived.kinematics.heat_mirrors:
        # But for rounding it is its own mirror image, and is solved as such.
        high_y = max(high_y, -low_y)
        low_y = -high_y
    return Domain(high_x - low_x, high_y - low_y, 0.5 * (low_y + high_y), 0.5 * (low_x + high_x))


def _span(centres: Array, size: float, places: NDArray[np.intp]) -> tuple[float, float]:
    """Lowest and highest coordinate (m) of a domain around the elements of `size` at `places` among those with the given
    `centres`."""
    low, high = float(centres[places[0]]) - 0.5 * size, float(centres[places[-1]]) + 0.5 * size
    length = high - low
    return (low - (ROOM + WAY * (places[0] == 0)) * length, high + (ROOM + WAY * (places[-1] == centres.size - 1)) * length)

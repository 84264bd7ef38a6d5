"""What each state of a grid is started from: decided here, and nowhere else.

The first of these that exists is taken:

    isothermal state    1. the previous problem of a sweep on this grid, with what the coarser grid has changed since
                        2. the coarser grid
                        3. nothing: Hertz's pressure and full stick
    coupled state       1. the coarser grid: a heated contact changes more from problem to problem than from grid to grid
                        2. the previous problem on this grid, before a coarser grid that did not converge
                        3. the isothermal state
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.numerics.grid import Prolongation
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.refinement.refinement_level import RefinementLevel
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import Fields, unknowns_of
from thermoroll_cli.steady_state.friction import friction_before_heat

LEAST_COVER = 0.3
"""Elements that the isothermal contact covers by less start without pressure between dissimilar bodies: the solver adds an
element more readily than it drops one."""
FIRST_GUESS = 1e-2
"""Residual at which tractions under the isothermal pressure are good enough for what acts back to start from."""


@dataclass(frozen=True)
class Starts:
    """Sources of first guesses on one grid: the next `coarser` grid of the same problem, the `previous` problem of a sweep on
    this grid, and that problem's next coarser grid."""

    discretisation: Discretisation
    coarser: RefinementLevel | None = None
    previous: RefinementLevel | None = None
    previous_coarser: RefinementLevel | None = None

    def isothermal(self) -> Contact:
        """First guess of the state without thermal deformation."""
        discretisation, source = self.discretisation, self.previous or self.coarser
        fields = _unheated(discretisation)
        if source is None:
            pressure, tangential = discretisation.isothermal_pressure, Traction.unknown(discretisation.grid.shape)
            if fields:
                tangential = discretisation.roll(pressure, tangential, FIRST_GUESS)
            return Contact(pressure, tangential, **fields)
        guess = _carried_over(discretisation, source.discretisation, source.isothermal.contact)
        if self.previous is not None:
            guess = replace(guess, tangential=self._predicted(self.previous))
        return _with_fields(guess, fields)

    def coupled(self, isothermal: Contact, home: Discretisation) -> Contact:
        """First guess of the state with thermal deformation on `home`, which may have another domain than the `isothermal` one
        beside it."""
        source = self.of_coupled
        if source is None or source.coupled is None:
            return self.moved(home, self.discretisation, isothermal)
        return self.moved(home, source.home, source.coupled.contact)

    @property
    def of_coupled(self) -> RefinementLevel | None:
        """The level that the coupled state is started from, if there is one: one that has converged before one that has not."""
        known = [level for level in (self.coarser, self.previous) if level is not None and level.coupled is not None]
        return min(known, key=lambda level: level.coupled is None or not level.coupled.converged, default=None)

    @staticmethod
    def moved(home: Discretisation, source: Discretisation, contact: Contact) -> Contact:
        """First guess of the state with thermal deformation on `home` from a `contact` on another domain or grid."""
        fields = _unheated(home) | {"expansion": np.zeros(home.grid.shape)}
        return _with_fields(_carried_over(home, source, contact), fields)

    def _predicted(self, previous: RefinementLevel) -> Traction:
        """Tractions of the previous problem on this grid, plus what the coarser grid has changed since. Shares of the traction
        bound are carried over, so that slip stays slip."""
        tangential = previous.isothermal.contact.tangential
        if self.coarser is None or self.previous_coarser is None:
            return tangential
        old, new = self.previous_coarser.isothermal.contact, self.coarser.isothermal.contact
        bound, coarse_bound = self.discretisation.isothermal_pressure.pressure, new.normal.pressure
        prolong = Prolongation(self.coarser.discretisation.grid, self.discretisation.grid)
        change = new.tangential.traction - old.tangential.traction * (coarse_bound / np.where(
            old.normal.pressure > 0.0, old.normal.pressure, 1.0))
        return replace(tangential, traction=tangential.traction + prolong.traction(change, coarse_bound, bound),
                       creepage=new.tangential.creepage)


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
    if source.has_grid_of(discretisation):
        return contact
    prolong = Prolongation(source.grid, discretisation.grid)
    guess = discretisation.isothermal_pressure
    if contact.normal is not source.isothermal_pressure:
        if contact.expansion is None:
            # Little has changed of the isothermal pressure: its steep border need not be interpolated.
            change = prolong(contact.normal.pressure - source.isothermal_pressure.pressure)
            enough = guess.covered > LEAST_COVER
            pressure = np.where(enough, np.maximum(guess.pressure + change, 0.0), 0.0)
        else:
            pressure = np.maximum(prolong.from_inside(contact.normal.pressure), 0.0)
        guess = replace(guess, pressure=pressure, covered=(pressure > 0.0).astype(float))
    traction = prolong.traction(contact.tangential.traction, contact.normal.pressure, guess.pressure)
    fields = {name: prolong(field) for name, field in unknowns_of(contact).items()}
    return Contact(guess, Traction.guess(traction, contact.tangential.creepage), **fields)

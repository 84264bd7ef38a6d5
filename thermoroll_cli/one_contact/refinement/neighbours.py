"""The start of a state from the last problem solved.

A state starts from that of the last problem on the same grid, x₁, and the change from that problem to this one on the coarser
grid,

    x = x₁ + P(x_coarse − x₁,coarse)

in Hertz's units: pressures over their peak, tractions over their bound, displacements over the approach, places over the sides
of the domain, so that neighbours may differ in load and profile, too. Whatever was solved counts: points of a sweep, steps of
wear, a loop over problems.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.fixed_point import UNKNOWNS, Fields, unknowns_of
from thermoroll_cli.physics.numerics.grid import Prolongation
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.tools.arrays import Array


def at_place(levels: Sequence[Level], place: tuple[object, ...]) -> Level | None:
    """The one of the `levels` of another problem that is at `place`."""
    return next((level for level in levels if level.here.place == place), None)


def predicted(here: Discretisation, coarse: Level | None, levels: Sequence[Level]) -> Contact | None:
    """First guess on `here` from the `levels` of the last problem and the next coarser one of this problem (None: there is
    none); None if nothing predicts it."""
    last = at_place(levels, here.place)
    if last is None or not all(level is None or level.state.converged for level in (last, coarse)):
        return None
    fields, creepage = _scaled(last)
    before = None if coarse is None else at_place(levels, coarse.here.place)
    if coarse is not None and before is not None and before.state.converged:
        (new, new_creepage), (old, old_creepage) = _scaled(coarse), _scaled(before)
        prolong = Prolongation(coarse.here.grid, here.grid)
        # Shares of the bound count with the pressure that they belong to: outside the contact there are none.
        pressure = np.maximum(new["pressure"], 0.0)
        weight = prolong(pressure)
        share = prolong((new["share"] - old["share"]) * pressure) / np.where(weight > 0.0, weight, 1.0)
        for name in fields.keys() & new.keys() & old.keys():
            fields[name] = fields[name] + (share if name == "share" else prolong(new[name] - old[name]))
        creepage = creepage + new_creepage - old_creepage
    return _contact(here, fields, creepage, last)


def _contact(here: Discretisation, fields: Fields, creepage: Array, last: Level) -> Contact:
    """The state of these `fields` and `creepage` in Hertz's units; only the `last` contact has pressure, and it is the
    isothermal one if nothing acts back on that."""
    derived, normal = here.derived, here.isothermal_pressure
    unknowns = {name: field * UNKNOWNS[name](derived) for name, field in fields.items() if name in UNKNOWNS}
    if unknowns.keys() - {"friction"}:
        pressure, start = (np.where(last.state.contact.normal.contact, np.maximum(fields[name], 0.0), 0.0)
                           * derived.scales.peak_pressure for name in ("pressure", "start"))
        normal = replace(normal, pressure=pressure, covered=(pressure > 0.0).astype(float), whole_elements=start)
    bound = unknowns.get("friction", derived.problem.friction.coefficient) * normal.pressure
    along, across = creepage * derived.saturation_creepage
    return Contact(normal, Traction.guess(fields["share"] * bound, (float(along), float(across))), **unknowns)


def _scaled(level: Level) -> tuple[Fields, Array]:
    """The fields of a state and its creepages in Hertz's units."""
    derived, contact = level.here.derived, level.state.contact
    normal = contact.normal
    bound = (derived.problem.friction.coefficient if contact.friction is None else contact.friction) * normal.pressure
    fields = {
        "pressure": normal.pressure / derived.scales.peak_pressure,
        "start": normal.start / derived.scales.peak_pressure,
        "share": contact.tangential.traction / np.where(bound > 0.0, bound, 1.0),
    } | {name: field / UNKNOWNS[name](derived) for name, field in unknowns_of(contact).items()}
    return fields, np.array(contact.tangential.creepage) / (derived.saturation_creepage or 1.0)

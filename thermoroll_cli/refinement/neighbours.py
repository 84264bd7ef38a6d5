"""The start of a state from the last problems solved.

A state starts from that of the last problem on the same grid, x₁, and the change from that problem to this one on the coarser
grid; on the coarsest one, from the change between the last two problems, times the step t to this one over theirs:

    x = x₁ + P(x_coarse − x₁,coarse),     x = x₁ + t (x₁ − x₀)

in Hertz's units: pressures over their peak, tractions over their bound, displacements over the approach, places over the sides
of the domain, so that neighbours may differ in load and profile, too. Whatever was solved counts: points of a sweep, steps of
wear, a loop over `Solver`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.grid import Prolongation
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.refinement.level import Level
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import UNKNOWNS, Fields, unknowns_of

LONGEST = 3.0
"""Largest |t|. Without: 12 % more transforms after a step that is ten times the one before it."""
ASIDE = 0.1
"""Part of a step that may lie aside of the step before; more is a corner of a sweep over several keys."""


def at_place(levels: Sequence[Level], place: tuple[object, ...]) -> list[Level]:
    """Those of the `levels` of other problems that are at `place`."""
    return [level for level in levels if level.here.place == place]


def step_length(problems: Sequence[Problem]) -> float:
    """t: the step from the second to the third problem over that from the first to the second, each number over its largest
    value; 0 where they do not go on in the same direction, or much further."""
    numbers = [list(_numbers(problem)) for problem in problems]
    if len({len(values) for values in numbers}) > 1:
        return 0.0
    values = np.array(numbers)
    before, step = np.diff(values / np.where(values.any(axis=0), np.abs(values).max(axis=0), 1.0), axis=0)
    t = float(step @ before) / max(float(before @ before), 1e-300)
    aside = np.linalg.norm(step - t * before)
    return t if abs(t) <= LONGEST and aside <= ASIDE * np.linalg.norm(step) else 0.0


def _numbers(value: object) -> Iterator[float]:
    """The finite numbers of a problem."""
    parts = [getattr(value, part.name) for part in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else value
    if isinstance(parts, list | tuple):
        for part in parts:
            yield from _numbers(part)
    elif isinstance(parts, float) and math.isfinite(parts):
        yield parts


def predicted(here: Discretisation, coarse: Level | None, levels: Sequence[Level]) -> Contact | None:
    """First guess on `here` from the `levels` of the last problems, newest first, and the next coarser one of this problem
    (None: there is none); None if nothing predicts it."""
    last, earlier = (*at_place(levels, here.place), None, None)[:2]
    if last is None or not all(level is None or level.state.converged for level in (last, coarse)):
        return None
    now, before, t = last, earlier, 1.0
    if coarse is not None:
        now, before = coarse, next(iter(at_place(levels, coarse.here.place)), None)
    elif earlier is not None:
        t = step_length([level.here.derived.problem for level in (earlier, last)] + [here.derived.problem])
    fields, creepage = _scaled(last)
    if before is not None and before.state.converged:
        (new, new_creepage), (old, old_creepage) = _scaled(now), _scaled(before)
        prolong = Prolongation(now.here.grid, here.grid)
        # Shares of the bound count with the pressure that they belong to: outside the contact there are none.
        pressure = np.maximum(new["pressure"], 0.0)
        weight = prolong(pressure)
        share = prolong(t * (new["share"] - old["share"]) * pressure) / np.where(weight > 0.0, weight, 1.0)
        for name in fields.keys() & new.keys() & old.keys():
            fields[name] = fields[name] + (share if name == "share" else prolong(t * (new[name] - old[name])))
        creepage = creepage + t * (new_creepage - old_creepage)
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

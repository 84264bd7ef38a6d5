"""One iteration of the article's Fig. 2: press → roll → heat → expand; friction that falls or rises with the temperature."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.one_contact.steady_state.traction import coulomb_bound
from thermoroll_cli.physics.heat.frictional_heat import Heat
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.tools.arrays import Array

DIVISION = 0.3
"""Tolerance of the division of heat over that of the tractions that make it."""


def iterate(discretisation: Discretisation, state: Contact, tolerances: Tolerances) -> Contact:
    """Press the bodies together, roll them, compute the heat, and the displacements of the surfaces by heat and shear.

    `state` is the start of the iteration: the fields that act back on the contact (`UNKNOWNS` of `fixed_point`; None if not
    active), and pressure and tractions from which the solvers start. Returns the state with the pressure and tractions for
    these fields, and with the fields that follow from them. In the steady state both sets of fields are equal.
    """
    if state.expansion is not None and discretisation.derived.problem.approach is not None:
        # A given approach counts from the mean of the heated surfaces, which mixing does not keep at zero.
        state = replace(state, expansion=discretisation.pressure.without_approach(state.expansion, state.normal.covered)[0])
    normal = discretisation.press(state.offset, state.normal, tolerances.normal)
    tangential = discretisation.roll(normal, state.tangential, tolerances.tangential, state.friction)
    rolled = replace(state, normal=normal, tangential=tangential)
    if state.shear_displacement is not None:
        rolled = replace(rolled, shear_displacement=discretisation.traction.coupling.normal_displacement(tangential.traction))
    if state.expansion is None and state.friction is None:
        return rolled
    heat = discretisation.heat(rolled, DIVISION * tolerances.tangential)
    expansion = None if state.expansion is None else expansion_in(discretisation, heat, rolled)
    friction = None if state.friction is None else friction_of(discretisation, heat)
    return replace(rolled, expansion=expansion, friction=friction)


def expansion_in(discretisation: Discretisation, heat: Heat, contact: Contact) -> Array:
    """Thermal expansion u_z^t of both bodies in m, (nx, ny); its mean over the contact is removed, because the approach absorbs
    constants: an approach, found or given, counts from the mean of the heated surfaces."""
    expansion = heat.expansion()
    return discretisation.pressure.without_approach(expansion, contact.normal.covered)[0]


LEAST_RESERVE = 0.002
"""Least reserve of friction, as a share of a prescribed force: with less, the creepage grows without bound."""


def friction_before_heat(discretisation: Discretisation) -> Array:
    """Coefficient of friction at the bulk temperatures, (nx, ny)."""
    heating = discretisation.derived.problem.heating
    bulk = 0.5 * (heating.bulk_lower + heating.bulk_upper)
    return np.full(discretisation.grid.shape, discretisation.derived.problem.friction.at(bulk))


def friction_of(discretisation: Discretisation, heat: Heat) -> Array:
    """Coefficient of friction, (nx, ny), at the mean temperature of both surfaces with `heat`."""
    problem = discretisation.derived.problem
    lower, upper = heat.temperatures()
    bulk = problem.heating.bulk_lower + problem.heating.bulk_upper
    return problem.friction.at(0.5 * (lower + upper + bulk))


def admissible_friction(discretisation: Discretisation, wanted: Contact, before: Array) -> tuple[Array, bool]:
    """The coefficient of friction of `wanted` within its limits. If that cannot transmit the prescribed force, returns an
    intermediate one between `before` and it that halves the reserve, and True; else False."""
    problem, pressure = discretisation.derived.problem, wanted.normal.pressure
    assert wanted.friction is not None
    friction = np.clip(wanted.friction, *problem.friction.limits)
    force = problem.prescribed_force
    after, had = (transmissible_force(discretisation, f, pressure) for f in (friction, before))
    if after >= (1.0 + LEAST_RESERVE) * force or had <= after:
        return friction, False
    return before + (friction - before) * (0.5 * (had - force) / (had - after)), True


def reserve(discretisation: Discretisation, contact: Contact) -> float:
    """What friction in `contact` carries beyond the prescribed force in N; infinite where its coefficient is the same
    everywhere on a plane, since that is known before solving."""
    problem = discretisation.derived.problem
    if contact.friction is None and not problem.friction.across and isinstance(problem.geometry, Geometry):
        return math.inf
    friction = np.asarray(problem.friction.coefficient) if contact.friction is None else contact.friction
    return transmissible_force(discretisation, friction, contact.normal.pressure) - problem.prescribed_force


def transmissible_force(discretisation: Discretisation, friction: Array, pressure: Array) -> float:
    """Largest tangential force in N: ∫ μp, with the largest factor of a law of slip that rises."""
    law = discretisation.derived.problem.friction.law
    highest = 1.0 if law is None else law.highest
    bound = coulomb_bound(discretisation.derived.problem, pressure, friction, discretisation.grid)
    return highest * float(bound.sum()) * discretisation.grid.element_area

"""Friction that falls or rises with the temperature of the contact."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.frictional_heat import Heat
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.steady_state.discretisation import Discretisation

LEAST_RESERVE = 0.002
"""Least reserve of friction, as a share of a prescribed force: with less, the creepage grows without bound."""


def friction_at(problem: Problem, temperature: Array | float) -> Array:
    """μ(T) = μ₀ [1 − s (T − T₀)] above T₀, between `friction_minimum` and `friction_maximum` times μ₀; T in K above the
    temperature of μ₀."""
    factor = 1.0 - problem.friction_slope * np.maximum(np.asarray(temperature) - problem.friction_start, 0.0)
    return np.asarray(problem.friction * np.clip(factor, problem.friction_minimum, problem.friction_maximum))


def friction_limits(problem: Problem) -> tuple[float, float]:
    """Least and largest coefficient of friction at any temperature."""
    if problem.friction_slope > 0.0:
        return problem.friction * problem.friction_minimum, problem.friction
    return problem.friction, problem.friction * problem.friction_maximum


def friction_before_heat(discretisation: Discretisation) -> Array:
    """Coefficient of friction at the bulk temperatures, (nx, ny)."""
    heating = discretisation.derived.problem.heating
    bulk = 0.5 * (heating.bulk_lower + heating.bulk_upper)
    return np.full(discretisation.grid.shape, friction_at(discretisation.derived.problem, bulk))


def friction_of(discretisation: Discretisation, heat: Heat) -> Array:
    """Coefficient of friction, (nx, ny), at the mean temperature of both surfaces with `heat`."""
    problem = discretisation.derived.problem
    lower, upper = heat.temperatures()
    bulk = problem.heating.bulk_lower + problem.heating.bulk_upper
    return friction_at(problem, 0.5 * (lower + upper + bulk))


def admissible_friction(discretisation: Discretisation, wanted: Contact, before: Array) -> tuple[Array, bool]:
    """The coefficient of friction of `wanted` within its limits. If that cannot transmit the prescribed force, returns an
    intermediate one between `before` and it that halves the reserve, and True; else False."""
    problem, pressure = discretisation.derived.problem, wanted.normal.pressure
    assert wanted.friction is not None
    friction = np.clip(wanted.friction, *friction_limits(problem))
    force = problem.prescribed_force
    after, had = (transmissible_force(discretisation, f, pressure) for f in (friction, before))
    if after >= (1.0 + LEAST_RESERVE) * force or had <= after:
        return friction, False
    return before + (friction - before) * (0.5 * (had - force) / (had - after)), True


def can_transmit(discretisation: Discretisation, contact: Contact) -> bool:
    """True if friction in `contact` can transmit the prescribed force with the `LEAST_RESERVE`."""
    if contact.friction is None:
        return True
    force = transmissible_force(discretisation, contact.friction, contact.normal.pressure)
    return force > discretisation.derived.problem.prescribed_force


def transmissible_force(discretisation: Discretisation, friction: Array, pressure: Array) -> float:
    """Largest tangential force in N: ∫ μp."""
    return float((friction * pressure).sum()) * discretisation.grid.element_area

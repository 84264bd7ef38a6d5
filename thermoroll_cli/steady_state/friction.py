"""Friction that falls with the temperature of the contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.model.contact import Contact
from thermoroll_cli.model.problem import Problem
from thermoroll_cli.steady_state.discretisation import Discretisation

Array = NDArray[np.float64]

RESERVE = 0.002
"""Part of a prescribed force by which friction must exceed it: beyond, creepage grows without end."""


def friction_at(problem: Problem, temperature: Array | float) -> Array:
    """μ(T) = μ₀ (1 − s T), at least `friction_minimum` of μ₀ and at most μ₀; T in K above the temperature of μ₀."""
    factor = 1.0 - problem.friction_slope * np.asarray(temperature)
    return np.asarray(problem.friction * np.clip(factor, problem.friction_minimum, 1.0))


def friction_before_heat(discretisation: Discretisation) -> Array:
    """Coefficient of friction at the bulk temperatures, (nx, ny)."""
    heating = discretisation.derived.problem.heating
    bulk = 0.5 * (heating.bulk_lower + heating.bulk_upper)
    return np.full(discretisation.grid.shape, friction_at(discretisation.derived.problem, bulk))


def friction_of(discretisation: Discretisation, contact: Contact) -> Array:
    """Coefficient of friction that goes with the heat of `contact`, (nx, ny), at the mean temperature of both surfaces."""
    problem = discretisation.derived.problem
    lower, upper = discretisation.heat(contact).temperatures()
    bulk = problem.heating.bulk_lower + problem.heating.bulk_upper
    return friction_at(problem, 0.5 * (lower + upper + bulk))


def held_back(discretisation: Discretisation, friction: Array, before: Array, pressure: Array) -> tuple[Array, bool]:
    """`friction`, unless it could not carry the prescribed force any more: then on the way there from `before`, as far as it
    loses half of what it has in reserve. And whether that was so."""
    force = discretisation.derived.problem.prescribed_force
    wanted, had = (carried(discretisation, f, pressure) for f in (friction, before))
    if wanted >= (1.0 + RESERVE) * force or had <= wanted:
        return friction, False
    return before + (friction - before) * (0.5 * (had - force) / (had - wanted)), True


def carried(discretisation: Discretisation, friction: Array, pressure: Array) -> float:
    """Largest tangential force in N: ∫ μp."""
    return float((friction * pressure).sum()) * discretisation.grid.element_area

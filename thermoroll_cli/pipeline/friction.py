"""Friction that falls with the temperature of the contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.pipeline.contact import Contact
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.pipeline.problem import Problem

Array = NDArray[np.float64]


def friction_at(problem: Problem, temperature: Array | float) -> Array:
    """μ(T) = μ₀ (1 − s T), at least `friction_minimum` of μ₀ and at most μ₀; T in K above the temperature of μ₀."""
    factor = 1.0 - problem.friction_slope * np.asarray(temperature)
    return np.asarray(problem.friction * np.clip(factor, problem.friction_minimum, 1.0))


def friction_before_heat(level: Level) -> Array:
    """Coefficient of friction at the bulk temperatures, (nx, ny)."""
    heating = level.scene.problem.heating
    return np.full(level.grid.shape, friction_at(level.scene.problem, 0.5 * (heating.bulk_lower + heating.bulk_upper)))


def friction_of(level: Level, contact: Contact) -> Array:
    """Coefficient of friction that goes with the heat of `contact`, (nx, ny), at the mean temperature of both surfaces."""
    problem = level.scene.problem
    lower, upper = level.heat(contact).temperatures()
    bulk = problem.heating.bulk_lower + problem.heating.bulk_upper
    return friction_at(problem, 0.5 * (lower + upper + bulk))

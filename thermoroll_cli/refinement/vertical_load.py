"""The normal load of a conformal contact whose total force along z is given, to which the traction contributes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result

ROUNDS = 8
"""Normal loads that are tried: three are usual."""
MET = 1e-5
"""Departure of the vertical force, relative, with which a load is found: the solvers leave a tenth of that."""


def under_vertical(problem: Problem, solve: Callable[[Problem], Result]) -> Result:
    """The result of `problem` under the load with which pressure and traction carry its `vertical` force (N) along z, by the
    secant method on their sum. `solve` solves one problem whose load is given.

    The error of the vertical force is one of the load, and of whatever grows with it: no scalar grows faster."""
    wanted = problem.vertical
    assert wanted is not None
    load, before = wanted, (0.0, 0.0)
    for _ in range(ROUNDS):
        result = solve(replace(problem, vertical=None, normal_force=load))
        force = result.coupled.scalars["contact_force_z_N"]
        departure = abs(force / wanted - 1.0)
        if not result.converged or not departure > MET:
            break
        slope = (force - before[1]) / (load - before[0])
        before = load, force
        load += (wanted - force) / slope if slope > 0.0 else wanted - force
    found = replace(result, problem=replace(result.problem, vertical=wanted))
    if not result.converged:
        return found
    if departure > MET:
        return replace(found, converged=False, uncertainty={}, reason=(
            f"no normal load gives the vertical force of {wanted:.6g} N: {before[0]:.6g} N gives {force:.6g} N"))
    error = result.uncertainty["contact_force_z_N"] + departure * wanted
    share = error / result.problem.normal_force
    uncertainty = {name: known + share * abs(result.numbers[name]) for name, known in result.uncertainty.items()}
    return replace(found, uncertainty=uncertainty | {"normal_N": error, "contact_force_z_N": departure * wanted})

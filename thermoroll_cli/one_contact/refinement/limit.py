"""The maximum of a creep curve, if friction falls with slip: a larger prescribed force has no steady state, a smaller one may
belong to two creepages."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import scipy

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result

CURVE_GRID = 64
"""Elements per side on which the curve of twenty solutions is followed at most: forces are known to some 1e-4 of μW there."""
CREEPAGES = tuple(2.0**k for k in range(-2, 14))
"""Creepages at which the curve is followed until the force falls, over that of saturation: friction has fallen to
its limit at the last."""
RESOLUTION = 0.02
"""Relative width to which the creepages of the maximum and of the falling branch are found: the force of the flat maximum is
then known to 3e-4, the branch to 0.5 %. With 0.01: 7 % more solutions."""


@dataclass(frozen=True)
class CreepMaximum:
    """The largest `force` (N) along the prescribed direction and the `creepage` at which it is reached; the creepage of the
    prescribed force on the `falling` branch beyond it (nan: there is none)."""

    force: float
    creepage: float
    falling: float = math.nan


def has_maximum(problem: Problem) -> bool:
    """Whether a force is prescribed to friction that falls with slip."""
    return problem.friction.law is not None and problem.friction.law.fall() > 0.0 and problem.prescribed_force > 0.0


def direction_of(problem: Problem) -> tuple[float, float]:
    """Unit vector of the prescribed force; of two the direction of creepage is that of the force."""
    size = problem.prescribed_force
    return (problem.motion.force_x or 0.0) / size, (problem.motion.force_y or 0.0) / size


def under_creepage(problem: Problem, creepage: float) -> Problem:
    """`problem` with `creepage` along the prescribed force in place of the force."""
    x, y = direction_of(problem)
    motion = problem.motion
    given = (x * creepage if motion.force_x is not None else motion.creepage_x,
             y * creepage if motion.force_y is not None else motion.creepage_y)
    return replace(problem, motion=replace(motion, creepage_x=given[0], creepage_y=given[1], force_x=None, force_y=None))


def creep_maximum(
    problem: Problem, solve: Callable[[Problem], Result], followed: dict[Problem, float] | None = None
) -> CreepMaximum:
    """Follow the creep curve of `problem` to its maximum and, for a force below it, down the falling branch.

    `solve` solves one problem; some twelve coarse solutions are taken. `followed` keeps the forces of the problems of a curve:
    neighbours that differ in the prescribed force alone have the same. Heat counts only where friction depends on temperature.
    Raises ArithmeticError where a solution on the curve fails."""
    x, y = direction_of(problem)
    wanted = problem.prescribed_force
    nx, ny = (min(n, CURVE_GRID) for n in problem.numerics.grid or (CURVE_GRID, CURVE_GRID))
    heating = problem.heating if problem.friction_varies else replace(problem.heating, heat=False)
    coarse = replace(problem, numerics=Numerics((nx, ny), extent=problem.numerics.extent), heating=heating, subsurface=None)

    followed = {} if followed is None else followed

    def force(creepage: float) -> float:
        point = under_creepage(coarse, creepage)
        if point not in followed:
            result = solve(point)
            if not result.converged:
                raise ArithmeticError(f"the creep curve was followed to a creepage of {creepage:.3g}, where {result.reason}")
            followed[point] = x * result.coupled.scalars["force_x_N"] + y * result.coupled.scalars["force_y_N"]
        return followed[point]

    creepages = [DerivedQuantities(problem).saturation_creepage * each for each in CREEPAGES]
    # A curve that only rises to the limit of friction has its maximum at the end.
    fallen = next((i for i in range(1, len(creepages)) if force(creepages[i]) <= force(creepages[i - 1])), len(creepages) - 1)
    bounds = math.log(creepages[max(fallen - 2, 0)]), math.log(creepages[fallen])
    top = scipy.optimize.minimize_scalar(lambda c: -force(math.exp(c)), bounds=bounds, method="bounded",
                                         options={"xatol": RESOLUTION})
    maximum = CreepMaximum(-float(top.fun), math.exp(float(top.x)))
    if wanted > maximum.force:
        return maximum
    weaker = next((creepage for creepage in creepages[fallen:] if force(creepage) < wanted), None)
    if weaker is None:
        return maximum
    falling = scipy.optimize.brentq(lambda c: force(math.exp(c)) - wanted, math.log(maximum.creepage), math.log(weaker),
                                    xtol=RESOLUTION)
    return replace(maximum, falling=math.exp(falling))


def beyond_maximum(problem: Problem, maximum: CreepMaximum, solve: Callable[[Problem], Result]) -> Result:
    """The state at the maximum of the creep curve, marked as not converged, for a force that exceeds it."""
    result = with_maximum(solve(under_creepage(problem, maximum.creepage)), maximum)
    wanted, most = problem.force_text(problem.prescribed_force), problem.force_text(maximum.force)
    reason = (f"no steady state carries {wanted}: friction falls with slip, and the creep force is {most} at most, at a "
              f"creepage of {maximum.creepage:.3g}. The fields and scalars are those at this creepage; prescribe a smaller "
              "force, or a creepage")
    return replace(result, problem=problem, converged=False, reason=reason, uncertainty={})


def with_maximum(result: Result, maximum: CreepMaximum) -> Result:
    """`result` with the maximum of its creep curve among its scalars, and a warning that names the other creepage."""
    warnings = result.warnings
    if not math.isnan(maximum.falling):
        warnings = (*warnings, f"the same force is also carried at a creepage of {maximum.falling:.3g}, on the falling branch "
                               "of the creep curve; the result is the state on the rising one")
    return replace(result, warnings=warnings, of_problem={
        **result.of_problem, "creep_force_max_N": maximum.force, "creepage_at_creep_force_max": maximum.creepage,
        "creepage_falling_branch": maximum.falling})

"""Limits of the steady state: the largest speed that has one, where heat is too much, and the largest force.

Where friction falls with slip the creep curve has a maximum: a larger prescribed force has no steady state, a smaller one may
belong to two creepages.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy

from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import SolverOptions

SEARCH_GRID = (32, 32)
"""Grid of the search: fine enough that the limit moves by less than the last step of the bracket on finer ones."""
LOWERED_BY = 4.0
"""Speeds are lowered from one power of this factor to the next until there is a state: the same ones, whatever is asked for."""
LOWERINGS = 9
"""Speeds down to 1/260000 of the wanted one are tried; 0: nothing is searched for."""
RESOLUTION = 0.02
"""Speeds that are higher by less than this share are not tried."""
ATTEMPTS = 12
"""Speeds tried on the way up at most."""
RETREATS = (1.0, 0.95, 0.8)
"""Shares of the speed found that are tried on the wanted grid, where the limit may be a little lower."""
RAISED_BY = 1.12
"""The speed is raised from there by this factor, each state begun with the one before; by its root after a failure."""
RAISES = 6
"""Times that it is: to twice the speed that was found from a cold start at most."""
MOST_WORK = 9.0
"""Work of the search over that of the failed solve: no further state is tried that could exceed it."""
MOST_MOVES = 6
"""As `SolverOptions.most_moves`, for the search: starts are close, and what fails is given up."""

Solve = Callable[[Problem], Result]
"""Solves problems that differ in speed, and remembers the last state that it found as a start."""


@dataclass(frozen=True)
class _Bracket:
    """The state `found` at `speed`, and `why` there is none at the speed `high`."""

    found: Result
    speed: float
    high: float
    why: str

    def after(self, higher: float, attempt: Result) -> _Bracket:
        """The bracket with what came of an `attempt` at a `higher` speed."""
        if attempt.converged:
            return replace(self, found=attempt, speed=higher)
        return replace(self, high=higher, why=f"{attempt.reason} (on {_elements(attempt.problem)} elements)")


class _Search:
    """Solves until the work that is `allowed` might be exceeded; each attempt is expected to take what the largest one has."""

    def __init__(self, allowed: float) -> None:
        self._left, self._largest = allowed, 0.0

    def attempt(self, solve: Solve, problem: Problem) -> Result | None:
        """The solution of a problem; None where no work is left for it."""
        if self._left < self._largest or self._left <= 0.0:
            return None
        result = solve(problem)
        work = work_of(result)
        self._left, self._largest = self._left - work, max(self._largest, work)
        return result


def last_steady_state(
    problem: Problem, failed: Result, solver: Callable[[SolverOptions], Solve], options: SolverOptions
) -> Result:
    """The state at the largest speed for which one is found, instead of `failed`; marked as not converged, with the reason.

    On one coarse grid speed is lowered until there is a state, and raised from there, each state begun with the one before; the
    wanted grid is solved at the largest speed found so, and goes on from there if it is finer. Where that reaches the wanted
    speed, it is the result. The whole takes `MOST_WORK` times the work of the failed solve at most, in padded transforms times
    elements. `solver` makes one for given options. Returns `failed` where nothing is found.
    """
    # Not finer than what is asked for: then the bracket would take longer than the solution.
    nx, ny = (min(pair) for pair in zip(problem.numerics.grid or SEARCH_GRID, SEARCH_GRID, strict=True))
    coarse = replace(problem, numerics=Numerics((nx, ny), extent=problem.numerics.extent))
    # A contact that leaves its domains is given up early.
    few = replace(options, most_moves=MOST_MOVES)
    alone = replace(few, sequence=False)
    search, solve, finer = solver(alone), solver(few), coarse.numerics.grid != problem.numerics.grid
    work = _Search(MOST_WORK * work_of(failed))
    bracket = _searched(coarse, failed, search, work)
    if bracket is not None:
        bracket = _on_the_wanted(problem, bracket, solve, work) if finer else _raised(coarse, bracket, search, work)
    if bracket is None:
        return failed
    estimated = finer
    if not finer:
        found = work.attempt(solve, at_speed(problem, bracket.speed))
        if found is not None and found.converged:
            # With coarser grids before it, for its estimates of errors.
            bracket, estimated = replace(bracket, found=found), True
    if bracket.speed == problem.motion.speed:
        reason = "" if estimated else ("a steady state was found on this grid alone, begun with those of lower speeds, so its "
                                       "errors are not known: try a finer or coarser numerics.grid")
        return replace(bracket.found, problem=problem, converged=estimated, reason=reason)
    reason = (f"no steady state found beyond V = {bracket.speed:.4g} m/s (asked for {problem.motion.speed:g} m/s); the fields "
              f"and scalars are those at {bracket.speed:.4g} m/s. At {bracket.high:.4g} m/s: {bracket.why}")
    return replace(bracket.found, problem=problem, converged=False, reason=reason)


def _searched(coarse: Problem, failed: Result, solve: Solve, work: _Search) -> _Bracket | None:
    """The bracket of the largest speed on the `coarse` grid; None where no speed tried has a state."""
    wanted = coarse.motion.speed
    high, why = wanted, failed.reason
    low = LOWERED_BY ** (math.ceil(math.log(wanted, LOWERED_BY) - 1e-9) - 1)
    for _ in range(LOWERINGS):
        attempt = work.attempt(solve, at_speed(coarse, low))
        if attempt is None:
            return None
        if attempt.converged:
            break
        low, high, why = low / LOWERED_BY, low, attempt.reason
    else:
        return None
    bracket, above = _Bracket(attempt, low, high, why), LOWERED_BY * low
    for _ in range(ATTEMPTS):
        if bracket.high <= (1.0 + RESOLUTION) * bracket.speed:
            break
        higher = (bracket.speed * above) ** 0.5
        if higher >= wanted:
            # The wanted speed has no state, so nothing beyond it is tried.
            above = higher
            continue
        found = work.attempt(solve, at_speed(coarse, higher))
        if found is None:
            break
        bracket = bracket.after(higher, found)
        above = above if found.converged else higher
    return bracket


def _on_the_wanted(problem: Problem, bracket: _Bracket, solve: Solve, work: _Search) -> _Bracket | None:
    """The `bracket` of a coarse grid on that of `problem`; None where no speed tried there has a state."""
    for speed in (retreat * bracket.speed for retreat in RETREATS):
        found = work.attempt(solve, at_speed(problem, speed))
        if found is None:
            return None
        if found.converged:
            return _raised(problem, replace(bracket, found=found, speed=speed), solve, work)
        bracket = bracket.after(speed, found)
    return None


def _raised(problem: Problem, bracket: _Bracket, solve: Solve, work: _Search) -> _Bracket:
    """The bracket after raising the speed in steps: where it has failed it may not, from a state that is nearer."""
    wanted, factor = problem.motion.speed, RAISED_BY
    for _ in range(RAISES):
        higher = min(wanted, factor * bracket.speed)
        found = work.attempt(solve, at_speed(problem, higher))
        if found is None:
            break
        bracket = bracket.after(higher, found)
        factor = factor if found.converged else (higher / bracket.speed) ** 0.5
        if bracket.speed == wanted or factor < 1.0 + RESOLUTION:
            break
    return bracket


def work_of(result: Result) -> float:
    """Padded transforms on all grids, times the elements of each."""
    return float(sum(level["transforms"] * level["grid"][0] * level["grid"][1] for level in result.work["levels"]))


def _elements(problem: Problem) -> str:
    nx, ny = problem.numerics.grid or (0, 0)
    return f"{nx} × {ny}"


def at_speed(problem: Problem, speed: float) -> Problem:
    """The same problem at another rolling speed."""
    return replace(problem, motion=replace(problem.motion, speed=speed))


# --- the maximum of a creep curve --------------------------------------------------------------------------------------


CURVE_GRID = 64
"""Elements per side on which the curve is followed: the force is known to some 1e-4 of μW there."""
FIRST = 0.5
"""Creepage from which the curve is followed, over that of saturation."""
FACTOR = 2.0
"""Ratio of one creepage to the one before, until the force falls."""
MOST_STEPS = 14
"""Factors of two after which the curve counts as one without a maximum: friction has fallen to its limit by then."""
MAXIMUM_RESOLUTION, BRANCH_RESOLUTION = 0.02, 1e-3
"""Relative width to which the creepage of the maximum, and that of the falling branch, are found: the maximum is flat."""
ROUNDING = 1e-6
"""Changes below this share of the force are rounding noise."""


@dataclass(frozen=True)
class CreepMaximum:
    """The largest `force` (N) along the prescribed direction and the `creepage` at which it is reached; the creepage of the
    prescribed force on the `falling` branch beyond it (nan: there is none)."""

    force: float
    creepage: float
    falling: float = math.nan


def has_maximum(problem: Problem) -> bool:
    """Whether a force is prescribed to friction that falls with slip."""
    return problem.friction_law is not None and problem.friction_law.lowest < 1.0 and problem.prescribed_force > 0.0


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
    Raises ArithmeticError where the curve has no maximum, or a solution on it fails."""
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

    creepages = [FIRST * DerivedQuantities(problem).saturation_creepage]
    forces = [force(creepages[0])]
    while len(forces) < 2 or forces[-1] > forces[-2] * (1.0 + ROUNDING):
        if len(forces) > MOST_STEPS:
            raise ArithmeticError(f"the creep force still rises at a creepage of {creepages[-1]:.3g}")
        creepages.append(FACTOR * creepages[-1])
        forces.append(force(creepages[-1]))
    low = creepages[max(len(creepages) - 3, 0)] if len(creepages) > 2 else creepages[0] / FACTOR
    bounds = math.log(low), math.log(creepages[-1])
    top = scipy.optimize.minimize_scalar(lambda c: -force(math.exp(c)), bounds=bounds, method="bounded",
                                         options={"xatol": MAXIMUM_RESOLUTION})
    found = CreepMaximum(-float(top.fun), math.exp(float(top.x)))
    if wanted > found.force:
        return found
    while forces[-1] > wanted and len(forces) <= MOST_STEPS:
        creepages.append(FACTOR * creepages[-1])
        forces.append(force(creepages[-1]))
    if forces[-1] > wanted:
        return found
    start, end = math.log(max(found.creepage, creepages[-1] / FACTOR)), math.log(creepages[-1])
    falling = scipy.optimize.brentq(lambda c: force(math.exp(c)) - wanted, start, end, xtol=BRANCH_RESOLUTION)
    return replace(found, falling=math.exp(falling))


def beyond_maximum(problem: Problem, maximum: CreepMaximum, solve: Callable[[Problem], Result]) -> Result:
    """The state at the maximum of the creep curve, marked as not converged, for a force that exceeds it."""
    result = with_maximum(solve(under_creepage(problem, maximum.creepage)), maximum)
    reason = (f"no steady state carries {problem.prescribed_force:.6g} N: friction falls with slip, and the creep force is "
              f"{maximum.force:.6g} N at most, at a creepage of {maximum.creepage:.3g}. The fields and scalars are those at "
              "this creepage; prescribe a smaller force, or a creepage")
    return replace(result, problem=problem, converged=False, reason=reason, error=dict.fromkeys(result.error, np.nan))


def with_maximum(result: Result, maximum: CreepMaximum) -> Result:
    """`result` with the maximum of its creep curve among its scalars, and a warning that names the other creepage."""
    warnings = result.warnings
    if not math.isnan(maximum.falling):
        warnings = (*warnings, f"the same force is also carried at a creepage of {maximum.falling:.3g}, on the falling branch "
                               "of the creep curve; the result is the state on the rising one")
    return replace(result, warnings=warnings, hertz={
        **result.hertz, "creep_force_max_N": maximum.force, "creepage_at_creep_force_max": maximum.creepage,
        "creepage_falling_branch": maximum.falling})

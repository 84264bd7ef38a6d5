"""Where no steady state is found for the heat asked for: up to which speed there is one, and what fails beyond."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.steady_state.discretisation import SolverOptions

SEARCH_GRID = (32, 32)
"""Grid of the search: fine enough that the limit moves by less than the last step of the bracket on finer ones."""
LOWERED_BY = 4.0
"""Speeds are lowered from one power of this factor to the next until there is a state: the same ones, whatever is asked for."""
LOWERINGS = 9
"""Speeds down to 1/260000 of the wanted one are tried; 0: nothing is searched for."""
RESOLUTION = 0.02
"""Part of the speed by which it is no longer raised."""
ATTEMPTS = 12
"""Speeds tried on the way up at most."""
RETREATS = (1.0, 0.95, 0.8)
"""Parts of that speed tried on the wanted grid, which may have its limit a little earlier."""
RAISED_BY = 1.12
"""From there the speed is raised by this factor, each state begun with the one before; by its root after a failure."""
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

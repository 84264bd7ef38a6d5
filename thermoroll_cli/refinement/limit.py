"""Where no steady state is found for the heat asked for: up to which speed there is one, and what fails beyond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.steady_state.solver_options import SolverOptions

SEARCH_GRID = (32, 32)
"""Grid of the search: fine enough that the limit moves by less than the last step of the bracket on finer ones."""
LOWERED_BY = 4.0
"""Factor by which speed is lowered until there is a state. Then it is raised by this factor at most."""
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
MOST_WORK = 5.0
"""Work of raising the speed over that of the state that it began with: from then on it is not raised any more."""
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


def last_steady_state(
    problem: Problem, failed: Result, solver: Callable[[SolverOptions], Solve], options: SolverOptions
) -> Result:
    """The state at the largest speed for which one is found, instead of `failed`; marked as not converged, with the reason.

    On one coarse grid speed is lowered until there is a state, and raised from there, each state begun with the one before; the
    wanted grid is solved at the largest speed found so, and goes on from there if it is finer. Where that reaches the wanted
    speed, it is the result. The whole takes a bounded number of solutions, and of work. `solver` makes one
    for given options. Returns `failed` where nothing is found.
    """
    # Not finer than what is asked for: then the bracket would take longer than the solution.
    nx, ny = (min(pair) for pair in zip(problem.numerics.grid or SEARCH_GRID, SEARCH_GRID, strict=True))
    coarse = replace(problem, numerics=Numerics((nx, ny), extent=problem.numerics.extent))
    # A contact that leaves its domains is given up early.
    few = replace(options, most_moves=MOST_MOVES)
    alone = replace(few, sequence=False)
    search, solve, finer = solver(alone), solver(few), coarse.numerics.grid != problem.numerics.grid
    bracket = _searched(coarse, failed, search)
    if bracket is not None:
        bracket = _on_the_wanted(problem, bracket, solve) if finer else _raised(coarse, bracket, search)
    if bracket is None:
        return failed
    estimated = finer
    if not finer and (found := solve(at_speed(problem, bracket.speed))).converged:
        # With coarser grids before it, for its estimates of errors.
        bracket, estimated = replace(bracket, found=found), True
    if bracket.speed == problem.motion.speed:
        reason = "" if estimated else ("a steady state was found on this grid alone, begun with those of lower speeds, which "
                                       "does not tell how large its errors are: try a finer or coarser numerics.grid")
        return replace(bracket.found, problem=problem, converged=estimated, reason=reason)
    reason = (f"no steady state found beyond V = {bracket.speed:.4g} m/s (asked for {problem.motion.speed:g} m/s); the fields "
              f"and scalars are those at {bracket.speed:.4g} m/s. At {bracket.high:.4g} m/s: {bracket.why}")
    return replace(bracket.found, problem=problem, converged=False, reason=reason)


def _searched(coarse: Problem, failed: Result, solve: Solve) -> _Bracket | None:
    """The bracket of the largest speed on the `coarse` grid; None where no speed tried has a state."""
    wanted = coarse.motion.speed
    low, high, why = wanted / LOWERED_BY, wanted, failed.reason
    for _ in range(LOWERINGS):
        attempt = solve(at_speed(coarse, low))
        if attempt.converged:
            break
        low, high, why = low / LOWERED_BY, low, attempt.reason
    else:
        return None
    bracket = _Bracket(attempt, low, high, why)
    for _ in range(ATTEMPTS):
        if bracket.high <= (1.0 + RESOLUTION) * bracket.speed:
            break
        higher = min(LOWERED_BY * bracket.speed, (bracket.speed * bracket.high) ** 0.5)
        bracket = bracket.after(higher, solve(at_speed(coarse, higher)))
    return bracket


def _on_the_wanted(problem: Problem, bracket: _Bracket, solve: Solve) -> _Bracket | None:
    """The `bracket` of a coarse grid on that of `problem`; None where no speed tried there has a state."""
    for speed in (retreat * bracket.speed for retreat in RETREATS):
        found = solve(at_speed(problem, speed))
        if found.converged:
            return _raised(problem, replace(bracket, found=found, speed=speed), solve)
        bracket = bracket.after(speed, found)
    return None


def _raised(problem: Problem, bracket: _Bracket, solve: Solve) -> _Bracket:
    """The bracket after raising the speed in steps: where it has failed it may not, from a state that is nearer."""
    wanted, factor = problem.motion.speed, RAISED_BY
    allowed = MOST_WORK * work_of(bracket.found)
    for _ in range(RAISES):
        higher = min(wanted, factor * bracket.speed)
        attempt = solve(at_speed(problem, higher))
        bracket = bracket.after(higher, attempt)
        allowed -= work_of(attempt)
        factor = factor if attempt.converged else (higher / bracket.speed) ** 0.5
        if bracket.speed == wanted or allowed < 0.0 or factor < 1.0 + RESOLUTION:
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

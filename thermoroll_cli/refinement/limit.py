"""Where no steady state is found for the heat asked for: up to which speed there is one, and what fails beyond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from thermoroll_cli.numerics.solver_options import LimitOptions, SolverOptions
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result

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
    speed, it is the result. The whole takes a bounded number of solutions, and of work (`LimitOptions`). `solver` makes one
    for given options. Returns `failed` where nothing is found.
    """
    limit = options.limit
    # Not finer than what is asked for: then the bracket would take longer than the solution.
    nx, ny = (min(pair) for pair in zip(problem.numerics.grid or limit.coarse, limit.coarse, strict=True))
    coarse = replace(problem, numerics=Numerics((nx, ny), extent=problem.numerics.extent))
    # A contact that leaves its domains is given up early.
    few = replace(options, refinement=replace(options.refinement, most_moves=limit.most_moves))
    alone = replace(few, refinement=replace(few.refinement, sequence=False))
    search, solve, finer = solver(alone), solver(few), coarse.numerics.grid != problem.numerics.grid
    bracket = _searched(coarse, failed, search, limit)
    if bracket is not None:
        bracket = _on_the_wanted(problem, bracket, solve, limit) if finer else _raised(coarse, bracket, search, limit)
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


def _searched(coarse: Problem, failed: Result, solve: Solve, options: LimitOptions) -> _Bracket | None:
    """The bracket of the largest speed on the `coarse` grid; None where no speed tried has a state."""
    wanted = coarse.motion.speed
    low, high, why = wanted / options.lowered_by, wanted, failed.reason
    for _ in range(options.lowerings):
        attempt = solve(at_speed(coarse, low))
        if attempt.converged:
            break
        low, high, why = low / options.lowered_by, low, attempt.reason
    else:
        return None
    bracket = _Bracket(attempt, low, high, why)
    for _ in range(options.attempts):
        if bracket.high <= (1.0 + options.resolution) * bracket.speed:
            break
        higher = min(options.lowered_by * bracket.speed, (bracket.speed * bracket.high) ** 0.5)
        bracket = bracket.after(higher, solve(at_speed(coarse, higher)))
    return bracket


def _on_the_wanted(problem: Problem, bracket: _Bracket, solve: Solve, options: LimitOptions) -> _Bracket | None:
    """The `bracket` of a coarse grid on that of `problem`; None where no speed tried there has a state."""
    for speed in (retreat * bracket.speed for retreat in options.retreats):
        found = solve(at_speed(problem, speed))
        if found.converged:
            return _raised(problem, replace(bracket, found=found, speed=speed), solve, options)
        bracket = bracket.after(speed, found)
    return None


def _raised(problem: Problem, bracket: _Bracket, solve: Solve, options: LimitOptions) -> _Bracket:
    """The bracket after raising the speed in steps: where it has failed it may not, from a state that is nearer."""
    wanted, factor = problem.motion.speed, options.raised_by
    allowed = options.most_work * work_of(bracket.found)
    for _ in range(options.raises):
        higher = min(wanted, factor * bracket.speed)
        attempt = solve(at_speed(problem, higher))
        bracket = bracket.after(higher, attempt)
        allowed -= work_of(attempt)
        factor = factor if attempt.converged else (higher / bracket.speed) ** 0.5
        if bracket.speed == wanted or allowed < 0.0 or factor < 1.0 + options.resolution:
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

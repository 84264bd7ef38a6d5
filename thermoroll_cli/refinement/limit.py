"""Where no steady state is found for the heat asked for: up to which speed there is one, and what fails beyond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from thermoroll_cli.model.problem import Numerics, Problem
from thermoroll_cli.model.result import Result
from thermoroll_cli.solvers.solver_options import LimitOptions


def last_steady_state(
    problem: Problem, failed: Result, solve_once: Callable[[Problem], Result], solve_on: Callable[[Problem], Result],
    options: LimitOptions,
) -> Result:
    """The state at the largest speed for which one is found, instead of `failed`; marked as not converged, with the reason.

    Speed, and with it heat, is lowered until a coarse grid has a steady state, then the largest such speed is bracketed; the
    requested grid is solved there, and from there the speed is raised in steps, each begun with the state before (`solve_on`
    remembers it; `solve_once` begins afresh): where that reaches the wanted speed, it is the result. Returns `failed` where
    nothing is found.
    """
    wanted = problem.motion.speed
    # Not finer than what is asked for: then the bracket would take longer than the solution.
    nx, ny = (min(pair) for pair in zip(problem.numerics.grid or options.coarse, options.coarse, strict=True))
    coarse = replace(problem, numerics=Numerics((nx, ny), extent=problem.numerics.extent))

    low, high, why = 0.5 * wanted, wanted, failed.reason
    for _ in range(options.halvings):
        attempt = solve_once(at_speed(coarse, low))
        if attempt.converged:
            break
        low, high, why = 0.5 * low, low, attempt.reason
    else:
        return failed
    for _ in range(options.bisections):
        middle = (low * high) ** 0.5
        attempt = solve_once(at_speed(coarse, middle))
        if attempt.converged:
            low = middle
        else:
            high, why = middle, attempt.reason
    for speed in (retreat * low for retreat in options.retreats):
        found = solve_on(at_speed(problem, speed))
        if found.converged:
            factor = options.raised_by
            for _ in range(options.raises):
                higher = min(wanted, factor * speed)
                attempt = solve_on(at_speed(problem, higher))
                if not attempt.converged:
                    high, why, factor = higher, attempt.reason, factor**0.5
                    continue
                found, speed = attempt, higher
                if speed == wanted:
                    return found
            reason = (f"no steady state found beyond V = {speed:.3g} m/s (asked for {wanted:g} m/s); the fields and scalars "
                      f"are those at {speed:.3g} m/s. At {high:.3g} m/s: {why}")
            return replace(found, problem=problem, converged=False, reason=reason)
    return failed


def at_speed(problem: Problem, speed: float) -> Problem:
    """The same problem at another rolling speed."""
    return replace(problem, motion=replace(problem.motion, speed=speed))

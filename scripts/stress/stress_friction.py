"""Random contacts with friction that falls with slip: convergence, one solution from every start, order of convergence, work
beside that with constant friction; part of `make stress`.

    python -m scripts.stress.stress_friction [--cases N] [--first SEED] [--grid N]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass, replace

import numpy as np

from scripts.stress.random_friction import random_friction, random_rising, random_yield
from scripts.stress.stress_checks import solve_to_check, violations
from thermoroll_cli.problem.problem import Heating, Numerics, Problem
from thermoroll_cli.refinement.solve import Solver, solve
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import SolverOptions

CASES, GRID = 200, 32
CONVERGED_SHARE, AGREE = 0.99, 1e-4
EVERY = 10
"""One case of so many is also started from a contact that sticks and from one that slides."""
STICKING, SLIDING = 0.1, 10.0
"""Creepages of these starts, over those of the case."""
REFINED = (24, 48, 96)
"""Elements per side of the grids that show the order of convergence, in the other cases of one in `EVERY`."""
LEAST_ORDER, MOST_WORK = 1.5, 1.3
"""Median order, and median work over that with constant friction."""
FEWEST_ORDERS = 5
OTHERS = {"interlayer that yields": random_yield, "rising friction": random_rising}
ONE_IN = 4
"""For so many laws that fall one of each of `OTHERS` is tried."""


@dataclass(frozen=True)
class Outcome:
    """What became of one case: `excess` says that a force exceeds the maximum of the creep curve, `difference` is the largest
    one of forces from other starts over μ₀W, `order` that of the convergence of forces with the grid (nan: not tried). `work`
    counts tangential applications on the finest grid, `constant_work` those with constant friction."""

    seed: int
    converged: bool
    reason: str
    excess: bool
    work: int
    constant_work: int
    difference: float = math.nan
    order: float = math.nan


def outcome(seed: int, grid: int) -> Outcome:
    """Solve the case of `seed`, with its law and without, and from two more starts or on more grids where it is one of
    `EVERY`."""
    problem = replace(random_friction(seed), numerics=Numerics((grid, grid)))
    result = solve(problem)
    constant = solve(replace(problem, friction=replace(problem.friction, law=None)))
    work, constant_work = (r.work["levels"][-1]["applications"] for r in (result, constant))
    done = Outcome(seed, result.converged, result.reason, "no steady state carries" in result.reason, work, constant_work)
    if not result.converged or problem.prescribed_force:
        return done
    if seed % EVERY == EVERY // 2 and not problem.interlayer.compliance and not DerivedQuantities(problem).dissimilar:
        return replace(done, order=_order(problem))
    if seed % EVERY:
        return done
    forces = np.array([result.coupled.scalars[name] for name in ("force_x_N", "force_y_N")])
    found = []
    for factor in (STICKING, SLIDING):
        solver = Solver()
        solver.solve(_creeping(problem, factor))
        scalars = solver.solve(problem).coupled.scalars
        found.append(np.abs(forces - [scalars["force_x_N"], scalars["force_y_N"]]).max() / problem.traction_limit)
    return replace(done, difference=float(max(found)))


def broken_by(kind: str, seed: int, grid: int) -> list[str]:
    """What the contact of `seed` of a `kind` among `OTHERS` breaks: convergence, or an invariant."""
    result = solve_to_check(replace(OTHERS[kind](seed), numerics=Numerics((grid, grid))))
    faults = violations(result) if result.converged else [result.reason]
    return [f"seed {seed}, {kind}: {fault}" for fault in faults]


def _creeping(problem: Problem, factor: float) -> Problem:
    motion = problem.motion
    return replace(problem, motion=replace(motion, creepage_x=factor * (motion.creepage_x or 0.0),
                                           creepage_y=factor * (motion.creepage_y or 0.0), spin=factor * motion.spin))


def _order(problem: Problem) -> float:
    """Order by which forces on `REFINED` converge, without heat. With constant friction, too, bodies that differ are of first
    order, and interfacial layers of order 1 to 1.5."""
    forces = []
    for n in REFINED:
        result = solve(replace(problem, numerics=Numerics((n, n)), heating=Heating(heat=False)),
                       options=SolverOptions(extrapolated=False))
        forces.append([result.coupled.scalars[name] for name in ("force_x_N", "force_y_N")])
    changes = np.linalg.norm(np.diff(forces, axis=0), axis=1)
    return float(np.log2(changes[0] / changes[1]))


def missed(outcomes: list[Outcome]) -> list[str]:
    """Targets that were not met. A force above the maximum of its creep curve is told as such, and no failure."""
    solvable = [o for o in outcomes if not o.excess]
    failed = [f"seed {o.seed}: {o.reason}" for o in solvable if not o.converged]
    apart = [f"seed {o.seed}: starts differ by {o.difference:.1e} μW" for o in outcomes if o.difference > AGREE]
    found = (failed if len(failed) > math.ceil((1.0 - CONVERGED_SHARE) * len(solvable)) else []) + apart
    if (ratio := _work_ratio(outcomes)) > MOST_WORK:
        found.append(f"median work {ratio:.2f} times that with constant friction")
    orders = [o.order for o in outcomes if not math.isnan(o.order)]
    if len(orders) >= FEWEST_ORDERS and np.median(orders) < LEAST_ORDER:
        found.append(f"median order of convergence {np.median(orders):.2f}")
    return found


def _work_ratio(outcomes: list[Outcome]) -> float:
    """Median over all that converged of the work over that with constant friction."""
    return float(np.median([o.work / o.constant_work for o in outcomes if o.converged and o.constant_work]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--grid", type=int, default=GRID, help="elements per side")
    wishes = parser.parse_args()
    outcomes = [outcome(seed, wishes.grid) for seed in range(wishes.first, wishes.first + wishes.cases)]
    work, apart, orders = ([v for v in found if not math.isnan(v)]
                           for found in zip(*((o.work, o.difference, o.order) for o in outcomes), strict=True))
    print(f"{len(outcomes)} cases: {sum(o.converged for o in outcomes)} converged, {sum(o.excess for o in outcomes)} forces "
          "above the maximum",
          f"work: median {np.median(work):.0f}, largest {max(work)}; median over that with constant friction "
          f"{_work_ratio(outcomes):.2f}",
          f"{len(apart)} from other starts, largest difference {max(apart, default=math.nan):.1e} μW",
          f"orders of convergence: {np.sort(np.round(orders, 1))}", sep="\n")
    for o in outcomes:
        if not o.converged:
            print(f"seed {o.seed}: {o.reason}", file=sys.stderr)
    seeds, broken = range(wishes.first, wishes.first + wishes.cases // ONE_IN), []
    for kind in OTHERS:
        found = [fault for seed in seeds for fault in broken_by(kind, seed, wishes.grid)]
        print(f"{len(seeds)} of {kind}: {len(found)} faults")
        broken += found
    for target in missed(outcomes) + broken:
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(missed(outcomes) + broken))


if __name__ == "__main__":
    sys.exit(main())

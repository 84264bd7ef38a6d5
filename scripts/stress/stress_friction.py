"""Random contacts with friction that falls with slip: convergence, and one solution from every start; part of `make stress`.

    python -m scripts.stress.stress_friction [--cases N] [--first SEED] [--grid N]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass, replace

import numpy as np

from scripts.stress.random_friction import random_friction
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.refinement.solve import Solver, solve

CASES, GRID = 200, 32
CONVERGED_SHARE, AGREE = 0.99, 1e-4
EVERY = 10
"""One case of so many is also started from a contact that sticks and from one that slides."""
STICKING, SLIDING = 0.1, 10.0
"""Creepages of these starts, over those of the case."""


@dataclass(frozen=True)
class Outcome:
    """What became of one case: `excess` says that a force exceeds the maximum of the creep curve, `difference` is the largest
    one of forces from other starts over μ₀W (nan: not tried)."""

    seed: int
    converged: bool
    reason: str
    excess: bool
    work: int
    difference: float = math.nan


def outcome(seed: int, grid: int) -> Outcome:
    """Solve the case of `seed`, and from two more starts where it is one of `EVERY`."""
    problem = replace(random_friction(seed), numerics=Numerics((grid, grid)))
    result = solve(problem)
    work = result.work["levels"][-1]["applications"]
    done = Outcome(seed, result.converged, result.reason, "no steady state carries" in result.reason, work)
    if not result.converged or problem.prescribed_force or seed % EVERY:
        return done
    forces = np.array([result.coupled.scalars[name] for name in ("force_x_N", "force_y_N")])
    found = []
    for factor in (STICKING, SLIDING):
        solver = Solver()
        solver.solve(_creeping(problem, factor))
        scalars = solver.solve(problem).coupled.scalars
        found.append(np.abs(forces - [scalars["force_x_N"], scalars["force_y_N"]]).max() / problem.traction_limit)
    return replace(done, difference=float(max(found)))


def _creeping(problem: Problem, factor: float) -> Problem:
    motion = problem.motion
    return replace(problem, motion=replace(motion, creepage_x=factor * (motion.creepage_x or 0.0),
                                           creepage_y=factor * (motion.creepage_y or 0.0), spin=factor * motion.spin))


def missed(outcomes: list[Outcome]) -> list[str]:
    """Targets that were not met. A force above the maximum of its creep curve is told as such, and no failure."""
    solvable = [o for o in outcomes if not o.excess]
    failed = [f"seed {o.seed}: {o.reason}" for o in solvable if not o.converged]
    apart = [f"seed {o.seed}: starts differ by {o.difference:.1e} μW" for o in outcomes if o.difference > AGREE]
    return (failed if len(failed) > math.ceil((1.0 - CONVERGED_SHARE) * len(solvable)) else []) + apart


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--grid", type=int, default=GRID, help="elements per side")
    wishes = parser.parse_args()
    outcomes = [outcome(seed, wishes.grid) for seed in range(wishes.first, wishes.first + wishes.cases)]
    work, apart = [o.work for o in outcomes], [o.difference for o in outcomes if not math.isnan(o.difference)]
    print(f"{len(outcomes)} cases: {sum(o.converged for o in outcomes)} converged, {sum(o.excess for o in outcomes)} forces "
          f"above the maximum; work: median {np.median(work):.0f}, largest {max(work)}; {len(apart)} from other starts, "
          f"largest difference {max(apart, default=math.nan):.1e} μW")
    for o in outcomes:
        if not o.converged:
            print(f"seed {o.seed}: {o.reason}", file=sys.stderr)
    for target in missed(outcomes):
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(missed(outcomes)))


if __name__ == "__main__":
    sys.exit(main())

"""Solve random neighbouring problems one after the other and hold each against the same problem solved alone: `make stress`.

    python -m scripts.stress.stress_neighbours [--cases N] [--first SEED]
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from scripts.stress.random_contacts import random_contact
from scripts.stress.random_profiles import random_profile_contact
from thermoroll_cli.problem.geometry import Profile
from thermoroll_cli.problem.names import SCALARS
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.refinement.solve import Solver, solve

CASES, FIRST = 100, 7000
"""Cases of three problems, so of two pairs, each."""
SIDE = 32
SMALLEST, LARGEST = 0.003, 0.1
"""Relative change from one problem to the next."""
SHARE = 1.0 / 3.0
"""Of its estimated error that a scalar may differ from that of the problem alone."""
ROUNDING = 2e-5
"""Twice the tolerance of the solvers: less is no difference."""


@dataclass(frozen=True)
class Difference:
    """A scalar of one case that depends on what was solved before: by how much over its error scale, and its estimate."""

    seed: int
    varied: str
    scalar: str
    size: float
    estimate: float


def neighbours(seed: int) -> tuple[str, list[Problem]]:
    """Three problems in a row that differ in one quantity, and its name; every third case has a profile."""
    rng = np.random.default_rng([17, seed])
    problem = random_profile_contact(seed) if seed % 3 == 0 else random_contact(seed)
    problem = replace(problem, numerics=Numerics((SIDE, SIDE)))
    step = float(rng.choice([-1.0, 1.0])) * math.exp(rng.uniform(math.log(SMALLEST), math.log(LARGEST)))
    kinds = ("speed", "load", "creepage", "profile" if (not problem.geometry.elliptic) else "friction")
    varied = kinds[int(rng.integers(4))]
    return varied, [_scaled(problem, varied, (1.0 + step) ** k) for k in range(3)]


def _scaled(problem: Problem, varied: str, factor: float) -> Problem:
    motion, geometry = problem.motion, problem.geometry
    if varied == "speed":
        return replace(problem, motion=replace(motion, speed=factor * motion.speed))
    if varied == "load":
        # A force that slides at one load would at none below it.
        forces = {name: None if force is None else factor * force
                  for name, force in (("force_x", motion.force_x), ("force_y", motion.force_y))}
        return replace(problem, normal_force=factor * problem.normal_force, motion=replace(motion, **forces))
    if varied == "creepage":
        given = {name: None if value is None else factor * value
                 for name, value in (("creepage_x", motion.creepage_x), ("creepage_y", motion.creepage_y))}
        return replace(problem, motion=replace(motion, **given, spin=factor * motion.spin))
    if varied == "friction":
        factor = max(factor, 1.0) if problem.prescribed_force else factor
        return replace(problem, friction=replace(problem.friction, coefficient=factor * problem.friction.coefficient))
    return replace(problem, geometry=replace(geometry, **{
        name: None if profile is None else _deeper(profile, factor)
        for name, profile in (("lower_profile", geometry.lower_profile), ("upper_profile", geometry.upper_profile))}))


def _deeper(profile: Profile, factor: float) -> Profile:
    return replace(profile, drop=factor * profile.drop, points=tuple((y, factor * z) for y, z in profile.points))


def differences(seed: int) -> Iterator[Difference]:
    """What of one case depends on the problems before it."""
    varied, problems = neighbours(seed)
    solver = Solver()
    for place, problem in enumerate(problems):
        result = solver.solve(problem)
        if place == 0:
            continue
        alone = solve(problem)
        if result.converged != alone.converged:
            yield Difference(seed, varied, "converged", float(result.converged), float(alone.converged))
        if not (result.converged and alone.converged):
            continue
        warm, cold = result.summary(), alone.summary()
        for name in SCALARS:
            scale, estimate = error_scale(name, cold), alone.error[name]
            if not (scale > 0.0 and math.isfinite(estimate)):
                continue
            size = abs(warm[name] - cold[name]) / scale
            if not size <= max(SHARE * estimate, ROUNDING):
                yield Difference(seed, varied, name, size, estimate)


def main() -> int:
    parser = argparse.ArgumentParser(description="Problems that start from their neighbours, against the same ones alone.")
    parser.add_argument("--cases", type=int, default=CASES, help=f"cases of two pairs each (default {CASES})")
    parser.add_argument("--first", type=int, default=FIRST, help="first seed")
    wishes = parser.parse_args()
    start, found = time.perf_counter(), list[Difference]()
    for seed in range(wishes.first, wishes.first + wishes.cases):
        for difference in differences(seed):
            print(difference, flush=True)
            found.append(difference)
    print(f"{2 * wishes.cases} pairs, {len(found)} scalars of {len({d.seed for d in found})} cases differ, in "
          f"{time.perf_counter() - start:.0f} s")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())

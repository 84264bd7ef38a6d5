"""Seeded neighbouring problems, solved one after the other, and each held against the same problem solved alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from scripts.stress.checks import differences
from scripts.stress.outcome import Outcome
from scripts.stress.random_contacts import random_contact
from scripts.stress.random_profiles import random_profile_contact
from thermoroll_cli.problem.geometry import Profile
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.python_api import Solver, solve

SIDE = 32
SMALLEST, LARGEST = 0.003, 0.1
"""Relative change from one problem to the next."""


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


def check(drawn: tuple[str, list[Problem]]) -> Outcome:
    """Solve the problems one after the other and each alone: what differs is broken."""
    varied, problems = drawn
    solver = Solver()
    results = [(solver.solve(problem), solve(problem)) for problem in problems]
    broken = tuple(f"{varied}: {what}" for result, alone in results[1:] for what in differences(result, alone))
    reason = next((alone.reason for _, alone in results if not alone.converged), "")
    return Outcome(not reason, reason, broken=broken, work=results[-1][0].work["levels"][-1]["applications"])

"""How a wheelset stands on its rails: its height, its roll and the patches that bear it, given what is known of their
forces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from thermoroll_cli.wheelset.one_wheel import Bearing, Solved, WheelOnRail, height_of
from thermoroll_cli.wheelset.wheelset_problem import SideName, WheelsetProblem

ROLL_ROUNDS = 30
ROLLED = 1e-9
"""Difference of the heights of both wheels (m) at which a roll is found: 1e-9 rad, a thousandth of what a patch of 20 µm
notices."""
ROLL_STEP = 1e-3
"""First guess of how far (rad) a bracket of the roll must be widened."""

Found = TypeVar("Found")


@dataclass(frozen=True)
class Standing:
    """Roll (rad), height of the axle (m, down) and the loaded patches of each side."""

    roll: float
    height: float
    bearings: Mapping[SideName, Sequence[Bearing]]


def stand(problem: WheelsetProblem, solved: Mapping[SideName, tuple[Solved, ...]], before: Standing | None = None) -> Standing:
    """Where `problem` stands, with the ratios of forces that are known as `solved`, near the standing `before`.

    If the roll is found, it makes the heights of both wheels equal, and each carries half of the vertical force. With a given
    roll they carry the whole force together. Raises Unsolvable where a wheel misses its rail, NoHeight where it cannot carry
    its force."""
    if problem.vertical is None:
        wheels = _wheels(problem, solved, problem.position.roll)
        bearings = {side: wheel.bearings(0.0) for side, wheel in wheels.items()}
        return Standing(problem.position.roll, problem.position.z, bearings)
    start = None if before is None else before.height
    if not problem.finds_roll:
        wheels = _wheels(problem, solved, problem.position.roll)
        height, of_wheels = height_of(list(wheels.values()), problem.vertical, start)
        return Standing(problem.position.roll, height, dict(zip(wheels, of_wheels, strict=True)))
    return _rolled(problem, solved, before)


def _wheels(
    problem: WheelsetProblem, solved: Mapping[SideName, tuple[Solved, ...]], roll: float
) -> dict[SideName, WheelOnRail]:
    modulus = problem.contact.contact_modulus
    return {side: WheelOnRail(problem.facing(side, roll), modulus, solved.get(side, ()), problem.curved)
            for side in problem.sides}


def _rolled(
    problem: WheelsetProblem, solved: Mapping[SideName, tuple[Solved, ...]], before: Standing | None
) -> Standing:
    """The roll with equal heights of both wheels, each with half of the force."""
    start = None if before is None else before.height
    half = 0.5 * (problem.vertical or 0.0)

    def standing(roll: float) -> tuple[float, Standing]:
        nonlocal start
        standings = {side: height_of([wheel], half, start) for side, wheel in _wheels(problem, solved, roll).items()}
        (left, _), (right, _) = standings["left"], standings["right"]
        start = 0.5 * (left + right)
        return left - right, Standing(roll, start, {side: bearings[0] for side, (_, bearings) in standings.items()})

    return level(standing, problem.span, 0.0 if before is None else before.roll)


def level(difference_at: Callable[[float], tuple[float, Found]], span: float, roll: float) -> Found:
    """What is found at the roll (rad) with which the heights of both wheels are equal, from a first guess `roll`.

    `difference_at` gives the height of the left wheel less that of the right one (m), which grows with the roll by about the
    `span` (m) between the rails, and what was found with it. A secant within a bracket."""
    low, high = -math.inf, math.inf
    last: tuple[float, float] | None = None
    for _ in range(ROLL_ROUNDS):
        difference, standing = difference_at(roll)
        if abs(difference) <= ROLLED or high - low < ROLLED:
            break
        low, high = (roll, high) if difference < 0.0 else (low, roll)
        slope = span if last is None or difference == last[1] else (difference - last[1]) / (roll - last[0])
        last = roll, difference
        wanted = roll - difference / slope
        if low < wanted < high:
            roll = wanted
        elif math.isinf(low) or math.isinf(high):
            roll -= math.copysign(max(ROLL_STEP, 2.0 * abs(difference) / span), difference)
        else:
            roll = 0.5 * (low + high)
    return standing

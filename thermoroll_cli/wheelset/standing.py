"""How a wheelset stands on its rails: its height, its roll and the patches that bear it, given what is known of their
forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from thermoroll_cli.numerics.roots import RisingRoot
from thermoroll_cli.wheelset.one_wheel import Bearing, Placed, WheelOnRail, height_of
from thermoroll_cli.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem

ROLL_ROUNDS = 30
ROLLED = 1e-9
"""Difference of the heights of both wheels (m) at which a roll is found: 1e-9 rad, a thousandth of what a patch of 20 µm
notices."""
LONGEST_ROLL = 0.02
"""Longest step of the roll (rad): flanges that climb lift a wheel by ten or twenty millimetres."""

Found = TypeVar("Found")


@dataclass(frozen=True)
class Standing:
    """Roll (rad), height of the axle (m, down) and the loaded patches of each side."""

    roll: float
    height: float
    bearings: Mapping[SideName, Sequence[Bearing]]


Wheels = Mapping[SideName, WheelOnRail]


def wheels_of(problem: WheelsetProblem) -> Wheels:
    """The wheels of `problem`, whose patches are kept from standing to standing."""
    return {side: WheelOnRail(problem.contact.contact_modulus, curved=problem.curved) for side in problem.sides}


def stand(
    problem: WheelsetProblem, wheels: Wheels, solved: Mapping[SideName, tuple[Bearing, ...]], before: Standing | None = None
) -> Standing:
    """Where `problem` stands on its `wheels`, with the ratios of forces that are known as `solved`, near the standing `before`.

    If the roll is found, it makes the heights of both wheels equal, and each carries half of the vertical force. With a given
    roll they carry the whole force together. Raises Unsolvable where a wheel misses its rail, NoHeight where it cannot carry
    its force."""
    start = None if before is None else before.height

    def placed(side: SideName, roll: float) -> Placed:
        return wheels[side], problem.facing(side, roll), solved.get(side, ())

    if problem.vertical is None or not problem.finds_roll:
        roll = problem.position.roll
        on = [placed(side, roll) for side in problem.sides]
        height, found = ((problem.position.z, [wheel.bearings(facing, 0.0, known) for wheel, facing, known in on])
                         if problem.vertical is None else height_of(on, problem.vertical, start))
        return Standing(roll, height, dict(zip(problem.sides, found, strict=True)))
    half = 0.5 * problem.vertical

    def standing(roll: float) -> tuple[float, Standing]:
        nonlocal start
        (left, on_left), (right, on_right) = (height_of([placed(side, roll)], half, start) for side in SIDES)
        start = 0.5 * (left + right)
        return left - right, Standing(roll, start, {"left": on_left[0], "right": on_right[0]})

    return level(standing, problem.span, 0.0 if before is None else before.roll)


def level(difference_at: Callable[[float], tuple[float, Found]], span: float, roll: float) -> Found:
    """The result of `difference_at` at the roll (rad) that makes the heights of both wheels equal; `roll` is the first guess.

    `difference_at` gives the height of the left wheel less that of the right one (m), which grows with the roll by about the
    `span` (m) between the rails, and any result beside it."""
    root = RisingRoot(roll, span, LONGEST_ROLL)
    for _ in range(ROLL_ROUNDS):
        difference, standing = difference_at(root.place)
        if abs(difference) <= ROLLED or root.width < ROLLED:
            break
        root.move(difference)
    return standing

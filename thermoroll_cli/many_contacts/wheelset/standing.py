"""How a wheelset stands on its rails: its height, its roll and the patches that bear it, given what is known of their
forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from thermoroll_cli.many_contacts.wheelset.one_wheel import BALANCED, CarryingPatch, WheelOnRail, height_of
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem
from thermoroll_cli.physics.numerics.roots import RisingRoot

ROLL_ROUNDS = 30
ROLLED = 1e-9
"""Difference of the heights of both wheels (m) at which a roll is found: 1e-9 rad, a thousandth of what a patch of 20 µm
notices. A place that is rough by a factor has it larger by that factor."""
LONGEST_ROLL = 0.02
"""Longest step of the roll (rad): flanges that climb lift a wheel by ten or twenty millimetres."""

Found = TypeVar("Found")


@dataclass(frozen=True)
class Standing:
    """Roll (rad), height of the axle (m, down) and the loaded patches of each side. `depths` are those (m) of the wheels of
    each side below their first contacts, `slope` (m/rad) the change of their heights' difference with the roll, if known."""

    roll: float
    height: float
    carrying: Mapping[SideName, Sequence[CarryingPatch]]
    depths: Mapping[SideName, float] = field(default_factory=dict)
    slope: float | None = None


Wheels = Mapping[SideName, WheelOnRail]


def wheels_of(problem: WheelsetProblem) -> Wheels:
    """The wheels of `problem`, whose patches are kept from standing to standing."""
    return {side: WheelOnRail(problem.contact, curved=problem.curved) for side in problem.sides}


def stand(
    problem: WheelsetProblem, wheels: Wheels, solved: Mapping[SideName, tuple[CarryingPatch, ...]], before: Standing,
    within: float = BALANCED
) -> Standing:
    """Where `problem` stands on its `wheels`, with the ratios of forces that are known as `solved`, near the standing `before`.

    If the roll is found, it makes the heights of both wheels equal, and each carries half of the vertical force. With a given
    roll they carry the whole force together. Raises Unsolvable where a wheel misses its rail, NoHeight where it cannot carry
    its force."""
    depths = dict(before.depths)

    def carried(sides: Sequence[SideName], vertical: float, roll: float) -> tuple[float, dict[SideName, list[CarryingPatch]]]:
        placed = [(wheels[side], wheels[side].over(problem.facing(side, roll)), solved.get(side, ())) for side in sides]
        height, found = height_of(placed, vertical, depths.get(sides[0]), within)
        depths[sides[0]] = height - min(facing.clearance for _, facing, _ in placed)
        return height, dict(zip(sides, found, strict=True))

    if problem.vertical is None:
        return Standing(problem.position.roll, problem.position.z, {
            side: wheels[side].carrying(wheels[side].over(problem.facing(side)), 0.0, solved.get(side, ()))
            for side in problem.sides})
    if not problem.finds_roll:
        return Standing(problem.position.roll, *carried(problem.sides, problem.vertical, problem.position.roll), depths)
    half = 0.5 * problem.vertical

    def standing(roll: float) -> tuple[float, Standing]:
        (left, on_left), (right, on_right) = (carried((side,), half, roll) for side in SIDES)
        return left - right, Standing(roll, 0.5 * (left + right), on_left | on_right, depths)

    found, slope = level(standing, before.slope or problem.span, before.roll, ROLLED * within / BALANCED)
    return replace(found, slope=slope)


def level(difference_at: Callable[[float], tuple[float, Found]], slope: float, roll: float,
          within: float = ROLLED) -> tuple[Found, float]:
    """The result of `difference_at` at the roll (rad) that makes the heights of both wheels equal `within` a difference (m),
    and the slope there; `roll` is the first guess.

    `difference_at` gives the height of the left wheel less that of the right one (m), which grows with the roll by about the
    `slope` (m/rad), the distance of the rails under treads, and any result beside it."""
    root = RisingRoot(roll, slope, LONGEST_ROLL)
    for _ in range(ROLL_ROUNDS):
        difference, standing = difference_at(root.place)
        if abs(difference) <= within or root.width < within:
            break
        root.move(difference)
    return standing, root.slope

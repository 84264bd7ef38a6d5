"""The question: a wheelset on a track, in SI units; and what can be said of it without solving anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from thermoroll_cli.many_contacts.wheelset.kinematics import MotionOfWheelset
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.rolled_surfaces import lift
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.many_contacts.wheelset.varying import VaryingFacing
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import Task
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.surface import Heights

SideName = Literal["left", "right"]
SIDES: tuple[SideName, ...] = ("left", "right")


@dataclass(frozen=True)
class WheelsetProblem(Task):
    """Wheels on rails. `contact` is a problem whose geometry, load and creepages each patch replaces. `rails` and `wheels`
    have a value for each side that exists. Left ones are mirrored, so that all are right ones.

    Of `position` the height counts only if `vertical` (N) is None, the roll only if `finds_roll` is False; of `motion` the
    angular velocity only if `finds_speed` is False. It is found such that the rails drive the wheelset with the force
    `traction` (N), or without it such that they cause no torque about the axle. Patches are `curved`, or each lies in a plane
    and is alone. `contact_distance` (m), between the contacts of both wheels, concerns the equivalent conicity. Tables of a
    case that concern no wheel are `without_effect`."""

    kind: ClassVar[str] = "wheelset"

    contact: Problem
    rails: Mapping[SideName, RailSide]
    wheels: Mapping[SideName, WheelSide]
    position: Position
    motion: MotionOfWheelset
    vertical: float | None = None
    finds_roll: bool = False
    finds_speed: bool = False
    traction: float | None = None
    curved: bool = True
    contact_distance: float = 1.5
    without_effect: tuple[str, ...] = ()

    @property
    def varies(self) -> bool:
        """Whether a rail or a wheel changes along rolling."""
        return any(side.varies for side in (*self.rails.values(), *self.wheels.values()))

    @property
    def surfaces(self) -> dict[SideName, tuple[Heights | None, Heights | None]]:
        """Those of rail and wheel of each side."""
        return {side: (self.rails[side].surface, self.wheels[side].surface) for side in self.sides}

    @property
    def along(self) -> float:
        """Place of the axle along the track in m."""
        return next(iter(self.rails.values())).along

    @property
    def turned(self) -> float:
        """Angle of the wheels in rad."""
        return next(iter(self.wheels.values())).turned

    def rolled(self, distance: float, angle: float) -> WheelsetProblem:
        """The wheelset after a `distance` (m), with wheels that have turned by an `angle` (rad), lifted by the surfaces that
        stand there."""
        there = replace(self, rails={side: rail.rolled(distance) for side, rail in self.rails.items()},
                        wheels={side: wheel.rolled(angle) for side, wheel in self.wheels.items()})
        return replace(there, rails={side: replace(rail, lifts=lift(there.facing(side))) for side, rail in there.rails.items()})

    def refuse_variation(self, what: str) -> None:
        """Raises Unsolvable if a rail or a wheel changes along rolling, which `what` does not know."""
        for table, profile, sides in (("track", "rail_profile", self.rails), ("wheelset", "wheel_profile", self.wheels)):
            if any(side.slices is not None for side in sides.values()):
                raise Unsolvable(f"{what} knows no slices", f"{table}.{profile}", "one outline for the whole length")
            if any(side.surface is not None for side in sides.values()):
                raise Unsolvable(f"{what} knows no surfaces", f"{table}.surface", "a case without it")

    @property
    def sides(self) -> tuple[SideName, ...]:
        return tuple(side for side in SIDES if side in self.wheels)

    @property
    def span(self) -> float:
        """Distance of the rails, or half of it, in m."""
        return sum(rail.half_gauge for rail in self.rails.values())

    def facing(self, side: SideName, roll: float | None = None) -> Facing:
        """The wheel of a side as a right one over its rail, at z = 0 unless the height is given, with another `roll` if
        given."""
        position = self.position if roll is None else replace(self.position, roll=roll)
        if self.vertical is not None:
            position = replace(position, z=0.0)
        rail, wheel = self.rails[side], self.wheels[side]
        facing = Facing if rail.slices is None and wheel.slices is None else VaryingFacing
        return facing(rail, wheel, position.mirrored if side == "left" else position)


def sign_of(side: SideName) -> float:
    """1 for the right side, −1 for the left one, whose y and angles change sign in the mirror."""
    return 1.0 if side == "right" else -1.0

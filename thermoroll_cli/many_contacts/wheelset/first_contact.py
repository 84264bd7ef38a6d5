"""A wheelset before anything is solved: where its wheels touch first, its roll and rolling radii, and warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from thermoroll_cli.many_contacts.wheelset.curves import curve
from thermoroll_cli.many_contacts.wheelset.one_wheel import deepest
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.many_contacts.wheelset.standing import level
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SideName, WheelsetProblem, sign_of
from thermoroll_cli.problem.geometry import Unsolvable, rough_warning
from thermoroll_cli.problem.rounding import rounding_warning
from thermoroll_cli.tools.arrays import Array

KINK_ROOM = 3e-3
"""A corner this near to the first contact (m) may lie in the loaded one."""
HOLLOW = 0.5e-3
"""Rise of the radius towards the field side (m) from which on a tread is hollow: worn treads of common use have less."""
ROUGH_REACH = 5e-3
"""Distance from first contact (m) within which a profile is looked at, about the half-width of loaded ones."""
ROUNDED = 2e-4
"""Part of E* by which rounding may change a pressure without a word: a fiftieth of the pressures of wheels on rails."""


def touching(problem: WheelsetProblem) -> dict[SideName, Facing]:
    """The wheels where they touch first, with the roll that makes them touch together if it is to be found. Raises Unsolvable
    where one misses its rail, or overlaps it too deeply at the given height, or the flanges do not fit between the rails."""
    nominal = [Facing(replace(problem.rails[side], shift_y=0.0, shift_z=0.0, roll=0.0), wheel, Position())
               for side, wheel in problem.wheels.items()]
    room = sum(map(flange_clearance, nominal))
    if len(nominal) > 1 and room < 0.0:
        backs = " and ".join(f"{1e3 * facing.wheel.flange_back:.4g}" for facing in nominal)
        raise Unsolvable(f"no room for the flanges: they overlap the rails by {-1e3 * room:.3g} mm, with their backs at "
                         f"y = {backs} mm of the outlines", "wheelset.flange_back_mm",
                         "a smaller flange_back_distance_mm or a larger gauge_mm, or y where the outline has its flange back")

    def both(roll: float) -> tuple[float, dict[SideName, Facing]]:
        facings = {side: problem.facing(side, roll) for side in problem.sides}
        heights = [facing.clearance for facing in facings.values()]
        return heights[0] - heights[-1], facings

    facings = level(both, problem.span, 0.0)[0] if problem.finds_roll else both(problem.position.roll)[1]
    clearance = min(facing.clearance for facing in facings.values())
    most = max(map(deepest, facings.values()))
    if problem.vertical is None and clearance < -most:
        raise Unsolvable(f"a wheel overlaps its rail by {-1e3 * clearance:.4g} mm, elastic contacts here by "
                         f"{1e3 * most:.3g} mm at most", "wheelset.height_mm", "a smaller number: higher")
    return {side: facing.lowered(facing.clearance) for side, facing in facings.items()}


def touching_points(facing: Facing) -> tuple[tuple[RailSide, Array], tuple[WheelSide, Array]]:
    """Rail and wheel with the points (y, z in m) of their profiles that touch first; a rail that changes is as it is there:
    below the axle it may lack what touches ahead."""
    k = int(np.argmin(facing.gap))
    outline, of_wheel = facing.outlines
    rail = facing.rail.section(float(facing.ahead[k]))
    number = (round(outline.index[k]) if rail is facing.rail else
              int(np.argmin(np.hypot(rail.samples[0] - outline.y[k], rail.samples[1] - outline.z[k]))))
    return ((rail, curve(rail.profile).samples[:2, number]),
            (facing.wheel, curve(facing.wheel.profile).samples[:2, round(of_wheel.index[k])]))


def roll_of(first: Mapping[SideName, Facing]) -> float:
    """The roll (rad) of a wheelset whose wheels touch first as in `first`."""
    side, facing = next(iter(first.items()))
    return sign_of(side) * facing.position.roll


def facts_of(problem: WheelsetProblem) -> dict[str, float]:
    """Places and angles of first contact, roll, rolling radii and the clearance of the flanges, in the units of their names."""
    facts: dict[str, float] = {}
    facings = touching(problem)
    for side, facing in facings.items():
        k = int(np.argmin(facing.gap))
        rail, wheel = facing.outlines
        at_wheel, ((_, in_rail), (_, in_wheel)) = round(wheel.index[k]), touching_points(facing)
        sign = sign_of(side)
        facts |= {
            f"first_contact_y_{side}_mm": 1e3 * sign * float(rail.y[k]),
            f"first_contact_y_rail_{side}_mm": 1e3 * float(in_rail[0]),
            f"first_contact_y_wheel_{side}_mm": 1e3 * float(in_wheel[0]),
            f"first_contact_angle_{side}_mrad": 1e3 * sign * float(facing.angle[k]),
            f"rolling_radius_{side}_mm": 1e3 * float(facing.wheel.samples[1][at_wheel]),
            f"flange_clearance_{side}_mm": 1e3 * flange_clearance(facing),
        }  # fmt: skip
    facts["first_contact_roll_mrad"] = 1e3 * roll_of(facings)
    facts["first_contact_height_mm"] = 1e3 * next(iter(facings.values())).position.z
    if len(facings) == 2:
        facts["rolling_radius_difference_mm"] = facts["rolling_radius_right_mm"] - facts["rolling_radius_left_mm"]
    return facts


def flange_clearance(facing: Facing) -> float:
    """Way (m) to the side that is left between flange and rail at the gauge height, of a wheelset without roll and yaw at its
    nominal height; negative where the flange climbs, nan without a flange or a rail there."""
    rail, wheel = facing.rail, facing.wheel
    face = rail.samples[0][rail.samples[1] <= rail.gauge_height]
    y, r = wheel.samples[:2]
    flange = y[r >= wheel.radius + rail.gauge_height]
    return float(face.min()) - float(flange.max()) - facing.position.y if len(flange) and len(face) else math.nan


def gauge_side_warnings(problem: WheelsetProblem) -> Iterator[str]:
    """Rails that are not known down to the gauge height on their gauge side."""
    for side, rail in problem.rails.items():
        y, z = rail.samples[:2]
        top = int(np.argmin(z))
        gauge, field = (float((z[there] - z[top]).max()) for there in (y <= y[top], y >= y[top]))
        if gauge < rail.gauge_height and rail.origin is None:
            advice = ": mirror = true in the table of its profile exchanges the sides" if field >= rail.gauge_height else ""
            yield (f"the {side} rail is known down to {1e3 * gauge:.3g} mm below its top on the gauge side, and to "
                   f"{1e3 * field:.3g} mm on the other{advice}; the gauge is measured at {1e3 * rail.gauge_height:g} mm, and "
                   "the least y stands for the gauge point")


def hollow_of(wheel: WheelSide) -> tuple[float, float]:
    """By how much (m) the radius rises again from the flange to the field side, and the profile's y of the highest place there
    (m)."""
    y, z = curve(wheel.profile).to_the_field_side
    tread = slice(int(np.argmax(z)), None)
    rise = z[tread] - np.minimum.accumulate(z[tread])
    return float(rise.max()), float(y[tread][int(np.argmax(rise))])


def wheelset_warnings(problem: WheelsetProblem, first: Mapping[SideName, Facing] | None = None) -> Iterator[str]:
    """Warnings that need no solution; `first` is touching(problem), if it is known. Raises Unsolvable where a wheel misses its
    rail."""
    for table in problem.without_effect:
        yield f"[{table}] has no effect: the {problem.sides[0]} wheel alone is solved"
    yield from gauge_side_warnings(problem)
    facings = first or touching(problem)
    clearance = min(facing.position.z for facing in facings.values()) - problem.position.z
    if problem.vertical is None and clearance >= 0.0:
        yield f"no wheel touches its rail: {1e3 * clearance:.4g} mm are left"
    for side, facing in facings.items():
        hollow, y = hollow_of(facing.wheel)
        if hollow > HOLLOW:
            yield (f"the tread of the {side} wheel is hollow: its field side is {1e3 * hollow:.3g} mm higher at y = "
                   f"{1e3 * y:.4g} mm, so that contacts jump between flange and field side")
        k = int(np.argmin(facing.gap))
        for (what, own), (body, here) in zip((("rail", facing.rail), ("wheel", facing.wheel)), touching_points(facing),
                                             strict=True):
            profile, shape = body.profile, curve(body.profile)
            for corner in shape.corner_places:
                if math.dist(here, corner) < KINK_ROOM:
                    yield (f"the profile of the {side} {what} has a corner of more than 30 degrees at y = {1e3 * corner[0]:.4g}"
                           f" mm, {1e3 * math.dist(here, corner):.2g} mm from first contact: the pressure there has no upper "
                           "bound")
            yield from rough_warning(f"{side} {what}", [point for point in profile if math.dist(point, here) < ROUGH_REACH])
            modulus, place = problem.contact.contact_modulus, (float(here[0]), float(here[1]))
            for rounding in own.roundings_at(float(facing.ahead[k]), place, ROUGH_REACH):
                yield from rounding_warning(f"{side} {what}", rounding, modulus, ROUGH_REACH, ROUNDED * modulus)

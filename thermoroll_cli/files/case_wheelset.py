"""A wheelset on a track as tables of a case, and the problem that they describe.

Profiles are outlines here, in the frame of railway programs: points [y, z] in order along the surface, y to the field side, z
down."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Literal

from pydantic import AllowInfNan, Field, WithJsonSchema

from thermoroll_cli.files.case_surface import Parts, surface_of
from thermoroll_cli.files.case_table import Allowed, LengthUnit, Pair, Table, pairs, quantity, signed_length, unit_key
from thermoroll_cli.files.profile_file import running_surface
from thermoroll_cli.many_contacts.wheelset.curves import Points, smoothed
from thermoroll_cli.many_contacts.wheelset.kinematics import MotionOfWheelset
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, Roller, WheelSide
from thermoroll_cli.many_contacts.wheelset.slices import Slices
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem
from thermoroll_cli.problem.problem import BodyName, Problem
from thermoroll_cli.problem.rounding import MeasuredOutline, steps_of
from thermoroll_cli.problem.surface import Heights

CurveRadius = Annotated[
    float, AllowInfNan(True), signed_length(1.0, 1e9),
    WithJsonSchema({"type": ["number", "null"]}),
    Allowed("a number of either sign (positive to the right), 1 to 1e9 in magnitude, or inf (straight), in m"),
]  # fmt: skip


ALL_AROUND = 1.5 * math.pi
"""Angle between the first and the last slice of a wheel from which on they are all around it."""


_Slice = Annotated[list[float | str], Field(min_length=2, max_length=2)]


class SliceTable(Table):
    """One slice of a rail or a wheel that changes along rolling."""

    at: float = Field(description="Place along the track in mm, or angle of the wheel in degrees", ge=-1e7, le=1e7)
    points_mm: list[Pair] = pairs("[y, z] of numbers in mm", "As of an outline", least=2, needed=True)
    features_mm: list[float] | None = Field(
        default=None, description="Arc lengths that belong together in all slices; -1 where a part is missing", min_length=2,
        max_length=100)


class OutlineTable(Table):
    """Outline of a rail or a wheel: points, or a file of them; or slices along the track, or around the wheel."""

    points_mm: list[Pair] | None = pairs("[y, z] of numbers in mm",
                                         "[y, z] in mm in order along the surface, y to the field side, z down", least=2)
    file: Annotated[str | None, Allowed("the name of a .prr, .prw, .ban or .whl file, of one with two columns, or of a list of "
                                        "slices, .slcs or .slcw")] = Field(
        default=None, max_length=1000, description="Simpack's .prr or .prw, MiniProf's .ban or .whl, two columns y and z in "
        "mm, or slices, .slcs or .slcw")
    slices: Annotated[list[_Slice] | None,
                      Allowed("a list of pairs [place, file], places increasing: mm along the track, or degrees around the "
                              "wheel")] = Field(
        default=None, description="[place in mm along the track or in degrees around the wheel, file of the outline there]",
        min_length=1, max_length=1000)
    sections: list[SliceTable] | None = Field(default=None, description="Slices with their points, as they are read from files",
                                              min_length=1, max_length=1000)
    control_points: bool | None = Field(default=None, description="Slices are control points of splines along rolling, which "
                                        "smooth what changes from slice to slice; else the surface goes through them")
    unit: LengthUnit | None = unit_key("the file; else as it says, or mm")
    height_unit: LengthUnit | None = unit_key("its second column, if that differs")
    side: Literal["left", "right"] | None = Field(default=None, description="Side, of a file that has both; the right one if "
                                                  "left out")
    mirror: bool | None = Field(default=None, description="Change the sign of y, of a profile of the other side; given either "
                                "way, it overrules what the outline looks like")
    flip: bool | None = Field(default=None, description="Change the sign of z, of a profile that is upside down; given either "
                              "way, it overrules what the outline looks like")
    smoothing_mm: float = quantity("Wavelength of which smoothing leaves half of the amplitude; 0: none", 0.0, ge=0, le=1e3)

    @property
    def oriented(self) -> list[list[tuple[float, float]]]:
        """The points in mm of each slice, or of the only outline, with the signs that `mirror` and `flip` give them."""
        sides, out = -1.0 if self.mirror else 1.0, -1.0 if self.flip else 1.0
        outlines = [each.points_mm for each in self.sections] if self.sections else [self.points_mm] if self.points_mm else []
        return [[(sides * y, out * z) for y, z in points] for points in outlines]


Outline = Annotated[OutlineTable, Allowed("a table: points_mm or file")]


_Coordinate = Annotated[float, Field(ge=-1e4, le=1e4)]


class TrackSideTable(Table):
    """One rail, where it differs from the other."""

    rail_profile: Outline | None = Field(default=None, description="Outline of this rail")
    roller_radius_mm: float | None = quantity("Radius of the roller in place of this rail", None, ge=1, le=1e9)
    shift_y_mm: float = quantity("Shift of this rail to the field side", 0.0, ge=-1e3, le=1e3)
    shift_z_mm: float = quantity("Shift of this rail downwards", 0.0, ge=-1e3, le=1e3)
    roll_mrad: float = quantity("Roll of this rail about y = z = 0 of its outline, top to the field side", 0.0, ge=-500, le=500)
    origin_mm: Annotated[Annotated[list[_Coordinate], Field(min_length=2, max_length=2)] | None,
                         Allowed("[y, z] of numbers from -10000 to 10000")] = Field(
        default=None, description="Place of y = z = 0 of the outline, instead of gauge and top: [y to the field side from the "
        "middle of the track, z down] in mm")
    surface: Parts | None = Field(default=None, description="Heights along this rail", min_length=1, max_length=20)


class TrackTable(Table):
    """Two rails."""

    rail_profile: Outline | None = Field(default=None, description="Outline of both rails")
    gauge_mm: float = quantity("Distance between the rails", 1435.0, ge=100, le=1e4)
    gauge_height_mm: float = quantity("Depth below the top of the rails at which the gauge is measured", 14.0, ge=0, le=100)
    cant: float = quantity("Inclination of the rails inwards, 0.025 for 1:40", 0.0, ge=-0.5, le=0.5)
    curve_radius_m: CurveRadius | None = quantity("Radius of the curve, positive to the right; straight if left out", None)
    roller_radius_mm: float | None = quantity("Radius of the top of rollers in place of the rails; straight rails if left out",
                                              None, ge=1, le=1e9)
    roller_angular_velocity_rad_s: float | None = quantity("Angular velocity of the rollers; that of rolling.speed_m_s if left "
                                                           "out", None, ge=1e-9, le=1e6)
    surface: Parts | None = Field(default=None, description="Heights along both rails, upwards", min_length=1, max_length=20)
    left: TrackSideTable | None = Field(default=None, description="The left rail, where it differs")
    right: TrackSideTable | None = Field(default=None, description="The right rail, where it differs")


class WheelTable(Table):
    """One wheel, where it differs from the other."""

    wheel_profile: Outline | None = Field(default=None, description="Outline of this wheel")
    nominal_radius_mm: float | None = quantity("Radius of this wheel at z = 0 of its outline", None, ge=1, le=1e5)
    flange_back_mm: float | None = quantity("y of the flange back in the outline of this wheel", None, ge=-1e3, le=1e3)
    surface: Parts | None = Field(default=None, description="Heights around this wheel", min_length=1, max_length=20)


class WheelsetTable(Table):
    """A wheelset: its profiles, position, load and motion. Roll, height and angular velocity are solved for if left out."""

    wheel_profile: Outline | None = Field(default=None, description="Outline of both wheels")
    nominal_radius_mm: float = quantity("Radius of the wheels at z = 0 of their outlines", ge=1, le=1e5)
    flange_back_distance_mm: float = quantity("Distance between the backs of the flanges", 1360.0, ge=100, le=1e4)
    flange_back_mm: float = quantity("y of the flange back in the outline", -70.0, ge=-1e3, le=1e3)
    wheels: Literal["both", "left", "right"] = Field(default="both", description="Wheels that are solved")
    lateral_shift_mm: float = quantity("Shift of the wheelset to the right", 0.0, ge=-1e3, le=1e3)
    longitudinal_shift_mm: float = quantity("Shift of the wheelset forward over rollers", 0.0, ge=-1e3, le=1e3)
    position_mm: float = quantity("Place of the axle along a track that changes; over time where distance_mm is 0", 0.0,
                                  ge=-1e7, le=1e7)  # fmt: skip
    rotation_deg: float = quantity("Angle of a wheel that changes around itself: what stands below the axle; over time where "
                                   "distance_mm is 0", 0.0, ge=-1e7, le=1e7)  # fmt: skip
    yaw_mrad: float = quantity("Yaw, right wheel backwards", 0.0, ge=-500, le=500)
    roll_mrad: float | None = quantity("Roll, right wheel down; of both wheels found if left out", None, ge=-500, le=500)
    vertical_N: float | None = quantity("Vertical load of the wheelset, or of the wheel if there is one", None, ge=1e-6, le=1e9)
    height_mm: float | None = quantity("Height of the axle below its nominal one, down; instead of the load", None,
                                       ge=-1e3, le=1e3)
    angular_velocity_rad_s: float | None = quantity("Angular velocity, forward; found if left out", None, ge=-1e6, le=1e6)
    traction_N: float | None = quantity("Force of the rails on the wheelset, forward; left out: no torque about the axle",
                                        None, ge=-1e9, le=1e9)  # fmt: skip
    longitudinal_velocity_mm_s: float = quantity("Velocity of the wheelset forward over rollers", 0.0, ge=-1e6, le=1e6)
    lateral_velocity_mm_s: float = quantity("Velocity of the wheelset to the right", 0.0, ge=-1e6, le=1e6)
    vertical_velocity_mm_s: float | None = quantity("Velocity of the wheelset down; left out, that with which it follows rails "
                                                    "and wheels that rise and fall", None, ge=-1e6, le=1e6)
    roll_rate_mrad_s: float = quantity("Rate of the roll", 0.0, ge=-1e6, le=1e6)
    yaw_rate_mrad_s: float = quantity("Rate of the yaw", 0.0, ge=-1e6, le=1e6)
    patches: Literal["curved", "planar"] = Field(
        default="curved",
        description="Patches follow the surface; or each lies in its own plane and is alone, as in other programs",
    )
    contact_distance_mm: float = quantity("Distance between the contacts of both wheels, for the conicity", 1500.0,
                                          ge=100, le=1e4)  # fmt: skip
    surface: Parts | None = Field(default=None, description="Heights around both wheels, along their radius", min_length=1,
                                  max_length=20)  # fmt: skip
    left: WheelTable | None = Field(default=None, description="The left wheel, where it differs")
    right: WheelTable | None = Field(default=None, description="The right wheel, where it differs")


def wheelset_of(
    track: TrackTable, wheelset: WheelsetTable, contact: Problem, friction: Mapping[SideName, Points]
) -> WheelsetProblem:
    """The wheelset that both tables describe; `contact` has everything else but `friction` over the inclination of a rail."""
    names: tuple[SideName, ...] = SIDES if wheelset.wheels == "both" else (wheelset.wheels,)
    finds_speed = wheelset.angular_velocity_rad_s is None
    known: dict[tuple[int, float], Heights | None] = {}

    def surface(table: TrackTable | WheelsetTable, side: SideName, body: BodyName, radius: float) -> Heights | None:
        own = getattr(table, side)
        parts = (own and own.surface) or table.surface
        if (id(parts), radius) not in known:
            known[id(parts), radius] = surface_of(parts, body, 1e3 * radius)
        return known[id(parts), radius]

    rails = {side: replace(_rail(track, getattr(track, side), contact.motion.speed, wheelset.si("position_mm")),
                           friction=friction.get(side, ())) for side in names}
    rails = {side: replace(rail, surface=surface(track, side, "lower", rail.roller.radius if rail.roller else math.inf))
             for side, rail in rails.items()}
    wheels = {side: _wheel(wheelset, getattr(wheelset, side)) for side in names}
    wheels = {side: replace(wheel, surface=surface(wheelset, side, "upper", wheel.radius)) for side, wheel in wheels.items()}
    speeds = [rail.roller.turning * rail.roller.radius for rail in rails.values() if rail.roller]
    return WheelsetProblem(
        contact=contact,
        rails=rails,
        wheels=wheels,
        position=Position(wheelset.si("lateral_shift_mm"), wheelset.si("height_mm") or 0.0, wheelset.si("roll_mrad") or 0.0,
                          wheelset.si("yaw_mrad"), wheelset.si("longitudinal_shift_mm")),
        motion=MotionOfWheelset(
            max(speeds, default=contact.motion.speed), None if finds_speed else -(wheelset.angular_velocity_rad_s or 0.0),
            wheelset.si("lateral_velocity_mm_s"), wheelset.si("vertical_velocity_mm_s") or 0.0, wheelset.si("roll_rate_mrad_s"),
            wheelset.si("yaw_rate_mrad_s"), 1.0 / (track.curve_radius_m or math.inf),
            wheelset.si("longitudinal_velocity_mm_s"), wheelset.vertical_velocity_mm_s is None),
        vertical=wheelset.vertical_N,
        finds_roll=wheelset.roll_mrad is None and len(names) == 2,
        finds_speed=finds_speed,
        traction=wheelset.traction_N,
        curved=wheelset.patches == "curved",
        contact_distance=wheelset.si("contact_distance_mm"),
        without_effect=tuple(f"{name}.{side}" for name, table in (("wheelset", wheelset), ("track", track)) for side in SIDES
                             if side not in names and getattr(table, side) is not None),
    )  # fmt: skip


def _rail(track: TrackTable, own: TrackSideTable | None, speed: float, along: float) -> RailSide:
    """A rail with the axle at the place `along` (m) of its slices, or a roller whose top moves with `speed` (m/s) if its
    angular velocity is not given."""
    profile = (own and own.rail_profile) or track.rail_profile
    assert profile is not None
    moved = {} if own is None else {name: own.si(key) for name, key in (
        ("shift_y", "shift_y_mm"), ("shift_z", "shift_z_mm"), ("roll", "roll_mrad"))}
    slices = slices_of(profile)
    points, measured = (slices.outline_at(along), None) if slices else outline_of(profile, wheel=False)
    radius = (own and own.si("roller_radius_mm")) or track.si("roller_radius_mm")
    placed = RailSide(points, track.cant, 0.5 * track.si("gauge_mm"), track.si("gauge_height_mm"), measured=measured,
                      slices=slices, along=along, **moved)
    if radius:
        placed = replace(placed, roller=Roller(radius, track.roller_angular_velocity_rad_s or speed / radius))
    if own is None or own.origin_mm is None:
        return placed
    return replace(placed, origin=(1e-3 * own.origin_mm[0], 1e-3 * own.origin_mm[1]))


def _wheel(wheelset: WheelsetTable, own: WheelTable | None) -> WheelSide:
    profile = (own and own.wheel_profile) or wheelset.wheel_profile
    assert profile is not None
    radius, back = (wheelset.si(key) if own is None or own.si(key) is None else own.si(key)
                    for key in ("nominal_radius_mm", "flange_back_mm"))
    slices, angle = slices_of(profile, radius), math.radians(wheelset.rotation_deg)
    points, measured = (slices.outline_at(angle), None) if slices else outline_of(profile, wheel=True)
    return WheelSide(points, radius, 0.5 * wheelset.si("flange_back_distance_mm"), back, measured,
                     slices, angle)


def outline_of(table: OutlineTable, *, wheel: bool) -> tuple[Points, MeasuredOutline]:
    """The outline of a rail or a `wheel` in m, mirrored, turned and smoothed as the table says, of a closed section the running
    surface; and how its points were before."""
    return _outline(table.oriented[0], table.si("smoothing_mm"), wheel=wheel)


def _outline(oriented: list[tuple[float, float]], wavelength: float, *, wheel: bool) -> tuple[Points, MeasuredOutline]:
    surface = running_surface(oriented, wheel=wheel)
    points = tuple((y / 1e3, z / 1e3) for y, z in surface)
    across, down = steps_of(surface)
    measured = MeasuredOutline(points, (across / 1e3, down / 1e3), wavelength)
    return (smoothed(points, wavelength) if wavelength else points), measured


def slices_of(table: OutlineTable, radius: float | None = None) -> Slices | None:
    """The slices of a rail, or of a wheel of this `radius` (m), each as of `outline_of`, at places in m or rad; None without
    them, or where all are the same: that is one outline."""
    if not table.sections:
        return None
    wheel, wavelength = radius is not None, table.si("smoothing_mm")
    outlines, measured = zip(*(_outline(points, wavelength, wheel=wheel) for points in table.oriented), strict=True)
    missing = any(mark < 0.0 for each in table.sections for mark in each.features_mm or ())
    if not missing and all(outline == outlines[0] for outline in outlines):
        return None
    at = tuple(math.radians(each.at) if wheel else each.at / 1e3 for each in table.sections)
    features = tuple(tuple(mark / 1e3 for mark in each.features_mm or ()) for each in table.sections)
    return Slices(at, outlines, features if features[0] else (), wheel and at[-1] - at[0] > ALL_AROUND,
                  bool(table.control_points), measured, radius or 1.0)

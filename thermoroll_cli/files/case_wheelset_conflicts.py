"""Conflicts between the keys of a case of a wheelset on its track, and of one over time."""

from __future__ import annotations

from collections.abc import Iterator

from thermoroll_cli.files.case_conflicts import FLANGE, Conflict, Sections, materials_of
from thermoroll_cli.files.case_errors import Fault, KeyPath
from thermoroll_cli.files.case_history import HistoryTable
from thermoroll_cli.files.case_surface import given_surfaces
from thermoroll_cli.files.case_wheelset import TrackTable, WheelsetTable
from thermoroll_cli.files.profile_file import outline_fault, running_surface
from thermoroll_cli.many_contacts.history.course import OF_WHEELSETS, PATH, SPEED
from thermoroll_cli.many_contacts.history.history_plan import FIRST
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName

BACK_TO_TIP, BACK_TOLERANCE = 20.0, 3.0
"""Of the outline of a wheel in mm: from the flange's back to where an outline without it may begin, at the tip; how far an
outline may go on beyond the given back."""


def sides_of(wheelset: WheelsetTable) -> tuple[SideName, ...]:
    """The sides that have a wheel."""
    return SIDES if wheelset.wheels == "both" else (wheelset.wheels,)


def wheelset_conflicts(sections: Sections) -> Iterator[Conflict]:
    """Conflicts of a wheelset whose tables are valid."""
    track, wheelset = sections.get("track"), sections.get("wheelset")
    if sections.get("surface") is not None:
        yield Conflict(("surface",), "is of one contact", "[track.surface] and [wheelset.surface], over time", at_key=True)
    if track is not None and wheelset is not None:
        yield from _placed(track, wheelset)
        yield from _slices(track, wheelset)
    for path, material in materials_of(sections) if wheelset is not None else ():
        layers = enumerate(material.layers or ())
        for place, constants in ((path, material), *(((*path, "layers", number), layer) for number, layer in layers)):
            if constants.relaxation:
                yield Conflict((*place, "relaxation"), "is not computed for wheelsets", "elastic wheels and rails", at_key=True)


def _placed(track: TrackTable, wheelset: WheelsetTable) -> Iterator[Conflict]:
    """Outlines of all sides, and quantities that are found or given."""
    sides = sides_of(wheelset)
    for table, path, name in ((track, "track", "rail_profile"), (wheelset, "wheelset", "wheel_profile")):
        own = [side for side in SIDES if getattr(getattr(table, side), name, None) is not None]
        if getattr(table, name) is None:
            yield from (Conflict((path, name), f"is missing: the {side} side has none of its own", "a table: points_mm or file",
                                 at_key=True) for side in sides if side not in own)
        for place in ((path, name), *((path, side, name) for side in own)):
            outline = getattr(table if len(place) == 2 else getattr(table, place[1]), name)
            if outline is None:
                continue
            if outline.points_mm is None and not outline.sections:
                yield Conflict(place, "has neither points_mm nor file nor slices", "one of points_mm, file and slices",
                               at_key=True)
                continue
            if outline.sections and outline.points_mm:
                yield Conflict((*place, "sections"), "cannot be given together with points_mm", "one of both", at_key=True)
            if outline.control_points and not outline.sections:
                yield Conflict((*place, "control_points"), "the outline has no slices", "slices, or left out")
            if len({len(each.features_mm or ()) for each in outline.sections or ()}) > 1:
                yield Conflict((*place, "sections"), "features_mm are not as many in each slice", "as many in each, or none",
                               at_key=True)
            surface = running_surface(outline.oriented[0], wheel=path == "wheelset")
            faults = (outline_fault(points, wheel=path == "wheelset", mirror=outline.mirror, flip=outline.flip)
                      for points in outline.oriented)
            fault, hint = next((found for found in faults if found[0]), ("", ""))
            if fault:
                yield Conflict(place, fault, "an outline [y, z] in mm, y to the field side, z down", hint, at_key=True)
            elif path == "wheelset" and max(z for _, z in surface) > FLANGE:
                yield from _flange_backs(wheelset, place, min(y for y, _ in surface))
    rollers = [track.roller_radius_mm or getattr(getattr(track, side), "roller_radius_mm", None) for side in sides]
    if any(rollers) and not all(rollers):
        yield Conflict(("track", "roller_radius_mm"), "is missing: one side has a rail, the other one a roller", "two rollers",
                       at_key=True)
    if any(rollers) and track.curve_radius_m is not None:
        yield Conflict(("track", "curve_radius_m"), "rollers are no curve", "a straight track",
                       other=("track", "roller_radius_mm"))
    if track.roller_angular_velocity_rad_s is not None and not any(rollers):
        yield Conflict(("track", "roller_angular_velocity_rad_s"), "there is no roller", "roller_radius_mm beside it")
    for key in ("longitudinal_shift_mm", "longitudinal_velocity_mm_s"):
        if getattr(wheelset, key) and not any(rollers):
            yield Conflict(("wheelset", key), "a wheelset on straight rails travels, at any place with the rolling speed",
                           "0, or rollers (track.roller_radius_mm)")
    if wheelset.vertical_N is None and wheelset.height_mm is None:
        yield Conflict(("wheelset", "vertical_N"), "is missing", "a vertical load, or height_mm", at_key=True)
    if wheelset.height_mm is not None and wheelset.roll_mrad is None and len(sides) == 2:
        yield Conflict(("wheelset", "roll_mrad"),
                       "is missing: it is found from the loads of both wheels, and height_mm gives none",
                       "roll_mrad beside height_mm, or vertical_N", at_key=True, other=("wheelset", "height_mm"))
    if (wheelset.angular_velocity_rad_s or 1.0) < 0.0:
        yield Conflict(("wheelset", "angular_velocity_rad_s"), "the wheelset turns backwards", "a positive number: forward")


def _flange_backs(wheelset: WheelsetTable, place: KeyPath, begin: float) -> Iterator[Conflict]:
    """Flange backs, of the wheels with the outline at `place`, that are not where it begins (mm)."""
    backs: dict[KeyPath, float] = {}
    for side in SIDES:
        own = getattr(wheelset, side)
        if place != (("wheelset", side, "wheel_profile") if own and own.wheel_profile else ("wheelset", "wheel_profile")):
            continue
        if own and own.flange_back_mm is not None:
            backs["wheelset", side, "flange_back_mm"] = own.flange_back_mm
        else:
            backs["wheelset", "flange_back_mm"] = wheelset.flange_back_mm
    for key, back in backs.items():
        if not begin - BACK_TO_TIP <= back <= begin + BACK_TOLERANCE:
            yield Conflict(key, f"{back:g} mm is no y of the flange back of {'.'.join(map(str, place))}, which begins at "
                           f"y = {begin:.4g} mm", f"{begin - BACK_TO_TIP:.4g} to {begin + BACK_TOLERANCE:.4g} for this outline",
                           f"it may stand in [wheelset.{place[1]}], too" if len(place) == 3 and len(key) == 2 else "",
                           at_key=True, other=place)


def _slices(track: TrackTable, wheelset: WheelsetTable) -> Iterator[Conflict]:
    """What does not go with profiles that change along rolling, and what needs them."""
    varied = {name for name, key, tables in (("track", "rail_profile", (track, track.left, track.right)),
                                             ("wheelset", "wheel_profile", (wheelset, wheelset.left, wheelset.right)))
              for each in tables if (given := getattr(each, key, None)) is not None and given.sections}
    rolling = {given.path[0] for given in given_surfaces({"track": track, "wheelset": wheelset})}
    if varied and any(side is not None and side.roller_radius_mm for side in (track, track.left, track.right)):
        yield Conflict(("track", "roller_radius_mm"), "rollers, and wheels on them, have no slices", "rails, or one outline",
                       at_key=True)
    for key, name, what in (("position_mm", "track", "the rails are the same everywhere"),
                            ("rotation_deg", "wheelset", "the wheels are round")):
        if getattr(wheelset, key) and name not in {*varied, *rolling}:
            yield Conflict(("wheelset", key), what, f"0, or slices of a profile of [{name}], or over time [{name}.surface]")


def values_of_wheelset(sections: Sections, history: HistoryTable) -> Iterator[Fault]:
    """What is wrong with the values of keys of a wheelset."""
    path, track, rolling = ("history", "values"), sections.get("track"), sections.get("rolling")
    wheelset = sections.get("wheelset")
    rollers = [side for side in (track, getattr(track, "left", None), getattr(track, "right", None))
               if side is not None and side.roller_radius_mm]
    rates = {f"wheelset.{rate}": key for rate, key in zip(
        ("lateral_velocity_mm_s", "vertical_velocity_mm_s", "roll_rate_mrad_s", "yaw_rate_mrad_s"), PATH, strict=True)}
    for key in history.values:
        if key not in OF_WHEELSETS:
            yield path, f"{key} of a wheelset cannot change over time", ", ".join(OF_WHEELSETS)
        elif key == SPEED and rollers:
            yield path, f"{key} cannot change on rollers", "wheelset.angular_velocity_rad_s, or a track"
    for rate, key in rates.items():
        if key in history.values and (rate in history.values or getattr(wheelset, rate.removeprefix("wheelset."), None)):
            yield (path if rate in history.values else tuple(rate.split(".")), f"{rate} follows from the path, {key}",
                   "one of both")
    if rolling is not None and rolling.speed_m_s == 0.0:
        yield ("rolling", "speed_m_s"), "is 0, but a wheelset over time rolls", "a speed above 0"
    if sections.get("subsurface") is not None:
        yield ("subsurface",), "is not computed for wheelsets over time", "one contact, or a case without [history]"
    if history.fields_every:
        yield ("history", "fields_every"), "is of a single contact: of a wheelset the last row has fields", "0"
    numerics = sections.get("numerics")
    if numerics is not None and (numerics.accuracy is not None or numerics.accuracy_of):
        yield ("numerics", "accuracy"), "is not looked for over time by wheelsets", f"numerics.grid; {FIRST} if left out"

"""Conflicts between the keys of a case, beyond the range of each key and the pairs in `case_model.EXCLUSIVE`. Whether the
problem that a case describes can be solved is decided in `steady_state.solvable`."""

from __future__ import annotations

import inspect
import math
import statistics
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from itertools import chain, pairwise
from typing import Any, NamedTuple

from thermoroll_cli.files import case_model as model
from thermoroll_cli.files.case_errors import Fault, KeyPath
from thermoroll_cli.files.case_history import STATES, HistoryTable, history_faults
from thermoroll_cli.files.case_line import LOAD, PRESSURE, is_line, line_faults
from thermoroll_cli.files.case_model import THERMAL_CONSTANTS, MaterialTable, ProfileTable, TwoMaterials
from thermoroll_cli.files.case_problem import profile_of
from thermoroll_cli.files.case_surface import surface_faults
from thermoroll_cli.files.profile_file import point_fault
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES
from thermoroll_cli.problem.friction import FORMULAS, LAW_CONSTANTS
from thermoroll_cli.problem.kinds import Kind
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    GROUPS,
    LINE_SCALARS,
    SCALARS,
    SUBSURFACE_SCALARS,
)
from thermoroll_cli.problem.problem import BODIES

Sections = Mapping[str, Any]
"""The tables of a case that are valid by themselves, as models of `case_model`; None for a table left out."""

CROWN = ("length_mm", "drop_um", "flat_mm")
FLANGE, TREAD = 10.0, 70.0
"""Of the outline of a wheel in mm: z beyond which it has a flange; from the flange's back to the middle of the tread."""

LEAST_COEFFICIENT = 1e-12
"""Coefficient of friction below which arithmetic overflows; 0 is none."""


class Conflict(NamedTuple):
    """Keys that do not go together: the message stands at `path` and may refer to `other`."""

    path: KeyPath
    message: str
    allowed: str = ""
    hint: str = ""
    other: KeyPath = ()
    at_key: bool = False


def conflicts(sections: Sections, kind: Kind) -> Iterator[Conflict]:
    """Every conflict between keys whose tables are valid, of a case of this `kind`. A check has the tables that it needs as
    parameters, and is left out where one of them is missing or invalid."""
    for check, names in _checks().items():
        tables = [{**sections, "sections": sections, "kind": kind}.get(name) for name in names]
        if None not in tables:
            yield from check(*tables)


@cache
def _checks() -> dict[Callable[..., Iterator[Conflict]], tuple[str, ...]]:
    """Each check with the names of its tables, asked for once: a sweep checks every point."""
    checks = (
        _convexity, _vertical_force, _hertz_pressure, _profiles,
        _friction_places, _friction_law, _interlayer, _thermal_constants, _coatings,
        _relaxation,
        _bulk_temperatures, _recirculation, _strength, _subsurface, _wear, _of_kind, _line, _speed,
        _accuracy_of, _surface)  # fmt: skip
    return {check: tuple(inspect.signature(check).parameters) for check in checks}


def heat_is_on(sections: Sections) -> bool:
    """Whether a case asks for heat: by saying so, or by giving thermal constants without a [thermal] table."""
    thermal = sections["thermal"]
    if thermal is not None:
        return bool(thermal.heat)
    return any(getattr(material, key) is not None for _, material in materials_of(sections) for key in THERMAL_CONSTANTS)


def _convexity(sections: Sections, geometry: model.GeometryTable) -> Iterator[Conflict]:
    for axis in "xy":
        lower_key, upper_key = (f"{body}_radius_{axis}_mm" for body in BODIES)
        lower, upper = getattr(geometry, lower_key), getattr(geometry, upper_key)
        if lower is None or upper is None or (curvature := 1.0 / lower + 1.0 / upper) > 0.0:
            continue
        if math.isinf(lower) and math.isinf(upper):
            if axis == "y" and is_line(sections):
                continue
            reason, hint = "both bodies are flat", "give one body a finite radius" + (
                f", or a load per length, {LOAD}, or a pressure, {PRESSURE}, for a line contact" if axis == "y" else "")
        else:
            reason = f"1/{lower:g} + 1/{upper:g} = {curvature:.4g} 1/mm"
            hint = "a concave radius must be larger than the convex radius of the other body"
        yield Conflict(("geometry", upper_key if upper < 0 <= lower else lower_key),
                       f"convexity lost along {axis}: {reason} (geometry.{lower_key}, geometry.{upper_key})",
                       f"1/{lower_key} + 1/{upper_key} > 0", hint)


def _vertical_force(geometry: model.GeometryTable, load: model.LoadTable) -> Iterator[Conflict]:
    if load.vertical_N is not None and not geometry.conformal:
        yield Conflict(("load", "vertical_N"), "is of a conformal contact: in a plane it is the normal load", "normal_N, or "
                       "geometry.conformal = true", at_key=True)


def _hertz_pressure(sections: Sections, geometry: model.GeometryTable, load: model.LoadTable) -> Iterator[Conflict]:
    """A pressure says what the load is where Hertz's theory holds."""
    if load.hertz_pressure_MPa is None:
        return
    layered = any(table.layers or table.relaxation or table.relaxation_file for _, table in materials_of(sections))
    why = "a conformal contact" if geometry.conformal else "profiles" if geometry.lower_profile or geometry.upper_profile else (
        "bodies with coatings, or that relax" if layered else "")
    if why:
        yield Conflict(("load", "hertz_pressure_MPa"), f"is Hertz's pressure of smooth elastic bodies, not of {why}",
                       "normal_N, or another load", at_key=True)


def _profiles(sections: Sections, geometry: model.GeometryTable) -> Iterator[Conflict]:
    given = {"lower_profile": geometry.lower_profile, "upper_profile": geometry.upper_profile}
    profiles = {name: profile for name, profile in given.items() if profile is not None}
    faults = [fault for name, profile in profiles.items() for fault in _profile(("geometry", name), profile)]
    yield from faults
    if faults or not profiles:
        return
    rolling = sections.get("rolling")
    for name, profile in profiles.items():
        shape = profile_of(profile)
        low, high = (1e3 * end for end in shape.ends)
        if rolling is not None and rolling.differential_slip and not low < 0.0 < high:
            # The tread of a wheel with a flange lies 70 mm from its back; other bodies touch with their highest place first.
            heights = dict(shape.points) or {0.0: 0.0}
            flanged = max(heights.values()) - statistics.median(heights.values()) > 1e-3 * FLANGE
            there = low + TREAD if flanged else 1e3 * (max(heights, key=lambda y: heights[y]) + shape.offset)
            yield Conflict(("geometry", name), "has no material at y = 0, from where differential slip is measured: it reaches "
                           f"from {low:g} to {high:g} mm", "a profile around y = 0, or differential_slip = false in [rolling]",
                           f"offset_mm = {profile.offset_mm - there:.4g} in its table brings " + (
                               "the tread, 70 mm from the flange back," if flanged else "its highest place") + " to y = 0",
                           at_key=True)


def _accuracy_of(numerics: model.NumericsTable, sections: Sections, kind: Kind) -> Iterator[Conflict]:
    """Scalars that are to be accurate, and that the case does not have."""
    if numerics.accuracy_of is None:
        return
    heated = "thermal" in sections and heat_is_on(sections)
    missing = {"temperatures": not heated, "wear": sections.get("wear") is None}
    there = (LINE_SCALARS if is_line(sections) else SCALARS) | (
        {} if sections.get("subsurface") is None else SUBSURFACE_SCALARS) | (
        dict(kind.answer.scalars))
    groups = [group for group in GROUPS if not missing.get(group)]
    without = {name for group in GROUPS if missing.get(group) for name in GROUPS[group]}
    if not heated:
        without |= {name for name, scalar in there.items() if scalar.kind == "exchanged heat"}
    names = [name for name, scalar in there.items()
             if name not in without and (scalar.kind or name not in SCALARS | LINE_SCALARS)]
    path, allowed = ("numerics", "accuracy_of"), f"{', '.join(groups)}, or scalars: {', '.join(names)}"
    if not numerics.accuracy_of:
        yield Conflict(path, "is empty", allowed)
    for name in numerics.accuracy_of:
        if name not in groups and name not in names:
            why = "of this case" if name in GROUPS or name in ALL_SCALARS else "at all"
            yield Conflict(path, f'"{name}" is no scalar {why}, and no group of them', allowed)


def _of_kind(sections: Sections, kind: Kind) -> Iterator[Conflict]:
    yield from kind.conflicts(sections)


def _profile(path: KeyPath, profile: ProfileTable) -> Iterator[Conflict]:
    """Conflicts within one profile."""
    sources = "one of points_mm, file and kind"
    if profile.points_mm is None and profile.file is None and profile.kind is None:
        yield Conflict(path, "has neither points_mm nor file nor kind", sources, at_key=True)
    elif profile.kind is None:
        yield from (Conflict((*path, key), "belongs to a crown, with kind", sources) for key in CROWN
                    if getattr(profile, key) is not None)
    else:
        yield from (Conflict((*path, "kind"), f"a crown needs {key}", "length_mm and drop_um with kind") for key in CROWN[:2]
                    if getattr(profile, key) is None)
        if profile.length_mm is not None and profile.flat_mm is not None and profile.flat_mm >= profile.length_mm:
            yield Conflict((*path, "flat_mm"), "the flat part is as long as the crown",
                           f"less than length_mm = {profile.length_mm:g}")
    points = profile.points_mm or []
    for number, fault in enumerate((point_fault(points, k) for k in range(len(points))), 1):
        if fault:
            yield Conflict((*path, "points_mm"), f"point {number}: {fault}", "pairs [y, height] with y increasing")
            return


def _friction_places(
    friction: model.FrictionTable, load: model.LoadTable, sections: Sections, kind: Kind
) -> Iterator[Conflict]:
    """Coefficients of friction of places, and the one of all that is missing."""
    geometry, rails = sections.get("geometry"), kind.rails(sections)
    sides = {side: getattr(friction, side) for side in SIDES if getattr(friction, side) is not None}
    if not rails and geometry is not None:
        for key in ("over_angle", *sides):
            if getattr(friction, key) is not None:
                yield Conflict(("friction", key), "belongs to wheels on rails", "across, for bodies with profiles", at_key=True)
        if friction.across and not (geometry.lower_profile or geometry.upper_profile):
            yield Conflict(("friction", "across"), "belongs to bodies with profiles", "load.friction_coefficient, or a profile",
                           at_key=True)
    if rails and friction.across:
        yield Conflict(("friction", "across"), "belongs to one contact", "over_angle, for wheels on rails", at_key=True)
    for side, own in sides.items():
        if own.over_angle is None:
            yield Conflict(("friction", side), "is empty", "over_angle", at_key=True)
        elif rails and side not in rails:
            yield Conflict(("friction", side), f"has no effect: wheelset.wheels is {rails[0]}", '"both"', at_key=True)
    if load.friction_coefficient is None and not (
            friction.over_angle or friction.across or (rails and all(side in sides for side in rails))):
        yield Conflict(("load", "friction_coefficient"), "is missing", "0 to 10", at_key=True)
    if 0.0 < (load.friction_coefficient or 0.0) < LEAST_COEFFICIENT:
        yield Conflict(("load", "friction_coefficient"), "is too small to be computed with",
                       f"0, or {LEAST_COEFFICIENT:g} to 10")
    for path, points, end, unit in (
            (("friction", "across"), friction.across, 1e9, "mm"),
            (("friction", "over_angle"), friction.over_angle, 180.0, "degrees"),
            *((("friction", side, "over_angle"), own.over_angle, 180.0, "degrees") for side, own in sides.items())):
        yield from _curve(path, points or [], (-end, end), unit, f"increasing, from {-end:g} to {end:g} {unit}")


def _curve(
    path: KeyPath, points: list[list[float]], ends: tuple[float, float], unit: str, allowed: str,
    words: str = "coefficient", most: float = 10.0,
) -> Iterator[Conflict]:
    """The first fault of pairs [place, value]: places increase between the `ends`, values (`words`) are 0 to `most`."""
    before = -math.inf
    for number, (place, value) in enumerate(points, 1):
        if not (place > before and ends[0] <= place <= ends[1]):
            below = f" does not lie above {before:g} {unit}" if place <= before else ""
            yield Conflict(path, f"point {number}: {place:g} {unit}{below}", allowed)
            return
        if not 0.0 <= value <= most:
            yield Conflict(path, f"point {number}: {words} {value:g}", f"from 0 to {most:g}")
            return
        before = place


def _friction_law(friction: model.FrictionTable, load: model.LoadTable) -> Iterator[Conflict]:
    law = friction.law
    needed = ["table"] if law == "table" else [constant.key for constant in FORMULAS[law].constants] if law else []
    for key in (*LAW_CONSTANTS, "table"):
        given = getattr(friction, key) is not None
        if key in needed and not given:
            yield Conflict(("friction", "law"), f"{law} friction needs {key}", f"friction.{key}")
        elif given and law is None:
            yield Conflict(("friction", key), "belongs to a law of friction, and law is missing", "friction.law beside it")
        elif given and key not in needed:
            yield Conflict(("friction", key), f'does not belong to law = "{law}"', "the keys of one law")
    if law != "table" or not friction.table:
        return
    path, allowed = ("friction", "table"), "pairs [slip speed, coefficient], slip speeds increasing from 0"
    (first, coefficient), at_rest = friction.table[0], model.coefficient_at_rest(load, friction)
    if first != 0.0:
        yield Conflict(path, f"begins at a slip speed of {first:g} m/s", allowed)
    elif not math.isclose(coefficient, at_rest):
        of = "load.friction_coefficient" if load.friction_coefficient is not None else "the largest coefficient of all places"
        yield Conflict(path, f"has {coefficient:g} without slip, but {of} is {at_rest:g}",
                       f"the same coefficient without slip: {of} = {coefficient:g} beside this table"
                       + (", whose friction rises from zero" if coefficient == 0.0 else ""),
                       other=("load", "friction_coefficient"))
    yield from _curve(path, friction.table, (-math.inf, math.inf), "m/s", allowed)


def _interlayer(layer: model.InterlayerTable) -> Iterator[Conflict]:
    if layer.compliance_um_GPa is None and layer.yield_MPa is None:
        yield Conflict(("layer",), "has no constant", "compliance_um_GPa, yield_MPa or both", at_key=True)
    if layer.hardening_MPa_um and layer.yield_MPa is None:
        yield Conflict(("layer", "hardening_MPa_um"), "belongs to a yield stress", "layer.yield_MPa beside it")


def _thermal_constants(sections: Sections) -> Iterator[Conflict]:
    heated = "thermal" in sections and heat_is_on(sections)
    reason = "heat is on" if heated and sections["thermal"] is not None else "the other thermal constants are given"
    layers = ((((*path, "layers", number), layer) for path, body_material in materials_of(sections)
               for number, layer in enumerate(body_material.layers or ())))
    for path, constants in chain(materials_of(sections), layers):
        missing = [key for key in THERMAL_CONSTANTS if getattr(constants, key) is None]
        if missing and (heated or ("layers" in path and len(missing) < len(THERMAL_CONSTANTS))):
            yield Conflict(path, f"{reason}, but missing: {', '.join(missing)}",
                           f"all of {', '.join(THERMAL_CONSTANTS)}, or none of them and no heat",
                           "a mechanical case has heat = false in [thermal], or neither [thermal] nor thermal constants")


MOST_STIFF_ON_SOFT, MOST_SOFT_ON_STIFF = 300.0, 1e6
"""Largest ratios of the moduli of neighbours that the solvers are made for."""


def _coatings(sections: Sections) -> Iterator[Conflict]:
    geometry, strength = sections.get("geometry"), sections.get("strength")
    for path, body_material in materials_of(sections):
        below: MaterialTable | model.CoatingTable = body_material
        bodies = BODIES if path == ("material",) else path[-1:]
        radii = [abs(radius) for body in bodies for axis in "xy" if geometry is not None
                 and (radius := getattr(geometry, f"{body}_radius_{axis}_mm")) is not None]
        for number, layer in reversed(list(enumerate(body_material.layers or ()))):
            place = (*path, "layers", number)
            if radii and layer.thickness_um >= 1e3 * min(radii):
                yield Conflict((*place, "thickness_um"), "the coating is as thick as the smallest radius of its body",
                               f"less than {1e3 * min(radii):g}")
            owners = [getattr(strength, str(body), None) for body in bodies]
            if layer.shear_yield_MPa is not None and all(owner is None or owner.shear_yield_MPa is None for owner in owners):
                yield Conflict((*place, "shear_yield_MPa"), "has no effect without that of the body",
                               " or ".join(f"strength.{body}.shear_yield_MPa" for body in bodies) + " beside it")
            ratio = layer.youngs_modulus_GPa / below.youngs_modulus_GPa
            if ratio > MOST_STIFF_ON_SOFT or 1.0 / ratio > MOST_SOFT_ON_STIFF:
                kind, most = ("stiffer", MOST_STIFF_ON_SOFT) if ratio > 1.0 else ("softer", MOST_SOFT_ON_STIFF)
                yield Conflict((*place, "youngs_modulus_GPa"),
                               f"the coating is {max(ratio, 1.0 / ratio):.4g} times {kind} than the material below it",
                               f"at most {most:g} times {kind}")
            below = layer


SMALLEST_SHARE, TIMES = 1e-6, (1e-12, 1e12)
"""Least share of a modulus that relaxes, or remains; shortest and longest time in s."""


def _relaxation(sections: Sections) -> Iterator[Conflict]:
    for path, material in materials_of(sections):
        for place, constants in ((path, material), *(((*path, "layers", number), layer)
                                                     for number, layer in enumerate(material.layers or ()))):
            pairs, key = constants.relaxation or (), (*place, "relaxation")
            if constants.relaxation and constants.relaxation_file:
                yield Conflict((*place, "relaxation_file"), "cannot be given together with relaxation", "a series, or a file",
                               at_key=True)
            if not all(SMALLEST_SHARE <= share and TIMES[0] <= time <= TIMES[1] for share, time in pairs):
                yield Conflict(key, "has a share or a time outside the allowed range",
                               f"shares from {SMALLEST_SHARE:g}, times from {TIMES[0]:g} s to {TIMES[1]:g} s")
            elif (relaxed := sum(share for share, _ in pairs)) > 1.0 - SMALLEST_SHARE:
                yield Conflict(key, f"takes away {relaxed:g} of the modulus: nothing remains that carries a load",
                               "shares with a sum below 1")
        relaxing = [bool(layer.relaxation) for layer in material.layers or ()]
        if relaxing and material.relaxation:
            yield Conflict((*path, "relaxation"), "is not computed for a body below a coating", "layers on an elastic body",
                           at_key=True)
        for number, (above, own) in enumerate(pairwise(relaxing), 1):
            if own and not above:
                yield Conflict((*path, "layers", number, "relaxation"), "is not computed below an elastic layer",
                               "layers that relax on top", at_key=True)


def _bulk_temperatures(thermal: model.ThermalTable) -> Iterator[Conflict]:
    lower, upper = thermal.bulk_temperature_lower_K, thermal.bulk_temperature_upper_K
    if lower != upper and thermal.partition != "matched":
        yield Conflict(("thermal", "bulk_temperature_upper_K" if upper else "bulk_temperature_lower_K"),
                       f"bulk temperatures of {lower:g} K and {upper:g} K drive heat through the contact, which needs a "
                       "matched partition", 'equal bulk temperatures, or partition = "matched" in [thermal]',
                       other=("thermal", "partition"))


def _recirculation(thermal: model.ThermalTable) -> Iterator[Conflict]:
    for body in BODIES:
        table, path = getattr(thermal, body), ("thermal", body)
        if table is None:
            continue
        if not table.recirculate:
            # These keys have no effect. That is an error unless the case says `recirculate = false`.
            for key in sorted(table.model_fields_set) if "recirculate" not in table.model_fields_set else ():
                yield Conflict((*path, key), "has no effect on a body whose heat does not recirculate",
                               "recirculate = true beside it, or recirculate = false to keep it switched off",
                               "without recirculate every pass meets a cold body")
            continue
        if table.convection_W_m2K is None and table.thermal_resistance_K_W is None:
            yield Conflict((*path, "recirculate"), "a body that turns must be cooled, or it gets hotter without end",
                           "one of convection_W_m2K and thermal_resistance_K_W beside it")
        if thermal.peclet != "rolling":
            yield Conflict(("thermal", "peclet"), f"a body that turns carries its heat along: not as {thermal.peclet} sources",
                           '"rolling", or recirculate = false', other=(*path, "recirculate"))


def _wear(sections: Sections, wear: model.WearTable, kind: Kind) -> Iterator[Conflict]:
    geometry = sections.get("geometry")
    bodies = [body for body in BODIES if getattr(wear, body) is not None]
    if not bodies:
        yield Conflict(("wear",), "no body wears", "[wear.lower] or [wear.upper] with specific_wear_rate_mm3_Nm", at_key=True)
    for body in bodies if geometry is not None else ():
        if getattr(wear, body).track_length_m is None and math.isinf(getattr(geometry, f"{body}_radius_x_mm")):
            yield Conflict(("wear", body), f"the {body} body is flat along rolling and has no circumference", "track_length_m",
                           at_key=True)
    for body in bodies:
        path, rates = ("wear", body, "specific_wear_rate_mm3_Nm"), getattr(wear, body).specific_wear_rate_mm3_Nm
        if isinstance(rates, list):
            yield from _curve(path, rates, (math.ulp(0.0), 1e9), "N/mm2",
                              "pairs [T_gamma/A, rate], T_gamma/A increasing from above 0 to 1e9", "rate", 1e6)
            if not any(rate > 0.0 for _, rate in rates):
                yield Conflict(path, "no point has a rate above 0", "a rate above 0")
    if wear.positions is not None and not kind.has_positions:
        yield Conflict(("wear", "positions"), "are those of a wheelset", "[wheelset] and [track]", at_key=True)
    for number, (weight, keys) in enumerate(wear.positions or (), 1):
        if isinstance(weight, dict) or not isinstance(keys, dict):
            yield Conflict(("wear", "positions"), f"position {number} is no pair of a weight and keys",
                           "pairs [weight, {KEY = value, …}]", at_key=True)


def over_time(
    sections: Sections, values: Callable[[Sections, HistoryTable], Iterator[Fault]]
) -> Iterator[Conflict]:
    """Conflicts of a case over time, whose values of keys have the faults `values`."""
    history: HistoryTable | None = sections.get("history")
    if history is None:
        return
    for path, message, allowed in history_faults(sections, history, values):
        yield Conflict(path, message, allowed, at_key=True)
    heated = heat_is_on(sections)
    for path, material in materials_of(sections):
        if any(one.relaxation or one.relaxation_file for one in (material, *(material.layers or ()))):
            yield Conflict((*path, "relaxation"), "is not computed over time: what relaxes remembers its pressure, too",
                           "elastic bodies", at_key=True)
        if heated and material.layers:
            yield Conflict((*path, "layers"), "have no heat over time: their tables are those of a steady flow",
                           "heat = false in [thermal], or no coatings", at_key=True)
    if not heated:
        return
    subsurface = sections.get("subsurface")
    if subsurface is not None and subsurface.thermal is not False:
        yield Conflict(("subsurface", "thermal"), "stresses by heat are not computed over time", "thermal = false", at_key=True)
    thermal = sections["thermal"] or model.ThermalTable()
    if thermal.peclet == "sliding":
        yield Conflict(("thermal", "peclet"), "sources with the slip velocity are not computed over time",
                       '"rolling" or "stationary"', at_key=True)
    if history.begin and history.begin not in STATES:
        yield Conflict(("history", "begin"), "a result file does not tell what heat it has seen",
                       '"steady" or "pressed", or heat = false in [thermal]', at_key=True)


def _surface(sections: Sections) -> Iterator[Conflict]:
    for path, message, allowed in surface_faults(sections):
        yield Conflict(path, message, allowed, at_key=True)


def _speed(sections: Sections, rolling: model.RollingTable) -> Iterator[Conflict]:
    if rolling.speed_m_s is not None and rolling.speed_m_s < 1e-12 and (sections.get("history") is None or rolling.speed_m_s):
        message = "is below the allowed range" if rolling.speed_m_s else "must be greater than 0"
        yield Conflict(("rolling", "speed_m_s"), message, "a number from 1e-12 to 1e9, in m/s; 0 with [history]")


def _strength(sections: Sections, strength: model.StrengthTable) -> Iterator[Conflict]:
    subsurface = sections.get("subsurface")
    for body in BODIES if "subsurface" in sections else ():
        if getattr(strength, body) is not None and (subsurface is None or body not in subsurface.bodies):
            yield Conflict(("strength", body), f"the stresses inside the {body} body are not computed",
                           f'[subsurface] with "{body}" among its bodies', at_key=True)


def _subsurface(sections: Sections, subsurface: model.SubsurfaceTable) -> Iterator[Conflict]:
    if len(set(subsurface.bodies)) < len(subsurface.bodies):
        yield Conflict(("subsurface", "bodies"), "names a body twice", '["lower"], ["upper"] or ["lower", "upper"]')
    if not subsurface.thermal or "thermal" not in sections or "material" not in sections:
        return
    thermal = sections["thermal"]
    if not heat_is_on(sections):
        yield Conflict(("subsurface", "thermal"), "there is no heat that could make thermal stresses",
                       "false, or a case with heat",
                       f"heat needs {', '.join(THERMAL_CONSTANTS[:2])} and {THERMAL_CONSTANTS[2]} of the material, and no "
                       "heat = false", ("thermal", "heat"))
    elif thermal is not None and thermal.peclet == "sliding":
        yield Conflict(("subsurface", "thermal"), 'thermal stresses are not computed with peclet = "sliding" in [thermal]',
                       'false, or peclet = "rolling" or "stationary"', other=("thermal", "peclet"))


def _line(sections: Sections) -> Iterator[Conflict]:
    for path, message, allowed in line_faults(sections):
        yield Conflict(path, message, allowed, at_key=True)
    if not is_line(sections):
        return
    thermal = sections.get("thermal")
    if thermal is not None and thermal.heat and thermal.peclet != "rolling":
        yield Conflict(("thermal", "peclet"), "a line contact has no steady temperature where its heat rests on a body",
                       '"rolling", or heat = false')


def homogeneous(sections: Sections, message: str) -> Iterator[Fault]:
    """Faults with this `message` of bodies that are coated or relax."""
    for path, material in materials_of(sections):
        for key in ("layers", "relaxation"):
            if getattr(material, key):
                yield (*path, key), message, "homogeneous, elastic bodies"


def materials_of(sections: Sections) -> Iterator[tuple[KeyPath, MaterialTable]]:
    """The material of both bodies, or of each, with its path."""
    material = sections.get("material")
    if isinstance(material, TwoMaterials):
        yield ("material", "lower"), material.lower
        yield ("material", "upper"), material.upper
    elif isinstance(material, MaterialTable):
        yield ("material",), material

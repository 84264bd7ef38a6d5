"""Cases of CONTACT as cases of thermoroll: tables and keys, or the digit that cannot be written and why.

CONTACT's axes: x along travel, y or s to the right, z or n down into body 1 (the rail); creepages of body 1 relative to body 2,
forces on body 1. Here x points along the flow of the material, y to the left, and forces act on body 2. So a contact that
rolls towards its own +x (CHI = 0) keeps the signs of forces and changes those of creepages; towards −x (CHI = 180 degrees) it
is the other way round. M_z always changes its sign, spin never. Wheelsets have CONTACT's axes on both sides.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import elliprd, elliprf

from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.files.case_errors import CaseError, Finding, Span
from thermoroll_cli.files.csv_table import TableError
from thermoroll_cli.files.profile_file import SLICES, UNITS, read_outline, read_slices
from thermoroll_cli.many_contacts.wheelset.placement import Position
from thermoroll_cli.peer.deck import DeckCase
from thermoroll_cli.problem.names import known_as

Content = dict[str, Any]
GRID = {1: 48, 3: 64}
"""Elements per side of a contact of each module: CONTACT's own elements say nothing about the accuracy wanted here."""
LAW = {2: "linear", 3: "rational", 4: "exponential"}
SIGN = {0: -1.0, 1: 1.0, 4: -1.0, 5: 1.0}
"""Side of a wheel on a rail (C1 = 0 and 1) or on a roller, 1 for right ones."""


class LeftOut(Exception):
    """A case cannot be written; the text has its digit and the reason."""


@dataclass(frozen=True)
class DeckAxes:
    """Sign from forces here (on body 2, or rails) along x and y to CONTACT's, the side of a wheel, the place (x, y) in mm
    of a single contact, whose origin here is where the bodies are closest, and the length in mm of a line contact (0: none).
    Where profiles vary along rolling, forces are compared `in_patches`: those of CONTACT lie in level planes, inclined across
    as the slice below the axle is."""

    sign: float
    side: str = ""
    place: tuple[float, float] = (0.0, 0.0)
    length: float = 0.0
    in_patches: bool = False

    def force(self, scalars: Mapping[str, Any], patches: Sequence[Mapping[str, Any]] = ()) -> list[float]:
        """[x, y, z] in N in CONTACT's axes from the scalars of a result; `in_patches` the sums over those of its patches along
        rolling, across and into the rail."""
        if self.in_patches:
            return [sum(patch[name] for patch in patches) for name in ("force_x_N", "force_s_N", "normal_N")]
        names = [f"track_force_{axis}_{self.side}_N" for axis in "xyz"] if self.side else ["force_x_N", "force_y_N", "normal_N"]
        x, y, z = (float(scalars[known_as(name, scalars)]) * (self.length or 1.0) for name in names)
        return [self.sign * x, self.sign * y, z]


class EarlierCase(NamedTuple):
    """A case that was written: its `name` and `axes`."""

    name: str
    axes: DeckAxes


def converted(case: DeckCase, deck: Path, before: EarlierCase | None) -> tuple[Content, DeckAxes]:
    """Tables and keys of `case` of the file `deck`, and the axes of its forces; a case over time goes on from the state of
    `before`, the one before it of the same contact, if that was written.

    Raises LeftOut, and CaseError where a profile is missing.
    """
    digits, values = case.digits, case.values
    _leave_out(
        (digits["R"] >= 2, f"R = {digits['R']}: CONTACT does not compute it"),
        (digits["M"] not in (0, 1, 4), f"M = {digits['M']}: simplified theories of the tractions are not solved"),
        ("damping" in values and digits["M2"] > 0, "M2 = 2: damping"),
        (values.get("influence", 2) not in (2, 3), f"C = {values.get('influence')}: influence coefficients of another kind"),
        (digits["T"] not in (0, 1, 2, 3), f"T = {digits['T']}: unknown"),
        ("material" not in values or "friction" not in values, "C or L: no earlier case has the values that are kept"),
    )
    content = {**_materials(case), **_friction(case), "numerics": {"grid": GRID[case.module]}}
    content["title"] = f"{deck.name}, case {case.number}"
    if digits["S"] and not without(case):
        content["subsurface"] = {}
    add = _wheelset if case.module == 1 else _contact
    return content, add(case, deck, before, content)


def without(case: DeckCase) -> str:
    """What a case that is written goes without, though CONTACT puts it out: empty for nothing."""
    digits = case.digits
    return f"S = {digits['S']}: stresses below the surface over time" if digits["S"] and digits["T"] in (1, 2) else ""


def _leave_out(*reasons: tuple[bool, str]) -> None:
    for holds, reason in reasons:
        if holds:
            raise LeftOut(reason)


def _materials(case: DeckCase) -> Content:
    read, digits, heat = case.values["material"], case.digits, case.values.get("heat")
    bodies: list[dict[str, Any]] = []
    for k in (1, 2):
        body: dict[str, Any] = {
            "youngs_modulus_GPa": 2e-3 * read[f"GG{k}"] * (1.0 + read[f"POISS{k}"]),
            "poisson_ratio": read[f"POISS{k}"],
        }
        # A spring of compliance 1/G and a Kelvin body of FG/G: the modulus falls to G/(1 + FG) in the time TC/(1 + FG).
        if digits["M"] == 1 and (ratio := read[f"FG{k}"]) > 0.0:
            if read[f"TC{k}"] > 0.0:
                body["relaxation"] = [[ratio / (1.0 + ratio), read[f"TC{k}"] / (1.0 + ratio)]]
            else:
                body["youngs_modulus_GPa"] /= 1.0 + ratio
        if digits["H"] and heat:
            of = heat[k - 1]
            body |= {"conductivity_W_mK": 1e3 * of["LAMBDA"], "diffusivity_mm2_s": of["LAMBDA"] / (of["DENS"] * of["HEATCP"]),
                     "expansion_um_mK": 0.0}  # fmt: skip
        bodies.append(body)
    content: Content = {"material": bodies[0] if bodies[0] == bodies[1] else {"lower": bodies[0], "upper": bodies[1]}}
    if digits["M"] == 4:
        yields = 0.0 < read["TAU_C0"] < 1e10
        _leave_out(
            (yields and bool(digits["H"]), "M = 4: heat of a third body that yields"),
        )
        content["layer"] = {"compliance_um_GPa": 1e6 * read["LAYTHK"] / read["GG3"]} | (
            {"yield_MPa": read["TAU_C0"], "hardening_MPa_um": 1e-3 * read["K_TAU"]} if yields else {}
        )
    if digits["H"]:
        _leave_out(
            (heat is None, "H = 1: no earlier case has the values that are kept"),
            (digits["T"] in (1, 2), f"T = {digits['T']}: heat over time"),
        )
        assert heat is not None
        content["thermal"] = {
            "deformation": False,
            "partition": "matched",
            "bulk_temperature_lower_K": heat[0]["BKTEMP"],
            "bulk_temperature_upper_K": heat[1]["BKTEMP"],
        }
    return content


def _friction(case: DeckCase) -> Content:
    digits, rows, law, memory = case.digits, case.values["friction"], case.values["law"], case.values["memory"]
    if digits["T"] == 0:
        return {"load": {"friction_coefficient": 0.0}}
    places = [name for name in ("ALPHA", "SVF") if name in rows[0]]
    plain = [{name: value for name, value in row.items() if name not in places} for row in rows]
    one, first = all(row == plain[0] for row in plain), plain[0]
    if digits["V"] == 1 and law == 0 and not one:
        return {"friction": {"over_angle": [[math.degrees(row["ALPHA"]), row["FSTAT"]] for row in rows]}}
    _leave_out(
        (
            not one,
            f"V = {digits['V']}: "
            + {1: "a law of slip or temperature that varies over the angle", 2: "friction that varies along the track"}.get(
                digits["V"], "friction of each row"
            ),
        )
    )
    if law == 0:
        return {"load": {"friction_coefficient": first["FSTAT"]}}
    if law == 6:
        rest, change = first["FREF"], first["DFHEAT"]
        _leave_out(
            (not digits["H"], "L = 6: friction of the temperature without heat (H = 0)"),
            (memory["MEMDST"] > 0.0, "L = 6: memory of the temperature (MEMDST)"),
        )
        return {
            "load": {"friction_coefficient": rest},
            "friction": {
                "temperature_slope_1_K": -change / (first["DTHEAT"] * rest),
                "temperature_start_K": first["TREF"],
                ("temperature_minimum_factor" if change < 0.0 else "temperature_maximum_factor"): (rest + change) / rest,
            },
        }
    kinetic, *pairs = first.values()
    terms = [(size, half) for size, half in zip(pairs[::2], pairs[1::2], strict=True) if size > 1e-8]
    if not terms:
        return {"load": {"friction_coefficient": kinetic}}
    table: Content = {"memory_um": 1e3 * memory["MEMDST"], "memory_slip_mm_s": memory["MEM_S0"]} if memory["MEMDST"] else {}
    if len(terms) == 1:
        table |= {"law": LAW[law], "limit_coefficient": kinetic, "half_slip_m_s": 1e-3 * terms[0][1]}
    else:
        _leave_out((law != 2, f"L = {law}: two terms"))
        kinks = sorted({0.0, *(2.0 * half for _, half in terms)})
        table |= {
            "law": "table",
            "table": [[1e-3 * s, kinetic + sum(size * max(0.0, 1.0 - 0.5 * s / half) for size, half in terms)] for s in kinks],
        }
    return {"load": {"friction_coefficient": kinetic + sum(size for size, _ in terms)}, "friction": table}


def _contact(case: DeckCase, deck: Path, before: EarlierCase | None, content: Content) -> DeckAxes:
    """One contact (module 3)."""
    digits, values, motion, load = case.digits, case.values, case.values["motion"], content.setdefault("load", {})
    steps, rolls = digits["T"] in (1, 2), digits["T"] in (2, 3)
    _leave_out(
        ("shape" not in values, "D or Z: no earlier case has the shape that is kept"),
        (digits["E"] != 0, f"E = {digits['E']}: an extra rigid slip"),
        (any(motion.get(name) for name in ("SPINXO", "SPINYO")) and motion["CPHI"] != 0.0, "SPINXO, SPINYO: a centre of spin"),
        (rolls and "rolling" not in values, "C: no earlier case has the speed that is kept"),
    )
    rolling = values["rolling"] if rolls else {"CHI": 0.0, "VELOC": 1e3, "DQ": 0.0}
    backwards = abs(rolling["CHI"] - math.pi) < 1e-2
    _leave_out(
        (not backwards and abs(rolling["CHI"]) > 1e-2, f"CHI = {math.degrees(rolling['CHI']):g} degrees: rolling across")
    )
    length, along_2, across_2, least, place = _shape(case)
    content["geometry"] = {"lower_radius_x_mm": math.inf, "upper_radius_x_mm": 0.5 / along_2}
    if length:
        _leave_out((digits["N"] == 0, "N = 0: a line contact has no approach"))
        load["normal_N_mm"] = motion["FN"] / length
    else:
        content["geometry"] |= {"lower_radius_y_mm": math.inf, "upper_radius_y_mm": 0.5 / across_2}
        load |= {"normal_N": motion["FN"]} if digits["N"] else {"approach_um": 1e3 * (motion["FN"] - least)}
    axes = DeckAxes(-1.0 if backwards else 1.0, place=place, length=length)
    distance = rolling["DQ"]
    if steps:
        before = _going_on(case, before)
        # With T = 1 the material stands still, and a contact that moves over it rolls.
        there = place if before is None else before.axes.place
        moved, across = place[0] - there[0], place[1] - there[1]
        _leave_out((across != 0.0 or moved < 0.0 or (rolls and moved != 0.0), "IBASE = 1: a contact that moves across or back"))
        distance = moved or distance
    content["rolling"] = {"speed_m_s": 1e-3 * rolling["VELOC"], "differential_slip": False}
    if digits["T"] == 1 and not distance:
        content["rolling"]["speed_m_s"] = 0.0
    if digits["T"]:
        _motion(case, axes, distance, content)
    if steps:
        _history(case, distance, before, content)
        if length:
            content["history"]["length_mm"] = length
    return axes


def _shape(case: DeckCase) -> tuple[float, float, float, float, tuple[float, float]]:
    """Length of a line contact in mm (0: an ellipse), coefficients of x² and y² of the undeformed distance (1/mm), its least
    value and the place (x, y) of that in mm."""
    area, shape, read, motion = case.values["area"], case.values["shape"], case.values["material"], case.values["motion"]
    kind, bound = area["IPOTCN"], case.digits["B"]
    same = read["GG1"] == read["GG2"] and read["POISS1"] == read["POISS2"]
    _leave_out(
        (bound not in (0, 2) or (bound == 2 and (kind < -3 or kind > 0 or not same)), f"B = {bound}: an approximate pressure"),
        (kind == -6, "IPOTCN = -6: half of two ellipses"),
        (area["MX"] * area["MY"] == 1, "MX = MY = 1: a single element, whose pressure is the same everywhere"),
        (
            shape["IBASE"] != 1 and (shape["IBASE"], area["MY"]) != (2, 1),
            f"IBASE = {shape['IBASE']}: a shape that is no paraboloid",
        ),
        (shape["IPLAN"] != 1, f"IPLAN = {shape['IPLAN']}: a part of the surface that touches"),
    )
    if kind > 0:
        # Circles of the radius RM, of which there is one row.
        b1, b2, b3, b4, b5, b6 = shape.get("B") or (0.5 / shape["RM"], 0.0, 0.0, -shape["XM"] / shape["RM"], 0.0, 0.0)
        _leave_out(
            (b2 != 0.0, "IBASE = 1: a paraboloid that is turned"),
            (b1 <= 0.0 or b3 < 0.0, "IBASE = 1: no curvature along rolling, or a concave one"),
            (b3 == 0.0 and area["MY"] > 1, "IBASE = 1: a cylinder of finite length"),
            (b3 == 0.0 and b5 != 0.0, "IBASE = 1: a cylinder that is tilted"),
            (b3 == 0.0 and kind == 4, "IPOTCN = 4: a line contact whose length is not given"),
        )
        x = -0.5 * b4 / b1
        if b3 == 0.0:
            return (area["DY"] if kind in (1, 3) else area["DY"] - area["YL"]), b1, b3, 0.0, (x, 0.0)
        y = -0.5 * b5 / b3
        return 0.0, b1, b3, b6 - b1 * x**2 - b3 * y**2, (x, y)
    first, second = area["A"], area["B"]
    compliance = sum((1.0 - read[f"POISS{k}"]) / (2.0 * read[f"GG{k}"]) for k in (1, 2))
    if kind == -4:
        return 2.0 * second, first, 0.0, 0.0, (0.0, 0.0)
    if kind == -5:  # a² = 4 W R/(π E*) for the load W per length
        load = motion["FN"] / (2.0 * second)
        return 2.0 * second, 2.0 * load * compliance / (math.pi * first**2), 0.0, 0.0, (0.0, 0.0)
    if kind == -1:
        return 0.0, first, second, 0.0, (0.0, 0.0)
    if kind == -2:
        return 0.0, first, first * float(elliprd(0.0, second**2, 1.0) / elliprd(0.0, 1.0, second**2)), 0.0, (0.0, 0.0)
    # Hertz: A = s R_D(0, b², a²)/3 and B with a and b exchanged, s = p₀ab/E*, approach s R_F(0, a², b²).
    a, b = first**2, second**2
    scale = 1.5 * motion["FN"] * compliance / math.pi if case.digits["N"] else motion["FN"] / float(elliprf(0.0, a, b))
    return 0.0, scale * float(elliprd(0.0, b, a)) / 3.0, scale * float(elliprd(0.0, a, b)) / 3.0, 0.0, (0.0, 0.0)


def _motion(case: DeckCase, axes: DeckAxes, distance: float, content: Content) -> None:
    """Creepages, and forces in place of them; without a `distance` the slip happens at rest (`_history`)."""
    digits, motion, load, (x, y) = case.digits, case.values["motion"], content["load"], axes.place
    _leave_out(
        (digits["F"] > 0 and "friction_coefficient" not in load, "F with V = 1: forces relative to one coefficient"),
        (digits["T"] == 1 and motion["CPHI"] != 0.0, "T = 1: a rotation (CPHI) over time"),
    )
    ending = "_N_mm" if axes.length else "_N"
    if digits["F"]:
        limit = load["friction_coefficient"] * (load[f"normal{ending}"] if digits["N"] else _load_at(content))
    # Slip of T = 1 is a length.
    over = distance if digits["T"] == 1 else 1.0
    for name, key, given, spin in (
        ("FX", "longitudinal", digits["F"] >= 1, -motion["CPHI"] * y),
        ("FY", "lateral", digits["F"] == 2, motion["CPHI"] * x),
    ):
        if given:
            content.setdefault("force", {})[f"{key}{ending}"] = axes.sign * motion[name] * limit
        elif over:
            content.setdefault("creepage", {})[key] = -axes.sign * (motion[name] + spin) / over
    if motion["CPHI"]:
        content.setdefault("creepage", {})["spin_rad_mm"] = motion["CPHI"]


def _load_at(content: Content) -> float:
    """Hertz's load in N at the approach of a contact: it grows with the power 3/2."""
    geometry, material = content["geometry"], content["material"]
    _leave_out(("upper" in material, "F with N = 0: forces relative to a load that is found, between unlike bodies"))
    modulus = 1e3 * material["youngs_modulus_GPa"] / (2.0 * (1.0 - material["poisson_ratio"] ** 2))
    unit = hertz_contact(1.0 / geometry["upper_radius_x_mm"], 1.0 / geometry["upper_radius_y_mm"], modulus, 1.0).approach
    return float((1e-3 * content["load"]["approach_um"] / unit) ** 1.5)


def _history(case: DeckCase, distance: float, before: EarlierCase | None, content: Content) -> None:
    """One step of a contact over time, from nothing or from the state of the case before."""
    motion, given = case.values["motion"], (case.digits["F"] >= 1, case.digits["F"] == 2)
    history: Content = {"steps": 1, "begin": f"{before.name}.h5" if before else "pressed"}
    if distance:
        history["distance_mm"] = [0.0, distance]
    else:
        history |= {
            "time_s": [0.0, 1.0],
            "values": {
                f"shift.{key}_um": [0.0, -1e3 * motion[name]]
                for name, key, force in zip(("FX", "FY"), ("longitudinal", "lateral"), given, strict=True)
                if not force
            },
        }
    content["history"] = history


def _wheelset(case: DeckCase, deck: Path, before: EarlierCase | None, content: Content) -> DeckAxes:
    """A wheel on a rail or a roller (module 1). One that travels backwards is turned about the vertical: it is then a wheel of
    the other side."""
    digits, values = case.digits, case.values
    needed = ("track", "rail", "deviation", "wheelset", "wheel", "position", "velocity", "grid")
    missing = ", ".join(name for name in needed if name not in values)
    _leave_out(
        (digits["C1"] not in SIGN, f"C1 = {digits['C1']}: unknown"),
        (digits["B"] != 0, f"B = {digits['B']}: an approximate pressure"),
        (digits["F"] == 3, "F = 3: a rail on springs"),
        (missing != "", f"D, Z or E: no earlier case has what is kept ({missing})"),
    )
    track, shift, wheels, motion = (values[name] for name in ("track", "deviation", "wheelset", "velocity"))
    kind, sign, on_roller = values["grid"]["D"], SIGN[digits["C1"]], digits["C1"] >= 4
    _leave_out(
        (kind in (6, 7), f"D = {kind}: another plane of reference"),
        (on_roller != ("NOMRAD" in track), "C1: no earlier case has the track that is kept"),
        (bool(track.get("CURV")), "CURV: a curved track"),
        (on_roller and track.get("NOMRAD", 1.0) <= 0.0, "NOMRAD: a roller that is hollow"),
        (track["GAUGHT"] > 0.0 and track["SECOND"] > 1.0, "GAUGSQ: another crossing of the gauge height"),
        (any(shift[name] for name in ("VY", "VZ", "VROLL")), "VY, VZ, VROLL: a rail that moves"),
        (wheels.get("YTAPE", 1000.0) != 1000.0, "YTAPE: another place of the nominal radius"),
        (motion["VS"] == 0.0, "VS = 0: a wheel that does not roll"),
        (digits["F"] == 2 and motion["VPITCH"] != 0.0, "F = 2: a torque about the axle"),
        (kind == 3, "D = 3: slip that varies along rolling by the curvature of wheel and roller"),
    )
    turned = math.copysign(1.0, motion["VS"])
    side = "right" if sign * turned > 0.0 else "left"
    rail, top = _outline(values["rail"], deck)
    own = {"shift_y_mm": sign * shift["DY"], "shift_z_mm": shift["DZ"], "roll_mrad": 1e3 * sign * shift["ROLL"]}
    content["track"] = {"rail_profile": rail, "cant": track.get("CANT", 0.0), side: own}
    if track["GAUGHT"] > 0.0:
        content["track"] |= {"gauge_height_mm": track["GAUGHT"], "gauge_mm": track["THIRD"]}
    else:
        own["origin_mm"] = [sign * track["SECOND"], track["THIRD"]]
    speed = abs(motion["VS"])
    if on_roller:
        # The radius is that of z = 0 of the outline.
        content["track"] |= {"roller_radius_mm": track["NOMRAD"], "roller_angular_velocity_rad_s": speed}
        own["shift_z_mm"] += top if track["GAUGHT"] > 0.0 else 0.0
        speed *= track["NOMRAD"]
    # Only FBDIST/2 − FBPOS places a wheel: a single one may have its flange back on the track's middle.
    narrow = max(0.0, 1000.0 - wheels["FBDIST"]) if wheels["FBDIST"] < 100.0 else 0.0
    place, moving = _placed(case, sign, on_roller)
    content["wheelset"] = {
        "wheel_profile": _outline(values["wheel"], deck)[0], "wheels": side, "nominal_radius_mm": wheels["NOMRAD"],
        "flange_back_distance_mm": wheels["FBDIST"] + narrow, "flange_back_mm": wheels["FBPOS"] + 0.5 * narrow,
        "lateral_shift_mm": turned * place["Y"],
        ("vertical_N" if digits["N"] else "height_mm"): place["Z"],
        "roll_mrad": 1e3 * turned * place["ROLL"], "yaw_mrad": 1e3 * place["YAW"],
        "lateral_velocity_mm_s": turned * moving["VY"], "vertical_velocity_mm_s": moving["VZ"],
        "roll_rate_mrad_s": 1e3 * turned * moving["VROLL"], "yaw_rate_mrad_s": 1e3 * moving["VYAW"],
        "patches": "curved" if kind == 4 else "planar",
    }  # fmt: skip
    varies = [values[name]["NAME"].lower().endswith(SLICES) for name in ("rail", "wheel")]
    _leave_out(
        (any(varies) and turned < 0.0, "VS < 0: a wheel that travels backwards over profiles that vary"),
        (any(varies) and on_roller, "C1: rollers with profiles that vary"),
        (any(varies) and digits["T"] in (1, 2), f"T = {digits['T']}: profiles that vary over time"),
    )
    if varies[0]:
        content["wheelset"]["position_mm"] = place["S"]
    if varies[1]:
        content["wheelset"]["rotation_deg"] = -math.degrees(place["PITCH"])
    if any(varies):
        # A nose stands upright, whatever it looks like.
        for table in (content["track"]["rail_profile"], content["wheelset"]["wheel_profile"]):
            table.setdefault("flip", False)
    if on_roller:
        content["wheelset"] |= {
            "longitudinal_shift_mm": turned * place["S"],
            "longitudinal_velocity_mm_s": turned * moving["VX"],
        }
    # With F = 2 the torque is zero, as it is where neither is given.
    if digits["F"] == 0:
        content["wheelset"]["angular_velocity_rad_s"] = -turned * moving["VPITCH"]
    elif digits["F"] == 1:
        content["wheelset"]["traction_N"] = turned * motion["VPITCH"]
    content["rolling"] = {
        "speed_m_s": 1e-3 * (speed if on_roller else turned * moving["VX"]),
        "differential_slip": kind in (3, 4),
    }
    content.setdefault("load", {})
    axes = DeckAxes(turned, side, (turned * place["S"], 0.0), in_patches=any(varies))
    if digits["T"] in (1, 2):
        before = _going_on(case, before)
        distance, element = values["grid"]["DX"] * values["grid"]["DQREL"], values["grid"]["DX"]
        if digits["T"] == 1:
            # Velocities are ways of the step here, of a wheel that rolls by as much as its contact moves along the rail.
            distance = speed
            moved = distance if before is None else axes.place[0] - before.axes.place[0]
            _leave_out(
                (on_roller, "T = 1: a shift on a roller"),
                (before is None and distance > element, f"T = 1: a shift by VS = {distance:g} mm, by which nothing rolls"),
                (abs(moved - distance) > 1e-3 * element,
                 f"T = 1: the contact moves by {moved:g} mm and rolls by {distance:g} mm"),
            )
        content["history"] = {"steps": 1, "begin": f"{before.name}.h5" if before else "pressed", "distance_mm": [0.0, distance]}
    return axes


def _going_on(case: DeckCase, before: EarlierCase | None) -> EarlierCase | None:
    """The case before whose state this one over time goes on from; None if it begins from nothing."""
    first = case.digits["P"] == 2 or case.number == 1
    _leave_out(
        (not first and case.digits["P"] != 0, f"P = {case.digits['P']}: a part of the state before"),
        (not first and before is None, "P = 0: goes on from a case that is left out"),
    )
    return None if first else before


def _placed(case: DeckCase, sign: float, on_roller: bool) -> tuple[dict[str, float], dict[str, float]]:
    """Position and velocities of a wheelset, from which its wheel may deviate (E = 4 and 5): that of another one whose wheel is
    there and moves so. The wheel turns about the axle of the wheelset, its surface is one about an axle of its own."""
    at, motion, flexible, wheels = (case.values[name] for name in ("position", "velocity", "flexible", "wheelset"))
    moving = {**motion, "VX": 0.0 if on_roller else motion["VS"]}
    if not any(flexible.values()):
        return at, moving
    _leave_out(
        (any(flexible[f"wheel {name}"] for name in ("VX", "VY", "VZ", "VROLL", "VYAW", "VPITCH")),
         f"E = {case.digits['E']}: a wheel that moves on its axle"),
        (case.digits["F"] != 0, f"E = {case.digits['E']} with F = {case.digits['F']}: a wheel off its place that is driven"),
    )  # fmt: skip
    moved = {name: flexible[f"wheel D{name}"] for name in ("X", "Y", "Z", "ROLL", "YAW")}
    radius, y = wheels["NOMRAD"], sign * (0.5 * wheels["FBDIST"] - wheels["FBPOS"])
    axes = Position(roll=at["ROLL"], yaw=at["YAW"]).rotation
    own = Position(roll=moved["ROLL"], yaw=moved["YAW"]).rotation
    axle = axes @ own[:, 1]
    place = {"ROLL": math.atan2(axle[2], axle[1]), "YAW": -math.asin(axle[0])}
    there = Position(roll=place["ROLL"], yaw=place["YAW"]).rotation
    off = axes @ (own @ [0.0, 0.0, -radius] + [moved["X"], y + moved["Y"], radius + moved["Z"]]) - there @ [0.0, y, 0.0]
    turning = axes @ [motion["VROLL"], motion["VPITCH"], motion["VYAW"]]
    rates = dict(zip(("VROLL", "VPITCH", "VYAW"), (there.T @ turning).tolist(), strict=True))
    more = dict(zip(("VX", "VY", "VZ"), np.cross(turning, off).tolist(), strict=True))
    x, y, z = off.tolist()
    place |= {"S": at["S"] + x, "Y": at["Y"] + y, "Z": at["Z"] + (0.0 if case.digits["N"] else z)}
    return place, rates | {name: moving[name] + change for name, change in more.items()}


def _outline(read: dict[str, Any], deck: Path) -> tuple[Content, float]:
    """The table of a profile's file, which stays where it is, and the least z of its points in mm."""
    path = Path(os.path.realpath(deck.parent / read["NAME"].replace("\\", "/")))  # also of a link to itself
    if not path.is_file():
        raise CaseError([Finding("there is no such file", key="profile", value=read["NAME"], source=str(deck),
                                 span=Span(read["LINE"], 1, 1), line_text=f"'{read['NAME']}'")])  # fmt: skip
    units = {factor: unit for unit, factor in UNITS.items()}
    _leave_out(
        (read["SCALE"] not in units, f"SCALE = {read['SCALE']:g}: a profile that is scaled"),
        (read["ISMOOTH"] != 0 and read["SMOOTH"] > 0.0, f"ISMOOTH = {read['ISMOOTH']}: another smoothing"),
    )
    try:
        # Slices are turned and smoothed alike.
        first = path.parent / read_slices(path).slices[0].file if path.suffix.lower() in SLICES else path
        reading = read_outline(first).in_units(units[read["SCALE"]], None)
    except TableError as cause:
        raise LeftOut(str(cause)) from None
    table: Content = {"file": str(path)} | ({"unit": units[read["SCALE"]]} if read["SCALE"] != 1.0 else {})
    if read["MIRRORY"] == 1:
        table["mirror"] = True
    if (given := read.get("MIRRORZ", 0)) and (given == 1) != reading.turned:
        table["flip"] = True
    if read["SMOOTH"] > 0.0:
        # CONTACT's penalty λ belongs to the sum over all points, whatever their distance.
        spacing = sum(math.dist(first, second) for first, second in pairwise(reading.content)) / (len(reading.content) - 1)
        table["smoothing_mm"] = 2.0 * math.pi * (read["SMOOTH"] * spacing) ** 0.25
    return table, min(-z if table.get("flip") else z for _, z in reading.content)

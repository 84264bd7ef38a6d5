"""CONTACT's wheels on rails (module 1), and the same right wheel on its rail here."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from thermoroll_cli.files.profile_file import read_outline
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.many_contacts.wheelset.kinematics import MotionOfWheelset
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests" / "reference" / "wheelset"


@cache
def outline_points(name: str) -> Points:
    """The profile `name` in m."""
    path = FOLDER / name if (FOLDER / name).exists() else ROOT / "cases" / name
    return tuple((1e-3 * y, 1e-3 * z) for y, z in read_outline(path).content)


@cache
def contact_cases(kind: str = "cases") -> list[dict[str, Any]]:
    """CONTACT's results with their inputs, "cases" (planar) or "conformal"."""
    found: list[dict[str, Any]] = json.loads((FOLDER / "contact.json").read_text(encoding="utf-8"))[kind]
    return found


def case_named(name: str, kind: str = "cases") -> dict[str, Any]:
    return next(case for case in contact_cases(kind) if case["name"].strip() == name)


def side_of(case: dict[str, Any]) -> float:
    """−1 for a left wheel."""
    return 1.0 if case["input"]["side"] == "right" else -1.0


def facing_beside(case: dict[str, Any]) -> tuple[Facing, MotionOfWheelset]:
    """The wheel of a case at the height that CONTACT found, as a right wheel, and its motion."""
    i = case["input"]
    rail = RailSide(outline_points(i["rail"]), i["cant"], 0.5e-3 * i["gaugwd"], 1e-3 * i["gaught"])
    wheel = WheelSide(outline_points(i["wheel"]), 1e-3 * i["radius"], 0.5e-3 * i["fbdist"], 1e-3 * i["fbpos"])
    position = Position(1e-3 * i["y"], 1e-3 * case["contact"]["z_ws_mm"], i["roll"], i["yaw"])
    motion = MotionOfWheelset(1e-3 * i["vs"], i["omega"])
    if side_of(case) < 0.0:
        position, motion = position.mirrored, motion.mirrored
    return Facing(rail, wheel, position), motion

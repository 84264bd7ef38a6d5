"""The Manchester contact benchmark: cases for each displacement of the wheelset, beside CONTACT's results."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Mapping
from typing import Any

from thermoroll_cli import Case

ROOT = pathlib.Path(__file__).parents[1]
WHEEL, RAIL = 750.0, 760.5326
"""Distance of both profiles' origins from the middle of the track, mm."""


def contact_results() -> list[dict[str, Any]]:
    """CONTACT's results, one for each lateral displacement, in its own frame and signs."""
    return json.loads((ROOT / "tests" / "reference" / "manchester.json").read_text(encoding="utf-8"))["results"]


def case_beside(result: Mapping[str, Any]) -> Case:
    """The case of one of CONTACT's results. CONTACT's frame is rotated by 180° about z (docs/python.md): its y, its roll and
    its creepages change sign, its spin does not. The origin is its contact reference."""
    place = result["contact_y_track_mm"]
    longitudinal, lateral, spin = result["creepage"]
    return Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "geometry.lower_profile.offset_mm": RAIL + place,
        "geometry.upper_profile.offset_mm": WHEEL - result["lateral_displacement_mm"] + place,
        "geometry.upper_profile.tilt_mrad": -1e3 * result["wheelset_roll_rad"],
        "load.normal_N": result["normal_N"],
        "creepage.longitudinal": -longitudinal,
        "creepage.lateral": -lateral,
        "creepage.spin_rad_mm": spin,
    })  # fmt: skip

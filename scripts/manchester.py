"""The Manchester contact benchmark: both wheels of a displaced wheelset, beside CONTACT's results."""

from __future__ import annotations

import json
import pathlib
from functools import cache
from typing import Any

from thermoroll_cli import Case
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

ROOT = pathlib.Path(__file__).parents[1]
SHIFTS = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.5, 6.0, 6.5, 7.0, 8.0, 9.0, 10.0)
"""Displacements to the right in mm; the yaw is 2.4 mrad for each."""


@cache
def contact_results() -> dict[tuple[str, float], dict[str, Any]]:
    """CONTACT's inputs and results (planar patches) by side and displacement."""
    cases = json.loads((ROOT / "tests" / "reference" / "wheelset" / "contact.json").read_text(encoding="utf-8"))["cases"]
    named = {(case["name"].strip()): case for case in cases}
    return {(side, shift): named[f"A2.2 {side} y={shift:.1f}"] for side in ("left", "right") for shift in SHIFTS}


def wheelset_at(shift: float, grid: int, **more: Any) -> Result:
    """The wheelset displaced by `shift` mm, `grid`² elements for each patch, with `more` keys ("__" stands for the point)."""
    keys = {key.replace("__", "."): value for key, value in more.items()}
    case = Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "wheelset.lateral_shift_mm": shift, "wheelset.yaw_mrad": 2.4 * shift, "numerics.grid": [grid, grid], **keys})
    return solve(case)

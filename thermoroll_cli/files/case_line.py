"""Line contacts in case files: what a load per length means for the other keys, and what is not computed with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from thermoroll_cli.files.case_errors import Fault
from thermoroll_cli.problem.problem import BODIES

LOAD, PRESSURE = "load.normal_N_mm", "load.hertz_pressure_MPa"
REFUSED = ("geometry.conformal", "geometry.lower_profile", "geometry.upper_profile", "creepage.spin_rad_mm",
           "thermal.lower", "thermal.upper", "wear.distance_km", "wear.depth_um")  # fmt: skip
"""Tables and keys that are not computed for line contacts."""


def value_of(sections: Mapping[str, Any], key: str) -> Any:
    """The table of that name, or the value of a key "table.key", among the tables of a case; None where it has none."""
    table, _, inner = key.partition(".")
    given = sections.get(table)
    return getattr(given, inner, None) if inner and given is not None else given


def is_line(sections: Mapping[str, Any]) -> bool:
    """Whether a case is one of a line contact: its load is one per length, or follows from the pressure of two bodies that are
    flat across."""
    flat = all(value_of(sections, f"geometry.{body}_radius_y_mm") == math.inf for body in BODIES)
    return value_of(sections, LOAD) is not None or (flat and value_of(sections, PRESSURE) is not None)


def line_faults(sections: Mapping[str, Any]) -> Iterator[Fault]:
    """Keys that do not go with a line contact, or with another one."""
    force, geometry, numerics = (sections.get(name) for name in ("force", "geometry", "numerics"))
    line = is_line(sections)
    for way in ("longitudinal", "lateral"):
        own, other = (f"{way}_N_mm", f"{way}_N") if line else (f"{way}_N", f"{way}_N_mm")
        if force is not None and getattr(force, other) is not None:
            why = "is a force, but the load of a line contact is one per length" if line else (
                "is a force per length, but the load is a force")
            yield ("force", other), why, f"force.{own}" + ("" if line else f", or {LOAD}")
    if not line:
        return
    other = f"or without {LOAD}" if value_of(sections, LOAD) is not None else "or a body that is curved across"
    for key in REFUSED:
        if value_of(sections, key):
            yield tuple(key.split(".")), "is not computed for line contacts", f"a case without it, {other}"
    for body in BODIES if geometry is not None else ():
        radius = getattr(geometry, f"{body}_radius_y_mm")
        if radius is not None and math.isfinite(radius):
            yield (("geometry", f"{body}_radius_y_mm"), f"is finite, and {LOAD} is the load of bodies that are long across "
                   "rolling", "inf, or the key left out; or load.normal_N")  # fmt: skip
    if numerics is not None and isinstance(numerics.grid, tuple):
        yield ("numerics", "grid"), "a line contact has elements along rolling alone", "one number"

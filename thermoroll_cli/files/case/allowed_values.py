"""What a key of the case file may be, in words: read off its model."""

from __future__ import annotations

import re
from typing import get_args

from thermoroll_cli.files.case.case_model import (
    GRID_RANGE,
    LARGEST_PROFILE,
    LAYERS_RANGE,
    PROFILES,
    GeometryTable,
    SubsurfaceTable,
    Table,
)

_GRID_ALLOWED = f"a whole number from {GRID_RANGE[0]} to {GRID_RANGE[1]}, or two of them: [nx, ny]"
_RADIUS_ALLOWED = "a number of either sign (negative is concave), 1e-9 to 1e9 in magnitude, or inf (flat)"
_SUBSURFACE_ALLOWED = {
    "bodies": '["lower"], ["upper"] or ["lower", "upper"]',
    "layers": f"a whole number from {LAYERS_RANGE[0]} to {LAYERS_RANGE[1]}",
    "thermal": "true or false",
    "fields": '"plane", "von_mises" or "full"',
}
_PARTITION_ALLOWED = 'a number from 0 to 1, or "matched"'


def nested_table(table: type[Table], key: str) -> type[Table] | None:
    """The model of `key` where that is a table inside `table`."""
    field = table.model_fields.get(key)
    choices = (field.annotation, *get_args(field.annotation)) if field is not None else ()
    return next((c for c in choices if isinstance(c, type) and issubclass(c, Table)), None)


def allowed_values(table: type[Table], key: str) -> str:
    """What `key` of `table` may be, in words."""
    field = table.model_fields[key]
    if table is GeometryTable:
        return "a table: points_mm, file or kind" if key in PROFILES else f"{_RADIUS_ALLOWED}, in mm"
    special = {"points_mm": f"2 to {LARGEST_PROFILE} pairs [y, height] of numbers in mm, y increasing",
               "file": "the name of a file with two columns", "kind": '"logarithmic"', "interpolation": '"cubic" or "linear"',
               "grid": _GRID_ALLOWED, "partition": _PARTITION_ALLOWED, "deformation": 'true, false or "always"',
               "title": "up to 200 characters on one line"}
    if key in special:
        return special[key]
    if key == "peclet":
        return '"rolling", "sliding" or "stationary"'
    if table is SubsurfaceTable and key in _SUBSURFACE_ALLOWED:
        return _SUBSURFACE_ALLOWED[key]
    if field.annotation is bool:
        return "true or false"
    if nested_table(table, key) is not None:
        return "a table"
    limits = {name: getattr(item, name) for item in field.metadata for name in ("ge", "le") if hasattr(item, name)}
    extra = field.json_schema_extra
    unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
    in_unit = "" if unit == "1" else f", in {unit}"
    kind = "a whole number" if field.annotation is int else "a number"
    return f"{kind} from {_short(limits['ge'])} to {_short(limits['le'])}{in_unit}"


def _short(number: float) -> str:
    """1e9, not 1e+09."""
    return re.sub(r"e([-+])0*", lambda sign: "e-" if sign[1] == "-" else "e", f"{number:g}")

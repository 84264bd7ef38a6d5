"""The inputs of a case as people read them: every key with its value, in its own unit and in SI."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from thermoroll_cli.files.case.case_model import Settings

SI = {
    "GPa": ("Pa", 1e9),
    "W/(m K)": ("W/(m K)", 1.0),
    "1e-6/K": ("1/K", 1e-6),
    "mm2/s": ("m²/s", 1e-6),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "mrad": ("rad", 1e-3),
    "rad/mm": ("rad/m", 1e3),
}
"""Unit of a key → its SI unit, and what to multiply by. Units not named here are SI units."""


@dataclass(frozen=True)
class Input:
    """A key with its `value` in the unit of the key, and in SI: `si` is None for what is no number, `unit` empty for what
    has none."""

    key: str
    value: Any
    si: float | None
    unit: str


def inputs(settings: Settings) -> Iterator[Input]:
    """All keys of a case that have a value, in the order of the tables."""
    yield from _inputs(settings, "")


def _inputs(table: BaseModel, prefix: str) -> Iterator[Input]:
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        if isinstance(value, BaseModel):
            yield from _inputs(value, f"{prefix}{name}.")
        elif value is not None and value != "":
            extra = field.json_schema_extra
            unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
            yield _input(prefix + name, value, "" if unit == "1" else unit)


def _input(key: str, value: Any, unit: str) -> Input:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return Input(key, value, None, "")
    si_unit, factor = SI.get(unit, (unit, 1.0))
    # As in `case`: 30.0 / 1e3 is 0.03 to the last bit, 30.0 * 1e-3 is not.
    si = value / round(1.0 / factor) if factor < 1.0 and math.isfinite(value) else value * factor
    return Input(key, value, float(si), si_unit)

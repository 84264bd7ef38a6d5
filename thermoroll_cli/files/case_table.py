"""Tables of a case file: how a key declares its unit, its meaning and its range, and how tables turn into SI units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from thermoroll_cli.problem.names import unit_of

LARGEST_PROFILE = 2000
"""Points of a profile."""

SI = {
    "GPa": ("Pa", 1e9),
    "MPa": ("Pa", 1e6),
    "µm/(m K)": ("1/K", 1e-6),
    "mm²/s": ("m²/s", 1e-6),
    "km": ("m", 1e3),
    "mm": ("m", 1e-3),
    "µm": ("m", 1e-6),
    "mm³/(N m)": ("1/Pa", 1e-9),
    "µm/GPa": ("m/Pa", 1e-15),
    "mm/s": ("m/s", 1e-3),
    "mrad": ("rad", 1e-3),
    "mrad/s": ("rad/s", 1e-3),
    "rad/mm": ("rad/m", 1e3),
    "N/mm": ("N/m", 1e3),
    "MPa/µm": ("Pa/m", 1e12),
}
"""Unit of a key → its SI unit, and the factor to it. Units not named here are SI units."""

UNIT_AT_END = re.compile(
    r"_(?:[kMG]?Pa|N_mm|[kM]?N|[num]?m|cm|km|psi|lbf?|inch(?:es)?|W_mK|W_m2K|K_W|W_m_K|W_K|um_mK|1_K|per_K|ppm_K|mm2_s|m2_s|cm2_s"
    r"|um_GPa|MPa_um|mm3_Nm|kg_m3|m_s|mm_s|km_h|kmh|mph|rad_mm|rad_m|1_mm|1_m|percent|deg|rpm|Nm|m?rad(?:_s)?|s)$",
    re.IGNORECASE,
)
"""The unit at the end of a key: those of case files, and others that people write."""


@dataclass(frozen=True)
class Allowed:
    """The values a key may have, in words, where its type and range do not say enough: the keyword `allowed` of its schema."""

    words: str

    def __get_pydantic_json_schema__(self, core_schema: Any, handler: Any) -> dict[str, Any]:
        return {**handler(core_schema), "allowed": self.words}


def quantity(description: str, default: Any = ..., *, ge: float | None = None, le: float | None = None) -> Any:
    """A number, allowed from `ge` to `le`, in the unit at the end of its key; the default None means that the key may be left
    out."""
    # Every number has limits, far outside any use: arithmetic overflows with numbers like 1e-300.
    return Field(default=default, description=description, ge=ge, le=le)


def pairs(allowed: str, description: str, *, least: int = 1, most: int = LARGEST_PROFILE, needed: bool = False) -> Any:
    """A list of `least` to `most` pairs of numbers that may be left out unless it is `needed`; `allowed` says of what, in
    words."""
    return Field(default=... if needed else None, description=description, min_length=least, max_length=most,
                 json_schema_extra={"allowed": f"{least} to {most} pairs {allowed}"})


LengthUnit = Literal["m", "mm", "um", "in"]


def unit_key(of: str) -> Any:
    """The key of a table that says in which unit a file has its lengths; `of` says of which."""
    return Field(default=None, description=f"Unit of lengths in {of}")


def signed_length(low: float, high: float, *, zero: str = "is outside the allowed range") -> BeforeValidator:
    """Allows lengths of either sign from `low` to `high` in magnitude, and inf; `zero` says why not 0."""
    def check(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise PydanticCustomError("length", "must be a number")
        if value == 0:
            raise PydanticCustomError("length", zero)
        if not (low <= abs(value) <= high or value == math.inf):  # nan and -inf, too
            raise PydanticCustomError("length", "is outside the allowed range")
        return float(value)

    return BeforeValidator(check)


Pair = Annotated[list[float], Field(min_length=2, max_length=2)]


class Table(BaseModel):
    """A table of the case file: unknown keys, wrong types, nan and inf are errors."""

    # A table's validator is built when a case first has that table.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)

    def __getitem__(self, key: str) -> Any:
        """The value of a key of the case file, as its attribute: `settings["load"]["normal_N"]`. Raises KeyError."""
        if key not in type(self).model_fields:
            raise KeyError(f"{key}: there are {', '.join(type(self).model_fields)}")
        return getattr(self, key)

    @staticmethod
    def si_unit(key: str) -> tuple[str, float]:
        """The SI unit of `key`, empty if it has none, and the factor to it from the key's own unit."""
        unit = unit_of(key)
        return SI.get(unit, (unit, 1.0))

    def si(self, key: str) -> Any:
        """The value of `key` in SI units; None where it is left out.

        Factors below one divide: 30.0 / 1e3 is 0.03 to the last bit, 30.0 * 1e-3 is not."""
        value, factor = getattr(self, key), self.si_unit(key)[1]
        if value is None or factor == 1.0:
            return value
        return value / round(1.0 / factor) if factor < 1.0 else value * factor

    def in_si(self) -> dict[str, Any]:
        """The numbers and words given here, in SI units, by the names of their keys without the unit."""
        return {quantity_of(key): self.si(key) for key, value in self if isinstance(value, int | float | str)}


def quantity_of(key: str) -> str:
    """A key without the unit at its end."""
    return UNIT_AT_END.sub("", key)

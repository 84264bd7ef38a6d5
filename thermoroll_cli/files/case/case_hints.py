"""What the author of a case probably meant."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

from thermoroll_cli.files.case.allowed_values import nested_table
from thermoroll_cli.files.case.case_model import REQUIRED_SECTIONS, SECTIONS, MaterialTable

TABLES: dict[str, tuple[str, ...]] = {
    "material": (*MaterialTable.model_fields, "lower", "upper"),
    **{name: tuple(model.model_fields) for name, model in SECTIONS.items()},
}
"""Keys of every table."""

_TOP_LEVEL = ("title", *TABLES)

# The unit part of a key: what follows the quantity's name in a case file, and what people write in its place.
_UNIT = re.compile(
    r"_(?:[kMG]?Pa|[kM]?N|[num]?m|cm|km|psi|lbf?|inch(?:es)?|W_mK|W_m2K|K_W|W_m_K|W_K|um_mK|1_K|per_K|ppm_K|mm2_s|m2_s|cm2_s"
    r"|m_s|mm_s|km_h|kmh|mph|rad_mm|rad_m|1_mm|1_m|percent|deg|rad)$",
    re.IGNORECASE,
)


def meant_key(table: str, key: str) -> str:
    """The key of `table` ("" is the top level) that the unknown `key` was probably meant to be, "" if none is near."""
    known = known_keys(table)
    return _same_quantity(key, known) or _nearest(key, known)


def unknown_key(table: str, key: str) -> str:
    """Help for `key`, which `table` does not have."""
    known = known_keys(table)
    unit = _UNIT.search(key)
    same = _same_quantity(key, known)
    elsewhere = [name for name, keys in TABLES.items() if key in keys and name != table.split(".")[0]]
    if elsewhere and (unit or not same):
        return f"{key} belongs in [{elsewhere[0]}]"
    if same:
        wanted = _UNIT.search(same)
        found = f"not {unit.group()[1:]}" if unit else "which is missing here"
        return f'did you mean "{same}"? The unit is part of the key: {wanted.group()[1:] if wanted else "none"}, {found}'
    near = _nearest(key, known)
    return f'did you mean "{near}"?' if near else f"known here: {', '.join(known)}"


def known_keys(table: str) -> tuple[str, ...]:
    """Keys `table` ("" is the top level) may have."""
    if not table:
        return _TOP_LEVEL
    outer, _, inner = table.partition(".")
    if not inner:
        return TABLES[table]
    nested = MaterialTable if outer == "material" else nested_table(SECTIONS[outer], inner)
    return tuple(nested.model_fields) if nested is not None else ()


def missing_table(name: str) -> str:
    """What a missing table would have to hold."""
    if name == "material":
        return "add youngs_modulus_GPa and poisson_ratio, or the tables [material.lower] and [material.upper]"
    return f"add {', '.join(TABLES[name])}" if name in REQUIRED_SECTIONS else ""


def wrong_type(value: Any) -> str:
    """Help for a value of the wrong type."""
    if isinstance(value, str):
        if re.fullmatch(r"\s*[-+]?\d+,\d+\s*", value):
            return "a number is written with a point and without quotes: 0.5"
        if value.strip().lower() in ("true", "false"):
            return "true and false are written without quotes"
        try:
            float(value)
        except ValueError:
            return ""
        return "a number is written without quotes"
    return ""


def misspelt_word(value: Any, known: Iterable[str]) -> str:
    """The nearest known word, if `value` is one letter or two away from it."""
    near = _nearest(value, known) if isinstance(value, str) else ""
    return f'did you mean "{near}"?' if near else ""


def broken_syntax(line: str) -> str:
    """Help for a line that is not TOML."""
    slips: Mapping[str, str] = {
        r"=\s*[-+]?\d+,\d": "a decimal number is written with a point: 0.5",
        r"=\s*(True|False|TRUE|FALSE|yes|no|on|off)\b": "TOML writes true and false, in small letters",
        r"=\s*[-+]?(Inf|INF|Infinity|infinity|∞)": "TOML writes infinity as inf, without quotes",
        r"=\s*(NaN|NAN)": "nan is not an allowed value",
        r"=\s*[-+]?\.\d": "a number needs a digit before the point: 0.5",
        r"=\s*[-+]?\d+\.(?!\d)": "a number needs a digit after the point: 1.0",
        r"=\s*[A-Za-z]": "text is written in quotes",
        r"=\s*(#.*)?$": "a value is missing after the =",
        r"=\s*[-+]?[\d.eE+-]+\s*[A-Za-z%°µ]": "a value has no unit behind it: the unit is part of the key",
        r"^\s*\w+\s*:": "TOML writes key = value",
        r"^\s*\[[^]]*$": "a table header ends with ]",
    }
    return next((hint for pattern, hint in slips.items() if re.search(pattern, line)), "")


def _same_quantity(key: str, known: Iterable[str]) -> str:
    """The known key that differs from `key` in its unit only."""
    same = [name for name in known if _quantity(name) == _quantity(key) and name.lower() != key.lower()]
    return same[0] if same else ""


def _quantity(key: str) -> str:
    return _UNIT.sub("", key).lower()


def _nearest(word: str, known: Iterable[str]) -> str:
    lowered = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word.lower()[:200], lowered, n=1, cutoff=0.6)
    return lowered[near[0]] if near else ""

"""Results as tables for people."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from thermoroll_cli.problem.error_scale import absolute_error, mean_semi_axis
from thermoroll_cli.problem.names import ALL_SCALARS

UNBOUNDED = "no limit: a free end"
"""Beside values that grow with every refinement, because the contact reaches the end of a profile."""

_SIGNIFICANT_DIGITS = 5
_NEGLIGIBLE_ERROR = 1e-6
_NOISE = 1e-6
_NARROWEST = 9
"""A header is not broken into less."""
_HEADER_PART = re.compile(r"[^_.]+(?:_(?:N|K|W|s|mm|um|m_s|rad_mm|mm2|W_mK|um_mK|mm2_s|1_K|GPa|MPa|Nmm|W_mm2)$|[_.])?")
"""A word of a name; the last one with its unit."""


def scalar_table(summary: Mapping[str, Any], names: Sequence[str], *, both: bool, width: int) -> list[str]:
    """Lines of a table with one scalar a line: name, value ± estimated error in the unit of the value, the isothermal value if
    `both`, and its meaning, a brief one or none where `width` has no room for it.

    `summary` has the shape of `Result.summary()`. Scalars that were not computed are left out; what the case gives has no
    error (`absolute_error`).
    """
    rows = [("", "coupled", "isothermal")] if both else []
    shown_names = [""] if both else []
    isothermal = {**summary, **summary["isothermal"]}
    for name in names:
        value = summary.get(name, math.nan)
        if not _computed(value):
            continue
        error = absolute_error(name, summary)
        shown = "0" if math.isnan(error) and _is_noise(name, summary) else with_error(value, error)
        beside = "" if not both or name not in summary["isothermal"] else number(isothermal[name])
        rows.append((name, shown, "0" if beside and _is_noise(name, isothermal) else beside))
        shown_names.append(name)
    start = max(map(len, align(rows)), default=0) + 2
    lines = []
    for line, name in zip(align(rows), shown_names, strict=True):
        fitting = (text for text in _meanings(name, "patches" in summary) if start + len(text) <= width)
        remark = UNBOUNDED if name in summary.get("unbounded", ()) else next(fitting, "")
        lines.append((line.ljust(start) + remark).rstrip())
    return lines


def _meanings(name: str, profiles: bool) -> tuple[str, ...]:
    """The meaning of a scalar, and a brief one."""
    if name not in ALL_SCALARS:
        return ()
    scalar = ALL_SCALARS[name]
    return (scalar.without_hertz,) if profiles and scalar.without_hertz else (scalar.meaning, scalar.brief)


def align(rows: Sequence[Sequence[str]]) -> list[str]:
    """`rows` as lines with columns below each other."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))] if rows else []
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True) if width).rstrip() for row in rows
    ]


def with_remarks(rows: Sequence[Sequence[str]], remarks: Sequence[str], width: int) -> list[str]:
    """`rows` as by `align`, each with its remark behind it, or below it where `width` has no room."""
    lines = align(rows)
    start = max(map(len, lines), default=0) + 2
    told = []
    for line, remark in zip(lines, remarks, strict=True):
        if not remark or start + len(remark) <= width:
            told.append((line.ljust(start) + remark).rstrip())
        else:
            told += [line, *folded(remark, width, indent="      ")]
    return told


def folded(text: str, width: int, indent: str = "  ") -> list[str]:
    """`text` as lines of at most `width` characters (but not less than 40), indented, and further from the second on."""
    return textwrap.wrap(text, max(width, 40), initial_indent=indent, subsequent_indent=indent + "  ", break_on_hyphens=False)


def wrapped(name: str, width: int) -> list[str]:
    """The lines of `name` as a header above a column `width` wide: broken behind `_` and `.`, where a part does not fit."""
    lines = [""]
    for part in re.findall(_HEADER_PART, name):
        if lines[-1] and len(lines[-1] + part) > max(width, _NARROWEST):
            lines.append("")
        lines[-1] += part
    return lines


def with_error(value: float, error: float) -> str:
    """`11.07 ± 0.02`: the error with one digit (two if it starts with 1), the value with as many decimals. No ± without an
    error (nan)."""
    if not math.isfinite(error) or error == 0.0:
        return number(value)
    if error < _NEGLIGIBLE_ERROR * abs(value):
        return f"{number(value)} ± {error:.0e}"
    power = _common_power(max(abs(value), error))
    scaled, error = value / 10.0**power, error / 10.0**power
    exponent = math.floor(math.log10(error))
    decimals = -exponent + (1 if error / 10.0**exponent < 1.95 else 0)
    if round(scaled, decimals) == 0.0:
        return f"0 ± {error * 10.0**power:.1g}"
    text = f"{_rounded(scaled, decimals)} ± {_rounded(error, decimals)}"
    return f"({text})e{power}" if power else text


def number(value: float | None) -> str:
    """A number with the digits worth reading; a dash for one that was not computed."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:.{_SIGNIFICANT_DIGITS}g}"


def _common_power(value: float) -> int:
    """The power of ten to take out of a number too small or too large to be written plainly."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        return 0
    return math.floor(math.log10(abs(value)))


def _rounded(value: float, decimals: int) -> str:
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def _is_noise(name: str, scalars: Mapping[str, Any]) -> bool:
    """Whether a force or moment is what rounding leaves of the zero that a symmetry makes."""
    if name not in ("force_x_N", "force_y_N", "spin_moment_Nmm"):
        return False
    scale = math.hypot(scalars.get("force_x_N", 0.0), scalars.get("force_y_N", 0.0))
    if name == "spin_moment_Nmm":
        scale *= mean_semi_axis(scalars)
    return abs(scalars.get(name, 0.0)) <= _NOISE * scale


def _computed(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)

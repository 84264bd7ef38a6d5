"""Columns of a sweep's table as numbers and words for its figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.problem.names import UNITS

Column = NDArray[np.float64]


def failed_points(table: Mapping[str, Sequence[Any]]) -> NDArray[np.bool_]:
    """Points that did not converge: their scalars are none, or those of another state than the one asked for."""
    rows = len(next(iter(table.values()), ()))
    return np.array([said != "converged" for said in table.get("status", ["converged"] * rows)], dtype=bool)


def summary_of_row(table: Mapping[str, Sequence[Any]], row: int) -> dict[str, Any]:
    """A row as the summary of a result: its scalars, with their errors by name."""
    scalars = {name: column[row] for name, column in table.items() if isinstance(column[row], (int, float))}
    return scalars | {"error": {name.removeprefix("error."): v for name, v in scalars.items() if name.startswith("error.")}}


def merged(table: Mapping[str, Sequence[Any]], names: Sequence[str]) -> Column | None:
    """The largest of the named columns point by point; None where none of them holds a number."""
    found = [numbers(table[name]) for name in names if name in table]
    found = [values for values in found if np.any(np.isfinite(values))]
    return np.fmax.reduce(found) if found else None


def numbers(values: Sequence[Any]) -> Column:
    """The column as numbers, nan for what is none."""
    result = np.full(len(values), math.nan)
    for row, value in enumerate(values):
        try:
            result[row] = float(value)
        except (TypeError, ValueError):
            continue
    result[~np.isfinite(result)] = math.nan
    return result


def unbounded_points(table: Mapping[str, Sequence[Any]], names: Sequence[str]) -> NDArray[np.bool_]:
    """Points where any of the named columns has no limit: it grows with every refinement."""
    rows = len(next(iter(table.values()), ()))
    return np.array([not set(names).isdisjoint(str(cell).split()) for cell in table.get("unbounded", [""] * rows)], dtype=bool)


def cell_text(value: Any) -> str:
    """A swept value in few digits, large numbers without powers of ten."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return str(value)
    return f"{number:.0f}" if 1e3 <= abs(number) < 1e7 and number.is_integer() else f"{number:.4g}"


def with_value(key: str, value: Any) -> str:
    """A case key with its value: `rolling.speed_m_s` and 5 become "rolling speed = 5 m/s"."""
    words, _, unit = words_of(key).partition(" (")
    return f"{words} = {cell_text(value)} {unit.removesuffix(')')}".rstrip()


def words_of(key: str) -> str:
    """A case key as an axis label: `rolling.speed_m_s` becomes "rolling speed (m/s)"."""
    section, _, name = key.rpartition(".")
    suffix = next((suffix for suffix in UNITS if name.endswith(suffix)), "")
    words = name.removesuffix(suffix).replace("_", " ")
    if (section in ("creepage", "force") and words != "spin") or words == "normal":
        words = f"{words} {section}"
    elif section == "rolling":
        words = f"{section} {words}"
    return f"{words} ({UNITS[suffix]})" if suffix else words

"""A table of the positions of a wheelset's service: a column `weight`, and one for each key that differs."""

from __future__ import annotations

from typing import Any

from thermoroll_cli.files.case_source import toml_value
from thermoroll_cli.files.csv_table import FILE_LIMIT, read_columns
from thermoroll_cli.files.spellings import converted, in_own_units


def read_positions(path: str) -> list[list[Any]]:
    """[weight, {key: value}] of each line of the CSV file at `path` (`read_columns`). An empty cell leaves its key as the case
    has it; units in brackets behind keys are converted. Raises ValueError, OSError."""
    names, lines = read_columns(path, "a table of positions", gaps=True, largest=FILE_LIMIT)
    keys, factors = in_own_units(path, names)
    if "weight" not in keys or "" in keys or len({*keys}) < len(keys):
        raise ValueError("needs a header line with weight and keys, each once, and a line for each position")
    found = []
    for number, cells in lines:
        values = {key: toml_value(cell) for key, cell in zip(keys, cells, strict=True) if cell}
        values |= {key: converted(values[key], factor) for key, factor in zip(keys, factors, strict=True)
                   if factor != 1.0 and type(values.get(key)) in (int, float)}
        weight = values.pop("weight", None)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 < weight <= 1e9:
            given = cells[keys.index("weight")] or "nothing"
            raise ValueError(f"line {number}: the weight must be a number above 0, not {given}")
        for key, value in values.items():
            if not isinstance(value, bool | int | float | str):
                raise ValueError(f"line {number}: {key} must be a number or a word")
        found.append([float(weight), values])
    return found

"""A table of the positions of a wheelset's service: a column `weight`, and one for each key that differs."""

from __future__ import annotations

import csv
import io
from typing import Any

from thermoroll_cli.atomic import read_bytes
from thermoroll_cli.files.case_source import toml_value

LARGEST = 1 << 20
"""Bytes of such a file at most."""
WEIGHT = "weight"


def read_positions(path: str) -> list[list[Any]]:
    """[weight, {key: value}] of each line of the CSV file at `path`, whose cells are separated by commas, or by semicolons or
    tabs. An empty cell leaves its key as the case has it. Raises ValueError, OSError."""
    try:
        text = read_bytes(path, LARGEST, "a table of positions").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("not UTF-8 text") from None
    delimiter = next((mark for mark in ";\t" if mark in text.partition("\n")[0]), ",")
    reader = csv.reader(io.StringIO(text), delimiter=delimiter)
    lines = [(reader.line_num, [cell.strip() for cell in line]) for line in reader if any(cell.strip() for cell in line)]
    keys = lines[0][1] if lines else []
    if WEIGHT not in keys or "" in keys or len({*keys}) < len(keys) or len(lines) < 2:
        raise ValueError(f"needs a header line with {WEIGHT} and keys, each once, and a line for each position")
    found = []
    for number, cells in lines[1:]:
        if len(cells) != len(keys):
            raise ValueError(f"line {number}: {len(cells)} values for {len(keys)} columns")
        values = {key: toml_value(cell) for key, cell in zip(keys, cells, strict=True) if cell}
        weight = values.pop(WEIGHT, None)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 < weight <= 1e9:
            given = cells[keys.index(WEIGHT)] or "nothing"
            raise ValueError(f"line {number}: the weight must be a number above 0, not {given}")
        for key, value in values.items():
            if not isinstance(value, bool | int | float | str):
                raise ValueError(f"line {number}: {key} must be a number or a word")
        found.append([float(weight), values])
    return found

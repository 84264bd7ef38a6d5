"""A record over time, as a vehicle program or a rig exports it: what changes, and when.

The file has a header row and the columns `distance_mm` or `time_s` and keys that change. A name without its unit may have
another one in brackets, or in the row below: `time [ms]`, `load.normal [kN]`, `rolling.speed [km/h]`.
"""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Sequence
from itertools import pairwise

from thermoroll_cli.files.csv_table import FromFile, TableError, read_columns
from thermoroll_cli.files.spellings import converted, factor_of, meant
from thermoroll_cli.many_contacts.history.course import VARIED
from thermoroll_cli.problem.names import PLACES, unit_end, unit_of

HEAD = re.compile(r"(.*?)\s*(?:[\[(]([^\])]*)[\])])?")


def read_history(path: str | os.PathLike[str]) -> FromFile:
    """The tables of `[history]` in the file at `path` (`read_columns`). Raises TableError with file, line and column,
    OSError."""
    name = os.path.basename(os.fspath(path))
    heads, lines = read_columns(path, "a record over time")
    units = [""] * len(heads)
    if not any(map(_is_number, lines[0][1])):
        units, lines = lines[0][1], lines[1:]
    columns: dict[str, list[float]] = {}
    for place, (head, unit) in enumerate(zip(heads, units, strict=True)):
        key, factor = _column(name, head, unit)
        if key in columns:
            raise TableError(f"{name}: the column {key} stands there twice")
        columns[key] = []
        for number, cells in lines:
            if not _is_number(cells[place]):
                raise TableError(f'{name}, line {number}: {head} is "{cells[place]}", not a number')
            columns[key].append(converted(float(cells[place]), factor))
    places = [each for each in PLACES if each in columns]
    if len(places) != 1:
        raise TableError(f"{name} has {'both' if places else 'neither'} distance_mm {'and' if places else 'nor'} time_s",
                         f"one of them; found: {', '.join(columns)[:200]}")
    values = columns.pop(places[0])
    if len(values) < 2 or not columns:
        raise TableError(f"{name} has {len(values)} rows, and {len(columns)} keys that change", "two rows and a key at least")
    for before, (one, other) in enumerate(pairwise(values)):
        if other < one:
            raise TableError(f"{name}, line {lines[before + 1][0]}: {places[0]} falls from {one:g} to {other:g}",
                             "rows in the order of time; the same place twice is a jump")
    return FromFile({places[0]: values, "values": columns},
                    {"file": name, "rows": len(values), "first": values[0], "last": values[-1], "place": places[0],
                     "keys": list(columns)},
                    f"{{file}}: {{rows}} rows from {{first:.6g}} to {{last:.6g}} ({{place}}), {', '.join(columns)}")


def _column(name: str, head: str, below: str) -> tuple[str, float]:
    """The key of a column, and the size of its unit in that of the key. Raises TableError."""
    parts = HEAD.fullmatch(head)
    assert parts is not None
    own, unit = parts[1].strip(), (parts[2] or below).strip().strip("[]()")
    known: Sequence[str] = (*PLACES, *VARIED)
    key = next((each for each in known if own in (each, each.removesuffix(unit_end(each)))), None)
    if key is None:
        near = [each for each in (meant(own),) if each in VARIED] or difflib.get_close_matches(own, known, n=1)
        raise TableError(f"{name}: the column {own} is no key that changes over time",
                         f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}")
    if not unit and own != key:
        raise TableError(f"{name}: {own} has no unit", f"call it {key}, or write the unit behind the name in brackets")
    factor = factor_of(unit, unit_of(key)) if unit else 1.0
    if factor is None:
        raise TableError(f"{name}: the column {own} cannot be in {unit}",
                         f"{key} is in {unit_of(key) or 'numbers without a unit'}")
    return key, factor


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False

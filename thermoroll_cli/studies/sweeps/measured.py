"""Measured values: a table whose columns are what was varied (keys of a case) and what was measured (scalars)."""

from __future__ import annotations

import difflib
import math
import os
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from thermoroll_cli.files.case_schema import entry_at
from thermoroll_cli.files.case_source import key_path
from thermoroll_cli.files.csv_table import read_columns
from thermoroll_cli.files.spellings import converted, in_own_units, meant, unit_in
from thermoroll_cli.problem.names import ALL_SCALARS, ERROR, PER_LENGTH, PLACES, UNCERTAINTY, known_as, unit_of
from thermoroll_cli.tools.arrays import Array

OVER_LOAD = {"force_x_over_load": "force_x_N", "force_y_over_load": "force_y_N"}
"""Creep forces over the load, as rigs report them: column of the data → scalar in N."""


@dataclass(frozen=True)
class Measured:
    """Measured points.

    - `source`: the name of the file, for messages; `lines`: the number of each point in it;
    - `varied`: values by key of the case, (points,) in the units of the keys, and places of a history (`names.PLACES`);
    - `values`: values by scalar, (points,) in the units of the scalars;
    - `deviations`: their standard deviations, likewise, of scalars that have them;
    - `written`: units in which the file has varied values, by key, and their size in that of the key."""

    source: str
    lines: tuple[int, ...]
    varied: Mapping[str, Array]
    values: Mapping[str, Array]
    deviations: Mapping[str, Array]
    written: Mapping[str, tuple[str, float]] = field(default_factory=dict)

    @classmethod
    def of(cls, data: Measured | Mapping[str, Sequence[float]] | str | os.PathLike[str]) -> Measured:
        """The points of a file (`read`), or of a mapping or data frame with the same columns. Raises as `read` does."""
        if isinstance(data, Measured):
            return data
        if isinstance(data, str | os.PathLike):
            return cls.read(pathlib.Path(data))
        columns = {name: [float(value) for value in column] for name, column in zip(map(str, data), data.values(), strict=True)
                   if not name.startswith("#")}
        if len({len(column) for column in columns.values()}) != 1:
            raise ValueError("the columns of the data differ in length")
        count = len(next(iter(columns.values())))
        return cls._sorted("data", tuple(range(1, count + 1)), columns)

    @classmethod
    def read(cls, path: pathlib.Path) -> Measured:
        """The points in a CSV file: a header line with names of keys, of scalars, and NAME_error for their standard deviations,
        each also with a unit in brackets behind it, from which it is converted; separators and decimal commas as of `--points`.
        Columns whose name begins with # are left out.

        Raises ValueError, with file and line: an unknown or a repeated column, no measured one, text, nan, a deviation that is
        not positive; OSError."""
        heads, lines = read_columns(path, "a table of measured values")
        used = [place for place, head in enumerate(heads) if not head.startswith("#")]
        heads, lines = [heads[k] for k in used], [(number, [cells[k] for k in used]) for number, cells in lines]
        names, factors = in_own_units(str(path), heads)
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(f"{path}: the column {twice} stands there twice")
        columns: dict[str, list[float]] = {name: [] for name in names}
        for number, cells in lines:
            for name, cell, factor in zip(names, cells, factors, strict=True):
                try:
                    columns[name].append(float(cell) if factor == 1.0 else converted(float(cell), factor))
                except ValueError:
                    raise ValueError(f'{path}, line {number}: {name} is "{cell}", not a number') from None
        written = {name: (unit_in(head), factor) for name, head, factor in zip(names, heads, factors, strict=True)
                   if factor != 1.0}
        return replace(cls._sorted(str(path), tuple(number for number, _ in lines), columns), written=written)

    @classmethod
    def _sorted(cls, source: str, lines: tuple[int, ...], columns: Mapping[str, Sequence[float]]) -> Measured:
        varied, values, deviations = {}, {}, {}
        for name, column in columns.items():
            array = np.array(column, dtype=float)
            if not np.isfinite(array).all():
                raise ValueError(f"{source}, line {lines[int(np.argmin(np.isfinite(array)))]}: {name} is not finite")
            scalar = name.removesuffix(ERROR)
            if name in ALL_SCALARS or name in OVER_LOAD:
                values[name] = array
            elif scalar != name and (scalar in ALL_SCALARS or scalar in OVER_LOAD):
                if not (array > 0.0).all():
                    raise ValueError(f"{source}, line {lines[int(np.argmin(array > 0.0))]}: {name} must be above 0")
                deviations[scalar] = array
            elif name in PLACES or "minimum" in entry_at(key_path(name)):
                varied[name] = array
            else:
                key, unit = meant(name), unit_in(name)
                own = f"{key} [{unit}]" if key and unit and unit != unit_of(key) else key
                near = [own or next(iter(difflib.get_close_matches(name, [*ALL_SCALARS, *OVER_LOAD], n=1)), "")]
                if near == ["load.friction_coefficient"]:  # rigs call so what they measure
                    near = ["force_x_over_load", *near]
                hint = f"; did you mean {' or '.join(near)}?" if near[0] else ""
                raise ValueError(f"{source}: the column {name} is neither a key of a case that takes a number, nor a scalar, "
                                 f"nor a scalar with {ERROR} (# before its name leaves it out){hint}")
        if not values:
            raise ValueError(f"{source}: no column is a measured scalar, for example force_x_N or force_x_over_load")
        if not any(array.any() for array in values.values()):
            raise ValueError(f"{source}: every measured value is 0, and no case is found from that")
        if alone := next((name for name in deviations if name not in values), None):
            raise ValueError(f"{source}: {alone}{ERROR} stands there without {alone}")
        return cls(source, lines, varied, values, deviations)

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, number: int) -> str:
        """Where the point `number` (from 0) stands."""
        return f"{self.source}, line {self.lines[number]}"

    def only(self, kept: Sequence[int]) -> Measured:
        """The points with these numbers."""
        chosen = [{name: column[list(kept)] for name, column in part.items()}
                  for part in (self.varied, self.values, self.deviations)]
        varied, values, deviations = chosen
        return replace(self, lines=tuple(self.lines[number] for number in kept), varied=varied, values=values,
                       deviations=deviations)

    def in_newtons(self, loads: Sequence[float], load_name: str = "normal_N") -> Measured:
        """The same points with forces in place of forces over the load: that of the column load.normal_N, or of the cases that
        the points are compared with, where it is one, of `loads` (N). With the `load_name` normal_N_mm all are per length.
        Raises ValueError where it is not."""
        if not OVER_LOAD.keys() & self.values.keys():
            return self
        key = f"load.{load_name}"
        load = self.varied.get(key, loads[0])
        if key not in self.varied and max(loads) > (1.0 + 1e-9) * min(loads):
            raise ValueError(f"{self.source} has forces over the load, which varies: add the column {key}")
        forces = {name: force if load_name == "normal_N" else PER_LENGTH[force] for name, force in OVER_LOAD.items()}
        values, deviations = ({forces.get(name, name): column * load if name in OVER_LOAD else column
                               for name, column in part.items()} for part in (self.values, self.deviations))
        return Measured(self.source, self.lines, self.varied, values, deviations, self.written)

    def scale(self, name: str) -> Array:
        """What a difference in a scalar counts against: its standard deviations, else its largest value, (points,)."""
        if name in self.deviations:
            return self.deviations[name]
        largest = float(np.abs(self.values[name]).max())
        return np.full(len(self), largest if largest > 0.0 else 1.0)


def at_place(name: str, place: float, summary: Mapping[str, Any]) -> dict[str, Any] | str:
    """The summary of a history at a `place` of its column `name`, linear between its rows; what is wrong with that."""
    columns = summary.get("history")
    if columns is None:
        return f"{name} is a column of a case with [history] alone"
    first, *_, last = columns[name]
    if not first <= place <= last:
        return f"{name} = {place:g} is outside of the history, from {first:g} to {last:g}"
    there = {column: float(np.interp(place, columns[name], values)) for column, values in columns.items()
             if isinstance(values[0], float)}
    errors = {column.removeprefix(UNCERTAINTY): value for column, value in there.items() if column.startswith(UNCERTAINTY)}
    return {**summary, **there, "uncertainty": errors}


def scalar_in(name: str, summary: Mapping[str, float], load: float) -> float:
    """A measured scalar in the summary of a result under the `load` (N, or N/mm); nan if it was not computed."""
    value = summary.get(known_as(OVER_LOAD.get(name, name), summary))
    number = math.nan if value is None else float(value)
    return number / load if name in OVER_LOAD else number

"""The rows of a sweep, one per point, and their columns, also as a data frame."""

from __future__ import annotations

import math
import pathlib
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from thermoroll_cli import optional
from thermoroll_cli.problem import names
from thermoroll_cli.problem.names import STATES
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import row_of
from thermoroll_cli.sweeps.points import Points, Value
from thermoroll_cli.tasks.journal import Journal

if TYPE_CHECKING:
    import pandas
    import xarray

CONVERGED = "converged"
TEXTS = ("status", "reason", "unbounded", "warnings", "work.grid")
"""Columns of texts. `unbounded` names the scalars that have no limit at this point, where the contact reaches the end of a
profile."""


@dataclass(frozen=True)
class Row:
    """The outcome of one point. `summary` has the shape of `Result.summary()` and the columns of `OVER_LIMIT`, with nan for
    numbers that were not computed; `file` is the result file, if there is one."""

    number: int
    name: str
    over: Mapping[str, Value]
    summary: Mapping[str, Any]
    file: pathlib.Path | None

    @property
    def converged(self) -> bool:
        return bool(self.summary["status"] == CONVERGED)

    @property
    def reason(self) -> str:
        return str(self.summary["reason"])

    def flat(self) -> dict[str, Any]:
        """The swept values and the summary side by side, with `file`."""
        return {**self.over, **self.summary, "file": self.file}

    def cells(self) -> dict[str, Any]:
        """The values by column, numbers and texts."""
        summary, work = self.summary, self.summary["work"]
        return {**row_of(summary), **self.over, "unbounded": " ".join(summary["unbounded"]),
                "warnings": "; ".join(summary["warnings"]), "work.grid": "x".join(map(str, work.get("grid", ()))),
                "file": self.file.name if self.file else "", "work.applications": work.get("applications", math.nan)}


def summary_of(result: Result) -> dict[str, Any]:
    """The record of a result: what `Row.summary` is made of, in plain JSON types, without what was not computed."""
    summary = result.summary()
    limit = summary.get("friction_limit_N", math.nan)
    summary |= {name: summary[force] / limit for name, force in names.OVER_LIMIT.items() if limit > 0.0 and force in summary}
    known: dict[str, Any] = _known(summary)
    return known


def _known(value: Any) -> Any:
    """Without numbers that were not computed."""
    if isinstance(value, list):
        return [_known(each) for each in value]
    if not isinstance(value, Mapping):
        return value
    return {name: _known(inner) for name, inner in value.items() if not (isinstance(inner, float) and math.isnan(inner))}


def failed_summary(reason: str) -> dict[str, Any]:
    """The record of a point that has no result."""
    return {"status": "not_converged", "reason": reason}


def _whole(summary: Mapping[str, Any]) -> dict[str, Any]:
    """A record's summary with nan for everything that it lacks."""
    scalars = dict.fromkeys((*names.SCALARS, *names.PROBLEM_SCALARS, *names.OVER_LIMIT), math.nan)
    states = {state: dict.fromkeys(names.SCALARS, math.nan) | summary.get(state, {}) for state in STATES}
    return {**scalars, "work": {}, "warnings": [], "unbounded": [], **summary, **states}


@dataclass(frozen=True)
class Rows:
    """The rows known so far, read from the journal one by one, in the order of the points."""

    points: Points
    keys: Sequence[str]
    journal: Journal
    folder: pathlib.Path

    def row(self, number: int) -> Row:
        record = self.journal[self.keys[number - 1]]
        file = self.folder / record["file"] if record["file"] else None
        name = self.points.name(number) if file is None else file.stem
        return Row(number, name, self.points.over(number), _whole(record["summary"]), file)

    @property
    def numbers(self) -> list[int]:
        """The numbers of the points that have a row."""
        return [number for number, key in enumerate(self.keys, 1) if key in self.journal]

    def __iter__(self) -> Iterator[Row]:
        return map(self.row, self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


@dataclass(frozen=True)
class SweepColumns:
    """The table of a sweep: `columns` with a value per point (numbers, texts; nan where not computed), the swept `keys` among
    them, whether the points are a list (`listed`) or all combinations of values; if known the `title` and the text of the case,
    and the `attributes` of the file that says how it was solved."""

    columns: Mapping[str, Sequence[Any]]
    keys: tuple[str, ...]
    listed: bool
    title: str = ""
    case_text: str = ""
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def numbers(self) -> dict[str, Sequence[float]]:
        """The computed columns without texts."""
        return {name: column for name, column in self.columns.items() if name not in (*self.keys, *TEXTS, "file")}


def columns_of(rows: Rows, title: str = "") -> SweepColumns:
    """The table with all rows known now: the swept keys, texts, and every number that any row has."""
    keys = tuple(axis.key for axis in rows.points.axes)
    columns: dict[str, Any] = {name: [] for name in (*keys, *TEXTS, "work.applications", "file")}
    for before, row in enumerate(rows):
        cells = row.cells()
        # Arrays need a quarter of the memory of lists.
        columns |= {name: array("d", [math.nan]) * before for name, value in cells.items()
                    if name not in columns and isinstance(value, float) and not math.isnan(value)}
        for name, column in columns.items():
            column.append(cells.get(name, math.nan))
    declared = (*keys, *TEXTS[:-1], *names.SCALARS, *names.PROBLEM_SCALARS, *names.OVER_LIMIT, *names.SUBSURFACE_SCALARS,
                *(f"{state}.{name}" for state in STATES for name in names.SCALARS),
                *(f"uncertainty.{name}" for name in names.SUBSURFACE_SCALARS))
    last = {name: columns.pop(name) for name in (TEXTS[-1], "work.applications", "file")}
    # Those of an assembly and of its patches are not declared.
    ordered = {name: columns.pop(name) for name in declared if name in columns}
    return SweepColumns(ordered | columns | last, keys, rows.points.listed, title)


def attributes_of(name: str, keys: Sequence[str]) -> tuple[str, str]:
    """Unit and meaning of a column."""
    *parts, own = name.split(".")
    patch, state = (next((part for part in parts if (part in STATES) == known), "") for known in (False, True))
    if name in keys:
        return names.unit_of(name), f"swept key {name}"
    of_contacts = names.OF_CONTACTS["bearing" if patch.startswith("ball_") else "wheelset"]
    scalar = (of_contacts if patch else names.ALL_SCALARS).get(own)
    if scalar is None:
        return "", "number of the point" if name == "point" else name
    meaning = (f"patch {patch}: " if patch else "") + STATES.get(state, "") + scalar.meaning
    return scalar.unit or "1", meaning


class SweepTable(list[dict[str, Any]]):
    """The rows of a sweep as mappings: the swept keys, all scalars, `isothermal` and `uncertainty` as mappings, and `file`."""

    def __init__(self, rows: Rows) -> None:
        super().__init__(row.flat() for row in rows)
        self.points = rows.points
        self._table = columns_of(rows)

    def __repr__(self) -> str:
        converged = self._table.columns["status"].count(CONVERGED)
        return f"<sweep over {', '.join(self._table.keys)}: {len(self)} points, {converged} converged>"

    def _numbers(self) -> dict[str, Sequence[Any]]:
        return {"converged": [status == CONVERGED for status in self._table.columns["status"]], **self._table.numbers}

    def to_dataframe(self) -> pandas.DataFrame:
        """A `pandas.DataFrame` with a row per point: the swept keys, `converged`, and a column for each number.

        Raises ImportError, which names the package to install, if pandas is missing."""
        swept = {key: self._table.columns[key] for key in self._table.keys}
        return optional("pandas", "to_dataframe").DataFrame({**swept, **self._numbers()})

    def to_xarray(self) -> xarray.Dataset:
        """An `xarray.Dataset` with `converged` and each number over the swept keys; over `point` for a list of points.

        Raises ImportError, which names the package to install, if xarray is missing."""
        dataset = optional("xarray", "to_xarray").Dataset
        axes, listed = self.points.axes, self.points.listed
        dimensions = ("point",) if listed else tuple(axis.key for axis in axes)
        coordinates = {axis.key: (("point",) if listed else (axis.key,), list(axis.values)) for axis in axes}
        columns = {name: (dimensions, np.reshape(column, self.points.shape)) for name, column in self._numbers().items()}
        found = dataset(columns, coordinates)
        for name, variable in found.variables.items():
            labels = zip(("units", "long_name"), attributes_of(str(name), dimensions), strict=True)
            variable.attrs.update({label: text for label, text in labels if text})
        return found

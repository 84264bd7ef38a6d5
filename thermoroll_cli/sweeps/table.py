"""The rows of a sweep: one per point, as CSV, as HDF5 arrays over the swept keys, as a data frame; and read back from
the files."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.atomic import replacing, write_bytes
from thermoroll_cli.files.result.hdf5 import (
    ResultFileError,
    create,
    dimension_scale,
    fixed_text,
    image_of,
    label,
    opened,
    read_result,
    stamp,
)
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    OVER_LIMIT,
    PATCH_SCALARS,
    PROBLEM_SCALARS,
    SCALARS,
    SUBSURFACE_SCALARS,
    unit_of,
)
from thermoroll_cli.problem.result import Result
from thermoroll_cli.sweeps.points import Points, Value
from thermoroll_cli.tasks.journal import Journal

if TYPE_CHECKING:
    import pandas
    import xarray

FORMAT_VERSION = 2
KIND = "sweep"
CONVERGED = "converged"
STATES = {"isothermal": "without thermal deformation: ", "error": "estimated error: "}
"""Mappings of a summary that have all scalars of a state, too, and words before the meanings of their columns."""
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
        summary = self.summary
        prefixed = {f"{state}.{name}": value for state in STATES for name, value in summary[state].items()}
        grid = "x".join(str(side) for side in summary["work"].get("grid", ()))
        patches = {f"{patch['side']}_{patch['number']}.{name}": value for patch in summary.get("patches", ()) if "side" in patch
                   for name, value in (*patch.items(), *((f"error.{own}", error) for own, error in patch["error"].items()))
                   if isinstance(value, float)}
        return {**summary, **self.over, **prefixed, **patches, "unbounded": " ".join(summary["unbounded"]),
                "warnings": "; ".join(summary["warnings"]), "work.grid": grid, "file": self.file.name if self.file else "",
                "work.applications": summary["work"].get("applications", math.nan)}


def summary_of(result: Result) -> dict[str, Any]:
    """The record of a result: what `Row.summary` is made of, in plain JSON types, without what was not computed."""
    summary = result.summary()
    limit = summary.get("friction_limit_N", math.nan)
    summary |= {name: summary[force] / limit for name, force in OVER_LIMIT.items() if limit > 0.0 and force in summary}
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
    scalars = dict.fromkeys((*SCALARS, *PROBLEM_SCALARS, *OVER_LIMIT), math.nan)
    states = {state: dict.fromkeys(SCALARS, math.nan) | summary.get(state, {}) for state in STATES}
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
    """The table with all rows known now: the swept keys, texts, and arrays of numbers, those below the surface where any row
    has them."""
    keys, present = tuple(axis.key for axis in rows.points.axes), set[str]()
    for row in rows:
        present |= row.summary.keys() & SUBSURFACE_SCALARS.keys()
    below = [name for name in SUBSURFACE_SCALARS if name in present]
    prefixed = [f"{state}.{name}" for state in STATES for name in SCALARS] + [f"error.{name}" for name in below]
    columns: dict[str, Any] = {name: [] for name in (*keys, *TEXTS[:-1])}
    # Scalars of an assembly and of its patches.
    of_assembly = dict.fromkeys(name for row in rows if any("side" in patch for patch in row.summary.get("patches", ()))
                                for name, value in row.cells().items() if isinstance(value, float) and name not in keys)
    # Arrays need a quarter of the memory of lists.
    columns |= {name: array("d") for name in (*SCALARS, *PROBLEM_SCALARS, *OVER_LIMIT, *below, *prefixed, *of_assembly)}
    columns |= {name: [] for name in (TEXTS[-1], "work.applications", "file")}
    for row in rows:
        cells = row.cells()
        for name, column in columns.items():
            column.append(cells.get(name, math.nan))
    empty = {name for name, column in columns.items() if isinstance(column, array) and np.isnan(column).all()}
    kept = {name: column for name, column in columns.items() if name not in empty}
    return SweepColumns(kept, keys, rows.points.listed, title)


def write_csv(path: pathlib.Path, table: SweepColumns) -> None:
    """Replace the file at `path` by one with this table. Raises WriteError."""
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", errors="backslashreplace", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table.columns)
        writer.writerows(map(_cell, cells) for cells in zip(*table.columns.values(), strict=True))


def _cell(value: Any) -> str:
    """A number with all its digits, nothing for one that was not computed."""
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def write_hdf5(path: pathlib.Path, rows: Rows, table: SweepColumns, command_line: str) -> None:
    """Every column as an array over the swept keys, nan and empty where a point has no row. Raises WriteError."""
    points, known = rows.points, np.array(rows.numbers, dtype=int) - 1
    columns: dict[str, NDArray[Any]] = {}
    for name, column in table.numbers.items():
        columns[name] = np.full(points.count, math.nan)
        columns[name][known] = column
    for name in TEXTS:
        texts = np.full(points.count, b"", dtype=object)
        texts[known] = [text.encode("utf-8", "backslashreplace") for text in table.columns[name]]
        columns[name] = texts.astype(bytes)
    coordinates = {axis.key: _array(axis.values) for axis in points.axes}
    if points.listed:
        columns = {**coordinates, **columns}
        coordinates = {"point": np.arange(1, points.count + 1)}
    inputs = {"case_text": points.text, "settings": json.dumps([override.text for override in points.settings]),
              "keys": json.dumps(table.keys)}

    def fill(file: h5py.File) -> None:
        stamp(file, FORMAT_VERSION, kind=KIND, title=points.point(1).problem.title, command_line=command_line)
        for name, text in inputs.items():
            create(file, f"input/{name}", fixed_text(text))
        scales = [dimension_scale(file, key, values, **_attributes(key, table.keys)) for key, values in coordinates.items()]
        for name, flat in columns.items():
            label(create(file, name, flat.reshape(points.shape), scales), **_attributes(name, table.keys))

    write_bytes(path, image_of(fill))


def _attributes(name: str, keys: Sequence[str]) -> dict[str, str]:
    """Meaning and units of a column. Errors are relative (`error_scale`) and have no units."""
    *parts, own = name.split(".")
    patch, state = (next((part for part in parts if (part in STATES) == known), "") for known in (False, True))
    if name in keys:
        return {"long_name": f"swept key {name}"} | ({"units": unit} if (unit := unit_of(name)) else {})
    scalar = (PATCH_SCALARS if patch else ALL_SCALARS).get(own)
    if scalar is None:
        return {"long_name": "number of the point" if name == "point" else name}
    meaning = (f"patch {patch}: " if patch else "") + STATES.get(state, "") + scalar.meaning
    return {"long_name": meaning} if state == "error" else {"long_name": meaning, "units": scalar.unit or "1"}


def _array(values: Sequence[Value]) -> NDArray[Any]:
    """Numbers as they are, words as bytes."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower().encode() if isinstance(value, bool) else str(value).encode() for value in values])
    return np.asarray(values)


def is_sweep_file(path: pathlib.Path) -> bool:
    """Whether the file at `path` has the many points of a sweep: a CSV table, or an HDF5 file of this kind. A damaged file is
    none; reading it reports the fault."""
    if path.suffix.lower() == ".csv":
        return True
    try:
        with h5py.File(path, "r", locking=False) as file:
            return bool(file.attrs.get("kind") == KIND.encode())
    except (OSError, RuntimeError, KeyError):
        return False


def read_sweep(path: pathlib.Path) -> SweepColumns:
    """The table in the file at `path`, as `sweep` writes sweep.csv and sweep.h5. Raises ResultFileError."""
    try:
        return _read_csv(path) if path.suffix.lower() == ".csv" else _read_hdf5(path)
    except (OSError, ValueError, KeyError, IndexError, StopIteration) as cause:
        reason = cause.strerror if isinstance(cause, OSError) and cause.strerror else "not the table of a sweep"
        raise ResultFileError(f"{path}: {reason}") from cause


def _read_csv(path: pathlib.Path) -> SweepColumns:
    with open(path, encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    if header[:2] == ["side", "number"]:  # the exported patches of a wheelset
        raise ValueError
    columns = {name: [_value(text) for text in column] for name, column in zip(header, zip(*rows, strict=True), strict=True)}
    keys = tuple(header[: header.index("status")])
    listed = math.prod(len(set(columns[key])) for key in keys) != len(rows)
    beside = _result_beside(path, columns)
    if beside is None:
        return SweepColumns(columns, keys, listed)
    return SweepColumns(columns, keys, listed, beside.problem.title, beside.case_text, beside.attributes)


def _result_beside(path: pathlib.Path, columns: Mapping[str, Sequence[Any]]) -> Result | None:
    """A result file beside a table of text, which lacks the case; None without one."""
    for name in columns.get("file", ()):
        if isinstance(name, str) and name and path.with_name(name).exists():
            return read_result(path.with_name(name), with_fields=False)
    return None


def _value(text: str) -> float | str:
    try:
        return float(text) if text else math.nan
    except ValueError:
        return text


def _read_hdf5(path: pathlib.Path) -> SweepColumns:
    with opened(path, KIND, FORMAT_VERSION) as file:
        keys, shape = tuple(json.loads(file["input/keys"].asstr()[()])), file["status"].shape
        columns = {name: _flat(item[()]) for name, item in file.items() if getattr(item, "shape", ()) == shape}
        listed = "point" in file
        if not listed:
            swept = np.meshgrid(*(file[key][()] for key in keys), indexing="ij")
            columns |= {key: _flat(values) for key, values in zip(keys, swept, strict=True)}
        attributes = {name: value.decode() if isinstance(value, bytes) else value for name, value in file.attrs.items()}
        return SweepColumns(columns, keys, listed, attributes["title"], file["input/case_text"].asstr()[()], attributes)


def _flat(values: NDArray[Any]) -> list[Any]:
    return [value.decode() if isinstance(value, bytes) else value for value in values.ravel().tolist()]


class SweepTable(list[dict[str, Any]]):
    """The rows of a sweep as mappings: the swept keys, all scalars, `isothermal` and `error` as mappings, and `file`."""

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
        try:
            import pandas
        except ImportError:
            raise ImportError("to_dataframe needs the package pandas, which is not installed: pip install pandas") from None
        swept = {key: self._table.columns[key] for key in self._table.keys}
        return pandas.DataFrame({**swept, **self._numbers()})

    def to_xarray(self) -> xarray.Dataset:
        """An `xarray.Dataset` with `converged` and each number over the swept keys; over `point` for a list of points.

        Raises ImportError, which names the package to install, if xarray is missing."""
        try:
            import xarray
        except ImportError:
            raise ImportError("to_xarray needs the package xarray, which is not installed: pip install xarray") from None
        axes, listed = self.points.axes, self.points.listed
        dimensions = ("point",) if listed else tuple(axis.key for axis in axes)
        coordinates = {axis.key: (("point",) if listed else (axis.key,), list(axis.values), _attributes(axis.key, dimensions))
                       for axis in axes}
        columns = {name: (dimensions, np.reshape(column, self.points.shape), _attributes(name, ()))
                   for name, column in self._numbers().items()}
        return xarray.Dataset(columns, coordinates)

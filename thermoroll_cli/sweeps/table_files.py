"""The table of a sweep in files: CSV, and HDF5 arrays over the swept keys."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.atomic import replacing
from thermoroll_cli.files.result.labelled import Labelled, Node, ResultFileError, is_kind, load, of_texts, save
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.result import Result
from thermoroll_cli.sweeps.points import Value
from thermoroll_cli.sweeps.table import TEXTS, Rows, SweepColumns, attributes_of

KIND = "sweep"


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
    columns = {each.key: _array(each.values) for each in points.axes} if points.listed else {}
    for name, column in table.numbers.items():
        columns[name] = np.full(points.count, math.nan)
        columns[name][known] = column
    for name in TEXTS:
        columns[name] = np.full(points.count, "", dtype=object)
        columns[name][known] = table.columns[name]
    coordinates = {"point": np.arange(1, points.count + 1)} if points.listed else {
        each.key: _array(each.values) for each in points.axes}
    over = {name: (name,) for name in coordinates} | dict.fromkeys(columns, tuple(coordinates))
    arrays = {name: Labelled(over[name], values.reshape(points.shape) if name in columns else values,
                             *attributes_of(name, table.keys)) for name, values in (coordinates | columns).items()}
    texts = {"case_text": points.text, "settings": json.dumps([override.text for override in points.settings])}
    save(path, Node(arrays, {"title": points.case(1).settings.title, "keys": json.dumps(table.keys)}, {
        "input": of_texts(texts)}), KIND, command_line)  # fmt: skip


def _array(values: Sequence[Value]) -> NDArray[Any]:
    """Numbers as they are, words as texts."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower() if isinstance(value, bool) else str(value) for value in values])
    return np.asarray(values)


# --- reading ---------------------------------------------------------------------------------------------------------


def is_sweep_file(path: pathlib.Path) -> bool:
    """Whether the file at `path` has the many points of a sweep: a CSV table, or an HDF5 file of this kind."""
    return path.suffix.lower() == ".csv" or is_kind(path, KIND)


def read_sweep(path: pathlib.Path) -> SweepColumns:
    """The table in the file at `path`, as `sweep` writes sweep.csv and sweep.h5. Raises ResultFileError."""
    try:
        return _read_csv(path) if path.suffix.lower() == ".csv" else _read_hdf5(path)
    except ResultFileError:
        raise
    except (OSError, ValueError, KeyError, IndexError, StopIteration) as cause:
        reason = cause.strerror if isinstance(cause, OSError) and cause.strerror else "not the table of a sweep"
        raise ResultFileError(f"{path}: {reason}") from cause


def _read_csv(path: pathlib.Path) -> SweepColumns:
    with open(path, encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    if header[:2] in (["side", "number"], ["ball", "ring"]):  # the exported contacts of an assembly
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
    tree = load(path, KIND)
    keys, over = tuple(tree.json("keys")), tree.arrays["status"].axes
    columns = {name: array.values.ravel().tolist() for name, array in tree.arrays.items() if array.axes == over}
    if not (listed := "point" in tree.arrays):
        swept = np.meshgrid(*(tree.arrays[key].values for key in keys), indexing="ij")
        columns |= {key: values.ravel().tolist() for key, values in zip(keys, swept, strict=True)}
    return SweepColumns(columns, keys, listed, str(tree.attributes["title"]), tree.nodes["input"].texts("case_text")[0],
                        tree.attributes)

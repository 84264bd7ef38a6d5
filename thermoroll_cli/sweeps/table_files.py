"""The table of a sweep in files: CSV, and HDF5 arrays over the swept keys."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.atomic import replacing, write_bytes
from thermoroll_cli.files.result import hdf5
from thermoroll_cli.files.result.hdf5 import ResultFileError, read_result
from thermoroll_cli.problem.result import Result
from thermoroll_cli.sweeps.points import Value
from thermoroll_cli.sweeps.table import TEXTS, Rows, SweepColumns, attributes_of

FORMAT_VERSION = 2
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
        hdf5.stamp(file, FORMAT_VERSION, kind=KIND, title=points.case(1).settings.title, command_line=command_line)
        for name, text in inputs.items():
            hdf5.create(file, f"input/{name}", hdf5.fixed_text(text))
        scales = [hdf5.dimension_scale(file, key, values, **attributes_of(key, table.keys))
                  for key, values in coordinates.items()]
        for name, flat in columns.items():
            hdf5.label(hdf5.create(file, name, flat.reshape(points.shape), scales), **attributes_of(name, table.keys))

    write_bytes(path, hdf5.image_of(fill))


def _array(values: Sequence[Value]) -> NDArray[Any]:
    """Numbers as they are, words as bytes."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower().encode() if isinstance(value, bool) else str(value).encode() for value in values])
    return np.asarray(values)


# --- reading ---------------------------------------------------------------------------------------------------------


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
    with hdf5.opened(path, KIND, FORMAT_VERSION) as file:
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

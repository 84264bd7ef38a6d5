"""The scalars of many points: in one HDF5 file, where every scalar is an array over the swept keys, which are its coordinates;
and read back from it, or from the CSV table of a sweep."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.files.atomic import replacing
from thermoroll_cli.files.result.hdf5 import LAYOUT, ResultFileError, create, dimension_scale, fixed_text, label, opened, stamp
from thermoroll_cli.problem.names import ALL_SCALARS

FORMAT_VERSION = 2
KIND = "sweep"
PREFIXES = {"isothermal": "without thermal deformation: ", "error": "estimated error: "}


@dataclass(frozen=True)
class SweepColumns:
    """The table of a sweep: `columns` with a value per point (numbers, texts; nan where not computed), the swept `keys` among
    them, whether the points are a list (`listed`) or all combinations of values, and the `title` of the case, if known."""

    columns: Mapping[str, Sequence[Any]]
    keys: tuple[str, ...]
    listed: bool
    title: str = ""


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
    columns = {name: [_cell(text) for text in column] for name, column in zip(header, zip(*rows, strict=True), strict=True)}
    keys = tuple(header[: header.index("status")])
    return SweepColumns(columns, keys, math.prod(len(set(columns[key])) for key in keys) != len(rows))


def _cell(text: str) -> float | str:
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
        return SweepColumns(columns, keys, listed, file.attrs["title"].decode())


def _flat(values: NDArray[Any]) -> list[Any]:
    return [value.decode() if isinstance(value, bytes) else value for value in values.ravel().tolist()]


def write_sweep_file(
    path: pathlib.Path, coordinates: Mapping[str, Sequence[Any]], columns: Mapping[str, NDArray[Any]], *, listed: bool,
    case_text: str, settings: Sequence[str], command_line: str, title: str,
) -> None:
    """Write `columns`, flat arrays with a value per point of `coordinates`, the last of which varies fastest. The coordinates
    of `listed` points are columns, too, over one dimension `point`. Complete or not at all; raises WriteError."""
    with replacing(path) as temporary, h5py.File(temporary, "w", libver=LAYOUT) as file:
        stamp(file, FORMAT_VERSION, kind=KIND, title=title, command_line=command_line)
        inputs = file.create_group("input")
        for name, text in {"case_text": case_text, "settings": json.dumps(list(settings)),
                           "keys": json.dumps(list(coordinates))}.items():  # fmt: skip
            inputs[name] = fixed_text(text)
        if listed:
            count = len(next(iter(coordinates.values())))
            columns = {**{key: _array(values) for key, values in coordinates.items()}, **columns}
            coordinates = {"point": range(1, count + 1)}
        meaning = "number of the point" if listed else "swept key {}"
        scales = [dimension_scale(file, key, _array(values), long_name=meaning.format(key))
                  for key, values in coordinates.items()]
        shape = tuple(len(values) for values in coordinates.values())
        for name, flat in columns.items():
            state, _, own = name.rpartition(".")
            meaning = PREFIXES.get(state, "") + (ALL_SCALARS[own].meaning if own in ALL_SCALARS else name)
            label(create(file, name, flat.reshape(shape), scales), long_name=meaning)


def _array(values: Sequence[Any]) -> NDArray[Any]:
    """Numbers as they are, words as bytes."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower().encode() if isinstance(value, bool) else str(value).encode() for value in values])
    return np.asarray(values)

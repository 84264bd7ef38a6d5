"""The scalars of many points in one HDF5 file that a killed program cannot damage.

Every scalar is an array over the swept keys, which are its coordinates. All arrays are laid out, and the HDF5 structure closed,
before the first point is solved; from then on rows are written straight into their places, so that nothing in the file's
structure ever changes and other programs can read it at any time. A row counts when its checksum, written last, is right.
"""

from __future__ import annotations

import datetime
import json
import math
import os
import pathlib
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli import __version__
from thermoroll_cli.files.atomic import WriteError, replacing
from thermoroll_cli.files.provenance import provenance
from thermoroll_cli.files.result.hdf5 import LAYOUT, PROGRAM, ResultFileError, fixed_text, label
from thermoroll_cli.problem.names import ALL_SCALARS, HERTZ_SCALARS, SCALARS, SUBSURFACE_SCALARS

FORMAT_VERSION = 1
KIND = "sweep"
NUMBERS = (*SCALARS, *HERTZ_SCALARS, *(f"{state}.{name}" for state in ("isothermal", "error") for name in SCALARS),
           "work.applications")
"""Columns of numbers that every file has, nan where not computed."""
TEXTS = {"status": 13, "reason": 240, "unbounded": 64, "work.grid": 12}
"""Columns of texts, with their lengths in bytes; all empty where a point is not solved yet."""
CHECKSUM = "row_checksum"
BLOCK = 512
"""Rows read at once."""

Coordinates = Mapping[str, Sequence[int | float]]


@dataclass(frozen=True)
class ScalarRow:
    """The row of point `number` (from 1): `numbers` in the order of `ScalarFile.numbers`, with nan for those that are left out
    at the end, `texts` in that of `TEXTS`."""

    number: int
    numbers: tuple[float, ...]
    texts: tuple[str, ...]


@dataclass(frozen=True)
class ScalarFile:
    """A file at `path` for the points of `coordinates`, the last of which varies fastest; `identity` tells the case apart.
    `offsets` are the places of the columns in the file; `below` are the scalars below the surface among them."""

    path: pathlib.Path
    coordinates: Coordinates
    identity: str
    offsets: Mapping[str, int]
    below: tuple[str, ...] = ()

    @property
    def numbers(self) -> tuple[str, ...]:
        """Columns of numbers."""
        return _numbers(self.below)

    @property
    def count(self) -> int:
        return math.prod(len(values) for values in self.coordinates.values())

    @classmethod
    def create(
        cls, path: pathlib.Path, coordinates: Coordinates, identity: str, *, texts: Mapping[str, str], command_line: str,
        title: str, below: Sequence[str] = (), old: ScalarFile | None = None,
    ) -> ScalarFile:
        """A file without rows, in the place of any other, but for those rows of `old` (another sweep of the same keys) whose
        coordinates occur here, too. `texts` go into the group `input`; scalars `below` the surface get columns, too. Raises
        WriteError."""

        with replacing(path) as temporary:
            with h5py.File(temporary, "w", libver=LAYOUT) as file:
                _write_structure(file, coordinates, identity, texts, command_line, title, below)
            if old is not None:
                made = cls.open(temporary)
                made.write(old._rows_at(coordinates))
        return cls.open(path)

    @classmethod
    def open(cls, path: pathlib.Path) -> ScalarFile:
        """Raises ResultFileError for a file that is foreign, cut short, damaged or of another version."""

        try:
            with h5py.File(path, "r", locking=False) as file:
                if file.attrs.get("program", b"").decode() != PROGRAM or file.attrs.get("kind", b"").decode() != KIND:
                    raise ResultFileError(f"{path}: an HDF5 file, but no {PROGRAM} sweep")
                if file.attrs["format_version"] != FORMAT_VERSION:
                    raise ResultFileError(f"{path}: sweep format {file.attrs['format_version']}; this version reads "
                                          f"{FORMAT_VERSION} only")
                keys = json.loads(file["input/keys"].asstr()[()])
                coordinates = {key: file[key][()].tolist() for key in keys}
                shape = tuple(len(values) for values in coordinates.values())
                offsets = {}
                below = tuple(name for name in SUBSURFACE_SCALARS if name in file)
                for name in (*_numbers(below), *TEXTS, CHECKSUM):
                    item = file[name]
                    if item.shape != shape or item.dtype != _dtype(name) or item.id.get_offset() is None:
                        raise ValueError(f"column {name} has another shape")
                    offsets[name] = int(item.id.get_offset())
                return cls(path, coordinates, file["input/identity"].asstr()[()], offsets, below)
        except FileNotFoundError:
            raise ResultFileError(f"{path}: no such file") from None
        except ResultFileError:
            raise
        except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError) as cause:
            raise ResultFileError(f"{path}: not a whole sweep file ({' '.join(str(cause).split())})") from cause

    def write(self, rows: Sequence[ScalarRow]) -> None:
        """Put `rows` into their places. Raises WriteError."""
        if not rows:
            return
        rows = sorted(rows, key=lambda row: row.number)
        numbers = np.full((len(rows), len(self.numbers)), math.nan)
        for values, row in zip(numbers, rows, strict=True):
            values[: len(row.numbers)] = row.numbers
        texts = [np.array([_cut(row.texts[i], size) for row in rows], dtype=f"S{size}")
                 for i, size in enumerate(TEXTS.values())]
        places = np.array([row.number - 1 for row in rows])
        # Neighbours are written together.
        runs = np.split(np.arange(len(rows)), np.flatnonzero(np.diff(places) != 1) + 1)
        columns: list[tuple[str, NDArray[Any]]] = list(zip(self.numbers, numbers.T.copy(), strict=True))
        columns += [*zip(TEXTS, texts, strict=True), (CHECKSUM, _checksums(numbers, texts))]
        try:
            descriptor = os.open(self.path, os.O_WRONLY)
            try:
                for name, values in columns:
                    for run in runs:
                        place = self.offsets[name] + int(places[run[0]]) * values.dtype.itemsize
                        _write_at(descriptor, values[run[0] : run[-1] + 1].tobytes(), place)
            finally:
                os.close(descriptor)
        except OSError as cause:
            raise WriteError(self.path, cause) from cause

    def finished(self) -> NDArray[np.bool_]:
        """Which points have a whole row, (count,) in the order of their numbers."""
        return np.concatenate([block[CHECKSUM] for block in self.blocks()])

    def blocks(self) -> Iterator[dict[str, NDArray[Any]]]:
        """The columns, some thousand rows at a time: numbers, texts as bytes, and for the checksum whether it is right."""
        with open(self.path, "rb") as stream:
            for first in range(0, self.count, BLOCK):
                size = min(BLOCK, self.count - first)
                columns = {name: _read_at(stream, offset, first, size, _dtype(name)) for name, offset in self.offsets.items()}
                right = _checksums(np.stack([columns[name] for name in self.numbers], axis=1),
                                   [columns[name] for name in TEXTS])
                columns[CHECKSUM] = (columns[CHECKSUM] == right) & (columns["status"] != b"")
                yield columns

    def _rows_at(self, coordinates: Coordinates) -> list[ScalarRow]:
        """The finished rows whose coordinates are among others of the same names, with the numbers they have there."""
        names = list(coordinates)
        shape = tuple(len(values) for values in self.coordinates.values())
        places = [{value: i for i, value in enumerate(coordinates[name])} for name in names]
        order = [list(self.coordinates).index(name) for name in names]
        values = list(self.coordinates.values())
        new_shape = tuple(len(v) for v in coordinates.values())
        found, number = [], 0
        for block in self.blocks():
            for row in range(len(block[CHECKSUM])):
                index = np.unravel_index(number, shape)
                number += 1
                if not block[CHECKSUM][row]:
                    continue
                there = [places[k].get(values[i][int(index[i])]) for k, i in enumerate(order)]
                if None not in there:
                    place = int(np.ravel_multi_index([k for k in there if k is not None], new_shape)) + 1
                    found.append(ScalarRow(place, tuple(float(block[name][row]) for name in self.numbers),
                                           tuple(block[name][row].decode("utf-8", "replace") for name in TEXTS)))
        return found


def _write_structure(
    file: h5py.File, coordinates: Coordinates, identity: str, texts: Mapping[str, str], command_line: str, title: str,
    below: Sequence[str],
) -> None:
    file.attrs["format_version"] = FORMAT_VERSION
    label(file, program=PROGRAM, program_version=__version__, kind=KIND, title=title, command_line=command_line,
          created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"), **provenance())
    inputs = file.create_group("input")
    for name, text in {**texts, "identity": identity, "keys": json.dumps(list(coordinates))}.items():
        inputs[name] = fixed_text(text)
    scales = []
    for key, values in coordinates.items():
        scale = file.create_dataset(key, data=np.asarray(values), track_times=False)
        scale.make_scale(key)
        label(scale, long_name=f"swept key {key}")
        scales.append(scale)
    shape = tuple(len(values) for values in coordinates.values())
    for name in (*_numbers(below), *TEXTS, CHECKSUM):
        item = _create_column(file, name, shape)
        for dimension, scale in zip(item.dims, scales, strict=True):
            dimension.attach_scale(scale)
        state, _, own = name.rpartition(".")
        long_name = ALL_SCALARS[own].meaning if own in ALL_SCALARS else name
        prefix = {"isothermal": "without thermal deformation: ", "error": "estimated error: "}.get(state, "")
        label(item, long_name=prefix + long_name)


def _numbers(below: Sequence[str]) -> tuple[str, ...]:
    return (*NUMBERS, *below, *(f"error.{name}" for name in below))


def _create_column(file: h5py.File, name: str, shape: tuple[int, ...]) -> h5py.Dataset:
    """An array whose place in the file is fixed at once."""

    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_obj_track_times(False)
    dtype = _dtype(name)
    if dtype.kind == "f":
        properties.set_fill_value(np.array(math.nan))
        properties.set_fill_time(h5py.h5d.FILL_TIME_ALLOC)
    else:
        # Nothing is written: the operating system gives zeros, and room on the disk when it is needed.
        properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(dtype, logical=True), space, properties))


def _dtype(name: str) -> np.dtype[Any]:
    if name in TEXTS:
        return np.dtype(f"S{TEXTS[name]}")
    return np.dtype(np.uint32 if name == CHECKSUM else np.float64)


def _checksums(numbers: NDArray[np.float64], texts: Sequence[NDArray[Any]]) -> NDArray[np.uint32]:
    """CRC-32 of each row of (rows, columns) with its texts."""
    raw = np.concatenate([np.ascontiguousarray(part).view(np.uint8).reshape(len(numbers), -1) for part in (numbers, *texts)],
                         axis=1)
    return np.array([zlib.crc32(row) for row in raw], dtype=np.uint32)


def _cut(text: str, size: int) -> bytes:
    """As many characters of `text` as have room."""
    whole = " ".join(text.split()).encode("utf-8", "backslashreplace")
    return whole if len(whole) <= size else whole[: size - 4].decode("utf-8", "ignore").encode() + b" ..."


def _write_at(descriptor: int, content: bytes, place: int) -> None:
    while content:
        written = os.pwrite(descriptor, content, place)
        content, place = content[written:], place + written


def _read_at(stream: Any, offset: int, first: int, size: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    wanted = size * dtype.itemsize
    content = os.pread(stream.fileno(), wanted, offset + first * dtype.itemsize)
    if len(content) < wanted:
        raise ResultFileError(f"{stream.name}: cut short")
    return np.frombuffer(content, dtype=dtype)

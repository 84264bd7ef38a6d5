"""The scalars of many points in one HDF5 file: every scalar is an array over the swept keys, which are its coordinates."""

from __future__ import annotations

import datetime
import json
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli import __version__
from thermoroll_cli.files.atomic import replacing
from thermoroll_cli.files.provenance import provenance
from thermoroll_cli.files.result.hdf5 import LAYOUT, PROGRAM, fixed_text, label
from thermoroll_cli.problem.names import ALL_SCALARS

FORMAT_VERSION = 2
KIND = "sweep"
PREFIXES = {"isothermal": "without thermal deformation: ", "error": "estimated error: "}


def write_sweep_file(
    path: pathlib.Path, coordinates: Mapping[str, Sequence[Any]], columns: Mapping[str, NDArray[Any]], *, listed: bool,
    case_text: str, settings: Sequence[str], command_line: str, title: str,
) -> None:
    """Write `columns`, flat arrays with a value per point of `coordinates`, the last of which varies fastest. The coordinates
    of `listed` points are columns, too, over one dimension `point`. Complete or not at all; raises WriteError."""
    with replacing(path) as temporary, h5py.File(temporary, "w", libver=LAYOUT) as file:
        file.attrs["format_version"] = FORMAT_VERSION
        label(file, program=PROGRAM, program_version=__version__, kind=KIND, title=title, command_line=command_line,
              created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"), **provenance())
        inputs = file.create_group("input")
        for name, text in {"case_text": case_text, "settings": json.dumps(list(settings)),
                           "keys": json.dumps(list(coordinates))}.items():  # fmt: skip
            inputs[name] = fixed_text(text)
        if listed:
            count = len(next(iter(coordinates.values())))
            columns = {**{key: _array(values) for key, values in coordinates.items()}, **columns}
            coordinates = {"point": range(1, count + 1)}
        scales = []
        for key, values in coordinates.items():
            scale = file.create_dataset(key, data=_array(values), track_times=False)
            scale.make_scale(key)
            label(scale, long_name="number of the point" if listed else f"swept key {key}")
            scales.append(scale)
        shape = tuple(len(values) for values in coordinates.values())
        for name, flat in columns.items():
            item = file.create_dataset(name, data=flat.reshape(shape), track_times=False)
            for dimension, scale in zip(item.dims, scales, strict=True):
                dimension.attach_scale(scale)
            state, _, own = name.rpartition(".")
            label(item, long_name=PREFIXES.get(state, "") + (ALL_SCALARS[own].meaning if own in ALL_SCALARS else name))


def _array(values: Sequence[Any]) -> NDArray[Any]:
    """Numbers as they are, words as bytes."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower().encode() if isinstance(value, bool) else str(value).encode() for value in values])
    return np.asarray(values)

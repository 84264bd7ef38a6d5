"""One HDF5 file per solve: fields as arrays with dimensions and units, scalars as attributes, and the case itself.

The file is built in memory and written in one go (`atomic.write_bytes`): HDF5 has no good answer to a disk that fills
up while a file is open, a byte string has.

Layout (format version 1)::

    /               format_version, program, program_version, created, command_line, title, converged; versions of Python,
                    numpy, scipy, FFTW, pyFFTW, h5py, HDF5, and the platform
    /input          case_text, case_json (as read and resolved), problem_json (SI, as solved)
    /fields         x, y and the 2-D fields of `FIELDS` in SI units, coupled state
    /isothermal     the same for the isothermal geometry; a hard link to /fields where nothing feeds back. With x and y of its
                    own where the domain has followed a heated contact
    /mesh           point coordinates for XDMF; those of /isothermal in /mesh_isothermal, if they differ
    /subsurface     lower, upper: stresses inside the bodies, where the case asks for them (`subsurface_groups`)
    /summary        scalars under their public names; subgroups isothermal and error; work as JSON
    /history        residuals per iteration
"""

from __future__ import annotations

import dataclasses
import datetime
import json
import os
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from thermoroll_cli import __version__
from thermoroll_cli.files.atomic import write_bytes
from thermoroll_cli.files.provenance import provenance
from thermoroll_cli.files.result.hdf5_text import LAYOUT, fixed_text, label, storable
from thermoroll_cli.files.result.stored import FORMAT_VERSION, ITERATION, PROGRAM, ResultFileError, read_result
from thermoroll_cli.files.result.subsurface_groups import write_subsurface
from thermoroll_cli.problem.names import FIELDS, Field
from thermoroll_cli.problem.result import Result, State

BLOCK_SIZE = 4 * 1024 * 1024
"""Step by which the file in memory grows: large enough that big files are not copied over and over."""

__all__ = ["ResultFileError", "read_result", "write_result"]


def write_result(path: str | os.PathLike[str], result: Result, *, case_text: str, case_json: str, command_line: str) -> None:
    """Write `result` and the case it came from to `path`, complete or not at all.

    Equal results give bit-identical datasets; only the root attributes `created` and `command_line` tell two runs
    apart.

    Raises `atomic.WriteError` (an OSError) with a plain message if the disk is full, the folder read-only, ….
    """

    with h5py.File("in memory", "w", driver="core", backing_store=False, block_size=BLOCK_SIZE, libver=LAYOUT) as file:
        _write_root(file, result, command_line)
        _write_texts(
            file.create_group("input"),
            case_text=case_text,
            case_json=case_json,
            problem_json=json.dumps(dataclasses.asdict(result.problem) | {"title": storable(result.problem.title)}),
        )
        _write_state(file.create_group("fields"), result.coupled)
        if result.isothermal is result.coupled:
            file["isothermal"] = file["fields"]
        else:
            _write_state(file.create_group("isothermal"), result.isothermal)
        _write_mesh(file.create_group("mesh"), result.x, result.y)
        if result.own_grids:
            _write_mesh(file.create_group("mesh_isothermal"), result.isothermal.x, result.isothermal.y)
        if result.subsurface is not None:

            write_subsurface(file, result.subsurface, result.x, result.y)
        _write_summary(file.create_group("summary"), result.summary())
        _write_history(file.create_group("history"), result.history)
        file.flush()
        image = file.id.get_file_image()
    write_bytes(path, image)


def _write_root(file: h5py.File, result: Result, command_line: str) -> None:
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["converged"] = bool(result.converged)
    label(
        file,
        program=PROGRAM,
        program_version=__version__,
        created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        command_line=command_line,
        title=result.problem.title,
        **provenance(),
    )


def _write_texts(group: h5py.Group, **texts: str) -> None:
    # Datasets, because an attribute is held in memory whole and case files may be of any size.
    for name, text in texts.items():
        _create(group, name, fixed_text(text))


def _write_state(group: h5py.Group, state: State) -> None:
    x = _write_scale(group, "x", state.x, "m", "along rolling, trailing edge at +x")
    y = _write_scale(group, "y", state.y, "m", "lateral")
    for name, values in state.fields.items():
        field = FIELDS.get(name) or Field(name, "", name)
        # The state is a label of three values; eight bytes for each would be a sixth of the file.
        dtype = np.int8 if name == "state" else np.float64
        dataset = _create(group, name, np.asarray(values, dtype=dtype))
        dataset.dims[0].attach_scale(x)
        dataset.dims[1].attach_scale(y)
        label(dataset, units=field.unit, long_name=field.meaning)


def _write_mesh(group: h5py.Group, x: ArrayLike, y: ArrayLike) -> None:
    """Coordinates of every point, (nx, ny, 3). XDMF's rectilinear meshes want x as the fastest index and these
    fields have it slowest, so ParaView needs the points spelt out; compressed they take a few kilobytes."""
    across, along = np.meshgrid(np.asarray(x, dtype=np.float32), np.asarray(y, dtype=np.float32), indexing="ij")
    points = np.stack([across, along, np.zeros_like(across)], axis=-1)
    scales = [
        _write_scale(group, name, np.arange(length), "1", f"index along {name}")
        for name, length in zip("ijc", points.shape, strict=True)
    ]
    dataset = _create(group, "points", points, chunks=True, compression="gzip", compression_opts=1)
    for dimension, scale in zip(dataset.dims, scales, strict=True):
        dimension.attach_scale(scale)
    label(dataset, units="m", long_name="x, y, z of the element centres")


def _write_summary(group: h5py.Group, summary: Mapping[str, Any]) -> None:
    attributes = group.attrs
    for name, value in summary.items():
        if name in ("isothermal", "error"):
            _write_summary(group.create_group(name), value)
        elif isinstance(value, (Mapping, list, tuple)):
            label(group, **{name: json.dumps(value, default=_plain)})
        elif isinstance(value, str):
            label(group, **{name: value})
        else:
            attributes[name] = _number(value)


def _write_history(group: h5py.Group, history: Mapping[str, ArrayLike]) -> None:
    for name, values in history.items():
        residuals = np.asarray(values, dtype=np.float64).ravel()
        dataset = _create(group, name, residuals)
        # Each history has a length of its own, so each has a dimension of its own.
        scale = _write_scale(group, name + ITERATION, np.arange(residuals.size), "1", "iteration")
        dataset.dims[0].attach_scale(scale)


def _write_scale(group: h5py.Group, name: str, values: ArrayLike, units: str, long_name: str) -> h5py.Dataset:
    scale = _create(group, name, np.asarray(values))
    scale.make_scale(name)
    label(scale, units=units, long_name=long_name)
    return scale


def _create(group: h5py.Group, name: str, content: NDArray[Any], **options: Any) -> h5py.Dataset:
    """A dataset that does not depend on the time of writing and whose damage is noticed on reading."""
    checked = content.ndim > 0 and content.size > 0
    options = {"chunks": content.shape if checked else None, "fletcher32": checked, **options}
    return group.create_dataset(name, data=content, dtype=content.dtype, track_times=False, **options)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays as what JSON knows."""
    return value.tolist() if hasattr(value, "tolist") else str(value)

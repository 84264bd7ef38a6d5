"""One HDF5 file per solve: fields as arrays with dimensions and units, scalars as attributes, and the case itself.

The file is built in memory and written in one go (`atomic.write_bytes`): HDF5 has no good answer to a disk that fills up
while a file is open, a byte string has. The layout: docs/read_results.md, "Result files".
"""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import functools
import json
import math
import os
import pathlib
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import h5py
import numpy as np
import scipy
from numpy.typing import ArrayLike
from pydantic import TypeAdapter

from thermoroll_cli import __version__
from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.numerics.convolution import fftw
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    FIELDS,
    PROBLEM_SCALARS,
    STRENGTH_FIELDS,
    SUBSURFACE_FIELDS,
    SUBSURFACE_SCALARS,
    Field,
)
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import BodyStresses, Peak, Result, State, Subsurface

FORMAT_VERSION = 3
"""Raised whenever a reader of the previous layout would misread a file."""

PROGRAM = "thermoroll"

LAYOUT = ("v108", "v108")
"""HDF5 1.8's layout on disk, which every reader of today knows. Unlike the older default it carries checksums: damage
becomes an error message, where the HDF5 library would otherwise crash or hang."""

ITERATION = "_iteration"
"""End of the name of a history's dimension scale."""

BODY_PARTS = {
    "": ("fields", "zxy", ""),
    "plane_": ("plane", "zx", " on the plane y = plane_y"),
    "below_stressed_": ("below_stressed", "z", " below the largest von Mises stress"),
    "below_hottest_": ("below_heated", "z", " below the hottest point of the surface"),
}
"""How the names of datasets of a body begin → part of `BodyStresses`, axes, and words added to the meaning of a field."""

POINTS = Field("points", "m", "x, y, z of the element centres")
SIDES = {"lower": -1.0, "upper": 1.0}
"""Signs of the heights of layers in /mesh."""


class ResultFileError(OSError):
    """A file is not a result of this program, or not a whole one. The message names it and its fault."""


def write_result(path: str | os.PathLike[str], result: Result, command_line: str = "Python") -> None:
    """Write the file of `file_image` to `path`, complete or not at all. Raises `atomic.WriteError` (an OSError) with a plain
    message if the disk is full, the folder read-only, …."""
    write_bytes(path, file_image(result, command_line))


def file_image(result: Result, command_line: str, *, more: Callable[[h5py.File], None] = lambda file: None) -> bytes:
    """The content of the file of a `result` and the case it came from; `more` adds groups of its own.

    Equal results give bit-identical datasets; only the root attributes `created` and `command_line` differ between two runs.
    """
    def fill(file: h5py.File) -> None:
        stamp(file, FORMAT_VERSION, command_line=command_line, title=result.problem.title)
        # Datasets, because an attribute is held in memory whole and case files may be of any size.
        for name, text in (("case_text", result.case_text), ("case_json", result.case_json)):
            create(file, f"input/{name}", fixed_text(text))
        _write_result(file, result)
        more(file)

    return image_of(fill)


def image_of(fill: Callable[[h5py.File], None]) -> bytes:
    """The content of the HDF5 file that `fill` fills. It is made in memory: HDF5 crashes if the disk is full."""
    # It grows by so large steps that big files are not copied over and over.
    with h5py.File("in memory", "w", driver="core", backing_store=False, block_size=4 * 2**20, libver=LAYOUT) as file:
        fill(file)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


def stamp(file: h5py.File, version: int, **texts: str) -> None:
    """Root attributes of every HDF5 file of this program: who wrote it, when, with which libraries on which platform."""
    pyfftw = fftw()
    file.attrs["format_version"] = version
    label(file, program=PROGRAM, program_version=__version__,
          created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"), **texts,
          python_version=platform.python_version(), numpy_version=np.__version__, scipy_version=scipy.__version__,
          fftw_version=pyfftw.fftw_version, pyfftw_version=pyfftw.__version__, h5py_version=h5py.__version__,
          hdf5_version=h5py.version.hdf5_version, platform=f"{platform.system()} {platform.release()} {platform.machine()}")


def _write_result(group: h5py.Group, result: Result) -> None:
    """All of a result but its case; the contacts of an assembly as groups of the same layout."""
    group.attrs["converged"] = bool(result.converged)
    problem = dataclasses.asdict(result.problem) | {"title": storable(result.problem.title)}
    create(group, "input/problem_json", fixed_text(json.dumps(problem)))
    if result.assembly:
        label(group, assembly=result.assembly)
    else:
        _write_fields(group, result)
    if result.record:
        label(group, record=json.dumps(result.record))
    for name, line in result.lines.items():
        create(group, f"lines/{name}", line)
    for patch in result.contacts:
        _write_result(group.create_group(f"patches/{patch.name}"), patch)
    summary = result.summary()
    if result.contacts:
        del summary["patches"]
    _write_summary(group.create_group("summary"), summary)
    histories = group.create_group("history")
    for name, values in result.history.items():
        residuals = np.asarray(values, dtype=np.float64).ravel()
        # Each history has a length of its own, so each has a dimension of its own.
        iterations = dimension_scale(histories, name + ITERATION, np.arange(residuals.size), units="1", long_name="iteration")
        create(histories, name, residuals, [iterations])


def _write_fields(group: h5py.Group, result: Result) -> None:
    _write_state(group.create_group("fields"), result.coupled)
    _write_mesh(group.create_group("mesh"), result.coupled)
    if result.isothermal is result.coupled:
        group["isothermal"] = group["fields"]
    else:
        _write_state(group.create_group("isothermal"), result.isothermal)
    if result.own_grids:
        _write_mesh(group.create_group("mesh_isothermal"), result.isothermal)
    for body, stresses in result.bodies.items():
        _write_body(group, body, stresses, result.coupled)


def _write_state(group: h5py.Group, state: State) -> None:
    scales = _plane_scales(group, state)
    for name, values in state.fields.items():
        field = FIELDS.get(name) or Field(name, "", name)
        # The state is a label of three values; eight bytes for each would be a sixth of the file.
        stored = np.asarray(values, dtype=np.int8 if name == "state" else np.float64)
        create(group, name, stored, scales, field)


def _write_mesh(group: h5py.Group, state: State) -> None:
    """Coordinates of every point, (nx, ny, 3). XDMF's rectilinear meshes want x as the fastest index and these
    fields have it slowest, so ParaView needs explicit points; compressed they have a few kilobytes."""
    points = _points(state.x, state.y, np.zeros(1))[:, :, 0]
    scales = [dimension_scale(group, name, np.arange(length), units="1", long_name=f"index along {name}")
              for name, length in zip("ijc", points.shape, strict=True)]
    create(group, "points", points, scales, POINTS, chunks=True, compression="gzip", compression_opts=1)


def _points(*axes: AnyArray) -> AnyArray:
    """Coordinates (…, 3) in single precision of the points of a grid."""
    return np.stack(np.meshgrid(*(np.asarray(axis, dtype=np.float32) for axis in axes), indexing="ij"), axis=-1)


def _write_body(file: h5py.Group, body: str, stresses: BodyStresses, state: State) -> None:
    group = file.create_group(f"subsurface/{body}")
    scales = dict(zip("xy", _plane_scales(group, state), strict=True))
    depths = np.asarray(stresses.depths, dtype=np.float64)
    scales["z"] = dimension_scale(group, "z", depths, units="m", long_name="depth, into the body")
    for prefix, (part, axes, where) in BODY_PARTS.items():
        for name, values in getattr(stresses, part).items():
            field = SUBSURFACE_FIELDS[name]
            layered = (1, *values.shape[1:]) if values.ndim > 1 else values.shape
            field = dataclasses.replace(field, meaning=field.meaning + where)
            create(group, prefix + name, values, [scales[axis] for axis in axes], field, chunks=layered)
    for name, values in stresses.strength.items():
        create(group, name, values, [scales[axis] for axis in "zy"[: values.ndim]], STRENGTH_FIELDS[name])
    group.attrs["plane_y"] = stresses.plane_y
    group.attrs.update({f"stressed_{name}": value for name, value in vars(stresses.most_stressed).items()})
    if stresses.hottest is not None:
        group.attrs.update({f"hottest_{name}": value for name, value in vars(stresses.hottest).items() if name != "z"})
    if stresses.fields:
        points = np.moveaxis(_points(state.x, state.y, SIDES[body] * stresses.depths), 2, 0)
        create(file, f"mesh/subsurface_{body}", points, (), POINTS, chunks=(1, *points.shape[1:]), compression="gzip",
               compression_opts=1)  # fmt: skip


def _write_summary(group: h5py.Group, summary: Mapping[str, Any]) -> None:
    for name, value in summary.items():
        if name in ("isothermal", "error"):
            _write_summary(group.create_group(name), value)
        elif isinstance(value, (Mapping, list, tuple)):
            label(group, **{name: json.dumps(value)})
        elif isinstance(value, str):
            label(group, **{name: value})
        else:
            group.attrs[name] = math.nan if value is None else float(value)


def _plane_scales(group: h5py.Group, state: State) -> list[h5py.Dataset]:
    return [dimension_scale(group, "x", state.x, units="m", long_name="along rolling, trailing edge at +x"),
            dimension_scale(group, "y", state.y, units="m", long_name="lateral")]


def dimension_scale(group: h5py.Group, name: str, values: ArrayLike, **texts: str) -> h5py.Dataset:
    """A dimension scale, with attributes such as its units."""
    scale = create(group, name, np.asarray(values))
    scale.make_scale(name)
    label(scale, **texts)
    return scale


def create(
    group: h5py.Group, name: str, content: AnyArray, scales: Sequence[h5py.Dataset] = (), field: Field | None = None,
    **options: Any,
) -> h5py.Dataset:
    """A dataset over `scales`, labelled as its `field`, that does not depend on the time of writing."""
    dataset = group.create_dataset(name, data=content, dtype=content.dtype, track_times=False, **options)
    for dimension, scale in zip(dataset.dims, scales, strict=bool(scales)):
        dimension.attach_scale(scale)
    if field is not None:
        label(dataset, units=field.unit, long_name=field.meaning)
    return dataset


def label(item: h5py.HLObject, **texts: str) -> None:
    """Attributes of `item` that are texts."""
    for name, text in texts.items():
        content = fixed_text(text)
        item.attrs.create(name, content, dtype=content.dtype)


def fixed_text(value: str) -> AnyArray:
    """`value` in an array of fixed length: HDF5 keeps texts of variable length in a heap without checksums and may loop forever
    on a damaged one."""
    encoded = storable(value).encode()
    return np.array(encoded, dtype=h5py.string_dtype("utf-8", max(1, len(encoded))))


def storable(value: str) -> str:
    """`value` as HDF5 can hold it: no NUL (TOML may spell one), no lone surrogates (file names may have them)."""
    return value.replace("\0", "\N{REPLACEMENT CHARACTER}").encode("utf-8", "backslashreplace").decode()


def read_result(path: str | os.PathLike[str], *, with_fields: bool = True) -> Result:
    """The result in the file that `thermoroll run` or `Result.save` wrote.

    Parameters:

    - `path`: the HDF5 file;
    - `with_fields`: False leaves fields and histories out, if only the scalars and the case matter.

    Raises ResultFileError (an OSError), with a plain message, for a file that is missing, unreadable, foreign, truncated,
    damaged or of another version."""
    with opened(path, "result", FORMAT_VERSION) as file:
        texts = {name: file[f"input/{name}"].asstr()[()] for name in ("case_text", "case_json")}
        result = _read(file, with_fields).with_case(texts["case_text"], texts["case_json"])
        return dataclasses.replace(result, attributes={name: _python(value) for name, value in file.attrs.items()})


@contextlib.contextmanager
def opened(path: str | os.PathLike[str], kind: str, version: int) -> Iterator[h5py.File]:
    """The HDF5 file of this `kind` and `version` at `path`, to be read inside. Raises ResultFileError for another file, and for
    every error inside: the exception that damage causes depends on which byte is wrong."""
    path = pathlib.Path(path)
    if fault := _fault(path):
        raise ResultFileError(f"{path}: {fault}")
    try:
        # No lock: files are replaced whole, never edited, and some network file systems cannot lock.
        with h5py.File(path, "r", locking=False) as file:
            if _python(file.attrs.get("program")) != PROGRAM or "format_version" not in file.attrs:
                raise ResultFileError(f"{path}: an HDF5 file, but not a {PROGRAM} {kind}")
            stored = _python(file.attrs.get("kind", "result"))
            if stored != kind:
                raise ResultFileError(f"{path}: a {PROGRAM} {stored}, not a {kind}")
            if (written := int(file.attrs["format_version"])) != version:
                by = _python(file.attrs.get("program_version", "unknown"))
                raise ResultFileError(f"{path}: {kind} format {written}, written by {PROGRAM} {by}; this version reads format "
                                      f"{version} only: make it again")
            yield file
    except ResultFileError:
        raise
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError, OverflowError, MemoryError) as cause:
        detail = cause.args[0] if cause.args else type(cause).__name__
        damage = "truncated HDF5 file, its end is missing" if "truncated" in str(cause) else f"damaged {kind} file ({detail})"
        raise ResultFileError(f"{path}: {damage}") from cause


def _fault(path: pathlib.Path) -> str:
    """Why the file at `path` cannot be HDF5; empty if it may be."""
    if path.exists() and not path.is_file():
        return "this is a folder, not a result file" if path.is_dir() else "not a regular file"
    try:
        with open(path, "rb") as stream:
            start = stream.read(8)
    except FileNotFoundError:
        return "no such file"
    except OSError as cause:
        return f"cannot be read ({cause.strerror or cause})"
    if not start:
        return "the file is empty"
    return "" if start == b"\x89HDF\r\n\x1a\n" else "not an HDF5 file"


def _read(group: h5py.Group, with_fields: bool) -> Result:
    summary = _read_attributes(group["summary"])
    # In the order of the declarations: HDF5 has its attributes by alphabet.
    numbers = {name: value for name, value in summary.items() if isinstance(value, int | float)}
    assembly = _python(group.attrs.get("assembly", ""))
    of_problem = {name: numbers.pop(name) for name in PROBLEM_SCALARS if name in numbers}
    below = {} if assembly else {name: numbers.pop(name) for name in SUBSURFACE_SCALARS if name in numbers}
    error = _read_attributes(group["summary/error"])
    error_below = {} if assembly else {name: error.pop(name) for name in SUBSURFACE_SCALARS if name in error}
    if assembly:
        coupled = isothermal = State({}, _ordered(numbers), np.zeros(0), np.zeros(0))
    else:
        coupled = isothermal = _read_state(group["fields"], numbers, with_fields)
        if group["isothermal"] != group["fields"]:
            isothermal = _read_state(group["isothermal"], _read_attributes(group["summary/isothermal"]), with_fields)
    bodies = {body: _read_body(part) for body, part in group["subsurface"].items()} if with_fields and below else {}
    # Scales are recognised by their names: asking HDF5 would read references, which carry no checksum.
    history = {name: item[()] for name, item in group["history"].items() if not name.endswith(ITERATION)} if with_fields else {}
    contacts = [dataclasses.replace(_read(part, with_fields), name=name) for name, part in group.get("patches", {}).items()]
    return Result(
        problem=_problem_adapter().validate_json(group["input/problem_json"].asstr()[()]),
        coupled=coupled,
        isothermal=isothermal,
        of_problem=of_problem,
        converged=bool(group.attrs["converged"]),
        reason=summary["reason"],
        error=error,
        work=summary.get("work", {}),
        history=history,
        warnings=tuple(summary.get("warnings", ())),
        patches=tuple(contacts) or tuple(summary.get("patches", ())),
        unbounded=tuple(summary.get("unbounded", ())),
        subsurface=Subsurface(bodies, below, error_below) if below else None,
        assembly=assembly,
        record=json.loads(_python(group.attrs.get("record", "{}"))),
        lines={name: item[()] for name, item in group.get("lines", {}).items()} if with_fields else {},
    )


def _ordered(scalars: Mapping[str, float]) -> dict[str, float]:
    """`scalars` in the order of their declarations."""
    return {name: scalars[name] for name in ALL_SCALARS if name in scalars} | dict(scalars)


@functools.cache
def _problem_adapter() -> TypeAdapter[Problem]:
    """Reads problems; made once, which takes a third of the time of reading a file."""
    return TypeAdapter(Problem)


def _read_state(group: h5py.Group, scalars: Mapping[str, float], with_fields: bool) -> State:
    x, y = group["x"][()], group["y"][()]
    if not all((np.diff(axis) > 0.0).all() for axis in (x, y)):
        raise ValueError("its coordinates do not increase")
    fields = {name: dataset[()] for name, dataset in group.items() if with_fields and name not in ("x", "y")}
    for name, values in fields.items():
        if values.shape != (x.size, y.size):
            raise ValueError(f"field {name} has shape {values.shape}, its coordinates {(x.size, y.size)}")
    return State(fields, _ordered(scalars), x, y)


def _read_body(group: h5py.Group) -> BodyStresses:
    parts: dict[str, dict[str, AnyArray]] = {part: {} for part, _, _ in BODY_PARTS.values()}
    strength: dict[str, AnyArray] = {}
    for name, dataset in group.items():
        if name in STRENGTH_FIELDS:
            strength[name] = dataset[()]
        elif name not in ("x", "y", "z"):
            prefix = next(prefix for prefix in reversed(BODY_PARTS) if name.startswith(prefix))
            parts[BODY_PARTS[prefix][0]][name.removeprefix(prefix)] = dataset[()]
    at = {name: float(value) for name, value in group.attrs.items()}
    stressed = Peak(at["stressed_value"], at["stressed_x"], at["stressed_y"], at["stressed_z"])
    hottest = Peak(at["hottest_value"], at["hottest_x"], at["hottest_y"], 0.0) if "hottest_value" in at else None
    return BodyStresses(group["z"][()], at["plane_y"], most_stressed=stressed, hottest=hottest, strength=strength, **parts)


def _read_attributes(group: h5py.Group) -> dict[str, Any]:
    """The attributes of a group of /summary; texts that hold JSON are read."""
    attributes = {name: _python(value) for name, value in group.attrs.items()}
    texts = {name for name, value in attributes.items()
             if isinstance(value, str) and value[:1] in ("{", "[")} - {"status", "reason"}
    return {name: json.loads(value) if name in texts else value for name, value in attributes.items()}


def _python(value: Any) -> Any:
    """An attribute as a plain Python value."""
    if isinstance(value, bytes):
        return value.decode("utf-8")
    return value.item() if isinstance(value, np.generic) else value

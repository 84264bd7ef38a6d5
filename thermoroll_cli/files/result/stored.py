"""A result file read back as the `Result` that it was written from."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from thermoroll_cli.files.result.subsurface_groups import read_subsurface
from thermoroll_cli.problem.names import HERTZ_SCALARS, SCALARS, SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.subsurface import Subsurface

FORMAT_VERSION = 1
"""Raised whenever a reader of the previous layout would misread a file."""

PROGRAM = "thermoroll"

ITERATION = "_iteration"
"""What the name of a history's dimension scale ends with."""

_NOT_FIELDS = ("x", "y")


class ResultFileError(OSError):
    """A file is not a result of this program, or not a whole one. The message names it and says what is wrong."""


def read_result(path: str | os.PathLike[str], *, with_fields: bool = True) -> Result:
    """The result in the file at `path`; without its fields and histories if only the scalars and the case matter.

    Raises ResultFileError for a file that is missing, unreadable, foreign, truncated, damaged or of another version.
    """

    path = pathlib.Path(path)
    _check_plain_file(path)
    try:
        # No lock: files are replaced whole, never edited, and some network file systems cannot lock.
        file = h5py.File(path, "r", locking=False)
    except OSError as cause:
        raise ResultFileError(f"{path}: {_open_failure(path, cause)}") from cause
    # Past this point the file is HDF5. What damage inside it raises depends on which byte is wrong.
    try:
        with file:
            _check_origin(path, file)
            return _read(file, with_fields)
    except ResultFileError:
        raise
    except (
        OSError,
        KeyError,
        ValueError,
        TypeError,
        AttributeError,
        RuntimeError,
        OverflowError,
        MemoryError,
    ) as cause:
        detail = cause.args[0] if cause.args else type(cause).__name__
        raise ResultFileError(f"{path}: damaged result file ({detail})") from cause


def _check_plain_file(path: pathlib.Path) -> None:
    try:
        if path.is_dir():
            raise ResultFileError(f"{path}: this is a folder, not a result file")
        if path.exists() and not path.is_file():
            raise ResultFileError(f"{path}: not a regular file")
        if not path.exists():
            raise ResultFileError(f"{path}: no such file")
        with open(path, "rb"):
            pass
    except ResultFileError:
        raise
    except OSError as cause:
        raise ResultFileError(f"{path}: cannot be read ({cause.strerror or cause})") from cause


def _open_failure(path: pathlib.Path, cause: OSError) -> str:
    if path.stat().st_size == 0:
        return "the file is empty"
    if "truncated" in str(cause):
        return "truncated HDF5 file, its end is missing"
    with open(path, "rb") as stream:
        signature = stream.read(8)
    if signature != b"\x89HDF\r\n\x1a\n":
        return "not an HDF5 file"
    return f"damaged HDF5 file ({cause})"


def _check_origin(path: pathlib.Path, file: h5py.File) -> None:
    if _python(file.attrs.get("program")) != PROGRAM or "format_version" not in file.attrs:
        raise ResultFileError(f"{path}: an HDF5 file, but not a {PROGRAM} result")
    if "kind" in file.attrs:
        raise ResultFileError(f"{path}: a {PROGRAM} {_python(file.attrs['kind'])} of many points, not the result of one")
    version = int(file.attrs["format_version"])
    if version != FORMAT_VERSION:
        written_by = _python(file.attrs.get("program_version", "unknown"))
        raise ResultFileError(
            f"{path}: result format {version}, written by {PROGRAM} {written_by}; this version reads format "
            f"{FORMAT_VERSION} only"
        )


def _read(file: h5py.File, with_fields: bool) -> Result:
    summary = _read_summary(file["summary"])
    same = file["isothermal"] == file["fields"]
    # The order of the declarations: HDF5 has its attributes by alphabet.
    numbers = {name: value for name, value in summary.items() if isinstance(value, int | float)}
    hertz = {name: numbers.pop(name) for name in HERTZ_SCALARS if name in numbers}
    below = {name: numbers.pop(name) for name in SUBSURFACE_SCALARS if name in numbers}
    errors_below = {name: summary["error"].pop(name) for name in SUBSURFACE_SCALARS if name in summary["error"]}
    coupled = _read_state(file["fields"], numbers, with_fields)
    # Scales are told by their names: asking HDF5 would read references, which carry no checksum.
    history = {name: item[()] for name, item in file["history"].items() if not name.endswith(ITERATION)} if with_fields else {}
    inputs = file["input"]
    return Result(
        problem=TypeAdapter(Problem).validate_json(inputs["problem_json"].asstr()[()]),
        coupled=coupled,
        isothermal=coupled if same else _read_state(file["isothermal"], summary["isothermal"], with_fields),
        hertz=hertz,
        converged=bool(file.attrs["converged"]),
        reason=summary["reason"],
        error=summary["error"],
        work=summary.get("work", {}),
        history=history,
        warnings=tuple(summary.get("warnings", ())),
        case_text=inputs["case_text"].asstr()[()],
        case_json=inputs["case_json"].asstr()[()],
        patches=tuple(summary.get("patches", ())),
        unbounded=tuple(summary.get("unbounded", ())),
        subsurface=Subsurface(read_subsurface(file) if with_fields else {}, below, errors_below) if below else None,
        attributes={name: _python(value) for name, value in file.attrs.items()},
    )


def _read_state(group: h5py.Group, scalars: Mapping[str, float], with_fields: bool) -> State:
    x, y = group["x"][()], group["y"][()]
    ordered = {name: scalars[name] for name in SCALARS if name in scalars}
    return State(_read_fields(group, (x.size, y.size)) if with_fields else {}, {**ordered, **scalars}, x, y)


def _read_fields(group: h5py.Group, shape: tuple[int, int]) -> dict[str, NDArray[Any]]:
    fields = {name: dataset[()] for name, dataset in group.items() if name not in _NOT_FIELDS}
    for name, values in fields.items():
        if values.shape != shape:
            raise ValueError(f"field {name} has shape {values.shape}, its coordinates {shape}")
    return fields


def _read_summary(group: h5py.Group) -> dict[str, Any]:
    summary: dict[str, Any] = {}
    for name, value in group.attrs.items():
        plain = _python(value)
        is_json = isinstance(plain, str) and plain[:1] in ("{", "[") and name not in ("status", "reason")
        summary[name] = json.loads(plain) if is_json else plain
    for name in ("isothermal", "error"):
        summary[name] = {key: _python(value) for key, value in group[name].attrs.items()}
    return summary


def _python(value: Any) -> Any:
    """An attribute as a plain Python value."""
    if isinstance(value, bytes):
        return value.decode("utf-8")
    return value.item() if isinstance(value, np.generic) else value

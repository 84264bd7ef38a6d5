"""Trees of labelled arrays, and the HDF5 files that hold them: every file of numbers of this program.

A node has arrays over named axes, each with its unit and its meaning, attributes, and further nodes. An array over the axis of
its own name is that axis. `xarray.open_datatree` opens the same files.

A file is built in memory and written in one go (`atomic.write_bytes`): HDF5 has no good answer to a disk that fills up while a
file is open, a byte string has. A file is checked before it is read, since anybody may have written it: it may name other
files, claim more numbers than the memory holds, or be damaged.
"""

from __future__ import annotations

import datetime
import functools
import io
import json
import math
import os
import pathlib
import platform
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import h5py
import numpy as np
import scipy
from h5py import h5a, h5d, h5ds, h5g, h5l, h5o, h5p, h5s, h5t

from thermoroll_cli import __version__
from thermoroll_cli.physics.numerics.convolution import fftw
from thermoroll_cli.tools.arrays import AnyArray
from thermoroll_cli.tools.atomic import write_bytes

FORMAT_VERSION = 4
"""Raised whenever a reader of the previous layout would misread a file."""

PROGRAM = "thermoroll"

LAYOUT = ("v110", "v110")
"""HDF5 1.10's layout on disk: the oldest with checksums over everything that says where numbers lie."""

MOST_COMPRESSED = 64
"""Bytes of numbers per byte in a file; ours have 5 at most, and one of 20,000 would fill the memory from a small file."""

MADE_BY = {"sweep": "sweep", "creep_force_table": "table build"}
"""Kind of a file → the command that writes it, if that is another one than `run`."""

Attribute = str | int | float


class ResultFileError(OSError):
    """A file is not one of this program, or not a whole one. The message names it and its fault."""


class Labelled(NamedTuple):
    """`values` over `axes`, numbers or texts, with their unit and meaning; `compressed` in a file, for very many."""

    axes: tuple[str, ...]
    values: AnyArray
    units: str = ""
    meaning: str = ""
    compressed: bool = False


@dataclass(frozen=True)
class Node:
    """`arrays` and further `nodes` by name, and `attributes`."""

    arrays: Mapping[str, Labelled] = field(default_factory=dict)
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    nodes: Mapping[str, Node] = field(default_factory=dict)

    def texts(self, name: str) -> list[str]:
        """The array `name` of texts."""
        return [str(value) for value in self.arrays[name].values.tolist()]

    def text(self, name: str) -> str:
        """The only text of the array `name`. Raises ValueError where it has none, or several, or numbers."""
        if self.arrays[name].values.shape != (1,) or not isinstance(found := self.arrays[name].values[0], str):
            raise ValueError(f"{name} is not one text")
        return str(found)

    def json(self, name: str, default: Any = None) -> Any:
        """The attribute `name`, a text in JSON; `default` where there is none."""
        return json.loads(str(self.attributes[name])) if name in self.attributes else default


def axis(name: str, values: Any, units: str = "", meaning: str = "") -> dict[str, Labelled]:
    """The array that is the axis `name`."""
    return {name: Labelled((name,), np.asarray(values), units, meaning)}


def of_texts(texts: Mapping[str, str]) -> Node:
    """Texts of any length by name: an attribute is held in memory whole."""
    return Node(axis("part", [0]) | {name: Labelled(("part",), np.array([storable(text)])) for name, text in texts.items()})


# --- writing ---------------------------------------------------------------------------------------------------------


def save(path: str | os.PathLike[str], tree: Node, kind: str, command_line: str = "Python") -> None:
    """Write the file of `image` to `path`, complete or not at all. Raises `atomic.WriteError` (an OSError) with a plain message
    if the disk is full, the folder read-only, …."""
    write_bytes(path, image(tree, kind, command_line))


def image(tree: Node, kind: str, command_line: str) -> bytes:
    """The content of the file of a `tree`, of a `kind` as "result". Equal trees give bit-identical datasets; only the root
    attributes `created` and `command_line` differ between two runs."""
    content = io.BytesIO()  # the image of a file in memory, HDF5's own, has a wrong checksum before HDF5 2
    with h5py.File(content, "w", libver=LAYOUT) as file:
        pyfftw = fftw()
        _write(h5g.open(file.id, b"/"), Node(tree.arrays, {
            **tree.attributes, "program": PROGRAM, "kind": kind, "format_version": FORMAT_VERSION,
            "program_version": __version__, "command_line": command_line,
            "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "python_version": platform.python_version(), "numpy_version": np.__version__, "scipy_version": scipy.__version__,
            "fftw_version": pyfftw.fftw_version, "pyfftw_version": pyfftw.__version__, "h5py_version": h5py.__version__,
            "hdf5_version": h5py.version.hdf5_version,
            "platform": f"{platform.system()} {platform.release()} {platform.machine()}"}, tree.nodes))  # fmt: skip
    return content.getvalue()


def _write(group: h5g.GroupID, node: Node) -> None:
    for name, value in node.attributes.items():
        _attribute(group, name, value)
    written: dict[str, h5d.DatasetID] = {}
    for name, array in sorted(node.arrays.items(), key=lambda item: item[1].axes != (item[0],)):  # axes first
        values = np.ascontiguousarray(array.values)
        if values.dtype.kind in "UO":
            texts = [text.encode("utf-8", "backslashreplace") for text in values.ravel().tolist()]
            values = np.array(texts, dtype=bytes).reshape(values.shape)
        made = h5p.create(h5p.DATASET_CREATE)
        made.set_obj_track_times(False)
        if values.size:
            made.set_chunk(values.shape if values.ndim < 3 else (1, *values.shape[1:]))
            if array.compressed:
                made.set_shuffle()
                made.set_deflate(4)
            made.set_fletcher32()
        item = h5d.create(group, name.encode(), _stored(values.dtype.kind, values.dtype.itemsize),
                          h5s.create_simple(values.shape), made)  # fmt: skip
        item.write(h5s.ALL, h5s.ALL, values, mtype=_stored(values.dtype.kind, values.dtype.itemsize))
        for label, text in (("axes", " ".join(array.axes)), ("units", array.units), ("long_name", array.meaning)):
            if text:
                _attribute(item, label, text)
        written[name] = item
        if array.axes == (name,):
            h5ds.set_scale(item, name.encode())
        else:
            for number, along in enumerate(array.axes):
                h5ds.attach_scale(item, written[along], number)
    for name, inner in node.nodes.items():
        _write(h5g.create(group, name.encode()), inner)


_ONE = h5s.create(h5s.SCALAR)


def _attribute(item: h5g.GroupID | h5d.DatasetID, name: str, value: Attribute) -> None:
    """A new attribute. Texts have a fixed length: HDF5 keeps others in a heap without checksums. `AttributeManager.create`
    takes four times as long."""
    content = np.array(storable(value).encode() or b"\0" if isinstance(value, str) else value)
    kind = _stored(content.dtype.kind, max(1, content.dtype.itemsize))
    h5a.create(item, name.encode(), kind, _ONE).write(content, mtype=kind)


@functools.cache
def _stored(kind: str, size: int) -> h5t.TypeID:
    """The HDF5 type of numbers, and of texts of `size` bytes."""
    return h5t.py_create(h5py.string_dtype("utf-8", size) if kind == "S" else np.dtype(f"{kind}{size}"), logical=True)


def storable(value: str) -> str:
    """`value` as HDF5 can hold it: no NUL (TOML may spell one), no lone surrogates (file names may have them)."""
    return value.replace("\0", "\N{REPLACEMENT CHARACTER}").encode("utf-8", "backslashreplace").decode()


# --- reading ---------------------------------------------------------------------------------------------------------


def load(path: str | os.PathLike[str], kind: str, without: Collection[str] = ()) -> Node:
    """The tree in the file of this `kind` at `path`, but for the arrays of nodes called as one of `without`. Raises
    ResultFileError for a file that is missing, unreadable, foreign, damaged, or of another kind or version."""
    path = pathlib.Path(path)
    if fault := _fault(path):
        raise ResultFileError(f"{path}: {fault}")
    try:
        # No lock: files are replaced whole, never edited, and some network file systems cannot lock.
        with h5py.File(path, "r", locking=False) as file:
            known = {name: _value(file, name) for name in ("program", "kind", "format_version", "program_version")
                     if name in file.attrs}
            if known.get("program") != PROGRAM or "format_version" not in known:
                raise ResultFileError(f"{path}: an HDF5 file, but not a {PROGRAM} {kind}")
            if (stored := known.get("kind", "result")) != kind:
                raise ResultFileError(f"{path}: a {PROGRAM} {stored}, not a {kind}")
            if (version := known["format_version"]) != FORMAT_VERSION:
                raise ResultFileError(
                    f"{path}: {kind} format {version}, written by {PROGRAM} {known.get('program_version', 'unknown')}; this "
                    f"version reads format {FORMAT_VERSION} only: make it again with thermoroll {MADE_BY.get(kind, 'run')}")
            # All of it is checked before anything is read.
            return _read(_checked(file, {h5o.get_info(file.id).addr}, without))
    except ResultFileError:
        raise
    except _Foreign as cause:
        raise ResultFileError(f"{path}: damaged or foreign {kind} file ({cause})") from None
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError, OverflowError, MemoryError) as cause:
        detail = cause.args[0] if cause.args else type(cause).__name__
        damage = "truncated HDF5 file, its end is missing" if "truncated" in str(cause) else f"damaged {kind} file ({detail})"
        raise ResultFileError(f"{path}: {damage}") from cause


def kind_of(path: pathlib.Path) -> Any:
    """The kind of which the file at `path` says it is; None of a damaged one, and reading it reports the fault."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return _value(file, "kind")
    except (OSError, RuntimeError, KeyError, ValueError):
        return None


class _Foreign(ValueError):
    """What no file of this program has."""


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


class _Checked(NamedTuple):
    """A group, its arrays that are to be read, with their axes, and the groups inside."""

    group: h5py.Group
    arrays: dict[str, tuple[h5py.Dataset, tuple[str, ...]]]
    inside: dict[str, _Checked]


def _checked(group: h5py.Group, seen: set[int], without: Collection[str]) -> _Checked:
    """What is to be read of a `group`. Raises _Foreign for what no file of this program has: links into other files, numbers
    that lie elsewhere, are no numbers or texts, or fill more than the file could hold."""
    found = _Checked(group, {}, {})
    for name in group:
        where = f"{group.name.rstrip('/')}/{name}"
        if group.id.links.get_info(name.encode()).type != h5l.TYPE_HARD:
            raise _Foreign(f"{where} is a link")
        item = group[name]
        address = h5o.get_info(item.id).addr
        if address in seen:
            raise _Foreign(f"{where} has two names")
        seen.add(address)
        if isinstance(item, h5py.Group):
            found.inside[name] = _checked(item, seen, without)
            continue
        if not isinstance(item, h5py.Dataset):
            raise _Foreign(f"{where} is neither a group nor an array")
        kind, made = item.id.get_type(), item.id.get_create_plist()
        if made.get_external_count() or made.get_layout() == h5d.VIRTUAL:
            raise _Foreign(f"{where} lies in another file")
        if kind.get_class() not in (h5t.INTEGER, h5t.FLOAT) and not (
                kind.get_class() == h5t.STRING and not kind.is_variable_str()):
            raise _Foreign(f"{where} holds neither numbers nor texts")
        size = math.prod(item.shape) * kind.get_size()
        if item.id.get_space().get_simple_extent_type() != h5s.SIMPLE or size > MOST_COMPRESSED * item.id.get_storage_size():
            raise _Foreign(f"{where} is to hold {item.shape} numbers, which the file has not")
        found.arrays[name] = item, tuple(str(_value(item, "axes")).split())
    for item, axes in found.arrays.values():
        if len(set(axes)) < len(axes) or item.shape != tuple(found.arrays[along][0].shape[0] for along in axes):
            raise _Foreign(f"{item.name} has the shape {item.shape}, and not that of its axes {', '.join(axes)}")
    return found._replace(arrays={}) if group.name.rpartition("/")[2] in without else found


def _read(checked: _Checked) -> Node:
    arrays = dict[str, Labelled]()
    for name, (item, axes) in checked.arrays.items():
        values = item[()]
        if values.dtype.kind == "S":
            texts = np.empty(values.shape, dtype=object)
            texts.ravel()[:] = [text.decode("utf-8") for text in values.ravel().tolist()]
            values = texts
        units, meaning = (str(_value(item, label)) if h5a.exists(item.id, label.encode()) else ""
                          for label in ("units", "long_name"))
        arrays[name] = Labelled(axes, values, units, meaning)
    return Node(arrays, {name: _value(checked.group, name) for name in checked.group.attrs},
                {name: _read(inner) for name, inner in checked.inside.items()})


def _value(item: h5py.HLObject, name: str) -> Attribute:
    """An attribute as a plain Python value. Raises _Foreign for another than a number or a text."""
    attribute = h5a.open(item.id, name.encode())
    kind = attribute.get_type()
    if attribute.shape or kind.get_class() not in (h5t.INTEGER, h5t.FLOAT, h5t.STRING) or (
            kind.get_class() == h5t.STRING and kind.is_variable_str()):
        raise _Foreign(f"the attribute {name} of {item.name} is neither a number nor a text")
    content = np.empty((), dtype=attribute.dtype)
    attribute.read(content)
    value: bytes | int | float = content.item()
    return value.decode("utf-8") if isinstance(value, bytes) else value

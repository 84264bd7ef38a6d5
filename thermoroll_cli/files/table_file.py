"""Tables of many states in files: CSV, and HDF5 arrays over what was varied."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from thermoroll_cli.files.csv_table import image_of_rows
from thermoroll_cli.files.result.labelled import Labelled, Node, ResultFileError, axis, image, kind_of, load, of_texts
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.columns import CASE, TEXTS, Columns
from thermoroll_cli.problem.kinds import every_kind
from thermoroll_cli.problem.names import FIELDS, PLACES, column_of
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.tools.arrays import AnyArray
from thermoroll_cli.tools.atomic import write_bytes

SWEEP, HISTORY = "sweep", "history"
"""Kinds of files of tables."""
ENDS = "_history.csv", "_history.h5"
"""How the names of the files of a history end, behind that of the result."""


def write_csv(path: pathlib.Path, table: Columns) -> None:
    """Replace the file at `path` by one with this table. Raises WriteError."""
    write_bytes(path, _csv(table))


def _csv(table: Columns) -> bytes:
    return image_of_rows(table.columns, (map(_cell, cells) for cells in zip(*table.columns.values(), strict=True)))


def _cell(value: Any) -> str:
    """A number with all its digits, nothing for one that was not computed."""
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def columns_node(table: Columns) -> Node:
    """The columns as arrays over the axes of the table, which must have a state for each place there."""
    axes = table.coordinates
    shape, arrays = [len(values) for values in axes.values()], dict[str, Labelled]()
    for name, values in axes.items():
        label = column_of(name, table.varied) if name in table else ("", f"number of the {name}")
        arrays |= axis(name, _array(values.tolist()), *label)
    for name, column in table.columns.items():
        if name not in axes and name != "file":
            arrays[name] = Labelled(table.over, _array(column).reshape(shape), *column_of(name, table.varied))
    return Node(arrays)


def tree_of_table(table: Columns, **texts: str) -> Node:
    """The tree of the file of a table, with the text of its case and other `texts` by name; fields of states in `fields`."""
    return Node(columns_node(table).arrays, {"title": table.title, "keys": json.dumps(table.varied)}, {
        "input": of_texts({"case_text": table.case_text, **texts}), "fields": fields_node(table.states)})


def history_files(stem: str, result: Result, command_line: str) -> dict[str, bytes]:
    """The contents of STEM_history.csv and STEM_history.h5 by their names; none of another result than one over time."""
    if result.history is None:
        return {}
    return {f"{stem}{ENDS[0]}": _csv(result.history),
            f"{stem}{ENDS[1]}": image(tree_of_table(result.history), HISTORY, command_line)}


def fields_node(states: Mapping[int, State]) -> Node:
    """The fields of states on one grid over the number of their row, x and y; of a line contact over x alone."""
    if not states:
        return Node()
    first = next(iter(states.values()))
    arrays = axis("row", np.array(list(states)), "", "row of the table") | (
        axis("x", first.x, "m", "along rolling, trailing edge at +x")
        | (axis("y", first.y, "m", "lateral") if len(first.y) else {}))
    for name, field in FIELDS.items():
        if all(name in state.fields for state in states.values()):
            kind = np.int8 if name == "state" else np.float64
            stack = np.stack([np.asarray(state.fields[name], dtype=kind) for state in states.values()])
            # One number everywhere would be compressed beyond what readers take for honest.
            arrays[name] = Labelled(("row", "x", "y")[: stack.ndim], stack, field.unit, field.meaning,
                                    compressed=bool(np.ptp(stack)))
    return Node(arrays)


def _array(values: Sequence[Any]) -> AnyArray:
    """Numbers as they are, words as texts."""
    if any(isinstance(value, bool | str) for value in values):
        return np.array([str(value).lower() if isinstance(value, bool) else str(value) for value in values], dtype=object)
    return np.asarray(values)


# --- reading ---------------------------------------------------------------------------------------------------------


def is_table(path: pathlib.Path) -> bool:
    """Whether the file at `path` says that it holds the table of many states."""
    return path.suffix.lower() == ".csv" or kind_of(path) in (SWEEP, HISTORY)


def read_stored(path: pathlib.Path, *, with_fields: bool = False) -> Result | Columns:
    """What the file at `path` holds: a result, or the table of many states, `with_fields` if wanted. Raises ResultFileError."""
    return read_table(path, with_fields=with_fields) if is_table(path) else read_result(path)


def history_beside(path: pathlib.Path) -> Columns | None:
    """The table of the history whose last state the result at `path` is, if it lies beside. Raises ResultFileError."""
    beside = (path.with_name(f"{path.stem}{end}") for end in reversed(ENDS))
    found = next((each for each in beside if path.suffix == ".h5" and each.exists()), None)
    return None if found is None else read_table(found)


def read_table(path: pathlib.Path, *, with_fields: bool = False) -> Columns:
    """The table in the file at `path`, as `sweep` writes sweep.csv and sweep.h5, and `run` NAME_history.csv and
    NAME_history.h5, the latter `with_fields` if wanted. Raises ResultFileError."""
    try:
        return _read_csv(path) if path.suffix.lower() == ".csv" else _read_hdf5(path, with_fields=with_fields)
    except ResultFileError:
        raise
    except (OSError, ValueError, KeyError, IndexError, StopIteration, csv.Error) as cause:
        reason = cause.strerror if isinstance(cause, OSError) and cause.strerror else "not the table of a sweep or of a history"
        raise ResultFileError(f"{path}: {reason}") from cause


def _read_csv(path: pathlib.Path) -> Columns:
    with open(path, encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    if any(keys and (*header[: len(keys)],) == keys for keys in (kind.answer.contact_keys for kind in every_kind())):
        # The exported contacts of an assembly.
        raise ValueError
    columns = {name: [_value(text) for text in column] for name, column in zip(header, zip(*rows, strict=True), strict=True)}
    keys = tuple(header[: header.index("status")])
    over: tuple[str, ...] = ("time_s",) if set(PLACES) <= {*keys} else keys
    if math.prod(len(set(columns[key])) for key in over) != len(rows):
        over = ("point",)
    # A table of text lacks the case, which a result beside it has; that of a sweep of several cases has none of its own.
    of_history = (path.stem.removesuffix("_history") + ".h5",) if path.stem.endswith("_history") else ()
    for name in (*(() if CASE in columns else columns.get("file", ())), *of_history):
        if isinstance(name, str) and name and path.with_name(name).exists():
            beside = read_result(path.with_name(name), with_fields=False)
            return Columns(columns, keys, over, beside.problem.title, beside.case_text, beside.attributes)
    return Columns(columns, keys, over)


def _value(text: str) -> float | str:
    try:
        return float(text) if text else math.nan
    except ValueError:
        return text


def _read_hdf5(path: pathlib.Path, *, with_fields: bool) -> Columns:
    tree = load(path, HISTORY if kind_of(path) == HISTORY else SWEEP, () if with_fields else ("fields",))
    keys, over = tuple(tree.json("keys")), tree.arrays["status"].axes
    columns = {name: array.values.ravel().tolist() for name, array in tree.arrays.items() if array.axes == over}
    if "point" not in over:
        along = np.meshgrid(*(tree.arrays[key].values for key in over), indexing="ij")
        columns |= {key: values.ravel().tolist() for key, values in zip(over, along, strict=True)}
    # As in tables of text, where what stands before the status was varied.
    columns = {name: columns[name] for name in dict.fromkeys((*keys, *TEXTS, *columns)) if name in columns}
    fields, states = tree.nodes.get("fields", Node()).arrays, dict[int, State]()
    for place, row in enumerate(fields["row"].values.tolist() if fields else ()):
        known = {name: array.values[place] for name, array in fields.items() if array.axes[:2] == ("row", "x")}
        numbers = {name: column[row] for name, column in columns.items() if isinstance(column[row], float)}
        states[row] = State(known, numbers, fields["x"].values, fields["y"].values if "y" in fields else np.zeros(0))
    title, case_text = str(tree.attributes["title"]), tree.nodes["input"].text("case_text")
    return Columns(columns, keys, over, title, case_text, tree.attributes, states)

"""Files of a wheelset: a result file for each patch, the whole as JSON, and a table of its patches."""

from __future__ import annotations

import csv
import io
import json
import math
import pathlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.files.result.hdf5 import write_result
from thermoroll_cli.wheelset.wheelset_result import WheelsetResult


def write_wheelset(
    stem: pathlib.Path, result: WheelsetResult, *, name: str, title: str, case_text: str, case_json: str, command_line: str
) -> list[pathlib.Path]:
    """Write STEM_left_1.h5, …, STEM.json and STEM.csv, and return their paths. Raises OSError with a plain message."""
    files = {patch.name: stem.with_name(f"{stem.name}_{patch.name}.h5") for patch in result.patches}
    for patch in result.patches:
        write_result(files[patch.name], replace(patch.result, case_text=case_text, case_json=case_json), command_line)
    whole, table = stem.with_name(f"{stem.name}.json"), stem.with_name(f"{stem.name}.csv")
    record = {"name": name, "title": title, **wheelset_record(result, {key: path.name for key, path in files.items()})}
    write_bytes(whole, (json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode())
    write_bytes(table, _table(record["patches"]).encode())
    return [whole, table, *files.values()]


def wheelset_record(result: WheelsetResult, files: Mapping[str, str] | None = None) -> dict[str, Any]:
    """`WheelsetResult.summary` as strict JSON: null for what was not computed."""
    record: dict[str, Any] = _finite(result.summary(files))
    return record


def _table(patches: list[dict[str, Any]]) -> str:
    """A line for each patch, with its errors in columns error.NAME."""
    rows = []
    for patch in patches:
        errors = {f"error.{name}": value for name, value in patch["error"].items() if value is not None and name in patch}
        rows.append({name: value for name, value in patch.items() if name != "error"} | errors)
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

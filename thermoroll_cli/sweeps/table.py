"""The rows of a sweep: one per point, as a table in a CSV file and as curves in a picture."""

from __future__ import annotations

import csv
import io
import math
import pathlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from thermoroll_cli.files.atomic import write_bytes
from thermoroll_cli.files.result.hdf5 import read_result
from thermoroll_cli.plots.sweep_figures import write_sweep_figure
from thermoroll_cli.problem.names import HERTZ_SCALARS, SCALARS, SUBSURFACE_SCALARS
from thermoroll_cli.sweeps.axis import Axis
from thermoroll_cli.sweeps.points import Point

CONVERGED, NOT_CONVERGED = "converged", "not_converged"
STATUS = ("status", "reason")
STATES = {"isothermal": SCALARS, "error": SCALARS}
OVER_LIMIT = {"force_x_over_friction_limit": "force_x_N", "force_y_over_friction_limit": "force_y_N"}
"""Creep forces over μW, as railway engineers plot them: column → scalar in N."""
UNBOUNDED = "unbounded"
"""Column with the names of the scalars that have no limit at this point (the contact reaches the end of a profile)."""
WORK = ("grid", "applications")
"""What of the work enters the table. Not the seconds: the tables of equal sweeps are equal."""


@dataclass(frozen=True)
class Row:
    """What became of one point. `summary` has the shape of `Result.summary()` and the columns of `OVER_LIMIT`, its numbers are
    nan for a point that has no `file`."""

    point: Point
    summary: Mapping[str, Any]
    file: pathlib.Path | None

    @property
    def converged(self) -> bool:
        return bool(self.summary["status"] == CONVERGED)

    @property
    def reason(self) -> str:
        return str(self.summary["reason"])


def row_of(point: Point, path: pathlib.Path) -> Row:
    """The row of a point from its result file. Raises OSError."""
    stored = read_result(path, with_fields=False).summary()
    scalars = {name: stored.get(name, math.nan) for name in (*STATUS, *SCALARS, *HERTZ_SCALARS)}
    states = {state: {name: stored[state].get(name, math.nan) for name in names} for state, names in STATES.items()}
    scalars |= over_limit(scalars)
    below = [name for name in SUBSURFACE_SCALARS if name in stored]
    scalars |= {name: stored[name] for name in below}
    states["error"] |= {name: stored["error"].get(name, math.nan) for name in below}
    scalars |= {UNBOUNDED: stored[UNBOUNDED]} if UNBOUNDED in stored else {}
    return Row(point, scalars | states | {name: stored.get(name) for name in ("work", "warnings")}, path)


def failed_row(point: Point, reason: str) -> Row:
    """The row of a point that has no result."""
    scalars = dict.fromkeys((*SCALARS, *HERTZ_SCALARS, *OVER_LIMIT), math.nan)
    states = {state: dict.fromkeys(names, math.nan) for state, names in STATES.items()}
    outcome = {"status": NOT_CONVERGED, "reason": reason}
    return Row(point, outcome | scalars | states | {"work": {}, "warnings": []}, None)


def over_limit(scalars: Mapping[str, Any]) -> dict[str, float]:
    """Columns of `OVER_LIMIT` from the scalars of a row; nan without friction."""
    limit = scalars["friction_limit_N"]
    return {name: scalars[force] / limit if limit > 0.0 else math.nan for name, force in OVER_LIMIT.items()}


def columns(axes: Sequence[Axis], below: Sequence[str] = ()) -> list[str]:
    """Names of the columns: swept keys, status and reason, what has no limit, scalars, forces over μW, scalars `below` the
    surface, `isothermal.` and `error.` scalars, work, file."""
    prefixed = [f"{state}.{name}" for state, names in STATES.items() for name in names] + [f"error.{name}" for name in below]
    swept = [axis.key for axis in axes]
    return [*swept, *STATUS, UNBOUNDED, *SCALARS, *HERTZ_SCALARS, *OVER_LIMIT, *below, *prefixed,
            *(f"work.{name}" for name in WORK), "file"]


def names_below(rows: Iterable[Row]) -> list[str]:
    """The scalars below the surface that any of the rows has."""
    found = {name for row in rows for name in row.summary}
    return [name for name in SUBSURFACE_SCALARS if name in found]


def cells(row: Row, axes: Sequence[Axis]) -> dict[str, Any]:
    """The values of a row by column."""
    summary = row.summary
    found: dict[str, Any] = {axis.key: value for axis, value in zip(axes, row.point.values, strict=True)}
    found |= {name: summary[name] for name in (*STATUS, *SCALARS, *HERTZ_SCALARS, *OVER_LIMIT)}
    found[UNBOUNDED] = " ".join(summary.get(UNBOUNDED, ()))
    found |= {name: summary[name] for name in SUBSURFACE_SCALARS if name in summary}
    found |= {f"{state}.{name}": value for state in STATES for name, value in summary[state].items()}
    work = summary["work"] or {}
    found["work.grid"] = "x".join(str(side) for side in work.get("grid", ()))
    found["work.applications"] = work.get("applications", "")
    return found | {"file": row.file.name if row.file else ""}


@dataclass
class TableFile:
    """The rows known so far, and the CSV file they are written to, in the order of the points."""

    path: pathlib.Path
    axes: Sequence[Axis]
    rows: dict[int, Row] = field(default_factory=dict)

    def write(self) -> None:
        """Replace the file by one with all rows known now. Raises OSError."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        names = columns(self.axes, names_below(self.rows.values()))
        writer.writerow(names)
        for row in self.in_order():
            found = cells(row, self.axes)
            # A point without a result has nothing below the surface either.
            writer.writerow([cell(found.get(name, math.nan)) for name in names])
        write_bytes(self.path, text.getvalue().encode("utf-8", "backslashreplace"))

    def in_order(self) -> list[Row]:
        return [self.rows[number] for number in sorted(self.rows)]


def draw(rows: Iterable[Row], axes: Sequence[Axis], path: pathlib.Path, title: str) -> bool:
    """Draw the scalars over the axis that varies fastest, a curve for each combination of the others. False, and no
    picture, where nothing converged or nothing varies. Raises OSError."""
    rows = list(rows)
    return draw_cells([cells(row, axes) for row in rows], axes, path, title, names_below(rows))


def draw_cells(
    rows: Sequence[Mapping[str, Any]], axes: Sequence[Axis], path: pathlib.Path, title: str, below: Sequence[str] = ()
) -> bool:
    """As `draw`, from the values of the rows by column."""

    varying = [axis.key for axis in reversed(axes) if len(axis.values) > 1]
    table = {name: [row.get(name, math.nan) for row in rows] for name in columns(axes, below)}
    if not varying or not any(
            status == CONVERGED and math.isfinite(x) for status, x in zip(table["status"], table[varying[0]], strict=True)):
        return False
    write_sweep_figure(table, varying, path, title=title)
    return True


def cell(value: Any) -> str:
    """A number with all its digits, nothing for one that was not computed."""
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value)
    return str(value)

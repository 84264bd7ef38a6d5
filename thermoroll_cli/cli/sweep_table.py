"""What `thermoroll sweep` prints at the end: the points as a table that fits the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from thermoroll_cli.cli.result_table import align, folded, number, wrapped

if TYPE_CHECKING:
    from thermoroll_cli.sweeps.axis import Axis
    from thermoroll_cli.sweeps.table import Row

SHOWN_SCALARS = (
    "creepage_longitudinal",
    "creepage_lateral",
    "speed_solved_m_s",
    "Q_F_W",
    "force_x_N",
    "force_y_N",
    "gamma_st",
    "gamma_p",
    "gamma_c",
    "temperature_rise_max_lower_K",
    "von_mises_max_lower_MPa",
    "von_mises_depth_lower_mm",
    "von_mises_max_upper_MPa",
    "von_mises_depth_upper_mm",
    "force_x_over_friction_limit",
    "force_y_over_friction_limit",
)
"""Columns in the order of their importance: a narrow terminal has room for the first ones."""
NOISE = 1e-5
SHOWN_ROWS = 40
FAILED = "NOT CONVERGED"


def table_lines(rows: Sequence[Row], axes: Sequence[Axis], width: int) -> Iterator[str]:
    """Lines of at most `width` characters: a row per point with the swept values and the scalars worth showing.

    A scalar that is the same at all points is told once. Nothing for more than `SHOWN_ROWS` points.
    """
    if len(rows) > SHOWN_ROWS:
        return
    names = [name for name in SHOWN_SCALARS if _worth_showing(name, rows, axes)]
    constant = [name for name in names if len(rows) > 1 and _is_constant(name, rows)]
    labels = [row.point.name + ("" if row.converged else f"  {FAILED}") for row in rows]
    table = [["", *labels]]
    for place, axis in enumerate(axes):
        table.append([axis.key, *(number(row.point.values[place]) for row in rows)])
    left_out: list[str] = []
    for name in (name for name in names if name not in constant):
        column = [name, *(number(row.summary.get(name)) for row in rows)]
        if left_out or _width([*table, column]) > width:
            left_out.append(name)
        else:
            table.append(column)
    headers = [wrapped(column[0], max(map(len, column[1:]))) for column in table]
    height = max(map(len, headers))
    filled = [[""] * (height - len(header)) + header + column[1:] for header, column in zip(headers, table, strict=True)]
    yield from align(list(zip(*filled, strict=True)))
    if constant:
        told = ", ".join(f"{name} = {number(_finite(name, rows)[0])}" for name in constant)
        yield from folded(f"at all points: {told}", width)
    endless = sorted({name for row in rows for name in row.summary.get("unbounded", ())})
    if endless:
        yield from folded(f"no limit where the contact reaches the end of a profile: {', '.join(endless)}", width)
    if left_out:
        yield from folded(f"more in the file: {', '.join(left_out)}", width)


def _width(table: Sequence[Sequence[str]]) -> int:
    """Characters a line takes, with headers wrapped over several lines."""
    cells = (max(len(part) for part in (*wrapped(c[0], max(map(len, c[1:]))), *c[1:])) for c in table)
    return sum(width + 2 for width in cells)


def _worth_showing(name: str, rows: Sequence[Row], axes: Sequence[Axis]) -> bool:
    """Whether the scalar `name` tells something that the swept values do not: it was computed, and is not given."""
    values = _finite(name, rows)
    motions = [row.point.problem.motion for row in rows]
    if not values:
        return False
    if name == "speed_solved_m_s":
        return any(row.summary[name] not in (motion.speed, None) and row.summary[name] == row.summary[name]
                   for row, motion in zip(rows, motions, strict=True))  # fmt: skip
    for direction, creepage, force in (("x", "creepage_longitudinal", "longitudinal"), ("y", "creepage_lateral", "lateral")):
        given = all(getattr(motion, f"force_{direction}") is not None for motion in motions)
        if name == creepage:
            return given
        if name == f"force_{direction}_N" and any(axis.key == f"force.{force}_N" for axis in axes):
            return False
    if not name.startswith("force_"):
        return True
    # What rounding leaves of a zero force is not worth a column.
    tail = name.removeprefix("force_x").removeprefix("force_y")
    largest = max(abs(value) for axis in "xy" for value in (*_finite(f"force_{axis}{tail}", rows), 0.0))
    return max(map(abs, values)) > NOISE * largest


def _is_constant(name: str, rows: Sequence[Row]) -> bool:
    return len({number(value) for value in _finite(name, rows)}) == 1 and len(_finite(name, rows)) == len(rows)


def _finite(name: str, rows: Sequence[Row]) -> list[float]:
    values = (row.summary.get(name, math.nan) for row in rows)
    return [value for value in values if value == value]

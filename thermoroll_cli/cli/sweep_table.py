"""The table that `thermoroll sweep` prints at the end, as wide as the terminal allows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from thermoroll_cli.cli.result_table import align, folded, wrapped
from thermoroll_cli.problem.scalar_errors import number

if TYPE_CHECKING:
    from thermoroll_cli.problem.problem import Motion
    from thermoroll_cli.sweeps.points import Points
    from thermoroll_cli.sweeps.table import Row

SHOWN_SCALARS = (
    "creepage_longitudinal", "creepage_lateral", "speed_solved_m_s", "Q_F_W", "force_x_N", "force_y_N", "gamma_st", "gamma_p",
    "gamma_c", "temperature_rise_max_lower_K", "von_mises_max_lower_MPa", "von_mises_depth_lower_mm", "von_mises_max_upper_MPa",
    "von_mises_depth_upper_mm", "force_x_over_friction_limit", "force_y_over_friction_limit",
)  # fmt: skip
"""Columns in the order of their importance: a narrow terminal has room for the first ones."""
NOISE = 1e-5
SHOWN_ROWS = 40
FAILED = "NOT CONVERGED"


def table_lines(rows: Sequence[Row], points: Points, width: int) -> Iterator[str]:
    """Lines of at most `width` characters: a row per point with the swept values and the scalars worth showing.

    A scalar that is the same at all points is shown once.
    """
    motions = [points.point(row.number).problem.motion for row in rows]
    swept = [axis.key for axis in points.axes]
    names = [name for name in SHOWN_SCALARS if _worth_showing(name, rows, motions, swept)]
    constant = [name for name in names if len(rows) > 1 and _is_constant(name, rows)]
    columns = [_column("", [row.name + ("" if row.converged else f"  {FAILED}") for row in rows])]
    columns += [_column(key, [_shown(row.over[key]) for row in rows]) for key in swept]
    left_out: list[str] = []
    for name in (name for name in names if name not in constant):
        column = _column(name, [number(row.summary.get(name)) for row in rows])
        if left_out or sum(2 + max(map(len, cells)) for cells in [*columns, column]) > width:
            left_out.append(name)
        else:
            columns.append(column)
    height = max(map(len, columns))
    yield from align(list(zip(*([""] * (height - len(column)) + column for column in columns), strict=True)))
    if constant:
        values = ", ".join(f"{name} = {number(_finite(name, rows)[0])}" for name in constant)
        yield from folded(f"at all points: {values}", width)
    endless = sorted({name for row in rows for name in row.summary["unbounded"]})
    if endless:
        yield from folded(f"no limit where the contact reaches the end of a profile: {', '.join(endless)}", width)
    if left_out:
        yield from folded(f"more in the file: {', '.join(left_out)}", width)


def _column(name: str, cells: list[str]) -> list[str]:
    """The lines of a header, and the `cells` below it."""
    return wrapped(name, max(map(len, cells))) + cells


def _shown(value: Any) -> str:
    return number(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def _worth_showing(name: str, rows: Sequence[Row], motions: Sequence[Motion], swept: Sequence[str]) -> bool:
    """Whether the scalar `name` adds something to the swept values: it was computed, and is not given."""
    values = _finite(name, rows)
    if not values:
        return False
    if name == "speed_solved_m_s":
        return any(row.summary[name] not in (motion.speed, None) and row.summary[name] == row.summary[name]
                   for row, motion in zip(rows, motions, strict=True))  # fmt: skip
    for direction, creepage, force in (("x", "creepage_longitudinal", "longitudinal"), ("y", "creepage_lateral", "lateral")):
        given = all(getattr(motion, f"force_{direction}") is not None for motion in motions)
        if name == creepage:
            return given
        if name == f"force_{direction}_N" and f"force.{force}_N" in swept:
            return False
    if not name.startswith("force_"):
        return True
    # The rounding noise of a zero force is not worth a column.
    tail = name.removeprefix("force_x").removeprefix("force_y")
    largest = max(abs(value) for axis in "xy" for value in (*_finite(f"force_{axis}{tail}", rows), 0.0))
    return max(map(abs, values)) > NOISE * largest


def _is_constant(name: str, rows: Sequence[Row]) -> bool:
    return len({number(value) for value in _finite(name, rows)}) == 1 and len(_finite(name, rows)) == len(rows)


def _finite(name: str, rows: Sequence[Row]) -> list[float]:
    values = (row.summary.get(name, math.nan) for row in rows)
    return [value for value in values if value == value]

"""The table of a sweep as curves in a picture. Apart from `table`, so that processes that only solve load no matplotlib."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence

from thermoroll_cli.plots import style
from thermoroll_cli.plots.fit_figures import mark_measured
from thermoroll_cli.plots.sweep_figures import sweep_figure
from thermoroll_cli.plots.wheelset_figures import wheelset_sweep_figure
from thermoroll_cli.problem.columns import CONVERGED, Columns
from thermoroll_cli.problem.names import known_as
from thermoroll_cli.studies.sweeps.measured import Measured

CASE = "case"
"""The column that tells tables drawn together apart."""
MOST_DRAWN = 20_000
"""Points of which a picture still shows something."""


def over_each_other(tables: Mapping[str, Columns]) -> Columns:
    """One table of several by the names of their cases, the column `CASE`, with the columns that all have. Raises ValueError
    where they were not varied over the same."""
    first, *others = tables.values()
    if different := next((table for table in others if {*table.varied} != {*first.varied}), None):
        raise ValueError(f"one is over {', '.join(first.label)}, another over {', '.join(different.label)}")
    shared = [name for name in first if name != CASE and all(name in table for table in tables.values())]
    columns = {name: [value for table in tables.values() for value in table[name]] for name in shared}
    columns[CASE] = [name for name, table in tables.items() for _ in range(table.count)]
    return Columns(columns, (*first.label, CASE), (*first.label, CASE))


def draw_table(
    table: Columns, path: pathlib.Path, *, compare: Sequence[str] = (), dpi: float | None = None,
    measured: Measured | None = None, x: str = "", only: Sequence[str] = (),
) -> str:
    """Draw the scalars over the column `x` of what was varied, or over the key with most numbers, or over words, a curve for
    each combination of the others; those of a list over the number of the point where several keys vary, those of a history
    over the distance rolled or over time. Of scalars that are named, `only` these are drawn. Returns why there is no picture,
    or nothing.

    Creep forces stand beside those of the theories to `compare` with, `measured` points over all; `dpi` is the resolution of
    PNG files. Raises OSError, and ValueError for what cannot be compared, or drawn: measured over another key, or of no
    diagram; no column `x` that varies, or none of those to be drawn."""
    columns = {**table, "point": list(range(1, table.count + 1))}
    varying = [key for key in reversed(table.label) if len(set(columns[key])) > 1]
    numeric = [key for key in varying if all(isinstance(value, int | float) for value in columns[key])]
    if not varying:
        return "a sweep of one point has no curve"
    if len(columns["point"]) > MOST_DRAWN:
        return f"more than {MOST_DRAWN} points"
    by_number = table.over == ("point",) and len(varying) > 1
    first = [max(numeric, key=lambda key: len(set(columns[key])))] if numeric else []
    over = ["point"] if by_number else [*first, *(key for key in reversed(varying) if key not in first)]
    if table.of_history:
        over = [table.place]
    if x:
        if x not in table.varied or len(set(columns[x])) < 2:
            raise ValueError(f"{x} was not varied, but {', '.join(reversed(varying))}")
        over = [x] if table.over == ("point",) or table.of_history else [x, *(key for key in reversed(varying) if key != x)]
    if CONVERGED not in columns["status"]:
        return "no point converged"
    with style.applied():
        if any(name.endswith(".y_rail_mm") for name in columns):
            style.save(wheelset_sweep_figure(columns, over[0], table.title), path, dpi)
            return ""
        figure = sweep_figure(columns, over, title=table.title, compare=compare, only=only)
        if measured is not None:
            if over[0] not in measured.varied:
                raise ValueError(f"{measured.source} has no column {over[0]}, over which the sweep is drawn")
            name = known_as("normal_N", columns)
            measured = measured.in_newtons([load for load, status in zip(columns[name], columns["status"], strict=True)
                                            if status == CONVERGED], name)  # fmt: skip
            if missing := mark_measured(figure, measured.varied[over[0]], measured.values, measured.deviations):
                raise ValueError(f"no diagram of this sweep shows {missing[0]}, which {measured.source} has")
        style.save(figure, path, dpi)
    return ""

"""The table of a sweep as curves in a picture. Apart from `table`, so that processes that only solve load no matplotlib."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

from thermoroll_cli.plots import style
from thermoroll_cli.plots.fit_figures import MEASURED, mark_measured
from thermoroll_cli.plots.sweep_figures import sweep_figure
from thermoroll_cli.plots.wheelset_figures import wheelset_sweep_figure
from thermoroll_cli.problem.columns import CASE, CONVERGED, Columns
from thermoroll_cli.problem.names import known_as
from thermoroll_cli.studies.sweeps.measured import Measured

MOST_DRAWN = 20_000
"""Points of which a picture still shows something."""


def over_each_other(tables: Mapping[str, Columns]) -> Columns:
    """One table of several by the names of their cases, the column `CASE`, with the columns that all have. Raises ValueError
    where they were not varied over the same."""
    first, *others = tables.values()
    if different := next((table for table in others if {*table.varied} - {CASE} != {*first.varied} - {CASE}), None):
        raise ValueError(f"one is over {', '.join(first.label)}, another over {', '.join(different.label)}")
    shared = [name for name in first if name != CASE and all(name in table for table in tables.values())]
    columns: dict[str, list[Any]] = {CASE: [f"{name}: {table[CASE][row]}" if CASE in table else name
                                            for name, table in tables.items() for row in range(table.count)]}
    columns |= {name: [value for table in tables.values() for value in table[name]] for name in shared}
    varied = (CASE, *(name for name in first.label if name != CASE))
    one_by_one = any(table.of_history or table.over == ("point",) for table in tables.values())
    return Columns(columns, varied, ("point",) if one_by_one else varied)


class NoCurve(ValueError):
    """Why a table has nothing to draw."""


def draw_table(
    table: Columns, path: pathlib.Path, *, compare: Sequence[str] = (), dpi: float | None = None,
    measured: Measured | None = None, x: str = "", only: Sequence[str] = (),
) -> str:
    """Write the picture `table_figure` to `path`; returns why there is none, or nothing. `dpi` is the resolution of PNG files.
    Raises OSError, and ValueError for what cannot be compared, or drawn."""
    try:
        with style.applied():
            style.save(table_figure(table, compare=compare, measured=measured, x=x, only=only), path, dpi)
    except NoCurve as cause:
        return str(cause)
    return ""


def table_figure(
    table: Columns, *, compare: Sequence[str] = (), measured: Measured | None = None, x: str = "", only: Sequence[str] = (),
    ax: Any = None,
) -> Any:
    """A figure of scalars over the column `x` of what was varied, or over the key with most numbers, or over words, a curve for
    each combination of the others, of which one is the case; where several keys vary in a list, over its only label with
    numbers, or over the number of the point; those of a history over the distance rolled or over time. Of scalars that are
    named, `only` these are drawn, one also on axes of the caller, `ax`.

    Creep forces stand beside those of the theories to `compare` with, `measured` points over all. Raises NoCurve where the
    table has none, and ValueError for what cannot be compared, or drawn: measured over another key, or of no diagram; no column
    `x` that varies, or none of those to be drawn."""
    cases = [CASE] if CASE in table.label and len(set(table[CASE])) > 1 else []
    columns = {**table, "point": _numbered(table[CASE] if cases else [""] * table.count)}
    varying = [key for key in reversed(table.label) if key != CASE and len(set(columns[key])) > 1] or cases
    numeric = [key for key in varying if all(isinstance(value, int | float) for value in columns[key])]
    if not varying:
        raise NoCurve("a sweep of one point has no curve")
    if len(columns["point"]) > MOST_DRAWN:
        raise NoCurve(f"more than {MOST_DRAWN} points")
    by_number = table.over == ("point",) and len(varying) > 1
    first = [max(numeric, key=lambda key: len(set(columns[key])))] if numeric else []
    # Where the points of a list lie: its only label with numbers, all of them different, else their number.
    labels = [key for key in numeric if "." not in key]
    only_label = len(labels) == 1 and len(set(columns[labels[0]])) == len(set(columns["point"]))
    numbered = labels if only_label else ["point"]
    over = [*(numbered if by_number else [*first, *(key for key in reversed(varying) if key not in first)]), *cases]
    if table.of_history:
        over = [table.place]
    if x:
        if x not in table.varied or len(set(columns[x])) < 2:
            raise ValueError(f"{x} was not varied, but {', '.join(dict.fromkeys([*cases, *reversed(varying)]))}")
        others = [] if table.over == ("point",) or table.of_history else [*reversed(varying)]
        over = [x, *(key for key in (*others, *cases) if key != x)]
    over = [*dict.fromkeys(over)]
    if CONVERGED not in columns.get("status", CONVERGED):
        raise NoCurve("no point converged")
    if any(name.endswith(".y_rail_mm") for name in columns) and len(over) == 1 and not only and measured is None:
        return wheelset_sweep_figure(columns, over[0], table.title)
    shown: Sequence[str] = [known_as(name, columns) for name in only]
    if measured is not None:
        if over[0] not in measured.varied:
            raise ValueError(f"{measured.source} has no column {over[0]}, over which the sweep is drawn")
        name = known_as("normal_N", columns)
        measured = measured.in_newtons([load for load, status in zip(columns[name], columns["status"], strict=True)
                                        if status == CONVERGED], name)  # fmt: skip
        shown = [*dict.fromkeys((*shown, *measured.values))] if only else ()
    figure = sweep_figure(columns, over, title=table.title, compare=compare, only=shown,
                          also=[MEASURED] if measured is not None else [], ax=ax)
    if measured is not None:
        if missing := mark_measured(figure, measured.varied[over[0]], measured.values, measured.deviations):
            raise ValueError(f"no diagram of this sweep shows {missing[0]}, which {measured.source} has")
    return figure


def plot_table(table: Columns, name: str, *, x: str, compare: Sequence[str], ax: Any) -> Any:
    """What `Columns.plot` draws. Raises ValueError."""
    if name and known_as(name, table) not in table:
        raise ValueError(f"no column {name!r}; there are {', '.join(table.numbers)}")
    with style.applied() if ax is None else nullcontext():  # axes of the caller keep their style
        return table_figure(table, compare=compare, x=x, only=[name] if name else [], ax=ax)


def _numbered(cases: Sequence[str]) -> list[int]:
    """The number of each state, from 1 for each of the cases."""
    counts = dict.fromkeys(cases, 0)
    numbers = []
    for case in cases:
        counts[case] += 1
        numbers.append(counts[case])
    return numbers

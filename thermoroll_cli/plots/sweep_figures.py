"""Scalars against the swept quantity (the article's Fig. 13; creep curves, speed curves)."""

from __future__ import annotations

import math
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from thermoroll_cli.plots.sheet import add_axes, few_ticks, new_figure, one_line, save, style
from thermoroll_cli.plots.sweep_columns import (
    Column,
    failed_points,
    merged,
    numbers,
    summary_of_row,
    unbounded_points,
    words_of,
)
from thermoroll_cli.plots.sweep_lines import ENDLESS, FAILED, Line, draw_legend, legend_entries, lines_of
from thermoroll_cli.problem.error_scale import absolute_error

WIDTH, HEIGHT = 2.5, 1.75
LEFT, BOTTOM, TOP, GAP_X, GAP_Y, RIGHT = 0.7, 0.5, 0.2, 1.08, 0.28, 0.5
LEGEND_ROW = 0.19
COLUMNS = 3

FLAT = 3.0
"""An axis spans at least this many times the estimated error: what is smaller is no change."""

DIAGRAMS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("frictional heat $Q_F$ (W)", ("Q_F_W",)),
    ("contact area ratio $\\gamma_c$", ("gamma_c",)),
    ("stick area ratio $\\gamma_{st}$", ("gamma_st",)),
    ("pressure ratio $\\gamma_p$", ("gamma_p",)),
    ("max. pressure (MPa)", ("pressure_max_MPa",)),
    ("max. temperature rise $\\Delta T$ (K)", ("temperature_rise_max_lower_K", "temperature_rise_max_upper_K")),
    ("creep force $F_x$ (N)", ("force_x_N",)),
    ("creep force $F_y$ (N)", ("force_y_N",)),
    ("spin moment $M_z$ (N mm)", ("spin_moment_Nmm",)),
    ("creepage $\\xi_x$", ("creepage_longitudinal",)),
    ("creepage $\\xi_y$", ("creepage_lateral",)),
    ("max. von Mises stress (MPa)", ("von_mises_max_lower_MPa", "von_mises_max_upper_MPa")),
    ("max. tensile stress (MPa)", ("tensile_stress_max_lower_MPa", "tensile_stress_max_upper_MPa")),
)
"""Label and columns of each diagram; where several columns hold values, the largest is drawn."""

PREFIXES = ("isothermal.", "isothermal_")
"""How the columns of the isothermal state may be called."""

NEGLIGIBLE = 1e-9
"""A quantity that stays below this share of its family (forces, creepages) is rounding noise and gets no diagram."""

STEADY = 1e-6
"""A creepage that is given, and ratios that only heat could change, get no diagram while they change by no more than this."""

FORCES, CREEPAGES = ("force_x_N", "force_y_N"), ("creepage_longitudinal", "creepage_lateral")


def write_sweep_figure(
    table: Mapping[str, Sequence[Any]], over: Sequence[str], path: pathlib.Path, *, title: str = ""
) -> pathlib.Path:
    """Draw the scalars of `table` (a column per name, a value per point) against the first quantity of `over`.

    There is one line for each combination of the further quantities. Columns with the prefix `isothermal.` (or
    `isothermal_`) are dashed beside the solid coupled ones where they differ. Points whose `status` is not "converged" are
    left out, and marked at the foot. The axis is logarithmic where the values are spaced so. Quantities that do not change
    or were not computed get no diagram. The format follows from the ending of `path`.

    Raises ValueError (nothing swept, a column missing, unknown format), OSError.
    """
    failed = failed_points(table)
    if not over or any(name not in table for name in over):
        raise ValueError(f"a sweep figure needs the swept quantities as columns, got {list(over)}")
    x = numbers(table[over[0]])
    if not np.any(np.isfinite(x) & ~failed):
        raise ValueError(f"the column {over[0]} holds no numbers")
    lines = lines_of(table, over, x, failed)
    x = x[~failed]
    table = {name: [value for value, bad in zip(column, failed, strict=True) if not bad] for name, column in table.items()}
    diagrams = [(label, names) for label, names in DIAGRAMS if _worth_drawing(table, names, over)]
    columns = min(COLUMNS, max(1, len(diagrams)))
    rows = max(1, -(-len(diagrams) // columns))
    states = _states(table, [name for _, names in diagrams for name in names])
    endless = any(unbounded_points(table, names).any() for _, names in diagrams)
    legend = legend_entries(lines, states, endless=endless)
    legend_rows = -(-len(legend) // columns)
    width = LEFT + columns * WIDTH + (columns - 1) * GAP_X + RIGHT
    bottom = BOTTOM + legend_rows * LEGEND_ROW
    height = bottom + rows * HEIGHT + (rows - 1) * GAP_Y + TOP + (0.15 if title else 0.0)
    with style():
        figure = new_figure(width, height)
        for place, (label, names) in enumerate(diagrams):
            row, column = divmod(place, columns)
            left = LEFT + column * (WIDTH + GAP_X)
            axes = add_axes(figure, left, bottom + (rows - 1 - row) * (HEIGHT + GAP_Y), WIDTH, HEIGHT)
            for prefix in states:
                values = merged(table, [prefix + name for name in names])
                if values is not None:
                    _draw(axes, x, values, lines, unbounded_points(table, names), dashed=bool(prefix))
            _not_closer_than(axes, _uncertainty(table, names))
            _mark_failed(axes, lines)
            if names[0] in FORCES:
                label += _add_share_of_limit(axes, table)
            _finish(axes, x, label, over[0] if place + columns >= len(diagrams) else "")
        if legend:
            draw_legend(figure, legend, columns)
        if title:
            figure.text(0.1 / width, 1.0 - 0.08 / height, one_line(title, int(width * 12)), va="top", parse_math=False)
        return save(figure, path)


def is_logarithmic(values: Column) -> bool:
    """Whether positive values over at least a factor 5 are spaced more evenly in their logarithms."""
    points = np.unique(values[np.isfinite(values)])
    if points.size < 3 or points[0] <= 0.0 or points[-1] < 5.0 * points[0]:
        return False

    def unevenness(positions: Column) -> float:
        steps = np.diff(positions)
        return float(steps.std() / steps.mean())

    return unevenness(np.log(points)) < unevenness(points)


def _worth_drawing(table: Mapping[str, Sequence[Any]], names: tuple[str, ...], over: Sequence[str]) -> bool:
    values = merged(table, names)
    if values is None:
        return False
    finite = values[np.isfinite(values)]
    if names[0].startswith(("creepage", "gamma_c", "gamma_p")) and np.ptp(finite) <= STEADY * np.abs(finite).max():
        return False
    if names == ("pressure_max_MPa",) and np.isfinite(numbers(table.get("hertz_p0_MPa", ()))).any():
        # γ_p over Hertz's pressure tells it.
        return False
    if any(name.endswith("." + names[0].removeprefix("creepage_")) for name in over):
        # The swept creepage against itself.
        return False
    return float(np.abs(finite).max()) > NEGLIGIBLE * _scale_of(table, names)


def _scale_of(table: Mapping[str, Sequence[Any]], names: tuple[str, ...]) -> float:
    """The largest value in the family that the quantity belongs to; of a moment, the largest force times sqrt(a0 b0)."""

    def largest(*columns: str) -> float:
        values = [np.abs(numbers(table[name])) for name in columns if name in table]
        return max((float(np.nanmax(column, initial=0.0, where=~np.isnan(column))) for column in values), default=0.0)

    if names == ("spin_moment_Nmm",):
        # Bodies with profiles have no Hertz ellipse: the circle of the contact's area.
        return largest(*FORCES) * math.sqrt(largest("hertz_a_mm") * largest("hertz_b_mm")
                                            or largest("contact_area_mm2") / math.pi)
    return largest(*next((family for family in (FORCES, CREEPAGES) if names[0] in family), names))


def _draw(
    axes: Axes, x: Column, values: Column, lines: list[Line], endless: NDArray[np.bool_], *, dashed: bool
) -> None:
    """The `values` of all lines over `x`; open circles where they are `endless`."""
    for line in lines:
        rows = line.rows[np.isfinite(values[line.rows])]
        look: dict[str, Any] = {"linestyle": (0, (4.0, 1.6)), "linewidth": 0.9} if dashed else {"linewidth": 1.3}
        marker: dict[str, Any] = {} if dashed or rows.size > 30 else {"marker": "o", "markersize": 2.2}
        axes.plot(x[rows], values[rows], color=line.colour, **look, **marker)
        if not dashed and endless[rows].any():
            axes.plot(x[rows][endless[rows]], values[rows][endless[rows]], **ENDLESS, color=line.colour)


def _finish(axes: Axes, x: Column, label: str, x_label: str) -> None:
    if is_logarithmic(x):
        axes.set_xscale("log")
        _few_logarithmic_ticks(axes, x)
        few_ticks(axes, y=5)
    else:
        few_ticks(axes, 5, 5)
    axes.set_ylabel(label)
    axes.grid(color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.tick_params(labelbottom=bool(x_label))
    if x_label:
        axes.set_xlabel(words_of(x_label), parse_math=False)


def _few_logarithmic_ticks(axes: Axes, x: Column) -> None:
    """Numbers at 1, 2, 5 of each decade, at 1 and 3 or at 1 alone, as many as have room; small ticks without numbers."""

    points = x[np.isfinite(x) & (x > 0.0)]
    decades = math.log10(float(points.max()) / float(points.min()))
    steps = (1.0, 2.0, 5.0) if decades < 1.8 else (1.0, 3.0) if decades < 2.6 else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=steps, numticks=7))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _uncertainty(table: Mapping[str, Sequence[Any]], names: tuple[str, ...]) -> float:
    """Largest estimated error of the quantity over the sweep, in its own unit; 0 where there is none."""
    rows = range(len(next(iter(table.values()), ())))
    errors = (absolute_error(name, summary_of_row(table, row)) for name in names if "error." + name in table for row in rows)
    return max((error for error in errors if math.isfinite(error)), default=0.0)


def _not_closer_than(axes: Axes, error: float) -> None:
    """Widen the vertical axis where what it shows is smaller than the error of the numbers."""
    low, high = axes.get_ylim()
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), FLAT * error, 5e-4 * max(abs(low), abs(high)))
    axes.set_ylim(middle - half, middle + half)


def _add_share_of_limit(axes: Axes, table: Mapping[str, Sequence[Any]]) -> str:
    """Numbers at the right that tell the force over μW, if μW is the same for all points, and words for it."""
    limits = numbers(table.get("friction_limit_N", ()))
    if limits.size == 0 or not np.ptp(limits) <= STEADY * limits[0]:
        return ""

    limit = float(limits[0])

    def over_limit(force: Any) -> Any:
        return force / limit

    def in_newtons(share: Any) -> Any:
        return share * limit

    right = axes.secondary_yaxis("right", functions=(over_limit, in_newtons))
    right.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    return "; right: over $\\mu W$"


def _mark_failed(axes: Axes, lines: list[Line]) -> None:
    """At the foot of the diagram, whatever its scale: a point that failed has no value there. In the colour of its line, and
    where several lines fail at one place, above each other."""
    failed = [line for line in lines if line.missed.size]
    for place, line in enumerate(failed):
        height = 0.04 + 0.3 * place / max(len(failed), 6)
        axes.plot(line.missed, np.full(line.missed.size, height), "x", markersize=4.0,
                  color=line.colour if len(lines) > 1 else FAILED, transform=axes.get_xaxis_transform())


def _states(table: Mapping[str, Sequence[Any]], names: list[str]) -> list[str]:
    """Prefixes of the states that differ from each other in what is drawn."""
    states = [""]
    for prefix in PREFIXES:
        both = [name for name in names if name in table and prefix + name in table]
        pairs = ((numbers(table[name]), numbers(table[prefix + name])) for name in both)
        if any(not np.allclose(one, other, rtol=1e-9, atol=0.0, equal_nan=True) for one, other in pairs):
            states.append(prefix)
    return states

"""One sheet per run: the maps of the final state, the cut, and all scalars with their errors."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure, SubFigure

from thermoroll_cli.plots.cuts import curves_of, draw_diagram, line_handles
from thermoroll_cli.plots.maps import (
    border_handles,
    colours_of,
    draw_arrows,
    draw_map,
    flow_label,
    lives_everywhere,
    scale_note,
    shape_of,
)
from thermoroll_cli.plots.run_frame import (
    HEAT_FLUX,
    PRESSURE,
    TEMPERATURE,
    TRACTION,
    Array,
    RunFrame,
    limits_of,
    unit_for,
)
from thermoroll_cli.plots.style import MM, add_headline, add_legend, few_ticks, new_figure, one_line, readable
from thermoroll_cli.problem.names import HERTZ_SCALARS, SCALARS, Quantity, Scalar
from thermoroll_cli.problem.number_text import computed, isothermal_text, number, scalar_text

PICTURES, TABLE = 150.0 * MM, 112.0 * MM
"""Widths of both halves of the sheet."""
LONGEST_MAP, TALLEST_MAP, AROUND_MAP, CUTS = 52.0 * MM, 60.0 * MM, 16.0 * MM, 58.0 * MM
"""Largest width and height of a map, room for what is around it, and height of the diagrams of the cut."""
FLAT = 0.4
LETTERS, ROW, FOOT = 7.0, 3.65 * MM, 3.4 * MM
"""Size of the letters of the table in points, distances of its rows and of the lines of remarks."""
COLUMNS = (0.0, 0.65, 0.83, 0.84)
"""Places of the words, of the values without deformation, the values (right ends) and the errors, over the table's width."""
LONGEST_WORDS, REMARK_LENGTH, REMARK_LINES = 40, 84, 5
"""Letters of words of the table before their brief form is taken, letters and number of lines of a remark."""

Row = tuple[str, str, str, str]


def summary_figure(frame: RunFrame) -> Figure:
    """The summary sheet. Maps show the state with all that feeds back; the table has both states and the error estimates."""
    maps = list(_maps(frame))
    rows, remarks = list(_rows(frame)), _remarks(frame)
    shape = shape_of(frame, whole=False)
    columns = 1 if shape < FLAT else 2
    lines = -(-len(maps) // columns)
    map_height = min(LONGEST_MAP * (2.0 if columns == 1 else 1.0) * shape, TALLEST_MAP) + AROUND_MAP
    height = max(lines * map_height + CUTS + 12.0 * MM, (len(rows) + 2) * ROW + len(remarks) * FOOT + 10.0 * MM)
    figure = new_figure(PICTURES + TABLE, height)
    left, right = figure.subfigures(1, 2, width_ratios=(PICTURES, TABLE), squeeze=False)[0]
    top, bottom = left.subfigures(2, 1, height_ratios=(height - CUTS, CUTS))
    grid = top.subplots(lines, columns, squeeze=False)
    for axes in grid.flat[len(maps):]:
        axes.set_visible(False)
    for axes, (quantity, values, body) in zip(grid.flat, maps, strict=False):
        limits = limits_of([v for q, v, _ in maps if q is quantity], quantity.from_zero)
        if quantity is HEAT_FLUX or quantity.unit == "Pa":
            limits = limits[0], min(limits[1], frame.last.maximum(quantity))
        scale = frame.scale(quantity, max(np.abs(limits)))
        colours = colours_of(quantity, limits[0] * scale.factor, limits[1] * scale.factor)
        image = draw_map(axes, frame, frame.last, values * scale.factor, colours, open_ended=lives_everywhere(quantity))
        if quantity is TRACTION:
            draw_arrows(axes, frame, frame.last, (LONGEST_MAP, LONGEST_MAP * shape))
        few_ticks(axes, 4, 4 if shape > FLAT else 2)
        bar = top.colorbar(image, cax=axes.inset_axes((1.03, 0.0, 0.02 if columns == 1 else 0.05, 1.0)))
        few_ticks(bar.ax, y=5)
        axes.set_title(", ".join(filter(None, (scale.label, f"{body} body" if body else ""))))
        if columns == 1:
            axes.label_outer()
    add_legend(top, border_handles(frame), 4)
    _draw_cuts(bottom, frame)
    _write_table(right, rows, remarks, height)
    add_headline(figure, frame.result.problem.title, frame.result.converged, scale_note(frame, whole=False))
    return figure


def _maps(frame: RunFrame) -> Iterator[tuple[Quantity, Array, str]]:
    """Quantity, values and body of the maps worth drawing; of two bodies that both get warmer, the hotter one."""
    for quantity in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE):
        found = [(values, body) for body in frame.bodies(quantity)
                 if (values := frame.last.values(quantity, body)) is not None and values.any()]
        if len(found) > 1 and all(limits_of([values], from_zero=True)[0] >= 0.0 for values, _ in found):
            found = [max(found, key=lambda each: float(each[0].max()))]
        for values, body in found:
            yield quantity, values, body


def _draw_cuts(figure: SubFigure, frame: RunFrame) -> None:
    """Pressure and traction along the cut."""
    found = [(quantity, curves) for quantity in (PRESSURE, TRACTION) if (curves := curves_of(frame, quantity))]
    if not found:
        return
    grid = figure.subplots(1, len(found), squeeze=False)
    for axes, (quantity, curves) in zip(grid.flat, found, strict=True):
        draw_diagram(axes, frame, quantity, curves)
        axes.set_title(frame.cut_words)
        axes.set_xlabel(flow_label(frame))
    add_legend(figure, line_handles(grid.flat), 3)


def _rows(frame: RunFrame) -> Iterator[Row]:
    """Rows of the table: words, the value without thermal deformation, the value, and its error. Rows of zeros are left out."""
    result, two = frame.result, len(frame.states) > 1
    summary, hertz = result.summary(), math.isfinite(result.hertz["hertz_p0_MPa"])
    yield ("thermal deformation", "without", "with", "± error") if two else ("", "", "value", "± error")
    for name, scalar in SCALARS.items():
        if any(computed(state.state.scalars.get(name)) and state.state.scalars[name] != 0.0 for state in frame.states):
            shown, _, error = readable(scalar_text(name, summary)).partition(" ±")
            first = readable(isothermal_text(name, summary)) if two else ""
            yield _words(scalar, hertz), first, shown, f"±{error}" if error else ""
    yield ("", "", "", "")
    for name, scalar in HERTZ_SCALARS.items():
        value = result.hertz.get(name, math.nan)
        # The speed stands below the table; here only where a lower one had to be solved.
        asked = name == "speed_solved_m_s" and value == result.problem.motion.speed
        if math.isfinite(value) and value != 0.0 and not asked:
            yield _words(scalar, hertz), "", readable(number(value)), ""


def _words(scalar: Scalar, hertz: bool) -> str:
    words = (not hertz and scalar.without_hertz) or scalar.meaning
    words = scalar.brief or words if len(words) > LONGEST_WORDS else words
    return f"{words} ({scalar.unit})" if scalar.unit else words


def _write_table(figure: SubFigure, rows: list[Row], remarks: list[str], height: float) -> None:
    """Columns as blocks of text, and the remarks below them."""
    top = 1.0 - 7.0 * MM / height
    for column, (place, side) in enumerate(zip(COLUMNS, ("left", "right", "right", "left"), strict=True)):
        for line, row in enumerate(rows):
            if row[column]:
                figure.text(place, top - line * ROW / height, row[column], ha=side, va="baseline", fontsize=LETTERS,
                            parse_math=False)
    below = top - (len(rows) + 0.5) * ROW / height
    for line, text in enumerate(remarks):
        figure.text(0.0, below - line * FOOT / height, text, va="baseline", fontsize=6.5, color="0.25", parse_math=False)


def _remarks(frame: RunFrame) -> list[str]:
    """Load, friction, speed and grid; the reason if it has not converged, and warnings."""
    problem, result = frame.result.problem, frame.result
    factor, unit = unit_for("N", problem.normal_force)
    grid = " × ".join(str(n) for n in result.work.get("grid", (result.x.size, result.y.size)))
    remarks = [f"W = {problem.normal_force * factor:.4g} {unit}, μ = {problem.friction:.4g}, "
               f"V = {problem.motion.speed:.4g} m/s, grid {grid}"]
    if frame.last.values(TRACTION) is not None:
        remarks.append("arrows: traction on the upper body")
    remarks += [result.reason] if result.reason else []
    remarks += [f"Warning: {text}" for text in result.warnings[:3]]
    return [line for text in remarks for line in _wrapped(re.sub(r"(?<!\w)-(?=\d)", "−", text))]


def _wrapped(text: str) -> list[str]:
    """A remark on a few lines as wide as the table."""
    lines = textwrap.wrap(one_line(text, 2000), REMARK_LENGTH, subsequent_indent="   ")
    return lines if len(lines) <= REMARK_LINES else [*lines[: REMARK_LINES - 1], lines[REMARK_LINES - 1] + " …"]

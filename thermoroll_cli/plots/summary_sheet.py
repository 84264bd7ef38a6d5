"""One sheet per run: the maps of the final state, the cut, and all scalars with their errors."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from matplotlib.figure import Figure

from thermoroll_cli.plots import style
from thermoroll_cli.plots.cuts import curves_of, draw_diagram, line_handles
from thermoroll_cli.plots.maps import (
    border_handles,
    colours_of,
    draw_arrows,
    draw_map,
    flow_label,
    lives_everywhere,
    map_note,
    shape_of,
)
from thermoroll_cli.plots.run_frame import (
    HEAT_FLUX,
    PRESSURE,
    TEMPERATURE,
    TRACTION,
    RunFrame,
    limits_of,
    unit_for,
)
from thermoroll_cli.problem.names import LINE_PROBLEM_SCALARS, LINE_SCALARS, PROBLEM_SCALARS, SCALARS, Quantity, Scalar
from thermoroll_cli.problem.scalar_errors import computed, isothermal_text, meaning_in, number, repeats, row_of, scalar_text
from thermoroll_cli.tools.arrays import Array

COLUMN, TABLE, WIDTH = 73.0 * style.MM, 153.0 * style.MM, 284.0 * style.MM
"""Distance of the columns of maps and diagrams, left end of the table, and width of the sheet."""
LABELS, AXIS, TITLE, HEADLINE, BAR = (size * style.MM for size in (16.5, 11.0, 5.0, 6.0, 2.5))
"""Room for labels at the left, for an axis, words above a map and the title; width of a colour bar."""
CUT, MARGIN = 38.0 * style.MM, 4.0 * style.MM
"""Height of the diagrams of the cut, and what is left free at the right of each."""
BLOCK = TITLE + CUT + AXIS
"""Height of such a diagram with what belongs to it."""
FLAT = 0.35
"""Maps of less height over width take both columns."""
LETTERS, ROW = 7.0, 2.95 * style.MM
"""Size of the letters of the table in points, and distance of its rows."""

SLIP = Quantity("slip", ("slip_x", "slip_y"), "slip velocity", "|ṡ|", "", "viridis", "", from_zero=True)

Row = tuple[str, str, str, str]
Map = tuple[Quantity, Array, str]


def summary_figure(frame: RunFrame) -> Figure:
    """The summary sheet. Maps show the state with all that feeds back, of a line contact all are diagrams; the table has both
    states and the error estimates."""
    maps, slip = [] if frame.line else list(_maps(frame)), frame.last.values(SLIP)
    if len(maps) % 2 and slip is not None and slip.any():
        maps.append((SLIP, slip, ""))  # without temperatures, say, it fills the last place
    rows, remarks = _rows(frame), _remarks(frame)
    shape = shape_of(frame, whole=False)
    columns = 1 if shape < FLAT else 2
    side = min(48.0 * style.MM + (2 - columns) * COLUMN, 60.0 * style.MM / shape)
    step = TITLE + side * shape + AXIS
    borders = border_handles(frame, arrows=any(quantity is TRACTION for quantity, _, _ in maps))
    cuts = [(quantity, curves) for quantity in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE)
            if (curves := curves_of(frame, quantity))]
    below_maps = HEADLINE + -(-len(maps) // columns) * step + style.legend_height(borders if maps else [], TABLE)
    below_table = HEADLINE + (len(rows) + len(remarks) + 4) * ROW
    spots, start, room = _spots(len(cuts), below_maps, below_table, line=frame.line)
    cuts = cuts[:len(spots)]
    lines = line_handles(curve for _, curves in cuts for curve in curves)
    below_cuts = max((top for _, top, _ in spots), default=0.0) + BLOCK + style.legend_height(lines, room)
    height = max(below_maps, below_cuts, below_table)
    figure = Figure(figsize=(WIDTH, height))
    for place, (quantity, values, body) in enumerate(maps):
        limits = limits_of([v for q, v, _ in maps if q is quantity], quantity.from_zero)
        if quantity is HEAT_FLUX or quantity.unit == "Pa":
            limits = limits[0], min(limits[1], frame.last.maximum(quantity))
        scale = frame.scale(quantity, frame.largest(quantity))
        colours = colours_of(quantity, limits[0] * scale.factor, limits[1] * scale.factor)
        row, column = divmod(place, columns)
        left, bottom = LABELS + column * COLUMN, height - HEADLINE - (row + 1) * step + AXIS
        axes = style.add_axes(figure, left, bottom, side, side * shape)
        image = draw_map(axes, frame, frame.last, values * scale.factor, colours, open_ended=lives_everywhere(quantity))
        if quantity is TRACTION:
            draw_arrows(axes, frame, frame.last, (side, side * shape))
        style.few_ticks(axes, 4, 4 if shape > FLAT else 2)
        bar = figure.colorbar(image, cax=style.add_axes(figure, left + side + 1.5 * style.MM, bottom, BAR, side * shape))
        style.few_ticks(bar.ax, y=5)
        axes.set_title(", ".join(filter(None, (scale.label, f"{body} body" if body else ""))))
    for (quantity, curves), (left, top, width) in zip(cuts, spots, strict=True):
        axes = style.add_axes(figure, left, height - top - TITLE - CUT, width, CUT)
        draw_diagram(axes, frame, quantity, curves)
        axes.set_title(frame.place_words(frame.cut_y))
        axes.set_xlabel(flow_label(frame))
    if maps:
        style.add_legend(figure, borders, at=(0.5 * TABLE, height - below_maps), width=TABLE)
    style.add_legend(figure, lines, at=(start + 0.5 * room, height - below_cuts), width=room)
    # Words, values without deformation, values and errors. Lines of one text would be as far apart as their letters are tall.
    top, places = height - HEADLINE - TITLE, ((0, "left"), (80, "right"), (100, "right"), (101, "left"))
    for nth, texts in enumerate(rows, start=1):
        for text, (beside, edge) in zip(texts, places, strict=True):
            if text:
                figure.text((TABLE + beside * style.MM) / WIDTH, (top - nth * ROW) / height, text, ha=edge, va="baseline",
                            fontsize=LETTERS, parse_math=False)
    figure.text(TABLE / WIDTH, (top - (len(rows) + 1) * ROW) / height, "\n".join(remarks), va="top", fontsize=LETTERS - 0.5,
                color="0.25", parse_math=False)
    frame.add_headline(figure, "" if frame.line else map_note(frame, whole=False))
    return figure


def _spots(
    count: int, below_maps: float, below_table: float, *, line: bool
) -> tuple[list[tuple[float, float, float]], float, float]:
    """Left end, top and width of as many of `count` diagrams of the cut as find a place, and where their legend begins and how
    much room it has.

    The first two fill the room below the table, above or beside each other, if they hardly make the sheet taller than its
    maps; else three or more are a row below maps and table, if the table does not reach below the maps; else two are below the
    maps. Those of a line contact stand in place of maps, where the last of three takes the row that it would have half of."""
    two, wide = min(count, 2), COLUMN - LABELS - MARGIN
    if line:
        spots = [(place % 2 * COLUMN, HEADLINE + place // 2 * BLOCK) for place in range(count)]
        widths = [wide + COLUMN * (place % 2 == 0 and place + 1 == count) for place in range(count)]
        return [(LABELS + x, y, width) for (x, y), width in zip(spots, widths, strict=True)], 0.0, TABLE
    room = WIDTH - TABLE
    if below_table + two * BLOCK < below_maps + 0.5 * BLOCK:
        return [(TABLE + LABELS, below_table + place * BLOCK, room - LABELS - MARGIN) for place in range(two)], TABLE, room
    if below_table + BLOCK < below_maps + 0.5 * BLOCK:
        step = room / max(two, 1)
        return [(TABLE + LABELS + place * step, below_table, step - LABELS - MARGIN) for place in range(two)], TABLE, room
    if count > 2 and below_table < below_maps + 0.25 * BLOCK:
        step, top = WIDTH / count, max(below_maps, below_table)
        return [(LABELS + place * step, top, step - LABELS - MARGIN) for place in range(count)], 0.0, WIDTH
    return [(LABELS + place * COLUMN, below_maps, wide) for place in range(two)], 0.0, TABLE


def _maps(frame: RunFrame) -> Iterator[Map]:
    """Quantity, values and body of the maps worth drawing; of two bodies that both get warmer, the hotter one."""
    for quantity in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE):
        drawn = [(values, body) for body in frame.bodies(quantity)
                 if (values := frame.last.values(quantity, body)) is not None and values.any()]
        if len(drawn) > 1 and all(limits_of([values], from_zero=True)[0] >= 0.0 for values, _ in drawn):
            drawn = [max(drawn, key=lambda each: float(each[0].max()))]
        for values, body in drawn:
            yield quantity, values, body


def _rows(frame: RunFrame) -> list[Row]:
    """Rows of the table: words, the value without thermal deformation, the value, its error. Rows of zeros are left out, and
    bodies that are alike share a row."""
    result, two = frame.result, len(frame.states) > 1
    row = row_of(result.summary())
    rows: list[Row] = [("thermal deformation", "without", "with", "± error") if two else ("", "", "value", "± error")]
    for name, scalar in (LINE_SCALARS if frame.line else SCALARS).items():
        if not any(computed(state.state.scalars.get(name)) for state in frame.states) or repeats(name, row):
            continue
        shown, _, error = style.readable(scalar_text(name, row)).partition(" ±")
        first = style.readable(isothermal_text(name, row)) if two else ""
        words, numbers = _words(scalar, row), (first, shown, f"±{error}" if error else "")
        if rows[-1] == (words.replace("upper body", "lower body"), *numbers):
            rows[-1] = (words.replace("the upper body", "each body").replace("upper body", "both bodies"), *numbers)
        elif {first, shown} - {"", "0", "–"}:
            rows.append((words, *numbers))
    rows.append(("", "", "", ""))
    rows += [(_words(scalar, row), "", style.readable(number(value)), "")
             for name, scalar in (PROBLEM_SCALARS | LINE_PROBLEM_SCALARS).items()
             if computed(value := result.of_problem.get(name)) and value != 0.0]
    return rows


def _words(scalar: Scalar, row: Mapping[str, Any]) -> str:
    words = meaning_in(row, scalar.name)
    words = scalar.brief or words if len(words) > 40 else words
    return f"{words} ({scalar.unit})" if scalar.unit else words


def _remarks(frame: RunFrame) -> list[str]:
    """Load, friction, speed and grid; the reason if it has not converged, and warnings."""
    problem, result = frame.result.problem, frame.result
    factor, unit = (1e-3, "N/mm") if frame.line else unit_for("N", problem.normal_force)
    grid = " × ".join(str(n) for n in result.work.get("grid", (result.x.size, result.y.size)))
    remarks = [f"W = {problem.normal_force * factor:.4g} {unit}, μ = {problem.friction.at_rest:.4g}, "
               f"V = {number(problem.motion.speed)} m/s, grid {grid}"]
    remarks += [result.reason] if result.reason else []
    remarks += [f"Warning: {text}" for text in result.warnings[:3]]
    flat = [style.one_line(re.sub(r"(?<!\w)-(?=\d)", "−", text), 2000) for text in remarks]
    return [line for text in flat for line in textwrap.wrap(
        text, 96, subsequent_indent="   ", max_lines=5, placeholder=" …")]

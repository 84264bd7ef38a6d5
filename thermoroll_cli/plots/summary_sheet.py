"""One sheet per run: the maps of the final state, the centre line, and all scalars."""

from __future__ import annotations

import math
import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from thermoroll_cli.plots.centreline import centreline_words, curves_of, draw_diagram, draw_legend
from thermoroll_cli.plots.colour_bar import draw_colour_bar
from thermoroll_cli.plots.field_figures import colours_of, limits_of, temperatures
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.lettering import Column
from thermoroll_cli.plots.maps import Frame, draw_arrows, draw_map
from thermoroll_cli.plots.sheet import add_axes, add_text, new_figure, one_line
from thermoroll_cli.plots.ticks import draw_sides
from thermoroll_cli.plots.units import HEAT_FLUX, LONGEST_ASPECT, PRESSURE, TEMPERATURE, TRACTION, scale_of
from thermoroll_cli.plots.view import RunView
from thermoroll_cli.problem.error_scale import absolute_error
from thermoroll_cli.problem.names import HERTZ_SCALARS, SCALARS, Quantity

LEFT, MAPS_WIDTH, MAPS_BOTTOM, TITLE_ROOM, BAR_ROOM = 0.62, 5.4, 2.4, 0.35, 0.65
DIAGRAM_WIDTH, DIAGRAM_HEIGHT, DIAGRAM_STEP, DIAGRAM_BOTTOM = 2.05, 1.15, 2.75, 0.65
WIDTH, TOP = 10.6, 0.4
TABLE_LEFT, TABLE_SIZE, ROW, REMARK_ROW = 6.2, 7.5, 0.194, 0.17
REMARK_LENGTH, REMARK_LINES = 76, 5
"""Characters on a line below the table, and lines that one remark may take."""
COLUMNS = (0.0, 2.75, 3.5, 4.25)
"""Where the table's columns are aligned: the words at their left end, the numbers at their right ends."""

Rows = list[tuple[str, str, str, str]]


def summary_figure(view: RunView, frame: Frame, normalised: bool) -> Figure:
    """The summary sheet. Maps show the final (coupled) state; the table has both states and the error estimates."""
    maps = _maps(view)
    # Both bodies in the colours of one scale, whichever of them cools.
    warm = limits_of([values for quantity, values, _ in maps if quantity is TEMPERATURE] or [np.zeros(1)], 1.0)
    rows, remarks = _rows(view), _remarks(view)
    aspect = min(max(frame.aspect(False), 1.0 / LONGEST_ASPECT), LONGEST_ASPECT)
    columns, box = _arrangement(len(maps), aspect)
    step_x, step_y = MAPS_WIDTH / columns, box[1] + TITLE_ROOM
    height = max(
        MAPS_BOTTOM + -(-len(maps) // columns) * step_y + TOP,
        TOP + (len(rows) + 1) * ROW + len(remarks) * REMARK_ROW,
    )
    # A long table leaves room below the diagrams, not between them and the maps.
    foot = height - MAPS_BOTTOM - -(-len(maps) // columns) * step_y - TOP
    figure = new_figure(WIDTH, height)
    for place, (quantity, values, body) in enumerate(maps):
        row, column = divmod(place, columns)
        corner = (LEFT + column * step_x, height - TOP - 0.15 - box[1] - row * step_y)
        limits = warm if quantity is TEMPERATURE else limits_of([values], 1.0)
        axes = _draw_map(figure, view, frame, quantity, values, limits, body, (*corner, *box), normalised)
        leftmost, lowest = column == 0, place + columns >= len(maps)
        sizes = (axes.bbox.width / figure.dpi, axes.bbox.height / figure.dpi)
        # Flat maps below each other share their axis.
        draw_sides(axes, (max(1, int(sizes[0] / 0.5)), max(1, int(sizes[1] / 0.5))), numbered=(lowest or columns > 1, leftmost),
                   labels=(frame.x_label if lowest else "", frame.y_label if leftmost else ""), pad=1.5)
    curves = [(quantity, curves_of(view, quantity)) for quantity in (PRESSURE, TRACTION)]
    for place, (quantity, lines) in enumerate(item for item in curves if item[1]):
        axes = add_axes(figure, LEFT + place * DIAGRAM_STEP, foot + DIAGRAM_BOTTOM, DIAGRAM_WIDTH, DIAGRAM_HEIGHT)
        draw_diagram(axes, view, quantity, lines, normalised, title=f" on {centreline_words(view)}")
    middle = LEFT + 0.5 * (DIAGRAM_STEP + DIAGRAM_WIDTH)
    draw_legend(figure, [curve for _, lines in curves for curve in lines], (middle, foot + 0.02))
    _write_table(figure, rows, remarks, height)
    add_headline(figure, view)
    return figure


def _maps(view: RunView) -> list[tuple[Quantity, NDArray[np.float64], str]]:
    """Quantity, values and body of the maps worth drawing."""
    state = view.states[-1]
    # Two bodies that both get warmer look alike: the hotter one tells enough.
    fields = [(values, body) for name, body in temperatures(view.states) if (values := state.field(name)) is not None]
    cools = any(limits_of([values], 1.0)[0] < 0.0 for values, _ in fields)
    thermal = fields if cools else sorted(fields, key=lambda field: -float(field[0].max()))[:1]
    found = [
        (PRESSURE, state.field("pressure"), ""),
        (TRACTION, state.magnitude("shear"), ""),
        (HEAT_FLUX, state.field("heat_flux"), ""),
        *((TEMPERATURE, values, body) for values, body in thermal),
    ]
    return [(quantity, values, body) for quantity, values, body in found if values is not None and values.any()]


def _arrangement(count: int, aspect: float) -> tuple[int, tuple[float, float]]:
    """Columns of maps and the box (width, height) for each: below each other if flat, in one row if tall."""
    if aspect < 0.5:
        return 1, (MAPS_WIDTH - BAR_ROOM, min(0.8, (MAPS_WIDTH - BAR_ROOM) * aspect))
    if aspect > 3.5:
        return max(count, 1), (MAPS_WIDTH / max(count, 2) - BAR_ROOM, 4.0)
    return 2, (1.95, 1.95)


def _draw_map(
    figure: Figure,
    view: RunView,
    frame: Frame,
    quantity: Quantity,
    values: NDArray[np.float64],
    span: tuple[float, float],
    body: str,
    box: tuple[float, float, float, float],
    normalised: bool,
) -> Axes:
    """One map, centred in `box` (left, bottom, width, height in inches), with its colour bar to the right of it; the colours
    tell the values of `span` (SI) apart."""
    number = len(view.states) - 1
    aspect = min(max(frame.aspect(False), 1.0 / LONGEST_ASPECT), LONGEST_ASPECT)
    width, height = min(box[2], box[3] / aspect), min(box[3], box[2] * aspect)
    x, y = box[0] + (box[2] - width) / 2, box[1] + (box[3] - height) / 2
    axes = add_axes(figure, x, y, width, height)
    scale, label = scale_of(quantity, view, max(span[1], -span[0]), normalised)
    colours, limits = colours_of(quantity, (span[0] * scale.factor, span[1] * scale.factor))
    draw_map(
        axes,
        frame,
        values * scale.factor,
        state=number,
        colours=colours,
        limits=limits,
        clipped=quantity is not TEMPERATURE,
    )
    if quantity is TRACTION:
        draw_arrows(axes, view, frame, number, (width, height))
    words = ", ".join(filter(None, (label, body)))
    # Maps that stand close together have short names.
    axes.set_title(words if box[2] > 1.5 else words.removeprefix(quantity.words).strip(), y=1.0, pad=3.0)
    draw_colour_bar(figure, (x + width + 0.1, y, 0.1, height), colours, limits, max(2, min(8, int(height / 0.4))))
    return axes


def _rows(view: RunView) -> Rows:
    """The table: words, isothermal and final value, estimated error in the unit of the value."""
    two, has_hertz = len(view.states) > 1, math.isfinite(view.summary.get("hertz_p0_MPa", math.nan))
    rows: Rows = [("", "isothermal", "coupled", "± est. error") if two else ("", "", "value", "± est. error")]
    for name in SCALARS:
        values = [state.scalars.get(name, math.nan) for state in view.states]
        if any(math.isfinite(value) for value in values):
            first = _number(values[0]) if two else ""
            error = _error(absolute_error(name, view.summary))
            words = (not has_hertz and SCALARS[name].without_hertz) or SCALARS[name].meaning
            rows.append((_words(words, name), first, _number(values[-1]), error))
    rows.append(("", "", "", ""))
    for name in HERTZ_SCALARS:
        # The speed stands below the table; here only where a lower one had to be solved.
        asked = name == "speed_solved_m_s" and view.summary.get(name) == view.problem.get("motion", {}).get("speed")
        if math.isfinite(view.summary.get(name, math.nan)) and not asked:
            rows.append((_words(HERTZ_SCALARS[name].meaning, name), "", _number(view.summary[name]), ""))
    return rows


def _write_table(figure: Figure, rows: Rows, remarks: list[str], height: float) -> None:

    for number, (place, side) in enumerate(zip(COLUMNS, ("left", "right", "right", "right"), strict=True)):
        text = "\n".join(row[number] for row in rows)
        figure.add_artist(Column((TABLE_LEFT + place) / WIDTH, 1.0 - TOP / height, text, size=TABLE_SIZE, pitch=ROW, ha=side,
                                 transform=figure.transFigure))
    y = height - TOP - (len(rows) + 1) * ROW
    for text in remarks:
        add_text(figure, TABLE_LEFT, y, text, va="baseline", fontsize=7.0, color="0.25")
        y -= REMARK_ROW


_UNITS = ("W_mm2", "rad_mm", "m_s", "mm2", "Nmm", "MPa", "mm", "um", "W", "K", "N", "s")
_SHORT = {
    "partition_mean": "heat share of the lower body",
    "thermal_displacement_max_um": "maximum thermal displacement",
    "power_balance_error": "power balance error",
    "T_gamma_N": "wear number Tγ",
    "surface_temperature_max_lower_K": "max. surface temperature, lower body",
    "surface_temperature_max_upper_K": "max. surface temperature, upper body",
    "temperature_rise_max_lower_K": "max. temperature rise, lower body",
    "temperature_rise_max_upper_K": "max. temperature rise, upper body",
}


def _words(long_name: str, name: str) -> str:
    unit = next((unit for unit in _UNITS if name.endswith("_" + unit)), "")
    shown = {"W_mm2": "W/mm²", "rad_mm": "rad/mm", "m_s": "m/s", "mm2": "mm²", "Nmm": "N mm", "um": "µm"}.get(unit, unit)
    words = _SHORT.get(name, long_name)
    return f"{words} ({shown})" if shown else words


def _number(value: float) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.5g}" if value == 0.0 or 1e-2 <= abs(value) < 1e6 else f"{value:.3e}"


def _error(value: float) -> str:
    if not (math.isfinite(value) and value > 0.0):
        return "–"
    rounded = float(f"{value:.1g}")
    return f"{rounded:.0f}" if 10.0 <= rounded < 1e6 else f"{rounded:g}"


def _remarks(view: RunView) -> list[str]:
    problem, motion = view.problem, view.problem.get("motion", {})
    grid = view.summary.get("work", {}).get("grid", [view.x.size, view.y.size])
    remarks = [
        f"W = {problem.get('normal_force', math.nan):.4g} N,  μ = {problem.get('friction', math.nan):.4g},  "
        f"V = {motion.get('speed', math.nan):.4g} m/s,  grid {' × '.join(str(n) for n in grid)}",
        "material flows to the right; arrows: traction on the upper body",
    ]
    if view.summary.get("reason"):
        remarks.append(str(view.summary["reason"]))
    remarks += [f"Warning: {text}" for text in view.summary.get("warnings", [])][:3]
    return [line for text in remarks for line in _lines(text)]


def _lines(text: str) -> list[str]:
    """A remark on a few lines as wide as the table."""
    lines = textwrap.wrap(one_line(text, 2000), REMARK_LENGTH, subsequent_indent="   ")
    return lines if len(lines) <= REMARK_LINES else [*lines[: REMARK_LINES - 1], lines[REMARK_LINES - 1] + " …"]

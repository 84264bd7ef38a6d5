"""One sheet per run: the maps of the final state, the centre line, and all scalars."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from thermoroll_cli.pipeline.result import HERTZ_SCALARS, SCALARS
from thermoroll_cli.plots.centreline import curves_of, draw_diagram
from thermoroll_cli.plots.field_figures import temperatures
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.maps import Frame, draw_arrows, draw_map
from thermoroll_cli.plots.sheet import add_axes, add_text, few_ticks, new_figure, one_line
from thermoroll_cli.plots.units import HEAT_FLUX, PRESSURE, TEMPERATURE, TRACTION, Quantity
from thermoroll_cli.plots.view import RunView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 11.2, 7.4
MAP, MAP_LEFT, MAP_STEP_X, MAP_STEP_Y, MAP_BOTTOM = 1.95, 0.6, 3.05, 2.45, 2.35
DIAGRAM_WIDTH, DIAGRAM_HEIGHT, DIAGRAM_BOTTOM = 2.38, 1.2, 0.45
TABLE_LEFT, TABLE_TOP, LINE = 6.6, 6.95, 0.186
COLUMNS = (2.72, 3.55, 4.4)
"""Right ends of the table's columns of numbers, from its left end."""


def summary_figure(view: RunView, frame: Frame, normalised: bool) -> Figure:
    """The summary sheet. Maps show the final (coupled) state; the table has both states and the error estimates."""
    figure = new_figure(WIDTH, HEIGHT)
    _maps(figure, view, frame, normalised)
    diagrams = [(quantity, curves_of(view, quantity)) for quantity in (PRESSURE, TRACTION)]
    for place, (quantity, curves) in enumerate(item for item in diagrams if item[1]):
        left = MAP_LEFT + place * MAP_STEP_X
        axes = add_axes(figure, left, DIAGRAM_BOTTOM, DIAGRAM_WIDTH, DIAGRAM_HEIGHT)
        draw_diagram(axes, view, quantity, curves, normalised)
        axes.set_title("on y = 0", pad=3.0)
    _table(figure, view)
    add_headline(figure, view)
    return figure


def _maps(figure: Figure, view: RunView, frame: Frame, normalised: bool) -> None:
    number = len(view.states) - 1
    state = view.states[number]
    thermal = temperatures(view.states)
    fields: list[tuple[Quantity, Any, str]] = [
        (PRESSURE, state.field("pressure"), ""),
        (TRACTION, state.magnitude("shear"), ""),
        (HEAT_FLUX, state.field("heat_flux"), ""),
        (TEMPERATURE, state.field(thermal[0][0]) if thermal else None, thermal[0][1] if thermal else ""),
    ]
    shown = [item for item in fields if item[1] is not None and item[1].max() > 0.0]
    for place, (quantity, values, body) in enumerate(shown):
        row, column = divmod(place, 2)
        whole = quantity is TEMPERATURE
        left, right, bottom, top = frame.domain if whole else frame.window
        aspect = min(max((top - bottom) / (right - left), 0.2), 5.0)
        width, height = min(MAP, MAP / aspect), min(MAP, MAP * aspect)
        corner_x = MAP_LEFT + column * MAP_STEP_X
        corner_y = MAP_BOTTOM + (1 - row) * MAP_STEP_Y + (MAP - height) / 2
        axes = add_axes(figure, corner_x + (MAP - width) / 2, corner_y, width, height)
        scale, label = quantity.scale(view, float(values.max()), normalised)
        image = draw_map(
            axes, frame, values * scale.factor, state=number, colours=quantity.colours,
            limits=(0.0, float(values.max()) * scale.factor), whole_domain=whole,
        )  # fmt: skip
        if quantity is TRACTION:
            draw_arrows(axes, view, frame, state, (width, height))
        few_ticks(axes, *(max(2, int(inches / 0.5)) for inches in (width, height)))
        axes.set_title(", ".join(filter(None, (quantity.words, state.label, body))), pad=3.0)
        axes.set_xlabel(frame.x_label, labelpad=1.5)
        axes.set_ylabel(frame.y_label, labelpad=1.5)
        bar = add_axes(figure, corner_x + (MAP + width) / 2 + 0.1, corner_y, 0.1, height)
        figure.colorbar(image, cax=bar, label=label.removeprefix(quantity.words).strip())
        few_ticks(bar, y=max(2, int(height / 0.4)))


def _table(figure: Figure, view: RunView) -> None:
    y = TABLE_TOP
    two = len(view.states) > 1
    heads = ("isothermal", "coupled", "rel. error") if two else ("", "value", "rel. error")
    for end, words in zip(COLUMNS, heads, strict=True):
        add_text(figure, TABLE_LEFT + end, y, words, ha="right", va="baseline", fontsize=7.0, color="0.35")
    error: Mapping[str, float] = view.summary.get("error", {})
    for name in SCALARS:
        values = [state.scalars.get(name, math.nan) for state in view.states]
        if not any(math.isfinite(value) for value in values):
            continue
        y -= LINE
        cells = [_number(value) for value in values]
        cells = cells if two else ["", *cells]
        _line(figure, y, _words(SCALARS[name], name), (*cells, _error(error.get(name, math.nan))))
    y -= 0.5 * LINE
    for name in HERTZ_SCALARS:
        y -= LINE
        _line(figure, y, _words(HERTZ_SCALARS[name], name), ("", _number(view.summary.get(name, math.nan)), ""))
    y -= 1.6 * LINE
    for text in _remarks(view):
        add_text(figure, TABLE_LEFT, y, one_line(text, 88), va="baseline", fontsize=7.0, color="0.25")
        y -= LINE


def _line(figure: Figure, y: float, words: str, cells: tuple[str, str, str]) -> None:
    add_text(figure, TABLE_LEFT, y, words, va="baseline", fontsize=7.0)
    for end, cell in zip(COLUMNS, cells, strict=True):
        if cell:
            add_text(figure, TABLE_LEFT + end, y, cell, ha="right", va="baseline", fontsize=7.0)


_UNITS = ("W_mm2", "rad_mm", "mm2", "Nmm", "MPa", "mm", "um", "W", "K", "N")
_SHORT = {
    "thermal_displacement_max_um": "maximum thermal displacement",
    "power_balance_error": "power balance error",
    "peclet_lower": "Péclet number, lower body",
    "peclet_upper": "Péclet number, upper body",
}


def _words(long_name: str, name: str) -> str:
    unit = next((unit for unit in _UNITS if name.endswith("_" + unit)), "")
    shown = {"W_mm2": "W/mm²", "rad_mm": "rad/mm", "mm2": "mm²", "Nmm": "N mm", "um": "µm"}.get(unit, unit)
    words = _SHORT.get(name, long_name)
    return f"{words} ({shown})" if shown else words


def _number(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "–"


def _error(value: float) -> str:
    return f"{value:.0e}" if math.isfinite(value) else "–"


def _remarks(view: RunView) -> list[str]:
    problem, motion = view.problem, view.problem.get("motion", {})
    grid = view.summary.get("work", {}).get("grid", [view.x.size, view.y.size])
    remarks = [
        f"W = {problem.get('normal_force', math.nan):.4g} N,  μ = {problem.get('friction', math.nan):.4g},  "
        f"V = {motion.get('speed', math.nan):.4g} m/s,  grid {' × '.join(str(n) for n in grid)}"
    ]
    if view.summary.get("reason"):
        remarks.append(str(view.summary["reason"]))
    return remarks + [f"Warning: {text}" for text in view.summary.get("warnings", [])][:3]

"""The pictures of single fields, isothermal beside coupled (the article's Figs. 6–9)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from thermoroll_cli.plots.colour_bar import draw_colour_bar
from thermoroll_cli.plots.headline import NOTE_ROOM, add_headline
from thermoroll_cli.plots.maps import Frame, draw_arrows, draw_map, legend_entries
from thermoroll_cli.plots.sheet import add_axes, add_text, even_lines, new_figure, real_minus
from thermoroll_cli.plots.ticks import draw_sides
from thermoroll_cli.plots.units import HEAT_FLUX, LONGEST_ASPECT, PRESSURE, TEMPERATURE, TRACTION, scale_of
from thermoroll_cli.plots.view import RunView, StateView
from thermoroll_cli.problem.names import Quantity, unit_of

LEFT, AXIS_ROOM, LEGEND_ROW, HEAD, GAP = 0.62, 0.53, 0.17, 0.22, 0.22
BAR_GAP, BAR_WIDTH, BAR_LABELS = 0.14, 0.13, 0.72
TITLE_ROOM = 0.24
NARROWEST = 1.45
COOLING = "coolwarm"
NEGLIGIBLE = 1e-3
"""Share of the largest value below which a temperature is drawn and told as zero."""
ALIKE = 5e-3
"""Share of the largest temperature by which those of both bodies differ at most where one picture stands for both."""
REMARK_ROW, SMALL_PER_INCH = 0.13, 16
"""Height of a line of remarks at the foot, and how many of its small letters an inch holds."""
LOWER, UPPER = "lower body", "upper body"


@dataclass(frozen=True)
class Panel:
    """One map: the number of its state, its values in SI units, its reported maximum (of the peak, which may rise above the
    largest element), the words above it, and whether the maximum grows with every refinement."""

    state: int
    values: NDArray[np.float64]
    maximum: float
    words: str
    unbounded: bool = False


@dataclass(frozen=True)
class PanelGrid:
    """Rows and columns of panels, and the size of one in inches. `true_shape` is False where a very long contact
    is drawn shorter than it is."""

    rows: int
    columns: int
    width: float
    height: float
    true_shape: bool

    @property
    def intervals(self) -> tuple[int, int]:
        """How many between the numbers along x and y, at most."""
        return max(1, min(6, int(self.width / 0.45))), max(1, min(6, int(self.height / 0.45)))


def pressure_figure(view: RunView, frame: Frame, normalised: bool) -> Figure | None:
    """Contact pressure of every state; None if there is none."""
    panels = [_panel(view, number, PRESSURE, state.field("pressure")) for number, state in enumerate(view.states)]
    return _figure(view, frame, PRESSURE, panels, normalised)


def traction_figure(view: RunView, frame: Frame, normalised: bool) -> Figure | None:
    """Magnitude and direction of the shear traction of every state; None without traction."""
    panels = [_panel(view, number, TRACTION, state.magnitude("shear")) for number, state in enumerate(view.states)]
    return _figure(view, frame, TRACTION, panels, normalised, arrows=True)


def heat_flux_figure(view: RunView, frame: Frame, normalised: bool) -> Figure | None:
    """Frictional heat flux of every state; None without heat."""
    panels = [_panel(view, number, HEAT_FLUX, state.field("heat_flux")) for number, state in enumerate(view.states)]
    return _figure(view, frame, HEAT_FLUX, panels, normalised)


def temperature_figure(view: RunView, frame: Frame, normalised: bool) -> Figure | None:
    """Temperature rise of every state, of both bodies where they differ; None without heat."""
    panels = [
        _panel(view, number, TEMPERATURE, state.field(name), body)
        for name, body in temperatures(view.states)
        for number, state in enumerate(view.states)
    ]
    return _figure(view, frame, TEMPERATURE, panels, normalised, whole_domain=True)


def temperatures(states: tuple[StateView, ...]) -> list[tuple[str, str]]:
    """Field and body of each temperature worth a picture: both only where they differ visibly."""
    lower, upper = ("temperature_rise_lower", LOWER), ("temperature_rise_upper", UPPER)
    fields = [[state.field(name) for state in states] for name, _ in (lower, upper)]
    there = [all(values is not None for values in each) for each in fields]
    if all(there):
        top = max(float(np.abs(values).max()) for each in fields for values in each if values is not None)
        same = all(
            np.allclose(one, other, rtol=0.0, atol=ALIKE * top)
            for one, other in zip(*fields, strict=True)
            if one is not None and other is not None
        )
        return [(lower[0], "")] if same else [lower, upper]
    return [body for body, exists in zip((lower, upper), there, strict=True) if exists]


def limits_of(fields: list[NDArray[np.float64]], factor: float) -> tuple[float, float]:
    """Smallest and largest value of the colours or an axis: from zero, unless a body cools; `factor` turns SI into what is
    drawn. What is rounding beside the largest value counts as zero."""
    low, high = min(float(f.min()) for f in fields) * factor, max(float(f.max()) for f in fields) * factor
    rounding = NEGLIGIBLE * max(high, -low)
    return low if low < -rounding else 0.0, high if high > rounding else 0.0


def colours_of(quantity: Quantity, limits: tuple[float, float]) -> tuple[str, tuple[float, float]]:
    """Colour map and the values at its ends: where a body cools, blue is colder and red warmer, alike from zero."""
    if limits[0] >= 0.0:
        return quantity.colours, limits
    reach = max(limits[1], -limits[0])
    return COOLING, (-reach, reach)


def grid_for(count: int, states: int, aspect: float) -> PanelGrid:
    """Arrange `count` panels whose height over width is `aspect`: states side by side, below each other if flat."""
    shown = min(max(aspect, 1.0 / LONGEST_ASPECT), LONGEST_ASPECT)
    columns = 1 if shown < 0.5 else states if states > 1 else count
    rows = count // columns
    if shown < 0.5:
        width = 5.4
    else:
        width = min(2.9, 4.4 / shown, 6.0 / (shown * rows))
    return PanelGrid(rows, columns, width, width * shown, shown == aspect)


def maximum_of(state: StateView, quantity: Quantity, values: NDArray[np.float64], body: str) -> float:
    """The maximum as it is reported among the scalars, in SI units; the largest of `values` where it is not."""
    reported = state.scalars.get(quantity.maximum.format((body or LOWER).split()[0]))
    unit = {"MPa": 1e6, "W/mm²": 1e6}.get(unit_of(quantity.maximum), 1.0)
    return float(values.max()) if reported is None or not math.isfinite(reported) else reported * unit


def _panel(
    view: RunView, number: int, quantity: Quantity, values: NDArray[np.float64] | None, body: str = ""
) -> Panel | None:
    if values is None:
        return None
    words = ", ".join(part for part in (view.states[number].label, body) if part)
    unbounded = quantity.maximum in view.summary.get("unbounded", ())
    return Panel(number, values, maximum_of(view.states[number], quantity, values, body), words, unbounded)


def _figure(
    view: RunView,
    frame: Frame,
    quantity: Quantity,
    found: list[Panel | None],
    normalised: bool,
    *,
    arrows: bool = False,
    whole_domain: bool = False,
) -> Figure | None:
    panels = [panel for panel in found if panel is not None]
    largest = max((float(np.abs(panel.values).max()) for panel in panels), default=0.0)
    if not largest > 0.0:
        return None
    scale, label = scale_of(quantity, view, largest, normalised)
    low, high = limits_of([panel.values for panel in panels], scale.factor)
    if not any(panel.unbounded for panel in panels):
        # Single elements at the end of a crown stand out of the field, and are no part of its maximum.
        high = min(high, max(panel.maximum for panel in panels) * scale.factor)
    colours, limits = colours_of(quantity, (low, high))
    grid = grid_for(len(panels), len({panel.state for panel in panels}), frame.aspect(whole_domain))
    slot = max(grid.width, NARROWEST)
    # Narrow maps have their words above the number, not before it.
    separator, title_room = (", ", TITLE_ROOM) if slot > 2.0 else ("\n", TITLE_ROOM + 0.14)
    room = grid.height + title_room
    width = LEFT + grid.columns * slot + (grid.columns - 1) * GAP + BAR_GAP + BAR_WIDTH + BAR_LABELS
    entries = legend_entries(view, any(border.stick for border in frame.borders))
    entry_columns = len(entries) if width > 6.0 or len(entries) * 1.3 < width else 2 if width > 3.6 else 1
    remarks = _directions(width, arrows=arrows)
    legend_foot = REMARK_ROW * len(remarks) + 0.04
    foot = AXIS_ROOM + LEGEND_ROW * -(-len(entries) // entry_columns) + legend_foot
    # Ticks and label of x stand below the lowest row only.
    head = HEAD if grid.true_shape else HEAD + NOTE_ROOM
    height = foot + grid.rows * room + head
    figure = new_figure(width, height)
    for place, panel in enumerate(panels):
        row, column = divmod(place, grid.columns)
        x = LEFT + column * (slot + GAP) + (slot - grid.width) / 2
        axes = add_axes(figure, x, foot + (grid.rows - 1 - row) * room, grid.width, grid.height)
        draw_map(axes, frame, panel.values * scale.factor, state=panel.state, colours=colours, limits=limits,
                 clipped=not whole_domain, whole_domain=whole_domain)
        if arrows:
            draw_arrows(axes, view, frame, panel.state, (grid.width, grid.height))
        axes.set_title(separator.join(filter(None, (panel.words, _extremes(panel, scale.factor)))), y=1.0, pad=4.0)
        # Ticks on all maps, numbers and labels on the outer ones.
        outer = (row == grid.rows - 1, column == 0)
        draw_sides(axes, grid.intervals, numbered=outer,
                   labels=(frame.x_label if outer[0] else "", frame.y_label if outer[1] else ""))
    bar_height = grid.rows * room - title_room
    draw_colour_bar(figure, (width - BAR_LABELS - BAR_WIDTH, foot, BAR_WIDTH, bar_height), colours, limits,
                    max(3, min(8, int(bar_height / 0.4))), label)
    add_headline(figure, view, note="" if grid.true_shape else "axes not to scale")
    _legend(figure, entries, entry_columns, legend_foot)
    for row, text in enumerate(reversed(remarks)):
        add_text(figure, width / 2, 0.05 + REMARK_ROW * row, text, ha="center", va="bottom", color="0.25", fontsize=7.0)
    return figure


def _directions(width: float, *, arrows: bool) -> list[str]:
    """Which way the bodies roll, and on which of them the `arrows` act, on lines that fit a figure of `width` inches."""
    texts = ["material of both bodies flows to the right, the leading edge is on the left"]
    if arrows:
        texts.append("arrows: traction on the upper body; its opposite acts on the lower one")
    return [line for text in texts for line in even_lines(text, max(20, int(width * SMALL_PER_INCH)))]


def _extremes(panel: Panel, factor: float) -> str:
    """The largest value, and the smallest where a body cools."""
    low, high = limits_of([panel.values], factor)
    high = panel.maximum * factor if high > 0.0 else high
    told = ", ".join(f"{word} {real_minus(f'{value:.4g}')}" for word, value in (("min", low), ("max", high)) if value != 0.0)
    return f"{told} (free end: no limit)" if panel.unbounded else told


def _legend(figure: Figure, entries: list[tuple[str, dict[str, Any]]], columns: int, bottom: float) -> None:

    handles = [Line2D([], [], linewidth=1.1, label=words, **look) for words, look in entries]
    # White lines need a ground to be seen on.
    figure.legend(
        handles=handles,
        loc="lower center",
        ncols=columns,
        bbox_to_anchor=(0.5, bottom / figure.get_size_inches()[1]),
        frameon=True,
        facecolor="0.72",
        edgecolor="none",
        framealpha=1.0,
        fancybox=False,
        borderpad=0.3,
        handlelength=2.4,
        columnspacing=1.4,
    )

"""The lines of a sweep's figure: which points they join, their colours, and the legend that names them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from thermoroll_cli.plots.sweep_columns import Column, with_value

PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999")
"""Colours that the colour-blind can tell apart (Okabe and Ito); more lines than these take theirs in order from `MANY`."""
MANY = "viridis"
LISTED = 24
"""Lines that the legend names; of more, every second, third … one."""
FAILED = "#c00000"
ENDLESS: dict[str, Any] = {"marker": "o", "markersize": 4.5, "markerfacecolor": "white", "linestyle": "none"}
"""Look of a peak that has no limit."""


@dataclass(frozen=True)
class Line:
    """The points of one combination of the further swept quantities, in the order of the first one; `missed` are the values
    of the first one that did not converge."""

    rows: NDArray[np.int_]
    missed: Column
    label: str
    colour: str


def lines_of(table: Mapping[str, Sequence[Any]], over: Sequence[str], x: Column, failed: NDArray[np.bool_]) -> list[Line]:
    """A line for each combination; its rows are counted without those that `failed`."""
    keys = [tuple(table[name][row] for name in over[1:]) for row in range(x.size)]
    distinct = list(dict.fromkeys(keys))
    colours = _colours(len(distinct))
    place = np.cumsum(~failed) - 1
    lines = []
    for key, colour in zip(distinct, colours, strict=True):
        own = np.array([other == key for other in keys]) & np.isfinite(x)
        rows = np.flatnonzero(own & ~failed)
        label = ", ".join(with_value(name, value) for name, value in zip(over[1:], key, strict=True))
        ordered = place[rows[np.argsort(x[rows], kind="stable")]]
        lines.append(Line(ordered, np.unique(x[own & failed]), label, colour))
    return lines


def _colours(count: int) -> Sequence[str]:
    """A colour for each line, none of them twice."""
    if count <= len(PALETTE):
        return PALETTE[:count]

    # Not to the end of the map: its yellow hardly shows on white.
    return [to_hex(colormaps[MANY](0.92 * place)) for place in np.linspace(0.0, 1.0, count)]


def legend_entries(lines: list[Line], states: list[str], *, endless: bool) -> list[tuple[str, dict[str, Any]]]:
    entries: list[tuple[str, dict[str, Any]]] = []
    if len(states) > 1:
        entries += [("coupled", {"color": "0.2", "linewidth": 1.3})]
        entries += [("isothermal", {"color": "0.2", "linewidth": 0.9, "linestyle": (0, (4.0, 1.6))})]
    if any(line.missed.size for line in lines):
        colour = "0.2" if len(lines) > 1 else FAILED
        entries += [("not converged", {"color": colour, "linestyle": "none", "marker": "x", "markersize": 4.0})]
    if endless:
        entries += [("no limit: a free end", {"color": "0.2", **ENDLESS})]
    shown = lines[:: -(-len(lines) // LISTED)] if len(lines) > 1 else []
    return entries + [(line.label, {"color": line.colour, "linewidth": 1.3}) for line in shown]


def draw_legend(figure: Any, entries: list[tuple[str, dict[str, Any]]], columns: int) -> None:

    handles = [Line2D([], [], label=label, **look) for label, look in entries]
    legend = figure.legend(handles=handles, loc="lower center", ncols=columns, handlelength=2.6, borderpad=0.2)
    for text in legend.get_texts():
        text.set_parse_math(False)



"""Picture of a contact over time: inputs, forces, stick and heat over the distance rolled, or over time."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from thermoroll_cli.plots import style

PANELS: tuple[tuple[str, tuple[tuple[str, str, float], ...]], ...] = (
    ("force (N)", (("force_x_N", "$F_x$", 1.0), ("force_y_N", "$F_y$", 1.0))),
    ("creepage (%)", (("creepage_longitudinal", r"$\xi_x$", 100.0), ("creepage_lateral", r"$\xi_y$", 100.0))),
    ("shift (µm)", (("shift_x_um", "along", 1.0), ("shift_y_um", "across", 1.0))),
    ("load (N)", (("normal_N", "$W$", 1.0),)),
    ("share of stick", (("gamma_st", "$\\gamma_{st}$", 1.0),)),
    ("heat (W)", (("Q_F_W", "$Q_F$", 1.0),)),
)
"""Axes of the picture: label, and columns with their labels and factors. Those that are zero are left out, and a load that
stays."""


def draw_history(
    path: pathlib.Path, columns: Mapping[str, Sequence[Any]], title: str, dpi: float | None = None
) -> pathlib.Path:
    """Write the picture to `path`. Raises OSError."""
    with style.applied():
        return style.save(_figure(columns, title), path, dpi)


def _figure(columns: Mapping[str, Sequence[Any]], title: str) -> Figure:
    shown = [(label, lines) for label, given in PANELS
             if (lines := [line for line in given if any(value == value and value for value in columns.get(line[0], ()))])
             and (lines[0][0] != "normal_N" or len({*columns["normal_N"]}) > 1)]
    rolls = columns["distance_mm"][-1] > columns["distance_mm"][0]
    places = columns["distance_mm"] if rolls else columns["time_s"]
    figure = style.new_figure(style.DOUBLE, 0.26 * style.DOUBLE * max(1, -(-len(shown) // 2)) + 0.1 * style.DOUBLE)
    axes = figure.subplots(max(1, -(-len(shown) // 2)), 2, squeeze=False).ravel()
    for one, (label, lines) in zip(axes, shown, strict=False):
        for (name, words, factor), colour in zip(lines, (style.AFTER, style.BEFORE), strict=False):
            one.plot(places, [factor * value for value in columns[name]], color=colour, label=words)
        one.set(xlabel="distance rolled (mm)" if rolls else "time (s)", ylabel=label)
        style.few_ticks(one, 6, 5, grid=True)
        if len(lines) > 1:
            one.legend(loc="best", fontsize="small")
    for one in axes[len(shown) :]:
        one.set_visible(False)
    style.add_headline(figure, title, note="over time")
    return figure

"""Measured points with their bars, the curve fitted to them with its band, and what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import PchipInterpolator

from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import ALL_SCALARS
from thermoroll_cli.tools.arrays import Array

POINTS: dict[str, Any] = {"fmt": "o", "color": "black", "markersize": 3.0, "elinewidth": 0.7, "capsize": 1.5, "zorder": 3}
"""Look of measured points."""
MEASURED = Line2D([], [], linestyle="none", marker="o", color="black", markersize=3.0, label="measured")
"""The same in a legend."""


def fit_figure(
    title: str, places: Array, over: str, measured: Mapping[str, Array], deviations: Mapping[str, Array],
    computed: Mapping[str, Array], band: Mapping[str, Array], found: Sequence[str], *, converged: bool = True,
) -> Figure:
    """For each scalar `measured` (points,) the points at `places`, values of what they are `over` in words ("": their numbers),
    with their standard `deviations`, and the values `computed` there, over a key as a curve with its 95 % `band` (half of it);
    below, what is measured less what is computed. The legend says what was `found`."""
    with style.applied():
        count = len(measured)
        figure = style.new_figure((style.SINGLE, style.DOUBLE)[count > 1], style.SINGLE)
        grid = figure.subplots(2, count, sharex="col", squeeze=False, height_ratios=(3.0, 1.0))
        for column, (name, values) in enumerate(measured.items()):
            above, below = grid[:, column]
            bars = deviations.get(name)
            above.errorbar(places, values, bars, label="measured", **POINTS)
            if not over:
                above.plot(places, computed[name], "x", color=style.AFTER, label="computed")
            else:
                known, first = np.unique(places, return_index=True)
                at = np.linspace(known[0], known[-1], 200)  # cubics between the measured places keep what rises rising
                line, half = (PchipInterpolator(known, part[name][first])(at) for part in (computed, band))
                above.plot(at, line, color=style.AFTER, label="\n".join(found))
                above.fill_between(at, line - half, line + half, color=style.AFTER, alpha=0.3, linewidth=0.0,
                                   label="95 % band of the curve")
            below.errorbar(places, values - computed[name], bars, **POINTS)
            below.axhline(0.0, color=style.AFTER)
            above.set_ylabel(_words(name))
            below.set_ylabel("measured −\ncomputed")
            below.set_xlabel(over or "number of the point", parse_math=False)
            for axes in (above, below):
                axes.grid(visible=True)
            style.few_ticks(below, 5, 3)
        style.add_headline(figure, title, converged)
        style.add_legend(figure, grid[0, 0].get_legend_handles_labels()[0])
        return figure


def _words(name: str) -> str:
    """The words beside an axis for a scalar, or for a force over the load."""
    if name not in ALL_SCALARS:
        return f"${{F_{name.split('_')[1]}}}/W$"
    return ALL_SCALARS[name].diagram or f"{ALL_SCALARS[name].meaning} ({ALL_SCALARS[name].unit})"


def mark_measured(figure: Figure, x: Array, values: Mapping[str, Array], deviations: Mapping[str, Array]) -> list[str]:
    """Draw measured points over the diagrams of a sweep that have their scalar; returns the scalars without a diagram."""
    missing = []
    for name, column in values.items():
        label = ALL_SCALARS[name].diagram if name in ALL_SCALARS else ""
        axes = next((axes for axes in figure.axes if label and axes.get_ylabel() == label), None)
        if axes is None:
            missing.append(name)
            continue
        axes.errorbar(x, column, deviations.get(name), **POINTS)
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, float(np.min(column))), max(high, 1.02 * float(np.max(column))))
    return missing

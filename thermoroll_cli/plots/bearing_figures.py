"""Pictures of a ball bearing: loads and contact angles of its balls around the circumference, and how they spin."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from thermoroll_cli.plots import style
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

RINGS = {"inner": (style.AFTER, "o"), "outer": (style.BEFORE, "s")}


def loads_figure(result: Result) -> Figure:
    """Loads and contact angles of all balls at both rings around the bearing; ball 1 is where the radial load points."""
    loads, angles = result.lines["loads"], np.degrees(result.lines["angles"])
    figure = style.new_figure(style.DOUBLE, 0.62 * style.DOUBLE)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for k, ring in enumerate(RINGS):
        _around(upper, ring, loads[k])
        _around(lower, ring, angles[k])
    upper.set(ylabel="load (N)", ylim=(0.0, None))
    lower.set(ylabel="contact angle (°)")
    return _finished(figure, result, (upper, lower))


def axes_figure(result: Result) -> Figure | None:
    """Spin over rolling of both contacts, and heat, of all balls around the bearing. None where nothing rolls."""
    count = result.lines["loads"].shape[1]
    figure = style.new_figure(style.DOUBLE, 0.62 * style.DOUBLE)
    upper, lower = figure.subplots(2, 1, sharex=True)
    drawn = False
    for ring in RINGS:
        for axes, name in ((upper, "spin_to_roll"), (lower, "Q_F_W")):
            values = np.full(count, math.nan)
            for contact in result.contacts:
                if contact.record["ring"] == ring:
                    values[contact.record["ball"] - 1] = contact.record.get(name, math.nan)
            _around(axes, ring, values)
            drawn |= not np.isnan(values).all()
    if not drawn:
        return None
    upper.set_ylabel("spin / rolling")
    lower.set(ylabel="heat of a contact (W)", ylim=(0.0, None))
    return _finished(figure, result, (upper, lower))


def _around(axes: Axes, ring: str, values: Array) -> None:
    """Values of all balls over their places, with ball 1 again at the end."""
    colour, marker = RINGS[ring]
    axes.plot(np.linspace(0.0, 360.0, len(values) + 1), np.append(values, values[0]), color=colour, marker=marker,
              markersize=3.0, linewidth=0.8, label=f"{ring} ring")


def _finished(figure: Figure, result: Result, panels: tuple[Axes, Axes]) -> Figure:
    for axes in panels:
        style.few_ticks(axes, 0, 5, grid=True)
        axes.set_xticks(np.arange(0.0, 361.0, 45.0))
        axes.ticklabel_format(axis="y", useOffset=False)
    panels[-1].set(xlabel="place of the ball from the radial load (°)", xlim=(0.0, 360.0))
    style.add_headline(figure, result.problem.title, result.converged)
    style.add_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure

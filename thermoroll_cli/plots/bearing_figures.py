"""Pictures of a ball bearing: loads and contact angles of its balls around the circumference, how they spin, and the
contacts of the ball that carries most."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from thermoroll_cli.plots import style
from thermoroll_cli.plots.wheelset_figures import pressure_maps
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

RINGS: dict[str, dict[str, Any]] = {
    "inner": {"color": style.AFTER, "marker": "o", "markersize": 2.5, "zorder": 3.0},
    "outer": {"color": style.BEFORE, "marker": "s", "markersize": 5.0, "markerfacecolor": "none", "zorder": 2.5}}
"""How both rings are drawn, so that one shows through the other."""
LEAST, ALIKE = 1e-9, 1e-3
"""Values that count as 0 everywhere, and relative differences as none."""


def loads_figure(result: Result) -> Figure | None:
    """Loads and contact angles of all balls at both rings around the bearing; ball 1 is where the radial load points. None
    where no ball is loaded."""
    return _figure(result, {"load (N)": result.lines["loads"], "contact angle (°)": np.degrees(result.lines["angles"])})


def axes_figure(result: Result) -> Figure | None:
    """Spin over rolling of both contacts, and heat, of all balls around the bearing. None where nothing rolls."""
    rows = {label: np.full(result.lines["loads"].shape, math.nan) for label in ("spin / rolling", "heat of a contact (W)")}
    for contact in result.contacts:
        place = [*RINGS].index(contact.record["ring"]), contact.record["ball"] - 1
        for values, name in zip(rows.values(), ("spin_to_roll", "Q_F_W"), strict=True):
            values[place] = contact.record.get(name, math.nan)
    return _figure(result, rows)


def patches_figure(result: Result) -> Figure | None:
    """The pressure in both contacts of the ball that carries most, of the first if all carry as much. None without contacts."""
    if not result.shown:
        return None
    loads = result.lines["loads"][0]
    most = ", which carries most" if np.ptp(loads) > ALIKE * loads.max() else ""
    titles = [f"{patch.record['ring']} ring, {patch.record['normal_N']:.4g} N" for patch in result.shown]
    return pressure_maps(result, f"ball {result.shown[0].record['ball']}{most}", titles)


def _figure(result: Result, rows: Mapping[str, Array]) -> Figure | None:
    """Values (2, n) at the inner and the outer ring of all balls over their places, in a panel for each of `rows` that is not 0
    everywhere, with ball 1 again at the end. None without such a panel."""
    rows = {label: values for label, values in rows.items() if np.abs(np.nan_to_num(values)).max() > LEAST}
    if not rows:
        return None
    figure = style.new_figure(style.DOUBLE, (0.06 + 0.28 * len(rows)) * style.DOUBLE)
    panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (label, values) in zip(panels, rows.items(), strict=True):
        for own, (ring, look) in zip(values, RINGS.items(), strict=True):
            axes.plot(np.linspace(0.0, 360.0, len(own) + 1), np.append(own, own[0]), label=f"{ring} ring", clip_on=False,
                      linewidth=0.8, **look)
        style.few_ticks(axes, 0, 5, grid=True)
        axes.set_xticks(np.arange(0.0, 361.0, 45.0))
        axes.ticklabel_format(axis="y", useOffset=False)
        axes.set_ylabel(label)
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        if label.endswith(("(N)", "(W)")):
            axes.set_ylim(0.0, 1.06 * high)
        elif high - low < ALIKE * max(abs(low), abs(high)):  # the same everywhere: no axis of rounding
            axes.set_ylim(sorted((0.9 * low, 1.1 * high)))
    panels[-1].set(xlabel="place of the ball from the radial load (°)", xlim=(0.0, 360.0))
    style.add_headline(figure, result.problem.title, result.converged)
    style.add_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure

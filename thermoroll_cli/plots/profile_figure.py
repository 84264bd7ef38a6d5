"""The surfaces across the rolling direction above the pressure between them: where a profile touches, and how hard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from thermoroll_cli.plots.colour_bar import draw_colour_bar
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.sheet import add_axes, add_text, few_ticks, new_figure
from thermoroll_cli.plots.units import PRESSURE, unit_for
from thermoroll_cli.plots.view import RunView
from thermoroll_cli.problem.problem import Geometry
from thermoroll_cli.problem.profile import Profile
from thermoroll_cli.problem.surface import closest_place, surfaces

LEFT, RIGHT, FOOT, HEAD, GAP = 0.7, 0.95, 0.7, 0.34, 0.12
WIDTH, SURFACES, MAP = 4.6, 1.5, 1.5
BAR_GAP, BAR_WIDTH = 0.12, 0.13
SAMPLES = 1001
LOWER, UPPER = "#0072b2", "#d55e00"


def profile_figure(view: RunView) -> Figure | None:
    """Heights of both unloaded surfaces where they touch first, and the pressure below; None without a profile."""
    geometry = _geometry(view.problem)
    if geometry is None:
        return None

    state = view.states[-1]
    pressure = state.field("pressure")
    if pressure is None:
        return None
    across = unit_for("m", float(np.abs(view.y).max()))
    along = unit_for("m", float(np.abs(view.x).max()))
    figure = new_figure(LEFT + WIDTH + RIGHT, FOOT + MAP + GAP + SURFACES + HEAD)
    top = add_axes(figure, LEFT, FOOT + MAP + GAP, WIDTH, SURFACES)
    edges = (view.y[0] - 0.5 * (view.y[1] - view.y[0]), view.y[-1] + 0.5 * (view.y[1] - view.y[0]))
    y = np.linspace(*edges, SAMPLES)
    touch = np.array([closest_place(geometry)])
    heights = [sign * (surface.height(y) - surface.height(touch))
               for sign, surface in zip((1.0, -1.0), surfaces(geometry), strict=True)]
    shown = [np.where(np.isfinite(height), height, np.nan) for height in heights]
    # A crown falls without bottom at its very end: what lies within three times the approach of the other body tells enough.
    reach = 3e-6 * view.summary["approach_um"]
    high = max(min(float(np.nanmax(h)), float(np.nanmax(shown[0])) + reach) for h in shown)
    low = min(max(float(np.nanmin(h)), float(np.nanmin(shown[1])) - reach) for h in shown)
    depth = unit_for("m", max(high, -low))
    for height, words, colour in ((shown[1], "upper body", UPPER), (shown[0], "lower body", LOWER)):
        top.plot(y * across.factor, height * depth.factor, color=colour, label=words)
    top.set_xlim(*(edge * across.factor for edge in edges))
    room = 0.08 * (high - low or 1.0)
    top.set_ylim((low - room) * depth.factor, (high + room) * depth.factor)
    top.set_ylabel(depth.label("height"))
    top.tick_params(labelbottom=False)
    top.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3, handlelength=1.2)
    _pressure_map(figure, view, pressure, across, along)
    few_ticks(top, 8, 4)
    _patches(top, view.summary.get("patches", ()), across.factor * 1e-3)
    note = "pressure has no limit at the end of a profile" if view.summary.get("unbounded") else ""
    add_headline(figure, view, note=note)
    remark = "surfaces unloaded, where they touch first; in the map material flows upwards"
    add_text(figure, LEFT + 0.5 * WIDTH, 0.07, remark, ha="center", va="bottom", color="0.25", fontsize=7.0)
    return figure


def _pressure_map(figure: Figure, view: RunView, pressure: Any, across: Any, along: Any) -> None:
    """Pressure with y to the right and x upwards, its colour bar beside it."""
    axes = add_axes(figure, LEFT, FOOT, WIDTH, MAP)
    scale = unit_for(PRESSURE.unit, float(pressure.max()))
    half_x, half_y = 0.5 * (view.x[1] - view.x[0]), 0.5 * (view.y[1] - view.y[0])
    sides = ((view.y[0] - half_y) * across.factor, (view.y[-1] + half_y) * across.factor,
             (view.x[0] - half_x) * along.factor, (view.x[-1] + half_x) * along.factor)
    shown = np.ma.masked_where(pressure <= 0.0, pressure * scale.factor)
    axes.set_facecolor("0.92")
    top = float(shown.max())
    axes.imshow(shown, origin="lower", extent=sides, aspect="auto", cmap=PRESSURE.colours, vmin=0.0, vmax=top,
                interpolation="nearest")
    axes.set_xlabel(across.label("y"))
    axes.set_ylabel(along.label("x"))
    few_ticks(axes, 8, 4)
    draw_colour_bar(figure, (LEFT + WIDTH + BAR_GAP, FOOT, BAR_WIDTH, MAP), PRESSURE.colours, (0.0, top), 4,
                    scale.label("pressure p"))


def _patches(axes: Any, patches: Any, factor: float) -> None:
    """A mark where the pressure of each patch acts."""
    for patch in patches:
        axes.axvline(patch["y_mm"] * factor, color="0.6", linewidth=0.6, linestyle=":")


def _geometry(problem: Mapping[str, Any]) -> Geometry | None:
    """The shapes of both bodies, of a solved or a stored problem; None without a profile."""
    given = dict(problem.get("geometry", {}))
    bodies = ("lower_profile", "upper_profile")
    if not any(given.get(body) for body in bodies):
        return None
    for body in bodies:
        if given.get(body):
            profile = dict(given[body])
            profile["points"] = tuple(tuple(point) for point in profile["points"])
            given[body] = Profile(**profile)
    return Geometry(**given)

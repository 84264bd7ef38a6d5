"""Stresses and temperatures below the surface: the plane through the largest stress, and lines into the depth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from thermoroll_cli.plots.centreline import draw_lines_legend
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.sheet import add_axes, add_text, few_ticks, new_figure, real_minus
from thermoroll_cli.plots.units import axes_scales, unit_for
from thermoroll_cli.plots.view import RunView
from thermoroll_cli.problem.result import BodyStresses, Peak

Array = NDArray[Any]

WIDTH, HEIGHT = 3.0, 2.0
LEFT, BOTTOM, TOP, GAP, BAR_GAP, BAR, AFTER_BAR, ROW_GAP = 0.62, 0.85, 0.42, 0.6, 0.1, 0.1, 0.42, 0.72
STRESS_COLOURS, HEAT_COLOURS = "viridis", "inferno"
LEVELS = 24
LINES = 12
STRESSED, HEATED, ELASTIC = "#d55e00", "#0072b2", (0, (4.0, 1.6))
"""Colours of the lines below both points, and dashes of the elastic part."""
COOL = 0.01
"""Share of the largest temperature rise: what is cooler all over is not worth its room."""
ROOM = 1.25
"""How far beyond the heated layer its diagrams reach."""
STRONGEST = "#e8262a"


@dataclass(frozen=True)
class _Scale:
    """Factors from SI to drawn lengths and stresses, and their labels."""

    x: float
    x_label: str
    z: float
    z_label: str
    stress: float
    stress_label: str


def subsurface_figure(view: RunView, body: str, normalised: bool) -> Figure | None:
    """The von Mises stress over p₀ on the plane of rolling through its maximum, the temperature on it, and both along lines
    into the depth below the most stressed and the hottest point; None where the body was not looked into.

    Elastic stresses stand beside the total where heat adds to them."""
    stresses = view.subsurface.get(body)
    if stresses is None:
        return None
    scale = _scale_of(view, normalised)
    hot = stresses.hottest is not None
    rows = 2 if hot else 1
    width = LEFT + WIDTH + BAR_GAP + BAR + AFTER_BAR + GAP + WIDTH + 0.15
    height = BOTTOM + rows * HEIGHT + (rows - 1) * ROW_GAP + TOP
    figure = new_figure(width, height)
    y, plane = _plane(view, stresses)
    across = unit_for("m", abs(y))
    place = real_minus(f"y = {y * across.factor:.3g} {across.unit}") if abs(y) > 1e-9 * abs(view.y[-1]) else "y = 0"
    bottom = BOTTOM + (rows - 1) * (HEIGHT + ROW_GAP)
    _draw_plane(figure, bottom, view, stresses, plane["von_mises"] * scale.stress, STRESS_COLOURS, scale,
                f"{scale.stress_label}, {place}", stresses.most_stressed)
    right = LEFT + WIDTH + BAR_GAP + BAR + AFTER_BAR + GAP
    axes = add_axes(figure, right, bottom, WIDTH, HEIGHT)
    _draw_stress_lines(axes, stresses, scale)
    if hot:
        _draw_plane(figure, BOTTOM, view, stresses, plane["temperature_rise"], HEAT_COLOURS, scale,
                    f"temperature rise (K), {place}", None)
        _draw_temperature_lines(add_axes(figure, right, BOTTOM, WIDTH, HEIGHT), stresses, scale)
    add_headline(figure, view, f", {body} body" if view.title else f"{body} body")
    _add_legend(figure, 0.5 * width, elastic="von_mises_elastic" in stresses.below_stressed, hot=hot)
    remark = "material flows to the right, z points into the body; ×: the largest stress"
    add_text(figure, 0.5 * width, 0.06, remark, ha="center", va="bottom", color="0.25", fontsize=7.0)
    return figure


def _scale_of(view: RunView, normalised: bool) -> _Scale:
    (x_factor, x_label), _ = axes_scales(view, normalised)
    peak = view.peak_pressure
    over_hertz = math.isfinite(peak)
    if not over_hertz:
        peak = view.summary["pressure_max_MPa"] * 1e6
    z_label = x_label.replace("x", "z")
    return _Scale(x_factor, x_label, x_factor, z_label, 1.0 / peak,
                  r"$\sigma_{\mathrm{vM}}/p_0$" if over_hertz else r"$\sigma_{\mathrm{vM}}/p_{\max}$")


def _plane(view: RunView, stresses: BodyStresses) -> tuple[float, Mapping[str, Array]]:
    """Where the plane lies and its fields (nz, nx): through the largest stress, where fields are kept everywhere."""
    if "von_mises" not in stresses.fields:
        return stresses.plane_y, stresses.plane
    row = int(np.argmin(np.abs(view.y - stresses.most_stressed.y)))
    y = 0.0 if abs(stresses.most_stressed.y) < 0.01 * (view.y[1] - view.y[0]) else float(view.y[row])
    return y, {name: values[:, :, row] for name, values in stresses.fields.items()}


def _draw_plane(
    figure: Figure, bottom: float, view: RunView, stresses: BodyStresses, values: Array, colours: str, scale: _Scale,
    title: str, strongest: Peak | None,
) -> None:
    """A map over x and depth with isolines, its colour bar, and a cross where the largest value is."""
    axes = add_axes(figure, LEFT, bottom, WIDTH, HEIGHT)
    x, z = view.x * scale.x, stresses.depths * scale.z
    top = float(values.max())
    levels = np.linspace(min(0.0, float(values.min())), top if top > 0.0 else 1.0, LEVELS + 1)
    image = axes.contourf(x, z, values, levels=levels, cmap=colours)
    axes.contour(x, z, values, levels=levels[:: LEVELS // LINES][1:-1], colors="white", linewidths=0.35, alpha=0.7)
    if strongest is not None:
        axes.plot([strongest.x * scale.x], [strongest.z * scale.z], "x", color=STRONGEST, markersize=5.0,
                  markeredgewidth=1.2, clip_on=False)
    axes.set_xlim(x[0], x[-1])
    _into_the_depth(axes, _heated_depth(stresses) * scale.z if strongest is None else z[-1], scale)
    axes.set_xlabel(scale.x_label)
    axes.set_title(title)
    few_ticks(axes, 5, 5)
    bar = add_axes(figure, LEFT + WIDTH + BAR_GAP, bottom, BAR, HEIGHT)
    figure.colorbar(image, cax=bar)
    few_ticks(bar, y=6)


def _draw_stress_lines(axes: Axes, stresses: BodyStresses, scale: _Scale) -> None:
    """Von Mises stress along the lines into the depth, and its elastic part where heat adds to it."""
    z = stresses.depths * scale.z
    lines = [(fields[name], colour, dashes)
             for fields, colour in ((stresses.below_stressed, STRESSED), (stresses.below_heated, HEATED))
             for name, dashes in (("von_mises", "solid"), ("von_mises_elastic", ELASTIC)) if fields and name in fields]
    for values, colour, dashes in lines:
        axes.plot(values * scale.stress, z, color=colour, linestyle=dashes)
    axes.set_xlim(0.0, 1.08 * scale.stress * max(float(values.max()) for values, *_ in lines))
    _finish_lines(axes, z[-1], scale, scale.stress_label)


def _draw_temperature_lines(axes: Axes, stresses: BodyStresses, scale: _Scale) -> None:
    """Temperature rise along the same lines."""
    z = stresses.depths * scale.z
    for fields, colour in ((stresses.below_stressed, STRESSED), (stresses.below_heated, HEATED)):
        axes.plot(fields["temperature_rise"], z, color=colour)
    rises = [fields["temperature_rise"] for fields in (stresses.below_stressed, stresses.below_heated)]
    low, high = min(0.0, *(float(rise.min()) for rise in rises)), max(float(rise.max()) for rise in rises)
    axes.set_xlim(1.08 * low, 1.08 * high if high > 0.0 else 1.0 if low == 0.0 else 0.0)
    _finish_lines(axes, _heated_depth(stresses) * scale.z, scale, "temperature rise (K)")


def _heated_depth(stresses: BodyStresses) -> float:
    """Depth (m) that shows where heat gets to: behind a fast source that is a skin of the depth of the stresses."""
    rise = np.abs(stresses.plane["temperature_rise"]).max(axis=1)
    warm = int(np.flatnonzero(rise > COOL * rise.max()).max(initial=1))
    deepest = float(stresses.depths[-1])
    return min(deepest, ROOM * float(stresses.depths[min(warm + 1, stresses.depths.size - 1)]))


def _finish_lines(axes: Axes, deepest: float, scale: _Scale, label: str) -> None:
    _into_the_depth(axes, deepest, scale)
    few_ticks(axes, 5, 5)
    axes.grid(color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.set_xlabel(label)


def _add_legend(figure: Figure, middle: float, *, elastic: bool, hot: bool) -> None:
    """What the lines are, below all diagrams: inside it would lie over one of them."""
    kinds: list[tuple[str, dict[str, Any]]] = [("below the largest stress", {"color": STRESSED})]
    kinds += [("below the hottest point", {"color": HEATED})] if hot else []
    kinds += [("elastic part", {"color": "0.3", "linestyle": ELASTIC})] if elastic else []
    draw_lines_legend(figure, kinds, (middle, 0.19))


def _into_the_depth(axes: Axes, deepest: float, scale: _Scale) -> None:
    """z downwards, into the body."""
    axes.set_ylim(deepest, 0.0)
    axes.set_ylabel(scale.z_label)

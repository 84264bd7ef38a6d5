"""Stresses and temperatures below the surface: the plane through the largest stress, and lines into the depth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.model.subsurface import BodyStresses, Peak
from thermoroll_cli.plots.sheet import add_axes, add_text, few_ticks, new_figure, one_line
from thermoroll_cli.plots.units import axes_scales
from thermoroll_cli.plots.view import RunView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[Any]

WIDTH, HEIGHT = 3.0, 2.0
LEFT, BOTTOM, TOP, GAP, BAR_GAP, BAR, AFTER_BAR, ROW_GAP = 0.62, 0.45, 0.42, 0.6, 0.1, 0.1, 0.42, 0.72
STRESS_COLOURS, HEAT_COLOURS = "viridis", "inferno"
LEVELS = 24
LINES = 12
TOTAL, ELASTIC, HEATED = "#d55e00", "#000000", "#0072b2"
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
    place = f"y = {y * 1e3:.3g} mm" if abs(y) > 1e-9 * abs(view.y[-1]) else "y = 0"
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
    title = ", ".join(filter(None, (view.title, f"{body} body")))
    add_text(figure, 0.1, height - 0.08, one_line(title, int(width * 12)), va="top")
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
    _into_the_depth(axes, z, scale)
    axes.set_xlabel(scale.x_label)
    axes.set_title(title)
    few_ticks(axes, 5, 5)
    bar = add_axes(figure, LEFT + WIDTH + BAR_GAP, bottom, BAR, HEIGHT)
    figure.colorbar(image, cax=bar)
    few_ticks(bar, y=6)


def _draw_stress_lines(axes: Axes, stresses: BodyStresses, scale: _Scale) -> None:
    """Von Mises stress along the lines into the depth."""
    z = stresses.depths * scale.z
    lines: list[tuple[Array, str, str, str]] = []
    below, heated = stresses.below_stressed, stresses.below_heated
    elastic = "von_mises_elastic" in below
    lines.append((below["von_mises"], TOTAL if elastic else ELASTIC, "-", "below the largest stress"))
    if elastic:
        lines.append((below["von_mises_elastic"], TOTAL, "--", "elastic part alone"))
    if heated:
        lines.append((heated["von_mises"], HEATED, "-", "below the hottest point"))
        lines.append((heated["von_mises_elastic"], HEATED, "--", "elastic part alone"))
    for values, colour, dashes, label in lines:
        axes.plot(values * scale.stress, z, color=colour, linestyle=dashes, label=label)
    axes.set_xlim(0.0, 1.08 * scale.stress * max(float(values.max()) for values, *_ in lines))
    _finish_lines(axes, z, scale, scale.stress_label)


def _draw_temperature_lines(axes: Axes, stresses: BodyStresses, scale: _Scale) -> None:
    """Temperature rise along the same lines."""
    z = stresses.depths * scale.z
    for fields, colour, label in ((stresses.below_stressed, TOTAL, "below the largest stress"),
                                  (stresses.below_heated, HEATED, "below the hottest point")):
        axes.plot(fields["temperature_rise"], z, color=colour, label=label)
    top = max(float(fields["temperature_rise"].max()) for fields in (stresses.below_stressed, stresses.below_heated))
    axes.set_xlim(0.0, 1.08 * top if top > 0.0 else 1.0)
    _finish_lines(axes, z, scale, "temperature rise (K)")


def _finish_lines(axes: Axes, z: Array, scale: _Scale, label: str) -> None:
    _into_the_depth(axes, z, scale)
    few_ticks(axes, 5, 5)
    axes.grid(color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.set_xlabel(label)
    axes.legend(loc="best")


def _into_the_depth(axes: Axes, z: Array, scale: _Scale) -> None:
    """z downwards, into the body."""
    axes.set_ylim(z[-1], z[0])
    axes.set_ylabel(scale.z_label)

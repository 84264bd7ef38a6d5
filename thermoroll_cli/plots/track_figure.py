"""Temperature across the track of bodies that bring heat back: what they bring, and how hot they get in the contact."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from thermoroll_cli.plots.borders import Array
from thermoroll_cli.plots.field_figures import ALIKE
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.sheet import add_axes, few_ticks, new_figure
from thermoroll_cli.plots.units import TEMPERATURE, axes_scales, scale_of
from thermoroll_cli.plots.view import RunView

WIDTH, HEIGHT = 4.2, 2.6
"""Of the diagram, in inches."""
LEFT, BOTTOM, TOP, RIGHT = 0.72, 1.02, 0.4, 0.15
"""Room around it, in inches."""
COLOURS = {"lower": "#0072b2", "upper": "#d55e00"}
"""Distinct for the colour-blind."""
LOOKS = {
    "hottest along rolling": ("solid", 1.4),
    "as it enters": ((0, (4.0, 1.4)), 1.4),
    "mean of the surface": ((0, (1.0, 1.5)), 1.0),
}
"""Dashes and weight of each kind of temperature."""


def track_figure(view: RunView, normalised: bool) -> Figure | None:
    """Surface temperatures of both bodies against y, surroundings included; None where no body brings heat back."""
    state = view.states[-1]
    returning = [body for body in COLOURS if state.field(f"entry_temperature_{body}") is not None]
    if not returning:
        return None
    figure = new_figure(LEFT + WIDTH + RIGHT, BOTTOM + HEIGHT + TOP)
    axes = add_axes(figure, LEFT, BOTTOM, WIDTH, HEIGHT)
    _, (factor, y_label) = axes_scales(view, normalised)
    y = view.y * factor
    highest, before = 0.0, None
    for body, colour in COLOURS.items():
        rise = state.field(f"temperature_rise_{body}")
        if rise is None:
            continue
        around = state.scalars[f"surface_temperature_max_{body}_K"] - state.scalars[f"temperature_rise_max_{body}_K"]
        curves = {"hottest along rolling": rise.max(axis=0) + around}
        entry = state.field(f"entry_temperature_{body}")
        if entry is not None:
            curves["as it enters"] = entry[0] + around
            curves["mean of the surface"] = np.full(y.size, state.scalars[f"bulk_temperature_{body}_K"])
        highest = max(highest, *(float(np.abs(values).max()) for values in curves.values()))
        if before is not None and _alike(before, curves, highest):
            for line in axes.lines:
                line.set_label(str(line.get_label()).replace("lower:", "both bodies:"))
            break
        for kind, values in curves.items():
            dashes, weight = LOOKS[kind]
            axes.plot(y, values, color=colour, linestyle=dashes, linewidth=weight, label=f"{body}: {kind}")
        before = curves
    inside = np.flatnonzero((state.fields["state"] > 0).any(axis=0))
    half = 0.5 * (y[1] - y[0])
    axes.axvspan(y[inside[0]] - half, y[inside[-1]] + half, color="0.94", linewidth=0, zorder=0, label="contact")
    scale = scale_of(TEMPERATURE, view, highest, normalised=False)[0]
    axes.set_ylabel(scale.label("surface temperature"))
    if scale.factor != 1.0:
        axes.yaxis.set_major_formatter(lambda value, _: f"{value * scale.factor:g}")
    axes.set_xlim(y[0] - half, y[-1] + half)
    axes.set_xlabel(y_label)
    few_ticks(axes, 5, 5)
    axes.grid(color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    figure.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=2, fontsize="small", handlelength=2.6, borderpad=0.2)
    add_headline(figure, view, ", across the track")
    return figure


def _alike(one: Mapping[str, Array], other: Mapping[str, Array], highest: float) -> bool:
    """Whether the curves of both bodies would lie on each other."""
    return one.keys() == other.keys() and all(
        np.allclose(one[kind], other[kind], rtol=0.0, atol=ALIKE * highest) for kind in one)

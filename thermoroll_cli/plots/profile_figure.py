"""The surfaces across the rolling direction above the pressure between them: where a profile touches, and how hard."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from thermoroll_cli.plots.maps import SHORT_BAR, colours_of, draw_map, scale_note
from thermoroll_cli.plots.run_frame import PRESSURE, RunFrame, length_scale
from thermoroll_cli.plots.style import AFTER, BEFORE, DOTTED, DOUBLE, MM, add_headline, add_legend, few_ticks, new_figure
from thermoroll_cli.problem.surface import closest_place, surfaces

SAMPLES = 1001
SURFACES, TALLEST, ROOM = 40.0 * MM, 60.0 * MM, 45.0 * MM
"""Heights of the diagram and at most of the map; width that labels and colour bar take."""


def profile_figure(frame: RunFrame) -> Figure | None:
    """Heights of both unloaded surfaces where they touch first, and the pressure below; None without a profile."""
    drawn = frame.last
    pressure = drawn.values(PRESSURE)
    if not frame.result.problem.geometry.has_profile or pressure is None:
        return None
    turned = RunFrame(**{**vars(frame), "turned": True, "window": frame.domain})
    left, right, low, high = frame.domain
    map_height = min(TALLEST, max((DOUBLE - ROOM) * (right - left) / (high - low), 15.0 * MM))
    figure = new_figure(DOUBLE, SURFACES + map_height + 30.0 * MM)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(SURFACES, map_height))
    _draw_surfaces(top, frame)
    scale = frame.scale(PRESSURE, float(pressure.max()))
    largest = drawn.maximum(PRESSURE) if PRESSURE.maximum not in frame.result.unbounded else float(pressure.max())
    image = draw_map(bottom, turned, drawn, pressure * scale.factor, colours_of(PRESSURE, 0.0, largest * scale.factor))
    bottom.set_box_aspect(None)
    few_ticks(bottom, 8, 4)
    figure.colorbar(image, ax=bottom, label=scale.label if map_height > SHORT_BAR else scale.brief, pad=0.02)
    notes = [scale_note(frame, whole=True), "pressure has no limit at the end of a profile" if frame.result.unbounded else ""]
    add_headline(figure, frame.result.problem.title, frame.result.converged, ", ".join(filter(None, notes)))
    handles, _ = top.get_legend_handles_labels()
    add_legend(figure, handles)
    return figure


def _draw_surfaces(axes: Axes, frame: RunFrame) -> None:
    """Heights over y; a line where the pressure of each patch acts."""
    geometry, result = frame.result.problem.geometry, frame.result
    across, (_, _, left, right) = frame.lengths[1], frame.domain
    y, touch = np.linspace(left, right, SAMPLES), np.array([closest_place(geometry)])
    heights = [sign * (surface.height(y) - surface.height(touch))
               for sign, surface in zip((1.0, -1.0), surfaces(geometry), strict=True)]
    lower, upper = (np.where(np.isfinite(height), height, np.nan) for height in heights)
    # A crown falls without bottom at its very end: three times the approach beyond the other body is enough.
    reach = 3e-6 * result.coupled.scalars["approach_um"]
    high = max(min(float(np.nanmax(height)), float(np.nanmax(lower)) + reach) for height in (lower, upper))
    low = min(max(float(np.nanmin(height)), float(np.nanmin(upper)) - reach) for height in (lower, upper))
    depth = length_scale(max(high, -low), "height")
    for height, words, colour in ((upper, "upper body", AFTER), (lower, "lower body", BEFORE)):
        axes.plot(y * across.factor, height * depth.factor, color=colour, label=f"{words}, unloaded")
    for number, patch in enumerate(result.patches):
        axes.axvline(patch["y_mm"] * 1e-3 * across.factor, color="0.5", linewidth=0.8, linestyle=DOTTED,
                     label="_" if number else "centre of pressure of a patch")
    margin = 0.08 * (high - low or 1.0)
    axes.set_ylim((low - margin) * depth.factor, (high + margin) * depth.factor)
    axes.set_ylabel(depth.label)
    axes.grid(visible=True)
    few_ticks(axes, 8, 4)

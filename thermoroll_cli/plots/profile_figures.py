"""Profiles across rolling: where they touch and how hard, and how they wear over the distance rolled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from thermoroll_cli.plots import style
from thermoroll_cli.plots.maps import SHORT_BAR, colours_of, draw_map, map_note
from thermoroll_cli.plots.run_frame import PRESSURE, AxisScale, RunFrame, unit_for
from thermoroll_cli.problem.problem import BodyName
from thermoroll_cli.tools.arrays import Array


def profile_figure(frame: RunFrame) -> Figure | None:
    """Heights of both unloaded surfaces where they touch first, and the pressure below; None without a profile."""
    drawn = frame.last
    pressure = drawn.values(PRESSURE)
    if not frame.result.patches or pressure is None:
        return None
    turned = replace(frame, turned=True, window=frame.domain)
    left, right, low, high = frame.domain
    # Labels and colour bar take 45 mm beside a map.
    map_height = min(60.0, max(135.0 * (right - left) / (high - low), 15.0)) * style.MM
    figure = style.new_figure(style.DOUBLE, map_height + 70.0 * style.MM)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(40.0 * style.MM, map_height))
    # Heights over y, and a line where the pressure of each patch acts.
    geometry, result = frame.result.problem.geometry, frame.result
    across = frame.lengths[1]
    y = np.linspace(low, high, 1001)
    lower, upper = (np.where(np.isfinite(height), height, np.nan) for height in geometry.section(y))
    # A crown falls without bottom at its very end: three times the approach beyond the other body is enough.
    reach = 3e-6 * result.coupled.scalars["approach_um"]
    highest = max(min(float(np.nanmax(height)), float(np.nanmax(lower)) + reach) for height in (lower, upper))
    lowest = min(max(float(np.nanmin(height)), float(np.nanmin(upper)) - reach) for height in (lower, upper))
    margin = 0.08 * (highest - lowest or 1e-5)  # straight surfaces need some room, too
    depth = AxisScale(*unit_for("m", max(highest, -lowest, margin)), "height")
    for height, words, colour in ((upper, "upper body", style.AFTER), (lower, "lower body", style.BEFORE)):
        top.plot(y * across.factor, height * depth.factor, color=colour, label=f"{words}, unloaded")
    for body, profile in geometry.profiles:
        if profile.measured:
            # Both surfaces are drawn upwards, so what is out of the upper body is drawn downwards.
            (own, given), smoothed = np.array(profile.measured).T, np.array(profile.points)[:, 1]
            y = own + profile.offset
            height = geometry.section(y)[body == "upper"] + (given - smoothed) * (-1.0 if body == "upper" else 1.0)
            top.plot(y * across.factor, height * depth.factor, "k.", markersize=2.0, zorder=1,
                      label=f"{body} body before smoothing")
    for number, patch in enumerate(result.records):
        top.axvline(patch["y_mm"] * 1e-3 * across.factor, color="0.5", linewidth=0.8, linestyle=style.DOTTED,
                     label="_" if number else "centre of pressure of a patch")
    top.set_ylim((lowest - margin) * depth.factor, (highest + margin) * depth.factor)
    top.set_ylabel(depth.label)
    style.few_ticks(top, 8, 4, grid=True)
    scale = frame.scale(PRESSURE, float(pressure.max()))
    largest = drawn.maximum(PRESSURE) if PRESSURE.maximum not in frame.result.unbounded else float(pressure.max())
    image = draw_map(bottom, turned, drawn, pressure * scale.factor, colours_of(PRESSURE, 0.0, largest * scale.factor))
    bottom.set_box_aspect(None)
    style.few_ticks(bottom, 8, 4)
    figure.colorbar(image, ax=bottom, label=scale.label if map_height > SHORT_BAR else scale.brief, pad=0.02)
    top.set_title("section, seen along the flow")
    bottom.set_title(map_note(frame, whole=True))
    note = "the largest pressure has no limit" if frame.result.unbounded else ""
    frame.add_headline(figure, note)
    handles, _ = top.get_legend_handles_labels()
    style.add_legend(figure, handles)
    return figure


def wear_figure(
    title: str, y: Array, profiles: Mapping[BodyName, Array], loads: Array, distances: Array, *,
    work: Array, regimes: Mapping[BodyName, Sequence[float]], converged: bool = True,
) -> Figure:
    """Worn `profiles` (m, by body, (snapshots, points)) at `y` (m), `loads` (N/m), and the
    `distances` (m) of the snapshots. If a body has `regimes` (Pa, the T_γ/A at which each ends) also the largest T_γ/A of
    each line of rolling, `work` (Pa), with the limits of the regimes."""
    worn = {body: heights for body, heights in profiles.items() if np.ptp(heights - heights[0], axis=0).any()}
    limits = {body: places for body, places in regimes.items() if places}
    touched = np.flatnonzero((loads > 1e-3 * loads.max()).any(axis=0))
    margin = max(1, len(touched) // 10)
    shown = slice(max(touched[0] - margin, 0), touched[-1] + margin + 1)
    kilometres, panels = 1e-3 * distances, len(worn) + 1 + len(limits)
    colours = ScalarMappable(Normalize(kilometres[0], kilometres[-1]), matplotlib.colormaps["viridis"])
    with style.applied():
        figure = style.new_figure(style.DOUBLE, 0.21 * style.DOUBLE * panels)
        axes = figure.subplots(panels, 1, sharex=True, squeeze=False)[:, 0]
        curves = [*((1e6 * heights, f"height (µm),\n{body} body") for body, heights in worn.items()),
                  (1e-3 * loads, "line load (N/mm)"),
                  *((1e-6 * work, f"largest $T_γ/A$ (N/mm²),\n{body} body") for body in limits)]
        for axis, (lines, label) in zip(axes, curves, strict=True):
            for distance, line in zip(kilometres, lines, strict=True):
                axis.plot(1e3 * y[shown], line[shown], color=colours.to_rgba(distance))
            axis.set_ylabel(label)
        for axis in axes[len(worn) :]:
            axis.set_ylim(0.0, None)
        for axis, places in zip(axes[len(worn) + 1 :], limits.values(), strict=True):
            # Where one regime of wear ends and the next begins, as far as the axis reaches.
            top = axis.get_ylim()[1]
            edges = [0.0, *(1e-6 * place for place in places if 1e-6 * place < top), top]
            for number, (low, high) in enumerate(pairwise(edges), 1):
                axis.axhline(low, color="0.5", linewidth=0.8, linestyle=style.DOTTED)
                axis.text(0.01, 0.5 * (low + high), f"regime {number}", transform=axis.get_yaxis_transform(), va="center",
                          fontsize=7)
            axis.set_ylim(0.0, top)
        axes[-1].set_xlabel("y (mm)")
        figure.colorbar(colours, ax=list(axes), label="distance rolled (km)")
        style.add_headline(figure, title, converged)
        return figure

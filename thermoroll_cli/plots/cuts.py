"""Fields along lines of the surface: along rolling, without and with thermal deformation (the article's Fig. 10), and the
temperatures across the track of bodies that bring heat back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from thermoroll_cli.plots import style
from thermoroll_cli.plots.maps import flow_label
from thermoroll_cli.plots.run_frame import (
    ALIKE,
    HEAT_FLUX,
    PRESSURE,
    TEMPERATURE,
    TRACTION,
    RunFrame,
    limits_of,
    on_line,
    unit_for,
)
from thermoroll_cli.problem.names import Quantity
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.tools.arrays import Array

LOOKS: tuple[tuple[str, Any], ...] = ((style.BEFORE, "solid"), (style.AFTER, style.DASHED))
"""Colour and dashes of the states without and with thermal deformation."""
OF_UPPER_BODY = {style.BEFORE: "#56b4e9", style.AFTER: "#e69f00"}
LIMIT, LIMIT_WITH_YIELD = "friction limit μp", "limit of friction and of the interlayer"


class Curve(NamedTuple):
    """One line of a diagram: `values` (SI) at `x` (m)."""

    x: Array
    values: Array
    colour: str
    dashes: Any
    label: str
    width: float = 1.3


def centreline_figure(frame: RunFrame) -> Figure | None:
    """Pressure, shear traction, heat flux and temperature along the cut, whichever exist; None without pressure."""
    candidates = [(quantity, curves_of(frame, quantity)) for quantity in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE)]
    diagrams = [(quantity, curves) for quantity, curves in candidates if curves]
    if not diagrams:
        return None
    columns = 2 if len(diagrams) % 2 == 0 else 1  # three, of a cold contact, fill one column of a page
    rows = -(-len(diagrams) // columns)
    handles = line_handles(curve for _, curves in diagrams for curve in curves)
    figure = style.new_figure(style.DOUBLE if columns == 2 else style.SINGLE, (48.0 * rows + 20.0) * style.MM)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True)
    for axes, (quantity, curves) in zip(grid.flat, diagrams, strict=True):
        draw_diagram(axes, frame, quantity, curves)
    for axes in grid[-1]:
        axes.set_xlabel(flow_label(frame))
    frame.add_headline(figure, frame.place_words(frame.cut_y))
    style.add_legend(figure, handles)
    return figure


def over_figure(frames: Mapping[str, RunFrame]) -> Figure | None:
    """Pressure, traction, heat flux and temperature of several results along the cut of each, in its last state, with a colour
    for each name; None where there is nothing to show."""
    colours = dict(zip(frames, (f"C{place}" for place in range(len(frames))), strict=True))
    diagrams = list[tuple[Quantity, list[Curve]]]()
    for quantity in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE):
        curves = [Curve(frame.last.state.x, on_line(frame.last.state.y, values, frame.cut_y), colours[name], dashes,
                        f"{name}, {body} body" if body == "upper" else name)
                  for name, frame in frames.items()
                  for body, dashes in zip(frame.bodies(quantity), ("solid", style.DASHED), strict=False)
                  if (values := frame.last.values(quantity, body)) is not None]
        if any(curve.values.any() for curve in curves):
            diagrams.append((quantity, curves))
    if not diagrams:
        return None
    frame = max(frames.values(), key=lambda each: each.domain[1])
    rows = -(-len(diagrams) // 2)
    figure = style.new_figure(style.DOUBLE if len(diagrams) > 1 else style.SINGLE, (58.0 * rows + 16.0) * style.MM)
    grid = figure.subplots(rows, min(len(diagrams), 2), squeeze=False)
    for axes in grid.flat[len(diagrams):]:
        axes.set_visible(False)
    for axes, (quantity, curves) in zip(grid.flat, diagrams, strict=False):
        draw_diagram(axes, frame, quantity, curves)
        axes.set_xlabel(flow_label(frame))
    style.add_headline(figure, "", all(each.result.converged for each in frames.values()),
                       ", ".join(filter(None, dict.fromkeys(each.place_words(each.cut_y) for each in frames.values()))))
    style.add_legend(figure, line_handles(curve for _, curves in diagrams for curve in curves))
    return figure


def curve_figure(frame: RunFrame, quantity: Quantity) -> Figure | None:
    """A quantity of a line contact over x; None where it was not computed or vanishes."""
    curves = curves_of(frame, quantity)
    if not curves:
        return None
    figure = style.new_figure(style.SINGLE, 70.0 * style.MM)
    axes = figure.subplots()
    draw_diagram(axes, frame, quantity, curves)
    axes.set_xlabel(flow_label(frame))
    frame.add_headline(figure)
    style.add_legend(figure, line_handles(curves))
    return figure


def line_handles(curves: Iterable[Curve]) -> list[Artist]:
    """Handles for the legend of `curves`, the friction limit last."""
    named = {curve.label: curve for curve in curves if curve.label}
    return [Line2D([], [], label=c.label, color=c.colour, linestyle=c.dashes, linewidth=c.width)
            for c in sorted(named.values(), key=lambda curve: curve.label in (LIMIT, LIMIT_WITH_YIELD))]


def draw_diagram(axes: Axes, frame: RunFrame, quantity: Quantity, curves: list[Curve]) -> None:
    """Draw `curves` of a quantity against x."""
    low, high = limits_of([curve.values for curve in curves], from_zero=True)
    scale, x = frame.scale(quantity, max(high, -low, frame.largest(quantity))), frame.lengths[0]
    for curve in curves:
        axes.plot(curve.x * x.factor, curve.values * scale.factor, color=curve.colour, linestyle=curve.dashes,
                  linewidth=curve.width)
    axes.set_xlim(min(curve.x[0] for curve in curves) * x.factor, max(curve.x[-1] for curve in curves) * x.factor)
    axes.set_ylim(1.06 * low * scale.factor, 1.06 * high * scale.factor)
    axes.set_ylabel(scale.label)
    style.few_ticks(axes, 5, 5, grid=True)


def curves_of(frame: RunFrame, quantity: Quantity) -> list[Curve]:
    """The lines of a quantity along the cut; empty where it was not computed or vanishes."""
    curves = []
    bodies = frame.bodies(quantity)
    for drawn, (colour, dashes) in zip(frame.states, LOOKS, strict=False):
        for body in bodies:
            values = drawn.values(quantity, body)
            if values is not None:
                # The lower body's line is the one that all other diagrams have, so only the upper body's is named.
                named = body == "upper" or (body and not drawn.label)
                label = ", ".join(filter(None, (drawn.label, f"{body} body" if named else "")))
                shade = OF_UPPER_BODY[colour] if body == "upper" else colour
                curves.append(Curve(drawn.state.x, on_line(drawn.state.y, values, frame.cut_y), shade, dashes, label))
    if not any(curve.values.any() for curve in curves):
        return []
    friction = frame.result.problem.friction.coefficient
    limit = LIMIT if frame.result.problem.interlayer.yield_stress is None else LIMIT_WITH_YIELD
    for drawn in frame.states if quantity is TRACTION and friction > 0.0 else ():
        if (pressure := drawn.values(PRESSURE)) is not None:
            bound = drawn.state.fields.get("friction_coefficient", friction) * pressure
            curves.append(Curve(drawn.state.x, on_line(drawn.state.y, bound, frame.cut_y), "black", style.DOTTED, limit, 1.1))
    return curves


def track_figure(frame: RunFrame) -> Figure | None:
    """Surface temperatures of both bodies against y, surroundings included; None where no body brings heat back."""
    drawn = frame.last
    fields, scalars, y = drawn.state.fields, drawn.state.scalars, frame.lengths[1]
    if not any(f"entry_temperature_{body}" in fields for body in BODIES):
        return None
    curves: dict[str, dict[str, Array]] = {}
    for body in (body for body in BODIES if f"temperature_rise_{body}" in fields):
        around = scalars[f"surface_temperature_max_{body}_K"] - scalars[f"temperature_rise_max_{body}_K"]
        rise, entry = fields[f"temperature_rise_{body}"], fields.get(f"entry_temperature_{body}")
        curves[body] = {"hottest along rolling": rise.max(axis=0) + around}
        if entry is not None:
            curves[body] |= {"as it enters": entry[0] + around,
                             "mean of the surface": np.full(rise.shape[1], scalars[f"bulk_temperature_{body}_K"])}
    largest = max(float(np.abs(values).max()) for kinds in curves.values() for values in kinds.values())
    names: dict[str, str] = {body: body for body in curves}
    one, other = (curves.get(body, {}) for body in BODIES)
    if one.keys() == other.keys() and all(
            np.allclose(one[kind], other[kind], rtol=0.0, atol=ALIKE * largest) for kind in one):
        names = {"lower": "both bodies"}  # their curves lie on each other
    figure = style.new_figure(style.SINGLE, 70.0 * style.MM)
    axes = figure.subplots()
    factor, unit = unit_for("K", largest)
    for body, colour in zip(BODIES, (style.BEFORE, style.AFTER), strict=True):
        looks = ("solid", 1.4), (style.DASHED, 1.4), (style.DOTTED, 1.0)
        for (kind, values), (dashes, width) in zip(curves[body].items() if body in names else (), looks, strict=False):
            axes.plot(drawn.state.y * y.factor, values * factor, color=colour, linestyle=dashes, linewidth=width,
                      label=f"{names[body]}: {kind}")
    inside = drawn.state.y[(fields["state"] > 0).any(axis=0)]
    half = drawn.half[1]
    axes.axvspan((inside[0] - half) * y.factor, (inside[-1] + half) * y.factor, color="0.93", linewidth=0, zorder=0,
                 label="contact")
    axes.set_xlim(drawn.domain[2] * y.factor, drawn.domain[3] * y.factor)
    axes.set_xlabel(y.label)
    axes.set_ylabel(f"surface temperature ({unit})")
    style.few_ticks(axes, 5, 5, grid=True)
    frame.add_headline(figure)
    handles: list[Artist] = axes.get_legend_handles_labels()[0]
    style.add_legend(figure, handles)
    return figure

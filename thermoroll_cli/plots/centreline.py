"""Fields along the middle of the contact, isothermal and coupled in one diagram each (the article's Fig. 10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from thermoroll_cli.plots.field_figures import UPPER, limits_of, temperatures
from thermoroll_cli.plots.headline import add_headline
from thermoroll_cli.plots.sheet import add_axes, new_figure, real_minus
from thermoroll_cli.plots.ticks import draw_sides
from thermoroll_cli.plots.units import HEAT_FLUX, PRESSURE, TEMPERATURE, TRACTION, axes_scales, scale_of, unit_for
from thermoroll_cli.plots.view import RunView, StateView
from thermoroll_cli.problem.names import Quantity

WIDTH, HEIGHT = 3.05, 1.9
LEFT, BOTTOM, TOP, GAP_X, GAP_Y = 0.68, 0.72, 0.4, 0.78, 0.2

ISOTHERMAL, COUPLED = ("#0072b2", "solid"), ("#d55e00", (0, (4.0, 1.4)))
"""Colour and dashes of the two states; distinct for the colour-blind and in print without colour."""

LIMIT = "friction limit μp"


@dataclass(frozen=True)
class Curve:
    """One line of a diagram, in SI units: `values` at `x`."""

    x: NDArray[np.float64]
    values: NDArray[np.float64]
    colour: str
    dashes: Any
    label: str
    weight: float = 1.3


def centreline_figure(view: RunView, normalised: bool) -> Figure | None:
    """Heat flux, temperature, pressure and shear traction on the centre line, whichever exist; None without pressure."""
    quantities = (HEAT_FLUX, TEMPERATURE, PRESSURE, TRACTION)
    diagrams = [(quantity, curves_of(view, quantity)) for quantity in quantities]
    diagrams = [(quantity, curves) for quantity, curves in diagrams if curves]
    if not diagrams:
        return None
    columns = min(2, len(diagrams))
    rows = -(-len(diagrams) // columns)
    width = LEFT + columns * WIDTH + (columns - 1) * GAP_X + 0.15
    height = BOTTOM + rows * HEIGHT + (rows - 1) * GAP_Y + TOP
    figure = new_figure(width, height)
    for place, (quantity, curves) in enumerate(diagrams):
        row, column = divmod(place, columns)
        axes = add_axes(figure, LEFT + column * (WIDTH + GAP_X), BOTTOM + (rows - 1 - row) * (HEIGHT + GAP_Y), WIDTH, HEIGHT)
        # Its x axis is labelled unless another diagram stands below.
        draw_diagram(axes, view, quantity, curves, normalised, labelled=place + columns >= len(diagrams))
    draw_legend(figure, [curve for _, curves in diagrams for curve in curves], (width / 2, 0.0))
    add_headline(figure, view, f", on {centreline_words(view)}")
    return figure


def draw_legend(figure: Figure, curves: list[Curve], place: tuple[float, float]) -> None:
    """One legend for all diagrams, each kind of line once, with the middle of its lower side at `place` in inches."""
    kinds = {curve.label: curve for curve in curves if curve.label}
    if kinds:
        looks = [(label, {"color": kind.colour, "linestyle": kind.dashes, "linewidth": kind.weight})
                 for label, kind in kinds.items()]
        draw_lines_legend(figure, looks, place)


def draw_lines_legend(figure: Figure, kinds: list[tuple[str, dict[str, Any]]], place: tuple[float, float]) -> None:
    """Words and look of each kind of line in one row, with the middle of its lower side at `place` in inches."""

    handles = [Line2D([], [], label=label, **look) for label, look in kinds]
    width, height = figure.get_size_inches()
    anchor = (place[0] / width, place[1] / height)
    figure.legend(
        handles=handles, loc="lower center", bbox_to_anchor=anchor, ncols=len(handles), handlelength=2.6, borderpad=0.2
    )


def curves_of(view: RunView, quantity: Quantity) -> list[Curve]:
    """The lines of `quantity` along the centre line; empty where it was not computed or vanishes."""
    looks = (ISOTHERMAL, COUPLED) if len(view.states) > 1 else (ISOTHERMAL,)
    curves = []
    for state, (colour, dashes) in zip(view.states, looks, strict=True):
        for body, values in _values(view, state, quantity):
            label = ", ".join(filter(None, (state.label, body)))
            curves.append(Curve(state.x, on_centreline(view, values, state=state), _shade(colour, body), dashes, label))
    if not any(curve.values.any() for curve in curves):
        return []
    friction = float(view.problem.get("friction") or 0.0)
    if quantity is TRACTION and friction > 0.0:
        for state, (colour, _) in zip(view.states, looks, strict=True):
            pressure = state.field("pressure")
            if pressure is not None:
                limit = friction * on_centreline(view, pressure, state=state)
                curves.append(Curve(state.x, limit, colour, (0, (1.0, 1.5)), LIMIT if state is view.states[0] else "", 0.8))
    return curves


def centreline_y(view: RunView) -> float:
    """The y (m) of the centre line: 0, or that of the largest pressure where the bodies do not touch on y = 0."""
    pressure = view.states[-1].field("pressure")
    if pressure is None or on_centreline(view, pressure, 0.0).any():
        return 0.0
    return float(view.y[np.unravel_index(int(pressure.argmax()), pressure.shape)[1]])


def centreline_words(view: RunView) -> str:
    """Where the centre line is."""
    y = centreline_y(view)
    scale = unit_for("m", abs(y))
    return real_minus(f"y = {y * scale.factor:.3g} {scale.unit}") if y else "y = 0"


def on_centreline(
    view: RunView, values: NDArray[np.float64], y: float | None = None, *, state: StateView | None = None
) -> NDArray[np.float64]:
    """`values` of a `state`, of the last one if not given, on the centre line, or at `y` (m): with an even number of elements
    y = 0 lies between two rows."""
    place = centreline_y(view) if y is None else y
    rows = (state or view.states[-1]).y
    above = int(np.clip(np.searchsorted(rows, place), 1, rows.size - 1))
    low, high = rows[above - 1], rows[above]
    share = float(np.clip((place - low) / (high - low), 0.0, 1.0))
    return (1.0 - share) * values[:, above - 1] + share * values[:, above]


def draw_diagram(
    axes: Axes, view: RunView, quantity: Quantity, curves: list[Curve], normalised: bool, *, labelled: bool = True,
    title: str = "",
) -> None:
    """Draw `curves` against x, which is `labelled` or left to a diagram below. What they are stands on the left, or above with
    the rest of the `title` behind it."""
    low, high = limits_of([curve.values for curve in curves], 1.0)
    scale, label = scale_of(quantity, view, max(high, -low), normalised)
    (factor, x_label), _ = axes_scales(view, normalised)
    for curve in curves:
        axes.plot(
            curve.x * factor, curve.values * scale.factor, color=curve.colour, linestyle=curve.dashes, linewidth=curve.weight,
            label=curve.label or None,
        )  # fmt: skip
    axes.set_xlim(min(curve.x[0] for curve in curves) * factor, max(curve.x[-1] for curve in curves) * factor)
    axes.set_ylim(1.06 * low * scale.factor, 1.06 * high * scale.factor)
    if title:
        axes.set_title(label + title, y=1.0, pad=3.0)
    draw_sides(axes, (5, 5), numbered=(labelled, True), labels=(x_label if labelled else "", "" if title else label), grid=True)


def _values(view: RunView, state: StateView, quantity: Quantity) -> list[tuple[str, NDArray[np.float64]]]:
    if quantity is TEMPERATURE:
        # With two states the lower body's line is the one that all other diagrams have, so only the upper body's is named.
        bodies = temperatures(view.states)
        named = len(bodies) > 1
        found = [(body if named and (body == UPPER or not state.label) else "", state.field(name)) for name, body in bodies]
    elif quantity is TRACTION:
        found = [("", state.magnitude("shear"))]
    else:
        found = [("", state.field(quantity.name))]
    return [(body, values) for body, values in found if values is not None]


def _shade(colour: str, body: str) -> str:
    """The state's own colour; a darker relative of it for the upper body."""
    return {ISOTHERMAL[0]: "#56b4e9", COUPLED[0]: "#e69f00"}[colour] if body == UPPER else colour

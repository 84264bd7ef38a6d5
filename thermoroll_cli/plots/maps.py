"""Maps of fields with the borders of contact and stick: the panel that pictures of fields are made of, and these pictures."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label, maximum

from thermoroll_cli.plots import style
from thermoroll_cli.plots.run_frame import (
    LONGEST_ASPECT,
    TEMPERATURE,
    TRACTION,
    WITHOUT,
    AxisScale,
    Borders,
    DrawnState,
    RunFrame,
    limits_of,
)
from thermoroll_cli.problem.names import Quantity
from thermoroll_cli.tools.arrays import Array

CONTACT, STICK = ("white", "black"), ("#38dfff", "black")
"""Colours of a border and of its casing, which make it visible on any ground, and look on dark maps as in the legend."""
LINE, CASING = 0.8, 2.0
"""Widths of a border and of its casing in points."""
ONE_SIDED = 0.1
"""Values of one sign that reach less than this share of those of the other need no diverging colours."""
ARROW: dict[str, Any] = {
    "angles": "uv", "scale": 1.0, "scale_units": "inches", "units": "inches", "width": 0.011, "headwidth": 4.0,
    "headlength": 4.5, "headaxislength": 4.0, "minlength": 0.0, "pivot": "mid", "facecolor": "white", "edgecolor": "0.1",
    "linewidth": 0.3,
}  # fmt: skip
FLAT = 0.45
"""Maps of less height over width stand below each other."""
TALLEST, SHORT_BAR = 120.0 * style.MM, 40.0 * style.MM
"""Largest height of a map; length of a colour bar from which the words fit beside it."""
LABELS, BAR, TITLE, AXIS, HEADLINE, GAP = (size * style.MM for size in (16.5, 21.5, 6.0, 10.0, 5.5, 6.0))
"""Room for labels at the left, the colour bar, a line of words above a map, its axis, the title, between maps."""
LETTER = 1.5 * style.MM
"""Width of a letter of these words."""


class Panel(NamedTuple):
    """One map: its state and values (SI), its reported maximum, the words above it, and whether its maximum has no limit."""

    drawn: DrawnState
    values: Array
    maximum: float
    words: str
    unbounded: bool = False


def field_figure(frame: RunFrame, quantity: Quantity) -> Figure | None:
    """A field of every state, of both bodies where they differ, on one scale; None where it was not computed or vanishes."""
    panels, whole = list[Panel](), lives_everywhere(quantity)
    for body, drawn in itertools.product(frame.bodies(quantity), frame.states):
        if (values := drawn.values(quantity, body)) is not None:
            if not (quantity.from_zero or whole):
                values = _continued(values, drawn.state.fields["state"] > 0)
            of_both = "both bodies" if any(name.endswith("_lower") for name in quantity.fields) else ""
            words = ", ".join(filter(None, (drawn.label, f"{body} body" if body else of_both)))
            panels.append(Panel(drawn, values, drawn.maximum(quantity, body), words,
                                quantity.maximum in frame.result.unbounded))
    largest = max((float(np.abs(panel.values).max()) for panel in panels), default=0.0)
    if not largest > 0.0:
        return None
    scale = frame.scale(quantity, largest)
    low, high = limits_of([panel.values for panel in panels], quantity.from_zero)
    if quantity.maximum and not any(panel.unbounded for panel in panels):
        # Single elements at the end of a crown stand out of the field, and are no part of its maximum.
        high = min(high, max(panel.maximum for panel in panels)) if high > 0.0 else high
    colours = colours_of(quantity, low * scale.factor, high * scale.factor)
    shape = shape_of(frame, whole)
    columns = 1 if shape < FLAT else min(len(panels), 2)
    rows = -(-len(panels) // columns)
    width = style.SINGLE if columns == 1 and shape >= FLAT else style.DOUBLE
    side = min((width - LABELS - BAR - (columns - 1) * GAP) / columns, TALLEST / shape)
    left = LABELS + 0.5 * (width - LABELS - BAR - columns * side - (columns - 1) * GAP)
    longest = max(len(f"{panel.words}, {extremes(panel, scale)}") for panel in panels)
    separator = ", " if longest * LETTER < side else "\n"
    step = side * shape + TITLE * (1.6 if separator == "\n" and any(panel.words for panel in panels) else 1)
    handles = border_handles(frame, arrows=quantity is TRACTION)
    foot = AXIS + style.legend_height(handles, width)
    figure = Figure(figsize=(width, foot + rows * step + HEADLINE))
    for place, panel in enumerate(panels):
        row, column = divmod(place, columns)
        axes = style.add_axes(figure, left + column * (side + GAP), foot + (rows - 1 - row) * step, side, side * shape)
        image = draw_map(axes, frame, panel.drawn, panel.values * scale.factor, colours, whole=whole)
        if quantity is TRACTION:
            draw_arrows(axes, frame, panel.drawn, (side, side * shape))
        axes.set_title(separator.join(filter(None, (panel.words, extremes(panel, scale)))))
        if column > 0:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
        if place + columns < len(panels):
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    length = (rows - 1) * step + side * shape
    bar = style.add_axes(figure, left + columns * (side + GAP) - GAP + 3.0 * style.MM, foot, 3.5 * style.MM, length)
    figure.colorbar(image, cax=bar, label=scale.label if length > SHORT_BAR else scale.brief)
    style.few_ticks(bar, y=6)
    frame.add_headline(figure, map_note(frame, whole))
    style.add_legend(figure, handles)
    return figure


def map_on(axes: Axes, frame: RunFrame, quantity: Quantity) -> bool:
    """Draw the map of a quantity in the last state, of the body where it is largest, with its borders and a colour bar, on the
    caller's `axes`; returns whether there is anything to show."""
    shown = [(values, body) for body in frame.bodies(quantity)
             if (values := frame.last.values(quantity, body)) is not None and values.any()]
    if not shown:
        return False
    values, body = max(shown, key=lambda each: float(each[0].max()))
    whole = lives_everywhere(quantity)
    if not (quantity.from_zero or whole):
        values = _continued(values, frame.last.state.fields["state"] > 0)
    scale = frame.scale(quantity, float(np.abs(values).max()))
    low, high = limits_of([values], quantity.from_zero)
    image = draw_map(axes, frame, frame.last, values * scale.factor,
                     colours_of(quantity, low * scale.factor, high * scale.factor), whole=whole)
    label = ", ".join(filter(None, (scale.label, f"{body} body" if body else "")))
    axes.figure.colorbar(image, ax=axes, label=label)
    return True


def _continued(values: Array, inside: NDArray[np.bool_]) -> Array:
    """`values` with those of the nearest element `inside` the contact around it: a zero there is no value of the field."""
    nearest = distance_transform_edt(~inside, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)]) if inside.any() else values


def lives_everywhere(quantity: Quantity) -> bool:
    """Whether a field goes on outside the contact, as temperatures and displacements do."""
    return quantity is TEMPERATURE or quantity.unit in ("K", "m")


def shape_of(frame: RunFrame, whole: bool) -> float:
    """Height over width of a map as it is drawn."""
    aspect = _aspect(frame, whole)
    return min(max(1.0 / aspect if frame.turned else aspect, 1.0 / LONGEST_ASPECT), LONGEST_ASPECT)


def map_note(frame: RunFrame, whole: bool) -> str:
    """From which side a map is seen, and whether lengths along both axes are drawn alike. z points into the lower body: a map
    with x to the right and y upwards, or turned by 90°, is seen against z."""
    alike = frame.normalised or 1.0 / LONGEST_ASPECT <= _aspect(frame, whole) <= LONGEST_ASPECT
    return "from below" if alike else "from below, axes not to scale"


def _aspect(frame: RunFrame, whole: bool) -> float:
    """Length along y over that along x. Normalised coordinates are drawn as if they were lengths of one unit."""
    left, right, bottom, top = frame.domain if whole else frame.window
    x, y = frame.lengths
    return (top - bottom) / (right - left) * (y.factor / x.factor if frame.normalised else 1.0)


def colours_of(quantity: Quantity, low: float, high: float) -> dict[str, Any]:
    """Colour map and limits for `imshow`: diverging from zero where values of both signs count."""
    if low < 0.0 < high and min(-low, high) > ONE_SIDED * max(-low, high):
        reach = max(-low, high)
        return {"cmap": "RdBu_r", "norm": TwoSlopeNorm(0.0, -reach, reach)}
    return {"cmap": quantity.colours, "norm": Normalize(low, high if high > low else low + 1.0)}


def draw_map(
    axes: Axes, frame: RunFrame, drawn: DrawnState, values: Array, colours: Mapping[str, Any], *, whole: bool = False,
    open_ended: bool = False,
) -> AxesImage:
    """Draw `values` (nx, ny; drawn units) of a state with its borders; dashed, those of the state without thermal deformation.

    The field is clipped by the border of the contact, unless it goes on outside, `open_ended`. The map shows the surroundings
    of the contact or the `whole` domain."""
    image = axes.imshow(values if frame.turned else values.T, origin="lower", extent=_placed(frame, drawn.domain),
                        interpolation="bilinear", aspect="auto", **colours)
    outline = drawn.borders.outline
    if outline is not None and not (whole or open_ended):
        image.set_clip_path(outline, transform=_in_metres(frame) + axes.transData)
    for state in frame.states[:1] if drawn is frame.states[0] else (frame.states[0], drawn):
        draw_borders(axes, state.borders, _in_metres(frame), "solid" if state is drawn else style.DASHED)
    left, right, bottom, top = _placed(frame, frame.domain if whole else frame.window)
    axes.set_xlim(left, right)
    axes.set_ylim((top, bottom) if frame.turned else (bottom, top))
    shape = shape_of(frame, whole)
    axes.set_box_aspect(shape)
    style.few_ticks(axes, 5, 5 if shape > 0.3 else 3)
    x, y = frame.lengths
    axes.set_xlabel(f"{y.label}, material flow ↓" if frame.turned else flow_label(frame))
    axes.set_ylabel(x.label if frame.turned else y.label)
    return image


def draw_borders(axes: Axes, borders: Borders, in_metres: Affine2D, dashes: Any = "solid", *, times: float = 1.0) -> None:
    """Borders of a state, each on a casing, so that they are seen on any ground; `in_metres` takes x, y in m to the map. Lines
    are `times` as wide as in print."""
    clip, place = borders.outline, in_metres + axes.transData
    for lines, (colour, casing) in ((borders.stick, STICK), (borders.contact, CONTACT)):
        for paint, width, look in ((casing, CASING, "solid"), (colour, LINE, dashes)):
            drawn = LineCollection(lines, colors=paint, linewidths=times * width, linestyles=[look], transform=place)
            axes.add_collection(drawn, autolim=False)
            if clip is not None and lines is borders.stick:
                drawn.set_clip_path(clip, transform=place)


def flow_label(frame: RunFrame) -> str:
    """Label of an axis along x, to the right; material of both bodies flows along it."""
    return f"{frame.lengths[0].label}, material flow →"


def _in_metres(frame: RunFrame) -> Affine2D:
    """From places in m to those on a map; the vertical axis of a turned one points downwards."""
    x, y = frame.lengths
    return Affine2D([[0.0, y.factor, 0.0], [x.factor, 0.0, 0.0], [0.0, 0.0, 1.0]]) if frame.turned else (
        Affine2D().scale(x.factor, y.factor))


def _placed(frame: RunFrame, box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Left, right, bottom and top on a map of a box in m."""
    low, high = _in_metres(frame).transform([[box[0], box[2]], [box[1], box[3]]])
    return low[0], high[0], low[1], high[1]


def draw_arrows(axes: Axes, frame: RunFrame, drawn: DrawnState, size: tuple[float, float]) -> None:
    """Arrows along the shear traction at some elements, about as far apart along x as along y on axes of `size` (inches): some
    90 on a patch, where that is 0.1 to 0.3 inches. The longest one of every patch spans most of that distance."""
    state, (left, right, bottom, top) = drawn.state, frame.window
    traction = np.nan_to_num([np.asarray(state.fields[name], dtype=float) for name in TRACTION.fields])
    patches, count = label(state.fields["state"] > 0)
    width, height = size[::-1] if frame.turned else size
    element = (2.0 * drawn.half[0] / (right - left) * width, 2.0 * drawn.half[1] / (top - bottom) * height)
    spacing = math.sqrt(np.count_nonzero(patches) * element[0] * element[1] / (90 * max(count, 1)))
    spacing = min(max(spacing, 0.1), 0.3)
    steps = [max(1, round(spacing / side)) for side in element]
    chosen = np.ix_(*(np.arange((n - 1) % step // 2, n, step) for n, step in zip(patches.shape, steps, strict=True)))
    length = np.hypot(*traction)
    largest = maximum(length, patches, np.arange(count + 1))[patches]
    shown = ((length > 0.04 * largest) & (state.fields["covered"] > 0.5))[chosen]
    arrows = 0.9 * spacing * np.stack([part[chosen][shown] / largest[chosen][shown] for part in traction])
    places = np.stack(np.broadcast_arrays(state.x[chosen[0]], state.y[chosen[1]]), axis=-1)[shown]
    axes.quiver(*_in_metres(frame).transform(places).T, *((arrows[1], -arrows[0]) if frame.turned else arrows), **ARROW)


def extremes(panel: Panel, scale: AxisScale) -> str:
    """The largest value with its unit, and the smallest where it is negative."""
    low = float(panel.values.min())
    parts = [("max", panel.maximum)] if panel.maximum > 0.0 else []
    parts += [("min", low)] if low < -ONE_SIDED * float(np.abs(panel.values).max()) else []
    shown = [f"{words} {value * scale.factor:.4g} {scale.unit}".rstrip() for words, value in reversed(parts)]
    text = style.readable(", ".join(shown))
    return f"{text} (no limit)" if panel.unbounded else text


def border_handles(frame: RunFrame, *, arrows: bool = False) -> list[Artist]:
    """Handles for the legend of a run's maps."""
    handles = kinds_of_borders(state.borders for state in frame.states)
    if len(frame.states) > 1:
        handles.append(_handle(WITHOUT, *CONTACT, style.DASHED))
    if arrows:
        several = max(label(drawn.state.fields["state"] > 0)[1] for drawn in frame.states) > 1
        words = "traction on the upper body" + (", scaled in each patch" if several else "")
        arrow = Path([(-1.0, -0.1), (0.3, -0.1), (0.3, -0.35), (1.0, 0.0), (0.3, 0.35), (0.3, 0.1), (-1.0, 0.1), (-1.0, -0.1)])
        handles.append(Line2D([], [], linestyle="none", marker=arrow, markersize=11.0, color="white",
                              markeredgecolor="black", markeredgewidth=0.5, label=words))
    return handles


def kinds_of_borders(several: Iterable[Borders]) -> list[Artist]:
    """Handles for the legend of maps with `several` borders of contact and stick."""
    kinds = [("contact border", CONTACT)]
    kinds += [("stick border", STICK)] if any(borders.stick for borders in several) else []
    return [_handle(words, *colours, "solid") for words, colours in kinds]


def _handle(words: str, colour: str, casing: str, dashes: Any) -> Line2D:
    return Line2D([], [], color=colour, linewidth=LINE, linestyle=dashes, label=words,
                  path_effects=[withStroke(linewidth=CASING, foreground=casing)])

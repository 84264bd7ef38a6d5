"""One field as a map with its borders: the panel that all pictures of fields are made of."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.image import AxesImage
from matplotlib.path import Path
from numpy.typing import NDArray

from thermoroll_cli.plots.borders import Array, Borders, Lines, borders_of
from thermoroll_cli.plots.units import axes_scales
from thermoroll_cli.plots.view import RunView

OUTSIDE = "0.92"
CONTACT_COLOUR = "#e8262a"
STICK_COLOUR = "white"
MARGIN = 0.06
ARROWS, CLOSEST, WIDEST = 170, 0.14, 0.3
"""About so many arrows on a map, at least and at most so far apart (inches)."""


@dataclass(frozen=True)
class Frame:
    """What all maps of one run share: coordinates of each state in drawn units, axis labels, the borders of each state in these
    units, the window around the contacts (left, right, bottom, top), and how many units of x a unit of y is (1 for
    normalised coordinates, which are drawn as if they were lengths)."""

    coordinates: tuple[tuple[Array, Array], ...]
    x_label: str
    y_label: str
    borders: tuple[Borders, ...]
    window: tuple[float, float, float, float]
    y_in_x: float = 1.0

    def view(self, whole_domain: bool) -> tuple[float, float, float, float]:
        """What a map shows: left, right, bottom, top."""
        return self.domain if whole_domain else self.window

    def aspect(self, whole_domain: bool) -> float:
        """True height over width of what a map shows."""
        left, right, bottom, top = self.view(whole_domain)
        return (top - bottom) * self.y_in_x / (right - left)

    @property
    def domain(self) -> tuple[float, float, float, float]:
        """What the domains of all states take together."""
        left, right, bottom, top = zip(*(self.domain_of(number) for number in range(len(self.coordinates))), strict=True)
        return min(left), max(right), min(bottom), max(top)

    def domain_of(self, state: int) -> tuple[float, float, float, float]:
        """The whole domain of a state, to the rims of its elements."""
        x, y = self.coordinates[state]
        dx, dy = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
        return x[0] - dx, x[-1] + dx, y[0] - dy, y[-1] + dy


def frame_of(view: RunView, normalised: bool) -> Frame:
    """The shared frame of a run's maps."""
    (x_factor, x_label), (y_factor, y_label) = axes_scales(view, normalised)
    factors = np.array([x_factor, y_factor])
    borders = tuple(_scaled(borders_of(state.x, state.y, state), factors) for state in view.states)
    y_in_x = 1.0 if normalised else x_factor / y_factor
    coordinates = tuple((state.x * x_factor, state.y * y_factor) for state in view.states)
    frame = Frame(coordinates, x_label, y_label, borders, (0.0, 0.0, 0.0, 0.0), y_in_x)
    points = [line for border in borders for line in border.contact]
    if not points:
        return dataclasses.replace(frame, window=frame.domain)
    low, high = np.min(np.vstack(points), axis=0), np.max(np.vstack(points), axis=0)
    rim = MARGIN * (high - low)
    left, right, bottom, top = frame.domain
    sides = (max(left, low[0] - rim[0]), min(right, high[0] + rim[0]))
    ends = (max(bottom, low[1] - rim[1]), min(top, high[1] + rim[1]))
    return dataclasses.replace(frame, window=(*sides, *ends))


def draw_map(
    axes: Axes,
    frame: Frame,
    values: NDArray[np.float64],
    *,
    state: int,
    colours: str,
    limits: tuple[float, float],
    clipped: bool = True,
    whole_domain: bool = False,
) -> AxesImage:
    """Draw `values` (drawn units, shape (nx, ny)) of the frame's state number `state` into `axes`.

    A field that lives in the contact is `clipped` by its border, a temperature is not. The isothermal borders are
    solid; on the coupled map its own are added, dashed. What is shown is the surroundings of the contact or the
    `whole_domain`.
    """
    image = axes.imshow(
        values.T,
        origin="lower",
        extent=frame.domain_of(state),
        vmin=limits[0],
        vmax=limits[1],
        cmap=colours,
        interpolation="bilinear",
        aspect="auto",
    )
    inside = _path(frame.borders[state].contact)
    # Also where another state was computed, but not this one.
    axes.set_facecolor(OUTSIDE)
    if clipped:
        if inside is not None:
            image.set_clip_path(inside, transform=axes.transData)
    for number, dashes in _line_styles(state):
        borders = frame.borders[number]
        _add_lines(axes, borders.contact, CONTACT_COLOUR, dashes)
        lines = _add_lines(axes, borders.stick, STICK_COLOUR, dashes)
        clip = _path(borders.contact)
        if lines is not None and clip is not None:
            lines.set_clip_path(clip, transform=axes.transData)
    left, right, bottom, top = frame.view(whole_domain)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    return image


def draw_arrows(axes: Axes, view: RunView, frame: Frame, number: int, size: tuple[float, float]) -> None:
    """Arrows along the shear traction of the state of this number, on a lattice of their own that is the same for every grid.

    `size` is that of the axes in inches: the lattice is square on paper and symmetrical about its middle. The longest
    arrow spans most of a spacing; those below 4 % of it are left out.
    """
    shear_x, shear_y = (view.states[number].field(name) for name in ("shear_x", "shear_y"))
    if shear_x is None or shear_y is None:
        return
    left, right, bottom, top = frame.window
    spacing = min(max(math.sqrt(size[0] * size[1] / ARROWS), CLOSEST), WIDEST)
    columns, rows = (max(3, round(length / spacing)) for length in size)
    x = left + (np.arange(columns) + 0.5) / columns * (right - left)
    y = bottom + (np.arange(rows) + 0.5) / rows * (top - bottom)
    u, v = (_sampled(frame.coordinates[number], component, x, y) for component in (shear_x, shear_y))
    length = np.hypot(u, v)
    largest = max(float(np.hypot(shear_x, shear_y).max()), 1e-300)
    shown = length > 0.04 * largest
    points_x, points_y = np.meshgrid(x, y, indexing="ij")
    inside = _path(frame.borders[number].contact)
    if inside is not None:
        places = np.stack([points_x.ravel(), points_y.ravel()], axis=1)
        shown &= inside.contains_points(places).reshape(shown.shape)
    unit = 0.9 * min(spacing, size[0] / columns, size[1] / rows) / largest
    axes.quiver(
        points_x[shown],
        points_y[shown],
        u[shown] * unit,
        v[shown] * unit,
        angles="uv",
        scale=1.0,
        scale_units="inches",
        units="inches",
        width=0.011,
        headwidth=4.0,
        headlength=4.5,
        headaxislength=4.0,
        minlength=0.0,
        pivot="mid",
        facecolor="white",
        edgecolor="0.1",
        linewidth=0.3,
    )


def legend_entries(view: RunView, with_stick: bool) -> list[tuple[str, dict[str, Any]]]:
    """Words and line style of every kind of border in a run's maps."""
    kinds = [("contact border", CONTACT_COLOUR)] + ([("stick border", STICK_COLOUR)] if with_stick else [])
    return [
        (f"{words}, {state.label}" if state.label else words, {"color": colour, "linestyle": dashes})
        for words, colour in kinds
        for state, (_, dashes) in zip(view.states, _line_styles(len(view.states) - 1), strict=True)
    ]


def _line_styles(state: int) -> list[tuple[int, Any]]:
    styles: list[tuple[int, Any]] = [(0, "solid"), (1, (0, (3.0, 1.6)))]
    return styles[: state + 1]


def _scaled(borders: Borders, factors: Array) -> Borders:
    return Borders([line * factors for line in borders.contact], [line * factors for line in borders.stick])


def _add_lines(axes: Axes, lines: Lines, colour: str, dashes: Any) -> Artist | None:

    if not lines:
        return None
    collection = LineCollection(lines, colors=colour, linewidths=1.1, linestyles=[dashes])
    axes.add_collection(collection, autolim=False)
    return collection


def _path(lines: Sequence[Array]) -> Any:

    return Path.make_compound_path(*(Path(line, closed=True) for line in lines)) if lines else None


def _sampled(coordinates: tuple[Array, Array], values: Array, x: Array, y: Array) -> Array:
    """Bilinear interpolation of `values`, given at `coordinates`, at all combinations of `x` and `y`."""
    (i, s), (j, t) = (_position(axis, points) for axis, points in zip(coordinates, (x, y), strict=True))
    s, t = s[:, None], t[None, :]
    corner = [values[np.ix_(i + a, j + b)] for a in (0, 1) for b in (0, 1)]
    return (1 - s) * ((1 - t) * corner[0] + t * corner[1]) + s * ((1 - t) * corner[2] + t * corner[3])


def _position(axis: Array, points: Array) -> tuple[NDArray[np.int_], Array]:
    position = np.clip((points - axis[0]) / (axis[1] - axis[0]), 0.0, axis.size - 1.0)
    index = np.minimum(position.astype(int), axis.size - 2)
    return index, position - index

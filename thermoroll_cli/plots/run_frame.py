"""All that the pictures of one run share: its states, units and axes, borders, the part that maps show, and the cut."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from contourpy import contour_generator
from matplotlib.figure import Figure
from matplotlib.path import Path
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter, gaussian_filter1d

from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import MULTIPLES, QUANTITIES, Quantity
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.tools.arrays import Array

Lines = list[Array]
"""Polylines, each of shape (points, 2) in m."""

PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE = (QUANTITIES[n] for n in ("pressure", "traction", "heat_flux", "temperature"))

WITHOUT, WITH = "without thermal deformation", "with thermal deformation"

READABLE = (0.1, 1e4)
"""The usual unit is kept while the largest number lies in here."""
LONGEST_ASPECT = 5.0
"""Maps whose sides differ by more are drawn with this ratio instead of the true one."""
ALIKE = 5e-3
"""Share of the largest temperature by which those of both bodies differ at most where one picture stands for both."""
SMOOTHING = 1.2
"""Width in elements of the bell by which covered shares are averaged: the border runs between the elements, without steps."""
RIM = 4
"""Elements added around the grid, for contacts that reach its rim."""


@dataclass(frozen=True)
class Borders:
    """Border of the contact (closed lines) and between stick and slip (to be clipped by the contact)."""

    contact: Lines
    stick: Lines

    @property
    def outline(self) -> Path | None:
        """The contact as one path to clip by; None without contact."""
        return Path.make_compound_path(*(Path(line, closed=True) for line in self.contact)) if self.contact else None


@dataclass(frozen=True)
class AxisScale:
    """`factor` turns SI values into the drawn ones, `unit` is their unit ("" for none), `words` and `symbol` the quantity."""

    factor: float
    unit: str
    words: str
    symbol: str = ""

    @property
    def label(self) -> str:
        words = f"{self.words} {self.symbol}".strip()
        return f"{words} ({self.unit})" if self.unit else words

    @property
    def brief(self) -> str:
        """A label of the symbol alone."""
        return f"{self.symbol} ({self.unit})" if self.symbol and self.unit else self.symbol or self.unit


@dataclass(frozen=True)
class DrawnState:
    """A state, what pictures call it ("" if there is only one), and its borders in m."""

    label: str
    state: State
    borders: Borders

    def values(self, quantity: Quantity, body: str = "") -> Array | None:
        """The quantity at the element centres (SI), the length of a vector; None where it was not computed."""
        vector = quantity.fields[0].endswith("_x")
        names = quantity.fields if vector or not body else [name for name in quantity.fields if name.endswith(body)]
        present = [self.state.fields.get(name) for name in names]
        arrays = [np.nan_to_num(np.asarray(values, dtype=float)) for values in present
                  if values is not None and np.isfinite(values).any()]
        if not arrays or (vector and len(arrays) < len(names)):
            return None
        return np.hypot(*arrays) if vector and len(arrays) > 1 else arrays[0]

    def maximum(self, quantity: Quantity, body: str = "") -> float:
        """The largest value as it is reported among the scalars, in SI units; that of the field where it is not."""
        reported = self.state.scalars.get(quantity.maximum.format(body or "lower"), math.nan)
        if math.isfinite(reported):
            return float(reported) * (1.0 if quantity.unit == "K" else 1e6)
        values = self.values(quantity, body)
        return math.nan if values is None else float(values.max())

    @property
    def half(self) -> tuple[float, float]:
        """Half of an element; of a line contact as wide as long."""
        if not len(self.state.y):
            return (0.5 * float(self.state.x[1] - self.state.x[0]),) * 2
        return 0.5 * float(self.state.x[1] - self.state.x[0]), 0.5 * float(self.state.y[1] - self.state.y[0])

    @property
    def domain(self) -> tuple[float, float, float, float]:
        """Smallest and largest x, y (m) to the rims of the elements."""
        (dx, dy), x, y = self.half, self.state.x, self.state.y if len(self.state.y) else np.zeros(1)
        return float(x[0]) - dx, float(x[-1]) + dx, float(y[0]) - dy, float(y[-1]) + dy


@dataclass(frozen=True)
class RunFrame:
    """One result as its pictures see it. The last of `states` is the one with all that feeds back.

    `normalised` pictures have the article's dimensionless quantities. `cut_y` is the line (m) along which fields are drawn over
    x. All maps are seen from below, against z; `turned` ones have y to the right and x downwards.
    """

    result: Result
    normalised: bool
    states: tuple[DrawnState, ...]
    cut_y: float
    window: tuple[float, float, float, float]
    turned: bool

    def add_headline(self, figure: Figure, note: str = "") -> None:
        """The title of the case above a picture, of a history with the state that is drawn, and a `note`."""
        style.add_headline(figure, self.result.problem.title, self.result.converged,
                           ", ".join(filter(None, (self.result.last_of, note))))

    @property
    def line(self) -> bool:
        """Whether the contact is a line contact, whose fields are curves over x and no maps."""
        return not len(self.last.state.y)

    @property
    def last(self) -> DrawnState:
        return self.states[-1]

    @property
    def domain(self) -> tuple[float, float, float, float]:
        """The domains of all states together, as `window`: smallest and largest x, y in m."""
        return _around([state.domain for state in self.states])

    @property
    def lengths(self) -> tuple[AxisScale, AxisScale]:
        """Scales of x and y: over the Hertz semi-axes, or in one unit for both unless the domain is so long that it cannot be
        drawn to scale anyway."""
        hertz = self.result.of_problem
        if self.normalised and math.isfinite(hertz["hertz_a_mm"]):
            b = hertz.get("hertz_b_mm", hertz["hertz_a_mm"])
            return AxisScale(1e3 / hertz["hertz_a_mm"], "", "x/a₀"), AxisScale(1e3 / b, "", "y/b₀")
        left, right, bottom, top = self.domain
        sizes = [max(-left, right), max(-bottom, top)]
        if max(sizes) < LONGEST_ASPECT * min(sizes):
            sizes = [max(sizes)] * 2
        x, y = (AxisScale(*unit_for("m", size), words) for size, words in zip(sizes, "xy", strict=True))
        return x, y

    def place_words(self, y: float) -> str:
        """Where a plane or line along x at `y` (m) is; "" in a line contact."""
        if self.line:
            return ""
        across = self.lengths[1]
        value = round(y * across.factor, 6)
        return f"{across.words} = " + (style.readable(f"{value:.3g} {across.unit}").rstrip() if value else "0")

    def largest(self, quantity: Quantity) -> float:
        """The largest magnitude (SI) of a quantity in all states: pictures of a run have one unit for it."""
        drawn = (state.values(quantity, body) for state in self.states for body in self.bodies(quantity))
        return max((float(np.abs(values).max()) for values in drawn if values is not None), default=0.0)

    def scale(self, quantity: Quantity, largest: float) -> AxisScale:
        """The scale of a quantity with values up to `largest` (SI)."""
        divisor = {"Pa": self.result.of_problem["hertz_p0_MPa"] * 1e6, "W/m2": self.heat_scale}.get(quantity.unit, math.nan)
        if self.normalised and math.isfinite(divisor):
            return AxisScale(1.0 / divisor, "", quantity.words, quantity.normalised)
        factor, unit = unit_for(quantity.unit, largest)
        return AxisScale(factor, unit, quantity.words, quantity.symbol)

    @property
    def heat_scale(self) -> float:
        """k/(α l) with l = 1 mm, by which the article divides heat fluxes; nan without thermal constants."""
        lower = self.result.problem.lower
        return lower.conductivity / (lower.expansion * 1e-3) if lower.conductivity and lower.expansion else math.nan

    def bodies(self, quantity: Quantity) -> list[str]:
        """Bodies whose fields of `quantity` are worth drawing: "" for one that is of no body or alike for both."""
        named: list[str] = [body for body in BODIES if any(name.endswith(body) for name in quantity.fields)]
        if not named:
            return [""]
        by_body = {body: [state.values(quantity, body) for state in self.states] for body in named}
        there = {body: [v for v in values if v is not None] for body, values in by_body.items()}
        shown = [body for body in named if there[body]]
        if len(shown) < 2:
            return shown
        largest = max(float(np.abs(v).max()) for values in there.values() for v in values)
        alike = all(np.allclose(one, other, rtol=0.0, atol=ALIKE * largest)
                    for one, other in zip(*(there[body] for body in shown), strict=True))
        return [""] if alike else shown


def frame_of(result: Result, normalised: bool = False, cut_y: float | None = None) -> RunFrame:
    """The frame of a result; the cut, if not given (m), runs along y = 0, or along the row that passes the largest share of
    every maximum of pressure, traction, heat and temperature if y = 0 passes less than 0.7 of that.

    Raises ValueError for a cut outside the domain.
    """
    states = [result.coupled] if result.coupled is result.isothermal else [result.isothermal, result.coupled]
    labels = [""] if len(states) == 1 else [WITHOUT, WITH]
    drawn = tuple(DrawnState(label, state, borders_of(state.x, state.y, state.fields) if len(state.y) else Borders([], []))
                  for label, state in zip(labels, states, strict=True))
    domain = _around([state.domain for state in drawn])
    if not len(result.y):
        if cut_y is not None:
            raise ValueError("a line contact is the same at every y: there is no cut to choose")
        return RunFrame(result, normalised, drawn, 0.0, domain, turned=False)
    points = [line for state in drawn for line in state.borders.contact]
    window = domain
    if points:
        low, high = np.min(np.vstack(points), axis=0), np.max(np.vstack(points), axis=0)
        rim = 0.06 * (high - low)
        window = (max(domain[0], low[0] - rim[0]), min(domain[1], high[0] + rim[0]),
                  max(domain[2], low[1] - rim[1]), min(domain[3], high[1] + rim[1]))
    if cut_y is None:
        rows, quantities = drawn[-1].state.y, [drawn[-1].values(one) for one in (PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE)]
        fields: list[Any] = [values / np.abs(values).max() for values in quantities if values is not None and values.any()]
        shares = np.min([np.abs(values).max(axis=0) for values in fields], axis=0) if fields else np.zeros(1)
        middle = min((float(np.abs(on_line(rows, values, 0.0)).max()) for values in fields), default=1.0)
        cut_y = 0.0 if middle >= 0.7 * shares.max() else float(rows[int(shares.argmax())])
    elif not domain[2] <= cut_y <= domain[3]:
        raise ValueError(f"the cut y = {1e3 * cut_y:g} mm is outside the domain, "
                         f"{1e3 * domain[2]:.4g} mm to {1e3 * domain[3]:.4g} mm")
    turned = window[3] - window[2] > 1.6 * (window[1] - window[0])
    return RunFrame(result, normalised, drawn, cut_y, window, turned)


def on_line(rows: Array, values: Array, y: float) -> Array:
    """`values` (nx, ny) along x at `y`, linear between the `rows` of element centres: between which y = 0 may lie; those (nx,)
    of a line contact as they are."""
    if values.ndim == 1:
        return values
    above = int(np.clip(np.searchsorted(rows, y), 1, rows.size - 1))
    share = float(np.clip((y - rows[above - 1]) / (rows[above] - rows[above - 1]), 0.0, 1.0))
    return np.asarray((1.0 - share) * values[:, above - 1] + share * values[:, above])


def limits_of(fields: Iterable[Array], from_zero: bool) -> tuple[float, float]:
    """Smallest and largest value of a scale: from zero if that means something or is near; values that are rounding beside the
    largest count as zero."""
    fields = list(fields)
    low, high = min(float(f.min()) for f in fields), max(float(f.max()) for f in fields)
    rounding = 1e-3 * max(high, -low)
    near = 0.15 * (high - low)
    if abs(low) <= rounding or (low > 0.0 and (from_zero or low < near)):
        low = 0.0
    if abs(high) <= rounding or (high < 0.0 and (from_zero or -high < near)):
        high = 0.0
    return low, high


def unit_for(unit: str, largest: float) -> tuple[float, str]:
    """Factor and name of the multiple of the SI `unit` in which `largest` reads well: the usual one if it does."""
    if unit not in MULTIPLES:
        return 1.0, "" if unit == "1" else unit
    usual, ladder = MULTIPLES[unit]
    name, size = ladder[usual]
    if largest > 0.0 and math.isfinite(largest) and not READABLE[0] <= largest / size < READABLE[1]:
        name, size = next((step for step in reversed(ladder) if largest >= step[1]), ladder[0])
    return 1.0 / size, name


def _around(boxes: Iterable[tuple[float, float, float, float]]) -> tuple[float, float, float, float]:
    left, right, bottom, top = zip(*boxes, strict=True)
    return min(left), max(right), min(bottom), max(top)


def borders_of(x: Array, y: Array, fields: Mapping[str, NDArray[Any]]) -> Borders:
    """Borders of a state with these fields at the element centres `x`, `y`: where half of an averaged element is in the
    contact, and where sticking ends along x."""
    covered, sticking = (np.pad(np.asarray(fields[name], dtype=float), RIM) for name in ("covered", "stick_share"))
    axes = (_widened(x), _widened(y))
    element = np.array([x[1] - x[0], y[1] - y[0]])
    averaged = gaussian_filter(covered, SMOOTHING, mode="constant", truncate=RIM / SMOOTHING)
    contact = [_rounded(line / element) * element for line in _contours(axes, averaged - 0.5)]
    if not sticking.any() or np.array_equal(sticking, covered):
        return Borders(contact, [])
    distance = gaussian_filter(_distance_from_slip(sticking, covered), 0.7, mode="nearest")
    outline = Borders(contact, []).outline
    return Borders(contact, [line for line in _contours(axes, distance) if _is_shown(line, element, outline)])


def _distance_from_slip(sticking: Array, covered: Array) -> Array:
    """Distance along x from the border between stick and slip, in elements (15 at most, in which borders nearly along x advance
    by one row), negative where surfaces slip.

    Shares know that border within an element along x only. The distance is linear across it, so that a contour of zero is
    straight between neighbouring rows, where a contour of the shares would have a step for each row."""
    nearest = distance_transform_edt(covered == 0.0, return_distances=False, return_indices=True)
    share = (sticking / np.where(covered > 0.0, covered, 1.0))[tuple(nearest)]
    sticks, place = share > 0.5, np.arange(share.shape[0], dtype=float)[:, None]
    border = place[:-1] + 0.5 + np.where(sticks[:-1], 1.0, -1.0) * (share[:-1] + share[1:] - 1.0)
    there, far = sticks[1:] != sticks[:-1], np.full((1, share.shape[1]), np.inf)
    before = np.maximum.accumulate(np.vstack([-far, np.where(there, border, -np.inf)]))
    after = np.minimum.accumulate(np.vstack([np.where(there, border, np.inf), far])[::-1])[::-1]
    return np.asarray(np.where(sticks, 1.0, -1.0) * np.clip(np.minimum(place - before, after - place), 0.0, 15.0))


def _contours(axes: tuple[Array, Array], values: Array) -> Lines:
    """Lines where `values` are zero."""
    return [np.asarray(line) for line in contour_generator(*axes, values.T, name="serial").lines(0.0)]


def _rounded(line: Array) -> Array:
    """A closed line, in elements, without waves of the size of an element: averaged along itself by a bell of 3 elements, or of
    1/40 of a shorter line."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    length = float(steps.sum())
    count = max(8, round(4.0 * length))
    places = np.arange(count) * (length / count)
    even = np.stack([np.interp(places, np.concatenate([[0.0], np.cumsum(steps)]), part) for part in line.T], axis=1)
    bell = min(3.0, length / 40.0) * count / length
    smooth = gaussian_filter1d(even, bell, axis=0, mode="wrap")
    return np.asarray(np.vstack([smooth, smooth[:1]]))


def _is_shown(line: Array, element: Array, outline: Path | None) -> bool:
    """Whether a stick border, with its sides over those of an `element`, is large enough to be placed: its length inside the
    `outline` of the contact, and the area in a closed one."""
    x, y = (line / element).T
    inside = np.zeros(len(line), dtype=bool) if outline is None else outline.contains_points(line)
    long = np.hypot(np.diff(x), np.diff(y))[inside[1:] & inside[:-1]].sum() > 4.0
    closed = np.array_equal(line[0], line[-1])
    return bool(long and (not closed or 0.5 * abs(x[:-1] @ y[1:] - x[1:] @ y[:-1]) > 6.0))


def _widened(axis: Array) -> Array:
    """Element centres with RIM more on each side."""
    step = axis[1] - axis[0]
    return axis[0] + step * np.arange(-RIM, axis.size + RIM)

"""The uniform grid of rectangular elements that all fields live on, interpolation from one grid to another, and formulas on the
elements around each one: highest value, slope, and the peak of a field between its samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.tools.arrays import AnyArray, Array, Mask


class Domain(NamedTuple):
    """A rectangle of `side_x` × `side_y` (m) about x = `centre_x`, y = `centre`."""

    side_x: float
    side_y: float
    centre: float = 0.0
    centre_x: float = 0.0

    @property
    def area(self) -> float:
        """Area in m²; of a line contact, whose `side_y` is inf, per m of length."""
        return self.side_x * (1.0 if math.isinf(self.side_y) else self.side_y)


@dataclass(frozen=True)
class Grid:
    """`nx` × `ny` rectangular elements of `dx` × `dy` (m), centred on x = `centre_x`, y = `centre`; arrays are indexed
    [ix, iy]. The elements of a line contact have no end across: `ny` is 1 and `dy` is inf, and all areas and sums over them are
    per m of length."""

    nx: int
    ny: int
    dx: float
    dy: float
    centre: float = 0.0
    centre_x: float = 0.0

    @classmethod
    def over(cls, shape: tuple[int, int], side_x: float, side_y: float, centre: float = 0.0, centre_x: float = 0.0) -> Grid:
        """Grid with `shape` elements over a `Domain` of side_x × side_y (m) about x = `centre_x`, y = `centre`."""
        nx, ny = shape
        return cls(nx, ny, side_x / nx, side_y / ny, centre, centre_x)

    @property
    def shape(self) -> tuple[int, int]:
        return self.nx, self.ny

    @property
    def sides(self) -> tuple[int, ...]:
        """`shape` without the side of a line contact, which has one element."""
        return self.shape[: 1 if math.isinf(self.dy) else 2]

    @property
    def element_area(self) -> float:
        """Area of an element in m²; of a line contact per m of length."""
        return self.dx * (1.0 if math.isinf(self.dy) else self.dy)

    @property
    def size(self) -> float:
        """Side in m of a square of the same area; the length of a line contact."""
        return math.sqrt(math.prod(n * side for n, side in zip(self.shape, (self.dx, self.dy), strict=True))) if (
            len(self.sides) > 1) else self.nx * self.dx

    @cached_property
    def x(self) -> Array:
        """Element centres along x, shape (nx,)."""
        return self.rows_with(0)

    @cached_property
    def y(self) -> Array:
        """Element centres along y, shape (ny,)."""
        if self.ny == 1:
            return np.array([self.centre])
        return np.asarray((np.arange(self.ny) - 0.5 * (self.ny - 1)) * self.dy + self.centre, dtype=np.float64)

    def rows_with(self, margin: int) -> Array:
        """Element centres along x with `margin` more at either end, shape (nx + 2 margin,)."""
        index = np.arange(-margin, self.nx + margin)
        return np.asarray((index - 0.5 * (self.nx - 1)) * self.dx + self.centre_x, dtype=np.float64)


def interpolation_matrix(source: Array, target: Array) -> Array:
    """Linear interpolation from uniformly spaced points `source` to `target`, constant beyond the ends: (nt, ns)."""
    n = len(source)
    if n == 1:
        return np.ones((len(target), 1))
    # Rounded: between equal grids nothing changes, zeros least of all.
    position = np.clip(np.round((target - source[0]) / (source[1] - source[0]), 9), 0.0, n - 1.0)
    left = np.minimum(position.astype(int), n - 2)
    weight = position - left
    rows = np.arange(len(target))
    matrix = np.zeros((len(target), n))
    matrix[rows, left] = 1.0 - weight
    matrix[rows, left + 1] += weight
    return matrix


def value_at(grid: Grid, field: Array, x: float, y: float) -> float:
    """The value of a `field` (nx, ny) at one place in m, by cubics through four elements along each direction.

    Beside a steep edge cubics overshoot: a value exceeds those of the four only where the inner two exceed the outer ones, by
    an eighth of that at most, as a parabola does."""
    for points, place in ((grid.x, x), (grid.y, y)):
        if len(points) == 1:
            field = field[0]
            continue
        first = min(max(int(np.searchsorted(points, place)) - 2, 0), max(len(points) - 4, 0))
        near, values = points[first : first + 4].tolist(), field[first : first + 4]
        weights = np.array([math.prod((place - b) / (a - b) for b in near if b != a) for a in near])
        inner, outer = values[1:-1], values[[0, -1]]
        low = values.min(axis=0) - 0.125 * np.maximum(outer.min(axis=0) - inner.min(axis=0), 0.0)
        high = values.max(axis=0) + 0.125 * np.maximum(inner.max(axis=0) - outer.max(axis=0), 0.0)
        field = np.clip(weights @ values, low, high)
    return float(field)


def _reached(source: Array, size: float, target: Array) -> Mask:
    """Mask of the points `target` that lie in an element of `size` about one of `source`, within rounding."""
    reach = 0.501 * size
    return np.asarray((target > source[0] - reach) & (target < source[-1] + reach))


class Prolongation:
    """Bilinear interpolation of element-centre values from one grid to another."""

    def __init__(self, source: Grid, target: Grid) -> None:
        self._x = interpolation_matrix(source.x, target.x)
        self._y = interpolation_matrix(source.y, target.y).T.copy()
        self._inside = np.outer(_reached(source.x, source.dx, target.x), _reached(source.y, source.dy, target.y))

    def __call__(self, field: Array) -> Array:
        """(..., nx, ny) on the source -> (..., nx, ny) on the target."""
        result: Array = self._x @ field @ self._y
        return result

    def from_inside(self, field: Array) -> Array:
        """The same, but zero beyond the elements of the source: for fields that vanish outside the contact."""
        return np.asarray(np.where(self._inside, self(field), 0.0))

    def traction(self, traction: Array, bound: Array, target_bound: Array) -> Array:
        """Carry (2, nx, ny) tractions as shares of the Coulomb bound: slip stays on the bound, and the square root at the
        border is not smeared."""
        fine = self(bound)
        share = self(traction) / np.where(fine > 0.0, fine, 1.0)
        return np.asarray(share * target_bound)


DIFFERENCE_OFFSETS = (-2, -1, 0, 1)
"""Rows of u, from the one where ∂u/∂x is wanted, that the weights of a difference formula belong to."""
UPSTREAM_WEIGHTS = (0.7 / 6 + 0.3 / 2, -0.7 - 0.3 * 2, 0.7 / 2 + 0.3 * 3 / 2, 0.7 / 3)
"""∂u/∂x over u at rows −2 … 1, times dx: 0.7 of the third-order and 0.3 of the second-order upstream formula. Their errors in
the dissipated heat have opposite signs, and both damp odd–even modes: Re D̂ = 0.7·(1−cos θ)²/3 + 0.3·(1−cos θ)² ≥ 0, so D A is
monotone (docs/numerics.md)."""


def framed(field: AnyArray, width: int = 1) -> AnyArray:
    """`field` (nx, ny) with `width` more elements of zeros on all sides; np.pad takes several times as long."""
    nx, ny = field.shape
    padded = np.zeros((nx + 2 * width, ny + 2 * width), dtype=field.dtype)
    padded[width : width + nx, width : width + ny] = field
    return padded


def neighbour_max(field: AnyArray) -> AnyArray:
    """Highest value around each element; `field` ≥ 0, or a mask (nx, ny)."""
    padded = framed(field)
    rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])


def neighbour_sum(field: AnyArray) -> AnyArray:
    """Sum of `field` (nx, ny) over each element and its eight neighbours."""
    padded = framed(field)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])


def sobel(padded: AnyArray, dx: float, dy: float) -> tuple[AnyArray, AnyArray]:
    """Sobel differences along x and y (eight times the slope), (nx, ny), of a field given with one more row and column on all
    sides, (nx+2, ny+2)."""
    rows = padded[:, :-2] + 2.0 * padded[:, 1:-1] + padded[:, 2:]
    columns = padded[:-2] + 2.0 * padded[1:-1] + padded[2:]
    return (rows[2:] - rows[:-2]) / dx, (columns[:, 2:] - columns[:, :-2]) / dy


MOST_PEAK_CURVATURE = 3.0
"""Largest ratio of the curvature of a peak to that of the field beside it. Temperature peaks behind narrow slip zones need more
than 1 (with 1 their errors are 20 % larger); at the edge of a plateau the ratio is unbounded."""
MOST_CUBIC_CURVATURE = 5.0
"""The same ratio for a cubic; its field beside the peak is the side that falls less."""

SMOOTH_BORDER_SHARE = 0.5
"""Share of an element's pressure that the next one carries at a smooth border, or more (0.55 where elements are whole)."""


SHARED = 1e-4
"""Relative difference from the largest value up to which elements share it."""
MOST_SHARING = 16
"""Largest number of such elements: more of them are a plateau, on which the first one is taken."""


def peak_value(field: Array, *, averages: bool = True) -> float:
    """Maximum of a smooth field of shape (nx, ny), given by its element averages (pressure) or, without `averages`, by its
    values at the elements' centres (temperature): what is reported and written over pictures.

    The top of the parabolas along x and y through the largest element, or that element's value at the edge of the field's
    support. Fields may have a corner there (a plateau that ends, a border of stick): the curvature of the parabola is at most
    `MOST_PEAK_CURVATURE` times that of the field beside the largest element, so a drop on one side alone adds nothing.
    Temperatures rise slowly through the contact and fall behind it: along x their top is that of a cubic, unless there is a
    corner.
    If several elements tie within `SHARED`, the highest interpolated peak is taken: rounding does not choose between them.
    """
    places = np.argwhere(field > (1.0 - SHARED) * field.max())
    if not 0 < len(places) <= MOST_SHARING:
        places = np.argwhere(field == field.max())[:1]
    tops = []
    for i, j in places.tolist():
        along = None if averages else _skew_rise(field[:, j], i)
        along = _rise(field[:, j], i, averages) if along is None else along
        tops.append(float(field[i, j]) + along + _rise(field[i, :], j, averages))
    return max(tops)


def _rise(line: Array, k: int, averages: bool) -> float:
    """Height of the top of the parabola along one line of averages above element k, the largest."""
    if not 0 < k < len(line) - 1 or min(line[k - 1], line[k + 1]) <= 0.0:
        return 0.0
    near = [float(value) for value in line[max(k - 2, 0) : k + 3]]
    beside = max((c - b) - (b - a) for a, b, c in zip(near, near[1:], near[2:], strict=False))
    if beside >= 0.0:
        return 0.0
    bend = max(float(line[k - 1] - 2.0 * line[k] + line[k + 1]), MOST_PEAK_CURVATURE * beside)
    # The slope in the middle, from the side that falls less: the other may lie behind a corner.
    slope = max(-0.5 * bend - float(line[k] - max(line[k - 1], line[k + 1])), 0.0)
    # Top of the parabola, and back from averages to values: f = mean − h² f''/24.
    return -0.5 * slope**2 / bend - (bend / 24.0 if averages else 0.0)


def _skew_rise(line: Array, k: int) -> float | None:
    """Height above the largest value k of the top of the cubic through it, its neighbours and the second neighbour on the side
    that falls less; None if that is not a smooth top. For Carter's contact on fast material the top of slip zones of 5 to 20
    elements has errors of 4e-3 to 2e-4 wherever it lies, a third to a fifth of a parabola's."""
    if not 1 < k < len(line) - 2 or min(line[k - 1], line[k + 1]) <= 0.0:
        return None
    two, one, top, other, beyond = line[k - 2 : k + 3] if line[k - 2] >= line[k + 2] else line[k - 2 : k + 3][::-1]
    bend, beside = one - 2.0 * top + other, two - 2.0 * one + top
    if beside >= 0.0 or bend < MOST_CUBIC_CURVATURE * beside or beyond >= other:
        return None
    b = 0.5 * bend
    c = (0.5 * (top + 4.0 * b - two) - 0.5 * (other - one)) / 3.0
    a = 0.5 * (other - one) - c
    root = b * b - 3.0 * a * c
    if root < 0.0 or math.sqrt(root) <= b:
        return None
    t = a / (math.sqrt(root) - b)
    return max(float(t * (a + t * (b + t * c))), 0.0) if -1.0 <= t <= 1.0 else None


def patches_across(covered: AnyArray) -> list[NDArray[np.intp]]:
    """Columns of each patch of a contact: patches are separated by columns of elements without contact."""
    loaded = np.flatnonzero((covered > 0.0).any(axis=0))
    return np.split(loaded, np.flatnonzero(np.diff(loaded) > 1) + 1)


def peak_inside(field: Array, covered: Array) -> float:
    """`peak_value` of a `field` (nx, ny) that is largest inside the contact, of which elements cover the fractions `covered`;
    the value of the largest element if that touches the border, where no top is smooth."""
    i, j = np.unravel_index(int(np.argmax(field)), field.shape)
    return peak_value(field) if framed(covered)[i : i + 3, j : j + 3].all() else float(field[i, j])


def between_sides(field: Array, pressure: Array, ends: tuple[bool, bool]) -> Array:
    """`field` (nx, ny) without the elements at a steep lateral border of the contact: those with a neighbour to one side that
    carries less than `SMOOTH_BORDER_SHARE` of their `pressure` and a neighbour to the other side that carries more, and the
    next ones inwards where the pressure rises towards such a border. Elements at the leading and the trailing edge stay: a slip
    zone may be one element wide. `ends` says that the first and the last column lie at the end of a profile, which is no border
    of this kind. A patch of which no element is left is kept whole."""
    beside = np.pad(pressure, ((0, 0), (1, 1)), mode="edge")
    beside[:, 0] *= ends[0]
    beside[:, -1] *= ends[1]
    low, high = (beside[:, side : side + pressure.shape[1]] < SMOOTH_BORDER_SHARE * pressure for side in (0, 2))
    steep = low ^ high
    # At the end of a profile the pressure is highest in the last element.
    steep[:, 0] &= not ends[0]
    steep[:, -1] &= not ends[1]
    rising = np.diff(pressure, axis=1) > 0.0  # from each element to the next one
    towards = np.zeros_like(steep)
    towards[:, 1:-1] = ((steep & high)[:, 2:] & rising[:, :-1]) | ((steep & low)[:, :-2] & ~rising[:, 1:])
    # A ridge of one element falls to both sides.
    kept = np.where(steep | (towards & ~(low & high)), 0.0, field)
    for columns in patches_across(pressure):
        if not kept[:, columns].any():
            kept[:, columns] = field[:, columns]
    return np.asarray(kept)

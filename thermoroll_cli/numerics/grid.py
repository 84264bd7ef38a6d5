"""The uniform grid of rectangular elements that all fields live on, and interpolation from one grid to another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array


class Domain(NamedTuple):
    """A rectangle of `side_x` × `side_y` (m) about x = `centre_x`, y = `centre`."""

    side_x: float
    side_y: float
    centre: float = 0.0
    centre_x: float = 0.0


@dataclass(frozen=True)
class Grid:
    """`nx` × `ny` rectangular elements of `dx` × `dy` (m), centred on x = `centre_x`, y = `centre`; arrays are indexed
    [ix, iy]."""

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
    def element_area(self) -> float:
        return self.dx * self.dy

    @cached_property
    def x(self) -> NDArray[np.float64]:
        """Element centres along x, shape (nx,)."""
        return self.rows_with(0)

    @cached_property
    def y(self) -> NDArray[np.float64]:
        """Element centres along y, shape (ny,)."""
        return np.asarray((np.arange(self.ny) - 0.5 * (self.ny - 1)) * self.dy + self.centre, dtype=np.float64)

    def rows_with(self, margin: int) -> NDArray[np.float64]:
        """Element centres along x with `margin` more at either end, shape (nx + 2 margin,)."""
        index = np.arange(-margin, self.nx + margin)
        return np.asarray((index - 0.5 * (self.nx - 1)) * self.dx + self.centre_x, dtype=np.float64)


def interpolation_matrix(source: Array, target: Array) -> Array:
    """Linear interpolation from uniformly spaced points `source` to `target`, constant beyond the ends: (nt, ns)."""
    n = len(source)
    if n == 1:
        return np.ones((len(target), 1))
    position = np.clip((target - source[0]) / (source[1] - source[0]), 0.0, n - 1.0)
    left = np.minimum(position.astype(int), n - 2)
    weight = position - left
    rows = np.arange(len(target))
    matrix = np.zeros((len(target), n))
    matrix[rows, left] = 1.0 - weight
    matrix[rows, left + 1] += weight
    return matrix


def _reached(source: Array, size: float, target: Array) -> NDArray[np.bool_]:
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

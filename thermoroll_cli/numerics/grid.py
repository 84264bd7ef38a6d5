"""The uniform grid of rectangular elements on which everything lives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


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
    def over(
        cls, shape: tuple[int, int], side_x: float, side_y: float, centre: float = 0.0, centre_x: float = 0.0
    ) -> Grid:
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
        """Element centres along x with so many more at either end, shape (nx + 2 margin,)."""
        index = np.arange(-margin, self.nx + margin)
        return np.asarray((index - 0.5 * (self.nx - 1)) * self.dx + self.centre_x, dtype=np.float64)

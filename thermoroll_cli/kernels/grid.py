"""The uniform grid of rectangular elements on which everything lives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Grid:
    """`nx` × `ny` rectangular elements of `dx` × `dy` (m), centred on x = 0, y = `centre`; arrays are indexed [ix, iy]."""

    nx: int
    ny: int
    dx: float
    dy: float
    centre: float = 0.0

    @classmethod
    def over(cls, shape: tuple[int, int], side_x: float, side_y: float, centre: float = 0.0) -> Grid:
        """Grid with `shape` elements over a domain of side_x × side_y (m) about y = `centre`."""
        nx, ny = shape
        return cls(nx, ny, side_x / nx, side_y / ny, centre)

    @property
    def shape(self) -> tuple[int, int]:
        return self.nx, self.ny

    @property
    def element_area(self) -> float:
        return self.dx * self.dy

    @cached_property
    def x(self) -> NDArray[np.float64]:
        """Element centres along x, shape (nx,)."""
        return np.asarray((np.arange(self.nx) - 0.5 * (self.nx - 1)) * self.dx, dtype=np.float64)

    @cached_property
    def y(self) -> NDArray[np.float64]:
        """Element centres along y, shape (ny,)."""
        return np.asarray((np.arange(self.ny) - 0.5 * (self.ny - 1)) * self.dy + self.centre, dtype=np.float64)

"""The part of a grid on which the tangential problem is solved: the contact's bounding box, or the half of it above y = 0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Mask
from thermoroll_cli.numerics.convolution import Parities, unfolded


@dataclass(frozen=True)
class Window:
    """Rows and columns of a grid of `grid` elements; with `mirror` (the parities of vector components across y = 0) the
    columns begin at y > 0 and stand for both sides."""

    grid: tuple[int, int]
    rows: slice
    columns: slice
    mirror: Parities | None

    @property
    def shape(self) -> tuple[int, int]:
        return self.rows.stop - self.rows.start, self.columns.stop - self.columns.start

    @property
    def weight(self) -> int:
        """Number of elements of the grid that each element of the window represents."""
        return 1 if self.mirror is None else 2

    def cut(self, field: NDArray[Any]) -> NDArray[Any]:
        """The part of a field (..., nx, ny) in the window."""
        return field[..., self.rows, self.columns]

    def scalar(self, field: NDArray[Any]) -> NDArray[Any]:
        """A scalar (n, m) of the window, even across y = 0, on the whole grid; zero outside."""
        full = np.zeros(self.grid, dtype=field.dtype)
        full[self.rows, self.both_sides.columns] = field if self.mirror is None else unfolded(field, 1)
        return full

    def vector(self, field: NDArray[Any]) -> NDArray[Any]:
        """A vector (2, n, m) of the window on the whole grid; zero outside."""
        full = np.zeros((2, *self.grid), dtype=field.dtype)
        both = self.both_sides.columns
        for i in (0, 1):
            full[i, self.rows, both] = field[i] if self.mirror is None else unfolded(field[i], self.mirror[i])
        return full

    @property
    def both_sides(self) -> Window:
        """The same without the mirror."""
        if self.mirror is None:
            return self
        return Window(self.grid, self.rows, slice(self.grid[1] - self.columns.stop, self.columns.stop), None)

    def holds(self, other: Window) -> bool:
        """True if `other` lies within this window and has the same symmetry."""
        return (self.mirror == other.mirror
                and self.rows.start <= other.rows.start and other.rows.stop <= self.rows.stop
                and self.columns.start <= other.columns.start and other.columns.stop <= self.columns.stop)

    def grown(self, other: Window) -> Window:
        """The smallest window that holds both."""
        def union(a: slice, b: slice) -> slice:
            return slice(min(a.start, b.start), max(a.stop, b.stop))

        return Window(self.grid, union(self.rows, other.rows), union(self.columns, other.columns), self.mirror)


def window_around(contact: Mask, mirror: Parities | None) -> Window:
    """The smallest window that holds `contact` (nx, ny); `mirror` needs an even ny."""
    rows, columns = np.flatnonzero(contact.any(axis=1)), np.flatnonzero(contact.any(axis=0))
    grid = (contact.shape[0], contact.shape[1])
    low, high = int(columns[0]), int(columns[-1]) + 1
    if mirror is not None:
        low, high = grid[1] // 2, max(high, grid[1] - low)
    return Window(grid, slice(int(rows[0]), int(rows[-1]) + 1), slice(low, high), mirror)

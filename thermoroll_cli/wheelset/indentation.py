"""Load of a patch where its wheel stands, on a coarse grid: enough to place a wheel and to share its load among patches."""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.contact.active_set import Approach
from thermoroll_cli.contact.normal_contact import NormalSolver
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.wheelset.patch_surface import PatchSurface
from thermoroll_cli.wheelset.placement import Position

COARSE_GRID = (32, 64)
"""Elements along and across on the overlap."""
BOX_SAMPLES = (17, 33)
"""Places along and across at which the overlap is looked for."""


class Indentation:
    """Normal contact of a patch on its overlap, for a wheel that stands where the patch was found, or near by: a wheel that has
    moved by (dy, dz) is closer by dz cos α − dy sin α, α being the inclination of the surface. `pressure` (Pa, (nx, ny)) of a
    similar patch is the first guess."""

    def __init__(self, patch: PatchSurface, contact_modulus: float, pressure: Array | None = None) -> None:
        self.patch = patch
        x0, x1, s0, s1 = _box(patch)
        grid = Grid.over(COARSE_GRID, x1 - x0, s1 - s0, 0.5 * (s0 + s1), 0.5 * (x0 + x1))
        gap = patch.gap(grid.x, grid.y)
        self._gap = np.where(np.isfinite(gap), gap, 1.0)
        self._angle, self._deepest = patch.inclination(grid.y), patch.inclination(np.array([patch.overlap[1]]))
        self._solver = NormalSolver(grid, contact_modulus)
        self._pressure = np.sqrt(np.maximum(-self._gap, 0.0)) if pressure is None else pressure

    @property
    def pressure(self) -> Array:
        """The last one that was found in Pa."""
        return self._pressure

    def moved(self, position: Position) -> tuple[float, float]:
        """(dy, dz) in m by which the wheel's material at the patch has moved if the wheelset is at `position`."""
        before, radius, there = self.patch.facing.position, self.patch.facing.wheel.radius, self.patch.place
        turned = position.rotation @ (before.rotation.T @ (there - before.origin(radius))) + position.origin(radius) - there
        return float(turned[1]), float(turned[2])

    def overlap(self, moved: tuple[float, float] = (0.0, 0.0)) -> float:
        """Largest overlap in m after the wheel has `moved`."""
        return self.patch.overlap[0] + float(_closer(self._deepest, moved)[0])

    def load(self, moved: tuple[float, float], sunk: float, over_coarse: float, within: float) -> float:
        """Load (N) of the patch whose wheel has `moved`, at an approach of `sunk` (m) from first touch, which is `over_coarse`
        times that of this grid; 0 where nothing remains. `within` is the residual gap over the elastic displacement."""
        if sunk <= 0.0:
            return 0.0
        gap = self._gap - _closer(self._angle, moved)
        solution = self._solver.solve(gap, Approach(sunk / over_coarse - self.overlap(moved)), self._pressure, within)
        if solution.contact.any():
            self._pressure = solution.pressure
        return self._solver.load(solution.pressure)


def _closer(angle: Array, moved: tuple[float, float]) -> Array:
    """By how much a wheel that has `moved` (m) is closer along normals of inclination `angle` (rad)."""
    return np.asarray(moved[1] * np.cos(angle) - moved[0] * np.sin(angle))


def _box(patch: PatchSurface) -> tuple[float, float, float, float]:
    """Lowest and highest x, lowest and highest s of the overlap in m. An elastic contact lies within it."""
    low, high = patch.overlapping
    depth, _ = patch.overlap
    lean = patch.locus_x(np.array([low, high]))
    half = 1.05 * math.sqrt(2.0 * patch.facing.wheel.radius * depth) * 1.2
    x = np.linspace(lean.min() - half, lean.max() + half, BOX_SAMPLES[0])
    s = np.linspace(low, high, BOX_SAMPLES[1])
    gap = patch.gap(x, s)
    # An overlap may lie between the places.
    inside = gap < 0.0 if (gap < 0.0).any() else gap == np.nanmin(gap)
    rows, columns = (np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0))
    step_x, step_s = x[1] - x[0], s[1] - s[0]
    return (float(x[rows[0]] - step_x), float(x[rows[-1]] + step_x),
            float(s[columns[0]] - step_s), float(s[columns[-1]] + step_s))

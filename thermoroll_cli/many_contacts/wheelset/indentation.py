"""Load of a patch where its wheel stands, on a coarse grid: enough to place a wheel and to share its load among patches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from thermoroll_cli.many_contacts.wheelset.patch_surface import PatchSurface
from thermoroll_cli.many_contacts.wheelset.placement import Position
from thermoroll_cli.physics.contact.active_set import Approach
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.surface import edges
from thermoroll_cli.tools.arrays import Array

COARSE_GRID = (24, 48)
"""Elements along and across on the overlap."""


class Indentation:
    """Normal contact of a patch on its overlap, for a wheel that stands where the patch was found, or near by: a wheel that has
    moved by (dy, dz) is closer by dz cos α − dy sin α, α being the inclination of the surface. `pressure` (Pa, (nx, ny)) is the
    last one that was found, at first that of a similar patch."""

    def __init__(self, patch: PatchSurface, contact_modulus: float, pressure: Array | None = None) -> None:
        self.patch = patch
        grid = _grid(patch)
        self._gap = _gap(patch, grid)
        self._angle, self._deepest = patch.inclination(grid.y), patch.inclination(np.array([patch.overlap[1]]))
        self._solver = NormalSolver(grid, Bodies(contact_modulus))
        self.pressure = np.sqrt(np.maximum(-self._gap, 0.0)) if pressure is None else pressure

    def moved(self, position: Position) -> tuple[float, float]:
        """(dy, dz) in m by which the wheel's material at the patch has moved if the wheelset is at `position`."""
        before, radius, there = self.patch.position, self.patch.facing.wheel.radius, self.patch.place
        position = replace(position, ahead=before.ahead, roller=before.roller, tilt=before.tilt, lift=before.lift)
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
        solution = self._solver.solve(gap, Approach(sunk / over_coarse - self.overlap(moved)), self.pressure, within)
        if solution.contact.any():
            self.pressure = solution.pressure
        return self._solver.load(solution.pressure)


def _closer(angle: Array, moved: tuple[float, float]) -> Array:
    """By how much a wheel that has `moved` (m) is closer along normals of inclination `angle` (rad)."""
    return np.asarray(moved[1] * np.cos(angle) - moved[0] * np.sin(angle))


def _grid(patch: PatchSurface) -> Grid:
    """A grid over the overlap and an element around it: an elastic contact lies within the overlap."""
    s, lowest, x_lowest, fitted = patch.table
    # An overlap may lie between the places.
    depth = np.where(lowest == lowest.min(), patch.overlap[0], -lowest)
    inside, step = depth > 0.0, s[1] - s[0]
    # The gap opens along as at an inclination of 75° at least: at the end of a profile its fit may not.
    half = np.sqrt(depth[inside] / np.maximum(fitted[0, inside], 0.125 / patch.facing.wheel.radius))
    rear, front = (x_lowest[inside] - half).min(), (x_lowest[inside] + half).max()
    low, high = s[inside][0] - step, s[inside][-1] + step
    nx, ny = COARSE_GRID
    return Grid.over(COARSE_GRID, nx / (nx - 2) * (front - rear), ny / (ny - 2) * (high - low), 0.5 * (low + high),
                     0.5 * (rear + front))


def _gap(patch: PatchSurface, grid: Grid) -> Array:
    """The gap of the surfaces in m, (nx, ny), as the solver of the patch has it; 1 m where there is no material."""
    s, lowest, x_lowest, fitted = patch.table
    lowest, x_lowest, *powers = scipy.interpolate.CubicSpline(s, np.array([lowest, x_lowest, *fitted]).T)(grid.y).T
    away = grid.x[:, None] - x_lowest
    gap = lowest + sum(power * away**n for n, power in enumerate(powers, 2))
    if patch.heights is not None:
        # Against the track: y = −s.
        gap = gap - patch.heights.over(edges(-grid.x[::-1], grid.dx), edges(-grid.y[::-1], grid.dy))[::-1, ::-1]
    return np.where((grid.y >= s[0]) & (grid.y <= s[-1]), gap, 1.0)

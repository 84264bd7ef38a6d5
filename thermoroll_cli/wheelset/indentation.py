"""Load of a patch from the depth of its overlap, on a coarse grid: enough to place a wheel and to share its load among
patches."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.contact.normal_contact import NormalSolver
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.wheelset.patch_surface import PatchSurface

COARSE_GRID = (32, 64)
"""Elements along and across on the overlap."""
BOX_SAMPLES = (65, 129)
"""Places along and across at which the overlap is looked for."""
TOLERANCE = 1e-4
"""Relative tolerance of the approach: ten times less than the error of the coarse grid."""
MOST_LOADS = 12


@dataclass(frozen=True)
class Indentation:
    """Normal contact of a patch on its overlap."""

    patch: PatchSurface
    contact_modulus: float

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Lowest and highest x, lowest and highest s of the overlap in m. An elastic contact lies within it."""
        low, high = self.patch.overlapping
        depth, _ = self.patch.overlap
        lean = self.patch.locus_x(np.array([low, high]))
        half = 1.05 * math.sqrt(2.0 * self.patch.facing.wheel.radius * depth) * 1.2
        x = np.linspace(lean.min() - half, lean.max() + half, BOX_SAMPLES[0])
        s = np.linspace(low, high, BOX_SAMPLES[1])
        rows, columns = (np.flatnonzero((self.patch.gap(x, s) < 0.0).any(axis=axis)) for axis in (1, 0))
        step_x, step_s = x[1] - x[0], s[1] - s[0]
        return (float(x[rows[0]] - step_x), float(x[rows[-1]] + step_x),
                float(s[columns[0]] - step_s), float(s[columns[-1]] + step_s))

    @cached_property
    def _grid(self) -> Grid:
        x0, x1, s0, s1 = self.box
        return Grid.over(COARSE_GRID, x1 - x0, s1 - s0, 0.5 * (s0 + s1), 0.5 * (x0 + x1))

    @cached_property
    def _gap(self) -> Array:
        gap = self.patch.gap(self._grid.x, self._grid.y)
        return np.where(np.isfinite(gap), gap, 1.0)

    @cached_property
    def _solver(self) -> NormalSolver:
        return NormalSolver(self._grid, self.contact_modulus)

    def load(self, less: float = 0.0, over_coarse: float = 1.0) -> float:
        """Load (N) at the overlap of the patch `less` a displacement by other loads (m), given that the approach is
        `over_coarse` times that of this grid; 0 where nothing remains."""
        depth = (self.patch.overlap[0] - less) / over_coarse
        if depth <= 0.0:
            return 0.0
        # Half of the overlap as a mean displacement of the patch of contact, in the manner of Kik and Piotrowski.
        sunk = np.maximum(-less - self._gap, 0.0)
        area = float(np.count_nonzero(sunk)) * self._grid.element_area
        load = 0.5 * self.contact_modulus * math.sqrt(area) * depth * 0.6
        pressure = np.sqrt(sunk)
        exponent = 1.5
        seen: tuple[float, float] | None = None
        for _ in range(MOST_LOADS):
            solution = self._solver.solve(self._gap, load, pressure, 0.1 * TOLERANCE)
            pressure = solution.pressure
            approach = solution.approach + self.patch.overlap[0]
            if abs(approach - depth) < TOLERANCE * depth:
                break
            if seen is not None and approach != seen[1]:
                exponent = min(max(math.log(load / seen[0]) / math.log(approach / seen[1]), 0.8), 3.0)
            seen = load, approach
            load *= (depth / approach) ** exponent
        return load * (depth / approach) ** exponent

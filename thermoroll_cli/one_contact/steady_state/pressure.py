"""The normal problem on one grid: the isothermal pressure, and the pressure with thermal expansion and shear."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from thermoroll_cli.exact.hertz import HertzContact, element_averages
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.contact.active_set import Approach
from thermoroll_cli.physics.contact.contact_scales import approach_weight
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.numerics.grid import Grid, Prolongation, peak_inside, peak_value
from thermoroll_cli.problem.contact import Pressure
from thermoroll_cli.tools.arrays import Array, Mask

BORDER_PRESSURES, LOW_PRESSURE = 3.0, 0.02
"""Pressure in the outermost elements, over the isothermal one there and over the peak, above which the domain cuts the contact
off. The first ratio is 0.5 to 1.5 for a contact that only bulges (by a quarter of the approach, on 8² to 20² elements), and 4
to 500 for one that has moved half out of its domain."""

FAR, FAR_APPROACHES = 1.0, 1e3
"""Gap, in m and in approaches, over which no bodies touch, in place of an infinite one: the domain of a patch that wanders
reaches beyond the ends that its surfaces have at one of its places."""


class PressureSolver:
    """Presses bodies of one gap together under one load or to one approach, on a `grid` that spans `extent` half-lengths of the
    contact (None: one that follows a heated contact, which may lie anywhere).

    If there is no closed form, the isothermal pressure starts from the predicted one, `start` (Pa, (nx, ny)), or else from that
    of `coarser`, the solver of the next coarser grid."""

    def __init__(
        self, derived: DerivedQuantities, grid: Grid, extent: float | None, tolerance: float, *, whole_elements: bool,
        coarser: PressureSolver | None = None, start: Array | None = None,
    ) -> None:
        self.grid = grid
        self._derived, self._extent, self._tolerance, self._whole_elements = derived, extent, tolerance, whole_elements
        self._coarser, self._start = coarser, start

    @cached_property
    def far(self) -> float:
        """Gap (m) beyond the ends of a surface."""
        return max(FAR, FAR_APPROACHES * self._derived.scales.approach)

    @cached_property
    def undeformed_gap(self) -> Array:
        """h_i in m, (nx, ny); `far` beyond the ends of a surface."""
        return np.minimum(self._derived.problem.geometry.gap(self.grid.x, self.grid.y), self.far)

    @cached_property
    def cosine(self) -> Array:
        """cos α across the contact, (ny,) (`approach_weight`)."""
        return approach_weight(self._derived.problem.geometry, self.grid.y)

    @cached_property
    def solver(self) -> NormalSolver:
        return NormalSolver(self.grid, self._derived.bodies, self.cosine)

    @cached_property
    def isothermal(self) -> Pressure:
        """Pressure on bodies that only their load deforms; for homogeneous bodies with radii Hertz's closed form."""
        if self._derived.hertz is not None:
            return self._of_hertz(self._derived.hertz)
        if self._start is not None:
            start = self._start
        elif self._coarser is None:
            start = np.zeros(self.grid.shape)
            if self.solver.below_stiff_layers and self._derived.problem.geometry.elliptic:
                scales, grid = self._derived.scales, self.grid
                start = np.maximum(1.0 - (grid.x[:, None] / scales.semi_axis_x) ** 2 - (grid.y / scales.semi_axis_y) ** 2, 0.0)
        else:
            finer, coarse = Prolongation(self._coarser.grid, self.grid), self._coarser.isothermal
            start = np.asarray(finer(coarse.start))
            if self._derived.bodies.dispersive:
                # Below stiff layers a contact that is too wide shrinks by a ring of elements per active set.
                start = start * (np.asarray(finer(coarse.covered)) > 0.5)
        return self.solve(None, start, self._tolerance,
                          mirrored=self._derived.kinematics.mirror_on(self.grid.ny, heated=True) is not None)

    def _of_hertz(self, hertz: HertzContact) -> Pressure:
        grid = self.grid
        if self._extent is not None:
            # Hertz's pressure is even in x and y: one quadrant is averaged, the others are its mirror images.
            x_edges, y_edges = (np.arange(n // 2, n + 1, dtype=np.float64) - 0.5 * n for n in grid.shape)
            quadrants = element_averages(hertz, x_edges * grid.dx, y_edges * grid.dy)
            # The middle elements belong to it where their number is odd.
            halves = (np.concatenate([part[grid.nx % 2 :][::-1], part]) for part in quadrants)
            pressure, covered = (np.concatenate([half[:, grid.ny % 2 :][:, ::-1], half], axis=1) for half in halves)
        else:
            pressure, covered = element_averages(hertz, *(
                centre[0] + (np.arange(n + 1) - 0.5) * size
                for centre, n, size in ((grid.x, grid.nx, grid.dx), (grid.y, grid.ny, grid.dy))))
        if self._whole_elements:
            pressure = hertz.pressure(grid.x[:, None], grid.y[None, :])
            pressure *= self._derived.problem.normal_force / (float(pressure.sum()) * grid.element_area)
            covered = (pressure > 0.0).astype(float)
        if self._derived.problem.line:
            # Displacements are known up to a constant: here they are zero in the middle.
            left, approach = hertz.gap(grid.x[:, None], grid.y), 0.0
            displacement = left - self.undeformed_gap
        else:
            displacement, approach = self.solver.displacement(pressure), hertz.approach
            left = self.undeformed_gap + displacement - approach
        gap = np.where(covered > 0.0, 0.0, np.maximum(left, 0.0))
        return Pressure(pressure, covered, displacement, gap, approach=approach, peak=hertz.peak_pressure)

    def solve(self, offset: Array | None, start: Array, tolerance: float, *, mirrored: bool) -> Pressure:
        """Contact pressure on bodies whose gap is closed by `offset` (m, (nx, ny)) beforehand: thermal expansion, normal
        displacement by shear (None: nothing). `start` (Pa) is where the solver begins; with `mirrored` all is even in y."""
        cosine, given = self.cosine, self._derived.given
        gap = (self.undeformed_gap - (0.0 if offset is None else offset)) / cosine
        # A contact that has wandered here may have left this gap's surfaces behind.
        start = np.where(self.undeformed_gap < self.far, start, 0.0)
        solution = self.solver.solve(gap, given, start * cosine, tolerance)
        if not solution.contact.any():
            # Heat on its way to a steady state may part the bodies at a given approach: they carry the load of the start.
            load = self.solver.load(start * cosine)
            solution = replace(self.solver.solve(gap, load, start * cosine, tolerance), converged=False)
        # Load and approach belong to each other on whole elements: their errors on both sides of the border cancel. That is
        # four times closer.
        force = self.solver.load(solution.pressure) if isinstance(given, Approach) else given
        refined = self.solver.refine(solution, gap, force, tolerance, mirrored=mirrored)
        pressure, covered, displacement, gap = (refined.pressure / cosine, refined.covered, refined.displacement * cosine,
                                                refined.gap * cosine)
        if mirrored:
            # They are even but for rounding, which could otherwise add a border element on one side only.
            pressure, covered, displacement, gap = (0.5 * (f + f[:, ::-1]) for f in (pressure, covered, displacement, gap))
        elliptic = self._derived.problem.geometry.elliptic
        peak = peak_value(pressure) if elliptic else peak_inside(pressure, covered)
        return Pressure(
            pressure, covered, displacement, gap, approach=solution.approach, peak=peak, offset=offset,
            whole_elements=solution.pressure / cosine, iterations=solution.iterations, converged=solution.converged,
            touches_rim=self._touches_rim(pressure))

    def load(self, normal: Pressure) -> float:
        """Normal force that a pressure carries in N."""
        return float((normal.pressure * self.cosine).sum()) * self.grid.element_area

    def without_approach(self, field: Array, covered: Array | Mask) -> tuple[Array, float]:
        """`field` (m) less its mean over the `covered` parts of elements, as an approach would take it out, and that
        approach; 0 where heat has parted the bodies."""
        area = float((self.cosine * covered).sum())
        approach = float((field * covered).sum()) / area if area > 0.0 else 0.0
        return field - approach * self.cosine, approach

    @property
    def at_ends(self) -> tuple[bool, bool]:
        """True if the domain ends where a profile ends, at its lowest and at its highest y: the contact cannot extend there."""
        grid, (lowest, highest) = self.grid, self._derived.scales.limits
        reach = 0.501 * grid.dy
        return bool(grid.y[0] - reach < lowest), bool(grid.y[-1] + reach > highest)

    def _touches_rim(self, pressure: Array) -> bool:
        """True if `pressure` in the outermost elements shows that the domain is too small. On coarse grids they also contain
        the border of the isothermal contact, so either their centres must lie in the outer half of the margin around it, or the
        pressure must exceed that of any border."""
        contact, grid, scales, ends = pressure > 0.0, self.grid, self._derived.scales, self.at_ends
        line = self._derived.problem.line  # whose only line of rolling has no rim beside it
        touched = contact[0].any() or contact[-1].any() or (
            not line and ((contact[:, 0].any() and not ends[0]) or (contact[:, -1].any() and not ends[1])))
        if self._extent is None:
            return bool(touched)
        half_room = 0.5 * (1.0 + 0.5 * self._extent)
        if touched and self._derived.hertz is not None:
            before = _outermost(self.isothermal.pressure, line=line)
            if _outermost(pressure, line=line) > BORDER_PRESSURES * before + LOW_PRESSURE * scales.peak_pressure:
                return True
        return bool(touched and grid.x[-1] - scales.centre_x > half_room * scales.semi_axis_x
                    and (line or any(ends) or grid.y[-1] - scales.centre > half_room * scales.semi_axis_y))


def _outermost(pressure: Array, *, line: bool) -> float:
    """Largest pressure in the outermost elements, of a `line` contact at both ends."""
    sides = pressure[0], pressure[-1], *(() if line else (pressure[:, 0], pressure[:, -1]))
    return float(max(side.max() for side in sides))

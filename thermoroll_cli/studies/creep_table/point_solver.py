"""Forces at the points of a table: many creepages of one ellipse, with the kernels of the first."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.special import elliprd

from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.physics.numerics.grid import interpolation_matrix
from thermoroll_cli.physics.rolling.element_borders import stick_share
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_solver import TangentialSolution
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.studies.creep_table.scaling import scales
from thermoroll_cli.tools.arrays import Array

QUANTITIES = ("force_x", "force_y", "spin_moment", "stick_fraction")
"""F_x/μW, F_y/μW, M_z/(μW sqrt(ab)), γ_st."""
FORCES = slice(0, 3)

STANDARD_ELEMENTS = 32
"""Elements per side, in the geometric mean, for an accuracy of `STANDARD_ACCURACY`; errors fall with its square."""
STANDARD_ACCURACY = 1e-3
TOLERANCE = 3e-5
"""Tolerance of the residual: forces are then 5e-6 μW from those of a perfect solution, 3e-5 at most."""
LOAD, FRICTION, RADIUS, MODULUS = 100.0, 0.3, 0.05, 1e11
"""A contact to solve for; the scaling laws make all others of it."""


def grid_for(aspect_ratio: float, accuracy: float) -> tuple[int, int]:
    """Elements along x and y, multiples of four. Slender contacts want more along their long side, but not in proportion."""
    mean = min(max(STANDARD_ELEMENTS * math.sqrt(STANDARD_ACCURACY / accuracy), 16), 64)
    slenderness = min(max(aspect_ratio**0.27, 0.5), 2.0)
    nx, ny = (max(8, 4 * round(side / 4.0)) for side in (mean * slenderness, mean / slenderness))
    return nx, ny


class EllipseSolver:
    """Forces of one ellipse. Each point is solved on a grid and on one of half as many elements a side: the integrals converge
    at second order, so both together give better values and an estimate of their error."""

    def __init__(self, aspect_ratio: float, poisson_ratio: float, accuracy: float = STANDARD_ACCURACY) -> None:
        nx, ny = grid_for(aspect_ratio, accuracy)
        self.scales = scales(creepage_coefficients(aspect_ratio, poisson_ratio))
        self._grids = [_OneGrid(aspect_ratio, poisson_ratio, shape) for shape in ((nx // 2, ny // 2), (nx, ny))]

    @property
    def problem(self) -> Problem:
        """The contact that is solved for."""
        return self._grids[-1].derived.problem

    def solve(self, creepages: Array) -> tuple[Array, Array]:
        """`QUANTITIES` (4, n) for the scaled creepages ξ', η', φ' of (3, n), each solved from the one before it, and the
        estimated errors of the forces over μW, (n,); nan where a solution has not converged."""
        below, above = self._grids
        values, errors = np.full((len(QUANTITIES), creepages.shape[1]), np.nan), np.full(creepages.shape[1], np.nan)
        before: tuple[Array, Array, Array] | None = None
        for k, creepage in enumerate(creepages.T):
            coarse, first = below.solve(creepage, None if before is None else before[0])
            carried = above.continued(below, first.traction)
            # The fine grid begins with the last point, and what the coarse one has found of the change since.
            fine, second = above.solve(creepage, carried if before is None else before[1] + carried - before[2])
            before = (first.traction, second.traction, carried) if first.converged and second.converged else None
            if before is None:
                continue
            change = fine[FORCES] - coarse[FORCES]
            fine[FORCES] += change / 3.0
            # Never above the bound: |F| of the two grids is not, but what is made of them could be by their errors.
            fine[:2] /= max(math.hypot(fine[0], fine[1]), 1.0)
            values[:, k], errors[k] = fine, math.hypot(change[0], change[1]) / 3.0
        return values, errors


class _OneGrid:
    def __init__(self, aspect_ratio: float, poisson_ratio: float, shape: tuple[int, int]) -> None:
        g = aspect_ratio
        ratio = math.sqrt(elliprd(0.0, 1.0 / g, g) / elliprd(0.0, g, 1.0 / g))  # of the curvatures along x and y (Hertz)
        body, motion = Material(MODULUS, poisson_ratio), Motion(1.0, 1e-3, 0.0, 1.0, differential_slip=False)
        self.derived = derived = DerivedQuantities(Problem(
            body, body, Geometry(RADIUS / ratio, RADIUS * ratio, math.inf, math.inf), LOAD, Friction(FRICTION), motion,
            Heating(heat=False, deformation=False), Numerics(shape)))
        discretisation = Discretisation(derived, shape, derived.problem.numerics.extent)
        self._pressure = pressure = discretisation.isothermal_pressure
        self.grid = grid = discretisation.grid
        self.window = window = discretisation.traction.window_around(pressure.contact, None)
        self.bound, self._covered = FRICTION * window.cut(pressure.pressure), window.cut(pressure.covered)
        self._problem = TangentialProblem(
            traction_bound=self.bound, covered=self._covered, rigid_slip=np.zeros((2, *window.shape)),
            element_area=grid.element_area,
            leading=discretisation.traction.leading(derived, pressure, window, undisturbed=True))
        self._solver = discretisation.traction.solver_of(window)
        x, y = grid.x[window.rows][:, None], grid.y[window.columns][None, :]
        self._x, self._y = np.broadcast_arrays(x, y)
        one, zero = np.ones(window.shape), np.zeros(window.shape)
        unit = derived.problem.traction_limit / (derived.problem.lower.shear_modulus * derived.scales.mean_radius**2)
        turn = unit / derived.scales.mean_radius
        self._unit_slips = np.array([[unit * one, zero], [zero, unit * one], [-turn * self._y, turn * self._x]])

    def continued(self, coarse: _OneGrid, tractions: Array) -> Array:
        """Tractions (2, n, m) of a coarser grid on this one, as shares of the bound: slip stays slip."""
        along = interpolation_matrix(coarse.grid.x[coarse.window.rows], self.grid.x[self.window.rows])
        across = interpolation_matrix(coarse.grid.y[coarse.window.columns], self.grid.y[self.window.columns]).T
        bound = along @ coarse.bound @ across
        return np.asarray(along @ tractions @ across * (self.bound / np.where(bound > 0.0, bound, 1.0)))

    def solve(self, creepage: Array, start: Array | None = None) -> tuple[Array, TangentialSolution]:
        """`QUANTITIES` (4,) and the solution for the scaled creepages (3,), from the tractions `start` or from full stick."""
        problem = replace(self._problem, rigid_slip=np.tensordot(creepage, self._unit_slips, axes=1))
        solution = self._solver.solve(problem, [] if start is None else [(start, (0.0, 0.0))], TOLERANCE)
        derived, grid, (tx, ty) = self.derived, self.grid, solution.traction
        share = grid.element_area / derived.problem.traction_limit
        moment = float((self._x * ty - self._y * tx).sum()) * share / derived.scales.mean_radius
        sticking = stick_share(solution.traction, solution.slip, self.bound, solution.stick, self._covered, grid.dx, grid.dy,
                               derived.bodies.shear)
        fraction = min(max(float(sticking.sum() / self._covered.sum()), 0.0), 1.0)
        return np.array([tx.sum() * share, ty.sum() * share, moment, fraction]), solution

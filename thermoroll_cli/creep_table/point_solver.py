"""Forces at the points of a table, all creepages of one ellipse at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.scaling import scales
from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.numerics.grid import interpolation_matrix
from thermoroll_cli.problem.problem import Geometry, Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.rolling.batch_solver import BatchSolver
from thermoroll_cli.rolling.element_borders import stick_share
from thermoroll_cli.rolling.newton import TangentialProblem
from thermoroll_cli.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.rolling.stick_inverse import StickInverse
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation

QUANTITIES = ("force_x", "force_y", "spin_moment", "stick_fraction")
"""F_x/μW, F_y/μW, M_z/(μW sqrt(ab)), γ_st."""
FORCES = slice(0, 3)

STANDARD_ELEMENTS = 32
"""Elements per side, in the geometric mean, for an accuracy of `STANDARD_ACCURACY`; errors fall with its square."""
STANDARD_ACCURACY = 1e-3
MOST_ELEMENTS, FEWEST_ELEMENTS = 64, 16
SHAPE_EXPONENT, MOST_STRETCHED = 0.27, 2.0
"""Slender contacts want more elements along their long side, but not in proportion to it."""
TOLERANCE = 3e-5
"""Tolerance of the residual: forces are then 5e-6 μW from those of a perfect solution, 3e-5 at most."""
BATCH = 160
"""Points solved together: enough for products of matrices to run at full speed, few enough for the memory."""
LOAD, FRICTION, RADIUS, MODULUS = 100.0, 0.3, 0.05, 1e11
"""A contact to solve for; the scaling laws make all others of it."""


def grid_for(aspect_ratio: float, accuracy: float) -> tuple[int, int]:
    """Elements along x and y, multiples of four."""
    mean = STANDARD_ELEMENTS * math.sqrt(STANDARD_ACCURACY / accuracy)
    mean = min(max(mean, FEWEST_ELEMENTS), MOST_ELEMENTS)
    stretch = min(max(aspect_ratio**SHAPE_EXPONENT, 1.0 / MOST_STRETCHED), MOST_STRETCHED)
    nx, ny = (max(8, 4 * round(side / 4.0)) for side in (mean * stretch, mean / stretch))
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

    @property
    def unit_creepages(self) -> tuple[float, float]:
        """The creepage with ξ' = 1 and the spin with φ' = 1 (rad/m) of `problem`."""
        return self._grids[-1].units

    def solve(self, creepages: Array) -> tuple[Array, Array]:
        """`QUANTITIES` (4, n) for the scaled creepages ξ', η', φ' of (3, n), and the estimated errors of the forces over μW,
        (n,); nan where a solution has not converged."""
        parts = [self._solve(creepages[:, i : i + BATCH]) for i in range(0, creepages.shape[1], BATCH)]
        return np.concatenate([values for values, _ in parts], axis=1), np.concatenate([errors for _, errors in parts])

    def _solve(self, creepages: Array) -> tuple[Array, Array]:
        below, above = self._grids
        coarse, first, tractions = below.solve(creepages)
        # A coarse solution starts most points better than full stick does, as it does in a single solve.
        fine, second, _ = above.solve(creepages, above.continued(below, tractions))
        failed = np.flatnonzero(~second)
        if failed.size:
            fine[:, failed], second[failed], _ = above.solve(creepages[:, failed])
        values = fine.copy()
        change = fine[FORCES] - coarse[FORCES]
        values[FORCES] += change / 3.0
        # Never above the bound: |F| of the two grids is not, but what is made of them could be by their errors.
        size = np.hypot(values[0], values[1])
        values[:2] /= np.maximum(size, 1.0)
        converged = first & second
        errors = np.hypot(*change[:2]) / 3.0
        return np.where(converged, values, np.nan), np.where(converged, errors, np.nan)


class _OneGrid:
    def __init__(self, aspect_ratio: float, poisson_ratio: float, shape: tuple[int, int]) -> None:
        self.derived = derived = DerivedQuantities(_problem(aspect_ratio, poisson_ratio, shape))
        discretisation = Discretisation(derived, shape, derived.problem.numerics.extent)
        self._pressure = pressure = discretisation.isothermal_pressure
        self.grid = grid = discretisation.grid
        self.window = window = discretisation.traction.window_around(pressure.contact, None, derived)
        gradient = RollingGradient(window.shape, grid.dx, grid.dy, derived.shear_compliance)
        self.bound, self._covered = FRICTION * window.cut(pressure.pressure), window.cut(pressure.covered)
        problem = TangentialProblem(
            traction_bound=self.bound, covered=self._covered, rigid_slip=np.zeros((2, *window.shape)),
            element_area=grid.element_area,
            leading=discretisation.traction.leading(derived, pressure, window, undisturbed=True))
        self._solver = BatchSolver(problem, gradient, StickInverse(window.shape, grid.dx, grid.dy, derived.shear_compliance))
        x, y = grid.x[window.rows][:, None], grid.y[window.columns][None, :]
        self._x, self._y = np.broadcast_arrays(x, y)
        one, zero = np.ones(window.shape), np.zeros(window.shape)
        unit = derived.problem.traction_limit / (derived.problem.lower.shear_modulus * derived.hertz.mean_radius**2)
        self.units = unit, turn = unit, unit / derived.hertz.mean_radius
        self._unit_slips = np.array([[unit * one, zero], [zero, unit * one], [-turn * self._y, turn * self._x]])
        self._unit_sticks = self._solver.full_stick(self._unit_slips)

    def continued(self, coarse: _OneGrid, tractions: Array) -> Array:
        """Tractions (B, 2, n, m) of a coarser grid on this one, as shares of the bound: slip stays slip."""
        along = interpolation_matrix(coarse.grid.x[coarse.window.rows], self.grid.x[self.window.rows])
        across = interpolation_matrix(coarse.grid.y[coarse.window.columns], self.grid.y[self.window.columns]).T
        bound = along @ coarse.bound @ across
        share = self.bound / np.where(bound > 0.0, bound, 1.0)
        return np.asarray(np.matmul(np.matmul(along, tractions), across) * share)

    def solve(self, creepages: Array, start: Array | None = None) -> tuple[Array, NDArray[np.bool_], Array]:
        """`QUANTITIES` (4, n), which points converged, and tractions (n, 2, …), from those of `start` or of full stick."""
        rigid = np.tensordot(creepages.T, self._unit_slips, axes=1)
        if start is None:
            start = np.tensordot(creepages.T, self._unit_sticks, axes=1)
        solution = self._solver.solve(rigid, start, TOLERANCE)
        derived, grid = self.derived, self.grid
        share = grid.element_area / derived.problem.traction_limit
        tx, ty = solution.traction[:, 0], solution.traction[:, 1]
        moment = (self._x * ty - self._y * tx).sum(axis=(1, 2)) * share / derived.hertz.mean_radius
        area = float(self._covered.sum())
        sticking = [float(stick_share(traction, slip, self.bound, stick, self._covered, grid.dx, grid.dy,
                                      derived.shear_compliance).sum())
                    for traction, slip, stick in zip(solution.traction, solution.slip, solution.stick, strict=True)]
        fraction = np.clip(np.array(sticking) / area, 0.0, 1.0)
        values = np.stack([tx.sum(axis=(1, 2)) * share, ty.sum(axis=(1, 2)) * share, moment, fraction])
        return values, solution.converged, solution.traction


def _problem(aspect_ratio: float, poisson_ratio: float, shape: tuple[int, int]) -> Problem:
    """A contact with semi-axes of the given ratio."""
    g = aspect_ratio
    ratio = math.sqrt(elliprd(0.0, 1.0 / g, g) / elliprd(0.0, g, 1.0 / g))  # of the curvatures along x and y (Hertz)
    body = Material(MODULUS, poisson_ratio)
    geometry = Geometry(RADIUS / ratio, RADIUS * ratio, math.inf, math.inf)
    motion = Motion(1.0, 1e-3, 0.0, 1.0, differential_slip=False)
    return Problem(body, body, geometry, LOAD, FRICTION, motion, Heating(heat=False, deformation=False), Numerics(shape))

"""The tangential problem on one grid: its window, its correction at the leading edge, and the choice of the solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.exact.hertz import shear_gradients
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.contact.shear_coupling import NormalShearCoupling
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.convolution import Convolution, Parities, in_pairs, multiply, unfolded
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.rolling.element_borders import continued_gradient, known_gradient
from thermoroll_cli.physics.rolling.hardening import Hardening
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import MARGIN, RollingGradient, RollingOptions, difference
from thermoroll_cli.physics.rolling.rolling_solver import RollingSolver, Start
from thermoroll_cli.physics.rolling.slip_friction import SlipFriction
from thermoroll_cli.physics.rolling.slip_heat import heat_of_slip
from thermoroll_cli.problem.contact import Past, Pressure, Traction
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

FORCE_TOLERANCE = 0.4
"""Factor of the tolerance of tractions under a prescribed force: the creepage amplifies the remaining residual. So it is from
Carter's tractions on: what they miss has one sign, and adds up in the force (1: by up to 3.6e-5 of μW on 256 elements)."""
BEYOND_YIELD = 1.02
"""Forces above this multiple of the interlayer's capacity, under the pressure without heat and shear, are rejected before
solving. Shear changes the capacity by less, and coarse grids overestimate it."""


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

    def scalar(self, field: NDArray[Any], parity: int = 1) -> NDArray[Any]:
        """A scalar (n, m) of the window, even (`parity` 1) or odd across y = 0, on the whole grid; zero outside."""
        full = np.zeros(self.grid, dtype=field.dtype)
        full[self.rows, self.both_sides.columns] = field if self.mirror is None else unfolded(field, parity)
        return full

    def vector(self, field: NDArray[Any]) -> NDArray[Any]:
        """A vector (2, n, m) of the window on the whole grid; zero outside."""
        if self.mirror is None:
            full = np.zeros((2, *self.grid))
            full[:, self.rows, self.columns] = field
            return full
        return np.stack([self.scalar(part, parity) for part, parity in zip(field, self.mirror, strict=True)])

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


class TractionSolver:
    """Solves tangential problems that share kernels (`Discretisation.has_kernels_of`); keeps the solvers of their windows."""

    def __init__(self, grid: Grid, bodies: Bodies, threads: int, options: RollingOptions) -> None:
        self.grid, self.bodies, self.options, self._threads = grid, bodies, options, threads
        self._near = bodies.near_border(grid.dx, grid.dy)
        self._windows: dict[Parities | None, Window] = {}
        self._solvers: dict[Parities | None, RollingSolver] = {}
        self._over_time: dict[tuple[Parities | None, float, bool], RollingSolver] = {}
        self._undisturbed_leading: tuple[Window, Pressure, Array] | None = None

    @cached_property
    def coupling(self) -> NormalShearCoupling:
        """Coupling of pressure and shear of unlike bodies."""
        return NormalShearCoupling(self.grid, self.bodies, self.options.difference_weights)

    def solve(
        self, derived: DerivedQuantities, normal: Pressure, rigid: Array, start: Traction, tolerance: float,
        friction: Array | None, *, undisturbed: bool,
    ) -> Traction:
        """Tractions and slip under the pressure `normal` (`undisturbed` says that it is Hertz's), driven by the slip `rigid`
        (2, nx, ny); `friction` as in `Discretisation.roll`. Raises Unsolvable if the interlayer yields far below the force."""
        problem, motion, past = derived.problem, derived.problem.motion, derived.past
        mirror = derived.kinematics.mirror_on(self.grid.ny, heated=not undisturbed or friction is not None)
        # A contact that grows meets material that has moved: displacements are needed everywhere.
        window = self.window_around(normal.contact if past is None else np.ones_like(normal.contact), mirror)
        solver = self._solvers[mirror] if past is None else self._step_solver(mirror, past)
        before = solver.gradient.applications
        # Between dissimilar bodies tractions begin like sqrt(s) ln s and have no given shape.
        has_shape = self.options.leading_known and not derived.dissimilar and solver.gradient.rolls
        bound, most = coulomb_bound(problem, normal.pressure, friction, self.grid), problem.interlayer.yield_stress
        if most is not None:
            bound = _capped(most, bound, normal.covered)
        if undisturbed:
            check_yield(problem, float(bound.sum()) * self.grid.element_area, BEYOND_YIELD)
        cell = TangentialProblem(
            traction_bound=window.cut(bound),
            covered=window.cut(normal.covered),
            rigid_slip=window.cut(rigid),
            element_area=self.grid.element_area * window.weight,
            force=(motion.force_x, motion.force_y),
            leading=self.leading(derived, normal, window, undisturbed=undisturbed) if has_shape else None,
            variation=_variation(derived, self.grid, window),
            slip_friction=self._slip_friction(derived, normal, bound, friction, window),
            spots=problem.heights is not None,
        )
        from_carter = start.is_unknown and undisturbed and derived.kinematics.carter
        solution = solver.solve(
            cell,
            [self._carter(derived, cell, window)] if from_carter else [] if start.is_unknown
            else [(window.cut(start.traction), start.creepage)],
            tolerance * (FORCE_TOLERANCE if cell.free or from_carter else 1.0),
        )
        creepage_x = solution.creepage[0] if motion.force_x is not None else motion.creepage_x or 0.0
        creepage_y = solution.creepage[1] if motion.force_y is not None else motion.creepage_y or 0.0
        rigid_inner = cell.rigid_slip + np.array(solution.creepage)[:, None, None]
        if past is not None:
            rigid_inner = rigid_inner - past.rate * solution.displacement
        hysteresis = solution.hysteresis * cell.element_area
        work = float((solution.traction * rigid_inner).sum()) * cell.element_area - hysteresis
        local = None
        if problem.interlayer.yield_stress is not None or problem.friction.law is not None or problem.friction.across:
            cell = replace(cell, traction_bound=solution.bound)
            reached = window.scalar(solution.bound)
            share = problem.friction.mean_share(self.grid.y, self.grid.dy)
            local = np.full(self.grid.shape, problem.friction.coefficient * share)
            np.divide(reached, normal.pressure, out=local, where=normal.pressure > 0.0)
        heat, slope = heat_of_slip(solution, cell, rigid_inner, solver.gradient.near_border, self.grid.dx, self.grid.dy)
        return Traction(
            traction=window.vector(solution.traction),
            slip=window.vector(solution.slip * (cell.covered > 0.0)),
            stick=window.scalar(solution.stick),
            creepage=(creepage_x, creepage_y),
            heat=window.scalar(heat),
            heat_slope=window.scalar(slope),
            work=work,
            residual=solution.residual,
            newton_steps=solution.newton_steps,
            applications=solver.gradient.applications - before,
            converged=solution.converged,
            friction=local,
            hardening=None if solution.hardening is None else window.scalar(solution.hardening),
            hysteresis=hysteresis,
            displacement=window.vector(solution.displacement),
        )

    def _carter(self, derived: DerivedQuantities, cell: TangentialProblem, window: Window) -> Start:
        """Tractions and creepages of Carter (`Kinematics.carter`) to begin from: a third of the applications, since from full
        stick the end of slip moves on by an element or two per step."""
        hertz, limit, compliance = derived.hertz, derived.problem.traction_limit, self.bodies.shear
        assert hertz is not None
        most = derived.problem.friction.coefficient * hertz.peak_pressure
        compliances = np.array([compliance.along, compliance.across])
        # The slip over the compliance is p0 μ (1 − a'/a), with a' the half-width of what sticks.
        towards = cell.rigid_slip.mean(axis=(1, 2)) / compliances
        if cell.free:
            share = np.array([force or 0.0 for force in cell.force]) / limit
            size = math.hypot(*share)
            towards = share * (most * (1.0 - math.sqrt(max(1.0 - size, 0.0))) / (size or 1.0))
        size, half = math.hypot(*towards), hertz.semi_axis_x
        stick = half * max(1.0 - size / most, 0.0)
        behind = self.grid.x[window.rows][:, None] + half - stick
        traction = cell.traction_bound - most / half * np.sqrt(np.maximum(stick**2 - behind**2, 0.0))
        along, across = (towards * compliances if cell.free else np.zeros(2)).tolist()
        return (towards / (size or 1.0))[:, None, None] * np.maximum(traction, 0.0), (along, across)

    def _slip_friction(
        self, derived: DerivedQuantities, normal: Pressure, bound: Array, friction: Array | None, window: Window
    ) -> SlipFriction | Hardening | None:
        """What changes the `bound` (nx, ny) with the slip, in the window; None if nothing does."""
        problem, past = derived.problem, derived.past
        layer, law, place = problem.interlayer, problem.friction.law, (self.grid.dx, window.cut(normal.covered))
        before = () if past is None or past.friction is None else (window.cut(past.friction), past.rate, past.rolls)
        if law is not None:
            return SlipFriction(law, problem.motion.speed, *place, *before)
        if layer.yield_stress is None or not layer.hardens:
            return None
        limit = coulomb_bound(problem, normal.pressure, friction, self.grid)
        return Hardening(window.cut(bound), window.cut(limit), layer.yield_stress, layer.hardening, *place, *before)

    # --- the window ----------------------------------------------------------------------------------------------

    def window_around(self, contact: NDArray[np.bool_], mirror: Parities | None) -> Window:
        """Window around the contact; the last one, with its solver, is kept while it still holds the contact."""
        need, last = window_around(contact, mirror), self._windows.get(mirror)
        if last is not None and last.holds(need):
            return last
        window = need if last is None else last.grown(need)
        self._windows[mirror] = window
        self._over_time.clear()
        self._solvers[mirror] = RollingSolver(RollingGradient(
            window.shape, self.grid.dx, self.grid.dy, self.bodies, self._threads, mirror,
            self.options.difference_weights), self.options)
        return window

    def _step_solver(self, mirror: Parities | None, past: Past) -> RollingSolver:
        """The solver of steps with the rate of `past`; those of the last few rates are kept."""
        key = mirror, past.rate, past.rolls
        if key not in self._over_time:
            if len(self._over_time) > 3:
                self._over_time.clear()
            gradient = self._solvers[mirror].gradient.over_time(past.rate, rolls=past.rolls)
            self._over_time[key] = RollingSolver(gradient, self.options)
        return self._over_time[key]

    def displacement(self, derived: DerivedQuantities, tangential: Traction) -> Array:
        """u = A τ in m, (2, nx, ny): that of the last solution, or computed on the whole grid."""
        if tangential.displacement is not None:
            return tangential.displacement
        if not tangential.traction.any():
            return np.zeros_like(tangential.traction)
        window = self.window_around(np.ones(self.grid.shape, dtype=bool), None)
        return np.asarray(self._solvers[None].gradient.displacement(window.cut(tangential.traction))[:, MARGIN:-MARGIN])

    def solver_of(self, window: Window) -> RollingSolver:
        """The solver of the window that was asked for last, with its symmetry."""
        return self._solvers[window.mirror]

    # --- the leading edge --------------------------------------------------------------------------------------

    def leading(self, derived: DerivedQuantities, normal: Pressure, window: Window, *, undisturbed: bool) -> Array:
        """Error of the difference formula at the leading edge (`known_gradient`), (3, n, m) in the window."""
        if not undisturbed:
            return self._missed(derived, normal, window, undisturbed=False)
        known = self._undisturbed_leading
        if known is None or known[0] != window or known[1] is not normal:
            known = self._undisturbed_leading = window, normal, self._missed(derived, normal, window, undisturbed=True)
        return known[2]

    def _missed(self, derived: DerivedQuantities, normal: Pressure, window: Window, *, undisturbed: bool) -> Array:
        """`leading` computed anew, for one application: under Hertz's pressure from the closed form, else from the gap."""
        grid, compliance = self.grid, self._near.shear
        # Of the half-spaces that stand for the bodies at the border; for elastic half-spaces the solver's own.
        operator = self._solvers[window.mirror].gradient if self._near is self.bodies else RollingGradient(
            window.shape, grid.dx, grid.dy, self._near, self._threads, window.mirror, self.options.difference_weights)
        gradient = operator.of_shape(window.cut(normal.pressure))
        both = window.both_sides
        if window.mirror is not None:
            gradient = np.stack([unfolded(field, parity) for field, parity in zip(gradient, (1, 1, -1), strict=True)])
        pressure, covered = both.cut(normal.pressure), both.cut(normal.covered)
        if undisturbed and derived.hertz is not None:
            along, across, mixed = shear_gradients(derived.hertz, compliance.isotropic, compliance.directional)
            x, y = np.broadcast_arrays(grid.x[both.rows][:, None], grid.y[both.columns])
            exact = np.stack([along * x, across * x, mixed * y])
        else:
            closed = self._closing(derived, normal)[both.rows.start : both.rows.stop + 2 * MARGIN, both.columns]
            isotropic = np.pi * self._near.contact_modulus * difference(closed, self.options.difference_weights, grid.dx)
            exact = continued_gradient(pressure, gradient, isotropic, grid.dx, grid.dy, compliance)
        return known_gradient(pressure, gradient, exact, covered)[:, :, -window.shape[1] :]

    def _closing(self, derived: DerivedQuantities, normal: Pressure) -> Array:
        """u_z^e inside the contact up to a constant, offset − h_i in m, continued outside, with `MARGIN` more rows at either
        end: (nx+4, ny)."""
        grid = self.grid
        gap = derived.problem.geometry.gap(grid.rows_with(MARGIN), grid.y)
        # A domain of all positions of a patch may reach beyond its surfaces at one of them.
        closing = -np.where(np.isinf(gap), 0.0, gap)
        if normal.offset is not None:
            # Rows beyond the domain only matter on the coarsest grids.
            closing += np.pad(normal.offset, ((MARGIN, MARGIN), (0, 0)), mode="reflect", reflect_type="odd")
        if self._beyond_border is not None:
            convolution, kernel = self._beyond_border
            hat = convolution.forward(normal.pressure)
            closing -= convolution.inverse(multiply(hat, kernel, out=hat))
        return closing

    @cached_property
    def _beyond_border(self) -> tuple[Convolution, AnyArray] | None:
        """Kernel of the normal displacement less that of the half-spaces at the border, on `MARGIN` more rows; None of bodies
        that are these half-spaces."""
        if self._near is self.bodies:
            return None
        place = self.grid.nx + MARGIN, self.grid.ny, self.grid.dx, self.grid.dy
        own, near = (bodies.normal_table(*place) for bodies in (self.bodies, self._near))
        convolution = Convolution(*self.grid.shape, MARGIN, MARGIN)
        rest = own._replace(quadrant=own.quadrant - near.quadrant)
        return convolution, in_pairs(rest.symbol((convolution.px, convolution.py)))


def coulomb_bound(problem: Problem, pressure: Array, friction: Array | None, grid: Grid) -> Array:
    """Mean of μp in each element in Pa, (nx, ny), with the local coefficient `friction` (None: the problem's) where places
    share it alike. Where shares change within an element they count with the pressure, which changes evenly there, too."""
    whole = (problem.friction.coefficient if friction is None else friction) * pressure
    if not problem.friction.across:
        return whole
    around = np.pad(whole, ((0, 0), (1, 1)))
    change = np.clip(0.5 * (around[:, 2:] - around[:, :-2]), -2.0 * whole, 2.0 * whole)
    moment = problem.friction.mean_of(lambda share, strip, offset: share * offset, grid.y, grid.dy)
    return whole * problem.friction.mean_share(grid.y, grid.dy) + change * moment


def _capped(most: float, bound: Array, covered: Array) -> Array:
    """Mean of min(b, `most`) in each element, (nx, ny), where the mean of b is `bound`.

    The square of a contact pressure changes evenly: in an element b² takes every value of a range equally often. The range of
    an element at the border begins at zero; that of others is as wide as the steps to the neighbours that carry more."""
    square = np.pad(bound**2, 1)
    own = square[1:-1, 1:-1] + np.finfo(float).tiny
    steps = (np.maximum(square[2:, 1:-1], square[:-2, 1:-1]) - own, np.maximum(square[1:-1, 2:], square[1:-1, :-2]) - own)
    half = np.minimum(0.5 * np.hypot(*(np.maximum(step, 0.0) for step in steps)), own)
    middle = own + half**2 / (12.0 * own)  # the mean of the square is above the square of the mean
    border, area = covered < 1.0, np.maximum(covered, 1e-3)
    low = np.where(border, 0.0, middle - half)
    high = np.where(border, 2.25 * own / area**2, middle + half + 1e-6 * own)
    below = np.clip(most**2, low, high)
    mean = (2.0 / 3.0 * (below**1.5 - low**1.5) + most * (high - below)) / (high - low)
    return np.where(high <= most**2, bound, np.minimum(bound, mean * np.where(border, area, 1.0)))


def check_yield(problem: Problem, limit: float, margin: float = 1.0) -> None:
    """Raises Unsolvable if the prescribed force reaches `margin` times the `limit` (N) that a yielding interlayer carries."""
    if problem.interlayer.most is not None and problem.prescribed_force >= margin * limit:
        raise Unsolvable(f"the interlayer yields: it carries {problem.force_text(limit)} at most, and the prescribed force is "
                         f"{problem.force_text(problem.prescribed_force)}", "force")


def _variation(derived: DerivedQuantities, grid: Grid, window: Window) -> Array | None:
    """Half the change of the longitudinal creepage across the width of an element by differential slip and spin, (n, m)."""
    kinematics = derived.kinematics
    if not kinematics.differential_slip.active:
        return None
    # Half the width about the centre: a crown ends infinitely deep, at the border of an element.
    low, high = (kinematics.slip_at(np.zeros(1), grid.y + part * grid.dy)[0] for part in (-0.25, 0.25))
    variation = np.abs(high - low)
    return window.cut(np.broadcast_to(variation, grid.shape))

"""All stages on one grid, with the kernels and plans that they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.exact.hertz_elements import element_averages
from thermoroll_cli.exact.hertz_shear import shear_gradients
from thermoroll_cli.kernels.grid import Grid
from thermoroll_cli.kernels.mirror import Parities, unfolded
from thermoroll_cli.pipeline.contact import Contact, Pressure, Traction
from thermoroll_cli.pipeline.heat import Heat, divide
from thermoroll_cli.pipeline.scene import Scene
from thermoroll_cli.pipeline.window import Window, window_around
from thermoroll_cli.solvers.dissimilar import NormalShearCoupling
from thermoroll_cli.solvers.heat import HeatResponse, ThermalResponse
from thermoroll_cli.solvers.leading_border import continued_gradient, known_gradient
from thermoroll_cli.solvers.normal import NormalSolution, NormalSolver
from thermoroll_cli.solvers.prolongation import Prolongation
from thermoroll_cli.solvers.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.solvers.tangential import RollingSolver, TangentialProblem, TangentialSolution
from thermoroll_cli.solvers.tangential_operator import DIFFERENCE_WEIGHTS, RollingGradient, difference

Array = NDArray[np.float64]


class Level:
    """The solvers of one scene on one grid; each is built when a stage first needs it."""

    def __init__(self, scene: Scene, shape: tuple[int, int], extent: float, threads: int = 1) -> None:
        self.scene = scene
        self.grid: Grid = scene.grid(shape, extent)
        self.extent = extent
        self.threads = threads
        self._windows: dict[Parities | None, Window] = {}
        self._rolling: dict[Parities | None, RollingSolver] = {}
        self._hertz_leading: tuple[Window, Array] | None = None
        self._heat: HeatResponse | None = None
        self._heats: list[tuple[Traction, Heat]] = []

    def serves(self, scene: Scene, shape: tuple[int, int], extent: float) -> bool:
        """Whether the kernels built here are those of another scene: same bodies, same Hertz contact, same grid."""
        return (self.grid.shape == shape and self.extent == extent and self.scene.hertz == scene.hertz
                and self.scene.shear_compliance == scene.shear_compliance
                and self.scene.coupling_constant == scene.coupling_constant)

    def show(self, scene: Scene) -> None:
        """Turn to another scene that the kernels serve (see `serves`)."""
        self.scene = scene
        self._heats.clear()

    # --- normal --------------------------------------------------------------------------------------------------

    @cached_property
    def undeformed_gap(self) -> Array:
        return self.scene.undeformed_gap(self.grid)

    @cached_property
    def normal_solver(self) -> NormalSolver:
        return NormalSolver(self.grid, self.scene.problem.contact_modulus)

    @cached_property
    def hertz(self) -> Pressure:
        """The isothermal pressure: smooth bodies without thermal bulge are in Hertz contact exactly, so nothing is solved."""
        hertz, grid = self.scene.hertz, self.grid
        # One quadrant tells the others.
        x_edges, y_edges = (np.arange(n // 2, n + 1, dtype=np.float64) - 0.5 * n for n in grid.shape)
        quadrants = element_averages(hertz, x_edges * grid.dx, y_edges * grid.dy)
        pressure, covered = (_four_quadrants(q, grid.shape) for q in quadrants)
        displacement = self.normal_solver.displacement(pressure)
        gap = np.maximum(self.undeformed_gap + displacement - hertz.approach, 0.0)
        return Pressure(pressure, covered, displacement, np.where(covered > 0.0, 0.0, gap), hertz.approach,
                        hertz.peak_pressure)

    def press(self, offset: Array, start: Array, tolerance: float) -> tuple[Pressure, NormalSolution]:
        """Contact pressure on bodies whose gap is closed by `offset` (m) beforehand (thermal expansion, lift by shear),
        starting from the pressure `start`."""
        gap, force = self.undeformed_gap - offset, self.scene.problem.normal_force
        solution = self.normal_solver.solve(gap, force, start, tolerance)
        refined = self.normal_solver.refine(solution, gap, force, tolerance)
        pressure, covered, displacement, gap = refined.pressure, refined.covered, refined.displacement, refined.gap
        if self._halves:
            # So they are but for rounding, which must not decide about an element of the border on one side only.
            pressure, covered, displacement, gap = (0.5 * (f + f[:, ::-1]) for f in (pressure, covered, displacement, gap))
        normal = Pressure(pressure, covered, displacement, gap, refined.approach, peak_value(pressure), offset)
        return normal, replace(solution, touches_rim=solution.touches_rim and self._rim_tells)

    @property
    def _rim_tells(self) -> bool:
        """Whether contact in the outermost elements means that the domain is too small: on coarse grids they also hold the
        border of Hertz's contact, so their centres must lie in the outer half of the room around it."""
        grid, hertz = self.grid, self.scene.hertz
        half_room = 0.5 * (1.0 + 0.5 * self.extent)
        return bool(grid.x[-1] > half_room * hertz.semi_axis_x and grid.y[-1] > half_room * hertz.semi_axis_y)

    # --- dissimilar bodies ---------------------------------------------------------------------------------------

    @cached_property
    def normal_shear(self) -> NormalShearCoupling:
        return NormalShearCoupling(self.grid, self.scene.coupling_constant)

    # --- tangential ----------------------------------------------------------------------------------------------

    def driving_slip(self, normal: Pressure) -> Array:
        """Slip s/V without any traction, (2, nx, ny): creepage and spin, and −∂u^p/∂x where the bodies stretch differently."""
        rigid = self.scene.rigid_slip(self.grid)
        if self.scene.dissimilar:
            rigid -= self.normal_shear.stretch(normal.pressure)
        return rigid

    def roll(
        self, normal: Pressure, starts: Sequence[Traction], tolerance: float, friction: Array | None = None
    ) -> Traction:
        """Tractions and slip under the given pressure, from whichever of `starts` fits best (none: from full stick).

        `friction` is the local coefficient (nx, ny), if it is not the same everywhere."""
        problem = self.scene.problem
        rigid = self.driving_slip(normal)
        motion = problem.motion
        given = (motion.creepage_x or 0.0, motion.creepage_y or 0.0)
        zero = np.zeros((2, *self.grid.shape))
        if not self.scene.has_traction:
            # Nothing to solve: without friction the surfaces slide freely, without creepage they stick.
            sliding = self.scene.moves
            return Traction(zero, rigid * normal.contact if sliding else zero,
                            normal.contact & (not sliding), given, np.zeros(self.grid.shape), 0.0, 0.0, 0, 0, True)
        mirror = self._mirror(normal, friction)
        window = self._window_around(normal.contact, mirror)
        before = self._rolling[mirror].gradient.applications
        cell = TangentialProblem(
            bound=(problem.friction if friction is None else window.cut(friction)) * window.cut(normal.pressure),
            covered=window.cut(normal.covered),
            rigid_slip=window.cut(rigid),
            element_area=self.grid.element_area * window.weight,
            force=(motion.force_x, motion.force_y),
            # Dissimilar bodies: there tractions begin like sqrt(s) ln s and have no given shape.
            leading=None if self.scene.dissimilar else self._leading(normal, window),
        )
        solution = self._rolling[mirror].solve(
            cell,
            [(window.cut(start.traction), start.creepage) for start in starts],
            tolerance * (0.4 if cell.free else 1.0),
        )
        creepage = tuple(s if f is not None else g for s, g, f in zip(
            solution.creepage, given, (motion.force_x, motion.force_y), strict=True))
        rigid_inner = cell.rigid_slip + np.array(solution.creepage)[:, None, None]
        work = float((solution.traction * rigid_inner).sum()) * cell.element_area
        return Traction(window.vector(solution.traction), window.vector(solution.slip * (cell.covered > 0.0)),
                        window.scalar(solution.stick), (creepage[0], creepage[1]),
                        window.scalar(_dissipated(solution, rigid_inner)), work, solution.residual,
                        solution.newton_steps, self._rolling[mirror].gradient.applications - before, solution.converged)

    def _leading(self, normal: Pressure, window: Window) -> Array:
        """What the difference formula misses at the leading border (`leading_border`), (3, n, m) in the window."""
        if normal is not self.hertz:
            return self._missed(normal, window)
        if self._hertz_leading is None or self._hertz_leading[0] != window:
            self._hertz_leading = window, self._missed(normal, window)
        return self._hertz_leading[1]

    def _missed(self, normal: Pressure, window: Window) -> Array:
        """`_leading` afresh, for one application: below Hertz's pressure from the closed form, below others from their gap."""
        grid, scene, compliance = self.grid, self.scene, self.scene.shear_compliance
        found = self._rolling[window.mirror].gradient.of_shape(window.cut(normal.pressure))
        both = window.both_sides
        if window.mirror is not None:
            found = np.stack([unfolded(field, parity) for field, parity in zip(found, (1, 1, -1), strict=True)])
        pressure, covered = both.cut(normal.pressure), both.cut(normal.covered)
        if normal is self.hertz:
            along, across, mixed = shear_gradients(scene.hertz, compliance.isotropic, compliance.directional)
            x, y = np.broadcast_arrays(grid.x[both.rows][:, None], grid.y[both.columns])
            exact = np.stack([along * x, across * x, mixed * y])
        else:
            closed = self._closing(normal)[both.rows.start : both.rows.stop + 4, both.columns]
            isotropic = np.pi * scene.problem.contact_modulus * difference(closed, DIFFERENCE_WEIGHTS, grid.dx)
            exact = continued_gradient(pressure, found, isotropic, grid.dx, grid.dy, compliance)
        missed = known_gradient(pressure, found, exact, covered)
        return missed[:, :, -window.shape[1] :]

    def _closing(self, normal: Pressure) -> Array:
        """u_z^e inside the contact up to a constant, offset − h_i in m, continued outside, on rows −2…nx+1: (nx+4, ny)."""
        grid = self.grid
        x = (np.arange(-2, grid.nx + 2) - 0.5 * (grid.nx - 1)) * grid.dx
        closing = -self.scene.hertz.undeformed_gap(x[:, None], grid.y[None, :])
        if normal.offset is not None:
            # Two rows beyond the domain matter on the coarsest grids alone.
            closing += np.pad(normal.offset, ((2, 2), (0, 0)), mode="reflect", reflect_type="odd")
        return closing

    def _mirror(self, normal: Pressure, friction: Array | None) -> Parities | None:
        """Parities of the tractions if half the contact tells the rest (see `Scene.mirror`)."""
        cold = normal is self.hertz and friction is None
        return self.scene.mirror if self._halves or (cold and self.grid.ny % 2 == 0) else None

    @property
    def _halves(self) -> bool:
        """Whether everything, heat and all, is its own mirror image across y = 0."""
        return self.scene.mirror is not None and self.scene.heat_mirrors and self.grid.ny % 2 == 0

    def _window_around(self, contact: NDArray[np.bool_], mirror: Parities | None) -> Window:
        """Where the contact lies; the solver of the last window is kept while that still holds the contact."""
        need, last = window_around(contact, mirror), self._windows.get(mirror)
        if last is not None and last.holds(need):
            return last
        window = need if last is None else last.grown(need)
        self._windows[mirror] = window
        self._rolling[mirror] = RollingSolver(RollingGradient(
            window.shape, self.grid.dx, self.grid.dy, self.scene.shear_compliance, self.threads, mirror))
        return window

    # --- heat ----------------------------------------------------------------------------------------------------

    @cached_property
    def _sliding(self) -> SlidingKernels:
        return SlidingKernels(self.grid)

    def heat_response(self, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        """Thermal response of both bodies at the given creepages and `slip` s/V (2, nx, ny), which only matters where the
        Péclet number is made with it. Kernels are kept, and built again only when speeds change."""
        lower, upper = self.scene.heated_bodies(*creepage)
        problem = self.scene.problem
        if problem.heating.peclet == "sliding":
            return SlidingHeatResponse(self._sliding, lower, upper, problem.motion.speed * np.hypot(slip[0], slip[1]))
        if self._heat is None or self._heat.bodies != (lower, upper):
            self._heat = HeatResponse(self.grid, lower, upper)
        return self._heat

    def heat_flux(self, tangential: Traction) -> Array:
        """Frictional heat flux q in W/m², (nx, ny)."""
        return self.scene.problem.motion.speed * tangential.heat

    def heat(self, contact: Contact) -> Heat:
        """The heat of a state, divided between the bodies. Those of the last two states asked for are kept."""
        tangential = contact.tangential
        known = next((heat for traction, heat in self._heats if traction is tangential), None)
        if known is None:
            response = self.heat_response(tangential.creepage, tangential.slip)
            known = divide(self.scene.problem.heating, response, self.heat_flux(tangential), contact.normal.contact)
            self._heats = [*self._heats[-1:], (tangential, known)]
        return known

    # --- between grids -------------------------------------------------------------------------------------------

    def continue_from(self, coarse: Level, contact: Contact, normal: Pressure) -> Traction:
        """Tractions of a coarser grid as a first guess under the pressure `normal` of this one."""
        prolong = Prolongation(coarse.grid, self.grid)
        old = contact.tangential
        traction = prolong.traction(old.traction, contact.normal.pressure, normal.pressure)
        nothing = np.zeros(self.grid.shape)
        return Traction(traction, traction, nothing > 0.0, old.creepage, nothing, 0.0, 0.0, 0, 0, True)

    @property
    def transforms(self) -> int:
        """Padded transforms done on this level by all stages."""
        total = self.normal_solver.transforms if "normal_solver" in self.__dict__ else 0
        total += sum(solver.gradient.transforms for solver in self._rolling.values())
        total += self.normal_shear.transforms if "normal_shear" in self.__dict__ else 0
        total += self._sliding.transforms if "_sliding" in self.__dict__ else 0
        return total + (self._heat.transforms if self._heat is not None else 0)


def _dissipated(solution: TangentialSolution, rigid: Array) -> Array:
    """τ·s, plus what slip zones narrower than an element dissipate, so that the heat equals the work of the forces.

    The upstream difference and the border compliance take up that power where it is lost; it is given back in proportion
    to their local share."""
    resolved = np.maximum((solution.traction * solution.slip).sum(axis=0), 0.0)
    missing = float((solution.traction * rigid).sum() - resolved.sum())
    if missing < 0.0:
        # What stands in for the border's compliance is no resistance everywhere: full sliding may dissipate 1e-5 too much.
        return np.asarray(resolved * (1.0 + missing / float(resolved.sum())))
    taken = np.maximum(solution.lost, 0.0)
    total = float(taken.sum())
    if missing == 0.0 or total <= 0.0:
        return resolved
    return np.asarray(resolved + taken * (missing / total))


def _four_quadrants(quadrant: Array, shape: tuple[int, int]) -> Array:
    """A field even in x and y on the whole grid; the quadrant holds the middle elements where their number is odd."""
    nx, ny = shape
    half = np.concatenate([quadrant[nx % 2 :][::-1], quadrant])
    return np.concatenate([half[:, ny % 2 :][:, ::-1], half], axis=1)


def peak_value(field: Array) -> float:
    """Maximum of a smooth field given by element averages: the top of the parabolas through the largest element and its
    neighbours, or that element's value at the edge of the field's support."""
    i, j = np.unravel_index(int(np.argmax(field)), field.shape)
    top = float(field[i, j])
    rise = 0.0
    for axis, k in ((0, i), (1, j)):
        line = field[:, j] if axis == 0 else field[i, :]
        if 0 < k < len(line) - 1 and min(line[k - 1], line[k + 1]) > 0.0:
            bend = float(line[k - 1] - 2.0 * top + line[k + 1])
            slope = 0.5 * float(line[k + 1] - line[k - 1])
            if bend < 0.0:
                # Top of the parabola, and back from averages to values: f = mean − h² f''/24.
                rise += -0.5 * slope**2 / bend - bend / 24.0
    return top + rise

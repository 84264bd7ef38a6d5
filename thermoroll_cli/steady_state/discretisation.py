"""All stages on one grid, with the kernels and plans that they share."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.contact.normal_contact import NormalSolver
from thermoroll_cli.contact.shear_coupling import NormalShearCoupling
from thermoroll_cli.exact.hertz_elements import element_averages
from thermoroll_cli.heat.frictional_heat import Heat, divide
from thermoroll_cli.heat.heat_response import HeatResponse, ThermalResponse
from thermoroll_cli.heat.recirculation import RecirculatingResponse, Roller, Track
from thermoroll_cli.heat.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.numerics.grid import Domain, Grid, Prolongation
from thermoroll_cli.numerics.stencils import peak_inside, peak_value
from thermoroll_cli.problem.contact import Contact, Pressure, Traction
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.solver_options import SolverOptions
from thermoroll_cli.steady_state.traction import TractionSolver

BORDER_PRESSURES, LOW_PRESSURE = 3.0, 0.02
"""Pressure in the outermost elements over the isothermal one there, and in units of the peak, from which a contact is being cut
off there: 0.5 to 1.5 of one that only bulges (by a quarter of the approach, on 8² to 20² elements), from 4 to 500 of one that
has moved half out of its domain."""


class Discretisation:
    """The solvers of one problem on one grid; each is built when a stage first needs it."""

    def __init__(
        self, derived: DerivedQuantities, shape: tuple[int, int], extent: float, threads: int = 1,
        options: SolverOptions | None = None, followed: Domain | None = None,
    ) -> None:
        """`followed` is the domain around a heated contact, which may lie anywhere, instead of the one of `extent` semi-axes
        about the isothermal contact."""
        self.options = options or SolverOptions()
        self.derived = derived
        self.followed = followed
        self.grid: Grid = derived.grid(shape, extent) if followed is None else Grid.over(shape, *followed)
        self.extent = extent
        self.threads = threads
        self.rolling = TractionSolver(self.grid, threads, self.options.rolling)
        self._heat: HeatResponse | None = None
        self._tracks: dict[Roller, Track] = {}
        self._returning: RecirculatingResponse | None = None
        self._heats: list[tuple[Traction, Heat]] = []
        self.coarser: Discretisation | None = None
        """The grid before, from which the isothermal pressure is started where it is not known in closed form."""

    def has_kernels_of(self, derived: DerivedQuantities, shape: tuple[int, int], extent: float) -> bool:
        """Whether the kernels built here are those of another problem: same bodies, same contact without heat, same grid."""
        return (self.grid.shape == shape and self.extent == extent and _same_contact(self.derived, derived)
                and self.derived.shear_compliance == derived.shear_compliance
                and self.derived.coupling_constant == derived.coupling_constant)

    def of(self, derived: DerivedQuantities) -> Discretisation:
        """This, turned to another problem with the same kernels (see `has_kernels_of`)."""
        self.derived = derived
        self._heats.clear()
        return self

    # --- normal --------------------------------------------------------------------------------------------------

    @cached_property
    def undeformed_gap(self) -> Array:
        return self.derived.undeformed_gap(self.grid.x, self.grid.y)

    @cached_property
    def normal_solver(self) -> NormalSolver:
        return NormalSolver(self.grid, self.derived.problem.contact_modulus)

    @cached_property
    def isothermal_pressure(self) -> Pressure:
        """Pressure on bodies that nothing but their load deforms: bodies with radii are in Hertz contact exactly, so nothing is
        solved."""
        if self.derived.problem.geometry.has_profile:
            return self._press(None, self._isothermal_start(), self.options.tolerances.normal)
        hertz, grid = self.derived.hertz, self.grid
        if self.followed is None:
            # Hertz's pressure is even in x and y: one quadrant is averaged, the others are its mirror images.
            x_edges, y_edges = (np.arange(n // 2, n + 1, dtype=np.float64) - 0.5 * n for n in grid.shape)
            quadrants = element_averages(hertz, x_edges * grid.dx, y_edges * grid.dy)
            pressure, covered = (_four_quadrants(q, grid.shape) for q in quadrants)
        else:
            pressure, covered = element_averages(hertz, *(
                centre[0] + (np.arange(n + 1) - 0.5) * size
                for centre, n, size in ((grid.x, grid.nx, grid.dx), (grid.y, grid.ny, grid.dy))))
        if self.options.whole_elements:
            pressure = hertz.pressure(grid.x[:, None], grid.y[None, :])
            pressure *= self.derived.problem.normal_force / (float(pressure.sum()) * grid.element_area)
            covered = (pressure > 0.0).astype(float)
        displacement = self.normal_solver.displacement(pressure)
        gap = np.maximum(self.undeformed_gap + displacement - hertz.approach, 0.0)
        gap = np.where(covered > 0.0, 0.0, gap)
        return Pressure(pressure, covered, displacement, gap, approach=hertz.approach, peak=hertz.peak_pressure)

    def press(self, offset: Array | None, start: Pressure, tolerance: float) -> Pressure:
        """Contact pressure on bodies whose gap is closed by `offset` (m, (nx, ny)) beforehand: thermal expansion, normal
        displacement by shear (None: nothing). `start` is where the solver begins."""
        return self.isothermal_pressure if offset is None else self._press(offset, start.start, tolerance)

    def _press(self, offset: Array | None, start: Array, tolerance: float) -> Pressure:
        gap, force = self.undeformed_gap - (0.0 if offset is None else offset), self.derived.problem.normal_force
        profile = self.derived.problem.geometry.has_profile
        solution = self.normal_solver.solve(gap, force, start, tolerance)
        refined = self.normal_solver.refine(solution, gap, force, tolerance)
        pressure, covered, displacement, gap = refined.pressure, refined.covered, refined.displacement, refined.gap
        if self.derived.kinematics.mirror_on(self.grid.ny, heated=True) is not None:
            # So they are but for rounding, which must not decide about an element of the border on one side only.
            pressure, covered, displacement, gap = (0.5 * (f + f[:, ::-1]) for f in (pressure, covered, displacement, gap))
        # Of whole elements, whose errors on both sides of the border cancel in the approach, where there is no Hertz contact
        # to compare with: four times closer on profiles.
        approach = solution.approach if profile else refined.approach
        peak = peak_inside(pressure, covered, self.at_ends) if profile else peak_value(pressure)
        return Pressure(
            pressure, covered, displacement, gap, approach=approach, peak=peak, offset=offset, whole_elements=solution.pressure,
            iterations=solution.iterations, converged=solution.converged, touches_rim=self._touches_rim(pressure))

    def _isothermal_start(self) -> Array:
        """Where the isothermal pressure of a profile is started: on the coarser grid, or everywhere."""
        if self.coarser is None:
            return np.zeros(self.grid.shape)
        return np.asarray(Prolongation(self.coarser.grid, self.grid)(self.coarser.isothermal_pressure.start))

    @property
    def at_ends(self) -> tuple[bool, bool]:
        """Whether the domain ends where a profile ends, at its lowest and at its highest y: the contact cannot go on there."""
        grid, (lowest, highest) = self.grid, self.derived.scales.limits
        reach = 0.501 * grid.dy
        return bool(grid.y[0] - reach < lowest), bool(grid.y[-1] + reach > highest)

    def _touches_rim(self, pressure: Array) -> bool:
        """Whether `pressure` in the outermost elements means that the domain is too small: on coarse grids they also hold the
        border of the isothermal contact, so their centres must lie in the outer half of the room around it, or the pressure
        must be more than any border's."""
        contact, grid, scales, ends = pressure > 0.0, self.grid, self.derived.scales, self.at_ends
        half_room = 0.5 * (1.0 + 0.5 * self.extent)
        touched = (contact[0].any() or contact[-1].any() or (contact[:, 0].any() and not ends[0])
                   or (contact[:, -1].any() and not ends[1]))
        if self.followed is not None:
            return bool(touched)
        if touched and not self.derived.problem.geometry.has_profile:
            before = _outermost(self.isothermal_pressure.pressure)
            if _outermost(pressure) > BORDER_PRESSURES * before + LOW_PRESSURE * scales.peak_pressure:
                return True
        return bool(touched and grid.x[-1] > half_room * scales.semi_axis_x
                    and (any(ends) or grid.y[-1] - scales.centre > half_room * scales.semi_axis_y))

    # --- dissimilar bodies ---------------------------------------------------------------------------------------

    @cached_property
    def normal_shear(self) -> NormalShearCoupling:
        return NormalShearCoupling(self.grid, self.derived.coupling_constant, self.options.rolling.difference_weights)

    def shear_displacement(self, traction: Array) -> Array:
        """−u_z^τ by which `traction` (2, nx, ny) closes the gap between dissimilar bodies, in m, (nx, ny).

        Its mean stays in: unlike thermal expansion it vanishes far away, and so it counts in the approach."""
        return self.normal_shear.normal_displacement(traction)

    # --- tangential ----------------------------------------------------------------------------------------------

    def driving_slip(self, normal: Pressure) -> Array:
        """Slip s/V without any traction, (2, nx, ny): creepage and spin, and −∂u^p/∂x where the bodies stretch differently."""
        rigid = self.derived.kinematics.rigid_slip(self.grid)
        if self.derived.dissimilar:
            rigid -= self.normal_shear.tangential_gradient(normal.pressure)
        return rigid

    def roll(
        self, normal: Pressure, start: Traction, tolerance: float, friction: Array | None = None
    ) -> Traction:
        """Tractions and slip under the given pressure, from the tractions of `start`.

        `friction` is the local coefficient (nx, ny), if it is not the same everywhere."""
        rigid = self.driving_slip(normal)
        zero = np.zeros((2, *self.grid.shape))
        if not self.derived.kinematics.has_traction:
            # Nothing to solve: without friction the surfaces slide freely, without creepage they stick.
            sliding = self.derived.kinematics.moves
            motion = self.derived.problem.motion
            given = (motion.creepage_x or 0.0, motion.creepage_y or 0.0)
            slip = rigid * normal.contact if sliding else zero
            return Traction(zero, slip, normal.contact & (not sliding), given, heat=zero[0], heat_slope=zero[0], work=0.0)
        return self.rolling.solve(self.derived, normal, rigid, start, tolerance, friction,
                                  undisturbed=normal is self.isothermal_pressure)

    # --- heat ----------------------------------------------------------------------------------------------------

    @cached_property
    def _sliding(self) -> SlidingKernels:

        return SlidingKernels(self.grid)

    def heat_response(self, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        """Thermal response of both bodies at the given creepages and `slip` s/V (2, nx, ny), which only matters where the
        Péclet number is made with it. Kernels are kept, and built again only when speeds change."""
        lower, upper = self.derived.heated_bodies(*creepage)
        problem = self.derived.problem
        if problem.heating.peclet == "sliding":

            return SlidingHeatResponse(self._sliding, lower, upper, problem.motion.speed * np.hypot(slip[0], slip[1]))
        if self._heat is None or self._heat.bodies != (lower, upper):
            self._heat = HeatResponse(self.grid, lower, upper)
        if problem.heating.recirculates:
            return self._recirculating(self._heat, creepage[0])
        return self._heat

    def _recirculating(self, passing: HeatResponse, creepage: float) -> RecirculatingResponse:
        """`passing`, and what the tracks of bodies that turn bring back. Tracks are kept until speeds or cooling change."""

        rollers = self.derived.rollers(creepage)
        self._tracks = {r: self._tracks.get(r) or Track(r, self.grid) for r in rollers if r is not None}
        lower, upper = (None if r is None else self._tracks[r] for r in rollers)
        found = RecirculatingResponse(passing, (lower, upper), bulging=self.derived.crown_matters)
        if self._returning is None or not self._returning.is_like(found):
            self._returning = found
        return self._returning

    def heat_flux(self, tangential: Traction) -> Array:
        """Frictional heat flux q in W/m², (nx, ny)."""
        return self.derived.problem.motion.speed * tangential.heat

    def heat(self, contact: Contact) -> Heat:
        """The heat of a state, divided between the bodies. Those of the last two states asked for are kept."""
        tangential = contact.tangential
        known = next((heat for traction, heat in self._heats if traction is tangential), None)
        if known is None:
            response = self.heat_response(tangential.creepage, tangential.slip)
            heating, normal = self.derived.problem.heating, contact.normal
            # What returns depends on all heat exchanged, and border elements that are hardly covered would exchange as much as
            # others: half covered ones are the whole contact on average.
            inside = normal.covered >= 0.5 if heating.recirculates else normal.contact
            slope = self.derived.problem.motion.speed * tangential.heat_slope
            before = self._heats[-1][1].into.exchanged if self._heats else None
            known = divide(heating, response, self.heat_flux(tangential), inside, slope, before)
            self._heats = [*self._heats[-1:], (tangential, known)]
        return known

    # --- work -----------------------------------------------------------------------------------------------------------

    @property
    def transforms(self) -> int:
        """Padded transforms done on this discretisation by all stages."""
        total = self.normal_solver.transforms if "normal_solver" in self.__dict__ else 0
        total += self.rolling.transforms
        total += self.normal_shear.transforms if "normal_shear" in self.__dict__ else 0
        total += self._sliding.transforms if "_sliding" in self.__dict__ else 0
        return total + (self._heat.transforms if self._heat is not None else 0)


def _outermost(pressure: Array) -> float:
    """Largest pressure in the outermost elements."""
    return float(max(side.max() for side in (pressure[0], pressure[-1], pressure[:, 0], pressure[:, -1])))


def _same_contact(one: DerivedQuantities, other: DerivedQuantities) -> bool:
    """Whether two problems have the same gap and the same isothermal pressure."""
    if one.problem.geometry.has_profile or other.problem.geometry.has_profile:
        return one.problem.geometry == other.problem.geometry and one.scales == other.scales
    return one.hertz == other.hertz


def _four_quadrants(quadrant: Array, shape: tuple[int, int]) -> Array:
    """A field even in x and y on the whole grid; the quadrant holds the middle elements where their number is odd."""
    nx, ny = shape
    half = np.concatenate([quadrant[nx % 2 :][::-1], quadrant])
    return np.concatenate([half[:, ny % 2 :][:, ::-1], half], axis=1)

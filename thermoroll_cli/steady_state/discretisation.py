"""A problem on one grid: its stages, with the solvers and kernels that they share."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.frictional_heat import Heat, divide
from thermoroll_cli.heat.heat_response import ThermalResponse
from thermoroll_cli.numerics.grid import Domain, Grid
from thermoroll_cli.problem.contact import Contact, Pressure, Traction
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.heated_bodies import HeatResponses
from thermoroll_cli.steady_state.pressure import PressureSolver
from thermoroll_cli.steady_state.solver_options import SolverOptions
from thermoroll_cli.steady_state.traction import TractionSolver

KEPT = 0.05
"""Part of its sides by which the domain of a profile's contact may differ from what it would be, before a neighbouring problem
gets one of its own: less than the room at the sides."""


class Discretisation:
    """One problem on one grid.

    `pressure`, `traction` and `responses` solve its stages; they know nothing of the motion, so problems with the same contact
    share them (`for_problem`). Each builds its kernels when they are first needed."""

    def __init__(
        self, derived: DerivedQuantities, shape: tuple[int, int], extent: float, threads: int = 1,
        options: SolverOptions | None = None, followed: Domain | None = None, coarser: Discretisation | None = None,
        neighbour: Discretisation | None = None,
    ) -> None:
        """`followed` is the domain around a heated contact, which may lie anywhere, instead of the one of `extent` semi-axes
        about the isothermal contact. `coarser` is the next coarser grid. `neighbour` is another problem's discretisation, whose
        grid and solvers are used (see `has_kernels_of`)."""
        self.derived, self.extent, self.threads, self.followed = derived, extent, threads, followed
        self.options = options or SolverOptions()
        if neighbour is None:
            self.grid: Grid = derived.grid(shape, extent) if followed is None else Grid.over(shape, *followed)
            self.traction: TractionSolver = TractionSolver(self.grid, derived.coupling_constant, threads, self.options.rolling)
            self.responses: HeatResponses = HeatResponses(self.grid)
        else:
            self.grid, self.traction, self.responses = neighbour.grid, neighbour.traction, neighbour.responses
        if neighbour is not None and _same_contact(neighbour.derived, derived):
            self.pressure: PressureSolver = neighbour.pressure
        else:
            before = neighbour or coarser
            self.pressure = PressureSolver(derived, self.grid, None if followed else extent, self.options,
                                           None if before is None else before.pressure)
        self._heats: list[tuple[Traction, Heat]] = []
        self._transforms_before = 0 if neighbour is None else neighbour._transforms_of_solvers

    def has_kernels_of(self, derived: DerivedQuantities, shape: tuple[int, int], extent: float) -> bool:
        """Whether the grid and the kernels here serve for another problem: same elastic constants, and the same contact without
        heat or, of bodies with profiles, one that lies in this domain nearly as it would in its own."""
        own = self.derived
        return (self.grid.shape == shape and self.extent == extent and own.shear_compliance == derived.shear_compliance
                and own.coupling_constant == derived.coupling_constant
                and own.problem.contact_modulus == derived.problem.contact_modulus
                and (_same_contact(own, derived) or self._fits(derived)))

    def _fits(self, derived: DerivedQuantities) -> bool:
        """Whether the domain is about that of another problem with profiles: it would wander with every small change."""
        if not (self.derived.problem.geometry.has_profile and derived.problem.geometry.has_profile):
            return False
        wanted, grid = derived.scales.domain(self.extent), self.grid
        side_x, side_y = grid.nx * grid.dx, grid.ny * grid.dy
        moved = max(abs(wanted.side_x / side_x - 1.0), abs(wanted.side_y / side_y - 1.0),
                    2.0 * abs(wanted.centre - grid.centre) / side_y)
        return (moved <= KEPT and self.derived.symmetric == derived.symmetric
                and self.derived.scales.limits == derived.scales.limits)

    def for_problem(self, derived: DerivedQuantities) -> Discretisation:
        """Another problem with the solvers of this one (see `has_kernels_of`)."""
        return Discretisation(derived, self.grid.shape, self.extent, self.threads, self.options, self.followed, neighbour=self)

    def has_grid_of(self, other: Discretisation) -> bool:
        """Whether fields here are fields there."""
        return self.grid == other.grid

    @property
    def isothermal_pressure(self) -> Pressure:
        """Pressure on bodies that nothing but their load deforms."""
        return self.pressure.isothermal

    def press(self, offset: Array | None, start: Pressure, tolerance: float) -> Pressure:
        """Contact pressure on bodies whose gap is closed by `offset` (m, (nx, ny)) beforehand: thermal expansion, normal
        displacement by shear (None: nothing). `start` is where the solver begins."""
        if offset is None:
            return self.isothermal_pressure
        mirrored = self.derived.kinematics.mirror_on(self.grid.ny, heated=True) is not None
        return self.pressure.solve(offset, start.start, tolerance, mirrored=mirrored)

    def driving_slip(self, normal: Pressure) -> Array:
        """Slip s/V without any traction, (2, nx, ny): creepage and spin, and −∂u^p/∂x where the bodies stretch differently."""
        rigid = self.derived.kinematics.rigid_slip(self.grid)
        if self.derived.dissimilar:
            rigid -= self.traction.coupling.tangential_gradient(normal.pressure)
        return rigid

    def roll(self, normal: Pressure, start: Traction, tolerance: float, friction: Array | None = None) -> Traction:
        """Tractions and slip under the given pressure, from the tractions of `start`.

        `friction` is the local coefficient (nx, ny), if it is not the same everywhere."""
        rigid = self.driving_slip(normal)
        if self.derived.kinematics.has_traction:
            return self.traction.solve(self.derived, normal, rigid, start, tolerance, friction,
                                       undisturbed=normal is self.isothermal_pressure)
        # Nothing to solve: without friction the surfaces slide freely, without creepage they stick.
        zero, sliding, motion = np.zeros((2, *self.grid.shape)), self.derived.kinematics.moves, self.derived.problem.motion
        slip = rigid * normal.contact if sliding else zero
        return Traction(zero, slip, normal.contact & (not sliding), (motion.creepage_x or 0.0, motion.creepage_y or 0.0),
                        heat=zero[0], heat_slope=zero[0], work=0.0)

    def heat_response(self, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        """Thermal response of both bodies at the given creepages and `slip` s/V (2, nx, ny)."""
        return self.responses.response(self.derived, creepage, slip)

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

    @property
    def transforms(self) -> int:
        """Padded transforms done for this problem by all stages, until another one takes over the solvers."""
        return self._transforms_of_solvers - self._transforms_before

    @property
    def _transforms_of_solvers(self) -> int:
        return self.pressure.transforms + self.traction.transforms + self.responses.transforms


def _same_contact(one: DerivedQuantities, other: DerivedQuantities) -> bool:
    """Whether two problems have the same gap and the same isothermal pressure."""
    if one.problem.geometry.has_profile or other.problem.geometry.has_profile:
        return one.problem.geometry == other.problem.geometry and one.scales == other.scales
    return one.hertz == other.hertz

"""A problem on one grid: its stages, and the solvers and kernels that they share."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import HeatResponses
from thermoroll_cli.one_contact.steady_state.pressure import PressureSolver
from thermoroll_cli.one_contact.steady_state.traction import TractionSolver
from thermoroll_cli.physics.heat.frictional_heat import MISMATCH_TOLERANCE, Heat, divide
from thermoroll_cli.physics.numerics.grid import Domain, Grid
from thermoroll_cli.physics.rolling.rolling_gradient import RollingOptions
from thermoroll_cli.problem.contact import Contact, Pressure, Traction
from thermoroll_cli.problem.surface import edges
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class Tolerances:
    """Relative: residual of the tractions, residual gap over approach, change of the fields that act back on the contact.

    Far below the discretisation error of any grid: a residual r moves forces and heat by r/3 at most."""

    tangential: float = 1e-5
    normal: float = 1e-7
    coupling: float = 3e-6

    def times(self, factor: float) -> Tolerances:
        """All of them looser by `factor`."""
        return Tolerances(factor * self.tangential, factor * self.normal, factor * self.coupling)


@dataclass(frozen=True)
class SolverOptions:
    """Tolerances and variants of the solution of a problem that experiments and the refinement vary; all other numbers are
    constants beside their use."""

    tolerances: Tolerances = Tolerances()
    rolling: RollingOptions = field(default_factory=RollingOptions)
    sequence: bool = True
    """Solve coarser grids first. They give the start, the estimates and the extrapolation."""
    extrapolated: bool = True
    """Extrapolate integrals from the last three grids."""
    most_moves: int = 8
    """Domains tried on one grid to follow a heated contact; iterations on one that proves too small end early."""
    whole_elements: bool = False
    """Hertz's pressure at the centres of whole elements, as in CONTACT, instead of its averages over covered parts."""


class Discretisation:
    """One problem on one grid.

    `pressure`, `traction` and `responses` solve its stages; they depend neither on the motion nor on the problem's `heights`,
    so problems with the same contact share them (`has_kernels_of`). Each builds its kernels when they are first needed."""

    pressure: PressureSolver
    traction: TractionSolver
    responses: HeatResponses
    heights: Array | None
    """Mean heights of the surfaces in each element over their smooth shapes in m, (nx, ny); None of smooth ones."""

    def __init__(
        self, derived: DerivedQuantities, shape: tuple[int, int], extent: float, threads: int = 1,
        options: SolverOptions | None = None, followed: Domain | None = None, coarser: Discretisation | None = None,
        before: Discretisation | None = None,
    ) -> None:
        """`followed` is a domain around a heated contact, at any place; it replaces the one of `extent` semi-axes about the
        isothermal contact. `coarser` is the next coarser grid; `before` the same grid of another problem, whose solvers are
        taken where they serve; else its isothermal pressure predicts this one, and its tables of thermal expansion are kept."""
        self.extent, self.threads, self.followed = extent, threads, followed
        self.options = options or SolverOptions()
        self.grid: Grid = derived.grid(shape, extent) if followed is None else Grid.over(shape, *followed)
        self._exchanged: Array | None = None
        self._ask(derived)
        if before is not None and before.has_kernels_of(derived):
            self.pressure, self.traction, self.responses = before.pressure, before.traction, before.responses
            return
        start = None if before is None else (
            before.isothermal_pressure.start * (derived.scales.peak_pressure / before.derived.scales.peak_pressure))
        self.pressure = PressureSolver(
            derived, self.grid, None if followed else extent, self.options.tolerances.normal,
            whole_elements=self.options.whole_elements, coarser=None if coarser is None else coarser.pressure,
            start=start)
        self.traction = TractionSolver(self.grid, derived.bodies, threads, self.options.rolling)
        self.responses = HeatResponses(self.grid, None if before is None else before.responses.tables)

    def under(self, derived: DerivedQuantities, responses: HeatResponses | None = None) -> Discretisation:
        """The same grid, with its kernels, for another load or motion of the same bodies, with other thermal `responses` if
        given."""
        other = copy.copy(self)
        other._ask(derived)
        other.responses = responses or self.responses
        if not self.has_kernels_of(derived):
            other.pressure = PressureSolver(
                derived, self.grid, None if self.followed else self.extent, self.options.tolerances.normal,
                whole_elements=self.options.whole_elements,
                start=self.isothermal_pressure.start * (derived.scales.peak_pressure / self.derived.scales.peak_pressure))
        return other

    def _ask(self, derived: DerivedQuantities) -> None:
        """Take a problem, of which nothing is solved yet."""
        self.derived = derived
        grid, heights = self.grid, derived.problem.heights
        self.heights = None if heights is None else heights.over(edges(grid.x, grid.dx), edges(grid.y, grid.dy))
        self._heats: WeakKeyDictionary[Traction, tuple[float, Heat]] = WeakKeyDictionary()
        self._rough_pressure: Pressure | None = None

    @property
    def place(self) -> tuple[object, ...]:
        """The grid in Hertz's units: places are equal on grids whose elements correspond, also of different problems."""
        if self.followed is None:
            return self.grid.shape, self.extent
        a, b = self.derived.scales.semi_axis_x, self.derived.scales.semi_axis_y
        units = Domain(a, b, b, a)
        return self.grid.shape, *(round(float(size / unit), 9) for size, unit in zip(self.followed, units, strict=True))

    def has_kernels_of(self, derived: DerivedQuantities) -> bool:
        """True if the solvers also serve another problem on this grid: the same bodies and gap, pressed together in the same
        way to the same isothermal pressure."""
        one, other = ((of.problem.approach is None, of.problem.geometry, of.scales, of.bodies)
                      for of in (self.derived, derived))
        return one == other

    @property
    def isothermal_pressure(self) -> Pressure:
        """Pressure on bodies that only their load deforms."""
        if self.heights is None:
            return self.pressure.isothermal
        if self._rough_pressure is None:
            self._rough_pressure = self.press(None, self.pressure.isothermal, self.options.tolerances.normal)
        return self._rough_pressure

    def press(self, offset: Array | None, start: Pressure, tolerance: float) -> Pressure:
        """Contact pressure on bodies whose gap is closed by the heights of their surfaces and by `offset` (m, (nx, ny))
        beforehand: thermal expansion, normal displacement by shear (None: nothing). `start` is where the solver begins."""
        if self.heights is not None:
            offset = self.heights if offset is None else self.heights + offset
        if offset is None:
            return self.isothermal_pressure
        mirrored = self.derived.kinematics.mirror_on(self.grid.ny, heated=True) is not None
        return self.pressure.solve(offset, start.start, tolerance, mirrored=mirrored)

    def driving_slip(self, normal: Pressure) -> Array:
        """Slip s/V without any traction, (2, nx, ny): creepage and spin, −∂u^p/∂x of bodies that strain differently, and in a
        step over time what the displacements before add."""
        rigid, past = self.derived.kinematics.rigid_slip(self.grid), self.derived.past
        if self.derived.dissimilar and (past is None or past.rolls):
            rigid -= self.traction.coupling.tangential_gradient(normal.pressure)
        if past is not None:
            rigid += past.slip
            if self.derived.dissimilar:
                rigid -= past.rate * self.traction.coupling.tangential_displacement(normal.pressure)
        return rigid

    def roll(self, normal: Pressure, start: Traction, tolerance: float, friction: Array | None = None) -> Traction:
        """Tractions and slip under the given pressure, from the tractions of `start`.

        `friction` is the local coefficient (nx, ny), if it is not the same everywhere."""
        rigid = self.driving_slip(normal)
        if self.derived.kinematics.has_traction:
            return self.traction.solve(self.derived, normal, rigid, start, tolerance, friction,
                                       undisturbed=normal is self.pressure.isothermal)
        # No solution is needed: without friction the surfaces slide freely, without creepage they stick.
        zero, sliding, motion = np.zeros((2, *self.grid.shape)), self.derived.kinematics.moves, self.derived.problem.motion
        slip = rigid * normal.contact if sliding else zero
        return Traction(zero, slip, normal.contact & (not sliding), (motion.creepage_x or 0.0, motion.creepage_y or 0.0),
                        heat=zero[0], heat_slope=zero[0], work=0.0)

    def heat(self, contact: Contact, tolerance: float = MISMATCH_TOLERANCE) -> Heat:
        """The heat of a state, divided between the bodies to `tolerance`. It is kept as long as the tractions that make it, and
        serves again if it was solved to no more than ten times that."""
        tangential = contact.tangential
        solved_to, known = self._heats.get(tangential, (math.inf, None))
        if known is None or solved_to > 10.0 * tolerance:
            response = self.responses.response(self.derived, tangential.creepage, tangential.slip)
            heating, speed = self.derived.problem.heating, self.derived.problem.motion.speed
            known = divide(heating, response, speed * tangential.heat, contact.normal.covered, speed * tangential.heat_slope,
                           self._exchanged, tolerance, self.responses.before)
            self._heats[tangential], self._exchanged = (tolerance, known), known.into.exchanged
        return known

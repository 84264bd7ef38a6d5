"""The steps of a history on one grid.

Material flows towards +x, and at a fixed place of the contact's frame the slip is

    s/V = ξ − ∂u/∂x − (1/V) ∂u/∂t = ξ − ∂u/∂x − ∂u/∂σ

with the distance rolled σ. Each step is a steady problem with D + c in place of D, and what is known of ∂u/∂σ joins the rigid
slip (`Past`):

    after the start or a jump     ∂u/∂σ = (u − u₁)/h                                          c = 1/h
    later                         ∂u/∂σ of the parabola through u, u₁ and u₂                  c = 1/h + 1/(h + k)

with the steps h from u₁ and k from u₂ to u₁: of second order. Without rolling displacements take the place of velocities: with
any length L, s/L = (δ + u₁ − u)/L for the shift δ of the step, which is exact while the direction of slip stays. L over the
time of the step stands for V. u is that of traction and, between unlike bodies, of pressure.

Heat is remembered (`heat_over_time`): the material of both bodies drifts with V ± half the creepage, which is the one given, or
where it is an unknown that of the step before. Their thermal expansion acts back within each step as in the steady state.

Surfaces with heights have moved as the material has. The gap of a step is closed by what stands in the contact at its end.

Energy: the tractions do the `work` ∫ ∬ τ·ξ dσ, of which ½ ∬ τ·u is stored, and the rest becomes heat.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.history.course import Beginning, History, When
from thermoroll_cli.many_contacts.history.kept_steps import NOTHING_KEPT, KeptSteps
from thermoroll_cli.one_contact.refinement.refine import first_guess
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.one_contact.steady_state.fixed_point import HEAT, Learnt, SteadyState, fixed_point
from thermoroll_cli.one_contact.steady_state.heated_bodies import HeatResponses, heated_bodies
from thermoroll_cli.one_contact.steady_state.scalars import reported_state
from thermoroll_cli.physics.heat.heat_over_time import UNMOVED, End, HeatMemory, Place
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatResponse, ThermalResponse
from thermoroll_cli.physics.numerics.convolution import Parities
from thermoroll_cli.physics.numerics.grid import Grid, Prolongation, neighbour_sum
from thermoroll_cli.problem.contact import Contact, Past, Traction
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.surface import Heights, SurfacesInContact
from thermoroll_cli.tools.arrays import Array

MOST_GROWTH = 2.4
"""Ratio of a step to the one before it, up to which the parabola through three states is used: it is stable up to 1 + √2."""


@dataclass(frozen=True)
class Moment(When):
    """One state of a history: the solver's `state` on the grid of `here`, its `reported` form, and of all steps since the last
    moment the `applications` and whether each was solved (`converged`)."""

    here: Discretisation
    state: SteadyState
    reported: State
    applications: int
    converged: bool


class Reached(NamedTuple):
    """The state at the `end` of a step: displacements `u` (2, nx, ny) in m, slip that drives the tractions (`rigid`, over V),
    `work` and `heat` in J since the start, the total `shift` in m, and the mean factor of `friction` that remembers."""

    place: float
    end: End
    distance: float
    contact: Contact
    u: Array
    rigid: Array
    work: float = 0.0
    heat: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    rolls: bool = True
    friction: Array | None = None


class _StepHeat(HeatResponses):
    """The response to the heat of the step that ends `now`, and what heat before it does then."""

    def __init__(self, memory: HeatMemory, now: End) -> None:
        super().__init__(memory.grid)
        self.before, self._own = memory.step(now)

    def response(self, derived: DerivedQuantities, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        return self._own


class Stepper:
    """One contact on one grid, from one state over time to the next: `last` and `before` it are those that it has reached.
    Once it has begun, `interpolated` is the share of the force that was lost between the grid of a state from a file and this
    one, and put back."""

    last: Reached | None = None
    before: Reached | None = None
    interpolated = 0.0

    def __init__(
        self, base: Discretisation, mirror: Parities | None, surfaces: tuple[Heights | None, Heights | None] = (None, None)
    ) -> None:
        """`base` has the grid, and the kernels of all states; `mirror` is the symmetry that all have, `surfaces` are those of
        the lower and of the upper body."""
        self.base, self.mirror, self.hot, self.surfaces = base, mirror, False, surfaces
        self.memory: HeatMemory | None = None
        problem = base.derived.problem
        if problem.heating.heat:
            bodies = heated_bodies(problem, 0.0, 0.0)
            self.hot = bool(problem.heating.deformation) and any(body.free_expansion for body in bodies)
            self.memory = HeatMemory(base.grid, bodies, expands=self.hot)

    def solved(self, here: Discretisation) -> SteadyState:
        """The solution of the step `here`, from the last state. Secants of the step before would not save iterations, and a
        history that goes on after a crash would not have them."""
        assert self.last is not None
        guess = first_guess(here, self.last.contact, hot=self.hot)
        if here.heights is not None:
            # Spots come, go and change their load with every step: tractions keep their share of it.
            normal = here.press(guess.offset, guess.normal, self.base.options.tolerances.normal)
            shares = _shares(guess)
            guess = replace(guess, normal=normal, tangential=Traction.guess(
                shares * normal.pressure, guess.tangential.creepage))
        return fixed_point(here, guess, self.base.options.tolerances, learnt=Learnt(HEAT.first_residual))

    def remember(
        self, here: Discretisation, contact: Contact, now: End, heat: DividedHeat | None = None, *, always: bool = False
    ) -> DividedHeat | None:
        """Remember the `heat` of a step, or without it that of its `contact`, which may have been the same at all times
        before; it is returned, None without any."""
        if self.memory is None:
            return None
        now = _seen_by_heat(now, here.derived.problem)
        if heat is None:
            found = here.heat(contact)
            assert isinstance(found.response, HeatResponse)
            heat = replace(found.into, slope=found.response.changes(found.into))
        self.memory.add(heat, now, heated_bodies(here.derived.problem, *contact.tangential.creepage) if always else None)
        return heat

    # --- the beginning -----------------------------------------------------------------------------------------------

    def begin(
        self, problem: Problem, begin: Beginning | State, moved: tuple[Place, Place] = UNMOVED
    ) -> tuple[Discretisation, SteadyState]:
        """The state of `problem` to begin with: the steady one, one without tractions, or one with those of a state. Surfaces
        stand where the bodies have `moved`; in a steady state they stay there."""
        problem = self._with_surfaces(problem, moved)
        here, tolerances = self.base.under(DerivedQuantities(problem)), self.base.options.tolerances
        mirror = None if isinstance(begin, State) else here.derived.kinematics.mirror_on(
            here.grid.ny, heated=problem.friction_varies or self.hot)
        # Displacements are needed wherever a later contact may be.
        here.traction.window_around(np.ones(here.grid.shape, dtype=bool), mirror)
        guess = first_guess(here, None, hot=False)
        if begin == "steady":
            cold = fixed_point(here, guess, tolerances)
            return here, cold if not self.hot else fixed_point(here, first_guess(here, cold.contact, hot=True), tolerances)
        nothing = np.zeros((2, *here.grid.shape))
        past = Past(1.0 / here.grid.dx, nothing, self.mirror, rolls=False)
        # Nothing rubs yet, and no heat flows.
        problem = replace(problem, heating=replace(problem.heating, partition=0.5))
        here = here.under(DerivedQuantities(self._still(problem, (0.0, 0.0), here.grid, 1.0), past))
        normal = here.isothermal_pressure
        traction, hardening = (nothing, nothing[0]) if begin == "pressed" else self._carried(begin, here, normal.pressure)
        if isinstance(begin, State) and here.derived.dissimilar and np.size(begin.fields["pressure"]) == normal.pressure.size:
            # The surfaces of unlike bodies lie where the pressure of that state, which its shear has changed, has moved them.
            pressure = np.reshape(begin.fields["pressure"], here.grid.shape)
            normal = replace(normal, pressure=pressure, covered=(pressure > 0.0).astype(float))
        contact = Contact(normal, Traction(
            traction, nothing, normal.contact, (0.0, 0.0), nothing[0], nothing[0], 0.0, hardening=hardening))
        return here, SteadyState(contact, 0, 0.0, True, 0, 0, 0, False, ())

    def _carried(self, state: State, here: Discretisation, pressure: Array) -> tuple[Array, Array]:
        """Tractions of a state on this grid, (2, nx, ny) in Pa, and by how much the yield stress of its interlayer has grown.
        Raises Unsolvable for those of a contact of another kind."""
        sizes = [(len(places), len(places) * float(places[1] - places[0]), float(places.mean()))
                 for places in (state.x, state.y) if places.size]
        line = len(sizes) == 1
        if line != here.derived.problem.line:
            raise Unsolvable("the state to begin with is " + ("one" if line else "not one") + " of a line contact",
                             "history.begin", '"steady", "pressed", or the result file of such a contact')
        (nx, length, centre_x), (ny, width, centre) = (*sizes, (1, math.inf, 0.0))[:2]
        source = Grid(nx, 1, length / nx, math.inf, 0.0, centre_x) if line else Grid.over(
            (nx, ny), length, width, centre, centre_x)
        fields = {name: np.reshape(values, source.shape) for name, values in state.fields.items()}
        traction = np.stack([fields["shear_x"], fields["shear_y"]])
        yields = np.asarray(fields.get("yield_stress", np.zeros(source.shape)))
        hardening = np.where(yields > 0.0, yields - (here.derived.problem.interlayer.yield_stress or 0.0), 0.0)
        if source.shape == here.grid.shape and np.allclose(
                (*source.x, *source.y), (*here.grid.x, *here.grid.y), rtol=1e-9, atol=0.0):
            return traction, hardening
        carry = Prolongation(source, here.grid)
        carried = carry.traction(traction, fields["pressure"], pressure)
        # Interpolation rounds off tractions where stick ends. What is missing of the force goes where friction leaves room.
        force = traction.sum(axis=(1, 2)) * source.element_area
        missing = force - carried.sum(axis=(1, 2)) * here.grid.element_area
        friction = here.derived.problem.friction
        bound = friction.coefficient * friction.mean_share(here.grid.y, here.grid.dy) * pressure
        room = np.maximum(bound - np.hypot(*carried), 0.0)
        most = max(float(room.sum()) * here.grid.element_area, float(np.hypot(*missing)))
        if most > 0.0:
            carried = carried + np.multiply.outer(missing / most, room)
            self.interpolated = float(np.hypot(*missing) / max(np.hypot(*force), np.hypot(*missing)))
        return carried, carry.from_inside(hardening)

    # --- one step ----------------------------------------------------------------------------------------------------

    def step(
        self, problem: Problem, time: float, distance: float, shift: Place = (0.0, 0.0), *, jumps: bool = False,
        heats: bool = True
    ) -> tuple[Discretisation, End]:
        """The step that ends with `problem`, with its past and, if it `heats`, its heat before; at its beginning the inputs may
        have jumped (`jumps`)."""
        grid, last, before = self.base.grid, self.last, None if jumps else self.before
        assert last is not None
        step = distance - last.distance
        if step == 0.0:
            moved = shift[0] - last.shift[0], shift[1] - last.shift[1]
            problem = self._still(problem, moved, grid, time - last.end.time)
            past = Past(1.0 / grid.dx, last.u / grid.dx, self.mirror, rolls=False, friction=last.friction)
        elif before is None or not last.rolls or not 0.0 < step <= MOST_GROWTH * (last.distance - before.distance):
            past = Past(1.0 / step, last.u / step, self.mirror, friction=last.friction)
        else:
            k = last.distance - before.distance
            one, two, rate = (step + k) / (step * k), step / (k * (step + k)), 1.0 / step + 1.0 / (step + k)
            friction = None if last.friction is None or before.friction is None else (
                last.friction * (one / rate) - before.friction * (two / rate))
            past = Past(rate, last.u * one - before.u * two, self.mirror, friction=friction)
        # Surfaces stand still in the state at the beginning: its rates are not those after it.
        constant = jumps or not past.rolls or not last.rolls or (self.before is None and any(self.surfaces))
        now = End(time, self._moved(problem, step, last, constant=constant), constant)
        ends = _seen_by_heat(now, problem)
        if self.memory is not None and not heats:
            self.memory.pass_by(ends)
        heat = _StepHeat(self.memory, ends) if self.memory is not None and heats else None
        return self.base.under(DerivedQuantities(self._with_surfaces(problem, now.moved), past), heat), now

    def _with_surfaces(self, problem: Problem, moved: tuple[Place, Place]) -> Problem:
        """`problem` with the heights that stand in the contact where the bodies have `moved`."""
        there = tuple((surface, place) for surface, place in zip(self.surfaces, moved, strict=True) if surface is not None)
        return replace(problem, heights=SurfacesInContact(there)) if there else problem

    def _moved(self, problem: Problem, step: float, last: Reached, *, constant: bool) -> tuple[Place, Place]:
        """How far the material of both bodies has moved at the end of a step over the distance `step`."""
        motion, (lower, upper) = problem.motion, last.end.moved
        creepages = []
        for given, found in zip((motion.creepage_x, motion.creepage_y), last.contact.tangential.creepage, strict=True):
            known = found if last.rolls == bool(step) else 0.0
            creepages.append(known if given is None else given if constant else 0.5 * (given + found))
        along, across = (0.5 * creepage * (step or self.base.grid.dx) for creepage in creepages)
        return (lower[0] + step + along, lower[1] + across), (upper[0] + step - along, upper[1] - across)

    @staticmethod
    def _still(problem: Problem, shift: tuple[float, float], grid: Grid, time: float) -> Problem:
        """`problem` without rolling: the length of an element over the `time` of the step stands for the speed."""
        motion = problem.motion
        return replace(problem, motion=replace(
            motion, speed=grid.dx / time, spin=0.0, differential_slip=False, at="origin",
            creepage_x=None if motion.force_x is not None else shift[0] / grid.dx,
            creepage_y=None if motion.force_y is not None else shift[1] / grid.dx))

    def reach(
        self, here: Discretisation, contact: Contact, place: float, now: End, distance: float, shift: Place = (0.0, 0.0)
    ) -> None:
        """Take the end of a step as the last state, with the energies since the one before: by the trapezoidal rule, but of
        inputs that have jumped, and of heat without rolling, which is that of the bound, by their values at the end."""
        last = self.last
        rigid, tangential = here.derived.kinematics.rigid_slip(here.grid), contact.tangential
        motion = here.derived.problem.motion
        for i, force in enumerate((motion.force_x, motion.force_y)):
            if force is not None:
                rigid[i] += tangential.creepage[i]
        u = here.traction.displacement(here.derived, tangential)
        if here.derived.dissimilar:
            u = u + here.traction.coupling.tangential_displacement(contact.normal.pressure)
        rolls = here.derived.past is None or here.derived.past.rolls
        work = heat = 0.0
        if last is not None:
            step = distance - last.distance
            if not rolls:
                step = here.grid.dx
                shift = last.shift[0] + tangential.creepage[0] * step, last.shift[1] + tangential.creepage[1] * step
            mean = rigid if now.constant else 0.5 * (rigid + last.rigid)
            rate = tangential.work if now.constant else 0.5 * (tangential.work + last.contact.tangential.work)
            done = 0.5 * float(((tangential.traction + last.contact.tangential.traction) * mean).sum()) * here.grid.element_area
            work, heat = last.work + done * step, last.heat + rate * step
        self.before, self.last = last, Reached(
            place, now, distance, contact, u, rigid, work, heat, shift, rolls, _friction_factor(here, contact))

    def reported(self, here: Discretisation, state: SteadyState) -> State:
        """What is reported of the last state."""
        reached = self.last
        assert reached is not None
        reported = reported_state(here, state.contact, heated=self.memory is not None)
        tangential = state.contact.tangential
        stored = 0.5 * float((tangential.traction * here.traction.displacement(here.derived, tangential)).sum())
        # Work and the heat of a step differ by what is stored. What is conducted depends on what has flowed before.
        scalars = {**reported.scalars, "elastic_energy_J": stored * here.grid.element_area, "work_J": reached.work,
                   "heat_J": reached.heat, "shift_x_um": 1e6 * reached.shift[0], "shift_y_um": 1e6 * reached.shift[1],
                   "power_balance_error": math.nan, "heat_conducted_W": math.nan}
        # It is the power of an expansion that moves with the contact, as in a steady state.
        scalars.pop("expansion_power_W", None)
        if here.heights is not None:
            reported = replace(reported, fields={**reported.fields, "surface_height": here.heights})
            scalars |= {"contact_spots": float(reported.spots),
                        "pressure_max_smooth_MPa": 1e-6 * here.pressure.isothermal.peak}
            scalars |= {f"surface_{body}_{axis}_mm": 1e3 * place
                        for body, surface, moved in zip(BODIES, self.surfaces, reached.end.moved, strict=True)
                        if surface is not None for axis, place in zip("xy", moved, strict=True)}
        if not reached.rolls:
            # Over a distance rolled there is nothing.
            scalars |= dict.fromkeys(("creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm", "T_gamma_N",
                                      "T_gamma_without_spin_N"), math.nan)
        return replace(reported, scalars=scalars)


class Steps:
    """A history on a grid of `shape` elements over `extent` half-lengths of the contact of its largest load (None: that of the
    problem)."""

    def __init__(
        self, history: History, shape: tuple[int, int], options: SolverOptions | None = None, threads: int = 1,
        extent: float | None = None,
    ) -> None:
        self.history, derived = history, DerivedQuantities(history.largest)
        base = Discretisation(derived, shape, extent or derived.problem.numerics.extent, threads, options)
        self.stepper = Stepper(base, None, history.surfaces)
        # Nothing is known of the symmetry of tractions that are given, nor of surfaces.
        if not isinstance(history.course.begin, Result) and not any(history.surfaces):
            self.stepper.mirror = DerivedQuantities(history.most).kinematics.mirror_on(
                shape[1], heated=derived.problem.friction_varies or self.stepper.hot)

    def moments(self, rows: Array, kept: KeptSteps = NOTHING_KEPT) -> Iterator[Moment]:
        """The states at the places `rows`, with further steps to the `stops` between them. The beginning, the last step, and
        those that are not `kept` are solved."""
        history, course, stepper = self.history, self.history.course, self.stepper
        stops = history.with_stops(rows)
        ends = zip(stops.tolist(), *(each.tolist() for each in history.clock(stops)), strict=True)
        work, solved = 0, True
        for number, (stop, time, distance) in enumerate(ends):
            known, problem, shift = None, history.problem_at(stop), history.shift_at(stop)
            if stepper.last is None:
                now, begin = End(time, history.begins_at(distance)), course.begin
                here, state = stepper.begin(problem, begin.coupled if isinstance(begin, Result) else begin, now.moved)
            else:
                known = kept.find(number, here.grid) if stop < rows[-1] else None
                here, now = stepper.step(problem, time, distance, shift, jumps=stepper.last.place in course.jumps,
                                         heats=known is None)
                state = known.state if known is not None else stepper.solved(here)
            work, solved = work + state.applications, solved and state.converged
            stepper.reach(here, state.contact, stop, now, distance, shift)
            heat = stepper.remember(here, state.contact, now, None if known is None else known.heat,
                                    always=number == 0 and course.begin == "steady")
            if known is not None:
                reported: State | None = State(known.fields, known.scalars, here.grid.x, here.grid.y)
            else:
                reported = stepper.reported(here, state) if stop in rows else None
                if number:
                    kept.keep(number, state, heat, reported, whole=stop in course.places_of_fields)
            if reported is not None and stop in rows:
                yield Moment(stop, time, distance, here, state, reported, work,
                             solved and state.contact.tangential.converged)
                work, solved = 0, True


def _shares(contact: Contact) -> Array:
    """Tractions over the pressure, (2, nx, ny); beside the contact the mean of the elements around."""
    pressure = contact.normal.pressure
    there = pressure > 0.0
    shares = np.where(there, contact.tangential.traction / np.where(there, pressure, 1.0), 0.0)
    count = neighbour_sum(there.astype(float))
    around = np.stack([neighbour_sum(share) for share in shares]) / np.where(count > 0.0, count, 1.0)
    return np.asarray(np.where(there, shares, around))


def _seen_by_heat(end: End, problem: Problem) -> End:
    """`end` for heat, whose material may be asked not to move."""
    return end if problem.heating.peclet == "rolling" else end._replace(moved=UNMOVED)


def _friction_factor(here: Discretisation, contact: Contact) -> Array | None:
    """The factor of friction with memory, (nx, ny), where there is no contact that of new material, or the growth of a yield
    stress in Pa; None without memory."""
    friction = here.derived.problem.friction
    if here.derived.problem.interlayer.hardens:
        hardening = contact.tangential.hardening
        return np.zeros(here.grid.shape) if hardening is None else hardening
    if friction.law is None or friction.law.memory == 0.0:
        return None
    factor, local = np.full(here.grid.shape, friction.law.at_rest), contact.tangential.friction
    if local is not None:
        scale = friction.coefficient if contact.friction is None else contact.friction
        scale = scale * friction.mean_share(here.grid.y, here.grid.dy)
        np.divide(local, scale, out=factor, where=contact.normal.pressure > 0.0)
    return factor

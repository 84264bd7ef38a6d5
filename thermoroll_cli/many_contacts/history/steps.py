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

Energy: the tractions do the `work` ∫ ∬ τ·ξ dσ, of which ½ ∬ τ·u is stored, and the rest becomes heat.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.many_contacts.history.kept_steps import NOTHING_KEPT, KeptSteps
from thermoroll_cli.one_contact.refinement.refine import first_guess
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.one_contact.steady_state.fixed_point import HEAT, Learnt, SteadyState, fixed_point
from thermoroll_cli.one_contact.steady_state.heated_bodies import HeatResponses, heated_bodies
from thermoroll_cli.one_contact.steady_state.scalars import reported_state
from thermoroll_cli.physics.heat.heat_over_time import End, HeatMemory, Place
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatResponse, ThermalResponse
from thermoroll_cli.physics.numerics.grid import Grid, Prolongation
from thermoroll_cli.problem.contact import Contact, Past, Traction
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.tools.arrays import Array

MOST_GROWTH = 2.4
"""Ratio of a step to the one before it, up to which the parabola through three states is used: it is stable up to 1 + √2."""


@dataclass(frozen=True)
class Moment:
    """One state of a history: its `place` in the course, `time` in s, `distance` rolled in m, the solver's `state` on the grid
    of `here`, its `reported` form, and of all steps since the last moment the `applications` and whether each was solved
    (`converged`)."""

    place: float
    time: float
    distance: float
    here: Discretisation
    state: SteadyState
    reported: State
    applications: int
    converged: bool


@dataclass(frozen=True)
class _Reached:
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


class Steps:
    """A history on a grid of `shape` elements over `extent` half-lengths of the contact of its largest load (None: that of the
    problem)."""

    def __init__(
        self, history: History, shape: tuple[int, int], options: SolverOptions | None = None, threads: int = 1,
        extent: float | None = None,
    ) -> None:
        self.history, self._options = history, options or SolverOptions()
        derived = DerivedQuantities(history.largest)
        self._base = Discretisation(derived, shape, extent or derived.problem.numerics.extent, threads, self._options)
        # Nothing is known of the symmetry of tractions that are given.
        given = isinstance(history.course.begin, Result)
        problem, self._hot = derived.problem, False
        self._memory: HeatMemory | None = None
        if problem.heating.heat:
            bodies = heated_bodies(problem, 0.0, 0.0)
            self._hot = bool(problem.heating.deformation) and any(body.free_expansion for body in bodies)
            self._memory = HeatMemory(self._base.grid, bodies, expands=self._hot)
        self._mirror = None if given else DerivedQuantities(history.most).kinematics.mirror_on(
            shape[1], heated=problem.friction_varies or self._hot)

    def moments(self, rows: Array, kept: KeptSteps = NOTHING_KEPT) -> Iterator[Moment]:
        """The states at the places `rows`, with further steps to the `stops` between them. The beginning, the last step, and
        those that are not `kept` are solved."""
        course = self.history.course
        stops = self.history.with_stops(rows)
        times, distances = self.history.clock(stops)
        here, state = self._begin(float(rows[0]))
        reached = self._arrived(here, state.contact, float(stops[0]), float(times[0]), float(distances[0]))
        heat = self._released(here, state.contact)
        if self._memory is not None and heat is not None:
            bodies = heated_bodies(here.derived.problem, *state.contact.tangential.creepage)
            self._memory.add(heat, reached.end, bodies if course.begin == "steady" else None)
        yield _moment(here, state, reached, self._reported(here, state, reached), state.applications, converged=state.converged)
        before: _Reached | None = None
        work, solved = 0, True
        ends = zip(stops[1:].tolist(), times[1:].tolist(), distances[1:].tolist(), strict=True)
        for number, (stop, time, distance) in enumerate(ends, 1):
            known = kept.find(number, here.grid) if stop < rows[-1] else None
            jumps = reached.place in course.jumps
            here, now = self._here(stop, time, distance, reached, None if jumps else before, jumps=jumps, heats=known is None)
            state = known.state if known is not None else fixed_point(
                here, first_guess(here, reached.contact, hot=self._hot), self._options.tolerances,
                learnt=Learnt(HEAT.first_residual, state.secants))
            work, solved = work + state.applications, solved and state.converged
            before, reached = reached, self._after(here, state.contact, stop, now, distance, reached)
            heat = known.heat if known is not None else self._released(here, state.contact)
            if self._memory is not None and heat is not None:
                self._memory.add(heat, now)
            if known is not None:
                reported: State | None = State(known.fields, known.scalars, here.grid.x, here.grid.y)
            else:
                reported = self._reported(here, state, reached) if stop in rows else None
                kept.keep(number, state, heat, reported, whole=stop in course.places_of_fields)
            if reported is not None and stop in rows:
                yield _moment(here, state, reached, reported, work, converged=solved)
                work, solved = 0, True

    # --- the beginning -----------------------------------------------------------------------------------------------

    def _begin(self, place: float) -> tuple[Discretisation, SteadyState]:
        """The state that the history begins with: the steady one, or tractions that are given."""
        begin, problem = self.history.course.begin, self.history.problem_at(place)
        here = self._base.under(DerivedQuantities(problem))
        mirror = None if isinstance(begin, Result) else here.derived.kinematics.mirror_on(
            here.grid.ny, heated=problem.friction_varies or self._hot)
        # Displacements are needed wherever a later contact may be.
        here.traction.window_around(np.ones(here.grid.shape, dtype=bool), mirror, here.derived)
        guess = first_guess(here, None, hot=False)
        if begin == "steady":
            cold = fixed_point(here, guess, self._options.tolerances)
            return here, cold if not self._hot else fixed_point(
                here, first_guess(here, cold.contact, hot=True), self._options.tolerances)
        nothing = np.zeros((2, *here.grid.shape))
        past = Past(1.0 / here.grid.dx, nothing, self._mirror, rolls=False)
        # Nothing rubs yet, and no heat flows.
        problem = replace(problem, heating=replace(problem.heating, partition=0.5))
        here = here.under(DerivedQuantities(self._still(problem, (0.0, 0.0), here.grid, 1.0), past))
        normal = here.isothermal_pressure
        traction, hardening = (nothing, nothing[0]) if begin == "pressed" else _carried(begin, here, normal.pressure)
        contact = Contact(normal, Traction(
            traction, nothing, normal.contact, (0.0, 0.0), nothing[0], nothing[0], 0.0, hardening=hardening))
        return here, SteadyState(contact, 0, 0.0, True, 0, 0, 0, False, ())

    # --- one step ----------------------------------------------------------------------------------------------------

    def _here(
        self, place: float, time: float, distance: float, last: _Reached, before: _Reached | None, *, jumps: bool, heats: bool
    ) -> tuple[Discretisation, End]:
        """The problem of the step that ends at `place`, with its past and, if it `heats`, its heat before."""
        problem, grid, step = self.history.problem_at(place), self._base.grid, distance - last.distance
        if step == 0.0:
            shift = self.history.shift_at(place)
            moved = shift[0] - last.shift[0], shift[1] - last.shift[1]
            problem = self._still(problem, moved, grid, time - last.end.time)
            past = Past(1.0 / grid.dx, last.u / grid.dx, self._mirror, rolls=False, friction=last.friction)
        elif before is None or not last.rolls or not 0.0 < step <= MOST_GROWTH * (last.distance - before.distance):
            past = Past(1.0 / step, last.u / step, self._mirror, friction=last.friction)
        else:
            k = last.distance - before.distance
            one, two, rate = (step + k) / (step * k), step / (k * (step + k)), 1.0 / step + 1.0 / (step + k)
            friction = None if last.friction is None or before.friction is None else (
                last.friction * (one / rate) - before.friction * (two / rate))
            past = Past(rate, last.u * one - before.u * two, self._mirror, friction=friction)
        constant = jumps or not past.rolls or not last.rolls
        now = End(time, self._moved(problem, step, last, constant=constant), constant)
        heat = _StepHeat(self._memory, now) if self._memory is not None and heats else None
        return self._base.under(DerivedQuantities(problem, past), heat), now

    def _moved(self, problem: Problem, step: float, last: _Reached, *, constant: bool) -> tuple[Place, Place]:
        """How far the material of both bodies has moved at the end of a step over the distance `step`."""
        motion, (lower, upper) = problem.motion, last.end.moved
        if problem.heating.peclet != "rolling":
            return lower, upper
        creepages = []
        for given, found in zip((motion.creepage_x, motion.creepage_y), last.contact.tangential.creepage, strict=True):
            known = found if last.rolls == bool(step) else 0.0
            creepages.append(known if given is None else given if constant else 0.5 * (given + found))
        along, across = (0.5 * creepage * (step or self._base.grid.dx) for creepage in creepages)
        return (lower[0] + step + along, lower[1] + across), (upper[0] + step - along, upper[1] - across)

    @staticmethod
    def _still(problem: Problem, shift: tuple[float, float], grid: Grid, time: float) -> Problem:
        """`problem` without rolling: the length of an element over the `time` of the step stands for the speed."""
        motion = problem.motion
        return replace(problem, motion=replace(
            motion, speed=grid.dx / time, spin=0.0, differential_slip=False, at="origin",
            creepage_x=None if motion.force_x is not None else shift[0] / grid.dx,
            creepage_y=None if motion.force_y is not None else shift[1] / grid.dx))

    def _arrived(self, here: Discretisation, contact: Contact, place: float, time: float, distance: float) -> _Reached:
        """What the steps begin from."""
        past = here.derived.past
        return _Reached(place, End(time, ((0.0, 0.0), (0.0, 0.0))), distance, contact, self._displacement(here, contact),
                        _rigid(here, contact), shift=self.history.shift_at(place), rolls=past is None or past.rolls,
                        friction=_friction_factor(here, contact))

    def _after(
        self, here: Discretisation, contact: Contact, place: float, now: End, distance: float, last: _Reached
    ) -> _Reached:
        """The end of a step, with the energies since the last one: by the trapezoidal rule, but of inputs that have jumped, and
        of heat without rolling, which is that of the bound, by their values at the end."""
        past, area = here.derived.past, here.grid.element_area
        assert past is not None
        rigid, traction, step = _rigid(here, contact), contact.tangential.traction, distance - last.distance
        shift = self.history.shift_at(place)
        if not past.rolls:
            step = here.grid.dx
            found = contact.tangential.creepage
            shift = last.shift[0] + found[0] * step, last.shift[1] + found[1] * step
        mean = rigid if now.constant else 0.5 * (rigid + last.rigid)
        rate = contact.tangential.work if now.constant else 0.5 * (contact.tangential.work + last.contact.tangential.work)
        work = 0.5 * float(((traction + last.contact.tangential.traction) * mean).sum()) * area
        return _Reached(place, now, distance, contact, self._displacement(here, contact), rigid, last.work + work * step,
                        last.heat + rate * step, shift, past.rolls, _friction_factor(here, contact))

    @staticmethod
    def _displacement(here: Discretisation, contact: Contact) -> Array:
        """u in m, (2, nx, ny), of traction and, between unlike bodies, of pressure."""
        u = here.traction.displacement(here.derived, contact.tangential)
        if here.derived.dissimilar:
            u = u + here.traction.coupling.tangential_displacement(contact.normal.pressure)
        return u

    def _released(self, here: Discretisation, contact: Contact) -> DividedHeat | None:
        """The heat of a state with its slopes; None where heat is not computed."""
        if self._memory is None:
            return None
        heat = here.heat(contact)
        assert isinstance(heat.response, HeatResponse)
        return replace(heat.into, slope=heat.response.changes(heat.into))

    def _reported(self, here: Discretisation, state: SteadyState, reached: _Reached) -> State:
        reported = reported_state(here, state.contact, heated=self._memory is not None)
        tangential = state.contact.tangential
        stored = 0.5 * float((tangential.traction * here.traction.displacement(here.derived, tangential)).sum())
        # Work and the heat of a step differ by what is stored. What is conducted depends on what has flowed before.
        scalars = {**reported.scalars, "elastic_energy_J": stored * here.grid.element_area, "work_J": reached.work,
                   "heat_J": reached.heat, "shift_x_um": 1e6 * reached.shift[0], "shift_y_um": 1e6 * reached.shift[1],
                   "power_balance_error": math.nan, "heat_conducted_W": math.nan}
        if not reached.rolls:
            # Over a distance rolled there is nothing.
            scalars |= dict.fromkeys(("creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm", "T_gamma_N",
                                      "T_gamma_without_spin_N"), math.nan)
        return replace(reported, scalars=scalars)


def _moment(
    here: Discretisation, state: SteadyState, reached: _Reached, reported: State, applications: int, *, converged: bool
) -> Moment:
    return Moment(reached.place, reached.end.time, reached.distance, here, state, reported, applications,
                  converged and state.contact.tangential.converged)


def _rigid(here: Discretisation, contact: Contact) -> Array:
    """Slip of the bodies far away over V, (2, nx, ny), with the creepages that were found."""
    rigid, motion = here.derived.kinematics.rigid_slip(here.grid), here.derived.problem.motion
    for i, force in enumerate((motion.force_x, motion.force_y)):
        if force is not None:
            rigid[i] += contact.tangential.creepage[i]
    return rigid


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


def _carried(result: Result, here: Discretisation, pressure: Array) -> tuple[Array, Array]:
    """Tractions of a result on this grid, (2, nx, ny) in Pa, and by how much the yield stress of its interlayer has grown.
    Raises Unsolvable for those of a contact of another kind."""
    source, line = _grid_of(result), here.derived.problem.line
    if math.isinf(source.dy) != line:
        raise Unsolvable("the state to begin with is " + ("not one" if line else "one") + " of a line contact", "history.begin",
                         '"steady", "pressed", or the result file of such a contact')
    fields = {name: np.reshape(values, source.shape) for name, values in result.fields.items()}
    traction = np.stack([fields["shear_x"], fields["shear_y"]])
    alike = source.shape == here.grid.shape and np.allclose(
        (*source.x, *source.y), (*here.grid.x, *here.grid.y), rtol=1e-9, atol=0.0)
    yields = np.asarray(fields.get("yield_stress", np.zeros(source.shape)))
    hardening = np.where(yields > 0.0, yields - (here.derived.problem.interlayer.yield_stress or 0.0), 0.0)
    if alike:
        return traction, hardening
    carry = Prolongation(source, here.grid)
    return carry.traction(traction, fields["pressure"], pressure), carry.from_inside(hardening)


def _grid_of(result: Result) -> Grid:
    """The grid of a result's fields."""
    steps = [float(places[1] - places[0]) for places in (result.x, result.y) if places.size]
    if len(steps) == 1:
        return Grid(len(result.x), 1, steps[0], math.inf, 0.0, float(result.x.mean()))
    return Grid.over((len(result.x), len(result.y)), len(result.x) * steps[0], len(result.y) * steps[1],
                     float(result.y.mean()), float(result.x.mean()))

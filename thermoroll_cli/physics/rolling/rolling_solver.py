"""Steady rolling with Coulomb friction: semismooth Newton on the slip equation itself (Eqs. 7–11).

On every contact element the traction τ and the slip s = ξ − ∂u/∂x satisfy τ = Proj(τ + ρ s), with the projection onto the disk
|τ| ≤ μp. The element sticks if τ + ρ s lies inside and slips along τ if it lies outside. The slip equation itself is
discretised, so f(y), g(y) of the article's Eq. 12 are not needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from thermoroll_cli.physics.rolling.hardening import Hardening
from thermoroll_cli.physics.rolling.newton import Iterate, Newton, TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient, RollingOptions
from thermoroll_cli.physics.rolling.slip_friction import SlipFriction
from thermoroll_cli.physics.rolling.stick_inverse import StickInverse
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

MOST_NEWTON_STEPS = 40
LOOSEST_FORCING = 0.1
"""Largest relative residual of the linear system of a Newton step."""
FORCING_SHARE = 0.9
"""Share of the square of the last gain to which the next step is solved (Eisenstat & Walker 1996, choice 2)."""
FIRST_SHARE = 1e4
"""Relative residual of the first step over the square of the residual of a start: a good start may need no other step. With it
steps of wear need a fifth fewer Newton steps, other neighbours a twentieth fewer."""
SLOW_REDUCTION = 0.6
"""Ratio of residuals above which a Newton step may only have moved false slip downstream; false slip is then searched for."""
HELPFUL_REDUCTION = 0.95
"""Ratio of residuals below which a step without false slip is followed by another one."""
STICK_FORCING = 1e-2
"""Relative residual of the linear problem of full stick, which is only a start."""
FULL_STICK_BOUND = 1e8
"""Factor of the traction bound at which nothing slips."""
LARGEST_REFINED_RESIDUAL = 1e-2
"""Residuals that grow when recomputed, but not beyond this, are reduced by further steps."""
OTHER_RELAXATION = 0.25
"""Factor of ρ with which a search goes on that has stopped: the residual then has other minima, and the same zeros."""

Start = tuple[Array, tuple[float, float]]
Finished = tuple[Iterate, AnyArray, AnyArray, float, AnyArray]
"""The last iterate, its slip, its lost power, that lost inside the bodies, and its displacement: see `Newton.finish`."""

MOST_BISECTIONS = 100
"""Creepages tried to meet a force."""
MOST_FRICTION_ITERATIONS = 60
"""Solutions with given coefficients of friction after which the fixed point is given up; 12 to 21 are usual."""
FRICTION_SETTLED = 1e-5
"""Mean change of the friction factor over the contact at which its fixed point is accepted."""


@dataclass(frozen=True)
class TangentialSolution:
    """`traction` in Pa and relative `slip` s/V, both (2, n, m); `stick` marks sticking elements; `creepage` holds what was
    solved for (0 where it was given). `lost` is the power per area and speed, in Pa, that the discretisation dissipates in
    each element (upstream difference and border compliance); `hysteresis` is the sum, in Pa, of the power that is lost inside
    bodies that relax. `displacement` is u = A τ in m, (2, n, m). `residual` is |τ − Proj(τ + ρ s)| over the expected tractions,
    both in the 2-norm. `bound` is the largest traction, in Pa, with the friction at this slip, `hardening` the growth of
    the interlayer's yield stress in Pa, (n, m); None if it does not change."""

    traction: Array
    slip: Array
    lost: Array
    stick: Mask
    creepage: tuple[float, float]
    residual: float
    newton_steps: int
    applications: int
    converged: bool
    bound: Array
    displacement: Array
    hardening: Array | None = None
    hysteresis: float = 0.0
    history: tuple[float, ...] = field(default=())


class RollingSolver:
    """Tangential solver for one bounding box and grid: keeps kernels and plans between solves."""

    def __init__(self, gradient: RollingGradient, options: RollingOptions | None = None) -> None:
        self.gradient = gradient
        self.options = options or RollingOptions()
        self._inverse = StickInverse(gradient.shape, gradient.dx, gradient.dy, gradient.bodies, gradient.mirror,
                                     gradient.weights, gradient.rate)

    def solve(self, problem: TangentialProblem, starts: Sequence[Start], tolerance: float = 1e-6) -> TangentialSolution:
        """Solve from the best of `starts`: tractions (2, n, m) and, if forces are given, the creepages to begin from.

        Without a start, or if that start fails, Newton begins from the tractions of full stick cut down to the bound. From
        other starts rows may slip falsely inside the stick area, alternating in y: such rows hardly change the slip, so the
        iteration does not correct them."""
        before, friction = self.gradient.applications, problem.slip_friction
        history: list[float] = []
        newton, finished = self._newton(problem, starts, tolerance, history)
        settled = finished[0].norm <= 2.0 * tolerance
        if not settled and len(problem.free) == 1 and problem.slip_friction is None:
            newton, finished = self._between(problem, tolerance, history)
            settled = finished[0].norm <= 2.0 * tolerance
        if not settled and problem.slip_friction is not None:
            newton, finished, settled = self._fixed_point(problem, newton, finished[0], tolerance, history)
        state, slip, lost, inside, displacement = finished
        creep = newton.creepage(state.unknown)
        return TangentialSolution(
            traction=state.traction,
            slip=slip,
            lost=lost,
            stick=newton.sticking(state),
            creepage=(float(creep[0]), float(creep[1])),
            residual=state.norm,
            newton_steps=len(history) - 1,
            applications=self.gradient.applications - before,
            converged=settled,
            bound=state.bound,
            displacement=displacement,
            hardening=friction.response(newton.free_slip(state)).hardening if isinstance(friction, Hardening) else None,
            hysteresis=inside,
            history=tuple(history),
        )

    def _newton(
        self, problem: TangentialProblem, starts: Sequence[Start], tolerance: float, history: list[float]
    ) -> tuple[Newton, Finished]:
        newton = Newton(problem, self.gradient, self._inverse, self.options)
        states = [newton.start(*start) for start in starts]
        if states:
            state = self._iterate(newton, min(states, key=lambda s: s.norm), tolerance, history)
        if not states or state.norm > tolerance:
            start = newton.start(*self._full_stick(problem))
            state = self._iterate(newton, start, tolerance, history)
        finished = newton.finish(state)
        if tolerance < finished[0].norm < LARGEST_REFINED_RESIDUAL:
            # Close to the friction limit the combined images lose digits: continue from the recomputed slip.
            finished = newton.finish(self._iterate(newton, finished[0], tolerance, history))
        if 2.0 * tolerance < finished[0].norm < LARGEST_REFINED_RESIDUAL and problem.slip_friction is None:
            other = replace(newton, options=replace(self.options, relaxation=OTHER_RELAXATION * self.options.relaxation))
            near = self._iterate(other, other.start(*_start_from(newton, finished[0])), tolerance, history)
            again = self._iterate(newton, newton.start(*_start_from(other, near)), tolerance, history)
            finished = min(finished, newton.finish(again), key=lambda each: each[0].norm)
        return newton, finished

    def _between(
        self, problem: TangentialProblem, tolerance: float, history: list[float]
    ) -> tuple[Newton, Finished]:
        """The creepage of one prescribed force between those at which all slides one way, and its tractions.

        Where friction is so low that bodies of unlike elasticity slide nearly everywhere, in both directions, elements change
        the direction of their slip one by one, and the force does not answer to small changes of the creepage: Newton's steps
        have no slope. It still grows with the creepage."""
        (i,), newton = problem.free, Newton(problem, self.gradient, self._inverse, self.options)
        traction, wanted = np.zeros_like(problem.rigid_slip), float(newton.target[0])

        def missing(creepage: float) -> float:
            """Sum of the tractions above the one that is wanted; 0 within the tolerance, and where these are not found."""
            nonlocal traction
            rigid = problem.rigid_slip.copy()
            rigid[i] += creepage
            _, (state, *_) = self._newton(replace(problem, rigid_slip=rigid, force=(None, None)), [(traction, (0.0, 0.0))],
                                          0.1 * tolerance, history)
            traction = state.traction
            above = float(traction[i].sum()) - wanted
            close = abs(above) <= tolerance * newton.reference * newton.force_scale
            return 0.0 if close or state.norm > tolerance else above

        own, room = problem.rigid_slip[i][newton.contact], newton.count * newton.creepage_unit
        ends = -float(own.max()) - room, -float(own.min()) + room
        creepage = [0.0, 0.0]
        if missing(ends[0]) * missing(ends[1]) < 0.0:
            creepage[i] = float(scipy.optimize.brentq(
                missing, *ends, xtol=1e-300, rtol=1e-15, maxiter=MOST_BISECTIONS, disp=False))
            missing(creepage[i])
        state = self._iterate(newton, newton.start(traction, (creepage[0], creepage[1])), tolerance, history)
        return newton, newton.finish(state)

    def _fixed_point(
        self, problem: TangentialProblem, newton: Newton, state: Iterate, tolerance: float, history: list[float]
    ) -> tuple[Newton, Finished, bool]:
        """The undamped fixed point on the coefficient of friction, for laws so steep that Newton stalls.

        It ends on the mean change of the factor, because a few elements at the onset of slip keep alternating."""
        assert problem.slip_friction is not None and state.response is not None
        factor = state.response.factor
        for _ in range(MOST_FRICTION_ITERATIONS):
            fixed = replace(problem, traction_bound=problem.traction_bound * factor, slip_friction=None)
            newton, finished = self._newton(fixed, [_start_from(newton, state)], tolerance, history)
            state = finished[0]
            if state.norm > 2.0 * tolerance:
                break
            before, factor = factor, problem.slip_friction.response(newton.free_slip(state)).factor
            if float(np.abs(factor - before)[newton.contact].mean()) <= FRICTION_SETTLED:
                return newton, finished, True
        return newton, finished, False

    def _iterate(self, newton: Newton, state: Iterate, tolerance: float, history: list[float]) -> Iterate:
        """Newton steps down to `tolerance`; the accuracy of each follows from the gain of the last (Eisenstat & Walker
        1996)."""
        history.append(state.norm)
        forcing = min(LOOSEST_FORCING, max(FIRST_SHARE * state.norm**2, 0.5 * tolerance / max(state.norm, tolerance)))
        best, looked = state, False
        # Where an interlayer hardens, the end of what yields moves on by an element per step.
        hardens = isinstance(newton.problem.slip_friction, Hardening)
        for step in range(max(MOST_NEWTON_STEPS, self.gradient.shape[0] if hardens else 0)):
            if state.norm <= tolerance or not np.isfinite(state.norm):
                break
            if step:
                ratio = history[-1] / history[-2]
                earned = max(FORCING_SHARE * ratio**2, 0.5 * tolerance / state.norm)
                forcing = min(LOOSEST_FORCING, earned)
                # Lone slip that is true comes back: then it does not help to remove it.
                looked = ratio > SLOW_REDUCTION and not (looked and ratio > HELPFUL_REDUCTION)
                if looked:
                    state = newton.without_false_slip(state)
            state = newton.step(state, forcing)
            history.append(state.norm)
            if state.norm < best.norm:
                best = state
        return best

    def _full_stick(self, problem: TangentialProblem) -> Start:
        """Tractions of full stick without a bound, which is a linear problem. Forces by friction that begins at zero need
        creepages: below a threshold of slip no force answers to them."""
        friction = problem.slip_friction
        begins_at_zero = isinstance(friction, SlipFriction) and friction.law.at_rest == 0.0 and bool(problem.free)
        unbounded = replace(problem, traction_bound=problem.traction_bound * FULL_STICK_BOUND,
                            slip_friction=None if begins_at_zero else friction)
        newton = Newton(unbounded, self.gradient, self._inverse, self.options)
        state = newton.step(newton.start(np.zeros_like(problem.rigid_slip), (0.0, 0.0)), STICK_FORCING)
        creep = newton.creepage(state.unknown)
        wanted = np.array([force or 0.0 for force in problem.force]) / problem.element_area
        if isinstance(friction, SlipFriction) and begins_at_zero and (size := math.hypot(*wanted)):
            # Full stick may need creepages against the force, where spin alone makes more of it.
            slip = friction.law.slip_of(size / float(problem.traction_bound.sum())) / friction.speed
            creep = max(float(creep @ wanted) / size, slip) * wanted / size
        return state.traction, (float(creep[0]), float(creep[1]))


def _start_from(newton: Newton, state: Iterate) -> Start:
    """Tractions and creepages of a `state`."""
    along, across = newton.creepage(state.unknown).tolist()
    return state.traction, (along, across)

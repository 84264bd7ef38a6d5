"""The search for the places and the motion of all balls: loads, then tractions, in rounds.

Four unknowns of a ball, the speed of the cage and the ball's angular velocity, follow from four conditions: no force along the
pitch circle, and moments of both contacts that turn the ball's axis with the cage, J ω_m e_a × ω_b. The tractions also push the
ball axially and outwards, which changes places and loads. Slopes of the tractions with the creepages are found by differences
once for the first ball, and corrected by each solution of a contact (Broyden 1965). Balls follow each other from the largest
load to the smallest, and each begins with the motion and the slopes of the one before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.bearing.bearing_problem import AXIAL, RINGS, BearingProblem, RingName
from thermoroll_cli.bearing.placement import Placement, place
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import Solver

Report = Callable[[str, Mapping[str, Any]], None]

BALANCED = 2e-5
"""Forces and moments over half of the diameter that are left of a ball's balance, over the friction limit of its contacts."""
SETTLED = 5e-4
"""Change of the friction that pushes a ball axially and outwards from round to round, over the same."""
MOST_ROUNDS, MOST_STEPS = 25, 30
LONGEST = 2.0
"""Largest change of a creepage in one step, over twice that at which a contact slides."""
DIFFERENCE = 0.04
"""Change of a creepage by which slopes are found, over that at which a contact slides."""
ROUGH_GRID = 40
"""Elements per side of the contacts at most until all is nearly in balance."""
APART = 0.1
"""Part of the estimated errors of forces by which those of both contacts of a ball differ."""
FOLLOWED = 0.4
"""Part of these errors of creepages by which scalars change: 0.3 at most in 22 random bearings, for friction saturates."""
LIGHT = 1e-4
"""Load of a ball over the largest of all below which it counts as free: it rolls as others carry it along."""
ALIKE = 1e-9
"""Relative difference of loads and angles of balls that are solved as one."""


@dataclass
class Ball:
    """Balls with the same loads and angles, by their numbers from 0, `members`.

    - `motion`: as of `BearingProblem.slip`; what is `left` of its balance, over the friction limit; whether it is `loaded` by
      both rings;
    - for each ring the `result` of its contact, its `force` (N) and `moment` (N m) on the ball about its centre, the
      `creepages`, and the `slopes` of the force along e_t and the moments over D/2, over μW, with the creepages, over those at
      which the contact slides;
    - `passed_on`: errors that the balance causes in each contact: of its load, over the load; of what depends on creepages,
      over its scale; and of its heat (W); `creepage_errors`, and that of the cage's speed, `cage_error` (rad/s)."""

    members: tuple[int, ...]
    motion: Array
    loads: Array = field(default_factory=lambda: np.zeros(2))
    angles: Array = field(default_factory=lambda: np.zeros(2))
    result: dict[RingName, Result] = field(default_factory=dict)
    force: dict[RingName, Array] = field(default_factory=dict)
    moment: dict[RingName, Array] = field(default_factory=dict)
    creepages: dict[RingName, Array] = field(default_factory=dict)
    slopes: dict[RingName, Array] = field(default_factory=dict)
    solvers: dict[RingName, Solver] = field(default_factory=dict)
    left: float = math.inf
    loaded: bool = False
    passed_on: dict[RingName, tuple[float, float, float]] = field(default_factory=dict)
    creepage_errors: dict[RingName, Array] = field(default_factory=dict)
    cage_error: float = math.nan


@dataclass
class SolvedBearing:
    """A bearing as it was found: its `placement`, its `balls`, those alike as one, and what is wrong with it (`reason`)."""

    problem: BearingProblem
    placement: Placement
    balls: list[Ball]
    reason: str = ""
    rounds: int = 0
    solves: int = 0


class BearingSearch:
    """Solves one bearing."""

    def __init__(self, problem: BearingProblem, threads: int, report: Report) -> None:
        self.problem, self.threads, self.report = problem, threads, report
        self.balls: list[Ball] = []
        self.rounds = self.solves = 0
        count = problem.balls
        self.on_balls, self.on_ring = np.zeros((count, 2)), np.zeros((count, 2))
        self.cage = np.full(count, problem.speeds[0] if not problem.rolls else math.nan)
        self.placement = self._placed(first=True)

    def solve(self) -> SolvedBearing:
        """The bearing in balance, or what is wrong with it."""
        reason = self.placement.reason
        if self.problem.rolls and not reason:
            self._kinematic()
        self._gather()
        contact = self.problem.contact
        if self.problem.balances and not reason:
            for stage, tolerance in self._stages():
                reason = self._balance(stage, tolerance)
        whole = contact if self.problem.rolls else replace(
            contact, friction=replace(contact.friction, coefficient=0.0, law=None), motion=Motion(1.0, differential_slip=False),
            heating=replace(contact.heating, heat=False, deformation=False))
        for ball in self.balls:
            if not ball.loaded:
                ball.result = {}
                continue
            # From nothing, so that it is the result of the same contact alone.
            ball.solvers = {}
            self._solve(ball, whole)
            if self.problem.balances and ball.slopes:
                ball.left = self._left(ball)
                self._pass_on_errors(ball)
        return SolvedBearing(self.problem, self.placement, self.balls, reason or self.placement.reason, self.rounds,
                             self.solves)

    def _stages(self) -> list[tuple[Problem, float]]:
        """The problems of contacts with which the balance is sought: a friction that falls with slip is followed from constant
        friction; then roughly, without heat unless friction depends on it; then as asked for, but for stresses below."""
        contact = replace(self.problem.contact, subsurface=None)
        grid = contact.numerics.grid or (ROUGH_GRID, ROUGH_GRID)
        rough = replace(
            contact, numerics=Numerics((min(grid[0], ROUGH_GRID), min(grid[1], ROUGH_GRID)), None, contact.numerics.extent),
            heating=contact.heating if contact.friction_varies else replace(contact.heating, heat=False, deformation=False))
        stages = [] if rough == contact else [(rough, 10.0 * BALANCED)]
        if contact.friction.law is not None:
            stages.insert(0, (replace(rough, friction=replace(contact.friction, law=None)), 50.0 * BALANCED))
        return [*stages, (contact, BALANCED)]

    # --- places --------------------------------------------------------------------------------------------------------

    def _placed(self, *, first: bool = False) -> Placement:
        centrifugal = self.problem.centrifugal(np.nan_to_num(self.cage))
        return place(self.problem, centrifugal, self.on_balls, self.on_ring, None if first else self.placement)

    def _kinematic(self) -> None:
        """Places with the speed of the cage of pure rolling; of balls that one ring alone touches the mean of the others."""
        ring = self.problem.controlling
        for _ in range(MOST_ROUNDS):
            speeds = np.array([self.problem.race_control(angles, ring)[0] if loads.min() > 0.0 else math.nan
                               for angles, loads in zip(self.placement.angles, self.placement.loads, strict=True)])
            mean = float(np.nanmean(speeds)) if not np.isnan(speeds).all() else (
                self.problem.race_control(np.zeros(2), ring)[0])
            before, self.cage = self.cage, np.where(np.isnan(speeds), mean, speeds)
            self.placement = self._placed()
            if np.abs(self.cage - before).max() <= 1e-11 * np.abs(self.cage).max():
                break

    def _gather(self) -> None:
        """Balls alike as one, from the largest load to the smallest."""
        loads, angles = self.placement.loads, self.placement.angles
        kinds: list[list[int]] = []
        scale = np.array([loads.max() or 1.0] * 2 + [1.0, 1.0])
        states = np.hstack([loads, np.where(loads > 0.0, angles, 0.0)]) / scale
        for j in np.argsort(-loads[:, 0], kind="stable").tolist():
            kind = next((kind for kind in kinds if np.abs(states[kind[0]] - states[j]).max() < ALIKE), None)
            if kind is None:
                kinds.append([j])
            else:
                kind.append(j)
        self.balls = [Ball(tuple(sorted(kind)), np.zeros(4)) for kind in kinds]
        ring = self.problem.controlling
        for ball in self.balls:
            self._put(ball)
            if ball.loaded and self.problem.rolls:
                ball.motion = self.problem.race_control(ball.angles, ring)
            elif self.problem.rolls:
                ball.motion[0] = self.cage[ball.members[0]]

    def _put(self, ball: Ball) -> None:
        ball.loads, ball.angles = (of[ball.members[0]] for of in (self.placement.loads, self.placement.angles))
        ball.loaded = bool(ball.loads.min() > LIGHT * self.placement.loads.max())

    # --- tractions -----------------------------------------------------------------------------------------------------

    def _solve(self, ball: Ball, contact: Problem) -> None:
        """Both contacts of a ball at its motion."""
        for k, ring in enumerate(RINGS):
            angle, load = float(ball.angles[k]), float(ball.loads[k])
            if not self.problem.rolls:
                slow = np.array([self.problem.speeds[0] - 1.0, 0.0, 0.0, 0.0])
                problem = replace(self.problem.contact_problem(contact, ring, angle, load, slow), motion=contact.motion)
            else:
                problem = self.problem.contact_problem(contact, ring, angle, load, ball.motion)
            self._learn(ball, ring, problem)
            self.solves += 1

    def _learn(self, ball: Ball, ring: RingName, problem: Problem) -> None:
        try:
            result = ball.solvers.setdefault(ring, Solver(self.threads)).solve(problem)
        except Unsolvable as cause:
            name = f"the {ring} contact of ball {ball.members[0] + 1}, of {problem.normal_force:.4g} N"
            raise Unsolvable(f"{name}, cannot be solved: {cause}", "bearing.load",
                             'other loads, or patches = "plane" in [bearing]') from None
        k = RINGS.index(ring)
        force, moment = tractions_on_ball(self.problem, ring, float(ball.angles[k]), result)
        ball.result[ring], ball.force[ring], ball.moment[ring] = result, force, moment
        ball.creepages[ring] = np.array([problem.motion.creepage_x, problem.motion.creepage_y, problem.motion.spin])

    def _wrench(self, ball: Ball, ring: RingName) -> Array:
        """Force along e_t and moments over D/2 of a contact, over its friction limit."""
        limit = self.problem.contact.friction.coefficient * ball.loads[RINGS.index(ring)]
        return np.array([ball.force[ring][2], *(2.0 * ball.moment[ring] / self.problem.ball_diameter)]) / limit

    def saturation(self, ball: Ball, ring: RingName) -> Array:
        """Creepages and spin at which a contact slides all over."""
        k = RINGS.index(ring)
        hertz = self.problem.hertz(ring, float(ball.angles[k]), float(ball.loads[k]))
        creepage = self.problem.contact.friction.coefficient * hertz.semi_axis_x * hertz.curvature_x
        return np.array([creepage, creepage, creepage / hertz.semi_axis_y])

    def rest(self, ball: Ball) -> Array:
        """What is left of the balance of a ball in N: the force along the pitch circle, and moments over D/2."""
        gyroscopic = self.problem.inertia * ball.motion[0] * np.cross(AXIAL, ball.motion[1:])
        moment = ball.moment["inner"] + ball.moment["outer"] - gyroscopic
        return np.array([sum(force[2] for force in ball.force.values()), *(2.0 * moment / self.problem.ball_diameter)])

    def jacobian(self, ball: Ball) -> Array:
        """Its derivatives with the motion of the ball."""
        total, mu = np.zeros((4, 4)), self.problem.contact.friction.coefficient
        for k, ring in enumerate(RINGS):
            by_motion = self._by_motion(ball, ring) / self.saturation(ball, ring)[:, None]
            total += mu * ball.loads[k] * ball.slopes[ring] @ by_motion
        inertia = 2.0 * self.problem.inertia / self.problem.ball_diameter
        total[1:, 0] -= inertia * np.cross(AXIAL, ball.motion[1:])
        total[1:, 1:] -= inertia * ball.motion[0] * np.cross(AXIAL, np.eye(3)).T
        return total

    def _pass_on_errors(self, ball: Ball) -> None:
        """Errors of motion and loads by those of the forces of both contacts, and by what is left of the balance.

        Both contacts have much the same grid, and most of what their forces miss is a like share of each, which leaves the
        balance as it is; the rest, `APART` of the estimates, is independent. What follows adds by its squares."""
        errors, friction, half = np.zeros((10, 4)), self.problem.contact.friction.coefficient, 0.5 * self.problem.ball_diameter
        parts: dict[RingName, Array] = {}
        for k, ring in enumerate(RINGS):
            normal, e_x, e_y = self.problem.frame(ring, float(ball.angles[k]))
            # Force along and across, and the moment about the normal over D/2, in the conditions of the balance.
            parts[ring] = np.array([[e_x[2], *e_y], [0.0, *-e_x], [0.0, *normal]])
            own = np.nan_to_num([ball.result[ring].uncertainty[name] for name in ("force_x_N", "force_y_N", "spin_moment_Nmm")])
            own *= [1.0, 1.0, 1e-3 / half]
            errors[3 * k : 3 * k + 3] = APART * own[:, None] * parts[ring]
            signs = np.sign([ball.result[ring][name] for name in ("force_x_N", "force_y_N", "spin_moment_Nmm")])
            errors[7:] += (signs * own)[:, None] * parts[ring]
        errors[6] = ball.left * self.limit(ball) * 0.5
        by_motion = -np.linalg.pinv(self.jacobian(ball), rcond=1e-10) @ errors.T
        ball.cage_error = float(np.linalg.norm(by_motion[0]))
        for k, ring in enumerate(RINGS):
            unit, here, load = self.saturation(ball, ring), ball.creepages[ring], float(ball.loads[k])
            moved = self._by_motion(ball, ring) @ by_motion
            scalars = ball.result[ring].coupled.scalars
            forces = np.array([scalars["force_x_N"], scalars["force_y_N"], 1e-3 * scalars["spin_moment_Nmm"]])
            # Moments of both forces about the ball's centre count twice in the balance: half is what each follows.
            changed = np.array([1.0, 1.0, half])[:, None] * (
                parts[ring] / (parts[ring] ** 2).sum(axis=1, keepdims=True)) @ (
                friction * load * ball.slopes[ring] @ (moved / unit[:, None]))
            power = self.problem.slip(ring, float(ball.angles[k]), ball.motion)[0] * (forces @ moved + here @ changed)
            ball.creepage_errors[ring] = np.linalg.norm(moved, axis=1)
            relative = np.linalg.norm(moved / unit[:, None], axis=0) / max(float(np.linalg.norm(here / unit)), 1.0)
            ball.passed_on[ring] = ((float(np.linalg.norm(errors[:, 0])) + SETTLED * self.limit(ball)) / load,
                                    FOLLOWED * float(np.linalg.norm(relative)), FOLLOWED * float(np.linalg.norm(power)))

    def _by_motion(self, ball: Ball, ring: RingName) -> Array:
        """Derivatives of the creepages of a contact with the motion of its ball, (3, 4)."""
        angle, step = float(ball.angles[RINGS.index(ring)]), 1e-6 * float(np.linalg.norm(ball.motion))
        here = self.problem.creepages(ring, angle, ball.motion)
        moved = (self.problem.creepages(ring, angle, ball.motion + step * unit) for unit in np.eye(4))
        return np.array([(creepages - here) / step for creepages in moved]).T

    def limit(self, ball: Ball) -> float:
        """Friction limit of a ball in N."""
        return self.problem.contact.friction.coefficient * float(ball.loads.max())

    def _differences(self, ball: Ball, contact: Problem) -> None:
        """Slopes of both contacts by differences."""
        for k, ring in enumerate(RINGS):
            kept = ball.result[ring], ball.force[ring], ball.moment[ring], ball.creepages[ring]
            before, unit, columns = self._wrench(ball, ring), self.saturation(ball, ring), []
            shaped = self.problem.contact_problem(contact, ring, float(ball.angles[k]), float(ball.loads[k]), ball.motion)
            for axis in range(3):
                moved = kept[3] + DIFFERENCE * unit * np.eye(3)[axis]
                x, y, spin = moved.tolist()
                self._learn(ball, ring, replace(shaped, motion=replace(shaped.motion, creepage_x=x, creepage_y=y, spin=spin)))
                self.solves += 1
                columns.append((self._wrench(ball, ring) - before) / DIFFERENCE)
            ball.slopes[ring] = np.array(columns).T
            ball.result[ring], ball.force[ring], ball.moment[ring], ball.creepages[ring] = kept

    def _step(self, ball: Ball) -> tuple[Array, float]:
        """Newton's step of the motion, of bounded changes of all creepages, and its share of the whole step."""
        unknown = slice(1, 4) if self.problem.common_cage else slice(0, 4)
        step = np.zeros(4)
        step[unknown] = np.linalg.lstsq(self.jacobian(ball)[unknown, unknown], -self.rest(ball)[unknown], rcond=1e-10)[0]
        change = 0.0
        for k, ring in enumerate(RINGS):
            moved = self._by_motion(ball, ring) @ step
            before, after = (self.problem.slip(ring, float(ball.angles[k]), motion)[0]
                             for motion in (ball.motion, ball.motion + step))
            # Surfaces go on flowing the same way.
            change = max(change, float(np.abs(moved / (2.0 * self.saturation(ball, ring))).max()),
                         2.0 * (1.0 - after / before) * LONGEST)
        share = min(1.0, LONGEST / max(change, 1e-300))
        return share * step, share

    def _left(self, ball: Ball) -> float:
        rest = self.rest(ball)
        return float(np.linalg.norm(rest[1:] if self.problem.common_cage else rest)) / self.limit(ball)

    def _in_balance(self, ball: Ball, contact: Problem, tolerance: float) -> None:
        """Move a ball until what is left of its balance falls below `tolerance`, or nothing more helps."""
        self._solve(ball, contact)
        ball.left = self._left(ball)
        fresh, failed = False, 0
        for _ in range(MOST_STEPS):
            if ball.left <= tolerance:
                return
            if not ball.slopes or failed > 2:
                if fresh:
                    return
                self._differences(ball, contact)
                fresh, failed = True, 0
            step, share = (part * 0.5**failed for part in self._step(ball))
            kept = (ball.motion, dict(ball.result), dict(ball.force), dict(ball.moment), dict(ball.creepages), ball.left)
            before = {ring: (self._wrench(ball, ring), ball.creepages[ring]) for ring in RINGS}
            ball.motion = ball.motion + step
            self._solve(ball, contact)
            for ring, (wrench, creepages) in before.items():
                moved = (ball.creepages[ring] - creepages) / self.saturation(ball, ring)
                missed = self._wrench(ball, ring) - wrench - ball.slopes[ring] @ moved
                ball.slopes[ring] = ball.slopes[ring] + np.outer(missed, moved) / max(float(moved @ moved), 1e-300)
            left = self._left(ball)
            if left < (1.0 - 0.1 * share) * ball.left:
                ball.left, failed, fresh = left, 0, False
            else:
                ball.motion, ball.result, ball.force, ball.moment, ball.creepages, ball.left = kept
                failed += 1

    def _balance(self, contact: Problem, tolerance: float) -> str:
        """Rounds of loads and tractions until nothing changes; else why not."""
        moved = 1.0
        loaded = [ball for ball in self.balls if ball.loaded]
        if not loaded:
            return "no ball touches both rings"
        for _ in range(MOST_ROUNDS):
            self.rounds += 1
            before: Ball | None = None
            wanted = tolerance if moved <= 20.0 * SETTLED else min(0.05 * moved, 0.05)
            for ball in loaded:
                if not ball.result:
                    self._begin(ball, before, contact)
                self._in_balance(ball, contact, wanted)
                before = ball
            moved = self._friction_moved()
            unbalanced = self._common_speed() if self.problem.common_cage else 0.0
            self.report("bearing", {"iteration": self.rounds, "residual": moved})
            worst = max(loaded, key=lambda ball: ball.left)
            # Places follow the friction once more only if it has changed: tractions are in balance at the places as they are.
            if moved <= SETTLED and unbalanced <= SETTLED and worst.left <= tolerance:
                return ""
            if worst.left > wanted and moved <= SETTLED:
                break
            self.placement = self._placed()
            if self.placement.reason:
                return self.placement.reason
            for ball in self.balls:
                self._put(ball)
            loaded = [ball for ball in self.balls if ball.loaded]
            if not loaded:
                return "no ball touches both rings"
        if worst.left > tolerance:
            return self._without_axis(worst)
        return f"the friction of the balls did not settle: it still changes by {moved:.1e} of its limit from round to round"

    def _begin(self, ball: Ball, before: Ball | None, contact: Problem) -> None:
        """The first motion: between both race controls, as far as the ball before, and its slopes."""
        inner, outer = (self.problem.race_control(ball.angles, ring) for ring in RINGS)
        if before is None:
            left = []
            for motion in (outer, 0.5 * (inner + outer), inner):
                ball.motion = motion
                self._solve(ball, contact)
                left.append((self._left(ball), motion))
            ball.motion = min(left, key=lambda pair: pair[0])[1]
        else:
            ball.motion = 0.5 * (inner + outer)
            its = [self.problem.race_control(before.angles, ring) for ring in RINGS]
            ball.motion = ball.motion + before.motion - 0.5 * (its[0] + its[1])
            ball.slopes = dict(before.slopes)
            for ring in RINGS:
                solver = Solver(self.threads)
                solver.last = before.solvers[ring].last
                ball.solvers[ring] = solver
        if self.problem.common_cage and before is not None:
            ball.motion[0] = before.motion[0]

    def _friction_moved(self) -> float:
        """Take over the friction that pushes balls and ring; its largest change over the friction limit."""
        moved = 0.0
        for ball in (ball for ball in self.balls if ball.loaded):
            push, on_ring = (ball.force["inner"] + ball.force["outer"])[:2], -ball.force["inner"][:2]
            cage = ball.motion[0]
            where, limit = list(ball.members), self.limit(ball)
            change = float(np.abs(push - self.on_balls[where[0]]).max())
            spread = abs(float(self.problem.centrifugal(cage) - self.problem.centrifugal(self.cage[where[0]])))
            moved = max(moved, (change + spread) / limit)
            self.on_balls[where], self.on_ring[where], self.cage[where] = push, on_ring, cage
        carried = [j for ball in self.balls if ball.loaded for j in ball.members]
        free = [j for j in range(self.problem.balls) if j not in carried]
        self.cage[free] = float(np.mean(self.cage[carried])) if carried else self.cage[free]
        return moved

    def _common_speed(self) -> float:
        """Newton's step of the speed that all balls share; the forces along the pitch circle together, over the limit."""
        force, slope, limit = 0.0, 0.0, 0.0
        loaded = [ball for ball in self.balls if ball.loaded]
        for ball in loaded:
            jacobian = self.jacobian(ball)
            rest, count = self.rest(ball), len(ball.members)
            follow = np.linalg.lstsq(jacobian[1:, 1:], np.stack([jacobian[1:, 0], rest[1:]], -1), rcond=1e-10)[0]
            force += count * (rest[0] - jacobian[0, 1:] @ follow[:, 1])
            slope += count * (jacobian[0, 0] - jacobian[0, 1:] @ follow[:, 0])
            limit += count * self.limit(ball)
        bound = 2e-3 * abs(float(loaded[0].motion[0]))
        step = min(max(-force / slope, -bound), bound) if slope else 0.0
        if abs(force) > SETTLED * limit:
            for ball in loaded:
                ball.motion = ball.motion + np.array([step, 0.0, 0.0, 0.0])
        return abs(force) / limit

    def _without_axis(self, ball: Ball) -> str:
        """Why a ball found no axis."""
        of_tractions, gyroscopic = self.limit(ball) * self.problem.ball_diameter, self.problem.inertia * float(
            np.linalg.norm(ball.motion[0] * np.cross(AXIAL, ball.motion[1:])))
        name = f"ball {ball.members[0] + 1}"
        if gyroscopic > 0.5 * of_tractions:
            return (f"{name}: no axis was found, {ball.left:.1e} of the friction limit are left over; its gyroscopic moment of "
                    f"{1e3 * gyroscopic:.3g} N mm is near what friction holds, {1e3 * of_tractions:.3g} N mm: more load, more "
                    "friction or less speed keeps it")
        return f"{name}: the tractions of its contacts do not balance, {ball.left:.1e} of the friction limit are left over"


def tractions_on_ball(problem: BearingProblem, ring: RingName, angle: float, result: Result) -> tuple[Array, Array]:
    """Force (N) and moment about the ball's centre (N m) by the tractions of a ring, along e_a, e_r and e_t.

    Tractions act at (x, Y, D/2 − h) in the axes of the contact from the ball's centre, h being the height of the common surface
    over the plane of the contact, and are inclined by its angle β(y) across."""
    normal, along, across = problem.frame(ring, angle)
    geometry, state = result.problem.geometry, result.coupled
    contact, conformity, diameter = result.problem, problem.conformity[RINGS.index(ring)], problem.ball_diameter
    share = contact.contact_modulus / contact.lower.plane_strain_modulus
    bent = ((1.0 - share) / conformity + 2.0 * share) / diameter
    turned = geometry.inclination(state.y) if isinstance(geometry, CurvedPatch) else bent * state.y
    sine, cosine = np.sin(turned), np.cos(turned)
    height, lateral, half = (1.0 - cosine) / bent, sine / bent, 0.5 * diameter
    area = float((state.x[1] - state.x[0]) * (state.y[1] - state.y[0]))
    shear_x, shear_y = (area * np.asarray(state.fields[name]) for name in ("shear_x", "shear_y"))
    scalars = state.scalars
    force_x, force_y = scalars["force_x_N"], scalars["force_y_N"] + float((shear_y * (cosine - 1.0)).sum())
    # Extrapolated forces, which are more accurate than sums of the fields, times their arm; the rest is small.
    moment = (
        -half * scalars["force_y_N"] + float((shear_y * (half - lateral * sine - (half - height) * cosine)).sum()),
        half * force_x + float((state.x[:, None] * sine * shear_y - height * shear_x).sum()),
        1e-3 * scalars["spin_moment_Nmm"],
    )
    return force_x * along + force_y * across, moment[0] * along + moment[1] * across + moment[2] * normal

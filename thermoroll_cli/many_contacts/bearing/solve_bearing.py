"""The search for the places and the motion of all balls.

Eight conditions hold of a ball. Four are of its motion, the speed of the cage and the ball's angular velocity: no force along
the pitch circle, and moments of both contacts that turn the ball's axis with the cage, J ω_m e_a × ω_b. Four are of its place:
tractions push the ball, and the inner ring with it, axially and outwards, with the friction with which it was placed. Newton's
method solves them together, for its place turns the contacts of a ball and so its creepages. Slopes of the tractions with the
creepages are found by differences once for the first ball, and corrected by each solution of a contact (Broyden 1965). A step
counts as one towards the balance if the next one, with the same slopes, is smaller (Deuflhard 2004): where spin makes a contact
slide, what is left of the conditions hardly depends on how both contacts share it, and tells little of the way. The first ball
begins with a race control, with the mean of both, or, where friction holds less than the gyroscopic moment, with an axis along
that of the bearing, which has none. Balls follow each other from the largest load to the smallest, and each begins with the
motion and the slopes of the one before, in rounds until the ring, which the friction of all balls moves, stays where it is.
With a common cage each ball first finds a speed of its own; then the speed of all is that at which the forces of their pockets
vanish together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.bearing.bearing_problem import RINGS, BearingProblem, RingName
from thermoroll_cli.many_contacts.bearing.placement import Placement, place
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

Report = Callable[[str, Mapping[str, Any]], None]

BALANCED = 2e-5
"""Forces and moments over half of the diameter that are left of a ball's balance, over the friction limit of its contacts."""
SETTLED = 5e-4
"""Difference of the friction that pushes a ball axially and outwards from that with which it was placed, over the same."""
MOST_ROUNDS, MOST_STEPS = 25, 30
FAST = 5.0
"""A contact slides fast at more than as many times the creepages at which it begins to slide all over: there only the ratios of
its creepages count, and what follows are shares of them."""
LONGEST, SHORTEST = 4.0, 0.03
"""Largest change of a creepage in one step, over that at which a contact slides, or a fifth of that at which it slides fast;
smallest share of a step that is tried."""
CLOSER, LESS, MORE = 0.1, 0.5, 3.0
"""Part of its share by which a step has to make the next one smaller, without leaving so much more; or part of the rest to
leave."""
SHORTER, LONGER = 0.4, 4.0
"""Share of a step that failed with which it is tried again; by how much the share may grow after one that did not."""
TELLS, NEAR = 0.005, 0.3
"""Changes of a creepage, in the unit of steps, above which a step tells slopes, and not what solutions leave open; and up to
which one that failed does."""
STILL = 1e-9
"""Change of a creepage in the same unit that is rounding."""
DIFFERENCE = 0.04
"""Change of a creepage by which slopes are found, in the same unit."""
NEARLY = 0.01
"""Rest of a ball above which it begins again elsewhere: rounds bring it to an end from less."""
ROUGH_GRID = 40
"""Elements per side of the contacts at most until all is nearly in balance."""
WRENCH = ("force_x_N", "force_y_N", "spin_moment_Nmm", "rolling_resistance_moment_Nmm")
INTEGRALS = (*WRENCH, "Q_F_W", "T_gamma_N", "expansion_power_W")
"""Scalars of a contact that act on its ball; those that follow its creepages by the slopes of the wrench."""
LIGHT = 1e-4
"""Load of a ball over the largest of all below which it counts as free: it rolls as others carry it along."""
ALIKE = 1e-9
"""Relative difference of loads and angles of balls that are solved as one."""


class SolvedContact(NamedTuple):
    """The `result` of a contact at `creepages` (3,); the `force` (N) and the `moment` about the ball's centre (N m) on the
    ball; and both, the moment over D/2, as a `wrench` (6,) over μW in the axes of the contact, e_z, e_x, e_y."""

    result: Result
    creepages: Array
    force: Array
    moment: Array
    wrench: Array


@dataclass
class Ball:
    """Balls with the same loads and angles, by their numbers from 0, `members`.

    - `motion`: as of `BearingProblem.slip`; whether it is `loaded` by both rings;
    - for each ring its `contacts`, and the `slopes` of their wrenches with the creepages, over those at which they slide;
    - the `INTEGRALS` of both contacts."""

    members: tuple[int, ...]
    motion: Array
    loads: Array = field(default_factory=lambda: np.zeros(2))
    angles: Array = field(default_factory=lambda: np.zeros(2))
    contacts: dict[RingName, SolvedContact] = field(default_factory=dict)
    slopes: dict[RingName, Array] = field(default_factory=dict)
    solvers: dict[RingName, ContactSolver] = field(default_factory=dict)
    loaded: bool = False
    integrals: dict[RingName, dict[str, float]] = field(default_factory=dict)


@dataclass
class SolvedBearing:
    """A bearing as it was found: its `placement`, its `balls`, those alike as one, and what is wrong with it (`reason`).

    `coarser` are the bearings that follow from the forces of the last three grids of its contacts, `settled` the one with
    nothing left of its conditions; both by the slopes of its balls, and only where axes follow from tractions."""

    problem: BearingProblem
    placement: Placement
    balls: list[Ball]
    reason: str = ""
    rounds: int = 0
    solves: int = 0
    coarser: tuple[SolvedBearing, ...] = ()
    settled: SolvedBearing | None = None


class BearingSearch:
    """Solves one bearing, from that of the search `before` if its balls are as many. Where friction falls with slip a bearing
    begins from nothing, so that its state does not depend on which was solved before."""

    def __init__(self, problem: BearingProblem, threads: int, report: Report, before: BearingSearch | None = None) -> None:
        self.problem, self.threads, self.report = problem, threads, report
        law, same = problem.contact.friction.law, before is not None and before.problem.balls == problem.balls
        self.before = before if same and problem.balances and law is None else None
        self.balls: list[Ball] = []
        self.rounds = self.solves = 0
        count = problem.balls
        self.on_balls, self.on_ring = np.zeros((count, 2)), np.zeros((count, 2))
        self.cage = np.full(count, problem.speeds[0] if not problem.rolls else math.nan)
        self.common: float | None = None
        self.placement = self._placed(first=True)

    def solve(self) -> SolvedBearing:
        """The bearing in balance, or what is wrong with it."""
        reason, ring = self.placement.reason, self.problem.controlling
        for _ in range(MOST_ROUNDS if self.problem.rolls and not reason else 0):
            # The cage has the speed of pure rolling, and with balls that one ring alone touches the mean of the others.
            speeds = np.array([self.problem.race_control(angles, ring)[0] if loads.min() > 0.0 else math.nan
                               for angles, loads in zip(self.placement.angles, self.placement.loads, strict=True)])
            mean = float(np.nanmean(speeds)) if not np.isnan(speeds).all() else (
                self.problem.race_control(np.zeros(2), ring)[0])
            before, self.cage = self.cage, np.where(np.isnan(speeds), mean, speeds)
            self.placement = self._placed()
            if (reason := self.placement.reason) or np.abs(self.cage - before).max() <= 1e-11 * np.abs(self.cage).max():
                break
        self._gather()
        if self.problem.balances and not reason:
            if self.before is not None:
                self._continue(self.before)
            for stage, tolerance in self.stages()[-1 if self.before is not None else 0 :]:
                reason = self._balance(stage, tolerance)
        for ball in self.balls:
            if not ball.loaded or self.placement.reason:
                ball.contacts = {}
                continue
            # From nothing, so that it is the result of the same contact alone.
            ball.solvers = {}
            self._solve(ball, self.whole)
            ball.integrals = {ring: integrals_of(solved.result.scalars)
                              for ring, solved in ball.contacts.items() if self.problem.rolls}
        solved = SolvedBearing(self.problem, self.placement, self.balls, reason or self.placement.reason, self.rounds,
                               self.solves)
        loaded = [ball for ball in self.balls if ball.loaded]
        if self.problem.balances and not solved.reason and all(ball.slopes for ball in loaded):
            grids = min(len(solver.last[1]) for ball in loaded for solver in ball.solvers.values())
            solved.settled = self._with_forces(None)
            solved.coarser = tuple(self._with_forces(-n) for n in range(min(grids, 3), 0, -1))
        return solved

    @property
    def whole(self) -> Problem:
        """What is asked of each contact; of rings at rest only what the load does."""
        contact = self.problem.contact
        return contact if self.problem.rolls else replace(
            contact, friction=replace(contact.friction, coefficient=0.0, law=None), motion=Motion(1.0, differential_slip=False),
            heating=replace(contact.heating, heat=False, deformation=False))

    def at_rest(self) -> list[Ball]:
        """The loaded balls as placed without centrifugal forces and friction, those alike as one, the largest load first."""
        self.cage = np.zeros(self.problem.balls)
        self.placement = self._placed(first=True)
        self._gather()
        return [ball for ball in self.balls if ball.loaded]

    def _continue(self, before: BearingSearch) -> None:
        """Begin with the axes, the slopes and, in proportion, the friction of the balls of another bearing."""
        ratio = np.diff(self.problem.speeds)[0] / np.diff(before.problem.speeds)[0]
        for ball in self.balls:
            was = next(each for each in before.balls if ball.members[0] in each.members)
            if not (ball.loaded and was.loaded and was.slopes):
                continue
            inner, outer = (self.problem.race_control(ball.angles, ring) - ratio * before.problem.race_control(was.angles, ring)
                            for ring in RINGS)
            ball.motion = ratio * was.motion + 0.5 * (inner + outer)
            # Contacts only say here that the ball begins with them: the first round solves them at its own motion.
            ball.slopes, ball.contacts = dict(was.slopes), dict(was.contacts)
            for ring in RINGS:
                ball.solvers[ring] = ContactSolver(self.threads)
                ball.solvers[ring].last = was.solvers[ring].last
            where, share = list(ball.members), self.limit(ball) / before.limit(was)
            self.on_balls[where], self.on_ring[where] = (share * of[was.members[0]] for of in (before.on_balls, before.on_ring))
            self.cage[where] = ball.motion[0]
        self.placement = self._placed()
        for ball in self.balls:
            self._put(ball)

    def stages(self) -> list[tuple[Problem, float]]:
        """The problems of contacts with which the balance is sought: a friction that falls with slip is followed from constant
        friction; then roughly, without heat unless friction depends on it; then as asked for, but for stresses below."""
        contact = replace(self.problem.contact, subsurface=None)
        grid = contact.numerics.grid or (ROUGH_GRID, ROUGH_GRID)
        cold = contact.heating.heat and not contact.friction_varies
        rough = replace(
            contact, numerics=Numerics((min(grid[0], ROUGH_GRID), min(grid[1], ROUGH_GRID)), None, contact.numerics.extent),
            heating=replace(contact.heating, heat=False, deformation=False) if cold else contact.heating)
        stages = [] if rough == contact else [(rough, 10.0 * BALANCED)]
        if contact.friction.law is not None:
            stages.insert(0, (replace(rough, friction=replace(contact.friction, law=None)), 50.0 * BALANCED))
        return [*stages, (contact, BALANCED)]

    # --- places --------------------------------------------------------------------------------------------------------

    def _placed(self, *, first: bool = False) -> Placement:
        centrifugal = self.problem.centrifugal(np.nan_to_num(self.cage))
        return place(self.problem, centrifugal, self.on_balls, self.on_ring, None if first else self.placement)

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
            ball.contacts[ring] = self._contact(ball, ring, problem)

    def _contact(self, ball: Ball, ring: RingName, problem: Problem) -> SolvedContact:
        try:
            result = ball.solvers.setdefault(ring, ContactSolver(self.threads)).solve(problem)
        except Unsolvable as cause:
            name = f"the {ring} contact of ball {ball.members[0] + 1}, of {problem.normal_force:.4g} N"
            raise Unsolvable(f"{name}, cannot be solved: {cause}", "bearing.load",
                             'other loads, or patches = "plane" in [bearing]') from None
        self.solves += 1
        force, moment = tractions_on_ball(self.problem, ring, float(ball.angles[RINGS.index(ring)]), result)
        frame, creepages = self._frame(ball, ring), [problem.motion.creepage_x, problem.motion.creepage_y, problem.motion.spin]
        wrench = np.concatenate([frame @ force, frame @ moment * (2.0 / self.problem.ball_diameter)])
        return SolvedContact(result, np.array(creepages), force, moment, wrench / self._friction(ball, ring))

    def _frame(self, ball: Ball, ring: RingName) -> Array:
        """e_z, e_x and e_y of a contact as rows."""
        return np.array(self.problem.frame(ring, float(ball.angles[RINGS.index(ring)])))

    def _friction(self, ball: Ball, ring: RingName) -> float:
        """Friction limit of a contact in N."""
        return self.problem.contact.friction.coefficient * float(ball.loads[RINGS.index(ring)])

    def limit(self, ball: Ball) -> float:
        """Friction limit of a ball in N."""
        return max(self._friction(ball, ring) for ring in RINGS)

    def saturation(self, ball: Ball, ring: RingName) -> Array:
        """Creepages and spin at which a contact slides all over."""
        k = RINGS.index(ring)
        return self.problem.saturation(ring, float(ball.angles[k]), float(ball.loads[k]))

    def unit(self, ball: Ball, ring: RingName) -> Array:
        """Unit of steps: creepages and spin at which a contact slides all over; where it slides fast, as many times as much."""
        saturation = self.saturation(ball, ring)
        return saturation * max(1.0, float(np.linalg.norm(ball.contacts[ring].creepages / saturation)) / FAST)

    def conditions(self, ball: Ball, ring: RingName, wrench: Array) -> Array:
        """What a contact's tractions, `wrench` (6, …), contribute to the conditions of a ball (8, …), in N: the force along the
        pitch circle, the moments over D/2, the force that pushes the ball axially and outwards, and that on the inner ring."""
        frame = self._friction(ball, ring) * self._frame(ball, ring).T
        force, moment = frame @ wrench[:3], frame @ wrench[3:]
        return np.concatenate([force[2:], moment, force[:2], -force[:2] if ring == "inner" else np.zeros_like(force[:2])])

    def rest(self, ball: Ball) -> Array:
        """What is left of the conditions of a ball (8,), in N; the last four are how much the friction that was found differs
        from that with which the ball was placed. Since its contacts were solved they follow their slopes."""
        first = ball.members[0]
        total = -np.concatenate([np.zeros(4), self.on_balls[first], self.on_ring[first]])
        total[1:4] -= 2.0 / self.problem.ball_diameter * self.problem.gyroscopic(ball.motion)
        for k, ring in enumerate(RINGS):
            solved = ball.contacts[ring]
            moved = self.problem.creepages(ring, float(ball.angles[k]), ball.motion) - solved.creepages
            wrench = solved.wrench + (ball.slopes[ring] @ (moved / self.saturation(ball, ring)) if ball.slopes else 0.0)
            total += self.conditions(ball, ring, wrench)
        return total

    def jacobian(self, ball: Ball) -> Array:
        """Derivatives of `rest` with the motion of the ball and the friction with which it is placed, (8, 8)."""
        total = np.diag([0.0] * 4 + [-1.0] * 4)
        for ring in RINGS:
            moved = self.changes(ball, ring) / self.saturation(ball, ring)[:, None]
            total += self.conditions(ball, ring, ball.slopes[ring] @ moved)
        turned = (self.problem.gyroscopic(ball.motion + unit) - self.problem.gyroscopic(ball.motion - unit)
                  for unit in np.eye(4))  # quadratic
        total[1:4, :4] -= np.transpose(list(turned)) / self.problem.ball_diameter
        return total

    def changes(self, ball: Ball, ring: RingName) -> Array:
        """Derivatives of the creepages of a contact with the motion of its ball, and, as that turns the contact, with the
        friction with which the ball is placed, (3, 8)."""
        k, step, tilt = RINGS.index(ring), 1e-6 * float(np.linalg.norm(ball.motion)), 1e-6
        angle, motion, members = float(ball.angles[k]), ball.motion, list(ball.members)
        here = self.problem.creepages(ring, angle, motion)
        by_motion = [(self.problem.creepages(ring, angle, motion + step * unit) - here) / step for unit in np.eye(4)]
        by_angle = (self.problem.creepages(ring, angle + tilt, motion) - here) / tilt
        turned = self.placement.turned[members[0], k, members].sum(axis=0)
        return np.hstack([np.transpose(by_motion), np.outer(by_angle, turned)])

    def _with_forces(self, level: int | None) -> SolvedBearing:
        """The bearing that follows, by the slopes of its balls, from the forces on the grid `level` (−1: the last one) in place
        of those that are extrapolated from all; None: with nothing left of its conditions."""
        on_balls, on_ring, cage = self.on_balls.copy(), self.on_ring.copy(), self.cage.copy()
        loaded = [ball for ball in self.balls if ball.loaded]
        apart: list[dict[RingName, dict[str, float]]] = []
        missing = []
        for ball in loaded:
            apart.append({ring: dict.fromkeys(INTEGRALS, 0.0) for ring in RINGS})
            missing.append(self.rest(ball) if level is None else np.zeros(8))
            for ring in RINGS:
                if level is None:
                    continue
                on_grid = integrals_of(ball.solvers[ring].last[1][level].reported.scalars)
                apart[-1][ring] = {name: on_grid[name] - ball.integrals[ring][name] for name in INTEGRALS}
                along, across, spin, brakes = (apart[-1][ring][name] for name in WRENCH)
                # Moments in N mm over half of the diameter in mm; D/2 away from where the forces act.
                spin, brakes = (2e-3 * moment / self.problem.ball_diameter for moment in (spin, brakes))
                wrench = np.array([0.0, along, across, spin, -across, along - brakes])
                missing[-1] = missing[-1] + self.conditions(ball, ring, wrench / self._friction(ball, ring))
        common = None if self.common is None else self._of_pockets(loaded, missing)[1]
        balls = {ball.members: replace(ball, integrals={}) for ball in self.balls}
        for ball, rest in zip(loaded, missing, strict=True):
            step = self._newton(ball, rest, None if common is None else common - float(ball.motion[0]))
            where, motion = list(ball.members), ball.motion + step[:4]
            balls[ball.members].motion = motion
            on_balls[where], on_ring[where], cage[where] = on_balls[where] + step[4:6], on_ring[where] + step[6:], motion[0]
        placement = place(self.problem, self.problem.centrifugal(np.nan_to_num(cage)), on_balls, on_ring, self.placement)
        for new in balls.values():
            new.loads, new.angles = (of[new.members[0]] for of in (placement.loads, placement.angles))
        for ball, off in zip(loaded, apart, strict=True):
            new = balls[ball.members]
            for k, ring in enumerate(RINGS):
                # Forces and moment follow the creepages by the slopes of the wrench, heat is their power.
                here, integrals = ball.contacts[ring].creepages, ball.integrals[ring]
                moved = self.problem.creepages(ring, float(new.angles[k]), new.motion) - here
                wrench = self._friction(ball, ring) * (ball.slopes[ring] @ (moved / self.saturation(ball, ring)))
                half = 0.5 * self.problem.ball_diameter
                follow, brakes = wrench[1:4] * [1.0, 1.0, half], half * float(wrench[1] - wrench[5])
                forces = np.array([integrals["force_x_N"], integrals["force_y_N"], 1e-3 * integrals["spin_moment_Nmm"]])
                speed, _, rolling = self.problem.slip(ring, float(ball.angles[k]), ball.motion)
                power = float((forces + follow) @ moved + follow @ here) + brakes * abs(rolling) / speed
                changes = (*(follow * [1.0, 1.0, 1e3]).tolist(), 1e3 * brakes, speed * power, power, 0.0)
                ratio = float(new.loads[k] / ball.loads[k])
                new.integrals[ring] = {name: ratio * (integrals[name] + off[ring][name] + change)
                                       for name, change in zip(INTEGRALS, changes, strict=True)}
        return SolvedBearing(self.problem, placement, list(balls.values()))

    def _whole_step(self, ball: Ball) -> tuple[Array, float]:
        """Newton's step of the motion and of the friction; and its largest change of a creepage, over that at which a contact
        slides."""
        step = self._newton(ball, self.rest(ball), None if self.common is None else self.common - float(ball.motion[0]))
        changes = [self.changes(ball, ring) @ step / self.unit(ball, ring) for ring in RINGS]
        return step, float(np.abs(changes).max())

    def _newton(self, ball: Ball, rest: Array, speed: float | None = None) -> Array:
        """The change of a ball's motion and of the friction with which it is placed that takes `rest` away; but for its force
        along the pitch circle, which its pocket takes, if the cage's `speed` changes by as much as is given."""
        unit = np.repeat([self.problem.contact.friction.coefficient * float(np.linalg.norm(ball.motion)), self.limit(ball)], 4)
        slopes, step = self.jacobian(ball), np.zeros(8)
        unknown = slice(0 if speed is None else 1, 8)
        step[0] = speed or 0.0
        step[unknown] = unit[unknown] * np.linalg.lstsq(
            (slopes * unit)[unknown, unknown], -(rest + slopes[:, 0] * step[0])[unknown], rcond=1e-10)[0]
        return step

    def left(self, ball: Ball) -> float:
        """What is left of the conditions of a ball, over its friction limit; of friction that differs, `SETTLED` counts as
        `BALANCED`. With a common cage its speed counts in place of the force along the pitch circle, over that at which the
        ball slides."""
        rest = self.rest(ball) / self.limit(ball)
        if self.common is not None:
            rest[0] = (ball.motion[0] - self.common) / (float(self.saturation(ball, "outer")[0]) * self.common)
        return math.hypot(float(np.linalg.norm(rest[:4])), BALANCED / SETTLED * float(np.linalg.norm(rest[4:])))

    def _in_balance(self, ball: Ball, contact: Problem, tolerance: float) -> None:
        """Move a ball, and its place with its friction, until what is left of its conditions falls below `tolerance`, or
        nothing more helps."""
        where, fresh, share = list(ball.members), False, 1.0
        for _ in range(MOST_STEPS):
            if (left := self.left(ball)) <= tolerance:
                return
            if not ball.slopes or share < SHORTEST:
                if fresh:
                    return
                for k, ring in enumerate(RINGS):
                    here, unit, columns = ball.contacts[ring], self.unit(ball, ring), []
                    shaped = self.problem.contact_problem(
                        contact, ring, float(ball.angles[k]), float(ball.loads[k]), ball.motion)
                    for axis in range(3):
                        x, y, spin = (here.creepages + DIFFERENCE * unit * np.eye(3)[axis]).tolist()
                        moved = replace(shaped, motion=replace(shaped.motion, creepage_x=x, creepage_y=y, spin=spin))
                        columns.append((self._contact(ball, ring, moved).wrench - here.wrench) / DIFFERENCE)
                    ball.slopes[ring] = np.array(columns).T * (self.saturation(ball, ring) / unit)
                fresh, share = True, 1.0
            step, size = self._whole_step(ball)
            # Surfaces go on flowing the same way in both contacts, at half of their speed at least.
            flows = [[self.problem.slip(ring, float(angle), motion)[0] for motion in (ball.motion, ball.motion + step[:4])]
                     for ring, angle in zip(RINGS, ball.angles, strict=True)]
            share = min(share, LONGEST / size, *(0.5 / max(1.0 - after / before, 0.5) for before, after in flows))
            step = share * step
            motion, placement, contacts = ball.motion, self.placement, dict(ball.contacts)
            on_ball, on_ring = self.on_balls[where], self.on_ring[where]
            ball.motion = motion + step[:4]
            self.on_balls[where], self.on_ring[where] = on_ball + step[4:6], on_ring + step[6:]
            self.cage[where] = ball.motion[0]
            self.placement = self._placed()
            self._put(ball)
            if ball.loaded and not self.placement.reason:
                self._solve(ball, contact)
                closer = (now := self.left(ball)) <= max(tolerance, LESS * left) or (
                    now < MORE * left and self._whole_step(ball)[1] < (1.0 - CLOSER * share) * size)
                for ring, was in contacts.items():
                    # Slopes that give the change of the wrench since the last step.
                    change = ball.contacts[ring].creepages - was.creepages
                    change, along = change / self.unit(ball, ring), change / self.saturation(ball, ring)
                    missed = ball.contacts[ring].wrench - was.wrench - ball.slopes[ring] @ along
                    if TELLS < float(np.abs(change).max()) < (math.inf if closer else NEAR):
                        ball.slopes[ring] = ball.slopes[ring] + np.outer(missed, along) / float(along @ along)
                if closer:
                    share, fresh = min(1.0, LONGER * share), False
                    continue
            ball.motion, self.placement, self.on_balls[where], self.on_ring[where] = motion, placement, on_ball, on_ring
            self.cage[where] = ball.motion[0]
            self._put(ball)
            ball.contacts = contacts
            turned = max(float(np.abs((self.problem.creepages(ring, float(angle), ball.motion) - contacts[ring].creepages)
                                      / self.unit(ball, ring)).max()) for ring, angle in zip(RINGS, ball.angles, strict=True))
            if turned <= STILL or not ball.loaded:
                share = SHORTER * share
            else:
                # The friction of other balls has turned the contacts since they were solved: what was left is an estimate.
                self._solve(ball, contact)

    def _balance(self, contact: Problem, tolerance: float) -> str:
        """Rounds over all balls until nothing changes; else why not."""
        for ball in self.balls:
            if ball.contacts:
                self._solve(ball, contact)
        left, idle, unbalanced, turned = 0.2, 0, 0.0, 0.0
        for _ in range(MOST_ROUNDS):
            self.rounds += 1
            loaded, last = [ball for ball in self.balls if ball.loaded], None
            if not loaded:
                return "no ball touches both rings: more load, or a displacement beyond the play, presses them"
            # The friction of every ball moves the ring: all of them get closer together.
            wanted = tolerance if len(loaded) == 1 else max(0.5 * tolerance, 0.05 * left)
            for ball in loaded:
                self._put(ball)  # the friction of those before may have freed it
                if not ball.loaded:
                    continue
                new = not ball.contacts
                if new and last is not None:
                    self._follow(ball, last, contact)
                if ball.contacts:
                    self._in_balance(ball, contact, wanted)
                if new and (not ball.contacts or self.left(ball) > max(wanted, NEARLY)):
                    self._first(ball, contact, wanted)
                last = ball
            loaded = [ball for ball in loaded if ball.loaded]
            # Pockets of balls that are alike have no forces.
            if self.problem.common_cage and len(loaded) > 1:
                unbalanced, turned = self._turn_cage(loaded, turned, tolerance)
            # Balls that one ring alone touches have no friction and go round as the others do, at their mean.
            carried = [j for ball in loaded for j in ball.members]
            free = [j for j in range(self.problem.balls) if j not in carried]
            self.on_balls[free] = self.on_ring[free] = 0.0
            self.cage[free] = float(np.mean(self.cage[carried]))
            self.placement = self._placed()
            if self.placement.reason:
                return self.placement.reason
            for ball in self.balls:
                self._put(ball)
            known = [ball for ball in self.balls if ball.loaded and ball.contacts]
            before, left = left, max(map(self.left, known), default=math.inf)
            self.report("bearing", {"iteration": self.rounds, "residual": left})
            if left <= tolerance and unbalanced <= tolerance and all(ball.contacts for ball in self.balls if ball.loaded):
                return ""
            idle = idle + 1 if left > 0.7 * before and unbalanced <= tolerance else 0
            if idle == 2:
                break
        if left <= tolerance:
            return f"the cage found no common speed: its pockets are left with {unbalanced:.1e} of the friction limit"
        ball = max(known, key=self.left)
        of_tractions, left = self.limit(ball) * self.problem.ball_diameter, self.left(ball)
        gyroscopic, name = float(np.linalg.norm(self.problem.gyroscopic(ball.motion))), f"ball {ball.members[0] + 1}"
        if gyroscopic > 0.5 * of_tractions:
            return (f"{name}: no axis was found, {left:.1e} of the friction limit are left over; its gyroscopic moment of "
                    f"{1e3 * gyroscopic:.3g} N mm is near what friction holds, {1e3 * of_tractions:.3g} N mm: more load, more "
                    "friction or less speed keeps it")
        finer = "; on a finer numerics.grid they change more smoothly" if left < NEARLY else ""
        return f"{name}: the tractions of its contacts do not balance, {left:.1e} of the friction limit are left over{finer}"

    def _first(self, ball: Ball, contact: Problem, tolerance: float) -> None:
        """A ball in balance from nothing: from the start that leaves least of its conditions, or, if that fails, the next."""
        where, bearing, starts = list(ball.members), self.problem, []
        held = float(np.linalg.norm(bearing.gyroscopic(ball.motion))) < self.limit(ball) * bearing.ball_diameter
        outer, inner = (partial(bearing.race_control, ring=ring) for ring in ("outer", "inner"))
        for last, start in ((not held, outer), (not held, lambda angles: 0.5 * (outer(angles) + inner(angles))),
                            (not held, inner), (held, bearing.along_the_bearing)):
            self.cage[where] = start(ball.angles)[0]
            self.placement = self._placed()
            self._put(ball)
            if not ball.loaded:
                continue
            ball.motion = start(ball.angles)
            self._solve(ball, contact)
            starts.append((last, self.left(ball), ball.motion, dict(ball.contacts), self.placement))
        for _, _, ball.motion, ball.contacts, self.placement in sorted(starts, key=lambda start: start[:2]):
            ball.slopes = {}
            self.cage[where], self.on_balls[where], self.on_ring[where] = ball.motion[0], 0.0, 0.0
            self._put(ball)
            self._in_balance(ball, contact, tolerance)
            if self.left(ball) <= max(tolerance, NEARLY):
                break

    def _follow(self, ball: Ball, before: Ball, contact: Problem) -> None:
        """The first motion: between both race controls, as far as the ball before, and with its slopes."""
        inner, outer = (self.problem.race_control(ball.angles, ring) for ring in RINGS)
        its = [self.problem.race_control(before.angles, ring) for ring in RINGS]
        ball.motion = 0.5 * (inner + outer) + before.motion - 0.5 * (its[0] + its[1])
        ball.slopes = dict(before.slopes)
        for ring in RINGS:
            ball.solvers[ring] = ContactSolver(self.threads)
            ball.solvers[ring].last = before.solvers[ring].last
        self._solve(ball, contact)

    def _turn_cage(self, loaded: list[Ball], last: float, tolerance: float) -> tuple[float, float]:
        """Change the speed that all balls share so that the forces of their pockets vanish together, by at most four times the
        `last` change, or seven tenths of it back; the first time each ball has its own speed. How large the forces were, over
        the friction limit of all balls, and the change."""
        force, speed = self._of_pockets(loaded, [self.rest(ball) for ball in loaded])
        if self.common is None:
            self.common = speed
        elif force > tolerance:
            step = speed - self.common
            slides = LONGEST * abs(self.common) * float(self.saturation(loaded[0], "outer")[0])
            most = (4.0 if step * last > 0.0 else 0.7) * abs(last) or slides
            last = min(max(step, -most), most)
            self.common += last
        return force, last

    def _of_pockets(self, loaded: list[Ball], rests: list[Array]) -> tuple[float, float]:
        """The force of all pockets along the pitch circle, over the friction limit, that `rests` of all balls would leave, and
        the common speed at which it vanishes, by the slopes of the balls."""
        force, slope, towards, limit = 0.0, 0.0, 0.0, 0.0
        for ball, rest in zip(loaded, rests, strict=True):
            count, slopes = len(ball.members), self.jacobian(ball)
            follow = np.linalg.lstsq(slopes[1:, 1:], np.stack([rest[1:], slopes[1:, 0]], -1), rcond=1e-10)[0]
            own, its = np.array([rest[0], slopes[0, 0]]) - slopes[0, 1:] @ follow
            force, slope, towards = force + count * own, slope + count * its, towards + count * its * ball.motion[0]
            limit += count * self.limit(ball)
        return abs(force) / limit, (towards - force) / slope


def integrals_of(scalars: Mapping[str, float]) -> dict[str, float]:
    """The `INTEGRALS` of a contact; those that it does not have are 0."""
    return {name: 0.0 if math.isnan(scalars.get(name, math.nan)) else scalars[name] for name in INTEGRALS}


def tractions_on_ball(problem: BearingProblem, ring: RingName, angle: float, result: Result) -> tuple[Array, Array]:
    """Force (N) and moment about the ball's centre (N m) by the tractions of a ring, along e_a, e_r and e_t, and the moment of
    its pressure, which is not symmetric along rolling between unlike or hot bodies.

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
    scalars = integrals_of(state.scalars)
    force_x, force_y = scalars["force_x_N"], scalars["force_y_N"] + float((shear_y * (cosine - 1.0)).sum())
    # Extrapolated forces, which are more accurate than sums of the fields, times their arm; the rest is small.
    moment = (
        -half * scalars["force_y_N"] + float((shear_y * (half - lateral * sine - (half - height) * cosine)).sum()),
        half * force_x - 1e-3 * scalars["rolling_resistance_moment_Nmm"]
        + float((state.x[:, None] * sine * shear_y - height * shear_x).sum()),
        1e-3 * scalars["spin_moment_Nmm"],
    )
    return force_x * along + force_y * across, moment[0] * along + moment[1] * across + moment[2] * normal

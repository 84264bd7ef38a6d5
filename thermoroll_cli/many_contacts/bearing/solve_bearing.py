"""The search for the places and the motion of all balls.

Newton's method solves the eight conditions of a ball (`arrangement`) together, for its place turns its contacts and so their
creepages. Slopes of the tractions with the creepages are found by differences once for the first ball, and corrected by each
solution of a contact (Broyden 1965). A step leads to another arrangement, which is accepted or not: it is if it leaves less, by
a part of what the slopes promise, or if the next step, with the same slopes, is smaller (Deuflhard 2004): where spin makes a
contact slide, what is left of the conditions hardly depends on how both contacts share it, and tells little of the way. The
first ball begins with a race control, with the mean of both, or, where friction holds less than the gyroscopic moment, with an
axis along that of the bearing, which has none. Balls follow each other from the largest load to the smallest, and each begins
with the motion and the slopes of the one before, in rounds until the ring, which the friction of all balls moves, stays where
it is. With a common cage each ball first finds a speed of its own; then the speed of all is that at which the forces of their
pockets vanish together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.bearing.arrangement import BALANCED, Arrangement, Ball
from thermoroll_cli.many_contacts.bearing.bearing_problem import RINGS, BearingProblem, RingName
from thermoroll_cli.many_contacts.bearing.placement import NOTHING_PRESSED, Placement
from thermoroll_cli.many_contacts.bearing.tractions import INTEGRALS, WRENCH, SolvedContact, integrals_of
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Motion, Numerics, Problem
from thermoroll_cli.tools.arrays import Array

Report = Callable[[str, Mapping[str, Any]], None]

MOST_ROUNDS, MOST_STEPS = 25, 30
LONGEST, SHORTEST = 4.0, 0.03
"""Largest change of a creepage in one step, over that at which a contact slides, or a fifth of that at which it slides fast;
smallest share of a step that is tried."""
CLOSER, LESS, MORE, PROMISED = 0.1, 0.5, 3.0, 0.25
"""Part of its share by which a step has to make the next one smaller, without leaving so much more than before, or than
`NEARLY`; or part of the rest to leave; or part to take away of what the slopes promise."""
SHORTER, LONGER = 0.4, 2.0
"""Share of a step that failed to which the next is limited; by how much the limit may grow after one that did not (4: with much
friction half of the steps fail, and 110 solutions are needed in place of 60 at μ = 5)."""
TELLS, NEAR = 0.005, 0.3
"""Changes of a creepage, in the unit of steps, above which a step tells slopes, and not what solutions leave open; and up to
which one that failed does."""
STILL = 1e-9
"""Change of a creepage in the same unit that is rounding."""
DIFFERENCE = 0.04
"""Change of a creepage by which slopes are found, in the same unit."""
SLOW, MOST_TOGETHER, MOST_IDLE = 0.7, 20, 2
"""Part that a round of all balls in turn leaves above which all move together, and how often at most; rounds in a row that
leave as much, after which it ends."""
MOST_SOLVES = 400
"""Contacts that are solved for each kind of loaded balls in one search, after which it ends: 10 to 140 where it ends well."""
CONTAINED = 2e-4
"""What may be left, over the largest friction limit, where nothing more helps: errors contain it."""
NEARLY = 0.01
"""Rest of a ball above which it begins again elsewhere: rounds bring it to an end from less."""
LENIENT = 50.0
"""How many times more may be left of a ball that carries little, over its own friction limit, at most."""
ROUGH_GRID = 40
"""Elements per side of the contacts at most until all is nearly in balance."""


@dataclass(frozen=True)
class SolvedBearing:
    """A bearing as it was found: its `placement`, its `balls`, those alike as one, and what is wrong with it (`reason`); `left`
    is the power in W of what is left of the conditions.

    `coarser` are the bearings that follow from the forces of the last three grids of its contacts, `doubted` those that follow
    if a force or moment of all contacts with a ring is off by its estimated error, `settled` the one with nothing left of its
    conditions; all by the slopes of its balls, and only where axes follow from tractions."""

    problem: BearingProblem
    placement: Placement
    balls: Sequence[Ball]
    reason: str = ""
    rounds: int = 0
    solves: int = 0
    left: float = 0.0
    coarser: tuple[SolvedBearing, ...] = ()
    doubted: tuple[SolvedBearing, ...] = ()
    settled: SolvedBearing | None = None


class BearingSearch:
    """Solves one bearing, from that of the search `before` if its balls are as many. Where friction falls with slip a bearing
    begins from nothing, so that its state does not depend on which was solved before. `now` is the arrangement so far."""

    def __init__(self, problem: BearingProblem, threads: int, report: Report, before: BearingSearch | None = None) -> None:
        self.problem, self.threads, self.report = problem, threads, report
        law, same = problem.contact.friction.law, before is not None and before.problem.balls == problem.balls
        self.before = before if same and problem.balances and law is None else None
        self.rounds = self.solves = self.most_solves = 0
        self.solvers: dict[tuple[tuple[int, ...], RingName], ContactSolver] = {}
        self.now = Arrangement.first(problem, np.full(problem.balls, 0.0 if problem.rolls else problem.speeds[0]))

    def solve(self) -> SolvedBearing:
        """The bearing in balance, or what is wrong with it."""
        reason = self._by_race_control()
        self.now = self.now.gathered()
        if self.problem.balances and not reason:
            if self.before is not None:
                self._continue(self.before)
            for stage, tolerance in self.stages()[-1 if self.before is not None else 0 :]:
                reason = self._balance(stage, tolerance)
        # From nothing, so that each is the result of the same contact alone.
        self.solvers = {}
        for k, ball in enumerate(self.now.balls):
            if not ball.loaded or self.now.placement.reason:
                self.now = self.now.with_ball(k, contacts={})
                continue
            self.now = self._solved(self.now, k, self.whole)
            if self.problem.rolls:
                self.now = self.now.with_ball(k, integrals={ring: integrals_of(solved.result.scalars)
                                                            for ring, solved in self.now.balls[k].contacts.items()})
        now = self.now
        solved = SolvedBearing(self.problem, now.placement, now.balls, reason or now.placement.reason, self.rounds, self.solves)
        loaded = [ball for ball in now.balls if ball.loaded]
        if not (self.problem.balances and not solved.reason and all(ball.slopes for ball in loaded)):
            return solved
        grids = min(len(self._solver(ball, ring).last[1]) for ball in loaded for ring in RINGS)
        return replace(
            solved, left=sum(self._power_left(ball) for ball in loaded), settled=self._with_forces(None),
            coarser=tuple(self._with_forces(partial(self._on_grid, level=-n)) for n in range(min(grids, 3), 0, -1)),
            doubted=tuple(self._with_forces(partial(self._off_by_error, of=ring, name=name))
                          for ring in RINGS for name in WRENCH))

    def _by_race_control(self) -> str:
        """Place all balls with the centrifugal forces of race control; the reason if nothing holds them."""
        ring = self.problem.controlling
        for _ in range(MOST_ROUNDS if self.problem.rolls and not self.now.placement.reason else 0):
            # The cage has the speed of pure rolling, and with balls that one ring alone touches the mean of the others.
            placement = self.now.placement
            speeds = np.array([self.problem.race_control(angles, ring)[0] if loads.min() > 0.0 else math.nan
                               for angles, loads in zip(placement.angles, placement.loads, strict=True)])
            mean = float(np.nanmean(speeds)) if not np.isnan(speeds).all() else (
                self.problem.race_control(np.zeros(2), ring)[0])
            before, cage = self.now.cage, np.where(np.isnan(speeds), mean, speeds)
            self.now = self.now.placed(cage=cage)
            if self.now.placement.reason or np.abs(cage - before).max() <= 1e-11 * np.abs(cage).max():
                break
        return self.now.placement.reason

    @property
    def whole(self) -> Problem:
        """What is asked of each contact; of rings at rest only what the load does."""
        contact = self.problem.contact
        return contact if self.problem.rolls else replace(
            contact, friction=replace(contact.friction, coefficient=0.0, law=None), motion=Motion(1.0, differential_slip=False),
            heating=replace(contact.heating, heat=False, deformation=False))

    def at_rest(self) -> list[Ball]:
        """The loaded balls as placed without centrifugal forces and friction, those alike as one, the largest load first."""
        self.now = Arrangement.first(self.problem, np.zeros(self.problem.balls)).gathered()
        return [ball for ball in self.now.balls if ball.loaded]

    def _continue(self, before: BearingSearch) -> None:
        """Begin with the axes, the slopes and, in proportion, the friction of the balls of another bearing."""
        ratio = np.diff(self.problem.speeds)[0] / np.diff(before.problem.speeds)[0]
        for k, ball in enumerate(self.now.balls):
            was = next(each for each in before.now.balls if ball.members[0] in each.members)
            if not (ball.loaded and was.loaded and was.slopes):
                continue
            inner, outer = (self.problem.race_control(ball.angles, ring) - ratio * before.problem.race_control(was.angles, ring)
                            for ring in RINGS)
            for ring in RINGS:
                self._solver(ball, ring).last = before._solver(was, ring).last
            # Contacts only say here that the ball begins with them: the first round solves them at its own motion.
            self.now = self.now.with_ball(k, slopes=was.slopes, contacts=was.contacts)
            share = self.now.limit(ball) / before.now.limit(was)
            motion, friction = ratio * was.motion + 0.5 * (inner + outer), share * before.now.friction_on(was)
            self.now = self.now.moved({k: np.concatenate([motion - ball.motion, friction])})

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

    # --- contacts ------------------------------------------------------------------------------------------------------

    def _solver(self, ball: Ball, ring: RingName) -> ContactSolver:
        return self.solvers.setdefault((ball.members, ring), ContactSolver(self.threads))

    def _solved(self, now: Arrangement, k: int, contact: Problem) -> Arrangement:
        """With both contacts of ball `k` solved at its motion."""
        ball, contacts = now.balls[k], dict[RingName, SolvedContact]()
        for ring, angle, load in zip(RINGS, ball.angles.tolist(), ball.loads.tolist(), strict=True):
            if not self.problem.rolls:
                slow = np.array([self.problem.speeds[0] - 1.0, 0.0, 0.0, 0.0])
                problem = replace(self.problem.contact_problem(contact, ring, angle, load, slow), motion=contact.motion)
            else:
                problem = self.problem.contact_problem(contact, ring, angle, load, ball.motion)
            contacts[ring] = self._contact(now, ball, ring, problem)
        return now.with_ball(k, contacts=contacts)

    def _contact(self, now: Arrangement, ball: Ball, ring: RingName, problem: Problem) -> SolvedContact:
        try:
            result = self._solver(ball, ring).solve(problem)
        except Unsolvable as cause:
            name = f"the {ring} contact of {ball.names}, of {problem.normal_force:.4g} N"
            raise Unsolvable(f"{name}, cannot be solved: {cause}", "bearing.load",
                             'other loads, or patches = "plane" in [bearing]') from None
        self.solves += 1
        angle = float(ball.angles[RINGS.index(ring)])
        return SolvedContact.of(self.problem, ring, angle, result, now.friction_limit(ball, ring))

    def _slopes(self, now: Arrangement, ball: Ball, contact: Problem) -> dict[RingName, Array]:
        """Slopes of the wrenches of both contacts of a ball by differences."""
        slopes = {}
        for ring, angle, load in zip(RINGS, ball.angles.tolist(), ball.loads.tolist(), strict=True):
            here, unit, columns = ball.contacts[ring], now.unit(ball, ring), []
            shaped = self.problem.contact_problem(contact, ring, angle, load, ball.motion)
            for axis in range(3):
                x, y, spin = (here.creepages + DIFFERENCE * unit * np.eye(3)[axis]).tolist()
                moved = replace(shaped, motion=replace(shaped.motion, creepage_x=x, creepage_y=y, spin=spin))
                columns.append((self._contact(now, ball, ring, moved).wrench - here.wrench) / DIFFERENCE)
            slopes[ring] = np.array(columns).T * (now.saturation(ball, ring) / unit)
        return slopes

    # --- one ball ------------------------------------------------------------------------------------------------------

    def _in_balance(self, now: Arrangement, k: int, contact: Problem, tolerance: float) -> Arrangement:
        """Move ball `k`, and its place with its friction, until what is left of its conditions falls below `tolerance`, or
        nothing more helps."""
        fresh, radius, whole = False, LONGEST, 0.0
        for _ in range(MOST_STEPS):
            if now.left(now.balls[k]) <= tolerance or self.solves >= self.most_solves:
                break
            if not now.balls[k].slopes or radius < SHORTEST * min(whole, LONGEST):
                if fresh:
                    break
                now = now.with_ball(k, slopes=self._slopes(now, now.balls[k], contact))
                fresh, radius = True, LONGEST
            step, size, whole = self._step(now, now.balls[k], radius)
            trial = now.moved({k: step})
            if trial.balls[k].loaded and not trial.placement.reason:
                trial = self._solved(trial, k, contact)
                closer = self._closer(now, trial, k, step, size, whole, tolerance)
                slopes = self._corrected(now.balls[k], trial.balls[k], now, closer=closer)
                if closer:
                    now = trial.with_ball(k, slopes=slopes)
                    radius, fresh = min(LONGEST, LONGER * radius), False
                    continue
                now = now.with_ball(k, slopes=slopes)
            if now.turned(now.balls[k]) <= STILL or not now.balls[k].loaded:
                radius = SHORTER * size
            else:
                # The friction of other balls has turned the contacts since they were solved: what was left is an estimate.
                now = self._solved(now, k, contact)
        return now

    def _step(self, now: Arrangement, ball: Ball, radius: float = LONGEST) -> tuple[Array, float, float]:
        """Newton's step within a `radius`, its largest change of a creepage, in the unit of steps, and that of the whole
        step."""
        rest = now.rest(ball)
        (whole,), size, _ = now.newton([ball], [rest], now.common)
        step = whole if size <= radius else now.newton([ball], [rest], now.common, radius)[0][0]
        # Surfaces go on flowing the same way in both contacts, at half of their speed at least.
        flows = [[self.problem.slip(ring, float(angle), motion)[0] for motion in (ball.motion, ball.motion + step[:4])]
                 for ring, angle in zip(RINGS, ball.angles, strict=True)]
        step = step * min(1.0, *(0.5 / max(1.0 - after / before, 0.5) for before, after in flows))
        return step, max(float(np.abs(now.changes(ball, ring) @ step / now.unit(ball, ring)).max()) for ring in RINGS), size

    def _closer(self, now: Arrangement, trial: Arrangement, k: int, step: Array, size: float, whole: float,
                tolerance: float) -> bool:
        """Whether a `trial`, which has made a `step` of a `size` towards the `whole` one, is closer to the balance."""
        ball, left, leaves = now.balls[k], now.left(now.balls[k]), trial.left(trial.balls[k])
        if leaves <= max(tolerance, LESS * left):
            return True
        promised = float(np.linalg.norm((now.rest(ball) + now.jacobian(ball) @ step) * now.weights(ball)))
        if now.common is None and left - leaves >= PROMISED * (left - promised) > 0.0:
            return True
        shorter = (1.0 - CLOSER * min(1.0, size / whole)) * whole
        return leaves < MORE * max(left, NEARLY) and self._step(trial, trial.balls[k])[2] < shorter

    def _corrected(self, was: Ball, found: Ball, now: Arrangement, *, closer: bool) -> dict[RingName, Array]:
        """Slopes that give the change of the wrenches since the last step, if that tells any."""
        slopes = dict(was.slopes)
        for ring in RINGS:
            change = found.contacts[ring].creepages - was.contacts[ring].creepages
            steps, along = change / now.unit(found, ring), change / now.saturation(found, ring)
            missed = found.contacts[ring].wrench - was.contacts[ring].wrench - slopes[ring] @ along
            if TELLS < float(np.abs(steps).max()) < (math.inf if closer else NEAR):
                slopes[ring] = slopes[ring] + np.outer(missed, along) / float(along @ along)
        return slopes

    # --- all balls -----------------------------------------------------------------------------------------------------

    def _balance(self, contact: Problem, tolerance: float) -> str:
        """Rounds over all balls until nothing changes; else why not."""
        for k, ball in enumerate(self.now.balls):
            if ball.contacts:
                self.now = self._solved(self.now, k, contact)
        left, idle, unbalanced, turned, together = 0.2, 0, 0.0, 0.0, False
        self.most_solves = self.solves + MOST_SOLVES * sum(ball.loaded for ball in self.now.balls)
        for _ in range(MOST_ROUNDS):
            self.rounds += 1
            if not any(ball.loaded for ball in self.now.balls):
                return NOTHING_PRESSED
            alone = not together
            if alone:  # else all get closer together: one ball alone moves the others apart again
                self._round(contact, tolerance, left)
            if self.now.placement.reason:
                return self.now.placement.reason
            # Pockets of balls that are alike have no forces.
            if self.problem.common_cage and sum(ball.loaded for ball in self.now.balls) > 1:
                unbalanced, turned = self._turn_cage(turned, tolerance)
            self._carry_along()
            if self.now.placement.reason:
                return self.now.placement.reason
            known = [ball for ball in self.now.balls if ball.loaded and ball.contacts]
            before, left = left, max(map(self.now.counts, known), default=math.inf)
            together = len(known) > 1 and left > max(tolerance, SLOW * before)
            if together:
                was, left = left, self._together(contact, tolerance)
                together = left < SLOW * was
            self.report("bearing", {"iteration": self.rounds, "residual": left})
            if left <= tolerance and unbalanced <= tolerance and all(ball.contacts for ball in self.now.balls if ball.loaded):
                return ""
            idle = idle + alone if left > SLOW * before and unbalanced <= tolerance else 0
            if idle == MOST_IDLE or self.solves >= self.most_solves:
                break
        if left <= CONTAINED and unbalanced <= tolerance and all(ball.contacts for ball in self.now.balls if ball.loaded):
            return ""
        if left <= tolerance:
            return f"the cage found no common speed: its pockets are left with {unbalanced:.1e} of the friction limit"
        return self._unbalanced(max((ball for ball in self.now.balls if ball.contacts and ball.loaded), key=self.now.counts))

    def _round(self, contact: Problem, tolerance: float, left: float) -> None:
        """Each loaded ball in turn. The friction of every ball moves the ring: all of them get closer together, from what is
        `left`. Of a ball that carries little more may be left, over its own limit, as it moves the bearing less."""
        order, last = [k for k, ball in enumerate(self.now.balls) if ball.loaded], None
        wanted = tolerance if len(order) == 1 else max(0.5 * tolerance, 0.05 * left)
        for k in order:
            if not (ball := self.now.balls[k]).loaded:  # the friction of those before has freed it
                continue
            within = wanted * min(LENIENT, self.now.largest_limit / self.now.limit(ball))
            new = not ball.contacts
            if new and last is not None:
                self.now = self._following(self.now, k, self.now.balls[last], contact)
            if self.now.balls[k].contacts:
                self.now = self._in_balance(self.now, k, contact, within)
            if new and (not self.now.balls[k].contacts or self.now.left(self.now.balls[k]) > max(within, NEARLY)):
                self.now = self._begun(self.now, k, contact, within)
            last = k

    def _together(self, contact: Problem, tolerance: float) -> float:
        """Newton's steps of all balls at once, as far as slopes hold, while these promise to leave less; what is left then."""
        loaded, radius = [k for k, ball in enumerate(self.now.balls) if ball.loaded], LONGEST
        for k in loaded:
            if not self.now.balls[k].slopes:
                self.now = self.now.with_ball(k, slopes=self._slopes(self.now, self.now.balls[k], contact))
        left = _of_all(self.now)
        for _ in range(MOST_TOGETHER):
            if left <= tolerance or radius < SHORTEST:
                break
            now, balls = self.now, [self.now.balls[k] for k in loaded]
            steps, size, promised = now.newton(balls, [now.rest(ball) for ball in balls], now.common, radius)
            if promised > (1.0 - CLOSER) * left:
                break
            trial = now.moved(dict(zip(loaded, steps, strict=True)))
            if trial.placement.reason or not all(trial.balls[k].loaded for k in loaded):
                radius = SHORTER * size
                continue
            for k in loaded:
                trial = self._solved(trial, k, contact)
            leaves = _of_all(trial)
            kept = (left - leaves) / (left - promised)
            closer = kept >= PROMISED
            self.now = trial if closer else now
            for k in loaded:
                self.now = self.now.with_ball(k, slopes=self._corrected(now.balls[k], trial.balls[k], now, closer=closer))
            left, radius = (leaves, min(LONGEST, (LONGER if kept > LESS else 1.0) * size)) if closer else (left, SHORTER * size)
        return max(self.now.counts(self.now.balls[k]) for k in loaded)

    def _carry_along(self) -> None:
        """Balls that one ring alone touches have no friction and go round as the others do, at their mean."""
        carried = [j for ball in self.now.balls if ball.loaded for j in ball.members]
        free = [j for j in range(self.problem.balls) if j not in carried]
        on_balls, on_ring, cage = self.now.on_balls.copy(), self.now.on_ring.copy(), self.now.cage.copy()
        on_balls[free] = on_ring[free] = 0.0
        cage[free] = float(np.mean(cage[carried])) if carried else 0.0
        self.now = self.now.placed(on_balls=on_balls, on_ring=on_ring, cage=cage)

    def _unbalanced(self, ball: Ball) -> str:
        """Why a ball is not in balance."""
        of_tractions, left = self.now.limit(ball) * self.problem.ball_diameter, self.now.left(ball)
        gyroscopic, carried = float(np.linalg.norm(self.problem.gyroscopic(ball.motion))), 100.0 * float(
            ball.loads.max() / self.now.placement.loads.max())
        if gyroscopic > 0.5 * of_tractions:
            return (f"{ball.names}: no axis was found, {left:.1e} of the friction limit are left over; its gyroscopic moment "
                    f"of {1e3 * gyroscopic:.3g} N mm is near what friction holds, {1e3 * of_tractions:.3g} N mm: more load, "
                    "more friction or less speed keeps it")
        share = "" if carried > 99.9 else f", which carries {carried:.2g} % of the largest load"
        return (f"{ball.names}{share}: the tractions of its contacts do not balance, {left:.1e} of its friction limit are left "
                'over; another numerics.grid may find the balance, and control = "outer" or "inner" in [bearing] has loads and '
                "contacts without it")

    def _begun(self, now: Arrangement, k: int, contact: Problem, tolerance: float) -> Arrangement:
        """Ball `k` in balance from nothing: from the start that leaves least of its conditions, or, if that fails, the next."""
        ball, bearing, starts = now.balls[k], self.problem, []
        held = float(np.linalg.norm(bearing.gyroscopic(ball.motion))) < now.limit(ball) * bearing.ball_diameter
        outer, inner = (partial(bearing.race_control, ring=ring) for ring in ("outer", "inner"))
        for last, start in ((not held, outer), (not held, lambda angles: 0.5 * (outer(angles) + inner(angles))),
                            (not held, inner), (held, bearing.along_the_bearing)):
            # The speed places the ball, and its place turns the axis.
            step = np.concatenate([start(ball.angles) - ball.motion, -now.friction_on(ball)])
            trial = now.with_ball(k, slopes={}, contacts={}).moved({k: step})
            if trial.balls[k].loaded:
                trial = self._solved(trial.with_ball(k, motion=start(trial.balls[k].angles)), k, contact)
                starts.append((last, trial.left(trial.balls[k]), trial))
        found = []
        for _, _, trial in sorted(starts, key=lambda start: start[:2]):
            trial = self._in_balance(trial, k, contact, tolerance)
            found.append((trial.left(trial.balls[k]), trial))
            if found[-1][0] <= max(tolerance, NEARLY):
                break
        return min(found, key=lambda each: each[0])[1] if found else now

    def _following(self, now: Arrangement, k: int, before: Ball, contact: Problem) -> Arrangement:
        """With the first motion of ball `k`: between both race controls, as far as the ball before, and with its slopes."""
        ball = now.balls[k]
        inner, outer = (self.problem.race_control(ball.angles, ring) for ring in RINGS)
        its = [self.problem.race_control(before.angles, ring) for ring in RINGS]
        for ring in RINGS:
            self._solver(ball, ring).last = self._solver(before, ring).last
        motion = 0.5 * (inner + outer) + before.motion - 0.5 * (its[0] + its[1])
        return self._solved(now.with_ball(k, motion=motion, slopes=before.slopes), k, contact)

    def _turn_cage(self, last: float, tolerance: float) -> tuple[float, float]:
        """Change the speed that all balls share so that the forces of their pockets vanish together, by at most four times the
        `last` change, or seven tenths of it back; the first time each ball has its own speed. How large the forces were, over
        the friction limit of all balls, and the change."""
        loaded = [ball for ball in self.now.balls if ball.loaded]
        force, speed = _of_pockets(self.now, loaded, [self.now.rest(ball) for ball in loaded])
        if self.now.common is None:
            self.now = replace(self.now, common=speed)
        elif force > tolerance:
            step = speed - self.now.common
            slides = LONGEST * abs(self.now.common) * float(self.now.saturation(loaded[0], "outer")[0])
            most = (4.0 if step * last > 0.0 else 0.7) * abs(last) or slides
            last = min(max(step, -most), most)
            self.now = replace(self.now, common=self.now.common + last)
        return force, last

    # --- what is known of it -------------------------------------------------------------------------------------------

    def _power_left(self, ball: Ball) -> float:
        """Power in W of what is left of the conditions of all balls like this one: heat and forces differ by as much."""
        rest, motion = np.abs(self.now.rest(ball)[:4]), np.abs(ball.motion)
        if self.now.common is not None:
            rest[0] = 0.0  # its pocket has it
        arms = np.array([0.5 * self.problem.pitch_diameter, *[0.5 * self.problem.ball_diameter] * 3])
        return len(ball.members) * float(rest @ (arms * motion))

    def _with_forces(self, apart_of: Callable[[Ball, RingName], dict[str, float]] | None) -> SolvedBearing:
        """The bearing that follows, by the slopes of its balls, if the integrals of each contact are as far `apart_of` those
        found; None: with nothing left of its conditions."""
        now = self.now
        loaded = [ball for ball in now.balls if ball.loaded]
        apart = {ball.members: {ring: apart_of(ball, ring) if apart_of else dict.fromkeys(INTEGRALS, 0.0) for ring in RINGS}
                 for ball in loaded}
        missing = [now.rest(ball) if apart_of is None else sum(
            (self._acting(ball, ring, apart[ball.members][ring]) for ring in RINGS), np.zeros(8)) for ball in loaded]
        common = None if now.common is None else _of_pockets(now, loaded, missing)[1]
        steps = now.newton(loaded, missing, common)[0]
        then = now.moved({now.balls.index(ball): step for ball, step in zip(loaded, steps, strict=True)})
        moved = [replace(new, integrals={ring: self._followed(was, new, ring, apart[was.members][ring]) for ring in RINGS})
                 if was.loaded else new for was, new in zip(now.balls, then.balls, strict=True)]
        return SolvedBearing(self.problem, then.placement, moved)

    def _on_grid(self, ball: Ball, ring: RingName, level: int) -> dict[str, float]:
        """By how much the integrals of a contact differ on the grid `level` (−1: the last one), in place of those that are
        extrapolated from all."""
        on_grid = integrals_of(self._solver(ball, ring).last[1][level].reported.scalars)
        return {name: on_grid[name] - ball.integrals[ring][name] for name in INTEGRALS}

    def _off_by_error(self, ball: Ball, ring: RingName, of: RingName, name: str) -> dict[str, float]:
        """The estimated error of one of the integrals of the contact with the ring `of`."""
        error = integrals_of(ball.contacts[ring].result.uncertainty)[name] if ring == of else 0.0
        return dict.fromkeys(INTEGRALS, 0.0) | {name: error}

    def _acting(self, ball: Ball, ring: RingName, integrals: Mapping[str, float]) -> Array:
        """What `integrals` of a contact contribute to the conditions of its ball; forces act D/2 from its centre."""
        along, across, *moments = (integrals[name] for name in WRENCH)
        spin, brakes = (2e-3 * moment / self.problem.ball_diameter for moment in moments)
        wrench = np.array([0.0, along, across, spin, -across, along - brakes])
        return self.now.conditions(ball, ring, wrench / self.now.friction_limit(ball, ring))

    def _followed(self, was: Ball, new: Ball, ring: RingName, off: Mapping[str, float]) -> dict[str, float]:
        """The integrals of a contact after its ball has moved, `off` by others: forces and moments follow the creepages by the
        slopes of the wrench, heat is their power."""
        here, integrals = was.contacts[ring].creepages, was.integrals[ring]
        moved = self.problem.creepages(ring, float(new.angles[RINGS.index(ring)]), new.motion) - here
        wrench = self.now.friction_limit(was, ring) * (was.slopes[ring] @ (moved / self.now.saturation(was, ring)))
        half = 0.5 * self.problem.ball_diameter
        follow, brakes = wrench[1:4] * [1.0, 1.0, half], half * float(wrench[1] - wrench[5])
        forces = np.array([integrals["force_x_N"], integrals["force_y_N"], 1e-3 * integrals["spin_moment_Nmm"]])
        speed, _, rolling = self.problem.slip(ring, float(was.angles[RINGS.index(ring)]), was.motion)
        power = float((forces + follow) @ moved + follow @ here) + brakes * abs(rolling) / speed
        changes = (*(follow * [1.0, 1.0, 1e3]).tolist(), 1e3 * brakes, speed * power, power, 0.0)
        ratio = float(new.loads[RINGS.index(ring)] / was.loads[RINGS.index(ring)])
        return {name: ratio * (integrals[name] + off[name] + change) for name, change in zip(INTEGRALS, changes, strict=True)}


def _of_all(now: Arrangement) -> float:
    """What is left of the conditions of all balls, over the friction limit of the one that carries most."""
    return math.hypot(*(now.counts(ball) for ball in now.balls if ball.loaded))


def _of_pockets(now: Arrangement, loaded: Sequence[Ball], rests: Sequence[Array]) -> tuple[float, float]:
    """The force of all pockets along the pitch circle, over the friction limit, that `rests` of all balls would leave, and the
    common speed at which it vanishes, by the slopes of the balls."""
    force, slope, towards, limit = 0.0, 0.0, 0.0, 0.0
    for ball, rest in zip(loaded, rests, strict=True):
        count, slopes = len(ball.members), now.jacobian(ball)
        follow = np.linalg.lstsq(slopes[1:, 1:], np.stack([rest[1:], slopes[1:, 0]], -1), rcond=1e-10)[0]
        own, its = np.array([rest[0], slopes[0, 0]]) - slopes[0, 1:] @ follow
        force, slope, towards = force + count * own, slope + count * its, towards + count * its * ball.motion[0]
        limit += count * now.limit(ball)
    return abs(force) / limit, (towards - force) / slope

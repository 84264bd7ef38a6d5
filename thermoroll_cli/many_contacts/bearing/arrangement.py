"""Where a bearing is on the way to its balance, and what is left of the conditions of its balls.

Eight conditions hold of a ball. Four are of its motion, the speed of the cage and the ball's angular velocity: no force along
the pitch circle, and moments of both contacts that turn the ball's axis with the cage, J ω_m e_a × ω_b. Four are of its place:
tractions push the ball, and the inner ring with it, axially and outwards, with the friction with which it was placed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.bearing.bearing_problem import RINGS, BearingProblem, RingName
from thermoroll_cli.many_contacts.bearing.placement import LIGHT, Placement, place
from thermoroll_cli.many_contacts.bearing.tractions import SolvedContact
from thermoroll_cli.tools.arrays import Array

BALANCED = 2e-5
"""Forces and moments over half of the diameter that are left of a ball's balance, over the largest friction limit of a ball."""
SETTLED = 5e-4
"""Difference of the friction that pushes a ball axially and outwards from that with which it was placed, over the same."""
CONDITIONS = np.repeat([1.0, BALANCED / SETTLED], 4)
"""How much each of the eight conditions counts."""
FAST = 5.0
"""A contact slides fast at more than as many times the creepages at which it begins to slide all over: there only the ratios of
its creepages count, and what follows are shares of them."""
ALIKE = 1e-9
"""Relative difference of loads and angles of balls that are solved as one."""
DAMPINGS = np.logspace(-9.0, 3.0, 49)
"""Weights of the changes of creepages, over their unit, beside what is left of the conditions, over the friction limit."""


@dataclass(frozen=True, eq=False)
class Ball:
    """Balls with the same loads and angles, by their numbers from 0, `members`.

    - `motion`: as of `BearingProblem.slip`; `loads` (N) and `angles` (rad) at the inner and the outer ring, and whether it is
      `loaded` by both;
    - for each ring its `contacts`, and the `slopes` of their wrenches with the creepages, over those at which they slide;
    - the `INTEGRALS` of both contacts."""

    members: tuple[int, ...]
    motion: Array
    loads: Array
    angles: Array
    loaded: bool
    contacts: Mapping[RingName, SolvedContact] = field(default_factory=dict)
    slopes: Mapping[RingName, Array] = field(default_factory=dict)
    integrals: Mapping[RingName, Mapping[str, float]] = field(default_factory=dict)

    @property
    def where(self) -> list[int]:
        return list(self.members)

    @property
    def names(self) -> str:
        """As messages have it, the numbers of alike balls from 1."""
        return f"ball {self.members[0] + 1}"


@dataclass(frozen=True, eq=False)
class Arrangement:
    """A bearing that is `placed` with the friction on its balls and, through each of them, on the inner ring (`on_balls`,
    `on_ring`, (n, 2) in N), and with the speeds (n,) with which they go round (`cage`, rad/s). `balls` has those alike as one;
    `common` is the speed that all have to share, None where each has its own."""

    problem: BearingProblem
    placement: Placement
    on_balls: Array
    on_ring: Array
    cage: Array
    balls: tuple[Ball, ...] = ()
    common: float | None = None

    @classmethod
    def first(cls, problem: BearingProblem, cage: Array) -> Arrangement:
        """One without friction."""
        none = np.zeros((problem.balls, 2))
        return cls(problem, place(problem, problem.centrifugal(cage), none, none), none, none, cage)

    # --- steps: each is another arrangement ----------------------------------------------------------------------------

    def placed(self, **changes: Any) -> Arrangement:
        """With `changes` of friction and speeds, and all balls where these place them."""
        new = replace(self, **changes)
        new = replace(new, placement=place(new.problem, new.problem.centrifugal(new.cage), new.on_balls, new.on_ring,
                                           self.placement))
        return replace(new, balls=tuple(new._put(ball) for ball in new.balls))

    def _put(self, ball: Ball) -> Ball:
        loads, angles = (of[ball.members[0]] for of in (self.placement.loads, self.placement.angles))
        return replace(ball, loads=loads, angles=angles, loaded=bool(loads.min() > LIGHT * self.placement.loads.max()))

    def gathered(self) -> Arrangement:
        """With balls alike as one, from the largest load to the smallest, and the motion of race control."""
        problem, loads, angles = self.problem, self.placement.loads, self.placement.angles
        kinds: list[list[int]] = []
        scale = np.array([loads.max() or 1.0] * 2 + [1.0, 1.0])
        states = np.hstack([loads, np.where(loads > 0.0, angles, 0.0)]) / scale
        for j in np.argsort(-loads[:, 0], kind="stable").tolist():
            kind = next((kind for kind in kinds if np.abs(states[kind[0]] - states[j]).max() < ALIKE), None)
            if kind is None:
                kinds.append([j])
            else:
                kind.append(j)
        balls = []
        for kind in kinds:
            still = np.array([self.cage[kind[0]], 0.0, 0.0, 0.0])
            ball = self._put(Ball(tuple(sorted(kind)), still, loads[kind[0]], angles[kind[0]], False))
            rolls = ball.loaded and problem.rolls
            balls.append(replace(ball, motion=problem.race_control(ball.angles, problem.controlling)) if rolls else ball)
        return replace(self, balls=tuple(balls))

    def with_ball(self, k: int, **changes: Any) -> Arrangement:
        """With changes of ball `k` alone, which move nothing."""
        return replace(self, balls=(*self.balls[:k], replace(self.balls[k], **changes), *self.balls[k + 1 :]))

    def moved(self, steps: Mapping[int, Array]) -> Arrangement:
        """With balls k moved by `steps` (8,): changes of the motion, and of the friction that pushes them and, through them,
        the inner ring."""
        on_balls, on_ring, cage, balls = self.on_balls.copy(), self.on_ring.copy(), self.cage.copy(), list(self.balls)
        for k, step in steps.items():
            balls[k] = replace(balls[k], motion=balls[k].motion + step[:4])
            where = balls[k].where
            on_balls[where], on_ring[where] = on_balls[where] + step[4:6], on_ring[where] + step[6:]
            cage[where] = balls[k].motion[0]
        return self.placed(balls=tuple(balls), on_balls=on_balls, on_ring=on_ring, cage=cage)

    def friction_on(self, ball: Ball) -> Array:
        """The friction (4,) with which a ball is placed."""
        first = ball.members[0]
        return np.concatenate([self.on_balls[first], self.on_ring[first]])

    # --- contacts ------------------------------------------------------------------------------------------------------

    def friction_limit(self, ball: Ball, ring: RingName) -> float:
        """Friction limit of a contact in N."""
        return self.problem.contact.friction.coefficient * float(ball.loads[RINGS.index(ring)])

    def limit(self, ball: Ball) -> float:
        """Friction limit of a ball in N."""
        return max(self.friction_limit(ball, ring) for ring in RINGS)

    @property
    def largest_limit(self) -> float:
        """Friction limit in N of the ball that carries most."""
        return max((self.limit(ball) for ball in self.balls), default=0.0)

    def saturation(self, ball: Ball, ring: RingName) -> Array:
        """Creepages and spin at which a contact slides all over."""
        k = RINGS.index(ring)
        return self.problem.saturation(ring, float(ball.angles[k]), float(ball.loads[k]))

    def unit(self, ball: Ball, ring: RingName) -> Array:
        """Unit of steps: creepages and spin at which a contact slides all over; where it slides fast, as many times as much."""
        saturation = self.saturation(ball, ring)
        return saturation * max(1.0, float(np.linalg.norm(ball.contacts[ring].creepages / saturation)) / FAST)

    def creepages(self, ball: Ball, ring: RingName) -> Array:
        """Creepages and spin (rad/m) of a contact as its ball moves now."""
        return self.problem.creepages(ring, float(ball.angles[RINGS.index(ring)]), ball.motion)

    def turned(self, ball: Ball) -> float:
        """Largest change of a creepage, in the unit of steps, since the contacts of a ball were solved."""
        return max(float(np.abs((self.creepages(ball, ring) - ball.contacts[ring].creepages) / self.unit(ball, ring)).max())
                   for ring in RINGS)

    # --- conditions ----------------------------------------------------------------------------------------------------

    def conditions(self, ball: Ball, ring: RingName, wrench: Array) -> Array:
        """What a contact's tractions, `wrench` (6, …), contribute to the conditions of a ball (8, …), in N: the force along the
        pitch circle, the moments over D/2, the force that pushes the ball axially and outwards, and that on the inner ring."""
        frame = np.array(self.problem.frame(ring, float(ball.angles[RINGS.index(ring)]))).T * self.friction_limit(ball, ring)
        force, moment = frame @ wrench[:3], frame @ wrench[3:]
        return np.concatenate([force[2:], moment, force[:2], -force[:2] if ring == "inner" else np.zeros_like(force[:2])])

    def rest(self, ball: Ball) -> Array:
        """What is left of the conditions of a ball (8,), in N; the last four are how much the friction that was found differs
        from that with which the ball was placed. Since its contacts were solved they follow their slopes."""
        total = -np.concatenate([np.zeros(4), self.friction_on(ball)])
        total[1:4] -= 2.0 / self.problem.ball_diameter * self.problem.gyroscopic(ball.motion)
        for ring in RINGS:
            solved = ball.contacts[ring]
            moved = (self.creepages(ball, ring) - solved.creepages) / self.saturation(ball, ring)
            total += self.conditions(ball, ring, solved.wrench + (ball.slopes[ring] @ moved if ball.slopes else 0.0))
        return total

    def weights(self, ball: Ball) -> Array:
        """Of the conditions (8,) in 1/N, over the ball's friction limit."""
        return CONDITIONS / self.limit(ball)

    def left(self, ball: Ball) -> float:
        """What is left of the conditions of a ball, over its friction limit. With a common cage its speed counts in place of
        the force along the pitch circle, over that at which the ball slides."""
        rest = self.rest(ball) * self.weights(ball)
        if self.common is not None:
            rest[0] = (ball.motion[0] - self.common) / (float(self.saturation(ball, "outer")[0]) * self.common)
        return float(np.linalg.norm(rest))

    def counts(self, ball: Ball) -> float:
        """The same over the friction limit of the ball that carries most: what it means to the bearing."""
        return self.left(ball) * self.limit(ball) / self.largest_limit

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
        step = 1e-6 * float(np.linalg.norm(ball.motion))
        angle, here = float(ball.angles[RINGS.index(ring)]), self.creepages(ball, ring)
        by_motion = [(self.problem.creepages(ring, angle, ball.motion + step * unit) - here) / step for unit in np.eye(4)]
        return np.hstack([np.transpose(by_motion), self.turning(ball, ring, ball)])

    def turning(self, ball: Ball, ring: RingName, other: Ball) -> Array:
        """Derivatives of the creepages of a contact with the friction with which an `other` ball is placed, (3, 4), which turns
        the contact."""
        k, tilt = RINGS.index(ring), 1e-6
        turned = self.problem.creepages(ring, float(ball.angles[k]) + tilt, ball.motion) - self.creepages(ball, ring)
        return np.outer(turned / tilt, self.placement.turned[ball.members[0], k, other.where].sum(axis=0))

    # --- Newton's step -------------------------------------------------------------------------------------------------

    def newton(
        self, balls: Sequence[Ball], rests: Sequence[Array], common: float | None, radius: float = math.inf
    ) -> tuple[Array, float, float]:
        """The changes (n, 8) of the motion of `balls` and of the friction with which they are placed that take their `rests`
        away, as each turns the contacts of the others by its friction; their largest change of a creepage, in the unit of
        steps; and what they leave by the slopes, over the largest friction limit of these balls.

        Where the largest change is above `radius` these are the changes within it that leave least (Levenberg 1944). If all
        cages come to the speed `common`, pockets take the forces along the pitch circle."""
        count, limit = len(balls), max(map(self.limit, balls))
        slopes, moves = np.zeros((count, 8, count, 8)), np.zeros((count, 6, count, 8))
        for i, ball in enumerate(balls):
            slopes[i, :, i] = self.jacobian(ball)
            for j, other in enumerate(balls):
                for rows, ring in zip((slice(0, 3), slice(3, 6)), RINGS, strict=True):
                    changes = self.changes(ball, ring) if j == i else np.hstack(
                        [np.zeros((3, 4)), self.turning(ball, ring, other)])
                    moves[i, rows, j] = changes / self.unit(ball, ring)[:, None]
                    if j != i:
                        turned = changes / self.saturation(ball, ring)[:, None]
                        slopes[i, :, j] += self.conditions(ball, ring, ball.slopes[ring] @ turned)
        given, free = np.zeros((count, 8)), np.tile(np.arange(8) >= (0 if common is None else 1), count)
        given[:, 0] = 0.0 if common is None else [common - float(ball.motion[0]) for ball in balls]
        unit = np.concatenate([np.repeat([self.problem.contact.friction.coefficient * float(np.linalg.norm(ball.motion)),
                                          self.limit(ball)], 4) for ball in balls])
        weights = np.tile(CONDITIONS, count) / limit
        over = weights[:, None] * slopes.reshape(8 * count, 8 * count)
        rest, moving = weights * np.ravel(rests), moves.reshape(6 * count, 8 * count)
        wanted, moved = -(rest + over @ given.ravel())[free], -moving @ given.ravel()
        matrix, lengths = (over * unit)[np.ix_(free, free)], (moving * unit)[:, free]

        def least(damping: float) -> tuple[Array, float]:
            step = given.ravel().copy()
            step[free] += unit[free] * np.linalg.lstsq(
                np.vstack([matrix, damping * lengths]) if damping else matrix,
                np.concatenate([wanted, damping * moved]) if damping else wanted, rcond=1e-10)[0]
            return step, float(np.abs(moving @ step).max())

        step, size = least(0.0)
        if size > radius:
            low, high = 0, len(DAMPINGS) - 1
            while low < high:  # the least damping that is enough
                middle = (low + high) // 2
                low, high = (low, middle) if least(DAMPINGS[middle])[1] <= radius else (middle + 1, high)
            step, size = least(DAMPINGS[low])
            share = min(1.0, radius / size)
            step, size = share * step, share * size
        return step.reshape(count, 8), size, float(np.linalg.norm((rest + over @ step)[free]))

"""Solve a wheelset: rounds of placing it by what is known of its patches, and of solving these where it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from thermoroll_cli.problem.problem import Numerics, Unsolvable
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.wheelset.one_wheel import SAME_PATCH, Bearing, NoHeight, Solved
from thermoroll_cli.wheelset.patch_problem import PatchForces, forces_of, problem_of_patch
from thermoroll_cli.wheelset.standing import Standing, stand
from thermoroll_cli.wheelset.wheelset_problem import SideName, WheelsetProblem

ROUGH_GRID = (32, 32)
"""On which ratios of forces, roll and angular velocity are found before the wanted grid is solved."""
ROUGH_ROUNDS, FINE_ROUNDS = 12, 6
ROUGH_RATIO, RATIO = 1e-3, 1e-4
"""Change of the vertical force over the load from round to round, rough and fine, with which a patch is known."""
ROUGH_DRIVE, DRIVE = 1e-3, 2e-4
"""Unbalanced torque about the axle over radius and friction limit (or traction over the limit), likewise."""
FIRST_STEP, LARGEST_STEP = 1e-4, 4e-3
"""First and largest step of the angular velocity, over itself."""

Report = Callable[[str, Mapping[str, Any]], None]


@dataclass(frozen=True)
class SolvedPatch:
    """A patch where the wheelset stands, with its problem's result and its forces, as of a right wheel."""

    side: SideName
    bearing: Bearing
    result: Result
    forces: PatchForces

    @property
    def solved(self) -> Solved:
        """The ratios of its forces, for the next round."""
        load, place = self.result.problem.normal_force, self.bearing.patch.region.place
        approach = 1e-6 * self.result.coupled.scalars["approach_um"]
        coarse = self.bearing.sunk / self.bearing.over_coarse
        return Solved(place.y, self.forces.force[2] / load, approach / coarse)


@dataclass(frozen=True)
class SolvedWheelset:
    """Where a wheelset stands, its angular velocity (rad/s, about the axle to the right: negative forward), its patches, and
    why it is not in balance (`reason`, empty if it is). `rounds` counts solutions of all patches; `drift` is the last change
    of the ratios of forces."""

    problem: WheelsetProblem
    standing: Standing
    angular_velocity: float
    patches: tuple[SolvedPatch, ...]
    reason: str = ""
    rounds: int = 0
    drift: float = 0.0


class WheelsetSolver:
    """Solves wheelset after wheelset; each begins where the last one stood, and its patches from the last results."""

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._before: SolvedWheelset | None = None
        self._solvers: dict[tuple[bool, SideName], list[tuple[float, Solver]]] = {}

    def solve(self, problem: WheelsetProblem, *, report: Report | None = None) -> SolvedWheelset:
        """The wheelset in balance. Raises Unsolvable where a wheel misses its rail."""
        state = _Search(problem, self._before, report or (lambda stage, info: None), self)
        rough = _rough(problem)
        try:
            if rough is not problem:
                state.rounds_of(rough, ROUGH_ROUNDS, ROUGH_RATIO, ROUGH_DRIVE)
            reason = state.rounds_of(problem, FINE_ROUNDS, RATIO, DRIVE)
        except NoHeight as cause:
            return state.without_height(cause)
        found = SolvedWheelset(problem, state.standing, state.drive.value, state.patches, reason, state.rounds, state.drift)
        self._before = found if not reason else None
        return found

    def solver(self, side: SideName, place: float, *, rough: bool) -> Solver:
        """The solver that has solved the patch nearest to `place` on a side before."""
        known = self._solvers.setdefault((rough, side), [])
        near = min(known, key=lambda entry: abs(entry[0] - place), default=None)
        if near is not None and abs(near[0] - place) < SAME_PATCH:
            known.remove(near)
            solver = near[1]
        else:
            solver = Solver(self.threads)
        known.append((place, solver))
        return solver


@dataclass
class _Drive:
    """A secant for the angular velocity: values and what they leave unbalanced."""

    value: float
    wanted: bool
    seen: list[tuple[float, float]] = field(default_factory=list)

    def move(self, unbalanced: float) -> None:
        """Go on from what the value leaves unbalanced."""
        last = self.seen[-1] if self.seen else None
        self.seen.append((self.value, unbalanced))
        largest = LARGEST_STEP * abs(self.value)
        if last is None or last[0] == self.value or last[1] == unbalanced:
            step = math.copysign(FIRST_STEP * abs(self.value), unbalanced)
        else:
            step = -unbalanced * (self.value - last[0]) / (unbalanced - last[1])
        self.value += min(max(step, -largest), largest)


class _Search:
    """One wheelset on the way to its balance."""

    def __init__(self, problem: WheelsetProblem, before: SolvedWheelset | None, report: Report, solver: WheelsetSolver) -> None:
        self.problem, self.report, self.solver = problem, report, solver
        self.standing: Standing | None
        self.solved: dict[SideName, tuple[Solved, ...]] = {}
        self.patches: tuple[SolvedPatch, ...] = ()
        self.rounds, self.drift = 0, math.inf
        start = problem.motion.angular_velocity
        if problem.finds_speed:
            start = before.angular_velocity if before is not None and before.problem.finds_speed else self._rolling()
        if before is not None:
            self._know(before.patches)
        self.drive = _Drive(start, problem.finds_speed)
        self.standing = None if before is None else before.standing

    def _rolling(self) -> float:
        radius = sum(wheel.radius for wheel in self.problem.wheels.values()) / len(self.problem.wheels)
        return -self.problem.motion.speed / radius

    def rounds_of(self, problem: WheelsetProblem, most: int, ratio: float, drive: float) -> str:
        """Rounds until the ratios of forces and the drive no longer change; else why not."""
        for _ in range(most):
            self.standing = stand(self.problem, self.solved, self.standing)
            self._solve_patches(problem)
            drift, unbalanced = self.drift, self._unbalanced()
            if drift <= ratio and abs(unbalanced) <= drive:
                return ""
            if self.drive.wanted and abs(unbalanced) > drive:
                self.drive.move(unbalanced)
        if self.drift > ratio:
            return f"the load did not settle among the patches: their vertical forces still change by {self.drift:.1e}"
        return f"no angular velocity balances the wheelset: {abs(unbalanced):.1e} of the friction limit remain"

    def _solve_patches(self, problem: WheelsetProblem) -> None:
        motion = replace(problem.motion, angular_velocity=self.drive.value)
        patches, drift = [], 0.0
        for side, bearings in self.standing.bearings.items():
            mine = motion if side == "right" else motion.mirrored
            for bearing in bearings:
                rough = problem is not self.problem
                place = bearing.patch.region.place.y
                contact = problem_of_patch(problem.contact, bearing, mine, bearing.load)
                result = self.solver.solver(side, place, rough=rough).solve(contact)
                patch = SolvedPatch(side, bearing, result, forces_of(bearing, mine, result))
                patches.append(patch)
                drift += abs(patch.solved.vertical - bearing.vertical) * bearing.load
                drift += abs(patch.solved.approach / bearing.over_coarse - 1.0) * bearing.load * (len(bearings) > 1)
        self.patches = tuple(patches)
        self.drift = drift / max(sum(patch.bearing.load for patch in patches), 1e-300)
        self.rounds += 1
        self.report("wheelset", {"iteration": self.rounds, "residual": self.drift})
        self._know(self.patches)

    def _know(self, patches: tuple[SolvedPatch, ...]) -> None:
        self.solved = {side: tuple(patch.solved for patch in patches if patch.side == side) for side in self.problem.sides}

    def _unbalanced(self) -> float:
        """What the drive leaves, over the limit of friction, positive where the wheelset must turn more slowly backwards."""
        if not self.drive.wanted:
            return 0.0
        limit = sum(patch.result.problem.traction_limit for patch in self.patches)
        if self.problem.traction is not None:
            forward = -sum(patch.forces.force[0] for patch in self.patches)
            return (forward - self.problem.traction) / limit
        radius = sum(wheel.radius for wheel in self.problem.wheels.values()) / len(self.problem.wheels)
        return sum(patch.forces.torque for patch in self.patches) / (radius * limit)

    def without_height(self, cause: NoHeight) -> SolvedWheelset:
        """The largest force that the wheels carry, and why there is no more."""
        raise Unsolvable(str(cause), "wheelset.vertical_N") from None


def _rough(problem: WheelsetProblem) -> WheelsetProblem:
    """`problem` on a rough grid, without heat unless friction depends on it; itself if it is as rough."""
    contact, wanted = problem.contact, problem.contact.numerics
    if wanted.grid is not None and max(wanted.grid) <= max(ROUGH_GRID):
        return problem
    heating = contact.heating if contact.friction_varies else replace(contact.heating, heat=False, deformation=False)
    rough = replace(contact, numerics=Numerics(ROUGH_GRID, None, wanted.extent), heating=heating, subsurface=None, wear=None)
    return replace(problem, contact=rough)

"""Solve a wheelset: rounds of placing it by what is known of its patches, and of solving these where it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.numerics.roots import RisingRoot
from thermoroll_cli.problem.problem import Numerics
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.steady_state.discretisation import SolverOptions
from thermoroll_cli.wheelset.one_wheel import DEEPEST, SAME_PATCH, Bearing, NoHeight
from thermoroll_cli.wheelset.patch_problem import SolvedPatch, friction_of, problem_of_patch, solved_patch
from thermoroll_cli.wheelset.standing import Standing, stand, wheels_of
from thermoroll_cli.wheelset.wheelset_problem import SideName, WheelsetProblem

ROUGH_GRID = (16, 16)
"""On which ratios of forces, roll and angular velocity are found before the wanted grid is solved."""
MOST_ROUNDS = 32
ROUGH_RATIO, RATIO = 0.1, 1e-4
"""Change of the vertical force over the load from round to round, rough and fine, with which a patch is known."""
ROUGH_DRIVE, DRIVE = 1e-3, 3e-5
"""Unbalanced torque about the axle over radius and friction limit (or traction over the limit), likewise."""
LARGEST_STEP = 4e-3
"""Largest step of the angular velocity, over itself."""
DRIVE_SLOPE = 100.0
"""First guess of the change of the unbalanced torque over its largest value with the angular velocity over itself."""
FALLING = 0.5
"""Share of the last change of the ratios from which on only half of a change is made: a flange that carries by friction answers
its load with more than the change."""
ANOTHER, OF_UNBALANCED = 1e-3, 0.1
"""Change of the ratios of forces, and that over what is unbalanced, from which on the next standing is another one, for which
no angular velocity is known to be too large or too small."""

Report = Callable[[str, Mapping[str, Any]], None]


@dataclass(frozen=True)
class SolvedWheelset:
    """The standing of a wheelset, its angular velocity (rad/s, about the axle to the right: negative forward), its patches, and
    why it is not in balance (`reason`, empty if it is). `rounds` counts solutions of all patches; `drift` is the last change
    of the ratios of forces, `drive_slope` (s/rad) the change with the angular velocity, if it was found, of what it leaves
    unbalanced over the limit of friction."""

    problem: WheelsetProblem
    standing: Standing
    angular_velocity: float
    patches: tuple[SolvedPatch, ...]
    reason: str = ""
    rounds: int = 0
    drift: float = 0.0
    drive_slope: float = 0.0


Solvers = dict[tuple[bool, SideName], list[tuple[float, Solver]]]
"""Solvers of the patches, rough or not, of a side, with the places y (m) of those that they have solved."""


def balanced(problem: WheelsetProblem, before: SolvedWheelset | None, solvers: Solvers, threads: int,
             report: Report) -> SolvedWheelset:
    """The wheelset in balance, from where one stood `before`; its patches go on from what `solvers` have solved. Raises
    Unsolvable where a wheel misses its rail."""
    state = _Search(problem, before, report, solvers, threads)
    rough = _rough(problem)
    try:
        if rough is not problem:
            state.rounds_of(rough, ROUGH_RATIO, ROUGH_DRIVE)
        reason = state.rounds_of(problem, RATIO, DRIVE)
        # The height follows the approaches of the last round, which leave the load of a wheel's only patch as it is.
        state.standing = stand(problem, state.wheels, state.solved, state.standing)
    except NoHeight as cause:
        return state.without_height(cause)
    assert state.standing is not None
    return SolvedWheelset(problem, state.standing, state.drive.place, state.patches, reason, state.rounds, state.drift,
                          -state.drive.slope)


def _drive_from(angular_velocity: float, slope: float = 0.0) -> RisingRoot:
    """The search for the angular velocity (rad/s), which what is unbalanced falls with; by the `slope` (s/rad) that it had
    before, if there was one."""
    size = max(abs(angular_velocity), 1e-300)
    return RisingRoot(angular_velocity, slope or DRIVE_SLOPE / size, LARGEST_STEP * size)


class _Search:
    """One wheelset on the way to its balance."""

    def __init__(self, problem: WheelsetProblem, before: SolvedWheelset | None, report: Report, solvers: Solvers,
                 threads: int) -> None:
        self.problem, self.report, self.solvers, self.threads = problem, report, solvers, threads
        self.standing: Standing | None
        self.solved: dict[SideName, tuple[Bearing, ...]] = {}
        self.patches: tuple[SolvedPatch, ...] = ()
        self.rounds, self.drift = 0, math.inf
        if before is not None:
            self._know(before.patches)
        self.standing = None if before is None else before.standing
        self.wheels = wheels_of(problem)
        given = problem.motion.angular_velocity
        turned = math.nan if before is None else before.angular_velocity * problem.motion.speed / before.problem.motion.speed
        self.drive = _drive_from(turned if given is None else given, 0.0 if before is None else -before.drive_slope)

    def rounds_of(self, problem: WheelsetProblem, ratio: float, drive: float) -> str:
        """Rounds until neither the ratios of forces nor what drives the wheelset change any more; else why not."""
        for _ in range(MOST_ROUNDS):
            before = self.drift
            self.standing = stand(self.problem, self.wheels, self.solved, self.standing)
            if problem.finds_speed and math.isnan(self.drive.place) and any(self.standing.bearings.values()):
                self.drive = _drive_from(-problem.motion.speed / self._rolling_radius())
            self._solve_patches(problem)
            unbalanced = self._unbalanced() if problem.finds_speed else 0.0
            if self.drift <= ratio and abs(unbalanced) <= drive:
                return ""
            if problem.finds_speed and math.isfinite(unbalanced):
                self.drive.move(-unbalanced)
            if self.drift > min(ANOTHER, OF_UNBALANCED * abs(unbalanced)):
                self.drive.restart()
            if self.drift > FALLING * before:
                self._know(self.patches, 0.5)
        if self.drift > ratio and not self._exceeds_friction:
            return f"the load did not settle among the patches: their vertical forces still change by {self.drift:.1e}"
        return self._without_balance(unbalanced)

    def _rolling_radius(self) -> float:
        """Mean radius of the loaded places of the wheels in m."""
        assert self.standing is not None
        largest = [max(bearings, key=lambda bearing: bearing.load) for bearings in self.standing.bearings.values() if bearings]
        return sum(bearing.patch.rolling_radius for bearing in largest) / len(largest)

    def _solve_patches(self, problem: WheelsetProblem) -> None:
        motion = replace(problem.motion, angular_velocity=self.drive.place)
        patches = []
        assert self.standing is not None
        for side, bearings in self.standing.bearings.items():
            mine = motion if side == "right" else motion.mirrored
            for bearing in bearings:
                solver = self._solver(side, bearing.patch.y, rough=problem is not self.problem)
                result = solver.solve(problem_of_patch(problem.contact, bearing, mine))
                patches.append(solved_patch(side, bearing, mine, result))
        self.patches = tuple(patches)
        self.drift = self._drifted()
        self.rounds += 1
        self.report("wheelset", {"iteration": self.rounds, "residual": self.drift})
        self._know(self.patches)

    def _solver(self, side: SideName, place: float, *, rough: bool) -> Solver:
        """The solver that has solved the patch nearest to `place` on a side before."""
        known = self.solvers.setdefault((rough, side), [])
        near = min(known, key=lambda entry: abs(entry[0] - place), default=None)
        if near is None or abs(near[0] - place) >= SAME_PATCH:
            # Errors of rough solutions are of no interest.
            near = place, Solver(self.threads, SolverOptions(sequence=not rough))
        known[:] = [*(entry for entry in known if entry is not near), (place, near[1])]
        return near[1]

    def _drifted(self) -> float:
        """Change of the vertical forces over the load by what is new: ratios of forces, and approaches. What all patches that
        carry a given force sink deeper together lowers the wheel and changes no load."""
        drift, groups = 0.0, [{side} for side in self.problem.sides]
        if not self.problem.finds_roll:
            groups = [set(self.problem.sides)]
        for sides in groups:
            mine = [patch for patch in self.patches if patch.side in sides]
            loads = np.array([patch.bearing.load for patch in mine])
            sunk = np.array([patch.solved.over_coarse / patch.bearing.over_coarse - 1.0 for patch in mine])
            if mine and self.problem.vertical is not None:
                sunk = sunk - loads @ sunk / loads.sum()
            turned = np.array([patch.solved.vertical - patch.bearing.vertical for patch in mine])
            drift += float(loads @ (np.abs(turned) + np.abs(sunk)))
        return drift / max(sum(patch.bearing.load for patch in self.patches), 1e-300)

    def _know(self, patches: tuple[SolvedPatch, ...], share: float = 1.0) -> None:
        """What is known for the next standing: the ratios of `patches`, or a `share` of their change."""
        self.solved = {side: tuple(patch.known(share) for patch in patches if patch.side == side)
                       for side in self.problem.sides}

    def _unbalanced(self) -> float:
        """The residual of the drive over the limit of friction, positive where the wheelset must turn more slowly backwards.
        Without friction each angular velocity leaves the wheelset without torque, and none drives it."""
        limit = self._limit
        if limit == 0.0:
            return math.inf if self.problem.traction else 0.0
        if self.problem.traction is not None:
            forward = -sum(patch.force[0] for patch in self.patches)
            return (forward - self.problem.traction) / limit
        radius = sum(wheel.radius for wheel in self.problem.wheels.values()) / len(self.problem.wheels)
        return sum(patch.torque for patch in self.patches) / (radius * limit)

    @property
    def _limit(self) -> float:
        """Largest force of friction of all patches in N."""
        return sum(patch.result.problem.traction_limit for patch in self.patches)

    @property
    def _exceeds_friction(self) -> bool:
        return self.problem.traction is not None and abs(self.problem.traction) > self._limit

    def _without_balance(self, unbalanced: float) -> str:
        """Why no angular velocity was found: more traction than friction transmits, or none in the range that was tried."""
        if self._exceeds_friction:
            return f"friction carries {self._limit:.4g} N at most, not traction_N = {self.problem.traction:.4g} N"
        return f"no angular velocity balances the wheelset: {abs(unbalanced):.1e} of the friction limit remain"

    def without_height(self, cause: NoHeight) -> SolvedWheelset:
        """The wheelset as it stood last, and why its wheels do not carry their force: Nadal's limit says when a flange
        climbs."""
        standing = self.standing or Standing(self.problem.position.roll, cause.z, {})
        return SolvedWheelset(self.problem, standing, self.drive.place, self.patches, self._too_little(cause), self.rounds,
                              self.drift)

    def _too_little(self, cause: NoHeight) -> str:
        wanted, depth = f"vertical_N = {self.problem.vertical:.4g} N", f"down to {1e3 * DEEPEST:g} mm below first contact"
        steepest = max(cause.bearings, key=lambda bearing: abs(bearing.patch.angle), default=None)
        if steepest is None:
            return f"no patch carries {wanted}, {depth}: the profiles meet at sharp ends alone"
        reason = f"the wheels carry {cause.largest:.4g} N at most, not {wanted}, {depth}"
        if cause.largest <= 0.0:
            reason = f"the wheels carry {wanted} at no height, {depth}"
        angle, friction = abs(steepest.patch.angle), self._friction_of(steepest)
        lateral, vertical, slope = abs(steepest.lateral) * steepest.load, steepest.vertical * steepest.load, math.tan(angle)
        limit = (slope - friction) / (1.0 + friction * slope)
        if vertical > 0.0 and not 0.0 < limit < lateral / vertical:
            return reason
        reason += (f": a normal force of {steepest.load:.4g} N at {1e3 * angle:.0f} mrad has Y = {lateral:.4g} N and "
                   f"Q = {vertical:.4g} N")
        reason += f", Y/Q = {lateral / vertical:.3g}" if vertical > 0.0 else ", for friction takes more than its vertical part"
        return reason if limit <= 0.0 else (
            f"{reason}; above Nadal's limit Y/Q = {limit:.3g} with the coefficient of friction {friction:.3g} a flange climbs")

    def _friction_of(self, bearing: Bearing) -> float:
        """Coefficient of friction of a patch, at the slip that was found if it depends on it."""
        y = bearing.patch.y
        near = min(self.patches, key=lambda patch: abs(patch.bearing.patch.y - y), default=None)
        found = math.nan if near is None else near.result.coupled.scalars.get("friction_mean", math.nan)
        return friction_of(self.problem.contact, bearing).coefficient if math.isnan(found) else found


def _rough(problem: WheelsetProblem) -> WheelsetProblem:
    """`problem` on a rough grid, without heat unless friction depends on it; itself if it is as rough."""
    contact, wanted = problem.contact, problem.contact.numerics
    if wanted.grid is not None and max(wanted.grid) <= max(ROUGH_GRID):
        return problem
    heating = contact.heating if contact.friction_varies else replace(contact.heating, heat=False, deformation=False)
    rough = replace(contact, numerics=Numerics(ROUGH_GRID, None, wanted.extent), heating=heating, subsurface=None, wear=None)
    return replace(problem, contact=rough)

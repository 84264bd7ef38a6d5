"""Solve a wheelset: rounds of placing it by what is known of its patches, and of solving these where it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from thermoroll_cli.many_contacts.wheelset.kinematics import MotionOfWheelset
from thermoroll_cli.many_contacts.wheelset.one_wheel import BALANCED, DEEPEST, SAME_PATCH, CarryingPatch, NoHeight, same_patch
from thermoroll_cli.many_contacts.wheelset.patch_problem import (
    SolvedPatch,
    estimated_friction,
    friction_of,
    problem_of_patch,
    solved_patch,
)
from thermoroll_cli.many_contacts.wheelset.standing import Standing, stand, wheels_of
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SideName, WheelsetProblem
from thermoroll_cli.one_contact.refinement.plan import grid_sequence
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.physics.numerics.krylov import Anderson
from thermoroll_cli.physics.numerics.roots import RisingRoot
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

MOST_ROUNDS, MIXED_ROUNDS, NEARLY_ROUNDS, LAST_ROUNDS = 32, 8, 20, 26
"""Rounds at most; with all unknowns mixed; and from which on a change of `ROUGH`, and of `NEARLY`, counts as an error, not as a
failure: patches that come and go, and approaches that jump with the places of the elements, leave no state that is met more
closely, and not every round is as close as others."""
ROUGHLY, NEARLY, ROUGH, FINE = 2e-2, 1e-2, 1e-3, 1e-4
"""On a rough grid and on the wanted one: change of the vertical force over the load from round to round with which patches are
known, and what is unbalanced then: torque about the axle over radius and friction limit, or traction over that limit. If the
rough grid leaves no heat out, a round costs hardly less on it: it is met only roughly, and left out on patches that are
known. What `MOST_ROUNDS` meet `NEARLY` is a result with a warning, and with errors that contain what is left."""
STOOD = 0.1
"""Share of these with which the wheelset is placed."""
GUESSES = 2
"""Standings from which friction is estimated: without friction, and with what it is there."""
DRIVE_SLOPE = 100.0
"""Usual change of what is unbalanced with the angular velocity over itself."""
LONGEST = 0.4
"""Longest step of the ratios of forces, and of the angular velocity over itself times `DRIVE_SLOPE`."""
NUDGE, FLATTEST = 1e-2, 1e-2
"""Step of both with which slopes are estimated, and least change of what is unbalanced over the latter: sliding leaves none."""

Report = Callable[[str, Mapping[str, Any]], None]


@dataclass(frozen=True)
class SolvedWheelset:
    """The standing of a wheelset, its angular velocity (rad/s, about the axle to the right: negative forward), its patches, and
    why it is not in balance (`reason`, empty if it is). `rounds` counts solutions of all patches; `left` is the last change of
    the vertical forces over the load or, if larger, what is unbalanced; `slopes`, (n + 1, n + 1), are those of the search (see
    `_Search`) for n patches, and `finer` is by how much its unknowns differ between the rough and the wanted grid."""

    problem: WheelsetProblem
    standing: Standing
    angular_velocity: float
    patches: tuple[SolvedPatch, ...]
    reason: str = ""
    rounds: int = 0
    left: float = 0.0
    slopes: Array = field(default_factory=lambda: -np.eye(1))
    finer: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def drive_slope(self) -> float:
        """Estimated change of what is unbalanced with the angular velocity over itself, as ratios of forces follow it."""
        return DRIVE_SLOPE / float(np.linalg.inv(self.slopes)[-1, -1])


Loaded = list[tuple[SideName, CarryingPatch]]
"""Patches that bear a wheelset, each with its side."""


class SolvesPatches(Protocol):
    """What solves a patch: a contact in the steady state, or a step of one over time."""

    def solve(self, problem: Problem) -> Result:
        """The result of the `problem` of a patch."""


class Solvers(Protocol):
    """What solves the patches of a wheelset, if they can (`rough_first`) on a rough grid before the wanted one."""

    rough_first: bool

    def of(self, loaded: Loaded, *, rough: bool = False) -> Sequence[SolvesPatches]:
        """What solves each of the patches that bear the wheelset, on a rough grid or on the wanted one."""


class SteadySolvers:
    """Solvers of the steady state, rough or not, for each side, with the places y (m) of those patches that they have
    solved."""

    rough_first = True

    def __init__(self, threads: int) -> None:
        self._threads = threads
        self._known: dict[tuple[bool, SideName], list[tuple[float, ContactSolver]]] = {}

    def of(self, loaded: Loaded, *, rough: bool = False) -> Sequence[ContactSolver]:
        """The solvers that have solved the patches nearest to these before."""
        return [self._near(side, carrying.patch.y, rough=rough) for side, carrying in loaded]

    def _near(self, side: SideName, place: float, *, rough: bool) -> ContactSolver:
        known = self._known.setdefault((rough, side), [])
        near = same_patch(known, place, lambda entry: entry[0])
        if near is None:
            near = place, ContactSolver(self._threads)
            if not rough and self._known.get((True, side)):
                near[1].last = self._near(side, place, rough=True).last
        known[:] = [*(entry for entry in known if entry is not near), (place, near[1])]
        return near[1]


def balanced(problem: WheelsetProblem, roll: float, before: SolvedWheelset | None, solvers: Solvers,
             report: Report) -> SolvedWheelset:
    """The wheelset in balance, from its first contact at a `roll` (rad), or from where one stood `before`; its patches go on
    from what `solvers` have solved. Raises Unsolvable where a wheel misses its rail."""
    state = _Search(problem, roll, before, report, solvers)
    # First on a rough grid, without heat unless friction depends on it.
    contact, rough = problem.contact, problem
    grids, heating = grid_sequence(contact), contact.heating
    if len(grids) >= 3 and solvers.rough_first:
        heating = heating if contact.friction_varies else replace(heating, heat=False, deformation=False)
        numerics = Numerics(grids[1], None, contact.numerics.extent)
        rough = replace(problem, contact=replace(contact, numerics=numerics, heating=heating, subsurface=None, wear=None))
    leaves_heat_out = heating.heat != contact.heating.heat
    coarse = np.zeros(0)
    try:
        known = bool(state.known) and not state.moved_on()
        if not known:
            state.guess()
        if rough is not problem and (leaves_heat_out or not known):
            state.rounds_of(rough, ROUGH if leaves_heat_out else ROUGHLY)
            coarse = state.next_place
            if before is not None and len(before.finer) == len(coarse):
                state.go_to(coarse + before.finer)
        reason = state.rounds_of(problem, FINE)
        finer = state.next_place - coarse if len(state.next_place) == len(coarse) else np.zeros(0)
        # The height follows the approaches of the last round, which leave the load of a wheel's only patch as it is.
        state.stand(BALANCED)
    except NoHeight as cause:
        return state.without_height(cause)
    return SolvedWheelset(problem, state.standing, state.velocity, state.patches, reason, state.rounds, state.left,
                          state.slopes, finer)


class _Search:
    """One wheelset on the way to its balance. Unknowns are the ratio of vertical force and load of each patch and, last, the
    angular velocity over `unit` (rad/s); residuals are what the former change by, and what is unbalanced. They are mixed with
    the Jacobian `slopes` as estimated for the patches `loaded`, ratios times `scales`, their shares of the load; `known` is
    what the next standing knows of them."""

    def __init__(self, problem: WheelsetProblem, roll: float, before: SolvedWheelset | None, report: Report,
                 solvers: Solvers) -> None:
        self.problem, self.report, self.solvers = problem, report, solvers
        self.wheels = wheels_of(problem)
        self.standing = Standing(roll, 0.0, {})
        self.loaded, self.known, self.patches = Loaded(), Loaded(), tuple[SolvedPatch, ...]()
        self.rounds, self.drift, self.left = 0, math.inf, math.inf
        radius, given = max(wheel.radius for wheel in problem.wheels.values()), problem.motion.angular_velocity
        self.unit = problem.motion.speed / (DRIVE_SLOPE * radius)
        self.velocity = -DRIVE_SLOPE * self.unit if given is None else given
        self.slopes, self.scales, self.mixing = -np.eye(1), np.ones(1), Anderson()
        if before is not None and before.patches:
            self.standing = replace(before.standing, roll=roll)
            self.known = [(patch.side, patch.solved) for patch in before.patches]
            if given is None:
                self.velocity = before.angular_velocity * problem.motion.speed / before.problem.motion.speed

    def moved_on(self) -> bool:
        """Whether the wheelset rests on other patches than before, or on none by what is known of these."""
        before = self.known
        try:
            self._stand(ROUGH)
        except NoHeight:
            self.known = []
        return not self.known or not _alike(before, self.loaded)

    def guess(self) -> None:
        """Ratios of forces and angular velocity by estimates of friction, unless no height is found with these."""
        for _ in range(GUESSES):
            try:
                self._stand(ROUGH)
            except NoHeight:
                if not self.loaded:
                    raise
                self.known = []
                return
            place = self._place_of(self.loaded)
            root = RisingRoot(place[-1], 1.0, LONGEST)
            for _ in range(MOST_ROUNDS if self.problem.finds_speed and self.loaded else 0):
                place[-1] = root.place
                unbalanced = self._estimated(place)[-1]
                if abs(unbalanced) <= ROUGH:
                    break
                root.move(-unbalanced)
            self.known = self.loaded
            self.go_to(place + np.array([*self._estimated(place)[:-1], 0.0]))

    def stand(self, within: float) -> None:
        """Place the wheelset by what is known of its patches: if no height is found with ratios of forces that were mixed, with
        those that were found. The vertical force is met `within` a share."""
        try:
            self._stand(within)
        except NoHeight:
            found = [(patch.side, patch.solved) for patch in self.patches]
            if self.known == found or not found:
                raise
            self.known, self.mixing = found, Anderson(len(self.slopes))
            self._stand(within)

    def _stand(self, within: float) -> None:
        solved = {of: tuple(carrying for side, carrying in self.known if side == of) for of in self.problem.sides}
        self.standing = stand(self.problem, self.wheels, solved, self.standing, within)
        before = self.loaded
        self.loaded = [(side, carrying) for side, patches in self.standing.carrying.items() for carrying in patches]
        if not _alike(before, self.loaded):
            place = self._place_of(self.loaded)
            nudged = [self._estimated(place + nudge) - self._estimated(place) for nudge in NUDGE * np.eye(len(place))]
            self.slopes = np.transpose(nudged) / NUDGE
            self.slopes[-1, -1] = min(self.slopes[-1, -1], -FLATTEST)
            loads = np.array([carrying.load for _, carrying in self.loaded])
            self.scales = np.array([*(loads / loads.sum()), 1.0])
            self.mixing = Anderson(len(place))

    @property
    def next_place(self) -> Array:
        """The unknowns of the next round."""
        return self._place_of(self.known)

    def _place_of(self, patches: Loaded) -> Array:
        return np.array([*(carrying.vertical for _, carrying in patches), self.velocity / self.unit])

    def go_to(self, place: Array) -> None:
        """Set the unknowns."""
        *ratios, velocity = place.tolist()
        if self.problem.finds_speed:
            self.velocity = velocity * self.unit
        self.known = [(side, replace(carrying, vertical=ratio))
                      for (side, carrying), ratio in zip(self.known, ratios, strict=True)]

    def _estimated(self, place: Array) -> Array:
        """The residuals at a `place` by estimates of friction, with loads that carry the same force."""
        motion, (*ratios, velocity) = self._motion(place[-1] * self.unit), place.tolist()
        changes, forward, torque, limit = [], 0.0, 0.0, 0.0
        for (side, carrying), ratio in zip(self.loaded, ratios, strict=True):
            mine = [(other, r) for (of, other), r in zip(self.loaded, ratios, strict=True) if of in self._together(side)]
            more = 1.0 if self.problem.vertical is None else (
                sum(other.load * other.vertical for other, _ in mine) / sum(other.load * r for other, r in mine))
            along, across = estimated_friction(self.problem.contact, carrying, motion[side])
            angle, load = carrying.patch.angle, more * carrying.load
            changes.append(math.cos(angle) + math.sin(angle) * across - ratio)
            forward -= along * load
            torque -= along * load * carrying.patch.rolling_radius
            limit += friction_of(self.problem.contact, carrying).coefficient * load
        return np.array([*changes, self._unbalanced(forward, torque, limit) if self.problem.finds_speed else -velocity])

    def _together(self, side: SideName) -> set[SideName]:
        """The sides that carry a vertical force together with `side`."""
        return {side} if self.problem.finds_roll else set(self.problem.sides)

    def rounds_of(self, problem: WheelsetProblem, tolerance: float) -> str:
        """Rounds until neither the ratios of forces nor what drives the wheelset change any more; else why not.

        After `MIXED_ROUNDS` the search circles about a root, which lies between the last velocities. Then ratios follow by
        substitution, the angular velocity in a bracket, and approaches are means over the rounds."""
        self.mixing = Anderson(len(self.slopes), known=self.mixing.secants)
        root, borne = None, Loaded()
        for turn in range(MOST_ROUNDS):
            self.stand(STOOD * tolerance)
            self._solve_patches(problem)
            forward, torque = -sum(patch.force[0] for patch in self.patches), sum(patch.torque for patch in self.patches)
            unbalanced = self._unbalanced(forward, torque, self._limit) if problem.finds_speed else 0.0
            self.left = max(self.drift, abs(unbalanced))
            known = self.left <= (tolerance if turn < NEARLY_ROUNDS else ROUGH if turn < LAST_ROUNDS else NEARLY)
            if known and problem is self.problem:
                return ""
            if self.drift <= tolerance and self._exceeds_friction:
                break
            if turn < MIXED_ROUNDS or not problem.finds_speed:
                self._mix(unbalanced)
            else:
                if root is None or not _alike(self.loaded, borne) or abs(unbalanced) > root.slope * root.width:
                    # The bracket is of the loads that it was begun with.
                    drive = 1.0 / float(np.linalg.inv(self.slopes)[-1, -1])
                    root, borne = RisingRoot(self.velocity / self.unit, abs(drive), LONGEST), self.loaded
                root.move(-unbalanced)
                self.go_to(np.array([*(found.vertical for _, found in self.known), root.place]))
            if turn >= MIXED_ROUNDS:
                new = 1.0 / (turn - MIXED_ROUNDS + 2)
                self.known = [(side, replace(found, over_coarse=found.over_coarse**new * carrying.over_coarse ** (1.0 - new)))
                              for (side, found), (_, carrying) in zip(self.known, self.loaded, strict=True)]
            if known:
                return ""
        if self.left <= NEARLY:
            return ""
        if self.drift > tolerance and not self._exceeds_friction:
            return f"the load did not settle among the patches: their vertical forces still change by {self.drift:.1e}"
        if self._exceeds_friction:
            return f"friction carries {self._limit:.4g} N at most, not traction_N = {problem.traction:.4g} N"
        return f"no angular velocity balances the wheelset: {abs(unbalanced):.1e} of the friction limit remain"

    def _mix(self, unbalanced: float) -> None:
        """Set the unknowns of the next round, from those of the last ones and what they led to."""
        place = self._place_of(self.loaded)
        changes = [found.vertical - before.vertical for (_, before), (_, found) in zip(self.loaded, self.known, strict=True)]
        newton = place - np.linalg.solve(self.slopes, [*changes, unbalanced])
        step = self.mixing.next(self.scales * place, self.scales * newton) / self.scales - place
        self.go_to(place + step * min(1.0, LONGEST / max(float(np.abs(step).max()), 1e-300)))

    def _solve_patches(self, problem: WheelsetProblem) -> None:
        """Solve all patches where they are, on the grid of `problem`; `drift` becomes the change of vertical forces over the
        load by that."""
        motion = self._motion(self.velocity)
        patches = []
        solvers = self.solvers.of(self.loaded, rough=problem is not self.problem)
        for (side, carrying), solver in zip(self.loaded, solvers, strict=True):
            result = solver.solve(problem_of_patch(problem.contact, carrying, motion[side]))
            patches.append(solved_patch(side, carrying, motion[side], result))
        self.patches = tuple(patches)
        self.known = [(patch.side, patch.solved) for patch in patches]
        # Vertical forces change by new ratios of forces and approaches. What all patches that carry a given force sink deeper
        # together lowers the wheel and changes no load.
        self.drift = 0.0
        for sides in {frozenset(self._together(side)) for side in self.problem.sides}:
            mine = [patch for patch in patches if patch.side in sides]
            loads = np.array([patch.carrying.load for patch in mine])
            sunk = np.array([patch.solved.over_coarse / patch.carrying.over_coarse - 1.0 for patch in mine])
            if mine and self.problem.vertical is not None:
                sunk = sunk - loads @ sunk / loads.sum()
            turned = np.array([patch.solved.vertical - patch.carrying.vertical for patch in mine])
            self.drift += float(loads @ (np.abs(turned) + np.abs(sunk)))
        self.drift /= max(sum(patch.carrying.load for patch in patches), 1e-300)
        self.rounds += 1
        self.report("wheelset", {"iteration": self.rounds, "residual": self.drift})

    def _motion(self, velocity: float) -> dict[SideName, MotionOfWheelset]:
        """The motion of each side, as of a right one, with an angular velocity (rad/s)."""
        motion = replace(self.problem.motion, angular_velocity=velocity)
        return {"left": motion.mirrored, "right": motion}

    def _unbalanced(self, forward: float, torque: float, limit: float) -> float:
        """What drives the wheelset in vain, over the limit of friction (N), positive where it must turn more slowly backwards,
        by the `forward` force (N) and the `torque` (N m) of its patches. Without friction each angular velocity leaves it
        without torque, and none drives it."""
        if limit == 0.0:
            return -math.copysign(1.0, self.problem.traction) if self.problem.traction else 0.0
        if self.problem.traction is not None:
            return (forward - self.problem.traction) / limit
        return torque / (limit * sum(wheel.radius for wheel in self.problem.wheels.values()) / len(self.problem.wheels))

    @property
    def _limit(self) -> float:
        """Largest force of friction of all patches in N."""
        return sum(patch.result.problem.traction_limit for patch in self.patches)

    @property
    def _exceeds_friction(self) -> bool:
        return self.problem.traction is not None and abs(self.problem.traction) > self._limit

    def without_height(self, cause: NoHeight) -> SolvedWheelset:
        """The wheelset as it stood last, and why its wheels do not carry their force: Nadal's limit says when a flange
        climbs."""
        standing = self.standing if self.standing.carrying else Standing(self.standing.roll, cause.z, {})
        return SolvedWheelset(self.problem, standing, self.velocity, self.patches, self._too_little(cause), self.rounds,
                              self.left)

    def _too_little(self, cause: NoHeight) -> str:
        wanted, depth = f"vertical_N = {self.problem.vertical:.4g} N", f"down to an approach of {1e3 * DEEPEST:g} mm"
        steepest = max(cause.carrying, key=lambda carrying: abs(carrying.patch.angle), default=None)
        if steepest is None:
            return f"no patch carries {wanted}, {depth}: the profiles meet at sharp ends alone"
        reason = f"the wheels carry {cause.largest:.4g} N at most, not {wanted}, {depth}"
        if cause.largest <= 0.0:
            reason = f"the wheels carry {wanted} at no height, {depth}"
        # Friction at the slip that was found if it depends on it.
        near = min(self.patches, key=lambda patch: abs(patch.carrying.patch.y - steepest.patch.y), default=None)
        friction = math.nan if near is None else near.result.coupled.scalars.get("friction_mean", math.nan)
        if math.isnan(friction):
            friction = friction_of(self.problem.contact, steepest).coefficient
        angle = abs(steepest.patch.angle)
        lateral, vertical, slope = abs(steepest.lateral) * steepest.load, steepest.vertical * steepest.load, math.tan(angle)
        limit = (slope - friction) / (1.0 + friction * slope)
        if vertical > 0.0 and not 0.0 < limit < lateral / vertical:
            return reason
        reason += (f": a normal force of {steepest.load:.4g} N at {1e3 * angle:.0f} mrad has Y = {lateral:.4g} N and "
                   f"Q = {vertical:.4g} N")
        reason += f", Y/Q = {lateral / vertical:.3g}" if vertical > 0.0 else ", for friction takes more than its vertical part"
        return reason if limit <= 0.0 else (
            f"{reason}; above Nadal's limit Y/Q = {limit:.3g} with the coefficient of friction {friction:.3g} a flange climbs")

def _alike(here: Loaded, there: Loaded) -> bool:
    """Whether these are the same patches."""
    return len(here) == len(there) and all(
        side == other and abs(carrying.patch.y - its.patch.y) < SAME_PATCH
        for (side, carrying), (other, its) in zip(here, there, strict=True))

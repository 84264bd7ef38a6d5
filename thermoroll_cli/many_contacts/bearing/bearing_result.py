"""The answer: a ball bearing with all its contacts, as scalars, and the result of each contact."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.many_contacts.bearing.arrangement import Ball
from thermoroll_cli.many_contacts.bearing.bearing_problem import AXIAL, RADIAL, RINGS, BearingProblem, RingName
from thermoroll_cli.many_contacts.bearing.placement import Placement
from thermoroll_cli.many_contacts.bearing.solve_bearing import BearingSearch, SolvedBearing
from thermoroll_cli.many_contacts.bearing.tractions import INTEGRALS, POWERS
from thermoroll_cli.one_contact.refinement.error_estimates import FLOOR
from thermoroll_cli.one_contact.refinement.plan import Plan, make_plan
from thermoroll_cli.problem.kinds import InWords
from thermoroll_cli.problem.names import BALL_SCALARS, SCALARS, TOGETHER
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import error_scale, missed_by_whole, together
from thermoroll_cli.tools.arrays import Array

LARGEST_POWER_ERROR = 2e-3
"""Heat of all contacts against the power of the rings, relative."""
ONLY_ROLLING = ("Q_F_W", "T_gamma_N", "gamma_st", "stick_area_mm2", "power_balance_error")
"""Scalars that say nothing of rings at rest."""
PRESSED = ("pressure", "peak pressure", "relative peak pressure", "area", "relative area")
"""Kinds of scalars that depend on the load, and not on the motion."""
RESULTANTS = "contact_force_y_N", "contact_force_z_N"
"""Scalars of the load and the tractions together."""
JUDGED = "axial_displacement_um", "radial_displacement_um", "torque_Nmm"
"""Scalars of the whole that have to be as accurate as is asked for, if no others are named."""
MOTION = "creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm"
"""Numbers of a contact by which it moves."""
FOLLOWED = 0.4
"""Part of the errors of creepages by which other scalars change: 0.3 at most in 22 random bearings, for friction saturates."""
DOUBTED = 0.25
"""Part that counts of what the estimated errors of all forces, as a root mean square, do to a ball. They are bounds for a
contact alone, most of which is stick that no element has seen, and not all of its forces reach theirs at once: in 9 random
bearings all of it was 20 times the true error in the middle, and a tenth covered what changes from grid to grid did not."""
BOTH_RINGS = 0.9
"""Exponent that joins the lives of both rings (Lundberg and Palmgren 1947)."""


class BearingSolver:
    """Solves bearing after bearing; each begins with the axes of the one before."""

    def __init__(self, threads: int = 1, options: object = None) -> None:
        self.threads = threads
        self._before: BearingSearch | None = None

    def solve(
        self, problem: BearingProblem, *, report: Callable[[str, Mapping[str, Any]], None] | None = None
    ) -> Result:
        """The result of `problem`; `reason` says what goes wrong. `report` is called with a stage and a mapping."""
        report = report or (lambda stage, info: None)
        search = BearingSearch(problem, self.threads, report, self._before)
        solved = search.solve()
        if solved.reason and search.before is not None:
            search = BearingSearch(problem, self.threads, report)
            solved = search.solve()
        # One more search leads on from here, not a chain of all.
        search.before = None
        self._before = None if solved.reason or not problem.balances else search
        return result_of(solved)


def bearing_warnings(problem: BearingProblem) -> Iterator[str]:
    """Warnings that need no solution."""
    law = problem.contact.friction.law
    if problem.rolls and law is not None and law.fall() > 0.0 and problem.control == "tractions":
        yield ("friction falls with slip, so that a ball can have several axes: the one that follows from the axis at constant "
               "friction is reported")
    if not problem.rolls:
        yield "both rings turn alike: there are loads and stresses, but no rolling, heat or torque"


def facts_of(problem: BearingProblem) -> dict[str, float]:
    """Numbers known before anything is solved, in the units of their names."""
    distance, angle = problem.groove_distance, problem.contact_angle
    return {
        "groove_distance_mm": 1e3 * distance,
        "free_contact_angle_deg": math.degrees(angle),
        "clearance_um": 2e6 * distance * (1.0 - math.cos(angle)),
        "axial_play_um": 2e6 * distance * math.sin(angle),
        "ball_mass_kg": problem.mass,
    }


SOLVES, COMMON = 50, 1.5
"""Contacts that are solved for the axis of a ball, 26 to 80 in bearings under thrust and combined loads; and times as many with
a common cage."""


@dataclass(frozen=True)
class BearingPlan:
    """Before anything is solved: the plan of the contact with the largest load, how many kinds of balls have loads and angles
    of their own at rest, about how many contacts are solved, and the time (s, one core) and the memory (bytes) of all."""

    contact: Plan
    kinds: int
    contact_solves: int
    seconds: float

    @property
    def memory_bytes(self) -> int:
        return 2 * self.kinds * self.contact.memory_bytes

    @property
    def steps(self) -> tuple[Any, ...]:
        return ()

    @property
    def in_words(self) -> InWords:
        alike = "all balls alike" if self.kinds == 1 else f"{self.kinds} kinds of balls by their loads"
        contact = self.contact.in_words
        return contact._replace(
            notes=[f"{alike} at rest, with two contacts each; about {self.contact_solves} contacts are solved"],
            record={**contact.record, "kinds_of_balls": self.kinds, "contact_solves": self.contact_solves})


def plan_of(problem: BearingProblem) -> BearingPlan | None:
    """The plan of a bearing; None if nothing is loaded at rest."""
    search = BearingSearch(problem, 1, lambda stage, info: None)
    balls = search.at_rest()
    if not balls or search.now.placement.reason:
        return None
    ball, axes = balls[0], 0
    if problem.balances:
        axes = round(SOLVES * (COMMON if problem.common_cage else 1.0) * len(balls))
    motion = problem.race_control(ball.angles, problem.controlling) if problem.rolls else np.array(
        [problem.speeds[0] - 1.0, 0.0, 0.0, 0.0])
    contacts = [problem.contact_problem(contact, "inner", float(ball.angles[0]), float(ball.loads[0]), motion)
                for contact in (search.whole, search.stages()[0][0])]
    if not problem.rolls:
        contacts[0] = replace(contacts[0], motion=search.whole.motion)
    whole, rough = map(make_plan, contacts)
    results = 2 * len(balls)
    return BearingPlan(whole, len(balls), axes + results, axes * rough.seconds + results * whole.seconds)


def result_of(solved: SolvedBearing) -> Result:
    """The result of a solved bearing; not converged where it is not in balance, or where a contact is not."""
    contacts = tuple(_contacts(solved))
    scalars, errors = _scalars(solved, contacts)
    reasons = [solved.reason] if solved.reason else []
    reasons += [f"contact {contact.name}: {contact.reason}" for contact in contacts if not contact.converged][:4]
    if solved.problem.balances and not reasons and scalars["torque_Nmm"] > 0.0:
        missing = abs(scalars["torque_from_forces_Nmm"] / scalars["torque_Nmm"] - 1.0)
        if missing > LARGEST_POWER_ERROR + errors["torque_from_forces_Nmm"] / scalars["torque_Nmm"]:
            reasons.append(f"the torques from heat and from forces differ by {missing:.1e}")
    if not reasons and (missed := missed_by_whole(scalars, errors, solved.problem.contact.numerics, JUDGED, _scale)):
        reasons.append(missed)
    state = State({}, scalars, np.zeros(0), np.zeros(0))
    grid: list[int] = max((contact.work["grid"] for contact in contacts), default=[])
    return Result(
        problem=solved.problem.contact, coupled=state, isothermal=state, of_problem={}, converged=not reasons,
        reason="; ".join(reasons), uncertainty=errors, patches=contacts, assembly="bearing",
        work={"grid": grid, "rounds": solved.rounds, "contact_solves": solved.solves},
        warnings=(*bearing_warnings(solved.problem), *_warnings(solved, contacts)), lines=_around(solved))


def _scale(name: str, scalars: Mapping[str, float]) -> float:
    """By what an accuracy is judged: displacements by the largest of them, all else by itself."""
    alike = [each for each in scalars if each.endswith("displacement_um")]
    return max(abs(scalars[each]) for each in (alike if name in alike else (name,)))


def _contacts(solved: SolvedBearing) -> Iterator[Result]:
    """The results of all contacts, ball by ball, with the errors that the balance of the balls passes on to them."""
    problem = solved.problem
    for j in range(problem.balls):
        k = next(k for k, ball in enumerate(solved.balls) if j in ball.members)
        ball = solved.balls[k]
        for ring, solved_contact in ball.contacts.items():
            result = solved_contact.result
            if not problem.rolls:
                nothing = dict.fromkeys(ONLY_ROLLING, math.nan)
                state = replace(result.coupled, scalars={**result.coupled.scalars, **nothing})
                result = replace(result, coupled=state, isothermal=state)
            own, numbers = dict(result.uncertainty), result.numbers
            errors = _errors(solved, lambda each, k=k, ring=ring: _followed(problem, each.balls[k], ring))  # type: ignore[misc]
            if solved.settled is not None:
                unit = problem.saturation(ring, float(ball.angles[RINGS.index(ring)]), numbers["normal_N"])
                moved = np.array([errors[name] for name in MOTION]) * [1.0, 1.0, 1e3] / unit
                sliding = max(float(np.linalg.norm(solved_contact.creepages / unit)), 1.0)
                share = FOLLOWED * float(np.linalg.norm(moved)) / sliding
                load = errors["normal_N"] / numbers["normal_N"]
                own = {name: error + (errors["normal_N"] + errors["force_y_N"] if name in RESULTANTS else
                                      (load if of_kind(name) in PRESSED else share) * abs(error_scale(name, numbers)))
                       for name, error in own.items()}
            record: dict[str, Any] = {"ball": j + 1, "ring": ring, **_followed(problem, ball, ring)}
            record |= {name: numbers[name] for name in BALL_SCALARS if name in numbers and not math.isnan(numbers[name])}
            # Forces are those of the balance; powers are no better known than by the contact alone, products than by factors.
            own |= {name: max(error, result.uncertainty.get(name, 0.0)) if name in POWERS else error
                    for name, error in errors.items()}
            if (product := "T_gamma_without_spin_N") in numbers and solved.settled is not None:
                factors = [(f"force_{axis}_N", creepage) for axis, creepage in zip("xy", MOTION, strict=False)]
                own[product] = max(own[product], sum(
                    abs(numbers[force]) * own[creepage] + abs(numbers[creepage]) * own[force] for force, creepage in factors))
            record |= {"status": result.status, "uncertainty": {
                name: float(own.get(name, math.nan)) for name in record if name not in ("ball", "ring")}}
            yield replace(result, name=f"ball_{j + 1}_{ring}", record=record,
                          uncertainty={name: own[name] for name in (*result.uncertainty, "normal_N")})


def _errors(solved: SolvedBearing, numbers: Callable[[SolvedBearing], Mapping[str, float]]) -> dict[str, float]:
    """Estimated errors of `numbers` of a bearing: their last change from grid to grid, no less than a quarter of the one before
    and than what the errors of the forces of all contacts do to them, with what is left of the conditions; 0 for places where
    they follow from no traction. Integrals are extrapolated, and err by less than they change; but those of both contacts hold
    each other in balance, which shows no order."""
    found, coarser, doubted = numbers(solved), *([numbers(each) for each in some] for some in (solved.coarser, solved.doubted))
    if solved.settled is None:
        known = math.nan if solved.problem.balances else 0.0
        return {name: known for name in found if name not in (*INTEGRALS, "torque_Nmm")}
    settled, errors = numbers(solved.settled), {}
    for name, value in found.items():
        changes = [abs(fine[name] - coarse[name]) for coarse, fine in itertools.pairwise(coarser)]
        change = max((each / 4.0**k for k, each in enumerate(reversed(changes))), default=math.nan)
        of_forces = DOUBTED * math.hypot(*(each[name] - value for each in doubted))
        errors[name] = max(change, of_forces) + abs(settled[name] - value) + FLOOR * abs(value)
    return errors


def of_kind(name: str) -> str:
    """The kind of a scalar of a contact."""
    return SCALARS[name].kind if name in SCALARS else "below"


def _followed(problem: BearingProblem, ball: Ball, ring: RingName) -> dict[str, float]:
    """Numbers of a contact and of its ball that the balance determines, in the units of their names."""
    k, motion = RINGS.index(ring), ball.motion
    numbers = {"normal_N": float(ball.loads[k]), "contact_angle_deg": math.degrees(ball.angles[k])}
    if problem.rolls:
        speed, slip, rolling = problem.slip(ring, float(ball.angles[k]), motion)
        turning = float(np.linalg.norm(motion[1:]))
        along, outwards, around = (problem.direction * motion[1:]).tolist()
        numbers |= {
            "rolling_speed_m_s": speed, "creepage_longitudinal": float(slip[0]) / speed,
            "creepage_lateral": float(slip[1]) / speed, "creepage_spin_rad_mm": 1e-3 * float(slip[2]) / speed,
            "spin_to_roll": -float(slip[2]) / rolling, "ball_pitch_deg": math.degrees(math.atan2(outwards, -along)),
            "ball_yaw_deg": math.degrees(math.asin(around / turning)), "ball_speed_rad_s": turning,
            "cage_speed_rad_s": float(motion[0]),
        }  # fmt: skip
    return numbers | dict(ball.integrals.get(ring, {}))


def _of_the_whole(solved: SolvedBearing) -> dict[str, float]:
    """Numbers of the whole bearing that the balance determines, in the units of their names."""
    problem, placement = solved.problem, solved.placement
    ring = placement.ring
    numbers = {
        "axial_displacement_um": 1e6 * ring[0], "radial_displacement_um": 1e6 * ring[1],
        "radial_displacement_across_um": 1e6 * ring[2], "tilt_mrad": 1e3 * ring[3], "tilt_across_mrad": 1e3 * ring[4],
        "cage_speed_rad_s": math.nan, "cage_speed_rpm": math.nan, "torque_Nmm": math.nan, "torque_from_forces_Nmm": math.nan,
        "axial_stiffness_N_um": 1e-6 * _stiffness(problem, placement, 0),
        "radial_stiffness_N_um": 1e-6 * _stiffness(problem, placement, 1), "life_L10r_Mrev": life(problem, placement.loads),
    }  # fmt: skip
    against = abs(problem.speeds[0] - problem.speeds[1])
    numbers["life_L10r_h"] = numbers["life_L10r_Mrev"] * 1e6 * 2.0 * math.pi / (3600.0 * against) if against else math.nan
    carried = [ball for ball in solved.balls if ball.integrals]
    if carried:
        count = sum(len(ball.members) for ball in carried)
        numbers["cage_speed_rad_s"] = sum(ball.motion[0] * len(ball.members) for ball in carried) / count
        numbers["cage_speed_rpm"] = 30.0 / math.pi * numbers["cage_speed_rad_s"]
        numbers |= {name: sum(len(ball.members) * ball.integrals[ring][name] for ball in carried for ring in RINGS)
                    for name in ("Q_F_W", "T_gamma_N", "expansion_power_W")}
        # The rings are driven by what friction takes, less what surfaces give back as they expand under pressure.
        numbers["torque_Nmm"] = 1e3 * (numbers["Q_F_W"] - numbers["expansion_power_W"]) / against
        if not problem.contact.heating.deformation:
            del numbers["expansion_power_W"]
    return {name: float(value) for name, value in numbers.items()}


def _scalars(solved: SolvedBearing, contacts: Sequence[Result]) -> tuple[dict[str, float], dict[str, float]]:
    """Scalars of the whole bearing and their errors."""
    problem, scalars, errors = solved.problem, _of_the_whole(solved), _errors(solved, _of_the_whole)
    if problem.axial_displacement is not None:  # it is given
        del errors["axial_displacement_um"]
    summaries = [contact.summary() for contact in contacts]
    for name, scalar in TOGETHER.items():
        assert scalar.together is not None
        found = together(name, summaries, scalar.together)
        if name not in errors and not math.isnan(found[0]):
            scalars[name], errors[name] = found
    for name in ("Q_F_W", "T_gamma_N"):  # no better known than by each contact alone: `errors` have the motion of all
        if name in errors:
            errors[name] = max(errors[name], sum(len(ball.members) * contact.result.uncertainty[name]
                                                 for ball in solved.balls for contact in ball.contacts.values()))
    if problem.rolls and contacts:
        over = 1e3 / abs(problem.speeds[0] - problem.speeds[1])
        errors["torque_Nmm"] = (errors["Q_F_W"] + errors.get("expansion_power_W", 0.0)) * over
    if problem.balances and contacts:
        # With race control the tractions on a ball do not balance, and give no torque.
        torque = 0.0
        for ball in solved.balls:
            if ball.loaded:
                inner = ball.contacts["inner"]
                lever = np.cross(0.5 * problem.pitch_diameter * RADIAL, inner.force)
                torque += len(ball.members) * float((lever + inner.moment) @ AXIAL)
        scalars["torque_from_forces_Nmm"] = 1e3 * problem.direction * torque
        errors["torque_from_forces_Nmm"] = errors["torque_Nmm"] + solved.left * over
    return scalars, errors


def _stiffness(problem: BearingProblem, placement: Placement, way: int) -> float:
    """Force per displacement of the inner ring in N/m along axis 0 or the radial load, 1, with all other loads as they are; nan
    where nothing holds the ring."""
    free = [k for k in range(5) if k == way or (k < 3 and (k or problem.axial_displacement is None)) or (
        k > 2 and problem.moments is not None)]
    scale = np.array([1.0, 1.0, 1.0, problem.arm, problem.arm])
    own = (placement.stiffness / np.outer(scale, scale))[np.ix_(free, free)]
    largest = float(np.abs(own).max())
    if largest == 0.0:
        return math.nan
    stiff = 1.0 / float(np.linalg.pinv(own, rcond=1e-9)[free.index(way), free.index(way)] or math.inf)
    return stiff if stiff > 1e-9 * largest else math.nan


def life(problem: BearingProblem, loads: Array) -> float:
    """Basic reference rating life L10r in millions of revolutions after ISO/TS 16281, from the `loads` (n, 2) of both rings:

        Q_c,i = C/(0.407 Z cos α⁰) (1 + x^(10/3))^0.3,     Q_c,e = C/(0.389 Z cos α⁰) (1 + x^(−10/3))^0.3,
        x = 1.044 ((1 − γ)/(1 + γ))^1.72 (f_i (2f_o − 1)/(f_o (2f_i − 1)))^0.41,     γ = D/d_m,

    with the nominal contact angle 0, and L = ((Q_ci/Q_ei)^(−10/3) + (Q_ce/Q_ee)^(−10/3))^(−0.9). The load of the ring that
    turns under it is the cubic mean, that of the other the mean of the power 10/3. nan without a capacity, and without
    rolling."""
    if problem.capacity is None or not problem.rolls or not loads.any():
        return math.nan
    ratio, (inner, outer) = problem.ball_diameter / problem.pitch_diameter, problem.conformity
    x = (1.044 * ((1.0 - ratio) / (1.0 + ratio)) ** 1.72
         * (inner / outer * (2.0 * outer - 1.0) / (2.0 * inner - 1.0)) ** 0.41)
    share = problem.capacity / problem.balls
    carried = share / 0.407 * (1.0 + x ** (10 / 3)) ** 0.3, share / 0.389 * (1.0 + x ** (-10 / 3)) ** 0.3
    still = [speed == 0.0 for speed in problem.speeds]
    powers = (10 / 3, 3.0) if still[0] and not still[1] else (3.0, 10 / 3)
    worn = 0.0
    for k, power in enumerate(powers):
        equivalent = float(np.mean(loads[:, k] ** power)) ** (1.0 / power)
        worn += (equivalent / carried[k]) ** (10 / 3)
    return float(worn ** -BOTH_RINGS)


def _warnings(solved: SolvedBearing, contacts: Sequence[Result]) -> Iterator[str]:
    """Balls that do not roll, and the doubts about contacts, each once."""
    free = [str(ball + 1) for kind in solved.balls if not kind.loaded for ball in kind.members]
    if free:
        force = float(solved.problem.centrifugal(max((kind.motion[0] for kind in solved.balls if not kind.loaded), key=abs)))
        outer = f": {force:.3g} N press them against the outer one" if force and solved.problem.rolls else ""
        yield (f"the inner ring hardly touches ball {', '.join(sorted(free, key=int))}{outer}; the result has no contacts "
               "of it")
    seen: dict[str, str] = {}
    for contact in contacts:
        for warning in contact.warnings:
            seen.setdefault(re.sub(r"[0-9.]+", "#", warning), f"contact {contact.name}: {warning}")
    yield from seen.values()


def _around(solved: SolvedBearing) -> dict[str, Array]:
    """Loads (N) and angles (rad) of all balls around the bearing, (2, n) at the inner and the outer ring."""
    placement = solved.placement
    return {"loads": placement.loads.T.copy(), "angles": np.where(placement.loads > 0.0, placement.angles, math.nan).T.copy()}

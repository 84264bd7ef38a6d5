"""The answer: a ball bearing with all its contacts, as scalars, and the result of each contact."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.bearing.bearing_problem import AXIAL, RADIAL, RINGS, BearingProblem, RingName
from thermoroll_cli.bearing.placement import Placement
from thermoroll_cli.bearing.solve_bearing import Ball, BearingSearch, SolvedBearing
from thermoroll_cli.problem.names import BALL_SCALARS, SCALARS, TOGETHER
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import computed, error_scale

LARGEST_POWER_ERROR = 2e-3
"""Heat of all contacts against the power of the rings, relative."""
ONLY_ROLLING = ("Q_F_W", "T_gamma_N", "gamma_st", "stick_area_mm2", "power_balance_error")
"""Scalars that say nothing of rings at rest."""
PRESSED = ("pressure", "peak pressure", "relative peak pressure", "area", "relative area")
"""Kinds of scalars that depend on the load, and not on the motion."""
BOTH_RINGS = 0.9
"""Exponent that joins the lives of both rings (Lundberg and Palmgren 1947)."""


class BearingSolver:
    """Solves bearing after bearing."""

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads

    def solve(
        self, problem: BearingProblem, *, report: Callable[[str, Mapping[str, Any]], None] | None = None
    ) -> Result:
        """The result of `problem`; `reason` says what goes wrong. `report` is called with a stage and a mapping."""
        return result_of(BearingSearch(problem, self.threads, report or (lambda stage, info: None)).solve())


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


def result_of(solved: SolvedBearing) -> Result:
    """The result of a solved bearing; not converged where it is not in balance, or where a contact is not."""
    contacts = tuple(_contacts(solved))
    scalars, errors = _scalars(solved, contacts)
    reasons = [solved.reason] if solved.reason else []
    reasons += [f"contact {contact.name}: {contact.reason}" for contact in contacts if not contact.converged][:4]
    if solved.problem.balances and not reasons and scalars["torque_Nmm"] > 0.0:
        missing = abs(scalars["torque_from_forces_Nmm"] / scalars["torque_Nmm"] - 1.0)
        if missing > LARGEST_POWER_ERROR + errors["torque_Nmm"] / scalars["torque_Nmm"]:
            reasons.append(f"the torques from heat and from forces differ by {missing:.1e}")
    state = State({}, scalars, np.zeros(0), np.zeros(0))
    grid: list[int] = max((contact.work["grid"] for contact in contacts), default=[])
    return Result(
        problem=solved.problem.contact, coupled=state, isothermal=state, of_problem={}, converged=not reasons,
        reason="; ".join(reasons), uncertainty=errors, patches=contacts, assembly="bearing",
        work={"grid": grid, "rounds": solved.rounds, "contact_solves": solved.solves},
        warnings=(*bearing_warnings(solved.problem), *_warnings(solved, contacts)), lines=_around(solved))


def _contacts(solved: SolvedBearing) -> Iterator[Result]:
    """The results of all contacts, ball by ball, with the errors that the balance of the balls passes on to them."""
    problem = solved.problem
    for j in range(problem.balls):
        ball = next(ball for ball in solved.balls if j in ball.members)
        for ring, solved_contact in ball.contacts.items():
            result = solved_contact.result
            if not problem.rolls:
                nothing = dict.fromkeys(ONLY_ROLLING, math.nan)
                state = replace(result.coupled, scalars={**result.coupled.scalars, **nothing})
                result = replace(result, coupled=state, isothermal=state)
            load, moved, power = ball.passed_on.get(ring, (0.0, 0.0, 0.0))
            numbers = result.numbers
            own = {name: error + (load + (0.0 if of_kind(name) in PRESSED else moved)) * abs(error_scale(name, numbers))
                   + (power if name == "Q_F_W" else 0.0) for name, error in result.uncertainty.items()}
            own |= {"normal_N": load * numbers["normal_N"]}
            whole = replace(result, name=f"ball_{j + 1}_{ring}", uncertainty=own)
            yield replace(whole, record=_record(problem, ball, j, ring, whole))


def of_kind(name: str) -> str:
    """The kind of a scalar of a contact."""
    return SCALARS[name].kind if name in SCALARS else "below"


def _record(problem: BearingProblem, ball: Ball, j: int, ring: RingName, result: Result) -> dict[str, Any]:
    """Numbers of a contact and of its ball, in the units of their names, with their errors."""
    k, scalars = RINGS.index(ring), result.numbers
    angle, motion = float(ball.angles[k]), ball.motion
    record: dict[str, Any] = {"ball": j + 1, "ring": ring, "normal_N": float(ball.loads[k]),
                              "contact_angle_deg": math.degrees(angle)}
    if problem.rolls:
        speed, slip, rolling = problem.slip(ring, angle, motion)
        turning = float(np.linalg.norm(motion[1:]))
        along, outwards, around = problem.direction * motion[1:]
        record |= {
            "rolling_speed_m_s": speed, "creepage_longitudinal": slip[0] / speed, "creepage_lateral": slip[1] / speed,
            "creepage_spin_rad_mm": 1e-3 * slip[2] / speed, "spin_to_roll": -slip[2] / rolling,
            "ball_pitch_deg": math.degrees(math.atan2(outwards, -along)),
            "ball_yaw_deg": math.degrees(math.asin(around / turning)), "ball_speed_rad_s": turning,
            "cage_speed_rad_s": float(motion[0]),
        }  # fmt: skip
        record = {name: float(value) if isinstance(value, np.floating) else value for name, value in record.items()}
    record |= {name: scalars[name] for name in BALL_SCALARS if name not in record and name in scalars
               and not math.isnan(scalars[name])}
    errors = {name: float(result.uncertainty.get(name, math.nan)) for name in record if name not in ("ball", "ring")}
    if ring in ball.creepage_errors:
        errors |= dict(zip(("creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm"),
                           ball.creepage_errors[ring] * [1.0, 1.0, 1e-3], strict=True))
        errors |= {"spin_to_roll": errors["creepage_spin_rad_mm"] / abs(record["creepage_spin_rad_mm"] or math.nan)
                   * abs(record["spin_to_roll"]), "cage_speed_rad_s": ball.cage_error}
    return record | {"status": result.status, "uncertainty": errors}


def _scalars(solved: SolvedBearing, contacts: Sequence[Result]) -> tuple[dict[str, float], dict[str, float]]:
    """Scalars of the whole bearing and their errors."""
    problem, placement = solved.problem, solved.placement
    ring = placement.ring
    scalars = {
        "axial_displacement_um": 1e6 * ring[0], "radial_displacement_um": 1e6 * ring[1],
        "radial_displacement_across_um": 1e6 * ring[2], "tilt_mrad": 1e3 * ring[3], "tilt_across_mrad": 1e3 * ring[4],
        "cage_speed_rad_s": math.nan, "torque_Nmm": math.nan, "torque_from_forces_Nmm": math.nan,
        "axial_stiffness_N_um": 1e-6 * _stiffness(problem, placement, 0),
        "radial_stiffness_N_um": 1e-6 * _stiffness(problem, placement, 1), "life_L10r_Mrev": life(problem, placement.loads),
    }  # fmt: skip
    scalars = {name: float(value) for name, value in scalars.items()}
    load = max((of[0] for ball in solved.balls for of in ball.passed_on.values()), default=0.0)
    # Errors of the friction that pushes the balls are loads on the ring.
    pushed = load * float(placement.loads[:, 0].sum())
    axial, radial = (pushed / scalars[f"{way}_stiffness_N_um"] for way in ("axial", "radial"))
    errors = {"axial_displacement_um": axial, "radial_displacement_um": radial, "radial_displacement_across_um": radial,
              "tilt_mrad": 1e-3 * axial / problem.arm, "tilt_across_mrad": 1e-3 * axial / problem.arm}
    errors |= {name: load * abs(scalars[name]) for name in ("axial_stiffness_N_um", "radial_stiffness_N_um")}
    errors["life_L10r_Mrev"] = 3.0 * load * scalars["life_L10r_Mrev"]
    if problem.axial_displacement is not None:
        errors["axial_displacement_um"] = math.nan
    summaries = [contact.summary() for contact in contacts]
    for name, scalar in TOGETHER.items():
        mine = [summary for summary in summaries if computed(summary.get(name))]
        assert scalar.together is not None
        if mine:
            own = [summary["uncertainty"].get(name, math.nan) for summary in mine]
            scalars[name] = scalar.together(summary[name] for summary in mine)
            errors[name] = (math.fsum if scalar.together is math.fsum else max)(own)
    if problem.rolls and contacts:
        over = 1e3 / abs(problem.speeds[0] - problem.speeds[1])
        carried = [(ball, len(ball.members)) for ball in solved.balls if ball.loaded]
        count = sum(number for _, number in carried)
        torque = sum(number * _torque(problem, ball) for ball, number in carried)
        scalars |= {"cage_speed_rad_s": float(sum(ball.motion[0] * number for ball, number in carried) / count),
                    "torque_Nmm": scalars["Q_F_W"] * over, "torque_from_forces_Nmm": 1e3 * problem.direction * torque}
        errors |= {"torque_Nmm": errors["Q_F_W"] * over, "torque_from_forces_Nmm": errors["Q_F_W"] * over,
                   "cage_speed_rad_s": sum(ball.cage_error * number for ball, number in carried) / count}
    return scalars, errors


def _torque(problem: BearingProblem, ball: Ball) -> float:
    """Torque in N m by which a ball brakes the inner ring, about the bearing's axis."""
    lever = np.cross(0.5 * problem.pitch_diameter * RADIAL, ball.contacts["inner"].force)
    return float((lever + ball.contacts["inner"].moment) @ AXIAL)


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

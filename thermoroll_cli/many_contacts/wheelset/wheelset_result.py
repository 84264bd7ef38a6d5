"""The answer: a wheelset in balance with all its patches, as scalars in track axes with forces on the rails."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.wheelset.first_contact import roll_of, touching, wheelset_warnings
from thermoroll_cli.many_contacts.wheelset.one_wheel import BALANCED, STIFFENING, same_patch
from thermoroll_cli.many_contacts.wheelset.patch_problem import SolvedPatch
from thermoroll_cli.many_contacts.wheelset.patch_surface import patches_of
from thermoroll_cli.many_contacts.wheelset.solve_wheelset import FINE, ROUGH, Report, SolvedWheelset, SteadySolvers, balanced
from thermoroll_cli.many_contacts.wheelset.varying import VaryingFacing, varying_patch
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem, sign_of
from thermoroll_cli.problem.names import IN_CONTACT, PATCH_SCALARS, TOGETHER, of_kind, of_side
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import error_scale, missed_by_whole, passed_on, together, worst
from thermoroll_cli.tools.arrays import Array

FORCES = "xyz"
POWERS = of_kind("integral", "exchanged heat", "worn")
"""Scalars that are powers of the creep forces, or follow these."""
LARGEST_FORCE_ERROR = 1e-3
"""Departure of the vertical force from a given one: ten times the change from round to round that ends them."""
LARGEST_POWER_ERROR = 2e-3
"""Heat of all patches against the power that the rails take from the wheelset."""
ROLLING = 1e-3
"""A wheelset with less heat than this share of friction limit times speed hardly slips: its heat is a small difference."""
ABOVE = tuple((0.006 * np.arange(-10, 11)).tolist()), 5e-4
"""Places (m) ahead of the axle, and the distance (m) of those across, at which a track that changes is kept."""
WIDEST_PLANE = 0.3
"""Turn of the surface across a patch (rad) from which a plane is a doubtful model; the solver warns of curved patches."""

JUDGED = ("height_mm", "roll_mrad", "angular_velocity_rad_s",
          *(f"track_force_{axis}_{side}_N" for axis in FORCES for side in SIDES))
"""Scalars of the whole that have to be as accurate as is asked for, if no others are named; patches answer for all else."""


class WheelsetSolver:
    """Solves wheelset after wheelset; each begins where the last one stood, and its patches from the last results."""

    def __init__(self, threads: int = 1, options: object = None) -> None:
        self._before: SolvedWheelset | None = None
        self._solvers = SteadySolvers(threads)

    def solve(self, problem: WheelsetProblem, *, report: Report | None = None) -> Result:
        """The result of `problem`. `report` is called with a stage and a mapping as the work goes on. Raises Unsolvable if a
        wheel misses its rail; `reason` says everything else that goes wrong."""
        first = touching(problem)
        warnings = tuple(wheelset_warnings(problem, first))
        found = balanced(problem, roll_of(first), self._before, self._solvers, report or (lambda stage, info: None))
        self._before = None if found.reason else found
        return result_of(found, warnings)


def solve_wheelset(problem: WheelsetProblem, *, threads: int = 1, report: Report | None = None) -> Result:
    """The result of `problem`, as by `WheelsetSolver`."""
    return WheelsetSolver(threads).solve(problem, report=report)


def result_of(solved: SolvedWheelset, warnings: tuple[str, ...]) -> Result:
    """The result of a solved wheelset; not converged where it is not in balance, or where a patch is not."""
    problem, shared = solved.problem, _shared_errors(solved)
    contacts = {side: tuple(_contacts(solved, shared, side)) for side in problem.sides}
    patches = tuple(patch for mine in contacts.values() for patch in mine)
    scalars, errors = _scalars(solved, shared, contacts)
    reasons = [solved.reason] if solved.reason else []
    share, places = (0.5, [f"{side}_" for side in problem.sides]) if problem.finds_roll else (1.0, [""])
    for place in places if problem.vertical is not None and not reasons else ():
        assert problem.vertical is not None
        force, wanted = scalars[f"track_force_z_{place}N"], share * problem.vertical
        if abs(force - wanted) > max(LARGEST_FORCE_ERROR, solved.left) * wanted:
            where = f"{place.rstrip('_')} rail carries" if place else "rails carry"
            reasons.append(f"the {where} {force:.6g} N, not {wanted:.6g} N: no height gives this force, which jumps there")
    reasons += [f"patch {patch.name}: {patch.reason}" for patch in patches if not patch.converged]
    sliding = sum(patch.problem.traction_limit for patch in patches) * problem.motion.speed
    # Patches have checked their own balance; together they err by what the angular velocity leaves unbalanced, too.
    unbalanced = FINE * sliding if problem.finds_speed else 0.0
    allowed = LARGEST_POWER_ERROR * max(scalars["Q_F_W"], ROLLING * sliding) + errors.get("Q_F_W", 0.0) + unbalanced
    if scalars["power_balance_error"] * scalars["Q_F_W"] > allowed:
        reasons.append(f"the heat of the patches and the power of the wheelset differ by {scalars['power_balance_error']:.1e}")
    if not reasons and (missed := missed_by_whole(scalars, errors, problem.contact.numerics, JUDGED)):
        reasons.append(missed)
    of_patches = dict.fromkeys(f"patch {patch.name}: {warning}" for patch in patches for warning in patch.warnings)
    state = State({}, scalars, np.zeros(0), np.zeros(0))
    return Result(
        problem=problem.contact, coupled=state, isothermal=state, of_problem={}, converged=not reasons,
        reason="; ".join(reasons), uncertainty=errors,
        work={"grid": next((patch.work["grid"] for patch in patches), []), "rounds": solved.rounds},
        patches=patches, assembly="wheelset",
        warnings=(*warnings, *_doubts(solved), *of_patches), lines=_outlines(solved))


def _contacts(solved: SolvedWheelset, shared: SharedErrors, side: SideName) -> Iterator[Result]:
    """The results of the patches of a side, from the left of the track, with their errors and places on the track: errors are
    a contact's own and that of its load, with which they grow at most in proportion. The power of the creep forces has also
    that of the creepage, by the angular velocity."""
    sign = sign_of(side)
    mine = [pair for pair in zip(solved.patches, shared.loads, strict=True) if pair[0].side == side]
    mine.sort(key=lambda pair: sign * pair[0].centre[1])
    for number, (patch, load) in enumerate(mine, 1):
        result = patch.result
        power, numbers = result.coupled.scalars["T_gamma_N"], result.numbers
        moved = abs(patch.force[0]) * shared.velocity / power if power else 0.0
        errors = {name: error + (load + (moved if name in POWERS else 0.0)) * error_scale(name, numbers)
                  for name, error in result.uncertainty.items()}
        surface, s = patch.carrying.patch, -result.y
        places = surface.position.on_track(surface.places(s))
        own_axes = (warning.replace(" y = ", " y (in the axes of its result) = ") for warning in result.warnings)
        whole = replace(
            result, name=f"{side}_{number}", uncertainty=errors | {"normal_N": load * result["normal_N"]},
            warnings=(*own_axes, *_doubts_of_patch(patch)),
            lines={"surface": np.stack([sign * places[:, 1], places[:, 2], sign * surface.inclination(s)])})
        yield replace(whole, record={"side": side, "number": number, **_record(patch, whole)})


def _outlines(solved: SolvedWheelset) -> dict[str, Array]:
    """Rails and wheels across the track, the axles of rollers, and where bodies change along rolling the tops of rails and the
    bottoms of wheels around the axle."""
    lines: dict[str, Array] = {}
    for side in solved.problem.sides:
        facing = solved.problem.facing(side, solved.standing.roll)
        facing = facing.lowered(solved.standing.height - facing.position.z)
        mirror, position = np.array([[sign_of(side)], [1.0]]), facing.position
        y, r = facing.wheel.samples[:2]
        section = position.rotation @ np.array([0.0 * y, y, r]) + position.origin(facing.wheel.radius)[:, None]
        locus = facing.locus[1:3]
        lines |= {f"rail_{side}": mirror * facing.rail.samples[:2],
                  f"wheel_{side}": mirror * np.where(np.isnan(locus), section[1:], locus)}
        if isinstance(facing, VaryingFacing):
            y = facing.outlines[0].y
            across = np.arange(float(y[0]), float(y[-1]), ABOVE[1])
            seen = facing.heights(np.array(ABOVE[0]), across)
            for x, *heights in zip(ABOVE[0], seen.rail, seen.wheel, strict=True):
                lines |= {f"{body}_{side}_at_{1e3 * x:g}_mm": mirror * np.stack((across, z))
                          for body, z in zip(("top", "bottom"), heights, strict=True)}
        if roller := facing.rail.roller:
            across = facing.rail.samples[0]
            lines[f"axle_{side}"] = mirror * np.stack([across, np.full(len(across), roller.radius)])
    return lines


def _doubts(solved: SolvedWheelset) -> Iterator[str]:
    """Overlaps that are no patches; a balance between two states, from one to the other of which patches jump."""
    problem, standing = solved.problem, solved.standing
    shares = problem.contact.compliance_shares
    for side in problem.sides:
        facing = problem.facing(side, standing.roll)
        facing = facing.lowered(standing.height - facing.position.z)
        solved_at = [patch.carrying.patch.y for patch in solved.patches if patch.side == side]
        for patch in patches_of(facing, curved=problem.curved, shares=shares, make=varying_patch):
            if same_patch(solved_at, patch.y, float) is None and not patch.faces:
                yield (f"the {side} wheel and rail overlap at y = {1e3 * sign_of(side) * patch.y:.4g} mm, at the sharp "
                       "end of a profile, where no normal meets both surfaces: this contact is left out")
    if ROUGH < solved.left < math.inf:
        yield (f"the balance is met within {solved.left:.1e} of the load or the friction limit, as patches come and go with "
               "the elements: errors contain that; a finer numerics.grid or smoothing_mm of the profiles helps")


def _doubts_of_patch(patch: SolvedPatch) -> Iterator[str]:
    """A surface that turns far across a plane; contacts apart from each other that share the grid of the patch."""
    surface, y = patch.carrying.patch, patch.result.coupled.y
    loaded = np.flatnonzero(np.asarray(patch.result.coupled.fields["pressure"]).any(axis=0))
    turn = 0.0 if surface.curved or not len(loaded) else float(np.ptp(replace(surface, curved=True).inclination(-y[loaded])))
    if turn > WIDEST_PLANE:
        yield (f"the surface turns by {turn:.2g} rad across the patch, which lies in a plane: "
               'patches = "curved" follows the surface')
    parts = np.split(loaded, np.flatnonzero(np.diff(loaded) > 1) + 1)
    if len(parts) > 1:
        places = 1e3 * sign_of(patch.side) * surface.places(-y)[:, 1]
        yield (f"it holds {len(parts)} contacts, at y = {' and '.join(f'{places[part].mean():.4g}' for part in parts)} mm, on "
               f"one grid: the narrowest is {min(map(len, parts))} elements wide; compare pressures with a finer numerics.grid")


def _record(patch: SolvedPatch, result: Result) -> dict[str, Any]:
    """Place, forces, creepages and the scalars of a patch with its `result` in track axes, in the units of their names, and
    their errors."""
    sign, scalars = sign_of(patch.side), result.scalars
    x, y, z = patch.on_track
    along, across, normal = patch.local
    rail, wheel = patch.in_profiles
    record = {
        "x_mm": 1e3 * x, "y_mm": 1e3 * sign * y, "z_mm": 1e3 * z, "angle_mrad": 1e3 * sign * patch.angle,
        "y_rail_mm": 1e3 * rail, "y_wheel_mm": 1e3 * wheel,
        "normal_N": normal, "force_x_N": along, "force_s_N": sign * across,
        "moment_n_Nmm": -sign * scalars["spin_moment_Nmm"],
        "creepage_x": patch.creepages[0], "creepage_s": sign * patch.creepages[1],
        "spin_rad_mm": 1e-3 * sign * patch.creepages[2],
    }  # fmt: skip
    record |= {name: scalars[name] for name in PATCH_SCALARS if name not in record and name in scalars}
    errors = {name: result.uncertainty.get(IN_CONTACT.get(name, name), math.nan) for name in record}
    return record | {"status": result.status, "uncertainty": errors}


Estimated = dict[str, tuple[float, float | None]]
"""Scalars, each with its error: nan where it is unknown, None of what is given or not there."""
NOT_THERE = math.nan, None


def _scalars(
    solved: SolvedWheelset, shared: SharedErrors, contacts: Mapping[SideName, Sequence[Result]]
) -> tuple[dict[str, float], dict[str, float]]:
    """Scalars of the whole wheelset and their errors, from its `contacts` by side; forces are in track axes. What is given, or
    not there, has no error, and neither has anything in the air."""
    sides = _of_sides(solved, shared)
    found = {**_position(solved, shared), **sides, **_of_both(solved.problem, sides), **_of_all_patches(contacts)}
    scalars = {name: value for name, (value, _) in found.items()}
    heat, power = scalars["Q_F_W"], sum(patch.power for patch in solved.patches) - scalars.get("expansion_power_W", 0.0)
    # Over time a part of the power is stored.
    over_time = any("work_J" in patch.result.coupled.scalars for patch in solved.patches)
    scalars["power_balance_error"] = math.nan if over_time else abs(heat + power) / heat if heat > 0.0 else 0.0
    return scalars, {name: error for name, (_, error) in found.items() if error is not None and solved.patches}


def _position(solved: SolvedWheelset, shared: SharedErrors) -> Estimated:
    """Where the wheelset stands, and how fast it turns."""
    problem, velocity = solved.problem, -solved.angular_velocity
    rolled = Estimated()
    for side in (side for side, surfaces in problem.surfaces.items() if any(surfaces)):
        spots = sum(patch.result.coupled.spots for patch in solved.patches if patch.side == side)
        rolled |= {f"surface_height_{side}_um": (1e6 * problem.rails[side].lifts, None),
                   f"contact_spots_{side}": (float(spots), None)}
    if problem.varies:
        rolled |= {"position_mm": (1e3 * problem.along, None), "rotation_deg": (math.degrees(problem.turned), None)}
    return {
        **rolled, "height_mm": (1e3 * solved.standing.height, None if problem.vertical is None else 1e3 * shared.height),
        "roll_mrad": (1e3 * solved.standing.roll, 1e3 * shared.roll if problem.finds_roll else None),
        "angular_velocity_rad_s": (velocity, shared.velocity * abs(velocity) if problem.finds_speed else None)}


def _of_sides(solved: SolvedWheelset, shared: SharedErrors) -> Estimated:
    """Forces on each rail, and the rolling radius of the patch with the largest load. A vertical force that is given for each
    wheel has no error."""
    problem, found = solved.problem, Estimated()
    given = problem.vertical is not None and (problem.finds_roll or len(problem.wheels) == 1)
    for side in SIDES:
        mine = [pair for pair in zip(solved.patches, shared.loads, strict=True) if pair[0].side == side]
        there = side in problem.sides
        force = sum((np.array([1.0, sign_of(side), 1.0]) * patch.force for patch, _ in mine), np.zeros(3))
        error = sum((patch.force_errors(load) for patch, load in mine), np.zeros(3))
        for axis, value, by in zip(FORCES, force.tolist(), error.tolist(), strict=True):
            found[f"track_force_{axis}_{side}_N"] = (value, None if axis == "z" and given else by) if there else NOT_THERE
        ratio, vertical = float(force[1] / force[2]) if force[2] else math.nan, 0.0 if given else float(error[2])
        by = float(passed_on([float(error[1]), vertical], [1.0, ratio])) / abs(float(force[2])) if force[2] else math.nan
        found[f"lateral_over_vertical_{side}"] = (ratio, by) if there else NOT_THERE
        most = max((patch for patch, _ in mine), key=lambda patch: patch.carrying.load, default=None)
        found[f"rolling_radius_{side}_mm"] = NOT_THERE if most is None else (
            1e3 * most.rolling_radius, 1e3 * most.rolling_radius_error)
    return found


def _of_both(problem: WheelsetProblem, sides: Estimated) -> Estimated:
    """Forces on both rails, and the difference of the rolling radii. A vertical force that is given has no error."""
    found = Estimated()
    for axis in FORCES:
        forces, errors = zip(*(sides[f"track_force_{axis}_{side}_N"] for side in problem.sides), strict=True)
        given = axis == "z" and problem.vertical is not None
        found[f"track_force_{axis}_N"] = sum(forces), None if given else sum(errors)
    (left, left_error), (right, right_error) = (sides[f"rolling_radius_{side}_mm"] for side in SIDES)
    error = None if left_error is None or right_error is None else left_error + right_error
    return found | {"rolling_radius_difference_mm": (right - left, error)}


def _of_all_patches(contacts: Mapping[SideName, Sequence[Result]]) -> Estimated:
    """What all patches have together, and sums over those of each wheel."""
    summaries = {side: [patch.summary() for patch in mine] for side, mine in contacts.items()}
    everyone = [summary for mine in summaries.values() for summary in mine]
    found = {"approach_max_um": together("approach_um", everyone)}
    for name, scalar in TOGETHER.items():
        assert scalar.together is not None
        found[name] = together(name, everyone, scalar.together)
        if scalar.together is math.fsum:
            found |= {of_side(name, side): together(name, mine, math.fsum) for side, mine in summaries.items()}
    found = {name: pair for name, pair in found.items() if not math.isnan(pair[0])}
    rises = [found[name] for body in BODIES if (name := f"temperature_rise_max_{body}_K") in found]
    nothing: Estimated = {"Q_F_W": (0.0, None), "T_gamma_N": (0.0, None), "pressure_max_MPa": (math.nan, None)}
    return nothing | found | {"temperature_rise_max_K": (
        max((value for value, _ in rises), default=math.nan), worst(error for _, error in rises) if rises else math.nan)}


# --- errors of height, velocity and loads, from those of the patches -------------------------------------------------


class SharedErrors(NamedTuple):
    """Errors of the `height` (m) and, if it is found, of the `roll` (rad), which is that of the heights of both wheels over the
    span; of the `loads` of all patches over themselves, and of the angular `velocity` over itself. 0 of what is given."""

    height: float
    roll: float
    loads: tuple[float, ...]
    velocity: float


def _shared_errors(solved: SolvedWheelset) -> SharedErrors:
    """Errors of height and loads. With errors e of the approaches δ at the same loads W, and an error dz of the height,

        dW_i = k_i (dz cos α_i − e_i),      k_i = 1.5 W_i/δ_i.

    At a given height dz = 0. Patches that carry a given force together have dz = Σ k_j e_j/Σ k_j cos α_j, and at about the same
    inclination dW_i = k_i Σ k_j (e_j − e_i)/Σ k_j. Signs are unknown: absolute values add. A load that is in equilibrium with a
    vertical force errs by the tolerance of that, too, by the last change of the ratio of both, and by the friction, which has a
    part in it; the angular velocity by the forces along the track, and by what the search left of them, over their change with
    it."""
    patches, finds_height = solved.patches, solved.problem.vertical is not None
    sunk, cosines = (np.array(column) for column in ([patch.carrying.sunk for patch in patches],
                                                     [math.cos(patch.carrying.patch.angle) for patch in patches]))
    stiffness = STIFFENING * np.array([patch.carrying.load for patch in patches]) / sunk
    estimated = sunk * np.array([patch.error_of("approach_um") / patch.result["approach_um"] for patch in patches])
    # The approach over that of the coarse grid has changed since the load was shared.
    moved = [abs(patch.solved.over_coarse / patch.carrying.over_coarse - 1.0) for patch in patches]
    approach = estimated + sunk * np.array(moved)
    heights, loads = [0.0], np.zeros(len(patches))
    sides = [patch.side for patch in patches]
    # Both wheels carry a force together if the roll is given.
    for of in [{side} for side in set(sides)] if solved.problem.finds_roll else [set(sides)]:
        group = [k for k, side in enumerate(sides) if side in of]
        own = stiffness[group]
        by_approach = -np.eye(len(group))
        if finds_height:
            heights.append(float(passed_on(estimated[group], own / (own @ cosines[group]))))
            by_approach += own / own.sum()
            for k in group:
                patch = patches[k]
                friction = abs(math.sin(patch.angle)) * patch.error_of("force_y_N") / patch.carrying.load
                loads[k] = BALANCED + abs(patch.solved.vertical / patch.carrying.vertical - 1.0) + friction
        loads[group] += STIFFENING / sunk[group] * passed_on(approach[group], by_approach)
    roll = sum(heights) / solved.problem.span if solved.problem.finds_roll else 0.0
    limit, velocity = sum(patch.result.problem.traction_limit for patch in patches), 0.0
    if solved.problem.finds_speed and limit:
        forces = sum(patch.force_errors(load)[0] for patch, load in zip(patches, loads.tolist(), strict=True))
        velocity = float(forces / limit + max(FINE, solved.left)) / abs(solved.drive_slope)
    return SharedErrors(max(heights), roll, tuple(loads.tolist()), velocity)

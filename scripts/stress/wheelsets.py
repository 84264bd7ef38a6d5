"""Seeded wheelsets on rails, and the check of each."""

from __future__ import annotations

import pathlib
from dataclasses import replace
from typing import Any

import numpy as np

from scripts.stress.courses import REFERENCE, pairs
from scripts.stress.outcome import Outcome
from thermoroll_cli import Case, CaseError
from thermoroll_cli.files.profile_file import read_outline
from thermoroll_cli.many_contacts.history.wheelset_over_time import WheelsetHistorySolver
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.names import UNCERTAINTY
from thermoroll_cli.problem.problem import Numerics
from thermoroll_cli.problem.result import Result

ROOT = pathlib.Path(__file__).parents[2]
RAILS = (("cases/MBench_UIC60_v3.prr", 0.0), ("tests/reference/wheelset/uic60_true.prr", 0.025),
         ("tests/reference/wheelset/site_b_hr.prr", 0.0))
"""Outlines of rails and their cant."""
WHEELS = (("cases/MBench_S1002_v3.prw", 1360.0, -70.0), ("tests/reference/wheelset/worn_high_mileage.prw", 1347.4, 0.0))
"""Outlines of wheels, distance of the flange backs, and y of the flange back."""
MEASURED = ROOT / "tests" / "reference" / "measured_profiles"
TIP = 8.0
"""Width (mm) of the tip of a flange on either side of its lowest point."""
EXCUSES = ("a flange climbs", "meet at sharp ends alone")
"""Words of the reasons of wheels that friction holds, and of those that meet their rails at the ends of profiles alone."""
LOAD_SHARE, POWER_SHARE, SLIPS = 1e-3, 2e-3, 1e-2
"""Departure of the vertical force from the load, and of the power from the heat, that may remain: from this share of the power
of full sliding where a wheelset hardly slips, for its angular velocity is found to a share of that."""


def random_wheelset(seed: int) -> Case:
    """The wheelset of `seed`, always the same."""
    return Case.from_dict(_drawn(np.random.default_rng([17, seed])))


def moved_rails(seed: int) -> Case:
    """A wheelset on rails with shifts and rolls of their own, with unequal wheels, and here and there beside its rails."""
    rng = np.random.default_rng([31, seed])
    content = _drawn(rng)
    for side in ("left", "right"):
        if rng.random() < 0.7:
            content["track"][side] = {"shift_y_mm": float(rng.uniform(-4.0, 4.0)), "shift_z_mm": float(rng.uniform(-3.0, 3.0)),
                                      "roll_mrad": float(rng.uniform(-25.0, 25.0))}
        if rng.random() < 0.4:
            content["wheelset"][side] = {"nominal_radius_mm": 460.0 + float(rng.uniform(-2.0, 2.0))}
    if rng.random() < 0.1:
        content["wheelset"]["lateral_shift_mm"] *= 10.0
    return Case.from_dict(content)


def on_rollers(seed: int) -> Case:
    """The wheelset of `moved_rails` on rollers, from half as large as the wheels to much larger."""
    rng = np.random.default_rng([37, seed])
    track = {"track.roller_radius_mm": float(10.0 ** rng.uniform(2.4, 4.0))}
    return moved_rails(seed).with_values(track | {"wheelset.longitudinal_shift_mm": float(rng.normal(0.0, 2.0))})


def tread_and_flange(seed: int) -> Case:
    """A wheelset with friction over the inclination of its rails: one to five points, some without friction, here and there
    others on one rail."""
    rng = np.random.default_rng([47, seed])
    content = _drawn(rng)

    def points() -> list[list[float]]:
        count = int(rng.integers(1, 6))
        angles = np.sort(rng.uniform(-75.0, 20.0, count)) + 1e-3 * np.arange(count)
        coefficients = np.where(rng.random(count) < 0.15, 0.0, rng.uniform(0.05, 0.6, count))
        return np.stack((angles, coefficients), axis=1).tolist()  # type: ignore[no-any-return]

    del content["load"]["friction_coefficient"]
    content["friction"] = {"over_angle": points()}
    side = ("left", "right")[rng.integers(2)]
    if rng.random() < 0.5 and content["wheelset"]["wheels"] in ("both", side):
        content["friction"][side] = {"over_angle": points()}
    return Case.from_dict(content)


def displaced(seed: int) -> Case:
    """A wheelset with unequal wheels that climbs a rail, or nearly: ± 8 to 14 mm, up to 40 mrad of yaw, friction up to 1."""
    rng = np.random.default_rng([41, seed])
    content = _drawn(rng)
    content["load"]["friction_coefficient"] = float(rng.uniform(0.0, 1.0))
    content["wheelset"] |= {
        "wheels": "both" if rng.random() < 0.7 else content["wheelset"]["wheels"],
        "lateral_shift_mm": float(rng.choice([-1.0, 1.0]) * rng.uniform(8.0, 14.0)),
        "yaw_mrad": float(rng.uniform(-40.0, 40.0)),
    }
    for side in ("left", "right"):
        if rng.random() < 0.4:
            content["wheelset"][side] = {"nominal_radius_mm": 460.0 + float(rng.uniform(-2.0, 2.0))}
    return Case.from_dict(content)


def over_time(seed: int, mirror: float = 1.0) -> Case:
    """A wheelset on a path of 5 to 200 mm, or its mirror image (-1): it is displaced, yaws and is loaded more or less, here and
    there with jumps, from the steady state or from nothing; one wheel of three in four, and every third seed with heat."""
    rng = np.random.default_rng([79, seed])
    content = _drawn(rng)
    if seed % 3 == 0:
        content["material"] |= {"conductivity_W_mK": 50.0, "diffusivity_mm2_s": 14.0, "expansion_um_mK": 11.5}
    wheelset = content["wheelset"]
    if wheelset["wheels"] == "both" and rng.random() < 0.6:
        wheelset["wheels"] = "left"
    # A flange that climbs has no balance, and one that jumps to the rail within a row no error.
    wheelset["lateral_shift_mm"], wheelset["yaw_mrad"] = float(rng.uniform(-6.0, 6.0)), float(rng.uniform(-4.0, 4.0))
    count, length = int(rng.integers(2, 5)), float(10.0 ** rng.uniform(0.7, 2.3))
    places = np.concatenate([[0.0], np.sort(rng.uniform(0.1, 0.9, count - 2)), [1.0]]) * length
    if rng.random() < 0.3:
        places = np.insert(places, 1, places[1]) if count > 2 else places
    count, values = len(places), {}
    away = 0.01 * length * rng.uniform(-1.0, 1.0, count)
    if rng.random() < 0.6:
        values["wheelset.yaw_mrad"] = mirror * (wheelset["yaw_mrad"] + min(2.0, 0.2 * length) * rng.uniform(-1.0, 1.0, count))
    if rng.random() < 0.4 and len(set(places)) == count:
        values["wheelset.lateral_shift_mm"] = mirror * (wheelset["lateral_shift_mm"] + away)
    if rng.random() < 0.5 or not values:
        values["wheelset.vertical_N"] = wheelset["vertical_N"] * rng.uniform(0.6, 1.0, count)
    for name in ("lateral_shift_mm", "yaw_mrad"):
        wheelset[name] *= mirror
    if mirror < 0.0:
        wheelset["wheels"] = {"left": "right", "right": "left", "both": "both"}[wheelset["wheels"]]
    content["history"] = {"distance_mm": places.tolist(), "steps": int(rng.choice([4, 8, 16])),
                          "begin": ("steady", "pressed")[rng.integers(2)],
                          "values": {key: given.tolist() for key, given in values.items()}}
    return Case.from_dict(content)


def worn_wheel(rng: np.random.Generator) -> tuple[dict[str, Any], float]:
    """The table of a profile as instruments find wheels, and y (mm) of its flange back: hollow or with a cylinder, on which
    wheelsets have a dead zone, with a thin flange or one of up to 76°, the face and the chamfered or rounded edge of the rim,
    4 µm of noise, any origin, and turned or mirrored signs."""
    y, z = np.array(read_outline(ROOT / WHEELS[0][0]).content).T
    if rng.random() < 0.6:
        z = z - float(rng.uniform(0.0, 1.5)) * np.exp(-(((y + 2.0) / 18.0) ** 2))
    elif rng.random() < 0.5:    # heights near that of the running circle are its own
        z = np.sign(z) * np.maximum(np.abs(z) - float(rng.uniform(0.02, 0.3)), 0.0)
    if rng.random() < 0.4:      # the face of the flange turned from 70° towards its back
        tip, steeper = int(np.argmax(z)), 1.0 / np.tan(np.radians(70.0)) - 1.0 / np.tan(np.radians(rng.uniform(70.0, 76.0)))
        y = y + np.where(y > y[tip], steeper * (np.maximum(z, 0.0) - z[tip]), 0.0)
    if rng.random() < 0.4:      # a flange worn on its face
        y = y - float(rng.uniform(0.0, 3.0)) * np.exp(-(((y + 38.0) / 4.0) ** 2))
    if rng.random() < 0.5:
        depth, round_off = float(rng.uniform(5.0, 35.0)), np.linspace(0.0, 0.5 * np.pi, int(rng.choice([2, 8])))[1:]
        edge = y[-1] + 5.0 * np.sin(round_off), z[-1] - 5.0 * (1.0 - np.cos(round_off))
        y, z = np.concatenate((y, edge[0], edge[0][-1:])), np.concatenate((z, edge[1], edge[1][-1:] - depth))
    if rng.random() < 0.3:
        z = z + rng.normal(0.0, 4e-3, len(z))
    origin, mirror, flip = float(rng.uniform(-50.0, 80.0)), bool(rng.random() < 0.3), bool(rng.random() < 0.2)
    points = np.stack(((-1.0 if mirror else 1.0) * (y + origin), (-1.0 if flip else 1.0) * z), axis=1)
    table: dict[str, Any] = {"points_mm": (points[::-1] if mirror else points).tolist(), "mirror": mirror, "flip": flip}
    return table, WHEELS[0][2] + origin


def worn_wheelset(seed: int) -> Case:
    """A wheelset that looks measured near the middle of the track, or measured wheels on measured rails."""
    rng = np.random.default_rng([61, seed])
    content = _drawn(rng)
    # In the middle spin is most of the power.
    content["wheelset"] |= {"lateral_shift_mm": 0.0 if rng.random() < 0.3 else float(rng.uniform(-6.0, 6.0)), "wheels": "both",
                            "yaw_mrad": 0.0, "vertical_N": float(rng.uniform(30e3, 160e3))}
    content["wheelset"]["flange_back_distance_mm"], content["numerics"]["grid"] = 1360.0, 24
    if rng.random() < 0.5:
        profile, back = worn_wheel(rng)
        content["wheelset"] |= {"wheel_profile": profile, "flange_back_mm": back}
    else:
        wheel = sorted(MEASURED.glob("*.whl"))[rng.integers(5)]
        rail = sorted(path for path in MEASURED.iterdir() if path.suffix.lower() == ".ban")[rng.integers(4)]
        back = min(y for y, _ in read_outline(wheel).content) + 0.05
        content["wheelset"] |= {"wheel_profile": {"file": str(wheel)}, "flange_back_mm": back}
        content["track"] |= {"rail_profile": {"file": str(rail), "mirror": rail.name == "avg_HR.BAN"}, "cant": 0.05,
                             "gauge_mm": 1435.0}
    return Case.from_dict(content)


def wrong_reference(seed: int) -> dict[str, Any]:
    """A wheelset in the middle of the track whose outline has its flange back elsewhere than it says."""
    rng = np.random.default_rng([37, seed])
    content = _drawn(rng)
    content["wheelset"]["lateral_shift_mm"] = 0.0
    content["wheelset"]["flange_back_mm"] += float(rng.uniform(-80.0, 80.0))
    return content


def check_reference(content: dict[str, Any]) -> Outcome:
    """A wheelset that stands on the tip of a flange is refused by the key of the flange back."""
    try:
        case = Case.from_dict(content)
    except CaseError as cause:
        keys = [finding.key for finding in cause.findings]
        broken = () if keys == ["wheelset.flange_back_mm"] else (f"refused for {keys}",)
        return Outcome(reason=str(cause), excused=True, broken=broken)
    try:
        task = case.task
        assert isinstance(task, WheelsetProblem)
        result = solve_wheelset(task)
    except Unsolvable as cause:
        broken = () if cause.key == "wheelset.flange_back_mm" else (f"refused for {cause.key}: {cause}",)
        return Outcome(reason=str(cause), excused=True, broken=broken)
    found = []
    for patch in result.contacts:
        outline = task.wheels[patch.record["side"]].profile
        tip = 1e3 * max(outline, key=lambda point: point[1])[0]
        if abs(patch.record["y_wheel_mm"] - tip) < TIP:
            found.append(f"patch {patch.name} lies on the tip of the flange")
    return Outcome(result.converged, result.reason, broken=tuple(found))


def _drawn(rng: np.random.Generator) -> dict[str, Any]:
    (rail, cant), (wheel, distance, back) = RAILS[rng.integers(len(RAILS))], WHEELS[rng.integers(len(WHEELS))]
    wheelset: dict[str, Any] = {
        "wheel_profile": {"file": str(ROOT / wheel)}, "nominal_radius_mm": 460.0, "flange_back_distance_mm": distance,
        "flange_back_mm": back, "lateral_shift_mm": float(rng.uniform(-13.0, 13.0)),
        "yaw_mrad": float(rng.uniform(-20.0, 20.0)),
        "wheels": ("left", "right", "both")[rng.integers(3)], "patches": ("curved", "planar")[rng.integers(2)],
        "vertical_N": float(np.exp(rng.uniform(np.log(1e3), np.log(160e3)))),
    }  # fmt: skip
    if rng.random() < 0.5:
        wheelset["angular_velocity_rad_s"] = 2.0 / 0.46 * (1.0 + 3e-3 * float(rng.normal()))
    gauge = 1435.0 + float(rng.uniform(-3.0, 15.0))
    return {
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "track": {"rail_profile": {"file": str(ROOT / rail)}, "cant": cant, "gauge_mm": gauge}, "wheelset": wheelset,
        "rolling": {"speed_m_s": 2.0}, "numerics": {"grid": 16}}


def check(case: Case) -> Outcome:
    """Solve the wheelset and check it. A wheel that misses its rail or meets it at the ends of the profiles alone, and a
    flange that climbs, are excused."""
    try:
        task = case.task
        assert isinstance(task, WheelsetProblem)
        result = solve_wheelset(task)
    except Unsolvable as cause:
        return Outcome(reason=str(cause), excused=True)
    return Outcome(result.converged, result.reason, excused=any(words in result.reason for words in EXCUSES),
                   broken=violations(task, result) if result.converged else ())


def check_over_time(case: Case, seed: int) -> Outcome:
    """Solve a wheelset over time: its load is carried at each row, other places change nothing, and its mirror image has the
    mirrored forces, within a tenth of their errors and what a balance may leave."""
    try:
        task = case.task
        result = WheelsetHistorySolver().solve(task)
        if not result.converged:
            return Outcome(reason=result.reason, excused=any(words in result.reason for words in EXCUSES))
        away = replace(task.course, places=tuple(place + 3.0 * task.course.places[-1] for place in task.course.places))
        others = [("other places", WheelsetHistorySolver().solve(replace(task, course=away)), 1.0),
                  ("mirror", WheelsetHistorySolver().solve(over_time(seed, -1.0).task), -1.0)]
    except Unsolvable as cause:
        return Outcome(reason=str(cause), excused=True)
    table, found = result.history, []
    loads = np.array(table.get("wheelset.vertical_N", task.problem.vertical))
    missing = np.abs(np.array(table["track_force_z_N"]) / loads - 1.0).max()
    if not missing < LOAD_SHARE:
        found.append(f"the load is missed by {missing:.1e}")
    errors = np.array(table[UNCERTAINTY + "track_force_y_N"])
    for name, other, sign in others:
        change = np.abs(np.array(table["track_force_y_N"]) - sign * np.array(other.history["track_force_y_N"]))
        if (change > 0.1 * errors + LOAD_SHARE * loads).any():
            found.append(f"{name}: the lateral force differs by {(change / loads).max():.1e} of the load")
    return Outcome(True, work=int(result.work["applications"] / result.work["steps"]), broken=tuple(found))


def covered_over_time(case: Case, *_: int) -> Outcome:
    """Solve a wheelset over time, with the estimated and true errors of the scalars of some rows."""
    try:
        task = case.task
        result = WheelsetHistorySolver().solve(task)
        n, steps = task.contact.numerics.grid[0], task.course.steps
        numerics = Numerics((REFERENCE * n, REFERENCE * n))
        problem = replace(task.problem, contact=replace(task.contact, numerics=numerics))
        course = replace(task.course, steps=REFERENCE * steps)
        fine = WheelsetHistorySolver().solve(replace(task, problem=problem, course=course))
    except Unsolvable as cause:
        return Outcome(reason=str(cause), excused=True)
    if not (result.converged and fine.converged):
        return Outcome(reason=result.reason or fine.reason, excused=any(words in result.reason for words in EXCUSES))
    return Outcome(True, pairs=tuple(pairs(result.history, fine.history, n)))


def violations(task: WheelsetProblem, result: Result) -> tuple[str, ...]:
    """The rails carry the load, the patches are numbered across, and the heat is the power."""
    scalars, found = result.scalars, []
    missing = abs(scalars["track_force_z_N"] / (task.vertical or 1.0) - 1.0)
    if not missing < LOAD_SHARE:
        found.append(f"the load is missed by {missing:.1e}")
    # Patches lose a part of their power in elements that slip only in part, and may miss their heat by its error.
    lost = sum(patch["power_balance_error"] * patch["Q_F_W"] for patch in result.contacts)
    sliding = sum(patch.problem.traction_limit for patch in result.contacts) * task.contact.motion.speed
    allowed = POWER_SHARE * max(scalars["Q_F_W"], SLIPS * sliding) + max(lost, result.uncertainty["Q_F_W"])
    if not scalars["power_balance_error"] * scalars["Q_F_W"] <= allowed:
        found.append(f"power and heat differ by {scalars['power_balance_error']:.1e}")
    for side in task.sides:
        places = [patch.record["y_mm"] for patch in result.contacts if patch.record["side"] == side]
        if not places or places != sorted(places):
            found.append(f"patches of the {side} side without order")
    return tuple(found)

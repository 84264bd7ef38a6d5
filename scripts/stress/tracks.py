"""Seeded tracks that change and wheels that are not round: rails that rise, wave, move aside, begin or end near the axle, and
wheels with flats and waves, of one side or of both, with different slices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.wheelsets import EXCUSES, violations
from thermoroll_cli import Case, CaseError
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.problem.geometry import Unsolvable

RADIUS = 460.0


def random_track(seed: int) -> dict[str, Any]:
    """Tables of the case of `seed`, always the same."""
    rng = np.random.default_rng([113, seed])
    wheels = str(rng.choice(["left", "right", "both"]))
    sides = ("left", "right") if wheels == "both" else (wheels,)
    track: dict[str, Any] = {side: {"rail_profile": _rail(rng), "origin_mm": [750.0, 0.0]} for side in sides}
    own = {side: {"wheel_profile": _wheel(rng)} for side in sides}
    wheelset = {"wheels": wheels, "nominal_radius_mm": RADIUS, "flange_back_mm": -70.0, "flange_back_distance_mm": 1360.0,
                "vertical_N": float(rng.uniform(2e4, 1e5)) * len(sides), "position_mm": float(rng.uniform(-40.0, 40.0)),
                "rotation_deg": float(rng.uniform(-6.0, 6.0)), "lateral_shift_mm": float(rng.uniform(-3.0, 3.0)), **own}
    if not any("sections" in each["wheel_profile"] for each in own.values()):
        del wheelset["rotation_deg"]
    if wheels != "both":
        wheelset["roll_mrad"] = float(rng.uniform(-1.0, 1.0))
    if rng.random() < 0.5:
        wheelset["angular_velocity_rad_s"] = 2e3 / RADIUS * (1.0 + float(rng.uniform(-5e-3, 5e-3)))
    return {"material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
            "rolling": {"speed_m_s": 2.0}, "numerics": {"grid": 12}, "track": track, "wheelset": wheelset}


def _rail(rng: np.random.Generator) -> dict[str, Any]:
    crown, y = float(rng.uniform(80.0, 400.0)), np.linspace(-30.0, 30.0, 41)
    places = np.arange(-200.0, 201.0, float(rng.choice([10.0, 20.0, 50.0])))
    rise, aside = float(rng.uniform(-0.05, 0.05)), float(rng.uniform(-0.05, 0.05))
    high, long, begins = float(rng.uniform(0.0, 0.2)), float(rng.uniform(80.0, 500.0)), rng.random() < 0.25
    sign, end = float(rng.choice([-1.0, 1.0])), float(rng.choice(places[np.abs(places) < 80.0]))
    low, length = [[-60.0, 25.0], [-35.0, 25.0]], 25.0
    sections = []
    for at in places.tolist():
        top = y**2 / (2.0 * crown) - rise * at + high * math.sin(2.0 * math.pi * at / long)
        points = np.stack((y + aside * at, top), axis=1).tolist()
        there = not begins or sign * (at - end) >= 0.0
        whole = length + float(np.hypot(*np.diff([low[1], *points], axis=0).T).sum())
        features = {"features_mm": [0.0, length, whole if there else -1.0]} if begins else {}
        lower = [[y + aside * at, z] for y, z in low] if begins else []
        sections.append({"at": at, "points_mm": lower + (points if there else []), **features})
    return {"flip": False, "sections": sections}


def _wheel(rng: np.random.Generator) -> dict[str, Any]:
    cone, half = float(rng.choice([0.0, 0.025, 0.05])), math.degrees(math.asin(float(rng.uniform(1.0, 30.0)) / RADIUS))
    if rng.random() < 0.3:
        return {"flip": False, "points_mm": [[y, -cone * y] for y in (-40.0, 0.0, 40.0)]}
    flat, high, waves = rng.random() < 0.6, float(rng.uniform(0.0, 0.05)), int(rng.integers(1, 20))
    sections = []
    for at in np.linspace(-15.0, 15.0, 121).tolist():
        chord = RADIUS * (math.cos(math.radians(half)) / math.cos(math.radians(at)) - 1.0) if flat and abs(at) < half else 0.0
        out = chord + high * math.sin(math.radians(waves * at))
        sections.append({"at": at, "points_mm": [[y, out - cone * y] for y in (-40.0, 0.0, 40.0)]})
    return {"flip": False, "sections": sections, "control_points": bool(rng.random() < 0.3)}


def check(content: dict[str, Any]) -> Outcome:
    """The wheelset on its track, solved or refused with a reason."""
    try:
        task = Case.from_dict(content).task
        assert isinstance(task, WheelsetProblem)
        result = solve_wheelset(task)
    except (CaseError, Unsolvable) as cause:
        return Outcome(reason=str(cause), excused=True)
    return Outcome(result.converged, result.reason, excused=any(words in result.reason for words in EXCUSES),
                   broken=violations(task, result) if result.converged else ())

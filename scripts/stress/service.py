"""Seeded wheelsets that wear over several positions, and the check of each: volumes, and what must not change anything."""

from __future__ import annotations

import math

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.wheelsets import random_wheelset
from thermoroll_cli import Case, wear
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem

VOLUME, SAME = 1e-3, 1e-6
"""Relative departure of the worn volume from that of the frictional work, and of one order of the positions from another."""
RATE, FRICTION = 1e-5, 0.3
MISSES = ("misses", "beside", "no contact", "touch")
"""Words of a reason of a wheel that is not on its rail."""


def in_service(seed: int) -> Case:
    """The wheelset of `random_wheelset(seed)` whose wheels, and at times rails, wear at one to three positions."""
    rng = np.random.default_rng([43, seed])
    shift = random_wheelset(seed).settings.wheelset
    assert shift is not None
    middle = float(np.clip(shift.lateral_shift_mm, -5.0, 5.0))
    positions = [[float(rng.uniform(0.1, 1.0)), {"wheelset.lateral_shift_mm": middle + float(rng.uniform(-2.0, 2.0)),
                                                 "wheelset.yaw_mrad": float(rng.uniform(-3.0, 3.0))}]
                 for _ in range(rng.integers(1, 4))]  # fmt: skip
    values = {"wear.upper.specific_wear_rate_mm3_Nm": RATE, "wear.positions": positions, "wear.depth_um": 3.0,
              "wear.step_um": float(rng.uniform(1.0, 5.0)), "wear.smoothing_mm": float(rng.choice([0.5, 5.0, 20.0]))}
    if rng.random() < 0.5:
        values |= {"wear.lower.specific_wear_rate_mm3_Nm": 2.0 * RATE,
                   "wear.lower.track_length_m": float(rng.uniform(1.0, 900.0))}
    return random_wheelset(seed).with_values(values)


def check(case: Case) -> Outcome:
    """Wear the wheelset, with its positions in order and with the first one in two parts at the end, and check the volumes."""
    done, task = wear(case), case.task
    assert isinstance(task, WheelsetProblem)
    if not done.converged:
        return Outcome(False, done.reason, excused=any(word in done.reason for word in MISSES))
    distance = 1e3 * np.array([row["distance_km"] for row in done.rows])
    work = float(np.array([row["T_gamma_N"] for row in done.rows])[:-1] @ np.diff(distance))
    volume = math.fsum(done.rows[-1][f"worn_volume_wheel_{side}_cm3"] for side in task.sides)
    broken = []
    if abs(1e3 * volume - RATE * work / FRICTION) > VOLUME * 1e3 * volume:
        broken.append(f"the wheels lose {1e3 * volume:g} mm³, the work is worth {RATE * work / FRICTION:g} mm³")
    wear_table = case.settings.wear
    assert wear_table is not None and wear_table.positions is not None
    (weight, keys), *rest = wear_table.positions
    assert isinstance(weight, float)
    other = wear(case.with_values({"wear.positions": [*rest, [0.25 * weight, keys], [0.75 * weight, keys]]}))
    for name, value in done.rows[-1].items():
        if not math.isclose(value, other.rows[-1][name], rel_tol=SAME, abs_tol=1e-12) and not math.isnan(value):
            broken.append(f"{name} is {value:g}, with the positions in another order {other.rows[-1][name]:g}")
    return Outcome(True, broken=tuple(broken))

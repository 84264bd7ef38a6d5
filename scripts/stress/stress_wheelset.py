"""Solve hundreds of random wheelsets and check what must hold of each: `make stress`.

`--seed N` solves the wheelset of one seed and tells what became of it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import pathlib
import sys
import time
import traceback
import warnings
from typing import Any

import numpy as np

from scripts.stress.stress import Outcome, table, told
from thermoroll_cli import Case
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.wheelset.wheelset_result import WheelsetResult, solve_wheelset

ROOT = pathlib.Path(__file__).parents[2]
RAILS = (("cases/MBench_UIC60_v3.prr", 0.0), ("tests/reference/wheelset/uic60_true.prr", 0.025),
         ("tests/reference/wheelset/site_b_hr.prr", 0.0))
"""Outlines of rails and their cant."""
WHEELS = (("cases/MBench_S1002_v3.prw", 1360.0, -70.0), ("tests/reference/wheelset/worn_high_mileage.prw", 1347.4, 0.0))
"""Outlines of wheels, distance of the flange backs, and y of the flange back."""
CASES = 500
CONVERGED_SHARE = 0.98
LOAD_SHARE, POWER_SHARE = 1e-3, 2e-3
"""Departure of the vertical force from the load, and of the power from the heat, that may remain."""


def case_of(seed: int) -> Case:
    """The wheelset of `seed`, always the same."""
    rng = np.random.default_rng([17, seed])
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
    return Case.from_dict({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "track": {"rail_profile": {"file": str(ROOT / rail)}, "cant": cant, "gauge_mm": gauge}, "wheelset": wheelset,
        "rolling": {"speed_m_s": 2.0}, "numerics": {"grid": 16}})


def run_seed(seed: int) -> Outcome:
    """Solve the wheelset of `seed` and check it; warnings count as crashes. A wheel that misses its rail is said to."""
    start, case = time.perf_counter(), case_of(seed)
    kind = f"wheelset, {case.settings.wheelset.wheels}"  # type: ignore[union-attr]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            task = case.task
            assert isinstance(task, WheelsetProblem)
            result = solve_wheelset(task)
        broken = violations(result) if result.converged else ()
        return Outcome(seed, kind, True, result.converged, result.reason, broken, 0, time.perf_counter() - start)
    except Unsolvable as cause:
        return Outcome(seed, kind, True, True, str(cause), (), 0, time.perf_counter() - start)
    except Exception as cause:
        place = traceback.extract_tb(cause.__traceback__)[-1]
        broken = (f"{type(cause).__name__}: {cause} ({pathlib.Path(place.filename).name}:{place.lineno})",)
        return Outcome(seed, kind, True, False, "", broken, 0, time.perf_counter() - start, crashed=True)


def violations(result: WheelsetResult) -> tuple[str, ...]:
    """The rails carry the load, the patches are numbered across, and the heat is the power."""
    scalars, found = result.scalars, []
    missing = abs(scalars["track_force_z_N"] / (result.problem.vertical or 1.0) - 1.0)
    if not missing < LOAD_SHARE:
        found.append(f"the load is missed by {missing:.1e}")
    if not scalars["power_balance_error"] < POWER_SHARE:
        found.append(f"power and heat differ by {scalars['power_balance_error']:.1e}")
    for side in result.problem.sides:
        places = [patch.record["y_mm"] for patch in result.patches if patch.side == side]
        if not places or places != sorted(places):
            found.append(f"patches of the {side} side without order")
    return tuple(found)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, help="the wheelset of this seed only")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--jobs", type=int, default=2)
    wishes = parser.parse_args()
    if wishes.seed is not None:
        print(case_of(wishes.seed).to_toml()[-900:], told(run_seed(wishes.seed)), sep="\n")
        return 0
    with multiprocessing.get_context("spawn").Pool(wishes.jobs) as pool:
        outcomes = pool.map(run_seed, range(wishes.cases), chunksize=4)
    print(table(outcomes))
    for outcome in outcomes:
        if outcome.broken or not outcome.converged:
            print(told(outcome), file=sys.stderr)
    converged = sum(outcome.converged for outcome in outcomes)
    return int(any(outcome.broken for outcome in outcomes) or converged < CONVERGED_SHARE * len(outcomes))


if __name__ == "__main__":
    sys.exit(main())

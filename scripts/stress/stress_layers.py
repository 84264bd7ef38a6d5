"""Random contacts of bodies with bonded layers: what must hold of each, and of two grids; part of `make stress`.

    python -m scripts.stress.stress_layers [--cases N] [--first SEED] [--grid N] [--seed N]
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
import traceback
import warnings
from dataclasses import replace
from pathlib import Path

from scripts.stress.random_layers import random_layers
from scripts.stress.stress import LARGE_WORK, Outcome, table, told
from scripts.stress.stress_checks import solve_to_check, violations
from thermoroll_cli.problem.names import SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import Numerics, Problem, SubsurfaceRequest
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.refinement.solve import solve

CASES, GRID = 100, 32
CONVERGED_SHARE, WITHIN_SHARE = 0.99, 0.95
LOOKED_INTO = 4
"""Of so many contacts one has stresses below the surface."""
COMPARED = ("contact_area_mm2", "pressure_max_MPa", "approach_um", "force_x_N", "force_y_N", "Q_F_W",
            *(name for name in SUBSURFACE_SCALARS if name.endswith("_MPa") and not name.startswith("elastic")))
"""Scalars of the grid that are compared with those of one twice as fine."""


def run_seed(seed: int, grid: int = GRID) -> Outcome:
    """Solve the contact of `seed` and check the result; warnings count as crashes."""
    start, kind = time.perf_counter(), "layers"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = solve_to_check(contact(seed, grid))
        return Outcome(seed, kind, True, result.converged, result.reason, tuple(violations(result)),
                       result.work["levels"][-1]["applications"], time.perf_counter() - start)
    except Exception as cause:
        place = traceback.extract_tb(cause.__traceback__)[-1]
        broken = (f"{type(cause).__name__}: {cause} ({Path(place.filename).name}:{place.lineno})",)
        return Outcome(seed, kind, True, False, "", broken, 0, time.perf_counter() - start, crashed=True)


def contact(seed: int, grid: int) -> Problem:
    """The contact of `seed` on `grid` elements per side, with stresses below the surface of some."""
    below = SubsurfaceRequest() if seed % LOOKED_INTO == 0 else None
    return replace(random_layers(seed), numerics=Numerics(grid=(grid, grid)), subsurface=below)


def grid_changes(seed: int, grid: int = GRID) -> dict[str, float]:
    """What a grid twice as fine changes `COMPARED` by, over the error estimates of both grids together."""
    coarse, fine = (solve(contact(seed, n)).summary() for n in (grid, 2 * grid))
    found = {}
    for name in COMPARED:
        if name not in fine:
            continue
        scale, allowed = error_scale(name, fine), coarse["error"].get(name, 0.0) + fine["error"].get(name, 0.0)
        if allowed > 0.0 and scale > 0.0:
            found[name] = abs(coarse[name] - fine[name]) / scale / allowed
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, help="the contact of this seed only")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--grid", type=int, default=GRID, help="elements per side of the coarser grid")
    parser.add_argument("--jobs", type=int, default=2)
    wishes = parser.parse_args()
    if wishes.seed is not None:
        one = wishes.seed, wishes.grid
        print(random_layers(wishes.seed), told(run_seed(*one)), grid_changes(*one), sep="\n")
        return 0
    jobs = [(seed, wishes.grid) for seed in range(wishes.first, wishes.first + wishes.cases)]
    with multiprocessing.get_context("spawn").Pool(wishes.jobs) as pool:
        outcomes = pool.starmap(run_seed, jobs, chunksize=4)
        changes = pool.starmap(grid_changes, jobs, chunksize=4)
    print(table(outcomes))
    ratios = [(seed, name, ratio) for (seed, _), found in zip(jobs, changes, strict=True) for name, ratio in found.items()]
    beyond = sorted((entry for entry in ratios if entry[2] > 1.0), key=lambda entry: -entry[2])
    print(f"{len(ratios) - len(beyond)} of {len(ratios)} scalars change by less than the estimates on a grid twice as fine")
    for outcome in outcomes:
        if outcome.broken or not outcome.converged or outcome.work > LARGE_WORK:
            print(told(outcome), file=sys.stderr)
    for seed, name, ratio in beyond:
        print(f"seed {seed}: {name} changes by {ratio:.2f} of the estimates", file=sys.stderr)
    converged = sum(o.converged for o in outcomes)
    return int(any(o.broken for o in outcomes) or converged < CONVERGED_SHARE * len(outcomes)
               or len(beyond) > (1.0 - WITHIN_SHARE) * len(ratios))


if __name__ == "__main__":
    sys.exit(main())

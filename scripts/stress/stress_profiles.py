"""Solve hundreds of random contacts of bodies with transverse profiles and check what must hold of each: `make stress`.

`--seed N` solves the contact of one seed and tells what became of it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import pathlib
import sys
import time
import traceback
import warnings
from dataclasses import replace

from scripts.stress.random_profiles import AWKWARD, KINDS, random_profile_contact
from scripts.stress.stress import LARGE_WORK, Outcome, table, told
from scripts.stress.stress_checks import solve_to_check, violations
from thermoroll_cli.problem.problem import Numerics, Problem

DOCUMENT = pathlib.Path(__file__).parents[2] / "docs" / "robustness.md"
PLACE = ("<!-- profiles -->\n", "<!-- end profiles -->")
CASES = 200
GRIDS = ((16, 16), (24, 24), (32, 32), (33, 47), (24, 64), (48, 48), (64, 32))
PROFILE_CONVERGED_SHARE = 0.99


def problem_of(seed: int, kinds: tuple[str, ...] = KINDS) -> Problem:
    """The contact of `seed`, on one of `GRIDS`."""
    return replace(random_profile_contact(seed, kinds), numerics=Numerics(grid=GRIDS[seed % len(GRIDS)]))


def run_seed(seed: int, kinds: tuple[str, ...] = KINDS) -> Outcome:
    """Solve the contact of `seed` and check the result; warnings count as crashes."""
    start, kind = time.perf_counter(), f"profile, {kinds[seed % len(kinds)]}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = solve_to_check(problem_of(seed, kinds))
        broken = (*violations(result), *patch_violations(result.problem, result.patches))
        return Outcome(seed, kind, True, result.converged, result.reason, broken, result.work["levels"][-1]["applications"],
                       time.perf_counter() - start)
    except Exception as cause:
        place = traceback.extract_tb(cause.__traceback__)[-1]
        broken = (f"{type(cause).__name__}: {cause} ({pathlib.Path(place.filename).name}:{place.lineno})",)
        return Outcome(seed, kind, True, False, "", broken, 0, time.perf_counter() - start, crashed=True)


def patch_violations(problem: Problem, patches: tuple) -> tuple[str, ...]:
    """All patches together carry the load, each some of it, and they lie in order."""
    load = sum(patch["normal_N"] for patch in patches)
    share = load / problem.normal_force
    found = [] if abs(share - 1.0) < 2e-6 else [f"patches carry {share:.7f} of the load"]
    places = [patch["y_mm"] for patch in patches]
    if not patches or places != sorted(places) or min(patch["normal_N"] for patch in patches) <= 0.0:
        found.append("patches without load or order")
    return tuple(found)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, help="the contact of this seed only")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cases", type=int, default=CASES, help="of the usual kinds, and as many awkward ones")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="put the table into docs/robustness.md")
    wishes = parser.parse_args()
    if wishes.seed is not None:
        print(problem_of(wishes.seed), told(run_seed(wishes.seed)), sep="\n")
        return 0
    with multiprocessing.get_context("spawn").Pool(wishes.jobs) as pool:
        drawn = [(seed, kinds) for kinds in (KINDS, AWKWARD) for seed in range(wishes.first, wishes.first + wishes.cases)]
        outcomes = pool.starmap(run_seed, drawn, chunksize=4)
    print(table(outcomes))
    for outcome in outcomes:
        if outcome.broken or not outcome.converged or outcome.work > LARGE_WORK:
            print(told(outcome), file=sys.stderr)
    if wishes.write:
        before, rest = DOCUMENT.read_text(encoding="utf-8").split(PLACE[0])
        DOCUMENT.write_text(before + PLACE[0] + table(outcomes) + PLACE[1] + rest.split(PLACE[1], 1)[1], encoding="utf-8")
    converged = sum(o.converged for o in outcomes)
    return int(any(o.broken for o in outcomes) or converged < PROFILE_CONVERGED_SHARE * len(outcomes))


if __name__ == "__main__":
    sys.exit(main())

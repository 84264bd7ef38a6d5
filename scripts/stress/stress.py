"""Solve thousands of random but valid cases and check what must hold of each: `make stress`.

`--seed N` solves the case of one seed, prints it as a case file, and tells what became of it.
"""

from __future__ import annotations

import argparse
import collections
import math
import multiprocessing
import pathlib
import sys
import time
import traceback
import warnings
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from scripts.stress.stress_cases import BELOW_LIMIT, StressCase, stress_case
from scripts.stress.stress_checks import solve_to_check, violations
from thermoroll_cli.problem.result import Result

DOCUMENT = pathlib.Path(__file__).parents[2] / "docs" / "robustness.md"
PLACE = ("<!-- outcomes -->\n", "<!-- end -->")
CASES = 2400
CONVERGED_SHARE = 0.995
MEDIAN_WORK, LARGE_WORK = 80, 300
SLOW = 30.0


@dataclass(frozen=True)
class Outcome:
    """What became of one case; `broken` tells of crashes and violated invariants, `work` counts tangential applications on
    the finest grid."""

    seed: int
    kind: str
    below_limit: bool
    converged: bool
    reason: str
    broken: tuple[str, ...]
    work: int
    seconds: float
    crashed: bool = False


def outcome_of(case: StressCase) -> Outcome:
    """Solve `case` and check the result; warnings count as crashes."""
    start = time.perf_counter()
    converged, crashed, reason, work = False, False, "", 0
    broken: tuple[str, ...] = ()
    below = case.below_limit
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = solve_to_check(case.problem)
        broken = tuple(violations(result))
        below = below and not bulges(result)
        converged, reason, work = result.converged, result.reason, result.work["levels"][-1]["applications"]
    except Exception as cause:
        crashed = True
        place = traceback.extract_tb(cause.__traceback__)[-1]
        broken = (f"{type(cause).__name__}: {cause} ({pathlib.Path(place.filename).name}:{place.lineno})",)
    seconds = time.perf_counter() - start
    return Outcome(case.seed, case.kind, below, converged, reason, broken, work, seconds, crashed)


def bulges(result: Result) -> bool:
    """Whether the heat of the state without deformation would bulge by more than a case below the limit may: the plan's bound
    can be too low for dissimilar bodies, whose pressure alone makes them slip."""
    scalars = result.isothermal.scalars
    return bool(result.problem.heating.deformation
                and scalars["thermal_displacement_max_um"] > BELOW_LIMIT * scalars["approach_um"])  # fmt: skip


def run_seed(seed: int) -> Outcome:
    """Outcome of the case of `seed`."""
    return outcome_of(stress_case(seed))


def run(seeds: Iterable[int], jobs: int, seconds: float = math.inf) -> list[Outcome]:
    """Outcomes of all `seeds`; what fails is told at once on standard error. After `seconds` the rest is left
    out."""
    outcomes: list[Outcome] = []
    end = time.perf_counter() + seconds
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        for done in pool.imap_unordered(run_seed, seeds, chunksize=4):
            outcomes.append(done)
            if time.perf_counter() > end:
                print("out of time: the rest is left out", file=sys.stderr)
                break
            if done.broken or (done.below_limit and not done.converged) or done.seconds > SLOW or done.work > LARGE_WORK:
                print(told(done), file=sys.stderr, flush=True)
    return sorted(outcomes, key=lambda o: o.seed)


def told(outcome: Outcome) -> str:
    """One line about `outcome`."""
    what = "; ".join(outcome.broken) or outcome.reason or "converged"
    where = "" if outcome.below_limit else ", beyond the limit"
    return f"seed {outcome.seed} ({outcome.kind}{where}, {outcome.work} applications, {outcome.seconds:.1f} s): {what}"


def table(outcomes: list[Outcome]) -> str:
    """The table of outcomes by what the kind of a case begins with, in Markdown."""
    groups: dict[str, list[Outcome]] = collections.defaultdict(list)
    for o in outcomes:
        groups[o.kind.partition(",")[0]].append(o)
    header = ["kind of case", "cases", "converged below the limit", "converged beyond", "reason given", "crashes",
              "broken invariants", "work: median", "99th percentile"]  # fmt: skip
    rows = [row(kind, groups[kind]) for kind in sorted(groups)] if len(groups) > 1 else []
    head, *body = ("| " + " | ".join(cells) + " |\n" for cells in (header, *rows, row("**all**", outcomes)))
    return "".join([head, "|---|" + "---:|" * (len(header) - 1) + "\n", *body])


def row(name: str, outcomes: list[Outcome]) -> list[str]:
    below = [o.converged for o in outcomes if o.below_limit]
    beyond = [o.converged for o in outcomes if not o.below_limit]
    work = [o.work for o in outcomes if o.work]
    return [
        name,
        str(len(outcomes)),
        f"{sum(below)} of {len(below)}",
        f"{sum(beyond)} of {len(beyond)}",
        str(sum(not o.converged and bool(o.reason) for o in outcomes)),
        str(sum(o.crashed for o in outcomes)),
        str(sum(bool(o.broken) and not o.crashed for o in outcomes)),
        f"{np.median(work):.0f}" if work else "",
        f"{np.percentile(work, 99):.0f}" if work else "",
    ]


def missed(outcomes: list[Outcome]) -> list[str]:
    """Targets that were not met."""
    below = [o.converged for o in outcomes if o.below_limit]
    work = [o.work for o in outcomes if o.work]
    found = []
    if broken := sum(bool(o.broken) for o in outcomes):
        found.append(f"{broken} cases crashed or broke an invariant")
    if sum(below) < CONVERGED_SHARE * len(below):
        found.append(f"{sum(below)} of {len(below)} cases below the thermo-elastic limit converged")
    if np.median(work) > MEDIAN_WORK or np.percentile(work, 99) > LARGE_WORK:
        found.append(f"work: median {np.median(work):.0f}, 99th percentile {np.percentile(work, 99):.0f} applications")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, help="the case of this seed only")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=math.inf, help="leave out what takes longer")
    parser.add_argument("--write", action="store_true", help="put the table into docs/robustness.md")
    wishes = parser.parse_args()
    if wishes.seed is not None:
        case = stress_case(wishes.seed)
        print(case.case.to_toml())
        outcome = outcome_of(case)
        print(f"# bulge/approach {case.bulge:.2e}\n# {told(outcome)}")
        return int(bool(outcome.broken))
    start = time.perf_counter()
    outcomes = run(range(wishes.first, wishes.first + wishes.cases), wishes.jobs, wishes.seconds)
    print(table(outcomes))
    print(f"{len(outcomes)} cases in {time.perf_counter() - start:.0f} s, the longest {max(o.seconds for o in outcomes):.1f} s")
    if wishes.write:
        text = DOCUMENT.read_text(encoding="utf-8")
        before, rest = text.split(PLACE[0])
        DOCUMENT.write_text(before + PLACE[0] + table(outcomes) + PLACE[1] + rest.split(PLACE[1], 1)[1], encoding="utf-8")
    for target in missed(outcomes):
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(missed(outcomes)))


if __name__ == "__main__":
    sys.exit(main())

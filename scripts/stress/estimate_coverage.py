"""Hold the error estimates against the truth on cases of two populations: part of `make stress`.

    python -m scripts.stress.estimate_coverage [--cases N] [--first SEED] [--grids 32 64] [--write]

Each case is solved on a grid and on one five times as fine. A pair is one scalar of one case; it is covered if its true
error does not exceed the estimate.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scripts.stress.random_contacts import random_contact
from scripts.stress.stress_cases import stress_case
from thermoroll_cli.problem.error_scale import error_scale
from thermoroll_cli.problem.names import SCALARS
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.refinement.solve import solve

DOCUMENT = pathlib.Path(__file__).parents[2] / "docs" / "verification.md"
PLACE = ("<!-- coverage -->\n", "<!-- end -->")
CASES, FIRST, FINER = 40, 1000, 5
EXACT = 2e-6
"""A smaller true error is none: such pairs would make the median of estimate over true error look large."""
COVERED, SHORT, MEDIAN = 0.95, 0.01, 5.0
DERIVED = ("T_gamma_N", "contact_area_mm2", "pressure_max_MPa", "stick_area_mm2", "surface_temperature_max_lower_K",
           "surface_temperature_max_upper_K")
"""Scalars whose error is that of another one."""


def _of_the_generator(seed: int) -> Problem | None:
    case = stress_case(810000 + seed)
    return case.problem if case.below_limit else None


POPULATIONS: dict[str, Callable[[int], Problem | None]] = {
    "random contacts": random_contact, "stress generator": _of_the_generator}


@dataclass(frozen=True)
class Pair:
    """Estimated and true error of one scalar of one case, over the scalar's `error_scale`."""

    population: str
    seed: int
    grid: int
    scalar: str
    estimate: float
    true: float

    @property
    def shortfall(self) -> float:
        """True error over estimate."""
        return self.true / self.estimate if self.estimate > 0.0 else (math.inf if self.true > 0.0 else 0.0)


def pairs_of(population: str, seed: int, grid: int) -> Iterator[Pair]:
    """The pairs of one case; none if it is beyond the thermo-elastic limit or does not converge."""
    problem = POPULATIONS[population](seed)
    if problem is None:
        return
    coarse, fine = (solve(replace(problem, numerics=replace(problem.numerics, grid=(n, n), accuracy=None)))
                    for n in (grid, FINER * grid))
    if not (coarse.converged and fine.converged):
        return
    summary, truth = coarse.summary(), fine.coupled.scalars
    for name in SCALARS:
        scale, estimate = error_scale(name, summary), coarse.error[name]
        if name not in DERIVED and math.isfinite(estimate) and scale > 0.0:
            yield Pair(population, seed, grid, name, estimate, abs(summary[name] - truth[name]) / scale)


def table(pairs: list[Pair], population: str, grids: tuple[int, ...]) -> str:
    """Of one population, in Markdown: pairs, covered, short by three and ten times, median estimate over true error."""
    head = ["", *(f"N = {n}: {what}" for n in grids for what in ("pairs", "covered", "short by 3", "by 10", "median"))]
    lines = [head, ["---", *["---:"] * (len(head) - 1)]]
    for name in (*SCALARS, "all"):
        cells = [f"`{name}`" if name in SCALARS else f"**{name}**"]
        for grid in grids:
            some = [p for p in pairs if (p.population, p.grid) == (population, grid) and name in (p.scalar, "all")]
            cells += _figures(some)
        if any(cells[1:]):
            lines.append(cells)
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def _figures(some: list[Pair]) -> list[str]:
    if not some:
        return [""] * 5
    short = np.array([p.shortfall for p in some])
    inexact = [p.estimate / p.true for p in some if p.true > EXACT]
    return [str(len(some)), f"{np.mean(short <= 1.0):.1%}", f"{np.mean(short > 3.0):.1%}", str(int((short > 10.0).sum())),
            f"{np.median(inexact):.1f}" if inexact else ""]


def missed(pairs: list[Pair]) -> list[str]:
    """Targets that were not met, and the worst pairs."""
    found = []
    groups: dict[tuple[str, int, str], list[Pair]] = {}
    for pair in pairs:
        groups.setdefault((pair.population, pair.grid, pair.scalar), []).append(pair)
    for (population, grid, name), some in sorted(groups.items()):
        short = np.array([p.shortfall for p in some])
        # One more case than the share allows: a few cases tell no shares.
        if (short > 1.0).sum() > math.ceil((1.0 - COVERED) * len(some)) or (short > 3.0).sum() > math.ceil(SHORT * len(some)):
            found.append(f"{population}, N = {grid}, {name}: {np.mean(short <= 1.0):.1%} covered, "
                         f"{np.mean(short > 3.0):.1%} short by three times")
    found += [f"short by ten times: {p}" for p in pairs if p.shortfall > 10.0]
    inexact = [p.estimate / p.true for p in pairs if p.true > EXACT]
    if inexact and np.median(inexact) > MEDIAN:
        found.append(f"median estimate over true error: {np.median(inexact):.1f}")
    return found


def measured(cases: range, grids: tuple[int, ...], store: pathlib.Path | None = None) -> list[Pair]:
    """All pairs; each is appended to `store` as a line of JSON as soon as it is known."""
    pairs: list[Pair] = []
    for seed in cases:
        for population in POPULATIONS:
            for grid in grids:
                new = list(pairs_of(population, seed, grid))
                pairs += new
                if store is not None:
                    with store.open("a", encoding="utf-8") as lines:
                        lines.writelines(json.dumps(vars(pair)) + "\n" for pair in new)
    return pairs


def loaded(store: pathlib.Path) -> list[Pair]:
    """The pairs in a file that `measured` wrote."""
    fields: list[Mapping[str, Any]] = [json.loads(line) for line in store.read_text(encoding="utf-8").splitlines()]
    return [Pair(**each) for each in fields]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=CASES, help=f"of each population (default {CASES}, in full 500)")
    parser.add_argument("--first", type=int, default=FIRST,
                        help="first seed; the weights were fitted on seeds between 505 and 6379")
    parser.add_argument("--grids", type=int, nargs="+", default=[32], help="elements per side (default 32)")
    parser.add_argument("--store", type=pathlib.Path, help="keep the pairs in this file, line by line")
    parser.add_argument("--load", action="store_true", help="solve nothing: judge the pairs in that file")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/verification.md")
    wishes = parser.parse_args()
    start, grids = time.perf_counter(), tuple(wishes.grids)
    seeds = range(wishes.first, wishes.first + wishes.cases)
    pairs = loaded(wishes.store) if wishes.load else measured(seeds, grids, wishes.store)
    text = "".join(f"{population.capitalize()}:\n\n{table(pairs, population, grids)}\n" for population in POPULATIONS)
    print(text)
    print(f"{len({(p.population, p.seed, p.grid) for p in pairs})} cases in {time.perf_counter() - start:.0f} s")
    if wishes.write:
        document = DOCUMENT.read_text(encoding="utf-8")
        before, rest = document.split(PLACE[0])
        DOCUMENT.write_text(before + PLACE[0] + text + PLACE[1] + rest.split(PLACE[1], 1)[1], encoding="utf-8")
    for target in missed(pairs):
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(missed(pairs)))


if __name__ == "__main__":
    sys.exit(main())

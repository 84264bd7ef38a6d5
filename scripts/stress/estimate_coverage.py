"""Hold the error estimates against the truth on random cases: part of `make stress`.

    python -m scripts.stress.estimate_coverage [--cases N] [--first SEED] [--grids 32 64] [--reference 192] [--write]

Each case is solved on all grids and on one several times as fine. A pair is one scalar of one case; it is covered if its true
error does not exceed the estimate. Pairs are judged by family: random contacts and the stress generator scalar by scalar,
profiles and stresses below the surface as one family each.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scripts.stress.random_contacts import random_contact
from scripts.stress.random_friction import random_friction, random_strength
from scripts.stress.random_layers import random_hot_layers, random_layers
from scripts.stress.random_profiles import random_profile_contact
from scripts.stress.stress_cases import stress_case
from thermoroll_cli.problem.names import SCALARS, STRENGTH_SCALARS
from thermoroll_cli.problem.problem import Problem, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import CREEPAGES, error_scale
from thermoroll_cli.refinement.error_estimates import AREAS, INTEGRALS, MAXIMA, PRESSURES, STICK
from thermoroll_cli.refinement.solve import solve

DOCUMENT = pathlib.Path(__file__).parents[2] / "docs" / "robustness.md"
PLACE = ("<!-- coverage -->\n", "<!-- end -->")
CASES, FIRST = 40, 1000
FINER = 5
"""The grid that stands for the truth is so many times as fine as the finest one. Below the surface its layers double, too."""
EXACT = 2e-6
"""A smaller true error is none: such pairs would make the median of estimate over true error look large."""
ROUNDING = 1e-12
COVERED, SHORT, SHORT_BY_TEN, MEDIAN, FAMILY_MEDIAN = 0.95, 0.01, 1.0 / 2000.0, 8.0, 12.0
DERIVED = ("T_gamma_N", "contact_area_mm2", "pressure_max_MPa", "stick_area_mm2", "surface_temperature_max_lower_K",
           "surface_temperature_max_upper_K")
"""Scalars whose error is that of another one."""

BELOW, PROFILES, FALLING, STRONG = "below the surface", "profiles", "falling friction", "strength and wear"
LAYERED, HOT, BONDED = "layers", "heat through layers", "stresses in layers"
APART = (PROFILES, BELOW, FALLING, STRONG, LAYERED, HOT, BONDED)
"""Populations that are families of their own."""
FAMILIES: dict[str, Sequence[str]] = {
    "integrals": INTEGRALS, "creepages found": CREEPAGES, "areas": AREAS, "stick": STICK, "maxima": MAXIMA,
    "pressure, approach": PRESSURES,
}
OTHERS = "temperatures, expansion"


def family(population: str, scalar: str) -> str:
    """The family by which a pair is judged."""
    if population in APART:
        return population
    return next((name for name, scalars in FAMILIES.items() if scalar in scalars), OTHERS)


def _of_the_generator(seed: int) -> Problem | None:
    case = stress_case(810000 + seed)
    return case.problem if case.below_limit else None


def _below_the_surface(seed: int) -> Problem:
    return replace(random_contact(50000 + seed), subsurface=SubsurfaceRequest())


POPULATIONS: dict[str, Callable[[int], Problem | None]] = {
    "random contacts": random_contact, "stress generator": _of_the_generator, PROFILES: random_profile_contact,
    BELOW: _below_the_surface, FALLING: random_friction, STRONG: random_strength, LAYERED: random_layers,
    HOT: random_hot_layers, BONDED: lambda seed: replace(random_layers(seed), subsurface=SubsurfaceRequest())}


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
    def family(self) -> str:
        return family(self.population, self.scalar)

    @property
    def shortfall(self) -> float:
        """True error over estimate; what symmetry makes zero has an estimate of zero and rounding for an error."""
        return 0.0 if self.true < ROUNDING else self.true / self.estimate if self.estimate > 0.0 else math.inf


def pairs_of(population: str, seed: int, *grids: int, reference: int | None = None) -> Iterator[Pair]:
    """The pairs of one case on `grids`, against a grid of `reference` elements per side (default `FINER` times the last); none
    if it is beyond the thermo-elastic limit or does not converge."""
    problem = POPULATIONS[population](seed)
    if problem is None:
        return
    solved = {grid: _on(problem, grid) for grid in grids}
    fine = _on(_with_layers_between(problem), reference or FINER * grids[-1])
    if not all(result.converged for result in (fine, *solved.values())):
        return
    truth = fine.summary()
    for grid, coarse in solved.items():
        summary = coarse.summary()
        names = tuple(coarse.subsurface.scalars) if coarse.subsurface is not None else tuple(SCALARS)
        if population == STRONG:
            names = tuple(name for name in names if name in STRENGTH_SCALARS)
            names += tuple(name for name in SCALARS if name.startswith("wear_"))
        for name in names:
            scale, estimate = error_scale(name, summary), summary["error"].get(name, math.nan)
            # The fine grid may lack a maximum below the surface that the coarse one has: that error is not known.
            if name not in DERIVED and math.isfinite(estimate) and scale > 0.0 and math.isfinite(truth[name]):
                yield Pair(population, seed, grid, name, estimate, abs(summary[name] - truth[name]) / scale)


def _on(problem: Problem, grid: int) -> Result:
    return solve(replace(problem, numerics=replace(problem.numerics, grid=(grid, grid), accuracy=None)))


def _with_layers_between(problem: Problem) -> Problem:
    """The problem with another layer between any two layers below the surface."""
    if problem.subsurface is None:
        return problem
    layers = len(next(iter(_on(problem, 16).bodies.values())).depths)
    return replace(problem, subsurface=replace(problem.subsurface, layers=2 * layers - 2))


def table(pairs: list[Pair], grids: tuple[int, ...]) -> str:
    """In Markdown, by family: pairs, covered, short by three and ten times, median of estimate over true error."""
    head = ["", *(f"N = {n}: {column}" for n in grids for column in ("pairs", "covered", "short by 3", "by 10", "median"))]
    lines = [head, ["---", *["---:"] * (len(head) - 1)]]
    for name in (*FAMILIES, OTHERS, "all of these", *APART):
        cells = [f"**{name}**" if name == "all of these" else name]
        for grid in grids:
            cells += _figures([p for p in pairs if p.grid == grid and _belongs(p, name)])
        if any(cells[1:]):
            lines.append(cells)
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def _belongs(pair: Pair, name: str) -> bool:
    return pair.family == name or (name == "all of these" and pair.population not in APART)


def _figures(some: list[Pair]) -> list[str]:
    if not some:
        return [""] * 5
    short = np.array([p.shortfall for p in some])
    return [str(len(some)), f"{np.mean(short <= 1.0):.1%}", f"{np.mean(short > 3.0):.1%}", str(int((short > 10.0).sum())),
            "" if math.isnan(median := _median(some)) else f"{median:.1f}"]


def _median(some: list[Pair]) -> float:
    inexact = [p.estimate / p.true for p in some if p.true > EXACT]
    return float(np.median(inexact)) if inexact else math.nan


def missed(pairs: list[Pair]) -> list[str]:
    """Targets that were not met, and the worst pairs."""
    found = []
    families: dict[str, list[Pair]] = {}
    for pair in pairs:
        families.setdefault(pair.family, []).append(pair)
    for name, some in sorted(families.items()):
        short = np.array([p.shortfall for p in some])
        # One more pair than the share allows: a few pairs tell no shares.
        if (short > 1.0).sum() > math.ceil((1.0 - COVERED) * len(some)) or (short > 3.0).sum() > math.ceil(SHORT * len(some)):
            found.append(f"{name}: {np.mean(short <= 1.0):.1%} covered, {np.mean(short > 3.0):.1%} short by three times")
        if _median(some) > FAMILY_MEDIAN:
            found.append(f"{name}: median of estimate over true error {_median(some):.1f}")
    worst = [p for p in pairs if p.shortfall > 10.0]
    if len(worst) > math.ceil(SHORT_BY_TEN * len(pairs)):
        found += [f"short by ten times: {p}" for p in worst]
    if _median(pairs) > MEDIAN:
        found.append(f"all: median of estimate over true error {_median(pairs):.1f}")
    return found


def measured(
    cases: range, grids: tuple[int, ...], store: pathlib.Path | None = None,
    populations: Sequence[str] = tuple(POPULATIONS), reference: int | None = None,
) -> list[Pair]:
    """All pairs; each is appended to `store` as a line of JSON as soon as it is known."""
    pairs: list[Pair] = []
    for seed in cases:
        for population in populations:
            new = list(pairs_of(population, seed, *grids, reference=reference))
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
    parser.add_argument("--cases", type=int, default=CASES, help=f"of each population (default {CASES})")
    parser.add_argument("--first", type=int, default=FIRST, help="first seed")
    parser.add_argument("--grids", type=int, nargs="+", default=[32], help="elements per side (default 32)")
    parser.add_argument("--reference", type=int, help=f"elements per side of the truth (default {FINER} times the finest grid)")
    parser.add_argument("--only", nargs="+", choices=tuple(POPULATIONS), default=tuple(POPULATIONS), metavar="POPULATION",
                        help=", ".join(POPULATIONS))
    parser.add_argument("--store", type=pathlib.Path, help="keep the pairs in this file, line by line")
    parser.add_argument("--load", action="store_true", help="solve nothing: judge the pairs in that file")
    parser.add_argument("--write", action="store_true", help=f"put the table into {DOCUMENT.name}")
    wishes = parser.parse_args()
    start, grids = time.perf_counter(), tuple(wishes.grids)
    seeds = range(wishes.first, wishes.first + wishes.cases)
    pairs = (loaded(wishes.store) if wishes.load
             else measured(seeds, grids, wishes.store, wishes.only, wishes.reference))
    text = table(pairs, grids)
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

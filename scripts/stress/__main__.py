"""Solve random but valid cases and check what must hold of each: `make stress`.

    python -m scripts.stress [POPULATION ...] [--first SEED] [--count N] [--jobs J] [--write]

A POPULATION is a name of `populations.POPULATIONS`, or the beginning of some: "coverage" means all that begin with it, but
"contacts", which is a name, means these alone. With `--count 1` the case of the seed `--first` is shown, too.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import pathlib
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import asdict
from itertools import repeat

import numpy as np

from scripts.stress import coverage
from scripts.stress.outcome import Outcome, Pair
from scripts.stress.populations import POPULATIONS, run_seed

PAGES = {"stress": "developing", "coverage": "verification"}
"""Pages of docs/ with the tables."""
CONVERGED_SHARE = 0.995
MEDIAN_WORK, LARGE_WORK = 80, 300
SLOW = 30.0
HEADER = ("population", "cases", "converged", "refused with a reason", "of these excused", "broken", "work: median",
          "99th percentile", "longest CPU s")  # fmt: skip


def outcomes_of(
    drawn: list[tuple[str, int]], jobs: int, store: pathlib.Path | None, grids: tuple[int, ...]
) -> Iterator[Outcome]:
    """Outcomes of the seeds of populations, in their order; those that `store` has are not solved again, and others are
    added to it, a line of JSON each."""
    lines = store.read_text(encoding="utf-8").splitlines() if store is not None and store.exists() else []
    known = {(o.population, o.seed): o for o in map(_loaded, lines)}
    new = [each for each in drawn if each not in known]
    yield from (known[each] for each in drawn if each in known)
    # Started afresh: a forked process hangs after a transform with threads.
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, spawn) if jobs > 1 else nullcontext() as pool:
        for outcome in (pool.map if pool else map)(run_seed, *zip(*new, strict=True), repeat(grids)) if new else ():
            if store is not None:
                with store.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(outcome)) + "\n")
            yield outcome


def _loaded(line: str) -> Outcome:
    entries = json.loads(line)
    pairs, broken = tuple(Pair(**pair) for pair in entries.pop("pairs")), tuple(entries.pop("broken"))
    return Outcome(pairs=pairs, broken=broken, **entries)


def row(name: str, outcomes: list[Outcome]) -> str:
    """The line about one population, in Markdown."""
    refused, work = [o for o in outcomes if not o.converged and o.reason], [o.work for o in outcomes if o.work]
    cells = [name, len(outcomes), sum(o.converged for o in outcomes), len(refused), sum(o.excused for o in refused),
             sum(bool(o.broken) for o in outcomes), *(f"{np.percentile(work, p):.0f}" if work else "" for p in (50, 99)),
             f"{max(o.seconds for o in outcomes):.1f}"]  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |\n"


def missed(outcomes: list[Outcome]) -> list[str]:
    """Targets that one population misses."""
    due, work = [o.converged for o in outcomes if not o.excused], [o.work for o in outcomes if o.work]
    found = []
    if broken := sum(bool(o.broken) for o in outcomes):
        found.append(f"{broken} cases are broken")
    # One more than the share allows: a few cases tell no shares.
    if due.count(False) > math.ceil((1.0 - CONVERGED_SHARE) * len(due)):
        found.append(f"{sum(due)} of {len(due)} cases converged")
    if work and (np.median(work) > MEDIAN_WORK or np.percentile(work, 99) > LARGE_WORK):
        found.append(f"work: median {np.median(work):.0f}, 99th percentile {np.percentile(work, 99):.0f} applications")
    return found


def _page(place: str) -> pathlib.Path:
    return pathlib.Path(__file__).parents[2] / "docs" / f"{PAGES[place]}.md"


def write(place: str, text: str) -> None:
    """Put `text` between the marks of `place` in its page."""
    before, mark, rest = _page(place).read_text(encoding="utf-8").partition(f"<!-- {place} -->\n")
    _page(place).write_text(before + mark + text + "<!-- end" + rest.partition("<!-- end")[2], encoding="utf-8")


def written_rows() -> dict[str, str]:
    """The lines of populations that the page has, by name."""
    text = _page("stress").read_text(encoding="utf-8").partition("<!-- stress -->\n")[2].partition("<!-- end")[0]
    return {line.split(" | ")[0].removeprefix("| "): line for line in text.splitlines(keepends=True)}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("populations", nargs="*", metavar="POPULATION", help=", ".join(POPULATIONS))
    parser.add_argument("--first", type=int, default=0, help="first seed", metavar="SEED")
    parser.add_argument("--count", type=int, help="cases of each population", metavar="N")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="J")
    parser.add_argument("--grids", type=int, nargs="+", default=(), metavar="N",
                        help="elements per side for coverage; its table is written, too")
    parser.add_argument("--store", type=pathlib.Path, help="a file that keeps outcomes: its cases are not solved again")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/")
    wishes = parser.parse_args(arguments)
    for word in wishes.populations:
        if not any(name.startswith(word) for name in POPULATIONS):
            parser.error(f"no population begins with {word!r}: {', '.join(POPULATIONS)}")
    names = [name for name in POPULATIONS if any(
        name == word or (word not in POPULATIONS and name.startswith(word)) for word in wishes.populations or [""])]
    drawn = [(name, seed) for name in names
             for seed in range(wishes.first, wishes.first + (wishes.count or POPULATIONS[name].cases))]  # fmt: skip
    if wishes.count == 1:
        print(*(POPULATIONS[name].draw(seed) for name, seed in drawn), sep="\n")
    outcomes: dict[str, list[Outcome]] = {name: [] for name in names}
    for outcome in outcomes_of(drawn, wishes.jobs, wishes.store, tuple(wishes.grids)):
        outcomes[outcome.population].append(outcome)
        if (outcome.broken or not (outcome.converged or outcome.excused) or outcome.seconds > SLOW
                or outcome.work > LARGE_WORK or wishes.count == 1):  # fmt: skip
            print(outcome, file=sys.stderr, flush=True)
    rows = {name: row(name, some) for name, some in outcomes.items()}
    head = "| " + " | ".join(HEADER) + " |\n|---|" + "---:|" * (len(HEADER) - 1) + "\n"
    print(head + "".join(rows.values()))
    failures = [f"{name}: {target}" for name, some in outcomes.items() for target in missed(some)]
    judged = [o for some in outcomes.values() for o in some if o.pairs]
    if judged:
        print(coverage.table(judged))
        failures += coverage.missed(judged)
    if wishes.write:
        rows = written_rows() | rows
        write("stress", head + "".join(rows[name] for name in POPULATIONS if name in rows))
        if judged and wishes.grids:
            write("coverage", coverage.table(judged))
    for target in failures:
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())

"""Measure what thermoroll costs and how good it is, and write benchmarks/results.json, its figures and docs/benchmarks.md.

    python -m scripts.benchmark.bench [--only PART]... [--runs N] [--largest N] [--peers PYTHON]

PYTHON is an interpreter that has tamaas and ContactMechanics; without it their rows are left out. Parts that are not measured
keep the numbers of results.json. Times are medians over N runs (default 5), on one thread.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import sys
from collections.abc import Callable
from typing import Any

from scripts.benchmark import bench_cost, bench_error, bench_figures, bench_page, bench_points
from scripts.benchmark.bench_measure import FOLDER, ROOT, WORST, elsewhere, log, machine, problem_of, references, stage
from thermoroll_cli.refinement.solve import solve

FRICTIONLESS_GRIDS = (64, 128)
OWN = ("thermoroll", "thermoroll-flat", "polonsky-keer")
PEERS = ("tamaas", "ContactMechanics")


def frictionless(runs: int, peers: str | None) -> list[dict[str, Any]]:
    """Hertz contact by every solver on equal grids, equally close to the discrete solution, each in its own process."""
    script = str(FOLDER / "baselines" / "frictionless.py")
    rows = []
    for grid in FRICTIONLESS_GRIDS:
        for name in (*OWN, *PEERS):
            interpreter = sys.executable if name in OWN else peers
            if interpreter is None:
                rows.append({"solver": name, "N": grid, "failed": "not installed"})
                continue
            try:
                rows.append(json.loads(elsewhere([interpreter, script, name, str(grid), str(runs)])[1].splitlines()[-1]))
            except RuntimeError as cause:
                log(str(cause))
                rows.append({"solver": name, "N": grid, "failed": "not installed"})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="PART")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--largest", type=int, default=1024, help="largest grid measured (default 1024)")
    parser.add_argument("--peers", metavar="PYTHON")
    parser.add_argument("--page", action="store_true", help="measure nothing: draw the figures and write the page again")
    options = parser.parse_args()
    runs, largest = options.runs, options.largest
    parts: dict[str, Callable[[], Any]] = {
        "accuracy": lambda: bench_error.accuracy(runs, min(largest, 512)),
        "baselines": lambda: bench_error.baselines(runs, min(largest, 256)),
        "frictionless": lambda: frictionless(runs, options.peers),
        "transforms": lambda: bench_cost.transforms(runs, min(largest, 256)),
        "points": lambda: bench_points.points(runs),
        "startup": lambda: bench_cost.startup(runs),
        "plain_start": lambda: bench_cost.plain_start(4 * runs),
        "scaling": lambda: bench_cost.scaling(runs, largest),
        "memory": lambda: bench_cost.memory(largest),
    }
    for name in options.only or ():
        if name not in parts:
            parser.error(f"no part {name!r}: there are {', '.join(parts)}")
    record = FOLDER / "results.json"
    results: dict[str, Any] = json.loads(record.read_text()) if record.exists() else {}
    if options.page and "accuracy" in results:
        measured = results["accuracy"]["measured"]
        measured["contact"] = bench_error.contact(references())
        measured["against_contact"] = bench_error.speed_against_contact(measured["rows"], measured["contact"])
        record.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    else:
        solve(problem_of(WORST, 64))  # imports and buffers of a first solve belong to no measurement
    for name in () if options.page else options.only or parts:
        results[name] = {"machine": machine() | {"runs": runs}, "measured": stage(name, parts[name])}
        if "accuracy" in results:
            measured = results["accuracy"]["measured"]
            measured["against_contact"] = bench_error.speed_against_contact(measured["rows"], measured["contact"])
        record.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    bench_figures.draw(results, FOLDER)
    (ROOT / "docs" / "benchmarks.md").write_text(bench_page.page(results), encoding="utf-8")


if __name__ == "__main__":
    main()

"""Measure the cost and the errors of thermoroll; write results.json, the benchmark's tables in docs/ and its figure.

    python -m scripts.benchmark.bench [--only PART]... [--row ROW]... [--runs N] [--contact PROGRAM] [--peers PYTHON] [--page]

ROW is a function of `rows`: of the part of that name these are measured alone. PROGRAM is CONTACT's executable, PYTHON an
interpreter that has tamaas and ContactMechanics. What is not measured keeps the numbers of results.json. Times are processor
seconds on one thread, medians over N runs (default 5).
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import pathlib
import statistics
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from scripts.benchmark import contact, kinds, over_time, page, positions, rows
from scripts.benchmark.cases import (
    BASELINES,
    FOLDER,
    HOT,
    MECHANICAL,
    ROOT,
    errors,
    estimated,
    log,
    machine,
    problem_of,
    process,
    references,
    seconds,
)
from scripts.stress.random_contacts import random_contact
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

ASKED_SEEDS, FIXED = range(100, 112), Numerics((64, 64))
ASKED_ACCURACIES = (1e-2, 1e-3, 1e-4)
ASKED_GROUPS = ("forces", "heat", "temperatures", "stresses")
GRIDS = (16, 32, 64, 128, 256)
PROCESS_GRIDS = (64, 128, 256, 512, 1024)
TAKEN_AWAY_CASES = ("article_4_1_mechanical", "article_3_1_case_5")
FRICTIONLESS_GRIDS = (64, 128)


def accuracy(runs: int) -> list[dict[str, Any]]:
    """One row per case and grid: seconds, true errors, estimates, applications on the finest grid."""
    fine, out = references(), []
    for case in (*MECHANICAL, HOT):
        for grid in GRIDS:
            problem = problem_of(case, grid)
            result = solve(problem)
            work = partial(solve, problem)
            out.append({"case": case, "N": grid, "seconds": statistics.median(seconds(work) for _ in range(runs)),
                        "error": errors(result.coupled.scalars, fine[case], result.problem.traction_limit),
                        "estimate": estimated(result), "applications": result.work["levels"][-1]["applications"]})
    return out


def taken_away(runs: int) -> list[dict[str, Any]]:
    """The solver with one of its ideas taken away at a time, in turn with the whole one, at N = 128."""
    out = []
    for case in TAKEN_AWAY_CASES:
        problem, fine = problem_of(case, 128), references()[case]
        for name, options in {"thermoroll": SolverOptions(), **BASELINES}.items():
            result = solve(problem, options=options)
            changed, whole = partial(solve, problem, options=options), partial(solve, problem)
            ratios = [seconds(changed) / seconds(whole) for _ in range(runs)]
            out.append({"case": case, "solver": name, "ratio": statistics.median(ratios),
                        "applications": result.work["levels"][-1]["applications"],
                        "error": errors(result.coupled.scalars, fine, problem.traction_limit)["forces"]})
    return out


def frictionless(runs: int, peers: str) -> list[dict[str, Any]]:
    """Hertz contact by every solver on equal grids, equally close to the discrete solution, each in its own process."""
    script = str(FOLDER / "frictionless.py")
    return [json.loads(process([sys.executable if name.startswith("thermoroll") else peers, script, name, str(grid), str(runs)])
                       .output.splitlines()[-1])
            for grid in FRICTIONLESS_GRIDS for name in ("thermoroll", "thermoroll-flat", "tamaas", "ContactMechanics")]


def asked() -> list[dict[str, Any]]:
    """What each group of scalars costs alone, and the usual ones: a row per accuracy and group over the same contacts."""
    return [_asked(wanted, group) for wanted in ASKED_ACCURACIES for group in (*ASKED_GROUPS, "")]


def _asked(wanted: float, group: str) -> dict[str, Any]:
    """A group (empty: the usual scalars) to an accuracy; each contact beside the same one on a fixed grid, in turn."""
    numerics = Numerics(accuracy=wanted, accuracy_of=(group,) if group else ())
    problems = [one for one in map(random_contact, ASKED_SEEDS) if one.heating.heat or group != "temperatures"]
    found = [(_timed(replace(one, numerics=FIXED)), _timed(replace(one, numerics=numerics))) for one in problems]
    results = [result for _, (result, _) in found]
    row = {"accuracy": wanted, "asked": group or "usual scalars", "contacts": len(found),
           "N": statistics.median(result.work["grid"][0] for result in results),
           "applications": statistics.median(_elements(one) / _elements(fixed) for (fixed, _), (one, _) in found),
           "cpu": statistics.median(own / beside for (_, beside), (_, own) in found),
           "reached": sum(result.converged for result in results)}
    log(f"  {row}")
    return row


def _timed(problem: Problem) -> tuple[Result, float]:
    """A result, and the processor seconds that it took."""
    results: list[Result] = []
    spent = seconds(lambda: results.append(solve(problem)))
    return results[0], spent


def _elements(result: Result) -> int:
    """Elements that the operator of rolling was applied to, each as often, on all grids."""
    return sum(level["grid"][0] * level["grid"][1] * (level["applications"] + level.get("coupled_applications", 0))
               for level in result.work["levels"])


def processes(runs: int) -> list[dict[str, Any]]:
    """Processor seconds and peak memory of whole processes, in turn."""
    program = str(pathlib.Path(sys.executable).parent / "thermoroll")
    given = [program, "run", str(ROOT / "cases" / "article_4_1.toml"), "--quiet"]
    with tempfile.TemporaryDirectory() as folder:
        commands = {"thermoroll --help": [program, "--help"],
                    "import of NumPy, SciPy, h5py, matplotlib":
                        [sys.executable, "-c", "import numpy, scipy.special, h5py, matplotlib.figure"],
                    "run, N = 128, six pictures": [*given, "-o", folder]}
        commands |= {f"run --no-plots, N = {n}": [*given, "-o", folder, "--no-plots", "--set", f"numerics.grid={n}"]
                     for n in PROCESS_GRIDS}
        found: dict[str, list[Any]] = {name: [] for name in commands}
        for run in range(runs):
            for name, command in commands.items():
                if run == 0 or "1024" not in name:
                    found[name].append(process(command))
    return [{"name": name, "seconds": statistics.median(one.seconds for one in each), "peak": max(one.peak for one in each)}
            for name, each in found.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="PART")
    parser.add_argument("--row", action="append", metavar="ROW", choices=[row.__name__ for row in rows.ROWS])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--contact", metavar="PROGRAM", help="CONTACT's executable")
    parser.add_argument("--peers", metavar="PYTHON")
    parser.add_argument("--page", action="store_true", help="measure nothing: fill in the tables and draw the figure again")
    options = parser.parse_args()
    runs = options.runs
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # one core for everything that is compared
    parts: dict[str, Callable[[], Any]] = {
        "accuracy": lambda: accuracy(runs), "taken_away": lambda: taken_away(runs), "rows": lambda: rows.measure(runs),
        "processes": lambda: processes(runs), "asked": asked, "over_time": lambda: over_time.measure(runs),
        "kinds": lambda: kinds.measure(runs),
    }
    if options.contact:
        parts["contact"] = lambda: contact.against_contact(options.contact, runs)
        parts["positions"] = lambda: positions.against_contact(options.contact, runs)
    if options.peers:
        parts["frictionless"] = lambda: frictionless(runs, options.peers)
    for name in options.only or ():
        if name not in parts:
            parser.error(f"no part {name!r}: there are {', '.join(parts)}; more with --contact and --peers")
    record = FOLDER / "results.json"
    results: dict[str, Any] = json.loads(record.read_text()) if record.exists() else {}
    for name in () if options.page else options.only or parts:
        log(name)
        solve(problem_of(HOT, 32))  # imports and buffers of a first solve belong to no measurement
        if name == "rows" and options.row and name in results:
            found = {row["name"]: row for row in (*results[name]["measured"], *rows.measure(runs, options.row))}
            results[name]["measured"] = list(found.values())
        else:
            results[name] = {"machine": machine() | {"runs": runs}, "measured": parts[name]()}
        record.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    page.write(results)


if __name__ == "__main__":
    main()

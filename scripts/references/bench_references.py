"""Write scripts/benchmark/references.json: the benchmark's cases on the finest grids, against which its errors are taken.

    python -m scripts.references.bench_references [--grid N]

Takes minutes and is no part of `make bench`. All scalars are extrapolated from the last two grids.
"""

from __future__ import annotations

import argparse
import json
import math

from scripts.benchmark.cases import COUPLED_SCALARS, FOLDER, HOT, MECHANICAL, SPINNING, log, problem_of
from scripts.references.estimate_references import extrapolated
from thermoroll_cli.python_api import solve


def reference(case: str, grid: int) -> dict[str, float]:
    coarse, fine = (solve(problem_of(case, n)) for n in (grid // 2, grid))
    if not (coarse.converged and fine.converged):
        raise RuntimeError(f"{case}: {coarse.reason} {fine.reason}")
    values = extrapolated(coarse, fine, (*COUPLED_SCALARS, "force_y_N"))
    return {name: value for name, value in values.items() if not math.isnan(value)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", type=int, default=1024)
    grid = parser.parse_args().grid
    cases = {}
    for case in (*MECHANICAL, *SPINNING, HOT):
        cases[case] = reference(case, grid)
        log(f"{case}: {cases[case]}")
    lines = ",\n".join(f"  {json.dumps(case)}: {json.dumps(values)}" for case, values in cases.items())
    about = json.dumps(f"Scalars of the benchmark's cases with N = {grid}, extrapolated from N = {grid // 2}. "
                       "Written by scripts/references/bench_references.py.")
    (FOLDER / "references.json").write_text(f'{{\n "about": {about},\n "cases": {{\n{lines}\n }}\n}}\n', encoding="utf-8")


if __name__ == "__main__":
    main()

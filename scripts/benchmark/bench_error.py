"""Run time against error: the article's cases on grids from N = 16 to 512, and the same with one idea taken away at a time."""

from __future__ import annotations

import statistics
from typing import Any

from benchmarks.baselines.rolling import BASELINES
from scripts.benchmark.bench_measure import (
    CONTACT,
    FINE_REFERENCE,
    FORCES,
    HOT,
    MECHANICAL,
    SIDE_BY_SIDE,
    WORST,
    errors,
    estimated,
    finest,
    problem_of,
    references,
    timed,
)

GRIDS = (16, 32, 64, 128, 256, 512)
HOT_GRIDS = (16, 32, 64, 128, 256)
BASELINE_GRIDS = (16, 32, 64, 128, 256)
BASELINE_CASES = (WORST, "article_3_1_case_5")
LARGEST_UNPRECONDITIONED = 128
RUNS = 5
LEVELS = (64, 128, 256)
"""CONTACT's grids at which errors are made equal."""
CONTACT_SOLVER, CONTACT_TOLERANCE = "GDsteady", 1e-5
"""Its fastest solver of steady rolling, and its default tolerance, which costs no accuracy here."""


def _runs(case: str, grid: int, runs: int) -> int:
    """On the largest grids only one case is repeated: the others serve for their errors."""
    return 1 if grid > 256 and case != WORST else runs


def accuracy(runs: int = RUNS, largest: int = 512) -> dict[str, Any]:
    """One row per case and grid: seconds, true error, estimate, applications."""
    fine = references()
    rows = []
    for case in (*MECHANICAL, HOT):
        for grid in HOT_GRIDS if case == HOT else GRIDS:
            if grid > largest:
                continue
            run = timed(problem_of(case, grid), _runs(case, grid, runs))
            result = run.result
            limit = result.problem.traction_limit
            rows.append({
                "case": case, "N": grid, "seconds": run.wall, "cpu_seconds": run.cpu, "runs": run.runs,
                "error": errors(result.coupled.scalars, fine[case], limit), "estimate": estimated(result),
                "applications": finest(result)["applications"],
                "against_fine_reference": None if case == HOT else _against_fine_reference(case, result),
            })
    return {"rows": rows, "contact": contact(fine)}


def _against_fine_reference(case: str, result: Any) -> dict[str, dict[str, float]]:
    """Distance from rolling_fine.json, and the uncertainty that it states, both over μW (heat: relative)."""
    fine = FINE_REFERENCE[case]["fine"]
    stated = fine["uncertainty"]
    limit, scalars = result.problem.traction_limit, result.isothermal.scalars
    distance, uncertainty = {}, {}
    for axis in "xy":
        key = f"force_{axis}_over_muW"
        distance[f"force_{axis}"] = abs(scalars[f"force_{axis}_N"] / limit - fine[key])
        uncertainty[f"force_{axis}"] = stated[key]
    heat = fine["heat_over_V_muW"]
    distance["heat"] = abs(scalars["Q_F_W"] / limit / heat - 1.0)
    uncertainty["heat"] = stated["heat_over_V_muW"] / heat
    distance["stick"] = abs(scalars["gamma_st"] - fine["stick_fraction"])
    uncertainty["stick"] = stated["stick_fraction"]
    return {"distance": distance, "uncertainty": uncertainty}


def contact(fine: dict[str, dict[str, float]]) -> list[dict[str, Any]]:
    """CONTACT's errors against the same references, with its processor seconds at its default tolerance."""
    rows = []
    for row in sorted(SIDE_BY_SIDE, key=lambda r: r["N"]):
        data = CONTACT[row["case"]]
        if (row["solver"], row["eps"]) != (CONTACT_SOLVER, CONTACT_TOLERANCE) or str(row["N"]) not in data["grids"]:
            continue
        limit = data["input"]["normal_N"] * data["input"]["friction_coefficient"]
        values = data["grids"][str(row["N"])]
        # It reports the slip of whole elements as dissipation; the work of its forces is the better value.
        scalars = {"force_x_N": row["force_x_N"], "force_y_N": row["force_y_N"],
                   "Q_F_W": values["dissipation_from_forces_W"], "gamma_st": values["stick_fraction"]}
        rows.append({"case": row["case"], "N": row["N"], "cpu_seconds": row["cpu_s"], "forces": [row[k] for k in FORCES],
                     "error": errors(scalars, fine[row["case"]], limit)})
    return rows


def baselines(runs: int = RUNS, largest: int = 256) -> list[dict[str, Any]]:
    """Thermoroll and the baselines in turn on two cases, grid by grid."""
    fine = references()
    rows = []
    for case in BASELINE_CASES:
        for grid in BASELINE_GRIDS:
            if grid > largest:
                continue
            problem = problem_of(case, grid)
            own = timed(problem, runs)
            rows.append(_row("thermoroll", case, grid, own, own.wall, fine[case]))
            for name, options in BASELINES.items():
                if name.startswith("unpreconditioned") and grid > LARGEST_UNPRECONDITIONED:
                    continue
                try:
                    run = timed(problem, runs if grid <= 128 else min(runs, 3), options)
                except RuntimeError as cause:
                    rows.append({"solver": name, "case": case, "N": grid, "failed": str(cause)})
                    continue
                rows.append(_row(name, case, grid, run, own.wall, fine[case]))
    return rows


def _row(name: str, case: str, grid: int, run: Any, own: float, fine: dict[str, float]) -> dict[str, Any]:
    result = run.result
    return {"solver": name, "case": case, "N": grid, "seconds": run.wall, "cpu_seconds": run.cpu, "runs": run.runs,
            "ratio": run.wall / own, "applications": finest(result)["applications"],
            "error": errors(result.coupled.scalars, fine, result.problem.traction_limit)}


def speed_against_contact(rows: list[dict[str, Any]], contact: list[dict[str, Any]]) -> dict[str, Any]:
    """CONTACT's processor seconds over ours on the coarsest grid whose forces are as good as its own: by its N, and for its
    forces extrapolated from N = 64 and 128."""
    fine = references()
    levels: dict[str, Any] = {}
    for n in LEVELS:
        levels[f"N = {n}"] = _equal_errors(rows, [r for r in contact if r["N"] == n])
    extrapolated = []
    for case in dict.fromkeys(r["case"] for r in contact):
        coarse, last = (next(r for r in contact if (r["case"], r["N"]) == (case, n)) for n in (64, 128))
        # First order: the error halves.
        forces = [2.0 * b - a for a, b in zip(coarse["forces"], last["forces"], strict=True)]
        limit = CONTACT[case]["input"]["normal_N"] * CONTACT[case]["input"]["friction_coefficient"]
        off = max(abs(found - fine[case][name]) for found, name in zip(forces, FORCES, strict=True)) / limit
        seconds = coarse["cpu_seconds"] + last["cpu_seconds"]
        extrapolated.append({"case": case, "cpu_seconds": seconds, "error": {"forces": off}})
    levels["N = 64 and 128, extrapolated"] = _equal_errors(rows, extrapolated)
    return levels


def _equal_errors(rows: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> dict[str, Any]:
    found = []
    for other in theirs:
        own = [r for r in rows if r["case"] == other["case"] and r["error"]["forces"] <= other["error"]["forces"]]
        if own:
            best = min(own, key=lambda r: r["N"])
            found.append({"case": other["case"], "contact_seconds": other["cpu_seconds"],
                          "contact_error": other["error"]["forces"], "N": best["N"], "seconds": best["cpu_seconds"],
                          "error": best["error"]["forces"], "ratio": other["cpu_seconds"] / best["cpu_seconds"]})
    return {"rows": found, "median": statistics.median(r["ratio"] for r in found) if found else None}

"""Run time against error: the article's cases on grids from N = 16 to 512, and the same with one idea taken away at a time."""

from __future__ import annotations

import statistics
from typing import Any

from benchmarks.baselines.rolling import BASELINES
from scripts.benchmark.bench_measure import (
    CONTACT,
    FINE_REFERENCE,
    HOT,
    MECHANICAL,
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
    return {"rows": rows, "contact": _contact(fine)}


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


def _contact(fine: dict[str, dict[str, float]]) -> list[dict[str, Any]]:
    """CONTACT's errors against the same references, with its CPU seconds, both measured elsewhere."""
    rows = []
    for case, data in CONTACT.items():
        limit = data["input"]["normal_N"] * data["input"]["friction_coefficient"]
        for grid, values in data["grids"].items():
            # It reports the slip of whole elements as dissipation; the work of its forces is the better value.
            scalars = {"force_x_N": values["force_x_N"], "force_y_N": values["force_y_N"],
                       "Q_F_W": values["dissipation_from_forces_W"], "gamma_st": values["stick_fraction"]}
            rows.append({"case": case, "N": int(grid), "cpu_seconds": values["cpu_s"],
                         "error": errors(scalars, fine[case], limit)})
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


def speed_against_contact(rows: list[dict[str, Any]], contact: list[dict[str, Any]], wanted: float | None) -> dict[str, Any]:
    """CONTACT's processor seconds at N = 256 over ours on the coarsest grid whose forces and heat are as good as its own
    there, or better than `wanted`."""
    ratios: dict[str, Any] = {}
    for case in MECHANICAL:
        theirs = next(r for r in contact if r["case"] == case and r["N"] == 256)
        for row in sorted((r for r in rows if r["case"] == case), key=lambda r: r["N"]):
            if all(row["error"][name] <= (wanted or theirs["error"][name]) for name in ("forces", "Q_F_W")):
                ratios[case] = {"N": row["N"], "seconds": row["cpu_seconds"], "error": row["error"]["forces"],
                                "contact_seconds": theirs["cpu_seconds"], "contact_error": theirs["error"]["forces"],
                                "ratio": theirs["cpu_seconds"] / row["cpu_seconds"]}
                break
    return {"cases": ratios, "median": statistics.median(r["ratio"] for r in ratios.values()) if ratios else None,
            "least": min((r["ratio"] for r in ratios.values()), default=None)}

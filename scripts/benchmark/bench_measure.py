"""What all parts of the benchmark share: cases, medians, fine references, processes of their own."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from scripts.problems import spin_ellipse
from thermoroll_cli import Case
from thermoroll_cli.problem.problem import Heating, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import solve
from thermoroll_cli.steady_state.solver_options import SolverOptions

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks"
REFERENCE = ROOT / "tests" / "reference"

CONTACT = json.loads((REFERENCE / "contact_rolling.json").read_text())["cases"]
SIDE_BY_SIDE = json.loads((REFERENCE / "contact_side_by_side.json").read_text())["rows"]
"""CONTACT's processor seconds, of four of these cases."""
FINE_REFERENCE = json.loads((REFERENCE / "rolling_fine.json").read_text())["cases"]
MECHANICAL = tuple(FINE_REFERENCE)
"""Seven isothermal rolling cases of the article."""
HOT = "article_4_1"
"""The article's thermally coupled case."""
WORST = "article_4_1_mechanical"
"""The case of the cost measurements."""

SPINNING = {"spin_ellipse_0.5": 0.5, "spin_ellipse_2": 2.0}
"""Elliptic contacts, by a0/b0, in which spin makes most of the slip: references for tests (`scripts.problems.spin_ellipse`)."""

FORCES = ("force_x_N", "force_y_N")
COUPLED_SCALARS = ("Q_F_W", "force_x_N", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K")


def problem_of(case: str, grid: int) -> Problem:
    """A case of the benchmark on a square grid."""
    if case in SPINNING:
        return spin_ellipse(SPINNING[case], grid)
    if case == HOT:
        problem = Case.read(ROOT / "cases" / "article_4_1.toml").problem
    else:
        given = FINE_REFERENCE[case]["input"]
        name = "article_3_1_case_1" if case.startswith("article_3_1") else "article_4_1"
        problem = Case.read(ROOT / "cases" / f"{name}.toml").problem
        motion = dataclasses.replace(problem.motion, speed=1.0, creepage_x=given["creepage_longitudinal"],
                                     creepage_y=given["creepage_lateral"], spin=given["spin_rad_mm"] * 1e3)
        problem = dataclasses.replace(problem, motion=motion, heating=Heating(heat=False, deformation=False))
        radius = given["radius_mm"] * 1e-3
        assert math.isclose(problem.geometry.lower_radius_x, radius) and problem.normal_force == given["normal_N"]
        assert problem.friction == given["friction_coefficient"]
    return dataclasses.replace(problem, numerics=Numerics(grid=(grid, grid)))


@dataclasses.dataclass(frozen=True)
class Timed:
    """Medians over `runs` runs, in s: elapsed, and of the processor."""

    result: Result
    wall: float
    cpu: float
    runs: int


def timed(problem: Problem, runs: int, options: SolverOptions | None = None) -> Timed:
    """Solve `problem` again and again, on one thread, from nothing each time; baselines with their own `options`."""
    walls, cpus = [], []
    for _ in range(runs):
        wall, cpu = time.perf_counter(), time.process_time()
        result = solve(problem, options=options)
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    if not result.converged:
        raise RuntimeError(f"{problem.title} did not converge: {result.reason}")
    return Timed(result, statistics.median(walls), statistics.median(cpus), runs)


def finest(result: Result) -> dict[str, Any]:
    """Account of the finest grid."""
    level: dict[str, Any] = result.work["levels"][-1]
    return level


# --- errors ----------------------------------------------------------------------------------------------------------


def references() -> dict[str, dict[str, float]]:
    """Scalars of every case on a much finer grid (benchmarks/references.json)."""
    table: dict[str, dict[str, float]] = json.loads((FOLDER / "references.json").read_text())["cases"]
    return table




def errors(scalars: Any, fine: dict[str, float], limit: float) -> dict[str, float]:
    """True errors: of forces together over μW, of the stick fraction absolute, of the rest relative."""
    out = {"forces": math.hypot(*(scalars[k] - fine[k] for k in FORCES)) / limit}
    for name, value in fine.items():
        if name not in FORCES and value != 0.0 and name in scalars:
            out[name] = abs(scalars[name] - value) / (1.0 if name == "gamma_st" else abs(value))
    return out


def estimated(result: Result) -> dict[str, float]:
    """Estimates in the same form as `errors`."""
    limit, scalars = result.problem.traction_limit, result.coupled.scalars
    forces = [result.error[k] * max(abs(scalars[k]), limit) / limit for k in FORCES]
    return {"forces": math.hypot(*forces), **{k: result.error[k] for k in COUPLED_SCALARS if k not in FORCES}}


# --- elsewhere -------------------------------------------------------------------------------------------------------


def elsewhere(command: Sequence[str], runs: int = 1, *, timeout: float = 600.0) -> tuple[float, str]:
    """Median elapsed seconds of whole processes on one thread, and what the last one printed."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=timeout, check=False)
        seconds.append(time.perf_counter() - start)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()[-500:]}")
    return statistics.median(seconds), done.stdout


def machine() -> dict[str, Any]:
    """What the times depend on, in general terms."""
    model = platform.processor() or platform.machine()
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].split(":", 1)[1].strip() if lines else model
    return {"processor": model, "cores": os.cpu_count(), "python": platform.python_version(), "load": os.getloadavg()[0]}


def log(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def stage(name: str, work: Callable[[], Any]) -> Any:
    """Run a part and say how long it took."""
    start = time.perf_counter()
    result = work()
    log(f"{name}: {time.perf_counter() - start:.1f} s")
    return result

"""Cases of the benchmark, their reference values and errors, and processor seconds of solves and of whole processes."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from typing import Any

from tests.support.errors import relative
from tests.support.problems import spin_ellipse
from thermoroll_cli import Case
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.physics.heat.heat_response import small_table
from thermoroll_cli.physics.rolling.rolling_gradient import RollingOptions
from thermoroll_cli.problem.problem import Heating, Numerics, Problem
from thermoroll_cli.problem.result import Result

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = pathlib.Path(__file__).resolve().parent

FINE_REFERENCE = json.loads((ROOT / "tests" / "reference" / "rolling_fine.json").read_text())["cases"]
MECHANICAL = tuple(FINE_REFERENCE)
"""Seven isothermal rolling cases of the article."""
HOT = "article_4_1"
"""The article's thermally coupled case."""
SPINNING = {"spin_ellipse_0.5": 0.5, "spin_ellipse_2": 2.0}
"""Elliptic contacts, by a0/b0, in which spin makes most of the slip: references for tests (`problems.spin_ellipse`)."""

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
        assert math.isclose(problem.geometry.lower_radius_x, given["radius_mm"] * 1e-3)
        assert (problem.normal_force, problem.friction.coefficient) == (given["normal_N"], given["friction_coefficient"])
    return dataclasses.replace(problem, numerics=Numerics(grid=(grid, grid)))


def references() -> dict[str, dict[str, float]]:
    """Scalars of every case on a much finer grid (references.json, by `scripts.references.bench_references`)."""
    table: dict[str, dict[str, float]] = json.loads((FOLDER / "references.json").read_text())["cases"]
    return table


def errors(scalars: Any, fine: dict[str, float], limit: float) -> dict[str, float]:
    """True errors: of both forces together over μW (`limit`), of the stick fraction absolute, of the rest relative."""
    out = {"forces": math.hypot(*(scalars[k] - fine[k] for k in FORCES)) / limit}
    for name, value in fine.items():
        if name not in FORCES and value != 0.0 and name in scalars:
            out[name] = abs(scalars[name] - value) / (1.0 if name == "gamma_st" else abs(value))
    return out


def estimated(result: Result) -> dict[str, float]:
    """Estimates in the same form as `errors`."""
    limit, scalars = result.problem.traction_limit, result.coupled.scalars
    forces = [relative(result)[k] * max(abs(scalars[k]), limit) / limit for k in FORCES]
    return {"forces": math.hypot(*forces), **{k: relative(result)[k] for k in COUPLED_SCALARS if k not in FORCES}}


def seconds(work: Callable[[], object]) -> float:
    """Processor seconds of this process for one call of `work`, which finds no tables of thermal expansion of others."""
    small_table.cache_clear()
    start = time.process_time()
    work()
    return time.process_time() - start


@dataclasses.dataclass(frozen=True)
class Process:
    """Processor seconds (user and system) and peak memory in bytes of a finished process, and its standard output."""

    seconds: float
    peak: int
    output: str


LAUNCHER = """import resource, subprocess, sys
code = subprocess.call(sys.argv[2:])
used = resource.getrusage(resource.RUSAGE_CHILDREN)
with open(sys.argv[1], "w") as file:
    file.write(f"{used.ru_utime + used.ru_stime} {used.ru_maxrss}")
sys.exit(code)"""
"""A small process between: on Linux the peak memory of a process counts that of the process which started it."""


def process(command: Sequence[str], folder: pathlib.Path | None = None) -> Process:
    """Run `command` in `folder` on one thread; raises RuntimeError with its standard error where it fails."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    with tempfile.NamedTemporaryFile("r") as usage:
        done = subprocess.run([sys.executable, "-S", "-c", LAUNCHER, usage.name, *command], capture_output=True, text=True,
                              env=environment, cwd=folder or ROOT, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()[-500:]}")
        taken, peak = usage.read().split()
    return Process(float(taken), int(peak) * (1 if sys.platform == "darwin" else 1024), done.stdout)


def machine() -> dict[str, Any]:
    """The machine in general terms, and how busy it is."""
    model = platform.processor() or platform.machine()
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].split(":", 1)[1].strip() if lines else model
    return {"processor": model, "cores": os.cpu_count(), "python": platform.python_version(), "load": os.getloadavg()[0]}


def log(text: str) -> None:
    """Progress on standard error."""
    print(text, file=sys.stderr, flush=True)


# --- the rolling solver with one of its ideas taken away at a time: a comparison shows the worth of that idea alone ---


UPSTREAM = (0.0, -1.0, 1.0, 0.0)
"""(u_i − u_{i−1})/h at offsets −2 … 1."""

WITHOUT_EXTRAPOLATION = SolverOptions(extrapolated=False)
"""Values of the last grid as they are."""

FIRST_ORDER = dataclasses.replace(
    WITHOUT_EXTRAPOLATION,
    rolling=RollingOptions(difference_weights=UPSTREAM, leading_known=False),
    whole_elements=True,
)
"""CONTACT's discretisation: first-order upstream differences, whole elements inside the contact border, and the values of
the last grid as they are."""

UNPRECONDITIONED = SolverOptions(rolling=RollingOptions(preconditioned=False))
"""GMRES on the Newton equations as they are (without restart, as long as it takes)."""

NO_CONTINUATION = SolverOptions(sequence=False)
"""The wanted grid alone, from a cold start: then there is neither an estimate nor an extrapolation."""

BASELINES: dict[str, SolverOptions] = {
    "first-order discretisation": FIRST_ORDER,
    "no continuation": NO_CONTINUATION,
    "unpreconditioned GMRES": UNPRECONDITIONED,
}

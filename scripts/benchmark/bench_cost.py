"""What a solve costs: time and memory against N, the share of its own Fourier transforms, start-up of the whole program."""

from __future__ import annotations

import json
import math
import pathlib
import resource
import statistics
import sys
import tempfile
import time
from typing import Any

import numpy as np
import pyfftw

from scripts.benchmark.bench_measure import HOT, MECHANICAL, ROOT, WORST, elsewhere, finest, log, problem_of, timed
from thermoroll_cli.refinement.solve import solve

GRIDS = (64, 128, 256, 512, 1024)
UNIT = 512
ALL_IMPORTS = "import numpy, h5py, typer; from pydantic import BaseModel, TypeAdapter; TypeAdapter(int)"
IMPORTS = "import numpy, scipy.special, pyfftw, h5py, matplotlib.figure"


# --- cost against N --------------------------------------------------------------------------------------------------


def scaling(runs: int, largest: int) -> dict[str, Any]:
    """Time of the whole solve of one isothermal case against N, with the exponent of time ~ elements^p."""
    rows = []
    for grid in (n for n in GRIDS if n <= largest):
        # A solve of a million elements takes half a minute: half a dozen of them would be most of the benchmark.
        run = timed(problem_of(WORST, grid), runs if grid <= 512 else min(runs, 2))
        rows.append({"N": grid, "seconds": run.wall, "cpu_seconds": run.cpu, "runs": run.runs,
                     "microseconds_per_element": 1e6 * run.cpu / grid**2, "applications": finest(run.result)["applications"]})
        log(f"  N = {grid}: {run.wall:.2f} s")
    slope = np.polyfit([math.log(r["N"] ** 2) for r in rows[1:]], [math.log(r["cpu_seconds"]) for r in rows[1:]], 1)[0]
    by_grid = {r["N"]: r["microseconds_per_element"] for r in rows}
    growth = by_grid[max(by_grid)] / by_grid[128] if 128 in by_grid else None
    return {"case": WORST, "rows": rows, "exponent": float(slope), "growth_per_element_from_128": growth}


MEMORY_PROBE = """
import json, resource, sys, time
sys.path.insert(0, {scripts!r})
from scripts.benchmark.bench_measure import problem_of
from thermoroll_cli.refinement.solve import solve
start = time.perf_counter()
result = solve(problem_of({case!r}, {grid}))
# Of this program alone where the system tells: the other figure also knows what started it.
status = open("/proc/self/status").read().splitlines() if sys.platform == "linux" else []
own = [int(line.split()[1]) for line in status if line.startswith("VmHWM")]
peak = (own or [resource.getrusage(resource.RUSAGE_SELF).ru_maxrss])[0] * 1024
print(json.dumps({{"case": {case!r}, "N": {grid}, "seconds": time.perf_counter() - start, "peak_bytes": peak,
                  "converged": result.converged, "reason": result.reason}}))
"""


def memory(largest: int) -> list[dict[str, Any]]:
    """Peak memory of processes that solve one case each: isothermal and coupled."""
    rows = []
    for case in (WORST, HOT):
        for grid in (n for n in (256, 512, 1024) if n <= largest):
            probe = MEMORY_PROBE.format(scripts=str(ROOT / "scripts"), case=case, grid=grid)
            rows.append(json.loads(elsewhere([sys.executable, "-c", probe])[1]))
            log(f"  {case}, N = {grid}: {rows[-1]['peak_bytes'] / 2**30:.2f} GiB")
    return rows


# --- the share of the transforms -------------------------------------------------------------------------------------


class _Counted:
    """A plan that counts how often it is executed."""

    def __init__(self, plan: Any, real: bool, length: int, batch: int) -> None:
        self.plan, self.count = plan, 0
        # Operations of one execution, 2.5 or 5 n log2 n per transform of n values.
        self.operations = (2.5 if real else 5.0) * batch * length * math.log2(max(length, 2))

    def execute(self) -> None:
        self.count += 1
        self.plan.execute()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.plan, name)


class PlanRecorder:
    """Inside it every plan that is made counts its executions."""

    def __init__(self) -> None:
        self.plans: list[_Counted] = []
        self._make = pyfftw.FFTW

    def __enter__(self) -> PlanRecorder:
        pyfftw.FFTW = self._record
        return self

    def __exit__(self, *_: object) -> None:
        pyfftw.FFTW = self._make

    def _record(self, a: Any, b: Any, axes: tuple[int, ...] = (-1,), **options: Any) -> _Counted:
        plan = self._make(a, b, axes=axes, **options)
        field = b if np.iscomplexobj(a) else a
        length = math.prod(field.shape[axis] for axis in axes)
        counted = _Counted(plan, not np.iscomplexobj(field), length, field.size // length)
        self.plans.append(counted)
        return counted

    def alone(self) -> float:
        """Seconds of the processor for all executions again, with nothing in between."""
        start = time.process_time()
        for plan in self.plans:
            execute = plan.plan.execute
            for _ in range(plan.count):
                execute()
        return time.process_time() - start

    @property
    def equivalents(self) -> float:
        """All transforms in units of a real two-dimensional one of 512 × 512."""
        unit = 2.5 * UNIT**2 * math.log2(UNIT**2)
        return sum(plan.count * plan.operations for plan in self.plans) / unit


class PlainTransforms:
    """What the applications of a solve would cost in plain padded transforms alone: two there and two back in double
    precision on the plane of twice the grid's sides, with neither symmetry used nor passes over zeros left out."""

    def __init__(self, grids: list[list[int]]) -> None:
        self._pairs = []
        for nx, ny in grids:
            field = pyfftw.zeros_aligned((2 * nx, 2 * ny))
            hat = pyfftw.zeros_aligned((2 * nx, ny + 1), dtype=np.complex128)
            flags = ("FFTW_ESTIMATE",)
            self._pairs.append((pyfftw.FFTW(field, hat, axes=(0, 1), flags=flags),
                                pyfftw.FFTW(hat, field, axes=(0, 1), direction="FFTW_BACKWARD", flags=flags)))

    def alone(self, applications: list[int]) -> float:
        """Seconds of the processor for so many applications on each grid."""
        start = time.process_time()
        for (there, back), count in zip(self._pairs, applications, strict=True):
            for _ in range(2 * count):
                there.execute()
                back.execute()
        return time.process_time() - start


def transforms(runs: int, grid: int = 256) -> dict[str, Any]:
    """Solver time over the time of its own transforms (both of the processor), and their number, for every isothermal case."""
    rows = []
    for case in MECHANICAL:
        problem = problem_of(case, grid)
        solve(problem)
        with PlanRecorder() as recorder:
            result = solve(problem)
        levels = result.work["levels"]
        plain, applications = PlainTransforms([level["grid"] for level in levels]), [level["applications"] for level in levels]
        ratios, seconds, alone, whole = [], [], [], []
        for _ in range(runs):
            # In turn, so that whatever slows the machine slows both.
            start = time.process_time()
            solve(problem)
            seconds.append(time.process_time() - start)
            alone.append(recorder.alone())
            whole.append(plain.alone(applications))
            ratios.append(seconds[-1] / alone[-1])
        rows.append({"case": case, "N": grid, "seconds": statistics.median(seconds),
                     "transforms_alone": statistics.median(alone), "ratio": statistics.median(ratios), "runs": runs,
                     "plain_transforms_alone": statistics.median(whole),
                     "equivalents_512": recorder.equivalents,
                     "padded_transforms": sum(level["transforms"] for level in levels),
                     "applications": finest(result)["applications"]})
    return {"rows": rows, "ratio": statistics.median(r["ratio"] for r in rows),
            "equivalents_512": max(r["equivalents_512"] for r in rows)}


# --- the whole process -----------------------------------------------------------------------------------------------


def startup(runs: int) -> dict[str, Any]:
    """`thermoroll run` with HDF5 and pictures against the imports that it cannot do without, in turn."""
    case = (ROOT / "cases" / "article_4_1.toml").read_text()
    program = str(pathlib.Path(sys.executable).parent / "thermoroll")
    out: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        adaptive = pathlib.Path(folder) / "adaptive.toml"
        adaptive.write_text(case.replace("grid = 128", "accuracy = 1e-3"))
        given = ROOT / "cases" / "article_4_1.toml"
        commands = {
            "imports": [sys.executable, "-c", IMPORTS],
            "imports, Dask not installed": [sys.executable, "-c", f"import sys; sys.modules['dask'] = None; {IMPORTS}"],
            "accuracy = 1e-3": [program, "run", str(adaptive), "-o", folder],
            "grid = 128": [program, "run", str(given), "-o", folder],
        }
        seconds: dict[str, list[float]] = {name: [] for name in commands}
        cpu: dict[str, list[float]] = {name: [] for name in commands}
        failed: dict[str, str] = {}
        for _ in range(runs):
            for name, command in commands.items():
                before = _children_seconds()
                try:
                    seconds[name].append(elsewhere(command)[0])
                    cpu[name].append(_children_seconds() - before)
                except RuntimeError as cause:
                    failed[name] = str(cause)
        for name, values in seconds.items():
            if values:
                out[name] = {"seconds": statistics.median(values), "cpu_seconds": statistics.median(cpu[name]), "runs": runs,
                             "cpu_ratio": statistics.median(cpu[name]) / statistics.median(cpu["imports"]),
                             "ratio": statistics.median(v / w for v, w in zip(values, seconds["imports"], strict=True))}
            else:
                out[name] = {"failed": failed[name]}
        result = solve(_adaptive_problem(adaptive))
        out["reached"] = {"converged": result.converged, "reason": result.reason, "grid": result.work["grid"],
                          "error": {k: v for k, v in result.error.items() if v == v}}
    return out


def plain_start(runs: int) -> dict[str, Any]:
    """`thermoroll run --no-plots` of a mechanical case as a whole process against `import numpy, h5py`, in turn; and against
    what else it imports of others, and what it takes to read a case."""
    case = (ROOT / "cases" / "table1.toml").read_text() + "\n"
    program = str(pathlib.Path(sys.executable).parent / "thermoroll")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "case.toml"
        path.write_text(case)
        run = [program, "run", str(path), "--no-plots", "-o", folder, "--set", "thermal.heat=false", "--set"]
        commands = {"imports": [sys.executable, "-c", "import numpy, h5py"],
                    "imports, Typer, pydantic": [sys.executable, "-c", ALL_IMPORTS],
                    "thermoroll validate": [program, "validate", str(path)],
                    **{f"N = {n}": [*run, f"numerics.grid={n}"] for n in (32, 64, 128)}}
        cpu: dict[str, list[float]] = {name: [] for name in commands}
        for _ in range(runs + 1):
            for name, command in commands.items():
                before = _children_seconds()
                # With compiled modules kept, as after an installation.
                elsewhere(["env", "-u", "PYTHONDONTWRITEBYTECODE", *command])
                cpu[name].append(_children_seconds() - before)
    # The first time modules are compiled.
    return {name: {"cpu_seconds": statistics.median(values[1:]), "runs": runs,
                   "cpu_ratio": statistics.median(v / w for v, w in zip(values[1:], cpu["imports"][1:], strict=True))}
            for name, values in cpu.items()}


def _children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _adaptive_problem(path: pathlib.Path) -> Any:
    from thermoroll_cli import Case

    return Case.read(path).problem

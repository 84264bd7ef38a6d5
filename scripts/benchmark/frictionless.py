"""Hertz contact of a unit sphere on one grid by one solver; prints JSON. Runs in the interpreter that has the solver.

    python frictionless.py SOLVER N RUNS

SOLVER is thermoroll, thermoroll-flat (from a flat first guess instead of Hertz's), tamaas or ContactMechanics. All solve the
same free-space problem with constant pressure on each element. Tolerances mean different things to different programs, so each
gets the loosest power of ten with which its pressures come within `WANTED` (rms on the contact, over the peak) of its solution
at the tightest. Only the solve is timed, not the making of kernels and plans.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Solve = Callable[[float], Array]

WANTED = 1e-6
SIDE = 2.2
"""Domain over the contact radius, which is 1 as are E* and 1/R."""
LOAD = 4.0 / 3.0
TIGHTEST = 1e-11


def _gap(n: int) -> Array:
    x = (np.arange(n) + 0.5) / n * SIDE - 0.5 * SIDE
    return np.asarray(0.5 * (x[:, None] ** 2 + x[None, :] ** 2))


def hertz(n: int) -> Array:
    """Hertz pressure at element centres."""
    return np.asarray(2.0 / np.pi * np.sqrt(np.maximum(1.0 - 2.0 * _gap(n), 0.0)))


def thermoroll(n: int, flat: bool) -> Solve:
    from thermoroll_cli.physics.contact.normal_contact import NormalSolver
    from thermoroll_cli.physics.halfspace.bodies import Bodies
    from thermoroll_cli.physics.numerics.grid import Grid

    solver = NormalSolver(Grid.over((n, n), SIDE, SIDE), Bodies(1.0))
    start = np.ones((n, n)) if flat else hertz(n)
    return lambda tolerance: solver.solve(_gap(n), LOAD, start, tolerance).pressure


def tamaas(n: int) -> Solve:
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIDE, SIDE], [n, n])
    model.E, model.nu = 1.0, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "free")

    def solve(tolerance: float) -> Array:
        model.traction[...] = 0.0
        solver = tm.PolonskyKeerRey(model, -_gap(n), tolerance)
        solver.setIntegralOperator("free")
        solver.max_iter = 10000
        solver.solve(LOAD / SIDE**2)
        return np.array(model.traction).reshape(n, n)

    return solve


def contact_mechanics(n: int) -> Solve:
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Factory import make_system
    from SurfaceTopography import Topography

    system = make_system(substrate=FreeFFTElasticHalfSpace((n, n), 1.0, (SIDE, SIDE)),
                         surface=Topography(-_gap(n), (SIDE, SIDE)))

    def solve(tolerance: float) -> Array:
        solution = system.minimize_proxy(external_force=LOAD, pentol=tolerance, forcetol=tolerance)
        return np.asarray(np.abs(np.asarray(solution.jac))[:n, :n] * (n / SIDE) ** 2)

    return solve


SOLVERS: dict[str, Callable[[int], Solve]] = {
    "thermoroll": lambda n: thermoroll(n, flat=False), "thermoroll-flat": lambda n: thermoroll(n, flat=True),
    "tamaas": tamaas, "ContactMechanics": contact_mechanics,
}


def distance(pressure: Array, best: Array) -> float:
    """Root mean square over the contact, over the peak."""
    inside = best > 0.0
    return float(np.sqrt(np.mean((pressure[inside] - best[inside]) ** 2)) / best.max())


def measure(name: str, n: int, runs: int) -> dict[str, Any]:
    """Processor milliseconds, median over `runs`, at the loosest sufficient tolerance."""
    solve = SOLVERS[name](n)
    best = solve(TIGHTEST)
    tolerance = next(t for t in (10.0**-k for k in range(2, 12)) if distance(solve(t), best) <= WANTED)
    taken = []
    for _ in range(runs):
        start = time.process_time()
        solve(tolerance)
        taken.append(time.process_time() - start)
    return {"solver": name, "N": n, "tolerance": tolerance, "ms": 1e3 * statistics.median(taken),
            "peak_error": abs(float(best.max()) * np.pi / 2.0 - 1.0)}


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))

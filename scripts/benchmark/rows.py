"""Cost of features beside the plain way, in turn in one process. A new comparison is a function here and its name in `ROWS`."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from scripts.benchmark.cases import HOT, ROOT, log, problem_of, seconds
from thermoroll_cli import Case
from thermoroll_cli.creep_table.point_solver import EllipseSolver
from thermoroll_cli.creep_table.values import Axes
from thermoroll_cli.problem.problem import Heating, Motion, Numerics, Problem
from thermoroll_cli.refinement.solve import Solver, solve


@dataclasses.dataclass(frozen=True)
class Row:
    """`work` beside `plain`, both for as many `points` (or different numbers of them); seconds are stated per point."""

    name: str
    beside: str
    work: Callable[[], object]
    plain: Callable[[], object]
    points: int = 1
    plain_points: int = 1


def sweep() -> Row:
    """30 speeds of the coupled case, each started from its neighbours, beside each one solved from nothing."""
    problem = problem_of(HOT, 64)
    return _swept("30 speeds, coupled", [_moving(problem, speed=float(v)) for v in np.linspace(10.0, 200.0, 30)])


def sweep_of_loads() -> Row:
    """20 loads on a profile, coupled."""
    problem = _on_case("crowned_roller")
    return _swept("20 loads on a profile", [dataclasses.replace(problem, normal_force=problem.normal_force * float(f))
                                            for f in np.linspace(0.7, 1.3, 20)])


def sweep_of_rails() -> Row:
    """20 creepages of a wheel on a rail."""
    problem = _on_case("wheel_rail")
    return _swept("20 creepages of wheel and rail",
                  [_moving(problem, creepage_x=float(c)) for c in np.linspace(1e-3, 1e-2, 20)])


def table_16() -> Row:
    """Creep forces of a table at its coarser accuracy."""
    return _table(16, 4e-3)


def table_32() -> Row:
    """Creep forces of a table."""
    return _table(32, 1e-3)


def heat() -> Row:
    """Heat that deforms the contact."""
    problem = problem_of(HOT, 128)
    isothermal = dataclasses.replace(problem, heating=Heating(heat=False, deformation=False))
    return Row("heat and thermal deformation, N = 128", "isothermal", partial(solve, problem), partial(solve, isothermal))


def subsurface() -> Row:
    """Stresses and temperatures below the surface."""
    problem = dataclasses.replace(Case.read(ROOT / "cases" / "hot_sliding.toml").problem, numerics=Numerics((64, 64)))
    return Row("stresses and temperatures below the surface, N = 64", "surface only",
               partial(solve, problem), partial(solve, dataclasses.replace(problem, subsurface=None)))


ROWS: list[Callable[[], Row]] = [sweep, sweep_of_loads, sweep_of_rails, table_16, table_32, heat, subsurface]


def measure(runs: int) -> list[dict[str, Any]]:
    """Milliseconds per point of both ways, medians, and the ratios of single runs: median, least, largest."""
    out = []
    for make in ROWS:
        row = make()
        row.work()  # buffers and imports of a first call belong to no measurement
        pairs = [(seconds(row.work) / row.points, seconds(row.plain) / row.plain_points) for _ in range(runs)]
        ratios = [one / other for one, other in pairs]
        out.append({"name": row.name, "beside": row.beside, "ms": 1e3 * statistics.median(one for one, _ in pairs),
                    "beside_ms": 1e3 * statistics.median(other for _, other in pairs),
                    "ratio": statistics.median(ratios), "least": min(ratios), "largest": max(ratios)})
        log(f"  {out[-1]}")
    return out


def _in_order(problems: Iterable[Problem]) -> None:
    solver = Solver()
    for problem in problems:
        solver.solve(problem)


def _swept(what: str, problems: list[Problem]) -> Row:
    def cold() -> None:
        for one in problems:
            solve(one)

    return Row(f"point of a sweep over {what}, N = 64", "the same points from nothing", partial(_in_order, problems), cold,
               len(problems), len(problems))


def _on_case(name: str) -> Problem:
    return dataclasses.replace(Case.read(ROOT / "cases" / f"{name}.toml").problem, numerics=Numerics((64, 64)))


def _moving(problem: Problem, **motion: float) -> Problem:
    return dataclasses.replace(problem, motion=dataclasses.replace(problem.motion, **motion))


def _table(side: int, accuracy: float) -> Row:
    axes = Axes((1.0,), 8, 5, 9)
    ellipse = EllipseSolver(axes.aspect_ratios[0], 0.28, accuracy)
    creepages = axes.scaled(0, axes.points) / np.array(ellipse.scales)[:, None]
    # As in a sweep: along the magnitude, each point started from the one before it.
    order = np.arange(axes.points).reshape(axes.magnitudes - 1, -1).T[::3].ravel()
    problem = dataclasses.replace(ellipse.problem, numerics=Numerics((side, side)))
    unit, turn = ellipse.unit_creepages
    problems = [dataclasses.replace(problem, motion=Motion(1.0, x * unit, y * unit, z * turn, differential_slip=False))
                for x, y, z in creepages[:, order].T]
    return Row(f"point of a table of creep forces, N = {side}", "point of a sweep", partial(ellipse.solve, creepages),
               partial(_in_order, problems), creepages.shape[1], len(problems))

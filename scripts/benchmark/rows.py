"""Cost of features beside the plain way, in turn in one process. A new comparison is a function here and its name in `ROWS`."""

from __future__ import annotations

import dataclasses
import itertools
import math
import statistics
from collections.abc import Callable, Collection, Iterable
from functools import partial
from typing import Any

import numpy as np

from scripts.benchmark.cases import HOT, ROOT, log, problem_of, seconds
from thermoroll_cli import Case
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.physics.contact.contact_scales import contact_scales
from thermoroll_cli.problem.problem import Heating, Numerics, Problem, Strength, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver, solve
from thermoroll_cli.studies.worn.evolution import evolution

PARTLY_SLIDING = 2e-3
"""Creepage of the twin disc at which part of the contact sticks."""
STRENGTH = Strength(300e6, 0.3)


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


def sweep_of_hot_loads() -> Row:
    """20 loads of the coupled case."""
    problem = problem_of(HOT, 64)
    return _swept("20 loads, coupled", [dataclasses.replace(problem, normal_force=problem.normal_force * float(f))
                                        for f in np.linspace(0.7, 1.3, 20)])


def sweep_of_hot_creepages() -> Row:
    """20 creepages of the coupled case."""
    problem = problem_of(HOT, 64)
    return _swept("20 creepages, coupled", [_moving(problem, creepage_x=(problem.motion.creepage_x or 0.0) * float(f))
                                            for f in np.linspace(0.3, 1.5, 20)])


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


def sweep_of_creepages() -> Row:
    """60 creepages up to full sliding, isothermal."""
    problem = problem_of("article_3_1_case_1", 64)
    last = 2.0 * (problem.motion.creepage_x or 0.0)
    return _swept("60 creepages, isothermal", [_moving(problem, creepage_x=float(c)) for c in last / 60 * np.arange(1, 61)])


def sweep_of_wear() -> Row:
    """The first steps of wear of a twin disc that slides in part, each of 2 % of the approach."""
    problem = Case.read(ROOT / "cases" / "twin_disc_wear.toml").problem
    wear = dataclasses.replace(problem.wear, step_fraction=0.02, depth=math.inf, distance=math.inf)  # type: ignore[type-var]
    problem = dataclasses.replace(_moving(problem, creepage_x=PARTLY_SLIDING), numerics=Numerics((64, 64)), wear=wear)
    states = itertools.islice(evolution(problem), 20)
    return _swept("20 steps of wear", [state.result.problem for state in states if state.result is not None])


def heat() -> Row:
    """Heat that deforms the contact."""
    problem = problem_of(HOT, 128)
    isothermal = dataclasses.replace(problem, heating=Heating(heat=False, deformation=False))
    return Row("heat and thermal deformation, N = 128", "isothermal", partial(solve, problem), partial(solve, isothermal))


def line() -> Row:
    """A pair of teeth beside the article's contact, both without heat."""
    teeth = Case.read(ROOT / "cases" / "gear_pair.toml").problem
    return Row("line contact, 128 elements", "isothermal case of the article, N = 64", partial(solve, teeth),
               partial(solve, problem_of("article_3_1_case_1", 64)))


def hot_line() -> Row:
    """The same pair where heat deforms it, beside the article's coupled case."""
    problem = problem_of(HOT, 64)
    teeth = dataclasses.replace(Case.read(ROOT / "cases" / "gear_pair.toml").problem, lower=problem.lower, upper=problem.upper,
                                heating=Heating(heat=True, deformation="always"))
    return Row("line contact with heat and thermal deformation, 128 elements", "coupled case of the article, N = 64",
               partial(solve, teeth), partial(solve, problem))


def subsurface() -> Row:
    """Stresses and temperatures below the surface."""
    problem = dataclasses.replace(Case.read(ROOT / "cases" / "hot_sliding.toml").problem, numerics=Numerics((64, 64)))
    return Row("stresses and temperatures below the surface, N = 64", "surface only",
               partial(solve, problem), partial(solve, dataclasses.replace(problem, subsurface=None)))


def strength() -> Row:
    """Shakedown, alternating plasticity and Dang Van stress of both bodies in 28 layers."""
    problem = dataclasses.replace(Case.read(ROOT / "cases" / "hot_sliding.toml").problem, numerics=Numerics((128, 128)))
    request = SubsurfaceRequest(layers=28)
    strong = dataclasses.replace(request, lower_strength=STRENGTH, upper_strength=STRENGTH)
    return Row("stresses in 28 layers with shakedown and fatigue, N = 128", "stresses alone",
               partial(solve, dataclasses.replace(problem, subsurface=strong)),
               partial(solve, dataclasses.replace(problem, subsurface=request)))


def friction_law() -> Row:
    """Friction that falls with slip, with memory, through a layer of dirt."""
    problem = _on_case("eurosprinter", 128)
    problems = [_moving(problem, creepage_x=float(c)) for c in np.geomspace(1e-3, 2e-2, 8)]
    constant = [dataclasses.replace(one, friction=dataclasses.replace(one.friction, law=None)) for one in problems]
    return Row("friction law with memory, N = 128", "constant friction", partial(_alone, problems),
               partial(_alone, constant), len(problems), len(problems))


def heat_through_layers() -> Row:
    """A bonded coating with heat, which divides between the bodies."""
    problem = _on_case("coated_ball_heat", 128)
    plain = {name: dataclasses.replace(getattr(problem, name), layers=()) for name in ("lower", "upper")}
    return Row("heat through layers, N = 128", "without layers", partial(solve, problem),
               partial(solve, dataclasses.replace(problem, **plain)))


def layers() -> Row:
    """A bonded coating."""
    problem = dataclasses.replace(_on_case("coated_ball", 128), subsurface=None)
    plain = {name: dataclasses.replace(getattr(problem, name), layers=()) for name in ("lower", "upper")}
    return Row("bodies with layers, N = 128", "without layers", partial(solve, problem),
               partial(solve, dataclasses.replace(problem, **plain)))


def stresses_in_layers() -> Row:
    """Stresses inside a coated body."""
    problem = _on_case("coated_ball", 128)
    return Row("stresses in a body with layers, N = 128", "without layers", partial(solve, problem),
               partial(solve, dataclasses.replace(problem, upper=dataclasses.replace(problem.upper, layers=()))))


def conformal() -> Row:
    """A ball in a groove, on the curved common surface."""
    text = (ROOT / "cases" / "ball_in_groove.toml").read_text()
    curved, plane = (dataclasses.replace(Case.parse(text.replace("conformal = true", f"conformal = {flag}")).problem,
                                         numerics=Numerics((128, 128))) for flag in ("true", "false"))
    return Row("conformal contact, N = 128", "in a plane", partial(solve, curved), partial(solve, plane))


def wheelset() -> Row:
    """Both wheels of the Manchester benchmark, whose place and loads are found, beside the last states of the patches."""
    task = Case.read(ROOT / "cases" / "manchester.toml").task
    assert isinstance(task, WheelsetProblem)
    patches = [patch.problem for patch in solve_wheelset(task).contacts]
    return Row(f"wheelset with {len(patches)} patches, N = 48", "its patches alone", partial(_found, task),
               partial(_alone, patches))


def wheel() -> Row:
    """One wheel with two patches, which are found and share the load, beside these patches alone."""
    task = Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "wheelset.wheels": "right", "wheelset.lateral_shift_mm": 5.0, "wheelset.yaw_mrad": 12.0, "wheelset.roll_mrad": -0.32,
        "wheelset.angular_velocity_rad_s": 4.344, "wheelset.vertical_N": 10e3}).task
    assert isinstance(task, WheelsetProblem)
    patches = [patch.problem for patch in solve_wheelset(task).patches]
    return Row(f"a wheel with {len(patches)} patches, N = 48", "its patches alone", partial(_found, task),
               partial(_alone, patches))


ROWS: list[Callable[[], Row]] = [
    sweep, sweep_of_hot_loads, sweep_of_hot_creepages, sweep_of_loads, sweep_of_rails, sweep_of_creepages, sweep_of_wear,
    heat, line, hot_line, heat_through_layers, subsurface, strength, friction_law, layers, stresses_in_layers,
    conformal, wheelset, wheel]


def measure(runs: int, only: Collection[str] = ()) -> list[dict[str, Any]]:
    """Milliseconds per point of both ways, medians, and the ratios of single runs: median, least, largest; of the rows `only`,
    by the names of their functions, if there are any."""
    out = []
    for make in ROWS:
        if only and make.__name__ not in only:
            continue
        row = make()
        # Buffers and imports of a first call belong to no measurement.
        applications = [_applications(row.work()), _applications(row.plain())]
        pairs = [(seconds(row.work) / row.points, seconds(row.plain) / row.plain_points) for _ in range(runs)]
        ratios = [one / other for one, other in pairs]
        out.append({"name": row.name, "beside": row.beside, "ms": 1e3 * statistics.median(one for one, _ in pairs),
                    "beside_ms": 1e3 * statistics.median(other for _, other in pairs),
                    "applications": applications[0] / applications[1] if all(applications) else None,
                    "ratio": statistics.median(ratios), "least": min(ratios), "largest": max(ratios)})
        log(f"  {out[-1]}")
    return out


def _found(task: WheelsetProblem) -> object:
    contact_scales.cache_clear()
    return solve_wheelset(task)


def _applications(found: object) -> int:
    """Applications of the operator of rolling in one or several results; 0 where there are none."""
    results = found if isinstance(found, list) else [found]
    return sum(level["applications"] + level.get("coupled_applications", 0)
               for one in results if isinstance(one, Result) for level in one.work.get("levels", ()))


def _in_order(problems: Iterable[Problem]) -> list[Result]:
    contact_scales.cache_clear()
    solver = Solver()
    return [solver.solve(problem) for problem in problems]


def _alone(problems: Iterable[Problem]) -> list[Result]:
    contact_scales.cache_clear()
    return [solve(problem) for problem in problems]


def _swept(what: str, problems: list[Problem]) -> Row:
    return Row(f"point of a sweep over {what}, N = 64", "the same points from nothing", partial(_in_order, problems),
               partial(_alone, problems), len(problems), len(problems))


def _on_case(name: str, side: int = 64) -> Problem:
    return dataclasses.replace(Case.read(ROOT / "cases" / f"{name}.toml").problem, numerics=Numerics((side, side)))


def _moving(problem: Problem, **motion: float) -> Problem:
    return dataclasses.replace(problem, motion=dataclasses.replace(problem.motion, **motion))

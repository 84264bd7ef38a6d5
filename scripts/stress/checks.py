"""What must hold of any result: checked on its fields, by other means than the program's own checks."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.random_cases import BELOW_LIMIT
from tests.support.errors import relative
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.physics.contact.shear_coupling import NormalShearCoupling
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.names import known_as
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.python_api import Solver, solve

LOAD = 2e-6
COULOMB = 2e-4
COULOMB_ELEMENT = 2e-3
DIRECTION = 2e-3
BALANCE = 1e-5
FULL_FRICTION, SLIP_RESOLVED = 0.5, 16
"""Power that friction could take beyond the one that it takes, and elements per side, half of them loaded, from which this
holds: the slip of coarser grids is one row of elements, which stick in part."""
RELAXING_BALANCE = 0.1
"""The same for bodies that relax, whose power follows from the gap: of few elements, and with narrow slip zones."""
COLD = 1e-4
"""How far below zero a temperature may come out, over its peak: where bodies divide their heat, elements outside miss zero."""
GAP = 1e-6
FORCE = 2e-5
FORCES = ("force_x_N", "force_y_N")
STARTS = {"sticking": 0.1, "sliding": 10.0}
"""Creepages of other starts, over those of the case."""
ROUNDING = 2e-5
"""Twice the tolerance of the solvers: less is no difference."""


def solved(problem: Problem, *checks: Callable[[Result], Iterable[str]]) -> Outcome:
    """Solve `problem` and look for `violations`, and for what further `checks` find wrong. It is excused if there is more heat
    than a steady state below the thermo-elastic limit has, or a force above the maximum of the creep curve, or above what
    friction across the contact carries."""
    result = solve_to_check(problem)
    broken = [*violations(result), *(fault for check in checks for fault in check(result))]
    excused = bulges(result) or "no steady state carries" in result.reason or carries_less(result)
    return Outcome(result.converged, result.reason, excused, tuple(broken), result.work["levels"][-1]["applications"])


def solve_to_check(problem: Problem) -> Result:
    """Solve `problem`. A creepage found for a force is that of the finest grid, as all fields are, and not extrapolated: only
    then is its work the heat of these fields, to rounding."""
    forced = problem.motion.force_x is not None or problem.motion.force_y is not None
    return solve(problem, options=SolverOptions(extrapolated=not forced))


def violations(result: Result) -> list[str]:
    """Invariants that `result` breaks. Only a converged result must keep those of the physics; none may be without a
    reason or hold a nan."""
    found = [] if result.converged or result.reason else ["not converged, without a reason"]
    for name, state in (("coupled", result.coupled), ("isothermal", result.isothermal)):
        found += [f"{name}: {what}" for what in _not_finite(state)]
        if result.converged and not found:
            found += [f"{name}: {what}" for what in _broken(result, state)]
    json.dumps(result.summary())
    return found


def bulges(result: Result) -> bool:
    """Whether the heat of the state without deformation would bulge by more than a case below the limit may: the plan's bound
    can be too low for dissimilar bodies, whose pressure alone makes them slip."""
    scalars, approach = result.isothermal.scalars, 1e6 * DerivedQuantities(result.problem).scales.approach
    return bool(result.problem.heating.deformation
                and scalars["thermal_displacement_max_um"] > BELOW_LIMIT * scalars.get("approach_um", approach))  # fmt: skip


def carries_less(result: Result) -> bool:
    """Whether friction across the contact carries less than the prescribed force, Σ μ₀ m(y) p dA, under a pressure that is
    right: it carries the load."""
    problem, across = result.problem, result.problem.friction.across
    if not across or not problem.prescribed_force:
        return False
    grid, pressure = _grid(result.coupled), result.coupled.fields["pressure"]
    load = float((pressure * np.cos(problem.geometry.inclination(grid.y))).sum()) * grid.element_area
    places, shares = zip(*across, strict=True)
    carried = problem.friction.coefficient * float((np.interp(grid.y, places, shares) * pressure).sum()) * grid.element_area
    return abs(load / problem.normal_force - 1.0) < LOAD and problem.prescribed_force > carried


def patches(result: Result) -> Iterator[str]:
    """All patches together carry the load, each some of it, and they lie in order."""
    share = sum(patch["normal_N"] for patch in result.records) / result.problem.normal_force
    if abs(share - 1.0) >= LOAD:
        yield f"patches carry {share:.7f} of the load"
    places = [patch["y_mm"] for patch in result.records]
    if not places or places != sorted(places) or min(patch["normal_N"] for patch in result.records) <= 0.0:
        yield "patches without load or order"


SHIFTED = ("force_x_N", "force_y_N", "Q_F_W", "gamma_st", "pressure_max_MPa", "contact_area_mm2")


def same_elsewhere(pair: tuple[Problem, Problem]) -> Outcome:
    """The second contact is the first one at another place across rolling."""
    here, there = pair
    return solved(there, lambda result: differences(result, solve_to_check(here), SHIFTED))


def narrow(result: Result) -> Iterator[str]:
    """The largest pressure is that of a patch, and has no estimate if this patch is narrower than three elements."""
    scalars, parts = result.coupled.scalars, [patch["pressure_max_MPa"] for patch in result.records]
    if abs(scalars["pressure_max_MPa"] / max(parts) - 1.0) >= ROUNDING:
        yield f"largest pressure {scalars['pressure_max_MPa']:.6g} MPa, of the patches {max(parts):.6g} MPa"
    pressure, few = result.coupled.fields["pressure"], 3
    loaded = (pressure > 0.0).any(axis=0)
    around = np.convolve(loaded, np.ones(few), "valid") == few  # three columns in a row
    wide = np.convolve(around, np.ones(few)) > 0.0
    if not wide[pressure.max(axis=0).argmax()] and not math.isnan(relative(result)["pressure_max_MPa"]):
        yield "a largest pressure of one or two elements has an estimate"


def distinct(result: Result) -> Iterator[str]:
    """From a contact that sticks and from one that slides the forces must be the same."""
    problem, motion = result.problem, result.problem.motion
    if not result.converged or problem.prescribed_force:
        return
    for start, factor in STARTS.items():
        solver = Solver()
        creepages = {name: factor * (getattr(motion, name) or 0.0) for name in ("creepage_x", "creepage_y", "spin")}
        solver.solve(replace(problem, motion=replace(motion, **creepages)))
        yield from (f"started {start}: {what}" for what in differences(solver.solve(problem), result, FORCES))


def differences(result: Result, alone: Result, names: Iterable[str] = ()) -> Iterator[str]:
    """Which of `names`, or of all, in `result`, which depends on problems before it, differ from those of `alone` by more than
    both estimates: a grid may have several solutions, each as far from the truth as its estimate says."""
    if result.converged != alone.converged:
        yield f"converged {result.converged}, alone {alone.converged}"
    if not (result.converged and alone.converged):
        return
    warm, cold = result.summary(), alone.summary()
    for name in (known_as(each, cold) for each in names or alone.coupled.scalars):
        scale, estimate = error_scale(name, cold), relative(alone)[name] + relative(result)[name]
        if not (scale > 0.0 and math.isfinite(estimate)):
            continue
        size = abs(warm[name] - cold[name]) / scale
        if not size <= max(estimate, ROUNDING):
            yield f"{name} differs by {size:.2g} of its scale, estimate {estimate:.2g}"


def _not_finite(state: State) -> list[str]:
    return [f"{name} is not finite" for name, values in state.fields.items() if not np.isfinite(values).all()]


def _broken(result: Result, state: State) -> list[str]:
    problem, scalars, grid = result.problem, state.scalars, _grid(state)
    fields, found = {name: values.reshape(grid.shape) for name, values in state.fields.items()}, []

    def hold(what: str, excess: float, allowed: float) -> None:
        if not excess <= allowed:
            found.append(f"{what}: {excess:.3g} > {allowed:.3g}")

    pressure = fields["pressure"]
    traction = np.stack([fields["shear_x"], fields["shear_y"]])
    slip = np.stack([fields["slip_x"], fields["slip_y"]]) / problem.motion.speed
    flux = fields["heat_flux"] / problem.motion.speed
    shear, speed = np.hypot(*traction), np.hypot(*slip)
    friction = fields.get("friction_coefficient", problem.friction.coefficient)
    hold("pressure < 0", float(-pressure.min()), 0.0)
    hold("gap < 0", float(-fields["gap"].min()) / DerivedQuantities(problem).scales.approach, GAP)
    carried = pressure * np.cos(problem.geometry.inclination(grid.y))
    # At a given approach each state has its own load.
    load = problem.normal_force if problem.approach is None else scalars["normal_N"]
    hold("load", abs(float(carried.sum()) * grid.element_area / load - 1.0), LOAD)
    bound = friction * pressure
    excess = np.maximum(shear - bound, 0.0)
    hold("Coulomb", float(np.linalg.norm(excess)), COULOMB * float(np.linalg.norm(bound)))
    hold("Coulomb in one element", float(excess.max()), COULOMB_ELEMENT * float(bound.max()))
    rubbed = float((shear * speed).sum())
    spanned = min(int(np.count_nonzero((pressure > 0.0).any(axis=1 - axis))) for axis in range(len(grid.sides)))
    if min(*grid.sides, 2 * spanned) >= SLIP_RESOLVED:
        hold("friction not reached in slip", float((bound * speed).sum()) - rubbed, FULL_FRICTION * rubbed)
    work, dissipated = _work(problem, state, grid, traction, pressure), float(flux.sum()) * grid.element_area
    scale = max(rubbed * grid.element_area, abs(work), dissipated)
    hold("slip across the traction", (rubbed - float((traction * slip).sum())) * grid.element_area, DIRECTION * scale)
    hold("heat flux < 0", float(-flux.min()), 0.0)
    if problem.relaxes:
        hold("power of forces and resistance", scalars["power_balance_error"], RELAXING_BALANCE)
        hold("resistance < 0", -scalars[known_as("rolling_resistance_N", scalars)], 0.0)
    else:
        hold("power balance", abs(dissipated - work), BALANCE * max(abs(work), dissipated))
    # Between passes a track may get colder than its mean, and that colder than what surrounds the body.
    if not problem.heating.conducts and not problem.heating.recirculates:
        for body in ("lower", "upper"):
            rise = fields.get(f"temperature_rise_{body}")
            if rise is not None:
                hold(f"temperature of the {body} body < 0", float(-rise.min()), COLD * float(rise.max()))
    force = traction.sum(axis=(1, 2)) * grid.element_area
    for axis, got, wanted in zip("xy", force, (problem.motion.force_x, problem.motion.force_y), strict=True):
        if wanted is not None:
            hold(f"force along {axis}", abs(got - wanted), FORCE * problem.traction_limit)
        name = known_as(f"force_{axis}_N", scalars)
        if not math.isfinite(scalars[name]):
            found.append(f"{name} is {scalars[name]}")
    return found


def _work(problem: Problem, state: State, grid: Grid, traction: np.ndarray, pressure: np.ndarray) -> float:
    """Power over V that the motion puts in: ξ·F + ξ_φ M_z, what differential slip adds, and for dissimilar bodies what the
    pressure's moment does."""
    motion = problem.motion
    derived = DerivedQuantities(problem)
    slip = derived.kinematics.rigid_slip(grid)
    slip[0] += state.scalars["creepage_longitudinal"] if motion.creepage_x is None else 0.0
    slip[1] += state.scalars["creepage_lateral"] if motion.creepage_y is None else 0.0
    if derived.dissimilar:
        coupling = NormalShearCoupling(grid, derived.bodies)
        slip -= coupling.tangential_gradient(pressure)
    return float((traction * slip).sum()) * grid.element_area


def _grid(state: State) -> Grid:
    """The grid of a state; that of a line contact has one element across, without ends."""
    (nx, dx, centre_x), (ny, dy, centre) = (
        (axis.size, float(axis[-1] - axis[0]) / (axis.size - 1), float(axis[0] + axis[-1]) / 2) if axis.size
        else (1, math.inf, 0.0) for axis in (state.x, state.y))
    return Grid(nx, ny, dx, dy, centre, centre_x)

"""Friction that falls with the temperature of the contact: law, fixed point, limits, cost, case file."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scripts.stress.populations import POPULATIONS
from tests.support.cases import parse
from tests.support.command_line import THERMAL
from tests.support.scenes import article_4_1, on_grid, order, reference, rolling, saturation, solved
from thermoroll_cli.files.case import Case
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.physics.halfspace.thermal import temperature_table
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.friction import Friction, Interlayer
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver, solve

K = 50.2
AT_REST = Heating(peclet="stationary", deformation=False)


def falling(problem: Problem, slope: float, minimum: float = 0.1) -> Problem:
    return changed(problem, slope=slope, minimum=minimum)


def changed(problem: Problem, **friction: float) -> Problem:
    return replace(problem, friction=replace(problem.friction, **friction))


def warm(grid: int = 16, slope: float = 5e-3, minimum: float = 0.1, **changes) -> Problem:
    """Spheres at ξ = 0.003 that get about 25 K warm with constant friction (heat acts on the friction alone)."""
    return falling(
        rolling(grid=grid, **{"creepage": (0.003, 0.0), "speed": 20.0, "heating": AT_REST, **changes}), slope, minimum
    )


def hot(grid: int = 16, slope: float = 1e-3) -> Problem:
    """The article's hot case at half its heat: friction and shape both change."""
    return falling(replace(article_4_1(grid), motion=Motion(100.0, 0.003, 0.0)), slope)


def mean_temperature(result, state) -> np.ndarray:
    heating = result.problem.heating
    rises = state.fields["temperature_rise_lower"] + state.fields["temperature_rise_upper"]
    return 0.5 * (rises + heating.bulk_lower + heating.bulk_upper)


def states(result):
    return {id(s): s for s in (result.coupled, result.isothermal)}.values()


# --- the law ------------------------------------------------------------------------------------------------------


def test_the_law():
    """μ₀ (1 − sT) between a floor and μ₀."""
    problem = falling(rolling(), 2e-3, 0.25)
    np.testing.assert_allclose(
        problem.friction.at(np.array([-50.0, 0.0, 100.0, 375.0, 1e4])), 0.3 * np.array([1.0, 1.0, 0.8, 0.25, 0.25])
    )
    assert warm().friction_varies and not warm(slope=0.0).friction_varies
    assert not warm(friction=0.0).friction_varies and not replace(warm(), heating=Heating(heat=False)).friction_varies


def test_threshold_floor_and_a_slope_of_either_sign():
    """Unchanged up to a temperature, then falling to a floor or rising to a ceiling."""
    temperatures = np.array([-50.0, 0.0, 100.0, 150.0, 200.0, 1e4])
    fading = changed(falling(rolling(), 2e-3, 0.4), start=100.0)
    np.testing.assert_allclose(fading.friction.at(temperatures), 0.3 * np.array([1.0, 1.0, 1.0, 0.9, 0.8, 0.4]))
    rising = changed(fading, slope=-2e-3, maximum=1.5)
    np.testing.assert_allclose(rising.friction.at(temperatures), 0.3 * np.array([1.0, 1.0, 1.0, 1.1, 1.2, 1.5]))


def test_friction_that_rises_makes_more_heat():
    constant, rising = solved(warm(slope=0.0)), solve(changed(warm(), slope=-5e-3, maximum=1.3))
    assert rising.converged, rising.reason
    friction = rising.coupled.fields["friction_coefficient"]
    inside = rising.coupled.fields["state"] > 0
    assert friction[inside].min() >= 0.3 and 0.31 < friction[inside].max() <= 0.39 + 1e-12
    assert rising.coupled.scalars["Q_F_W"] > 1.02 * constant.coupled.scalars["Q_F_W"]
    assert rising.coupled.scalars["force_x_N"] > constant.coupled.scalars["force_x_N"]


@pytest.mark.parametrize("base", [hot(slope=0.0)])
def test_without_a_slope_nothing_changes_and_nothing_costs(base):
    result, other = solve(base), solve(changed(base, minimum=0.7))
    for name, field in result.coupled.fields.items():
        np.testing.assert_array_equal(field, other.coupled.fields[name])
    assert "friction_coefficient" not in result.coupled.fields
    assert result.work["iterations"] == other.work["iterations"]
    assert result.work["levels"] == other.work["levels"]
    plan = make_plan(base)
    assert "warm friction" not in plan.run and "warm friction" not in plan.skipped


# --- the fixed point ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("problem", [warm(), hot(), warm(slope=0.03), warm(heating=Heating(deformation=False), speed=500.0)])
def test_friction_belongs_to_the_temperature_of_the_result(problem):
    """Both states: μ = μ(T) to 2e-4, |τ| ≤ μp with the local μ, reached where it slips, heat in balance."""
    result = solved(problem)
    assert result.converged, result.reason
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    for state in states(result):
        f = state.fields
        inside, slipping = f["state"] > 0, f["state"] == 2
        friction, expected = f["friction_coefficient"], problem.friction.at(mean_temperature(result, state))
        assert np.abs(friction - expected)[inside].max() < 2e-4 * problem.friction.coefficient
        assert not friction[~inside].any() and friction.min() >= 0.0
        assert friction[inside].min() < 0.97 * problem.friction.coefficient
        bound, shear = friction * f["pressure"], np.hypot(f["shear_x"], f["shear_y"])
        assert (shear - bound).max() < 1e-3 * bound.max()
        np.testing.assert_allclose(shear[slipping], bound[slipping], atol=1e-3 * bound.max())
        assert shear.sum() * area < friction[inside].max() * problem.normal_force
    if result.coupled is not result.isothermal:
        assert result.coupled.scalars["force_x_N"] < result.isothermal.scalars["force_x_N"]


def test_full_sliding_is_a_linear_problem():
    """Far beyond saturation τ = μp and q = μpVξ: μ = μ₀ − μ₀ s K (½ pVξ μ) with the temperature table K, solved densely."""
    base = warm(grid=16, slope=3e-2, speed=0.02)
    creepage = 500.0 * saturation(base).creepage
    result = solve(replace(base, motion=Motion(0.02, creepage, 0.0)))
    grid = Grid(16, 16, result.x[1] - result.x[0], result.y[1] - result.y[0])
    f = result.coupled.fields
    pressure = f["pressure"].ravel()
    table = temperature_table(16, 16, grid.dy / grid.dx, 0.0) * grid.dx / K
    i, j = np.divmod(np.arange(256), 16)
    influence = table[i[:, None] - i[None, :] + 15, j[:, None] - j[None, :] + 15]
    matrix = np.eye(256) + base.friction.coefficient * base.friction.slope * influence * (0.5 * pressure * 0.02 * creepage)
    exact = np.linalg.solve(matrix, np.full(256, base.friction.coefficient)).reshape(16, 16)
    inside = f["state"] > 0
    assert exact[inside].min() < 0.8 * base.friction.coefficient
    np.testing.assert_allclose(f["friction_coefficient"][inside], exact[inside], rtol=5e-3)
    assert result.coupled.scalars["force_x_N"] == pytest.approx(
        float((exact * f["pressure"]).sum()) * grid.element_area, rel=3e-3
    )


@pytest.mark.slow
def test_steeper_slopes_give_less_force_and_heat_down_to_the_floor():
    slopes = [0.0, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]
    results = [solved(warm(slope=s, minimum=0.4)) for s in slopes]
    assert all(r.converged for r in results), [r.reason for r in results]
    forces = np.array([r.coupled.scalars["force_x_N"] for r in results])
    heats = np.array([r.coupled.scalars["Q_F_W"] for r in results])
    assert (np.diff(forces) < 0.0).all() and (np.diff(heats) < 0.0).all()
    least = solved(warm(slope=0.0, friction=0.4 * 0.3)).coupled.scalars
    assert forces[-1] == pytest.approx(least["force_x_N"], rel=1e-3)
    f = results[-1].coupled.fields
    assert f["friction_coefficient"][f["state"] > 0].min() == pytest.approx(0.4 * 0.3, rel=1e-12)


def test_first_order_in_the_slope():
    """dF/ds by a small slope from both ends: F(s) − F(0) is linear, as the friction lost is s μ₀ ∫ pT over the slip area."""
    forces = [solved(warm(grid=32, slope=s)).coupled.scalars["force_x_N"] for s in (0.0, 1e-4, 2e-4)]
    assert forces[2] - forces[0] == pytest.approx(2.0 * (forces[1] - forces[0]), rel=0.02)
    f = solved(warm(grid=32, slope=0.0)).coupled
    slipping = f.fields["state"] == 2
    lost = (f.fields["pressure"] * f.fields["temperature_rise_lower"])[slipping].sum()
    area = (2.2 / 32) ** 2 * np.prod([solved(warm(grid=32, slope=0.0))[k] * 1e-3 for k in ("hertz_a_mm", "hertz_b_mm")])
    # Less traction in the slip area lets the stick area grow and carry a little more: not all is lost.
    assert 0.8 < (forces[0] - forces[1]) / (1e-4 * 0.3 * lost * area) < 1.05


@pytest.mark.slow
def test_cost():
    """Outer iterations of friction alone ≤ 8; with deformation at most 4 more than without falling friction."""
    assert solved(warm(grid=32)).work["iterations"]["warm_friction_iterations"] <= 8
    cold, falls = solved(hot(32, 0.0)).work, solved(hot(32)).work
    assert falls["iterations"]["coupling_iterations"] <= cold["iterations"]["coupling_iterations"] + 4
    assert falls["applications"] <= 3.0 * cold["applications"]


def test_converges_with_the_grid():
    sides = [16, 32]
    forces = [solved(warm(grid=n)).coupled.scalars["force_x_N"] for n in [*sides, 64]]
    assert abs(forces[1] / forces[-1] - 1.0) < 2e-3
    assert order(sides, np.array(forces[:-1]) / forces[-1] - 1.0) > 0.8


# --- around it ----------------------------------------------------------------------------------------------------


def test_warm_bodies_have_less_friction_before_any_heat():
    """Bulk temperatures of 80 and 120 K on a slope of 1e-3 take a tenth of the friction; slow rolling adds no heat."""
    heating = replace(AT_REST, bulk_lower=80.0, bulk_upper=120.0)
    slow = warm(slope=1e-3, speed=1e-6, heating=heating)
    tenth = warm(slope=0.0, speed=1e-6, friction=0.27)
    for name in ("force_x_N", "gamma_st", "shear_max_MPa"):
        assert solved(slow).coupled.scalars[name] == pytest.approx(solved(tenth).coupled.scalars[name], rel=2e-4)
    cold = replace(slow, heating=replace(heating, bulk_lower=-80.0, bulk_upper=-120.0))
    assert solved(cold).coupled.scalars["force_x_N"] == pytest.approx(
        solved(warm(slope=0.0, speed=1e-6)).coupled.scalars["force_x_N"], rel=2e-4
    )


def test_a_prescribed_force_takes_more_creepage_when_friction_varies():
    given = {"creepage": (None, 0.0), "force": (12.0, None)}
    cool, warmed = solved(warm(slope=0.0, **given)), solved(warm(slope=0.01, **given))
    assert warmed.converged, warmed.reason
    assert warmed.coupled.scalars["force_x_N"] == pytest.approx(12.0, rel=1e-5)
    assert warmed.coupled.scalars["creepage_longitudinal"] > 1.02 * cool.coupled.scalars["creepage_longitudinal"]


def test_friction_that_falls_below_the_prescribed_force_is_explained():
    """Bulk temperatures alone take half of the friction: 15 N of 19.5 N can no longer be carried."""
    heating = replace(AT_REST, bulk_lower=100.0, bulk_upper=100.0)
    result = solve(warm(grid=16, slope=5e-3, heating=heating, creepage=(None, 0.0), force=(15.0, None)))
    assert not result.converged
    assert "it carries 9.75 N, less than the prescribed 15 N" in result.reason


@pytest.mark.slow
def test_a_failed_iteration_is_no_bound_of_the_force():
    """The creep curve of this contact reaches 29.6 of 30 N; the friction of the iteration that fails at 29.99 N is lower."""
    problem = falling(rolling(grid=16, geometry=Geometry(0.02, 0.02, 0.02, 0.03), load=100.0, creepage=(None, 5e-4),
                              force=(29.99, None), speed=10.0, heating=Heating()), 0.004)
    result = solve(problem)
    assert not result.converged and "not the largest force that has a steady state" in result.reason
    assert solve(replace(problem, motion=replace(problem.motion, force_x=29.0))).converged


def test_several_steady_states_are_warned_of():
    """Friction that rises steeply with temperature: from below and from above the same problem ends in two states. Where a
    change of friction comes back smaller there is one, and no warning."""
    base = rolling(grid=10, geometry=Geometry(0.02, 0.02, 0.02, 0.03), load=100.0, creepage=(0.05, 0.0), speed=34.0,
                   heating=Heating(deformation=False))

    def states(slope: float) -> list[Result]:
        steep = changed(base, slope=slope, start=60.0, maximum=4.0)
        found = []
        for speeds in ((30.0, 34.0), range(58, 33, -4)):
            solver = Solver()
            found.append([solver.solve(replace(steep, motion=replace(steep.motion, speed=float(v)))) for v in speeds][-1])
        assert all(result.converged for result in found)
        return found

    for slope, several in ((-2.0, True), (-0.01, False)):
        up, down = states(slope)
        apart = abs(down.coupled.scalars["force_x_N"] - up.coupled.scalars["force_x_N"])
        assert (apart > 1.0) == several
        assert all(any("several steady states" in w for w in result.warnings) == several for result in (up, down))


def test_mirror_images_and_scale():
    base = replace(warm(grid=12), motion=Motion(20.0, 0.002, 0.001, 3.0))
    here = solved(base).coupled
    there = solved(replace(base, motion=Motion(20.0, 0.002, -0.001, -3.0))).coupled
    for name in ("friction_coefficient", "heat_flux"):
        np.testing.assert_allclose(there.fields[name][:, ::-1], here.fields[name], atol=1e-3 * here.fields[name].max())
    geometry = replace(base.geometry, **{k: 8.0 * v for k, v in vars(base.geometry).items() if v and isinstance(v, float)})
    large = replace(base, geometry=geometry, normal_force=64.0 * 65.0, motion=Motion(2.5, 0.002, 0.001, 3.0 / 8.0))
    for name in ("gamma_st", "temperature_rise_max_lower_K", "creepage_longitudinal"):
        assert solved(large).coupled.scalars[name] == pytest.approx(here.scalars[name], rel=1e-8)


@pytest.mark.slow
def test_a_sweep_of_the_slope_goes_through_zero():
    solver = Solver()
    for slope in (1e-3, 0.0, 2e-3):
        swept, fresh = solver.solve(hot(24, slope)), solved(hot(24, slope))
        assert swept.coupled.scalars["force_x_N"] == pytest.approx(fresh.coupled.scalars["force_x_N"], rel=3e-4)
        assert ("friction_coefficient" in swept.coupled.fields) == (slope > 0.0)


def assert_friction_goes_with_temperature(problem):
    result = solved(problem)
    assert result.converged, result.reason
    f = result.coupled.fields
    inside = f["state"] > 0
    expected = problem.friction.at(mean_temperature(result, result.coupled))
    assert np.abs(f["friction_coefficient"] - expected)[inside].max() < 3e-4 * problem.friction.coefficient


def test_dissimilar_bodies_with_falling_friction_and_matched_heat():
    ceramic = Material(300e9, 0.28, 20.0, 3e-6, 8e-6)
    heating = Heating(partition="matched", deformation=True, bulk_upper=30.0)
    problem = replace(falling(article_4_1(16, heating=heating), 2e-3), upper=ceramic, motion=Motion(60.0, 0.003, 0.0))
    assert_friction_goes_with_temperature(problem)


@pytest.mark.slow
def test_heat_that_travels_with_the_slip():
    problem = falling(replace(article_4_1(16, heating=Heating(peclet="sliding")), motion=Motion(100.0, 0.003, 0.0)), 5e-3)
    assert_friction_goes_with_temperature(problem)


# --- plan, case file, command line --------------------------------------------------------------------------------


def test_the_plan_says_so():
    assert "warm friction" in make_plan(warm()).run
    assert "no friction and heat" in make_plan(replace(warm(), heating=Heating(heat=False))).skipped["warm friction"]
    assert "no friction and heat" in make_plan(warm(creepage=(0.0, 0.0))).skipped["warm friction"]


def test_keys_of_the_case_file():
    case = parse(THERMAL, "friction.temperature_slope_1_K=2e-3", "friction.temperature_minimum_factor=0.3")
    assert (case.problem.friction.slope, case.problem.friction.minimum) == (2e-3, 0.3)
    default = parse(THERMAL).problem
    assert (default.friction.slope, default.friction.minimum) == (0.0, 0.1)
    assert parse(case.to_toml()).problem == case.problem


def test_grid_ladder_carries_the_friction_up():
    """The finest grid starts from the friction of the coarser one: few iterations there."""
    ladder = solved(on_grid(warm(), 32))
    assert ladder.work["levels"][-1]["warm_friction_iterations"] <= 5


# --- CONTACT ---------------------------------------------------------------------------------------------------------

LOCOMOTIVE = replace(
    Case.read(Path(__file__).parents[2] / "cases" / "eurosprinter.toml").problem, interlayer=Interlayer(),
    heating=Heating(deformation=False), **dict.fromkeys(("lower", "upper"), Material(209.92e9, 0.28, 50.0, 0.0, 14.154e-6)),
    numerics=Numerics(grid=(24, 24)))  # fmt: skip


@pytest.mark.parametrize(("series", "slope"), [(2, -0.19 / 1200), pytest.param(4, 0.19 / 400, marks=pytest.mark.slow)])
def test_forces_and_temperatures_agree_with_contact(series: int, slope: float):
    """CONTACT's errors fall like √h, so its values are extrapolated in that. The speeds of both bodies differ here, and not
    there: the mean of both temperatures is compared."""
    found: dict[float, list] = {}
    for number, creepage, _, force, temperature in reference("friction_temperature")["values"]:
        if number == series:
            found.setdefault(creepage, []).append((force, temperature))
    friction = Friction(0.33, slope=slope / 0.33, minimum=0.14 / 0.33)
    for creepage, values in found.items():
        before, last = np.array(values[-2:])
        force, temperature = last + (last - before) / (math.sqrt(2.0) - 1.0)
        motion = replace(LOCOMOTIVE.motion, creepage_x=creepage)
        scalars = solved(replace(LOCOMOTIVE, friction=friction, motion=motion)).coupled.scalars
        mean = 0.5 * (scalars["temperature_rise_max_lower_K"] + scalars["temperature_rise_max_upper_K"])
        assert scalars["force_x_N"] == pytest.approx(force, rel=3e-3)
        assert mean == pytest.approx(temperature, rel=1.5e-2)


def test_friction_that_jumps_between_elements_says_what_to_change():
    """Friction falls to its least within 0.07 K, and the contact warms by 0.12 K: two of seven grids find a state, with mean
    coefficients of 0.067 and 0.102. A flatter slope, as the reason advises, has one."""
    steep = POPULATIONS["given approaches"].draw(674078).problem
    steep = replace(steep, heating=replace(steep.heating, deformation=False))
    result = solve(steep)
    assert not result.converged
    assert "within 0.072 K friction reaches its limit, and the contact warms by 0.12 K" in result.reason
    assert "friction.temperature_slope_1_K" in result.reason and "numerics.grid" not in result.reason
    assert solve(changed(steep, slope=0.2 * steep.friction.slope)).converged

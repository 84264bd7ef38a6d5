"""The public pipeline: names, invariants on varied cases, determinism, ladders, estimates, plans, warm starts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.support.errors import relative
from tests.support.sampling import sampled
from tests.support.scenes import (
    MECHANICAL,
    STEEL,
    article_4_1,
    elastic,
    ellipse,
    on_grid,
    reference_problem,
    rolling,
    saturation,
    solved,
)
from thermoroll_cli.one_contact.refinement.plan import COARSEST, grid_sequence, make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.names import FIELDS, SCALARS
from thermoroll_cli.problem.problem import Heating, Motion, Numerics, Problem
from thermoroll_cli.python_api import Solver, solve

PHYSICAL = [
    "Q_F_W", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K", "temperature_rise_max_upper_K",
    "force_x_N", "force_y_N", "spin_moment_Nmm", "creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm",
    "pressure_max_MPa", "shear_max_MPa", "heat_flux_max_W_mm2", "approach_um", "contact_area_mm2", "stick_area_mm2",
    "thermal_displacement_max_um", "power_balance_error",
]  # fmt: skip
INPUTS = ["hertz_a_mm", "hertz_b_mm", "hertz_p0_MPa", "peclet_lower", "peclet_upper"]
FIELD_NAMES = [
    "pressure", "shear_x", "shear_y", "slip_x", "slip_y", "state", "heat_flux", "temperature_rise_lower",
    "temperature_rise_upper", "displacement_elastic", "displacement_thermal", "gap",
]  # fmt: skip


def driven(base: Problem, x: float, y: float, spin: float, speed: float = 1.0) -> Problem:
    """Creepages and spin in units of saturation."""
    scale = saturation(base)
    return replace(base, motion=Motion(speed, x * scale.creepage, y * scale.creepage, spin * scale.spin))


def body(poisson_ratio: float):
    return replace(STEEL, poisson_ratio=poisson_ratio)


VARIED = {
    "circle": driven(rolling(grid=40, heating=Heating()), 0.4, 0.2, 0.1),
    "elliptic 1:5": driven(rolling(grid=40, geometry=ellipse(0.2), heating=Heating()), 0.5, -0.3, 0.2),
    "elliptic 4:1": driven(rolling(grid=40, geometry=ellipse(4.0), heating=Heating()), 0.3, 0.3, -0.5),
    "spin dominated": driven(rolling(grid=40, heating=Heating()), 0.05, -0.05, 1.0),
    "oblong grid": driven(rolling(grid=(64, 28), geometry=ellipse(2.0), heating=Heating()), 0.6, 0.1, 0.3),
    "odd grid": driven(rolling(grid=(35, 43), heating=Heating()), -0.5, 0.2, 0.3),
    "low friction": driven(rolling(grid=40, friction=0.01, heating=Heating()), 0.5, 0.2, 0.2),
    "high friction": driven(rolling(grid=40, friction=1.0, heating=Heating()), 0.4, 0.4, 0.4),
    "no Poisson effect": driven(rolling(grid=40, body=body(0.0), heating=Heating()), 0.5, 0.2, 0.3),
    "incompressible": driven(rolling(grid=40, body=body(0.5), heating=Heating()), 0.5, 0.2, 0.3),
    "almost all stick": driven(rolling(grid=64, heating=Heating()), 0.02, 0.01, 0.01),
    "almost all slip": driven(rolling(grid=40, heating=Heating()), 0.9, 0.4, 0.1),
    "sliding": driven(rolling(grid=40, heating=Heating()), 30.0, -10.0, 5.0),
    "hot": article_4_1(64),
    "hot with spin": driven(
        rolling(grid=40, geometry=ellipse(0.5), heating=Heating(peclet="stationary")), 0.8, 0.2, 0.3, 150.0
    ),
    "concave": rolling(grid=48, geometry=Geometry(0.03, 0.03, 0.03, -0.05), creepage=(1e-3, 0.0), heating=Heating()),
}


SECOND = ("elliptic 4:1", "elliptic 1:5", "odd grid", "low friction", "high friction", "no Poisson effect", "incompressible",
          "sliding", "almost all slip")
"""Of which others are further than these, or are both at once."""


# --- names --------------------------------------------------------------------------------------------------------


def test_summary_has_every_name_of_the_interface():
    summary = solved(VARIED["hot"]).summary()
    for name in ["status", "reason", *PHYSICAL, *INPUTS, "isothermal", "uncertainty", "work"]:
        assert name in summary, name
    assert set(PHYSICAL) <= set(SCALARS)
    assert set(summary["isothermal"]) == set(SCALARS)
    assert set(SCALARS) < set(summary["uncertainty"])
    assert summary["status"] == "converged" and summary["reason"] == ""
    for name in ("grid", "iterations", "applications", "seconds", "skipped", "levels"):
        assert name in summary["work"], name


@pytest.mark.slow
def test_every_field_is_there_with_the_shape_of_the_grid():
    result = solved(on_grid(VARIED["hot"], (20, 28)))
    for state in (result.coupled, result.isothermal):
        assert set(FIELD_NAMES) <= set(state.fields) <= set(FIELDS)
        for field in state.fields.values():
            assert field.shape == (20, 28) == (len(result.x), len(result.y))
            assert np.isfinite(field).all()
    assert set(np.unique(result.coupled.fields["state"])) == {0, 1, 2}


def test_progress_is_reported_per_grid():
    problem, seen = on_grid(VARIED["hot"], 32), []
    solve(problem, report=lambda stage, info: seen.append((stage, tuple(info["grid"]))))
    climb = [(stage, shape) for shape in grid_sequence(problem) for stage in ("tangential", "coupling")]
    assert seen[-len(climb) :] == climb


# --- invariants ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.slow if name in SECOND else (), id=name.replace(" ", "-")) for name in VARIED])
def test_varied_cases(name):
    """p ≥ 0, h ≥ 0, ∬p = W, |τ| ≤ μp, slip along τ, q ≥ 0, ∬q = Q_F, ΔT ≥ 0, work = heat in both states; scalars are those of
    the fields, with errors small enough to use; and the work that it takes."""
    varied = VARIED[name]
    result = solved(varied)
    assert result.converged, result.reason
    area = float((result.x[1] - result.x[0]) * (result.y[1] - result.y[0]))
    for state in {id(s): s for s in (result.coupled, result.isothermal)}.values():
        f, s = state.fields, state.scalars
        pressure, inside = f["pressure"], f["state"] > 0
        assert pressure.min() >= 0.0 and (pressure[inside] > 0.0).all() and not pressure[~inside].any()
        assert pressure.sum() * area == pytest.approx(varied.normal_force, rel=1e-7)
        assert f["gap"].min() >= 0.0 and not f["gap"][inside].any()
        bound, shear = varied.friction.coefficient * pressure, np.hypot(f["shear_x"], f["shear_y"])
        assert (shear - bound).max() < 5e-3 * bound.max()
        assert np.linalg.norm(np.maximum(shear - bound, 0.0)) < 2e-4 * np.linalg.norm(bound)
        speed = np.hypot(f["slip_x"], f["slip_y"])
        power = f["shear_x"] * f["slip_x"] + f["shear_y"] * f["slip_y"]
        assert np.sum(shear * speed - power) < 1e-3 * max(np.sum(shear * speed), s["Q_F_W"] / area)
        stick = f["state"] == 1
        assert not speed[stick].any() and not speed[~inside].any() and not shear[~inside].any()
        assert f["heat_flux"].min() >= 0.0 and not f["heat_flux"][~inside].any()
        m = varied.motion
        slip, x = DerivedQuantities(varied).kinematics.differential_slip, result.x[:, None]
        rigid = (s["creepage_longitudinal"] + slip(result.y) - m.spin * result.y,
                 s["creepage_lateral"] + m.spin * x - x * slip.slope(result.y))
        work = m.speed * (f["shear_x"] * rigid[0] + f["shear_y"] * rigid[1]).sum() * area
        assert f["heat_flux"].sum() * area == pytest.approx(work, rel=1e-6)
        for name in ("temperature_rise_lower", "temperature_rise_upper"):
            assert f[name].min() >= -1e-9 * f[name].max()
        assert 0.0 <= s["gamma_st"] <= 1.0
        assert math.hypot(s["force_x_N"], s["force_y_N"]) <= varied.traction_limit * (1.0 + 1e-6)
    f, s = result.coupled.fields, result.coupled.scalars
    # Integrals may be extrapolated, which moves them further than their estimated error then is.
    arm = result.x[:, None] * f["shear_y"] - result.y[None, :] * f["shear_x"]
    arm_scale = 1e3 * varied.traction_limit * math.sqrt(result["hertz_a_mm"] * result["hertz_b_mm"]) * 1e-3
    for name, value, scale in (("force_x_N", f["shear_x"].sum() * area, varied.traction_limit),
                               ("force_y_N", f["shear_y"].sum() * area, varied.traction_limit),
                               ("spin_moment_Nmm", 1e3 * arm.sum() * area, arm_scale),
                               ("Q_F_W", f["heat_flux"].sum() * area, 0.0)):
        tolerance = max(15.0 * relative(result)[name] * max(abs(s[name]), scale), 1e-13 * scale)
        assert s[name] == pytest.approx(value, abs=tolerance), name
    assert s["gamma_p"] == pytest.approx(s["pressure_max_MPa"] / result.of_problem["hertz_p0_MPa"], rel=1e-12)
    assert s["pressure_max_MPa"] == pytest.approx(1e-6 * f["pressure"].max(), rel=0.01)
    hertz_area = math.pi * result.of_problem["hertz_a_mm"] * result.of_problem["hertz_b_mm"]
    assert s["gamma_c"] == pytest.approx(s["contact_area_mm2"] / hertz_area, rel=1e-12)
    assert s["gamma_st"] == pytest.approx(s["stick_area_mm2"] / s["contact_area_mm2"], rel=1e-12)
    counted = np.count_nonzero(f["state"]) * area * 1e6
    assert s["contact_area_mm2"] == pytest.approx(counted, rel=0.08)
    sticking = np.count_nonzero(f["state"] == 1) / np.count_nonzero(f["state"])
    assert s["gamma_st"] == pytest.approx(sticking, abs=0.05)
    for name in ("lower", "upper"):
        assert s[f"temperature_rise_max_{name}_K"] == pytest.approx(f[f"temperature_rise_{name}"].max(), rel=0.06)
    # Estimates below 5 %, and zero only for what vanishes by symmetry.
    for name in ("Q_F_W", "gamma_c", "gamma_p", "force_x_N", "force_y_N"):
        assert (relative(result)[name] > 0.0) == (s[name] != 0.0) and relative(result)[name] < 0.05, name
    # Small creepages are the most expensive.
    assert result.work["levels"][-1]["applications"] <= 80
    resolved = result.isothermal.scalars["gamma_st"] < 0.75
    assert result.isothermal.scalars["power_balance_error"] <= (2e-3 if resolved else 0.2)


# --- isothermal geometry ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("aspect", sampled([0.1, 10.0]))
def test_isothermal_normal_state_is_hertz(aspect):
    """p_max within 2e-4, area within 0.5 %, displacement and gap against the closed form, at N = 128."""
    problem = rolling(grid=128, geometry=ellipse(aspect), creepage=(5e-4, 0.0))
    result, hertz = solved(problem), DerivedQuantities(problem).hertz
    f, s = result.isothermal.fields, result.isothermal.scalars
    assert result.of_problem["hertz_a_mm"] / result.of_problem["hertz_b_mm"] == pytest.approx(aspect, rel=1e-9)
    assert s["gamma_p"] == pytest.approx(1.0, abs=2e-4)
    assert s["gamma_c"] == pytest.approx(1.0, abs=5e-3)
    assert s["approach_um"] == pytest.approx(hertz.approach * 1e6, rel=1e-4)
    x, y = result.x[:, None], result.y[None, :]
    assert np.abs(f["displacement_elastic"] - hertz.displacement(x, y)).max() < 1e-3 * hertz.approach
    assert np.abs(f["gap"] - hertz.gap(x, y)).max() < 5e-3 * hertz.approach
    whole = (x / hertz.semi_axis_x) ** 2 + (y / hertz.semi_axis_y) ** 2 < 0.9
    assert np.abs(f["pressure"] - hertz.pressure(x, y))[whole].max() < 1e-3 * hertz.peak_pressure


# --- ladder, plan and estimates -----------------------------------------------------------------------------------


def test_ladder_doubles_up_to_the_grid_that_is_asked_for():
    for grid in ((128, 128), (100, 60), (31, 200), (17, 17), (128, 33)):
        ladder = grid_sequence(rolling(grid=grid))
        assert ladder[-1] == grid
        assert max(ladder[0]) < 4 * COARSEST
        for coarse, fine in pairwise(ladder):
            for few, many in zip(coarse, fine, strict=True):
                assert 1.8 < many / few <= 2.0 or few == many < 4 * COARSEST


def test_plan_tells_before_solving_what_will_be_done():
    plan = make_plan(VARIED["hot"])
    assert {"tangential", "heat", "deformation"} <= set(plan.run)
    assert plan.grid == (64, 64) and plan.memory_bytes > 0 and plan.seconds > 0.0
    result = solved(VARIED["hot"])
    for name in INPUTS:
        assert plan.facts[name] == result.of_problem[name]
    assert plan.skipped == result.work["skipped"]
    for problem in VARIED.values():
        other = make_plan(problem)
        assert not set(other.run) & set(other.skipped)


@pytest.mark.slow
@pytest.mark.parametrize("wanted", sampled([2e-2, 2e-3]))
def test_accuracy_picks_the_grid(wanted):
    """Coarse where little is asked for; the scalars are then as good as that, against a fine grid."""
    problem = reference_problem("article_3_1_case_2", 128)
    result = solved(replace(problem, numerics=Numerics(accuracy=wanted)))
    assert result.converged, result.reason
    fine = solved(problem).coupled.scalars
    assert len(result.x) <= 128
    for name in ("Q_F_W", "force_x_N", "force_y_N", "gamma_st"):
        assert relative(result)[name] <= wanted
        assert result.coupled.scalars[name] == pytest.approx(fine[name], abs=2.0 * wanted * max(1.0, abs(fine[name])))


# --- one problem after another ------------------------------------------------------------------------------------


def test_a_warm_started_sweep_gives_the_answers_of_single_solves():
    """Neighbouring creepages through one Solver: the same scalars to the solver's tolerance, for less work."""
    solver = Solver()
    base = rolling(grid=32, heating=MECHANICAL, body=elastic(0.28))
    problems = [driven(base, share, 0.1, 0.1) for share in (0.2, 0.25, 0.3)]
    swept, single = [solver.solve(p) for p in problems], [solve(p) for p in problems]
    for one, other in zip(swept, single, strict=True):
        assert one.converged
        for name in ("force_x_N", "force_y_N", "Q_F_W"):
            assert one.coupled.scalars[name] == pytest.approx(other.coupled.scalars[name], rel=5e-4)
    work = [sum(sum(level["applications"] for level in r.work["levels"]) for r in results) for results in (swept, single)]
    assert work[0] < 0.9 * work[1]

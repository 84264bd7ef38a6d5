"""Smallest balls, shakedown, alternating plasticity and Dang Van's stress against independent solutions."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.support.command_line import MECHANICAL, call
from tests.support.errors import relative
from tests.support.scenes import strong_circle
from thermoroll_cli import read_result
from thermoroll_cli.files.case import Case
from thermoroll_cli.physics.stress.smallest_ball import smallest_balls
from thermoroll_cli.physics.stress.strength import deviator, largest_over_depth, line_fatigue, shakedown_at_depth, tresca_shear
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Numerics, Strength, SubsurfaceRequest
from thermoroll_cli.python_api import solve

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "life_shakedown_fatigue.json").read_text())
CASES = Path(__file__).parents[2] / "cases"
SQRT3 = math.sqrt(3.0)


@pytest.mark.parametrize("cloud", REFERENCE["clouds"])
def test_random_histories_agree_with_an_interior_point_method(cloud: dict) -> None:
    stress = np.array(cloud["stress_xx_yy_zz_xy_xz_yz_MPa"]).T[:, :, None]
    tolerance = REFERENCE["meta"]["tolerance"]
    alternating, dang_van, _ = line_fatigue(stress, cloud["a_DV"])
    assert shakedown_at_depth(stress)[0] * SQRT3 == pytest.approx(cloud["shakedown_xx_yy_xy"], rel=tolerance["clouds_balls"])
    assert alternating[0] * SQRT3 == pytest.approx(cloud["ball_5d"], rel=tolerance["clouds_balls"])
    assert dang_van[0] == pytest.approx(cloud["dang_van"], rel=tolerance["clouds_dang_van"])


def test_the_residual_stress_brings_all_states_to_the_yield_stress() -> None:
    stress = np.array(REFERENCE["clouds"][1]["stress_xx_yy_zz_xy_xz_yz_MPa"]).T[:, :, None]
    needed, found = shakedown_at_depth(stress)
    residual = np.zeros((6, 1, 1))
    residual[[0, 1, 3], 0, 0] = found
    loaded = np.linalg.norm(deviator(stress + residual), axis=-1)
    unloaded = np.linalg.norm(deviator(residual), axis=-1)
    assert max(loaded.max(), unloaded.max()) == pytest.approx(SQRT3 * needed, rel=1e-9)


def test_a_mirrored_state_needs_only_one_half() -> None:
    half = np.random.default_rng(1).normal(size=(6, 20, 8))
    signs = np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0])[:, None, None]
    whole = np.concatenate([signs * half[:, :, ::-1], half], axis=2)
    assert shakedown_at_depth(half, mirrored=True)[0] == pytest.approx(shakedown_at_depth(whole)[0], rel=1e-9)


def test_balls_of_many_sets_are_optimal_and_do_not_depend_on_the_start() -> None:
    """Optimality: the centre is a convex combination of points on the ball, and no point lies outside."""
    generator = np.random.default_rng(2)
    points = np.cumsum(generator.normal(size=(30, 40, 5)), axis=1)
    cold = smallest_balls(points)
    warm = smallest_balls(points, start=smallest_balls(points + 0.1 * generator.normal(size=points.shape)))
    distances = ((points - cold.centres[:, None]) ** 2).sum(axis=2)
    assert np.allclose(distances.max(axis=1), cold.squared_radii, rtol=1e-9)
    for number in range(len(points)):
        on_it = cold.basis[number][cold.multipliers[number] > 1e-9]
        assert np.allclose(distances[number, on_it], cold.squared_radii[number], rtol=1e-7)
    assert np.allclose(np.einsum("bs,bsd->bd", cold.multipliers, np.take_along_axis(points, cold.basis[..., None], 1)),
                       cold.centres)
    assert np.allclose(warm.squared_radii, cold.squared_radii, rtol=1e-9)


def test_tresca_shear_is_half_the_difference_of_principal_stresses() -> None:
    tensors = np.random.default_rng(3).normal(size=(50, 3, 3))
    tensors += tensors.transpose(0, 2, 1)
    principal = np.linalg.eigvalsh(tensors)
    stress = np.stack([tensors[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))])
    assert np.allclose(tresca_shear(deviator(stress)), 0.5 * (principal[:, 2] - principal[:, 0]))


def test_largest_over_depth_finds_the_top_of_a_parabola_and_leaves_the_surface_out() -> None:
    depths = np.array([0.0, 0.1, 0.25, 0.4, 0.7])
    values = 2.0 - (depths - 0.3) ** 2
    values[0] = 5.0
    value, depth = largest_over_depth(depths, values)
    assert value == pytest.approx(2.0) and depth == pytest.approx(0.3)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.2])
def test_shakedown_and_fatigue_over_depth(friction: float) -> None:
    """Against quadratures of Boussinesq's and Cerruti's stresses. Their histories end at the border of a domain, which matters
    farther down; there against those of a domain that is wide by itself."""
    wanted = next(h for h in REFERENCE["hertz"] if (h["a"], h["b"], h["mu_x"], h["mu_y"]) == (1, 1, friction, 0))
    result = solve(strong_circle(friction))
    body, p0 = result.subsurface.bodies["lower"], result.of_problem["hertz_p0_MPa"] * 1e6
    relative = np.array(wanted["depths_over_smaller_semi_axis"][1:])
    depths = relative * result.of_problem["hertz_a_mm"] * 1e-3
    wide = solve(replace(strong_circle(friction), numerics=Numerics((96, 96), extent=5.5))).subsurface.bodies["lower"]
    for name, factor, column, last in (("shakedown_k", SQRT3, "shakedown", 2.0), ("alternating_k", SQRT3, "ball_5d", 0.8),
                                       ("dang_van", 1.0, "dang_van_0p3", 0.35)):
        found, there = (CubicSpline(each.depths, each.strength[name].reshape(len(each.depths), -1).max(axis=1))(depths)
                        for each in (body, wide))
        assert found == pytest.approx(there, rel=0.02), name
        complete = relative <= last
        assert (found * factor / p0)[complete] == pytest.approx(np.array(wanted[column][1:])[complete], rel=6e-3), name


@pytest.mark.slow
def test_strength_compares_with_what_is_needed_and_has_estimates() -> None:
    coarse, fine = solve(strong_circle(0.2, 24)), solve(strong_circle(0.2, 64))
    scalars, error = coarse.subsurface.scalars, relative(coarse)
    assert scalars["shakedown_factor_lower"] == pytest.approx(200.0 / scalars["shakedown_k_lower_MPa"])
    utilised = abs(coarse.coupled.scalars["force_x_N"]) / 65.0
    assert scalars["fatigue_index_surface_lower"] == pytest.approx(utilised - 200.0 / coarse["hertz_p0_MPa"], rel=1e-9)
    pressure = coarse.coupled.scalars["pressure_max_MPa"]
    for name in ("shakedown_k_below_lower_MPa", "alternating_k_below_lower_MPa", "dang_van_max_below_lower_MPa",
                 "shakedown_k_surface_lower_MPa", "dang_van_max_surface_lower_MPa"):
        assert abs(scalars[name] - fine.subsurface.scalars[name]) <= error[name] * pressure, name


@pytest.mark.slow
@pytest.mark.parametrize(("name", "coefficient", "truth"), [("ball_bearing", 0.5, 174.3), ("wheel_rail", 0.38, 121.2)])
def test_histories_go_on_outside_the_domain(name: str, coefficient: float, truth: float) -> None:
    """Without friction. The truth is that of 512 elements along 4.4 half-lengths; histories that end with the domain give 162.7
    and 119.0 on this grid."""
    problem = Case.read(CASES / f"{name}.toml").problem
    request = SubsurfaceRequest(("lower",), lower_strength=Strength(5e8, coefficient))
    result = solve(replace(problem, friction=Friction(0.0), heating=Heating(heat=False), numerics=Numerics((32, 32)),
                           subsurface=request))
    found, error = (each["dang_van_max_below_lower_MPa"] for each in (result.subsurface.scalars, relative(result)))
    assert found == pytest.approx(truth, rel=0.02)
    assert abs(found - truth) <= error * result.coupled.scalars["pressure_max_MPa"]
    # No islands: below what the surface causes it rises to one peak and falls.
    below = result.subsurface.bodies["lower"].strength["dang_van"].max(axis=1)
    below = below[int(np.argmin(below[:12])) :]
    assert np.count_nonzero(np.diff(np.sign(np.diff(below)))) == 1


@pytest.mark.slow
def test_what_falls_from_the_surface_has_no_estimate_below_it() -> None:
    """The first depth carries more than the peak below it: another first depth would have another value."""
    result = solve(strong_circle(0.4, 24))
    steps = np.diff(result.subsurface.bodies["lower"].strength["shakedown_k"])
    assert (steps[:2] < 0.0).all() and (steps > 0.0).any()
    error = relative(result)
    assert math.isnan(error["shakedown_k_below_lower_MPa"]) and error["shakedown_k_lower_MPa"] > 0.0


def test_strength_needs_stresses_of_its_body(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(MECHANICAL + "\n[strength.lower]\nshear_yield_MPa = 300.0\n")
    done = call("run", case, "--no-plots", "-o", tmp_path)
    assert done.returncode == 3 and "strength.lower" in done.stderr and "[subsurface]" in done.stderr
    case.write_text(MECHANICAL + "\n[subsurface]\nlayers = 8\n[strength.lower]\nshear_yield_MPa = 300.0\n")
    done = call("run", case, "--no-plots", "--json", "-o", tmp_path)
    assert json.loads(done.stdout)["shakedown_factor_lower"] > 0.0
    kept = read_result(tmp_path / "case.h5").subsurface.bodies["lower"].strength
    assert kept["shakedown_k"].shape == (8,) and kept["dang_van"].shape[0] == 8

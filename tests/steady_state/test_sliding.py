"""Heat that travels with the local slip speed, and with each body's own speed up to pure sliding and beyond."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.scenes import STEEL, article_4_1, rolling, solved
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_table
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.heat.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.problem import Heating, Motion

K, FREE_EXPANSION, KAPPA = 50.2, 1.28 * 11.7e-6, 10e-6
GRID = Grid(8, 6, 2.0e-5, 1.4e-5)
SLIDING = Heating(peclet="sliding")


def body(diffusivity: float = KAPPA, conductivity: float = K, expansion: float = FREE_EXPANSION) -> HeatedBody:
    return HeatedBody(conductivity, expansion, diffusivity, 0.0)


def slip_and_flux(peclet: float, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Slip speed with V a/κ up to about `peclet`, a = half the grid, and the flux it makes; a fifth of all sources stick."""
    random = np.random.default_rng(seed)
    speed = random.random(GRID.shape) ** 3 * peclet * KAPPA / (4 * GRID.dx)
    speed[random.random(GRID.shape) < 0.2] = 0.0
    return speed, speed * (0.5 + random.random(GRID.shape)) * 1e9


def direct_sum(table, grid: Grid, speed: np.ndarray, flux: np.ndarray, diffusivity: float) -> np.ndarray:
    """Σ K_P(x')(x − x') q(x') with a table made for every source element: material moves along +x at the slip speed."""
    nx, ny = grid.shape
    total = np.zeros(grid.shape)
    for i, j in zip(*np.nonzero(flux), strict=True):
        kernel = table(nx, ny, grid.dy / grid.dx, float(speed[i, j] * grid.dx / diffusivity))
        total += flux[i, j] * kernel[nx - 1 - i : 2 * nx - 1 - i, ny - 1 - j : 2 * ny - 1 - j]
    return total


def test_response_is_the_sum_over_sources_with_a_kernel_each():
    """Both temperatures and the sum of expansions, bodies alike or not: within 1e-5 of the peak (1e-4 is asked for)."""
    speed, flux = slip_and_flux(30.0)
    bodies = body(), body(0.3 * KAPPA, conductivity=20.0, expansion=3e-5)
    response = SlidingHeatResponse(SlidingKernels(GRID), *bodies, speed)
    heat = DividedHeat(flux, 0.35)
    expansion = np.zeros(GRID.shape)
    for found, b, part in zip(response.temperatures(heat), bodies, (heat.lower, heat.upper), strict=True):
        exact = direct_sum(temperature_table, GRID, speed, part, b.diffusivity) * GRID.dx / b.conductivity
        assert np.abs(found - exact).max() < 1e-5 * exact.max()
        expansion += direct_sum(displacement_table, GRID, speed, part * b.free_expansion / b.conductivity, b.diffusivity)
    found = response.displacement(heat)
    assert np.abs(found - expansion * GRID.dx**2).max() < 1e-5 * np.ptp(found)
    report = response.report()
    assert 0.0 < report["error"] <= 1e-5
    assert 2 <= report["terms_temperature"] <= 25 and 2 <= report["terms_displacement"] <= 25
    # One Péclet number for all would not do.
    mean = SlidingHeatResponse(SlidingKernels(GRID), *bodies, np.full(GRID.shape, speed[flux > 0].mean()))
    crude = mean.temperatures(heat)[0] - response.temperatures(heat)[0]
    assert np.abs(crude).max() > 1e-3 * response.temperatures(heat)[0].max()


@pytest.mark.parametrize("divided", sampled([True, False]))
def test_uniform_slip_is_uniform_motion(divided):
    """The same slip everywhere, or none, is the convolution with one kernel (the constant of sources at rest is arbitrary)."""
    # The same along each row: nothing changes within elements, which only uniform motion takes into account.
    flux = np.tile(np.random.default_rng(3).random(GRID.ny), (GRID.nx, 1))
    heat = DividedHeat(flux, 0.4, 0.3 * flux[:, ::-1] if divided else None)
    for speed in (0.0, 0.02, 3.0):
        pair = [replace(b, speed_x=speed) for b in (body(), body(2 * KAPPA, 20.0))]
        sliding = SlidingHeatResponse(SlidingKernels(GRID), *pair, np.full(GRID.shape, speed))
        moving = HeatResponse(GRID, *pair)
        for found, exact in zip(sliding.temperatures(heat), moving.temperatures(heat), strict=True):
            np.testing.assert_allclose(found, exact, atol=2e-5 * np.abs(exact).max())
        found, exact = sliding.displacement(heat), moving.displacement(heat)
        np.testing.assert_allclose(found - found.mean(), exact - exact.mean(), atol=2e-5 * np.ptp(exact))
        gap, exact = sliding.temperature_difference(flux), moving.temperature_difference(flux)
        np.testing.assert_allclose(gap, exact, atol=2e-5 * np.abs(exact).max())


def test_bodies_of_one_diffusivity_share_a_response():
    """Of other conductivities: the difference that an exchanged heat makes is the sum of both rises."""
    flux = np.random.default_rng(5).random(GRID.shape)
    pair = [replace(b, speed_x=0.02) for b in (body(), body(KAPPA, 20.0))]
    sliding, moving = SlidingHeatResponse(SlidingKernels(GRID), *pair, np.full(GRID.shape, 0.02)), HeatResponse(GRID, *pair)
    exact = moving.temperature_difference(flux)
    np.testing.assert_allclose(sliding.temperature_difference(flux), exact, atol=2e-5 * np.abs(exact).max())


def test_expansions_serve_until_slip_has_doubled():
    """Kernels are built for a power of two: states with a little more or less slip share them, back and forth, too."""
    kernels = SlidingKernels(GRID)
    limit = 0.25 * KAPPA / GRID.dx  # P = V dx/κ = 1/4 is the end of a range

    def terms(speed: float) -> int:
        return kernels.covering("temperature", speed * GRID.dx / KAPPA)[1].terms

    def built() -> int:
        return kernels.expansion.cache_info().misses

    first = terms(0.6 * limit)
    assert [terms(f * limit) for f in (0.7, 0.9, 1.0, 0.51)] == [first] * 4
    assert built() == 1
    for factor in (1.01, 0.99, 1.5, 0.8):
        terms(factor * limit)
    assert built() == 2
    terms(0.4 * limit)
    assert built() == 3
    kernels.covering("displacement", 0.2)
    assert built() == 4


def test_answers_do_not_depend_on_what_was_solved_before():
    speed, flux = slip_and_flux(1.0)
    heat = DividedHeat(flux, 0.5)
    used = SlidingKernels(GRID)
    for factor in (5.0, 0.1, 30.0):
        SlidingHeatResponse(used, body(), body(), factor * speed).displacement(heat)
    again = SlidingHeatResponse(used, body(), body(), speed)
    fresh = SlidingHeatResponse(SlidingKernels(GRID), body(), body(), speed)
    np.testing.assert_array_equal(again.displacement(heat), fresh.displacement(heat))
    assert again.report() == fresh.report()


# --- in the pipeline ----------------------------------------------------------------------------------------------


def test_result_is_the_sum_over_its_own_slip():
    """Fields of a result alone: heat flux and slip give its temperatures, by one kernel per source, within 1e-4."""
    slow_heat = replace(STEEL, diffusivity=KAPPA / 20.0, expansion=1e-8)  # Péclet numbers up to 2.5, but hardly a bulge
    result = solved(rolling(grid=8, creepage=(0.003, 0.001), spin=5.0, body=slow_heat, heating=SLIDING))
    assert "deformation" in result.work["skipped"]
    fields, scalars = result.coupled.fields, result.coupled.scalars
    grid = Grid(8, 8, result.x[1] - result.x[0], result.y[1] - result.y[0])
    speed = np.hypot(fields["slip_x"], fields["slip_y"])
    exact = direct_sum(temperature_table, grid, speed, fields["heat_flux"], KAPPA / 20.0) * grid.dx / K
    np.testing.assert_allclose(fields["temperature_rise_lower"], 0.5 * exact, atol=1e-4 * exact.max())
    np.testing.assert_allclose(fields["temperature_rise_upper"], 0.5 * exact, atol=1e-4 * exact.max())
    expansion = direct_sum(displacement_table, grid, speed, fields["heat_flux"], KAPPA / 20.0)
    expansion *= grid.dx**2 * 1.28e-8 / K
    inside = fields["state"] > 0
    shift = (fields["displacement_thermal"] - expansion)[inside].mean()
    np.testing.assert_allclose(fields["displacement_thermal"], expansion + shift, atol=1e-4 * np.ptp(expansion))
    assert abs(np.average(fields["displacement_thermal"], weights=fields["covered"])) < 1e-12 * np.ptp(expansion)
    assert scalars["partition_mean"] == 0.5
    assert result.work["sliding"]["error"] < 1e-4
    assert result.work["sliding"]["terms_temperature"] <= 12 and result.work["sliding"]["terms_displacement"] <= 12


@pytest.mark.slow
def test_article_4_1_with_sliding_peclet_numbers():
    """Coupled: hotter than with the material's own speed, cooler than at rest, and cheap: kernels are built once a range."""
    results = {mode: solved(article_4_1(16, heating=Heating(peclet=mode))) for mode in ("rolling", "sliding", "stationary")}
    assert all(r.converged for r in results.values())
    hot = [results[m].coupled.scalars["temperature_rise_max_lower_K"] for m in ("rolling", "sliding", "stationary")]
    peak = [results[m].coupled.scalars["gamma_p"] for m in ("rolling", "sliding", "stationary")]
    assert hot[0] < hot[1] < hot[2] and 1.0 == pytest.approx(peak[0]) and 1.01 < peak[1] < peak[2]
    sliding = results["sliding"]
    assert sliding.work["sliding"]["terms_displacement"] <= 20
    assert sliding.work["iterations"]["coupling_iterations"] <= 10
    assert not any("sideways" in w for w in sliding.warnings)


@pytest.mark.slow
def test_mirrored_and_reversed_creepage_and_exchanged_bodies():
    """Heat is carried along x whichever way the surfaces slip: all symmetries of rolling hold in the coupled state."""
    base = replace(article_4_1(12, heating=SLIDING), motion=Motion(100.0, 0.003, 0.001, 5.0))
    here = solved(base).coupled
    mirrored = solved(replace(base, motion=Motion(100.0, 0.003, -0.001, -5.0))).coupled
    reversed_ = solved(replace(base, motion=Motion(100.0, -0.003, -0.001, -5.0))).coupled
    for name in ("pressure", "temperature_rise_lower", "displacement_thermal", "heat_flux"):
        scale = np.abs(here.fields[name]).max()
        np.testing.assert_allclose(mirrored.fields[name][:, ::-1], here.fields[name], atol=2e-4 * scale)
        np.testing.assert_allclose(reversed_.fields[name], here.fields[name], atol=2e-4 * scale)
    for name, sign in (("shear_x", -1.0), ("shear_y", -1.0)):
        scale = np.abs(here.fields[name]).max()
        np.testing.assert_allclose(sign * reversed_.fields[name], here.fields[name], atol=2e-3 * scale)


@pytest.mark.slow
def test_a_scaled_problem_has_the_same_numbers():
    """Lengths × 8, loads × 64, speed / 8: the same stresses and Péclet numbers; expansion in proportion to the length."""
    small = replace(article_4_1(12, heating=SLIDING), motion=Motion(100.0, 0.003, 0.0))
    geometry = replace(small.geometry, **{k: 8.0 * v for k, v in vars(small.geometry).items() if v and isinstance(v, float)})
    large = replace(small, geometry=geometry, normal_force=64.0 * 65.0, motion=Motion(12.5, 0.003, 0.0))
    a, b = solved(small), solved(large)
    for name in ("gamma_p", "gamma_c", "gamma_st", "temperature_rise_max_lower_K"):
        assert b.coupled.scalars[name] == pytest.approx(a.coupled.scalars[name], rel=1e-9)
    assert b.work["sliding"] == pytest.approx(a.work["sliding"], rel=1e-6)


def test_sideways_slip_is_told():
    lateral = rolling(grid=16, creepage=(0.0, 0.003), speed=10.0, heating=SLIDING)
    (warning,) = [w for w in solved(lateral).warnings if "sideways" in w]
    assert "100 % of the heat" in warning and "sliding" in warning
    # Slow slip spreads alike in all directions, and rolling Péclet numbers do not ask.
    assert not solved(replace(lateral, motion=Motion(0.01, 0.0, 0.003))).warnings
    assert not solved(replace(lateral, heating=Heating(peclet="rolling"))).warnings


# --- each body at its own speed -----------------------------------------------------------------------------------


def rolling_heat(creepage: float, grid: int = 32, deformation: bool = False):
    """A slow, hot sphere on sphere, so that P = V a0/κ ≈ 4; slide-roll ratio = `creepage`."""
    return solved(rolling(grid=grid, creepage=(creepage, 0.0), speed=0.2, heating=Heating(deformation=deformation)))


def test_the_resting_body_of_pure_sliding_has_a_symmetric_temperature():
    """V ∓ C/2 = 0: no wake in one body, P = 2V a0/κ in the other."""
    fields = rolling_heat(2.0).coupled.fields
    rise, moving = fields["temperature_rise_upper"], fields["temperature_rise_lower"]
    np.testing.assert_allclose(rise, rise[::-1], atol=1e-3 * rise.max())
    x = np.arange(32)[:, None] - 15.5
    assert float((moving * x).sum() / moving.sum()) > 1.0, "its wake"


def test_beyond_pure_sliding_one_body_is_heated_backwards():
    """Slide-roll ratio 3: surface speeds 2.5 V and −0.5 V; the slower one has its wake ahead of the contact."""
    fields = rolling_heat(-3.0).coupled.fields
    x = np.arange(32)[:, None] - 15.5
    for name, sign in (("upper", 1.0), ("lower", -1.0)):
        rise = fields[f"temperature_rise_{name}"]
        assert sign * float((rise * x).sum() / rise.sum()) > 0.3


@pytest.mark.slow
def test_expansion_passes_smoothly_through_a_body_at_rest():
    """The table of a body at rest has an arbitrary constant, which must not show: ξ = 2 lies between ξ = 2 ∓ 1e-4."""
    slow, rest, back = (
        rolling_heat(xi, deformation=True).coupled.fields["displacement_thermal"] for xi in (1.9999, 2.0, 2.0001)
    )
    np.testing.assert_allclose(rest, 0.5 * (slow + back), atol=1e-4 * np.ptp(rest))
    np.testing.assert_allclose(slow, back, atol=2e-3 * np.ptp(rest))


def test_bodies_that_meet_at_opposite_speeds():
    """Speeds V ± C/2 with C ≫ V: equal bodies at ±C/2, mirror images of each other."""
    fields = rolling_heat(1e4).coupled.fields
    lower, upper = fields["temperature_rise_lower"], fields["temperature_rise_upper"]
    np.testing.assert_allclose(lower, upper[::-1], atol=2e-3 * lower.max())


def test_sideways_speeds_mirror_each_other():
    """Lateral creepage: lower body +C/2 along y, upper −C/2: mirror images in y."""
    fields = solved(rolling(grid=32, creepage=(0.0, 1.0), speed=1.0, heating=Heating(deformation=False))).coupled.fields
    lower, upper = fields["temperature_rise_lower"], fields["temperature_rise_upper"]
    np.testing.assert_allclose(lower, upper[:, ::-1], atol=1e-3 * lower.max())
    y = np.arange(32)[None, :] - 15.5
    assert float((lower * y).sum() / lower.sum()) > 0.5

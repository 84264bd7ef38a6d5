"""Surface temperatures and expansions of both bodies: exact sources, shares, wakes, symmetries, far fields."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.errors import relative
from tests.support.scenes import STEEL, ellipse, rolling, saturation, solved
from thermoroll_cli.exact.moving_sources import ellipse_temperature, rectangle_temperature
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.heated_bodies import heated_bodies, peclet_numbers
from thermoroll_cli.physics.halfspace.thermal import displacement_table, slopes, temperature_slope_table, temperature_table
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.problem import Heating, Motion, Problem

K, FREE_EXPANSION, KAPPA = 50.2, 1.28 * 11.7e-6, 10e-6
SIZE = 2e-4


def body(speed_x: float = 0.0, speed_y: float = 0.0, conductivity: float = K, expansion: float = FREE_EXPANSION):
    return HeatedBody(conductivity, expansion, KAPPA, speed_x, speed_y)


class Pair:
    """Two bodies on a grid, `share` of all heat into the lower one."""

    def __init__(self, grid: Grid, lower: HeatedBody, upper: HeatedBody, share: float = 0.5) -> None:
        self.response, self.share = HeatResponse(grid, lower, upper), share

    def temperatures(self, flux, slope=None):
        return self.response.temperatures(DividedHeat(flux, self.share, slope=slope))

    def displacement(self, flux):
        return self.response.displacement(DividedHeat(flux, self.share))


def speed_of(peclet: float) -> float:
    """Speed in m/s with V·SIZE/κ = `peclet`."""
    return peclet * KAPPA / SIZE


def square_source(n: int, width: int) -> tuple[Grid, np.ndarray, float]:
    """1 MW/m² on width × width elements in the middle of n × n; their half-side is SIZE."""
    grid = Grid(n, n, 2 * SIZE / width, 2 * SIZE / width)
    flux = np.zeros((n, n))
    inside = slice((n - width) // 2, (n + width) // 2)
    flux[inside, inside] = 1e6
    return grid, flux, 1e6


# --- temperature --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("peclet", [0.0, 1.0, 18.8, 300.0])
def test_a_uniform_square_is_exact_on_every_element(peclet):
    """Whole elements of uniform flux: nothing is discretised but the table, good to 1e-9 everywhere on the grid."""
    grid, flux, q = square_source(24, 10)
    lower, upper = Pair(grid, body(speed_of(peclet)), body(speed_of(peclet)), 0.3).temperatures(flux)
    exact = rectangle_temperature(grid.x[:, None], grid.y[None, :], SIZE, SIZE, q, K, KAPPA, speed_of(peclet))
    np.testing.assert_allclose(lower, 0.3 * exact, atol=1e-9 * exact.max())
    np.testing.assert_allclose(upper, 0.7 * exact, atol=1e-9 * exact.max())


@pytest.mark.parametrize("peclet", [0.0, 5.0, 200.0])
def test_temperatures_are_positive_and_trail_the_source(peclet):
    """Hot where material has been heated: the centroid of the temperature lies downstream, at +x, or in the middle."""
    grid, flux, _ = square_source(40, 12)
    rise = Pair(grid, body(speed_of(peclet)), body(), 1.0).temperatures(flux)[0]
    assert rise.min() > -1e-12 * rise.max()
    centroid = float((rise * grid.x[:, None]).sum() / rise.sum())
    if peclet == 0.0:
        assert abs(centroid) < 1e-10 * SIZE
    else:
        assert centroid > 0.2 * SIZE
        np.testing.assert_array_less(rise[grid.x < -1.5 * SIZE].max(), rise[grid.x > 1.5 * SIZE].max())
    i, _ = np.unravel_index(int(np.argmax(rise)), rise.shape)
    assert grid.x[i] >= -0.51 * grid.dx


def test_response_is_the_direct_sum_of_its_tables():
    """Both fields of two different bodies on a small grid, element by element; only the sum of expansions is felt."""
    grid = Grid(7, 9, 2e-5, 3e-5)
    flux = np.random.default_rng(4).random(grid.shape) * 1e6
    bodies = body(0.5, 0.1), body(0.2, -0.1, conductivity=20.0, expansion=2e-5)
    pair = Pair(grid, *bodies, 0.35)

    def direct(table, flux):
        out = np.zeros(grid.shape)
        for i in range(7):
            for j in range(9):
                out[i, j] = sum(table[i - k + 6, j - m + 8] * flux[k, m] for k in range(7) for m in range(9))
        return out

    expansion = np.zeros(grid.shape)
    for found, b, share in zip(pair.temperatures(flux), bodies, (0.35, 0.65), strict=True):
        peclets = b.speed_x * grid.dx / b.diffusivity, b.speed_y * grid.dx / b.diffusivity
        expected = direct(temperature_table(7, 9, 1.5, *peclets), flux)
        expected += direct(temperature_slope_table(7, 9, 1.5, *peclets), slopes(flux))
        expected *= share * grid.dx / b.conductivity
        np.testing.assert_allclose(found, expected, rtol=1e-10)
        scale = share * b.free_expansion * grid.dx**2 / b.conductivity
        expansion += scale * direct(displacement_table(7, 9, 1.5, *peclets), flux)
    np.testing.assert_allclose(pair.displacement(flux), expansion, rtol=1e-10)


def warm(problem: Problem, **heating) -> Problem:
    return replace(problem, heating=Heating(**{"deformation": False, **heating}))


MODERATE = warm(rolling(grid=32, creepage=(0.0016, 0.0004), spin=1.0))


@pytest.mark.parametrize("peclet", ["rolling", "stationary"])
def test_heat_flux_carries_all_of_the_heat(peclet):
    result = solved(warm(MODERATE, peclet=peclet))
    fields, s = result.coupled.fields, result.coupled.scalars
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    assert fields["heat_flux"].min() >= 0.0
    assert fields["heat_flux"].sum() * area == pytest.approx(s["Q_F_W"], rel=2.0 * relative(result)["Q_F_W"])
    assert s["heat_flux_max_W_mm2"] == pytest.approx(fields["heat_flux"].max() * 1e-6, rel=0.05)
    assert not fields["heat_flux"][fields["state"] == 0].any()


def test_speeds_of_both_bodies_differ_by_the_creepage():
    derived = DerivedQuantities(replace(MODERATE, motion=Motion(10.0, 0.02, -0.01)))
    lower, upper = heated_bodies(derived.problem, 0.02, -0.01)
    assert (lower.speed_x, lower.speed_y) == pytest.approx((10.1, -0.05))
    assert (upper.speed_x, upper.speed_y) == pytest.approx((9.9, 0.05))
    stationary = heated_bodies(warm(derived.problem, peclet="stationary"), 0.02, -0.01)
    assert {(b.speed_x, b.speed_y) for b in stationary} == {(0.0, 0.0)}


def test_peclet_numbers_are_reported_with_a0_as_length():
    """Table 1 with κ = 10 mm²/s: V a0/κ ≈ 18.6, of each body with its own speed V ± C/2; none at rest."""
    result = solved(rolling(grid=16, creepage=(0.003, 0.0), heating=Heating(deformation=False)))
    assert result.of_problem["peclet_lower"] == pytest.approx(18.6, abs=0.05)
    assert result.of_problem["peclet_upper"] / result.of_problem["peclet_lower"] == pytest.approx(0.9985 / 1.0015, rel=1e-12)
    rest = DerivedQuantities(replace(result.problem, motion=replace(result.problem.motion, creepage_x=2.0)))
    assert peclet_numbers(rest) == (pytest.approx(2.0 * result.of_problem["peclet_lower"] / 1.0015), 0.0)
    assert peclet_numbers(DerivedQuantities(warm(result.problem, peclet="stationary"))) == (0.0, 0.0)
    slow = replace(STEEL, diffusivity=20e-6)
    other = solved(replace(result.problem, upper=slow))
    assert other.of_problem["peclet_upper"] == pytest.approx(0.5 * result.of_problem["peclet_upper"], rel=1e-12)


def test_partition_divides_the_temperatures():
    even, uneven = (solved(warm(MODERATE, partition=p, peclet="stationary")).coupled.scalars for p in (0.5, 0.2))
    names = "temperature_rise_max_lower_K", "temperature_rise_max_upper_K"
    assert even[names[0]] == pytest.approx(even[names[1]], rel=1e-12)
    assert uneven[names[0]] == pytest.approx(0.4 * even[names[0]], rel=1e-12)
    assert uneven[names[1]] == pytest.approx(1.6 * even[names[1]], rel=1e-12)


@pytest.mark.parametrize("aspect", [0.25, 1.0, 4.0])
def test_full_slip_temperature_is_that_of_an_elliptic_hertzian_source(aspect):
    """Far beyond saturation q = μpVξ: hottest point against the exact ellipse, per body, at N = 64."""
    base = warm(rolling(grid=64, geometry=ellipse(aspect), speed=1.0))
    creep = 200.0 * saturation(base).creepage
    result = solved(replace(base, motion=Motion(1.0, creep, 0.0)))
    hertz = DerivedQuantities(base).hertz
    flux = base.friction.coefficient * hertz.peak_pressure * creep
    rise = result.coupled.fields["temperature_rise_lower"]
    i, j = np.unravel_index(int(np.argmax(rise)), rise.shape)
    exact = ellipse_temperature(float(result.x[i]), float(result.y[j]), hertz.semi_axis_x, hertz.semi_axis_y, 0.5 * flux, K,
                                KAPPA, 1.0 + creep / 2.0, "hertz")
    assert rise[i, j] == pytest.approx(exact, rel=2e-3)
    assert result.coupled.scalars["temperature_rise_max_lower_K"] == pytest.approx(exact, rel=2e-3)

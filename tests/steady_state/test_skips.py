"""Stages that a problem does not need are skipped: the answer stays the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.scenes import MECHANICAL, STEEL, article_4_1, rolling, solved, twin_disc
from thermoroll_cli.one_contact.refinement.expected_heat import bulge_bound, deformation_effect
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.refinement.refine import first_guess
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.one_contact.steady_state.fixed_point import fixed_point
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_table
from thermoroll_cli.physics.heat import heat_response
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.problem import STANDARD_ACCURACY, Heating, Material, Motion
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.arrays import Array

CREEPAGE = (0.0016, 0.0004)


def transforms(result: Result) -> int:
    return sum(level["transforms"] for level in result.work["levels"])


def applications(result: Result) -> int:
    return sum(level["applications"] + level.get("coupled_applications", 0) for level in result.work["levels"])


# --- nothing rubs ----------------------------------------------------------------------------------------------------


def test_no_creepage() -> None:
    still, creeping = (solve(rolling(grid=24, creepage=(c, 0.0))) for c in (0.0, 1e-9))
    assert "tangential" in still.work["skipped"] and "tangential" not in creeping.work["skipped"]
    assert applications(still) == 0
    np.testing.assert_array_equal(still.coupled.fields["pressure"], creeping.coupled.fields["pressure"])
    # The limit of a creepage that vanishes: no force, and everything sticks.
    assert still.coupled.scalars["force_x_N"] == 0.0
    assert abs(creeping.coupled.scalars["force_x_N"]) < 1e-5 * creeping.problem.traction_limit
    assert still.coupled.scalars["gamma_st"] == 1.0 == pytest.approx(creeping.coupled.scalars["gamma_st"], abs=0.02)


def test_no_friction() -> None:
    smooth, rough = (solve(rolling(grid=24, creepage=CREEPAGE, friction=mu)) for mu in (0.0, 1e-6))
    assert "tangential" in smooth.work["skipped"]
    assert applications(smooth) == 0
    assert smooth.coupled.scalars["force_x_N"] == 0.0 == smooth.coupled.scalars["Q_F_W"]
    assert rough.coupled.scalars["force_x_N"] <= 1e-6 * 65.0
    assert smooth.coupled.scalars["gamma_st"] == 0.0 == pytest.approx(rough.coupled.scalars["gamma_st"], abs=0.02)
    # Whatever slides slides with the rigid slip.
    inside = smooth.coupled.fields["state"] > 0
    scale = np.abs(smooth.coupled.fields["slip_x"]).max()
    for name in ("slip_x", "slip_y"):
        np.testing.assert_allclose(smooth.coupled.fields[name][inside], rough.coupled.fields[name][inside], atol=1e-2 * scale)


# --- heat ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["force_x_N", "force_y_N", "Q_F_W", "gamma_st", "gamma_p", "gamma_c"])
def test_heat_switched_off(name: str) -> None:
    cold, warm = (solved(rolling(grid=24, creepage=CREEPAGE, heating=h)) for h in (MECHANICAL, Heating(deformation=False)))
    assert "heat" in cold.work["skipped"] and "heat" not in warm.work["skipped"]
    assert cold.coupled.scalars[name] == warm.coupled.scalars[name]
    assert np.isnan(cold.coupled.scalars["temperature_rise_max_lower_K"])
    assert "temperature_rise_lower" not in cold.coupled.fields
    assert transforms(warm) > transforms(cold)


def test_deformation_switched_off() -> None:
    problem = article_4_1(16)
    coupled = solve(problem)
    stiff = solve(replace(problem, heating=replace(problem.heating, deformation=False)))
    assert "deformation" in stiff.work["skipped"]
    for name in ("Q_F_W", "force_x_N", "gamma_p", "temperature_rise_max_lower_K"):
        assert stiff.coupled.scalars[name] == coupled.isothermal.scalars[name]
    assert transforms(coupled) > 2 * transforms(stiff)


def test_bulge_below_tolerance() -> None:
    problem = rolling(grid=32, creepage=CREEPAGE, heating=Heating())
    skipped = solve(problem)
    assert "deformation" in skipped.work["skipped"]
    # The same fixed point iterated for nothing.
    discretisation = Discretisation(DerivedQuantities(problem), (32, 32), problem.numerics.extent)
    start = fixed_point(discretisation, first_guess(discretisation, None, hot=False), Tolerances()).contact
    state = fixed_point(discretisation, first_guess(discretisation, start, hot=True), Tolerances())
    assert state.converged and state.acts_back
    # Against the same solver without the bulge: Hertz's closed form differs from both by the discretisation.
    cold = discretisation.press(np.zeros(discretisation.grid.shape), start.normal, 1e-7)
    assert state.contact.normal.peak == pytest.approx(cold.peak, rel=STANDARD_ACCURACY)
    assert state.contact.normal.covered.sum() == pytest.approx(cold.covered.sum(), rel=STANDARD_ACCURACY)
    rolled = discretisation.roll(cold, start.tangential, 1e-5)
    change = np.abs((state.contact.tangential.traction - rolled.traction).sum(axis=(1, 2))) * discretisation.grid.element_area
    assert change.max() < STANDARD_ACCURACY * problem.traction_limit


def test_bulge_above_tolerance_is_not_skipped() -> None:
    assert make_plan(article_4_1(32)).runs("deformation")


@pytest.mark.parametrize("upper", [
    STEEL, replace(STEEL, expansion=2e-5), pytest.param(replace(STEEL, poisson_ratio=0.45), marks=pytest.mark.slow)])
@pytest.mark.parametrize("bulk", [0.0, 40.0])
def test_the_bulge_is_estimated_before_anything_is_solved(upper: Material, bulk: float) -> None:
    """To a tenth where the contact slides as a whole; what conduction adds is added in full."""
    heating = Heating(partition="matched", bulk_lower=bulk)
    problem = replace(twin_disc(16, motion=Motion(2.0, 0.05)), upper=upper, heating=heating)
    bulge = 1e-6 * solve(problem).isothermal.scalars["thermal_displacement_max_um"]
    assert 0.9 * bulge < bulge_bound(DerivedQuantities(problem)) < (1.1 if not bulk else 1.6) * bulge


def test_the_effect_of_the_bulge_is_bounded_where_the_contact_slides_in_part() -> None:
    """At little heat, made on one side: the bound of what it changes is not twice as large as what it does."""
    problem = article_4_1(32, speed=10.0)
    result = solve(problem)
    change = max(abs(result.coupled.scalars[name] / result.isothermal.scalars[name] - 1.0) for name in ("gamma_p", "gamma_c"))
    assert change < deformation_effect(DerivedQuantities(problem)) < 2.0 * change


# --- equal bodies ----------------------------------------------------------------------------------------------------


def test_equal_bodies_share_thermal_kernels() -> None:
    grid = Grid.over((24, 24), 1e-3, 1e-3)
    body = HeatedBody(50.0, 1.3 * 11.7e-6, 1e-5, 1.0)
    other = replace(body, diffusivity=body.diffusivity * (1.0 + 1e-12))
    flux = np.random.default_rng(1).random(grid.shape)
    heat = DividedHeat(flux, 0.4)
    shared, apart = HeatResponse(grid, body, body), HeatResponse(grid, body, other)
    np.testing.assert_allclose(shared.displacement(heat), apart.displacement(heat), rtol=1e-9)
    for a, b in zip(shared.temperatures(heat), apart.temperatures(heat), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9)


@pytest.mark.parametrize(("unlike", "tables"), [(1.0, 2), (1.0 + 1e-12, 4)], ids=["equal", "different"])
def test_each_kind_of_body_has_its_own_thermal_tables(unlike: float, tables: int, monkeypatch: pytest.MonkeyPatch) -> None:
    built = []
    heat_response.small_table.cache_clear()
    for table in (displacement_table, temperature_table):
        def counted(*place: float, table: Callable[..., Array] = table) -> Array:
            built.append(table)
            return table(*place)

        monkeypatch.setattr(heat_response, table.__name__, counted)
    grid, body = Grid.over((24, 24), 1e-3, 1e-3), HeatedBody(50.0, 1.3 * 11.7e-6, 1e-5, 1.0)
    response = HeatResponse(grid, body, replace(body, diffusivity=unlike * body.diffusivity))
    heat = DividedHeat(np.ones(grid.shape), 0.4)
    response.displacement(heat)
    response.temperatures(heat)
    assert len(built) == tables


def test_equal_elastic_constants_need_no_iteration_of_pressure_and_shear() -> None:
    upper = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * (1.0 + 1e-4))
    equal = rolling(grid=32, creepage=CREEPAGE)
    nearly = replace(equal, upper=upper)
    one, other = solve(equal), solve(nearly)
    assert "elastic coupling" in one.work["skipped"] and "elastic coupling" not in other.work["skipped"]
    assert "normal (isothermal)" in one.work["skipped"]
    for name in ("force_x_N", "force_y_N"):
        assert one.coupled.scalars[name] == pytest.approx(other.coupled.scalars[name], abs=1e-3 * equal.traction_limit)
    assert transforms(other) > transforms(one)


def test_hertz_pressure_is_not_solved_for() -> None:
    discretisation = Discretisation(DerivedQuantities(rolling(grid=64)), (64, 64), 2.2)
    exact = discretisation.isothermal_pressure
    solved = discretisation.press(np.zeros(discretisation.grid.shape), exact, 1e-7)
    assert np.abs(solved.pressure - exact.pressure).max() < 5e-3 * exact.pressure.max()
    assert solved.approach == pytest.approx(exact.approach, rel=1e-3)
    assert solved.iterations > 0


# --- operator --------------------------------------------------------------------------------------------------------


def test_no_cross_terms_without_lateral_contraction() -> None:
    traction = np.random.default_rng(2).standard_normal((2, 20, 14))
    plain, tiny = (RollingGradient((20, 14), 1e-5, 1e-5, Bodies.of_shear(ShearCompliance(1e-12, d))) for d in (0.0, 1e-30))
    np.testing.assert_allclose(plain(traction), tiny(traction), rtol=0.0, atol=1e-13 * np.abs(plain(traction)).max())
    # Only one component is loaded: the other one stays exactly zero.
    traction[1] = 0.0
    assert not plain(traction)[1].any()


def test_bounding_box_of_the_contact() -> None:
    # The same elements in a domain of twice the size.
    small, large = (solve(rolling(grid=n, extent=e, creepage=CREEPAGE)) for n, e in ((16, 2.2), (32, 4.4)))
    inner = slice(8, 24)
    for name in ("pressure", "shear_x", "shear_y", "slip_x"):
        expected = small.coupled.fields[name]
        np.testing.assert_allclose(large.coupled.fields[name][inner, inner], expected, atol=2e-4 * np.abs(expected).max())
    sizes = []
    for n, e in ((16, 2.2), (32, 4.4)):
        discretisation = Discretisation(DerivedQuantities(rolling(grid=n, extent=e)), (n, n), e)
        contact = discretisation.isothermal_pressure.contact
        sizes.append(discretisation.traction.window_around(contact, None).shape)
    assert sizes[0] == sizes[1]


def test_contact_s_box_serves_smaller_contacts() -> None:
    discretisation = Discretisation(DerivedQuantities(rolling(grid=32)), (32, 32), 2.2)
    contact = discretisation.isothermal_pressure.contact
    solver = discretisation.traction.solver_of(discretisation.traction.window_around(contact, None))
    contact = contact.copy()
    contact[:8] = False
    window = discretisation.traction.window_around(contact, None)
    assert discretisation.traction.solver_of(window) is solver, "kernels and plans are kept"

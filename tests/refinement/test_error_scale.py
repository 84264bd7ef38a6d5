"""One meaning of `error` per scalar, and what has none."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.support.scenes import STEEL, rolling
from thermoroll_cli.problem.names import SCALARS
from thermoroll_cli.problem.problem import Heating
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import TEMPERATURES, absolute_error, error_scale
from thermoroll_cli.refinement.solve import solve
from thermoroll_cli.steady_state.derived import DerivedQuantities

HOT = rolling(grid=32, creepage=(1e-3, 4e-4), spin=0.2, speed=2.0, heating=Heating(bulk_upper=30.0))


@pytest.fixture(scope="module")
def hot() -> Result:
    return solve(HOT)


def test_every_error_turns_into_the_unit_of_its_scalar(hot: Result) -> None:
    """Against the documented table, scalar by scalar."""
    s = hot.summary()
    radius = DerivedQuantities(HOT).hertz.mean_radius
    limit = 0.3 * 65.0
    special = {
        "force_x_N": limit, "force_y_N": limit, "spin_moment_Nmm": limit * radius * 1e3, "gamma_st": 1.0,
        "stick_area_mm2": s["contact_area_mm2"],
        # Fixed partition: rises far below the 30 K between the bodies.
        **dict.fromkeys(TEMPERATURES, 30.0),
    }  # fmt: skip
    given = {"creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm", "partition_mean", "power_balance_error",
             "heat_conducted_W",
             *(f"{what}_{body}_K" for what in ("bulk_temperature", "entry_temperature_max") for body in ("lower", "upper"))}
    assert set(s["error"]) == set(SCALARS)
    for name in (n for n in SCALARS if n in given or not math.isnan(s[n])):
        if name in given:
            assert math.isnan(s["error"][name]) and math.isnan(absolute_error(name, s)), name
        else:
            assert absolute_error(name, s) == pytest.approx(s["error"][name] * special.get(name, abs(s[name])), rel=1e-12), name
            assert s["error"][name] > 0.0, name


def test_temperatures_count_against_the_largest_rise_where_bulk_temperatures_are_equal(hot: Result) -> None:
    s = {**hot.summary(), "surface_temperature_max_upper_K": hot.coupled.scalars["temperature_rise_max_upper_K"]}
    hottest = max(s["temperature_rise_max_lower_K"], s["temperature_rise_max_upper_K"])
    assert error_scale("temperature_rise_max_lower_K", s) == hottest


def test_a_prescribed_force_has_no_error_and_the_creepage_found_has_one() -> None:
    result = solve(rolling(grid=32, creepage=(None, 0.0), force=(8.0, None), body=replace(STEEL, poisson_ratio=0.3)))
    assert math.isnan(result.error["force_x_N"]) and math.isnan(result.error["creepage_lateral"])
    assert 0.0 < result.error["creepage_longitudinal"] < 0.1
    assert error_scale("creepage_longitudinal", result.summary()) == result.coupled.scalars["creepage_longitudinal"]


def test_results_of_other_programs_lack_a_scale() -> None:
    """JSON writes nan as null, older files have no friction limit."""
    assert math.isnan(absolute_error("force_x_N", {"error": {"force_x_N": 1e-3}}))
    assert math.isnan(absolute_error("Q_F_W", {"Q_F_W": None, "error": {"Q_F_W": 1e-3}}))

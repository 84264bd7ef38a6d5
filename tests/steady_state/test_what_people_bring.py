"""Cases that people brought and that no generator draws."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.support.cases import parse
from tests.support.command_line import THERMAL
from tests.support.scenes import article_4_1, rolling
from thermoroll_cli import Case
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.doubts import warnings_before
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Heating, ReturningTrack
from thermoroll_cli.python_api import solve

COATED = THERMAL.replace("[geometry]", """
[[material.upper.layers]]
thickness_um = 5.0
youngs_modulus_GPa = 100.0
poisson_ratio = 0.2
[[material.upper.layers]]
thickness_um = 15.0
youngs_modulus_GPa = 100.0
poisson_ratio = 0.2
[geometry]""").replace("conductivity_W_mK = 50.2\nexpansion_um_mK = 11.7\ndiffusivity_mm2_s = 10.0\n", "")


def test_layers_of_one_material_that_touch_are_one() -> None:
    split, (layer,) = parse(COATED).problem, parse(COATED).problem.upper.layers
    whole = parse(COATED.replace("thickness_um = 5.0", "thickness_um = 20.0", 1).replace(
        "[[material.upper.layers]]\nthickness_um = 15.0\nyoungs_modulus_GPa = 100.0\npoisson_ratio = 0.2\n", "")).problem
    assert layer.thickness == pytest.approx(20e-6) and replace(split, upper=whole.upper) == whole


def test_a_negative_speed_is_refused() -> None:
    with pytest.raises(Unsolvable, match="negative"):
        solve(replace(article_4_1(8), motion=replace(article_4_1(8).motion, speed=-1.0)))


def test_a_conformal_contact_carries_what_its_whole_pressure_carries() -> None:
    """A force between μW and μ∫p slides everywhere, or sticks in a little place, and is no fault."""
    groove = Case.from_dict({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28},
        "geometry": {"lower_radius_x_mm": float("inf"), "lower_radius_y_mm": -10.3, "upper_radius_x_mm": 10.0,
                     "upper_radius_y_mm": 10.0, "conformal": True},
        "load": {"normal_N": 2000.0, "friction_coefficient": 0.3}, "rolling": {"speed_m_s": 1.0},
        "thermal": {"heat": False}, "numerics": {"grid": [12, 24]}})  # fmt: skip
    sliding = solve(groove.with_values({"creepage.longitudinal": 0.2}).problem)
    most = sliding["force_x_N"]
    assert most > 1.003 * 600.0
    found = solve(groove.with_values({"force.longitudinal_N": 600.0 + 0.5 * (most - 600.0)}).problem)
    assert found.converged, found.reason
    beyond = solve(groove.with_values({"force.longitudinal_N": 1.001 * most}).problem)
    assert not beyond.converged and "less than the prescribed" in beyond.reason


def test_heat_that_returns_to_one_of_two_turning_bodies_is_doubtful() -> None:
    problem = rolling(grid=16, creepage=(0.01, 0.0), speed=3.0, heating=Heating())
    track = ReturningTrack(width=10e-3, resistance=4.0)
    heating = replace(problem.heating, partition="matched", peclet="rolling", lower_track=track)
    one, both = (replace(problem, heating=each) for each in (heating, replace(heating, upper_track=track)))
    said = [[text for text in warnings_before(DerivedQuantities(each)) if "returns to the contact on the lower" in text]
            for each in (one, both)]
    assert len(said[0]) == 1 and not said[1]



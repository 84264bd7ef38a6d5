"""Scalars that vanish by physics spoil no run, and a body that only cools is reported as such."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.scenes import rolling
from thermoroll_cli.numerics.grid import peak_value
from thermoroll_cli.problem.problem import Heating, Material, Numerics, Problem
from thermoroll_cli.refinement.solve import solve

CERAMIC = Material(310e9, 0.26, 30.0, 3.2e-6, 11.7e-6)


def hybrid_bearing(**numerics: float) -> Problem:
    """A ceramic ball at 80 K above the reference on a steel ring at 70 K, that slips so little that the ball only cools."""
    problem = rolling(creepage=(1e-5, 0.0), speed=5.0, heating=Heating(partition="matched", bulk_lower=70.0, bulk_upper=80.0))
    return replace(problem, upper=CERAMIC, numerics=Numerics(**numerics))


def test_a_body_that_only_cools_does_not_spoil_the_accuracy() -> None:
    # 1e-3 is reached on 512 elements: exchanged heat is of first order at the border of its area, and so is its estimate.
    result = solve(hybrid_bearing(accuracy=3e-3))
    scalars = result.coupled.scalars
    assert result.converged, result.reason
    assert max(result.work["grid"]) <= 256
    assert result.coupled.fields["temperature_rise_upper"].min() < -3.0
    assert scalars["temperature_rise_max_upper_K"] == 0.0
    assert scalars["surface_temperature_max_upper_K"] == 80.0
    assert scalars["surface_temperature_max_lower_K"] == 70.0 + scalars["temperature_rise_max_lower_K"]
    assert 0.0 < scalars["temperature_rise_max_lower_K"] < 10.0


def test_no_maximum_looks_across_the_edge_of_a_plateau() -> None:
    """Bulk temperatures 0 and 150 K without slip: both surfaces are at 75 K wherever equal bodies touch."""
    problem = rolling(grid=32, speed=2.0, heating=Heating(partition="matched", bulk_upper=150.0))
    for grid in (24, 32, 48):
        result = solve(replace(problem, numerics=Numerics((grid, grid))))
        highest = result.coupled.fields["temperature_rise_lower"].max()
        reported = result.coupled.scalars["temperature_rise_max_lower_K"]
        assert highest == pytest.approx(75.0, abs=0.01)
        assert highest <= reported <= highest + 0.05, grid


def test_the_peak_of_a_smooth_field_is_found_between_elements() -> None:
    edges = np.linspace(-1.0, 1.0, 41) + 0.013
    averages = np.diff(edges - edges**3 / 3.0) / np.diff(edges)
    field = averages[:, None] * averages[None, :]
    assert field.max() < 0.9995
    assert peak_value(field) == pytest.approx(1.0, abs=2e-6)

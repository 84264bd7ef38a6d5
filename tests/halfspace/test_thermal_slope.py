"""Heat that changes linearly within its element: its kernel, and what it is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.scenes import rolling
from thermoroll_cli.halfspace.thermal import slopes, temperature_at, temperature_slope_table, temperature_table
from thermoroll_cli.problem.problem import Geometry, Heating
from thermoroll_cli.refinement.solve import solve


@pytest.mark.parametrize("peclet", [(0.0, 0.0), (0.1, 0.0), (2.0, 0.5), (-3.0, 0.0), (300.0, 0.0)])
def test_a_slope_is_many_narrow_sources(peclet: tuple[float, float]) -> None:
    """An element of 81 uniform slices with the slope's first moment: within 3e-5 of an element on itself."""
    nx, ny, aspect, parts = 6, 4, 0.7, 81
    x, y = np.arange(1.0 - nx, nx), aspect * np.arange(1.0 - ny, ny)
    expected = np.zeros((len(x), len(y)))
    for place in (np.arange(parts) - parts // 2) / parts:
        one = temperature_at(parts * (x - place), parts * y, parts * aspect, peclet[0] / parts, peclet[1] / parts)
        expected += place * one / parts
    expected *= parts**2 / (parts**2 - 1.0)
    scale = temperature_table(nx, ny, aspect, *peclet).max()
    assert np.abs(temperature_slope_table(nx, ny, aspect, *peclet) - expected).max() < 3e-5 * scale


def test_slopes_stay_inside_the_heated_rows() -> None:
    flux = np.array([0.0, 1.0, 4.0, 5.0, 5.0, 0.0, 2.0, 0.0])[:, None]
    assert slopes(flux)[:, 0].tolist() == [0.0, 2.0, 2.0, 0.5, 0.0, 0.0, 0.0, 0.0]  # 3 would make the flux negative


def test_narrow_slip_zones_are_as_hot_as_on_fine_grids() -> None:
    """Wheel on rail at a fifth of saturation: heat from the last sixth of the contact, 9 elements at N = 64 (with constant
    flux in each element 7e-3 too cold there, and still 2e-3 at N = 128)."""
    geometry = Geometry(float("inf"), 0.3, 0.5, -0.4)
    problem = rolling(geometry=geometry, load=1e5, creepage=(5e-4, 0.0), speed=30.0, heating=Heating(deformation=False))
    hottest = {}
    for grid in (64, 128, 192):
        result = solve(replace(problem, numerics=replace(problem.numerics, grid=(grid, grid))))
        hottest[grid] = result.coupled.scalars["temperature_rise_max_lower_K"]
    assert hottest[64] == pytest.approx(hottest[192], rel=1.5e-3)
    assert hottest[128] == pytest.approx(hottest[192], rel=4e-4)

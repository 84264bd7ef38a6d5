"""Examples that come with CONTACT, solved here: temperatures after Ertz & Knothe, and a locomotive's creep curve.

CONTACT's own figure for the first, 166.8 K with elements of 0.2 mm, doubles the share of the element itself in its temperature
sum, so that its error falls like the square root of the element: with 0.2, 0.1 and 0.05 mm it gives 166.8, 162.7, 159.7 K.
"""

from __future__ import annotations

import math

import pytest

from tests.support.documents import printed
from tests.support.scenes import MECHANICAL, rolling
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

RAIL = Material(210e9, 0.3, 50.0, 11.7e-6, 50.0 / (450.0 * 7850.0))
WHEEL_ON_RAIL = Geometry(math.inf, 0.3, 0.5, -0.4)
"""Semi-axes 5.88 mm and 10.54 mm under 100 kN."""


def ertz_and_knothe(creepage: float, bulk: float) -> Result:
    heating = Heating(deformation=False, partition="matched", bulk_upper=bulk)
    return solve(rolling(grid=64, geometry=WHEEL_ON_RAIL, body=RAIL, load=1e5, friction=0.3, creepage=(creepage, 0.0),
                         speed=30.0, heating=heating))


@pytest.mark.parametrize(
    ("creepage", "bulk", "hottest"), [(1.0 / 30.0, 0.0, 152.8), (0.0, 150.0, 75.0), (1.0 / 30.0, 150.0, 227.8 - 0.6)]
)
def test_ertz_and_knothe(creepage: float, bulk: float, hottest: float) -> None:
    """Sliding at 1 m/s, a wheel 150 K warmer than the rail, and both: hottest rail, against CONTACT refined (within 0.3 K).

    CONTACT moves both bodies at 30 m/s, so that they meet at 75 K, and finds 227.8 K for both together. Here the rail passes at
    30.5 m/s and the wheel at 29.5 m/s: 150 K sqrt(29.5)/(sqrt(29.5) + sqrt(30.5)) = 74.4 K, 0.6 K less."""
    result = ertz_and_knothe(creepage, bulk)
    assert result.of_problem["hertz_a_mm"] == pytest.approx(5.88, abs=0.01)
    assert result.of_problem["hertz_b_mm"] == pytest.approx(10.54, abs=0.01)
    found = result.coupled.scalars["surface_temperature_max_lower_K"]
    assert found == pytest.approx(hottest, abs=0.3)
    if creepage:
        value, rounding = printed("verification", "227.1 K." if bulk else "152.7 K, and one 150 K warmer")[0]
        assert found == pytest.approx(value, abs=rounding)


@pytest.mark.parametrize(("creepage", "contact"), [(4e-4, 9143.0), (1.2e-3, 22870.0), (2.4e-3, 33340.0), (4.8e-3, 35180.0)])
def test_creep_curve_of_a_locomotive(creepage: float, contact: float) -> None:
    """Eurosprinter, 106.7 kN: CONTACT's forces on 44 × 44 elements, too high by its first order, most where most sticks."""
    steel = Material(209.92e9, 0.28)
    geometry = Geometry(math.inf, math.inf, 0.625, 1.77672)
    problem = rolling(grid=48, geometry=geometry, body=steel, load=106.7e3, friction=0.33, creepage=(creepage, 0.0),
                      heating=MECHANICAL)
    force = solve(problem).coupled.scalars["force_x_N"]
    assert 0.981 * contact < force < 1.001 * contact

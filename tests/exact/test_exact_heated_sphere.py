"""The coupled contact of a sphere that slides and heats itself: against others, against its own equations, its limits."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from tests.support.sampling import sampled
from tests.support.scenes import reference
from thermoroll_cli.exact.heated_sphere import gap_residual, heated_sphere
from thermoroll_cli.exact.hertz import hertz_contact

MODULUS = 210e9 / (1 - 0.28**2) / 2
CURVATURE = 2 / 0.03
PER_SLIP = 1.28 * 11.7e-6 / 50.2


def state(slip_speed, terms=12):
    """Equal steel spheres of 30 mm under 65 N, μs = `slip_speed`."""
    return heated_sphere(MODULUS, CURVATURE, 65.0, PER_SLIP * slip_speed, terms)


@pytest.mark.parametrize("case", sampled(reference("heated_sphere")["cases"], 4), ids=lambda c: f"{c['Q_F_W']} W")
def test_matches_the_independent_solution(case):
    """The reference states γ_p to 1e-7 at the lowest heat and 1e-5 at the highest."""
    found = state(case["Q_F_W"] / 65.0)
    assert found.peak_ratio == pytest.approx(case["gamma_p"], rel=1e-6)
    assert found.area_ratio == pytest.approx(case["gamma_c"], rel=6e-5)
    assert found.radius / found.radius_cold == pytest.approx(case["radius_over_a0"], rel=3e-5)
    assert found.centre_temperature(case["Q_F_W"] / 2, 50.2) == pytest.approx(case["temperature_rise_centre_K"], rel=1e-6)


def test_closes_the_gap_and_has_converged():
    heat = 160.0 / 65.0
    found, fewer = state(heat), state(heat, 8)
    inside = np.linspace(0.01, 0.99, 40) * found.radius
    approach = 0.5 * CURVATURE * found.radius_cold**2
    assert np.abs(gap_residual(found, CURVATURE, PER_SLIP * heat, inside)).max() < 2e-5 * approach
    assert np.abs(gap_residual(found, CURVATURE, 0.99 * PER_SLIP * heat, inside)).max() > 1e-3 * approach
    assert found.peak_ratio == pytest.approx(fewer.peak_ratio, rel=1e-6)
    assert np.all(found.pressure(inside) > 0.0)
    carried = quad(lambda r: 2 * math.pi * r * float(found.pressure(r)), 0.0, found.radius)[0]
    assert carried == pytest.approx(65.0, rel=1e-6)


def test_without_heat_it_is_hertz():
    found, hertz = state(0.0), hertz_contact(CURVATURE, CURVATURE, MODULUS, 65.0)
    assert found.radius == pytest.approx(hertz.semi_axis_x, rel=1e-9)
    assert found.peak_ratio == pytest.approx(1.0, rel=1e-8)
    r = np.linspace(0.0, 0.99, 30) * hertz.semi_axis_x
    assert found.pressure(r) == pytest.approx(hertz.pressure(r, 0.0), rel=1e-6)

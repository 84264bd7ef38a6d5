"""Strong heat: the coupled states that are known exactly, from a cold start, and honest words where nothing is found."""

import numpy as np
import pytest

from tests.support.scenes import reference, rolling, solved
from thermoroll_cli.model.problem import Heating

CASES = {case["Q_F_W"]: case for case in reference("heated_sphere")["cases"]}


def sliding(heat, grid):
    """Spheres that slide as a whole and make `heat` W, sources at rest."""
    speed = heat / 65.0 / 1e-4
    return rolling(grid=grid, friction=1e-4, creepage=(1.0, 0.0), speed=speed, heating=Heating(peclet="stationary"))


def work(result):
    """Transforms on all grids, each as much as its elements."""
    return sum(level["transforms"] * level["grid"][0] * level["grid"][1] for level in result.work["levels"])


@pytest.mark.parametrize("heat", CASES)
def test_exact_states(heat):
    """At N = 128 from a cold start: γ_p to 3e-4, ΔT to 5e-4, γ_c to 2e-3, within the estimates, at bounded work."""
    result, known = solved(sliding(heat, 128)), CASES[heat]
    assert result.converged, result.reason
    for name, key, tolerance in (("gamma_p", "gamma_p", 3e-4), ("gamma_c", "gamma_c", 2e-3),
                                 ("temperature_rise_max_lower_K", "temperature_rise_centre_K", 5e-4)):
        error = abs(result.coupled.scalars[name] / known[key] - 1.0)
        assert error < tolerance
        assert error < 2.0 * result.error[name]
    assert result.coupled.scalars["Q_F_W"] == pytest.approx(heat, rel=2e-5)
    assert work(result) < 8.0 * work(solved(sliding(11.28, 128)))


def test_the_domain_follows_a_contact_that_shrinks():
    """At 160 W it is a quarter as wide; both states are told on the same part of the surface, and the load is carried there."""
    result = solved(sliding(160, 64))
    assert result.converged, result.reason
    assert result.work["extent"] == 2.2 and 0.5 < result.work["extent_coupled"] < 0.9
    assert any("little of the domain" in warning for warning in result.warnings)
    inside = result.coupled.fields["state"] > 0
    assert np.count_nonzero(inside.any(axis=1)) > 30
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    assert result.coupled.fields["pressure"].sum() * area == pytest.approx(65.0, rel=1e-6)
    assert result.isothermal.scalars["gamma_c"] == pytest.approx(1.0, rel=1e-3)
    cold = result.isothermal.fields["pressure"]
    assert cold.shape == inside.shape and cold.min() > 0.6 * 1e6 * result.hertz["hertz_p0_MPa"]
    assert (result.isothermal.fields["state"] == 2).all()


def test_a_contact_that_keeps_its_size_keeps_its_domain():
    result = solved(sliding(11.28, 64))
    assert result.work["extent"] == result.work["extent_coupled"] == 2.2 and not result.warnings

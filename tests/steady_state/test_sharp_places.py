"""Kinks and ends of profiles: no value that the grid makes up, and a warning that names the place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.errors import relative
from tests.support.profiles import below, points
from tests.support.sampling import sampled
from tests.support.scenes import rolling
from thermoroll_cli.one_contact.refinement.sharp_places import PEAKS
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.python_api import solve

ROOF = Profile(points=((-3e-3, -3e-5), (0.0, 0.0), (3e-3, -3e-5)), interpolation="linear")


def roof(grid: int, profile: Profile = ROOF):
    geometry = Geometry(0.02, math.inf, 0.02, math.inf, upper_profile=profile)
    return solve(rolling(grid=grid, geometry=geometry, load=100.0, creepage=(1e-3, 0.0), differential_slip=True))


def test_a_kink_in_the_middle_is_the_same_on_even_and_odd_grids():
    """The slope at y = 0 is the mean of both sides: the limit of a kink that is rounded over less and less."""
    even, odd = roof(32), roof(33)
    for result in (even, odd):
        assert result.converged
        assert result.coupled.scalars["force_y_N"] == pytest.approx(0.0, abs=1e-6)
        assert result.coupled.scalars["spin_moment_Nmm"] == pytest.approx(0.0, abs=1e-6)
    difference = even.coupled.scalars["force_x_N"] - odd.coupled.scalars["force_x_N"]
    assert abs(difference) < 30.0 * (relative(even)["force_x_N"] + relative(odd)["force_x_N"])
    y = np.linspace(-3e-3, 3e-3, 601)
    blunt = roof(32, Profile(points=tuple(zip(y.tolist(), (-0.01 * (np.hypot(y, 1e-5) - 1e-5)).tolist(), strict=True))))
    assert even.coupled.scalars["force_x_N"] == pytest.approx(blunt.coupled.scalars["force_x_N"], rel=5e-3)


def test_a_kink_in_the_contact_has_no_limit():
    result = roof(32)
    assert set(result.unbounded) == set(PEAKS)
    assert all(math.isnan(relative(result)[name]) for name in PEAKS)
    assert any("kink of 20 mrad at y = 0 mm" in warning for warning in result.warnings)
    # It does grow: by the share that the warning says.
    grown = roof(64).coupled.scalars["pressure_max_MPa"] / result.coupled.scalars["pressure_max_MPa"]
    assert 1.05 < grown < 1.25


def test_kinks_that_are_no_edges_or_outside_do_not_count():
    hollow = Profile(points=((-3e-3, 3e-5), (0.0, 0.0), (3e-3, 3e-5)), interpolation="linear")
    assert hollow.kinks == ()
    y = np.linspace(-3.0, 3.0, 601)
    fine = below(Profile(tuple(zip((1e-3 * y).tolist(), (-1e-3 * y**2 / 160.0).tolist(), strict=True)), "linear"), 0.02)
    result = solve(rolling(grid=16, geometry=fine, load=100.0))
    assert result.unbounded == () and not any("kink" in warning for warning in result.warnings)


@pytest.mark.parametrize(("drop", "tilt", "resolved"), [(1.5e-6, 4e-4, True), (0.7e-6, 2e-4, False), (12e-6, 0.0, True)])
def test_the_end_of_a_crown_is_resolved_or_said(drop, tilt, resolved):
    """A crown with little drop carries a peak that is narrower than an element; no single element at an end is the largest."""
    geometry = below(Profile(length=0.012, drop=drop, tilt=tilt), 0.009)
    result = solve(rolling(grid=48, geometry=geometry, load=2500.0))
    assert math.isfinite(relative(result)["pressure_max_MPa"]) is resolved
    if tilt == 4e-4:
        assert result.coupled.scalars["pressure_max_MPa"] == pytest.approx(1083.0, rel=5e-3)
    assert any("part within an element at y = 6 mm" in warning for warning in result.warnings) is not resolved
    assert result["pressure_max_MPa"] >= 1e-6 * result.fields["pressure"].max()
    assert result.unbounded == ()


def test_a_patch_of_three_elements_is_said():
    """A wide ridge beside a steep one that the first domain holds, too."""
    both = points(lambda y: -np.minimum((y + 2.0) ** 2 / 80.0, (y - 2.0) ** 2 / 0.5 + 0.002), -4.0, 4.0, 801)
    result = solve(rolling(grid=16, geometry=below(both, 0.02), load=300.0))
    assert any("3 elements wide, too few" in warning for warning in result.warnings)
    assert math.isnan(relative(result)["pressure_max_MPa"])


def test_many_small_patches_are_one_warning():
    """Ridges as of a noisy profile, each one or two elements wide."""
    ridges = points(lambda y: -(np.round(y) ** 2 / 4000.0 + (y - np.round(y)) ** 2 / 0.5), -4.0, 4.0, 1601)
    result = solve(rolling(grid=32, geometry=below(ridges, 0.02), load=300.0))
    few = [warning for warning in result.warnings if "too few for its largest pressure (" in warning]
    assert len(result.patches) > 3 and len(few) == 1 and "such places)" in few[0]


@pytest.mark.parametrize("seed", sampled(range(3), 3))
def test_the_largest_pressure_of_a_rough_profile_is_that_of_its_field_or_above(seed):
    """Noise of a few micrometres makes lobes of a few elements, whose largest ones may lie at their border."""
    rough = np.random.default_rng(seed).normal(0.0, 2e-3, 161)
    y = np.linspace(-8.0, 8.0, 161)
    profile = Profile(points=tuple(zip((1e-3 * y).tolist(), (1e-3 * (rough - y**2 / 200.0)).tolist(), strict=True)))
    result = solve(rolling(grid=32, geometry=below(profile, 0.4), load=4e4, creepage=(1e-3, 0.0)))
    field = 1e-6 * result.fields["pressure"].max()
    assert result["pressure_max_MPa"] >= field
    assert result["pressure_max_MPa"] == max(patch["pressure_max_MPa"] for patch in result.patches)
    assert result["shear_max_MPa"] >= 1e-6 * np.hypot(result.fields["shear_x"], result.fields["shear_y"]).max()
    if math.isnan(relative(result)["pressure_max_MPa"]):
        assert any("which has no error estimate" in each or "too few" in each or "kink" in each for each in result.warnings)


@pytest.mark.parametrize("grid", [32, 48, 64])
def test_the_largest_pressure_is_never_below_that_of_a_patch(grid):
    """Crowns of 20 and 1 mm side by side: the second is one to three elements wide."""
    both = points(lambda y: -np.minimum((y + 2.0) ** 2 / 40.0, (y - 2.0) ** 2 / 2.0), -4.0, 4.0, 801)
    result = solve(rolling(grid=grid, geometry=below(both, 0.02), load=1000.0, creepage=(1e-2, 0.0)))
    scalars, parts = result.coupled.scalars, [patch["pressure_max_MPa"] for patch in result.patches]
    assert len(parts) == 2 and parts[1] > 1.2 * parts[0]
    assert scalars["pressure_max_MPa"] == max(parts) and scalars["gamma_p"] == pytest.approx(1.0, rel=1e-9)
    assert scalars["shear_max_MPa"] == pytest.approx(0.3 * max(parts), rel=0.1)
    assert math.isnan(relative(result)["pressure_max_MPa"])
    assert any("elements wide, too few" in warning for warning in result.warnings)

"""The Manchester contact benchmark beside CONTACT, whose forces are good to some 5 % and pressures to 1 %."""

import pytest

from scripts.manchester import ROOT, case_beside, contact_results
from thermoroll_cli import Case, solve

NEAR = [result for result in contact_results() if result["lateral_displacement_mm"] in (0.0, 2.0, 6.0)]


@pytest.mark.parametrize("theirs", NEAR, ids=lambda result: f"{result['lateral_displacement_mm']:g} mm")
def test_wheel_on_rail(theirs):
    case: Case = case_beside(theirs).with_values({"numerics.grid": [48, 48]})
    result = solve(case)
    assert result.converged, result.reason
    s, limit = result.coupled.scalars, 0.3 * theirs["normal_N"]
    assert s["pressure_max_MPa"] == pytest.approx(theirs["pressure_max_MPa"], rel=0.02)
    assert s["approach_um"] == pytest.approx(1e3 * theirs["approach_mm"], rel=0.01)
    assert s["force_x_N"] == pytest.approx(theirs["force_x_N"], abs=0.005 * limit)
    assert s["force_y_N"] == pytest.approx(theirs["force_s_N"], abs=0.005 * limit)


def test_the_case_is_that_of_4_mm():
    (theirs,) = (result for result in contact_results() if result["lateral_displacement_mm"] == 4.0)
    own, made = Case.read(ROOT / "cases" / "manchester.toml"), case_beside(theirs)
    assert made.problem.motion == own.problem.motion
    assert made.problem.geometry.upper_profile.offset == pytest.approx(own.problem.geometry.upper_profile.offset)
    assert made.problem.geometry.lower_profile.offset == pytest.approx(own.problem.geometry.lower_profile.offset)

"""Wheels and rails as instruments measured them: wheelsets that rest on them, and their equivalent conicity."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scripts.stress.conicities import by_integration
from thermoroll_cli import Case, CaseError, conicity, solve
from thermoroll_cli.files.profile_file import read_outline

REFERENCE = Path(__file__).parents[1] / "reference"
FOLDER = REFERENCE / "measured_profiles"
CASES = Path(__file__).parents[2] / "cases"
WHEELS = ("Car7216_0001r.whl", "Car7358_0001r.whl", "avg_wheel.whl", "left-wheel-v1-pre-dry.whl", "whl_left_iter288.whl")
RAILS = ("avg_HR.BAN", "avg_low2.ban", "left-roller-v1-pre-dry.ban", "rail_left_iter288.ban")
SHIFTS = (0.0, 3.0, -5.0)
PAIRS = list(itertools.product(range(len(WHEELS)), range(len(RAILS))))
HARD = ("avg_wheel.whl", "avg_HR.BAN", -5.0)
"""A flange."""


def tables(wheel: dict[str, Any], rail: dict[str, Any], **wheelset: Any) -> dict[str, dict[str, Any]]:
    return {
        "material": {"youngs_modulus_GPa": 209.92, "poisson_ratio": 0.28},
        "track": {"rail_profile": rail, "gauge_mm": 1435.0, "gauge_height_mm": 14.0},
        "wheelset": {"wheel_profile": wheel, "nominal_radius_mm": 460.0, "flange_back_distance_mm": 1360.0,
                     "vertical_N": 100e3, **wheelset},
        "load": {"friction_coefficient": 0.3}, "rolling": {"speed_m_s": 20.0}, "thermal": {"heat": False},
        "numerics": {"grid": 32},
    }  # fmt: skip


def measured(wheel: str, rail: str, **wheelset: Any) -> dict[str, dict[str, Any]]:
    """A measured wheel on a measured rail with a cant of 1:20; its flange back is where the measurement begins."""
    back = min(y for y, _ in read_outline(FOLDER / wheel).content) + 0.05
    hand = {"mirror": True} if rail == "avg_HR.BAN" else {}
    case = tables({"file": str(FOLDER / wheel)}, {"file": str(FOLDER / rail), **hand}, flange_back_mm=back, **wheelset)
    case["track"]["cant"] = 0.05
    return case


@pytest.mark.parametrize(("wheel", "rail", "shift"), [
    HARD, *(pytest.param(*given, marks=pytest.mark.slow) for i, j in PAIRS
            if (given := (WHEELS[i], RAILS[j], SHIFTS[(i + j) % 3])) != HARD)])  # fmt: skip
def test_a_wheelset_rests_on_measured_profiles(wheel: str, rail: str, shift: float) -> None:
    """Each wheel on each rail, and each of them at each shift."""
    result = solve(Case.from_dict(measured(wheel, rail, lateral_shift_mm=shift)))
    assert result.converged, result.reason
    assert result["track_force_z_N"] == pytest.approx(1e5, rel=1e-3)
    # Patches lose a part of their power in elements that slip only in part; beyond that the angular velocity may leave a
    # ten-thousandth of the power of full sliding, 60 W.
    heat = result["Q_F_W"]
    lost = sum(patch["power_balance_error"] * patch["Q_F_W"] for patch in result.patches)
    assert result["power_balance_error"] * heat <= lost + 2e-3 * heat


@pytest.mark.slow
def test_a_search_for_tractions_that_stops_goes_on_with_another_residual() -> None:
    """Four contacts on one grid, in which hardly anything slips: the residual had a minimum of 9e-5 on this grid and not beside
    it."""
    case = measured("avg_wheel.whl", "left-roller-v1-pre-dry.ban", lateral_shift_mm=0.0)
    result = solve(Case.from_dict({**case, "numerics": {"grid": 96}}))
    assert result.converged, result.reason


@pytest.mark.slow
def test_two_patches_that_become_one_at_the_given_force_are_one_already() -> None:
    """As two, which displace each other like points, they carry less than 50 kN where they meet, as one they carry more."""
    case = measured("Car7358_0001r.whl", "rail_left_iter288.ban", lateral_shift_mm=-5.0)
    case["wheelset"]["flange_back_mm"] = 0.0
    case["numerics"]["grid"] = 16
    result = solve(Case.from_dict(case))
    assert result.converged, result.reason
    assert result["track_force_z_right_N"] == pytest.approx(50e3, rel=1e-3)
    assert [patch.name for patch in result.patches] == ["left_1", "right_1"]
    assert any("right_1: it holds 2 contacts" in warning for warning in result.warnings)


def agrees(found: Any) -> None:
    product = found.problem.contact_distance * found.mean_radius
    for amplitude, value in zip(found.amplitudes, found.conicity, strict=True):
        if np.isfinite(value):
            expected = by_integration(found.shifts, found.radius_difference, amplitude, product)
            assert value == pytest.approx(expected, rel=0.03, abs=0.01), amplitude


@pytest.mark.parametrize(("wheel", "rail"), [
    pair if pair == ("left-wheel-v1-pre-dry.whl", "left-roller-v1-pre-dry.ban")
    else pytest.param(*pair, marks=pytest.mark.slow)
    for pair in ((WHEELS[i], RAILS[j]) for i, j in PAIRS if (i + j) % 2 == 1)])  # fmt: skip
def test_measured_wheels_have_a_conicity(wheel: str, rail: str) -> None:
    found = conicity(measured(wheel, rail), [1.0, 2.0, 3.0, 5.0])
    assert np.isfinite(found.conicity[:3]).all(), found.warnings
    assert np.isfinite(found.conicity[3]) or any("beyond the profiles" in text for text in found.warnings)
    agrees(found)
    assert len(repr(found)) < 100 and "at 3 mm, 4 amplitudes from 1 to 5 mm" in repr(found)


@pytest.mark.slow
@pytest.mark.parametrize(("depth", "expected"), [
    (0.4, 0.23), pytest.param(0.9, 0.33, marks=pytest.mark.slow), pytest.param(1.4, 0.55, marks=pytest.mark.slow)])
def test_a_hollow_wheel_has_the_conicity_of_the_orbit_over_both_wells(depth: float, expected: float) -> None:
    y, z = np.array(read_outline(CASES / "MBench_S1002_v3.prw").content).T
    hollow = np.stack((y, z - depth * np.exp(-(((y + 2.0) / 18.0) ** 2))), axis=1).tolist()
    case = tables({"points_mm": hollow}, {"file": str(CASES / "MBench_UIC60_v3.prr")}, flange_back_mm=-70.0)
    found = conicity(case, [1.0, 2.0, 3.0, 5.0])
    assert found.conicity[2] == pytest.approx(expected, abs=0.01)
    agrees(found)


@pytest.mark.parametrize("wheel", [
    "face_30_cone_0.05.whl",
    *(pytest.param(name, marks=pytest.mark.slow) for name in (
        "no_face_30_cone_0.05.csv", "header_numbers.whl", "face_12_cone_0.05.csv", "face_30_cone_0.05.csv"))])
def test_the_face_of_the_rim_and_its_edge_do_not_climb(wheel: str) -> None:
    """Only the flange climbs: a chamfer on the field side, however steep, changes no conicity. A rim that is measured further
    up than the flange is down turns nothing over."""
    folder = REFERENCE / "synthetic_profiles"
    case = tables({"file": str(folder / wheel)}, {"file": str(folder / "rail.csv")}, flange_back_mm=0.2)
    assert conicity(case, [1.0, 3.0]).conicity == pytest.approx([0.05, 0.05], abs=2e-4)


def test_a_rail_of_the_other_hand_is_named_with_the_key_that_mirrors_it() -> None:
    folder = REFERENCE / "synthetic_profiles"
    wheel, rail = ({"file": str(folder / name)} for name in ("plain_cone.csv", "rail_other_hand.csv"))
    warnings = conicity(tables(wheel, rail, flange_back_mm=0.2)).warnings
    assert sum("rail is known down to" in text and "mirror = true" in text for text in warnings) == 2
    found = conicity(tables(wheel, {**rail, "mirror": True}, flange_back_mm=0.2), [1.0, 3.0])
    assert found.conicity == pytest.approx([0.05, 0.05], abs=2e-4)


def test_an_outline_that_is_upside_down_is_turned_by_flip() -> None:
    y, z = np.array(read_outline(CASES / "MBench_S1002_v3.prw").content).T
    rail, turned = {"file": str(CASES / "MBench_UIC60_v3.prr")}, np.stack((y, -z), axis=1).tolist()
    with pytest.raises(CaseError, match=r"upside down[^@]*flip = true[^@]*mirror = true"):
        Case.from_dict(tables({"points_mm": turned}, rail))
    right, flipped = (Case.from_dict(tables(wheel, rail)).task for wheel in (
        {"points_mm": np.stack((y, z), axis=1).tolist()}, {"points_mm": turned, "flip": True}))
    assert flipped == right


def test_headers_and_decimal_commas_of_instruments() -> None:
    folder = REFERENCE / "synthetic_profiles"
    header = read_outline(folder / "header_numbers.whl")
    assert len(header.content) == 228 and max(z for _, z in header.content) == pytest.approx(24.5127)
    comma = read_outline(folder / "comma.ban")
    y, z = np.array(comma.content).T
    assert len(y) == 81 and (y.min(), y.max()) == (-20.0, 20.0)
    np.testing.assert_allclose(z - z.min(), y**2 / 600.0, atol=1e-3)


@pytest.mark.slow
def test_a_patch_at_the_end_of_a_profile_has_a_gap_up_to_its_limit() -> None:
    """The end of a rail of the other hand lies in a patch: iterated with other places, the last normal missed it."""
    case = measured("Car7216_0001r.whl", "avg_HR.BAN", lateral_shift_mm=-5.0)
    case["wheelset"]["flange_back_mm"] = 0.0
    case["track"]["rail_profile"].pop("mirror")
    case["numerics"]["grid"] = 12
    result = solve(Case.from_dict(case))
    assert any("mirror = true" in text for text in result.warnings)
    assert any("reaches the end of a profile" in text for text in result.warnings)
    assert result.contacts and all(np.isfinite(patch.coupled.fields["pressure"]).all() for patch in result.contacts)

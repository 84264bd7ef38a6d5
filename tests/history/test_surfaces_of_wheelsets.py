"""Surfaces of rails and wheels that roll: what they do to a wheel whose contact is known, and how a case gives them."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.soft_wheel import RADIUS, column, wheel
from thermoroll_cli import Case, CaseError, Result, conicity, solve
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.many_contacts.history.wheelset_over_time import facts_over_time, warnings_over_time

CASES = Path(__file__).parents[2] / "cases"
LOADED: dict[str, Any] = {"height_mm": None, "vertical_N": 237.0}
LEVEL: dict[str, Any] = {"kind": "wave", "amplitude_um": 100.0, "wavelength_mm": 1e6}
LONG = 200.0
BENT = 0.2 * LONG**2 / (4.0 * math.pi**2 * RADIUS)
"""Amplitude (mm) of a wave of the length LONG whose curvature is a fifth of that of the wheel."""


def rolled(surface: dict[str, Any] | None = None, on_wheel: dict[str, Any] | None = None, **tables: Any) -> Result:
    """A wheel under a load over a few steps, with a surface of the rail or of the wheel."""
    table = {"track": {"surface": surface}} | tables
    table["wheelset"] = LOADED | {"surface": on_wheel, "angular_velocity_rad_s": 10.0} | table.get("wheelset", {})
    case = wheel(**{"history": {"distance_mm": [0, 3], "steps": 2}, "numerics": {"grid": 12}} | table)
    result: Result = solve(Case.from_dict(case))
    assert result.converged, result.reason
    return result


def test_heights_that_are_the_same_everywhere_lift_the_wheel_and_do_nothing_else() -> None:
    creeping = {"wheelset": {"angular_velocity_rad_s": 9.96}, "history": {"distance_mm": [0, 3], "steps": 1}}
    smooth, level = rolled(**creeping), rolled(LEVEL, **creeping)
    np.testing.assert_allclose(column(smooth, "height_mm") - column(level, "height_mm"), 0.1, atol=5e-5)  # other domains
    np.testing.assert_allclose(column(level, "surface_height_right_um"), 100.0, rtol=1e-6)
    for name in ("pressure_max_MPa", "track_force_x_N", "contact_area_mm2"):
        np.testing.assert_allclose(column(level, name), column(smooth, name), rtol=2e-3, err_msg=name)
    assert {"surface_height_right_um", "position_mm"}.isdisjoint(smooth.history or ())


@pytest.mark.parametrize("sign", [1.0, pytest.param(-1.0, marks=pytest.mark.slow)])
def test_a_long_wave_is_a_curvature_of_rail_or_wheel(sign: float) -> None:
    """On its crest the wheel is as on a level rail with 1/R + k²Δ, in its trough with 1/R − k²Δ; it lies higher by Δ."""
    wave = {"kind": "wave", "amplitude_um": sign * 1e3 * BENT, "wavelength_mm": LONG, "start_mm": 3.0}
    rail, on_wheel = rolled(wave), rolled(None, wave)
    radius = RADIUS / (1.0 + 0.2 * sign)
    case = wheel(wheelset=LOADED | {"nominal_radius_mm": radius, "angular_velocity_rad_s": 1e3 / radius})
    del case["history"]
    steady = solve(Case.from_dict(case))
    for name in ("pressure_max_MPa", "contact_area_mm2"):
        assert rail[name] == pytest.approx(steady[name], rel=5e-3), name
    assert rail["height_mm"] == pytest.approx(steady["height_mm"] - sign * BENT, abs=2e-3)
    assert rail["position_mm"] == pytest.approx(3.0)
    assert on_wheel["rotation_deg"] == pytest.approx(math.degrees(3.0 / RADIUS))
    # Wheels that roll without slip turn by as much as they travel.
    for name in ("height_mm", "pressure_max_MPa", "contact_area_mm2"):
        np.testing.assert_allclose(column(on_wheel, name), column(rail, name), rtol=1e-3, err_msg=name)


def test_crests_that_touch_are_counted() -> None:
    """Five crests lie under a smooth contact of 8 mm, three or four of which touch: an odd number about one in the middle, an
    even one about a trough."""
    wave = {"kind": "wave", "amplitude_um": 60.0, "wavelength_mm": 3.0}
    result = rolled(wave, numerics={"grid": 24}, history={"distance_mm": [0, 1.5], "steps": 1})
    assert column(result, "contact_spots_right").tolist() == [3.0, 4.0]
    assert result.history is not None and "contact_spots_left" not in result.history
    assert "uncertainty.contact_spots_right" not in result.history


@pytest.mark.slow
def test_a_rise_ahead_moves_the_contact_ahead() -> None:
    """To where the gap x²/2R − h′x is least, R h′ ahead of the axle; behind it where rail or wheel fall."""
    for ahead, body in ((1.0, "surface"), (-1.0, "on_wheel")):
        rise = {"kind": "wave", "amplitude_um": 50.0, "wavelength_mm": LONG, "start_mm": ahead * 0.25 * LONG}
        (patch,) = rolled(**{body: rise}, history={"distance_mm": [-0.01, 0.0], "steps": 1}).patches
        moved = RADIUS * 0.05 * 2.0 * math.pi / LONG
        assert patch.record["x_mm"] == pytest.approx(ahead * moved, rel=0.03)  # type: ignore[union-attr]


@pytest.mark.slow
def test_each_wave_has_its_own_period_and_begins_where_it_is_said() -> None:
    """A rail's wave by distance, a wheel's by the angle: the same after a wavelength, from the start, place or rotation."""
    short = {"kind": "wave", "amplitude_um": 20.0, "wavelength_mm": 12.0, "start_mm": 2.0}
    coarse = {"numerics": {"grid": 8}, "history": {"distance_mm": [0, 3], "steps": 1}}
    once = column(rolled(short, **coarse), "pressure_max_MPa")
    moved = rolled(short | {"start_mm": 14.0}, wheelset={"position_mm": 24.0}, **coarse)
    np.testing.assert_allclose(column(moved, "pressure_max_MPa"), once, rtol=1e-9)
    turned = rolled(None, short, wheelset={"rotation_deg": math.degrees(36.0 / RADIUS)}, **coarse)
    np.testing.assert_allclose(column(turned, "pressure_max_MPa"), once, rtol=2e-3)
    assert np.ptp(once) > 0.02 * once.max()


@pytest.mark.slow
def test_a_dent_of_the_left_rail_is_that_of_the_right_one_in_the_mirror() -> None:
    dent = {"kind": "dent", "depth_um": 40.0, "radius_mm": 3.0, "offset_mm": 1.0, "start_mm": 2.0}
    right = rolled(dent)
    left = rolled(dent, wheelset={"wheels": "left"}, track={"right": None, "left": {"origin_mm": [0.0, 0.0]}, "surface": dent})
    assert abs(right["track_force_y_N"]) > 0.1
    for name, sign in (("pressure_max_MPa", 1.0), ("height_mm", 1.0), ("track_force_y_N", -1.0)):
        np.testing.assert_allclose(column(left, name), sign * column(right, name), rtol=1e-6, err_msg=name)


@pytest.mark.slow
def test_a_history_goes_on_where_the_surfaces_of_the_one_before_stand(tmp_path: Path) -> None:
    wave = {"kind": "wave", "amplitude_um": 20.0, "wavelength_mm": 12.0}
    whole = rolled(wave, wave, history={"distance_mm": [0, 6], "steps": 4})
    rolled(wave, wave).save(tmp_path / "first.h5")
    assert [*read_result(tmp_path / "first.h5").surfaces] == ["right rail", "right wheel"]
    second = rolled(wave, wave, history={
        "distance_mm": None, "time_s": [0, 3e-3], "steps": 2, "begin": str(tmp_path / "first.h5")})
    for name in ("surface_height_right_um", "position_mm", "rotation_deg"):
        np.testing.assert_allclose(column(second, name), column(whole, name)[2:], rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(column(second, "pressure_max_MPa"), column(whole, "pressure_max_MPa")[2:], rtol=0.03)  # grids


def wheelset(**tables: dict[str, Any]) -> dict[str, Any]:
    """Both wheels, over time."""
    case = tomllib.loads((CASES / "manchester.toml").read_text())
    case["track"]["rail_profile"] = {"file": str(CASES / "MBench_UIC60_v3.prr")}
    case["wheelset"]["wheel_profile"] = {"file": str(CASES / "MBench_S1002_v3.prw")}
    case["wheelset"] |= {"lateral_shift_mm": 0.0, "yaw_mrad": 0.0}
    case["history"] = {"distance_mm": [0, 80], "steps": 32}
    return {**case, **{name: {**case.get(name, {}), **table} for name, table in tables.items()}}


def test_one_rail_that_is_higher_rolls_the_wheelset() -> None:
    """By the difference of the heights over the distance of the contacts; a wheel that is larger does so, too."""
    smooth = facts_over_time(Case.from_dict(wheelset()).task)
    apart = smooth["first_contact_y_right_mm"] - smooth["first_contact_y_left_mm"]
    for table in ("track", "wheelset"):
        one = facts_over_time(Case.from_dict(wheelset(**{table: {"left": {"surface": LEVEL}}})).task)
        assert one["first_contact_roll_mrad"] == pytest.approx(0.1 / apart * 1e3, rel=0.02)
        assert one["first_contact_height_mm"] == pytest.approx(smooth["first_contact_height_mm"] - 0.05, abs=2e-3)


def test_a_rigid_wheel_rolls_over_the_edges_of_its_flat() -> None:
    """A chord of the length L: the wheel lies lower by L²/8R on its middle, by L²/32R half-way, where an edge bears, and on
    that edge not at all. An elastic one leans on the edge behind while the middle of the flat is still ahead."""
    length, radius = 40.0, 460.0
    one = {"wheels": "right", "roll_mrad": 0.0}
    smooth = facts_over_time(Case.from_dict(wheelset(wheelset=one)).task)["first_contact_height_mm"]
    for ahead, share in ((0.0, 1.0), (0.25 * length, 0.25), (0.5 * length, 0.0)):
        flat = {"kind": "flat", "length_mm": length, "rounding_mm": 0.0, "start_mm": ahead}
        there = facts_over_time(Case.from_dict(wheelset(wheelset=one | {"surface": flat})).task)["first_contact_height_mm"]
        assert there - smooth == pytest.approx(share * length**2 / (8.0 * radius), abs=2e-3)
    (patch,) = rolled(None, {"kind": "flat", "length_mm": 20.0, "start_mm": 8.0}).patches
    assert -6.0 < patch.record["x_mm"] < -2.0  # type: ignore[union-attr]


def test_what_a_case_says_of_surfaces_and_where_it_may_have_them(tmp_path: Path) -> None:
    wave = {"kind": "wave", "amplitude_um": 300.0, "wavelength_mm": 4.0}
    flat = {"kind": "flat", "length_mm": 30.0}
    case = Case.from_dict(wheelset(track={"surface": wave}, wheelset={"right": {"surface": flat}}))
    (tmp_path / "rough.toml").write_text(case.to_toml())
    shown = json.loads(call("show", tmp_path / "rough.toml", "--json").stdout)
    assert [*shown["surfaces"]] == ["track.surface", "wheelset.right.surface"]
    assert shown["surfaces"]["track.surface"]["rms_um"] == pytest.approx(300.0 / math.sqrt(2.0))
    warnings = " ".join(warnings_over_time(case.task))
    assert "steps of 2.5 mm are long beside waves of 4 mm of the left rail" in warnings and "slopes" in warnings
    right = case.task.problem.wheels["right"].surface
    assert right.depth == pytest.approx(0.03**2 / (8.0 * 0.46)) and case.task.problem.wheels["left"].surface is None
    with pytest.raises(Exception, match="knows no surfaces"):
        conicity(case)
    steady = wheelset(track={"surface": wave})
    del steady["history"]
    for content, key, words in (
            (steady, "track.surface", "steady state"), (wheelset(surface={"lower": wave}), "surface", "track.surface"),
            (wheelset(track={"surface": flat}), "track.surface.kind", "convex"),
            (wheelset(wheelset={"rotation_deg": 3.0}), "wheelset.rotation_deg", "round")):  # fmt: skip
        with pytest.raises(CaseError) as caught:
            Case.from_dict(content)
        assert [(finding.key, words in str(finding)) for finding in caught.value.findings] == [(key, True)]

"""Outlines of wheels and rails as people have them: noses of crossings, closed sections, the wrong hand, rounded numbers, other
units and the files of Vampire. What an outline looks like may be overruled by a key, and nothing ends as a bug."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from thermoroll_cli import Case, CaseError, solve
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.files.profile_file import outline_fault, read_outline, running_surface
from thermoroll_cli.many_contacts.wheelset.first_contact import touching
from thermoroll_cli.problem.rounding import steps_of

STEEL = {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.3}
CASES = Path(__file__).parents[2] / "cases"
RAIL, WHEEL = (read_outline(CASES / name).content for name in ("MBench_UIC60_v3.prr", "MBench_S1002_v3.prw"))
NOSE = [[-5.1, 35.7], [-1.0, 12.0], [0.5, 5.5], [3.1, 2.6], [7.5, 2.0], [14.8, 2.2], [18.5, 3.6], [19.9, 6.5], [20.7, 10.5],
        [24.8, 33.5], [26.8, 38.4], [32.7, 39.8], [44.3, 39.8], [56.1, 39.8]]  # fmt: skip
"""The nose of a crossing beside a shelf, z down: half of its width lies on the shelf."""
SECTION = [[0, 0], [18, 0.8], [28, 3], [33, 8], [36, 14], [36.5, 36], [25, 44], [8.25, 54], [8.25, 140], [30, 152], [75, 160],
           [75, 172]]  # fmt: skip
"""Half of the section of a rail, z down; the other half is its mirror image."""


def closed_section() -> list[list[float]]:
    """A whole rail, as drawings and CAD have it, begun at its foot."""
    half = [[float(y), float(z)] for y, z in SECTION]
    return [*half[::-1], *([-y, z] for y, z in half[1:]), half[-1]]


def tables(rail: dict[str, Any], wheel: dict[str, Any] | None = None, **wheelset: Any) -> dict[str, Any]:
    return {"material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
            "rolling": {"speed_m_s": 20.0}, "numerics": {"grid": 16}, "track": {"rail_profile": rail},
            "wheelset": {"wheel_profile": wheel or {"points_mm": WHEEL}, "nominal_radius_mm": 460.0, "vertical_N": 1e5,
                         **wheelset}}  # fmt: skip


def written(tmp_path: Path, content: dict[str, Any]) -> Path:
    path = tmp_path / "case.toml"
    path.write_text(Case.from_dict(content).to_toml())
    return path


def test_the_nose_of_a_crossing_stands_upright() -> None:
    assert outline_fault(NOSE, wheel=False) == ("", "")
    told, advice = outline_fault([[y, -z] for y, z in RAIL], wheel=False)
    assert "upside down" in told and "flip = true" in advice and "flip = false" in advice


@pytest.mark.parametrize("flip", [True, False])
def test_a_key_overrules_what_an_outline_looks_like(flip: bool) -> None:
    upside_down = [[y, -z] for y, z in RAIL]
    with pytest.raises(CaseError, match="upside down"):
        Case.from_dict(tables({"points_mm": upside_down}))
    Case.from_dict(tables({"points_mm": upside_down, "flip": flip}))
    other_hand = [[-y, z] for y, z in WHEEL]
    with pytest.raises(CaseError, match="the flange lies on the field side"):
        Case.from_dict(tables({"points_mm": RAIL}, {"points_mm": other_hand}, flange_back_mm=-60.0))
    case = tables({"points_mm": RAIL}, {"points_mm": other_hand, "mirror": True})
    assert Case.from_dict(case).task.wheels == Case.from_dict(tables({"points_mm": RAIL})).task.wheels


def test_wheels_in_a_groove_rest_on_sharp_ends_alone(tmp_path: Path) -> None:
    """A V groove whose sides are as steep as flanges: the wheels lie on its edges, and each command says so."""
    groove = [[-5.133, -35.676], [7.6, -2.0], [56.058, -39.808]]
    path = written(tmp_path, tables({"points_mm": groove}, lateral_shift_mm=3.0))
    done = call("run", path, "-o", tmp_path, "--json")
    assert done.returncode == 4 and "meet at sharp ends alone" in json.loads(done.stdout)["reason"]
    assert call("show", path).returncode == 0
    assert "touches its rail where a profile ends" in " ".join(call("conicity", path, "-o", tmp_path).stdout.split())


def test_closed_sections_have_a_running_surface(tmp_path: Path) -> None:
    """Of a rail its head, down to its widest place; upside down it has its foot on top."""
    section = closed_section()
    head = running_surface(section, wheel=False)
    assert sorted(head) == sorted([*([y, z] for y, z in SECTION if z <= 36), *([-y, z] for y, z in SECTION if 0 < z <= 36)])
    assert running_surface(RAIL, wheel=False) == RAIL
    as_a_whole, as_its_head = (Case.from_dict(tables({"points_mm": points})).task.rails for points in (section, head))
    assert as_a_whole == as_its_head
    assert "upside down" in outline_fault([[y, -z] for y, z in section], wheel=False)[0]
    wheel = [*WHEEL, [WHEEL[-1][0], -50.0], [WHEEL[0][0], -50.0], WHEEL[0]]
    assert running_surface(wheel, wheel=True) == WHEEL
    (tmp_path / "rail.csv").write_text("\n".join(f"{y} {z}" for y, z in section))
    (tmp_path / "case.toml").write_text(written(tmp_path, tables({"points_mm": RAIL})).read_text())
    shown = call("show", tmp_path / "case.toml", "--set", f"track.rail_profile.file={tmp_path / 'rail.csv'}").stdout
    assert "the running surface of a closed section" in " ".join(shown.split())


def test_a_rail_of_the_other_hand_has_no_conicity_and_is_told_of_mirror(tmp_path: Path) -> None:
    """Its gauge side ends above the gauge height: no shift has two contacts, and the picture shows none."""
    rail = [[float(y), float(y**2 / 600.0 + 25.0 * max(y - 33.0, 0.0))] for y in np.linspace(-12.0, 34.0, 93)]
    path = written(tmp_path, tables({"points_mm": rail}, {"points_mm": [[0.0, 0.0], [135.0, -6.75]]}, flange_back_mm=0.2))
    done = call("conicity", path, "-o", tmp_path)
    told = " ".join(done.stdout.split())
    assert done.returncode == 4 and "mirror = true in the table of its profile exchanges the sides" in told, told
    assert (tmp_path / "case_conicity.png").exists()
    assert "mirror = true" in call("run", path, "-o", tmp_path, "--no-plots").stdout


def test_rounded_heights_are_told_and_counted(tmp_path: Path) -> None:
    """An arc of R 300 at every 0.5 mm, heights in mm with three decimals, as instruments export them: Hertz lies within ±. A
    cone whose heights are multiples of 0.05 mm has none to be told of."""
    y = np.linspace(-30.0, 30.0, 121)
    arc = {"points_mm": [[a, b] for a, b in zip(y.tolist(), np.round(-(y**2) / 600.0, 3).tolist(), strict=True)]}
    ball = {"material": STEEL, "load": {"normal_N": 5e4, "friction_coefficient": 0.0}, "rolling": {"speed_m_s": 1.0},
            "numerics": {"grid": 48},
            "geometry": {"lower_radius_x_mm": math.inf, "upper_radius_x_mm": 460.0, "upper_radius_y_mm": math.inf,
                         "lower_profile": arc}}  # fmt: skip
    below = {**ball, "numerics": {"grid": 24}, "subsurface": {"bodies": ["lower"]}}
    result = solve(Case.from_dict(ball))
    exact = 1e-6 * hertz_contact(1.0 / 0.46, 1.0 / 0.3, 105e9 / 0.91, 5e4).peak_pressure
    error = result.uncertainty["pressure_max_MPa"]
    assert 0.03 * exact < abs(result["pressure_max_MPa"] - exact) < error < 0.2 * exact
    assert any("rounded to about 0.001 mm" in warning for warning in result.warnings)
    smooth = solve({**below, "geometry": {**ball["geometry"], "lower_profile": None, "lower_radius_y_mm": 300.0}})
    for over_time in ({}, {"history": {"distance_mm": [0, 1], "steps": 1, "fields_every": 1,
                                       "values": {"load.normal_N": [4e4, 5e4]}}}):
        found = solve({**below, **over_time})
        assert abs(found["pressure_max_MPa"] - exact) < found.uncertainty["pressure_max_MPa"] < 0.3 * exact
        stress, known = found["von_mises_max_lower_MPa"], smooth["von_mises_max_lower_MPa"]
        assert 0.004 * known < abs(stress - known) < found.uncertainty["von_mises_max_lower_MPa"] < 0.03 * known
    arc["smoothing_mm"] = 4.0
    smoothed = solve(Case.from_dict(ball))
    assert abs(smoothed["pressure_max_MPa"] - exact) < smoothed.uncertainty["pressure_max_MPa"] < 0.2 * error
    rail = [[float(a), float(np.round(a**2 / 600.0, 2))] for a in y]
    cone = [[float(a), round(-0.05 * float(a), 6)] for a in range(-70, 66)]
    told = call("show", written(tmp_path, tables({"points_mm": rail}, {"points_mm": cone}, vertical_N=2e5))).stdout
    assert "right rail has points 0.5 mm apart that are rounded to about 0.01 mm" in " ".join(told.split())
    assert "right wheel has points" not in " ".join(told.split())


@pytest.mark.parametrize(("unit", "height_unit", "across", "up"), [("m", None, 1e-3, 1e-3), ("um", None, 1e3, 1e3),
                                                                   ("in", None, 1 / 25.4, 1 / 25.4),
                                                                   ("mm", "um", 1.0, 1e3), (None, "um", 1.0, 1e3)])  # fmt: skip
def test_files_in_other_units(tmp_path: Path, unit: str | None, height_unit: str | None, across: float, up: float) -> None:
    (tmp_path / "rail.csv").write_text("\n".join(f"{across * y!r}, {up * z!r}" for y, z in RAIL))
    given = {key: value for key, value in (("unit", unit), ("height_unit", height_unit)) if value}
    read = Case.from_dict(tables({"file": str(tmp_path / "rail.csv"), **given}))
    assert np.array(read.settings.track.rail_profile.points_mm) == pytest.approx(np.array(RAIL), abs=1e-9)
    assert Case.parse(read.to_toml()).task == read.task
    assert (height_unit or unit or "mm") in read.profiles["track.rail_profile"]["unit"]
    with pytest.raises(CaseError, match="is about a file, and there is none"):
        Case.from_dict(tables({"points_mm": RAIL, "unit": "m"}))


def test_inches(tmp_path: Path) -> None:
    """A wheel and a rail in inches are refused with the key; steps of numbers in inches are those that the file has."""
    rail, wheel = tmp_path / "rail.csv", tmp_path / "wheel.csv"
    for path, points in ((rail, RAIL), (wheel, WHEEL)):
        path.write_text("\n".join(f"{y / 25.4:.4f}, {z / 25.4:.4f}" for y, z in points))
    for each in ({"rail": {"file": str(rail)}}, {"rail": {"points_mm": RAIL}, "wheel": {"file": str(wheel)}}):
        with pytest.raises(CaseError, match=r'seem to be in inches: .*unit = "in"'):
            Case.from_dict(tables(**each))
    read = Case.from_dict(tables({"file": str(rail), "unit": "in"}, {"file": str(wheel), "unit": "in"}))
    assert read.profiles["wheelset.wheel_profile"]["step_mm"] == pytest.approx(0.00254, rel=1e-9)
    told = read.readings["track.rail_profile"].words(read.profiles["track.rail_profile"])
    assert "points in inches, y from -43.7" in told
    assert steps_of([[0.001 * k, 0.005 * k] for k in range(20)]) == (0.001, 0.005)


def test_each_wheel_has_its_own_flange_back() -> None:
    """Two instruments that begin elsewhere: the wheelset is the same as with outlines that begin alike."""
    moved = [[y + 67.5, z] for y, z in WHEEL]
    own = tables({"points_mm": RAIL}, wheel_profile={"points_mm": WHEEL},
                 right={"wheel_profile": {"points_mm": moved}, "flange_back_mm": -2.5})
    alike, apart = (Case.from_dict(each).task for each in (tables({"points_mm": RAIL}), own))
    for first, second in zip(touching(alike).values(), touching(apart).values(), strict=True):
        np.testing.assert_allclose(first.gap, second.gap, atol=1e-12)
    with pytest.raises(CaseError, match=r"(?s)-70 mm is no y of .* wheelset.right.wheel_profile.*in \[wheelset.right\]"):
        Case.from_dict(tables({"points_mm": RAIL}, right={"wheel_profile": {"points_mm": moved}}))
    with pytest.raises(CaseError, match=r"wheelset.left.flange_back_mm: 0 mm is no y of .* of wheelset.wheel_profile,"):
        Case.from_dict(tables({"points_mm": RAIL}, left={"flange_back_mm": 0.0}))


def test_heights_in_micrometres_are_asked_about() -> None:
    """A pressure that no solid carries is a warning that names units, and the key that mends it."""
    y = np.linspace(-5.0, 5.0, 41)
    ball = {"material": STEEL, "load": {"normal_N": 1e3, "friction_coefficient": 0.1}, "rolling": {"speed_m_s": 1.0},
            "numerics": {"grid": 16},
            "geometry": {"lower_radius_x_mm": math.inf, "upper_radius_x_mm": 20.0, "upper_radius_y_mm": math.inf,
                         "lower_profile": {"points_mm": np.stack((y, -1e3 * y**2 / 40.0), axis=1).tolist()}}}  # fmt: skip
    warnings = " ".join(solve(Case.from_dict(ball)).warnings)
    assert "in the units of their keys?" in warnings and 'height_unit = "um"' in warnings


def test_profiles_of_both_sides_as_vampire_has_them(tmp_path: Path) -> None:
    """y from the middle of the track; z of rails up. The right side, unless the left one is asked for."""
    rows = "\n".join(f"{-y - 750.0:.6f}, {z:.6f}, {y + 750.0:.6f}, {z + 0.5:.6f}" for y, z in WHEEL)
    (tmp_path / "wheel.whe").write_text(f"WHEELPROFILE\na title\nTREADDATUM EUROPEAN\nFLANGEBACK 1360\n{rows}\n")
    right = read_outline(tmp_path / "wheel.whe")
    assert right.wheel and np.array(right.content) == pytest.approx(np.array(WHEEL) + np.array([0.0, 0.5]), abs=1e-6)
    assert "the other differs by 0.5 mm" in right.note
    assert np.array(read_outline(tmp_path / "wheel.whe", "left").content) == pytest.approx(np.array(WHEEL), abs=1e-6)
    rows = "\n".join(f"{-y - 717.5} {-z} {y + 717.5} {-z}" for y, z in RAIL)
    (tmp_path / "rail.rai").write_text(f"RAILPROFILE\na title\nGAUGEPOINT CUSTOM 14\nGAUGE 1435\n{rows}\n")
    case = Case.from_dict(tables({"file": str(tmp_path / "rail.rai")}, {"file": str(tmp_path / "wheel.whe"), "side": "left"}))
    assert np.array(case.settings.track.rail_profile.points_mm) == pytest.approx(np.array(RAIL), abs=1e-9)
    (tmp_path / "rail.rai").write_text(f"RAILPROFILE\na title\nGAUGEPOINT CUSTOM 14\n{rows}\n")
    with pytest.raises(CaseError, match="GAUGEPOINT and GAUGE"):
        Case.from_dict(tables({"file": str(tmp_path / "rail.rai")}))
    (tmp_path / "rail.txt").write_text(rows)
    with pytest.raises(CaseError) as caught:
        Case.from_dict(tables({"file": str(tmp_path / "rail.txt")}))
    assert "begin a file of both sides as Vampire does" in caught.value.findings[0].hint

"""A wheelset solved: forces beside CONTACT's, mirrored sides, what is found, through the command a user calls."""

from __future__ import annotations

import json
import math
import re
import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.documents import cell, printed
from tests.support.errors import relative
from tests.support.wheelsets import ROOT, case_named, contact_cases, facing_beside, outline_points
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.wheelset.patch_surface import section
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import WheelsetSolver, solve_wheelset
from thermoroll_cli.physics.contact.contact_scales import contact_scales
from thermoroll_cli.physics.numerics.convolution import counted
from thermoroll_cli.plots.wheelset_figures import patches_figure
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

TEXT = f"""
title = "Manchester"
[material]
youngs_modulus_GPa = 209.92
poisson_ratio = 0.28
[track]
rail_profile = {{ file = "{ROOT}/cases/MBench_UIC60_v3.prr" }}
[wheelset]
wheel_profile = {{ file = "{ROOT}/cases/MBench_S1002_v3.prw" }}
nominal_radius_mm = 460.0
lateral_shift_mm = 4.0
yaw_mrad = 9.6
vertical_N = 20e3
patches = "planar"
[load]
friction_coefficient = 0.3
[rolling]
speed_m_s = 2.0
[numerics]
grid = 24
"""
GIVEN = "roll_mrad = -0.25\nangular_velocity_rad_s = 4.344"
STANDING = TEXT.replace("grid = 24", "grid = 16").replace("yaw_mrad", f"{GIVEN}\nyaw_mrad")
"""Neither the roll nor the speed is to be found."""
SLOW = partial(pytest.param, marks=pytest.mark.slow)


def beside(case: dict, *, grid: int = 24, curved: bool = False) -> WheelsetProblem:
    """One wheel of CONTACT's cases."""
    i = case["input"]
    facing, _ = facing_beside(case)
    body = Material(2e6 * i["G"] * (1.0 + i["nu"]), i["nu"])
    contact = Problem(body, body, Geometry(math.inf, 0.3, 0.46, math.inf), 1.0, Friction(i["mu"]), Motion(1e-3 * i["vs"]),
                      Heating(heat=False, deformation=False), Numerics((grid, grid)))  # fmt: skip
    position = Position(1e-3 * i["y"], 1e-3 * (i["z"] or 0.0), i["roll"], i["yaw"])
    motion = facing_beside(case)[1]
    return WheelsetProblem(contact, {i["side"]: facing.rail}, {i["side"]: facing.wheel}, position,
                           motion.mirrored if i["side"] == "left" else motion, i["fz"] if i["z"] is None else None,
                           curved=curved)  # fmt: skip


def force(result: Result) -> np.ndarray:
    return np.array([result.scalars[f"track_force_{axis}_N"] for axis in "xyz"])


@pytest.mark.slow
def test_the_moment_of_the_pressure_brakes_a_wheel_of_another_material():
    """A softer wheel that pulls on a steel rail: the moment of its pressure is a quarter of the heat of friction."""
    unlike = TEXT.replace(
        "[material]\nyoungs_modulus_GPa = 209.92\npoisson_ratio = 0.28",
        "[material.lower]\nyoungs_modulus_GPa = 209.92\npoisson_ratio = 0.28\n"
        "[material.upper]\nyoungs_modulus_GPa = 70.0\npoisson_ratio = 0.33")
    unlike = unlike.replace("lateral_shift_mm = 4.0\nyaw_mrad = 9.6", "lateral_shift_mm = 0.0\ntraction_N = 800.0")
    result = solve(Case.from_dict(tomllib.loads(unlike.replace("grid = 24", "grid = 10"))))
    assert result.converged, result.reason
    brakes = 1e-3 * result["rolling_resistance_moment_Nmm"] * 2.0 / 0.46
    assert abs(brakes) > 0.2 * result["Q_F_W"]
    assert result["power_balance_error"] < 0.05


def test_traction_and_load_are_met():
    """To 1e-4 of what friction can carry, and of the load."""
    pulls = TEXT.replace("lateral_shift_mm = 4.0\nyaw_mrad = 9.6", "lateral_shift_mm = 6.0\ntraction_N = 800.0")
    result = solve(Case.from_dict(tomllib.loads(pulls.replace("grid = 24", "grid = 8"))))
    assert result["track_force_x_N"] == pytest.approx(-800.0, abs=1e-4 * 0.3 * 20e3)
    assert result["track_force_z_N"] == pytest.approx(20e3, rel=1e-4)


@pytest.mark.parametrize(("name", "tolerance"), [
    SLOW("A2.2 left y=4.0", 1e-3), ("A2.2 right y=8.0", 1.5e-3), SLOW("worn heavy haul right y=14.74", 1.5e-3),
    SLOW("B gauge 1450 cant 1:40 right y=12", 1.5e-3), SLOW("A2.2 right y=5.0 apart", 1e-3),
])  # fmt: skip
def test_planar_patches_are_those_of_contact(name, tolerance):
    case = case_named(name)
    result = solve_wheelset(beside(case))
    theirs = case["contact"]
    assert result.converged, result.reason
    assert result.scalars["height_mm"] == pytest.approx(theirs["z_ws_mm"], abs=3e-4)
    np.testing.assert_allclose(force(result), theirs["force_rail_track_N"], atol=tolerance * case["input"]["fz"])
    assert result.scalars["power_balance_error"] < 2e-3
    for ours, patch in zip(result.patches, sorted(theirs["patches"], key=lambda patch: patch["y_tr"]), strict=True):
        small = 0.01 if patch["Fn"] < 0.2 * case["input"]["fz"] else 0.003
        assert ours.record["normal_N"] == pytest.approx(patch["Fn"], rel=small)
        assert ours.record["pressure_max_MPa"] == pytest.approx(patch["pmax"], rel=0.015)
        assert ours.record["creepage_x"] == pytest.approx(patch["cksi"], abs=1.2e-5)


@pytest.mark.parametrize(("name", "tolerance"), [
    ("A2.2 right y=5.0 joined, conformal", 1.5e-3), SLOW("A2.2 right y=8.0 conformal", 6e-3),
    SLOW("100 kN, wide contact right y=6.2, conformal", 1.5e-3), SLOW("100 kN, wide contact right y=6.4, conformal", 6e-3),
])  # fmt: skip
def test_curved_patches_press_each_other_apart(name, tolerance):
    """CONTACT solves both patches in one domain; here each knows the other's displacement. Across the wide ones the surface
    turns by 0.8 rad: there the approach closes the gap by less than where the patch is deepest."""
    case = case_named(name, "conformal")
    result = solve_wheelset(beside(case, curved=True))
    np.testing.assert_allclose(force(result), case["contact"]["force_rail_track_N"], atol=tolerance * case["input"]["fz"])
    assert result.scalars["height_mm"] == pytest.approx(case["contact"]["z_ws_mm"], abs=1e-3)


@pytest.mark.slow
def test_all_wheels_of_contact_are_as_far_as_printed():
    """Planar patches at N = 64, where CONTACT has as many patches; conformal ones over the angle of the steepest patch."""
    found: dict[str, list[float]] = {"normal": [], "tangential": [], "forces": [], "largest": []}
    for case in contact_cases():
        result, theirs = solve_wheelset(beside(case, grid=64)), case["contact"]
        if len(result.patches) != len(theirs["patches"]):
            continue
        on_rail = np.array(theirs["force_rail_track_N"])
        found["forces"].append(float(np.abs(force(result) - on_rail).max() / on_rail[2]))
        for ours, patch in zip(result.patches, sorted(theirs["patches"], key=lambda patch: patch["y_tr"]), strict=True):
            record = ours.record
            found["normal"].append(abs(record["normal_N"] / patch["Fn"] - 1.0))
            difference = math.hypot(record["force_x_N"] - patch["Fx"], record["force_s_N"] - patch["Fs"])
            found["tangential"].append(difference / patch["Fn"])
            found["largest"].append(abs(record["pressure_max_MPa"] / patch["pmax"] - 1.0))
    assert len(found["forces"]) == printed("verification", "48 wheels with planar patches")[0].value
    for row, values in found.items():
        for column, value in (("median", float(np.median(values))), ("largest", max(values))):
            (shown,) = cell("verification", row, column)
            assert 100.0 * value <= shown.value + shown.rounding, (row, column)

    usual, *steep = printed("verification", "0.07 % of the load, at angles of 55°, 61° and 69° by 0.3 %, 0.4 % and 2.1 %")
    for case in contact_cases("conformal"):
        result, theirs = solve_wheelset(beside(case, grid=64, curved=True)), case["contact"]["force_rail_track_N"]
        missed = 100.0 * float(np.abs(force(result) - theirs).max()) / theirs[2]
        angle = max(abs(math.degrees(1e-3 * patch.record["angle_mrad"])) for patch in result.patches)
        shown = next((most for at, most in zip(steep[:3], steep[3:], strict=True) if abs(angle - at.value) < 0.5), usual)
        assert missed <= shown.value + shown.rounding, case["name"]


S1002 = f"{ROOT}/cases/MBench_S1002_v3.prw"
UIC60 = f"{ROOT}/cases/MBench_UIC60_v3.prr", 0.0
UPRIGHT = f"{ROOT}/tests/reference/wheelset/uic60_true.prr", 0.025


def moved_rail(rail: tuple[str, float], side: str, moved: tuple[float, float, float], shift: float) -> Result:
    """A wheel with 10 kN on a rail of its own place: shifts in mm and roll in mrad to the field side."""
    text = TEXT.replace(UIC60[0], rail[0]).replace("20e3", "10e3").replace("grid = 24", "grid = 8")
    text = text.replace("_mm = 4.0", f"_mm = {shift}")
    text = text.replace("[wheelset]", f'cant = {rail[1]}\n[track.{side}]\nshift_y_mm = {moved[0]}\nshift_z_mm = {moved[1]}\n'
                        f'roll_mrad = {moved[2]}\n[wheelset]\nwheels = "{side}"\nangular_velocity_rad_s = 4.3481181')
    return solve(tomllib.loads(text.replace("yaw_mrad = 9.6\n", "")))


@pytest.mark.parametrize(("rail", "side", "moved", "shift", "height"), [
    SLOW(UIC60, "right", (0.0, 0.0, 5.0), 0.0, 0.1225), SLOW(UIC60, "right", (0.0, 0.0, 5.0), 4.0, -0.2217),
    SLOW(UIC60, "right", (0.0, 0.0, -10.0), 0.0, 0.2353), SLOW(UIC60, "left", (0.0, 0.0, -5.0), 0.0, 0.2264),
    SLOW(UPRIGHT, "right", (0.0, 0.0, 5.0), 0.0, 0.2816), SLOW(UPRIGHT, "right", (2.0, -1.0, -8.0), 2.0, -0.7832),
    (UPRIGHT, "left", (-2.0, -1.0, -8.0), -2.0, -0.8230),
])  # fmt: skip
def test_a_rail_rolls_about_its_own_origin(rail, side, moved, shift, height):
    """Heights by CONTACT d431cdb, module 1 with deviations of the rail, which it gives to four digits (elements of 0.2 mm); and
    the mirror image has the same height and forces."""
    result = moved_rail(rail, side, moved, shift)
    other = moved_rail(rail, "left" if side == "right" else "right", moved, -shift)
    assert result.converged and result.scalars["height_mm"] == pytest.approx(height, abs=2e-4)
    assert other.scalars["height_mm"] == result.scalars["height_mm"]
    np.testing.assert_array_equal(force(other), force(result) * [1.0, -1.0, 1.0])
    for name in ("y_mm", "angle_mrad", "force_s_N", "moment_n_Nmm", "creepage_s", "spin_rad_mm"):
        assert other.patches[0].record[name] == -result.patches[0].record[name]


def right_wheel(**keys) -> Result:
    text = TEXT.replace("[wheelset]", '[wheelset]\nwheels = "right"\nangular_velocity_rad_s = 4.33')
    return solve(Case.parse(text).with_values({f"wheelset.{key}": value for key, value in keys.items() if key != "grid"}
                                              | {"numerics.grid": keys["grid"]}))


@pytest.mark.parametrize("grid", [24, SLOW(48)])
def test_two_contacts_in_one_patch_are_said_on_every_grid(grid):
    """With their places in the axes of the track: the narrow one has no pressure to rely on (951 to 2063 MPa, N = 32 to 96)."""
    result = right_wheel(yaw_mrad=4.0, roll_mrad=0.0, lateral_shift_mm=5.0, vertical_N=60e3, patches="curved", grid=grid)
    (said,) = (warning for warning in result.warnings if "it holds" in warning)
    assert said.startswith("patch right_1: it holds 2 contacts, at y = 736.") and "and 72" in said and len(result.patches) == 1


@pytest.mark.parametrize("grid", [24, SLOW(32), SLOW(48), SLOW(64)])
def test_a_peak_at_the_end_of_a_plane_patch_has_no_estimate(grid):
    """1700 to 1707 MPa here, 1861 on 192² elements: within the last element the surfaces part."""
    result = right_wheel(yaw_mrad=5.0, roll_mrad=-0.5, lateral_shift_mm=6.4, vertical_N=100e3, grid=grid)
    assert math.isnan(result.patches[0].record["uncertainty"]["pressure_max_MPa"])
    assert any("the surfaces part within an element at y (in the axes of its result)" in warning for warning in result.warnings)


def test_a_run_finds_roll_and_angular_velocity(tmp_path):
    """Both wheels through `run`: the values of CONTACT's table, and one file."""
    (tmp_path / "m.toml").write_text(TEXT)
    run = call("run", tmp_path / "m.toml", "-o", tmp_path / "out", "--json", "-q")
    assert run.returncode == 0, run.stderr
    record = json.loads(run.stdout)
    table = case_named("A2.2 left y=4.0")["input"]
    assert record["roll_mrad"] == pytest.approx(1e3 * table["roll"], abs=5e-4)
    assert record["angular_velocity_rad_s"] == pytest.approx(-table["omega"], abs=5e-5)
    for side in ("left", "right"):
        theirs = case_named(f"A2.2 {side} y=4.0")["contact"]["force_rail_track_N"]
        ours = [record[f"track_force_{axis}_{side}_N"] for axis in "xyz"]
        assert ours == pytest.approx(theirs, abs=15.0)
    assert [(patch["side"], patch["number"]) for patch in record["patches"]] == [("left", 1), ("right", 1)]
    files = {f"m{ending}" for ending in (".h5", "_section.png", "_patches.png")}
    assert {path.name for path in (tmp_path / "out").iterdir()} == files == {Path(file).name for file in record["files"]}
    assert "file" not in record["patches"][0]


WORN = f"{ROOT}/tests/reference/wheelset/worn_high_mileage.prw"


@pytest.mark.parametrize(("profile", "more", "found"), [
    (WORN, "", "-70 mm is no y of the flange back of wheelset.wheel_profile, which begins at y = 3.934 mm"),
    (S1002, "flange_back_mm = 0.0", "0 mm is no y of the flange back of wheelset.wheel_profile, which begins at y = -69.61 mm"),
    (S1002, "flange_back_distance_mm = 1380.0", "no room for the flanges: they overlap the rails by 6.68 mm, with their backs "
     "at y = -70 and -70 mm"),
    (WORN, "flange_back_mm = 0.0\nflange_back_distance_mm = 1347.4", ""),
    (S1002, "", ""), (S1002, "[track.right]\nshift_y_mm = -20", ""),
])  # fmt: skip
def test_a_flange_back_that_is_none_is_said(tmp_path, profile, more, found):
    """A wheel on the tip of its flange carries any load at several gigapascals. A rail moved deliberately may touch it."""
    text = TEXT.replace(S1002, profile)
    (tmp_path / "m.toml").write_text(text.replace("[load]", f"{more}\n[load]"))
    checked = call("validate", tmp_path / "m.toml", "--json")
    record = json.loads(checked.stdout)
    assert checked.returncode == (3 if found else 0) and record["valid"] == (not found), checked.stderr
    for error in record["errors"]:
        assert error["key"] == "wheelset.flange_back_mm" and error["message"].startswith(found) and error["allowed"]


def test_a_wheelset_shows_itself_in_a_notebook():
    """One wheel in the air: the pictures of the other one have a legend, and nothing raises."""
    result = solve(tomllib.loads(TEXT.replace("grid = 24", "grid = 16").replace("yaw_mrad", "roll_mrad = 5.0\nyaw_mrad")))
    assert repr(result).startswith("<Result 'Manchester', wheelset with 1 patch, converged, Q_F = 114")
    assert result.patches[0].name == "right_1" and result.patches[0].record["side"] == "right"
    assert "<td>vertical force on both rails</td><td>20000</td><td>N</td>" in result._repr_html_()
    (legend,) = result.plot().legends
    assert [text.get_text() for text in legend.get_texts()] == ["rail", "wheel", "largest pressure"]
    assert len(result.plot("patches").axes) == 2
    with pytest.raises(ValueError, match="'sections' is none of section, gap, patches"):
        result.plot("sections")


def test_a_wheel_beside_its_rail_is_invalid(tmp_path):
    (tmp_path / "m.toml").write_text(TEXT)
    run = call("run", tmp_path / "m.toml", "-o", tmp_path / "out", "--set", "wheelset.lateral_shift_mm=-120", "--no-plots")
    assert run.returncode == 3 and "misses its rail by" in run.stderr and "wheelset.lateral_shift_mm" in run.stderr


@pytest.mark.slow
def test_a_sweep_onto_the_flange_starts_anew():
    """The next point rests on the flange, of which the last one says nothing: few rounds find what one alone finds."""
    text = TEXT.replace("yaw_mrad = 9.6", 'yaw_mrad = 0.0\nwheels = "right"').replace("grid = 24", "grid = 12")
    before, flange = (Case.parse(text.replace("shift_mm = 4.0", f"shift_mm = {shift}")).task for shift in (6.0, 6.5))
    solver = WheelsetSolver()
    solver.solve(before)
    found, alone = solver.solve(flange), solve_wheelset(flange)
    assert found.converged and found.work["rounds"] <= alone.work["rounds"] + 4
    for name in ("track_force_x_right_N", "track_force_y_right_N"):
        assert found[name] == pytest.approx(alone[name], abs=2e-4 * 20e3), name


def transforms(work) -> tuple[int, object]:
    """Two-dimensional transforms of `work()`, which take most of its time, and what it returns."""
    contact_scales.cache_clear()
    before = counted.transforms
    found = work()
    return counted.transforms - before, found


@pytest.mark.slow
@pytest.mark.parametrize(("shift", "first", "following"), [(3.0, 2.0, 0.9), SLOW(5.0, 3.2, 1.9), SLOW(7.0, 2.0, 1.5)])
def test_a_wheel_costs_little_more_than_its_patches(shift, first, following):
    """One wheel without heat: a patch, two of them, one on the flange; and where it stands a little later. Measured: 1.9, 3.1
    and 1.8, then 0.7, 1.6 and 1.3 times its patches alone."""
    case = Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "wheelset.wheels": "right", "wheelset.vertical_N": 10e3, "wheelset.yaw_mrad": 2.4 * shift, "thermal.heat": False,
        "wheelset.roll_mrad": -0.06 * shift, "wheelset.angular_velocity_rad_s": 4.344})
    here, there = (case.with_values({"wheelset.lateral_shift_mm": at}).task for at in (shift, shift + 0.02))
    solver = WheelsetSolver()
    whole, result = transforms(lambda: solver.solve(here))
    after, moved = transforms(lambda: solver.solve(there))
    alone, _ = transforms(lambda: [solve(patch.problem) for patch in result.patches])
    assert result.converged and moved.converged and len(result.patches) == (2 if shift == 5.0 else 1)
    assert whole <= first * alone and after <= following * alone


def test_other_commands_say_what_they_take(tmp_path):
    (tmp_path / "m.toml").write_text(TEXT)
    shown = call("show", tmp_path / "m.toml", "--json")
    facts = json.loads(shown.stdout)
    assert facts["rolling_radius_difference_mm"] == pytest.approx(1.23, abs=0.02)
    assert 0.0 < facts["flange_clearance_right_mm"] < facts["flange_clearance_left_mm"]
    rail, wheel = facts["profiles"]["track.rail_profile"], facts["profiles"]["wheelset.wheel_profile"]
    assert (rail["points"], rail["unit"], rail["flange"]) == (495, "mm", None)
    assert (wheel["flange"], wheel["mirrored"], wheel["z_mm"]) == ("-y", True, pytest.approx([-2.636, 28.0], abs=1e-3))
    assert "MBench_S1002_v3.prw: Simpack, 399 points in mm" in " ".join(call("show", tmp_path / "m.toml").stdout.split())
    assert call("validate", tmp_path / "m.toml").stdout.endswith("valid\n")
    table = call("wear", tmp_path / "m.toml", "-o", tmp_path)
    assert table.returncode == 3 and "does not say how far the profiles wear" in table.stderr


def test_borders_in_maps_have_no_steps_of_elements():
    axes = patches_figure(solve_wheelset(beside(case_named("A2.2 right y=8.0"), grid=16))).axes[0]
    border = axes.collections[-1].get_paths()[0].vertices
    along = np.diff(np.vstack((border, border[1])) / np.ptp(border, axis=0), axis=0)
    turns = np.diff(np.unwrap(np.arctan2(along[:, 1], along[:, 0])))
    assert abs(turns).max() < 0.2 and axes.images[0].get_clip_path() is not None


def test_maps_of_coarse_patches_show_an_element_around_the_contact():
    """Elements of 3 mm along."""
    task = beside(case_named("A2.2 right y=8.0"), grid=8)
    task = replace(task, contact=replace(task.contact, numerics=Numerics((8, 8), extent=5.0)))
    shown = np.array(patches_figure(solve_wheelset(task)).axes[0].images[0].get_array())
    assert shown.any() and not shown[[0, -1]].any() and not shown[:, [0, -1]].any()


@pytest.mark.parametrize(("settings", "code", "words"), [
    (("vertical_N=2e7",), 4, ("N at most, not vertical_N = 2e+07 N",)),
    # Friction on the flange lifts the rail: Y/Q has no bound, and the load cannot be reached.
    (("wheels='right'", "lateral_shift_mm=8.0", "yaw_mrad=-20.0"), 4,
     ("vertical_N = 2e+04 N", "Nadal's limit Y/Q = 0.7", "Q = -")),
    (("wheels='right'", "traction_N=2e4"), 4, ("friction carries", "not traction_N = 2e+04 N")),
    (("wheels='right'", "height_mm=-3.0"), 0, ("no wheel touches its rail: ",)),
    (("wheels='right'", "height_mm=3.0"), 3, ("wheelset.height_mm", "overlaps its rail by ", "elastic contacts here by 1")),
])  # fmt: skip
def test_what_a_wheelset_cannot_reach_is_said(tmp_path, settings, code, words):
    """With the largest force found, or the way that is left; the exit code is that of every run."""
    friction = 0.6 if "yaw_mrad=-20.0" in settings else 0.3
    text = TEXT.replace("grid = 24", "grid = 8").replace("friction_coefficient = 0.3", f"friction_coefficient = {friction}")
    if "height_mm" in settings[-1]:
        text = text.replace("vertical_N = 20e3\n", "")
    (tmp_path / "m.toml").write_text(text)
    run = call("run", tmp_path / "m.toml", "-o", tmp_path / "out", "--json", "--no-plots",
               *(part for setting in settings for part in ("--set", f"wheelset.{setting}")))  # fmt: skip
    assert run.returncode == code, run.stderr
    assert all(word in run.stderr for word in words), run.stderr


@pytest.mark.parametrize("grid", [10, SLOW(24)])
def test_nadal_s_limit_has_the_coefficient_of_the_slip_that_was_found(grid):
    """A rising law is far from its largest coefficient, 0.9, at 60 mm/s."""
    law = {"friction.law": "table", "friction.table": [[0.0, 0.1], [0.1, 0.6], [10.0, 0.9]]}
    case = Case.parse(TEXT).with_values(law | {
        "load.friction_coefficient": 0.1, "numerics.grid": grid, "wheelset.wheels": "right", "wheelset.lateral_shift_mm": 8.0,
        "wheelset.yaw_mrad": -20.0})  # fmt: skip
    result = solve(case)
    assert not result.converged
    found = re.findall(r"Nadal's limit Y/Q = (\S+) with the coefficient of friction (\S+)", result.reason)
    assert [tuple(map(float, each)) for each in found] == [pytest.approx((0.807, 0.56), abs=2e-3)], result.reason


def test_a_wheelset_without_friction_rolls_freely():
    """Any angular velocity leaves it without torque, and nothing drives it."""
    frictionless = TEXT.replace("friction_coefficient = 0.3", "friction_coefficient = 0.0").replace("grid = 24", "grid = 8")
    frictionless = frictionless.replace("yaw_mrad", "roll_mrad = -0.25\nyaw_mrad")
    contact = Case.parse(frictionless, name="case.toml")
    result = solve_wheelset(contact.task)
    assert result.converged, result.reason
    assert result.scalars["angular_velocity_rad_s"] == pytest.approx(2.0 / 0.46, rel=5e-3)
    assert result.scalars["track_force_x_N"] == 0.0 == result.scalars["Q_F_W"]
    driven = solve_wheelset(replace(contact.task, traction=10.0))
    assert "friction carries 0 N at most" in driven.reason


@pytest.mark.slow
def test_a_contact_at_the_end_of_a_rail_has_a_pressure_without_bound():
    points = [[1e3 * y, 1e3 * z] for y, z in outline_points("MBench_UIC60_v3.prr") if y > -0.0135]
    text = TEXT.replace(f'{{ file = "{ROOT}/cases/MBench_UIC60_v3.prr" }}', f"{{ points_mm = {points} }}")
    task = Case.parse(text.replace("yaw_mrad", 'wheels = "right"\nyaw_mrad').replace("grid = 24", "grid = 12")).task
    result = solve_wheelset(task)
    assert result.converged, result.reason
    assert any("reaches the end of a profile" in warning for warning in result.warnings)
    assert math.isnan(relative(result)["pressure_max_MPa"]) and relative(result)["height_mm"] < 0.1
    # On the flank of the flange the sharp end finds no normal that it shares with the wheel.
    problem = replace(task, curved=True, vertical=5e3)
    for shift, reason in ((5e-3, "no height gives this force"), (7e-3, "the profiles meet at sharp ends alone")):
        beyond = solve_wheelset(replace(problem, position=replace(problem.position, y=shift)))
        assert reason in beyond.reason
    assert any("at the sharp end of a profile" in warning for warning in beyond.warnings)


@pytest.mark.parametrize("patches", ["planar", "curved"])
def test_a_cone_on_an_arc_is_hertz_contact(patches):
    """Place, height, force, pressure and approach in closed form, each within its error."""
    slope, radius = 0.05, 0.3
    rail = [(y, radius - math.sqrt(radius**2 - y**2)) for y in np.linspace(-0.035, 0.035, 141)]
    case = beside(case_named("A2.2 right y=8.0"))
    problem = replace(
        case, vertical=50e3, position=Position(), curved=patches == "curved", finds_speed=True,
        motion=replace(case.motion, angular_velocity=None), contact=replace(case.contact, friction=Friction(0.0)),
        rails={"right": RailSide(tuple(rail), 0.0, 0.7175, 0.014)},
        wheels={"right": WheelSide(((-0.04, 0.04 * slope), (0.0, 0.0), (0.04, -0.04 * slope)), 0.46, 0.68, -0.07)})
    result = solve_wheelset(problem)
    angle, middle = math.atan(slope), 0.7175 + 0.035
    offset = middle - radius * math.sin(angle) - 0.75
    rolling, load = 0.46 - slope * offset, 50e3 / math.cos(angle)
    hertz = hertz_contact(math.cos(angle) / rolling, 1.0 / radius, case.contact.contact_modulus, load)
    height = radius * (1.0 - math.cos(angle)) + slope * offset + hertz.approach / math.cos(angle)
    (patch,) = result.patches
    exact_values = {"pressure_max_MPa": 1e-6 * hertz.peak_pressure, "approach_um": 1e6 * hertz.approach, "normal_N": load}
    for name, exact in exact_values.items():
        assert patch.record[name] == pytest.approx(exact, abs=patch.record["uncertainty"][name]), name
        assert patch.record["uncertainty"][name] < 0.02 * abs(exact)
    assert result.scalars["height_mm"] == pytest.approx(1e3 * height, abs=relative(result)["height_mm"] * 1e3 * hertz.approach)
    assert result.scalars["rolling_radius_right_mm"] == pytest.approx(1e3 * rolling, abs=2e-4)
    assert patch.record["y_mm"] == pytest.approx(1e3 * (0.75 + offset), abs=2e-3)
    assert result.scalars["approach_max_um"] == patch.record["approach_um"]


@pytest.mark.slow
@pytest.mark.parametrize("at_height", [False, SLOW(True)])
def test_errors_of_patches_contain_that_of_their_loads(at_height):
    """Two patches share a load, or have one from a given height: coarse values are as far from finer ones as they say."""
    case = case_named("A2.2 right y=5.0 joined, conformal", "conformal")
    problem = beside(case, grid=16, curved=True)
    if at_height:
        problem = replace(problem, vertical=None, position=replace(problem.position, z=1e-3 * case["contact"]["z_ws_mm"]))
    contact = replace(problem.contact, numerics=Numerics((48, 48)))
    coarse, fine = solve_wheelset(problem), solve_wheelset(replace(problem, contact=contact))
    assert math.isnan(coarse.uncertainty["height_mm"]) == at_height
    assert math.isnan(coarse.uncertainty["track_force_z_right_N"]) != at_height
    scales = dict.fromkeys(("track_force_x_right_N", "track_force_y_right_N"), coarse.scalars["track_force_z_N"])
    for name, scale in {**scales, "lateral_over_vertical_right": 1.0}.items():
        assert abs(coarse.scalars[name] - fine.scalars[name]) <= relative(coarse)[name] * scale, name
    for rough, good in zip(coarse.patches, fine.patches, strict=True):
        for name in ("normal_N", "force_x_N", "force_s_N", "T_gamma_N", "approach_um"):
            assert abs(rough.record[name] - good.record[name]) <= rough.record["uncertainty"][name], name
        assert rough.record["uncertainty"]["normal_N"] < 0.05 * rough.record["normal_N"]


@pytest.mark.slow
@pytest.mark.parametrize(("shift", "yaw"), [
    (12.0, 30.0), (14.0, 40.0), (11.0, 26.0)])
def test_a_wheelset_that_climbs_its_rail_has_an_end_and_a_mirror_image(shift, yaw):
    """The height of one roll is no start for the next where that is deeper than any contact. The work is bounded: rounds."""
    both = [solve(Case.parse(TEXT.replace("grid = 24", "grid = 8")).with_values({
        "wheelset.lateral_shift_mm": sign * shift, "wheelset.yaw_mrad": sign * yaw})).summary() for sign in (1.0, -1.0)]
    assert [one["status"] for one in both] == ["converged", "converged"]
    assert both[0]["roll_mrad"] == pytest.approx(-both[1]["roll_mrad"], rel=1e-6)
    assert abs(both[0]["roll_mrad"]) > 10.0
    assert both[0]["track_force_y_right_N"] == pytest.approx(-both[1]["track_force_y_left_N"], abs=2.0)


@pytest.mark.slow
def test_roll_speed_and_rolling_radii_have_errors_that_cover_a_finer_grid():
    """The power of the creep forces moves with the angular velocity; what is given has no error."""
    coarse, fine = (solve(Case.parse(TEXT.replace("grid = 24", f"grid = {side}"))) for side in (16, 32))
    for name in ("roll_mrad", "rolling_radius_left_mm", "rolling_radius_right_mm", "rolling_radius_difference_mm"):
        assert abs(coarse[name] - fine[name]) <= coarse.uncertainty[name] < 0.02
    for name in ("angular_velocity_rad_s", "T_gamma_N", "Q_F_W"):
        assert abs(coarse[name] - fine[name]) <= coarse.uncertainty[name], name
    assert 0.0 < relative(fine)["angular_velocity_rad_s"] < 1e-4
    given = solve(Case.parse(STANDING.replace("grid = 16", "grid = 8"))).uncertainty
    assert math.isnan(given["roll_mrad"]) and math.isnan(given["angular_velocity_rad_s"])


@pytest.mark.parametrize(("turns", "wheel_modulus"), [
    (1.02, 210.0), (1.0, 70.0), SLOW(1.0, 210.0), SLOW(1.0, 300.0)])
def test_a_cylinder_on_a_crowned_rail_is_a_single_contact(turns: float, wheel_modulus: float) -> None:
    """Heathcote's slip is that of the surface in which both bodies touch, also where the wheel's own has none. Of unlike bodies
    that do not couple, (1 − 2ν)/G alike, the stiffer one keeps more of its shape."""
    steel, load = {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, {"friction_coefficient": 0.3}
    poisson = 0.25 * (math.sqrt(9.0 - 8.0 * 0.44 * 1.28 * wheel_modulus / 210.0) - 1.0)
    materials = {"lower": steel, "upper": {"youngs_modulus_GPa": wheel_modulus, "poisson_ratio": poisson}}
    common = {"material": materials, "thermal": {"heat": False}, "numerics": {"grid": 32}}
    rail = [[y, 300.0 - math.sqrt(300.0**2 - y**2)] for y in np.linspace(-25.0, 25.0, 201).tolist()]
    wheel = {"wheel_profile": {"points_mm": [[y, 0.0] for y in range(-60, 61)]}, "nominal_radius_mm": 460.0, "wheels": "right",
             "flange_back_distance_mm": 1360.0, "flange_back_mm": -60.0, "vertical_N": 50e3}
    whole = solve(Case.from_dict(common | {
        "track": {"rail_profile": {"points_mm": rail}, "gauge_mm": 1435.0, "gauge_height_mm": 1.0}, "load": load,
        "wheelset": wheel | ({"angular_velocity_rad_s": turns * 2.0 / 0.46} if turns > 1.0 else {}),
        "rolling": {"speed_m_s": 2.0}}))
    motion = whole.contacts[0].problem.motion
    assert motion.creepage_x is not None
    single = solve(Case.from_dict(common | {
        "geometry": {"lower_radius_x_mm": math.inf, "upper_radius_x_mm": 460.0, "lower_radius_y_mm": 300.0,
                     "upper_radius_y_mm": math.inf},
        "load": load | {"normal_N": 50e3}, "creepage": {"longitudinal": motion.creepage_x},
        "rolling": {"speed_m_s": motion.speed}}))
    apart = abs(whole["Q_F_W"] - single["Q_F_W"])
    assert apart <= whole.uncertainty["Q_F_W"] + single.uncertainty["Q_F_W"] < 0.1 * single["Q_F_W"]
    assert single["Q_F_W"] > 1e-3


def test_a_surface_that_is_too_steep_has_no_section() -> None:
    angle = np.radians(np.linspace(0.0, 89.0, 90))
    at, value = np.sin(angle), -np.cos(angle)
    assert section(at, value, np.cos(angle), np.sin(angle), 40)[1][-1] == 84
    with pytest.raises(Unsolvable, match="steeper than 84 degrees"):
        section(at, value, np.cos(angle), np.sin(angle), 86)

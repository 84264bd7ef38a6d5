"""Friction that depends on the place: over the inclination of rails beside CONTACT, and across bodies with profiles."""

from __future__ import annotations

import copy
import json
import math
from functools import lru_cache, partial

import h5py
import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.documents import printed
from tests.support.sampling import sampled
from tests.support.wheelsets import ROOT, case_named
from thermoroll_cli import Case, CaseError, solve

CONTACT_EXAMPLE = [[-20.0, 0.2], [-10.0, 0.3]]


def right_wheel(friction, patches="curved", grid=16, side="right", name="A2.2 right y=5.5", **more):
    """The right wheel of the Manchester benchmark at 5.5 mm with 10 kN, or another one, or its mirror image."""
    given, sign = case_named(name)["input"], 1.0 if side == "right" else -1.0
    settings = {
        "wheelset.wheels": side, "wheelset.vertical_N": 1e4, "wheelset.lateral_shift_mm": given["y"] * sign,
        "wheelset.patches": patches, "wheelset.yaw_mrad": 1e3 * sign * given["yaw"],
        "wheelset.roll_mrad": 1e3 * sign * given["roll"], "wheelset.angular_velocity_rad_s": -given["omega"],
        "thermal.heat": False, "numerics.grid": grid,
    }  # fmt: skip
    content = json.loads(Case.read(ROOT / "cases" / "manchester.toml").with_values(settings).to_json())
    if friction is not None:
        content["load"] = more
        content["friction"] = friction
    return solve(content)


def forces(result, side="right"):
    return np.array([result[f"track_force_{way}_{side}_N"] for way in "xy"])


def assert_is_printed(result, theirs, text):
    """The row of docs/wheelset.md has CONTACT's forces and, within ± and the printed digits, those found here."""
    *others, x, y = printed("wheelset", text)
    assert [number.value for number in others[-2:]] == [float(f"{value:.0f}") for value in theirs]
    for way, number, found in zip("xy", (x, y), forces(result), strict=True):
        assert found == pytest.approx(number.value, abs=number.rounding + result.uncertainty[f"track_force_{way}_right_N"])


@pytest.mark.parametrize(("patches", "theirs", "within", "row"), [
    ("planar", (-608.6, 1417.0), 20.0, "−609, 1417; −613, 1400"),
    pytest.param("curved", (-613.9, 1387.0), 5.0, "−614, 1387; −614, 1388", marks=pytest.mark.slow)])
def test_forces_with_a_lubricated_flange_are_those_of_contact(patches, theirs, within, row):
    result = right_wheel({"over_angle": CONTACT_EXAMPLE}, patches, grid=32)
    np.testing.assert_allclose(forces(result), theirs, atol=within)
    assert_is_printed(result, theirs, row)
    (patch,) = result.patches
    local = patch.fields["friction_coefficient"][patch.fields["pressure"] > 0.0]
    assert local.min() == pytest.approx(0.2, abs=1e-3) and 0.21 < local.max() < 0.3
    assert len(result.plot("friction").axes) == 2
    assert patch["friction_limit_N"] == pytest.approx(patch["friction_mean"] * patch.problem.normal_force, rel=0.01)


@pytest.mark.parametrize(("patches", "theirs", "within", "row"), [
    ("curved", (-657.6, 562.9), 5.0, "−658, 563; −658, 565"),
    pytest.param("planar", (-630.1, 468.6), 2.0, "−630, 469; −629, 468", marks=pytest.mark.slow)])
def test_forces_of_tread_and_flange_are_those_of_contact(patches, theirs, within, row):
    """Two patches 10 mm apart share the load, one on the dry tread, one on the flange's root. CONTACT keeps them apart only if
    its D_SEP and D_COMB are smaller than 10 mm, here 0.3 and 0.2 mm. With 6 and 3 mm, as in its example, it turns the tread's
    patch from 7.6 to 14.2 degrees on the way to one patch: (−637.4, 646.3) N. Its conformal patch (0.1 mm) holds both."""
    result = right_wheel({"over_angle": CONTACT_EXAMPLE}, patches, grid=32, name="A2.2 right y=5.0 apart")
    assert [patch["friction_mean"] for patch in result.patches] == pytest.approx([0.2289, 0.3], abs=2e-4)
    np.testing.assert_allclose(forces(result), theirs, atol=within)
    assert_is_printed(result, theirs, row)


def test_forces_of_joined_patches_that_documents_quote_are_those_of_contact():
    forces_there = case_named("A2.2 right y=5.0 joined, conformal", "conformal")["contact"]["force_rail_track_N"]
    for number, value in zip(printed("wheelset", "−849 and 20 N on the right rail"), forces_there, strict=False):
        assert value == pytest.approx(number.value, abs=1.0)


def test_constant_points_change_nothing():
    wheel = partial(right_wheel, grid=8)
    given = wheel(None, friction_coefficient=0.3)
    assert wheel({"over_angle": [[-20.0, 0.3], [5.0, 0.3]]}).scalars == given.scalars
    assert wheel({"right": {"over_angle": [[0.0, 0.3]]}}).scalars == given.scalars


@pytest.mark.slow
def test_a_wheel_has_its_own_friction_and_a_mirrored_one_mirrored_forces():
    wheel = partial(right_wheel, grid=8)
    own = wheel({"over_angle": [[0.0, 0.1]], "right": {"over_angle": CONTACT_EXAMPLE}})
    np.testing.assert_allclose(forces(own), forces(wheel({"over_angle": CONTACT_EXAMPLE})), rtol=1e-9)
    left = wheel({"over_angle": CONTACT_EXAMPLE}, side="left")
    np.testing.assert_allclose(forces(left, "left") * [1.0, -1.0], forces(own), rtol=1e-6)


PROFILED = {
    "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28},
    "geometry": {"lower_radius_x_mm": math.inf, "upper_radius_x_mm": 460.0, "upper_radius_y_mm": math.inf,
                 "lower_profile": {"points_mm": [[float(y), -y * y / 600.0] for y in range(-20, 21)]}},
    "load": {"normal_N": 8e4}, "rolling": {"speed_m_s": 20.0}, "creepage": {"longitudinal": 0.001},
    "numerics": {"grid": 16},
}  # fmt: skip


def profiled(friction, **more):
    content = copy.deepcopy(PROFILED)
    for name, table in more.items():
        content[name] = content.get(name, {}) | table
    return solve(content | ({"friction": friction} if friction else {}))


def test_full_sliding_has_the_coefficient_of_every_place():
    points = [[-4.0, 0.1], [1.0, 0.4]]
    result = profiled({"across": points}, creepage={"longitudinal": 0.1})
    fields, y = result.fields, 1e3 * result.coupled.y
    dy = y[1] - y[0]
    # Elements have the mean of the places in them, each with its pressure, which changes evenly.
    place, pressure = (np.arange(200) + 0.5 - 100.0) / 200.0, fields["pressure"]
    slope = np.clip(np.gradient(np.pad(pressure, ((0, 0), (1, 1))), axis=1)[:, 1:-1], -2.0 * pressure, 2.0 * pressure)
    there = np.interp(y[:, None] + dy * place, *np.array(points).T)
    expected = (there * (pressure[:, :, None] + slope[:, :, None] * place)).mean(axis=2)
    np.testing.assert_allclose(np.hypot(fields["shear_x"], fields["shear_y"]), expected, atol=1e-3 * expected.max())
    np.testing.assert_allclose((fields["friction_coefficient"] * pressure)[pressure > 0.0], expected[pressure > 0.0], rtol=1e-4)


@lru_cache
def fine_lines():
    """Load per width of lines of rolling, in Pa m, and their y in mm."""
    fine = profiled({"across": [[0.0, 0.3]]}, numerics={"grid": 96})
    return fine.fields["pressure"].sum(axis=0), 1e3 * fine.coupled.y


@pytest.mark.parametrize("grid", [16, 17])
@pytest.mark.parametrize("points", [[[-0.01, 0.3], [0.0, 0.6], [0.01, 0.3]], [[-0.01, 0.0], [0.0, 0.6], [0.01, 0.0]],
                                    [[0.999, 0.3], [1.001, 0.1]]])  # fmt: skip
def test_friction_that_changes_within_an_element_is_carried_as_it_is(grid, points):
    """A spike, a stripe and a step in full sliding, on grids with and without a column in the middle: the force is that of the
    pressure of a fine grid, within its error, and about the limit. Peaks beside such places have no error, and a warning says
    so."""
    result = profiled({"across": points}, creepage={"longitudinal": 0.1}, numerics={"grid": grid})
    lines, y = fine_lines()
    t = np.linspace(y[0], y[-1], 400001)
    exact = 8e4 * np.average(np.interp(t, *np.array(points).T), weights=np.interp(t, y, lines))
    assert result["friction_limit_N"] == pytest.approx(exact, rel=1e-3)
    assert abs(result["force_x_N"] - exact) <= result.uncertainty["force_x_N"] + 1e-5 * exact
    assert math.isnan(result.uncertainty["shear_max_MPa"])
    assert any(warning.startswith("friction changes by") for warning in result.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("points", sampled([[[2.0, 0.0], [2.02, 0.5]], [[0.7, 0.1], [0.72, 0.5], [0.9, 0.5], [0.92, 0.1]],
                                            [[-1.5, 0.5], [-1.49, 0.05], [-1.2, 0.05], [-1.19, 0.5]]], 3))  # fmt: skip
@pytest.mark.parametrize("creepage", sampled([{"longitudinal": 1.2e-3, "lateral": 6e-4}, {"longitudinal": 3e-4}]))
def test_forces_of_contacts_that_stick_have_errors_where_friction_jumps(points, creepage):
    """A step to nothing, a stripe as wide as an element and one of little friction, against a grid four times as fine."""
    fine = profiled({"across": points}, creepage=creepage, numerics={"grid": 112})
    limit = fine["friction_limit_N"]
    for grid in (24, 28, 33):
        result = profiled({"across": points}, creepage=creepage, numerics={"grid": grid})
        for name in ("force_x_N", "force_y_N", "Q_F_W", "stick_area_mm2"):
            own = result.uncertainty[name] + fine.uncertainty[name]
            # Areas that stick are found element by element: some are off by more than their error.
            assert abs(result[name] - fine[name]) <= (2.0 if name == "stick_area_mm2" else 1.0) * own + 1e-9, (name, grid)
        assert 1e-5 * limit < result.uncertainty["force_x_N"] < 0.05 * limit


def test_a_spike_between_elements_has_the_largest_temperature_of_none():
    heat = {"material": {"conductivity_W_mK": 50.0, "diffusivity_mm2_s": 14.0, "expansion_um_mK": 12.0},
            "thermal": {"deformation": False}}
    spike, step = [[0.4, 0.1], [0.41, 0.6], [0.42, 0.1]], [[0.4, 0.1], [0.41, 0.6]]
    for points, known in ((spike, False), (step, True)):
        result = profiled({"across": points}, creepage={"longitudinal": 0.01}, **heat)
        assert math.isfinite(result.uncertainty["temperature_rise_max_lower_K"]) is known
        assert math.isfinite(result.uncertainty["temperature_rise_mean_lower_K"])
        (warning,) = (warning for warning in result.warnings if warning.startswith("friction changes by"))
        assert ("largest temperatures" in warning) is not known


def test_constant_mirrored_and_split_points_across_change_nothing():
    given = profiled(None, load={"friction_coefficient": 0.3})
    assert profiled({"across": [[-3.0, 0.3], [8.0, 0.3]]}).scalars == given.scalars
    points = [[-3.0, 0.2], [3.0, 0.4]]
    one = profiled({"across": points})
    other = profiled({"across": [[-y, mu] for y, mu in reversed(points)]})
    split = profiled({"across": [[-9.0, 0.2], points[0], [0.0, 0.3], points[1], [9.0, 0.4]]})
    for name, sign in (("force_x_N", 1.0), ("force_y_N", -1.0), ("spin_moment_Nmm", -1.0), ("stick_area_mm2", 1.0)):
        assert other[name] == pytest.approx(sign * one[name], rel=1e-5)
        assert split[name] == pytest.approx(one[name], rel=1e-5)
    assert abs(one["spin_moment_Nmm"]) > 0.01 * one["force_x_N"]
    assert given["force_x_N"] > one["force_x_N"]


def test_laws_of_slip_and_temperature_multiply_the_places():
    """In full sliding at one slip speed a law is one factor of all places."""
    law = {"law": "rational", "limit_coefficient": 0.2, "half_slip_m_s": 1.0}
    sliding = {"creepage": {"longitudinal": 0.5}, "rolling": {"speed_m_s": 20.0, "differential_slip": False}}
    whole = profiled({"across": [[-3.0, 0.2], [3.0, 0.4]]}, **sliding)
    fallen = profiled({"across": [[-3.0, 0.2], [3.0, 0.4]], **law}, **sliding)
    assert fallen["force_x_N"] / whole["force_x_N"] == pytest.approx(0.5 + 0.5 / 11.0, rel=1e-3)
    carried = profiled({"across": [[-3.0, 0.2], [3.0, 0.4]]}, creepage={"longitudinal": None},
                       force={"longitudinal_N": 0.8 * whole["force_x_N"]})  # fmt: skip
    assert carried.converged and carried["creepage_longitudinal"] > 0.001


@pytest.mark.parametrize("share", [1.02, pytest.param(1.2, marks=pytest.mark.slow)])
def test_a_force_that_the_places_do_not_carry_has_a_reason(share):
    result = profiled({"across": [[-3.0, 0.2], [3.0, 0.4]]}, creepage={"longitudinal": None},
                      force={"longitudinal_N": share * 0.3 * 8e4})  # fmt: skip
    assert not result.converged and "friction across the contact carries 24" in result.reason


def test_radii_have_no_places_and_the_command_writes_the_local_coefficient(tmp_path):
    geometry = dict.fromkeys(("lower_radius_x_mm", "lower_radius_y_mm", "upper_radius_x_mm", "upper_radius_y_mm"), 30.0)
    with pytest.raises(CaseError, match="belongs to bodies with profiles"):
        solve(PROFILED | {"geometry": geometry, "friction": {"across": [[0.0, 0.2]]}})
    case = Case.from_dict(PROFILED | {"friction": {"across": [[-3.0, 0.2], [3.0, 0.4]]}})
    (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    done = call("run", tmp_path / "case.toml", "-o", tmp_path, "--json", "--no-plots")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "case.h5") as file:
        assert np.ptp(np.unique(file["fields/friction_coefficient"][...])[1:]) > 0.1
    assert json.loads(done.stdout)["friction_mean"] > 0.2
    shown = call("show", tmp_path / "case.toml")
    assert "friction.across" in shown.stdout


def test_other_commands_take_friction_of_places(tmp_path):
    """Tables of local coefficients, and wear, by the command."""
    content = PROFILED | {"friction": {"across": [[-3.0, 0.2], [3.0, 0.4]]}, "numerics": {"grid": 12},
                          "creepage": {"longitudinal": 0.1},
                          "wear": {"depth_um": 1.0, "upper": {"specific_wear_rate_mm3_Nm": 1e-4}}}
    (tmp_path / "case.toml").write_text(Case.from_dict(content).to_toml(), encoding="utf-8")
    quiet = ("-q", "--no-plots", "-o", "out")
    for command in (("run", "case.toml", *quiet), ("export", "out/case.h5", "--format", "csv", "-o", "out")):
        done = call(*command, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    table = np.genfromtxt(tmp_path / "out" / "case.csv", delimiter=",", names=True)
    local, y = table["friction_coefficient"], table["y_mm"]
    loaded = table["pressure_MPa"] > 0.0
    # Elements have a mean of what is in them, where the pressure is high more than where it is low.
    np.testing.assert_allclose(local[loaded], np.interp(y[loaded], [-3.0, 3.0], [0.2, 0.4]), atol=4e-3)
    worn = call("wear", "case.toml", "--json", *quiet, cwd=tmp_path)
    assert worn.returncode == 0, worn.stderr
    row = json.loads(worn.stdout)
    # In full sliding the wear follows the pressure, and the heat the friction: what is worn off is κ W ξ, whatever the places.
    assert row["worn_volume_upper_cm3"] * 1e3 == pytest.approx(1e-4 * 8e4 * 0.1 * 1e3 * row["distance_km"], rel=1e-3)


@pytest.mark.slow
def test_a_wheelset_with_a_lubricated_flange_wears(tmp_path):
    """Worn volume κ ∫ p s: of Tγ with the coefficient of each place, so more than by the largest coefficient alone."""
    case = Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "wheelset.wheels": "right", "wheelset.vertical_N": 1e4, "wheelset.lateral_shift_mm": 5.5, "wheelset.yaw_mrad": 13.2,
        "wheelset.angular_velocity_rad_s": 4.3319, "numerics.grid": 12, "thermal.heat": False})  # fmt: skip
    content = json.loads(case.to_json()) | {"load": {}, "friction": {"over_angle": CONTACT_EXAMPLE},
                                            "wear": {"depth_um": 2.0, "upper": {"specific_wear_rate_mm3_Nm": 1e-5}}}
    (tmp_path / "case.toml").write_text(Case.from_dict(content).to_toml(), encoding="utf-8")
    worn = call("wear", "case.toml", "--json", "-q", "--no-plots", "-o", "out", cwd=tmp_path)
    assert worn.returncode == 0, worn.stderr
    again = call("run", "--from", "out/case_wear.h5", "--json", "-q", "--no-plots", "-o", "out", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    row = json.loads(worn.stdout)
    at_most = 1e-5 * row["T_gamma_N"] * 1e3 * row["distance_km"]
    assert at_most / 0.25 < 1e3 * row["worn_volume_wheel_right_cm3"] < at_most / 0.19

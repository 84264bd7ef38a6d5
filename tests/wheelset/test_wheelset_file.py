"""The one file of a wheelset through every command that takes results, and its scalars from those of its patches."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
import pytest
import xarray

from tests.support.command_line import call
from tests.support.wheelsets import ROOT
from thermoroll_cli import Case, Solver, read_result
from thermoroll_cli.problem.names import TOGETHER
from thermoroll_cli.problem.result import Result

WORN = Case.read(ROOT / "cases" / "manchester.toml").with_values({
    "numerics.grid": 12, "thermal.deformation": False, "wheelset.lateral_shift_mm": 5.0, "wheelset.yaw_mrad": 12.0,
    "wheelset.roll_mrad": -0.355, "wheelset.angular_velocity_rad_s": 4.3345, "wheelset.patches": "planar",
    "wear.upper.specific_wear_rate_mm3_Nm": 1e-5})  # fmt: skip
CASE = WORN.with_values({"subsurface.bodies": ["lower"], "subsurface.thermal": False, "subsurface.layers": 6,
                         "subsurface.fields": "full", "strength.lower.shear_yield_MPa": 400.0})
NAMES = ["left_1", "right_1", "right_2"]


@pytest.fixture(scope="module")
def solved() -> list[Result]:
    """What `run` has solved, as the file has it."""
    return []


@pytest.fixture(scope="module")
def folder(solved: list[Result], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With m.toml, its results, and what `run` has printed."""
    folder = tmp_path_factory.mktemp("wheelset")
    (folder / "m.toml").write_text(CASE.to_toml())
    by_run = Solver.solve
    with mock.patch.object(Solver, "solve", lambda *task, **how: solved.append(by_run(*task, **how)) or solved[-1]):
        done = call("run", "m.toml", "--no-plots", cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "printed").write_text(done.stdout, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def stored(folder: Path) -> Result:
    return read_result(folder / "results" / "m.h5")


def test_all_of_it_comes_back(folder: Path, stored: Result, solved: list[Result]) -> None:
    """As solved; each patch as an ordinary result, with its place on the track."""
    (result,) = solved
    result = result.with_case(stored.case_text, CASE.to_json())
    assert [path.name for path in (folder / "results").iterdir()] == ["m.h5"]
    assert [patch.name for patch in stored.contacts] == NAMES == [patch.name for patch in result.contacts]
    for one, other in ((stored, result), *zip(stored.contacts, result.contacts, strict=True)):
        summaries = [each.summary() for each in (one, other)]
        for summary in summaries:
            summary.pop("work")
        assert json.dumps(summaries[0], sort_keys=True) == json.dumps(summaries[1], sort_keys=True)
        assert one.case_json == CASE.to_json() and one.lines.keys() == other.lines.keys()
        for name, line in one.lines.items():
            np.testing.assert_array_equal(line, other.lines[name])
        for name, values in one.fields.items():
            np.testing.assert_array_equal(values, other.fields[name])
    with h5py.File(folder / "results" / "m.h5") as file:
        single = set(file["patches/left_1"])
        assert {"fields", "numbers", "lower", "lines"} <= single and "numbers" in file
    with xarray.open_datatree(folder / "results" / "m.h5", engine="h5netcdf") as tree:
        assert tree["patches/right_2/fields/pressure"].dims == ("x", "y") and tree["lines/rail_left"].sizes["coordinate"] == 2
        assert tree["patches/left_1/lower/stress_xx"].dims == ("z", "x", "y")
    whole = read_result(folder / "results" / "m.h5", with_fields=False)
    assert whole.scalars == stored.scalars and not whole.contacts[0].fields


def test_the_whole_has_the_scalars_of_its_patches(stored: Result) -> None:
    """Sums, of each wheel too, and largest values of all that was computed, strength and wear among them, with errors."""
    for name in ("Q_F_W", "T_gamma_N", "contact_area_mm2", "heat_into_lower_W", "wear_rate_upper_mm3_m"):
        of = [patch[name] for patch in stored.contacts]
        stem, unit = re.fullmatch(r"(.*?)(_W|_N|_mm2|_mm3_m)", name).groups()  # type: ignore[union-attr]
        assert stored[name] == pytest.approx(sum(of), rel=1e-12)
        assert stored[f"{stem}_left{unit}"] == of[0]
        assert stored[f"{stem}_right{unit}"] == pytest.approx(of[1] + of[2], rel=1e-12)
        assert stored.uncertainty[name] == pytest.approx(sum(patch.uncertainty[name] for patch in stored.contacts), rel=1e-9)
    for name in ("pressure_max_MPa", "von_mises_max_lower_MPa", "shakedown_k_lower_MPa", "wear_depth_max_upper_nm",
                 "temperature_rise_max_upper_K", "surface_temperature_max_lower_K"):
        assert stored[name] == max(patch[name] for patch in stored.contacts)
        assert stored.uncertainty[name] == pytest.approx(max(patch.uncertainty[name] for patch in stored.contacts), rel=1e-9)
    assert stored["shakedown_factor_lower"] == min(patch["shakedown_factor_lower"] for patch in stored.contacts)
    for name in TOGETHER:
        assert (name in stored.scalars) == any(name in patch.scalars for patch in stored.contacts), name
    record = stored.records[1]
    assert record["von_mises_max_lower_MPa"] == stored.contacts[1]["von_mises_max_lower_MPa"]
    assert record["uncertainty"]["von_mises_max_lower_MPa"] > 0.0 < record["uncertainty"]["normal_N"]
    assert not any(isinstance(value, float) and math.isnan(value) for value in record.values())


def test_the_table_shows_them_with_their_errors(folder: Path, stored: Result) -> None:
    printed = (folder / "printed").read_text(encoding="utf-8")
    rows = {line.split()[0]: line for line in printed.splitlines()}
    assert rows["von_mises_max_lower_MPa"].count("±") == 3 and rows["wear_area_upper_SIDE_um2"].count("±") == 2
    assert rows["T_gamma_SIDE_N"].count("±") == 2 and rows["Q_F_W"].count("±") == 3
    shown = [float(number) for number in rows["pressure_max_MPa"].split()[1:-1] if number != "±"]
    for patch, value, error in zip(stored.records, shown[::2], shown[1::2], strict=True):
        assert value == pytest.approx(patch["pressure_max_MPa"], abs=error)
        assert error == pytest.approx(patch["uncertainty"]["pressure_max_MPa"], rel=0.5)
    assert "wrote results/m.h5" in printed


@pytest.mark.slow
def test_pictures_of_the_file_are_those_of_the_run(folder: Path, stored: Result) -> None:
    drawn = call("plot", "results/m.h5", "-o", "plotted", cwd=folder, painted=True)
    assert drawn.returncode == 0, drawn.stderr
    assert {path.name for path in (folder / "plotted").iterdir()} == {"m_section.png", "m_patches.png"}
    drawn = call("plot", "results/m.h5", "-o", "fields", "--fields", "section,pressure", cwd=folder)
    assert {path.name for path in (folder / "fields").iterdir()} == {"m_section.png", *(f"m_{n}_pressure.png" for n in NAMES)}
    section, patches = stored.plot(), stored.plot("patches")
    words = [text.get_text() for figure in (section, patches) for text in figure.texts]
    assert any("seen from behind" in text for text in words) and any("seen from above" in text for text in words)
    assert re.search(r"right wheel\npatch 1: [\d.]+ kN, \d+ MPa, angle −\d+ mrad\npatch 2: ", section.axes[1].get_title())
    assert stored.contacts[0].plot("pressure").axes
    wrong = call("plot", "results/m.h5", "--fields", "presure", cwd=folder)
    assert wrong.returncode == 2 and "no picture 'presure'" in wrong.stderr


def test_the_comb_stands_where_the_patch_lies(stored: Result) -> None:
    """Places of the patches' lines on the track are those of their records."""
    for patch in stored.contacts:
        y, z, angle = patch.lines["surface"]
        centre = float(patch.fields["pressure"].sum(axis=0) @ patch.y / patch.fields["pressure"].sum())
        at = [float(np.interp(centre, patch.y, line)) for line in (y, z, angle)]
        assert [1e3 * value for value in at] == pytest.approx(
            [patch.record[name] for name in ("y_mm", "z_mm", "angle_mrad")], abs=1e-2)
        side = patch.record["side"]
        rail = stored.lines[f"rail_{side}"]
        assert np.hypot(*(rail - np.array([at[0], at[1]])[:, None])).min() < 5e-4


def test_files_are_compared_patch_by_patch(folder: Path) -> None:
    shutil.copy(folder / "results" / "m.h5", folder / "again.h5")
    same = call("compare", "results/m.h5", "again.h5", cwd=folder)
    assert same.returncode == 0 and "largest difference 0.0e+00" in same.stdout
    assert call("run", "--from", "again.h5", "-o", "moved", "-q", "--no-plots", "--set", "wheelset.lateral_shift_mm=4",
                cwd=folder).returncode == 0  # fmt: skip
    other = call("compare", "results/m.h5", "moved/again.h5", "--json", cwd=folder)
    rows = {row["name"]: row for row in json.loads(other.stdout)["rows"]}
    assert other.returncode == 6 and not rows["right_2"]["within"] and not rows["left_1.pressure_max_MPa"]["within"]
    assert rows["right_2"]["note"] == "missing in the second file" and not rows["track_force_x_left_N"]["within"]


def test_export_has_tables_for_spreadsheets_and_grids_for_paraview(folder: Path, stored: Result) -> None:
    done = call("export", "results/m.h5", "--format", "csv", "--format", "xdmf", "-o", "exported", cwd=folder)
    assert done.returncode == 0, done.stderr
    with open(folder / "exported" / "m.csv", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for row, patch in zip(rows, stored.contacts, strict=True):
        assert float(row["normal_N"]) == patch.record["normal_N"]
        assert float(row["uncertainty.force_s_N"]) == patch.record["uncertainty"]["force_s_N"]
    with open(folder / "exported" / "m_right_2.csv", encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == stored.contacts[2].fields["pressure"].size
    text = (folder / "exported" / "m.xdmf").read_text()
    with h5py.File(folder / "results" / "m.h5") as file:
        places = re.findall(r"m\.h5:(/[\w/]+)", text)
        assert len(places) > 30 and all(place in file for place in places)
    drawn = call("plot", "exported/m.csv", cwd=folder)
    assert drawn.returncode == 5 and "not the table of a sweep" in drawn.stderr
    done = call("export", "results/m.h5", "--format", "csv", "--stress-path", "0,0.1", "-o", "exported", cwd=folder)
    assert done.returncode == 0 and (folder / "exported" / "m_left_1_stress_path.csv").exists(), done.stderr


def test_a_result_is_a_case_for_other_commands(folder: Path) -> None:
    shown = call("show", "results/m.h5", "--json", cwd=folder)
    assert json.loads(shown.stdout)["inputs"]["wheelset.lateral_shift_mm"]["value"] == 5.0
    worn = call("wear", "results/m.h5", "-o", "worn", cwd=folder)
    assert worn.returncode == 3 and "does not say how far the profiles wear" in worn.stderr


@pytest.mark.slow
def test_python_takes_it_as_any_result(stored: Result, tmp_path: Path) -> None:
    assert read_result(stored.save(tmp_path / "w.h5")).scalars == stored.scalars
    patch = stored.contacts[1].save(tmp_path / "p.h5")
    assert read_result(patch).scalars == stored.contacts[1].scalars
    data = stored.contacts[1].to_xarray()
    assert data.pressure.attrs["units"] == "Pa" and "pressure" not in stored.to_xarray()
    assert stored.to_xarray().attrs["track_force_z_N"] == stored["track_force_z_N"]
    solver = Solver()
    here, there = (solver.solve(WORN.with_values({"wheelset.lateral_shift_mm": shift, "thermal.heat": False}))
                   for shift in (3.0, 3.1))
    assert here.converged and there.converged and there.case_json != here.case_json


def test_a_sweep_has_columns_of_patches_with_units(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(WORN.with_values({"thermal.heat": False}).to_toml())
    done = call("sweep", "m.toml", "--over", "wheelset.lateral_shift_mm=4,5", "-o", ".", "--scalars-only", "-q", "--json",
                cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "sweep.png").exists(), done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    with open(tmp_path / "sweep.csv", encoding="utf-8") as stream:
        table = list(csv.DictReader(stream))
    assert rows[1]["over"] == {"wheelset.lateral_shift_mm": 5} and rows[1]["rolling_radius_difference_mm"] > 0.5
    assert float(table[1]["left_1.y_rail_mm"]) == rows[1]["patches"][0]["y_rail_mm"]
    assert float(table[1]["right_1.uncertainty.normal_N"]) == rows[1]["patches"][1]["uncertainty"]["normal_N"]
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert file["right_2.normal_N"].attrs["units"] == b"N" and math.isnan(file["right_2.normal_N"][0])
        assert file["right_1.uncertainty.normal_N"].attrs["units"] == b"N" and file["right_1.uncertainty.normal_N"][1] > 0.0
        assert file["wear_rate_upper_left_mm3_m"].attrs["units"].decode() == "mm³/m"
        assert file["track_force_y_left_N"].attrs["units"] == b"N" and file["uncertainty.track_force_y_left_N"][0] > 0.0
        meaning = file["left_1.uncertainty.Q_F_W"].attrs["long_name"].decode()
        assert meaning == "patch left_1: estimated error: total frictional heat"

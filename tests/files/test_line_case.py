"""Line contacts through their real entry points: keys, names per length, files, pictures, and what is refused by name."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.documents import ROOT
from thermoroll_cli import Case, CaseError, read_result, solve
from thermoroll_cli.cli.cases import template_text
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.problem.names import ACROSS, LINE_SCALARS, PER_LENGTH
from thermoroll_cli.problem.scalar_errors import meaning_in

GEARS: dict[str, Any] = {
    "material": {"youngs_modulus_GPa": 206.0, "poisson_ratio": 0.3},
    "geometry": {"lower_radius_x_mm": 10.0, "upper_radius_x_mm": 15.0},
    "load": {"normal_N_mm": 12.5, "friction_coefficient": 0.06}, "rolling": {"speed_m_s": 3.0},
    "creepage": {"longitudinal": 0.0002}, "numerics": {"grid": 32}}


def gears(**tables: dict[str, Any]) -> dict[str, Any]:
    return {**GEARS, **{name: {**GEARS.get(name, {}), **table} for name, table in tables.items()}}


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "gears.toml"
    path.write_text(Case.from_dict(GEARS).to_toml())
    return path


def test_names_are_per_length_and_fields_over_x() -> None:
    result = solve(GEARS)
    assert result.converged and set(result.coupled.scalars) == {*LINE_SCALARS}
    assert not {*PER_LENGTH, *ACROSS} & {*result.numbers}
    # E* = 206/(2·0.91) GPa, R = 6 mm: Hertz by hand.
    modulus = 206e3 / 1.82
    half = math.sqrt(4.0 * 12.5 * 6.0 / (math.pi * modulus))
    assert meaning_in(result.coupled.scalars, "gamma_c") == "contact width / Hertz width"
    assert result["hertz_a_mm"] == pytest.approx(half) and result["contact_width_mm"] == pytest.approx(2.0 * half)
    assert result["pressure_max_MPa"] == pytest.approx(2.0 * 12.5 / (math.pi * half))
    assert result["friction_limit_N_mm"] == pytest.approx(0.75) and result["normal_N_mm"] == pytest.approx(12.5)
    force, creepage = result["force_x_N_mm"], 0.0002
    assert result["Q_F_W_mm"] == pytest.approx(force * creepage * 3.0, rel=1e-6)
    assert result["T_gamma_N_mm"] == pytest.approx(force * creepage, rel=1e-6)
    assert {values.shape for values in result.fields.values()} == {(32,)} and result.y.size == 0
    dataset = result.to_xarray()
    assert dataset["pressure"].dims == ("x",) and dataset.attrs["force_x_N_mm"] == force
    # N/m² times m is N/m.
    assert float(result.fields["shear_x"].sum() * np.diff(result.x)[0]) == pytest.approx(1e3 * force, rel=1e-3)
    assert "F_x = 0.67" in repr(result) and "N/mm" in repr(result) and "×" not in repr(result)


def test_run_writes_files_and_pictures(case: Path, tmp_path: Path) -> None:
    done = call("run", case, "-o", tmp_path / "out", "--json", "--report")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["force_x_N_mm"] == pytest.approx(0.677, abs=2e-3) and record["work"]["grid"] == [32]
    assert record["uncertainty"]["force_x_N_mm"] > 0.0 and "approach_um" not in record and "force_x_N" not in record
    pictures = {Path(name).stem for name in record["files"] if name.endswith(".png")}
    assert {"gears_pressure", "gears_traction", "gears_heat_flux", "gears_summary", "gears_centreline"} == pictures
    assert call("plot", tmp_path / "out" / "gears.h5", "--fields", "summary", painted=True).returncode == 0
    stored = read_result(tmp_path / "out" / "gears.h5")
    assert stored["force_x_N_mm"] == record["force_x_N_mm"] and stored.fields["pressure"].shape == (32,)
    assert call("compare", tmp_path / "out" / "gears.h5", tmp_path / "out" / "gears.h5").returncode == 0
    again = call("run", "--from", tmp_path / "out" / "gears.h5", "-o", tmp_path / "again", "--json", "--no-plots")
    assert json.loads(again.stdout)["force_x_N_mm"] == record["force_x_N_mm"]
    assert call("export", tmp_path / "out" / "gears.h5", "--format", "csv", "-o", tmp_path).returncode == 0
    with (tmp_path / "gears.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 32 and "y_mm" not in rows[0] and float(rows[16]["pressure_MPa"]) == pytest.approx(274.0, rel=0.01)


def test_stresses_and_strength_have_files_pictures_and_paths(case: Path, tmp_path: Path) -> None:
    keys = ("subsurface.layers=6", "numerics.grid=16", "strength.lower.shear_yield_MPa=300")
    settings = [part for key in keys for part in ("--set", key)]
    done = call("run", case, "-o", tmp_path, "--json", *settings)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert {"gears_subsurface_lower", "gears_strength_lower", "gears_shakedown_map"} <= {
        Path(name).stem for name in record["files"]}
    assert record["shakedown_factor_lower"] > 1.0 and record["von_mises_max_lower_MPa"] > 100.0
    file = tmp_path / "gears.h5"
    stored = read_result(file).bodies["lower"]
    assert stored.plane["von_mises"].shape == (6, 16) and stored.strength["shakedown_k"].shape == (6,)
    assert call("compare", file, file).returncode == 0
    assert call("export", file, "--format", "csv", "--stress-path", "0,0.02", "-o", tmp_path).returncode == 0
    with (tmp_path / "gears_stress_path.csv").open() as path:
        rows = list(csv.DictReader(path))
    assert len(rows) > 16 and min(float(row["lower_stress_zz_MPa"]) for row in rows) < -100.0


def test_show_and_sweeps(case: Path, tmp_path: Path) -> None:
    shown = json.loads(call("show", case, "--json").stdout)
    assert shown["grid"] == [32] and shown["hertz_p0_MPa"] == pytest.approx(273.97, rel=1e-4)
    assert shown["saturation_creepage"] == pytest.approx(0.06 * shown["hertz_a_mm"] / 6.0)
    assert shown["inputs"]["load.normal_N_mm"] == {"value": 12.5, "si": 12500.0, "unit": "N/m"}
    assert "approach_um" not in shown and "hertz_b_mm" not in shown
    out = tmp_path / "sweep"
    done = call("sweep", case, "--over", "load.normal_N_mm=5:20:2", "-o", out)
    assert done.returncode == 0, done.stderr
    with (out / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["normal_N_mm"]) for row in rows] == [5.0, 20.0]
    assert all(float(row["force_x_over_friction_limit"]) == pytest.approx(
        float(row["force_x_N_mm"]) / float(row["friction_limit_N_mm"])) for row in rows)
    assert (out / "sweep.png").exists() and "force_x_N" not in rows[0]
    animated = call("plot", out / "sweep.csv", "--animate", "load.normal_N_mm", "-o", tmp_path)
    assert animated.returncode == 0 and list(tmp_path.glob("*.gif")), animated.stderr


def test_everything_the_template_offers_in_comments_works() -> None:
    offered = re.sub(r"^# (\w+ = |\[)", r"\1", template_text("line-contact"), flags=re.MULTILINE)
    offered = offered.replace("[material]\n", "[material.lower]\n")
    offered = re.sub(r"^(longitudinal|lateral|partition) = [\d.]+\n", "", offered, flags=re.MULTILINE)
    problem = Case.parse(offered.replace("\nyield_MPa", "\n# yield_MPa")).problem
    assert problem.line and problem.friction.law is not None and problem.lower != problem.upper
    assert problem.heating.conducts and problem.interlayer.compliance > 0.0
    assert problem.subsurface is not None and problem.subsurface.upper_strength is not None and problem.wear is not None
    assert problem.motion.force_x == 500.0 and problem.motion.force_y == 0.0


def test_an_accuracy_picks_the_elements() -> None:
    result = solve(gears(numerics={"grid": None, "accuracy": 2e-4, "accuracy_of": ["forces", "stick_width_mm"]}))
    assert result.converged and result.x.size >= 64
    assert result.uncertainty["force_x_N_mm"] <= 2e-4 * result["friction_limit_N_mm"]


def test_bodies_that_are_coated_or_relax() -> None:
    coating = {"layers": [{"thickness_um": 50.0, "youngs_modulus_GPa": 400.0, "poisson_ratio": 0.25}]}
    hard, soft = solve(gears(material=coating)), solve(gears(material={"relaxation": [[0.3, 1e-5]]}))
    assert hard.converged and 280.0 < hard["pressure_max_MPa"] < 400.0
    assert soft.converged and soft["hysteresis_W_mm"] == pytest.approx(3.0 * soft["rolling_resistance_N_mm"])
    assert soft["rolling_resistance_moment_N"] > 0.0 and "hysteresis_W" not in soft.numbers


def refused(content: dict[str, Any]) -> set[str]:
    """Keys of the errors of a case; none if it is valid."""
    try:
        Case.from_dict(content)
    except CaseError as error:
        return {finding.key for finding in error.findings}
    return set()


HEATED = {"conductivity_W_mK": 50.0, "expansion_um_mK": 11.0, "diffusivity_mm2_s": 12.0}
SAMPLES = json.loads((ROOT / "tests" / "reference" / "tables_with_each_key.json").read_text())
"""A table with each key."""
OF_OTHERS = {"friction": {"over_angle", "across", "left", "right"}, "wear": {"positions", "positions_file"}}
"""Keys of bodies with profiles and of wheelsets, which also other contacts with radii refuse."""


def test_every_key_has_a_sample() -> None:
    schema = case_schema()
    for table, samples in SAMPLES.items():
        entry = schema["properties"][table]
        name = next(part["$ref"] for part in (entry, *entry.get("anyOf", ())) if "$ref" in part).rpartition("/")[2]
        assert {*samples} | OF_OTHERS.get(table, set()) == {*schema["$defs"][name]["properties"]}, table


@pytest.mark.parametrize("table", SAMPLES)
def test_every_key_runs_or_is_refused_by_name(table: str) -> None:
    for key, sample in SAMPLES[table].items():
        heated = table == "thermal" or key.startswith("temperature")
        others: dict[str, dict[str, Any]] = {"material": HEATED} if heated else {}
        if table == "strength":
            others["subsurface"] = {"layers": 6}
        line = gears(numerics={"grid": 8}, **others, **{table: sample})
        round_one = {**line, "load": {"normal_N": 5.0, "friction_coefficient": 0.06},
                     "geometry": {**line["geometry"], "lower_radius_y_mm": 10.0, "upper_radius_y_mm": 10.0}}
        assert refused(round_one) == set(), key
        keys = refused(line)
        assert all(named.split(".")[0] in (table, "thermal" if heated else table) for named in keys), (key, keys)
        assert keys or solve(line).converged, key

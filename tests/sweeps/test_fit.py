"""Values of a case from measurements: exact data, noise, what data do not determine, and bad input through the command."""

from __future__ import annotations

import functools
import json
import math
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

from tests.support.command_line import call as invoke
from thermoroll_cli import Case, fit, sweep
from thermoroll_cli.studies.sweeps.fit import Parameter
from thermoroll_cli.studies.sweeps.measured import Measured
from thermoroll_cli.tools.runner import Processes

CASE = {
    "material": {"youngs_modulus_GPa": 205.0, "poisson_ratio": 0.29},
    "geometry": {"lower_radius_x_mm": 500.0, "lower_radius_y_mm": 63.5, "upper_radius_x_mm": 116.5,
                 "upper_radius_y_mm": math.inf},
    "load": {"normal_N": 9400.0, "friction_coefficient": 0.5},
    "layer": {"compliance_um_GPa": 4.0},
    "rolling": {"speed_m_s": 0.83, "differential_slip": False},
    "numerics": {"grid": 12},
}
KEYS = ["load.friction_coefficient", "layer.compliance_um_GPa"]
CREEPAGES = [1e-3, 3e-3, 1.2e-2]
MORE = [5e-4, 2e-3, 4e-3, 1.5e-2]
"""Creepages, enough of them to determine the interlayer beside the error of the grid."""
KNOWN = CASE | {"layer": {"compliance_um_GPa": 2.0}}
"""With the interlayer of the curves, so that friction alone is free."""


def creep_curve(friction: float, compliance: float, creepages: list[float] = CREEPAGES) -> dict[str, list[float]]:
    """Computed forces over the load, as if they were measured."""
    case = CASE | {"load": {"normal_N": 9400.0, "friction_coefficient": friction}, "layer": {"compliance_um_GPa": compliance}}
    rows = sweep(case, {"creepage.longitudinal": creepages})
    return {"creepage.longitudinal": creepages, "force_x_over_load": [row["force_x_N"] / 9400.0 for row in rows]}


def write(path: Path, columns: dict[str, list[float]], mark: str = ",") -> Path:
    lines = [mark.join(columns), *(mark.join(map(repr, row)) for row in zip(*columns.values(), strict=True))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_exact_data_are_met():
    start = CASE | {"load": CASE["load"] | {"friction_coefficient": 0.42}, "layer": {"compliance_um_GPa": 2.3}}
    found = fit(start, creep_curve(0.4, 2.0, MORE), KEYS)
    assert found.converged and found.warnings == ()
    assert [found.parameters[key].value for key in KEYS] == pytest.approx([0.4, 2.0], rel=1e-4)
    # What is left of the interval is the error of the grid.
    shares = [found.parameters[key].uncertainty_95 / found.parameters[key].value for key in KEYS]
    assert 0.0 < shares[0] < 0.05 and 0.0 < shares[1] < 2.0


@functools.cache
def noisy_curve(noise: float) -> dict[str, list[float]]:
    data = creep_curve(0.4, 2.0)
    return data | {"force_x_over_load": [v * (1.0 + noise * (-1.0) ** k) for k, v in enumerate(data["force_x_over_load"])]}


def in_newton(data: dict[str, list[float]]) -> dict[str, list[float]]:
    creepages, shares = data.values()
    return {"creepage.longitudinal": creepages, "force_x_N": [9400.0 * share for share in shares]}


@functools.cache
def fitted(noise: float) -> dict[str, Parameter]:
    return fit(KNOWN, noisy_curve(noise), KEYS[:1]).parameters


@pytest.mark.slow
def test_no_case_is_solved_twice_on_a_coarse_grid():
    """Steps and derivatives share what they know: each count of solved cases is that before and new ones."""
    counts: list[int] = []
    found = fit(CASE, creep_curve(0.4, 2.0), KEYS, report=counts.append)
    assert counts == sorted(set(counts)) and found.solved == counts[-1]


@pytest.mark.slow
def test_order_of_points_and_units_of_weights_change_nothing():
    turned = {name: column[::-1] for name, column in in_newton(noisy_curve(0.01)).items()}
    other = fit(KNOWN, turned | {"force_x_N_error": [7.0] * len(CREEPAGES)}, KEYS[:1]).parameters[KEYS[0]]
    assert other.value == pytest.approx(fitted(0.01)[KEYS[0]].value, rel=1e-3)
    assert other.uncertainty_95 == pytest.approx(fitted(0.01)[KEYS[0]].uncertainty_95, rel=1e-2)


@pytest.mark.slow
def test_interval_grows_with_the_noise_and_a_repeated_point_counts_twice():
    # The coarser grid of the other tests has an error that counts more than the smaller noise.
    finer = KNOWN | {"numerics": {"grid": 24}}
    widths = [fit(finer, noisy_curve(noise), KEYS[:1]).parameters[KEYS[0]].uncertainty_95 for noise in (0.01, 0.03)]
    assert widths[1] / widths[0] == pytest.approx(3.0, rel=0.3)
    data = noisy_curve(0.03)
    twice = fit(KNOWN, {name: [*column, column[1]] for name, column in data.items()}, KEYS[:1])
    weighted = fit(KNOWN, data | {"force_x_over_load_error": [0.01, 0.01 / math.sqrt(2.0), 0.01]}, KEYS[:1])
    assert twice.degrees_of_freedom == len(CREEPAGES) == weighted.degrees_of_freedom + 1
    values = [found.parameters[KEYS[0]].value for found in (twice, weighted)]
    assert values[1] == pytest.approx(values[0], rel=1e-4) and abs(values[0] / fitted(0.03)[KEYS[0]].value - 1.0) > 1e-3


def test_full_sliding_does_not_determine_the_interlayer():
    found = fit(CASE | {"load": CASE["load"] | {"friction_coefficient": 0.4}}, creep_curve(0.4, 2.0, [0.05, 0.08]), KEYS[1:])
    assert math.isnan(found.parameters[KEYS[1]].uncertainty_95)
    assert any(KEYS[1] in warning for warning in found.warnings)
    assert found.record()["parameters"][KEYS[1]] == {"value": found.parameters[KEYS[1]].value, "uncertainty_95": None,
                                                    "doubt": "not determined"}  # fmt: skip


def test_a_value_at_its_bound_says_so():
    found = fit(KNOWN, creep_curve(0.4, 2.0, CREEPAGES[1:]), [f"{KEYS[0]}=0.45:0.6"])
    assert found.parameters[KEYS[0]].value == pytest.approx(0.45, rel=2e-3)
    assert math.isnan(found.parameters[KEYS[0]].uncertainty_95)
    assert any("at the end of its range" in warning for warning in found.warnings)


@pytest.mark.slow
def test_several_varied_keys_and_scalars_at_once():
    points = [(1e-3, 5e-4), (6e-3, -2e-3)]
    case = CASE | {"load": {"normal_N": 9400.0, "friction_coefficient": 0.4}}
    rows = sweep(case, [{"creepage.longitudinal": x, "creepage.lateral": y} for x, y in points])
    data = {"creepage.longitudinal": [x for x, _ in points], "creepage.lateral": [y for _, y in points],
            "force_x_N": [row["force_x_N"] for row in rows], "force_y_N": [row["force_y_N"] for row in rows]}
    found = fit(CASE, data, KEYS)
    assert [found.parameters[key].value for key in KEYS] == pytest.approx([0.4, 4.0], rel=1e-4)
    axes = found.figure().axes
    assert len(axes) == 4 and axes[-1].get_xlabel() == "number of the point"


def test_the_command_writes_case_record_and_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rig.toml").write_text(Case.from_dict(KNOWN).to_toml(), encoding="utf-8")
    data = {name: values[1:] for name, values in noisy_curve(0.01).items()}
    text = write(tmp_path / "curve.csv", data, ";").read_text().replace(".", ",").replace("creepage,", "creepage.")
    (tmp_path / "curve.csv").write_text("\ufeff" + text, encoding="utf-8")  # as a spreadsheet writes it
    done = invoke("fit", "rig.toml", "curve.csv", "--free", KEYS[0], "-o", "out", "--json", "--format", "png",
                  "--format", "svg", painted=True)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert set(record) == {"name", "status", "reason", "parameters", "correlation", "rms", "points", "degrees_of_freedom",
                           "warnings", "files"}
    value, uncertainty, doubt = record["parameters"][KEYS[0]].values()
    assert value == pytest.approx(0.4, rel=0.01) and 0.0 < uncertainty < 0.05 and doubt == ""
    assert json.loads(Path("out/rig_fit.json").read_text())["parameters"] == record["parameters"]
    assert Case.read("out/rig_fit.toml").settings.load.friction_coefficient == pytest.approx(value, rel=1e-4)
    assert Path("out/rig_fit.png").read_bytes().startswith(b"\x89PNG")
    assert "<text" in Path("out/rig_fit.svg").read_text(encoding="utf-8")  # and not the outlines of its letters
    kept = Path("out/rig_fit.json").read_bytes()
    more = ("fit", "rig.toml", "curve.csv", "--free", "layer.compliance_um_GPa=0.5:50", "-o", "out", "--no-plots")
    lost = invoke(*more)
    assert lost.returncode == 5 and Path("out/rig_fit.json").read_bytes() == kept
    assert f"of a fit of {KEYS[0]} to curve.csv, not of layer.compliance_um_GPa=0.5:50 to curve.csv" in lost.stderr
    assert invoke("fit", "rig.toml", "curve.csv", "--free", KEYS[0], "-o", "out", "--no-plots").returncode == 0
    drawn = invoke("sweep", "out/rig_fit.toml", "--over", "creepage.longitudinal=0.001:0.01:3", "-o", "out", "--scalars-only",
                   "--measured", "newton.csv")  # fmt: skip
    assert drawn.returncode == 5 and "newton.csv" in drawn.stderr
    write(tmp_path / "newton.csv", in_newton(data))
    drawn = invoke("sweep", "out/rig_fit.toml", "--over", "creepage.longitudinal=0.001:0.01:3", "-o", "out", "--scalars-only",
                   "--measured", "newton.csv")  # fmt: skip
    assert drawn.returncode == 0, drawn.stderr
    marks: list[list[float]] = []
    monkeypatch.setattr(Axes, "errorbar", lambda axes, x, y, *bars, **look: marks.append(list(y)))
    for name in ("newton.csv", "curve.csv"):  # forces, and forces over the load
        assert invoke("plot", "out/sweep.h5", "--measured", name).returncode == 0
    assert invoke("plot", "out/sweep.h5", "--measured", name, "--columns", "gamma_st").returncode == 0  # the force beside it
    assert len(marks) == 3 and all(each == pytest.approx(marks[0]) for each in marks)


def test_keys_that_a_law_needs_may_be_free(tmp_path, monkeypatch):
    """The case alone is invalid: it names a law and leaves its values to the fit."""
    monkeypatch.chdir(tmp_path)
    law = {"law": "exponential", "memory_um": 100.0, "half_slip_m_s": 0.05}
    whole = Case.from_dict(KNOWN | {"friction": law | {"limit_coefficient": 0.3}})
    creepages = [1e-2, 0.1]
    rows = sweep(whole, {"creepage.longitudinal": creepages})
    write(tmp_path / "curve.csv", {"creepage.longitudinal": creepages, "force_x_N": [row["force_x_N"] for row in rows]})
    Path("rig.toml").write_text(whole.to_toml().replace("limit_coefficient = 0.3\n", ""), encoding="utf-8")
    limit = "friction.limit_coefficient"
    assert invoke("fit", "rig.toml", "curve.csv", "--free", KEYS[0]).returncode == 3
    done = invoke("fit", "rig.toml", "curve.csv", "--free", f"{limit}=0.1:0.4", "--no-plots")
    assert done.returncode == 0 and "2 points, 1 degree of freedom" in done.stdout, done.stderr
    record = json.loads(Path("results/rig_fit.json").read_text())
    assert record["parameters"][limit]["value"] == pytest.approx(0.3, rel=1e-3)


@pytest.mark.slow
def test_a_key_that_acts_by_its_square_is_found_from_the_end_0_of_its_range():
    creepages = [1e-3, 4e-3]
    rows = sweep(KNOWN | {"creepage": {"lateral": 3e-3}}, {"creepage.longitudinal": creepages})
    data = {"creepage.longitudinal": creepages, "force_x_N": [row["force_x_N"] for row in rows]}
    found = fit(KNOWN, data, ["creepage.lateral=0:0.01"])
    assert found.converged and not found.warnings
    assert found.parameters["creepage.lateral"].value == pytest.approx(3e-3, rel=1e-4)


def test_a_fit_that_begins_on_a_coarse_grid_ends_on_that_of_the_case():
    """Finer than the grid on which fits begin, so that the slopes of the coarse one lead on the fine one."""
    fine = KNOWN | {"numerics": {"grid": 48}}
    rows = sweep(fine, {"creepage.longitudinal": CREEPAGES[1:]})
    data = {"creepage.longitudinal": CREEPAGES[1:], "force_x_N": [row["force_x_N"] for row in rows]}
    found = fit(fine, data, ["load.friction_coefficient=0.2:0.8"])
    assert found.converged and found.warnings == ()
    assert found.parameters[KEYS[0]].value == pytest.approx(0.5, rel=1e-3)


@pytest.mark.slow
def test_a_fit_goes_on_where_a_worker_is_killed(monkeypatch):
    def broken(*arguments):
        raise BrokenProcessPool

    monkeypatch.setattr(Processes, "map", broken)
    assert fit(KNOWN, noisy_curve(0.01), KEYS[:1], jobs=2).parameters == fitted(0.01)


def test_forces_over_a_load_that_varies_need_it_beside_them():
    data = {"creepage.longitudinal": [1e-3, 2e-3], "force_x_over_load": [0.1, 0.2], "force_x_over_load_error": [0.01, 0.02]}
    with pytest.raises(ValueError, match=r"add the column load\.normal_N"):
        Measured.of(data).in_newtons([100.0, 200.0])
    forces = Measured.of(data | {"load.normal_N": [100.0, 200.0]}).in_newtons([100.0, 200.0])
    assert forces.values["force_x_N"].tolist() == [10.0, 40.0] and forces.deviations["force_x_N"].tolist() == [1.0, 4.0]


@pytest.mark.parametrize(("free", "words"), [
    ("load.friction", "not a key"), ("numerics.grid", "not a key"), (f"{KEYS[0]}=2:1", "LOW must be below HIGH"),
    (f"{KEYS[0]}=0.6:0.9", "outside of its range"), ("creepage.lateral", "begins at 0"),
    ("rolling.speed_m_s=a:b", "KEY=LOW:HIGH"),
    ("friction.limit_coefficient", "has no value"),
])
def test_bad_keys_are_named(free, words):
    with pytest.raises(ValueError, match=words):
        fit(CASE, {"creepage.longitudinal": [1e-3], "force_x_N": [100.0]}, [free])


def test_points_without_a_steady_state_are_left_out_only_if_asked_for():
    case = {**CASE, "force": {"longitudinal_N": 100.0}}
    forces = [500.0, 1500.0]
    found = sweep({**case, "layer": {"compliance_um_GPa": 3.0}}, {"force.longitudinal_N": forces})
    data = {"force.longitudinal_N": [*forces, 4710.0],
            "creepage_longitudinal": [*(row["creepage_longitudinal"] for row in found), 2e-2]}
    with pytest.raises(ValueError, match=r"data, line 3.*begin with other values of layer.compliance_um_GPa"):
        fit(case, data, [KEYS[1]])
    found = fit(case, data, [KEYS[1]], skip_failed=True)
    assert len(found.measured) == 2 and "line 3" in found.warnings[0]


def test_a_value_of_either_sign_says_so():
    case = {**CASE, "creepage": {"lateral": 3e-3}}
    forces = [row["force_x_N"] for row in sweep(case, {"creepage.longitudinal": CREEPAGES[::2]})]
    found = fit(case, {"creepage.longitudinal": CREEPAGES[::2], "force_x_N": forces}, ["creepage.lateral=-0.01:0.01"])
    assert [w for w in found.warnings if "sign of creepage.lateral" in w and "-0.003 fits as well" in w]


def test_a_value_within_its_error_of_zero_says_so():
    """Forces across that scatter about none determine a small interval about 0, and no creepage."""
    case = {**CASE, "creepage": {"lateral": 1e-3}}
    data = {"creepage.longitudinal": CREEPAGES, "force_y_N": [20.0, -30.0, 15.0]}
    found = fit(case, data, ["creepage.lateral=-0.01:0.01"])
    value = found.parameters["creepage.lateral"]
    assert found.converged and abs(value.value) < value.uncertainty_95 < 1e-3
    (note,) = (each for each in found.warnings if "do not tell creepage.lateral from 0" in each)
    assert found.record()["parameters"]["creepage.lateral"]["doubt"] == "not distinct from 0"
    assert note.endswith(f"{value.value:.3g} ± {value.uncertainty_95:.2g}")


@pytest.mark.slow
def test_temperatures_determine_a_conductivity():
    steel = {"conductivity_W_mK": 45.0, "diffusivity_mm2_s": 12.3, "expansion_um_mK": 11.0}
    case = {**CASE, "material": CASE["material"] | steel, "creepage": {"longitudinal": 5e-3}, "thermal": {"deformation": False}}
    hottest, speeds = "temperature_rise_max_lower_K", [1.0, 4.0]
    data = {"rolling.speed_m_s": speeds, hottest: [row[hottest] for row in sweep(case, {"rolling.speed_m_s": speeds})]}
    start = Case.from_dict(case).with_values({"material.conductivity_W_mK": 60.0})
    found = fit(start, data, ["material.conductivity_W_mK"])
    assert found.parameters["material.conductivity_W_mK"].value == pytest.approx(45.0, rel=1e-4)


@pytest.mark.slow
def test_a_wheelset_is_fitted_as_a_contact():
    given = {"numerics.grid": 8, "wheelset.wheels": "right", "wheelset.roll_mrad": 0.0, "load.friction_coefficient": 0.25,
             "wheelset.angular_velocity_rad_s": 4.34, "thermal.heat": False}
    case = Case.read("cases/manchester.toml").with_values(given)
    shifts, measured = [1.0], ("track_force_y_right_N", "Q_F_W")
    rows = sweep(case, {"wheelset.lateral_shift_mm": shifts})
    data = {"wheelset.lateral_shift_mm": shifts} | {name: [row[name] for row in rows] for name in measured}
    found = fit(case.with_values({KEYS[0]: 0.24}), data, [KEYS[0]])
    assert found.parameters[KEYS[0]].value == pytest.approx(0.25, rel=1e-4)


@pytest.mark.slow
def test_a_grid_without_an_estimate_gives_no_interval():
    found = fit(CASE | {"numerics": {"grid": 8}}, creep_curve(0.4, 2.0), KEYS)
    assert all(math.isnan(one.uncertainty_95) for one in found.parameters.values())
    assert any("no intervals" in warning for warning in found.warnings)


def test_a_unit_behind_a_name_is_no_part_of_it(tmp_path):
    (tmp_path / "data.csv").write_text("creepage.longitudinal;force_x_N [N]\n0,001;100\n", encoding="utf-8")
    assert list(Measured.read(tmp_path / "data.csv").values) == ["force_x_N"]


def test_columns_that_begin_with_a_hash_are_left_out(tmp_path):
    """Whatever a rig writes beside what is fitted: text, repeated names, other quantities with decimal commas."""
    (tmp_path / "rig.csv").write_text("#time;creepage.longitudinal [%];#µ;force_x_N;#µ\n"
                                      "10:05;5,0;0,4;602;-\n10:06;3,0;0,42;631;-\n")
    read = Measured.read(tmp_path / "rig.csv")
    assert {name: column.tolist() for name, column in (read.varied | read.values).items()} == {
        "creepage.longitudinal": [0.05, 0.03], "force_x_N": [602.0, 631.0]}
    assert list(Measured.of({"#note": ["a"], "force_x_N": [1.0]}).values) == ["force_x_N"]


def test_units_behind_names_are_converted_and_words_of_rigs_have_a_hint(tmp_path):
    data = tmp_path / "data.csv"
    data.write_text("creepage.longitudinal [%],load.normal_N [kN],force_x_over_load [%],force_x_over_load_error [-]\n"
                    "0.7,.1,20,.1\n")
    read = Measured.read(data)
    assert {name: values.tolist() for name, values in read.varied.items()} == {"creepage.longitudinal": [0.007],
                                                                              "load.normal_N": [100.0]}
    assert read.values["force_x_over_load"].tolist() == [0.2] and read.deviations["force_x_over_load"].tolist() == [0.1]
    assert read.written["creepage.longitudinal"] == ("%", 0.01)
    for header, told in (("SRR [%],force_x_N", "did you mean creepage.longitudinal?"),
                         ("creepage_percent,force_x_N", r"did you mean creepage.longitudinal \[%\]?"),
                         ("creepage.longitudinal,mu", "did you mean force_x_over_load or load.friction_coefficient?"),
                         ("load [kN],force_x_N", r"did you mean load.normal_N \[kN\]?"),
                         ("load.normal_N [mm],force_x_N", "load.normal_N is in N, kN, MN")):
        data.write_text(f"{header}\n1,2\n")
        with pytest.raises(ValueError, match=told.replace("?", r"\?")):
            Measured.read(data)


def test_a_column_of_a_mapping_must_be_as_long_as_the_others():
    with pytest.raises(ValueError, match="differ in length"):
        Measured.of({"creepage.longitudinal": [1e-3], "force_x_N": np.array([1.0, 2.0])})

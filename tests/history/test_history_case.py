"""Cases over time through their real entry points: columns, errors, files, and what is refused."""

from __future__ import annotations

import csv
import json
import math
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import tomli_w

from scripts.stress.courses import random_course
from tests.support.command_line import call
from tests.support.datasets import datasets
from tests.support.sampling import sampled
from thermoroll_cli import Case, CaseError, fit, solve
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.many_contacts.history.history_plan import MOST_SECONDS, plan_of
from thermoroll_cli.many_contacts.history.solve import HistorySolver
from thermoroll_cli.one_contact.steady_state.fixed_point import fixed_point
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.result import Result

BALL: dict[str, Any] = {
    "material": {"youngs_modulus_GPa": 0.00256, "poisson_ratio": 0.28},
    "geometry": {"lower_radius_x_mm": float("inf"), "lower_radius_y_mm": float("inf"), "upper_radius_x_mm": 168.73,
                 "upper_radius_y_mm": 168.73},
    "load": {"normal_N": 0.4705, "friction_coefficient": 0.4},
    "rolling": {"speed_m_s": 1.0, "differential_slip": False},
    "numerics": {"grid": 16},
    "history": {"distance_mm": [0, 0, 7], "steps": 8, "values": {"creepage.longitudinal": [0.001, 0.003, 0.003]}},
}


WARM = {**BALL["material"], "conductivity_W_mK": 50, "expansion_um_mK": 11, "diffusivity_mm2_s": 13}


def ball(**tables: dict[str, Any]) -> dict[str, Any]:
    """The case with other tables; None takes a key out."""
    return {**BALL, **{name: {key: value for key, value in {**BALL.get(name, {}), **table}.items() if value is not None}
                       for name, table in tables.items()}}


def test_columns_and_their_errors() -> None:
    result = solve(ball())
    history = result.history
    assert result.converged and history is not None
    assert {len(column) for column in history.values()} == {9}
    assert history["distance_mm"] == pytest.approx(np.linspace(0.0, 7.0, 9))
    assert history["creepage.longitudinal"] == [0.001] + [0.003] * 8
    assert result["force_x_N"] == history["force_x_N"][-1] and result.uncertainty["force_x_N"] > 0.0
    assert not result.warnings
    finest = [0.047713, 0.060254, 0.071464, 0.081242, 0.089593, 0.096474, 0.10187, 0.10589, 0.10892]  # 32 × 32, 24 steps
    assert (np.abs(np.array(history["force_x_N"]) - finest) <= np.array(history["uncertainty.force_x_N"])).all()
    assert history.to_dataframe()["heat_J"].is_monotonic_increasing
    frame = history.to_xarray()
    assert frame["force_x_N"].sizes == {"time_s": 9} and frame["heat_J"].attrs["units"] == "J" and frame["converged"].all()
    assert history["force_x_over_friction_limit"][-1] == history["force_x_N"][-1] / history["friction_limit_N"][-1]


def test_heat_at_an_absurd_speed_is_refused_and_shown_without_rows_that_vary(tmp_path: Path) -> None:
    """Pe = V a/κ with the a of Hertz's circle, (3WR/4E*)^(1/3): 1e9 m/s would take more than 45 s on 16². Without values over
    time there is nothing to show beside their key."""
    case = ball(material=WARM, history={"steps": 3, "distance_mm": [0, 7], "values": {}})
    path = tmp_path / "fast.toml"
    path.write_text(tomli_w.dumps(case), encoding="utf-8")
    done = call("show", path)
    assert done.returncode == 0, done.stderr
    radius = (0.75 * 0.4705 * 0.16873 / (0.5 * 2.56e6 / (1.0 - 0.28**2))) ** (1.0 / 3.0)
    done = call("run", path, "--set", "rolling.speed_m_s=1e9", "-o", tmp_path)
    assert done.returncode == 3 and "rolling.speed_m_s = 1e9: " in done.stderr
    assert f"a Péclet number of {1e9 * radius / 13e-6:.1e}" in done.stderr
    assert f"at most {1e8 * 13e-6 / radius:.3g} here" in done.stderr


def test_an_accuracy_that_would_take_long_is_given_up_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the estimated seconds of three runs allowed there is no fourth one, and the reason says what to set."""
    case = ball(numerics={"grid": None, "accuracy": 1e-3}, history={"steps": 3})
    monkeypatch.setattr("thermoroll_cli.many_contacts.history.solve.MOST_SECONDS", 1.0)
    task, runs = Case.from_dict(case).task, set[Any]()
    found = HistorySolver().solve(task, report=lambda _, info: runs.add(tuple(info["grid"])))
    assert not found.converged and max(runs) <= (32, 32)
    assert "take less than 1 s" in found.reason and "set numerics.grid and history.steps" in found.reason


def test_what_a_run_writes_and_what_is_drawn_and_reported_of_it(tmp_path: Path) -> None:
    """The result file has the last state alone; the curves come from the table beside it, which is one as that of a sweep."""
    (tmp_path / "ball.toml").write_text(Case.from_dict(ball(numerics={"grid": 8}, history={"steps": 2})).to_toml())
    done = call("run", "ball.toml", "-o", ".", "--json", "--report", "--plots", "summary", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert "few steps (2)" in " ".join(record["warnings"])
    with (tmp_path / "ball_history.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["force_x_N"]) for row in rows] == record["history"]["force_x_N"]
    assert {"ball.h5", "ball_history.csv", "ball_history.png"} <= {Path(name).name for name in record["files"]}
    assert record["force_x_N"] == record["history"]["force_x_N"][-1]
    whole = (tmp_path / "ball_report.html").read_text()
    assert "3 of 3 states converged" in whole and "frictional heat since the start" in whole
    result = read_result(tmp_path / "ball.h5")
    assert result["heat_J"] == record["history"]["heat_J"][-1] and result.last_of == "the last state, at 7 mm"
    with matplotlib.rc_context():
        picture = figure(result, "traction")
    assert picture is not None and "the last state, at 7 mm" in picture.get_suptitle()
    for command in (("plot", "ball_history.csv", "-o", "again"), ("report", "ball_history.csv"), ("report", "ball.h5"),
                    ("plot", "ball.h5", "--format", "svg")):
        done = call(*command, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "again" / "ball_history.png").exists()
    assert (tmp_path / "ball_history.svg").exists() and "ball_history.svg" in done.stdout
    page = (tmp_path / "ball_history_report.html").read_text()
    assert "over distance rolled, from 0 to 7 mm: 3 of 3 states converged" in page
    page = (tmp_path / "ball_report.html").read_text(encoding="utf-8")
    assert "A contact over distance rolled, from 0 to 7 mm" in page and "The last state, at 7 mm, of two bodies" in page
    assert "friction_limit_N" in page and "creep force" in page
    read = read_table(tmp_path / "ball_history.csv")
    assert read.of_history and read.label == ("distance_mm", "creepage.longitudinal") and "values" in read.case_text
    (tmp_path / "ball_history.h5").unlink()
    (tmp_path / "ball_history.csv").unlink()
    assert call("report", tmp_path / "ball.h5", "-o", tmp_path / "alone.html").returncode == 0
    assert "The last state, at 7 mm, of two bodies" in (tmp_path / "alone.html").read_text(encoding="utf-8")


def test_show_has_steps_grids_and_what_heat_takes(tmp_path: Path) -> None:
    case = ball(history={"steps": 8}, material=WARM, thermal={"deformation": False})
    (tmp_path / "ball.toml").write_text(Case.from_dict(case).to_toml())
    text = call("show", tmp_path / "ball.toml").stdout
    assert "grid 8×8: 4 and 4 steps" in text and "grid 16×16: 9 steps" in text and "remember the heat" in text
    plan = json.loads(call("show", tmp_path / "ball.toml", "--json").stdout)
    assert plan["grids"] == [{"grid": [8, 8], "steps": [4, 4]}, {"grid": [16, 16], "steps": [9]}] and not plan["upper_bound"]
    assert plan["heat_memory_bytes"] == 9 * (2 + 4 + 2) * 16 * 32 * 17
    assert "few steps (3)" in call("show", tmp_path / "ball.toml", "--set", "history.steps=3").stdout
    search = {**case, "numerics": {"accuracy": 1e-3, "accuracy_of": ["forces"]}}
    (tmp_path / "ball.toml").write_text(Case.from_dict(search).to_toml())
    text = call("show", tmp_path / "ball.toml").stdout
    assert "grid 256×256: 17 to 513 steps at most, until forces are good to 0.001" in text
    assert "s if 32 elements a side are enough" in text and "at most about" in text
    plan, most = (json.loads(call("show", tmp_path / "ball.toml", "--json", *sets).stdout) for sets in (
        (), ("--set", "numerics.grid=256", "--set", "history.steps=512")))
    assert plan["upper_bound"] and plan["seconds"] == MOST_SECONDS < most["seconds"]
    assert plan["heat_memory_bytes"] == most["heat_memory_bytes"]


def test_the_progress_of_a_history_ends_with_its_last_step() -> None:
    """What the plan expects is what is reported."""
    task, reports = Case.from_dict(ball(history={"steps": 5})).task, list[Any]()
    HistorySolver().solve(task, report=lambda stage, info: reports.append((stage, tuple(info["grid"]))))
    assert reports == plan_of(task).steps


def test_a_picture_that_is_not_drawn_is_not_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("thermoroll_cli.studies.sweeps.table_picture.MOST_DRAWN", 2)
    (tmp_path / "ball.toml").write_text(Case.from_dict(ball(numerics={"grid": 8}, history={"steps": 2})).to_toml())
    done = call("run", tmp_path / "ball.toml", "-o", tmp_path, "--plots", "summary")
    assert done.returncode == 0 and "no picture: more than 2 points" in done.stdout, done.stderr
    assert "ball_summary.png" in done.stdout and "ball_history.png" not in done.stdout
    assert [path.name for path in tmp_path.glob("*.png")] == ["ball_summary.png"]


@pytest.mark.slow
def test_fields_of_some_rows_and_their_animation(tmp_path: Path) -> None:
    (tmp_path / "ball.toml").write_text(Case.from_dict(ball(numerics={"grid": 8}, history={"fields_every": 4})).to_toml())
    for command in (("run", tmp_path / "ball.toml", "-o", tmp_path, "--no-plots"),
                    ("plot", tmp_path / "ball_history.h5", "--animate", "distance_mm", "-o", tmp_path)):
        done = call(*command, painted=True)
        assert done.returncode == 0, done.stderr
    read = read_table(tmp_path / "ball_history.h5", with_fields=True)
    assert [*read.states] == [0, 4, 8]
    last = read_result(tmp_path / "ball.h5")
    assert np.array_equal(read.states[8].fields["shear_x"], last.fields["shear_x"])
    assert read.states[8].scalars["force_x_N"] == last["force_x_N"] and read["heat_J"][-1] == last["heat_J"]
    assert (tmp_path / "ball_history.gif").read_bytes().startswith(b"GIF")
    done = call("plot", tmp_path / "ball_history.csv", "--animate", "distance_mm")
    assert done.returncode == 2 and "history.fields_every" in done.stderr


def recorded(tmp_path: Path, text: str) -> Case:
    (tmp_path / "record.csv").write_text(text)
    case = ball(history={"file": "record.csv", "steps": 2})
    case["history"] = {name: value for name, value in case["history"].items() if name not in ("distance_mm", "values")}
    return Case.parse(tomli_w.dumps(case), name=str(tmp_path / "case"))


def test_a_record_over_time_is_read_with_its_units(tmp_path: Path) -> None:
    case = recorded(tmp_path, "time;load.normal;creepage.longitudinal\nms;kN;%\n0;0,0005;0,1\n7;0,0004;0,3\n")
    course = case.task.course  # type: ignore[union-attr]
    assert course.places == pytest.approx((0.0, 0.007))
    assert course.values["load.normal_N"] == pytest.approx((0.5, 0.4))
    assert course.values["creepage.longitudinal"] == pytest.approx((0.001, 0.003))
    again = Case.parse(case.to_toml(), name="elsewhere")
    assert again.task.course == course  # type: ignore[union-attr]
    case = recorded(tmp_path, "distance [m],rolling.speed [km/h]\n0,3.6\n0.007,7.2\n")
    course = case.task.course  # type: ignore[union-attr]
    assert course.by_distance and course.values["rolling.speed_m_s"] == pytest.approx((1.0, 2.0))


@pytest.mark.parametrize("text", [
    "time_s,load.normal_N\r0,500\r0.007,400\r", '"time_s", "load.normal [kN]"\n0, 0.5\n0.007, "0.4"\n',
    "time [µs],load.normal_N\n0,500\n7000,400\n", "time,load.normal\nus,N\n0,500\n7e3,400\n",
])  # fmt: skip
def test_a_record_as_old_macs_instruments_and_hands_write_it(tmp_path: Path, text: str) -> None:
    course = recorded(tmp_path, text).task.course  # type: ignore[union-attr]
    assert course.places == pytest.approx((0.0, 0.007))
    assert course.values["load.normal_N"] == pytest.approx((500.0, 400.0))


def test_a_long_record_is_shown_without_a_look_at_each_of_its_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made, problem_at = [], History.problem_at
    monkeypatch.setattr(History, "problem_at", lambda *given, **more: made.append(1) or problem_at(*given, **more))
    text = "time_s,load.normal_N,creepage.longitudinal\n"
    text += "".join(f"{row}e-4,{400 + 7 * (row % 9)},{1e-4 * (row % 11):g}\n" for row in range(2000))
    (tmp_path / "record.csv").write_text(text)
    (tmp_path / "case.toml").write_text(tomli_w.dumps({**BALL, "history": {"file": "record.csv"}}))
    shown = call("show", tmp_path / "case.toml")
    assert shown.returncode == 0, shown.stderr
    assert 0 < len(made) < 20


def test_a_force_that_friction_cannot_carry_is_found_between_the_extremes() -> None:
    case = ball(history={"values": {"load.normal_N": [100, 60, 100, 50], "force.longitudinal_N": [29, 20, 29, 14]},
                         "distance_mm": [0, 1, 2, 3]}, load={"friction_coefficient": 0.3})
    with pytest.raises(Unsolvable, match="at 1 mm: the tangential force of 20 N reaches or exceeds"):
        plan_of(Case.from_dict(case).task)  # type: ignore[arg-type]


@pytest.mark.parametrize("jumps", sampled([True, False]))
def test_heat_at_rest_is_that_of_the_largest_force(jumps: bool) -> None:
    """A force that is there at once rubs as one that grows to it does, which is exact in one step. That it then falls by a
    tenth turns the slip of a twentieth of it back: 4 · 0.05³ of that heat (Mindlin and Deresiewicz)."""
    heats = list[float]()
    for forces in ([0.12, 0.12], [0.12, 0.108]):
        times, values = ([0, 1, 1, 2], [0.0, 0.0, *forces]) if jumps else ([0, 1], forces)
        table = solve(ball(rolling={"speed_m_s": 0.0}, numerics={"grid": 16}, history={
            "time_s": times, "distance_mm": None, "values": {"force.longitudinal_N": values}, "steps": 2,
            "begin": "pressed"})).history
        assert table is not None
        heats.append(table["heat_J"][-1])
    assert heats[1] == pytest.approx(heats[0], rel=2e-3)


@pytest.mark.slow
def test_elements_and_steps_until_every_row_is_accurate() -> None:
    """Every row is within the accuracy of a solution with six times the steps; a better accuracy takes more work."""
    wave = {"distance_mm": [0, 2, 5, 7], "values": {"creepage.longitudinal": [0.001, 0.0013, 0.0017, 0.002]}}
    fine = [0.047613, 0.048184, 0.049752, 0.052158, 0.055227, 0.058831, 0.062904, 0.06738]  # 48 × 48 elements, 42 steps
    case = {**ball(), "numerics": {"accuracy": 0.02, "accuracy_of": ["forces"]}, "history": {**wave, "steps": 7}}
    applications = [0]
    for accuracy in (0.02, 0.004):
        case["numerics"]["accuracy"] = accuracy
        found = solve(case)
        assert found.converged and found.history is not None and len(found.history["time_s"]) == 8
        limit = np.array(found.history["friction_limit_N"])
        errors = np.array(found.history["uncertainty.force_x_N"]) / limit
        true = np.abs(np.array(found.history["force_x_N"]) - fine) / limit
        assert (true <= errors).all() and errors.max() <= accuracy
        applications.append(found.work["applications"])
    assert applications == sorted(set(applications))


@pytest.mark.slow
def test_an_accuracy_that_no_grid_would_reach_is_given_up_soon() -> None:
    """A load that grows makes all stick that a small force moves, but a rim far narrower than an element: its heat is known to
    no share of itself on 256 elements a side, and the forces, which are given, and the pressure are."""
    case = ball(rolling={"speed_m_s": 0.0}, history={}, numerics={"grid": None, "accuracy": 0.05})
    case["history"] = {"time_s": [0, 1], "values": {"force.longitudinal_N": [-0.01, 0.0], "load.normal_N": [0.3, 0.6]},
                       "steps": 3, "begin": "pressed"}
    found = solve(case)
    assert not found.converged and found.work["grid"][0] <= 64
    assert "Q_F_W is good to" in found.reason and "or for others in numerics.accuracy_of" in found.reason
    assert solve({**case, "numerics": {"accuracy": 0.05, "accuracy_of": ["pressure_max_MPa"]}}).converged


@pytest.mark.slow
def test_a_sweep_keeps_the_history_of_each_point(tmp_path: Path) -> None:
    (tmp_path / "ball.toml").write_text(Case.from_dict(ball(history={"steps": 4})).to_toml())
    command: list[str | Path] = ["sweep", tmp_path / "ball.toml", "--over", "load.friction_coefficient=0.3,0.4", "-o",
                                 tmp_path / "out", "--no-plots"]
    assert call(*command).returncode == 0
    table = read_table(tmp_path / "out" / "sweep.csv")
    for file, force in zip(table["file"], table["force_x_N"], strict=True):
        history = read_table(tmp_path / "out" / file.replace(".h5", "_history.h5"))
        assert history.count == 5 and history["force_x_N"][-1] == force
    before = (tmp_path / "out" / "ball_0001.h5").stat().st_mtime_ns
    (tmp_path / "out" / "ball_0002_history.csv").unlink()
    assert call(*command, "--resume").returncode == 0
    assert (tmp_path / "out" / "ball_0002_history.csv").exists()
    assert (tmp_path / "out" / "ball_0001.h5").stat().st_mtime_ns == before
    command[3] = "load.friction_coefficient=0.3,0.35"
    (tmp_path / "out" / "ball_0003_history.csv").write_text("of another one")
    done = call(*command, "--force")
    assert "of another sweep" in done.stderr and "ball_0003_history.csv" in done.stderr


def test_a_fit_to_a_record_over_time() -> None:
    """Data of finer steps between the rows; without noise the coefficient of friction is found. On the grid of the case, which
    the tolerance allows: 2 % of friction."""
    fine = solve(ball(numerics={"grid": 8}, history={"steps": 6})).history
    assert fine is not None
    rows = [2, 6]
    data = {"distance_mm": [fine["distance_mm"][row] for row in rows], "force_x_N": [fine["force_x_N"][row] for row in rows]}
    found = fit(ball(load={"friction_coefficient": 0.35}, history={"steps": 3}, numerics={"grid": 8}), data,
                ["load.friction_coefficient=0.3:0.5"])
    value = found.parameters["load.friction_coefficient"]
    assert found.converged and value.value == pytest.approx(0.4, abs=max(0.02, value.uncertainty_95))
    with pytest.raises(ValueError, match="outside of the history, from 0 to 7"):
        fit(ball(), {"distance_mm": [8.0], "force_x_N": [0.1]}, ["load.friction_coefficient"])
    steady = {name: table for name, table in ball().items() if name != "history"}
    with pytest.raises(ValueError, match=r"case with \[history\] alone"):
        fit(steady, {"distance_mm": [8.0], "force_x_N": [0.1]}, ["load.friction_coefficient"])


def test_an_interruption_keeps_the_rows_and_resume_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    """The same bytes, but for times: table, record, and every array of both files."""
    (tmp_path / "ball.toml").write_text(Case.from_dict(ball(history={"steps": 8, "fields_every": 4})).to_toml())
    command = "run", str(tmp_path / "ball.toml"), "--no-plots", "--json", "--reproducible", "-o", str(tmp_path / "results")
    table = tmp_path / "results" / "ball_history.csv"

    def run(*options: str) -> list[Any]:
        done = call(*command, *options)
        assert done.returncode == 0, done.stderr
        return [done.stdout, table.read_bytes(), datasets(table.with_suffix(".h5")), datasets(table.with_name("ball.h5"))]

    whole = run()
    with subprocess.Popen([sys.executable, "-m", "thermoroll_cli", *command, "-v"], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True) as running:
        assert running.stderr is not None
        for number, _ in enumerate(line for line in running.stderr if "grid 16×16" in line):
            if number == 4:
                running.send_signal(signal.SIGINT)
                break
        rest = running.stderr.read()
    assert running.returncode == 130 and "rows up to here" in rest and "--resume goes on" in rest
    assert 1 <= read_table(table).count < 8 and "uncertainty.force_x_N" in read_table(table)
    other = call(*command, "--resume", "--set", "load.friction_coefficient=0.3")
    assert other.returncode == 5 and "ball_history.jsonl: of another history" in other.stderr
    assert run("--resume") == whole and not table.with_suffix(".jsonl").exists()


REMEMBERING: list[dict[str, Any]] = [
    {"history": {"values": {"creepage.longitudinal": [0.001, 0.003, 0.003], "load.normal_N": [0.4, 0.5, 0.6]},
                 "fields_every": 2}},
    {"material": {"lower": WARM, "upper": {**WARM, "conductivity_W_mK": 20, "youngs_modulus_GPa": 0.003},
                  "youngs_modulus_GPa": None, "poisson_ratio": None},
     "thermal": {"partition": "matched", "deformation": False}},
    {"friction": {"law": "exponential", "limit_coefficient": 0.2, "half_slip_m_s": 0.001, "memory_um": 1000}},
    {"geometry": {"lower_radius_y_mm": None, "upper_radius_y_mm": None}, "load": {"normal_N": None, "normal_N_mm": 0.1},
     "history": {"length_mm": 100.0}},
]


@pytest.mark.parametrize("tables", REMEMBERING)
def test_a_history_goes_on_with_all_that_it_remembers(
    tables: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From any step on, to the same bits, and it solves none of the kept steps again."""
    case = Case.from_dict(ball(**{**tables, "numerics": {"grid": 12}, "history": {"steps": 4, **tables.get("history", {})}}))
    solved, path = list[Any](), tmp_path / "steps.jsonl"
    steps = "thermoroll_cli.many_contacts.history.steps"
    monkeypatch.setattr(f"{steps}.fixed_point", lambda *a, **k: solved.append(a) or fixed_point(*a, **k))

    def run(*, resume: bool) -> Result:
        return solve(case, journal=path, resume=resume)

    whole = run(resume=False)
    records, before = path.read_bytes().splitlines(keepends=True), len(solved)
    for kept in (2, len(records) - 1):
        path.write_bytes(b"".join(records[: 1 + kept]))
        solved.clear()
        found = run(resume=True)
        # The beginning and the last step of each run are solved again.
        assert before - kept <= len(solved) <= before - kept + 3
        assert found.history is not None and whole.history is not None and list(found.history) == list(whole.history)
        for name, column in whole.history.numbers.items():
            np.testing.assert_array_equal(found.history.numbers[name], column, name)
        for name, field in whole.fields.items():
            np.testing.assert_array_equal(found.fields[name], field, name)
        assert repr(found.uncertainty) == repr(whole.uncertainty)


def test_nothing_rolls() -> None:
    case = ball(rolling={"speed_m_s": 0.0}, history={})
    case["history"] = {"time_s": [0, 1, 2], "values": {"force.longitudinal_N": [0, 0.12, 0]}, "steps": 8}
    history = solve(case).history
    assert history is not None and history["force_x_N"] == pytest.approx(history["force.longitudinal_N"], abs=1e-5)
    assert "uncertainty.force_x_N" not in history and 0.0 < history["shift_x_um"][-1] < 0.5 * history["shift_x_um"][4]


@pytest.mark.parametrize("numerics", sampled([{"grid": 24}, {"accuracy": 0.1, "accuracy_of": ["Q_F_W"]}]))
def test_the_power_of_a_row_at_rest_is_the_mean_since_the_row_before(numerics: dict[str, Any]) -> None:
    """Also where the force turns back between two rows, and with steps between them: the heat since then over the time."""
    case = ball(rolling={"speed_m_s": 0.0}, history={}, numerics={"grid": 24})
    case["history"] = {"time_s": [0, 1.2, 2], "values": {"force.longitudinal_N": [0, 0.14, -0.06]}, "steps": 4}
    powers = [1.8959e-08, 1.8443e-07, 2.2734e-07, 2.2149e-07]  # of 48 × 48 elements and 48 steps
    result = solve({**case, "numerics": numerics})
    found = result.history
    assert found is not None and result.converged and result["Q_F_W"] == found["Q_F_W"][-1]
    assert np.diff(found["heat_J"]) / 0.5 == pytest.approx(found["Q_F_W"][1:], rel=1e-9)
    assert (np.abs(np.array(found["Q_F_W"][1:]) - powers) < found["uncertainty.Q_F_W"][1:]).all()
    assert max(found["uncertainty.Q_F_W"]) < 0.8 * max(powers)


def test_a_key_that_changes_has_no_other_value() -> None:
    with pytest.raises(CaseError, match="changes over time"):
        Case.from_dict(ball()).with_values({"creepage.longitudinal": 0.002})
    with pytest.raises(ValueError, match="friction can carry"):
        solve(ball(history={"values": {"force.longitudinal_N": [0, 1, 1]}}))
    without = {name: table for name, table in ball(rolling={"speed_m_s": 0.0}).items() if name != "history"}
    with pytest.raises(CaseError, match="greater than 0"):
        Case.from_dict(without)


ROUND = [[y, -y * y / 340.0] for y in np.linspace(-8, 8, 17)]


@pytest.mark.parametrize("tables", sampled([
    {"geometry": {"upper_radius_y_mm": None, "upper_profile": {"points_mm": ROUND}}}, {"layer": {"compliance_um_GPa": 2e5}},
    {"geometry": {"lower_radius_y_mm": -190.0, "conformal": True}},
    {"material": {"layers": [{"thickness_um": 1500, "youngs_modulus_GPa": 0.001, "poisson_ratio": 0.4}]}}]))  # fmt: skip
def test_the_steady_state_stays(tables: dict[str, Any]) -> None:
    """Of profiles, interlayers, conformal and coated bodies, and it is that of the case without a history."""
    case = ball(**tables, history={"distance_mm": [0, 0.5, 7], "values": {"creepage.longitudinal": [0.002] * 3}})
    case["history"].pop("steps")
    history = solve(case).history
    steady = solve({**{name: table for name, table in case.items() if name != "history"}, "creepage": {"longitudinal": 0.002}})
    assert history is not None and np.ptp(history["force_x_N"]) < 1e-4 * history["force_x_N"][0]
    assert history["force_x_N"][0] == pytest.approx(steady["force_x_N"], abs=2.0 * history["uncertainty.force_x_N"][0])


@pytest.mark.slow
def test_a_shift_of_coated_and_of_conformal_bodies() -> None:
    """A thick coating is its material, a thin one that below; a conformal contact that is hardly curved that of its radii."""
    def shifted(**tables: dict[str, Any]) -> float:
        case = ball(rolling={"speed_m_s": 0.0}, **tables)
        case["history"] = {"time_s": [0, 1], "steps": 2,
                           "values": {"shift.longitudinal_um": [0, 25], "shift.lateral_um": [0, 15]}}
        return float(np.hypot(*(solve(case)[f"force_{axis}_N"] for axis in "xy")))

    def coated(thickness: float) -> dict[str, Any]:
        return {"layers": [{"thickness_um": thickness, "youngs_modulus_GPa": 0.001, "poisson_ratio": 0.28}]}

    plain, soft = shifted(), shifted(material={"youngs_modulus_GPa": 0.001})
    assert shifted(material=coated(1e5)) == pytest.approx(soft, rel=1e-2) and soft < 0.9 * plain
    assert shifted(material=coated(2.0)) == pytest.approx(plain, rel=5e-3)
    curved = {"lower_radius_y_mm": -1e4, "upper_radius_y_mm": 1.0 / (1.0 / 168.73 + 1e-4)}
    assert shifted(geometry={**curved, "conformal": True}) == pytest.approx(plain, rel=5e-3)


def still(tmp_path: Path, begin: str, shifts: dict[str, list[float]]) -> Case:
    """A case without rolling, of one step for each place, in the folder `tmp_path`."""
    case = ball(rolling={"speed_m_s": 0.0})
    case["history"] = {"time_s": [*range(len(next(iter(shifts.values()))))], "begin": begin,
                       "values": {f"shift.{name}_um": values for name, values in shifts.items()}}
    return Case.parse(tomli_w.dumps(case), name=str(tmp_path / "case"))


def test_a_history_goes_on_from_a_file(tmp_path: Path) -> None:
    """Two cases of one step each are one case of two; tractions across are not lost where the second step shifts along."""
    whole = solve(still(tmp_path, "pressed", {"longitudinal": [0, 5, 20], "lateral": [0, 20, 20]}))
    solve(still(tmp_path, "pressed", {"longitudinal": [0, 5], "lateral": [0, 20]})).save(tmp_path / "first.h5")
    second = still(tmp_path, "first.h5", {"longitudinal": [0, 15]})
    parts = solve(second)
    assert whole.converged and parts.converged and abs(whole["force_y_N"]) > 0.01
    assert [parts[name] for name in ("force_x_N", "force_y_N")] == pytest.approx(
        [whole[name] for name in ("force_x_N", "force_y_N")], rel=1e-5)
    (tmp_path / "first.h5").unlink()
    with pytest.raises(ValueError, match=r"first\.h5"):
        solve(second)


@pytest.mark.slow
def test_energy_that_is_missing_is_an_error_of_work_and_heat() -> None:
    """Few steps without rolling under a load that varies: what the work misses counts in its error."""
    case = ball(rolling={"speed_m_s": 0.0})
    case["history"] = {"time_s": [0, 0.4, 1], "steps": 4,
                       "values": {"load.normal_N": [0.3, 0.6, 0.2], "shift.longitudinal_um": [0, 400, -200]}}
    coarse = solve(case).history
    fine = solve({**case, "history": {**case["history"], "steps": 20}, "numerics": {"grid": 24}}).history
    assert coarse is not None and fine is not None
    for name in ("work_J", "heat_J"):
        assert abs(coarse[name][-1] - fine[name][-1]) < coarse[f"uncertainty.{name}"][-1], name
    assert (np.array(coarse["uncertainty.work_J"]) >= coarse["uncertainty.heat_J"]).all()


@pytest.mark.slow
def test_the_pressure_in_the_middle_errs_with_the_largest_one() -> None:
    """A contact of unlike bodies that has the same one on 10 and on 20 elements, and yet another one on finer grids."""
    course = random_course(207)
    course = replace(course, course=replace(course.course, steps=2))
    fine = replace(course, problem=replace(course.problem, numerics=replace(course.problem.numerics, grid=(40, 40))))
    found, exact = (HistorySolver().solve(each).history for each in (course, fine))
    assert found is not None and exact is not None
    true = np.abs(np.array(found["pressure_centre_MPa"]) - exact["pressure_centre_MPa"])
    assert (true <= found["uncertainty.pressure_centre_MPa"]).all()


def warm(begin: str, *, slow: float = 1.0, **tables: dict[str, Any]) -> dict[str, Any]:
    """Constant creepage of unlike bodies at 0.1 m/s, `slow` times as slow with as much less diffusivity."""
    case = ball(thermal={"deformation": False, "partition": "matched"}, **{"rolling": {"speed_m_s": 0.1 / slow}, **tables})
    case["material"] = {
        "lower": {**WARM, "diffusivity_mm2_s": 13 / slow},
        "upper": {**WARM, "conductivity_W_mK": 5, "diffusivity_mm2_s": 2 / slow},
    }
    case["history"] = {
        "distance_mm": [0, 42], "steps": 56, "begin": begin, "values": {"creepage.longitudinal": [0.003, 0.003]},
        **tables.get("history", {})}
    return case


TEMPERATURES = "temperature_rise_max_lower_K", "temperature_rise_max_upper_K", "temperature_rise_mean_lower_K"


def test_half_the_speed_and_diffusivity_is_half_as_warm() -> None:
    fast, slow = (
        solve(warm("pressed", slow=slow, numerics={"grid": 8}, history={"steps": 8})).history for slow in (1.0, 2.0)
    )
    assert fast is not None and slow is not None
    for name in TEMPERATURES:
        assert slow[name] == pytest.approx([0.5 * value for value in fast[name]], rel=1e-4)


@pytest.mark.slow
def test_bulk_temperatures_that_change() -> None:
    """A body that enters warmer heats the other one; friction adds its heat, and the surfaces are equally warm."""
    case = warm(
        "steady",
        history={"steps": 8, "values": {"creepage.longitudinal": [0.001, 0.003], "thermal.bulk_temperature_upper_K": [0, 30]}},
    )
    history = solve(case).history
    assert history is not None and history["thermal.bulk_temperature_upper_K"][-1] == 30
    assert 0.0 < history["temperature_rise_max_lower_K"][-1] < 30 and history["heat_into_upper_W"][-1] < 0.0
    assert "partition_mean" not in history or np.isnan(history["partition_mean"][-1])


def test_steps_in_which_heat_stays_in_its_element() -> None:
    """Microseconds without rolling: the rise at the surface of a half-space, 2 q √(t/π)/(k/√κ), under heat of constant flux."""
    case, time = warm("pressed", numerics={"grid": 10}), 1e-6
    case |= {"rolling": {"speed_m_s": 0.0}, "thermal": {"deformation": False, "partition": 1.0}}
    case["history"] = {"time_s": [0, time], "steps": 1, "values": {"shift.longitudinal_um": [0, 4000]}}
    result = solve(case)
    flux = 1e6 * result["heat_flux_max_W_mm2"]
    exact = 2.0 * flux * math.sqrt(13e-6 * time / math.pi) / 50
    assert result["temperature_rise_max_lower_K"] == pytest.approx(exact, rel=0.02)


def test_heat_at_rest() -> None:
    """Bodies of unlike temperatures, pressed together: in the end the heat of a disc, 2 a ΔT/(1/k₁ + 1/k₂) twice, flows."""
    case = warm("pressed")
    case["thermal"] |= {"bulk_temperature_upper_K": 20.0}
    case["rolling"] = {"speed_m_s": 0.0}
    case["history"] = {"time_s": [0, 1e4], "steps": 8, "values": {"load.normal_N": [0.4705, 0.4705]}}
    result = solve(case)
    history = result.history
    assert history is not None
    conducted = 4.0 * 1e-3 * result["hertz_a_mm"] * 20.0 / (1.0 / 50 + 1.0 / 5)
    assert history["heat_into_lower_W"][-1] == pytest.approx(conducted, rel=0.02)
    assert history["heat_into_lower_W"][1] > history["heat_into_lower_W"][-1]


def hot(**tables: dict[str, Any]) -> tuple[dict[str, Any], list[Any]]:
    """A steel ball that slides with half its rolling speed of 20 m/s, without its history, and what it is over time: from the
    steady state, and from nothing."""
    case = ball(numerics={"grid": 10}, geometry={"upper_radius_x_mm": 15.0, "upper_radius_y_mm": 15.0}, **tables)
    case["material"] = {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28, "conductivity_W_mK": 50, "expansion_um_mK": 11.7,
                        "diffusivity_mm2_s": 10}
    case |= {"load": {"normal_N": 65, "friction_coefficient": 0.3}, "rolling": {"speed_m_s": 20.0, "differential_slip": False}}
    case.pop("history")
    course = {"distance_mm": [0, 1.4], "steps": 20, "values": {"creepage.longitudinal": [0.5, 0.5]}}
    return case, [solve({**case, "history": {**course, "begin": begin}}).history for begin in ("steady", "pressed")]


@pytest.mark.slow
def test_expansion_ends_in_the_steady_coupled_state() -> None:
    """Sliding that heats the surfaces: what begins with the coupled state stays there, and what begins cold ends there."""
    case, (stays, grows) = hot()
    for name in ("gamma_p", "gamma_c", "temperature_rise_max_lower_K", "thermal_displacement_max_um"):
        steady = stays[name][0]
        assert stays[name] == pytest.approx([steady] * 21, rel=1e-3), name
        assert grows[name][-1] == pytest.approx(steady, rel=2e-3), name
    assert stays["gamma_p"][0] > 1.02 and grows["gamma_p"][0] == 1.0
    result = solve({**case, "creepage": {"longitudinal": 0.5}})
    assert stays["gamma_p"][0] == pytest.approx(result["gamma_p"], rel=2e-3)


FALLING = {"law": "exponential", "limit_coefficient": 0.2, "half_slip_m_s": 0.01, "memory_um": 20.0}


def test_friction_remembers_while_bodies_slide_without_rolling() -> None:
    """f − f(s) falls like e^(−s t/d) under a shift at constant speed once all slides."""
    speed, time, steps = 0.02, 8e-3, 24
    case = ball(rolling={"speed_m_s": 0.0}, friction=FALLING, numerics={"grid": 10}, material={"youngs_modulus_GPa": 210.0})
    case["history"] = {"time_s": [0, time], "steps": steps, "values": {"shift.longitudinal_um": [0, 1e6 * speed * time]}}
    history = solve(case).history
    assert history is not None and set(history["gamma_st"][4:]) == {0.0}
    coefficient = np.array(history["force_x_N"][4:]) / 0.4705 - (0.2 + 0.2 * 0.5 ** (speed / 0.01))
    assert coefficient[1:] / coefficient[:-1] == pytest.approx(math.exp(-speed * time / steps / 20e-6), rel=0.02)


@pytest.mark.slow
def test_friction_that_remembers_in_rolling() -> None:
    """The steady state stays, is the end of what begins from nothing, and a step that is long leads to it at once."""
    case = ball(friction=FALLING, numerics={"grid": 16}, rolling={"speed_m_s": 1.0})
    case["history"] = {"distance_mm": [0, 28], "steps": 28, "values": {"creepage.longitudinal": [0.01, 0.01]}}
    leap = {**case["history"], "distance_mm": [0, 1e5], "steps": 1}
    histories = [solve({**case, "history": {**given, "begin": begin}}).history
                 for given, begin in ((case["history"], "steady"), (case["history"], "pressed"), (leap, "pressed"))]
    without = {name: table for name, table in case.items() if name != "history"}
    steady = solve({**without, "creepage": {"longitudinal": 0.01}})
    for history in histories:
        assert history is not None
        assert history["force_x_N"][-1] == pytest.approx(histories[0]["force_x_N"][0], rel=2e-3)  # type: ignore[index]
        assert history["force_x_N"][-1] == pytest.approx(steady["force_x_N"], abs=2.0 * history["uncertainty.force_x_N"][-1])
    assert histories[0] is not None and histories[0]["friction_mean"][0] < 0.39


@pytest.mark.slow
def test_friction_that_falls_with_temperature() -> None:
    """It does so as the surfaces warm up, and ends with the force of the steady state."""
    _, (stays, grows) = hot(friction={"temperature_slope_1_K": 0.001}, thermal={"deformation": False})
    steady = stays["force_x_N"][0]
    assert steady < 0.95 * 0.3 * 65.0 and stays["force_x_N"] == pytest.approx([steady] * 21, rel=1e-3)
    assert max(grows["force_x_N"]) > 1.01 * steady and grows["force_x_N"][-1] == pytest.approx(steady, rel=3e-3)


def test_an_error_is_no_larger_than_what_its_row_can_have() -> None:
    """A load that falls to a thousandth: what friction carries falls, too, and the first row has no tractions at all."""
    history = solve(ball(numerics={"grid": 16}, history={"distance_mm": [0, 4], "steps": 8, "begin": "pressed", "values": {
        "load.normal_N": [0.4705, 0.0005], "creepage.longitudinal": [0.003, 0.003]}})).history
    assert history is not None
    limit, force = np.array(history["friction_limit_N"]), np.array(history["force_x_N"])
    error = np.array(history["uncertainty.force_x_N"])
    assert (error <= limit + np.abs(force)).all() and error[-1] <= 2.0 * limit[-1] < 5e-4 and error.max() > 1e-3
    for name in ("force_x_N", "Q_F_W", "heat_J", "shear_max_MPa", "gamma_st", "elastic_energy_J"):
        assert history[f"uncertainty.{name}"][0] == 0.0, name
        assert min(history[f"uncertainty.{name}"][1:]) > 0.0, name


@pytest.mark.slow
@pytest.mark.parametrize(("begin", "forces", "heats"), [
    pytest.param("steady", [0.11907, 0.084463, 0.025039, -0.046922, -0.10599],
                 [0.0003572, 0.00017364, 1.9387e-05, 3.6099e-05, 0.00026024], marks=pytest.mark.slow),
    ("pressed", [0.0, 0.081405, 0.024917, -0.046927, -0.10599], [0.0, 0.00015708, 1.919e-05, 3.6113e-05, 0.00026025]),
])
def test_an_accuracy_takes_steps_where_steps_err(begin: str, forces: list[float], heats: list[float]) -> None:
    """A creepage that passes through 0 in four steps, each three times as long as the contact: steps err, and are added, not
    elements (256 × 256 in 48 processor seconds before). `forces` (N) and `heats` (W) are those of 64 × 64 and 128 steps."""
    found = solve(ball(numerics={"grid": None, "accuracy": 0.1}, history={
        "distance_mm": [0, 56], "steps": 4, "begin": begin, "values": {"creepage.longitudinal": [0.003, -0.003]}}))
    assert found.converged and found.work["grid"] == [32, 32] and found.history is not None
    assert found.history["force_x_N"] == pytest.approx(forces, abs=0.1 * max(forces))
    assert found.history["Q_F_W"] == pytest.approx(heats, abs=0.1 * max(heats))


def test_unlike_bodies_go_on_from_a_file_where_they_stood() -> None:
    """Their shear has changed the pressure, which has moved their surfaces: a history cut in two is the whole."""
    unlike = {"lower": BALL["material"], "upper": {"youngs_modulus_GPa": 0.02, "poisson_ratio": 0.28}}
    still = ball(material={**unlike, "youngs_modulus_GPa": None, "poisson_ratio": None}, rolling={"speed_m_s": 0.0},
                 numerics={"grid": 10})
    still["history"] = {"time_s": [0, 1, 2, 3], "values": {"shift.longitudinal_um": [0, 4, 8, 12]}}
    whole, task = solve(still), Case.from_dict(still).task
    assert isinstance(task, History) and whole.history is not None
    course = task.course
    values = course.values["shift.longitudinal_um"]
    first, second = ({"places": course.places[part], "values": {"shift.longitudinal_um": values[part]}}
                     for part in (slice(0, 3), slice(2, 4)))
    before = HistorySolver().solve(replace(task, course=replace(course, **first)))
    after = HistorySolver().solve(replace(task, course=replace(course, begin=before, **second))).history
    assert after is not None
    limit = whole.history["friction_limit_N"][-1]
    assert after["force_x_N"][-1] == pytest.approx(whole.history["force_x_N"][-1], abs=1e-4 * limit)


@pytest.mark.slow
def test_friction_may_vanish_for_a_while() -> None:
    """An oily spot: nothing is carried on it, and behind it the contact begins as from nothing."""
    spot = ball(load={"friction_coefficient": 0.4}, history={
        "distance_mm": [0, 3, 4, 5, 5, 9], "steps": 18, "begin": "pressed", "values": {
            "load.friction_coefficient": [0.4, 0.4, 0.0, 0.0, 0.4, 0.4], "creepage.longitudinal": [0.003] * 6}})
    history = solve(spot).history
    assert history is not None and set(history["status"]) == {"converged"}
    force, limit = np.array(history["force_x_N"]), np.array(history["friction_limit_N"])
    assert (force[8:11] == 0.0).all() and (force <= limit * (1.0 + 1e-9)).all()
    assert force[11:17] == pytest.approx(force[1:7], rel=1e-3)
    assert np.isnan(history["force_x_over_friction_limit"])[8:11].all()


def test_a_creepage_of_zero_beside_a_force_over_time_is_left_out() -> None:
    """Cases that older versions resolved have it written; another creepage contradicts the force."""
    values = {"values": {"force.longitudinal_N": [0.05, 0.1, 0.1]}}
    written = Case.from_dict(ball(creepage={"longitudinal": 0.0}, history=values))
    assert written == Case.from_dict(ball(history=values)) and written.task.problem.motion.creepage_x is None
    with pytest.raises(CaseError, match="cannot be given together"):
        Case.from_dict(ball(creepage={"longitudinal": 1e-3}, history=values))


def test_a_domain_smaller_than_the_contact_grows_with_a_warning() -> None:
    """As of a contact without a history."""
    case = {**ball(), "numerics": {"grid": 8, "extent": 1.5}}
    over_time = solve(case)
    single = solve({name: table for name, table in case.items() if name != "history"})
    warning = "numerics.extent = 1.5 is smaller than the contact: grown to 2.1"
    assert warning in over_time.warnings and warning in single.warnings and over_time.work["extent"] == 2.1

"""What a sweep prints, and what it says about files that were there before."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.support.command_line import MECHANICAL, call
from thermoroll_cli.cli.tables import FAILED, sweep_table, wrapped
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.problem.scalar_errors import with_error, worth_showing
from thermoroll_cli.studies.sweeps.points import Base, Points, parse_axes


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "spheres.toml"
    path.write_text(MECHANICAL.replace("grid = 16", "grid = 8"))
    return path


@pytest.fixture(autouse=True)
def ordinary_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def printed_columns(stdout: str, name: str = "spheres_0001") -> list[str]:
    """The headers of the printed table, put together again, in their order."""
    lines = stdout.replace(f"  {FAILED}", f"__{FAILED}").splitlines()
    row = next(index for index, line in enumerate(lines) if name in line)
    header = [line for line in lines[:row] if "spheres_" not in line]
    table = [*header, *(line for line in lines[row:] if line.startswith("  spheres_"))]
    written = [any(line[place:place + 1].strip() for line in table) for place in range(max(map(len, table)) + 2)]
    starts = [place for place, there in enumerate(written) if there and not any(written[max(place - 2, 0):place])]
    ends = [*starts[1:], None]
    return ["".join(line[start:end].strip() for line in header) for start, end in zip(starts, ends, strict=True)][1:]


def test_a_swept_force_shows_the_creepage_found(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    over = ("--over", "force.longitudinal_N=5,10", "--set", "numerics.grid=16")
    done = call("sweep", case, *over, "-o", tmp_path / "out", "--no-plots")
    columns = printed_columns(done.stdout)
    assert columns[:2] == ["force.longitudinal_N", "Q_F_W"] and "creepage_longitudinal" in columns
    assert "force_x_N" not in columns and "force_x_over_friction_limit" in columns
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    place = 1 + columns.index("creepage_longitudinal")
    shown = [line.split()[place] for line in done.stdout.splitlines() if line.startswith("  spheres_")]
    value, error = ([float(row[f"{state}creepage_longitudinal"]) for row in rows] for state in ("", "uncertainty."))
    assert shown == [with_error(v, e).replace(" ", "") for v, e in zip(value, error, strict=True)]
    assert all("±" in text for text in shown)
    place = 1 + columns.index("force_x_over_friction_limit")
    shares = [line.split()[place] for line in done.stdout.splitlines() if line.startswith("  spheres_")]
    assert all("±" not in share for share in shares), "a given force has no error"


def test_a_given_creepage_is_not_shown_again_and_what_never_changes_only_once(case: Path, tmp_path: Path) -> None:
    done = call("sweep", case, "--over", "creepage.longitudinal=1e-3,2e-3", "-o", tmp_path / "out", "--no-plots")
    assert "creepage_longitudinal" not in printed_columns(done.stdout)
    (told,) = (line for line in done.stdout.splitlines() if line.startswith("  at all points: "))
    assert "creepage" not in told
    assert "gamma_p = 1" in told and "gamma_c = 1" in told and "gamma_p" not in printed_columns(done.stdout)


@pytest.mark.parametrize("columns", [60, 200])
def test_tables_fit_the_terminal(columns: int, case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    over = ("--over", "force.longitudinal_N=5,10", "--over", "force.lateral_N=1,2")
    done = call("sweep", case, *over, "-o", "out", "--no-plots", cwd=tmp_path)
    assert max(map(len, done.stdout.splitlines())) <= columns
    assert ("more in the file" in done.stdout) == (columns < 200)


def test_what_reads_as_another_column_comes_last() -> None:
    """The largest temperature of a wheelset is that of one of its bodies, and takes no room of the pressure."""
    points = Points.of([Base(MECHANICAL, "", "spheres")], parse_axes(["load.normal_N=65,80"]))
    rows = [SimpleNamespace(name=points.name(number), number=number, over=points.over(number), converged=True, cells=partial(
        dict, unbounded="", temperature_rise_max_lower_K=5.0 * number, temperature_rise_max_K=5.0 * number,
        Q_F_W=9.0 + number, pressure_max_MPa=600.0 + number, hertz_p0_MPa=600.0 + number)) for number in (1, 2)]  # fmt: skip
    printed = printed_columns("\n".join(sweep_table(rows, points, 60)))
    assert "pressure_max_MPa" in printed and "temperature_rise_max_K" not in printed


def test_a_narrow_table_shows_what_changes_most(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    done = call("sweep", case, "--over", "creepage.lateral=0,1e-3", "-o", tmp_path / "out", "--no-plots")
    columns = printed_columns(done.stdout)
    assert "force_y_N" in columns and "force_x_N" not in columns and "force_x_N" in done.stdout


def test_a_table_of_many_inputs_has_results_in_a_further_block(tmp_path: Path) -> None:
    (tmp_path / "one_case.toml").write_text(MECHANICAL.replace("grid = 16", "grid = 8"))
    keys = "load.normal_N,geometry.lower_radius_x_mm,geometry.upper_radius_x_mm,rolling.speed_m_s,creepage.longitudinal"
    (tmp_path / "points.csv").write_text(f"{keys}\n448,30,30,1,0.001\n447.9,35,30,1.25,0.002\n4,40,30.5,2,0.003\n")
    asked = ("sweep", tmp_path / "one_case.toml", "--points", tmp_path / "points.csv", "--no-plots", "-o",
             tmp_path / "out")
    lines = call(*asked).stdout.splitlines()
    rows = [line for line in lines if line.startswith("  one_case_000")]
    assert len(rows) == 6 and max(map(len, lines[:-1])) <= 80 and "force_" in "".join(lines[:16])
    assert [row.split()[1] for row in rows[:3]] == ["448", "447.9", "4"]
    assert rows[0].index("448 ") == rows[1].index("447.9") == rows[2].index(" 4 ") - 1, "one below the other"
    lines = call(*asked, "--columns", "approach_um,shear_max_MPa", "--limit", "force_x_N<2000").stdout.splitlines()
    heads = "".join(lines[next(k for k, line in enumerate(lines) if "_0003" in line):][1:4])
    assert [heads.find(name) >= 0 for name in ("approach_um", "shear_")] == [True, True]


def test_headers_break_where_words_end() -> None:
    assert wrapped("rolling.speed_m_s", 5) == ["rolling.", "speed_m_s"]
    assert wrapped("Q_F_W", 6) == ["Q_F_W"]
    assert wrapped("temperature_rise_max_lower_K", 7) == ["temperature_", "rise_max_", "lower_K"]
    assert wrapped("gamma_c", 20) == ["gamma_c"]


def test_files_that_a_smaller_sweep_leaves_over_are_removed_and_those_of_others_are_told(case: Path, tmp_path: Path) -> None:
    over = ("--over", "creepage.longitudinal=1e-3,2e-3,3e-3")
    first = call("sweep", case, *over, "-o", "out", cwd=tmp_path)
    assert "another sweep" not in first.stderr and "earlier run" not in first.stderr
    (tmp_path / "out" / "spheres_0007.h5").write_bytes(b"of somebody else")
    resumed = call("sweep", case, "--over", "creepage.longitudinal=1e-3", "-o", "out", "--no-plots", "--resume", cwd=tmp_path)
    assert "3 files of another sweep, not touched, not in sweep.csv: spheres_0002.h5 … spheres_0007.h5" in resumed.stderr
    done = call("sweep", case, "--over", "creepage.longitudinal=4e-3", "-o", "out", "--no-plots", "--force", cwd=tmp_path)
    assert "out: 2 files of the sweep before, removed: spheres_0002.h5 … spheres_0003.h5" in done.stderr
    assert "out: 1 file of another sweep, not touched, not in sweep.csv: spheres_0007.h5" in done.stderr
    assert "left from an earlier run, not updated: out/sweep.png" in done.stderr
    assert sorted(path.name for path in (tmp_path / "out").glob("*.h5")) == ["spheres_0001.h5", "spheres_0007.h5"]
    quiet = call("sweep", case, "--over", "creepage.longitudinal=4e-3", "-o", "out", "--no-plots", "-q", cwd=tmp_path)
    assert quiet.stderr == ""


@pytest.mark.slow
def test_peaks_without_a_limit_are_told_in_every_form(tmp_path: Path) -> None:
    """An arc that ends beside its top: under the smaller load the contact does not get there."""
    profile = "[geometry.upper_profile]\npoints_mm = [[-0.1, -0.000167], [0.0, 0.0], [1.0, -0.01667], [2.0, -0.0667]]\n[load]"
    text = MECHANICAL.replace("grid = 16", "grid = 8").replace("upper_radius_y_mm = 30.0\n", "").replace("[load]", profile)
    (tmp_path / "spheres.toml").write_text(text)
    over = ("--over", "load.normal_N=0.5,65", "--no-plots")
    done = call("sweep", tmp_path / "spheres.toml", *over, "-o", tmp_path / "out", "--json")
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert all(len(json.loads(line)["patches"]) == 1 for line in done.stdout.splitlines())
    told = [json.loads(line).get("unbounded", []) for line in done.stdout.splitlines()]
    assert [row["unbounded"].split() for row in rows] == told, done.stderr
    assert any("pressure_max_MPa" in names for names in told) and [] in told
    alone = call("sweep", tmp_path / "spheres.toml", *over, "-o", tmp_path / "alone", "--json", "--scalars-only")
    assert [json.loads(line).get("unbounded", []) for line in alone.stdout.splitlines()] == told
    printed = call("sweep", tmp_path / "spheres.toml", *over, "-o", tmp_path / "out", "--resume").stdout
    assert "no limit (an end or a kink of a profile): gamma_p" in " ".join(printed.split())


def test_each_kind_of_warning_is_shown_once(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = ContactSolver.solve

    def warned(self: ContactSolver, problem: Any, **options: Any) -> Any:
        hot = (f"{40 * problem.normal_force:g} K is hot",) if problem.normal_force > 50.0 else ()
        return replace(good(self, problem, **options), warnings=(*hot, "flat") if problem.normal_force > 70.0 else hot)

    monkeypatch.setattr(ContactSolver, "solve", warned)
    for only in ((), ("--scalars-only",)):
        done = call("sweep", case, "--over", "load.normal_N=40,60,80", "-o", tmp_path / "out", "--no-plots", *only)
        warnings = [line.strip() for line in done.stdout.splitlines() if "warning: " in line]
        assert warnings == ["warning: 2400 K is hot (at spheres_0002 and 1 more point)", "warning: flat (at spheres_0003)"]
        rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
        assert [row["warnings"] for row in rows] == ["", "2400 K is hot", "3200 K is hot; flat"]


def test_a_sweep_of_one_point_says_that_it_draws_no_picture(case: Path, tmp_path: Path) -> None:
    done = call("sweep", case, "--over", "load.normal_N=40", "-o", tmp_path / "out")
    assert "no picture: a sweep of one point has no curve" in done.stdout
    assert not (tmp_path / "out" / "sweep.png").exists()


def test_what_is_worth_showing_follows_the_values() -> None:
    def shown(name: str, swept: str = "rolling.speed_m_s", **columns: list[float]) -> bool:
        points = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
        return worth_showing(name, points, [swept])

    force, creepage, steady = "force_x_N", "creepage_longitudinal", [2.0, 2.0]
    assert shown(force, force_x_N=[1.0, 2.0], force_y_N=[0.0, 0.0], creepage_longitudinal=steady)
    assert not shown(creepage, force_x_N=[1.0, 2.0], creepage_longitudinal=steady, creepage_lateral=[0.0, 0.0],
                     creepage_spin_rad_mm=[0.0, 0.0], hertz_a_mm=[1.0, 1.0], hertz_b_mm=[1.0, 1.0])
    assert not shown(force, force_x_N=steady, creepage_longitudinal=[1.0, 2.0]), "the force is given"
    assert not shown(creepage, "creepage.longitudinal", creepage_longitudinal=[1.0, 2.0])
    assert not shown("force_y_N", force_x_N=steady, force_y_N=[1e-7, 2e-7]), "rounding"
    assert not shown("Q_F_W", Q_F_W=[math.nan, math.nan])
    pressures = [900.0, 1200.0]
    assert shown("pressure_max_MPa", pressure_max_MPa=pressures, hertz_p0_MPa=pressures)
    assert not shown("pressure_max_MPa", pressure_max_MPa=pressures, hertz_p0_MPa=steady)
    assert shown("pressure_max_MPa", pressure_max_MPa=pressures)

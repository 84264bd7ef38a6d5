"""`run` through the real entry point: files, streams, exit codes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import MECHANICAL, THERMAL, call
from tests.support.documents import ROOT
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.names import PROBLEM_SCALARS, SCALARS

HOPELESS = THERMAL.replace("speed_m_s = 1.0", "speed_m_s = 1e5").replace("grid = 16", "grid = 8")
HOPELESS += '[thermal]\npeclet = "stationary"\n'
"""Beyond the heat for which there is a steady state."""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "two spheres.toml"
    path.write_text(MECHANICAL)
    return path


def strict(line: str) -> dict[str, Any]:
    """One JSON object; NaN and Infinity, which Python would accept, are not JSON."""
    return dict(json.loads(line, parse_constant=lambda name: pytest.fail(f"{name} is not JSON")))


@pytest.mark.slow
def test_run_writes_files_and_a_table(case: Path, tmp_path: Path) -> None:
    done = call("run", case, "--set", "numerics.grid=32", cwd=tmp_path)  # two grids, so there are estimates
    assert done.returncode == 0
    assert "converged" in done.stdout and "Q_F_W" in done.stdout and "±" in done.stdout
    assert "grid 32×32" in done.stderr
    names = {path.name for path in (tmp_path / "results").iterdir()}
    assert "two spheres.h5" in names
    assert any(name.endswith(".png") for name in names)
    assert all(name.startswith("two spheres") for name in names)
    stored = read_result(tmp_path / "results" / "two spheres.h5")
    assert stored.case_text == MECHANICAL
    assert stored.attributes["command_line"] == f"thermoroll run '{case}' --set numerics.grid=32"


def test_json_can_be_the_same_byte_by_byte(case: Path, tmp_path: Path) -> None:
    once, twice = (call("run", case, "--json", "--reproducible", "--no-plots", "-o", "o", cwd=tmp_path).stdout
                   for _ in range(2))
    assert once == twice
    assert "seconds" not in strict(once)["work"] and "applications" in strict(once)["work"]


def test_json_is_one_line_and_nothing_else(case: Path, tmp_path: Path) -> None:
    done = call("run", case, "--json", "--no-plots", "-o", "o", cwd=tmp_path)
    (line,) = done.stdout.splitlines()
    result = strict(line)
    # A mechanical case: what needs heat is left out or null.
    assert set(result) | {"temperature_rise_max_lower_K", "temperature_rise_max_upper_K", "thermal_displacement_max_um"} >= {
        *SCALARS,
        *PROBLEM_SCALARS,
    }
    assert result["peclet_lower"] is None
    assert result["status"] == "converged"
    assert {"reason", "isothermal", "uncertainty", "work", "warnings"} <= set(result)
    assert result["name"] == "two spheres"
    assert result["files"] == ["o/two spheres.h5"]
    assert [path.name for path in (tmp_path / "o").iterdir()] == ["two spheres.h5"]


def test_quiet_and_verbose(case: Path, tmp_path: Path) -> None:
    quiet = call("run", case, "-q", "--no-plots", cwd=tmp_path)
    assert (quiet.returncode, quiet.stdout, quiet.stderr) == (0, "", "")
    quiet_json = call("run", case, "-q", "--json", "--no-plots", cwd=tmp_path)
    assert quiet_json.stderr == "" and len(quiet_json.stdout.splitlines()) == 1
    normal = call("run", case, "--no-plots", cwd=tmp_path)
    verbose = call("run", case, "-v", "--no-plots", cwd=tmp_path)
    assert "power_balance_error" in verbose.stdout and "power_balance_error" not in normal.stdout
    assert len(verbose.stderr.splitlines()) >= len(normal.stderr.splitlines())


def test_several_cases_and_standard_input(case: Path, tmp_path: Path) -> None:
    (tmp_path / "zwei.toml").write_text(MECHANICAL)
    done = call("run", case, "zwei.toml", "-", "--json", "--no-plots", cwd=tmp_path, stdin=MECHANICAL)
    assert [strict(line)["name"] for line in done.stdout.splitlines()] == ["two spheres", "zwei", "stdin"]
    assert {path.name for path in (tmp_path / "results").iterdir()} == {"two spheres.h5", "zwei.h5", "stdin.h5"}


def test_picture_options(case: Path, tmp_path: Path) -> None:
    done = call("run", case, "--plots", "summary", "--format", "svg", "--normalised", "-q", cwd=tmp_path)
    assert done.returncode == 0
    assert {path.suffix for path in (tmp_path / "results").iterdir()} == {".h5", ".svg"}
    call("run", case, "--set", "output.plots=false", "-q", "-o", "none", cwd=tmp_path)
    assert {path.suffix for path in (tmp_path / "none").iterdir()} == {".h5"}
    for folder, options in (("case", ("--set", 'output.plots="summary"')), ("option", ("--plots", "summary", "--set",
                            "output.plots=false"))):  # fmt: skip
        call("run", case, *options, "-q", "-o", folder, cwd=tmp_path)
        assert {path.name for path in (tmp_path / folder).iterdir()} == {f"{case.stem}.h5", f"{case.stem}_summary.png"}
    call("run", case, "--no-plots", "--plots", "none", "-q", "-o", "neither", cwd=tmp_path)
    assert {path.suffix for path in (tmp_path / "neither").iterdir()} == {".h5"}
    assert call("run", case, "--no-plots", "--plots", "all", cwd=tmp_path).returncode == 2
    assert call("run", case, "--format", "gif", cwd=tmp_path).returncode == 2


def test_invalid_case_stops_everything_before_it_starts(case: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(MECHANICAL.replace("normal_N = 65.0", "normal_kN = 65.0"))
    done = call("run", case, "bad.toml", "missing.toml", "--json", cwd=tmp_path)
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 3 and [record["case"] for record in records] == ["bad.toml", "missing.toml"]
    assert all(record["errors"] and not record["valid"] for record in records)
    assert 'did you mean "normal_N"' in done.stderr and "missing.toml: error: no such file" in done.stderr
    assert done.stderr.endswith("2 errors; nothing was computed\n")
    assert not (tmp_path / "results").exists()


def test_not_converged_is_written_and_told(case: Path, tmp_path: Path) -> None:
    (tmp_path / "hot.toml").write_text(HOPELESS)
    done = call("run", "hot.toml", case, "--json", "--no-plots", cwd=tmp_path)
    assert done.returncode == 4
    hot, fine = (strict(line) for line in done.stdout.splitlines())
    assert (hot["status"], fine["status"]) == ("not_converged", "converged")
    assert hot["reason"] and hot["reason"] in done.stderr
    assert read_result(tmp_path / "results" / "hot.h5").converged is False
    table = call("run", "hot.toml", "--no-plots", "--limit", "pressure_max_MPa<1", cwd=tmp_path)
    assert table.returncode == 4, "and not that of a limit"
    assert "NOT CONVERGED" in table.stdout
    (reason,) = [line for line in table.stdout.splitlines() if hot["reason"][:30] in line]
    assert reason[2:32] not in table.stderr  # said once


def test_places_that_cannot_be_written(case: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for place in ("file", "file/below", "/proc/nowhere", "/dev/null"):
        done = call("run", case, "-o", place, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (5, "")
        assert place in done.stderr
    (tmp_path / "results" / "two spheres.h5").mkdir(parents=True)
    done = call("run", case, "--json", "--no-plots", cwd=tmp_path)
    assert done.returncode == 5
    assert strict(done.stdout)["files"] == []  # the numbers are not lost
    assert not any(path.suffix == ".part" for path in (tmp_path / "results").iterdir())


def test_heat_that_comes_back_has_its_flash_and_bulk_temperatures_printed(tmp_path: Path) -> None:
    """The largest rise counts from the surroundings, and is about the bulk temperature that the disc reaches plus the flash."""
    asked = ("run", ROOT / "cases" / "twin_disc.toml", "-o", tmp_path, "--no-plots", "--set", "numerics.grid=16")
    lines = " ".join(call(*asked).stdout.split())
    record = read_result(tmp_path / "twin_disc.h5")
    flash, bulk, rise = (record[f"{name}_lower_K"]
                         for name in ("flash_temperature_max", "bulk_temperature", "temperature_rise_max"))
    assert flash + bulk == pytest.approx(rise, rel=0.03) and flash < 0.3 * rise
    for name, words in (("flash_temperature_max", "flash temperature"), ("bulk_temperature", "bulk temperature"),
                        ("temperature_rise_max", "rise above the surroundings")):
        assert f"{name}_lower_K" in lines and words in lines

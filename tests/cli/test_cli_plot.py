"""`thermoroll plot` with its options, for results and for sweeps; `Result.plot` in notebooks."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from PIL import Image

from tests.support import synthetic
from tests.support.command_line import call
from thermoroll_cli.files.result.hdf5 import write_result
from thermoroll_cli.python_api import read_result

CREEP = """[material]
youngs_modulus_GPa = 210.0
poisson_ratio = 0.28
[geometry]
lower_radius_x_mm = inf
lower_radius_y_mm = 300.0
upper_radius_x_mm = 460.0
upper_radius_y_mm = inf
[load]
normal_N = 80e3
friction_coefficient = 0.3
[rolling]
speed_m_s = 10.0
[numerics]
grid = 16
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("result") / "r.h5"
    write_result(path, synthetic.result((24, 24)), case_text="", case_json="{}", command_line="")
    return path


def test_pictures_are_chosen_and_sized(result: Path, tmp_path: Path) -> None:
    done = call("plot", result, "-o", tmp_path, "--fields", "pressure,gap", "--dpi", 100)
    assert done.returncode == 0, done.stderr
    assert sorted(os.listdir(tmp_path)) == ["r_gap.png", "r_pressure.png"]
    with Image.open(tmp_path / "r_pressure.png") as image:
        assert image.width == pytest.approx(180 / 25.4 * 100, abs=1)


def test_the_cut_is_where_it_is_asked_for(result: Path, tmp_path: Path) -> None:
    done = call("plot", result, "-o", tmp_path, "--fields", "centreline", "--cut-y", 0.05, "--format", "svg")
    assert done.returncode == 0, done.stderr
    assert "y = 0.05 mm" in (tmp_path / "r_centreline.svg").read_text()


@pytest.mark.parametrize(("options", "message"), [
    (["--fields", "presure"], "there is no picture 'presure'"), (["--cut-y", 70], "outside the domain"),
    (["--dpi", 0], "--dpi"),
    ])  # fmt: skip
def test_wrong_options_are_usage_errors(result: Path, tmp_path: Path, options: list[str], message: str) -> None:
    done = call("plot", result, "-o", tmp_path, *options)
    assert (done.returncode, message in " ".join(done.stderr.split())) == (2, True), done.stderr
    assert os.listdir(tmp_path) == []


def test_sweeps_are_drawn_again_from_either_table(tmp_path: Path) -> None:
    """With theories beside the creep forces, on request; CSV has no title."""
    case = tmp_path / "creep.toml"
    case.write_text(CREEP)
    over = ("--over", "creepage.longitudinal=0.0005:0.004:3")
    done = call("sweep", case, *over, "--scalars-only", "-o", tmp_path, "--compare", "linear,polach,fastsim", "--format", "svg")
    assert done.returncode == 0, done.stderr
    assert call("sweep", case, *over, "-o", tmp_path, "--compare", "contact").returncode == 2
    theories = ("Kalker's linear theory", "FASTSIM", "Polach")
    first = (tmp_path / "sweep.svg").read_text()
    assert all(words in first for words in theories)
    for table in ("sweep.csv", "sweep.h5"):
        (tmp_path / "sweep.svg").unlink()
        assert call("plot", tmp_path / table, "--compare", "linear,polach,fastsim", "--format", "svg").returncode == 0
        again = (tmp_path / "sweep.svg").read_text()
        assert all(words in again for words in theories)
        assert table == "sweep.csv" or again == first
    assert call("plot", tmp_path / "sweep.csv").returncode == 0
    assert (tmp_path / "sweep.png").exists()


def test_files_that_are_no_tables_are_refused(tmp_path: Path) -> None:
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    done = call("plot", tmp_path / "other.csv")
    assert (done.returncode, "not the table of a sweep" in done.stderr) == (5, True), done.stderr


def test_pictures_in_notebooks(result: Path) -> None:
    read = read_result(result)
    assert read.plot("pressure").axes and read.plot("gap").axes
    with pytest.raises(ValueError, match="nothing to show in a picture 'track'"):
        read.plot("track")
    with pytest.raises(ValueError, match="there is no picture 'presure'"):
        read.plot("presure")

"""`plot`, `compare`, `export` through the real entry point, for results and for sweeps; `Result.plot` in notebooks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from tests.support.command_line import MECHANICAL, call
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.plots import style as plot_style


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two results that differ."""
    folder = tmp_path_factory.mktemp("results")
    for name, creepage in (("a", "0.003"), ("b", "0.002")):
        (folder / f"{name}.toml").write_text(MECHANICAL.replace("0.003", creepage))
        assert call("run", f"{name}.toml", "--no-plots", "-q", "-o", ".", cwd=folder).returncode == 0
    return folder


def test_plot_prints_what_it_wrote(results: Path, tmp_path: Path) -> None:
    files = (results / "a.h5", results / "b.h5")
    done = call("plot", *files, "-o", tmp_path / "pictures", "--format", "svg", "--fields", "pressure,gap")
    assert (done.returncode, done.stderr) == (0, "")
    written = [Path(line) for line in done.stdout.splitlines()]
    assert sorted(written) == sorted((tmp_path / "pictures").iterdir())
    assert {path.suffix for path in written} == {".svg"}
    assert [path.stem for path in sorted(written)] == ["a_gap", "a_pressure", "b_gap", "b_pressure"]


@pytest.mark.slow
def test_plot_writes_beside_the_result(results: Path, tmp_path: Path) -> None:
    (tmp_path / "a.h5").write_bytes((results / "a.h5").read_bytes())
    done = call("plot", "a.h5", "--normalised", "-q", "--dpi", 100, painted=True, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "")
    assert len(list(tmp_path.glob("a_*.png"))) >= 3
    with Image.open(tmp_path / "a_pressure.png") as image:
        assert image.width == pytest.approx(90 / 25.4 * 100, abs=1)


def test_plot_tells_which_pictures_show_another_result(results: Path, tmp_path: Path) -> None:
    (tmp_path / "a.h5").write_bytes((results / "a.h5").read_bytes())
    (tmp_path / "a_temperature.png").write_bytes(b"of a result with heat")
    (tmp_path / "a_pressure.svg").write_bytes(b"of this result")
    done = call("plot", "a.h5", cwd=tmp_path)
    assert done.stderr == "thermoroll: left from an earlier run, not updated: a_temperature.png\n"


def test_compare_outside_tolerance(results: Path) -> None:
    done = call("compare", results / "a.h5", results / "b.h5", "--rtol", "1e-3")
    assert (done.returncode, done.stderr) == (6, "")
    assert "Q_F_W" in done.stdout and "outside" in done.stdout
    assert call("compare", results / "a.h5", results / "b.h5", "--rtol", "1e9", "-q").returncode == 0
    assert call("compare", results / "a.h5", results / "b.h5", "-q").stdout == ""
    everything = call("compare", results / "a.h5", results / "b.h5", "--rtol", "1e9", "-v")
    assert everything.returncode == 0 and "pressure" in everything.stdout


def test_a_state_that_is_the_same_is_compared_once_and_fields_where_they_differ_most(results: Path) -> None:
    done = call("compare", results / "a.h5", results / "b.h5", "--json")
    rows = {row["name"]: row for row in json.loads(done.stdout)["rows"]}
    assert (done.returncode, json.loads(done.stdout)["within"]) == (6, False) and "quantities are outside 1e-06" in done.stderr
    assert [rows[name]["within"] for name in ("Q_F_W", "hertz_a_mm")] == [False, True]
    assert not [name for name in rows if name.startswith("isothermal.")]
    a, b = (read_result(results / f"{name}.h5") for name in "ab")
    distance = np.abs(a.coupled.fields["shear_x"] - b.coupled.fields["shear_x"])
    i, j = np.unravel_index(distance.argmax(), distance.shape)
    shear = rows["shear_x"]
    assert (shear["a"], shear["b"]) == (a.coupled.fields["shear_x"][i, j], b.coupled.fields["shear_x"][i, j])
    assert shear["note"] == f"at x = {1e3 * a.x[i]:.3g}, y = {1e3 * a.y[j]:.3g} mm"
    assert rows["pressure"]["note"] == "largest magnitudes" and rows["pressure"]["difference"] == 0.0


def test_opposite_creepages_differ_by_opposite_values(results: Path, tmp_path: Path) -> None:
    for name, creepage in (("forwards", "0.003"), ("backwards", "-0.003")):
        settings = ("--set", f"creepage.longitudinal={creepage}", "--no-plots", "-q", "-o", tmp_path / name)
        assert call("run", results / "a.toml", *settings).returncode == 0
    done = call("compare", tmp_path / "forwards" / "a.h5", tmp_path / "backwards" / "a.h5")
    first, second, difference = next(line.split()[1:4] for line in done.stdout.splitlines() if line.startswith("  shear_x "))
    assert float(first) == -float(second) and float(difference) == 2.0
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_several_formats_are_written_by_one_command(results: Path, tmp_path: Path) -> None:
    done = call("export", results / "a.h5", "--format", "xdmf", "--format", "csv", "--format", "csv", "-o", tmp_path)
    names = ("a.xdmf", "a_points.hdf5", "a.csv")
    assert (done.returncode, done.stdout.split()) == (0, [str(tmp_path / name) for name in names])


def test_sweeps_are_drawn_again_from_either_table(tmp_path: Path) -> None:
    """With theories beside the creep forces, on request; CSV has no title."""
    case = tmp_path / "creep.toml"
    case.write_text(MECHANICAL)
    over = ("--over", "creepage.longitudinal=0.0005,0.004", "--columns", "force_x_N")
    done = call("sweep", case, *over, "--scalars-only", "-o", tmp_path, "--compare", "linear,polach,fastsim", "--format", "svg",
                painted=True)
    assert done.returncode == 0, done.stderr
    assert call("sweep", case, *over, "-o", tmp_path, "--compare", "contact").returncode == 2
    theories = ("Kalker's linear theory", "FASTSIM", "Polach")
    first = (tmp_path / "sweep.svg").read_text()
    assert all(words in first for words in theories)
    (tmp_path / "sweep.svg").unlink()
    done = call("plot", tmp_path / "sweep.h5", "--compare", "linear,polach,fastsim", "--format", "svg", *over[2:], painted=True)
    assert done.returncode == 0
    assert (tmp_path / "sweep.svg").read_text() == first
    assert call("plot", tmp_path / "sweep.csv", "--compare", "linear", "--format", "svg", painted=True).returncode == 0
    shown = (tmp_path / "sweep.svg").read_text()
    assert [words in shown for words in theories] == [True, False, False]


def test_several_sweeps_or_results_are_drawn_over_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "spheres.toml").write_text(MECHANICAL.replace("grid = 16", "grid = 8"))
    pictures: list[Figure] = []
    monkeypatch.setattr(plot_style, "save", lambda figure, path, dpi=None: pictures.append(figure) or path)
    for name, friction in (("dry", "0.4"), ("wet", "0.1")):
        over = ("--over", "load.normal_N=50,65,80", "--set", f"load.friction_coefficient={friction}")
        assert call("sweep", tmp_path / "spheres.toml", *over, "-o", tmp_path / name, "--no-plots", "-q").returncode == 0
    both = [tmp_path / name / "sweep.csv" for name in ("dry", "wet")]
    done = call("plot", *both, "--over", "--columns", "force_x_N", "-o", tmp_path)
    assert (done.returncode, done.stdout.strip()) == (0, str(tmp_path / "sweep_over.png"))
    columns = [read_table(path) for path in both]
    drawn = [list(line.get_ydata()) for line in pictures[0].axes[0].lines]
    assert drawn == [list(table["force_x_N"]) for table in columns] and drawn[0] != drawn[1]
    assert [text.get_text() for text in pictures[0].legends[0].get_texts()] == ["dry", "wet"]
    results = [tmp_path / name / "spheres_0001.h5" for name in ("dry", "wet")]
    assert call("plot", *results, "--over", "-o", tmp_path).returncode == 0
    assert [text.get_text() for text in pictures[1].legends[0].get_texts()] == ["dry", "wet"]
    peaks = [max(line.get_ydata()) for line in pictures[1].axes[1].lines]
    assert peaks[0] > 1.5 * peaks[1]
    for file, option in ((results[0], ("--x", "load.normal_N")), (results[0], ("--compare", "linear")),
                         (both[0], ("--cut-y", "0")), (both[0], ("--normalised",))):
        unused = call("plot", file, *option, "-o", tmp_path / "unused")
        assert unused.returncode == 2 and "of which this option draws nothing" in " ".join(unused.stderr.split())
    mixed = call("plot", results[0], both[0], "--over", "-o", tmp_path)
    assert mixed.returncode == 2 and "several results of contacts, or several tables" in mixed.stderr

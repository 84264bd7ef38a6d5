"""A heated contact that has moved, through the whole program: each state has points of its own in files and pictures."""

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.support.command_line import call
from thermoroll_cli.files.result.outcome import read_result

CASE = Path(__file__).parents[2] / "cases" / "article_4_1.toml"
SETTINGS = ("--set", "rolling.speed_m_s=600", "--set", "numerics.grid=24")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("followed")
    done = call("run", CASE, *SETTINGS, "--json", "-q", "-o", path)
    assert done.returncode == 0, done.stderr
    (path / "told.json").write_text(done.stdout)
    return path


def test_what_is_told(folder: Path) -> None:
    told = json.loads((folder / "told.json").read_text())
    left, right, low, high = told["work"]["domain_coupled_mm"]
    assert left + right > 0.05 and low == pytest.approx(-high)
    assert any("has followed the heated contact" in warning for warning in told["warnings"])
    stored = read_result(folder / "article_4_1.h5")
    assert stored.own_grids
    dx = stored.x[1] - stored.x[0]
    assert 1e3 * (stored.x[0] - 0.5 * dx) == pytest.approx(left) and 1e3 * (stored.x[-1] + 0.5 * dx) == pytest.approx(right)
    assert stored.isothermal.x == pytest.approx(-stored.isothermal.x[::-1])
    assert {p.name for p in folder.glob("*.png")} >= {"article_4_1_summary.png", "article_4_1_temperature.png"}


def test_each_state_carries_the_load_on_its_own_grid(folder: Path) -> None:
    with h5py.File(folder / "article_4_1.h5") as file:
        for group in ("fields", "isothermal/fields"):
            x, y, pressure = (file[f"{group}/{name}"][()] for name in ("x", "y", "pressure"))
            assert pressure.sum() * (x[1] - x[0]) * (y[1] - y[0]) == pytest.approx(65.0, rel=1e-6)
            assert file[f"{group}/pressure"].dims[0][0] == file[f"{group}/x"]


def test_exports_have_both_sets_of_points(folder: Path) -> None:
    stored = read_result(folder / "article_4_1.h5")
    done = call("export", folder / "article_4_1.h5", "--format", "csv")
    written = [Path(line) for line in done.stdout.splitlines()]
    assert [path.name for path in written] == ["article_4_1.csv", "article_4_1_isothermal.csv"]
    columns = ("pressure_MPa", "isothermal_pressure_MPa")
    for path, state, column in zip(written, (stored.coupled, stored.isothermal), columns, strict=True):
        x, field = state.x, state.fields["pressure"]
        table = np.genfromtxt(path, delimiter=",", names=True)
        np.testing.assert_allclose(table["x_mm"][:: len(x)], 1e3 * x, rtol=1e-8, atol=1e-12)
        np.testing.assert_allclose(table[column], 1e-6 * field.ravel(), rtol=1e-8)
    assert call("export", folder / "article_4_1.h5", "--format", "xdmf").returncode == 0
    grids = ElementTree.parse(folder / "article_4_1.xdmf").findall(".//Grid")
    assert [grid.get("Name") for grid in grids] == ["contact", "contact without thermal deformation"]
    for grid, x in zip(grids, (stored.x, stored.isothermal.x), strict=True):
        where = [str(item.text).split(":") for item in grid.iter("DataItem") if item.get("Format") == "HDF"]
        for name, place in where:
            with h5py.File(folder / name) as file:
                assert place in file
        with h5py.File(folder / where[0][0]) as file:
            np.testing.assert_allclose(file[where[0][1]][:, 0, 0], x, rtol=1e-6)


def test_compare_tells_which_grids_differ(folder: Path, tmp_path: Path) -> None:
    mine = folder / "article_4_1.h5"
    assert call("compare", mine, mine).returncode == 0
    slower = ("--set", "rolling.speed_m_s=350", "--set", "numerics.grid=24")
    assert call("run", CASE, *slower, "--no-plots", "-q", "-o", tmp_path).returncode == 0
    done = call("compare", mine, tmp_path / "article_4_1.h5", "--rtol", "0.5")
    words = " ".join((done.stdout + done.stderr).split())
    assert "fields not compared: different grids" in words and "about x = " in words
    assert "isothermal.heat_flux" in " ".join(call("compare", mine, tmp_path / "article_4_1.h5").stdout.split())

"""The table [subsurface] through the real entry point: errors, files, exports, sweeps, comparison, pictures."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

from tests.support.command_line import MECHANICAL, THERMAL, call
from tests.support.errors import relative
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.plots.pictures import KINDS, draw, figure
from thermoroll_cli.problem.names import BOND_SCALARS, STRENGTH_SCALARS, SUBSURFACE_FIELDS, SUBSURFACE_SCALARS

TABLE = "[subsurface]\nlayers = 16\nfields = {}\n"


def written(folder: Path, text: str, name: str = "spheres") -> Path:
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with everything in it."""
    folder = tmp_path_factory.mktemp("full")
    done = call("run", written(folder, THERMAL + TABLE.format('"full"')), "-o", folder, "--no-plots")
    assert done.returncode == 0
    assert "von_mises_max_lower_MPa" in done.stdout
    return folder / "spheres.h5"


def test_an_empty_table_is_a_wish() -> None:
    """All defaults; the resolved case keeps it, and a case without the table stays without."""
    case = Case.parse(MECHANICAL + "[subsurface]\n")
    assert case.problem.subsurface is not None
    assert Case.parse(case.to_toml()).problem == case.problem
    assert Case.from_json(case.to_json()).problem == case.problem
    assert Case.parse(MECHANICAL).problem.subsurface is None
    deeper = case.with_values({"subsurface.depth_mm": 0.5, "subsurface.bodies": ["upper"]}).problem.subsurface
    assert (deeper.depth, deeper.bodies) == (0.5e-3, ("upper",))


@pytest.mark.slow
def test_hdf5_and_xarray(full: Path) -> None:
    """Layers as chunks, in single precision, with coordinates; read back as they were written."""
    with h5py.File(full) as file:
        dataset = file["lower/stress_xz"]
        assert dataset.dtype == np.float32
        assert dataset.shape == (16, 16, 16)
        assert dataset.chunks == (1, 16, 16)
    with xarray.open_dataset(full, group="upper", engine="h5netcdf") as body:
        assert body.von_mises.dims == ("z", "x", "y")
        assert body.von_mises.units == "Pa"
        assert float(body.z[0]) == 0.0
        assert set(SUBSURFACE_FIELDS) <= set(body.data_vars)
        assert body.plane_temperature_rise.dims == ("z", "x")
    stored = read_result(full)
    assert set(stored.bodies) == {"lower", "upper"}
    assert SUBSURFACE_SCALARS.keys() - STRENGTH_SCALARS.keys() - BOND_SCALARS.keys() <= stored.summary().keys()
    lower = stored.bodies["lower"]
    assert lower.most_stressed.value == pytest.approx(stored.summary()["von_mises_max_lower_MPa"] * 1e6)
    assert lower.fields["von_mises"].max() <= lower.most_stressed.value * (1.0 + 1e-6)
    assert relative(stored)["von_mises_max_lower_MPa"] < 0.1


@pytest.mark.slow
def test_json_and_show(tmp_path: Path) -> None:
    case = written(tmp_path, MECHANICAL + TABLE.format('"plane"') + 'bodies = ["lower"]\n')
    record = json.loads(call("run", case, "-o", tmp_path, "--json", "--no-plots").stdout)
    names = [name for name in record if "von_mises" in name]
    assert "von_mises_max_lower_MPa" in names
    assert not any("upper" in name for name in names)
    assert record["uncertainty"]["von_mises_depth_lower_mm"] > 0.0
    assert "below the surface" in record["work"]["seconds"]
    shown = json.loads(call("show", case, "--json").stdout)
    without = json.loads(call("show", written(tmp_path, MECHANICAL, "plain"), "--json").stdout)
    assert "below the surface" in shown["run"]
    assert shown["subsurface_layers"] == 16
    assert shown["memory_bytes"] > without["memory_bytes"]
    assert shown["seconds"] > without["seconds"]


def test_stress_path(full: Path, tmp_path: Path) -> None:
    """A line along x: at a layer and a row the stored values, in between smooth ones; outside an error."""
    stored = read_result(full)
    body = stored.bodies["upper"]
    layer, row = 3, 9
    where = f"{float(stored.y[row] * 1e3)!r},{float(body.depths[layer] * 1e3)!r}"
    assert call("export", full, "--format", "csv", "--stress-path", where, "-o", tmp_path).returncode == 0
    with open(tmp_path / "spheres_stress_path.csv") as stream:
        every = list(csv.DictReader(stream))
    places = np.array([float(r["x_mm"]) for r in every])
    first = int(np.argmin(np.abs(places - stored.x[0] * 1e3)))
    rows = every[first : first + 16]
    assert (np.diff(places) > 0.0).all() and places[0] < 50.0 * stored.x[0] * 1e3
    equivalent = [float(r["upper_von_mises_elastic_MPa"]) for r in every]
    assert max(equivalent[0], equivalent[-1]) < 1e-3 * max(equivalent)
    assert float(every[-1]["upper_temperature_rise_K"]) > 0.0  # the wake of heat
    got = [float(r["upper_stress_xz_MPa"]) for r in rows]
    np.testing.assert_allclose(got, body.fields["stress_xz"][layer, :, row] * 1e-6, rtol=1e-6, atol=1e-9)
    assert float(rows[-1]["time_s"]) - float(rows[0]["time_s"]) == pytest.approx(np.ptp(stored.x) / 1.0)
    assert float(rows[5]["lower_temperature_rise_K"]) == pytest.approx(
        float(stored.bodies["lower"].fields["temperature_rise"][layer, 5, row]), rel=1e-5)  # fmt: skip
    for wrong, words in (("0,9", "outside"), ("9,0", "outside"), ("0", "not Y,Z"), ("a,b", "not Y,Z")):
        done = call("export", full, "--format", "csv", "--stress-path", wrong)
        assert done.returncode == 2
        assert words in done.stderr
    assert call("export", full, "--format", "xdmf", "--stress-path", "0,0").returncode == 2


@pytest.mark.slow
@pytest.mark.parametrize("body", [pytest.param(THERMAL, marks=pytest.mark.slow), MECHANICAL + """
[[material.lower.layers]]
thickness_um = 20.0
youngs_modulus_GPa = 400.0
poisson_ratio = 0.25
"""], ids=["heat", "coating"])
def test_history_outside_the_domain_is_that_of_a_wider_one(tmp_path: Path, body: str) -> None:
    lines = {}
    for name, wide in (("narrow", 1), ("wide", 2)):
        text = body.replace("grid = 16", f"grid = {24 * wide}\nextent = {2.2 * wide}") + TABLE.format('"plane"')
        text += "bodies = ['lower']\ndepth_mm = 0.2\n"
        assert call("run", written(tmp_path, text, name), "-o", tmp_path, "--no-plots", "-q").returncode == 0
        where = ("--stress-path", "0,0.1", "-o", tmp_path)
        assert call("export", tmp_path / f"{name}.h5", "--format", "csv", *where).returncode == 0
        with open(tmp_path / f"{name}_stress_path.csv") as stream:
            rows = list(csv.DictReader(stream))
        lines[name] = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    x, limit = lines["narrow"]["x_mm"], read_result(tmp_path / "wide.h5").x[-1] * 1e3
    outside = (np.abs(x) < limit) & (np.abs(x) > read_result(tmp_path / "narrow.h5").x[-1] * 1e3)
    assert outside.sum() >= 6
    for key, values in lines["narrow"].items():
        if "stress" in key or "temperature" in key:
            truth = np.interp(x, lines["wide"]["x_mm"], lines["wide"][key])
            assert np.abs(values - truth)[outside].max() < 0.015 * np.abs(lines["wide"][key]).max() + 1e-9, key


def test_stress_path_on_the_kept_plane_only(tmp_path: Path) -> None:
    case = written(tmp_path, MECHANICAL + TABLE.format('"plane"'))
    plain = written(tmp_path, MECHANICAL, "plain")
    assert call("run", case, plain, "-o", tmp_path, "--no-plots", "-q").returncode == 0
    assert call("export", tmp_path / "spheres.h5", "--format", "csv", "--stress-path", "0,0.05").returncode == 0
    done = call("export", tmp_path / "spheres.h5", "--format", "csv", "--stress-path", "0.1,0.05")
    assert done.returncode == 5
    assert 'fields = "full"' in done.stderr
    assert call("export", tmp_path / "plain.h5", "--format", "csv", "--stress-path", "0,0.05").returncode == 5


def test_xdmf_shows_both_bodies(full: Path, tmp_path: Path) -> None:
    assert call("export", full, "--format", "xdmf", "--format", "vtu", "-o", tmp_path).returncode == 0
    grids = ElementTree.parse(tmp_path / "spheres.xdmf").getroot().findall("Domain/Grid")
    assert [grid.get("Name") for grid in grids] == ["contact", "lower body", "upper body"]
    for grid, sign in zip(grids[1:], (-1.0, 1.0), strict=True):
        assert grid.find("Topology").get("Dimensions") == "16 16 16"
        for item in grid.iter("DataItem"):
            name, inside = item.text.split(":")
            with h5py.File(tmp_path / name) as file:
                assert file[inside].shape == tuple(int(side) for side in item.get("Dimensions").split())
        name, inside = grid.find("Geometry/DataItem").text.split(":")
        with h5py.File(tmp_path / name) as file:
            assert sign * file[inside][-1, 0, 0, 2] == pytest.approx(read_result(full).bodies["lower"].depths[-1], rel=1e-6)
            assert file[inside][0, 3, 0, 0] == pytest.approx(read_result(full).x[3], rel=1e-6)
    body = read_result(full).bodies["lower"]
    arrays = {array.get("Name"): np.array(array.text.split(), float)
              for array in ElementTree.parse(tmp_path / "spheres_lower.vtu").iter("DataArray")}
    np.testing.assert_array_equal(arrays["stress_xx"], body.fields["stress_xx"].ravel())
    corners = arrays["points"].reshape(-1, 3)[arrays["connectivity"].astype(int).reshape(-1, 8)]
    # The last layer lies deepest, at z < 0; the volumes fill the domain.
    assert corners[..., 2].min() == -body.depths[-1]
    edges = np.abs(corners[:, 6] - corners[:, 0])
    whole = np.ptp(arrays["points"].reshape(-1, 3), axis=0)
    assert edges.prod(axis=1).sum() == pytest.approx(whole.prod(), rel=1e-9)


def test_pictures(full: Path, tmp_path: Path) -> None:
    """One for each body, from the file as from the result; none where nothing was asked for."""
    result = read_result(full)
    for normalised in (False, True):
        picture = figure(result, "subsurface_lower", normalised=normalised)
        assert picture is not None
        labels = [axes.get_ylabel() for axes in picture.axes]
        assert any("temperature rise" in label for label in labels) and any("von Mises" in label for label in labels)
        assert picture.axes[0].get_ylim()[0] > picture.axes[0].get_ylim()[1], "z points into the body"
    (path,) = draw(result, tmp_path / "full", kinds=["subsurface_lower"])
    assert path.name == "full_subsurface_lower.png" and path.stat().st_size > 20_000
    without = replace(result, subsurface=None)
    assert figure(without, "subsurface_lower") is None
    axes = Figure().add_subplot()
    result.plot("subsurface_lower", ax=axes)
    place, *_ = axes.get_lines()
    body = result.bodies["lower"]
    assert place.get_ydata()[0] / axes.get_ylim()[0] == pytest.approx(body.most_stressed.z / body.depths[-1])
    with pytest.raises(ValueError, match=r"no table \[subsurface\]"):
        without.plot("subsurface_lower", ax=axes)
    assert {f"subsurface_{body}" for body in ("lower", "upper")} <= set(KINDS)

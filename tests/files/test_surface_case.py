"""Surfaces in case files: what is made and read, what is refused and how it is said."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from thermoroll_cli import Case
from thermoroll_cli.files.case_errors import CaseError
from thermoroll_cli.many_contacts.history.history_plan import warnings_of
from thermoroll_cli.problem.surface import Dent, Flat, MeasuredHeights, Sum, Wave

BALL: dict[str, Any] = {
    "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.3},
    "geometry": {"lower_radius_x_mm": math.inf, "lower_radius_y_mm": math.inf, "upper_radius_x_mm": 10.0,
                 "upper_radius_y_mm": 10.0},
    "load": {"normal_N": 100.0, "friction_coefficient": 0.1}, "rolling": {"speed_m_s": 1.0},
    "history": {"distance_mm": [0.0, 0.3], "steps": 10, "values": {"creepage.longitudinal": [0.001, 0.001]}},
    "numerics": {"grid": 32},
}  # fmt: skip
ROUGH = {"kind": "rough", "rms_um": 0.1, "shortest_mm": 0.03, "longest_mm": 0.3}


def with_surface(changes: dict[str, Any] | None = None, **bodies: Any) -> dict[str, Any]:
    content = copy.deepcopy(BALL) | {"surface": bodies}
    for table, keys in (changes or {}).items():
        content[table] = content.get(table, {}) | keys if keys is not None else None
    return content


def surfaces(**bodies: Any) -> Any:
    return Case.from_dict(with_surface(**bodies)).task.surfaces


def test_made_surfaces() -> None:
    """Units, the defaults of each kind, sums, and roughness with its numbers."""
    lower, upper = surfaces(
        lower={"kind": "wave", "amplitude_um": 0.5, "wavelength_mm": 0.2, "angle_deg": 90.0, "start_mm": 0.1},
        upper=[{"kind": "dent", "depth_um": 2.0, "radius_mm": 0.05, "offset_mm": 0.01},
               {"kind": "flat", "length_mm": 0.4, "repeat": True}])  # fmt: skip
    assert lower == Wave(0.5e-6, 0.2e-3, math.pi / 2.0, 0.1e-3)
    assert upper == Sum((Dent(2e-6, 0.05e-3, side=0.01e-3), Flat(0.4e-3, 10e-3, 0.04e-3, turn=2.0 * math.pi * 10e-3)))
    (rough, other), (again, _) = (surfaces(lower=ROUGH, upper=ROUGH | {"seed": 2}) for _ in range(2))
    assert isinstance(rough, MeasuredHeights) and rough.repeats == (True, True)
    np.testing.assert_array_equal(rough.heights, again.heights)
    assert not np.allclose(rough.heights, other.heights)
    texture = rough.texture
    assert texture.rms == pytest.approx(0.1e-6)
    assert texture.shortest == pytest.approx(0.03e-3, rel=0.06)
    # PSD ~ k^(−2−2H): a decade of its waves has 10^(2H) times the power of the next one.
    k = np.hypot(*texture.waves)
    power, octave = texture.power / k**2, 2.0 * math.pi / 0.24e-3 * 2.0 ** np.arange(3)
    inside = [power[(k >= low) & (k < 2.0 * low)].sum() for low in octave]
    np.testing.assert_allclose(np.log2(np.divide(inside[:-1], inside[1:])), 1.6, atol=0.35)
    ground = surfaces(lower=ROUGH | {"lay_angle_deg": 90.0, "lay_ratio": 5.0})[0].texture
    along, across = (np.sqrt((ground.power * (part / np.hypot(*ground.waves)) ** 2).sum()) for part in ground.waves)
    assert 3.0 < along / across < 8.0  # waves across the lay are shorter: ground along y, it is rough along rolling


@pytest.mark.parametrize("written", ["npy", "npz", "csv", "txt", "columns", "columns without some"])
def test_files_of_heights(tmp_path: Path, written: str) -> None:
    """Each way to write the same heights gives the same points; missing ones are filled in where that is asked for."""
    heights = np.random.default_rng(3).normal(size=(12, 7))
    table: dict[str, Any] = {"spacing_um": [2.0, 3.0], "remove": "none"}
    path = tmp_path / f"heights.{written.split()[0]}"
    if written == "npy":
        np.save(path, heights)
    elif written == "npz":
        np.savez(path, heights=heights, other=np.zeros(3))
    elif written == "csv":
        path.write_text("\n".join(";".join(f"{value:.12g}".replace(".", ",") for value in row) for row in heights))
    elif written == "txt":
        np.savetxt(path, heights, header="heights in µm")
    else:
        table.pop("spacing_um")
        x, y = np.meshgrid(2e-3 * np.arange(12) + 5.0, 3e-3 * np.arange(7), indexing="ij")
        rows = np.stack([x, y, heights], axis=-1).reshape(-1, 3)
        if "without" in written:
            rows = np.delete(rows, 33, axis=0)
            table["fill"] = "interpolate"
            heights[33 // 7, 33 % 7] = np.nan
        rows = np.random.default_rng(4).permutation(rows)
        path.write_text("x y h\n" + "\n".join(" ".join(map(repr, row.tolist())) for row in rows))
    surface = surfaces(lower={"file": str(path)} | table)[0]
    known = np.isfinite(heights)
    np.testing.assert_allclose(surface.heights[known], 1e-6 * heights[known], rtol=1e-9)
    assert np.isfinite(surface.heights).all()
    assert surface.spacing == pytest.approx((2e-6, 3e-6))
    assert surface.side == pytest.approx(-9e-6)  # its middle lies at y = 0


def test_what_is_filled_in_is_told_and_has_a_limit(tmp_path: Path) -> None:
    """A twentieth of the points may lack a height; more of them is a warning, more than half an error."""
    heights, path = np.random.default_rng(5).normal(size=(20, 20)), tmp_path / "spots.npy"
    table = {"file": str(path), "spacing_um": 5.0, "fill": "interpolate"}
    for count, told in ((20, False), (21, True), (200, True)):
        heights.flat[:count] = np.nan
        np.save(path, heights)
        words = f"{100.0 * count / 400:.3g} % of the points of the lower surface had no height"
        history = Case.from_dict(with_surface(lower=table)).task
        assert any(warning.startswith(words) for warning in warnings_of(history)) == told
    heights.flat[200] = np.nan
    np.save(path, heights)
    with pytest.raises(CaseError, match=r"spots.npy: 50.2 % of its 400 points have no height") as caught:
        surfaces(lower=table)
    assert caught.value.findings[0].key == "surface.lower.file" and "at most 50 %" in caught.value.findings[0].hint


def test_heights_are_turned_levelled_and_smoothed(tmp_path: Path) -> None:
    x, y = 1e-6 * np.arange(200)[:, None], 1e-6 * np.arange(80)
    wave = 0.2e-6 * np.cos(2.0 * np.pi * x / 20e-6) * np.ones(80)
    np.save(tmp_path / "tilted.npy", 1e9 * (wave + 3e-3 * x - 2e-3 * y + 5e-6))
    table = {"file": str(tmp_path / "tilted.npy"), "spacing_um": 1.0, "unit": "nm"}
    level = surfaces(lower=table)[0].heights
    np.testing.assert_allclose(level, wave - wave.mean(), atol=4e-9)
    turned = surfaces(lower=table | {"along": "y", "flip": True, "mirror": True, "remove": "none"})[0].heights
    raw = surfaces(lower=table | {"remove": "none"})[0].heights
    np.testing.assert_allclose(turned, -raw.T[:, ::-1])
    smooth = surfaces(lower=table | {"smoothing_mm": 0.02})[0].heights
    assert np.ptp(smooth[60:140]) == pytest.approx(0.5 * np.ptp(level[60:140]), rel=0.02)
    bowl = surfaces(lower=table | {"remove": "polynomial", "degree": 2})[0].heights
    assert abs(bowl.mean()) < 1e-12


@pytest.mark.parametrize(("content", "key", "words"), [
    (np.full((4, 4), np.nan), "file", "no point has a height"),
    (np.where(np.eye(4) > 0, np.nan, 0.0), "file", "25 % of its 16 points"),
    (np.zeros((1, 9)), "file", "is no surface"), (np.zeros((3, 3, 3)), "file", "is no surface"),
    (np.array([[1e12, 0.0], [0.0, -1e12], [1e12, 1e12]]), "file", "unit"), (np.array([["a", "b"]]), "file", "no numbers"),
    (b"hello\nworld\n", "file", "no numbers"), (b"", "file", "no heights"), (b"1 2 3\n4 5\n", "file", "2 values"),
    (b"0 0 1\n1 0 1\n3 0.3 1\n3.5 1 1\n", "file", "regular grid"), (b"PK\x03\x04\x00", "file", "instrument"),
    (b"1 2\n3 4\n", "file", "spacing_um"), (None, "file", "o such file"),
    (b"\\*File list\n\\Version: 0x07200000\n", "file", "instrument"),
])  # fmt: skip
def test_hostile_files(tmp_path: Path, content: Any, key: str, words: str) -> None:
    # A microscope's file begins with lines of text.
    path = tmp_path / ("s.npy" if isinstance(content, np.ndarray) else "s.spm" if content and b"*File" in content else "s.txt")
    if isinstance(content, np.ndarray):
        np.save(path, content)
    elif content is not None:
        path.write_bytes(content)
    table = {"file": str(path), **({"spacing_um": 1.0} if isinstance(content, np.ndarray) else {})}
    with pytest.raises(CaseError) as caught:
        surfaces(upper=table)
    finding = caught.value.findings[0]
    assert finding.key == f"surface.upper.{key}"
    assert path.name in str(caught.value) and words in f"{finding.message} {finding.hint} {finding.allowed}"


def test_a_case_with_surfaces_is_shown_and_comes_back(tmp_path: Path) -> None:
    """Numbers of each surface, warnings with what would do, and the same case from its resolved text."""
    np.save(tmp_path / "ground.npy", np.random.default_rng(5).normal(size=(64, 64)))
    content = with_surface(lower={"file": str(tmp_path / "ground.npy"), "spacing_um": 5.0}, upper=[ROUGH, ROUGH])
    case = Case.from_dict(content)
    assert Case.parse(case.to_toml()) == case and Case.from_json(case.to_json()) == case
    (tmp_path / "case.toml").write_text(case.to_toml())
    shown = call("show", tmp_path / "case.toml", "--json")
    record = json.loads(shown.stdout)
    assert list(record["surfaces"]) == ["surface.lower", "surface.upper.0", "surface.upper.1"]
    assert record["surfaces"]["surface.upper.0"]["rms_um"] == pytest.approx(0.1)
    assert record["surfaces"]["surface.lower"]["points"] == [64, 64]
    elements, steps = (next(line for line in record["warnings"] if line.startswith(start) and "lower" in line)
                       for start in ("elements", "steps"))
    assert "numerics.grid = " in elements and "history.steps = " in steps
    assert "rms slope" in call("show", tmp_path / "case.toml").stdout
    # A journal has the case with the checksum, so that --resume notices other heights.
    np.save(tmp_path / "ground.npy", np.zeros((64, 64)))
    assert Case.from_dict(content).to_json() != case.to_json()
    with pytest.raises(CaseError, match="has changed") as caught:
        Case.parse(case.to_toml())
    assert [finding.key for finding in caught.value.findings] == ["surface.lower.0.checksum"]


SDF = (Path(__file__).parents[1] / "reference" / "synthetic_profiles" / "header.sdf").read_text()


@pytest.mark.parametrize("ending", ["sdf", "xyz", "x3p", "nc"])
def test_files_of_instruments(tmp_path: Path, ending: str) -> None:
    """Units and spacing are those of the file; that of the upper body is mirrored unless the case says otherwise."""
    library = pytest.importorskip("SurfaceTopography")
    heights, path = 1e-6 * np.random.default_rng(6).normal(size=(20, 12)), tmp_path / f"measured.{ending}"
    table: dict[str, Any] = {"file": str(path), "remove": "none"}
    if ending == "sdf":
        rows = (" ".join(f"{1e12 * value:.0f}" for value in row) for row in heights.T)
        path.write_text(SDF + "\n".join(rows) + "\n*\n")
    elif ending == "xyz":
        x, y = np.meshgrid(2.0 * np.arange(20), 3.0 * np.arange(12), indexing="ij")
        np.savetxt(path, np.stack([x, y, 1e6 * heights], axis=-1).reshape(-1, 3))
        table["unit"] = "um"  # which such a file does not tell
    else:
        measured = library.Topography(heights, (40e-6, 36e-6), unit="m")
        measured.to_x3p(path) if ending == "x3p" else measured.to_netcdf(str(path))
    lower, upper = surfaces(lower=table, upper=table)
    np.testing.assert_allclose(lower.heights, heights, atol=1e-12)
    assert lower.spacing == pytest.approx((2e-6, 3e-6), rel=1e-6)
    np.testing.assert_array_equal(upper.heights, lower.heights[:, ::-1])
    np.testing.assert_array_equal(surfaces(upper=table | {"mirror": False})[1].heights, lower.heights)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(CaseError, match=path.name):
        surfaces(lower=table)

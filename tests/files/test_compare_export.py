"""Differences between two results, and what other programs get to see of them."""

from __future__ import annotations

import csv
import dataclasses
import math
import os
import pathlib
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

from tests.support import synthetic
from tests.support.command_line import call
from thermoroll_cli.files.result.compare import Comparison, Pair, compare, compare_tables
from thermoroll_cli.files.result.export import export_csv, export_vtu, export_xdmf
from thermoroll_cli.files.result.labelled import save
from thermoroll_cli.files.result.outcome import read_result, tree_of, write_result
from thermoroll_cli.files.table_file import HISTORY, tree_of_table, write_csv
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.names import PROBLEM_SCALARS, SCALARS
from thermoroll_cli.problem.result import BodyStresses, Peak, Result, Subsurface


def compare_results(a: Result, b: Result, rtol: float = 1e-6) -> Comparison:
    return compare(tree_of(a), tree_of(b), rtol)


def stored(path: pathlib.Path, result: Result) -> Result:
    write_result(path, result)
    return read_result(path)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return tmp_path_factory.mktemp("a") / "a.h5"


@pytest.fixture(scope="module")
def reference(path: pathlib.Path) -> Result:
    return stored(path, synthetic.result((20, 16)))


def with_scalars(result: Result, **scalars: float) -> Result:
    hertz = {name: scalars.pop(name) for name in PROBLEM_SCALARS if name in scalars}
    coupled = dataclasses.replace(result.coupled, scalars={**result.coupled.scalars, **scalars})
    return dataclasses.replace(result, coupled=coupled, of_problem={**result.of_problem, **hertz})


def with_field(result: Result, name: str, values: np.ndarray) -> Result:
    coupled = dataclasses.replace(result.coupled, fields={**result.coupled.fields, name: values})
    return dataclasses.replace(result, coupled=coupled)


def row(comparison: Comparison, name: str) -> Pair:
    return next(row for row in comparison.rows if row.name == name)


def test_a_result_is_equal_to_itself(reference: Result) -> None:
    comparison = compare_results(reference, reference, rtol=0.0)
    assert comparison.within and comparison.largest == 0.0 and not comparison.notes
    names = [row.name for row in comparison.rows]
    assert len(names) == len(set(names))
    assert (set(SCALARS) | set(PROBLEM_SCALARS)) & set(reference.summary()) <= set(names)
    assert {"isothermal." + name for name in reference.isothermal.scalars} <= set(names)
    assert {"pressure", "isothermal.pressure", "status"} <= set(names)


def test_scalars_are_compared_relatively(reference: Result) -> None:
    changed = with_scalars(reference, gamma_p=reference.coupled.scalars["gamma_p"] * 1.001)
    comparison = compare_results(reference, changed, rtol=1e-4)
    assert [row.name for row in comparison.outside] == ["gamma_p"]
    assert row(comparison, "gamma_p").difference == pytest.approx(1e-3, rel=1e-2)
    assert compare_results(reference, changed, rtol=1.1e-3).within
    assert not compare_results(reference, dataclasses.replace(reference, converged=False)).within


def test_a_scalar_that_only_one_file_names_is_told_and_does_not_count(reference: Result) -> None:
    """As between files of two versions of the program; one that was not computed is another matter."""
    scalars = {k: v for k, v in reference.coupled.scalars.items() if k != "gamma_st"}
    older = dataclasses.replace(reference, coupled=dataclasses.replace(reference.coupled, scalars=scalars))
    for one, other, side in ((reference, older, "second"), (older, reference, "first")):
        comparison = compare_results(one, other)
        assert comparison.within and comparison.largest == 0.0
        assert f"not compared, missing in the {side} file: gamma_st" in comparison.notes
    assert not compare_results(reference, with_scalars(reference, gamma_st=math.nan)).within


def test_rounding_noise_of_a_vanishing_component_is_no_difference(reference: Result) -> None:
    one, other = (with_scalars(reference, force_y_N=noise, spin_moment_Nmm=noise) for noise in (1e-15, -3e-16))
    assert compare_results(one, other, rtol=1e-12).within
    shaken = with_field(reference, "shear_y", reference.coupled.fields["shear_y"] + 1e-3)
    assert compare_results(reference, shaken, rtol=1e-9).within


def test_nan_equals_nan_and_nothing_else(reference: Result) -> None:
    hole = with_scalars(reference, Q_F_W=math.nan)
    assert compare_results(hole, hole).within
    assert row(compare_results(hole, reference), "Q_F_W").difference == math.inf
    values = reference.coupled.fields["pressure"].copy()
    values[3, 3] = math.nan
    holed = with_field(reference, "pressure", values)
    assert compare_results(holed, holed).within
    assert row(compare_results(holed, reference), "pressure").difference == math.inf
    endless = with_scalars(reference, peclet_lower=math.inf)
    assert compare_results(endless, endless).within and not compare_results(endless, reference).within


def test_patches_warnings_and_what_is_unbounded_are_compared(reference: Result) -> None:
    patch = {"y_mm": 1e-17, "normal_N": 50.0, "force_x_N": 1.0, "force_y_N": 1e-15}
    one = dataclasses.replace(reference, patches=(patch,))
    noisy = dataclasses.replace(reference, patches=({**patch, "y_mm": 0.0, "force_y_N": -1e-15},))
    assert compare_results(one, noisy, rtol=1e-12).within
    for change, name in (({"patches": ({**patch, "normal_N": 51.0},)}, "patches.1.normal_N"), ({"patches": ()}, "patches"),
                         ({"warnings": ("a doubt",)}, "warnings"), ({"unbounded": ("gamma_p",)}, "unbounded")):
        other = dataclasses.replace(one, **change)
        assert name in [row.name for row in compare_results(one, other, rtol=1e-3).outside]


def test_stresses_at_other_depths_are_not_compared(reference: Result) -> None:
    def below(factor: float) -> Result:
        depths, line = factor * np.linspace(0.0, 1e-4, 4), {"von_mises": np.full((4, 20), factor)}
        body = BodyStresses(depths, 0.0, line, Peak(1.0, 0.0, 0.0, 0.0), None, {})
        return dataclasses.replace(reference, subsurface=Subsurface({"lower": body}, {}, {}))

    assert compare_results(below(1.0), below(1.0)).within
    assert [row.name for row in compare_results(below(1.0), below(1.01)).outside] == ["subsurface.lower.depths"]


def test_fields_are_compared_by_their_largest_value(reference: Result) -> None:
    values = reference.coupled.fields["pressure"].copy()
    values[10, 8] += 1e-3 * values.max()
    other = with_field(reference, "pressure", values)
    comparison = compare_results(reference, other, rtol=1e-4)
    assert [row.name for row in comparison.outside] == ["pressure"]
    assert row(comparison, "pressure").difference == pytest.approx(1e-3)
    labels = reference.coupled.fields["state"].copy()
    labels[10, 8] = 3 - labels[10, 8]
    other = with_field(reference, "state", labels)
    contact = np.count_nonzero(labels)
    assert row(compare_results(reference, other), "state").difference == pytest.approx(1 / contact)


def test_what_one_side_lacks_is_a_difference(tmp_path: pathlib.Path, reference: Result) -> None:
    cold = stored(tmp_path / "cold.h5", synthetic.result((20, 16), heat=False))
    comparison = compare_results(cold, reference, rtol=10.0)
    assert not comparison.within
    assert row(comparison, "heat_flux").note == "missing in the first file"
    assert row(compare_results(reference, cold), "heat_flux").note == "missing in the second file"
    not_computed = compare_results(with_scalars(cold, Q_F_W=math.nan), reference, rtol=10.0)
    assert row(not_computed, "Q_F_W").difference == math.inf


@pytest.mark.parametrize("change", [{"shape": (24, 16)}, {"extent": 3.0}])
def test_fields_on_different_grids_are_not_compared(
    tmp_path: pathlib.Path, reference: Result, change: dict[str, object]
) -> None:
    other = stored(tmp_path / "b.h5", synthetic.result(**{"shape": (20, 16), **change}))
    comparison = compare_results(reference, other, rtol=0.2)
    assert "fields not compared: different grids (20×16 over" in comparison.notes[0]
    assert math.isnan(row(comparison, "pressure").difference) and row(comparison, "pressure").note
    assert row(comparison, "gamma_c").difference == 0.0
    assert comparison.within


def over_time(count: int = 5, **columns: list[float]) -> Columns:
    """A history whose force passes through zero, of a friction limit of 2 N."""
    times = [0.25 * row for row in range(count)]
    made = {"distance_mm": times, "time_s": times, "status": ["converged"] * count, "force_x_N": [t - 0.5 for t in times],
            "Q_F_W": [t * (1.0 - t) for t in times], "friction_limit_N": [2.0] * count, "uncertainty.Q_F_W": [0.1] * count}
    return Columns({**made, **columns}, ("distance_mm", "time_s"), ("time_s",))


def test_histories_are_compared_over_their_largest_values(tmp_path: pathlib.Path) -> None:
    one = over_time()
    other = over_time(force_x_N=[-0.5, -0.25, 0.002, 0.25, 0.5], Q_F_W=[0.0, 0.1875, 0.25, 0.18, 0.0])
    found = {row.name: row for row in compare_tables(one, other).rows}
    assert found["force_x_N"].difference == pytest.approx(1e-3) and found["force_x_N"].note == "at distance_mm = 0.5"
    assert (found["Q_F_W"].a, found["Q_F_W"].b) == (0.1875, 0.18)
    assert found["Q_F_W"].difference == pytest.approx(0.0075 / 0.25)
    assert not {"uncertainty.Q_F_W"} & {*found} and found["time_s"].difference == 0.0
    sweep = [Columns({"load.normal_N": [1.0, 2.0], "Q_F_W": values}, ("load.normal_N",), ("load.normal_N",))
             for values in ([1.0, 100.0], [1.01, 100.0])]
    assert compare_tables(*sweep).largest == pytest.approx(0.01 / 1.01), "each point of a sweep over its own"
    assert [row.name for row in compare_tables(one, over_time(4)).outside] == ["rows"]
    with pytest.raises(ValueError, match=r"one is over distance_mm, the other over load\.normal_N"):
        compare_tables(one, sweep[0])
    for name, table in (("a", one), ("b", other)):
        write_csv(tmp_path / f"{name}.csv", table)
    assert call("compare", "a.csv", "a.csv", cwd=tmp_path).returncode == 0
    done = call("compare", "a.csv", "b.csv", "--rtol", "0.01", cwd=tmp_path)
    assert done.returncode == 6 and "Q_F_W" in done.stdout and "force_x_N" not in done.stdout
    save(tmp_path / "c.h5", tree_of_table(one), HISTORY)
    assert call("export", "c.h5", "--format", "csv", cwd=tmp_path).returncode == 0
    assert call("compare", "c.h5", "c.csv", "--rtol", "0", cwd=tmp_path).stdout.startswith("all within 0;")
    assert "c.h5 is a table: --format csv writes its rows" in call("export", "c.h5", "--format", "vtu", cwd=tmp_path).stderr


def test_csv_has_a_line_per_point_and_units_in_its_names(tmp_path: pathlib.Path, path: pathlib.Path, reference: Result) -> None:
    export_csv(path, tmp_path / "a.csv")
    with open(tmp_path / "a.csv", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == 20 * 16
    assert {"x_mm", "y_mm", "pressure_MPa", "slip_x_m_s", "state", "heat_flux_W_mm2", "gap_um"} <= set(lines[0])
    assert "isothermal_temperature_rise_lower_K" in lines[0]
    i, j = 13, 5
    line = lines[i * 16 + j]
    assert float(line["x_mm"]) == pytest.approx(reference.x[i] * 1e3, rel=1e-9)
    assert float(line["y_mm"]) == pytest.approx(reference.y[j] * 1e3, rel=1e-9)
    assert float(line["pressure_MPa"]) == pytest.approx(reference.coupled.fields["pressure"][i, j] * 1e-6, rel=1e-9)
    assert line["state"] == str(reference.coupled.fields["state"][i, j])


def test_csv_of_a_single_state_has_no_second_one(tmp_path: pathlib.Path) -> None:
    stored(tmp_path / "a.h5", synthetic.result((8, 8), deformation=False))
    export_csv(tmp_path / "a.h5", tmp_path / "a.csv")
    assert "isothermal" not in (tmp_path / "a.csv").read_text().splitlines()[0]


def test_xdmf_points_into_the_result_in_the_order_of_its_fields(
    tmp_path: pathlib.Path, path: pathlib.Path, reference: Result
) -> None:
    out = tmp_path / "elsewhere" / "a & b.xdmf"
    out.parent.mkdir()
    export_xdmf(path, out)
    grid = ElementTree.parse(out).getroot().find("./Domain/Grid")
    assert grid is not None
    topology, points = grid.find("Topology"), grid.find("Geometry/DataItem")
    assert topology is not None and topology.get("Dimensions") == "20 16 1"

    def resolve(item: ElementTree.Element | None) -> np.ndarray:
        assert item is not None and item.text is not None
        file, _, dataset = item.text.rpartition(":")
        with h5py.File(os.path.join(out.parent, file)) as content:
            values = content[dataset][()]
        assert " ".join(map(str, values.shape)) == item.get("Dimensions")
        assert values.dtype.itemsize == int(item.get("Precision", 0))
        return values

    xyz = resolve(points)
    names = [attribute.get("Name") for attribute in grid.findall("Attribute")]
    assert {"pressure", "isothermal_pressure", "state"} <= set(names)
    for attribute in grid.findall("Attribute[@AttributeType='Scalar']"):
        resolve(attribute.find("DataItem"))
    found = grid.findall("Attribute[@AttributeType='Vector']")
    vectors = {attribute.get("Name"): attribute.find("DataItem") for attribute in found}
    assert set(vectors) == {"shear", "slip", "isothermal_shear", "isothermal_slip"}
    shear = vectors["shear"]
    assert shear is not None and shear.get("Function") == "JOIN($0, $1, 0*$0)" and shear.get("Dimensions") == "20 16 1 3"
    for component, item in zip("xy", shear.findall("DataItem"), strict=True):
        np.testing.assert_array_equal(resolve(item), reference.coupled.fields[f"shear_{component}"])
    hottest = resolve(grid.find("Attribute[@Name='temperature_rise_lower']/DataItem")).argmax()
    # In the order of the file, point and value belong together: the trailing edge at +x is the hottest.
    assert xyz.reshape(-1, 3)[hottest][0] > 0.5 * reference.x.max()
    np.testing.assert_allclose(xyz[..., 0], np.broadcast_to(reference.x[:, None], (20, 16)), rtol=1e-6)
    np.testing.assert_allclose(xyz[..., 1], np.broadcast_to(reference.y, (20, 16)), rtol=1e-6)


def test_vtu_has_the_numbers_of_the_result_at_its_places(tmp_path: pathlib.Path, path: pathlib.Path, reference: Result) -> None:
    (out,) = export_vtu(path, tmp_path / "a & b.vtu")
    (piece,) = ElementTree.parse(out).getroot().findall("UnstructuredGrid/Piece")
    arrays = {array.get("Name"): np.array((array.text or "").split(), float) for array in piece.iter("DataArray")}
    assert (piece.get("NumberOfPoints"), piece.get("NumberOfCells")) == ("320", "285")
    places = arrays["points"].reshape(-1, 3)
    x, y, z = places.T
    assert (z == 0.0).all()
    at = np.searchsorted(reference.x, x), np.searchsorted(reference.y, y)
    for prefix, state in (("", reference.coupled), ("isothermal_", reference.isothermal)):
        for name, values in state.fields.items():
            np.testing.assert_array_equal(arrays[prefix + name], values[at])
    np.testing.assert_array_equal(arrays["shear"].reshape(-1, 3)[:, 1], reference.coupled.fields["shear_y"][at])
    # Every cell is an element's area large, between four neighbours, in their order around it.
    corners = places[arrays["connectivity"].astype(int).reshape(-1, 4)]
    one, other = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    np.testing.assert_allclose(area, np.diff(reference.x)[0] * np.diff(reference.y)[0], rtol=1e-9)
    assert arrays["offsets"][-1] == 4 * 285 and (arrays["types"] == 9).all()

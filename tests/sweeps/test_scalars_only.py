"""Sweeps without a file per point: the same rows, also when interrupted and resumed."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray

from tests.support.command_line import MECHANICAL, call
from thermoroll_cli import Case, sweep
from thermoroll_cli.studies.sweeps.sweep import JOURNAL_NAME

KEYS = ("creepage.longitudinal", "creepage.lateral")
LATERAL, LONGITUDINAL = 2, 6
SWEEP = ("--over", f"{KEYS[0]}=0.0005:0.006:{LONGITUDINAL}", "--over", f"{KEYS[1]}=0.0001:0.002:{LATERAL}",
         "--set", "numerics.grid=8", "--scalars-only", "--no-plots")  # fmt: skip
@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("case") / "spheres.toml"
    path.write_text(MECHANICAL)
    return path


@pytest.fixture(scope="module")
def serial(case: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("serial")
    assert call("sweep", case, *SWEEP, "-o", folder, "-q").returncode == 0
    return folder


def data(folder: Path) -> xarray.Dataset:
    with xarray.open_datatree(folder / "sweep.h5", engine="h5netcdf") as opened:
        assert "case_text" in opened["input"]
        return opened.to_dataset().load()


def copied(serial: Path, folder: Path) -> Path:
    return Path(shutil.copy(serial / JOURNAL_NAME, folder))


@pytest.mark.slow
def test_rows_are_those_of_a_sweep_with_files(case: Path, serial: Path, tmp_path: Path) -> None:
    few = ("--over", f"{KEYS[0]}=0.0005,0.0016", "--over", SWEEP[3], "--set", "numerics.grid=8", "--no-plots", "-q")
    call("sweep", case, *few, "-o", tmp_path)
    with open(tmp_path / "sweep.csv") as one, open(serial / "sweep.csv") as other:
        for mine, theirs in zip(csv.DictReader(other), csv.DictReader(one), strict=False):
            assert {**mine, "file": ""} == {**theirs, "file": ""}


def test_an_array_over_the_swept_keys(serial: Path) -> None:
    found = data(serial)
    assert dict(found.sizes) == {KEYS[0]: LONGITUDINAL, KEYS[1]: LATERAL}
    assert (found["force_x_N"].units, found["isothermal.gamma_c"].units) == ("N", "1")
    assert "units" not in found["reason"].attrs | found[KEYS[0]].attrs
    np.testing.assert_allclose(found[KEYS[0]], np.linspace(0.0005, 0.006, LONGITUDINAL))
    assert (found.status == b"converged").all()
    with open(serial / "sweep.csv") as stream:
        column = [float(row["force_y_N"]) for row in csv.DictReader(stream)]
    np.testing.assert_array_equal(found.force_y_N.values.ravel(), column)
    assert found.force_y_N.attrs["long_name"] == "lateral creep force"


@pytest.mark.slow
def test_more_values_keep_what_is_there(case: Path, serial: Path, tmp_path: Path) -> None:
    copied(serial, tmp_path)
    more = ("--over", f"{KEYS[1]}=0.0001,0.002,0.003", "--over", f"{KEYS[0]}=0.0005,0.006", *SWEEP[4:])
    done = call("sweep", case, *more, "-o", tmp_path, "--resume")
    assert "4 of 6 points are finished already" in done.stderr
    old, new = (data(folder).force_x_N.values for folder in (serial, tmp_path))
    assert new.shape == (3, 2)
    np.testing.assert_array_equal(new[:2], old[[0, -1]][:, [0, -1]].T)


def test_what_cannot_be_resumed(case: Path, tmp_path: Path) -> None:
    journal = tmp_path / JOURNAL_NAME
    journal.write_bytes(b"nonsense\n")
    done = call("sweep", case, *SWEEP, "-o", tmp_path, "--resume")
    assert (done.returncode, "of another sweep, or another version" in done.stderr) == (5, True)
    assert journal.read_bytes() == b"nonsense\n"


def test_points_that_fail_become_rows_and_invalid_ones_stop_it(case: Path, tmp_path: Path) -> None:
    force = ("--over", "force.longitudinal_N=10,19,25", "--set", "numerics.grid=8", "--scalars-only", "--no-plots")
    done = call("sweep", case, *force, "-o", tmp_path)
    assert (done.returncode, "--over force.longitudinal_N=25" in done.stderr) == (3, True)
    assert not (tmp_path / "sweep.h5").exists()
    strict = ("--over", "load.normal_N=60,70", "--set", "numerics.grid=[8, 20]", "--set", "thermal.heat=true")
    done = call("sweep", case, *strict, "--scalars-only", "-o", tmp_path)
    assert done.returncode == 3


def test_a_data_frame_has_numbers_in_flat_columns() -> None:
    case = Case.parse(MECHANICAL).with_values({"numerics.grid": 16})
    rows = sweep(case, {"load.normal_N": [60.0, 65.0], "thermal.heat": [False]})
    frame = rows.to_dataframe()
    assert list(frame.columns[:3]) == ["load.normal_N", "thermal.heat", "converged"]
    assert frame["force_x_N"].tolist() == [row["force_x_N"] for row in rows]
    assert {kind.kind for kind in frame.dtypes} <= set("fib")
    arrays = rows.to_xarray()
    assert dict(arrays.sizes) == {"load.normal_N": 2, "thermal.heat": 1}
    assert float(arrays["isothermal.force_x_N"].sel({"load.normal_N": 65.0})[0]) == rows[1]["isothermal"]["force_x_N"]
    names = ("load.normal_N", "isothermal.force_x_N", "gamma_st", "uncertainty.force_x_N")
    assert [arrays[name].attrs["units"] for name in names] == ["N", "N", "1", "N"]
    for values in ([16, [16, 32]], [16, None]):
        with pytest.raises(ValueError, match="must be numbers, words or true and false, not"):
            sweep(case, {"numerics.grid": values})
        with pytest.raises(ValueError, match="must be numbers, words or true"):
            sweep(case, [{"numerics.grid": value} for value in values])
    listed = sweep(case, [{"load.normal_N": 60.0, "rolling.speed_m_s": 1}, {"load.normal_N": 65.0, "rolling.speed_m_s": 2}])
    assert dict(listed.to_xarray().sizes) == {"point": 2}
    assert [row["force_x_N"] for row in listed] == [row["force_x_N"] for row in rows]
    with pytest.raises(ValueError, match="same keys"):
        sweep(case, [{"load.normal_N": 60.0}, {"rolling.speed_m_s": 2.0}])

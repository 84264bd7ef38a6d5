"""What `thermoroll_cli` offers to notebooks and scripts: as docs/python.md says."""

from __future__ import annotations

import platform
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

import thermoroll_cli
from tests.support import synthetic
from tests.support.command_line import MECHANICAL, PATIENCE, THERMAL, call
from thermoroll_cli import Case, CaseError, Result, read_result, solve
from thermoroll_cli.sweeps.points import MOST_POINTS

ROOT = Path(thermoroll_cli.__file__).parent.parent
PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def hot() -> Result:
    return solve(Case.parse(THERMAL, name="hot"))


def test_the_page_runs(tmp_path: Path) -> None:
    """All blocks of docs/python.md, one after the other, with warnings as errors; on a coarser grid."""
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    page = "\n".join(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL))
    assert page.count('"numerics.grid": 32') == 2
    (tmp_path / "page.py").write_text(page.replace('"numerics.grid": 32', '"numerics.grid": 16'), encoding="utf-8")
    command = [sys.executable, "-W", "error", "page.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("<Result ") and "must be greater than 0" in done.stdout
    assert (tmp_path / "hot.h5").exists() and (tmp_path / "creep" / "sweep.csv").exists()


def test_names_are_offered_lazily() -> None:
    names = {"Case", "CaseError", "Problem", "Result", "Solver", "read_result", "solve", "sweep"}
    assert names <= set(dir(thermoroll_cli))
    assert all(callable(getattr(thermoroll_cli, name)) for name in names)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        thermoroll_cli.nonsense  # noqa: B018
    program = "import sys, thermoroll_cli; print([m for m in ('numpy', 'pydantic', 'h5py') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout == "[]\n"


def test_a_saved_result_is_the_file_of_the_command(hot: Result, tmp_path: Path) -> None:
    (tmp_path / "hot.toml").write_text(THERMAL)
    assert call("run", "hot.toml", "--no-plots", "-q", cwd=tmp_path).returncode == 0
    assert hot.save(tmp_path / "saved.h5") == tmp_path / "saved.h5"
    command, saved = read_result(tmp_path / "results" / "hot.h5"), read_result(tmp_path / "saved.h5")
    assert (saved.case_text, saved.case_json) == (command.case_text, command.case_json)
    for name, values in command.coupled.fields.items():
        np.testing.assert_array_equal(saved.coupled.fields[name], values)
    assert call("run", "--from", "saved.h5", "--no-plots", "-q", "-o", "again", cwd=tmp_path).returncode == 0


def test_a_result_of_a_problem_has_no_case(tmp_path: Path) -> None:
    solve(Case.parse(MECHANICAL).problem).save(tmp_path / "bare.h5")
    assert call("plot", "bare.h5", cwd=tmp_path).returncode == 0
    done = call("run", "--from", "bare.h5", cwd=tmp_path)
    assert done.returncode == 3 and "no resolved case" in done.stderr


def test_labelled_arrays_are_those_of_the_file(hot: Result, tmp_path: Path) -> None:
    path = hot.save(tmp_path / "hot.h5")
    for state, group in (("coupled", "fields"), ("isothermal", "isothermal")):
        found = hot.to_xarray(state)
        with xarray.open_dataset(path, group=group, engine="h5netcdf") as expected:
            assert set(found) == set(expected)
            for name in expected:
                np.testing.assert_array_equal(found[name], expected[name])
                assert found[name].attrs["units"] == expected[name].attrs["units"]
            np.testing.assert_array_equal(found.x, expected.x)
    assert hot.to_xarray().attrs["Q_F_W"] == hot.coupled.scalars["Q_F_W"]
    with pytest.raises(ValueError, match='"coupled" and "isothermal"'):
        hot.to_xarray("cold")


def test_without_xarray_it_says_what_to_install(hot: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match="pip install xarray"):
        hot.to_xarray()


def test_a_result_is_shown_in_a_line(hot: Result) -> None:
    assert repr(hot).startswith("<Result 'Two spheres', 16×16, converged, Q_F = ")
    assert "not converged: the coupling" in repr(synthetic.result((8, 8), converged=False))
    assert all(len(repr(shown)) < 300 and "\n" not in repr(shown) for shown in (hot, hot.coupled))


def test_a_sweep_gives_the_rows_of_the_command(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL)
    over = "--over", "load.normal_N=50,60", "--over", "creepage.longitudinal=0.001,0.002"
    assert call("sweep", "case.toml", *over, "--no-plots", "-q", cwd=tmp_path).returncode == 0
    told: list[dict] = []
    case = Case.read(tmp_path / "case.toml")
    keys = {"load.normal_N": np.array([50, 60]), "creepage.longitudinal": [0.001, 0.002]}
    rows = thermoroll_cli.sweep(case, keys, tmp_path / "python", report=told.append)
    assert [row["file"].name for row in rows] == [f"case_000{n}.h5" for n in range(1, 5)] and told == rows
    for row in rows:
        expected = read_result(tmp_path / "results" / row["file"].name).summary()
        assert row["status"] == "converged" and row["force_x_N"] == expected["force_x_N"]
    unkept = thermoroll_cli.sweep(case, keys)
    assert [row["force_x_N"] for row in unkept] == [row["force_x_N"] for row in rows]
    assert all(row["file"] is None for row in unkept)


@pytest.mark.parametrize(
    ("over", "error", "message"),
    [
        ({"load.normal_N": []}, ValueError, "no values"),
        ({"load.normal_N": [1.0, 1.0]}, ValueError, "more than once"),
        ({"load.normal_N": [1.0, -1.0]}, CaseError, "^sweep over load.normal_N=-1.0: .*greater than 0"),
        ({"load.normal_N": range(1, MOST_POINTS + 2)}, ValueError, "too many"),
    ],
)
def test_wrong_sweeps_say_why(over: dict, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        thermoroll_cli.sweep(Case.parse(MECHANICAL), over)


def test_files_tell_what_computed_them(hot: Result, tmp_path: Path) -> None:
    import h5py
    import scipy

    attributes = read_result(hot.save(tmp_path / "hot.h5")).attributes
    assert attributes["python_version"] == platform.python_version()
    assert attributes["numpy_version"] == np.__version__ and attributes["scipy_version"] == scipy.__version__
    assert attributes["h5py_version"] == h5py.__version__ and attributes["hdf5_version"] == h5py.version.hdf5_version
    assert attributes["fftw_version"].startswith("3.") and platform.machine() in attributes["platform"]

"""What `thermoroll_cli` offers to notebooks and scripts: as docs/read_results.md says."""

from __future__ import annotations

import math
import pickle
import platform
import re
import subprocess
import sys
import tomllib
import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from threadpoolctl import threadpool_info, threadpool_limits

import thermoroll_cli
from tests.support import synthetic
from tests.support.command_line import MECHANICAL, PATIENCE, THERMAL, call
from thermoroll_cli import Case, CaseError, Result, read_result, solve, sweep
from thermoroll_cli.studies.sweeps.points import MOST_POINTS

MECHANICAL_CASE = Case.parse(MECHANICAL)
ROOT = Path(thermoroll_cli.__file__).parent.parent
PAGE = (ROOT / "docs" / "read_results.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def hot() -> Result:
    return solve(Case.parse(THERMAL, name="hot"))


@pytest.mark.slow
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """All blocks of docs/read_results.md, one after the other, with warnings as errors. Only the block that names xarray needs
    it. What `print` writes is what stands beside it."""
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert sum("xarray" in block for block in blocks) == 1
    names: dict[str, Any] = {"__name__": "page"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in blocks:
            with monkeypatch.context() as hiding:
                if "xarray" not in block:
                    hiding.setitem(sys.modules, "xarray", None)
                exec(compile(block, "read_results.md", "exec"), names)
            if "print(result)" in block:  # of what follows no numbers are shown
                names["case"] = names["case"].with_values({"numerics.grid": 12})
    out = capsys.readouterr().out
    assert out.startswith("<Result ") and "must be greater than 0" in out
    assert (tmp_path / "hot.h5").exists() and (tmp_path / "creep" / "sweep.csv").exists()
    printed, shown = ([line for line in text if line.startswith("<")] for text in (
        out.splitlines(), re.findall(r"print\(\w+\) +# (<.*>)", PAGE)))
    assert len(printed) == len(shown) == 2
    for line, words in zip(printed, shown, strict=True):
        # Numbers to a per cent; … stands for the rest.
        number = r"\b\d+\.\d+\b"
        here, there = ([float(value) for value in re.findall(number, text)] for text in (line, words))
        assert here[: len(there)] == pytest.approx(there, rel=1e-2)
        assert re.fullmatch(re.escape(re.sub(number, "#", words)).replace("…", ".*"), re.sub(number, "#", line))


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
    assert call("plot", "bare.h5", "--fields", "pressure", cwd=tmp_path).returncode == 0
    done = call("run", "--from", "bare.h5", cwd=tmp_path)
    assert done.returncode == 3 and "no resolved case" in done.stderr


def test_labelled_arrays_are_those_of_the_file(hot: Result, tmp_path: Path) -> None:
    path = hot.save(tmp_path / "hot.h5")
    cold = "fields" if hot.isothermal is hot.coupled else "isothermal/fields"
    for state, group in (("coupled", "fields"), ("isothermal", cold)):
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


def test_scalars_are_those_that_apply(hot: Result) -> None:
    """Without nan; each with its uncertainty in its own unit, nan where it is given. Inside and outside make the same class."""
    cold = solve(MECHANICAL_CASE)
    assert type(solve(MECHANICAL_CASE.problem)) is type(cold) is thermoroll_cli.Result is type(synthetic.result())
    assert not any(math.isnan(value) for value in cold.scalars.values())
    assert "heat_into_lower_W" in hot.scalars and "heat_into_lower_W" not in cold.scalars
    with pytest.raises(KeyError, match=r"no scalar 'heat_into_lower_W'; there are .*Q_F_W"):
        cold["heat_into_lower_W"]
    limit = cold["friction_limit_N"]
    assert 0.0 < cold.uncertainty["force_x_N"] < 0.05 * limit and limit == pytest.approx(19.5)
    assert 0.0 < cold.uncertainty["Q_F_W"] < 0.05 * cold["Q_F_W"]
    assert math.isnan(cold.uncertainty["creepage_longitudinal"]) and cold.scalars.keys() <= cold.uncertainty.keys()
    assert cold.fields is cold.coupled.fields and cold["force_x_N"] == cold.coupled.scalars["force_x_N"]


def test_files_and_mappings_are_cases(tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_text(MECHANICAL)
    tables = tomllib.loads(MECHANICAL)
    one, other = solve(tmp_path / "two.toml"), solve(tables)
    assert one.coupled.scalars["force_x_N"] == other.coupled.scalars["force_x_N"] and one.case_text == MECHANICAL
    assert Case.from_json(other.case_json).settings == Case.from_dict(tables).settings
    with pytest.raises(CaseError, match="no such file"):
        solve("missing.toml")


def test_a_result_cannot_be_changed_and_names_what_it_has(hot: Result) -> None:
    with pytest.raises(ValueError, match="read-only"):
        hot.coupled.fields["pressure"][0, 0] = 1.0
    with pytest.raises(TypeError):
        hot.coupled.scalars["Q_F_W"] = 1.0  # type: ignore[index]
    for mapping, wrong, there in ((hot.coupled.fields, "presure", "pressure, shear_x"), (hot.coupled.scalars, "Q_F", "Q_F_W")):
        with pytest.raises(KeyError, match=f"'{wrong}'; there are .*{there}"):
            mapping[wrong]
    with pytest.raises(KeyError, match=r"pressure is a field: result.fields\['pressure'\]"):
        hot["pressure"]
    assert hot.coupled.fields.get("presure") is None and len(hot.coupled.fields) == len(dict(hot.coupled.fields))
    copy = pickle.loads(pickle.dumps(hot))
    assert repr(copy.summary()) == repr(hot.summary()) and list(copy.coupled.fields) == list(hot.coupled.fields)


def test_a_picture_is_a_figure(hot: Result, tmp_path: Path) -> None:
    figure = hot.plot("pressure")
    figure.savefig(tmp_path / "pressure.pdf")
    assert (tmp_path / "pressure.pdf").stat().st_size > 5_000
    assert hot.plot("gap", normalised=True).axes
    with pytest.raises(ValueError, match="there is no picture 'presure'; there are pressure"):
        hot.plot("presure")
    with pytest.raises(ValueError, match="nothing to show in a picture 'profile'"):
        hot.plot("profile")


def test_a_notebook_shows_a_table(hot: Result) -> None:
    strong = synthetic.result((8, 8))
    page = hot._repr_html_()
    assert "Two spheres" in page and "<tr><td>scalar</td><td>value</td><td>unit</td></tr>" in page
    page = strong._repr_html_()
    rows = {cells[0]: cells[1:] for row in re.findall("<tr>(.*?)</tr>", page) if (cells := re.findall("<td>(.*?)</td>", row))}
    assert rows["scalar"] == ["coupled", "isothermal", "unit"]
    assert rows["maximum pressure"][2] == "MPa" and " ± " in rows["maximum pressure"][0]
    assert rows["lateral creep force"] == ["0", "0", "N"]
    assert "Result &#x27;Synthetic&#x27;" in page


def test_a_result_is_shown_in_a_line(hot: Result) -> None:
    assert repr(hot).startswith("<Result 'Two spheres', 16×16, converged, Q_F = ")
    assert "not converged: the coupling" in repr(synthetic.result((8, 8), converged=False))
    assert all(len(repr(shown)) < 300 and "\n" not in repr(shown) for shown in (hot, hot.coupled))


def test_a_sweep_gives_the_rows_of_the_command(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL.replace("grid = 16", "grid = 8"))
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


@pytest.mark.parametrize(("over", "error", "message"), [
    ({"load.normal_N": []}, ValueError, "no values"),
    ({"load.normal_N": [1.0, 1.0]}, ValueError, "more than once"),
    ({"load.normal_N": 5}, ValueError, r"load.normal_N needs a list of values, as \[5\]"),
    ({"thermal.peclet": "rolling"}, ValueError, "needs a list of values"),
    ({"load.normal_N": [1.0, -1.0]}, CaseError, "^sweep over load.normal_N=-1.0: .*greater than 0"),
    ({"load.normal_N": range(1, MOST_POINTS + 2)}, ValueError, "too many"),
])
def test_wrong_sweeps_say_why(over: dict, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        thermoroll_cli.sweep(Case.parse(MECHANICAL), over)


def test_wrong_cases_and_options_say_why(hot: Result) -> None:
    with pytest.raises(TypeError, match="a mapping of tables, not int"):
        solve(5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="threads must be 1 or more"):
        solve(Case.parse(THERMAL), threads=0)
    again = thermoroll_cli.Solver().solve(Case.parse(THERMAL, name="hot"))
    assert again.scalars["Q_F_W"] == hot.coupled.scalars["Q_F_W"] and again.case_json == hot.case_json
    assert {"hertz_a_mm", "T_gamma_N"} <= again.scalars.keys()


def test_a_sweep_over_a_data_frame() -> None:
    pandas = pytest.importorskip("pandas")
    points = pandas.DataFrame({"load.normal_N": [50.0, 60.0], "creepage.longitudinal": [0.001, 0.002]})
    rows = thermoroll_cli.sweep(MECHANICAL_CASE, points)
    assert [row["load.normal_N"] for row in rows] == [50.0, 60.0]
    assert repr(rows) == "<sweep over load.normal_N, creepage.longitudinal: 2 points, 2 converged>"


@pytest.mark.slow
def test_a_script_without_main_guard_is_told(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL)
    (tmp_path / "script.py").write_text('import thermoroll_cli\n'
                                        'thermoroll_cli.sweep("case.toml", {"load.normal_N": [50, 60]}, jobs=2)\n')
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.stderr.count("Traceback") == 1 and done.stderr.endswith('put its work behind if __name__ == "__main__":\n')


def test_files_tell_what_computed_them(hot: Result, tmp_path: Path) -> None:
    import h5py
    import scipy

    attributes = read_result(hot.save(tmp_path / "hot.h5")).attributes
    assert attributes["python_version"] == platform.python_version()
    assert attributes["numpy_version"] == np.__version__ and attributes["scipy_version"] == scipy.__version__
    assert attributes["h5py_version"] == h5py.__version__ and attributes["hdf5_version"] == h5py.version.hdf5_version
    assert attributes["fftw_version"].startswith("3.") and platform.machine() in attributes["platform"]


def test_linear_algebra_has_one_thread_while_a_case_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Afterwards it has those of the user again, also where the solve ends with an exception."""
    monkeypatch.setattr("thermoroll_cli.tools.process._decided", False)

    def count() -> set[int]:
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    with threadpool_limits(2, "blas"):
        for most in (1000, 3):
            seen: list[set[int]] = []

            def report(*_: object, most: int = most, seen: list[set[int]] = seen) -> None:
                seen.append(count())
                if len(seen) > most:
                    raise InterruptedError

            with suppress(InterruptedError):
                solve(Case.parse(THERMAL).with_values({"numerics.grid": 8}), report=report)
            assert {*map(tuple, seen)} == {(1,)} and count() == {2}


def test_several_cases_in_one_sweep() -> None:
    dry = Case.parse(MECHANICAL.replace("grid = 16", "grid = 8"), name="dry")
    slippery = dry.with_values({"load.friction_coefficient": 0.1, "creepage.longitudinal": 0.05})
    rows = sweep([dry, replace(slippery, name="wet")], {"load.normal_N": [50.0, 100.0]})
    assert [(row["case"], row["load.normal_N"]) for row in rows] == [("dry", 50), ("dry", 100), ("wet", 50), ("wet", 100)]
    table = rows.to_xarray()
    assert table.force_x_N.sel(case="wet").values == pytest.approx([5.0, 10.0], rel=1e-4)
    with pytest.raises(ValueError, match="several cases are called dry: they need names of their own"):
        sweep([dry, slippery], {"load.normal_N": [50.0, 100.0]})

"""The printed ± is the error of JSON and HDF5 in the unit of the value, for every scalar; what is given has none."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import THERMAL, Called, call
from tests.support.errors import relative
from thermoroll_cli.cli.tables import alike, scalar_table
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.names import ALL_SCALARS, PROBLEM_SCALARS, SCALARS
from thermoroll_cli.problem.scalar_errors import MISMATCHES, isothermal_text, number, rounded, with_error

CASE = (
    THERMAL.replace("grid = 16", "grid = 20").replace("longitudinal = 0.003", "lateral = 0.001\nspin_rad_mm = 0.002")
    + "[force]\nlongitudinal_N = 12.0\n"
    + '[thermal]\npeclet = "stationary"\npartition = "matched"\nbulk_temperature_lower_K = 5.0\n'
).replace("speed_m_s = 1.0", "speed_m_s = 50.0")
"""Everything at once: heat that feeds back, a force and a creepage, spin, different bulk temperatures, two grids."""

GIVEN = ("force_x_N", "creepage_lateral", "creepage_spin_rad_mm")
NUMBER = r"\(?(-?[\d.]+(?:e[-+]?\d+)?)"
ROW = re.compile(rf"  (\w+) +{NUMBER}(?: ± ([\d.]+(?:e[-+]?\d+)?)\)?(?:e(-?\d+))?)?")


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Called, dict[str, Any], Path]:
    folder = tmp_path_factory.mktemp("error_bars")
    (folder / "case.toml").write_text(CASE)
    table = call("run", "case.toml", "-v", "--no-plots", cwd=folder)
    record = json.loads(call("run", "case.toml", "-q", "--json", "--no-plots", cwd=folder).stdout)
    return table, record, folder / "results" / "case.h5"


def printed(table: Called) -> dict[str, tuple[float, float]]:
    """Value and error of each row; nan for an error that is not printed."""
    rows = {}
    for name, value, error, power in (match.groups() for match in map(ROW.match, table.stdout.splitlines()) if match):
        factor = 10.0 ** int(power or 0)
        rows[name] = float(value) * factor, float(error) * factor if error else math.nan
    return rows


def test_table_json_and_hdf5_tell_the_same_error_of_every_scalar(outputs: tuple[Called, dict[str, Any], Path]) -> None:
    table, record, path = outputs
    stored, rows = read_result(path).summary(), printed(table)
    # What this case has no use for (tracks of turning bodies, …) is null, and in no table.
    assert set(rows) == {name for name in (*SCALARS, *PROBLEM_SCALARS) if record.get(name) is not None}
    assert len(rows) >= 30
    with_bars = 0
    for name, (value, shown) in rows.items():
        error = record["uncertainty"].get(name)
        assert stored[name] == record[name]
        if name in SCALARS:
            assert stored["uncertainty"][name] == error or (error is None and math.isnan(stored["uncertainty"][name]))
        if error is None or error == 0.0:
            assert math.isnan(shown)
            assert value == pytest.approx(record[name], rel=0.05 if name in MISMATCHES else 1e-4)
            continue
        with_bars += 1
        # One digit is printed, two if it starts with 1.
        assert shown == pytest.approx(error, rel=0.35)
        assert abs(value - record[name]) <= 0.51 * max(shown, 1e-5 * abs(record[name]))
    assert with_bars >= 15


def test_scales_that_are_not_the_value(outputs: tuple[Called, dict[str, Any], Path]) -> None:
    table, record, _ = outputs
    rows, error = printed(table), relative(record)
    limit, arm = 0.3 * 65.0, math.sqrt(record["hertz_a_mm"] * record["hertz_b_mm"])
    rises = [record[f"temperature_rise_max_{body}_K"] for body in ("lower", "upper")]
    assert rows["gamma_st"][1] == pytest.approx(error["gamma_st"], rel=0.35)
    assert rows["force_y_N"][1] == pytest.approx(error["force_y_N"] * limit, rel=0.35)
    assert rows["spin_moment_Nmm"][1] == pytest.approx(error["spin_moment_Nmm"] * limit * arm, rel=0.35)
    for body in ("lower", "upper"):
        name = f"temperature_rise_max_{body}_K"
        assert rows[name][1] == pytest.approx(error[name] * max(*rises, 5.0), rel=0.35)


def test_what_is_given_has_no_error(outputs: tuple[Called, dict[str, Any], Path]) -> None:
    table, record, _ = outputs
    for name in GIVEN:
        assert record["uncertainty"].get(name) is None
        assert math.isnan(printed(table)[name][1])
    assert record["uncertainty"]["creepage_longitudinal"] > 0.0 and record["uncertainty"]["force_y_N"] > 0.0


def test_one_grid_alone_says_that_it_has_no_estimates(outputs: tuple[Called, dict[str, Any], Path]) -> None:
    table, _, path = outputs
    coarse = call("run", "case.toml", "--set", "numerics.grid=10", "--no-plots", "-o", "coarse", cwd=path.parents[1])
    assert "±" not in coarse.stdout and "no error estimates" in coarse.stdout
    assert "no error estimates" not in table.stdout


@pytest.mark.slow
def test_table_fits_eighty_columns(outputs: tuple[Called, dict[str, Any], Path], monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, path = outputs
    for columns in (80, 130):
        monkeypatch.setenv("COLUMNS", str(columns))
        lines = call("run", "case.toml", "--no-plots", cwd=path.parents[1]).stdout.splitlines()
        assert max(map(len, lines)) <= columns
        # Beside its value, or below it where there is no room.
        (words,) = (line for line in lines if "maximum temperature rise, lower body" in line)
        assert words.startswith("  temperature_rise_max_lower_K") == (columns == 130)


def test_a_meaning_without_room_is_shortened() -> None:
    summary = {"orthogonal_shear_range_max_upper_MPa": 422.0, "layer_tension_max_upper_MPa": 230.0,
               "power_balance_error": 1.5997e-4, "uncertainty": {}}  # fmt: skip
    lines = scalar_table(summary, list(ALL_SCALARS), both=False, width=76)
    assert max(map(len, lines)) <= 76
    assert [" ".join(line.split()[1:]) for line in lines] == [
        "0.00016 heat of unresolved slip",
        "230 largest first principal …",
        "422 largest range of σ_xz …",
    ]
    narrow = scalar_table(summary, list(ALL_SCALARS), both=False, width=64)
    assert max(map(len, narrow)) <= 64 and "…" not in "".join(narrow)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(11.0712, 0.0213, "11.07 ± 0.02"), (316.987, 0.0143, "316.987 ± 0.014"), (0.0, 3.9e-4, "0 ± 0.0004"),
     (-1e-9, 3.9e-4, "0 ± 0.0004"), (6.186e-4, 1.3e-6, "(6.186 ± 0.013)e-4"), (3100.0, 1234.0, "3100 ± 1200"),
     (0.02, 0.5, "0 ± 0.5"), (2.0, math.nan, "2"), (1.0, 0.0, "1"), (5.0, 1e-9, "5 ± 1e-09"),
     (459.743436, 1.09e-4, "459.74344 ± 0.00011"), (-6.2446e-16, math.nan, "0"),
     (3e-14, 6e-14, "0"), (2e-10, math.nan, "2e-10"), (100000.4, math.nan, "100000"),
     (-123456.7, 1e-3, "-123456.7000 ± 0.0010"),
     (999999.0, math.nan, "1e+06")],
)
def test_value_with_error(value: float, error: float, text: str) -> None:
    assert with_error(value, error) == text


def test_numbers_of_a_column_are_written_alike() -> None:
    """Those of a load that passes 100 kN; what a symmetry makes zero has no digits; 15.42927 beside 0.93634 is not
    15.42900."""
    assert [number(value) for value in (99021.3, 1e5, 123456.7)] == ["99021", "100000", "123460"]
    assert [number(value, 4) for value in (1502.4, 15024.0, 8.63e-17, -0.0)] == ["1502", "15020", "0", "0"]
    assert alike(["15.429", "0.93634", "-2"]) == ["15.429  ", " 0.93634", "-2      "]


def test_a_value_beside_another_has_its_digits() -> None:
    assert [rounded(value, 1.2) for value in (265.9843, 0.04, math.nan)] == ["266.0", "0", "–"]
    assert rounded(0.0, 1.5e-5) == "0"
    failed = {"pressure_max_MPa": 2e4, "isothermal.pressure_max_MPa": 898.6, "uncertainty.pressure_max_MPa": 5e4}
    assert isothermal_text("pressure_max_MPa", failed) == "900", "not 0: the error is that of the coupled state"
    assert rounded(6.18712e-4, 1.3e-6) == "6.187e-4" and rounded(2.5, math.nan) == "2.5"

"""Measured moduli: the series that fits them, how files are read, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.cases import Case
from tests.support.command_line import call
from thermoroll_cli.files.case import CaseError
from thermoroll_cli.files.column_files import read_series
from thermoroll_cli.problem.relaxation import modulus_at

SERIES = ((0.30, 1e-4), (0.25, 1e-3), (0.20, 1e-2))
FREQUENCIES = np.logspace(-1.0, 5.0, 25)
CASE = """
geometry = {lower_radius_x_mm = inf, lower_radius_y_mm = inf, upper_radius_x_mm = 50.0, upper_radius_y_mm = 200.0}
load = {normal_N = 500.0, friction_coefficient = 0.3}
rolling.speed_m_s = 2.0
numerics.grid = 8
[material]
youngs_modulus_GPa = 2.4
poisson_ratio = 0.38
relaxation_file = { file = "dma.csv" }
"""


def measured(header: str = "frequency_Hz,storage_GPa,loss_GPa", unit: float = 1.0, separator: str = ",") -> str:
    rows = [header.replace(",", separator)]
    for frequency in FREQUENCIES:
        modulus = 2.4 * unit * modulus_at(SERIES, 2.0 * np.pi * frequency)
        row = separator.join(f"{value:.6g}" for value in (frequency, modulus.real, modulus.imag))
        rows.append(row.replace(".", ",") if separator == ";" else row)
    return "\n".join(rows) + "\n"


def test_a_series_is_found_again(tmp_path: Path) -> None:
    (tmp_path / "dma.csv").write_text(measured())
    found = read_series(tmp_path / "dma.csv")
    assert found.shown["rms_deviation"] < 0.02
    assert found.shown["modulus_GPa"] == pytest.approx(2.4, rel=0.02)
    assert found.shown["relaxed_share"] == pytest.approx(0.25, rel=0.02)
    for frequency in FREQUENCIES:
        once, again = (modulus_at([(share, time) for share, time in series], 2.0 * np.pi * frequency)
                       for series in (SERIES, found.content))
        assert abs(again / once - 1.0) < 0.06
    assert "25 frequencies from 0.1 to 1e+05 Hz" in found.words(found.record())


@pytest.mark.parametrize("header", ["Frequency [Hz];E' (MPa);tan δ", "Freq (rad/s),E′ [MPa],tan(delta) [-]",
                                    "f_Hz;G'_MPa;tan_delta"])  # fmt: skip
def test_columns_may_be_named_as_instruments_name_them(tmp_path: Path, header: str) -> None:
    separator = ";" if ";" in header else ","
    turns = 2.0 * np.pi if "rad" in header else 1.0
    rows = [header]
    for frequency in FREQUENCIES:
        modulus = 2400.0 * modulus_at(SERIES, 2.0 * np.pi * frequency)
        rows.append(separator.join(f"{x:.8g}" for x in (frequency * turns, modulus.real, modulus.imag / modulus.real)))
    (tmp_path / "instrument.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (tmp_path / "dma.csv").write_text(measured())
    found, plain = (read_series(tmp_path / name) for name in ("instrument.csv", "dma.csv"))
    assert np.array(found.content) == pytest.approx(np.array(plain.content), rel=0.01)
    assert found.shown["modulus_GPa"] == pytest.approx(plain.shown["modulus_GPa"], rel=1e-4)


@pytest.mark.parametrize(("header", "unit", "separator"), [
    ("frequency_Hz,storage_MPa,loss_MPa", 1e3, ","), ("frequency_Hz,storage_Pa,loss_Pa", 1e9, "\t"),
    ("frequency_Hz,storage_GPa,loss_GPa", 1.0, ";"),
])
def test_units_and_separators_mean_the_same(tmp_path: Path, header: str, unit: float, separator: str) -> None:
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    one.write_text(measured())
    other.write_text(measured(header, unit, separator), encoding="cp1252")
    first, second = read_series(one), read_series(other)
    assert second.shown["modulus_GPa"] == pytest.approx(first.shown["modulus_GPa"], rel=1e-9)
    assert np.array(second.content) == pytest.approx(np.array(first.content), rel=1e-6)


def test_a_case_with_a_file(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "dma.csv").write_text(measured())
    shown = call("show", tmp_path / "case.toml")
    assert shown.returncode == 0, shown.stderr
    assert "% of it remains" in " ".join(shown.stdout.split())
    ran = call("run", tmp_path / "case.toml", "-o", tmp_path, "--set", "output.plots=false")
    assert ran.returncode == 0, ran.stderr
    assert "rolling_resistance_N" in ran.stdout
    case = Case.parse(CASE, name=str(tmp_path / "case.toml"))
    assert [*map(list, case.problem.lower.relaxation)] == read_series(tmp_path / "dma.csv").content
    # What the file says is part of the case from then on.
    assert Case.parse(case.to_toml()).problem == case.problem


def test_a_layer_with_a_file_is_shown(tmp_path: Path) -> None:
    layer = "[[material.lower.layers]]\nthickness_um = 5e3\nyoungs_modulus_GPa = 2.4\npoisson_ratio = 0.38\n"
    steel = "youngs_modulus_GPa = 210.0\npoisson_ratio = 0.3\n"
    named = 'relaxation_file = { file = "dma.csv" }\n'
    bodies = f"[material.lower]\n{steel}{layer}{named}[material.upper]\n{steel}"
    (tmp_path / "case.toml").write_text(CASE[: CASE.index("[material]")] + bodies)
    (tmp_path / "dma.csv").write_text(measured())
    shown = call("show", tmp_path / "case.toml")
    assert shown.returncode == 0, shown.stderr
    assert "material.lower.layers.0.relaxation_file" in shown.stdout and "25 frequencies" in shown.stdout
    case = Case.read(tmp_path / "case.toml")
    bare = [{"thickness_um": 5e3, "youngs_modulus_GPa": 2.4, "poisson_ratio": 0.38}]
    assert case.profiles and not case.with_values({"material.lower.layers": bare}).profiles


def test_a_file_beside_a_series_or_missing(tmp_path: Path) -> None:
    for change, message in ((("poisson", "relaxation = [[0.5, 1.0]]\npoisson"), "together with relaxation"),
                            (("dma.csv", "none.csv"), "no such file")):
        with pytest.raises(CaseError) as caught:
            Case.parse(CASE.replace(*change), name=str(tmp_path / "case.toml"))
        assert [message in finding.message for finding in caught.value.findings] == [True]

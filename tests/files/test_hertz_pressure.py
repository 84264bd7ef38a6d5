"""Loads that are given by Hertz's pressure, through the command."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, call

PRESSURE = MECHANICAL.replace("normal_N = 65.0", "hertz_pressure_MPa = 1200.0")


@pytest.mark.parametrize(("upper", "lower"), [((210.0, 0.28), (210.0, 0.28)), ((315.0, 0.26), (206.0, 0.3))])
def test_the_load_is_that_of_hertz(upper: tuple[float, float], lower: tuple[float, float], tmp_path: Path) -> None:
    """W = π³ p₀³ R²/(6 E*²) of two spheres with 1/R = 2/30 mm."""
    bodies = "".join(f"[material.{body}]\nyoungs_modulus_GPa = {modulus}\npoisson_ratio = {ratio}\n"
                     for body, (modulus, ratio) in (("upper", upper), ("lower", lower)))
    text = bodies + PRESSURE[PRESSURE.index("[geometry]"):].replace("grid = 16", "grid = 8")
    (tmp_path / "case.toml").write_text(text)
    modulus = 1.0 / sum((1.0 - ratio**2) / (1e9 * young) for young, ratio in (upper, lower))
    load = math.pi**3 * 1.2e9**3 * 0.015**2 / (6.0 * modulus**2)
    record = json.loads(call("run", tmp_path / "case.toml", "-o", tmp_path, "--no-plots", "--json", "-q").stdout)
    assert record["normal_N"] == pytest.approx(load, rel=1e-9) and record["hertz_p0_MPa"] == pytest.approx(1200.0)
    assert record["friction_limit_N"] == pytest.approx(0.3 * load)
    shown = json.loads(call("show", tmp_path / "case.toml", "--json").stdout)
    assert shown["normal_N"] == pytest.approx(load) and shown["inputs"]["load.hertz_pressure_MPa"]["si"] == 1.2e9
    done = call("run", tmp_path / "case.toml", "-o", tmp_path, "--no-plots", "-q", "--json", "--set", "load.normal_N=65")
    assert json.loads(done.stdout)["normal_N"] == 65.0
    over = ("--over", "load.hertz_pressure_MPa=600,1200")
    table = call("sweep", tmp_path / "case.toml", *over, "--no-plots", "-o", tmp_path, "--json")
    loads = [json.loads(line)["normal_N"] for line in table.stdout.splitlines()]
    assert loads == pytest.approx([load / 8.0, load])


def test_the_load_per_length_of_two_cylinders_is_that_of_hertz(tmp_path: Path) -> None:
    """W' = π R p₀²/E*, and half-width a = 2 R p₀/E*; carried to the creep force, sweeps, and a fit."""
    flat = PRESSURE.replace("radius_y_mm = 30.0", "radius_y_mm = inf").replace("longitudinal = 0.003", "longitudinal = 0.05")
    (tmp_path / "case.toml").write_text(flat)
    modulus, radius = 0.5 * 210e9 / (1.0 - 0.28**2), 0.015
    load, half_width = math.pi * radius * 1.2e9**2 / modulus, 2.0 * radius * 1.2e9 / modulus
    table = call("sweep", tmp_path / "case.toml", "--over", "load.hertz_pressure_MPa=1200,600", "--no-plots", "-o", tmp_path,
                 "--json")
    whole, half = (json.loads(line) for line in table.stdout.splitlines())
    assert whole["hertz_p0_MPa"] == pytest.approx(1200.0) and whole["hertz_a_mm"] == pytest.approx(1e3 * half_width, rel=1e-9)
    assert [whole["normal_N_mm"], half["normal_N_mm"]] == pytest.approx([1e-3 * load, 0.25e-3 * load], rel=1e-9)
    assert whole["force_x_N_mm"] == pytest.approx(0.3e-3 * load, rel=1e-4)
    shown = json.loads(call("show", tmp_path / "case.toml", "--json").stdout)
    assert shown["normal_N_mm"] == pytest.approx(1e-3 * load)
    (tmp_path / "data.csv").write_text("creepage.longitudinal,force_x_over_load\n0.05,0.2\n0.06,0.2\n")
    fitted = call("fit", tmp_path / "case.toml", tmp_path / "data.csv", "--free", "load.friction_coefficient", "--no-plots",
                  "-o", tmp_path, "--json")
    assert json.loads(fitted.stdout)["parameters"]["load.friction_coefficient"]["value"] == pytest.approx(0.2, rel=1e-3)

"""Accuracy of the scalars that are asked for, and of no others."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, call
from tests.support.errors import relative
from tests.support.scenes import accurate_to, article_4_1
from thermoroll_cli.problem.names import GROUPS, SCALARS, of_contacts
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve


@cache
def everything(accuracy: float) -> Result:
    return solve(accurate_to(accuracy, article_4_1(64), "forces", "heat", "temperatures", "shares", "pressure_max_MPa"))


@pytest.mark.slow
@pytest.mark.parametrize("asked", [
    ("forces",), *(pytest.param(asked, marks=pytest.mark.slow) for asked in (("Q_F_W",), ("shares", "temperatures")))])
def test_only_what_is_asked_for_decides_the_grid(asked: tuple[str, ...]) -> None:
    found, all_of_it = solve(accurate_to(2e-3, article_4_1(64), *asked)), everything(2e-3)
    assert found.converged and all_of_it.converged
    assert len(found.x) <= len(all_of_it.x)
    for name in of_contacts(asked):
        assert not relative(found)[name] > 2e-3
    # The others keep their values and errors.
    assert relative(found)["heat_flux_max_W_mm2"] > 0.0 and found["pressure_max_MPa"] > 0.0


@pytest.mark.slow
def test_forces_alone_need_a_coarser_grid_than_everything() -> None:
    forces, all_of_it = solve(accurate_to(2e-3, article_4_1(64), "forces")), everything(2e-3)
    assert len(forces.x) < len(all_of_it.x)
    assert abs(forces["force_x_N"] - all_of_it["force_x_N"]) < 1e-3 * all_of_it["friction_limit_N"]


def test_scalars_of_an_assembly_stand_for_those_of_its_contacts() -> None:
    assert of_contacts(["track_force_y_left_N"]) == {*GROUPS["forces"]} & {*SCALARS}
    assert of_contacts(["Q_F_left_W", "heat_into_lower_W"]) == {"Q_F_W", "heat_into_lower_W"}
    assert {"wear_area_upper_um2"} < of_contacts(["wear"])
    assert {*SCALARS} < of_contacts(["all"])


def test_a_strip_that_hardly_sticks_fails_nothing() -> None:
    """Two discs that slide nearly everywhere over an interlayer: the share that sticks is known to a few elements of any grid,
    and nothing depends on it (forces err by less than what it could carry)."""
    found = solve({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28},
        "geometry": {"lower_radius_x_mm": 23.5, "lower_radius_y_mm": math.inf, "upper_radius_x_mm": 23.5,
                     "upper_radius_y_mm": 200.0},
        "load": {"normal_N": 1500.0, "friction_coefficient": 0.34}, "layer": {"compliance_um_GPa": 0.7},
        "rolling": {"speed_m_s": 3.0}, "creepage": {"longitudinal": 0.02}})
    assert found.converged and 0.0 < found["gamma_st"] < 0.02 and found.uncertainty["gamma_st"] > 1e-3
    assert found.uncertainty["force_x_N"] < 1e-3 * found["friction_limit_N"]


def test_without_an_accuracy_it_is_the_usual_one(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL.replace("grid = 16", 'accuracy_of = ["forces"]'))
    done = call("run", tmp_path / "case.toml", "--json", "--no-plots", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["work"]["accuracy_of"] == ["forces"] and record["work"]["grid"][0] <= 64

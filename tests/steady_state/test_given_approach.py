"""A given approach and the load found for it."""

from __future__ import annotations

import dataclasses
import math

import pytest

from tests.support.profiles import CROWN, below
from tests.support.scenes import article_4_1, rolling
from thermoroll_cli import Case, CaseError
from thermoroll_cli.refinement.solve import solve
from thermoroll_cli.steady_state.given_approach import with_coarse_load

HOT = article_4_1(16)
PROBLEMS = {
    "Hertz": rolling(grid=16, creepage=(1e-3, 0.0)),
    "profile": rolling(grid=24, geometry=below(CROWN, 0.01), load=800.0, creepage=(5e-4, 0.0)),
    "hot": dataclasses.replace(HOT, heating=dataclasses.replace(HOT.heating, peclet="rolling")),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_load_of_an_approach_is_the_one_that_caused_it(name):
    problem = PROBLEMS[name]
    forward = solve(problem)
    approach = forward.coupled.scalars["approach_um"] * 1e-6
    back = solve(with_coarse_load(dataclasses.replace(problem, normal_force=2.0 * problem.normal_force, approach=approach)))
    assert back.converged, back.reason
    assert back.coupled.scalars["normal_N"] == pytest.approx(problem.normal_force, rel=1e-6)
    assert back.coupled.scalars["force_x_N"] == pytest.approx(forward.coupled.scalars["force_x_N"], rel=1e-4)
    assert math.isnan(back.error["approach_um"]) and math.isnan(forward.error["normal_N"])
    assert back.error["normal_N"] == pytest.approx(1.5 * forward.error["approach_um"], rel=0.5)
    assert back.error["force_x_N"] > forward.error["force_x_N"]


def test_the_error_of_the_load_covers_a_finer_grid():
    problem = PROBLEMS["profile"]
    given = with_coarse_load(dataclasses.replace(problem, approach=2.0e-6))
    coarse, fine = (solve(dataclasses.replace(given, numerics=dataclasses.replace(problem.numerics, grid=(n, n))))
                    for n in (24, 96))
    missed = abs(coarse.coupled.scalars["normal_N"] / fine.coupled.scalars["normal_N"] - 1.0)
    assert missed <= coarse.error["normal_N"] < 0.05


def test_a_case_gives_one_of_both():
    text = ("[material]\nyoungs_modulus_GPa = 210.0\npoisson_ratio = 0.3\n[geometry]\n"
            + "".join(f"{body}_radius_{axis}_mm = 20.0\n" for body in ("lower", "upper") for axis in "xy")
            + "[rolling]\nspeed_m_s = 1.0\n[load]\nfriction_coefficient = 0.3\n")
    case = Case.parse(text + "approach_um = 3.0\n")
    assert case.problem.approach == pytest.approx(3e-6)
    assert solve(case.problem).coupled.scalars["approach_um"] == pytest.approx(3.0, rel=1e-6)
    with pytest.raises(CaseError, match="approach_um"):
        Case.parse(text + "approach_um = 3.0\nnormal_N = 20.0\n")
    with pytest.raises(CaseError, match="normal_N"):
        Case.parse(text)


def test_an_approach_with_stationary_heat_is_refused():
    """The expansion is known up to a constant then; without deformation it does not matter."""
    with pytest.raises(CaseError, match=r"(?s)approach_um.*any constant.*normal_N"):
        Case.parse(STATIONARY)
    assert Case.parse(STATIONARY + "deformation = false\n").problem.approach == pytest.approx(3e-6)


STATIONARY = """
[material]
youngs_modulus_GPa = 210.0
poisson_ratio = 0.3
conductivity_W_mK = 50.0
expansion_um_mK = 11.7
diffusivity_mm2_s = 12.0
[geometry]
lower_radius_x_mm = 20.0
lower_radius_y_mm = 20.0
upper_radius_x_mm = 20.0
upper_radius_y_mm = 20.0
[load]
approach_um = 3.0
friction_coefficient = 0.3
[rolling]
speed_m_s = 1.0
[creepage]
longitudinal = 0.001
[thermal]
peclet = "stationary"
"""

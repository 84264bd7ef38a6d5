"""A given approach: the load of every kind of contact is found with it, for about the work of a given load."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from scripts.stress.populations import POPULATIONS
from tests.support.command_line import THERMAL
from tests.support.errors import relative
from tests.support.profiles import CROWN, GEOMETRIES, below
from tests.support.sampling import sampled
from tests.support.scenes import article_4_1, elastic, rolling
from thermoroll_cli import Case, CaseError
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.one_contact.steady_state.derived import pressed_to
from thermoroll_cli.physics.numerics.convolution import counted
from thermoroll_cli.problem.curved_patch import conformal_patch
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Layer, Problem
from thermoroll_cli.python_api import Solver, solve

ELASTIC = rolling(grid=16, creepage=(1e-3, 0.0))


def groove() -> Problem:
    problem = replace(ELASTIC, geometry=Geometry(0.005, 0.005, -0.03, -0.0055))
    return replace(problem, geometry=conformal_patch(problem.geometry, problem.compliance_shares))


def hot(factor: float) -> Problem:
    """The article's case with heat that moves with the bodies, which expand that much more."""
    problem = article_4_1(12)
    body = replace(problem.lower, expansion=factor * problem.lower.expansion)
    return replace(problem, lower=body, upper=body, heating=Heating(peclet="rolling"))


PROBLEMS = {
    "Hertz": ELASTIC,
    "profile": rolling(grid=16, geometry=below(CROWN, 0.01), load=800.0, creepage=(5e-4, 0.0)),
    "two patches": rolling(grid=32, geometry=GEOMETRIES["c_two_patches"], body=elastic(0.3), load=9e3, creepage=(5e-4, 0.0)),
    "conformal": groove(),
    "coated": replace(ELASTIC, lower=replace(ELASTIC.lower, layers=(Layer(20e-6, 500e9, 0.2),))),
    "shear coupling": replace(ELASTIC, lower=replace(ELASTIC.lower, poisson_ratio=0.45, youngs_modulus=3e9)),
    "prescribed force": replace(ELASTIC, motion=replace(ELASTIC.motion, creepage_x=None, force_x=5.0)),
    "hot": hot(100.0),
    "strong heat": hot(300.0),
    "hot profile": replace(hot(1000.0), geometry=below(CROWN, 0.01), normal_force=800.0),
}


@pytest.mark.parametrize("name", sampled(PROBLEMS, 9))
def test_the_load_of_an_approach_is_the_one_that_caused_it(name):
    """Within the errors of both, for their domains may differ: heat counts from its mean, and presses cold bodies less."""
    problem = PROBLEMS[name]
    before = counted.transforms
    forward = solve(problem)
    work = counted.transforms - before
    approach = forward.coupled.scalars["approach_um"] * 1e-6
    given = pressed_to(problem, approach)
    before = counted.transforms
    back = solve(given)
    assert forward.converged and back.converged, back.reason
    assert counted.transforms - before <= 1.6 * work
    missed = abs(back.coupled.scalars["normal_N"] / problem.normal_force - 1.0)
    error = 0.0 if math.isnan(relative(forward)["approach_um"]) else relative(forward)["approach_um"]
    assert missed <= relative(back)["normal_N"] + 1.5 * error + 1e-9
    assert relative(back)["normal_N"] < 0.3
    assert back.coupled.scalars["approach_um"] == pytest.approx(1e6 * approach, rel=1e-12)
    assert math.isnan(relative(back)["approach_um"]) and math.isnan(relative(forward)["normal_N"])
    assert back.problem.normal_force == back.coupled.scalars["normal_N"]
    assert back.of_problem["friction_limit_N"] == problem.friction.coefficient * back.problem.normal_force
    for force in ("force_x_N", "Q_F_W"):
        errors = [relative(result)[force] for result in (back, forward) if not math.isnan(relative(result)[force])]
        allowed = sum(errors) + 2.0 * (missed + 1e-9)
        scale = max(abs(forward.coupled.scalars[force]), 1e-300) if force == "Q_F_W" else forward.of_problem["friction_limit_N"]
        assert abs(back.coupled.scalars[force] - forward.coupled.scalars[force]) <= allowed * scale


def test_without_heat_and_shear_the_load_is_hertzs():
    hertz = hertz_contact(100.0, 100.0, ELASTIC.contact_modulus, 50.0)
    result = solve(pressed_to(replace(ELASTIC, geometry=Geometry(0.02, 0.02, 0.02, 0.02)), hertz.approach))
    assert result.coupled.scalars["normal_N"] == pytest.approx(50.0, rel=1e-6)
    assert result.coupled.scalars["pressure_max_MPa"] == pytest.approx(1e-6 * hertz.peak_pressure, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["profile", pytest.param("strong heat", marks=pytest.mark.slow)])
def test_load_and_approach_converge_at_second_order(name):
    """The mean of the expansion counts parts of elements: with whole ones the approach would be of first order."""
    problem, values = PROBLEMS[name], []
    for n in (16, 32, 64):
        on = replace(problem, numerics=replace(problem.numerics, grid=(n, n)))
        given = solve(on).coupled.scalars["approach_um"], solve(pressed_to(on, 2.2e-6)).coupled.scalars["normal_N"]
        values.append(given)
    for before, middle, last in zip(*values, strict=True):
        assert abs(last - middle) < 0.45 * abs(middle - before)
        assert abs(last / middle - 1.0) < 5e-3


def test_the_error_of_the_load_covers_a_finer_grid():
    given = pressed_to(PROBLEMS["profile"], 2.0e-6)
    coarse, fine = (solve(replace(given, numerics=replace(given.numerics, grid=(n, n)))) for n in (24, 72))
    missed = abs(coarse.coupled.scalars["normal_N"] / fine.coupled.scalars["normal_N"] - 1.0)
    assert missed <= relative(coarse)["normal_N"] < 0.05


def test_neighbours_may_be_pressed_by_a_load():
    """The isothermal pressure of one is not taken for that of the other."""
    solver, cold = Solver(), PROBLEMS["profile"]
    first = solver.solve(cold)
    given = pressed_to(cold, 1.1e-6 * first.coupled.scalars["approach_um"])
    assert solver.solve(given).coupled.scalars["normal_N"] == pytest.approx(
        solve(given).coupled.scalars["normal_N"], rel=1e-6)


def test_a_case_gives_one_of_both():
    text = ("[material]\nyoungs_modulus_GPa = 210.0\npoisson_ratio = 0.3\n[geometry]\n"
            + "".join(f"{body}_radius_{axis}_mm = 20.0\n" for body in ("lower", "upper") for axis in "xy")
            + "[rolling]\nspeed_m_s = 1.0\n[load]\nfriction_coefficient = 0.3\n")
    case = Case.parse(text + "approach_um = 3.0\n")
    assert case.problem.approach == pytest.approx(3e-6)
    assert solve(case.problem).coupled.scalars["approach_um"] == pytest.approx(3.0, rel=1e-12)
    with pytest.raises(CaseError, match="approach_um"):
        Case.parse(text + "approach_um = 3.0\nnormal_N = 20.0\n")
    with pytest.raises(CaseError, match="normal_N"):
        Case.parse(text)


def test_an_approach_with_stationary_heat_is_refused():
    """The expansion is known up to a constant then; without deformation it does not matter."""
    with pytest.raises(CaseError, match=r"(?s)approach_um.*any constant.*normal_N"):
        Case.parse(STATIONARY)
    assert Case.parse(STATIONARY + "deformation = false\n").problem.approach == pytest.approx(3e-6)


@pytest.mark.slow
def test_heat_that_parts_the_bodies_is_no_fault():
    """A random contact whose heat lifts one body off the other on the way to a steady state."""
    drawn = POPULATIONS["given approaches"].draw(660033)
    result = solve(drawn.problem)
    assert not result.converged and "no steady state was found" in result.reason


STATIONARY = THERMAL.replace("normal_N = 65.0", "approach_um = 3.0") + '[thermal]\npeclet = "stationary"\n'

"""An interlayer that hardens or softens: derivatives, closed forms, limits, CONTACT, and steps over time."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.documents import printed
from tests.support.problems import rolling
from thermoroll_cli import Case, CaseError, solve
from thermoroll_cli.many_contacts.history.course import Course, History
from thermoroll_cli.many_contacts.history.steps import Steps
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.rolling import rolling_solver
from thermoroll_cli.physics.rolling.hardening import Hardening
from thermoroll_cli.problem.friction import Interlayer
from thermoroll_cli.problem.problem import Problem

CREEPAGE = "creepage.longitudinal"


def layered(share: float, hardening: float, grid: int = 24, creepage: float = 0.002) -> Problem:
    """Spheres over an interlayer that yields at a `share` of the largest μp, and whose yield stress changes by `hardening`
    times that when the material slips by a thousandth of the contact's half-width."""
    problem = rolling(grid=grid, creepage=(creepage, 0.0))
    hertz = DerivedQuantities(problem).hertz
    bound = problem.friction.coefficient * hertz.peak_pressure
    return replace(problem, interlayer=Interlayer(0.0, share * bound, hardening * bound / (1e-3 * hertz.semi_axis_x)))


def force(problem: Problem) -> float:
    result = solve(problem)
    assert result.converged, result.reason
    return float(result.coupled.scalars["force_x_N"]) / problem.traction_limit


@pytest.mark.parametrize("rolls", [True, False])
@pytest.mark.parametrize("over_time", [True, False])
@pytest.mark.parametrize("rate", [3e13, 3e15, -1e14])
def test_the_derivative_is_that_of_the_factor(rate: float, *, over_time: bool, rolls: bool) -> None:
    generator = np.random.default_rng(2)
    slip, change = 1e-3 * generator.random((12, 5)), 1e-3 * generator.normal(size=(12, 5))
    covered = np.ones((12, 5))
    covered[0], covered[-1], covered[6, 2] = 0.3, 0.7, 0.0
    limit = 2e8 * np.sin(np.linspace(0.2, 2.9, 12))[:, None] * np.linspace(0.3, 1.0, 5) * (covered > 0.0)
    past = (1e6 * generator.random((12, 5)), 3e4, rolls) if over_time else ()
    layer = Hardening(np.minimum(limit, 6e7), limit, 6e7, rate, 1e-5, covered, *past)
    step, inside = 1e-6, covered > 0.0
    found = layer.response(slip).change(change)
    difference = (layer.response(slip + step * change).factor - layer.response(slip - step * change).factor) / (2.0 * step)
    if rate > 0.0:
        assert np.allclose(found[inside], difference[inside], rtol=1e-5, atol=1e-8)
    else:  # but for elements that begin to yield, whose share moves
        assert np.isclose(found[inside], difference[inside], rtol=1e-2, atol=1e-6).mean() > 0.7


@pytest.mark.parametrize("hardening", [0.02, 0.3, -0.02])
def test_a_layer_that_slides_as_a_whole_carries_what_it_has_hardened_to(hardening: float) -> None:
    """At large creepages ξ bodies are rigid: |τ| is μp, or c₀ + kξ times the distance from where μp exceeded that."""
    creepage, share = 0.05, 0.3
    problem = layered(share, hardening * 1e-3 / creepage, 32, creepage)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 801), np.linspace(0.0, 1.0, 400, endpoint=False) + 1.0 / 800.0, indexing="ij")
    bound = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    stress, carried = np.full(400, share), np.zeros(400)
    for row in bound:
        yields = row > stress
        carried += np.minimum(row, stress)
        stress = np.where(yields, np.clip(stress + hardening * (x[1, 0] - x[0, 0]), 0.1 * share, row), stress)
    exact = 2.0 * carried.sum() * (x[1, 0] - x[0, 0]) / 400.0 / (2.0 * math.pi / 3.0)
    assert force(problem) == pytest.approx(exact, rel=2e-3)


@pytest.mark.slow
def test_limits_are_perfect_yield_and_coulombs_friction() -> None:
    perfect, elastic = force(layered(0.3, 0.0)), force(rolling(grid=24, creepage=(0.002, 0.0)))
    forces = [force(layered(0.3, hardening)) for hardening in (-1e-4, 1e-4, 0.1, 5.0)]
    assert forces[0] < perfect < forces[1] and (np.diff(forces) > 0.0).all()
    assert perfect == pytest.approx(forces[0], rel=1e-3) and perfect == pytest.approx(forces[1], rel=1e-3)
    assert forces[-1] == pytest.approx(elastic, rel=0.02) and perfect < 0.8 * elastic


def test_lengths_are_a_scale() -> None:
    """k is a stress over a length."""
    problem = layered(0.4, 0.3)
    larger = replace(problem, normal_force=16.0 * problem.normal_force, interlayer=replace(
        problem.interlayer, hardening=0.25 * problem.interlayer.hardening), geometry=replace(
        problem.geometry, **{name: 4.0 * getattr(problem.geometry, name) for name in
                             ("lower_radius_x", "lower_radius_y", "upper_radius_x", "upper_radius_y")}))
    assert force(larger) == pytest.approx(force(problem), rel=1e-6)


CARTER = """
material = {{youngs_modulus_GPa = 209.92, poisson_ratio = 0.28}}
geometry = {{lower_radius_x_mm = inf, upper_radius_x_mm = 500.0}}
load = {{normal_N_mm = 178.9, friction_coefficient = 0.5}}
rolling.speed_m_s = 30.0
creepage.longitudinal = 0.0004
layer = {{yield_MPa = 35.0, hardening_MPa_um = {}}}
numerics.grid = 64
"""


@pytest.mark.parametrize(("hardening", "expected"), [(4018.0, 11_440.0), (123.0, 11_200.0), (0.0, 10_430.0), (-20.5, 9_668.0)])
def test_a_line_contact_has_the_force_of_contact(hardening: float, expected: float) -> None:
    """CONTACT's cases carter_plast on elements of 80, 40 and 20 µm, extrapolated: N for a length of 200 mm."""
    result = solve(Case.parse(CARTER.format(hardening)))
    rates = [rate.value for rate in printed("verification", "4018, 123, 0 and −20.5 MPa/µm")]
    theirs = printed("verification", "11,440, 11,200, 10,430 and 9,668 N,")[rates.index(hardening)]
    ours = printed("verification", "11,442, 11,198, 10,431 and 9,668 N.")[rates.index(hardening)]
    assert theirs.value == expected and result.converged
    assert 200.0 * result["force_x_N_mm"] == pytest.approx(ours.value, abs=ours.rounding)


def test_the_end_of_what_yields_may_move_over_all_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    """By one per Newton step: more steps than usual are allowed."""
    monkeypatch.setattr(rolling_solver, "MOST_NEWTON_STEPS", 6)
    assert solve(Case.parse(CARTER.format(4018.0).replace("grid = 64", "grid = 16"))).converged


def moments(problem: Problem, places: tuple[float, ...], steps: int, begin: object = "steady") -> list:
    assert problem.numerics.grid is not None
    course = Course(places, {CREEPAGE: (float(problem.motion.creepage_x or 0.0),) * len(places)}, True, steps,
                    begin=begin)  # type: ignore[arg-type]
    return list(Steps(History(problem, course), problem.numerics.grid).moments(course.rows))


def test_over_time_a_steady_state_stays_and_is_reached() -> None:
    problem = layered(0.3, 0.3, 16)
    a = DerivedQuantities(problem).hertz.semi_axis_x
    steady, pressed = moments(problem, (0.0, a), 4), moments(problem, (0.0, 8.0 * a), 16, "pressed")
    assert steady[-1].converged
    kept = [moment.reported.fields["yield_stress"] for moment in (steady[0], steady[-1])]
    inside = kept[0] > 0.0
    assert np.ptp(kept[0][inside]) > 0.2 * problem.interlayer.yield_stress
    np.testing.assert_allclose(kept[1][inside], kept[0][inside], rtol=2e-2)  # of elements that reach μp
    begins, stays, reached = (moment.reported.scalars["force_x_N"] for moment in (steady[0], steady[-1], pressed[-1]))
    assert stays == pytest.approx(begins, rel=5e-4) and reached == pytest.approx(begins, rel=2e-3)


BALL = CARTER.replace("normal_N_mm = 178.9", "normal_N = 2000.0").replace("grid = 64", "grid = 16").replace(
    "upper_radius_x_mm = 500.0", "upper_radius_x_mm = 500.0, lower_radius_y_mm = inf, upper_radius_y_mm = 500.0").format(123.0)


def test_a_state_in_a_file_knows_how_far_it_has_hardened(tmp_path: Path) -> None:
    """Without rolling two cases of one step are one of two: what has hardened counts in the second."""
    still = BALL.replace("speed_m_s = 30.0", "speed_m_s = 0.0").replace("creepage.longitudinal = 0.0004", "")

    def shifted(shifts: str, begin: str, steps: int) -> str:
        return (f'{still}\n[history]\ntime_s = [0, 1]\nsteps = {steps}\nbegin = "{begin}"\n'
                f'values = {{ "shift.longitudinal_um" = {shifts} }}\n')

    solve(Case.parse(shifted("[0, 2]", "pressed", 1))).save(tmp_path / "first.h5")
    second = solve(Case.parse(shifted("[2, 4]", str(tmp_path / "first.h5"), 1)))
    whole = solve(Case.parse(shifted("[0, 4]", "pressed", 2)))
    assert second.converged and whole.converged and whole.fields["yield_stress"].max() > 60e6
    assert second["force_x_N"] == pytest.approx(whole["force_x_N"], rel=1e-6)
    np.testing.assert_allclose(second.fields["yield_stress"], whole.fields["yield_stress"], rtol=1e-5)


def test_hardening_needs_a_yield_stress() -> None:
    with pytest.raises(CaseError, match="belongs to a yield stress"):
        Case.parse(BALL.replace("yield_MPa = 35.0", "compliance_um_GPa = 1.0"))

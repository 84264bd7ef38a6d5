"""Strong heat: the coupled states that are known exactly, from a cold start, on domains that follow the contact."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scripts.stress.random_cases import stress_case
from tests.support.documents import cell, printed
from tests.support.errors import relative
from tests.support.scenes import STEEL, article_4_1, reference, rolling, solved
from thermoroll_cli import Case
from thermoroll_cli.exact.heated_sphere import heated_sphere
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.python_api import Solver, solve

CASE = Case.read(Path(__file__).parents[2] / "cases" / "article_4_1.toml")
CASES = {case["Q_F_W"]: case for case in reference("heated_sphere")["cases"]}


def sliding(heat, grid):
    """Spheres that slide as a whole and make `heat` W, sources at rest."""
    speed = heat / 65.0 / 1e-4
    return rolling(grid=grid, friction=1e-4, creepage=(1.0, 0.0), speed=speed, heating=Heating(peclet="stationary"))


def transforms(result):
    """Transforms on all grids, each as much as its elements."""
    return sum(level["transforms"] * level["grid"][0] * level["grid"][1] for level in result.work["levels"])


def applications(result):
    """Applications of the normal and of the tangential operator, counted likewise."""
    return sum((level["applications"] + level["coupled_applications"] + level["coupled_normal_iterations"])
               * level["grid"][0] * level["grid"][1] for level in result.work["levels"])


@pytest.mark.slow
@pytest.mark.parametrize("heat", CASES)
def test_exact_states(heat):
    """At N = 128 from a cold start: γ_p to 3e-4, ΔT to 5e-4, γ_c to 2e-3, within the estimates, at bounded work; those that
    docs/verification.md has with the errors and the estimates printed there, of which the README names the largest."""
    result, known = solved(sliding(heat, 128)), CASES[heat]
    assert result.converged, result.reason
    (largest,) = printed("README", "7e-4, on 128 × 128")[:1]
    for name, key, tolerance in (("gamma_p", "gamma_p", 3e-4), ("gamma_c", "gamma_c", 2e-3),
                                 ("temperature_rise_max_lower_K", "temperature_rise_centre_K", 5e-4)):
        error = abs(result.coupled.scalars[name] / known[key] - 1.0)
        assert error < tolerance
        assert error < relative(result)[name]
        if heat in (2, 40, 160):
            column = {"gamma_p": "γ_p", "gamma_c": "γ_c"}.get(name, "ΔT")
            shown, estimate = cell("verification", f"{heat:.0f}", column)
            assert error <= shown.value + shown.rounding <= largest.value + largest.rounding
            assert relative(result)[name] == pytest.approx(estimate.value, abs=estimate.rounding)
    assert result.coupled.scalars["Q_F_W"] == pytest.approx(heat, rel=2e-5)
    for count, share in ((transforms, 3.0), (applications, 3.0)):
        assert count(result) < share * count(solved(sliding(11.28, 128)))


def test_the_usual_heat_is_cheap():
    """The work of the case that strong heat is measured against, over that of 128² elements."""
    assert transforms(solved(sliding(11.28, 128))) < 190 * 128**2


def on(result, state):
    """Elements and their area (m²), and the middle of the contact along x and y in semi-axes."""
    area = (state.x[1] - state.x[0]) * (state.y[1] - state.y[0])
    inside = state.fields["state"] > 0
    semi_axes = 1e-3 * result.of_problem["hertz_a_mm"], 1e-3 * result.of_problem["hertz_b_mm"]
    middle = [0.5 * (c[0] + c[-1]) / half for c, half in zip(
        (state.x[inside.any(axis=1)], state.y[inside.any(axis=0)]), semi_axes, strict=True)]
    return inside, area, middle


@pytest.mark.slow
@pytest.mark.parametrize("speeds", [
    (200.0, 250.0), pytest.param((450.0, 500.0), marks=pytest.mark.slow)])
def test_neighbours_do_not_decide_where_the_domain_goes(speeds):
    """At 250 m/s the contact leaves the usual domain for a while, and comes back; above 320 m/s it has one of its own."""
    solver = Solver()
    for speed in speeds:
        problem = CASE.with_values({"rolling.speed_m_s": speed, "numerics.grid": 24}).problem
        result, alone = solver.solve(problem), solve(problem)
        assert result.converged and alone.converged
        assert alone.own_grids == (speed > 320.0)
        assert result.work["domain_coupled_mm"] == alone.work["domain_coupled_mm"]
        summary = alone.summary()
        for name in ("Q_F_W", "force_x_N", "gamma_p", "gamma_c", "temperature_rise_max_lower_K", "thermal_displacement_max_um"):
            off = abs(result.coupled.scalars[name] - alone.coupled.scalars[name])
            assert off < 2e-5 * error_scale(name, summary), (speed, name)


@pytest.mark.slow
def test_the_domain_follows_a_contact_that_shrinks():
    """At 160 W it is a quarter as wide; each state has the whole of its contact, on a grid of its own, and carries the load."""
    result = solved(sliding(160, 64))
    assert result.converged, result.reason
    assert result.work["extent"] == 2.2 and 0.5 < result.work["extent_coupled"] < 0.9
    assert any("has followed the heated contact" in warning for warning in result.warnings)
    assert result.own_grids
    for state, across in ((result.coupled, 30), (result.isothermal, 55)):
        inside, area, middle = on(result, state)
        assert np.count_nonzero(inside.any(axis=1)) > across
        assert state.fields["pressure"].sum() * area == pytest.approx(65.0, rel=1e-6)
        assert state.fields["heat_flux"].sum() * area == pytest.approx(160.0, rel=1e-4)
        assert np.allclose(middle, 0.0, atol=0.02)
    assert result.isothermal.scalars["gamma_c"] == pytest.approx(1.0, rel=1e-3)
    cold = result.isothermal.fields["pressure"]
    assert cold.max() == pytest.approx(1e6 * result.of_problem["hertz_p0_MPa"], rel=2e-3)
    assert (result.isothermal.fields["state"][cold > 0] == 2).all()


def partly_sliding(grid, creepage=(0.003, 0.0), extent=2.2, speed=600.0, spin=0.0, radius_y=0.03):
    """Sources at rest under spheres that roll with creepage: half as hot behind the contact as in front of it."""
    problem = rolling(grid=grid, creepage=creepage, speed=speed, spin=spin, heating=Heating(peclet="stationary"),
                      geometry=Geometry(0.03, radius_y, 0.03, radius_y))
    return replace(problem, numerics=replace(problem.numerics, extent=extent))


@pytest.mark.slow
@pytest.mark.parametrize("radius_y", [0.03, pytest.param(0.09, marks=pytest.mark.slow)])
def test_the_domain_follows_a_contact_that_moves(radius_y):
    """Heat draws the contact to its trailing side. On the domain that follows it errors are less than half of those on one that
    holds it from the beginning, with as many elements, and the states agree."""
    followed = solved(partly_sliding(48, radius_y=radius_y))
    still = SolverOptions(most_moves=0)
    fixed, fine = (solve(partly_sliding(n, extent=3.4, radius_y=radius_y), options=still) for n in (48, 96))
    assert followed.converged and fixed.converged and fine.converged
    assert followed.work["extent"] == 2.2 and fine.work["extent_coupled"] == 3.4 and not fine.own_grids
    left, right, low, high = followed.work["domain_coupled_mm"]
    assert left + right > 0.25 * (right - left) and low == pytest.approx(-high)
    inside, _, (middle, across) = on(followed, followed.coupled)
    assert middle > 0.25 and across == pytest.approx(0.0, abs=1e-9)
    assert not (inside[0].any() or inside[-1].any() or inside[:, 0].any() or inside[:, -1].any())
    assert on(fine, fine.coupled)[2][0] == pytest.approx(middle, abs=0.03)
    missed = []
    for name in ("gamma_p", "gamma_c", "Q_F_W", "temperature_rise_max_lower_K", "force_x_N"):
        exact = fine.coupled.scalars[name]
        error, other = (abs(r.coupled.scalars[name] / exact - 1.0) for r in (followed, fixed))
        assert error < relative(followed)[name] + relative(fine)[name]
        missed.append(error / other)
    assert np.median(missed) < 0.5 and missed[0] < 0.4
    for name in ("gamma_p", "Q_F_W", "force_x_N"):
        assert followed.isothermal.scalars[name] == pytest.approx(fine.isothermal.scalars[name], rel=1e-3)


@pytest.mark.slow
def test_the_domain_follows_to_either_side():
    """Spin makes more heat on one side, and the contact moves there; reversed spin to the other side: mirror images."""
    right, left = (solved(partly_sliding(24, spin=spin)) for spin in (-8.0, 8.0))
    assert right.converged and left.converged and right.own_grids
    loads = [(r.coupled.fields["pressure"].sum(axis=0) * r.y).sum() / r.coupled.fields["pressure"].sum() for r in (right, left)]
    assert abs(loads[0]) > 0.03e-3 * right.of_problem["hertz_b_mm"]
    assert loads[0] == pytest.approx(-loads[1], rel=1e-3)
    np.testing.assert_allclose(right.y, -left.y[::-1], atol=1e-12)
    np.testing.assert_allclose(right.x, left.x, atol=1e-12)
    for name, sign in (("pressure", 1), ("shear_x", 1), ("shear_y", -1), ("temperature_rise_lower", 1)):
        one, other = right.coupled.fields[name], sign * left.coupled.fields[name][:, ::-1]
        np.testing.assert_allclose(one, other, atol=2e-3 * np.abs(one).max())


def test_a_contact_that_grows_gets_room():
    """Bodies that contract when warm: the heated contact is larger than its domain was."""
    body = replace(STEEL, expansion=-STEEL.expansion)
    result = solve(replace(partly_sliding(32, speed=200.0), lower=body, upper=body))
    assert result.converged, result.reason
    assert result.work["extent"] == 2.2 < result.work["extent_coupled"] and result.coupled.scalars["gamma_c"] > 1.15


def test_a_contact_that_keeps_its_size_keeps_its_domain():
    result = solved(sliding(11.28, 64))
    assert result.work["extent"] == result.work["extent_coupled"] == 2.2 and not result.warnings


@pytest.mark.slow
@pytest.mark.parametrize("heat", [640.0])
def test_heat_that_leaves_a_tenth_of_the_contact(heat):
    """Peaks of 172 and 306 times Hertz's are found from a cold start, within their estimates."""
    result = solved(sliding(heat, 64))
    exact = heated_sphere(STEEL.youngs_modulus / (1.0 - STEEL.poisson_ratio**2) / 2.0, 2.0 / 0.03, 65.0,
                          (1.0 + STEEL.poisson_ratio) * STEEL.expansion / STEEL.conductivity * heat / 65.0)
    assert result.converged, result.reason
    for name, value in (("gamma_p", exact.peak_ratio), ("gamma_c", exact.area_ratio)):
        assert abs(result.coupled.scalars[name] / value - 1.0) < min(relative(result)[name], 4e-3)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [98, 128])
def test_a_contact_that_partly_sticks_at_six_times_the_heat_of_the_article(elements):
    """1200 m/s instead of 200: beyond what turns that remember little find from a cold start, and what is given up after a
    dozen iterations without a gain: of 21 grids from 90 to 130 six had no steady state then. The peak lies on few elements and
    is 6.7 to 7.4 times Hertz's on them; the other values are of 128 elements."""
    found = solved(article_4_1(elements, 1200.0))
    assert found.converged and found.own_grids, found.reason
    assert found.coupled.fields["pressure"].sum() * on(found, found.coupled)[1] == pytest.approx(65.0, rel=1e-6)
    assert found.coupled.scalars["gamma_p"] == pytest.approx(7.05, rel=0.06)
    for name, value in (("gamma_c", 0.5618), ("Q_F_W", 69.10)):
        assert abs(found.coupled.scalars[name] / value - 1.0) < relative(found)[name] + 0.004, name


@pytest.mark.slow
def test_a_run_without_a_steady_state_ends_with_its_own_best_state():
    """The article's case at 4000 m/s: solved on its own grids alone, with finite fields, and a reason that names one cause, the
    share of the heat that was balanced, and the sweep that shows how far a state can be followed."""
    grids = []
    failed = solve(article_4_1(24, 4000.0), report=lambda stage, info: grids.append(tuple(info["grid"])))
    assert not failed.converged and failed.status == "not_converged"
    assert set(grids) == {(6, 6), (12, 12), (24, 24)} and len(grids) == 6
    causes = r"balance with more than [\d.]+ % of its own heat", "with all of the heat stopped", r"left each of \d+ domains"
    assert re.search("|".join(causes), failed.reason)
    assert "thermoroll sweep CASE --over rolling.speed_m_s=80:4000:14:log" in failed.reason
    assert "Coulomb" not in failed.reason and failed.reason.count(";") <= 3
    assert all(np.isfinite(field).all() for field in failed.coupled.fields.values())
    hottest = max(failed.coupled.scalars[f"temperature_rise_max_{body}_K"] for body in ("lower", "upper"))
    assert any(f"temperature rises by up to {hottest:.4g} K" in warning for warning in failed.warnings)


@pytest.mark.slow
def test_a_domain_does_not_follow_a_contact_that_the_iteration_lost():
    """On grids of a few elements it shrank until the coordinates of its elements were one number."""
    result = solve(stress_case(922).problem)
    assert not result.converged
    assert np.diff(result.x).min() > 1e-6 * np.abs(result.x).max()

"""Prescribed forces: creepages solved for in the same Newton system, in any mix, up to the friction limit. Symmetries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from scripts.stress.random_profiles import ROUGH, random_profile_contact
from tests.support.sampling import sampled
from tests.support.scenes import CASES, Dimensionless, ellipse, reference_problem, rolling, saturation, solved
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

N = 32


def carried(result: Result) -> dict[str, float]:
    """Forces (N) that the tractions of the isothermal state carry on their grid; reported ones may be extrapolated."""
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    return {axis: float(result.isothermal.fields[f"shear_{axis}"].sum() * area) for axis in "xy"}


def prescribing(problem: Problem, directions: str) -> Problem:
    """The same problem with the creep forces of its solution given instead of the creepages of `directions`."""
    forward, given = solved(problem).isothermal.scalars, dict[str, float | None]()
    for axis in directions:
        given |= {f"creepage_{axis}": None, f"force_{axis}": forward[f"force_{axis}_N"]}
    return replace(problem, motion=replace(problem.motion, **given))


def creepage_scale(problem: Problem) -> float:
    m = problem.motion
    return math.hypot(m.creepage_x or 0.0, m.creepage_y or 0.0) or saturation(problem).creepage


@pytest.mark.parametrize("directions", ["xy", "x", pytest.param("y", marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", CASES)
def test_forward_creepages_are_recovered(case, directions):
    """Force met to 1e-6 μW, creepage to 1e-4; with one force given, the other creepage and the spin stay as given."""
    forward = reference_problem(case, N)
    inverse = prescribing(forward, directions)
    result = solved(inverse)
    s, m = result.isothermal.scalars, forward.motion
    assert result.converged, result.reason
    for axis, wanted in zip("xy", (inverse.motion.force_x, inverse.motion.force_y), strict=True):
        if wanted is not None:
            assert s[f"force_{axis}_N"] == pytest.approx(wanted, abs=1e-6 * forward.traction_limit)
            assert carried(result)[axis] == pytest.approx(wanted, abs=1e-6 * forward.traction_limit)
    scale = creepage_scale(forward)
    assert s["creepage_longitudinal"] == pytest.approx(m.creepage_x, abs=1e-4 * scale)
    assert s["creepage_lateral"] == pytest.approx(m.creepage_y, abs=1e-4 * scale)
    assert s["creepage_spin_rad_mm"] == pytest.approx(m.spin * 1e-3, rel=1e-14)
    for given, name in ((("x" not in directions), "creepage_longitudinal"), (("y" not in directions), "creepage_lateral")):
        if given:
            assert s[name] == (m.creepage_x if name == "creepage_longitudinal" else m.creepage_y)


@pytest.mark.parametrize("case", CASES)
def test_forces_cost_at_most_half_as_much_again(case):
    """Applications on the finest grid and on the whole ladder, against the creepage case with the same answer."""
    forward = reference_problem(case, N)
    one, other = solved(forward), solved(prescribing(forward, "xy"))
    assert other.work["levels"][-1]["applications"] <= 1.5 * one.work["levels"][-1]["applications"]
    total = [sum(level["applications"] for level in r.work["levels"]) for r in (one, other)]
    assert total[1] <= 1.5 * total[0]


@pytest.mark.parametrize("angle", [0.0, 0.7, *(pytest.param(angle, marks=pytest.mark.slow) for angle in (math.pi / 2, -2.2))])
@pytest.mark.parametrize("share", [0.1, 0.9, 0.999, *(pytest.param(share, marks=pytest.mark.slow) for share in (0.5, 0.99))])
def test_forces_up_to_the_friction_limit_are_met(share, angle):
    """Newton does not need luck close to μW: the creepage stays below full slip and the force is met to 1e-6 μW."""
    limit = 0.3 * 65.0
    wanted = share * limit * math.cos(angle), share * limit * math.sin(angle)
    result = solved(rolling(grid=N, creepage=(None, None), force=wanted))
    s = result.coupled.scalars
    assert result.converged, result.reason
    assert (s["force_x_N"], s["force_y_N"]) == pytest.approx(wanted, abs=1e-6 * limit)
    creepage = np.array([s["creepage_longitudinal"], s["creepage_lateral"]])
    along = creepage @ np.array([math.cos(angle), math.sin(angle)])
    assert 0.0 < along < 1.3 * saturation(result.problem).creepage
    assert s["gamma_st"] > 0.0


@pytest.mark.parametrize("aspect", [0.2, 1.0, 4.0])
def test_no_force_under_spin_needs_a_lateral_creepage(aspect):
    """F_x = F_y = 0 with spin: the creepage that cancels Kalker's lateral force of spin, ξ_y > 0 for ξ_φ > 0."""
    base = rolling(grid=N, geometry=ellipse(aspect), creepage=(None, None), force=(0.0, 0.0))
    spin = 0.5 * saturation(base).spin
    result = solved(replace(base, motion=replace(base.motion, spin=spin)))
    s = result.coupled.scalars
    assert result.converged
    assert abs(s["force_x_N"]) < 1e-6 * base.traction_limit and abs(s["force_y_N"]) < 1e-6 * base.traction_limit
    assert s["creepage_lateral"] > 0.0
    assert abs(s["creepage_longitudinal"]) < 1e-5 * s["creepage_lateral"]


@pytest.mark.parametrize("force", [(25.0, None), (None, -19.6), (14.0, 14.0)])
def test_forces_beyond_the_friction_limit_are_refused_before_solving(force):
    creepage = tuple(0.0 if f is None else None for f in force)
    problem = rolling(grid=N, creepage=creepage, force=force)
    for start in (make_plan, solve):
        with pytest.raises(ValueError, match=r"what friction can carry, 0\.3 · 65 N = 19\.5 N"):
            start(problem)


def test_no_force_at_all_leaves_the_surfaces_sticking():
    result = solve(rolling(grid=32, creepage=(None, None), force=(0.0, 0.0)))
    s = result.coupled.scalars
    assert result.converged
    assert (s["creepage_longitudinal"], s["creepage_lateral"], s["force_x_N"], s["Q_F_W"]) == (0.0, 0.0, 0.0, 0.0)


def test_prescribed_force_in_the_coupled_state():
    """The coupled state meets the force with its own creepage, the isothermal one with another."""
    problem = rolling(grid=32, creepage=(None, None), force=(15.0, 0.0), speed=150.0, heating=Heating(peclet="stationary"))
    result = solved(problem)
    assert result.converged, result.reason
    for state in (result.coupled, result.isothermal):
        assert state.scalars["force_x_N"] == pytest.approx(15.0, abs=1e-5 * problem.traction_limit)
    cold, hot = (s.scalars["creepage_longitudinal"] for s in (result.isothermal, result.coupled))
    assert abs(hot - cold) > 0.01 * cold


# --- symmetries ---------------------------------------------------------------------------------------------------

MIXED = replace(rolling(grid=(18, 16), geometry=ellipse(0.6), creepage=(1e-3, 6e-4), spin=3.0, heating=Heating()),
                normal_force=100.0)
HOT = replace(MIXED, motion=Motion(150.0, 2e-3, 1e-3, 2.0, differential_slip=False), heating=Heating(peclet="stationary"))
FORCED = replace(MIXED, motion=Motion(1.0, None, 6e-4, 3.0, 12.0, None, differential_slip=False))
SOLVED = [pytest.param(MIXED, id="isothermal", marks=pytest.mark.slow), pytest.param(HOT, id="coupled"),
          pytest.param(FORCED, id="force", marks=pytest.mark.slow)]
ODD = ("shear_y", "slip_y")


def with_motion(problem: Problem, sign_x: float, sign_y: float, sign_spin: float) -> Problem:
    signs = {"creepage_x": sign_x, "force_x": sign_x, "creepage_y": sign_y, "force_y": sign_y, "spin": sign_spin}
    given = {name: getattr(problem.motion, name) for name in signs}
    return replace(problem, motion=replace(problem.motion, **{
        name: None if value is None else signs[name] * value for name, value in given.items()}))


@pytest.mark.slow
@pytest.mark.parametrize("problem", SOLVED)
def test_mirrored_in_y_the_lateral_force_and_spin_moment_change_sign(problem):
    one, other = solved(problem).coupled, solved(with_motion(problem, 1.0, -1.0, -1.0)).coupled
    for name in ("force_y_N", "spin_moment_Nmm", "creepage_lateral", "creepage_spin_rad_mm"):
        assert other.scalars[name] == pytest.approx(-one.scalars[name], rel=1e-7)
    for name in ("force_x_N", "Q_F_W", "gamma_st", "gamma_c", "gamma_p", "temperature_rise_max_lower_K"):
        assert other.scalars[name] == pytest.approx(one.scalars[name], rel=1e-7)
    for name, field in one.fields.items():
        sign, scale = (-1.0 if name in ODD else 1.0), float(np.abs(field).max())
        # The place of the stick border is a quotient of small differences.
        tolerance = 1e-6 if name == "stick_share" else 1e-7
        np.testing.assert_allclose(other.fields[name][:, ::-1], sign * field, atol=tolerance * scale)


@pytest.mark.parametrize("problem", SOLVED)
def test_reversed_creepages_reverse_all_tractions(problem):
    """Heat, pressure and areas stay; stationary bodies do not notice, moving ones exchange their speeds."""
    one, other = solved(problem).coupled, solved(with_motion(problem, -1.0, -1.0, -1.0)).coupled
    for name in ("force_x_N", "force_y_N", "spin_moment_Nmm"):
        assert other.scalars[name] == pytest.approx(-one.scalars[name], rel=1e-9)
    for name in ("Q_F_W", "gamma_st", "gamma_c", "gamma_p"):
        assert other.scalars[name] == pytest.approx(one.scalars[name], rel=1e-9)
    scale = np.abs(one.fields["shear_x"]).max()
    for name in ("shear_x", "shear_y"):
        np.testing.assert_allclose(other.fields[name], -one.fields[name], atol=1e-9 * scale)
    np.testing.assert_allclose(other.fields["temperature_rise_lower"], one.fields["temperature_rise_upper"], rtol=1e-6)
    np.testing.assert_allclose(other.fields["temperature_rise_upper"], one.fields["temperature_rise_lower"], rtol=1e-6)


def scaled(problem: Problem, length: float, stress: float, diffusivity: float) -> Problem:
    """Lengths × `length`, stresses × `stress`, κ and k × `diffusivity`: every dimensionless number is kept."""

    def body(b):
        return replace(b, youngs_modulus=b.youngs_modulus * stress, conductivity=b.conductivity * stress * diffusivity,
                       diffusivity=b.diffusivity * diffusivity)

    g, m, force = problem.geometry, problem.motion, length**2 * stress
    forces = {name: None if getattr(m, name) is None else force * getattr(m, name) for name in ("force_x", "force_y")}
    radii = (g.lower_radius_x, g.lower_radius_y, g.upper_radius_x, g.upper_radius_y)
    return replace(problem, lower=body(problem.lower), upper=body(problem.upper), normal_force=problem.normal_force * force,
                   geometry=Geometry(*(radius * length for radius in radii)),
                   motion=replace(m, speed=m.speed * diffusivity / length, spin=m.spin / length, **forces))


@pytest.mark.parametrize("problem", SOLVED)
@pytest.mark.parametrize("factors", sampled([(1e6, 1e-6, 1.0), (3.7e-3, 13.0, 0.29), (4.0, 2.0**-7, 8.0)], 3))
def test_dimensionless_results_do_not_depend_on_the_units(problem, factors):
    """Lengths, loads, speeds and constants scaled consistently: equal to the rounding of steps in single precision."""
    one, other = solved(problem), solved(scaled(problem, *factors))
    length, stress, _ = factors
    pairs = {
        "gamma_c": 1.0, "gamma_st": 1.0, "gamma_p": 1.0, "creepage_longitudinal": 1.0, "creepage_lateral": 1.0,
        "force_x_N": length**2 * stress, "force_y_N": length**2 * stress, "spin_moment_Nmm": length**3 * stress,
        "temperature_rise_max_lower_K": 1.0, "temperature_rise_max_upper_K": 1.0, "power_balance_error": 1.0,
        "approach_um": length, "thermal_displacement_max_um": length,
        "pressure_max_MPa": stress, "shear_max_MPa": stress,
    }  # fmt: skip
    for name, factor in pairs.items():
        expected = one.coupled.scalars[name]
        assert other.coupled.scalars[name] / factor == pytest.approx(expected, rel=1e-7, abs=1e-8), name
    gaps = [each.coupled.fields["gap"] for each in (one, other)]
    np.testing.assert_allclose(gaps[1] / length, gaps[0], atol=1e-6 * gaps[0].max())
    first, second = Dimensionless.of(one), Dimensionless.of(other)
    assert second.heat == pytest.approx(first.heat, rel=1e-7)
    assert second.applications == first.applications


def test_turning_bodies_upside_down_keeps_everything_but_the_temperatures_places():
    """Exchanging the bodies with the sign of the creepage is the same contact."""
    soft = replace(MIXED.lower, conductivity=20.0)
    one = replace(MIXED, lower=soft)
    other = with_motion(replace(MIXED, upper=soft), -1.0, -1.0, -1.0)
    first, second = solved(one).coupled, solved(other).coupled
    assert second.scalars["force_x_N"] == pytest.approx(-first.scalars["force_x_N"], rel=1e-9)
    lower, upper = first.scalars["temperature_rise_max_lower_K"], first.scalars["temperature_rise_max_upper_K"]
    assert second.scalars["temperature_rise_max_upper_K"] == pytest.approx(lower, rel=1e-6)
    assert second.scalars["temperature_rise_max_lower_K"] == pytest.approx(upper, rel=1e-6)
    assert lower > 1.5 * upper


@pytest.mark.slow
def test_a_rough_contact_that_mostly_sticks_takes_few_applications() -> None:
    """Elements that borders cut lie inside its runs of stick, and their own traction decides their slip: 723 applications if
    they are integrated along rolling with the others. The creepage is that of half as many elements a side."""
    problem = random_profile_contact(75001, ROUGH)
    found, coarse = (solve(replace(problem, numerics=Numerics(grid=(side, side)))) for side in (128, 64))
    assert found.converged and found.work["levels"][-1]["applications"] < 80
    names = "creepage_longitudinal", "gamma_st"
    assert all(abs(found[name] - coarse[name]) < coarse.uncertainty[name] for name in names)

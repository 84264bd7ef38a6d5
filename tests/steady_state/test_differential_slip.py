"""Differential (Heathcote) slip: against CONTACT, in closed form, its symmetries, and where it is left out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy

from scripts.closed_forms import heathcote
from tests.support.documents import cell
from tests.support.profiles import points
from tests.support.sampling import sampled
from tests.support.scenes import MECHANICAL, STEEL, elastic, reference, rolling, solved, spheres
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.halfspace.coatings import Coatings
from thermoroll_cli.physics.halfspace.layered import difference_compliance, halfspace_compliance
from thermoroll_cli.physics.rolling import differential_slip as module
from thermoroll_cli.problem.curved_patch import conformal_patch
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Problem, compliance_shares
from thermoroll_cli.python_api import solve

REFERENCES = reference("differential_slip")["cases"]
FORCES = ("force_x_N", "force_y_N")
GROOVE = Geometry(0.022, -0.0066, 0.00635, 0.00635)


def with_slip(**options) -> Problem:
    """A ball in a groove with differential slip."""
    groove = {"geometry": GROOVE, "body": elastic(0.3), "load": 500.0, "friction": 0.1, "differential_slip": True}
    return rolling(**groove | options)


def slip_of(problem: Problem) -> module.DifferentialSlip:
    return DerivedQuantities(problem).kinematics.differential_slip


def reference_case(name: str, grid: int) -> Problem:
    given = REFERENCES[name]["input"]
    radii = ("lower_radius_x_mm", "lower_radius_y_mm", "upper_radius_x_mm", "upper_radius_y_mm")
    return with_slip(
        grid=grid, geometry=Geometry(*(given[key] * 1e-3 for key in radii)), load=given["normal_N"],
        friction=given["friction_coefficient"], creepage=(given["longitudinal"], given["lateral"]),
        spin=given["spin_rad_mm"] * 1e3)


@pytest.mark.parametrize("name", sampled(sorted(REFERENCES, reverse=True)))
def test_contact_and_the_fine_grid_agree(name, monkeypatch):
    """Forces at N = 64 over μW; the moment over μW times the long semi-axis. CONTACT was given the part along rolling alone."""
    monkeypatch.setattr(Geometry, "lateral_slip", lambda _, shares, x, y: 0.0 * x * y)
    given, problem = REFERENCES[name], reference_case(name, 64)
    s, limit = solve(problem).coupled.scalars, problem.traction_limit
    assert slip_of(problem)(np.array([1e-3]))[0] == pytest.approx(given["c_1_mm2"], rel=1e-12)
    scales = dict.fromkeys(FORCES, limit) | {"spin_moment_Nmm": limit * max(given["semi_axes_mm"])}
    for key, scale in scales.items():
        assert abs(s[key] - given["with_the_term_N256"][key]) < 2e-4 * scale, key
        allowed = max(5e-4 * scale, given["contact_uncertainty"][key])
        assert abs(s[key] - given["contact_extrapolated"][key]) < allowed, key
    if name == "ball_in_groove_spin":
        for row, key in (("F_x", "force_x_N"), ("F_y", "force_y_N"), ("Q_F", "Q_F_W")):
            shown, uncertain = cell("verification", row, "groove with spin, N = 64")
            theirs = key if row != "Q_F" else "Q_F_W_at_1_m_s"
            scale = limit if row != "Q_F" else given["contact_extrapolated"][theirs]
            assert abs(s[key] - given["contact_extrapolated"][theirs]) / scale <= shown.value + shown.rounding, row
            assert given["contact_uncertainty"][theirs] / scale == pytest.approx(uncertain.value, abs=uncertain.rounding), row
    # CONTACT's own grids are far from their limit: 7 and 4 % in Q_F, so its extrapolation is not held against anything.
    fine = solve(reference_case(name, 128)).coupled.scalars
    assert fine["Q_F_W"] == pytest.approx(given["with_the_term_N256"]["Q_F_W_at_1_m_s"], rel=5e-4)
    assert fine["gamma_st"] == pytest.approx(given["with_the_term_N256"]["gamma_st"], abs=5e-4)


@pytest.mark.parametrize("name", REFERENCES)
def test_slip_across_rolling_on_a_fine_grid(name):
    """N = 64 against N = 256, with both parts of differential slip."""
    fine, problem = REFERENCES[name]["with_the_lateral_part_N256"], reference_case(name, 64)
    s = solved(problem).coupled.scalars
    for key in FORCES:
        assert abs(s[key] - fine[key]) < 2e-4 * problem.traction_limit, key
    assert s["Q_F_W"] == pytest.approx(fine["Q_F_W_at_1_m_s"], rel=2e-3)


@pytest.mark.parametrize("offset", [5e-3, -10e-3])
@pytest.mark.parametrize("at", ["contact", "origin"])
def test_it_does_not_matter_where_the_origin_lies(at, offset):
    """A crowned wheel beside y = 0 has the forces, the heat and the stick of one at y = 0, about the place where it touches."""
    def wheel(shift: float) -> Problem:
        profile = replace(points(lambda y: -(y**2) / 200.0, -40.0, 40.0, 161), offset=shift)
        geometry = Geometry(math.inf, math.inf, 0.46, math.inf, upper_profile=profile)
        problem = rolling(grid=24, geometry=geometry, load=40e3, creepage=(5e-4, 2e-4), spin=0.05, differential_slip=True)
        return replace(problem, motion=replace(problem.motion, at="contact"))

    here, there = wheel(0.0), wheel(offset)
    if at == "origin":
        slip, motion, place = slip_of(there), there.motion, np.array([offset])
        spin = motion.spin + float(slip.slope(place)[0])
        there = replace(there, motion=replace(
            motion, at=at, creepage_x=motion.creepage_x + spin * offset - float(slip(place)[0]), spin=spin))
    results = [solved(problem) for problem in (here, there)]
    one, other = (result.coupled.scalars for result in results)
    for key in (*FORCES, "Q_F_W", "gamma_st", "spin_moment_at_contact_Nmm"):
        assert other[key] == pytest.approx(one[key], rel=1e-6), key
    for key in ("Q_F_W", "gamma_st"):
        assert results[1].uncertainty[key] == pytest.approx(results[0].uncertainty[key], rel=1e-3), key


@pytest.mark.slow
def test_a_plane_is_the_limit_of_a_conformal_contact():
    """A ball in a groove with spin: all forces differ by the square of the width over the radius, at N = 32. F_y would
    be 11 % off with slip along rolling alone."""
    options = {"grid": 32, "creepage": (5e-4, 0.0), "spin": 10.0}
    differences = []
    for load in (100.0, 12.5):
        shapes = GROOVE, conformal_patch(GROOVE, (0.5, 0.5))
        plane, curved = (solved(with_slip(geometry=shape, load=load, **options)).coupled.scalars for shape in shapes)
        differences.append([abs(plane[key] / curved[key] - 1.0) for key in (*FORCES, "spin_moment_Nmm", "Q_F_W")])
    assert max(differences[0]) < 0.015 and max(differences[1]) < 0.005
    assert differences[1][1] == pytest.approx(differences[0][1] / 4.0, rel=0.3)


def full_sliding(grid: int) -> tuple[float, float, float]:
    """Neutral line over b, creepage over −c b² and Q_F/(μWV c b²) of a free-rolling ball in a groove without elastic slip."""
    problem = with_slip(grid=grid, friction=1e-6, creepage=(None, 0.0), force=(0.0, None))
    result = solved(problem)
    assert result.converged, result.reason
    b = DerivedQuantities(problem).hertz.semi_axis_y
    largest = float(slip_of(problem)(np.array([b]))[0])
    s, slip = result.coupled.scalars, result.coupled.fields["slip_x"][grid // 2]
    assert abs(s["force_x_N"]) < 1e-6 * problem.traction_limit and s["gamma_st"] == 0.0
    j = int(np.flatnonzero((slip[1:] > 0.0) & (slip[:-1] <= 0.0))[-1])
    neutral = result.y[j] - slip[j] * (result.y[j + 1] - result.y[j]) / (slip[j + 1] - slip[j])
    return neutral / b, -s["creepage_longitudinal"] / largest, s["Q_F_W"] / (problem.traction_limit * largest)


@pytest.mark.slow
def test_free_rolling_that_slides_everywhere():
    """Neutral lines at ±√ζ b, ξ = −ζ c b² and Q_F by quadrature. A slender contact, or slip along rolling alone, would have
    ζ = 4 sin² 10° and Q_F = 0.161142 μWV c b², as the load per width is ¾(1 − y²/b²) W/b."""
    assert heathcote(0.0) == pytest.approx((4.0 * math.sin(math.radians(10.0)) ** 2, 0.161142), rel=5e-4)
    hertz = DerivedQuantities(with_slip(grid=32)).hertz
    zeta, heat = heathcote(hertz.semi_axis_x / hertz.semi_axis_y)
    exact = math.sqrt(zeta), zeta, heat
    assert full_sliding(128) == pytest.approx(exact, rel=1e-3)
    # The neutral line lies where it lies, not on a column of elements.
    coarse = full_sliding(32)
    assert abs(full_sliding(128)[1] / exact[1] - 1.0) < 0.2 * abs(coarse[1] / exact[1] - 1.0)


def test_two_bodies_share_the_curvature_by_their_stiffness():
    problem = replace(with_slip(geometry=spheres(0.02)), lower=elastic(0.3, 70e9))
    shares = problem.compliance_shares
    assert sum(shares) == pytest.approx(1.0) and shares[0] == pytest.approx(0.75)
    rigid = replace(problem, upper=elastic(0.3, 1e20))
    # A rigid ball keeps its shape: the common surface is its own, y²/2R below.
    assert slip_of(rigid)(np.array([1e-3]))[0] == pytest.approx(0.5e-6 / 0.02 * (2.0 / 0.02))


def test_a_coated_body_takes_the_share_that_its_coating_gives_it():
    """The coefficients of y² of both displacements under √(1 − r²), with its load as weight, from Hankel's integral."""
    k = np.exp(np.linspace(math.log(1e-3), math.log(1e3), 6001))
    at = 0.5 * math.pi * (np.arange(100) + 0.5) / 100.0
    radius, weight = np.sin(at), np.sqrt(np.sin(at)) * np.cos(at)
    waves = scipy.special.j0(np.outer(radius, k)) * scipy.special.spherical_jn(1, k) * 1e-3

    def curvature(body: Material) -> float:
        top = halfspace_compliance(body.surface.youngs_modulus, body.surface.poisson_ratio).nn
        more = difference_compliance(body.layers, (body.youngs_modulus, body.poisson_ratio), k * 1e3).nn if body.layers else 0.0
        displacement = np.trapezoid((top + more) * waves, np.log(k), axis=1)
        return float(np.linalg.lstsq(np.stack((radius**0, radius**2), axis=1) * weight[:, None], displacement * weight)[0][1])

    body, other = elastic(0.3, 210e9), elastic(0.3, 70e9)
    for thickness, modulus in ((3e-5, 2.4e9), (1e-3, 2.4e9), (3e-4, 400e9)):
        coated = replace(body, layers=(Layer(thickness, modulus, 0.35),))
        found, parts = Coatings.of(coated, other).shares(1e-3, 1e-3), (curvature(coated), curvature(other))
        assert found == pytest.approx(np.array(parts) / sum(parts), abs=2e-3)
        assert Coatings.of(other, coated).shares(1e-3, 1e-3) == pytest.approx(found[::-1])
    # As thick as a body, it is one; as thin as nothing, there is none.
    for thickness, like in ((1.0, replace(body, youngs_modulus=2.4e9)), (1e-9, body)):
        thin = replace(body, layers=(Layer(thickness, 2.4e9, 0.3),))
        assert Coatings.of(thin, other).shares(1e-3, 2e-4) == pytest.approx(compliance_shares(like, other), abs=1e-4)


def test_a_thick_soft_coating_slips_as_a_body_of_its_material():
    """Free rolling of a steel ball in a steel groove with a coating of fourteen half-widths: with the shares of the steels
    a quarter of the heat would be missing."""
    soft, options = elastic(0.49, 3e9), {"geometry": Geometry(math.inf, -0.03, 0.02, 0.02), "load": 40.0, "grid": 24,
                                         "creepage": (None, 0.0), "force": (0.0, None)}
    whole, coated = (solved(replace(with_slip(**options), lower=lower)) for lower in (
        soft, replace(elastic(0.3, 210e9), layers=(Layer(6e-3, 3e9, 0.49),))))
    assert coated["Q_F_W"] == pytest.approx(whole["Q_F_W"], rel=0.01)


def test_a_curved_patch_warns_of_a_coating_that_its_surface_does_not_have():
    geometry = conformal_patch(GROOVE, (0.5, 0.5))
    for thickness, expected in ((2e-3, 1), (1e-7, 0)):
        lower = replace(elastic(0.3, 210e9), layers=(Layer(thickness, 20e9, 0.3),))
        warnings = solved(replace(with_slip(geometry=geometry, grid=16), lower=lower)).warnings
        assert sum("shares of the substrates" in text for text in warnings) == expected


@pytest.mark.slow
def test_turned_upside_down_it_is_the_same_contact():
    """Exchanging unlike bodies with the sign of the creepage reverses forces and keeps the heat; so does a mirror the spin."""
    geometry = Geometry(0.022, -0.0066, 0.00635, 0.00635)
    turned = Geometry(geometry.upper_radius_x, geometry.upper_radius_y, geometry.lower_radius_x, geometry.lower_radius_y)
    soft, stiff = elastic(0.35, 110e9), elastic(0.28)
    one = replace(with_slip(grid=32, geometry=geometry, creepage=(4e-4, 2e-4), spin=3.0), lower=soft, upper=stiff)
    motion = replace(one.motion, creepage_x=-4e-4, creepage_y=-2e-4, spin=-3.0)
    other = replace(one, geometry=turned, lower=stiff, upper=soft, motion=motion)
    mirrored = replace(one, motion=replace(one.motion, creepage_y=-2e-4, spin=-3.0))
    first, second, third = (solved(p).coupled.scalars for p in (one, other, mirrored))
    for key in ("force_x_N", "force_y_N", "spin_moment_Nmm"):
        assert second[key] == pytest.approx(-first[key], abs=2e-5 * one.traction_limit)
        sign = 1.0 if key == "force_x_N" else -1.0
        assert third[key] == pytest.approx(sign * first[key], abs=2e-5 * one.traction_limit)
    assert second["Q_F_W"] == pytest.approx(first["Q_F_W"], rel=2e-5)
    assert solved(one).work["skipped"].get("differential slip") is None


def test_half_the_contact_is_enough_for_longitudinal_rolling_only():
    longitudinal = make_plan(with_slip(grid=32, creepage=(1e-3, 0.0)))
    lateral = make_plan(with_slip(grid=32, creepage=(0.0, 1e-3)))
    assert "tangential, y < 0" in longitudinal.skipped and "tangential, y < 0" not in lateral.skipped


def test_plan_says_whether_it_runs():
    assert make_plan(with_slip(grid=32, creepage=(1e-3, 0.0))).runs("differential slip")
    off = make_plan(with_slip(grid=32, creepage=(1e-3, 0.0), differential_slip=False))
    assert off.skipped["differential slip"] == "switched off"
    equal = make_plan(with_slip(grid=32, geometry=spheres(0.03), creepage=(1e-3, 0.0)))
    assert equal.skipped["differential slip"].startswith("exactly zero")
    # With nothing else that moves it is all there is.
    alone = make_plan(with_slip(grid=32))
    assert alone.runs("tangential") and alone.runs("differential slip")
    assert solved(with_slip(grid=32)).coupled.scalars["Q_F_W"] > 0.0


def test_skipped_where_it_changes_nothing(monkeypatch):
    """Just below the threshold the plan leaves it out; forced to take part, no scalar notices by the accuracy asked for."""
    problem = with_slip(grid=48, geometry=Geometry(0.02, 0.02, 0.02, 0.02003), creepage=(4e-4, 0.0), friction=0.3)
    without = solved(problem)
    assert "changes nothing" in without.work["skipped"]["differential slip"]
    monkeypatch.setattr(module, "LARGEST_EFFECT", math.inf)
    taken = solve(replace(problem, title="taken"))  # another one, of which nothing is known yet
    assert "differential slip" not in taken.work["skipped"]
    for key in ("Q_F_W", "gamma_st", "shear_max_MPa"):
        assert taken.coupled.scalars[key] == pytest.approx(without.coupled.scalars[key], rel=1e-3)
    assert taken.coupled.scalars["force_x_N"] == pytest.approx(without.coupled.scalars["force_x_N"], abs=1e-3 * 150.0)
    assert taken.coupled.scalars["Q_F_W"] != without.coupled.scalars["Q_F_W"]


def test_hot_groove_keeps_its_balances():
    heating = Heating(peclet="stationary")
    problem = rolling(grid=32, geometry=GROOVE, load=500.0, friction=0.1, creepage=(None, 0.0), force=(0.0, None), speed=60.0,
                      heating=heating, differential_slip=True)
    result = solved(problem)
    assert result.converged, result.reason
    s = result.coupled.scalars
    # The force does no work on the creepage: all heat comes from the differential slip, more of it inside the smaller contact.
    assert abs(s["force_x_N"]) < 1e-5 * problem.traction_limit and s["Q_F_W"] > 0.0 and s["gamma_p"] > 1.01


def test_without_friction_there_is_no_traction():
    result = solved(replace(with_slip(grid=16, friction=0.0), lower=STEEL, upper=STEEL, motion=Motion(1.0), heating=MECHANICAL))
    assert result.converged and result.coupled.scalars["Q_F_W"] == 0.0

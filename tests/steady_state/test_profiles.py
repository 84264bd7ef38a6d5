"""Transverse profiles: against CONTACT, against the ellipses that they can stand for, ends, patches, symmetry, heat."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.documents import cell
from tests.support.errors import relative
from tests.support.profiles import CROWN, GEOMETRIES, REFERENCES, below, egg, points, solved_by_contact, two_bumps
from tests.support.sampling import sampled
from tests.support.scenes import STEEL, elastic, on_grid, order, rolling, solved
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, Kinematics
from thermoroll_cli.physics.contact.contact_scales import contact_scales
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.problem.geometry import Geometry, Profile, surfaces
from thermoroll_cli.problem.problem import Heating
from thermoroll_cli.python_api import Solver, solve

MODULUS = 210e9 / (2.0 * (1.0 - 0.3**2))
ARC = below(points(lambda y: -(y**2) / (2.0 * 40.0), -4.0, 4.0, 41), 0.02)
BALL = Geometry(math.inf, math.inf, 0.02, 0.04)


@pytest.mark.parametrize("load", [1e-12, 1e-6, 1.0])
def test_a_contact_between_two_samples_of_the_profile_is_found(load):
    """Of 4001 places across, 2 µm apart, none or one lies in the smallest contact, of 8 nm."""
    scales, hertz = contact_scales(ARC, Bodies(MODULUS), load), hertz_contact(1.0 / 0.02, 1.0 / 0.04, MODULUS, load)
    assert (scales.semi_axis_x, scales.semi_axis_y) == pytest.approx((hertz.semi_axis_x, hertz.semi_axis_y), rel=0.02)


# --- against CONTACT ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=() if name == "c_two_patches" else pytest.mark.slow)
    for name in REFERENCES if REFERENCES[name]["input"]["tangential"]])
def test_contact_agrees(name):
    """N = 128: forces within 3e-4 μW, p_max 3e-4, area 0.2 %, approach 1e-4, Q_F 1e-3, each plus CONTACT's uncertainty; and as
    docs/verification.md says."""
    problem, values = solved_by_contact(name, 128), REFERENCES[name]["values"]
    result = solved(problem)
    assert result.converged, result.reason
    s, limit = result.coupled.scalars, problem.traction_limit
    length = 1e3 * DerivedQuantities(problem).scales.mean_radius

    def close(value: float, key: str, tolerance: float) -> None:
        assert abs(value - values[key]["value"]) <= tolerance + values[key]["uncertainty"], key

    for key in ("force_x_N", "force_y_N"):
        close(s[key], key, 3e-4 * limit)
    close(s["spin_moment_Nmm"], "spin_moment_Nmm", 3e-4 * limit * length)
    close(s["pressure_max_MPa"], "pressure_max_MPa", 3e-4 * s["pressure_max_MPa"])
    close(s["contact_area_mm2"], "contact_area_from_fitted_borders_mm2", 2e-3 * s["contact_area_mm2"])
    close(1e-3 * s["approach_um"], "approach_mm", 1e-4 * 1e-3 * s["approach_um"])
    close(s["Q_F_W"], "frictional_power_W_at_1_m_s", 1e-3 * s["Q_F_W"])
    column = {"a3": "crowned roller, N = 128", "b_": "egg-shaped", "c_": "two patches with spin"}[name[:2]]
    for row, ours, theirs in (("F_x", "force_x_N", "force_x_N"), ("F_y", "force_y_N", "force_y_N"),
                              ("Q_F", "Q_F_W", "frictional_power_W_at_1_m_s"),
                              ("largest pressure", "pressure_max_MPa", "pressure_max_MPa"),
                              ("contact area", "contact_area_mm2", "contact_area_from_fitted_borders_mm2")):
        scale = limit if row.startswith("F") else values[theirs]["value"]
        if shown := cell("verification", row, column):
            assert abs(s[ours] - values[theirs]["value"]) / scale <= shown[0].value + shown[0].rounding, row
            assert values[theirs]["uncertainty"] / scale == pytest.approx(shown[1].value, abs=shown[1].rounding), row
    assert all(math.isnan(result.of_problem[key]) for key in ("hertz_a_mm", "hertz_b_mm", "hertz_p0_MPa", "kalker_C11"))
    assert s["gamma_c"] == 1.0 and s["gamma_p"] == 1.0
    assert sum(patch["force_x_N"] for patch in result.patches) == pytest.approx(s["force_x_N"], abs=3e-4 * limit)
    if name == "c_two_patches":
        for side, patch in zip(("left", "right"), result.patches, strict=True):
            for key in ("force_x_N", "force_y_N"):
                close(patch[key], f"{side}_{key}", 3e-4 * limit)
            close(patch["area_mm2"], f"{side}_contact_area_mm2", 2e-3 * patch["area_mm2"])
            assert patch["normal_N"] == pytest.approx(0.5 * problem.normal_force, rel=1e-6)


@pytest.mark.slow
def test_kalkers_frame_by_rotation_and_by_mirror():
    """A rotation about z turns lateral creepage and the profile, a mirror spin alone: both keep Kalker's signs of an asymmetric
    contact if profile, creepage and spin go together. Spin reversed on the same profile is another problem."""
    name, limit = "b_asymmetric_c3_2e-4", 0.3 * 2e4
    turned = solved_by_contact(name, 48)
    motion = turned.motion
    mirrored = replace(turned, geometry=below(points(lambda y: egg(-y), -6.0, 6.0), 0.3),
                       motion=replace(motion, creepage_y=-motion.creepage_y, spin=-motion.spin))
    other = replace(turned, motion=replace(motion, spin=-motion.spin))
    one, two, wrong = (solved(problem).coupled.scalars for problem in (turned, mirrored, other))
    contact = {key: REFERENCES[name]["values"][key]["value"] for key in ("force_x_N", "force_y_N")}
    assert one["force_x_N"] == pytest.approx(contact["force_x_N"], abs=1e-3 * limit)
    assert one["force_y_N"] == pytest.approx(contact["force_y_N"], abs=1e-3 * limit)
    for key, sign in (("force_x_N", 1.0), ("force_y_N", -1.0), ("spin_moment_Nmm", -1.0), ("Q_F_W", 1.0)):
        assert two[key] == pytest.approx(sign * one[key], rel=1e-6)
    assert abs(wrong["force_y_N"] - one["force_y_N"]) > 0.05 * limit


def test_pressure_of_a_crowned_roller_along_its_length():
    """CONTACT's pressure on x = 0, every half millimetre; and none of the grids has a spike where the roller ends."""
    for grid in (32, 64):
        result = solved(solved_by_contact("a1_crowned_roller_normal", grid))
        pressure = result.coupled.fields["pressure"][grid // 2]
        for point in REFERENCES["a1_crowned_roller_normal"]["pressure_on_x0"]:
            if abs(point["y_mm"]) <= 4.5:
                at = np.interp(1e-3 * point["y_mm"], result.y, pressure) * 1e-6
                assert at == pytest.approx(point["p_MPa"], rel=1e-2 if grid == 32 else 2e-3)
        assert result.coupled.fields["pressure"].max() < 1.01 * pressure.max()
        assert result.coupled.scalars["pressure_max_MPa"] == pytest.approx(891.52, rel=2e-3)


# --- ellipses in disguise ---------------------------------------------------------------------------------------------


def both(grid: int, **motion):
    options = {"grid": grid, "body": elastic(0.3), "load": 400.0, "friction": 0.2, "differential_slip": True} | motion
    return solved(rolling(geometry=ARC, **options)), solved(rolling(geometry=BALL, **options))


@pytest.mark.slow
def test_an_arc_of_points_is_the_elliptic_contact():
    """N = 128, with differential slip: all scalars within 1e-4 (forces of μW), in at most twice the applications."""
    arc, ball = both(128, creepage=(6e-4, 3e-4), spin=0.3)
    one, other, limit = arc.coupled.scalars, ball.coupled.scalars, arc.problem.traction_limit
    assert arc.converged and ball.converged
    for key in ("force_x_N", "force_y_N"):
        assert abs(one[key] - other[key]) < 1e-4 * limit, key
    arm = 1e3 * DerivedQuantities(ball.problem).scales.mean_radius
    assert abs(one["spin_moment_Nmm"] - other["spin_moment_Nmm"]) < 1e-4 * limit * arm
    for key in ("Q_F_W", "pressure_max_MPa", "contact_area_mm2", "approach_um"):
        assert one[key] == pytest.approx(other[key], rel=1e-4), key
    assert one["gamma_st"] == pytest.approx(other["gamma_st"], abs=3e-4)
    assert arc.work["levels"][-1]["applications"] <= 2 * ball.work["levels"][-1]["applications"]
    assert arc.patches[0]["pressure_max_MPa"] == pytest.approx(other["pressure_max_MPa"], rel=1e-4)


def test_its_pressure_converges_at_second_order():
    exact = hertz_contact(BALL.curvature_x, BALL.curvature_y, MODULUS, 400.0)
    errors = {key: [] for key in ("approach_um", "pressure_max_MPa")}
    for grid in (12, 24, 48):
        s = solved(rolling(grid=grid, geometry=ARC, body=elastic(0.3), load=400.0)).coupled.scalars
        errors["approach_um"].append(s["approach_um"] / (1e6 * exact.approach) - 1.0)
        errors["pressure_max_MPa"].append(s["pressure_max_MPa"] / (1e-6 * exact.peak_pressure) - 1.0)
    for key, error in errors.items():
        assert abs(error[-1]) < 2e-4 and abs(error[-1]) < 0.5 * abs(error[0]), (key, error)


def test_heat_bulges_an_arc_as_it_does_the_ellipse():
    """γ_c and γ_p relate to the cold contact: for an arc that is Hertz's."""
    heating = Heating(peclet="stationary")
    options = {"grid": 16, "body": STEEL, "load": 65.0, "creepage": (0.003, 0.0), "speed": 100.0, "heating": heating}
    arc = solved(rolling(geometry=below(points(lambda y: -(y**2) / 30.0, -1.0, 1.0, 41), 0.015), **options))
    ball = solved(rolling(geometry=Geometry(math.inf, math.inf, 0.015, 0.015), **options))
    assert arc.converged, arc.reason
    for key in ("gamma_c", "gamma_p", "Q_F_W", "temperature_rise_max_lower_K"):
        assert arc.coupled.scalars[key] == pytest.approx(ball.coupled.scalars[key], rel=3e-3), key
    assert ball.coupled.scalars["gamma_p"] > 1.1 and arc.isothermal.scalars["gamma_p"] == 1.0


def test_tilt_and_offset_move_an_arc():
    """A parabola tilted by t is the same parabola moved by t R, and an offset moves it back: the contact is the centred one."""
    tilt, radius = 5e-3, 0.04
    profile = points(lambda y: -(y**2) / 80.0, -4.0, 4.0, 41, tilt=tilt, offset=-tilt * radius)
    assert below(profile, 0.02).first_touch[0] == pytest.approx(0.0, abs=1e-9)
    turned = solved(rolling(grid=16, geometry=below(profile, 0.02), body=elastic(0.3), load=400.0))
    straight = solved(rolling(grid=16, geometry=ARC, body=elastic(0.3), load=400.0))
    for key in ("approach_um", "pressure_max_MPa", "contact_area_mm2"):
        assert turned.coupled.scalars[key] == pytest.approx(straight.coupled.scalars[key], rel=2e-3), key


# --- closed forms --------------------------------------------------------------------------------------------------


def test_two_bumps_far_apart_are_two_hertz_contacts():
    """Each carries half the load; the approach exceeds Hertz's by the cross-talk W₁/(πE* d)."""
    radius, distance = 0.02, 10e-3

    def bumps(y):
        return -((np.abs(y) - 0.5e3 * distance) ** 2) / (2.0 * 1e3 * radius)

    apart = points(bumps, -6.0, 6.0, 1201, interpolation="linear")
    result = solved(rolling(grid=(32, 512), geometry=below(apart, radius), body=elastic(0.3), load=600.0))
    hertz = hertz_contact(1.0 / radius, 1.0 / radius, MODULUS, 300.0)
    assert [patch["normal_N"] for patch in result.patches] == pytest.approx([300.0, 300.0], rel=1e-6)
    assert [patch["y_mm"] for patch in result.patches] == pytest.approx([-5.0, 5.0], abs=2e-3)
    cross_talk = 300.0 / (math.pi * MODULUS * distance)
    assert 1e-6 * result.coupled.scalars["approach_um"] - hertz.approach == pytest.approx(cross_talk, rel=0.15)
    assert result.coupled.scalars["pressure_max_MPa"] == pytest.approx(1e-6 * hertz.peak_pressure, rel=1e-2)


def test_a_long_roller_presses_like_a_cylinder_away_from_its_ends():
    """p₀ = sqrt(W' E*/πR) with the load per length W' of the middle."""
    long = Profile(length=0.1, drop=2e-6)
    result = solved(rolling(grid=(64, 128), geometry=below(long, 0.01), body=elastic(0.3), load=20e3))
    pressure = result.coupled.fields["pressure"]
    middle = pressure[:, 64]
    per_length = float(middle.sum()) * (result.x[1] - result.x[0])
    assert middle.max() == pytest.approx(math.sqrt(per_length * MODULUS / (math.pi * 0.01)), rel=2e-3)


def test_a_rigid_common_surface_gives_the_slip_of_its_profile():
    """d(y) of the two-bump profile on a flat body: half of its height (equal bodies) over the radius; and its slope."""
    problem = rolling(geometry=GEOMETRIES["c_two_patches"], body=elastic(0.3), differential_slip=True)
    y = np.linspace(-6e-3, 6e-3, 7)
    expected = -0.5 * 1e-3 * (two_bumps(1e3 * y) - two_bumps(np.zeros(1))) / 0.3
    slip = DerivedQuantities(problem).kinematics.differential_slip
    np.testing.assert_allclose(slip(y), expected, atol=1e-9)
    step = 1e-7
    np.testing.assert_allclose(slip.slope(y), (slip(y + step) - slip(y - step)) / (2.0 * step), atol=1e-6)


# --- ends --------------------------------------------------------------------------------------------------------------


ENDS = {"body": elastic(0.3), "load": 400.0, "friction": 0.2, "creepage": (6e-4, 0.0)}


@pytest.mark.slow
def test_a_contact_at_an_end_is_marked():
    """An arc that ends 0.1 mm beside its top: pressure without limit there, marked and without an error estimate."""
    cut = below(points(lambda y: -(y**2) / 80.0, -0.1, 4.0, 42), 0.02)
    assert contact_scales(cut, Bodies(MODULUS), 400.0).ends == (True, False)
    problem = rolling(grid=32, geometry=cut, differential_slip=True, **ENDS)
    result = solved(problem)
    assert result.converged, result.reason
    assert any("no upper bound" in warning for warning in result.warnings)
    assert {"pressure_max_MPa", "gamma_p"} <= set(result.summary()["unbounded"])
    assert math.isnan(relative(result)["pressure_max_MPa"]) and relative(result)["force_x_N"] < 0.05
    # The grid begins where the material does, and the pressure is highest there: more so on a finer grid.
    assert result.y[0] - 0.5 * (result.y[1] - result.y[0]) == pytest.approx(-1e-4)
    fine = solved(rolling(grid=64, geometry=cut, differential_slip=True, **ENDS)).coupled.scalars["pressure_max_MPa"]
    assert fine > 1.05 * result.coupled.scalars["pressure_max_MPa"]
    assert int(np.argmax(result.coupled.fields["pressure"].max(axis=0))) == 0
    whole = solved(rolling(grid=32, geometry=ARC, **ENDS))
    assert not whole.warnings and "unbounded" not in whole.summary()


def test_a_sharp_roller_is_solved_and_marked():
    """A contact past both ends: the middle presses as a line contact does, the ends press harder."""
    sharp = below(points(lambda y: 0.0 * y, -5.0, 5.0, 5), 0.02)
    result = solved(rolling(grid=32, geometry=sharp, **ENDS))
    assert result.converged and {"pressure_max_MPa", "gamma_p"} <= set(result.summary()["unbounded"])
    assert any("both ends" in warning and "relieve the ends" in warning for warning in result.warnings)
    pressure = result.coupled.fields["pressure"]
    per_length = float(pressure[:, 16].sum()) * (result.x[1] - result.x[0])
    assert pressure[:, 16].max() == pytest.approx(math.sqrt(per_length * MODULUS / (math.pi * 0.02)), rel=2e-2)
    assert per_length == pytest.approx(400.0 / 0.01, rel=0.1)
    assert (pressure[16, [0, -1]] > 1.1 * pressure[16, 16]).all()


def test_profiles_that_never_face_each_other():
    apart = Geometry(math.inf, math.inf, 0.02, math.inf, points(egg, -6.0, -2.0), points(egg, 2.0, 6.0))
    with pytest.raises(ValueError, match="never face each other"):
        apart.across(np.zeros(1))


# --- what works for ellipses works for profiles ---------------------------------------------------------------------------


@pytest.mark.slow
def test_symmetric_profiles_keep_the_half_problem(monkeypatch):
    problem = rolling(grid=32, geometry=GEOMETRIES["c_two_patches"], body=elastic(0.3), load=2e4, creepage=(1e-3, 0.0),
                      differential_slip=True)
    assert "tangential, y < 0" in make_plan(problem).skipped
    half = solved(problem)
    assert "tangential, y < 0" not in make_plan(replace(problem, geometry=GEOMETRIES["b_asymmetric_c3_2e-4"])).skipped
    monkeypatch.setattr(Kinematics, "mirror", None)
    whole = Solver().solve(replace(problem, title="whole"))  # another one, of which nothing is known yet
    for key in ("force_x_N", "Q_F_W"):
        assert half.coupled.scalars[key] == pytest.approx(whole.coupled.scalars[key], rel=1e-4)


@pytest.mark.slow
def test_prescribed_forces_and_matched_heat():
    """The sum of both patches is the force asked for; heat, differential slip and spin take part."""
    heating = Heating(peclet="rolling", partition="matched", bulk_upper=50.0)
    problem = rolling(grid=32, geometry=GEOMETRIES["c_two_patches"], load=2e4, creepage=(None, 0.0), force=(2000.0, None),
                      spin=-0.1, heating=heating, differential_slip=True)
    result = solved(problem)
    assert result.converged, result.reason
    assert sum(patch["force_x_N"] for patch in result.patches) == pytest.approx(2000.0, abs=1e-5 * problem.traction_limit)
    assert result.coupled.scalars["temperature_rise_max_lower_K"] > 5.0


@pytest.mark.slow
def test_neighbours_of_a_sweep_with_and_without_the_same_profile():
    one = rolling(grid=16, geometry=GEOMETRIES["b_asymmetric_c3_2e-4"], body=elastic(0.3), load=2e4, creepage=(1.5e-3, 5e-4))
    moved = replace(one.geometry, upper_profile=replace(one.geometry.upper_profile, tilt=2e-3))
    faster = replace(one, motion=replace(one.motion, creepage_x=1.6e-3))
    other = replace(one, geometry=moved)
    solver = Solver()
    for problem in (one, faster, other, one):
        again = solver.solve(problem).coupled.scalars
        for key in ("force_x_N", "pressure_max_MPa"):
            assert again[key] == pytest.approx(solved(problem).coupled.scalars[key], rel=5e-5)


def test_surfaces_say_where_half_spaces_are_doubtful():
    steep = below(points(lambda y: -(y**2) / 2.0, -4.0, 4.0, 41), 0.02)
    warnings = make_plan(rolling(grid=16, geometry=steep, load=30e3)).warnings
    assert any("inclined by" in text for text in warnings) and any("of the radius of curvature" in text for text in warnings)
    assert not make_plan(rolling(grid=16, geometry=GEOMETRIES["a1_crowned_roller_normal"], load=2000.0)).warnings


@pytest.mark.parametrize("interpolation", ["cubic", "linear"])
def test_surfaces_and_their_derivatives(interpolation):
    profile = points(egg, -6.0, 6.0, 25, interpolation=interpolation, offset=1e-4, tilt=3e-3)
    (_, surface), y, step = surfaces(below(profile, 0.3)), np.linspace(-5.8e-3, 5.8e-3, 11), 1e-8
    expected = (surface.height(y + step) - surface.height(y - step)) / (2.0 * step)
    np.testing.assert_allclose(surface.slope(y), expected, atol=1e-5)
    assert np.isinf(surface.height(np.array([-7e-3, 7e-3]))).all()
    crown = surfaces(below(CROWN, 0.01))[1]
    np.testing.assert_allclose(crown.height(np.array([0.0, 3e-3])), [0.0, 1e-6 * math.log(1.0 - 0.36)])
    flat = surfaces(below(replace(CROWN, flat=5e-3), 0.01))[1]
    np.testing.assert_allclose(flat.height(np.array([2.4e-3, 4e-3])), [0.0, 1e-6 * math.log(1.0 - 0.6**2)])


# --- convergence and estimates ------------------------------------------------------------------------------------------

ORDERS = {
    "cubic": (GEOMETRIES["b_asymmetric_c3_2e-4"], 2e4, 1.7),
    "bumps": (GEOMETRIES["c_two_patches"], 2e4, 1.5),
    "kink": (below(points(lambda y: np.where(y < 0.0, -(y**2) / 80.0, -(y**2) / 200.0), -4.0, 4.0, 321), 0.02), 400.0, 1.0),
    "crown": (GEOMETRIES["a1_crowned_roller_normal"], 2000.0, 1.0),
}
"""Geometry, load in N, and the order that must be seen: a kink in the curvature keeps at least the first."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", sampled(ORDERS, 4))
def test_order_of_convergence(kind):
    """Forces, heat, approach and largest pressure at N = 16, 32, 64 against 128."""
    geometry, load, least = ORDERS[kind]
    base = rolling(grid=16, geometry=geometry, body=elastic(0.3), load=load, friction=0.2, differential_slip=True)
    size = DerivedQuantities(base).saturation_creepage
    values = {}
    for grid in (16, 32, 64, 128):
        motion = replace(base.motion, creepage_x=0.4 * size, creepage_y=0.2 * size)
        s = solved(replace(on_grid(base, grid), motion=motion)).coupled.scalars
        values[grid] = np.array([s[key] for key in ("force_x_N", "Q_F_W", "approach_um", "pressure_max_MPa")])
    errors = [float(np.abs(values[grid] / values[128] - 1.0).max()) for grid in (16, 32, 64)]
    assert order([16, 32, 64], errors) > least
    assert errors[-1] < 3e-3


def test_a_pressure_that_has_not_converged_is_no_result(monkeypatch):
    """Neither that of the grid nor the coarse one from which the domain follows."""
    solve_normal = NormalSolver.solve
    monkeypatch.setattr(NormalSolver, "solve", lambda *args: replace(solve_normal(*args), converged=False))
    result = solve(rolling(grid=16, geometry=GEOMETRIES["c_two_patches"], body=elastic(0.3), load=1.9e4, creepage=(1e-3, 0.0)))
    assert not result.converged
    assert "isothermal state: the pressure has not converged" in result.reason
    assert "the coarse pressure from which the domain follows has not converged" in result.reason

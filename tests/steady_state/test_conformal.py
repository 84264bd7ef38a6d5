"""Conformal contacts: the limit of small angles, free rolling and full sliding in a groove, power, and the case of the page."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import thermoroll_cli
from tests.support.command_line import call
from tests.support.profiles import points
from tests.support.scenes import elastic, order, rolling, solved
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.case_errors import CaseError
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.curved_patch import CurvedPatch, conformal_patch
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.problem import Problem

GROOVE = Geometry(0.022, -0.006604, 0.00635, 0.00635)
CASE = Path(thermoroll_cli.__file__).parent.parent / "cases" / "ball_in_groove.toml"


def ball(conformal: bool = True, geometry: Geometry = GROOVE, **options) -> Problem:
    """A ball in a groove of osculation 0.52."""
    shape = conformal_patch(geometry, (0.5, 0.5)) if conformal else geometry
    return rolling(**{"grid": 32, "geometry": shape, "body": elastic(0.3), "load": 1000.0, "friction": 0.1,
                      "creepage": (5e-4, 0.0), "differential_slip": True} | options)


@pytest.mark.slow
def test_small_angles_are_those_of_a_plane():
    """The pressure and the approach differ by the square of the angle; a longitudinal force without spin likewise."""
    loads = np.array([800.0, 100.0, 12.5])
    differences = []
    for load in loads:
        curved, plane = (solved(ball(conformal, load=load)).coupled.scalars for conformal in (True, False))
        differences.append([abs(curved[name] / plane[name] - 1.0) for name in ("approach_um", "pressure_max_MPa")])
        assert curved["force_x_N"] == pytest.approx(plane["force_x_N"], rel=5e-3)
    approach, pressure = np.array(differences).T
    # The width of the contact grows like the third root of the load.
    assert order(1.0 / np.cbrt(loads), approach) == pytest.approx(2.0, abs=0.2)
    assert pressure[0] < 0.02 and order(1.0 / np.cbrt(loads[:2]), pressure[:2]) == pytest.approx(2.0, abs=0.2)


def test_a_vertical_force_is_that_of_pressure_and_traction(tmp_path):
    """Spin has a lateral traction on the inclined surface: a force of .1 % along z."""
    case = Case.read(CASE).with_values({"numerics.grid": [16, 32]})
    given = thermoroll_cli.solve(case)
    found = thermoroll_cli.solve(case.with_values({"load.vertical_N": given["contact_force_z_N"]}))
    assert given["contact_force_z_N"] - 1000.0 > 0.5 and math.isnan(given.uncertainty["normal_N"])
    assert found["normal_N"] == pytest.approx(1000.0, rel=1e-5) and found.uncertainty["normal_N"] > 0.0
    assert found["contact_force_z_N"] == pytest.approx(given["contact_force_z_N"], rel=1e-5)
    assert found.uncertainty["contact_force_z_N"] < 0.02 < found.uncertainty["force_x_N"] - given.uncertainty["force_x_N"]
    found.save(tmp_path / "found.h5")
    assert read_result(tmp_path / "found.h5").problem == found.problem and found.problem.vertical == given["contact_force_z_N"]
    with pytest.raises(CaseError, match=r"normal_N, or geometry\.conformal = true"):
        case.with_values({"load.vertical_N": 1000.0, "geometry.conformal": False})
    both = tmp_path / "both.toml"
    both.write_text(CASE.read_text().replace("[load]\n", "[load]\nvertical_N = 1000.0\n"))
    with pytest.raises(CaseError, match="a normal load, or a vertical force"):
        Case.read(both)


@pytest.mark.slow
@pytest.mark.parametrize(("radii", "load"), [
    ((0.012, 0.05, 0.06, -0.052), 8000.0),  # the barrel's axis lies within its radius across
    ((0.02, 0.02, 0.02, 0.03), 100.0),
    ((math.inf, 0.036757, 0.02637, 0.05794), 700.9),
    ((0.02, 0.3, 0.02, -0.301), 1e4),
    ((math.inf, 0.099, 0.349, 0.0393), 3070.0),  # normals of a wider surface would miss the ball
    ((-0.468, -0.0575, 0.373, 0.0566), 0.02),  # narrower than even samples of the surface would show
])  # fmt: skip
def test_any_radii_agree_with_the_plane_at_small_angles(radii, load):
    plane, curved = (solved(ball(conformal, Geometry(*radii), load=load, friction=0.0)) for conformal in (False, True))
    assert plane.converged and curved.converged
    scales = DerivedQuantities(plane.problem).scales
    angle = scales.semi_axis_y / min(map(abs, radii[1::2]))
    for name in ("approach_um", "pressure_max_MPa", "contact_area_mm2"):
        assert curved.coupled.scalars[name] == pytest.approx(plane.coupled.scalars[name], rel=2e-3 + angle**2), name


def test_a_contact_that_ends_where_the_model_ends_is_refused():
    with pytest.raises(Unsolvable, match="where the model of a half-space ends"):
        solved(ball(geometry=Geometry(math.inf, -0.0065, 0.00635, 0.00635), load=1e6))
    heavy = call("run", CASE, "--set", "load.normal_N=1e6")
    assert heavy.returncode == 3 and "load.normal_N = 1e6: the contact reaches y = -5.498 or 5.498 mm" in heavy.stderr


def test_the_common_surface_ends_where_the_gap_is_a_quarter_of_the_radius_along():
    """A circle of radius R on a plane, R' = R/16 along: R - sqrt(R² - y²) = R'/4, a fifth of the width first looked at."""
    radius, along = 0.02, 0.02 / 16.0
    lateral = conformal_patch(Geometry(along, radius, math.inf, math.inf), (0.5, 0.5)).lateral
    end = math.sqrt(radius**2 - (radius - 0.25 * along) ** 2)
    assert (lateral[0], lateral[-1]) == pytest.approx((-end, end), rel=2e-3)


def test_surfaces_too_steep_where_they_touch_are_refused():
    text = CASE.read_text().replace("lower_radius_y_mm = -6.604", "").replace("upper_radius_y_mm = 6.35", "")
    for body, slope in (("lower", 4), ("upper", -4)):
        text += f"[geometry.{body}_profile]\npoints_mm = [[-1, {-slope}], [0, 0], [1, {slope * 1.1}]]\n"
    with pytest.raises(CaseError, match=r"geometry\.conformal = true: the surfaces touch at y = .* inclined by more than 1\.2"):
        Case.parse(text)


def test_where_nothing_is_curved_conformal_is_planar():
    text = CASE.read_text().replace("lower_radius_y_mm = -6.604", "lower_radius_y_mm = 6.35")
    assert Case.parse(text).problem.geometry == Case.parse(text.replace("conformal = true", "")).problem.geometry


def power(problem: Problem) -> tuple[float, float]:
    """∬ τ·s of a solved contact, and F·v + M·ω with the resultants of pressure and traction on the curved surface, both in W.

    The bodies turn over each other at V(1/R_x1 + 1/R_x2) about y, through the point y = 0 of the common surface."""
    result, geometry, motion = solved(problem), problem.geometry, problem.motion
    assert result.converged, result.reason
    assert isinstance(geometry, CurvedPatch)
    fields, x, s = result.coupled.fields, result.x, result.y
    area = (x[1] - x[0]) * (s[1] - s[0])
    curvature = 1.0 / geometry.lower_radius_x + 1.0 / geometry.upper_radius_x
    lateral, angle = geometry.lateral_place(s), geometry.inclination(s)
    middles = (np.arange(2000) + 0.5) / 2000
    height = np.array([end * np.sin(geometry.inclination(end * middles)).mean() for end in s])
    position = np.stack(np.broadcast_arrays(x[:, None], lateral, height))
    force = area * np.stack([fields["shear_x"], fields["shear_y"] * np.cos(angle) - fields["pressure"] * np.sin(angle),
                             fields["shear_y"] * np.sin(angle) + fields["pressure"] * np.cos(angle)])
    creepage = [result.coupled.scalars[name] for name in ("creepage_longitudinal", "creepage_lateral")]
    turning = motion.speed * np.array([0.0, curvature, motion.spin])
    moment = np.cross(position, force, axis=0).sum(axis=(1, 2))
    work = float(force.sum(axis=(1, 2)) @ (motion.speed * np.array([*creepage, 0.0])) + moment @ turning)
    return result.coupled.scalars["Q_F_W"], work


@pytest.mark.parametrize("options", [
    {"spin": 10.0},
    {"friction": 1e-6, "creepage": (5e-4, 2e-4), "spin": -20.0},
    {"creepage": (None, 0.0), "force": (0.0, None)},
], ids=["spin", "full sliding", "free rolling"])  # fmt: skip
def test_the_bodies_do_the_work_of_the_slip(options):
    heat, work = power(ball(grid=48, **options))
    assert heat == pytest.approx(work, rel=2e-3)


def test_free_rolling_in_a_groove():
    """Heathcote's slip without elastic slip: no net force, and neutral lines at ±2 sin 10° b for small angles, but for 0.7 %:
    the spin about the inclined normals, which a plane does not have, turns the slip near them, in the proportion a/b = 0.11."""
    problem = ball(grid=64, friction=1e-6, load=1.0, creepage=(None, 0.0), force=(0.0, None))
    result = solved(problem)
    assert result.converged and abs(result.coupled.scalars["force_x_N"]) < 1e-6 * problem.traction_limit
    slip, y = result.coupled.fields["slip_x"][32], result.y
    j = int(np.flatnonzero((slip[1:] > 0.0) & (slip[:-1] <= 0.0))[-1])
    neutral = y[j] - slip[j] * (y[j + 1] - y[j]) / (slip[j + 1] - slip[j])
    half_width = DerivedQuantities(ball(conformal=False, load=1.0)).hertz.semi_axis_y
    assert neutral / half_width == pytest.approx(2.0 * math.sin(math.radians(10.0)), rel=1e-2)


def test_creepages_at_the_contact_are_those_at_its_centre_of_pressure():
    """A ball beside the middle of its groove: the slip at the centre of pressure is the given one, and so is the spin."""
    egg = points(lambda y: -(y**2) / 8.0 - 0.02 * y**3, -2.0, 2.0)
    geometry = Geometry(0.02, math.inf, 0.02, math.inf, upper_profile=replace(egg, offset=1e-3, tilt=0.05))
    for conformal in (True, False):
        problem = ball(conformal, geometry, load=100.0, creepage=(3e-4, -2e-4), spin=2.0)
        derived = DerivedQuantities(replace(problem, motion=replace(problem.motion, at="contact")))
        place = derived.scales.pressure_centre
        assert abs(place) > 2e-4
        assert derived.kinematics.slip_at(np.zeros(1), np.array([place]))[:, 0] == pytest.approx([3e-4, -2e-4], rel=1e-9)
        along, across = derived.kinematics.slip_at(np.array([0.0, 0.0, 1e-5]), place + np.array([-1e-5, 1e-5, 0.0]))
        assert -(along[1] - along[0]) / 2e-5 == pytest.approx(2.0, rel=1e-3)
        if conformal:
            assert (across[2] + 2e-4) / 1e-5 == pytest.approx(2.0, rel=1e-3)
        assert solved(derived.problem).coupled.scalars["contact_y_mm"] == pytest.approx(1e3 * place, rel=0.02)


def test_the_case_of_a_groove(tmp_path):
    """What the case's comment promises, through the command, on a coarser grid."""
    done = call("run", CASE, "-o", tmp_path, "--json", "--set", "numerics.grid=32", "--set", "output.plots=false")
    summary = json.loads(done.stdout)
    assert done.returncode == 0 and summary["status"] == "converged"
    expected = {"Q_F_W": 4.05, "force_x_N": 56.0, "force_y_N": -4.16, "pressure_max_MPa": 1920.6, "spin_moment_Nmm": 13.38}
    for name, value in expected.items():
        assert summary[name] == pytest.approx(value, rel=2e-2, abs=0.2), name

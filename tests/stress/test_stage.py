"""The whole stage on solved contacts: exact maxima, another program's stresses, what the plan promises, what is kept."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.documents import at_most, cell
from tests.support.errors import relative
from tests.support.interpolation import at_point
from tests.support.scenes import MECHANICAL, elastic, ellipse, rolling, spheres
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.physics.stress.strength import von_mises
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.names import BOND_SCALARS, STRENGTH_SCALARS, SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import Heating, Material, Numerics, Strength, SubsurfaceRequest
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.python_api import solve

REFERENCE = Path(__file__).parents[1] / "reference"
CONTACT = json.loads((REFERENCE / "subsurface_elastic.json").read_text())["cases"]
MAXIMA = json.loads((REFERENCE / "subsurface_fields.json").read_text())["benchmarks"]
BODY = elastic(0.3)
HOT = Heating(deformation=False)


def solved(request=None, **given):
    return solve(replace(rolling(**given), subsurface=request or SubsurfaceRequest()))


def peak(result, body, prefix=""):
    """Largest von Mises stress over p₀, and its x, y and depth over the smaller semi-axis."""
    scalars, unit = result.subsurface.scalars, min(result.of_problem["hertz_a_mm"], result.of_problem["hertz_b_mm"])
    places = [scalars[f"{prefix}von_mises_{axis}_{body}_mm"] / unit for axis in ("x", "y", "depth")]
    return scalars[f"{prefix}von_mises_max_{body}_MPa"] / result.of_problem["hertz_p0_MPa"], *places


@pytest.mark.slow
def test_sphere():
    """Exact: 0.620041 p₀ at 0.480864 a (ν = 0.3), by parabolas between layers and between elements of any parity."""
    largest, x, y, depth = peak(solved(grid=33, body=BODY, friction=0.0), "lower")
    wanted, at = MAXIMA["circle_vonMises_max"]
    assert largest == pytest.approx(wanted, abs=2e-5)
    assert depth == pytest.approx(at, abs=1e-4)
    assert abs(x) < 1e-6
    assert abs(y) < 1e-6


def test_the_largest_shear_stress_below_a_sphere_is_half_of_the_difference_of_the_principal_stresses():
    """On the axis σ_zz and σ_xx = σ_yy are principal, so that half of Tresca's stress is half of von Mises's: 0.310 p₀."""
    scalars = solved(grid=32, body=BODY, friction=0.0).scalars
    assert scalars["tresca_shear_max_lower_MPa"] == pytest.approx(0.5 * scalars["von_mises_max_lower_MPa"], rel=1e-4)
    assert scalars["tresca_shear_depth_lower_mm"] == pytest.approx(scalars["von_mises_depth_lower_mm"], rel=1e-3)


@pytest.mark.slow
def test_sliding_sphere():
    """With all of the traction along x: 0.6476 and 0.6598 p₀, towards where the traction on the body points."""
    friction = 0.3
    wanted, x, depth = MAXIMA[f"sliding_mu_{friction:.2f}_vonMises_max_x_z"]
    result = solved(grid=48, body=BODY, friction=friction, creepage=(5.0, 0.0))
    for body, side in (("lower", -1.0), ("upper", 1.0)):
        found = peak(result, body)
        assert found[0] == pytest.approx(wanted, abs=2e-5)
        assert found[1:] == pytest.approx((side * x, 0.0, depth), abs=5e-4)


def below_the_middle(a, b, z, nu):
    """Stresses in p₀ on the axis of an elliptic Hertz contact, by quadrature of Boussinesq's point load (Johnson 3.18)."""
    u, wu = np.polynomial.legendre.leggauss(400)
    top = math.asinh(b / z)
    y = z * np.sinh(0.5 * top * (u + 1.0))
    weight_y = wu * 0.5 * top * z * np.cosh(0.5 * top * (u + 1.0))
    v, wv = np.polynomial.legendre.leggauss(80)
    width = a * np.sqrt(1.0 - (y / b) ** 2)[:, None]
    x = width * np.sin(0.25 * math.pi * (v + 1.0))
    weight_x = wv * 0.25 * math.pi * width * np.cos(0.25 * math.pi * (v + 1.0))
    y = np.broadcast_to(y[:, None], x.shape)
    load = 4.0 * np.sqrt(np.maximum(1.0 - (x / a) ** 2 - (y / b) ** 2, 0.0)) * weight_x * weight_y[:, None] / (2.0 * math.pi)
    s2 = x * x + y * y
    r = np.sqrt(s2 + z * z)

    def along(first, second):
        plane = (1.0 - 2.0 * nu) / s2 * ((1.0 - z / r) * (first**2 - second**2) / s2 + z * second**2 / r**3)
        return float((load * (plane - 3.0 * z * first**2 / r**5)).sum())

    return np.array([along(x, y), along(y, x), float((-3.0 * load * z**3 / r**5).sum()), 0.0, 0.0, 0.0])


@pytest.mark.slow
def test_the_tension_behind_a_sliding_sphere():
    """It is largest at the border of the contact, and converges slowly: as docs/verification.md says, with its ±."""
    scalars = solved(SubsurfaceRequest(), grid=128, geometry=spheres(0.03), body=elastic(0.3), load=65.0, friction=0.25,
                     creepage=(0.05, 0.0))
    (exact,) = cell("verification", "tension behind a sliding sphere", "against")
    value, error, *_ = cell("verification", "tension behind a sliding sphere", "difference")
    peak, name = scalars["hertz_p0_MPa"], "tensile_stress_max_lower_MPa"
    assert scalars[name] / peak == pytest.approx(value.value, abs=value.rounding)
    assert scalars.uncertainty[name] / peak == pytest.approx(error.value, abs=error.rounding)
    assert abs(value.value - exact.value) < error.value


@pytest.mark.slow
def test_contact_like_a_line():
    """a/b = 0.02: von Mises on the axis as by quadrature; the range of σ_xz is that of a line, p₀/2 at a/2."""
    result = solved(grid=64, body=BODY, friction=0.0, geometry=ellipse(0.02), request=SubsurfaceRequest(("lower",)))
    largest, *_, depth = peak(result, "lower")
    a, b = result.of_problem["hertz_a_mm"], result.of_problem["hertz_b_mm"]
    on_axis = {z: float(von_mises(below_the_middle(a, b, z * a, 0.3))) for z in (depth - 0.02, depth, depth + 0.02)}
    assert largest == pytest.approx(on_axis[depth], abs=1e-4)
    below, here, above = on_axis.values()
    assert depth - 0.02 * 0.5 * (above - below) / (above - 2.0 * here + below) == pytest.approx(depth, abs=2e-3)
    assert largest == pytest.approx(MAXIMA["line_vonMises_max"][0], rel=0.01)
    scalars = result.subsurface.scalars
    assert scalars["orthogonal_shear_range_max_lower_MPa"] / result.of_problem["hertz_p0_MPa"] == pytest.approx(0.5, abs=5e-4)
    assert scalars["orthogonal_shear_range_depth_lower_mm"] / a == pytest.approx(0.5, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTACT)
def test_stresses_of_another_program(name):
    """CONTACT on three grids, extrapolated: 70 points, to its uncertainties and what docs/verification.md adds."""
    case = CONTACT[name]
    given = case["input"]
    body = elastic(given["poisson_ratio"], given["youngs_modulus_GPa"] * 1e9)
    result = solved(
        SubsurfaceRequest(fields="full"), grid=96, geometry=spheres(given["radius_mm"] / 1e3), body=body,
        load=given["normal_N"], friction=given["friction_coefficient"] if case["tangential"] else 0.0,
        creepage=(given["creepage_longitudinal"], 0.0),
    )  # fmt: skip
    a = case["a_mm"] / 1e3
    allowed = at_most("verification", "140 points in both bodies") * result.of_problem["hertz_p0_MPa"]
    for point in case["points_plane_y0"]:
        side = "upper" if point["z_over_a"] > 0.0 else "lower"
        stresses = result.subsurface.bodies[side]
        where = abs(point["z_over_a"]) * a, point["x_over_a"] * a, 0.0
        for component in ("xx", "yy", "zz", "xy", "xz", "yz"):
            # In the file z is the same for both bodies; here it points into each.
            sign = -1e-6 if side == "lower" and component in ("xz", "yz") else 1e-6
            got = sign * at_point(stresses.fields[f"stress_{component}"], (stresses.depths, result.x, result.y), where)
            wanted, uncertainty = point[f"sigma_{component}"]
            assert abs(got - wanted) < uncertainty + allowed, (point, component)


def test_both_bodies_carry_the_same_traction():
    """Between dissimilar bodies, too: σ_zz and, with opposite signs in their own frames, σ_xz agree at the surface."""
    problem = replace(rolling(grid=16, creepage=(0.001, 0.002)), lower=elastic(0.2, 70e9),
                      subsurface=SubsurfaceRequest(layers=6, fields="full"))  # fmt: skip
    bodies = solve(problem).subsurface.bodies
    lower, upper = bodies["lower"].fields, bodies["upper"].fields
    scale = np.abs(lower["stress_zz"]).max()
    np.testing.assert_allclose(lower["stress_zz"][0], upper["stress_zz"][0], atol=1e-6 * scale)
    for name in ("stress_xz", "stress_yz"):
        np.testing.assert_allclose(lower[name][0], -upper[name][0], atol=1e-6 * scale)
        assert np.abs(lower[name][0]).max() > 0.05 * scale
    assert np.abs(lower["stress_xx"] - upper["stress_xx"]).max() > 0.1 * scale


def test_temperatures_are_the_solvers_at_the_surface():
    result = solved(SubsurfaceRequest(layers=8, fields="full"), grid=12, creepage=(0.01, 0.0), speed=5.0, heating=HOT)
    for body in ("lower", "upper"):
        rise, stresses = result.coupled.fields[f"temperature_rise_{body}"], result.subsurface.bodies[body]
        np.testing.assert_allclose(stresses.fields["temperature_rise"][0], rise, rtol=1e-6, atol=1e-6 * rise.max())
        assert (np.diff(stresses.below_heated["temperature_rise"]) < 0.0).all()


def test_thermal_stresses_add_to_elastic_ones():
    """A hot skin is pressed together by what is cold around it, twice as much by twice the heat."""

    def stresses(speed, thermal):
        request = SubsurfaceRequest(("lower",), layers=8, fields="full", thermal=thermal)
        result = solved(request, grid=16, creepage=(0.01, 0.0), speed=speed,
                        heating=replace(HOT, peclet="stationary"))  # fmt: skip
        return result.subsurface.bodies["lower"].fields

    cold, hot, hotter = stresses(20.0, False), stresses(20.0, True), stresses(40.0, True)
    by_heat, by_twice = hot["stress_xx"] - cold["stress_xx"], hotter["stress_xx"] - cold["stress_xx"]
    scale = np.abs(by_heat).max()
    np.testing.assert_allclose(by_twice, 2.0 * by_heat, atol=2e-6 * np.abs(cold["stress_xx"]).max() + 1e-5 * scale)
    assert by_heat[0].min() == pytest.approx(-scale)
    np.testing.assert_array_equal(cold["von_mises"], hot["von_mises_elastic"])


def test_parts_that_are_not_needed_are_skipped_and_told():
    def below(request=None, **given):
        plan = make_plan(replace(rolling(**given), subsurface=request or SubsurfaceRequest()))
        told = {name: why for name, why in plan.skipped.items() if name.startswith(("below", "thermal"))}
        return plan.run, told, plan.facts

    run, skipped, facts = below(grid=32, creepage=(0.01, 0.0), heating=HOT)
    assert run[-2:] == ["below the surface", "thermal stresses"]
    assert skipped == {"below the surface, y < 0": "the mirror image of y > 0",
                       "below the surface, tables of the second body": "both bodies have the same Poisson ratio"}  # fmt: skip
    assert facts["subsurface_layers"] > 20
    run, skipped, _ = below(SubsurfaceRequest(("upper",)), grid=32, creepage=(0.0, 0.01), heating=replace(HOT, partition=1.0))
    assert "thermal stresses" not in run
    assert skipped == {"below the surface, lower body": "not asked for",
                       "thermal stresses": "no heat enters the bodies asked for"}  # fmt: skip
    run, skipped, _ = below(grid=32, creepage=(0.01, 0.0), heating=replace(HOT, partition=1.0))
    assert skipped["thermal stresses, upper body"] == "no heat enters it"
    _, skipped, _ = below(grid=32)
    assert skipped["thermal stresses"] == "no heat"
    assert skipped["below the surface, shear"] == "no traction acts on the surfaces"
    _, skipped, _ = below(grid=32, creepage=(0.01, 0.0), heating=replace(HOT, peclet="sliding"))
    assert "sliding" in skipped["thermal stresses"]
    _, skipped, _ = below(grid=32, creepage=(0.01, 0.0), heating=HOT, speed=1e6)
    assert "Péclet" in skipped["thermal stresses"]
    _, skipped, _ = below(grid=32, creepage=(0.01, 1.5), heating=HOT)
    assert "sideways" in skipped["thermal stresses"]
    assert not below(grid=32, creepage=(0.01, 0.0), heating=HOT, request=SubsurfaceRequest(thermal=False))[0].count(
        "thermal stresses")  # fmt: skip


def test_a_body_without_heat_has_elastic_stresses_only():
    result = solved(SubsurfaceRequest(layers=6), grid=16, creepage=(0.01, 0.0), heating=replace(HOT, partition=1.0), speed=5.0)
    lower, upper = result.subsurface.bodies["lower"], result.subsurface.bodies["upper"]
    assert lower.hottest is not None
    assert upper.hottest is None
    assert set(upper.plane) == set(lower.plane) - {"temperature_rise", "von_mises_elastic"}
    assert result.subsurface.scalars["elastic_von_mises_max_upper_MPa"] == result.subsurface.scalars["von_mises_max_upper_MPa"]
    assert result.subsurface.scalars.keys() == SUBSURFACE_SCALARS.keys() - STRENGTH_SCALARS.keys() - BOND_SCALARS.keys()


@pytest.mark.slow
def test_kept_fields():
    """One plane, von Mises stresses everywhere, or everything: the same numbers."""
    plane, stress, full = (
        solved(SubsurfaceRequest(("lower",), layers=6, fields=fields), grid=10, creepage=(0.01, 0.002), heating=HOT).subsurface
        for fields in ("plane", "von_mises", "full")
    )
    assert plane.scalars == stress.scalars == full.scalars
    assert plane.bodies["lower"].fields == {}
    assert set(stress.bodies["lower"].fields) == {"von_mises", "von_mises_elastic", "temperature_rise"}
    body = full.bodies["lower"]
    assert len(body.fields) == 9
    row = int(np.argmin(np.abs(solved(SubsurfaceRequest(layers=4), grid=10).y - body.plane_y)))
    for name, values in body.plane.items():
        np.testing.assert_array_equal(values, body.fields[name][:, :, row])
    components = np.stack([body.fields[f"stress_{c}"] for c in ("xx", "yy", "zz", "xy", "xz", "yz")]).astype(float)
    np.testing.assert_allclose(von_mises(components), body.fields["von_mises"], rtol=1e-4)


def test_too_shallow_is_told():
    result = solved(SubsurfaceRequest(depth=1e-5, layers=4), grid=16, friction=0.0)
    warning = next(warning for warning in result.warnings if "depth_mm" in warning)
    for name in ("von_mises_max_lower_MPa", "orthogonal_shear_range_max_upper_MPa"):
        assert name in warning and math.isnan(relative(result)[name])
    assert not solved(SubsurfaceRequest(layers=16), grid=16, friction=0.0).warnings


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0.05, pytest.param(0.11, marks=pytest.mark.slow)])
def test_a_maximum_below_the_last_layer_is_covered_or_told(depth: float | None) -> None:
    """The largest stresses of the whole body are covered, or have no estimate and are named, wherever the layers (mm) end."""
    body, strength = Material(210e9, 0.28), Strength(300e6, 0.3)
    problem = rolling(geometry=Geometry(0.02, 0.02, 0.02, 0.03), body=body, load=100.0, friction=0.3, creepage=(1e-3, 0.0),
                      heating=MECHANICAL)
    full, cut = (solve(replace(problem, numerics=Numerics((16, 16)), subsurface=SubsurfaceRequest(
        ("lower",), lower_strength=strength, depth=last))) for last in (None, depth and 1e-3 * depth))
    assert bool(cut.warnings) == (depth is not None)
    found = cut.subsurface.scalars
    for name, value in found.items():
        error = relative(cut)[name] * error_scale(name, cut.summary())
        off = abs(value - full.subsurface.scalars[name])
        told = name.removeprefix("elastic_") in "".join(cut.warnings) or not name.endswith("_max_lower_MPa")
        reference = relative(full)[name] * error_scale(name, full.summary())
        assert (math.isnan(error) and told) or off <= error + reference, name


@pytest.mark.slow
def test_few_layers_have_wide_estimates_and_a_warning():
    few, true = (solved(SubsurfaceRequest(("lower",), layers=layers), grid=16, creepage=(0.01, 0.0)) for layers in (6, None))
    assert "6 depths" in few.warnings[-1] and not true.warnings
    for name in ("von_mises_max_lower_MPa", "orthogonal_shear_range_max_lower_MPa", "von_mises_depth_lower_mm"):
        error = relative(few)[name] * error_scale(name, few.summary())
        assert error > abs(few.subsurface.scalars[name] - true.subsurface.scalars[name]) > 0.0, name


@pytest.mark.slow
def test_the_surface_carries_the_load_of_a_contact_that_shrinks():
    """At 160 W it is a quarter as wide: stresses are those of the part of the domain that has followed it."""
    speed = 160.0 / 65.0 / 1e-4
    problem = rolling(grid=32, friction=1e-4, creepage=(1.0, 0.0), speed=speed, heating=Heating(peclet="stationary"))
    result = solve(replace(problem, subsurface=SubsurfaceRequest(("lower",), layers=4, fields="full")))
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    surface = result.subsurface.bodies["lower"].fields["stress_zz"][0].astype(float)
    assert result.work["extent_coupled"] < 0.5 * result.work["extent"]
    assert surface.sum() * area == pytest.approx(-problem.normal_force, rel=1e-4)

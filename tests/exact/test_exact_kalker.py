"""Kalker's creepage coefficients against references and limits; creep forces by FASTSIM and Polach against the linear theory,
full sliding and the complete theory."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.scenes import reference
from thermoroll_cli.exact import kalker
from thermoroll_cli.exact.hertz import hertz_contact, line_contact
from thermoroll_cli.exact.kalker import creepage_coefficients, fastsim, fastsim_flexibilities, linear_creep_forces, polach
from thermoroll_cli.exact.rolling_cylinders import carter

COEFFICIENTS = reference("kalker_coefficients")
ROLLING = reference("contact_rolling")["cases"]
NAMES = ("C11", "C22", "C23", "C33")


def test_table_is_the_reference_and_its_nodes_are_hit():
    rows = COEFFICIENTS["published"]["rows"]
    assert len(kalker.TABLE) == len(rows) == 19
    assert list(kalker.TABLE_POISSON_RATIOS) == COEFFICIENTS["published"]["poisson_ratio"]
    for (aspect, *columns), row in zip(kalker.TABLE, rows, strict=True):
        assert aspect == pytest.approx(row["a_over_b"], rel=1e-6)
        for j, nu in enumerate(kalker.TABLE_POISSON_RATIOS):
            found = kalker.creepage_coefficients(aspect, nu)
            for name, column in zip(NAMES, columns, strict=True):
                assert column[j] == row[name][j]
                assert getattr(found, name.lower()) == pytest.approx(row[name][j], rel=1e-12)


@pytest.mark.parametrize("case", COEFFICIENTS["computed"], ids=lambda c: f"{c['a_over_b']}-{c['poisson_ratio']}")
def test_interpolation_matches_computed_values(case):
    found = kalker.creepage_coefficients(case["a_over_b"], case["poisson_ratio"])
    for name in NAMES:
        assert getattr(found, name.lower()) == pytest.approx(case[name], rel=8e-3 if name == "C33" else 4e-3)


@pytest.mark.slow
def test_interpolation_is_smooth_between_the_rows():
    """Each inner C11 is predicted from its neighbours by a straight line to 2.5 %, so cubics are far better."""
    for i in range(1, len(kalker.TABLE) - 1):
        before, row, after = (np.log([kalker.TABLE[j][0], *kalker.TABLE[j][1]]) for j in (i - 1, i, i + 1))
        share = (row[0] - before[0]) / (after[0] - before[0])
        np.testing.assert_allclose(row[1:], before[1:] + share * (after[1:] - before[1:]), atol=0.025)
    grid = np.geomspace(0.05, 10, 1000)
    for nu in (0.0, 0.3, 0.5):
        values = np.log([list(kalker.creepage_coefficients(g, nu)) for g in grid])
        assert np.abs(np.diff(values, axis=0)).max() < 2.5 * math.log(grid[1] / grid[0])
        # c22, c23 grow with a/b and c33 falls; c11 has a shallow minimum
        assert np.all(np.diff(values[:, 1:3], axis=0) > 0)
        assert np.all(np.diff(values[:, 3]) < 0)


@pytest.mark.parametrize("aspect", [0.1, 10.0])
@pytest.mark.parametrize("nu", [0.0, 0.25, 0.5])
def test_asymptotes_meet_the_table(aspect, nu):
    table, limit = kalker.creepage_coefficients(aspect, nu), kalker.asymptotic_coefficients(aspect, nu)
    for name in NAMES:
        assert getattr(limit, name.lower()) == pytest.approx(getattr(table, name.lower()), rel=0.08)
    beyond = kalker.creepage_coefficients(aspect**5, nu)
    far = kalker.asymptotic_coefficients(aspect**5, nu)
    for name in NAMES:
        assert getattr(beyond, name.lower()) == pytest.approx(getattr(far, name.lower()), rel=1e-4)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_wide_contacts_are_carters_strips(nu):
    """b ≫ a: each strip rolls by Carter's law; C11 and C33 are the strips' sums of F and of −y F."""
    shear_modulus, a, b = 8e10, 1e-6, 1e-1
    modulus = shear_modulus / (1 - nu)
    node, gauss = np.polynomial.legendre.leggauss(200)
    curvature, creepage = 40.0, 1e-9
    force = moment = 0.0
    for y, weight in zip(b * node, b * gauss, strict=True):
        half_width = a * math.sqrt(1 - (y / b) ** 2)
        strip = line_contact(curvature, modulus, 0.25 * math.pi * modulus * curvature * half_width**2)
        force += weight * carter(strip, 1.0, creepage).force
        # spin 1e-9/b: longitudinal creepage −ξ_φ y; moment −y F
        moment -= weight * y * carter(strip, 1.0, -creepage * y / b).force if y else 0.0
    limit = kalker.asymptotic_coefficients(a / b, nu)
    linear = kalker.linear_creep_forces(limit, a, b, shear_modulus, creepage_x=creepage)
    assert linear.force_x == pytest.approx(force, rel=1e-3)
    spinning = kalker.linear_creep_forces(limit, a, b, shear_modulus, spin=creepage / b)
    assert spinning.moment_z == pytest.approx(moment, rel=1e-3)


def linear_forces(case):
    given = case["input"]
    youngs, nu = given["youngs_modulus_GPa"] * 1e9, given["poisson_ratio"]
    a = case["hertz"]["a_mm"] * 1e-3
    return kalker.linear_creep_forces(kalker.creepage_coefficients(1.0, nu), a, a, youngs / (2 * (1 + nu)),
                                      given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_mm"] * 1e3)


@pytest.mark.parametrize("name", sorted(ROLLING))
def test_signs_are_those_of_the_rolling_cases(name):
    case = ROLLING[name]
    linear = linear_forces(case)
    for found, key in [(linear.force_x, "force_x_N"), (linear.force_y, "force_y_N")]:
        expected = case["extrapolated"][key]
        assert np.sign(round(found, 6)) == np.sign(round(expected, 6)), key


@pytest.mark.parametrize("curvatures", [(1.0, 1.0), (30.0, 2.0), (0.01, 5.0)])
def test_full_slip_creepage(curvatures):
    """For ν = 0 and E* = G a tangential traction displaces as a pressure does: ξ = μ κ_x a0."""
    contact = hertz_contact(*curvatures, 8e10, 50.0)
    expected = 0.3 * contact.curvature_x * contact.semi_axis_x
    assert kalker.full_slip_creepages(contact, 0.3, 8e10, 0.0) == pytest.approx((expected, expected), rel=1e-12)
    # f_x + f_y = 2 − ν for every direction
    assert sum(kalker.full_slip_creepages(contact, 0.3, 8e10, 0.4)) == pytest.approx(1.6 * expected, rel=1e-12)


def test_full_slip_creepage_of_circle_and_strip():
    circle = hertz_contact(3.0, 3.0, 9e10, 50.0)
    unit = 0.3 * circle.peak_pressure / 8e10
    expected = (math.pi / 8 * (4 - 3 * 0.28) * unit, math.pi / 8 * (4 - 0.28) * unit)
    assert kalker.full_slip_creepages(circle, 0.3, 8e10, 0.28) == pytest.approx(expected, rel=1e-13)
    # very wide: Carter's μ a/R with E* = G/(1 − ν), and antiplane with G
    wide = hertz_contact(1e5, 1.0, 9e10, 50.0)
    unit = 2 * 0.3 * wide.peak_pressure / 8e10
    assert kalker.full_slip_creepages(wide, 0.3, 8e10, 0.28) == pytest.approx((0.72 * unit, unit), rel=1e-3)


def test_fastsim_reproduces_the_linear_forces():
    """Traction x'/L grows from the leading edge: F_x = 8a²b ξ/(3 L1), F_y = −π a³b ξ_φ/(4 L3)."""
    a, b, shear_modulus = 2e-4, 5e-4, 8e10
    coefficients = kalker.creepage_coefficients(a / b, 0.28)
    flexibility = kalker.fastsim_flexibilities(coefficients, a, b, shear_modulus)
    linear = kalker.linear_creep_forces(coefficients, a, b, shear_modulus, 1e-4, 2e-4)
    assert linear.force_x == pytest.approx(8 * a**2 * b * 1e-4 / (3 * flexibility.longitudinal), rel=1e-12)
    assert linear.force_y == pytest.approx(8 * a**2 * b * 2e-4 / (3 * flexibility.lateral), rel=1e-12)
    spinning = kalker.linear_creep_forces(coefficients, a, b, shear_modulus, spin=3.0)
    assert spinning.force_y == pytest.approx(-math.pi * a**3 * b * 3.0 / (4 * flexibility.spin), rel=1e-12)


def test_combined_constants():
    assert kalker.combined_constants(8e10, 0.28, 8e10, 0.28) == pytest.approx((8e10, 0.28), rel=1e-14)
    shear_modulus, nu = kalker.combined_constants(2e10, 0.4, 8e10, 0.2)
    assert shear_modulus == pytest.approx(3.2e10)
    assert nu == pytest.approx(0.36)


G, LIMIT = 82e9, 25e3
A, B = 6e-3, 4e-3
ELLIPSE = creepage_coefficients(A / B, 0.27)
CONTACT = (ELLIPSE, A, B, G, LIMIT)

SMALL = [(1e-7, 0.0, 0.0), (0.0, 1e-7, 0.0), (0.0, 0.0, 1e-5), (1e-7, -2e-7, 0.0)]


@pytest.mark.parametrize("theory", [fastsim, polach])
@pytest.mark.parametrize("creepage", SMALL)
def test_little_creepage_gives_the_linear_forces(theory, creepage):
    found, linear = theory(*CONTACT, *creepage), linear_creep_forces(ELLIPSE, A, B, G, *creepage)
    size = math.hypot(linear.force_x, linear.force_y)
    assert math.hypot(found.force_x, found.force_y) == pytest.approx(size, rel=0.01)
    # Polach's force of both creepages is along the creepage, whatever the difference of C11 and C22.
    direction = 0.06 if theory is polach and all(creepage[:2]) else 0.01
    assert found.force_x == pytest.approx(linear.force_x, abs=direction * size)
    assert found.force_y == pytest.approx(linear.force_y, abs=direction * size)


@pytest.mark.parametrize("theory", [fastsim, polach])
@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2, 2.5, -1.2])
def test_much_creepage_gives_the_friction_limit_along_it(theory, angle):
    found = theory(*CONTACT, 0.5 * math.cos(angle), 0.5 * math.sin(angle))
    assert math.hypot(found.force_x, found.force_y) == pytest.approx(LIMIT, rel=6e-3)
    # FASTSIM weighs both creepages by the flexibilities even where all slips.
    weights = (ELLIPSE.c11, ELLIPSE.c22) if theory is fastsim else (1.0, 1.0)
    expected = math.atan2(weights[1] * math.sin(angle), weights[0] * math.cos(angle))
    assert math.atan2(found.force_y, found.force_x) == pytest.approx(expected, abs=6e-3)


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 2.0])
def test_fastsim_with_longitudinal_creepage_alone(share):
    """On a strip of half-length h stick ends at x = h − s a, s = ξ a π a b/(2 μW L): both parts of the force are integrals of
    polynomials."""
    flexibility = fastsim_flexibilities(ELLIPSE, A, B, G).longitudinal
    peak = 2.0 * LIMIT / (math.pi * A * B)
    creepage = share * peak * flexibility / A
    y = B * np.sin((np.arange(4000) + 0.5) / 4000 * math.pi - math.pi / 2)
    h = np.sqrt(1.0 - (y / B) ** 2)  # over a
    end = np.maximum(h - share, -h)
    stick = share * (end + h) ** 2 / 2.0
    slip = (h**2 * h - h**3 / 3.0) - (h**2 * end - end**3 / 3.0)
    exact = peak * A * float(((stick + slip) * math.pi / 4000 * B * np.sqrt(1.0 - (y / B) ** 2)).sum())
    assert fastsim(*CONTACT, creepage).force_x == pytest.approx(exact, abs=2e-3 * LIMIT)


def test_both_follow_the_complete_theory_between():
    """At half and at all of the saturation creepage of the linear law, within 15 % of Vermeulen and Johnson's curve."""
    full = 3.0 * LIMIT / (G * A * B * ELLIPSE.c11)
    for share in (1.0 / 3.0, 2.0 / 3.0):
        cubic = LIMIT * (1.0 - (1.0 - share) ** 3)
        for theory in (fastsim, polach):
            assert theory(*CONTACT, share * full).force_x == pytest.approx(cubic, rel=0.15)


@pytest.mark.parametrize("theory", [fastsim, polach])
def test_signs(theory):
    """Opposite creepages give opposite forces; spin acts against positive lateral creepage."""
    one, other = theory(*CONTACT, 1e-3, 2e-3, 0.3), theory(*CONTACT, -1e-3, -2e-3, -0.3)
    assert (one.force_x, one.force_y) == pytest.approx((-other.force_x, -other.force_y))
    assert theory(*CONTACT, 0.0, 0.0, 0.5).force_y < 0.0
    assert theory(*CONTACT, 0.0, 1e-3, 0.5).force_y < theory(*CONTACT, 0.0, 1e-3, 0.0).force_y

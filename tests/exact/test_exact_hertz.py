"""Hertz contact against the classical elliptic-integral equations, direct quadrature and its own limits."""

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from tests.support.scenes import reference
from thermoroll_cli.exact.hertz import hertz_contact, line_contact

ASPECTS = [0.02, 0.1, 0.5, 0.97, 1.0, 1.3, 4.0, 50.0]


def contact_of_aspect(aspect: float):
    """A contact with a0/b0 = aspect: find the curvature ratio that gives it."""
    log_ratio = brentq(
        lambda t: math.log(hertz_contact(math.exp(t / 2), math.exp(-t / 2), 1e11, 50.0).aspect_ratio / aspect), -12, 12
    )
    return hertz_contact(math.exp(log_ratio / 2), math.exp(-log_ratio / 2), 1e11, 50.0)


def test_circle_matches_the_closed_form():
    radius, modulus, force = 0.015, 1.139e11, 65.0
    contact = hertz_contact(1 / radius, 1 / radius, modulus, force)
    a = (0.75 * force * radius / modulus) ** (1 / 3)
    assert contact.semi_axis_x == pytest.approx(a, rel=1e-14)
    assert contact.semi_axis_y == pytest.approx(a, rel=1e-14)
    assert contact.approach == pytest.approx(a**2 / radius, rel=1e-14)
    assert contact.peak_pressure == pytest.approx(1.5 * force / (math.pi * a**2), rel=1e-14)
    assert contact.mean_pressure == pytest.approx(2 / 3 * contact.peak_pressure, rel=1e-14)
    assert contact.stiffness == pytest.approx(2 * modulus * a, rel=1e-14)
    assert contact.mean_radius == pytest.approx(a, rel=1e-14)


@pytest.mark.parametrize("case", ["article_3_1_case_1", "article_4_1_mechanical"])
def test_matches_the_contact_program(case):
    known = reference("contact_rolling")["cases"][case]
    given = known["input"]
    modulus = given["youngs_modulus_GPa"] * 1e9 / (2 * (1 - given["poisson_ratio"] ** 2))
    contact = hertz_contact(2e3 / given["radius_mm"], 2e3 / given["radius_mm"], modulus, given["normal_N"])
    assert contact.semi_axis_x == pytest.approx(known["hertz"]["a_mm"] * 1e-3, rel=1e-12)
    assert contact.peak_pressure == pytest.approx(known["hertz"]["p0_MPa"] * 1e6, rel=1e-12)


@pytest.mark.parametrize("aspect", [0.02, 0.2, 0.7, 3.0, 50.0])
def test_ellipse_satisfies_johnsons_equations(aspect):
    """Johnson (1985), Eqs. 4.25 and 4.26, with a ≥ b, e² = 1 − b²/a²:
    A = p0/E* b/(a² e²) (K − E), B = p0/E* b/(a² e²) (a²/b² E − K), δ = p0/E* b K; A, B half the curvatures."""
    contact = contact_of_aspect(aspect)
    a, b = max(contact.semi_axis_x, contact.semi_axis_y), min(contact.semi_axis_x, contact.semi_axis_y)
    along, across = sorted((contact.curvature_x, contact.curvature_y))
    ee = 1 - (b / a) ** 2
    k, e = ellipk(ee), ellipe(ee)
    scale = contact.peak_pressure / contact.contact_modulus * b / (a**2 * ee)
    assert 0.5 * along == pytest.approx(scale * (k - e), rel=1e-12)
    assert 0.5 * across == pytest.approx(scale * ((a / b) ** 2 * e - k), rel=1e-12)
    assert contact.approach == pytest.approx(contact.peak_pressure / contact.contact_modulus * b * k, rel=1e-12)
    assert contact.normal_force == pytest.approx(2 / 3 * contact.area * contact.peak_pressure, rel=1e-13)


def test_near_circle_is_smooth():
    """ln(a0/b0) → −(2/3) ln(κ_x/κ_y): a small difference must not drown in cancellation."""
    for difference in (1e-3, 1e-6, 1e-9, 1e-12):
        contact = hertz_contact(1.0 + difference, 1.0, 1e11, 50.0)
        slope = math.log(contact.aspect_ratio) / math.log1p(difference)
        assert slope == pytest.approx(-2 / 3, abs=max(1e-4 * difference, 1e-15 / difference))


@pytest.mark.parametrize("exponent", [-12, -6, 6, 12])
def test_extreme_curvature_ratios_become_line_contacts(exponent):
    ratio = 10.0**exponent
    contact = hertz_contact(ratio, 1.0, 1e11, 50.0)
    steep = max(ratio, 1.0)
    small = min(contact.semi_axis_x, contact.semi_axis_y)
    large = max(contact.semi_axis_x, contact.semi_axis_y)
    # middle of a long ellipse: the line contact's p0 = E* a κ/2, up to (b/a)² ln(a/b)
    bound = 5 * (small / large) ** 2 * math.log(large / small)
    assert contact.peak_pressure == pytest.approx(0.5e11 * small * steep, rel=max(bound, 1e-12))
    line = line_contact(steep, 1e11, 0.5 * math.pi * small * contact.peak_pressure)
    assert line.half_width == pytest.approx(small, rel=max(bound, 1e-12))


def test_axes_swap():
    one, other = hertz_contact(3.0, 70.0, 1e11, 50.0), hertz_contact(70.0, 3.0, 1e11, 50.0)
    assert one.semi_axis_x == pytest.approx(other.semi_axis_y, rel=1e-15)
    assert one.semi_axis_x > one.semi_axis_y
    assert one.displacement(2e-4, 1e-4) == pytest.approx(other.displacement(1e-4, 2e-4), rel=1e-14)


def test_units_do_not_matter():
    """Lengths in mm, forces in N: every number changes as its unit does."""
    metres, millimetres = hertz_contact(20.0, 90.0, 1e11, 50.0), hertz_contact(0.02, 0.09, 1e5, 50.0)
    assert millimetres.semi_axis_x == pytest.approx(1e3 * metres.semi_axis_x, rel=1e-14)
    assert millimetres.peak_pressure == pytest.approx(1e-6 * metres.peak_pressure, rel=1e-14)
    assert millimetres.gap(2.0, 3.0) == pytest.approx(1e3 * metres.gap(2e-3, 3e-3), rel=1e-13)


def displacement_inside_by_rays(contact, x, y):
    """u = 1/(πE*) ∬ p/r: along every line through the point the pressure is a semi-ellipse with a known area."""
    theta = (np.arange(4000) + 0.5) * math.pi / 4000
    a, b = contact.semi_axis_x, contact.semi_axis_y
    q = (np.cos(theta) / a) ** 2 + (np.sin(theta) / b) ** 2
    lean = x * np.cos(theta) / a**2 + y * np.sin(theta) / b**2
    peak = 1 - (x / a) ** 2 - (y / b) ** 2 + lean**2 / q
    return np.mean(0.5 * math.pi * contact.peak_pressure * peak / np.sqrt(q)) / contact.contact_modulus


def displacement_outside_by_quadrature(contact, x, y):
    """∬ p/(πE* r) over the ellipse in stretched polar coordinates, smooth as long as (x, y) is outside."""
    node, gauss = np.polynomial.legendre.leggauss(60)
    t = 0.25 * math.pi * (node + 1)
    rho, weight = np.sin(t), 0.25 * math.pi * gauss * np.cos(t) ** 2 * np.sin(t)
    angle = np.arange(800) * math.pi / 400
    sx = contact.semi_axis_x * rho[:, None] * np.cos(angle)
    sy = contact.semi_axis_y * rho[:, None] * np.sin(angle)
    total = np.sum(weight[:, None] / np.hypot(x - sx, y - sy)) * math.pi / 400
    area = contact.semi_axis_x * contact.semi_axis_y
    return contact.peak_pressure * area * total / (math.pi * contact.contact_modulus)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_displacement_matches_direct_quadrature(aspect):
    contact = contact_of_aspect(aspect)
    a, b = contact.semi_axis_x, contact.semi_axis_y
    for u, v in [(0.0, 0.0), (0.6, 0.0), (-0.3, 0.7), (0.1, -0.9)]:
        expected = displacement_inside_by_rays(contact, u * a, v * b)
        assert contact.displacement(u * a, v * b) == pytest.approx(expected, rel=1e-12)
    far = max(a, b)
    for x, y in [(a + 0.2 * far, 0.0), (0.0, -b - 0.2 * far), (a + 0.1 * far, b + 0.1 * far), (-3 * far, 2 * far)]:
        expected = displacement_outside_by_quadrature(contact, x, y)
        assert contact.displacement(x, y) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_gap_opens_with_power_three_halves(aspect):
    contact = contact_of_aspect(aspect)
    steps = np.geomspace(1e-4, 1e-3, 5)
    for direction in (0.3, 1.2):
        rim_x, rim_y = contact.semi_axis_x * math.cos(direction), contact.semi_axis_y * math.sin(direction)
        opening = contact.gap(rim_x * (1 + steps), rim_y * (1 + steps))
        assert np.all(opening > 0)
        assert np.polyfit(np.log(steps), np.log(opening), 1)[0] == pytest.approx(1.5, abs=5e-3)
        assert np.all(contact.gap(rim_x * (1 - steps), rim_y * (1 - steps)) == 0)


def test_far_field_and_balance():
    contact = hertz_contact(3.0, 70.0, 1e11, 50.0)
    r = 1e5 * contact.semi_axis_x
    assert contact.displacement(r, 0.0) == pytest.approx(50.0 / (math.pi * 1e11 * r), rel=1e-9)
    node, gauss = np.polynomial.legendre.leggauss(400)
    x, y = np.meshgrid(node * contact.semi_axis_x, node * contact.semi_axis_y, indexing="ij")
    force = gauss @ contact.pressure(x, y) @ gauss * contact.semi_axis_x * contact.semi_axis_y
    assert force == pytest.approx(50.0, rel=1e-4)


def test_shapes_broadcast():
    contact = hertz_contact(3.0, 70.0, 1e11, 50.0)
    x = np.linspace(-1e-3, 1e-3, 7)
    for method in (contact.pressure, contact.displacement, contact.gap, contact.undeformed_gap):
        grid = method(x[:, None], x[None, :3])
        assert grid.shape == (7, 3)
        assert method(0.0, 0.0).shape == ()
        assert grid[5, 1] == method(x[5], x[1])


def test_line_contact():
    line = line_contact(40.0, 1e11, 2e5)
    assert line.peak_pressure == pytest.approx(2 * 2e5 / (math.pi * line.half_width), rel=1e-14)
    assert line.pressure([0.0, line.half_width, 1.0]).tolist() == [line.peak_pressure, 0.0, 0.0]


def test_the_package_itself_imports_nothing():
    check = "import sys, thermoroll_cli.exact; sys.exit(any(m in sys.modules for m in ('numpy', 'scipy')))"
    assert subprocess.run([sys.executable, "-c", check], check=False).returncode == 0


@pytest.mark.parametrize("difference", [4e-16, 1e-12, 0.99e-6, 1.01e-6, 1e-4])
def test_almost_circular_contacts(difference):
    """Curvatures that differ by rounding: ln(a/b) is −2/3 of the logarithm of their ratio."""
    contact = hertz_contact(10.0 * math.exp(difference), 10.0, 1e11, 100.0)
    ratio = math.log(contact.semi_axis_x) - math.log(contact.semi_axis_y)
    assert ratio == pytest.approx(-2.0 / 3.0 * difference, rel=1e-6, abs=1e-15)

"""Elastic influence coefficients against quadratures of the point kernels, exact identities and closed-form fields."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from tests.support.scenes import order
from thermoroll_cli.exact.cattaneo_mindlin import full_slip_displacement
from thermoroll_cli.exact.hertz import element_averages, hertz_contact
from thermoroll_cli.exact.kalker import combined_constants
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, normal_table, rectangle_integrals, shear_tables
from thermoroll_cli.physics.numerics.convolution import Convolution
from thermoroll_cli.physics.numerics.grid import Grid

INTEGRANDS = {
    "xx": lambda x, y: x * x / np.hypot(x, y) ** 3,
    "yy": lambda x, y: y * y / np.hypot(x, y) ** 3,
    "xy": lambda x, y: x * y / np.hypot(x, y) ** 3,
}
OFFSETS = [(1, 0), (0, 1), (1, 1), (2, 0), (0, 3), (3, 2), (7, 1), (2, 9)]
SIZES = [(1.0, 1.0), (1.0, 0.3), (0.2, 1.0), (1.0, 10.0)]


def over_rectangle(integrand, i, j, dx, dy):
    """Gauss quadrature over the rectangle in panels no wider than its distance from the origin, where it is seen."""
    node, weight = np.polynomial.legendre.leggauss(24)
    low_x, high_x, low_y, high_y = (i - 0.5) * dx, (i + 0.5) * dx, (j - 0.5) * dy, (j + 0.5) * dy

    distance = math.hypot(max(low_x, 0.0), max(low_y, 0.0))
    total = 0.0
    xs, ys = (
        np.linspace(low, high, 1 + math.ceil((high - low) / distance)) for low, high in ((low_x, high_x), (low_y, high_y))
    )
    for x0, x1 in pairwise(xs):
        for y0, y1 in pairwise(ys):
            x = 0.5 * (x0 + x1) + 0.5 * (x1 - x0) * node
            y = 0.5 * (y0 + y1) + 0.5 * (y1 - y0) * node
            values = integrand(x[:, None], y[None, :])
            total += 0.25 * (x1 - x0) * (y1 - y0) * float(weight @ values @ weight)
    return total


def over_own_rectangle(angular, dx, dy):
    """∬ f(θ)/r over the rectangle around the origin is ∫ f(θ) R(θ) dθ, R the distance to its edge."""
    corner = math.atan2(dy, dx)

    def ray(theta):
        cos, sin = abs(math.cos(theta)), abs(math.sin(theta))
        reach = min(0.5 * dx / cos if cos > 1e-15 else math.inf, 0.5 * dy / sin if sin > 1e-15 else math.inf)
        return angular(theta) * reach

    ends = [0.0, corner, math.pi / 2]
    return 4.0 * sum(quad(ray, a, b, epsabs=0.0, epsrel=1e-13)[0] for a, b in pairwise(ends))


@pytest.mark.parametrize(("dx", "dy"), SIZES)
@pytest.mark.parametrize(("i", "j"), OFFSETS)
def test_rectangle_integrals_match_quadrature(i, j, dx, dy):
    tables = rectangle_integrals(10, 10, dx, dy)
    for name, table in zip(("xx", "yy", "xy"), tables, strict=True):
        expected = over_rectangle(INTEGRANDS[name], i, j, dx, dy) if i * j or name != "xy" else 0.0
        assert table[i, j] == pytest.approx(expected, rel=1e-9, abs=1e-12), name


@pytest.mark.parametrize(("dx", "dy"), SIZES)
def test_own_coefficients_match_quadrature(dx, dy):
    i_xx, i_yy, i_xy = (table[0, 0] for table in rectangle_integrals(1, 1, dx, dy))
    assert i_xx == pytest.approx(over_own_rectangle(lambda t: math.cos(t) ** 2, dx, dy), rel=1e-11)
    assert i_yy == pytest.approx(over_own_rectangle(lambda t: math.sin(t) ** 2, dx, dy), rel=1e-11)
    assert i_xy == 0.0


def test_far_elements_act_like_point_loads_without_cancellation():
    """At 250 element widths the corner differences must still leave more digits than the point load is accurate to."""
    i_xx, i_yy, i_xy = rectangle_integrals(256, 256, 1.0, 1.0)
    for i, j in [(255, 3), (4, 255), (200, 200)]:
        r = math.hypot(i, j)
        assert i_xx[i, j] + i_yy[i, j] == pytest.approx(1.0 / r, rel=3.0 / r**2)
        assert i_xx[i, j] == pytest.approx(i * i / r**3, rel=3.0 / r**2, abs=1.0 / r**3)
        assert i_xy[i, j] == pytest.approx(i * j / r**3, rel=10.0 / r**2)


def test_normal_table_is_loves_solution():
    """(1/πE*) ∬ 1/r, with 1/E* summed over both bodies."""
    modulus = 1.0 / ((1 - 0.3**2) / 200e9 + (1 - 0.2**2) / 70e9)
    table = normal_table(4, 4, 2e-6, 3e-6, modulus)
    for i, j in [(1, 0), (2, 3)]:
        expected = over_rectangle(lambda x, y: 1.0 / np.hypot(x, y), i, j, 2e-6, 3e-6) / (math.pi * modulus)
        assert table[i, j] == pytest.approx(expected, rel=1e-9)
    assert (np.diff(table, axis=0) < 0).all() and (np.diff(table, axis=1) < 0).all()


@pytest.mark.parametrize("bodies", [((80e9, 0.28), (80e9, 0.28)), ((80e9, 0.3), (26e9, 0.0)), ((2e9, 0.5), (9e9, 0.1))])
def test_shear_tables_are_cerrutis_solution_summed_over_the_bodies(bodies):
    """u_x = Σ 1/(2πG) ∬ {[(1−ν)/r + ν x²/r³] τ_x + ν x y/r³ τ_y}, and likewise u_y."""
    dx, dy, (i, j) = 2e-6, 3e-6, (2, 1)
    expected = np.zeros(3)
    for g, nu in bodies:
        xx = over_rectangle(lambda x, y, nu=nu: (1 - nu) / np.hypot(x, y) + nu * INTEGRANDS["xx"](x, y), i, j, dx, dy)
        yy = over_rectangle(lambda x, y, nu=nu: (1 - nu) / np.hypot(x, y) + nu * INTEGRANDS["yy"](x, y), i, j, dx, dy)
        xy = over_rectangle(lambda x, y, nu=nu: nu * INTEGRANDS["xy"](x, y), i, j, dx, dy)
        expected += np.array([xx, yy, xy]) / (2 * math.pi * g)
    tables = shear_tables(4, 4, dx, dy, ShearCompliance.of(*bodies))
    assert [table[i, j] for table in tables] == pytest.approx(expected, rel=1e-9)


def test_two_bodies_act_like_two_of_their_combined_constants():
    """Kalker's combined G and ν stand for both bodies in the tangential kernel."""
    bodies = (80e9, 0.3), (26e9, 0.1)
    combined = combined_constants(*bodies[0], *bodies[1])
    for one, other in zip(shear_tables(5, 4, 1.0, 0.7, ShearCompliance.of(*bodies)),
                          shear_tables(5, 4, 1.0, 0.7, ShearCompliance.of(combined, combined)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)


def test_strip_compliances_are_the_plane_limits():
    """Plane strain Σ(1−ν)/G along the gradient, anti-plane Σ1/G across it."""
    compliance = ShearCompliance.of((80e9, 0.28), (30e9, 0.4))
    assert compliance.along == pytest.approx(0.72 / 80e9 + 0.6 / 30e9, rel=1e-14)
    assert compliance.across == pytest.approx(1 / 80e9 + 1 / 30e9, rel=1e-14)


def test_a_long_strip_of_elements_acts_like_the_half_plane():
    """Summed over a long y the differences of u are those of −(compliance/π) ∫ ln|x − x'| dx'."""
    compliance = ShearCompliance.of((1.0, 0.28), (1.0, 0.28))
    count, dx, dy = 6, 1.0, 4e4
    tables = shear_tables(count, 2, dx, dy, compliance)

    def antiderivative(t):
        return t * math.log(abs(t)) - t

    logarithm = np.array([antiderivative(i + 0.5) - antiderivative(i - 0.5) for i in range(count)])
    for table, plane in ((tables[0], compliance.along), (tables[1], compliance.across)):
        strip = table[:, 0] + 2.0 * table[:, 1]
        np.testing.assert_allclose(strip - strip[0], -plane / math.pi * (logarithm - logarithm[0]), rtol=1e-7)


# --- order of the operators ---------------------------------------------------------------------------------------

SIDES = [16, 32, 64, 128]


def hertz_on_grid(n, aspect=1.0):
    """Element averages of a Hertz pressure with a0 = aspect, b0 = 1 in a domain of 2.2 semi-axes."""
    hertz = hertz_contact(40.0 * aspect**-1.6, 40.0, 1.0e11, 100.0)
    grid = Grid.over((n, n), 2.2 * hertz.semi_axis_x, 2.2 * hertz.semi_axis_y)
    edges = [np.append(c - 0.5 * d, c[-1] + 0.5 * d) for c, d in ((grid.x, grid.dx), (grid.y, grid.dy))]
    return hertz, grid, element_averages(hertz, *edges)[0]


def test_grid_is_centred_and_covers_its_domain():
    grid = Grid.over((5, 8), 1.0, 4.0)
    assert (grid.dx, grid.dy, grid.element_area) == pytest.approx((0.2, 0.5, 0.1))
    np.testing.assert_allclose(grid.x, [-0.4, -0.2, 0.0, 0.2, 0.4], atol=1e-15)
    np.testing.assert_allclose(grid.y, -grid.y[::-1], atol=1e-15)


@pytest.mark.parametrize("aspect", [1.0, 5.0])
def test_normal_displacement_converges_to_hertz(aspect):
    """u_z of the averaged Hertz pressure against the closed form, inside and outside the contact."""
    errors = []
    for n in SIDES:
        hertz, grid, pressure = hertz_on_grid(n, aspect)
        convolution = Convolution(n, n)
        kernel = convolution.quadrant_spectrum(normal_table(n, n, grid.dx, grid.dy, hertz.contact_modulus))
        hat = convolution.forward(pressure)
        u = convolution.inverse((hat.view(float) * kernel).view(complex))
        errors.append(np.abs(u - hertz.displacement(grid.x[:, None], grid.y[None, :])).mean() / hertz.approach)
    assert errors[-1] < 6e-5
    assert order(SIDES, errors) > 1.8


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_tangential_displacement_converges_to_cattaneo_mindlin(nu):
    """u_x and u_y of τ_x = μp on two bodies against the closed form, inside and outside the contact."""
    shear_modulus, errors = 80e9, []
    for n in SIDES:
        hertz, grid, traction = hertz_on_grid(n)
        tables = shear_tables(n, n, grid.dx, grid.dy, ShearCompliance.of((shear_modulus, nu), (shear_modulus, nu)))
        convolution = Convolution(n, n)
        hat = convolution.forward(traction)
        exact = full_slip_displacement(
            grid.x[:, None], grid.y[None, :], hertz.semi_axis_x, hertz.peak_pressure, shear_modulus, nu
        )
        worst = 0.0
        for table, parity, expected in zip((tables[0], tables[2]), (1, -1), exact, strict=True):
            kernel = convolution.quadrant_spectrum(table, parity)
            u = convolution.inverse((hat.view(float) * kernel).view(complex))
            worst = max(worst, np.abs(u - 2.0 * expected).mean() / np.abs(2.0 * exact[0]).max())
        errors.append(worst)
    assert errors[-1] < 6e-5
    assert order(SIDES, errors) > 1.8

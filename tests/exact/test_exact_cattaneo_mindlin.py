"""Cattaneo–Mindlin against direct quadrature of Cerruti's kernel and its own balances."""

import math

import numpy as np
import pytest

from thermoroll_cli.exact.cattaneo_mindlin import cattaneo_mindlin, full_slip_displacement

A, P0, MU, G, NU = 2e-4, 9e8, 0.3, 8e10, 0.28
LIMIT = MU * 2 / 3 * math.pi * A**2 * P0


def cerruti_inside(x, y, nu):
    """1/(2πG) ∬ {(1−ν)/r + ν (x−x')²/r³, ν (x−x')(y−y')/r³} τ, summed over lines through the point."""
    theta = (np.arange(400) + 0.5) * math.pi / 400
    along = x * np.cos(theta) + y * np.sin(theta)
    area = 0.5 * math.pi * P0 / A * (A**2 - x**2 - y**2 + along**2)
    u_x = np.sum((1 - nu + nu * np.cos(theta) ** 2) * area) * math.pi / 400
    u_y = np.sum(nu * np.cos(theta) * np.sin(theta) * area) * math.pi / 400
    return u_x / (2 * math.pi * G), u_y / (2 * math.pi * G)


def cerruti_outside(x, y, nu):
    node, gauss = np.polynomial.legendre.leggauss(60)
    t = 0.25 * math.pi * (node + 1)
    rho = A * np.sin(t)
    weight = P0 * A**2 * 0.25 * math.pi * gauss * np.cos(t) ** 2 * np.sin(t) * math.pi / 200
    angle = np.arange(400) * math.pi / 200
    dx, dy = x - rho[:, None] * np.cos(angle), y - rho[:, None] * np.sin(angle)
    r = np.hypot(dx, dy)
    u_x = np.sum(weight[:, None] * ((1 - nu) / r + nu * dx**2 / r**3))
    u_y = np.sum(weight[:, None] * nu * dx * dy / r**3)
    return u_x / (2 * math.pi * G), u_y / (2 * math.pi * G)


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_full_slip_displacement_matches_quadrature(nu):
    scale = P0 * A / G
    for x, y in [(0.0, 0.0), (0.5, 0.0), (-0.2, 0.9), (0.6, -0.6)]:
        found = full_slip_displacement(x * A, y * A, A, P0, G, nu)
        assert found == pytest.approx(cerruti_inside(x * A, y * A, nu), abs=1e-13 * scale)
    for x, y in [(1.3, 0.0), (0.0, -1.4), (1.0, 0.9), (-5.0, 3.0)]:
        found = full_slip_displacement(x * A, y * A, A, P0, G, nu)
        assert found == pytest.approx(cerruti_outside(x * A, y * A, nu), abs=1e-12 * scale)


def test_displacement_is_continuous_at_the_rim():
    angle = np.linspace(0, 2 * math.pi, 17)
    inner = full_slip_displacement((1 - 1e-9) * A * np.cos(angle), (1 - 1e-9) * A * np.sin(angle), A, P0, G, NU)
    outer = full_slip_displacement((1 + 1e-9) * A * np.cos(angle), (1 + 1e-9) * A * np.sin(angle), A, P0, G, NU)
    np.testing.assert_allclose(inner, outer, atol=1e-8 * P0 * A / G)


@pytest.mark.parametrize("share", [0.1, -0.5, 7 / 8, 1.0])
def test_partial_slip(share):
    solution = cattaneo_mindlin(A, P0, MU, share * LIMIT)
    assert solution.stick_radius == pytest.approx(A * (1 - abs(share)) ** (1 / 3), abs=1e-12 * A)
    node, gauss = np.polynomial.legendre.leggauss(200)
    # integrate over both annuli apart: the traction has a root at each radius
    total = 0.0
    for low, high in [(0.0, solution.stick_radius), (solution.stick_radius, A)]:
        r = low + 0.5 * (high - low) * (node + 1)
        total += 0.5 * (high - low) * gauss @ (2 * math.pi * r * solution.traction(r, 0.0))
    assert total == pytest.approx(share * LIMIT, rel=1e-5)

    u, v = np.meshgrid(np.linspace(-0.99, 0.99, 21), np.linspace(-0.99, 0.99, 21))
    u_x, u_y = solution.displacement(A * u, A * v, G, NU)
    sticks = np.hypot(u, v) * A < solution.stick_radius
    scale = abs(P0 * MU * A / G)
    np.testing.assert_allclose(u_x[sticks], solution.shift(G, NU), atol=1e-14 * scale)
    np.testing.assert_allclose(u_y[sticks], 0.0, atol=1e-14 * scale)
    slips = ~sticks & (np.hypot(u, v) < 1)
    # the surface lags behind the rigid shift where it slips
    assert np.all(np.sign(share) * (solution.shift(G, NU) - u_x[slips]) > 0)
    # and the traction there is at its limit
    limit = MU * P0 * np.sqrt(1 - np.hypot(u, v)[slips] ** 2)
    np.testing.assert_allclose(np.abs(solution.traction(A * u, A * v)[slips]), limit, rtol=1e-12)


def test_full_slip_shift_is_johnsons():
    """3μW(2−ν)/(16Ga) per body at the onset of sliding."""
    shift = cattaneo_mindlin(A, P0, MU, LIMIT).shift(G, NU)
    assert shift == pytest.approx(3 * LIMIT * (2 - NU) / (16 * G * A), rel=1e-14)

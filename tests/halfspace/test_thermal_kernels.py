"""Influence coefficients of a moving heat source, against references, direct quadrature, and exact identities."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import k0e

from tests.support.convolution import convolved
from tests.support.sampling import sampled
from tests.support.scenes import reference, rolling
from thermoroll_cli.physics.halfspace.thermal import (
    displacement_table,
    slopes,
    temperature_at,
    temperature_slope_table,
    temperature_table,
)
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating
from thermoroll_cli.python_api import solve

KERNEL = reference("thermal_kernel")["entries"]
SOURCES = reference("moving_sources")
TABLES = {"temperature": temperature_table, "displacement": displacement_table}
# Good to this, relative to the coefficient of an element on itself.
ACCURACY = {"temperature": 1e-10, "displacement": 3e-8}


@pytest.mark.parametrize("peclet", sorted({entry["P"] for entry in KERNEL}))
def test_reference_entries(peclet):
    entries = [entry for entry in KERNEL if entry["P"] == peclet]
    nx, ny = 201, 51
    for name, key in (("temperature", "T"), ("displacement", "U")):
        table = TABLES[name](nx, ny, 1.0, peclet)
        assert table.shape == (2 * nx - 1, 2 * ny - 1)
        computed = np.array([table[nx - 1 + e["offset"][0], ny - 1 + e["offset"][1]] for e in entries])
        error = np.abs(computed - [e[key] for e in entries]).max() / table[nx - 1, ny - 1]
        assert error < ACCURACY[name], f"{name}: {error:.1e}"


# ---- direct quadrature of the point kernels ----


def point_temperature(x, y, peclet_x, peclet_y):
    """exp(−(|P|r − P·r)/2)/2πr."""
    r = np.hypot(x, y)
    return np.exp(-0.5 * (math.hypot(peclet_x, peclet_y) * r - peclet_x * x - peclet_y * y)) / (2 * np.pi * r)


def point_displacement(x, y, peclet_x, peclet_y):
    """(2/π²) ∫ c exp(P·r c/2) K0(|P|r c/2) dθ, c = cos²θ, θ from 0 to π/2 (graded towards π/2, where K0 → ∞)."""
    nodes, weights = np.polynomial.legendre.leggauss(48)
    v = 0.5 * (nodes + 1.0)
    c = np.sin(0.5 * np.pi * v**3) ** 2
    weights = 0.5 * weights * 1.5 * np.pi * v**2 * c
    speed, total = math.hypot(peclet_x, peclet_y), np.zeros(np.broadcast(x, y).shape)
    r, along = np.hypot(x, y), peclet_x * x + peclet_y * y
    for ci, wi in zip(c, weights, strict=True):
        total += wi * k0e(0.5 * ci * speed * r) * np.exp(-0.5 * ci * (speed * r - along))
    return 2.0 / np.pi**2 * total


def panel_nodes(low, high, panels, order=10):
    nodes, weights = np.polynomial.legendre.leggauss(order)
    edges = np.linspace(low, high, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


def over_element(point_kernel, x, y, aspect, peclets):
    """Integral of a point kernel over the element whose centre lies at (x, y) from the point of observation."""
    if x == 0 and y == 0:
        # Triangles from the singular point to each edge: x = t·(point on the edge), t = v².
        t, wt = panel_nodes(0.0, 1.0, 2, 16)
        t, wt = t**2, 2 * t * wt
        total = 0.0
        for half_distance, half_length, turn in ((0.5, 0.5 * aspect, 0), (0.5 * aspect, 0.5, 1)):
            s, ws = panel_nodes(-half_length, half_length, 24)
            for sign in (-1.0, 1.0):
                normal = np.full_like(s, sign * half_distance)
                edge = (normal, s) if turn == 0 else (s, normal)
                values = point_kernel(np.multiply.outer(t, edge[0]), np.multiply.outer(t, edge[1]), *peclets)
                total += half_distance * (wt * t) @ values @ ws
        return total
    panels = 10 if abs(x) <= 1 and abs(y) <= aspect else 5
    sx, wx = panel_nodes(x - 0.5, x + 0.5, panels)
    sy, wy = panel_nodes(y - 0.5 * aspect, y + 0.5 * aspect, panels)
    return wx @ point_kernel(sx[:, None], sy[None, :], *peclets) @ wy


@pytest.mark.parametrize(("aspect", "peclets"), [
    (0.3, (-2.0, 5.0)),
    *(pytest.param(*row, marks=pytest.mark.slow) for row in (
        (0.1, (30.0, 0.0)), (0.1, (0.02, 0.0)), (10.0, (-8.0, 0.0)), (10.0, (0.5, 0.0)),
        (2.0, (100.0, 0.0)), (1.0, (3.0, 0.4)), (3.0, (0.0, -0.7)))),
])
def test_direct_quadrature(aspect, peclets):
    nx = ny = 16
    offsets = [(0, 0), (1, 0), (0, 1), (-1, -1), (5, -2), (-9, 0), (12, 15)]
    for name, point_kernel in (("temperature", point_temperature), ("displacement", point_displacement)):
        table = TABLES[name](nx, ny, aspect, *peclets)
        for i, j in offsets:
            exact = over_element(point_kernel, i, aspect * j, aspect, peclets)
            error = abs(table[nx - 1 + i, ny - 1 + j] - exact) / table[nx - 1, ny - 1]
            assert error < ACCURACY[name], f"{name} at {i}, {j}: {error:.1e}"


# ---- identities that hold for every entry ----


@pytest.mark.parametrize("name", TABLES)
def test_a_little_lateral_motion_changes_little(name):
    """The full table of oblique motion continues the half table of motion along x."""
    straight, oblique = (TABLES[name](20, 15, 0.8, 1.3, lateral) for lateral in (0.0, 1e-7))
    change = np.abs(oblique - straight).max() / straight.max()
    assert 1e-12 < change < 1e-6 + 2 * ACCURACY[name]


# ---- limits ----


def test_slow_motion():
    """T − T(0) → −P(1 − cosθ)/4π and U − U(0) → −(b/2π)[ln(P/16) + γ + 1], with errors that vanish like P ln P."""
    nx, ny, aspect = 12, 10, 0.6
    stationary = {name: table(nx, ny, aspect, 0.0) for name, table in TABLES.items()}
    slow = temperature_table(nx, ny, aspect, 1e-4)
    centre = (slow - stationary["temperature"])[nx - 1, ny - 1]
    assert centre == pytest.approx(-1e-4 * aspect / (4 * math.pi), rel=1e-3)
    errors = []
    for peclet in (1e-2, 1e-3, 1e-4):
        rise = displacement_table(nx, ny, aspect, peclet) - stationary["displacement"]
        rise += aspect / (2 * math.pi) * (math.log(peclet / 16.0) + np.euler_gamma + 1.0)
        errors.append(np.abs(rise).max())
    order = np.diff(np.log10(errors)).mean()
    assert -1.0 < order < -0.8
    assert errors[-1] < 1e-3


def test_fast_motion_is_one_dimensional_conduction():
    """Midway along the element the surface has been heated for half a passage: T = √(2/πP)(1 + O(1/P))."""
    table = temperature_table(4, 3, 1.0, 1e5)
    assert table[3, 2] == pytest.approx(math.sqrt(2.0 / (math.pi * 1e5)), rel=1e-5)
    assert np.abs(table[:3]).max() == 0.0


@pytest.mark.parametrize("name", sampled(TABLES))
def test_every_speed_is_finite_and_continuous(name):
    """From far below the smallest double that squares to more than zero, up to 1e5, without warnings or steps."""
    peclets = np.concatenate(([1e-300, 1e-30], np.logspace(-14, 5, 77)))
    tables = np.array([TABLES[name](3, 2, 3.0, p) for p in peclets])
    assert np.isfinite(tables).all()
    at_source = tables[:, 2, 1]
    assert (np.diff(at_source) <= 1e-10 * at_source[1:]).all()
    # A step of a quarter of a decade changes U by (b/2π) ln 10/4 at most, and T by about a factor 10^(1/8).
    if name == "temperature":
        assert (at_source[:-1] / at_source[1:]).max() < 10**0.15
    else:
        assert -np.diff(at_source[2:]).min() < 3.0 / (2 * math.pi) * math.log(10.0) / 4 + 1e-6


def test_smallest_grid():
    assert temperature_table(1, 1, 1.0, 0.0).shape == displacement_table(1, 1, 1.0, 2.0, 1.0).shape == (1, 1)


# ---- moving sources of finite size ----


def surface_temperature(flux, spacing, peclet_a):
    """Temperature at element centres, in q a/k, for a flux given on an n × n grid; P_a = V a/κ."""
    n = len(flux)
    table = temperature_table(n, n, 1.0, peclet_a * spacing)
    return spacing * convolved(flux, table)


@pytest.mark.parametrize("peclet", SOURCES["square"])
def test_square_source(peclet):
    """64 × 64 elements of uniform flux, |x|, |y| < a. Sampled points lie at corners of elements: offsets are halves."""
    exact, n = SOURCES["square"][peclet], 64
    spacing = 2.0 / n
    peclet_a = float(peclet)
    x = np.arange(-1.5 * n + 0.5, 2.5 * n)
    rows = temperature_at(x, np.arange(-n / 2 + 0.5, n / 2), 1.0, peclet_a * spacing).sum(axis=1)
    sums = np.convolve(rows, np.ones(n), "valid") * spacing
    points = (x[: len(sums)] + (n - 1) / 2) * spacing
    on_centre_line = np.interp(exact["x"], points, sums)
    error = np.abs(on_centre_line - exact["T"]) / exact["Tmax"]
    inside_or_outside = np.abs(np.abs(exact["x"]) - 1.0) > 1e-9
    assert error.max() < 1e-3
    assert error[inside_or_outside].max() < 1e-9

    temperature = surface_temperature(np.ones((n, n)), spacing, peclet_a)
    assert temperature.max() == pytest.approx(exact["Tmax"], rel=1e-3)
    hottest = -1.0 + spacing * (temperature.max(axis=1).argmax() + 0.5)
    assert hottest == pytest.approx(exact["xmax"], abs=spacing)


@pytest.mark.parametrize("peclet", ["1", "10", "100"])
@pytest.mark.parametrize(
    ("profile", "flux"),
    [("hertz", lambda r2: 1.5 * np.sqrt(1.0 - r2)), ("paraboloid", lambda r2: 2.0 * (1.0 - r2))],
)
def test_circular_sources_converge_at_second_order(profile, flux, peclet):
    exact = SOURCES["circle"][profile][peclet]["Tmax"]
    sizes, errors = [17, 33, 65, 129], []
    for n in sizes:
        spacing = 2.0 / n
        x = spacing * (np.arange(n) - 0.5 * (n - 1))
        r2 = np.minimum(x[:, None] ** 2 + x[None, :] ** 2, 1.0)
        centre_line = surface_temperature(flux(r2), spacing, float(peclet))[:, n // 2]
        fine = np.linspace(x[0], x[-1], 4001)
        errors.append(abs(CubicSpline(x, centre_line)(fine).max() / exact - 1.0))
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert -2.5 < slope < -1.8, errors
    assert errors[-1] < 1e-4


@pytest.mark.parametrize("peclet", [(0.0, 0.0), (0.1, 0.0), (2.0, 0.5), (-3.0, 0.0), (300.0, 0.0)])
def test_a_slope_is_many_narrow_sources(peclet: tuple[float, float]) -> None:
    """An element of 81 uniform slices with the slope's first moment: within 3e-5 of an element on itself."""
    nx, ny, aspect, parts = 6, 4, 0.7, 81
    x, y = np.arange(1.0 - nx, nx), aspect * np.arange(1.0 - ny, ny)
    expected = np.zeros((len(x), len(y)))
    for place in (np.arange(parts) - parts // 2) / parts:
        one = temperature_at(parts * (x - place), parts * y, parts * aspect, peclet[0] / parts, peclet[1] / parts)
        expected += place * one / parts
    expected *= parts**2 / (parts**2 - 1.0)
    scale = temperature_table(nx, ny, aspect, *peclet).max()
    assert np.abs(temperature_slope_table(nx, ny, aspect, *peclet) - expected).max() < 3e-5 * scale


def test_slopes_stay_inside_the_heated_rows() -> None:
    flux = np.array([0.0, 1.0, 4.0, 5.0, 5.0, 0.0, 2.0, 0.0])[:, None]
    assert slopes(flux)[:, 0].tolist() == [0.0, 2.0, 2.0, 0.5, 0.0, 0.0, 0.0, 0.0]  # 3 would make the flux negative


@pytest.mark.slow
def test_narrow_slip_zones_are_as_hot_as_on_fine_grids() -> None:
    """Wheel on rail at a fifth of saturation: heat from the last sixth of the contact, 9 elements at N = 64 (with constant
    flux in each element 7e-3 too cold there, and still 2e-3 at N = 128)."""
    geometry = Geometry(float("inf"), 0.3, 0.5, -0.4)
    problem = rolling(geometry=geometry, load=1e5, creepage=(5e-4, 0.0), speed=30.0, heating=Heating(deformation=False))
    hottest = {}
    for grid in (64, 128, 192):
        result = solve(replace(problem, numerics=replace(problem.numerics, grid=(grid, grid))))
        hottest[grid] = result.coupled.scalars["temperature_rise_max_lower_K"]
    assert hottest[64] == pytest.approx(hottest[192], rel=1.5e-3)
    assert hottest[128] == pytest.approx(hottest[192], rel=4e-4)

"""Low-rank expansion of thermal tables for a Péclet number that varies with the source."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.convolution import convolved
from tests.support.sampling import sampled
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_table
from thermoroll_cli.physics.halfspace.variable_peclet import variable_peclet_tables

TABLES = {"temperature": temperature_table, "displacement": displacement_table}


def true_error(tables, weights, peclets):
    """The two errors described in the module, of full tables."""
    nx, ny = (tables.shape[1] + 1) // 2, (tables.shape[2] + 1) // 2
    worst = 0.0
    for peclet in peclets:
        offset = weights.offset(peclet)
        varying = TABLES[weights.kind](nx, ny, weights.aspect, peclet) - offset
        difference = np.abs(np.tensordot(weights(peclet), tables, axes=(0, 0)) - varying)
        varying = np.abs(varying)
        worst = max(worst, difference.sum() / varying.sum(), difference.max() / varying.max())
    return worst


@pytest.mark.parametrize("kind", TABLES)
@pytest.mark.parametrize(("nx", "ny", "aspect", "peclet_max", "tolerance"), [
    (16, 16, 1.0, 10.0, 1e-3), (2, 1, 1.0, 1.0, 1e-5), (20, 20, 1.0, 1e-13, 1e-5),
    *(pytest.param(*row, marks=pytest.mark.slow) for row in (
        (16, 16, 1.0, 0.05, 1e-5), (16, 16, 1.0, 1.0, 1e-5), (24, 24, 1.0, 10.0, 1e-7), (12, 30, 0.2, 300.0, 1e-5),
        (16, 16, 1.0, 2e5, 1e-5), (60, 24, 5.0, 30.0, 1e-5))),
])
def test_error_is_below_the_tolerance_and_honest(kind, nx, ny, aspect, peclet_max, tolerance):
    tables, weights = variable_peclet_tables(nx, ny, aspect, peclet_max, kind, tolerance)
    assert tables.shape == (weights.terms, 2 * nx - 1, 2 * ny - 1)
    assert weights.error <= tolerance
    random = np.random.default_rng(1)
    fractions = np.concatenate(([0.0, 1.0], random.random(6), random.random(6) ** 8))
    assert true_error(tables, weights, peclet_max * fractions) <= 2.0 * weights.error + 1e-8


@pytest.mark.parametrize("kind", sampled(TABLES))
@pytest.mark.parametrize("peclet_max", sampled([20.0, 0.3]))
def test_response_against_one_kernel_per_source(kind, peclet_max):
    """Slip, flux and Péclet number rise together; some sources stick (P = 0, no flux), and some barely slip."""
    nx, ny, aspect = 7, 6, 0.7
    random = np.random.default_rng(2)
    peclet = peclet_max * random.random((nx, ny)) ** 3
    peclet[random.random((nx, ny)) < 0.2] = 0.0
    flux = peclet * (0.5 + random.random((nx, ny)))
    exact = np.zeros((nx, ny))
    for i, j in zip(*np.nonzero(flux), strict=True):
        table = TABLES[kind](nx, ny, aspect, peclet[i, j])
        exact += flux[i, j] * table[nx - 1 - i : 2 * nx - 1 - i, ny - 1 - j : 2 * ny - 1 - j]

    tables, weights = variable_peclet_tables(nx, ny, aspect, peclet_max, kind)
    response = np.full((nx, ny), (weights.offset(peclet) * flux).sum())
    for table, weight in zip(tables, weights(peclet), strict=True):
        response += convolved(weight * flux, table)
    assert np.abs(response - exact).max() < 1e-5 * np.abs(exact).max()
    # The check can fail: the kernel of the mean Péclet number is far off.
    uniform = TABLES[kind](nx, ny, aspect, peclet[flux > 0].mean())
    crude = convolved(flux, uniform)
    assert np.abs(crude - exact).max() > 1e-2 * np.abs(exact).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("peclet_a", "terms", "tight_terms"), [
        pytest.param(1.0, (4, 5), (5, 7), marks=pytest.mark.slow), (20.0, (9, 9), (12, 13)),
        pytest.param(200.0, (14, 14), (19, 19), marks=pytest.mark.slow)]
)
def test_number_of_terms(peclet_a, terms, tight_terms):
    """Terms for 1e-4 and 1e-6 at N = 64 elements over 2.2 a, as a function of P_a = V a/κ; hardly dependent on N."""
    for n in (32, 64):
        for tolerance, limits in ((1e-4, terms), (1e-6, tight_terms)):
            for kind, limit in zip(TABLES, limits, strict=True):
                _, weights = variable_peclet_tables(n, n, 1.0, peclet_a * 2.2 / n, kind, tolerance)
                assert abs(weights.terms - limit) <= 1


def test_offset_is_the_mean_of_the_table():
    nx, ny, aspect = 20, 16, 0.5
    tables, weights = variable_peclet_tables(nx, ny, aspect, 2.0, "displacement", 1e-7)
    assert np.abs(tables.mean(axis=(1, 2))).max() < 1e-9 * np.abs(tables).max()
    peclets = np.array([0.0, 1e-7, 1e-3, 0.4, 2.0])
    means = [displacement_table(nx, ny, aspect, p).mean() for p in peclets]
    np.testing.assert_allclose(weights.offset(peclets), means, rtol=1e-8)
    # Slow sources raise everything by −(b/2π) ln P: finite heat of a slip that dies out raises nothing.
    assert weights.offset(1e-200) - weights.offset(1e-100) == pytest.approx(aspect / (2 * math.pi) * 100 * math.log(10.0))
    assert np.abs(weights.offset(peclets[:1]) * 0.0).max() == 0.0
    # What is left of a table has a limit at P = 0: the table without motion, its mean removed.
    slow = np.tensordot(weights(0.0), tables, axes=(0, 0))
    stationary = displacement_table(nx, ny, aspect, 0.0)
    assert np.abs(slow - (stationary - stationary.mean())).max() < 1e-7 * np.abs(slow).max()
    _, temperature = variable_peclet_tables(nx, ny, aspect, 2.0, "temperature")
    assert (temperature.offset(peclets) == 0.0).all()


def test_no_motion_at_all_takes_one_term():
    for kind in TABLES:
        tables, weights = variable_peclet_tables(10, 8, 1.0, 0.0, kind)
        assert weights.terms == 1
        assert true_error(tables, weights, [0.0]) < 1e-9


def test_shapes_and_bad_arguments():
    _, weights = variable_peclet_tables(6, 5, 1.0, 1.0, "temperature")
    assert weights(0.5).shape == (weights.terms,)
    assert weights(np.zeros((6, 5))).shape == (weights.terms, 6, 5)
    assert weights(np.zeros(0)).shape == (weights.terms, 0)
    assert weights.offset(np.zeros((6, 5))).shape == (6, 5)
    for outside in (-1e-3, 1.001, math.nan):
        with pytest.raises(ValueError, match="between 0 and 1"):
            weights([0.5, outside])

"""The memory of bodies that relax: series, weights, tables against quadrature, symbols against tables."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from thermoroll_cli.physics.halfspace.bodies import bodies_of
from thermoroll_cli.physics.halfspace.relaxing import POINT_LOADS, Relaxing, filter_of, one_sided_means, weights
from thermoroll_cli.physics.numerics.convolution import half_plane_symbol, quadrant_symbol
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.problem.relaxation import modulus_at, retardation

TREAD = Material(2.4e9, 0.38, relaxation=((0.30, 1e-4), (0.25, 1e-3), (0.20, 1e-2)))
STEEL = Material(210e9, 0.3)


@given(st.lists(st.tuples(st.floats(1e-5, 1.0), st.floats(-9.0, 9.0)), min_size=1, max_size=8), st.floats(0.01, 0.999))
@settings(max_examples=25, deadline=None)
def test_compliance_is_the_inverse_of_the_modulus(shares: list[tuple[float, float]], relaxed: float) -> None:
    total = sum(share for share, _ in shares)
    series = [(share / total * relaxed, 10.0**power) for share, power in shares]
    pairs = retardation(series)
    assert 1.0 + sum(c for c, _ in pairs) == pytest.approx(1.0 / modulus_at(series, 0.0).real, rel=1e-6)
    for frequency in np.geomspace(1e-11, 1e11, 23):
        compliance = 1.0 + sum(c / (1.0 + 1j * frequency * time) for c, time in pairs)
        assert abs(compliance * modulus_at(series, frequency) - 1.0) < 1e-5


def test_retardation_times_interlace() -> None:
    times = sorted(time for _, time in TREAD.relaxation)
    slower = [time for _, time in TREAD.retardation]
    assert all(a < b for a, b in zip(times, slower, strict=True))
    assert all(a < b for a, b in zip(slower, times[1:], strict=False))


def test_one_time_in_two_parts_is_one() -> None:
    assert np.array(retardation([(0.2, 1.0), (0.3, 1.0)])) == pytest.approx(np.array(retardation([(0.5, 1.0)])))


@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 0.3, 5.0, 39.9, 40.1, 1e6])
def test_waves_lose_power_and_keep_their_mean(ratio: float) -> None:
    theta = np.linspace(-math.pi, math.pi, 401)
    factor = filter_of(ratio, theta)
    q, w = weights(ratio)
    assert q + w.sum() == pytest.approx(1.0, abs=1e-13)
    assert (factor.real > 0.0).all()
    assert (factor.imag * np.sign(theta) <= 1e-15).all()
    long = theta[205]
    assert factor[205] == pytest.approx(1.0 / (1.0 + 1j * long / ratio), rel=1e-4)


@pytest.mark.parametrize("kind", ["xx", "yy", "xy", "x", "y"])
@pytest.mark.parametrize("length", [0.4, 6.0, 300.0])
def test_means_are_those_of_the_integrals(kind: str, length: float) -> None:
    """Far from the element, whose finite size is then a small correction; on narrow and on wide elements."""
    kernel, dx = POINT_LOADS[kind][1], 1.0
    nodes, gauss = np.polynomial.legendre.leggauss(12)

    def seen(s: float, x: float, y: float, dy: float) -> float:
        values = kernel(np.array(x - s) + 0.5 * dx * nodes[:, None], y + 0.5 * dy * nodes, 0.0)
        return float(0.25 * dx * dy * (gauss @ values @ gauss) * math.exp(-s / length) / length)

    edges = [0.0, *np.geomspace(0.5 * min(length, 40.0), 60.0 * length, 12)]
    for dy in (1.3, 25.0):
        mean = one_sided_means(kind, 60, 4, dx, dy, np.array([length]))[0]
        for row, column in ((-59, 3), (-45, 1)):
            place = row * dx, column * dy, dy
            expected = sum(quad(seen, a, b, place, epsabs=1e-13)[0] for a, b in pairwise(edges))
            assert mean[row + 59, column] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_long_and_short_memories_of_tables() -> None:
    """Short memories follow at once, long ones not at all."""
    place = 20, 12, 1.0, 0.7
    short, long = one_sided_means("xx", *place, np.array([1e-9, 1e12]))
    instant = one_sided_means("xx", *place, np.array([1e-12]))[0]
    assert short == pytest.approx(instant, rel=1e-8)
    assert np.abs(long).max() < 1e-8 * instant.max()


@pytest.mark.parametrize("parity", [1, -1])
def test_symbols_of_symmetric_tables(parity: int) -> None:
    quadrant = np.random.default_rng(3).standard_normal((9, 7))
    if parity < 0:
        quadrant[0] = quadrant[:, 0] = 0.0
    both = np.concatenate([parity * quadrant[:0:-1], quadrant])
    known, found = quadrant_symbol(quadrant, (20, 14), parity), half_plane_symbol(both, (20, 14), parity)
    assert found == pytest.approx(known, abs=1e-12)
    with pytest.raises(ValueError, match="17 rows"):
        half_plane_symbol(both, (16, 14), parity)


def test_both_bodies_share_equal_lengths() -> None:
    one, two = Relaxing.of(TREAD, STEEL, 1.0), Relaxing.of(TREAD, TREAD, 1.0)
    assert one is not None
    assert two is not None
    assert Relaxing.of(STEEL, STEEL, 1.0) is None
    assert len(two.memories) == 3
    for single, double in zip(one.memories, two.memories, strict=True):
        assert double.normal == pytest.approx(2.0 * single.normal)
        assert double.coupling == 0.0


def tables_of(body: Material, other: Material, place: tuple[int, int, float, float]) -> dict[str, np.ndarray]:
    """All influence tables of a coated lower body on another, at offsets ≥ 0."""
    bodies, (rows, columns) = bodies_of(body, other, 1.0), place[:2]
    coupled = (sum(factor * table for factor, table in parts)[rows - 1 :, columns - 1 :]
               for parts in bodies.coupling_tables(*place))
    shear = (table.quadrant for table in bodies.shear_tables(*place))
    normal = bodies.normal_table(*place).quadrant
    return dict(zip(("nn", "xx", "yy", "xy", "x", "y"), (normal, *shear, *coupled), strict=True))


@pytest.mark.parametrize(("thickness", "tolerance"), [
    (1e-3, 4e-3), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((3e-4, 0.01), (8e-3, 4e-3)))])
def test_layers_that_have_relaxed_are_softer_layers(thickness: float, tolerance: float) -> None:
    """At rest memory adds what a layer of the relaxed modulus has more than one of the instantaneous: in all tables, with all
    signs, of the lower and of the upper body. The thinnest layer is as thick as an element."""
    layer = Layer(thickness, 50e6, 0.4, relaxation=((0.4, 1e-3), (0.2, 1e-2)))
    once, after = (replace(STEEL, layers=(replace(layer, youngs_modulus=modulus, relaxation=()),)) for modulus in (50e6, 20e6))
    place, (rows, columns) = (24, 20, 2e-4, 3e-4), (24, 20)
    for swapped in (False, True):
        bodies = (STEEL, replace(STEEL, layers=(layer,)))
        relaxing = Relaxing.of(*(bodies if swapped else bodies[::-1]), 1e-9)
        assert relaxing is not None
        added = {"nn": relaxing.normal_table(*place),
                 **dict(zip(("xx", "yy", "xy"), relaxing.shear_tables(*place), strict=True)),
                 **dict(zip(("x", "y"), relaxing.coupling_tables(*place), strict=True))}
        first, last = (tables_of(body, STEEL, place) for body in (once, after))
        for name, table in added.items():
            sign = -1.0 if swapped and name in ("x", "y") else 1.0
            expected, scale = sign * (last[name] - first[name]), np.abs(last[name] - first[name]).max()
            # An approach absorbs a constant of the normal displacement.
            missed = table[rows - 1 :] - expected
            missed -= missed.mean() if name in ("nn", "xx", "yy") else 0.0
            assert np.abs(missed).max() < tolerance * scale, name
            assert table.shape == (2 * rows - 1, columns)


def test_borders_feel_the_modulus_of_an_element() -> None:
    relaxing = Relaxing.of(STEEL, TREAD, 1.0)
    assert relaxing is not None
    relaxed, instant = relaxing.near_border(1e3, 1e3), relaxing.near_border(1e-9, 1e-9)
    assert instant.contact_modulus == pytest.approx(relaxing.surface_modulus, rel=1e-3)
    assert relaxed.contact_modulus == pytest.approx(relaxing.relaxed_modulus(relaxing.surface_modulus), rel=1e-3)
    assert min(instant.trust, relaxed.trust) > 0.999
    between = relaxing.near_border(1e-3, 1e-3)
    assert relaxed.contact_modulus < between.contact_modulus < instant.contact_modulus
    assert between.trust < 0.97

"""Free-space convolution against direct sums: extra rows, parities, repeatability, periodic symbols."""

from __future__ import annotations

import numpy as np
import pytest

from thermoroll_cli.physics.numerics.convolution import Convolution, multiply, quadrant_symbol

RANDOM = np.random.default_rng(20240521)


def direct_sum(field, kernel, before=0, after=0):
    """Σ kernel(i − i', j − j') field(i', j') on rows −before … nx−1+after, `kernel` a function of integer offsets."""
    nx, ny = field.shape
    out = np.zeros((nx + before + after, ny))
    for i in range(-before, nx + after):
        for j in range(ny):
            out[i + before, j] = sum(kernel(i - k, j - m) * field[k, m] for k in range(nx) for m in range(ny))
    return out


def from_quadrant(quadrant, parity):
    """The kernel that is even or odd in both offsets, as a function."""

    def kernel(i, j):
        value = quadrant[abs(i), abs(j)]
        return value if parity > 0 else np.sign(i) * np.sign(j) * value

    return kernel


def random_quadrant(nx, ny, parity):
    quadrant = RANDOM.normal(size=(nx, ny))
    if parity < 0:
        quadrant[0] = 0.0
        quadrant[:, 0] = 0.0
    return quadrant


def convolve(convolution, field, spectrum):
    hat = convolution.forward(field)
    return convolution.inverse(multiply(hat, spectrum, out=np.empty_like(hat)))


@pytest.mark.parametrize("parity", [1, -1])
@pytest.mark.parametrize(("before", "after"), [(0, 0), (2, 2), (2, 0), (0, 3), (1, 2)])
@pytest.mark.parametrize(("nx", "ny"), [(7, 5), (8, 8), (1, 6), (6, 1), (4, 9)])
def test_convolution_is_the_direct_sum_with_extra_rows(nx, ny, before, after, parity):
    convolution = Convolution(nx, ny, before, after)
    quadrant = random_quadrant(nx + max(before, after), ny, parity)
    field = RANDOM.normal(size=(nx, ny))
    found = convolve(convolution, field, convolution.quadrant_spectrum(quadrant, parity))
    expected = direct_sum(field, from_quadrant(quadrant, parity), before, after)
    assert found.shape == (nx + before + after, ny)
    np.testing.assert_allclose(found, expected, atol=1e-13 * nx * ny)


def test_a_kernel_without_symmetry_is_the_direct_sum():
    nx, ny = 6, 9
    convolution = Convolution(nx, ny)
    table = RANDOM.normal(size=(2 * nx - 1, 2 * ny - 1))
    field = RANDOM.normal(size=(nx, ny))
    hat = convolution.forward(field)
    hat *= convolution.spectrum(table)
    expected = direct_sum(field, lambda i, j: table[i + nx - 1, j + ny - 1])
    np.testing.assert_allclose(convolution.inverse(hat), expected, atol=1e-12)


def test_opposite_ends_do_not_feel_wrapped_images():
    """One loaded corner: the other corner sees the kernel at its own distance only."""
    n = 12
    convolution = Convolution(n, n)
    quadrant = np.zeros((n, n))
    quadrant[n - 1, n - 1] = 1.0
    field = np.zeros((n, n))
    field[0, 0] = 3.0
    expected = np.zeros((n, n))
    expected[-1, -1] = 3.0
    found = convolve(convolution, field, convolution.quadrant_spectrum(quadrant))
    np.testing.assert_allclose(found, expected, atol=1e-13)


@pytest.mark.parametrize("parity", [1, -1])
@pytest.mark.parametrize("padded", [(8, 10), (10, 6), (12, 4), (2, 8), (12, 1)])
def test_periodic_symbol_is_the_transform_of_the_wrapped_kernel(padded, parity):
    px, py = padded
    quadrant = random_quadrant(px // 2 + 1, py // 2 + 1, parity)
    symbol = quadrant_symbol(quadrant, padded, parity).T
    assert symbol.shape == (px, py // 2 + 1)
    value = from_quadrant(quadrant, parity)

    def wrapped(i, period):
        """The nearest image of offset i; None where two images are equally near."""
        i %= period
        return i if 2 * i < period else i - period

    full = np.array([[value(wrapped(i, px), wrapped(j, py)) for j in range(py)] for i in range(px)])
    if parity < 0:  # an odd kernel vanishes where its two images meet
        full[px // 2] = 0.0
        full[:, py // 2] = 0.0
    expected = np.fft.rfft2(full)
    np.testing.assert_allclose(expected.imag, 0.0, atol=1e-12)
    np.testing.assert_allclose(symbol, expected.real, atol=1e-12)


@pytest.mark.parametrize(("along", "across"), [(1, -1), (-1, 1)])
@pytest.mark.parametrize("padded", [(2, 2), (4, 2), (16, 24), (78, 30)])
def test_symbol_of_a_kernel_that_is_odd_in_one_offset(padded, along, across):
    hx, hy = padded[0] // 2, padded[1] // 2
    quadrant = RANDOM.normal(size=(hx + 1, hy + 1))
    if along < 0:
        quadrant[[0, -1]] = 0.0
    if across < 0:
        quadrant[:, [0, -1]] = 0.0
    both_x = np.concatenate([quadrant, along * quadrant[-2:0:-1]])
    full = np.concatenate([both_x, across * both_x[:, -2:0:-1]], axis=1)
    expected = np.fft.rfft2(full)
    np.testing.assert_allclose(expected.real, 0.0, atol=1e-12)
    np.testing.assert_allclose(quadrant_symbol(quadrant, padded, (along, across)).T, -expected.imag, atol=1e-12)

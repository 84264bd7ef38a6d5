"""Moving rectangles against reference quadratures, closed forms and superposition."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from thermoroll_cli.exact.moving_sources import point_source_temperature, rectangle_maximum, rectangle_temperature

REFERENCE = Path(__file__).parents[1] / "reference"
SQUARES = json.loads((REFERENCE / "moving_sources.json").read_text())["square"]
KERNEL = json.loads((REFERENCE / "thermal_kernel.json").read_text())["entries"]


@pytest.mark.parametrize("peclet", sorted(SQUARES, key=float))
def test_square_centre_line(peclet):
    entry = SQUARES[peclet]
    found = rectangle_temperature(entry["x"], 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, float(peclet))
    np.testing.assert_allclose(found, entry["T"], atol=1e-15)
    np.testing.assert_allclose(found, entry["T_edge_check"], atol=1e-15)
    peak = rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, float(peclet))
    assert peak.temperature == pytest.approx(entry["Tmax"], rel=1e-14)
    assert peak.x == pytest.approx(entry["xmax"], abs=1e-7)


def test_element_at_all_offsets_of_the_thermal_kernel():
    for entry in KERNEL:
        x, y = entry["offset"]
        found = float(rectangle_temperature(x, y, 0.5, 0.5, 1.0, 1.0, 1.0, entry["P"]))
        assert found == pytest.approx(entry["T"], rel=1e-13, abs=1e-20), entry


@pytest.mark.parametrize(("peclet", "expected"), [(1.0, 0.91143), (10.0, 0.47269), (100.0, 0.15856)])
def test_published_maxima_of_the_square(peclet, expected):
    assert rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, peclet).temperature == pytest.approx(expected, abs=6e-6)


def test_peclet_of_the_article_in_both_conventions():
    """Its Pe = 18.8 as V l/κ and as V l/(2κ)."""
    assert rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, 18.8).temperature == pytest.approx(0.35735, abs=6e-6)
    assert rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, 37.6).temperature == pytest.approx(0.25650, abs=6e-6)


def test_source_at_rest_is_a_closed_form():
    """kT/q = Σ [x asinh(y/|x|) + y asinh(x/|y|)]/2π over the corners; largest in the middle."""
    length, width = 2.0, 0.3

    def corner(x, y):
        return (x * np.arcsinh(y / abs(x)) + y * np.arcsinh(x / abs(y))) / (2 * math.pi)

    for x, y in [(0.1, 0.05), (3.0, 0.1), (-0.7, 5.0)]:
        expected = (
            corner(x + length, y + width)
            - corner(x - length, y + width)
            - corner(x + length, y - width)
            + corner(x - length, y - width)
        )
        assert rectangle_temperature(x, y, length, width, 3.0, 2.0, 1.0, 0.0) == pytest.approx(1.5 * expected, rel=1e-12)
    square = rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
    assert square.temperature == pytest.approx(4 / math.pi * math.log(1 + math.sqrt(2)), rel=1e-14)
    assert square.x == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("peclet", [0.0, 0.3, 40.0, 5000.0])
def test_halves_add_up_to_the_whole(peclet):
    x, y = np.array([-1.2, -0.5, 0.0, 0.4, 0.97, 2.5]), np.array([0.0, 0.3, -0.69, 0.71, 0.2, 1.5])
    whole = rectangle_temperature(x, y, 1.0, 0.7, 1.0, 1.0, 1.0, peclet)
    front = rectangle_temperature(x + 0.5, y, 0.5, 0.7, 1.0, 1.0, 1.0, peclet)
    back = rectangle_temperature(x - 0.5, y, 0.5, 0.7, 1.0, 1.0, 1.0, peclet)
    np.testing.assert_allclose(front + back, whole, atol=1e-14 * whole.max())


@pytest.mark.parametrize("peclet", [0.0, 2.0])
def test_far_rectangle_is_a_point_source(peclet):
    x, y = np.array([-3.0, 30.0, 400.0, 10.0]), np.array([100.0, 1.0, 2.0, -50.0])
    box = rectangle_temperature(x, y, 0.01, 0.01, 5.0, 3.0, 2.0, peclet)
    point = point_source_temperature(x, y, 0.0, 5.0 * 0.02**2, 3.0, 2.0, peclet)
    # the box smears the exponential by (v l)²: 1e-5
    np.testing.assert_allclose(box, point, rtol=1e-5)


def test_point_source_keeps_its_digits_in_the_plume():
    """At y ≪ x the exponent −v y²/(4x) is a difference of nearly equal numbers."""
    found = point_source_temperature(1.0, 1e-9, 0.0, 1.0, 1.0, 1.0, 1e18)
    assert found == pytest.approx(math.exp(-0.25) / (2 * math.pi), rel=1e-9)
    assert point_source_temperature(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0) == math.inf


def test_units_and_shapes():
    metres = rectangle_temperature(np.zeros((3, 1)), np.ones(4) * 1e-3, 2e-3, 1e-3, 1e6, 50.0, 1e-5, 0.1)
    millimetres = rectangle_temperature(0.0, 1.0, 2.0, 1.0, 1.0, 0.05, 10.0, 100.0)
    assert metres.shape == (3, 4)
    assert millimetres.shape == ()
    np.testing.assert_allclose(metres, float(millimetres), rtol=1e-13)


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="speed"):
        rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, -1.0)
    with pytest.raises(ValueError, match="diffusivity"):
        point_source_temperature(1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="half_width"):
        rectangle_temperature(0.0, 0.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0)

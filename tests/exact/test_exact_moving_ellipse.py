"""Moving circles and ellipses against reference values, strips of rectangles and means by another route."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from thermoroll_cli.exact.moving_sources import (
    EXPONENTS,
    band_temperature,
    circle_mean_temperature,
    ellipse_maximum,
    ellipse_temperature,
    rectangle_temperature,
)

REFERENCE = Path(__file__).parents[1] / "reference"
CIRCLES = json.loads((REFERENCE / "moving_sources.json").read_text())["circle"]


@pytest.mark.parametrize("peclet", ["0", "1", "10", "100"])
@pytest.mark.parametrize("shape", sorted(CIRCLES))
def test_circle_matches_the_reference(shape, peclet):
    """The reference is in mean flux, the functions in peak flux: q0 = (n + 1) q̄."""
    entry, peak_flux = CIRCLES[shape][peclet], EXPONENTS[shape] + 1.0
    peak = ellipse_maximum(1.0, 1.0, peak_flux, 1.0, 1.0, float(peclet), shape)
    assert peak.temperature == pytest.approx(entry["Tmax"], rel=2e-13)
    assert peak.x == pytest.approx(entry["xmax"], abs=1e-7)
    over_area = circle_mean_temperature(1.0, peak_flux, 1.0, 1.0, float(peclet), shape)
    assert over_area == pytest.approx(entry["Tmean_area"], rel=1e-10)
    over_flux = circle_mean_temperature(1.0, peak_flux, 1.0, 1.0, float(peclet), shape, weight=shape)
    assert over_flux == pytest.approx(entry["Tmean_fluxweighted"], rel=1e-10)


@pytest.mark.parametrize(("peclet", "expected"), [(1.0, 0.66146), (10.0, 0.35350), (100.0, 0.12226)])
def test_published_maxima_of_the_hertz_circle(peclet, expected):
    assert ellipse_maximum(1.0, 1.0, 1.0, 1.0, 1.0, peclet, "hertz").temperature == pytest.approx(expected, abs=6e-6)


@pytest.mark.parametrize("point", [(0.2, 0.5), (-0.6, -0.4), (0.5, 0.0)])
@pytest.mark.parametrize("peclet", [0.0, 3.0, 60.0])
def test_ellipse_off_centre_is_a_sum_of_strips(peclet, point):
    a, b, strips = 1.0, 1.6, 400
    y = (np.arange(strips) + 0.5) * 2 * b / strips - b
    total = 0.0
    for centre in y:
        half_length = a * math.sqrt(1 - (centre / b) ** 2)
        total += float(rectangle_temperature(point[0], point[1] - centre, half_length, b / strips, 1.0, 1.0, 1.0, peclet))
    assert ellipse_temperature(*point, a, b, 1.0, 1.0, 1.0, peclet) == pytest.approx(total, rel=1e-3)


def test_hertz_shape_is_a_pile_of_ellipses():
    """sqrt(1 − ρ²) = ∫_ρ^1 s/sqrt(1 − s²) ds: uniform ellipses of size s (here all sizes that contain the point)
    plus the smaller ones, seen from outside, as strips."""
    x, peclet, total = 0.0, 20.0, 0.0
    angle = (np.arange(200) + 0.5) * 0.5 * math.pi / 200
    for s in np.sin(angle):
        total += s * ellipse_temperature(x, 0.0, s, 0.8 * s, 1.0, 1.0, 1.0, peclet) * 0.5 * math.pi / 200
    assert ellipse_temperature(x, 0.0, 1.0, 0.8, 1.0, 1.0, 1.0, peclet, "hertz") == pytest.approx(total, rel=1e-4)


@pytest.mark.parametrize("shape", ["uniform", "hertz"])
def test_fast_ellipses_become_bands(shape):
    """First order in 1/P at fixed position; every line y = const is a band of its own chord."""
    y, b = 0.6, 1.5
    chord = math.sqrt(1 - (y / b) ** 2)
    peak_flux = chord if shape == "hertz" else 1.0
    errors = []
    for peclet in (1e2, 1e3, 1e4):
        exact = ellipse_temperature(0.3, y, 1.0, b, 1.0, 1.0, 1.0, peclet, shape)
        band = float(band_temperature(0.3, chord, peak_flux, 1.0, 1.0, peclet, shape))
        errors.append(abs(exact / band - 1))
    assert errors[-1] < 2e-4
    assert np.polyfit(np.log([1e2, 1e3, 1e4]), np.log(errors), 1)[0] == pytest.approx(-1.0, abs=0.1)


def test_symmetry_and_bad_input():
    up = ellipse_temperature(0.3, 0.4, 1.0, 0.7, 1.0, 1.0, 1.0, 7.0, "hertz")
    assert ellipse_temperature(0.3, -0.4, 1.0, 0.7, 1.0, 1.0, 1.0, 7.0, "hertz") == pytest.approx(up, rel=1e-13)
    with pytest.raises(ValueError, match="not inside"):
        ellipse_temperature(1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="shape"):
        ellipse_maximum(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, "gauss")
    with pytest.raises(ValueError, match="radius"):
        circle_mean_temperature(0.0, 1.0, 1.0, 1.0, 1.0)

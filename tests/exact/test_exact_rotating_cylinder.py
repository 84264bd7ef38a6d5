"""A cylinder that turns under a heat source: its series against limits, and one pass plus what the track brings back."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import kve

from thermoroll_cli.exact.moving_sources import band_temperature, rim_temperature
from thermoroll_cli.heat.recirculation import pass_sum, surface_slope

HALF, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY = 0.5e-3, 1e6, 0.03, 45.0, 1.2e-5
"""Band source of a traction drive, on a roller of 30 mm."""


def one_pass(x, speed, wavenumber):
    """Half-space under q₀ √(1 − x²/l²) cos λy: line sources of strength q cos λy on moving material."""
    drift = speed / (2.0 * DIFFUSIVITY)
    decay = math.hypot(drift, wavenumber)

    def source(root, side):
        # Roots of the distance from x: the response falls like one over them.
        distance = side * root**2
        flux = FLUX * math.sqrt(max(1.0 - ((x - distance) / HALF) ** 2, 0.0))
        return 2.0 * root * flux * math.exp(drift * distance - decay * root**2) * kve(0, decay * root**2)

    behind = quad(source, 0.0, math.sqrt(HALF + x), args=(1.0,), limit=200)[0]
    ahead = quad(source, 0.0, min(math.sqrt(HALF - x), 6.0 / math.sqrt(drift)), args=(-1.0,), limit=200)[0]
    return (behind + ahead) / (math.pi * CONDUCTIVITY)


@pytest.mark.parametrize(
    ("wavenumber", "speed", "convection"), [(0.0, 30.0, 3000.0), (1500.0, 30.0, 3000.0), (400.0, 8.0, 30.0)]
)
def test_one_pass_and_the_track_make_the_whole(wavenumber, speed, convection):
    """What earlier turns leave is the same all along the contact to 1e-3 of the peak, and on average to 1e-4."""
    x = np.linspace(-0.95, 0.95, 5) * HALF
    series = rim_temperature(x, HALF, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY, speed, convection, wavenumber)
    period = 2.0 * math.pi * RADIUS / speed
    mean_flux = 0.5 * math.pi * HALF * FLUX / speed / period
    returning = mean_flux * (
        1.0 / (CONDUCTIVITY * wavenumber * float(surface_slope(wavenumber * RADIUS)) + convection)
        + math.sqrt(period * DIFFUSIVITY / math.pi) / CONDUCTIVITY * float(pass_sum(DIFFUSIVITY * wavenumber**2 * period))
    )
    found = np.array([one_pass(float(at), speed, wavenumber) for at in x]) + returning
    assert returning > 0.05 * series.max()
    assert np.abs(found - series).max() < 1e-3 * series.max()
    assert abs(np.mean(found - series)) < 1e-4 * series.max()


def test_far_from_the_source_only_the_mean_is_left():
    """With strong cooling hardly anything comes back, and the band is a fast one."""
    x = np.linspace(-0.9, 0.9, 7) * HALF
    series = rim_temperature(x, HALF, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY, 300.0, 1e7)
    without = rim_temperature(x, HALF, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY, 300.0, 1e2)
    fast = band_temperature(x, HALF, FLUX, CONDUCTIVITY, DIFFUSIVITY, 300.0, "hertz")
    assert np.all(series < fast)
    assert np.all(without - series > 10 * fast.max())


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="convection"):
        rim_temperature(0.0, HALF, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY, 1.0, 0.0)
    with pytest.raises(ValueError, match="half of the rim"):
        rim_temperature(0.0, 1.0, FLUX, RADIUS, CONDUCTIVITY, DIFFUSIVITY, 1.0, 1.0)

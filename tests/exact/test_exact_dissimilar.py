"""Different materials: Spence's indentation and Bentall & Johnson's free rolling."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from thermoroll_cli.exact import rolling_cylinders as bj
from thermoroll_cli.exact import spence
from thermoroll_cli.exact.hertz import line_contact

REFERENCE = Path(__file__).parents[1] / "reference"


def test_spence_published_case():
    found = spence.spence_contact(0.5, 0.5)
    assert found.friction == pytest.approx(spence.PUBLISHED_FRICTION, rel=1e-3)
    assert found.centre_pressure == pytest.approx(spence.PUBLISHED_CENTRE_PRESSURE, abs=0.005)


@pytest.mark.parametrize("stick_ratio", [0.2, 0.5, 0.8])
def test_spence_weak_coupling_is_the_closed_form(stick_ratio):
    found = spence.spence_contact(stick_ratio, 0.001)
    assert found.friction == pytest.approx(spence.uncoupled_friction(stick_ratio, 0.001), rel=1e-3)
    assert found.centre_pressure == pytest.approx(1.0, abs=1e-4)
    assert found.load == pytest.approx(1.0, abs=1e-4)


def test_spence_friction_grows_with_the_stick_circle():
    frictions = [spence.spence_contact(ratio, 0.3).friction for ratio in (0.3, 0.6, 0.9)]
    assert frictions == sorted(frictions)
    with pytest.raises(ValueError, match="stick_ratio"):
        spence.spence_contact(0.95, 0.3)
    with pytest.raises(ValueError, match="dundurs_beta"):
        spence.uncoupled_friction(0.5, 0.0)


def test_bentall_johnson_published_constants():
    assert bj.material_mismatch(23e9, 0.31, 82e9, 0.28) == pytest.approx(0.2877, abs=5e-5)
    assert pytest.approx(0.457, abs=5e-4) == bj.FREE_ROLLING_COEFFICIENT


def test_free_rolling_has_no_net_force():
    """Slip with ∂u/∂x = K p (ν, G of both bodies, Hertz pressure); traction μp along the slip."""
    constants = (23e9, 0.31, 82e9, 0.28)
    modulus = 2 / ((1 - constants[1]) / constants[0] + (1 - constants[3]) / constants[2])
    contact = line_contact(40.0, modulus, 1e5)
    stretch = 0.5 * ((1 - 2 * constants[1]) / constants[0] - (1 - 2 * constants[3]) / constants[2])
    mismatch = bj.material_mismatch(*constants)
    creepage = bj.free_rolling_creepage(mismatch, contact.half_width, contact.curvature)
    angle = (np.arange(200000) + 0.5) * math.pi / 200000
    x = contact.half_width * np.cos(angle)
    slip = bj.low_friction_slip(x, creepage, mismatch, contact.half_width, contact.curvature)
    np.testing.assert_allclose(slip, creepage - stretch * contact.pressure(x), atol=1e-12 * creepage)
    force = np.mean(np.sign(slip) * contact.pressure(x) * np.sin(angle)) * math.pi * contact.half_width
    assert abs(force) < 1e-4 * contact.load_per_length
    assert np.all(slip[np.abs(x) < 0.403 * contact.half_width] < 0)
    assert np.all(slip[np.abs(x) > 0.405 * contact.half_width] > 0)


def test_sign_is_that_of_the_contact_program():
    """Lower body soft, no creepage: the lower body's surface slips back, so F_x < 0."""
    case = json.loads((REFERENCE / "contact_dissimilar.json").read_text())["cases"]["free_rolling"]
    lower, upper = case["input"]["lower"], case["input"]["upper"]
    shear = [body["youngs_modulus_GPa"] / (2 * (1 + body["poisson_ratio"])) for body in (lower, upper)]
    mismatch = bj.material_mismatch(shear[0], lower["poisson_ratio"], shear[1], upper["poisson_ratio"])
    assert mismatch > 0
    assert bj.low_friction_slip(0.0, 0.0, mismatch, 1e-3, 40.0) < 0
    assert case["extrapolated"]["force_x_N"] < 0

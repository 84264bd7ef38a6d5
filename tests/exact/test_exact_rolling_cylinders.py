"""Carter's and Hunter's rolling cylinders, different materials that roll freely, and Spence's indentation with friction."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from tests.support.sampling import sampled
from tests.support.scenes import reference
from thermoroll_cli.exact import rolling_cylinders as bj
from thermoroll_cli.exact import spence
from thermoroll_cli.exact.hertz import line_contact
from thermoroll_cli.exact.hunter import hunter
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage

CONTACT = line_contact(curvature=40.0, contact_modulus=1.1e11, load_per_length=3e5)
MU = 0.3
SATURATION = saturation_creepage(CONTACT, MU)
A = CONTACT.half_width


def slope(solution, x):
    """∂u/∂x = −2/(πE*) PV∫ τ(x')/(x − x') dx' by adaptive Cauchy quadrature."""
    pieces = sorted({-A, *(end for end in solution.stick_zone if abs(end) < A), A})
    total = 0.0
    for low, high in pairwise(pieces):
        if low < x < high:
            # quad's Cauchy weight is 1/(x' − x)
            total -= quad(solution.traction, low, high, weight="cauchy", wvar=x, limit=200, epsrel=1e-9)[0]
        else:
            total += quad(lambda s: float(solution.traction(s)) / (x - s), low, high, limit=200, epsrel=1e-9)[0]
    return -2 / (math.pi * CONTACT.contact_modulus) * total


@pytest.mark.parametrize("share", [0.2, -0.6, 0.95, 1.0, 1.7])
def test_slip_matches_the_half_plane_integral(share):
    solution = carter(CONTACT, MU, share * SATURATION)
    for u in (-0.8, -0.35, 0.1, 0.55, 0.93):
        expected = solution.creepage - slope(solution, u * A)
        assert solution.slip(u * A) == pytest.approx(expected, abs=2e-6 * SATURATION)


@pytest.mark.parametrize("share", [0.2, -0.6, 1.0, 1.7])
def test_force_heat_and_coulomb(share):
    solution = carter(CONTACT, MU, share * SATURATION)
    angle = (np.arange(20000) + 0.5) * math.pi / 20000
    x, weight = A * np.cos(angle), A * np.sin(angle) * math.pi / 20000
    traction, slip = solution.traction(x), solution.slip(x)
    assert weight @ traction == pytest.approx(solution.force, rel=1e-6)
    assert weight @ solution.heat_flux(x, 12.0) == pytest.approx(solution.heat(12.0), rel=1e-5)
    limit = MU * CONTACT.pressure(x)
    assert np.all(np.abs(traction) <= limit * (1 + 1e-8))
    assert np.all(traction * slip >= 0)
    slipping = x > solution.stick_zone[1]
    np.testing.assert_allclose(np.abs(traction[slipping]), limit[slipping], rtol=1e-8)
    assert np.all(slip[~slipping] == 0)


def test_stick_zone_is_at_the_leading_edge():
    """Material comes from −x: it sticks first, and the traction grows along the stick zone."""
    solution = carter(CONTACT, MU, 0.4 * SATURATION)
    assert solution.stick_zone == pytest.approx((-A, 0.2 * A), rel=1e-12)
    assert np.all(np.diff(solution.traction(np.linspace(-A, 0.0, 50))) > 0)
    assert solution.slip(0.9 * A) > 0


def test_small_creepage_is_linear():
    """F = 2 N R ξ/a for ξ → 0."""
    solution = carter(CONTACT, MU, 1e-6 * SATURATION)
    expected = 2 * CONTACT.load_per_length * solution.creepage / (A * CONTACT.curvature)
    assert solution.force == pytest.approx(expected, rel=1e-6)


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
    case = reference("contact_dissimilar")["cases"]["free_rolling"]
    lower, upper = case["input"]["lower"], case["input"]["upper"]
    shear = [body["youngs_modulus_GPa"] / (2 * (1 + body["poisson_ratio"])) for body in (lower, upper)]
    mismatch = bj.material_mismatch(shear[0], lower["poisson_ratio"], shear[1], upper["poisson_ratio"])
    assert mismatch > 0
    assert bj.low_friction_slip(0.0, 0.0, mismatch, 1e-3, 40.0) < 0
    assert case["extrapolated"]["force_x_N"] < 0


# --- Hunter: a half-plane that relaxes, against independent values, equilibrium, and its limits -----------------------------


@pytest.mark.parametrize("row", sampled(reference("relaxing_hunter")["rows"], 3),
                         ids=lambda row: f"{row['relaxed_over_glassy']}-{row['length_over_a0']}")
def test_values_of_an_independent_solution(row: dict[str, float]) -> None:
    contact = hunter(row["relaxed_over_glassy"], row["length_over_a0"])
    assert contact.half_width == pytest.approx(row["half_width_over_a0"], rel=1e-9)
    assert contact.centre == pytest.approx(row["centre_over_a0"], rel=1e-9)
    # The reference integrates its pressure numerically.
    assert contact.moment == pytest.approx(row["moment_over_wa0"], rel=6e-3)
    assert contact.pressure(np.linspace(-1.0, 1.0, 2001)).max() == pytest.approx(row["pressure_max_over_elastic"], rel=8e-3)


@pytest.mark.parametrize(("ratio", "length"), [
    (10.0, 1.0), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((1.2, 0.3), (3.0, 0.1), (30.0, 5.0)))])
def test_the_pressure_carries_load_and_moment(ratio: float, length: float) -> None:
    contact = hunter(ratio, length)
    t, weights = np.polynomial.legendre.leggauss(1000)
    per_length = 2.0 / math.pi * contact.half_width * contact.pressure(t) * weights
    assert per_length.sum() == pytest.approx(1.0, rel=1e-7)
    assert (per_length * (contact.centre + contact.half_width * t)).sum() == pytest.approx(contact.moment, rel=1e-7)
    assert contact.pressure(np.array([-1.0, 1.0])) == pytest.approx(0.0, abs=1e-9)


def test_fast_and_slow_rolling_are_elastic() -> None:
    slow, fast = hunter(4.0, 1e-4), hunter(4.0, 1e4)
    assert (slow.half_width, slow.centre) == pytest.approx((1.0, 0.0), abs=2e-4)
    assert (fast.half_width, fast.centre) == pytest.approx((0.5, 0.0), abs=1e-3)


def test_the_compliance_must_grow() -> None:
    with pytest.raises(ValueError, match="ratio_above_one"):
        hunter(1.0, 1.0)

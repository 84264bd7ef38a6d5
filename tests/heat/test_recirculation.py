"""What a body brings back: kernel functions, modes, energy, and wheel on rail and traction drive solved by others."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg
from scipy.interpolate import CubicSpline
from scipy.special import erfc, iv, ivp, kv, kvp

from tests.support.scenes import reference
from thermoroll_cli.physics.heat import recirculation
from thermoroll_cli.physics.heat.frictional_heat import match
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.heat.recirculation import (
    RecirculatingResponse,
    Track,
    TurningBody,
    bulge_sum,
    cylinder_factor,
    entry_temperatures,
    pass_sum,
    robin_roots,
    surface_slope,
)
from thermoroll_cli.physics.numerics.grid import Grid, peak_value

DRIVE = TurningBody(0.03, 0.02, 1, 30.0, 45.0, 1.2e-5, 1.56e-5, 0.3, convection=3000.0)


# --- functions of one wavenumber ---------------------------------------------------------------------------------


@pytest.mark.parametrize("epsilon", [0.004, 0.2, 0.999, 1.001, 7.0, 36.0])
def test_sums_over_passes(epsilon):
    n = np.arange(1, int(60 / epsilon) + 2)
    assert float(pass_sum(epsilon)) == pytest.approx(
        np.sum(np.exp(-n * epsilon) / np.sqrt(n)) - math.sqrt(math.pi / epsilon), abs=1e-12)
    assert float(bulge_sum(epsilon)) == pytest.approx(erfc(np.sqrt(n * epsilon)).sum() - 0.5 / epsilon, abs=1e-12)


def test_limits_of_the_kernel_functions():
    assert float(pass_sum(0.0)) == pytest.approx(-1.4603545088095868, rel=1e-14)
    assert float(bulge_sum(0.0)) == -0.5
    published = {5.0: 1.147, 10.0: 1.085, 20.0: 1.044, 50.0: 1.018}
    assert cylinder_factor(np.array(list(published)), 0.3) == pytest.approx(np.array(list(published.values())), abs=5e-4)
    # A long wave expands the cylinder freely, αRT; a short one sees a half-space.
    assert float(cylinder_factor(1e-3, 0.3)) == pytest.approx(1e-3 / 1.3, rel=1e-4)
    assert cylinder_factor(np.array([999.0, 1001.0]), 0.3) == pytest.approx(1.0 + 0.9 / 1000.0, rel=1e-5)
    assert cylinder_factor(np.array([999.0, 1001.0]), 0.3, bore=True) == pytest.approx(1.0 - 0.9 / 1000.0, rel=1e-5)


def expansion_of_a_wave(radius: float, poisson: float, *, bore: bool) -> float:
    """Radial displacement of a traction-free rim over (1 + ν)αT, λ = 1, by finite elements along r: u(r) cos λy, w(r) sin λy in
    a solid cylinder with T = I₀(r), or around a bore with T = K₀(r)."""
    r = radius + np.linspace(0.0, 18.0, 1201) if bore else np.linspace(0.0, radius, 1201)
    lame, heated = 2.0 * poisson / (1.0 - 2.0 * poisson), kv if bore else iv  # G = 1
    normal = np.diag([2.0, 2.0, 2.0, 1.0]) + lame * np.outer([1, 1, 1, 0], [1, 1, 1, 0])
    h, m = np.diff(r), 0.5 * (r[1:] + r[:-1])
    half, none = np.full(h.size, 0.5), np.zeros(h.size)
    # Radial, hoop and axial strain and shear from u, w at both nodes, in the middle of each element.
    strain = np.array([[-1 / h, none, 1 / h, none], [half / m, none, half / m, none], [none, half, none, half],
                       [-half, -1 / h, -half, 1 / h]])
    at = 2 * np.arange(h.size) + np.arange(4)[:, None]
    rows, columns = np.broadcast_arrays(at[:, None], at)
    stiffness = np.einsum("kin,kl,ljn->ijn", strain, normal, strain) * h * m
    matrix = scipy.sparse.coo_matrix((stiffness.ravel(), (rows.ravel(), columns.ravel())))
    load = np.bincount(at.ravel(), (h * m * (3 * lame + 2) * heated(0, m) / heated(0, radius) * strain[:3].sum(axis=0)).ravel())
    found = scipy.sparse.linalg.spsolve(matrix.tocsr(), load)
    return float(-found[0] if bore else found[-2]) / (1 + poisson)


@pytest.mark.parametrize("radius", [0.5, 3.0, 12.0])
@pytest.mark.parametrize("bore", [False, True])
def test_rims_of_cylinders_and_bores_against_finite_elements(radius, bore):
    assert cylinder_factor(radius, 0.28, bore=bore) == pytest.approx(expansion_of_a_wave(radius, 0.28, bore=bore), rel=1e-3)
    assert surface_slope(radius, bore=bore) == pytest.approx(
        -kvp(0, radius) / kv(0, radius) if bore else ivp(0, radius) / iv(0, radius), rel=1e-12)


@pytest.mark.parametrize("biot", [1e-8, 1e-3, 1.0, 1e5])
def test_robin_roots(biot):
    z = robin_roots(np.arange(9.0), biot)
    even, odd = z[0::2], z[1::2]
    assert even * np.sin(even) == pytest.approx(biot * np.cos(even), abs=1e-10 * max(1.0, biot))
    assert -odd * np.cos(odd) == pytest.approx(biot * np.sin(odd), abs=1e-10 * max(1.0, biot))
    assert np.all(np.diff(z) > 1.0) and z[0] < math.pi / 2


# --- energy ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convection", [3.0, 3000.0, 3e6])
def test_what_goes_in_goes_out_by_convection(convection):
    """Heat spread like each mode over the rim, and the steady temperature I₀(λr) φ(y) it makes: rim and ends give off as much,
    and their mean temperature is the heat times 1/(hA)."""
    roller = replace(DRIVE, convection=convection)
    wave, share, _ = roller.modes(2e4, 1e-3)
    y, weight = np.polynomial.legendre.leggauss(200)
    y, weight = 0.5 * roller.width * y, 0.5 * roller.width * weight
    for number in (0, 2, 8):
        lam = float(wave[number])
        shape = np.cos(lam * y)
        assert weight @ shape**2 == pytest.approx(1.0 / share[number], rel=1e-10)
        rho = float(surface_slope(lam * roller.radius))
        temperature = 1.0 / (roller.conductivity * lam * rho + convection)
        going_in = 2 * math.pi * roller.radius * float(weight @ shape)
        rim = convection * temperature * going_in
        ends = 2 * convection * temperature * math.cos(lam * roller.width / 2) * 2 * math.pi * roller.radius * rho / lam
        assert rim + ends == pytest.approx(going_in, rel=1e-10)


def test_bulk_temperature_is_the_heat_times_the_resistance():
    grid = Grid.over((12, 16), 1e-3, 1e-3)
    flux = np.random.default_rng(3).uniform(0.0, 1e8, grid.shape)
    heat = flux.sum() * grid.element_area
    for passes in (1, 9):
        cooled = Track(replace(DRIVE, passes=passes), grid)
        area = 2 * math.pi * DRIVE.radius * (DRIVE.width + DRIVE.radius)
        assert cooled.bulk_temperature(flux) * DRIVE.convection * area == pytest.approx(passes * heat, rel=1e-12)
        resisting = Track(replace(DRIVE, passes=passes, convection=None, resistance=2.0), grid)
        assert resisting.bulk_temperature(flux) == pytest.approx(2.0 * passes * heat, rel=1e-12)


@pytest.mark.parametrize("loss", [{"convection": 30.0}, {"convection": None, "resistance": 0.5}])
def test_further_modes_of_wide_bodies_are_counted_together(loss, monkeypatch):
    """As their sum one by one, and in no more memory for a body of any width."""
    grid = Grid.over((4, 24), 1e-3, 2e-3, centre=0.4e-3)
    together = Track(replace(DRIVE, width=12.0, **loss), grid)
    widest = Track(replace(DRIVE, width=1e6, **loss), grid)
    assert widest.body.modes(1e5, 2e-3)[0].size < 4 * recirculation.EACH_MODE
    monkeypatch.setattr(recirculation, "EACH_MODE", 10**7)
    assert together.body.modes(1e5, 2e-3)[0].size > 3e5
    alone = Track(together.body, grid)
    np.testing.assert_allclose(together.temperature, alone.temperature, atol=2e-6 * alone.temperature.max())
    crown = alone.bulge - alone.bulge.mean()
    np.testing.assert_allclose(together.bulge - together.bulge.mean(), crown, atol=3e-6 * np.ptp(crown))
    if "resistance" not in loss:
        np.testing.assert_allclose(widest.temperature, alone.temperature, rtol=5e-6)


def test_a_resistance_moves_the_mean_alone():
    """One kelvin per watt more is one kelvin per watt more everywhere, and no other bulge."""
    grid = Grid.over((8, 16), 1e-3, 1e-3)
    low, high = (Track(replace(DRIVE, convection=None, resistance=r), grid) for r in (1.0, 3.0))
    flux = np.full(grid.shape, 1e8)
    heat = flux.sum() * grid.element_area
    assert high.entry_temperature(flux) - low.entry_temperature(flux) == pytest.approx(np.full(16, 2.0 * heat), rel=1e-9)
    assert high.entry_bulge(flux) == pytest.approx(low.entry_bulge(flux))


# --- limits ------------------------------------------------------------------------------------------------------


def test_cooled_without_limit_the_track_returns_cold_but_for_the_passes():
    grid = Grid.over((8, 16), 1e-3, 1e-3)
    flux = np.full(grid.shape, 1e8)
    kept = [float(Track(replace(DRIVE, convection=h), grid).entry_temperature(flux).max()) for h in (3e3, 3e5, 1e12)]
    assert kept[0] > kept[1] > kept[2]
    assert kept[2] < 0.0  # the rim at 0 K all the time: even the mean in time, which the passes are counted against, is gone


def test_faster_passes_of_the_same_heat_leave_the_mean():
    """V → ∞ at the same heat: P → 0, and only the mean in time is left, whatever the speed."""
    grid = Grid.over((8, 16), 1e-3, 1e-3)
    flux = np.full(grid.shape, 1e8)
    at = {v: Track(replace(DRIVE, speed=v), grid).entry_temperature(flux)[8] for v in (3e3, 3e5, 3e7)}
    gap = [at[3e5] - at[3e3], at[3e7] - at[3e5]]
    assert 0.0 < gap[1] < 0.15 * gap[0]


# --- solved by others --------------------------------------------------------------------------------------------


def bodies(case):
    given = reference("recirculation")[case]["inputs"]
    for name, sign in (("lower", 1), ("upper", -1)):
        b, speed = given[name], given["V"] * (1 + sign * given["xi"] / 2)
        free = (1 + b["nu"]) * b["alpha"]
        roller = None
        if b["Rx"] != "inf":
            roller = TurningBody(b["Rx"], b["B"], 1, speed, b["k"], b["kappa"], free, b["nu"], convection=b["h"])
        yield HeatedBody(b["k"], free, b["kappa"], speed), roller


def semi_ellipsoid(case, n):
    """The prescribed flux as element averages, and the elements whose centres lie inside."""
    hertz = reference("recirculation")[case]["hertz"]
    a, b, heat = hertz["a"], hertz["b"], hertz["Q"]
    grid = Grid.over((n, n), 2.2 * a, 2.2 * b)
    fine = (np.arange(12) + 0.5) / 12 - 0.5
    x, y = ((c[:, None] + fine * d).ravel() for c, d in ((grid.x, grid.dx), (grid.y, grid.dy)))
    flux = np.sqrt(np.maximum(1 - (x[:, None] / a) ** 2 - (y / b) ** 2, 0)).reshape(n, 12, n, 12).mean(axis=(1, 3))
    flux *= heat / flux.sum() / grid.element_area
    return grid, flux, (grid.x[:, None] / a) ** 2 + (grid.y / b) ** 2 < 1


def response_of(case, grid):
    (lower, below), (upper, above) = bodies(case)
    tracks = tuple(None if r is None else Track(r, grid) for r in (below, above))
    return RecirculatingResponse(HeatResponse(grid, lower, upper), tracks)


def close(value, expected, uncertain):
    """Within three times the stated uncertainty, which is relative to the largest of `expected`."""
    return value == pytest.approx(expected, rel=0.0, abs=3.0 * uncertain * np.abs(expected).max())


def across(case, known, grid, field):
    """A field over y (ny,) at the places of `known`."""
    return CubicSpline(grid.y, field)(np.array(known["y_over_b"]) * reference("recirculation")[case]["hertz"]["b"])


@pytest.mark.parametrize("case", ["wheel_rail", "traction_drive"])
def test_given_heat_divided_evenly(case):
    """Temperatures and bulge of half the heat within three times the uncertainty stated."""
    grid, flux, _ = semi_ellipsoid(case, 129)
    response, half = response_of(case, grid), 0.5 * flux
    temperatures = response.temperatures(DividedHeat(flux, 0.5))
    for i, name in enumerate(("lower", "upper")):
        known, track = reference("recirculation")[case]["half"][name], response.tracks[i]
        uncertain = known["rel_uncertainty"]
        assert close(peak_value(temperatures[i]), known["T_max"], uncertain["T_max"])
        if track is None:
            continue
        assert close(across(case, known, grid, track.entry_temperature(half)), known["T_entry"], uncertain["T_entry"])
        bulge = across(case, known, grid, track.entry_bulge(half))
        assert close(bulge - bulge[0], known["bulge_m"], uncertain["bulge"])
        assert track.bulk_temperature(half) == pytest.approx(known["bulk"], rel=1e-12)


@pytest.mark.parametrize("case", ["wheel_rail", "traction_drive"])
def test_heat_that_divides_itself(case):
    """Shares, bulk, entry and surface temperatures and bulge within three times the uncertainty stated, in few applications."""
    grid, flux, inside = semi_ellipsoid(case, 193)
    response = response_of(case, grid)
    found = match(response, flux, inside)
    assert found.mismatch <= 1e-5 and found.applications <= 8
    temperatures, entries = response.temperatures(found.into), entry_temperatures(response.tracks, found.into)
    for i, (name, into) in enumerate((("lower", found.into.lower), ("upper", found.into.upper))):
        known, track = reference("recirculation")[case]["matched"][name], response.tracks[i]
        uncertain = known["rel_uncertainty"]
        assert close(into.sum() / flux.sum(), known["share"], uncertain["share"])
        assert close(peak_value(temperatures[i]), known["T_max"], uncertain["T_max"])
        assert close(across(case, known, grid, entries[i]), known["T_entry"], uncertain["T_entry"])
        if track is not None:
            # As sure as the share that it is a multiple of.
            assert close(track.bulk_temperature(into), known["bulk"], uncertain["share"])
            bulge = across(case, known, grid, track.entry_bulge(into))
            assert close(bulge - bulge[0], known["bulge_m"], uncertain["bulge"])


def test_equal_bodies_cooled_alike_share_evenly():
    grid, flux, inside = semi_ellipsoid("traction_drive", 24)
    body = HeatedBody(45.0, 1.56e-5, 1.2e-5, 30.0)
    alike = RecirculatingResponse(HeatResponse(grid, body, body), (Track(DRIVE, grid), Track(DRIVE, grid)))
    assert alike.matched_share == 0.5
    cooler = Track(replace(DRIVE, convection=6000.0), grid)
    unlike = RecirculatingResponse(HeatResponse(grid, body, body), (Track(DRIVE, grid), cooler))
    assert unlike.matched_share is None
    found = match(unlike, flux, inside)
    assert found.mismatch <= 1e-5 and found.into.lower.sum() < 0.499 * flux.sum()

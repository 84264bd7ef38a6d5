"""Heat that divides itself between the bodies: equal temperatures, exact limits, conduction, cost, and the pipeline."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.cases import parse
from tests.support.command_line import THERMAL
from tests.support.documents import printed
from tests.support.errors import relative
from tests.support.scenes import STEEL, article_4_1, order, rolling, solved
from thermoroll_cli.exact.moving_sources import band_temperature, circle_mean_temperature, effusivity
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.iteration import DIVISION
from thermoroll_cli.physics.heat.frictional_heat import match
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.heat.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.physics.numerics.convolution import counted
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.contact import Contact, Traction
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Material, Motion
from thermoroll_cli.python_api import solve

K, KAPPA, RADIUS = 50.2, 10e-6, 1e-4
MATCHED = Heating(partition="matched")
CERAMIC = Material(300e9, 0.28, 20.0, 3e-6, 8e-6)  # silicon nitride


def body(peclet: float = 0.0, conductivity: float = K, diffusivity: float = KAPPA, sideways: float = 0.0) -> HeatedBody:
    """A body that passes at V a/κ = `peclet` along x, `sideways` along y."""
    return HeatedBody(conductivity, 1e-5, diffusivity, peclet * diffusivity / RADIUS, sideways * diffusivity / RADIUS)


class Disc:
    """A circular contact of radius `RADIUS` on n × n elements, with Hertz-shaped heat of 1 MW/m² at its middle."""

    def __init__(self, n: int, extent: float = 2.2) -> None:
        self.grid = Grid.over((n, n), extent * RADIUS, extent * RADIUS)
        square = (self.grid.x[:, None] ** 2 + self.grid.y[None, :] ** 2) / RADIUS**2
        self.contact = square < 1.0
        self.flux = 1e6 * np.sqrt(np.maximum(1.0 - square, 0.0))
        self.none = np.zeros(self.grid.shape)

    def match(self, lower: HeatedBody, upper: HeatedBody, flux=None, bulk: float = 0.0):
        """The partition, and the mismatch of temperatures inside over their peak, computed independently."""
        response = HeatResponse(self.grid, lower, upper)
        partition = match(response, self.flux if flux is None else flux, self.contact, bulk)
        return partition, self.mismatch(response, partition, bulk)

    def mismatch(self, response, partition, bulk: float = 0.0) -> float:
        below, above = response.temperatures(partition.into)
        difference = np.abs(below - above - bulk)[self.contact].max()
        return float(difference / max(np.abs(below).max(), np.abs(above).max(), abs(bulk)))

    def heat(self, flux) -> float:
        return float(flux.sum()) * self.grid.element_area


# --- the linear problem -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("lower", "upper"), [
    (body(0.0), body(1.0)), (body(0.0), body(300.0, 2.0)), (body(18.0), body(18.1)), (body(18.0), body(-18.0)),
    (body(5.0, 20.0, 8e-6), body(400.0)), (body(3.0, sideways=2.0), body(3.0, sideways=-2.0)),
    (body(2e4), body(1e4, 1.0, 1e-7)),
])
def test_surfaces_are_equally_warm_inside_the_contact(lower, upper):
    """Mismatch ≤ 1e-5 of the peak (1e-3 is asked for), heat conserved to rounding, 3 to 14 applications (30 allowed)."""
    disc = Disc(48)
    partition, mismatch = disc.match(lower, upper)
    assert mismatch < 1e-5 and partition.mismatch < 1e-5
    assert 2 <= partition.applications <= 14
    np.testing.assert_allclose(partition.into.total, disc.flux, atol=1e-12 * disc.flux.max())
    assert disc.heat(partition.into.total) == pytest.approx(disc.heat(disc.flux), rel=1e-13)
    # No heat leaves a body outside the contact, but one surface may warm the other inside it.
    assert not partition.into.lower[~disc.contact].any() and not partition.into.upper[~disc.contact].any()


def test_applications_do_not_grow_with_the_grid():
    """Stationary on fast, friction and conduction: 16 to 128 elements per side."""
    counts = [Disc(n).match(body(0.0), body(300.0), bulk=10.0)[0].applications for n in (16, 32, 64, 128)]
    assert max(counts) <= 14 and counts[-1] <= 1.8 * counts[0]


def test_random_bodies_and_contacts():
    """Any two bodies, any shape of contact and flux with or without friction in places: always within the 30 applications."""
    random = np.random.default_rng(8)
    for _ in range(10):
        nx, ny = random.integers(12, 48, 2)
        grid = Grid(int(nx), int(ny), 1e-5, 1e-5 * 10.0 ** random.uniform(-0.7, 0.7))
        x, y = grid.x[:, None] / grid.x[-1], grid.y[None, :] / grid.y[-1]
        contact = x**2 + random.uniform(0.8, 2.0) * y**2 + 0.3 * np.sin(7 * x) < random.uniform(0.5, 0.95)
        flux = contact * random.random(grid.shape) * (x > random.uniform(-1.0, 0.5))
        bodies = [
            HeatedBody(10.0 ** random.uniform(-1, 2.5), 1e-5, 1e-5, random.choice([-1, 0, 1]) * 10.0 ** random.uniform(-2, 3))
            for _ in range(2)
        ]
        response = HeatResponse(grid, *bodies)
        bulk = float(random.choice([0.0, 1.0])) * 1e-6
        partition = match(response, flux, contact, bulk)
        assert partition.mismatch <= 1e-5 and partition.applications <= 30
        below, above = response.temperatures(partition.into)
        peak = max(np.abs(below).max(), np.abs(above).max(), bulk)
        assert np.abs(below - above - bulk)[contact].max() < 1e-5 * peak


def test_nothing_is_solved_where_both_bodies_respond_alike():
    """η = 0.5 for equal bodies at equal speed, k₁/(k₁ + k₂) for equal Péclet numbers: no application of anything."""
    disc = Disc(24)
    for other, share in ((body(7.0), 0.5), (body(7.0, 3.0 * K, 4.0 * KAPPA), 0.25)):
        response = HeatResponse(disc.grid, body(7.0), other)
        before = counted.transforms
        partition = match(response, disc.flux, disc.contact)
        assert partition.applications == 0 and counted.transforms == before
        assert partition.into.share == share
        np.testing.assert_allclose(partition.into.lower, share * disc.flux, rtol=1e-14)
        assert disc.mismatch(response, partition) < 1e-12


def test_neither_heat_nor_contact_is_no_problem():
    disc = Disc(16)
    response = HeatResponse(disc.grid, body(1.0), body(2.0))
    assert not match(response, disc.none, disc.contact).into.lower.any()
    assert not match(response, disc.none, disc.contact & False, 10.0).into.lower.any()


# --- limits -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("peclet", "within"), [(0.0, 1e-12), (1.0, 0.01), (10.0, 0.01), (100.0, 0.035), (1000.0, 0.06)])
def test_mean_share_of_a_body_at_rest_under_a_moving_one(peclet, within):
    """Blok's closure with mean temperatures, η = T̄₂/(T̄₁ + T̄₂): near the local division at all speeds, equal at rest."""
    disc = Disc(128)
    heat = disc.match(body(0.0), body(peclet))[0].into
    mean = [circle_mean_temperature(RADIUS, 1.0, K, KAPPA, p * KAPPA / RADIUS, "hertz") for p in (0.0, peclet)]
    share, blok = disc.heat(heat.lower) / disc.heat(disc.flux), mean[1] / (mean[0] + mean[1])
    assert share == pytest.approx(blok, rel=within)
    places = printed("verification", """1, 10, 100, 1000: 0.437, 0.258, 0.100, 0.0332 | Blok, by mean temperatures |
                                     0.440, 0.259, 0.103, 0.0350""")
    for speed, here, there in zip(places[:4], places[4:8], places[8:], strict=True):
        if speed.value == peclet:
            assert share == pytest.approx(here.value, abs=here.rounding)
            assert blok == pytest.approx(there.value, abs=there.rounding)


def test_body_at_rest_under_a_very_fast_one():
    """P → ∞: the fast body takes all but a little heat, so its surface has the temperature of a fast band row by row; the
    body at rest is warmed by that, and by reciprocity takes Q₁ = ∫ T q₁ with q₁ = 2k/(π sqrt(a² − r²)), what a disc at
    unit temperature gives off."""
    fast, disc = body(3e5), Disc(192)
    heat = disc.match(body(0.0), fast)[0].into
    n = 400
    angle = (np.arange(n) + 0.5) * math.pi / n  # y = a cos(angle); on a chord x = l sin(position)
    taken = 0.0
    for y in np.cos(angle):
        half = RADIUS * math.sqrt(1.0 - y**2)
        position = (np.arange(200) + 0.5) * math.pi / 200 - 0.5 * math.pi
        x = half * np.sin(position)
        rise = band_temperature(x, half, 1e6 * half / RADIUS, K, KAPPA, fast.speed_x, "hertz")
        # q₁ dx = 2k/π d(position) on the chord, dy = half d(angle)
        taken += float(np.sum(rise)) * (2.0 * K / math.pi) * (math.pi / 200) * half * (math.pi / n)
    assert disc.heat(heat.lower) == pytest.approx(taken, rel=3e-3)


@pytest.mark.parametrize("other", [body(4e4, 20.0, 5e-6), body(1e4)])
def test_two_fast_bodies_share_by_effusivity_and_speed(other):
    """P → ∞ for both: heat flows straight down, η = β₁√V₁/(β₁√V₁ + β₂√V₂) at every point."""
    one, disc = body(2e4), Disc(64)
    strength = [effusivity(b.conductivity, b.diffusivity) * math.sqrt(b.speed_x) for b in (one, other)]
    share = disc.match(one, other)[0].into.lower[disc.contact] / disc.flux[disc.contact]
    np.testing.assert_allclose(share, strength[0] / sum(strength), atol=5e-3)


def test_conduction_between_two_bodies_at_rest():
    """An isothermal disc on a half-space gives off 4kaT; two of them in series, 4aΔT/(1/k₁ + 1/k₂): first order or better."""
    exact = 4.0 * RADIUS * 30.0 / (1.0 / K + 1.0 / 20.0)
    sides, errors = [16, 32, 64, 128], []
    for n in sides:
        partition, mismatch = Disc(n).match(body(), body(0.0, 20.0), flux=Disc(n).none, bulk=30.0)
        errors.append(Disc(n).heat(partition.into.lower) / exact - 1.0)
        assert mismatch < 1e-5
        np.testing.assert_allclose(partition.into.lower, -partition.into.upper, rtol=1e-12)
    assert abs(errors[-1]) < 3e-3
    assert order(sides, errors) > 0.9


def test_conduction_between_two_fast_bodies():
    """Two half-spaces that meet: q = ΔT/[(1/β₁√V₁ + 1/β₂√V₂) sqrt(πs)] at the distance s from the leading edge."""
    one, other = body(4e3), body(1e3, 20.0)
    parts = [effusivity(b.conductivity, b.diffusivity) * math.sqrt(b.speed_x) for b in (one, other)]
    joint = 1.0 / (1.0 / parts[0] + 1.0 / parts[1])
    y = (np.arange(2000) + 0.5) / 2000.0
    exact = 30.0 * joint * 2.0 / math.sqrt(math.pi) * RADIUS**1.5 * 2.0 * np.mean(np.sqrt(2.0 * np.sqrt(1.0 - y**2)))
    disc = Disc(128)
    heat = disc.match(one, other, flux=disc.none, bulk=30.0)[0].into
    assert disc.heat(heat.lower) == pytest.approx(exact, rel=0.02)
    row = heat.lower[:, 64]
    s = disc.grid.x + math.sqrt(RADIUS**2 - disc.grid.y[64] ** 2)
    inside = (s > 0.3 * RADIUS) & (s < 1.9 * RADIUS)
    np.testing.assert_allclose(row[inside], 30.0 * joint / np.sqrt(math.pi * s[inside]), rtol=0.02)


def test_mean_share_converges_with_the_grid():
    sides, pair = [16, 32, 64, 128], (body(0.0), body(10.0))
    shares = [Disc(n).heat(Disc(n).match(*pair)[0].into.lower) / Disc(n).heat(Disc(n).flux) for n in sides]
    assert order(sides[:-1], np.array(shares[:-1]) - shares[-1]) > 0.9
    assert shares[2] == pytest.approx(shares[-1], rel=2e-3)


@pytest.mark.parametrize("speed", [0.02, 2.0])
def test_sliding_peclet_numbers_match_too(speed):
    """Every source its own Péclet number, and two diffusivities: the same bounds. Equal diffusivity: nothing to solve."""
    disc = Disc(32)
    slip = speed * np.maximum(disc.grid.x[:, None] / RADIUS + 0.3 + 0.2 * disc.grid.y[None, :] / RADIUS, 0.0)
    flux = disc.flux * (slip > 0.0)
    kernels = SlidingKernels(disc.grid)
    response = SlidingHeatResponse(kernels, body(), body(0.0, 20.0, 0.1 * KAPPA), slip)
    for bulk in (0.0, 20.0):
        partition = match(response, flux, disc.contact, bulk)
        assert disc.mismatch(response, partition, bulk) < 1e-5 and partition.applications <= 24
        np.testing.assert_allclose(partition.into.total, flux, atol=1e-12 * flux.max())
    alike = match(SlidingHeatResponse(kernels, body(), body(0.0, 3.0 * K), slip), flux, disc.contact)
    assert alike.applications == 0 and alike.into.share == 0.25


# --- in the pipeline ----------------------------------------------------------------------------------------------


def surfaces(result, bulk: float = 0.0) -> float:
    """Largest difference of both surface temperatures over their peak, in elements that touch as a whole."""
    f = result.coupled.fields
    inside, difference = f["covered"] == 1.0, f["temperature_rise_lower"] - f["temperature_rise_upper"] - bulk
    peak = max(np.abs(f["temperature_rise_lower"]).max(), np.abs(f["temperature_rise_upper"]).max(), abs(bulk))
    return float(np.abs(difference[inside]).max() / peak)


def test_steel_rolls_on_ceramic_at_one_temperature():
    problem = replace(rolling(grid=16, creepage=(0.003, 0.001), heating=MATCHED), upper=CERAMIC)
    result = solved(problem)
    fields, scalars = result.coupled.fields, result.coupled.scalars
    assert result.converged and "partition" not in result.work["skipped"]
    assert surfaces(result) < 1e-4
    lower, total = fields["heat_flux_lower"].sum(), fields["heat_flux"].sum()
    assert scalars["partition_mean"] == pytest.approx(lower / total, rel=1e-12)
    assert 0.6 < scalars["partition_mean"] < 0.7  # β√V in the ratio 15.9 : 7.1 would give 0.69
    assert result.work["partition"]["applications"] <= 12
    # The number it amounts to gives nearly the same hottest points.
    number = solved(replace(problem, heating=Heating(partition=scalars["partition_mean"]))).coupled.scalars
    for name in ("temperature_rise_max_lower_K", "temperature_rise_max_upper_K"):
        assert number[name] == pytest.approx(scalars[name], rel=0.05)


@pytest.mark.slow
def test_equal_bodies_are_not_solved_for():
    """Lateral creepage of bodies that roll alike along x still moves them apart along y; at equal speed nothing is left."""
    equal = solved(replace(article_4_1(12), heating=Heating(peclet="stationary", partition="matched")))
    half = solved(article_4_1(12))
    assert "equally warm with a share of 0.5" in equal.work["skipped"]["partition"]
    assert "partition" not in equal.work and "heat_flux_lower" not in equal.coupled.fields
    assert equal.coupled.scalars["partition_mean"] == 0.5
    for name, field in half.coupled.fields.items():
        np.testing.assert_array_equal(field, equal.coupled.fields[name])
    creeping = solved(rolling(grid=24, creepage=(0.003, 0.0), heating=MATCHED))
    assert creeping.coupled.scalars["partition_mean"] == pytest.approx(0.5, abs=1e-3)
    assert creeping.work["partition"]["applications"] <= 8


@pytest.mark.slow
def test_a_body_at_rest_takes_little_of_the_heat():
    """Slide-roll ratio 2 at V a/κ = 37 of the moving body: near the closure with mean temperatures."""
    result = solved(rolling(grid=32, creepage=(2.0, 0.0), heating=MATCHED))
    peclet = result.of_problem["peclet_lower"]
    assert result.of_problem["peclet_upper"] == 0.0
    mean = [circle_mean_temperature(1.0, 1.0, 1.0, 1.0, p, "hertz") for p in (peclet, 0.0)]
    assert result.coupled.scalars["partition_mean"] == pytest.approx(mean[1] / sum(mean), rel=0.02)
    assert surfaces(result) < 1e-4


def test_bulk_temperatures_drive_heat_without_any_slip():
    """A hot body rolling freely on a cold one: no friction, all heat by conduction, both surfaces equally warm inside."""
    heating = replace(MATCHED, bulk_lower=20.0, bulk_upper=120.0)
    insulator = replace(STEEL, conductivity=20.0, diffusivity=8e-6)
    problem = replace(rolling(grid=16, heating=heating), upper=insulator)
    result = solved(problem)
    fields, scalars = result.coupled.fields, result.coupled.scalars
    assert result.converged and scalars["Q_F_W"] == 0.0 and math.isnan(scalars["partition_mean"])
    assert surfaces(result, 100.0) < 1e-4
    assert fields["heat_flux_lower"].sum() > 0.0 > fields["temperature_rise_upper"].min()
    assert fields["temperature_rise_lower"].max() > 0.0
    # Exchanged bodies, exchanged temperatures: the same heat the other way.
    swapped = replace(problem, lower=insulator, upper=STEEL, heating=replace(heating, bulk_lower=120.0, bulk_upper=20.0))
    other = solved(swapped).coupled.fields
    np.testing.assert_allclose(-other["heat_flux_lower"], fields["heat_flux_lower"], rtol=1e-4, atol=1e-4 * 1e6)
    # Without a difference there is nothing to conduct, and equal bodies on equal terms need no solution.
    still = solve(replace(problem, heating=replace(heating, bulk_lower=120.0)))
    assert "nothing rubs" in still.work["skipped"]["heat"] and not still.coupled.fields["temperature_rise_lower"].any()


@pytest.mark.parametrize("grid", [13, 16, 24, 33])
def test_heat_that_two_spheres_at_rest_conduct(grid):
    """4 k a ΔT of a disc of one temperature on a half-space (Carslaw and Jaeger), for each body: border elements exchange
    what their part in contact does."""
    heating = replace(MATCHED, peclet="stationary", deformation=False, bulk_upper=100.0)
    problem = rolling(grid=grid, heating=heating)
    exact = 2.0 * STEEL.conductivity * DerivedQuantities(problem).scales.semi_axis_x * 100.0
    result = solve(problem)
    assert result.converged, result.reason
    off = result.coupled.scalars["heat_conducted_W"] - exact
    assert abs(off) < 0.02 * exact and abs(off) < relative(result)["heat_conducted_W"] * exact


def test_an_element_that_the_border_hardly_reaches_hardly_exchanges():
    disc = Disc(24)
    rim = disc.contact & ~np.roll(disc.contact, 1, axis=0)
    fluxes = []
    for part in (1e-3, 1e-6, 0.0):
        response = HeatResponse(disc.grid, body(), body(0.0, 20.0))
        partition = match(response, disc.none, np.where(rim, part, disc.contact), 30.0)
        assert partition.mismatch <= 1e-5
        fluxes.append(partition.into.lower)
    np.testing.assert_allclose(fluxes[1], fluxes[2], rtol=1e-4, atol=1e-5 * fluxes[2].max())
    assert 0.0 < fluxes[0][rim].max() < 0.01 * fluxes[0].max()


@pytest.mark.parametrize("peclet", ["rolling", "stationary", pytest.param("sliding", marks=pytest.mark.slow)])
def test_coupled_with_thermal_deformation(peclet):
    """Different expansions: each body's own part of the heat deforms it, within a few outer iterations."""
    heating = replace(MATCHED, peclet=peclet, bulk_upper=40.0)
    problem = replace(article_4_1(12, heating=heating), upper=CERAMIC, motion=Motion(100.0, 0.003, 0.0))
    result = solved(problem)
    assert result.converged, result.reason
    assert surfaces(result, 40.0) < 1e-4
    if "deformation" not in result.work["skipped"]:
        assert result.work["iterations"]["coupling_iterations"] <= 10
        assert result.coupled.scalars["gamma_p"] > 1.0
    scalars = result.coupled.scalars
    assert math.isnan(scalars["partition_mean"])
    assert scalars["heat_into_lower_W"] > 0.5 * scalars["Q_F_W"]


def test_conducted_heat_is_what_flows_without_friction():
    """From the hotter to the colder body, whatever the friction; friction alone divides by the rest of the heat."""
    heating = replace(MATCHED, bulk_upper=40.0, deformation=False)
    problem = article_4_1(12, heating=heating)
    problem = replace(problem, upper=replace(problem.upper, conductivity=30.0))
    rubbing, sliding_freely = solved(problem).coupled.scalars, solved(replace(problem, friction=Friction(0.0))).coupled.scalars
    alone = solved(replace(problem, heating=replace(heating, bulk_upper=0.0))).coupled.scalars
    assert sliding_freely["heat_into_lower_W"] == pytest.approx(-sliding_freely["heat_into_upper_W"], rel=1e-9)
    assert sliding_freely["heat_conducted_W"] == pytest.approx(sliding_freely["heat_into_lower_W"], rel=1e-9)
    assert rubbing["heat_conducted_W"] == pytest.approx(sliding_freely["heat_conducted_W"], rel=1e-4)
    by_friction = alone["heat_into_lower_W"]
    assert rubbing["heat_into_lower_W"] - by_friction == pytest.approx(rubbing["heat_conducted_W"], rel=1e-3)
    assert alone["heat_conducted_W"] == 0.0
    assert alone["partition_mean"] == pytest.approx(by_friction / alone["Q_F_W"], rel=1e-2)
    turned = solved(replace(problem, heating=replace(heating, bulk_upper=-40.0))).coupled.scalars
    assert turned["heat_conducted_W"] == pytest.approx(rubbing["heat_conducted_W"], rel=1e-4)


def test_expansion_is_that_of_each_body_with_its_own_heat():
    """Steel expands, the other body does not: all of the bulge comes from the heat that enters the steel."""
    grid = Grid(20, 20, 1e-5, 1e-5)
    random = np.random.default_rng(5)
    heat = DividedHeat(random.random(grid.shape), 0.4, random.random(grid.shape) - 0.5)
    stiff = replace(body(3.0), free_expansion=0.0)
    bodies = body(2.0), stiff
    only = HeatResponse(grid, *bodies).displacement(heat)
    alone = HeatResponse(grid, *bodies).displacement(DividedHeat(heat.lower, 1.0))
    np.testing.assert_allclose(only, alone, atol=1e-12 * np.abs(only).max())
    pair = body(2.0), body(3.0, 20.0)
    shared = DividedHeat(heat.total, 0.3)
    separate = replace(shared, exchanged=np.zeros(grid.shape))
    response = HeatResponse(grid, *pair)
    np.testing.assert_allclose(response.displacement(shared), response.displacement(separate), rtol=1e-11)
    for a, b in zip(response.temperatures(shared), response.temperatures(separate), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-11)


def test_heat_is_divided_as_closely_as_asked_for_and_kept_with_its_tractions():
    derived = DerivedQuantities(rolling(grid=32, creepage=(0.5, 0.0), speed=2.0, heating=MATCHED))
    here = Discretisation(derived, (32, 32), 2.2)
    contact = Contact(here.isothermal_pressure, here.roll(here.isothermal_pressure, Traction.unknown((32, 32)), 1e-5))
    loose = here.heat(contact, 1e-2)
    assert here.heat(contact, 1e-3) is loose and loose.mismatch > 1e-5
    close = here.heat(contact)
    assert close.mismatch <= 1e-6 and here.heat(contact, 1e-2) is close
    again = replace(contact, tangential=replace(contact.tangential))
    assert here.heat(again) is not close and here.heat(contact) is close


@pytest.mark.slow
def test_iterations_divide_heat_as_closely_as_their_tractions_are_known(monkeypatch):
    """More closely costs a tenth more transforms, and changes nothing."""
    problem = rolling(grid=32, creepage=(1.0, 0.0), speed=20.0, heating=MATCHED)
    transforms, results = [], []
    for division in (DIVISION, 1e-2 * DIVISION):
        monkeypatch.setattr("thermoroll_cli.one_contact.steady_state.iteration.DIVISION", division)
        before = counted.transforms
        results.append(solve(problem))
        transforms.append(counted.transforms - before)
    assert all(result.converged for result in results) and transforms[1] > 1.05 * transforms[0]
    usual, close = (result.coupled.scalars for result in results)
    for name in ("Q_F_W", "partition_mean", "gamma_p", "temperature_rise_max_lower_K"):
        assert usual[name] == pytest.approx(close[name], rel=3e-6)


# --- the case file ------------------------------------------------------------------------------------------------


def test_keys_of_the_case_file():
    case = parse(
        THERMAL, "thermal.partition=matched", "thermal.bulk_temperature_upper_K=60", "thermal.bulk_temperature_lower_K=5"
    )
    heating = case.problem.heating
    assert (heating.partition, heating.bulk_lower, heating.bulk_upper) == ("matched", 5.0, 60.0)
    assert heating.conducts and heating.bulk_difference == 55.0
    default = parse(THERMAL).problem.heating
    assert (default.partition, default.bulk_lower, default.bulk_upper, default.conducts) == (0.5, 0.0, 0.0, False)
    both = parse(THERMAL, "thermal.bulk_temperature_upper_K=60", "thermal.bulk_temperature_lower_K=60")
    assert not both.problem.heating.conducts

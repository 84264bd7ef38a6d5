"""Line contacts against the exact solutions of cylinders: Hertz, Carter along and across, Bentall and Johnson."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import k0e

from tests.support.documents import at_most
from tests.support.problems import MECHANICAL, elastic
from thermoroll_cli.exact.hertz import line_contact
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage
from thermoroll_cli.one_contact.refinement.plan import grid_sequence
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, coupling_tables, normal_table, shear_tables
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_slope_table, temperature_table
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.friction import Friction, FrictionLaw, Interlayer
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import (
    Heating,
    Material,
    Motion,
    Numerics,
    Problem,
    Strength,
    SubsurfaceRequest,
    Wear,
    WornBody,
)
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

STEEL = elastic(0.28)
FRICTION, LOAD = 0.3, 3e5


def cylinders(
    grid: int = 128, lower: Material = STEEL, upper: Material = STEEL, *, motion: Motion, friction: Friction | None = None,
    load: float = LOAD, radii: tuple[float, float] = (0.04, 0.06),
) -> Problem:
    """Cylinders under a load in N/m."""
    geometry = Geometry(radii[0], math.inf, radii[1], math.inf)
    return Problem(lower, upper, geometry, load, friction or Friction(FRICTION), motion, MECHANICAL, Numerics((grid, 1)))


def exact(problem: Problem):
    return line_contact(problem.geometry.curvature_x, problem.contact_modulus, problem.normal_force)


def at_share(share: float, grid: int = 128, *, across: bool = False) -> Problem:
    """Rolling at a share of the creepage beyond which all slides."""
    problem = cylinders(grid, motion=Motion(1.0))
    creepage = share * saturation_creepage(exact(problem), FRICTION)
    motion = Motion(1.0, creepage, 0.0) if not across else Motion(1.0, 0.0, creepage / (1.0 - STEEL.poisson_ratio))
    return replace(problem, motion=motion)


def errors_of(result: Result, share: float, *, across: bool = False) -> tuple[float, float]:
    """Errors of the force over μW and of the share that sticks, after Carter."""
    force = result["force_y_N_mm" if across else "force_x_N_mm"] / result["friction_limit_N_mm"]
    return abs(force - (1.0 - (1.0 - share) ** 2)), abs(result["gamma_st"] - (1.0 - share))


def test_kernels_are_those_of_long_rectangles() -> None:
    """Up to constants, which move bodies as a whole; a load of unit length."""
    dx, length, compliance = 0.1, 4e4, ShearCompliance(1.0, 0.4)
    for tables in (lambda dy: (normal_table(9, 1, dx, dy, 2.0),), lambda dy: shear_tables(9, 1, dx, dy, compliance)[:2]):
        for strip, long in zip(tables(math.inf), tables(length), strict=True):
            np.testing.assert_allclose(np.diff(strip[:, 0]), np.diff(long[:, 0]), rtol=1e-7, atol=1e-9)
            assert strip.min() == 0.0
    np.testing.assert_allclose(coupling_tables(9, 1, dx, math.inf)[0], coupling_tables(9, 1, dx, length)[0], atol=1e-4)
    assert not coupling_tables(9, 1, dx, math.inf)[1].any() and not shear_tables(9, 1, dx, math.inf, compliance)[2].any()


def test_pressure_found_is_that_of_hertz() -> None:
    """As where heat or shear acts back: the gap is closed on elements, and the border lies within them."""
    problem = at_share(0.5)
    grid = Discretisation(DerivedQuantities(problem), (128, 1), 2.2)
    hertz, found = grid.isothermal_pressure, grid.pressure.solve(None, np.ones((128, 1)), 1e-9, mirrored=False)
    assert found.converged and found.peak == pytest.approx(exact(problem).peak_pressure, rel=3e-4)
    assert np.abs(found.pressure - hertz.pressure).max() < 2e-3 * hertz.peak
    assert found.covered.sum() == pytest.approx(hertz.covered.sum(), rel=1e-3)


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_carter(share: float, across: bool) -> None:
    result = solve(at_share(share, across=across))
    force, stick = errors_of(result, share, across=across)
    row, difference = ("the same across rolling", "Carter's force, share of stick")[not across], "largest difference"
    assert result.converged and force <= at_most("line_contacts", row, difference)
    assert stick <= at_most("line_contacts", "Carter's force, share of stick", difference, 1)
    assert force <= result.uncertainty["force_y_N_mm" if across else "force_x_N_mm"] / result["friction_limit_N_mm"]
    assert stick <= result.uncertainty["gamma_st"]
    solution = carter(exact(at_share(share)), FRICTION, at_share(share).motion.creepage_x or 0.0)
    if not across:
        assert result["Q_F_W_mm"] == pytest.approx(1e-3 * solution.heat(1.0), rel=3e-4)
        at = result.x[16:-16:8]
        np.testing.assert_allclose(result.fields["shear_x"][16:-16:8], solution.traction(at), atol=0.01 * 0.3e9)


@pytest.mark.parametrize("grid", [16, 32, 64])
@pytest.mark.parametrize("share", [
    0.003, 0.02, 0.95, 0.985, *(pytest.param(share, marks=pytest.mark.slow) for share in (0.96, 0.97, 0.98, 0.995))])
def test_zones_within_an_element_are_in_the_estimates(share: float, grid: int) -> None:
    """A zone that sticks, or that slips, narrower than an element: no grid sees it, and the estimate does."""
    result = solve(at_share(share, grid))
    force, stick = errors_of(result, share)
    assert stick <= result.uncertainty["gamma_st"] < 6.0 / grid
    assert force <= result.uncertainty["force_x_N_mm"] / result["friction_limit_N_mm"] < 0.1


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1.2])
def test_the_first_grid_begins_with_carter(share: float) -> None:
    """Along, across, and with forces: from full stick the end of slip takes up to nine steps to its place."""
    along, across = at_share(share), at_share(share, across=True)
    limit = FRICTION * LOAD
    pulled = replace(along, motion=Motion(1.0, None, None, force_x=0.4 * share * limit, force_y=0.6 * share * limit))
    for problem in (along, across, pulled):
        first = solve(problem).work["levels"][0]
        assert first["newton_steps"] <= 4 and first["applications"] <= 24


@pytest.mark.parametrize("share", [1.01, 1.15, 1.29])
def test_a_force_that_only_friction_which_rises_with_slip_carries(share: float) -> None:
    """All slides: the force answers to the creepage by friction alone, whose mean is that at the creepage."""
    law = FrictionLaw("table", table=((0.0, 1.0), (0.3, 1.3)))
    motion = Motion(1.0, None, 0.0, force_x=share * FRICTION * LOAD)
    result = solve(cylinders(32, motion=motion, friction=Friction(FRICTION, law)))
    assert result.converged and result["creepage_longitudinal"] == pytest.approx(share - 1.0, rel=1e-3)
    assert sum(level["newton_steps"] for level in result.work["levels"]) <= 30


@pytest.mark.slow
def test_errors_fall_with_the_square_of_the_element() -> None:
    """Root mean squares over the creep curve, without extrapolation."""
    plain, shares = SolverOptions(extrapolated=False), np.linspace(0.1, 0.9, 9)
    coarse, fine = (np.linalg.norm([errors_of(solve(at_share(share, grid), options=plain), share)[0] for share in shares])
                    for grid in (64, 256))
    assert fine < coarse / 12.0


def test_a_force_needs_the_creepage_of_carter() -> None:
    """And both directions at once: along and across are alike but for their compliance."""
    problem = cylinders(motion=Motion(1.0, None, 0.0, force_x=0.75 * FRICTION * LOAD))
    wanted = 0.5 * saturation_creepage(exact(problem), FRICTION)
    assert solve(problem)["creepage_longitudinal"] == pytest.approx(wanted, rel=2e-4)
    incompressible = cylinders(lower=elastic(0.0), upper=elastic(0.0), motion=Motion(
        1.0, None, None, force_x=0.6 * 0.75 * FRICTION * LOAD, force_y=0.8 * 0.75 * FRICTION * LOAD))
    found = solve(incompressible)
    assert math.hypot(found["creepage_longitudinal"], found["creepage_lateral"]) == pytest.approx(
        0.5 * saturation_creepage(exact(incompressible), FRICTION), rel=2e-4)


@pytest.mark.parametrize(("friction", "force", "creepage", "pressure"), [
    *(pytest.param(*row, marks=pytest.mark.slow) for row in ((10.0, 0.0, 0.000366, 103.8), (0.05, 0.0, 0.0004294, 103.6))),
    pytest.param(0.05, -0.75, 0.0005392, 103.3, marks=pytest.mark.slow),
    # All slides: half of the pressure beyond both places where the slip turns, 0.404 a off the middle.
    (1e-4, 0.0, 0.0005263, 103.15)])
def test_aluminium_on_steel_after_bentall_and_johnson(
    friction: float, force: float, creepage: float, pressure: float
) -> None:
    load = 16.2019e3
    lower, upper = (elastic(nu, 2.0 * g * (1.0 + nu)) for g, nu in ((82e9, 0.28), (23e9, 0.31)))
    result = solve(cylinders(lower=lower, upper=upper, load=load, radii=(0.05, 0.05), friction=Friction(friction),
                             motion=Motion(1.0, None, 0.0, force_x=force * friction * load)))
    assert result.converged and abs(result["creepage_longitudinal"]) == pytest.approx(creepage, rel=0.01)
    assert result["pressure_max_MPa"] == pytest.approx(pressure, rel=0.01)
    assert 0.0 < result.uncertainty["creepage_longitudinal"] < 0.01 * creepage


@pytest.mark.slow
def test_it_is_the_middle_of_a_slender_ellipse() -> None:
    """Of a contact 100 times as wide as long, far from its ends, also with friction that falls with slip."""
    law = FrictionLaw("exponential", 0.6, 0.002)
    line = replace(at_share(0.7, 64), friction=Friction(FRICTION, law))
    slender = replace(line, geometry=Geometry(0.04, 400.0, 0.06, 400.0), numerics=Numerics((64, 128)))
    half = DerivedQuantities(line).scales.semi_axis_x
    wide = DerivedQuantities(slender)
    # The load of an ellipse of the same half-width and pressure in the middle.
    peak = DerivedQuantities(line).scales.peak_pressure
    slender = replace(slender, normal_force=slender.normal_force * (peak / wide.scales.peak_pressure) ** 3)
    middle = DerivedQuantities(slender).scales
    assert middle.semi_axis_x == pytest.approx(half, rel=0.02) and middle.semi_axis_y > 50.0 * half
    one, other = solve(line), solve(slender)
    lines = other.fields["shear_x"][:, 63] / middle.peak_pressure, one.fields["shear_x"] / peak
    assert np.abs(lines[0] - lines[1]).max() < 0.02


def test_an_interlayer_softens_the_beginning_of_the_creep_curve() -> None:
    """Full stick is a linear problem: (A + L) τ along x, here solved for elements."""
    problem = at_share(0.01, 64)
    scales = DerivedQuantities(problem).scales
    shear = DerivedQuantities(problem).saturation_creepage * scales.semi_axis_x
    layer = replace(problem, interlayer=Interlayer(3.0 * shear / (FRICTION * scales.peak_pressure)))
    stiff, soft = solve(problem)["force_x_N_mm"], solve(layer)["force_x_N_mm"]
    assert 0.1 * stiff < soft < 0.5 * stiff
    yields = solve(replace(at_share(3.0, 64), interlayer=Interlayer(0.0, 0.5 * FRICTION * scales.peak_pressure)))
    # ∫ min(μp, ½μp₀) of a semi-ellipse.
    carried = 2.0 / math.pi * (0.5 * math.sqrt(0.75) + math.asin(0.5))
    assert yields["force_x_N_mm"] == pytest.approx(carried * yields["friction_limit_N_mm"], rel=1e-3)


def k0_integral(x: float, peclet: float, shape=lambda s: 1.0, half: float = 0.5) -> float:
    """∫ shape(s) e^{P(x−s)/2} K₀(P|x−s|/2)/π ds over −half … half."""
    def integrand(s: float) -> float:
        z = 0.5 * peclet * (x - s)
        return shape(s) * math.exp(z - abs(z)) * float(k0e(abs(z))) / math.pi

    return quad(integrand, -half, half, points=[x] if abs(x) < half else None, limit=400, epsrel=1e-10)[0]


@pytest.mark.parametrize("peclet", [0.01, 0.5, 40.0, -3.0])
def test_kernels_of_heat_are_those_of_moving_lines(peclet: float) -> None:
    """And the expansion is that of long rectangles, up to a constant: the approach absorbs it."""
    x, table = np.arange(-4.0, 5.0), temperature_table(5, 1, math.inf, peclet)[:, 0]
    np.testing.assert_allclose(table, [k0_integral(at, peclet) for at in x], atol=1e-10 * table.max())
    slope = temperature_slope_table(5, 1, math.inf, peclet)[:, 0]
    np.testing.assert_allclose(slope, [k0_integral(at, peclet, lambda s: s) for at in x], atol=1e-10 * table.max())
    if peclet > 0.1:
        strip, long = (displacement_table(5, 1, aspect, peclet)[:, 0] for aspect in (math.inf, 4e3))
        np.testing.assert_allclose(strip - strip[4], long - long[4], atol=2e-4 * np.ptp(strip))


def test_material_at_rest_has_no_steady_temperature() -> None:
    for table in (temperature_table, temperature_slope_table, displacement_table):
        with pytest.raises(ValueError, match="at rest"):
            table(5, 1, math.inf, 0.0)


TOOTH = Material(206e9, 0.3, 46.6, 11.7e-6, 12.5e-6)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [3.0, *(pytest.param(speed, marks=pytest.mark.slow) for speed in (0.1, 60.0))])
def test_flash_temperatures_of_sliding_teeth(speed: float) -> None:
    motion, heating = Motion(speed, 0.2, 0.0), Heating(True, False, "rolling", 0.5)
    problem = replace(cylinders(128, TOOTH, TOOTH, motion=motion, load=12.5e3, radii=(0.01, 0.015), friction=Friction(0.06)),
                      heating=heating)
    result, contact = solve(problem), exact(problem)
    for body, moving in (("lower", 1.1 * speed), ("upper", 0.9 * speed)):
        peclet = moving * contact.half_width / TOOTH.diffusivity
        flux = 0.5 * 0.06 * contact.peak_pressure * 0.2 * speed

        def rise(at: float, peclet: float = peclet, flux: float = flux) -> float:
            shape = k0_integral(at, peclet, lambda s: math.sqrt(max(1.0 - s * s, 0.0)), 1.0)
            return flux * contact.half_width / TOOTH.conductivity * shape

        wanted = max(map(rise, np.linspace(-0.5, 1.2, 171)))
        assert result[f"temperature_rise_max_{body}_K"] == pytest.approx(wanted, rel=1e-3)
    assert result["heat_into_lower_W_mm"] == pytest.approx(0.5 * result["Q_F_W_mm"])
    if speed == 60.0:
        matched = solve(replace(problem, heating=replace(heating, partition="matched")))
        effusivity = TOOTH.conductivity / math.sqrt(TOOTH.diffusivity)
        blok = 1.11 * 0.06 * 12.5e3 * 0.2 * speed / (
            effusivity * (math.sqrt(1.1 * speed) + math.sqrt(0.9 * speed)) * math.sqrt(2.0 * contact.half_width))
        lower, upper = (matched[f"temperature_rise_max_{body}_K"] for body in ("lower", "upper"))
        assert lower == pytest.approx(upper, rel=1e-5) and lower == pytest.approx(blok, rel=0.01)


def test_expansion_acts_back_on_the_pressure() -> None:
    """Weak heat hardly, strong heat much: it concentrates the contact."""
    motion, heating = Motion(3.0, 0.2, 0.0), Heating(True, "always", "rolling", 0.5)
    problem = replace(cylinders(128, TOOTH, TOOTH, motion=motion, load=12.5e3, radii=(0.01, 0.015), friction=Friction(0.06)),
                      heating=heating)
    weak = solve(problem)
    assert weak.converged and 1.0 < weak["gamma_p"] < 1.002 and weak["gamma_c"] < 1.0
    bulge = DerivedQuantities(problem).scales.approach / (1e-6 * weak["thermal_displacement_max_um"])
    hot = replace(TOOTH, expansion=TOOTH.expansion * bulge)
    strong = solve(replace(problem, lower=hot, upper=hot))
    assert strong.converged, strong.reason
    assert strong["gamma_p"] > 1.15 and strong["gamma_c"] < 0.95
    finer = solve(replace(problem, lower=hot, upper=hot, numerics=Numerics((256, 1))))
    assert abs(strong["gamma_p"] - finer["gamma_p"]) <= strong.uncertainty["gamma_p"]


def mcewen(x: np.ndarray, z: np.ndarray, half: float) -> np.ndarray:
    """σ_xx, σ_zz, |σ_xz| over p₀ below a cylinder (McEwen; Johnson, Contact Mechanics, Eqs. 4.49)."""
    root = np.sqrt((half**2 - x**2 + z**2) ** 2 + 4.0 * x**2 * z**2)
    m2, n2 = 0.5 * (root + half**2 - x**2 + z**2), 0.5 * (root - half**2 + x**2 - z**2)
    m, n = np.sqrt(m2), np.sqrt(np.maximum(n2, 0.0))
    share = (z**2 + n2) / (m2 + n2)
    return np.stack([2.0 * z - m * (1.0 + share), -m * (1.0 - share), n * np.abs(m2 - z**2) / (m2 + n2)]) / half


def test_stresses_below_the_surface_are_those_of_mcewen() -> None:
    problem = replace(at_share(0.0), subsurface=SubsurfaceRequest(("lower",), fields="full"))
    result, contact = solve(problem), exact(problem)
    stresses = result.bodies["lower"]
    assert result.converged and not stresses.fields and stresses.plane["stress_xx"].shape == (len(stresses.depths), 128)
    below = stresses.depths > 0.1 * contact.half_width
    wanted = mcewen(result.x[None, :], stresses.depths[below, None], contact.half_width)
    for name, values in zip(("stress_xx", "stress_zz", "stress_xz"), wanted, strict=True):
        found = stresses.plane[name][below] / contact.peak_pressure
        assert np.abs((np.abs(found) if name == "stress_xz" else found) - values).max() < 1e-4
    plane_strain = 0.28 * (stresses.plane["stress_xx"] + stresses.plane["stress_zz"])
    np.testing.assert_allclose(stresses.plane["stress_yy"], plane_strain, atol=1e-6 * contact.peak_pressure)
    # Johnson, 4.2: the largest shear stress is 0.30 p₀, 0.78 a deep.
    assert result["tresca_shear_max_lower_MPa"] == pytest.approx(0.30028 * result["hertz_p0_MPa"], rel=1e-4)
    assert result["tresca_shear_depth_lower_mm"] == pytest.approx(0.786 * result["hertz_a_mm"], rel=2e-3)
    assert "von_mises_y_lower_mm" not in result.numbers


def test_shear_and_heat_below_the_surface() -> None:
    """At the surface σ_xz is the traction; lateral tractions make anti-plane shear alone; heat compresses the surface."""
    request = SubsurfaceRequest(("lower",), layers=8, lower_strength=Strength(4e8, 0.3))
    across = solve(replace(at_share(0.5, 32, across=True), subsurface=request))
    plane = across.bodies["lower"].plane
    shear = np.abs(across.fields["shear_y"])
    np.testing.assert_allclose(np.abs(plane["stress_yz"][0]), shear, atol=0.01 * shear.max())
    assert not across.fields["shear_x"].any() and across.bodies["lower"].strength["dang_van"].ndim == 1
    motion, heating = Motion(3.0, 0.2, 0.0), Heating(True, False, "rolling", 0.5)
    tooth = replace(cylinders(32, TOOTH, TOOTH, motion=motion, load=2e5, radii=(0.01, 0.015), friction=Friction(0.06)),
                    heating=heating, subsurface=SubsurfaceRequest(("lower",), layers=6), wear=Wear(WornBody(1e-15), WornBody()))
    hot = solve(tooth)
    inside, rise = hot.bodies["lower"].plane, hot.fields["temperature_rise_lower"]
    cold = solve(replace(tooth, heating=MECHANICAL)).bodies["lower"].plane
    np.testing.assert_allclose(inside["temperature_rise"][0], rise, atol=1e-5 * rise.max())
    # Fast material: the hot skin is held by the cold body below it.
    thermal = (inside["stress_yy"] - cold["stress_yy"])[0]
    expected = -TOOTH.youngs_modulus * (TOOTH.expansion or 0.0) / (1.0 - TOOTH.poisson_ratio) * rise
    assert np.abs(thermal - expected).max() < 0.2 * np.abs(expected).max()
    # Archard: κ ∫ p |s|/V dx, here κ times the load times the creepage.
    assert hot["wear_depth_max_lower_nm"] == pytest.approx(1e9 * 1e-15 * 2e5 * 0.2, rel=1e-4)
    assert hot["wear_rate_lower_mm2_m"] == pytest.approx(1e6 * 1e-15 * 2e5 * 0.2, rel=1e-4)


def test_only_the_grids_of_estimates_are_solved() -> None:
    """Where none is asked for, the first one is coarse."""
    assert grid_sequence(at_share(0.5, 512)) == ((128, 1), (256, 1), (512, 1))
    assert grid_sequence(replace(at_share(0.5), numerics=Numerics(None, 1e-3)))[0] == (16, 1)


def test_areas_are_per_length() -> None:
    grid = Grid(8, 1, 0.1, math.inf)
    assert grid.element_area == 0.1 and grid.y.tolist() == [0.0] and grid.sides == (8,)

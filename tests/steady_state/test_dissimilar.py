"""Two different bodies: the coupling kernels, both directions of the coupling, and rolling against other solutions."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import dblquad

from tests.support.documents import at_most, printed
from tests.support.sampling import sampled
from tests.support.scenes import MECHANICAL, STEEL, ellipse, on_grid, order, reference, spheres
from thermoroll_cli.exact import rolling_cylinders, spence
from thermoroll_cli.exact.hertz import element_averages, line_contact
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.refinement.warnings import tangential_expansion
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, Tolerances
from thermoroll_cli.physics.contact.shear_coupling import NormalShearCoupling
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import (
    ShearCompliance,
    coupling_constant,
    coupling_tables,
    normal_table,
    shear_tables,
)
from thermoroll_cli.physics.halfspace.thermal import temperature_table
from thermoroll_cli.physics.numerics.grid import UPSTREAM_WEIGHTS, Grid
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import DIFFERENCE_OFFSETS, RollingGradient
from thermoroll_cli.physics.rolling.rolling_solver import RollingSolver
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver, solve

CASES = ("polymer_lower", "free_rolling", "alu_ceramic_mixed")
POLYMER, CERAMIC = Material(5e9, 0.4, 0.3, 100e-6, 0.15e-6), Material(310e9, 0.26, 30.0, 3.2e-6, 9.4e-6)
ALUMINIUM = (23e9, 0.31)
HARD_STEEL = (82e9, 0.28)
"""Shear modulus and Poisson ratio of Bentall & Johnson's pair."""


def contact_case(name: str, grid: int) -> Problem:
    """One of the three cases of contact_dissimilar.json."""
    given = reference("contact_dissimilar")["cases"][name]["input"]
    lower, upper = (Material(given[b]["youngs_modulus_GPa"] * 1e9, given[b]["poisson_ratio"]) for b in ("lower", "upper"))
    # CONTACT's figures are those of surfaces without differential slip.
    motion = Motion(1.0, given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_mm"] * 1e3,
                    differential_slip=False)
    geometry = spheres(given["radius_mm_all_four"] * 1e-3)
    friction = Friction(given["friction_coefficient"])
    return on_grid(Problem(lower, upper, geometry, given["normal_N"], friction, motion, MECHANICAL), grid)


@cache
def solved(name: str, grid: int) -> Result:
    return solve(contact_case(name, grid))


def turned(problem: Problem) -> Problem:
    """The bodies change places: reflected at the contact plane, all slip changes its sign."""
    m, g = problem.motion, problem.geometry
    back = [None if v is None else -v for v in (m.creepage_x, m.creepage_y, m.spin, m.force_x, m.force_y)]
    geometry = Geometry(g.upper_radius_x, g.upper_radius_y, g.lower_radius_x, g.lower_radius_y)
    motion = Motion(m.speed, *back, m.differential_slip)
    return replace(problem, lower=problem.upper, upper=problem.lower, geometry=geometry, motion=motion)


# --- the moment of the pressure -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("creepage", "heat", "fed"), [(0.0, 0.8275, 0.0), (0.002, 8.2697, 9.9874)])
def test_the_moment_of_the_pressure_takes_its_part_of_the_power(creepage: float, heat: float, fed: float) -> None:
    """A ceramic ball of 10 mm on steel, 100 N, 1 m/s: mW of heat and of the creep force on 128 x 128 elements. What the force
    does not feed, or does not find again in heat, is the moment of the pressure times V/R."""
    ball = Problem(Material(206e9, 0.3), Material(315e9, 0.26), Geometry(math.inf, math.inf, 0.01, 0.01), 100.0,
                   Friction(0.05), Motion(1.0, creepage, 0.0, 0.0, differential_slip=False), MECHANICAL)
    found = solve(on_grid(ball, 32))
    assert 1e3 * found["Q_F_W"] == pytest.approx(heat, rel=5e-3)
    assert 1e3 * found["force_x_N"] * creepage == pytest.approx(fed, rel=1e-3)
    assert found["rolling_resistance_moment_Nmm"] / 10.0 == pytest.approx(1e-3 * (heat - fed), rel=1e-2)
    assert "rolling_resistance_N" not in found.scalars  # nothing is lost inside


# --- kernels -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("i", "j"), [(1, 0), (0, 1), (3, 2), (0, 5), (40, 7)])
def test_tables_are_the_integrals(i, j):
    dx, dy = 1.0, 0.7
    along, across = coupling_tables(41, 8, dx, dy)
    expected = [
        dblquad(lambda y, x, k=k: ((i * dx - x), (j * dy - y))[k] / ((i * dx - x) ** 2 + (j * dy - y) ** 2),
                -dx / 2, dx / 2, -dy / 2, dy / 2, epsabs=1e-12)[0]
        for k in (0, 1)
    ]  # fmt: skip
    np.testing.assert_allclose((along[i, j], across[i, j]), expected, atol=1e-12)


def test_tables_vanish_on_their_axes_and_fall_like_point_loads():
    along, across = coupling_tables(400, 300, 2e-6, 3e-6)
    assert not along[0].any() and not across[:, 0].any()
    x, y = 399 * 2e-6, 299 * 3e-6
    assert along[-1, -1] == pytest.approx(6e-12 * x / (x**2 + y**2), rel=1e-5)
    assert across[-1, -1] == pytest.approx(6e-12 * y / (x**2 + y**2), rel=1e-5)


def test_coupling_constant():
    """It vanishes without mismatch, changes sign with the bodies, and is Bentall & Johnson's κ = 2β in 1/Pa."""
    assert coupling_constant(HARD_STEEL, HARD_STEEL) == 0.0
    assert coupling_constant((1e9, 0.5), (80e9, 0.5)) == 0.0
    assert coupling_constant((1e9, 0.4), (3e9, 0.2)) == 0.0  # G/(1 − 2ν) alike
    k = coupling_constant(ALUMINIUM, HARD_STEEL)
    assert coupling_constant(HARD_STEEL, ALUMINIUM) == -k
    mismatch = rolling_cylinders.material_mismatch(*ALUMINIUM, *HARD_STEEL)
    compliance = ShearCompliance.of(ALUMINIUM, HARD_STEEL).along
    assert 4.0 * math.pi * k / compliance == pytest.approx(mismatch, rel=1e-14)
    lower, upper = (Material(2.0 * g * (1.0 + nu), nu) for g, nu in (ALUMINIUM, HARD_STEEL))
    derived = DerivedQuantities(Problem(lower, upper, spheres(0.02), 10.0, Friction(0.3), Motion(1.0)))
    assert derived.dundurs_beta == pytest.approx(0.5 * mismatch, rel=1e-14)


def axisymmetric(n: int) -> tuple[Grid, np.ndarray, np.ndarray, np.ndarray]:
    grid = Grid.over((n, n), 2.2, 2.2)
    x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
    return grid, x, y, np.hypot(x, y)


def test_hertz_pressure_draws_the_surface_inwards():
    """u_r = 2πK/r ∫_0^r p r' dr' for axisymmetric pressure; for p = sqrt(1 − r²): 2πK [1 − (1 − r²)^(3/2)]/(3r)."""
    constant, sizes, errors = 0.3, (24, 48, 96), []
    for n in sizes:
        grid, x, y, r = axisymmetric(n)
        edges = np.append(grid.x - 0.5 * grid.dx, grid.x[-1] + 0.5 * grid.dx)
        hertz = DerivedQuantities(contact_case("free_rolling", 16)).hertz
        pressure, _ = element_averages(hertz, edges * 4.013407e-4, edges * 4.013407e-4)
        pressure /= DerivedQuantities(contact_case("free_rolling", 16)).hertz.peak_pressure
        gradient = NormalShearCoupling(grid, Bodies(1.0, coupling_constant=constant)).tangential_gradient(pressure)
        inside = r < 0.8
        root = np.sqrt(1.0 - np.minimum(r, 0.99) ** 2)
        over_r = 2.0 * math.pi * constant * (1.0 - root**3) / (3.0 * r**2)  # u_r/r
        slope = 2.0 * math.pi * constant * root - 2.0 * over_r  # r d(u_r/r)/dr
        exact = np.stack([over_r + slope * (x / r) ** 2, slope * x * y / r**2])
        errors.append(np.abs(gradient - exact)[:, inside].max() / (2.0 * math.pi * constant))
    assert errors[-1] < 2e-3
    assert order(sizes, errors) > 1.4


def test_outward_shear_sinks_the_surface():
    """−u_z = −2πK ∫_r^1 τ dr' for radial tractions; for τ = r sqrt(1 − r²): −2πK (1 − r²)^(3/2)/3, as in Spence's equations."""
    constant, sizes, errors = 0.3, (24, 48, 96), []
    for n in sizes:
        grid, x, y, r = axisymmetric(n)
        root = np.sqrt(np.maximum(1.0 - r**2, 0.0))
        coupling = NormalShearCoupling(grid, Bodies(1.0, coupling_constant=constant))
        displacement = coupling.normal_displacement(np.stack([x * root, y * root]))
        errors.append(np.abs(displacement + 2.0 * math.pi * constant * root**3 / 3.0).max())
    assert errors[-1] < 2e-3
    assert order(sizes, errors) > 1.4


def test_both_directions_are_reciprocal():
    """Σ τ·∂u^p/∂x = −Σ p·(−u_z)(Dᵀτ): one kernel serves both, and D is the formula of the traction's own displacement."""
    random = np.random.default_rng(7)
    grid = Grid(14, 9, 1.0, 0.8)
    coupling = NormalShearCoupling(grid, Bodies(1.0, coupling_constant=0.4))
    pressure, traction = random.normal(size=(14, 9)), random.normal(size=(2, 14, 9))
    traction[:, :3] = traction[:, -3:] = 0.0
    transposed = sum(w * np.roll(traction, k, axis=1) for k, w in zip(DIFFERENCE_OFFSETS, UPSTREAM_WEIGHTS, strict=True))
    work = float((traction * coupling.tangential_gradient(pressure)).sum())
    assert work == pytest.approx(-float((pressure * coupling.normal_displacement(transposed)).sum()), rel=1e-12)


# --- limits with closed forms ------------------------------------------------------------------------------------


def quarter_matrix(table, parity, x, y, image):
    """Influence of loads mirrored at both axes, `image` = their signs on reflection in x and in y: (k, k), in elements."""
    total = np.zeros((x.size, x.size))
    for ex in (1, -1):
        for ey in (1, -1):
            i = np.rint(x[:, None] - ex * x).astype(int)
            j = np.rint(y[:, None] - ey * y).astype(int)
            sign = np.where(i < 0, parity[0], 1) * np.where(j < 0, parity[1], 1)
            total += image[0] ** (ex < 0) * image[1] ** (ey < 0) * sign * table[abs(i), abs(j)]
    return total


@pytest.mark.parametrize(("poisson_ratio", "stick_ratio"), [
    pytest.param(0.0, 0.5, marks=pytest.mark.slow), (0.25, 0.7)])
def test_spence_stick_circle(poisson_ratio, stick_ratio):
    """Indentation with friction does not roll, so the program cannot run it; but its kernels, in equations of their own, do:
    rigid flat punch (Spence's stick ratio is that of the sphere), u_t = 0 where it sticks, τ = μp where it slips."""
    m, shear = 24, 1.0
    rows, columns = np.nonzero(np.hypot(*np.meshgrid(np.arange(m) + 0.5, np.arange(m) + 0.5, indexing="ij")) < m)
    x, y = rows + 0.5, columns + 0.5
    bodies = (shear, poisson_ratio), (1e30 * shear, 0.3)
    modulus = 2.0 * shear / (1.0 - poisson_ratio)
    h = 1.0 / m
    xx, yy, xy = shear_tables(2 * m, 2 * m, h, h, ShearCompliance.of(*bodies))
    j_x, j_y = (coupling_constant(*bodies) * t for t in coupling_tables(2 * m, 2 * m, h, h))
    normal = quarter_matrix(normal_table(2 * m, 2 * m, h, h, modulus), (1, 1), x, y, (1, 1))
    along, across = (-1, 1), (1, -1)  # how τ_x and τ_y, and J_x and J_y, are reflected
    tangential = np.block([[quarter_matrix(xx, (1, 1), x, y, along), quarter_matrix(xy, (-1, -1), x, y, across)],
                           [quarter_matrix(xy, (-1, -1), x, y, along), quarter_matrix(yy, (1, 1), x, y, across)]])  # fmt: skip
    spread = np.vstack([quarter_matrix(j_x, along, x, y, (1, 1)), quarter_matrix(j_y, across, x, y, (1, 1))])
    normal_by_shear = np.hstack([quarter_matrix(j_x, along, x, y, along), quarter_matrix(j_y, across, x, y, across)])
    beta = (1.0 - 2.0 * poisson_ratio) / (2.0 * (1.0 - poisson_ratio))
    published = (beta, stick_ratio) == (0.5, 0.5)
    friction = spence.PUBLISHED_FRICTION if published else spence.spence_contact(stick_ratio, beta).friction

    # A p = 1 + N τ, and with it the displacement u = (A_t + J A⁻¹ N) τ + J A⁻¹ 1
    inverse = np.linalg.inv(normal)
    flat, bent = inverse.sum(axis=1), inverse @ normal_by_shear
    matrix, drive = tangential + spread @ bent, spread @ flat
    radial = np.concatenate([x, y]) / np.tile(np.hypot(x, y), 2)
    sign = -1.0  # the lower body is drawn inwards, and held back by −τ: τ points inwards
    stick = np.ones(x.size, dtype=bool)
    for _ in range(20):
        slips = np.tile(~stick, 2)
        system, right = matrix.copy(), -drive
        bound = friction * sign * radial
        system[slips] = (np.eye(2 * x.size) - bound[:, None] * np.tile(bent, (2, 1)))[slips]
        right[slips] = (bound * np.tile(flat, 2))[slips]
        traction = np.linalg.solve(system, right)
        pressure = flat + bent @ traction
        slip = -np.sum((radial * (matrix @ traction + drive)).reshape(2, -1), axis=0)
        new = np.where(stick, np.hypot(*traction.reshape(2, -1)) <= friction * pressure * (1.0 + 1e-9), sign * slip < 0.0)
        if np.array_equal(new, stick):
            break
        stick = new
    else:
        pytest.fail("no consistent stick area")
    found = math.sqrt(np.count_nonzero(stick) * h**2 / (math.pi / 4.0))
    assert found == pytest.approx(stick_ratio, rel=0.01)


class Cylinders:
    """Aluminium on steel, plane strain: one row of elements that are long across."""

    def __init__(self, n: int) -> None:
        compliance = ShearCompliance.of(ALUMINIUM, HARD_STEEL)
        self.contact = line_contact(20.0, 2.0 / compliance.along, 2e5)
        self.mismatch = rolling_cylinders.material_mismatch(*ALUMINIUM, *HARD_STEEL)
        a = self.contact.half_width
        self.scale = self.mismatch * a * self.contact.curvature  # κ a/R
        self.grid = grid = Grid(n, 1, 2.2 * a / n, 2000.0 * a)
        edge = np.clip(np.append(grid.x - 0.5 * grid.dx, grid.x[-1] + 0.5 * grid.dx) / a, -1.0, 1.0)
        self.covered = (np.diff(edge) * a / grid.dx)[:, None]
        area = 0.5 * (edge * np.sqrt(1.0 - edge**2) + np.arcsin(edge))
        self.pressure = (self.contact.peak_pressure * np.diff(area) * a / grid.dx)[:, None]
        coupling = NormalShearCoupling(grid, Bodies(1.0, coupling_constant=coupling_constant(ALUMINIUM, HARD_STEEL)))
        self.pressure_gradient = coupling.tangential_gradient(self.pressure)
        self._solver = RollingSolver(RollingGradient((n, 1), grid.dx, grid.dy, Bodies.of_shear(compliance)))

    def roll(self, creepage, friction):
        rigid = -self.pressure_gradient
        rigid[0] += creepage
        problem = TangentialProblem(friction * self.pressure, self.covered, rigid, self.grid.element_area)
        solution = self._solver.solve(problem, [(np.zeros_like(rigid), (0.0, 0.0))], 1e-8)
        assert solution.converged
        return solution, float(solution.traction[0].sum() / (friction * self.pressure.sum()))


def test_bentall_johnson_low_friction():
    """At ξ = 0.4574 κ a/R the force vanishes, and everywhere ṡ/V = ξ − κ a/(2R) sqrt(1 − x²/a²)."""
    cylinders = Cylinders(200)
    contact = cylinders.contact
    creepage = rolling_cylinders.free_rolling_creepage(cylinders.mismatch, contact.half_width, contact.curvature)
    solution, force = cylinders.roll(creepage, 1e-4)
    x = cylinders.grid.x
    exact = rolling_cylinders.low_friction_slip(x, creepage, cylinders.mismatch, contact.half_width, contact.curvature)
    inside = cylinders.covered[:, 0] == 1.0
    allowed = at_most("verification", "low friction, plane strain")
    np.testing.assert_allclose(solution.slip[0, inside, 0], exact[inside], rtol=0.0, atol=allowed * creepage)
    assert abs(force) < 0.02  # one element more or less of one sign


def test_complete_stick_in_free_rolling():
    """ξ = κ a/(πR): of the equation (1/π)⨍ τ/(x−x') dx' ~ ξ − κ a/(2R) sqrt(1 − x²/a²) the solution that begins at zero at
    the leading edge has no resultant then (Söhngen's inversion; tractions' effect on the pressure neglected)."""
    cylinders = Cylinders(100)
    friction = 3.0
    force = cylinders.roll(cylinders.scale / math.pi, friction)[1]
    at_rest = cylinders.roll(0.0, friction)[1]
    assert at_rest < 0.0
    assert abs(force) < 3e-3 * abs(at_rest)


@pytest.mark.slow
def test_slender_contact_rolls_freely_like_its_strips():
    """Little friction, contact long across: ξ = 2πK p0 0.5^(1/3), with half of the load on either side of the reversal."""
    lower, upper = (Material(2.0 * g * (1.0 + nu), nu) for g, nu in (ALUMINIUM, HARD_STEEL))
    errors = []
    for aspect in (0.1, 0.05, 0.02):
        motion = Motion(1.0, None, 0.0, 0.0, force_x=0.0, differential_slip=False)
        problem = on_grid(Problem(lower, upper, ellipse(aspect), 1000.0, Friction(1e-3), motion, MECHANICAL), 24)
        derived, result = DerivedQuantities(problem), solve(problem)
        assert result.converged
        strips = 2.0 * math.pi * derived.bodies.coupling_constant * derived.hertz.peak_pressure * 0.5 ** (1.0 / 3.0)
        errors.append(1.0 - result.coupled.scalars["creepage_longitudinal"] / strips)
    assert 0.0 < errors[2] < errors[1] < errors[0]
    assert errors[2] < 0.03


# --- against CONTACT ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sampled(CASES, 3))
def test_forces_are_those_of_contact(name):
    """Within what docs/verification.md says; the spin moment within its uncertainty."""
    result, problem = solved(name, 128), contact_case(name, 128)
    case = reference("contact_dissimilar")["cases"][name]
    assert result.converged
    for key in ("force_x_N", "force_y_N"):
        difference = abs(result.coupled.scalars[key] - case["extrapolated"][key])
        assert difference < at_most("verification", "forces of three cases") * problem.traction_limit
    moment = result.coupled.scalars["spin_moment_Nmm"] - case["extrapolated"]["spin_moment_Nmm"]
    assert abs(moment) < max(case["uncertainty"]["spin_moment_Nmm"], 1e-6)
    peak = result.coupled.scalars["pressure_max_MPa"]
    same = "largest pressure of the same"
    assert peak == pytest.approx(case["extrapolated"]["pressure_max_MPa"], rel=at_most("verification", same))
    # What shear does to the pressure is larger than all this.
    least, most = printed("verification", f"{same} (0.7 to 1.5 % above Hertz)")
    higher = 100.0 * (case["extrapolated"]["pressure_max_MPa"] / case["hertz_frictionless"]["p0_MPa"] - 1.0)
    assert least.value - least.rounding < higher < most.value + most.rounding
    assert result.of_problem["hertz_p0_MPa"] == pytest.approx(case["hertz_frictionless"]["p0_MPa"], rel=1e-9)


# --- bodies that are not different -------------------------------------------------------------------------------


@pytest.mark.parametrize("heating", sampled([Heating(peclet="stationary"), MECHANICAL]))
def test_equal_materials_given_twice(heating):
    """Nothing changes, and the plan says why."""
    once = on_grid(Problem(STEEL, STEEL, spheres(0.03), 65.0, Friction(0.3), Motion(200.0, 0.003, 0.0005, 1.0), heating), 12)
    twice = replace(once, upper=Material(210e9, 0.28, 50.2, 11.7e-6, 10e-6))
    first, second = solve(once), solve(twice)
    assert "same elastic constants" in make_plan(twice).skipped["elastic coupling"]
    assert make_plan(once).run == make_plan(twice).run
    for name, field in first.coupled.fields.items():
        np.testing.assert_allclose(second.coupled.fields[name], field, rtol=1e-10)
    assert second.coupled.scalars == pytest.approx(first.coupled.scalars, rel=1e-10, nan_ok=True)


@pytest.mark.parametrize("upper", [Material(2.0 * 3e9 * 1.2, 0.2), Material(210e9, 0.5)])
def test_materials_without_mismatch_are_not_coupled(upper):
    lower = Material(2.0 * 1e9 * 1.4, 0.4) if upper.poisson_ratio == 0.2 else Material(5e6, 0.5)
    motion = Motion(1.0, 0.004, differential_slip=False)
    problem = on_grid(Problem(lower, upper, spheres(0.02), 50.0, Friction(0.3), motion, MECHANICAL), 16)
    plan, result = make_plan(problem), solve(problem)
    assert "elastic coupling" not in plan.run and "Dundurs" in plan.skipped["elastic coupling"]
    assert result.converged and result.coupled.scalars["gamma_p"] == pytest.approx(1.0, abs=1e-12)
    still = make_plan(replace(problem, motion=Motion(1.0, differential_slip=False)))
    assert "tangential" in still.skipped


def test_without_friction_the_pressure_is_hertz():
    problem = replace(contact_case("free_rolling", 32), friction=Friction(0.0))
    plan, result = make_plan(problem), solve(problem)
    assert "no friction" in plan.skipped["elastic coupling"]
    discretisation = Discretisation(DerivedQuantities(problem), (32, 32), 2.2)
    np.testing.assert_array_equal(result.coupled.fields["pressure"], discretisation.isothermal_pressure.pressure)
    assert result.coupled.scalars["gamma_p"] == 1.0
    # and the surfaces slide past each other although there is no creepage
    assert result.coupled.fields["slip_x"].min() < -0.5 * 2.0 * math.pi * DerivedQuantities(problem).dundurs_beta * 1e-3


# --- what must hold for every state ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sampled(CASES, 3))
def test_bodies_that_change_places(name):
    """Tractions and slip change their signs with all creepages; pressures, heat and areas stay."""
    first, second = solved(name, 16), solve(turned(contact_case(name, 16)))
    for field in ("pressure", "gap", "heat_flux", "displacement_elastic"):
        expected = first.coupled.fields[field]
        np.testing.assert_allclose(second.coupled.fields[field], expected, atol=1e-9 * np.abs(expected).max())
    for field in ("shear_x", "shear_y", "slip_x", "slip_y"):
        expected = first.coupled.fields[field]
        np.testing.assert_allclose(second.coupled.fields[field], -expected, atol=1e-9 * np.abs(expected).max())


def test_mirrored_in_the_rolling_direction():
    problem = contact_case("alu_ceramic_mixed", 16)
    m = problem.motion
    mirrored = solve(replace(problem, motion=replace(m, creepage_y=-m.creepage_y, spin=-m.spin))).coupled.fields
    fields = solved("alu_ceramic_mixed", 16).coupled.fields
    for name, sign in (("pressure", 1), ("shear_x", 1), ("shear_y", -1), ("gap", 1)):
        scale = np.abs(fields[name]).max()
        np.testing.assert_allclose(mirrored[name][:, ::-1], sign * fields[name], atol=2e-3 * scale)


@pytest.mark.parametrize("name", CASES)
def test_rolling_moment_pays_for_the_heat(name):
    """Q_F/V = ξ·F − κ_x ∬ x p: pressure that leans against the rolling direction does work, too (p ⊥ u_z^e + u_z^τ)."""
    result, problem = solved(name, 128), contact_case(name, 128)
    s, m = result.coupled.scalars, problem.motion
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    lean = float((result.x[:, None] * result.coupled.fields["pressure"]).sum()) * area * problem.geometry.curvature_x
    creep = m.creepage_x * s["force_x_N"] + m.creepage_y * s["force_y_N"] + m.spin * s["spin_moment_Nmm"] * 1e-3
    assert s["Q_F_W"] / m.speed == pytest.approx(creep - lean, rel=0.04)
    assert s["Q_F_W"] > 0.0


def test_gap_is_made_of_its_parts():
    """h = h_i + u_z^e − δ, where u_z^e contains what the tractions do."""
    result, problem = solved("free_rolling", 32), contact_case("free_rolling", 32)
    fields = result.coupled.fields
    shape = DerivedQuantities(problem).hertz.undeformed_gap(result.x[:, None], result.y[None, :])
    apart = shape + fields["displacement_elastic"]
    outside = fields["pressure"] == 0.0
    np.testing.assert_allclose((apart - apart[16, 16])[outside], fields["gap"][outside],
                               atol=1e-4 * DerivedQuantities(problem).hertz.approach)  # fmt: skip


def test_prescribed_force():
    problem = contact_case("free_rolling", 24)
    free = replace(problem, motion=Motion(1.0, None, 0.0, 0.0, force_x=0.0))
    found = solve(free)
    assert found.converged
    assert abs(found.coupled.scalars["force_x_N"]) < 1e-5 * problem.traction_limit
    creepage = found.coupled.scalars["creepage_longitudinal"]
    assert creepage > 0.0  # the softer body creeps ahead
    back = solve(replace(problem, motion=Motion(1.0, creepage)))
    assert abs(back.coupled.scalars["force_x_N"]) < 1e-3 * problem.traction_limit


def test_strong_coupling():
    """β = ½, μ = 1: nothing worse exists among half-spaces."""
    soft, rigid = Material(1e9, 0.0), Material(1e15, 0.3)
    problem = on_grid(Problem(soft, rigid, ellipse(3.0), 50.0, Friction(1.0), Motion(1.0, 0.002, 0.01), MECHANICAL), 16, 2.75)
    result = solve(problem)
    assert DerivedQuantities(problem).dundurs_beta == pytest.approx(0.5, abs=1e-5)
    assert result.converged
    assert abs(result.coupled.scalars["gamma_p"] - 1.0) > 0.05


def test_sweeps_start_from_their_neighbour_but_never_from_other_bodies():
    solver = Solver()
    problem = contact_case("polymer_lower", 16)
    solver.solve(problem)
    neighbour = replace(problem, motion=Motion(1.0, 0.0042))
    warm, cold = solver.solve(neighbour), solve(neighbour)
    limit = problem.traction_limit
    assert warm.coupled.scalars["force_x_N"] == pytest.approx(cold.coupled.scalars["force_x_N"], abs=1e-4 * limit)
    other = turned(neighbour)
    discretisation = Discretisation(DerivedQuantities(problem), (16, 16), 2.2)
    assert discretisation.has_kernels_of(DerivedQuantities(neighbour))
    assert not discretisation.has_kernels_of(DerivedQuantities(other))
    force = solver.solve(other).coupled.scalars["force_x_N"]
    assert force == pytest.approx(-cold.coupled.scalars["force_x_N"], abs=1e-4 * limit)


# --- with heat ---------------------------------------------------------------------------------------------------


def hot(lower: Material, upper: Material, creepage: float, speed: float = 100.0, peclet: str = "stationary") -> Problem:
    heating = Heating(peclet=peclet)  # type: ignore[arg-type]
    return on_grid(Problem(lower, upper, spheres(0.03), 65.0, Friction(0.3), Motion(speed, creepage), heating), 16)


@pytest.mark.slow
def test_heat_and_shear_share_one_fixed_point():
    result, other = solve(hot(STEEL, CERAMIC, 0.003)), solve(hot(CERAMIC, STEEL, -0.003))
    assert result.converged and other.converged
    s, t = result.coupled.scalars, other.coupled.scalars
    assert s["gamma_p"] > result.isothermal.scalars["gamma_p"] > 1.0
    assert s["temperature_rise_max_lower_K"] == pytest.approx(t["temperature_rise_max_upper_K"], rel=1e-6)
    assert s["force_x_N"] == pytest.approx(-t["force_x_N"], rel=1e-6)
    assert result.residuals["coupling_residual"][-1] <= Tolerances().coupling
    assert result.residuals["elastic_coupling_residual"].size


def test_tangential_expansion_estimate():
    """Against 2(1+ν)α κ/s ∇(T − T_0) under a Hertz-shaped heat flux: never below the true maximum, nor 2.5 times above."""
    n, half = 48, 1.2
    grid = Grid.over((n, n), 2.0 * half, 2.0 * half)
    x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
    flux = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    inside = x**2 + y**2 < 0.9
    from thermoroll_cli.physics.numerics.convolution import Convolution

    convolution = Convolution(n, n)

    def temperature(peclet):
        spectrum = convolution.spectrum(temperature_table(n, n, 1.0, peclet * grid.dx))
        return grid.dx * convolution.inverse(convolution.forward(flux) * spectrum)

    hertz_a = DerivedQuantities(hot(STEEL, CERAMIC, 0.003)).hertz.semi_axis_x
    for peclet in (0.5, 5.0, 50.0, 500.0):
        moving, at_rest = temperature(peclet), temperature(0.0)
        exact = max(float(np.abs(g[inside]).max()) for g in np.gradient(2.0 / peclet * (moving - at_rest), grid.dx))
        # one body with (1+ν)α = 1 and the wanted V a0/κ, the other without expansion
        warm = Material(210e9, 0.25, 1.0, 0.8, hertz_a / peclet)
        bodies = replace(warm, youngs_modulus=210e9), replace(CERAMIC, expansion=0.0)
        derived = DerivedQuantities(hot(*bodies, 0.003, 1.0, "rolling"))
        scale = derived.peclet(derived.problem.lower) / peclet
        assert scale == pytest.approx(1.0, rel=0.05)
        estimate = tangential_expansion(derived, moving, moving)
        assert exact <= estimate <= 2.5 * exact


@pytest.mark.slow
def test_tangential_expansion_is_told_where_it_matters():
    def told(problem):
        return any("stretch along each other" in w for w in solve(problem).warnings)

    assert told(hot(STEEL, CERAMIC, 0.003))
    assert not told(hot(STEEL, STEEL, 0.003))
    assert not told(hot(POLYMER, STEEL, 0.03, 1.0, "rolling"))

"""Bodies with bonded layers: indentation and rolling against independent solutions, limits, coupling, files."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support import command_line
from tests.support.cases import findings, parse
from tests.support.sampling import sampled
from tests.support.scenes import MECHANICAL, reference
from tests.support.strips import solve_cell
from thermoroll_cli.exact.hertz import HertzContact, element_averages, hertz_contact, shear_gradients
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.contact.shear_coupling import NormalShearCoupling
from thermoroll_cli.physics.halfspace.bodies import bodies_of
from thermoroll_cli.physics.halfspace.coatings import Coatings
from thermoroll_cli.physics.numerics.grid import Grid, Prolongation
from thermoroll_cli.physics.rolling.element_borders import known_gradient
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.contact import Traction
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Layer, Material, Motion, Numerics, Problem
from thermoroll_cli.python_api import solve

INDENTATION, ROLLING = reference("layered_indentation")["rows"], reference("layered_rolling")["linear"]
STEEL, RIGID = Material(210e9, 0.3), Material(1e25, 0.0)
TOLERANCE = SolverOptions().tolerances.normal
POLYMER_LAYER = Layer(1e-4, 3e9, 0.4)
ROLLS = Motion(1.0, 0.0, 0.0, differential_slip=False)


def pressed(body: Material, other: Material, radius: float, force: float, *, friction: float = 0.0) -> Problem:
    return Problem(body, other, Geometry(radius, radius, math.inf, math.inf), force, Friction(friction), ROLLS, MECHANICAL)


def of_radius(problem: Problem, radius: float, elements: int) -> Problem:
    """`problem` under the load that makes its contact as large as a circle of `radius`."""
    for _ in range(12):
        pressure = Discretisation(DerivedQuantities(problem), (elements, elements), 2.2)
        larger = math.pi * radius**2 / (float(pressure.isothermal_pressure.covered.sum()) * pressure.grid.element_area)
        if abs(larger - 1.0) < 1e-4:
            return problem
        problem = replace(problem, normal_force=problem.normal_force * larger**1.3)
    raise AssertionError(f"the contact is {larger:g} times as large as asked for")


@pytest.mark.parametrize("row", sampled(INDENTATION[::3], 3),
                         ids=lambda row: f"{row['E_layer_over_E_substrate']}-{row['a_over_h']}")
def test_indentation_agrees_with_an_integral_equation(row: dict) -> None:
    """Below stiff layers the largest pressure is not that of the middle, which the reference gives."""
    h, radius, modulus = 1e-4, 0.1, 1e9
    a, contact_modulus = row["a_over_h"] * h, modulus / (1.0 - row["nu_layer"] ** 2)
    force = 4.0 * contact_modulus * (a / row["a_over_a_hertz"]) ** 3 / (3.0 * radius)
    layer = Layer(h, modulus, row["nu_layer"])
    body = Material(modulus / row["E_layer_over_E_substrate"], row["nu_substrate"], layers=(layer,))
    derived = DerivedQuantities(pressed(body, RIGID, radius, force))
    discretisation = Discretisation(derived, (64, 64), 2.2)
    found, hertz = discretisation.isothermal_pressure, hertz_contact(1.0 / radius, 1.0 / radius, contact_modulus, force)
    assert found.approach == pytest.approx(row["approach_over_hertz"] * hertz.approach, rel=1.5e-4)
    middle = 1.125 * found.pressure[32, 32] - 0.125 * found.pressure[33, 33]
    assert middle == pytest.approx(row["p0_over_p0_hertz"] * hertz.peak_pressure, rel=2e-3)
    assert found.peak > (1.0 - 1e-3) * middle
    area = float(found.covered.sum()) * discretisation.grid.element_area
    assert area == pytest.approx(math.pi * a**2, rel=2e-3 if h > 8.0 * discretisation.grid.dx else 2e-2)


@pytest.mark.slow
@pytest.mark.parametrize("row", ROLLING[:5:4], ids=lambda row: str(row["substrate"]["youngs_modulus"]))
def test_creep_coefficients_without_slip(row: dict) -> None:
    layer = Layer(**row["layers"][0])
    body = Material(row["substrate"]["youngs_modulus"], row["substrate"]["poisson_ratio"], layers=(layer,))
    problem = of_radius(pressed(body, body, 200.0, 0.01, friction=1e3), 1.0, 64)
    shear_modulus, creepage = 0.5 * layer.youngs_modulus / (1.0 + layer.poisson_ratio), 1e-3
    for axis, name in enumerate(("c11", "c22")):
        motion = replace(ROLLS, creepage_x=(creepage, 0.0)[axis], creepage_y=(0.0, creepage)[axis])
        discretisation = Discretisation(DerivedQuantities(replace(problem, motion=motion)), (64, 64), 2.2)
        rolled = discretisation.roll(discretisation.isothermal_pressure, Traction.unknown((64, 64)), 1e-6)
        assert rolled.converged
        force = float(rolled.traction[axis].sum()) * discretisation.grid.element_area
        assert force == pytest.approx(shear_modulus * creepage * row[name], rel=4e-3)


def stuck(
    row: dict, hertz: HertzContact, shape: tuple[int, int], dx: float, dy: float, unit: tuple[float, float, float]
) -> np.ndarray:
    """F_x, F_y and M_z per creepage, over the layer's shear modulus, of a contact of the shape of `hertz` between bodies coated
    alike, which sticks as a whole at the creepages and spin `unit`."""
    body = Material(row["substrate"]["youngs_modulus"], row["substrate"]["poisson_ratio"], layers=(Layer(**row["layers"][0]),))
    bodies = bodies_of(body, body, 1.0)
    x, y = ((np.arange(n + 1) - 0.5 * n) * size for n, size in zip(shape, (dx, dy), strict=True))
    pressure, covered = element_averages(hertz, x, y)
    x, y = np.broadcast_arrays(0.5 * (x[1:] + x[:-1])[:, None], 0.5 * (y[1:] + y[:-1]))
    border = bodies.near_border(dx, dy)
    along, across, mixed = shear_gradients(hertz, border.shear.isotropic, border.shear.directional)
    leading = known_gradient(pressure, RollingGradient(shape, dx, dy, border).of_shape(pressure),
                             np.stack([along * x, across * x, mixed * y]), covered)
    rigid = 1e-3 * np.stack([unit[0] - unit[2] * y, unit[1] + unit[2] * x])
    cell = TangentialProblem(1e4 * pressure, covered, rigid, dx * dy, leading=leading)
    solution = solve_cell(RollingGradient(shape, dx, dy, bodies), cell, 1e-8)
    assert solution.converged and solution.stick[covered > 0.0].all()
    tx, ty = solution.traction / (1e-3 * body.surface.shear_modulus) * dx * dy
    return np.array([tx.sum(), ty.sum(), (x * ty - y * tx).sum()])


def creep_coefficients(row: dict, n: int) -> dict[str, float]:
    a, b = row["a"], row["b"]
    place = HertzContact(a, b, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0), (n, n), 2.2 * a / n, 2.2 * b / n
    x, y, spin = (stuck(row, *place, unit) for unit in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    return {"c11": x[0] / (a * b), "c22": y[1] / (a * b), "c23": y[2] / (a * b) ** 1.5, "c33": spin[2] / (a * b) ** 2}


@pytest.mark.slow
@pytest.mark.parametrize("row", ROLLING[::8], ids=lambda row: f"{row['substrate']['youngs_modulus']}-{row['b']}")
def test_all_creep_coefficients_of_ellipses(row: dict) -> None:
    """Layers are 3 elements thick at least."""
    for name, found in creep_coefficients(row, 64).items():
        assert found == pytest.approx(row[name], rel=2.5e-3), name


@pytest.mark.slow
def test_creep_coefficients_converge_at_second_order() -> None:
    coarse, fine = (creep_coefficients(ROLLING[2], n) for n in (32, 64))
    for name in ("c11", "c22", "c33"):
        errors = [found[name] / ROLLING[2][name] - 1.0 for found in (coarse, fine)]
        assert math.log2(errors[0] / errors[1]) > 1.8, name
        assert (4.0 * fine[name] - coarse[name]) / 3.0 == pytest.approx(ROLLING[2][name], rel=1e-3)


@pytest.mark.parametrize("row", reference("layered_rolling")["line"], ids=lambda row: str(row["substrate"]["youngs_modulus"]))
def test_long_strips_roll_as_in_plane_strain(row: dict) -> None:
    """One row of elements, each 150 half-widths long on either side of the middle."""
    a, n = row["half_width"], 128
    hertz = HertzContact(a, 1e4 * a, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0)
    shear_modulus = 0.5 * row["layers"][0]["youngs_modulus"] / (1.0 + row["layers"][0]["poisson_ratio"])
    for axis, name in enumerate(("force_x_per_width_over_xi", "force_y_per_width_over_xi")):
        force = stuck(row, hertz, (n, 1), 2.2 * a / n, 300.0 * a, (1.0 - axis, axis, 0.0))[axis]
        assert shear_modulus * force / (300.0 * a) == pytest.approx(row[name], rel=1e-3)


@pytest.mark.parametrize("row", sampled(reference("layered_rolling")["winkler"][1:6:2], 3), ids=lambda row: str(row["t"]))
def test_thin_soft_layers_are_winkler_foundations(row: dict) -> None:
    """Closed form for layers that are thin beside the contact and stick to something rigid; here h/a = 0.01."""
    h, a, radius, friction, layer = 1e-4, 1e-2, 5.0, 0.3, Layer(1e-4, 1e7, 0.3)
    shear_modulus = layer.youngs_modulus / (2.0 * (1.0 + layer.poisson_ratio))
    # Both layers are compressed by half the overlap a²/2R, without room to move sideways.
    oedometric = 2.0 * shear_modulus * (1.0 - layer.poisson_ratio) / (1.0 - 2.0 * layer.poisson_ratio)
    peak = oedometric * a**2 / (4.0 * h * radius)
    creepage = row["t"] * 2.0 * friction * peak * (2.0 * h / shear_modulus) / a
    body = replace(STEEL, layers=(layer,))
    problem = replace(pressed(body, body, radius, 0.5 * math.pi * a**2 * peak, friction=friction),
                      motion=replace(ROLLS, creepage_x=creepage), numerics=Numerics(grid=(64, 64)))
    result = solve(problem)
    assert result.converged
    scalars = result.coupled.scalars
    assert scalars["force_x_N"] / problem.traction_limit == pytest.approx(row["force_over_muW"], abs=6e-3)
    assert scalars["gamma_st"] == pytest.approx(row["stick_share"], abs=0.03)


@pytest.mark.parametrize(("thickness", "alike"), [(1e-13, STEEL), (1e5, Material(50e9, 0.2))])
def test_thin_and_thick_layers_are_half_spaces(thickness: float, alike: Material) -> None:
    body = Material(210e9, 0.3, layers=(Layer(thickness, 50e9, 0.2),))
    grid, load = Grid.over((24, 24), 2.4e-3, 2.4e-3), 500.0
    gap = (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) / 0.04
    pairs = [bodies_of(lower, STEEL, 1.0) for lower in (body, alike)]
    assert [bodies.dispersive for bodies in pairs] == [True, False]
    solvers = [NormalSolver(grid, bodies) for bodies in pairs]
    found, expected = (s.refine(s.solve(gap, load, np.zeros(grid.shape)), gap, load) for s in solvers)
    assert np.abs(found.pressure - expected.pressure).max() < 1e-6 * expected.pressure.max()
    assert found.approach == pytest.approx(expected.approach, rel=1e-6)
    place = (24, 24, grid.dx, grid.dy)
    for one, other in zip(*(bodies.shear_tables(*place) for bodies in pairs), strict=True):
        assert np.abs(one.quadrant - other.quadrant).max() < 1e-6 * pairs[1].shear_tables(*place)[0].quadrant.max()
    traction = np.random.default_rng(3).standard_normal((2, 24, 24))
    one, other = (NormalShearCoupling(grid, bodies).normal_displacement(traction) for bodies in pairs)
    assert np.abs(one - other).max() < 1e-6 * max(np.abs(other).max(), 1e-11 * grid.dx)


def test_layers_of_the_same_material_change_nothing() -> None:
    plain = pressed(STEEL, STEEL, 0.02, 500.0, friction=0.3)
    same = replace(plain, lower=replace(STEEL, layers=(Layer(1e-5, 210e9, 0.3), Layer(1e-4, 210e9, 0.3))))
    assert DerivedQuantities(same).hertz == DerivedQuantities(plain).hertz is not None
    whole = Coatings.of(Material(210e9, 0.3, layers=(Layer(3e-4, 50e9, 0.2),)), STEEL)
    split = Coatings.of(Material(210e9, 0.3, layers=(Layer(1e-4, 50e9, 0.2), Layer(2e-4, 50e9, 0.2))), STEEL)
    assert whole is not None and split is not None
    one, other = (c.normal_table(16, 16, 1e-4, 1e-4) for c in (whole, split))
    assert np.abs(one - other).max() < 1e-10 * np.abs(one).max()


def test_symbols_are_those_of_the_tables() -> None:
    """Of decaying kernels: what a wave of tractions moves, in the middle of a large plane."""
    body = Material(210e9, 0.3, layers=(Layer(2e-4, 50e9, 0.2),))
    bodies, n, dx, dy = bodies_of(body, body, 1.0), 256, 1e-4, 1.3e-4
    xx, yy, xy = (table.quadrant for table in bodies.shear_tables(n, n, dx, dy))
    symbols = bodies.shear_symbols((2 * n, 2 * n), dx, dy)
    i, j = 60, 45
    theta = np.pi * np.arange(n)[:, None] * i / n, np.pi * np.arange(n)[None, :] * j / n
    window = np.outer(*(0.5 + 0.5 * np.cos(np.pi * np.arange(n) / n),) * 2)
    twice = np.where(np.arange(n) > 0, 2.0, 1.0)
    for table, symbol, odd in ((xx, symbols[0], False), (yy, symbols[1], False), (xy, symbols[2], True)):
        waves = -np.sin(theta[0]) * np.sin(theta[1]) if odd else np.cos(theta[0]) * np.cos(theta[1])
        found = float((table * window * waves * np.outer(twice, twice)).sum())
        assert found == pytest.approx(float(symbol[j, i]), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "a_over_h", "aspect"), [
    (0.01, 3.0, 1.0), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((100.0, 0.2, 1.0), (100.0, 20.0, 5.0)))])
def test_layers_do_not_make_the_normal_problem_hard(ratio: float, a_over_h: float, aspect: float) -> None:
    """From nothing on the coarser grid and from its solution on the finer one; without layers from a Hertz pressure."""
    body = Material(100e9, 0.3, layers=(Layer(1e-4, ratio * 100e9, 0.3),))
    place = Geometry(0.1, 0.1 * aspect, math.inf, math.inf)
    layered = of_radius(replace(pressed(body, RIGID, 0.1, 100.0), geometry=place), a_over_h * 1e-4, 32)
    plain = replace(pressed(Material(100e9, 0.3), RIGID, 0.1, 100.0), geometry=place)
    applications = []
    for problem in (layered, plain):
        before = Discretisation(DerivedQuantities(problem), (32, 32), 2.2)
        coarse, fine = before.pressure, Discretisation(before.derived, (64, 64), 2.2, coarser=before).pressure
        if DerivedQuantities(problem).hertz is not None:
            whole = coarse.solve(None, np.zeros((32, 32)), TOLERANCE, mirrored=True)
            found = fine.solve(None, np.asarray(Prolongation(coarse.grid, fine.grid)(whole.start)), TOLERANCE, mirrored=True)
        else:
            assert coarse.isothermal.converged
            found = fine.isothermal
        assert found.converged
        applications.append((coarse.solver.applications, fine.solver.applications))
    (layered_coarse, layered_fine), (plain_coarse, plain_fine) = applications
    assert layered_fine <= 1.5 * plain_fine
    assert layered_coarse <= (1.5 if ratio > 1.0 else 2.5) * plain_coarse


@pytest.mark.slow
@pytest.mark.parametrize("a_over_h", [5.0, 20.0])
def test_pressures_below_stiff_layers_are_solved_as_far_as_others(a_over_h: float) -> None:
    body = Material(100e9, 0.3, layers=(Layer(1e-4, 1e13, 0.3),))
    problem = of_radius(pressed(body, RIGID, 0.1, 100.0), a_over_h * 1e-4, 32)
    pressure = Discretisation(DerivedQuantities(problem), (64, 64), 2.2).pressure
    found = pressure.isothermal.whole_elements
    exact = pressure.solver.solve(pressure.undeformed_gap, problem.normal_force, found, 1e-11)
    assert exact.converged and np.array_equal(exact.contact, found > 0.0)
    assert np.abs(found - exact.pressure).max() < 3e-5 * exact.pressure.max()


def test_the_preconditioner_below_stiff_layers_is_symmetric_and_positive() -> None:
    body, grid = Material(1e9, 0.5, layers=(Layer(2e-5, 1e11, 0.3),)), Grid.over((26, 39), 1e-3, 4e-3)
    solver = NormalSolver(grid, bodies_of(body, STEEL, 1.0))
    assert solver.below_stiff_layers
    contact = (grid.x[:, None] / 4e-4) ** 2 + (grid.y / 1.7e-3) ** 2 < 1.0
    one, other = np.random.default_rng(1).standard_normal((2, *grid.shape)) * contact
    one, other = (field - contact * field.sum() / contact.sum() for field in (one, other))
    inverse = solver.preconditioner(contact)
    assert np.vdot(one, inverse(other)) == pytest.approx(np.vdot(inverse(one), other), rel=1e-9)
    assert np.vdot(one, inverse(one)) > 0.0


@pytest.mark.slow
def test_free_rolling_creeps_the_other_way_on_thin_layers() -> None:
    """3 GPa on steel: with thickness the creepage of a body that drives nothing changes its sign."""
    found = []
    for ratio in (0.05, 5.0):
        body = Material(210e9, 0.3, layers=(POLYMER_LAYER,))
        problem = of_radius(pressed(body, STEEL, 0.02, 20.0 * ratio**2, friction=0.5), ratio * POLYMER_LAYER.thickness, 32)
        motion = Motion(1.0, None, 0.0, force_x=0.0, differential_slip=False)
        result = solve(replace(problem, motion=motion, numerics=Numerics(grid=(32, 32))))
        assert result.converged
        found.append(result.coupled.scalars["creepage_longitudinal"])
    assert found[0] * found[1] < 0.0


def test_incompressible_surfaces_over_other_bodies_couple() -> None:
    """Dundurs' constant of the surfaces is zero, that of the bodies is not."""
    top = Layer(1e-4, 1e9, 0.5)
    problem = pressed(Material(210e9, 0.3, layers=(top,)), Material(1e9, 0.5), 0.02, 10.0, friction=0.3)
    derived = DerivedQuantities(problem)
    assert derived.bodies.coupling_constant == 0.0 and derived.dissimilar
    assert not DerivedQuantities(replace(problem, upper=problem.lower)).dissimilar


# --- files -------------------------------------------------------------------------------------------------------

CASE = command_line.MECHANICAL.replace("[geometry]", """\
[[material.layers]]
thickness_um = 2.0
youngs_modulus_GPa = 250.0
poisson_ratio = 0.2
[geometry]""")


def test_layers_of_a_case() -> None:
    case = parse(CASE, "material.layers.0.thickness_um=3")
    assert case.problem.lower.layers == case.problem.upper.layers == (Layer(3e-6, 250e9, 0.2),)
    assert parse(case.to_toml()) == case
    plan = make_plan(case.problem)
    assert "normal (isothermal)" in plan.run and "hertz_a_mm" not in plan.facts and plan.warnings == []


def test_at_most_five_layers() -> None:
    layer = CASE[CASE.index("[[") : CASE.index("[geometry]")]
    different = "".join(layer.replace("250.0", f"{250 + number}.0") for number in range(5))
    assert len(parse(CASE.replace(layer, different)).problem.lower.layers) == 5
    (found,) = findings(CASE.replace(layer, 6 * layer))
    assert "too many" in str(found)


def test_doubtful_layers_are_warned_of() -> None:
    thick = make_plan(parse(CASE, "material.layers.0.thickness_um=4000", "material.layers.0.youngs_modulus_GPa=100").problem)
    assert any("smallest radius thick" in warning for warning in thick.warnings)
    stiff = make_plan(parse(CASE.replace("210.0", "3.0"), "load.normal_N=0.01").problem)
    assert any("times stiffer" in warning for warning in stiff.warnings)

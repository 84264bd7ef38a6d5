"""Line contacts of bodies that are coated or relax: kernels of strips, Hunter's exact solution, limits of thin and thick
layers, and the middle of a slender contact."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from tests.support.documents import at_most
from tests.support.problems import MECHANICAL, elastic
from thermoroll_cli.exact.hunter import hunter
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.halfspace.coatings import Coatings
from thermoroll_cli.physics.halfspace.layered import LayeredBody
from thermoroll_cli.physics.halfspace.layered_stress import element_stresses
from thermoroll_cli.physics.halfspace.layered_thermal import LayeredHeat
from thermoroll_cli.physics.halfspace.relaxing import Relaxing
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Numerics, Problem, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.arrays import Array

DX, COUNT = 0.1, 9
STEEL = Material(206e9, 0.28, 46.6, 11.7e-6, 12.5e-6)
SOFT = elastic(0.3, 3e9)


def layer(thickness: float, modulus: float = 800e9) -> Layer:
    return Layer(thickness, modulus, 0.28, 2.0, 2e-5, 1e-6)


def coated(*layers: Layer) -> Material:
    return replace(STEEL, layers=layers)


STACK = coated(layer(0.3), layer(0.2, 50e9))


@pytest.mark.parametrize(("name", "which"), [("normal_table", 0), ("shear_tables", 0), ("shear_tables", 1),
                                             ("coupling_tables", 0)])
def test_kernels_of_coated_strips_are_those_of_long_rectangles(name: str, which: int) -> None:
    """Up to a constant, but for the coupling."""
    table = getattr(Coatings(STACK, SOFT), name)
    strip, long = (np.reshape(table(COUNT, 1, DX, dy), (-1, COUNT))[which] for dy in (math.inf, 3e3))
    if name != "coupling_tables":
        assert strip[-1] == 0.0
        long = long - long[-1]
    np.testing.assert_allclose(strip, long, atol=5e-4 * np.abs(long).max())


@pytest.mark.parametrize("depth", [0.0, 0.2, 0.4, 0.9])
def test_stresses_below_coated_strips(depth: float) -> None:
    body = LayeredBody.of(STACK)
    loads = (element_stresses(body, (4, columns), DX, dy, depth) for columns, dy in ((1, math.inf), (150, 0.4)))
    for strip, columns in zip(*loads, strict=True):
        long = columns[:, :, 0] + 2.0 * columns[:, :, 1:].sum(axis=2)
        there = strip.any(axis=(1, 2))
        assert there.sum() == (2 if there[3] else 4)
        np.testing.assert_allclose(strip[there, :, 0], long[there], atol=1e-3)


@pytest.mark.parametrize("quantity", ["temperature", "interface", "expansion"])
def test_heat_on_coated_strips(quantity: str) -> None:
    strip, long = (LayeredHeat(coated(layer(0.3))).table(quantity, (4, columns), (DX, dy), (3e-5, 0.0)).sum(axis=1)
                   for columns, dy in ((1, math.inf), (60, 1.0)))
    np.testing.assert_allclose(np.diff(strip), np.diff(long), atol=1e-4 * np.ptp(strip))


def memory_of(response: float, body: Material, speed: float) -> Array:
    """Exponential means of a strip's logarithm (`response` 0) or ramp (1), by quadrature."""
    def instantaneous(x: float) -> float:
        if response:
            return 2.0 * math.pi * min(max(x, -0.5 * DX), 0.5 * DX)
        ends = [end * math.log(abs(end)) if end else 0.0 for end in (x + 0.5 * DX, x - 0.5 * DX)]
        return -2.0 * (ends[0] - ends[1])

    def mean(x: float, length: float) -> float:
        edges = [edge for edge in (x + 0.5 * DX, x - 0.5 * DX) if 0.0 < edge < 60.0 * length]
        return quad(lambda s: math.exp(-s / length) * instantaneous(x - s) / length, 0.0, 60.0 * length,
                    points=edges or None, limit=400, epsabs=1e-11)[0]

    return np.array([sum(c * mean(x * DX, time * speed) for c, time in body.retardation) for x in range(1 - COUNT, COUNT)])


def test_kernels_of_strips_that_relax() -> None:
    body = replace(SOFT, relaxation=((0.5, 0.2), (0.3, 0.01)))
    bodies = Relaxing(body, STEEL, 1.0)
    normal, wanted = bodies.normal_table(COUNT, 1, DX, math.inf)[:, 0], memory_of(0, body, 1.0)
    wanted /= math.pi * body.plane_strain_modulus
    np.testing.assert_allclose(np.diff(normal), np.diff(wanted), atol=1e-8 * np.ptp(wanted))
    pull = 0.5 * (1.0 - 2.0 * body.poisson_ratio) / (2.0 * math.pi * body.shear_modulus) * memory_of(1, body, 1.0)
    np.testing.assert_allclose(bodies.coupling_tables(COUNT, 1, DX, math.inf)[0][:, 0], pull, atol=1e-8 * np.ptp(pull))
    thick = replace(SOFT, layers=(Layer(100.0, SOFT.youngs_modulus, SOFT.poisson_ratio, relaxation=body.relaxation),))
    layered = Relaxing(thick, STEEL, 1.0).normal_table(COUNT, 1, DX, math.inf)[:, 0]
    np.testing.assert_allclose(layered, normal, atol=5e-4 * np.ptp(normal))


def relaxing_cylinder(ratio: float, length: float, grid: int) -> tuple[Problem, float]:
    """A rigid cylinder that rolls without friction, and the half-width (m) of the contact that has relaxed."""
    body = Material(3e9, 0.3, relaxation=((1.0 - 1.0 / ratio, 1.0),))
    load, radius = 1e4, 0.01
    half = math.sqrt(4.0 * load * radius * ratio / (math.pi * body.plane_strain_modulus))
    speed = length * half / body.retardation[0][1]
    geometry = Geometry(math.inf, math.inf, radius, math.inf)
    return Problem(body, Material(1e20, 0.3), geometry, load, Friction(0.0), Motion(speed, 0.0, 0.0), MECHANICAL,
                   Numerics((grid, 1))), half


@pytest.mark.parametrize(("ratio", "length"), [
    (2.0, 0.1), (10.0, 1.0), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((2.0, 1.0), (10.0, 0.3), (10.0, 3.0)))])
def test_cylinders_that_relax_are_those_of_hunter(ratio: float, length: float) -> None:
    problem, half = relaxing_cylinder(ratio, length, 128)
    result, exact = solve(problem), hunter(ratio, length)
    moment = result["rolling_resistance_moment_N"] / (problem.normal_force * half)
    assert result.converged and moment == pytest.approx(-exact.moment, rel=5e-4)
    # The resistance times the radius is the moment, and its power all that is lost.
    resistance = result["rolling_resistance_N_mm"] * 1e3 * problem.geometry.upper_radius_x
    assert resistance == pytest.approx(-exact.moment * problem.normal_force * half, rel=5e-4)
    assert result["hysteresis_W_mm"] == pytest.approx(result["rolling_resistance_N_mm"] * problem.motion.speed)
    assert result["contact_width_mm"] == pytest.approx(2e3 * half * exact.half_width, rel=4e-3)
    highest = exact.pressure(np.linspace(-1.0, 1.0, 2001)).max() * 2.0 * problem.normal_force / (math.pi * half)
    assert abs(result["pressure_max_MPa"] * 1e6 / highest - 1.0) < max(
        1e-4, result.uncertainty["pressure_max_MPa"] / result["pressure_max_MPa"])


def test_errors_beside_hunter_fall_with_the_square_of_the_element() -> None:
    def error(grid: int) -> float:
        problem, half = relaxing_cylinder(4.0, 0.5, grid)
        resistance = solve(problem)["rolling_resistance_N_mm"] * 1e3 * problem.geometry.upper_radius_x
        return abs(resistance / (problem.normal_force * half) + hunter(4.0, 0.5).moment)

    assert error(128) < error(32) / 12.0


def cylinders(lower: Material, grid: int = 128, creepage: float = 5e-4, heating: Heating = MECHANICAL) -> Problem:
    return Problem(lower, STEEL, Geometry(0.04, math.inf, 0.06, math.inf), 3e5, Friction(0.3), Motion(1.0, creepage, 0.0),
                   heating, Numerics((grid, 1)))


MEASURED = ("pressure_max_MPa", "force_x_N_mm", "gamma_st", "contact_width_mm")


def test_a_coating_of_its_body_is_no_coating() -> None:
    plain, same, nearly = (solve(cylinders(body)) for body in (
        STEEL, coated(replace(layer(1e-4), youngs_modulus=206e9)), coated(layer(1e-4, 206e9 * (1.0 + 1e-9)))))
    for name in MEASURED:
        assert same[name] == plain[name]
        # Here the border is found on elements.
        assert nearly[name] == pytest.approx(plain[name], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("body", "across"), [
    pytest.param(coated(layer(1e-4)), False, marks=pytest.mark.slow),
    (replace(STEEL, relaxation=((0.6, 2e-4), (0.2, 2e-3))), True)])
def test_creepages_at_which_all_slides_know_layers_and_memory(body: Material, across: bool) -> None:
    """And between them a strip that sticks within an element of the coarse grid is in its estimate."""
    about = DerivedQuantities(cylinders(body)).saturation_creepage / (1.0 - STEEL.poisson_ratio * across)

    def rolled(share: float, grid: int) -> Result:
        motion = Motion(1.0, 0.0, share * about) if across else Motion(1.0, share * about, 0.0)
        return solve(replace(cylinders(body, grid), motion=motion))

    assert rolled(0.8, 32)["gamma_st"] > 0.0 and rolled(1.25, 32)["gamma_st"] == 0.0
    for share in (0.92, 1.0, 1.08):
        coarse, fine = rolled(share, 24), rolled(share, 128)
        assert abs(coarse["gamma_st"] - fine["gamma_st"]) <= coarse.uncertainty["gamma_st"]


def test_thin_and_thick_coatings_are_the_bodies_below_and_above() -> None:
    hard = elastic(0.28, 800e9)
    for body, other in ((coated(layer(1e-8)), STEEL), (coated(layer(1.0)), hard)):
        found, wanted = solve(cylinders(body)), solve(cylinders(other))
        for name in MEASURED:
            assert found[name] == pytest.approx(wanted[name], rel=3e-3), name


@pytest.mark.slow
def test_a_coated_line_is_the_middle_of_a_slender_contact() -> None:
    line = cylinders(coated(layer(1e-4)), 64, 1e-3)
    # The load at which a contact 240 times as wide as long carries 300 N/mm in its middle.
    slender = replace(line, geometry=Geometry(0.04, 400.0, 0.06, 400.0), normal_force=24943.6, numerics=Numerics((64, 32)))
    one, other = solve(line), solve(slender)
    assert other.fields["pressure"][:, 15].sum() * np.diff(other.x)[0] == pytest.approx(line.normal_force, rel=2e-3)
    for name in ("pressure", "shear_x"):
        middle = np.interp(one.x, other.x, other.fields[name][:, 15])
        allowed = at_most("line_contacts", "a coating of 800 GPa on steel", "largest difference")
        assert np.abs(middle - one.fields[name])[6:-6].max() <= allowed * one.fields[name].max()


@pytest.mark.slow
def test_heat_and_stresses_of_a_coated_line() -> None:
    """A coating that is nearly its body; and one that insulates, whose surface is hotter."""
    heating, request = Heating(True, True, "rolling", 0.5), SubsurfaceRequest(("lower",), thermal=False, layers=8)
    alike = Layer(1e-4, 206e9 * (1.0 + 1e-9), 0.28, STEEL.conductivity, STEEL.expansion, STEEL.diffusivity)
    plain, same, insulated = (solve(replace(cylinders(body, 32, 0.05, heating), subsurface=request))
                              for body in (STEEL, coated(alike), coated(layer(1e-4))))
    for name in ("temperature_rise_max_lower_K", "von_mises_max_lower_MPa", "gamma_p"):
        assert same[name] == pytest.approx(plain[name], rel=5e-3), name
    assert insulated.converged and insulated["temperature_rise_max_lower_K"] > 5.0 * plain["temperature_rise_max_lower_K"]
    assert insulated["temperature_interface_max_lower_K"] < insulated["temperature_rise_max_lower_K"]
    # The interface lies in the contact, not at the border of the domain.
    assert not any("border of the domain" in warning for warning in insulated.warnings)

"""Bodies that relax: contacts against exact solutions and a prototype, limits, invariances, power, and case files."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.cases import parse
from tests.support.documents import at_most
from tests.support.errors import relative
from tests.support.sampling import sampled
from tests.support.scenes import MECHANICAL, accurate_to, reference, solved
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.exact.hunter import hunter
from thermoroll_cli.one_contact.refinement.error_estimates import missed_accuracy
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.relaxation import Series

STEEL = Material(210e9, 0.3)
GLASSY = Material(2.6e9, 0.3)
TREAD = Material(2.4e9, 0.38, relaxation=((0.30, 1e-4), (0.25, 1e-3), (0.20, 1e-2)))
SPEED = 2.0
WHEEL = Geometry(math.inf, math.inf, 0.05, 0.2)


def one_time(ratio: float, length: float, speed: float = 1.0, body: Material = GLASSY) -> Material:
    """A body with one retardation time, rolled through in `length` (m), and the `ratio` of relaxed over instantaneous
    compliance."""
    return replace(body, relaxation=((1.0 - 1.0 / ratio, length / speed / ratio),))


def roller(lower: Material = STEEL, upper: Material = TREAD, *, friction: float = 0.3, grid: tuple[int, int] = (16, 16),
           load: float = 500.0, geometry: Geometry = WHEEL, **motion: float) -> Problem:
    moved = Motion(**({"speed": SPEED, "creepage_x": 0.0, "creepage_y": 0.0, "differential_slip": False} | motion))
    return Problem(lower, upper, geometry, load, Friction(friction), moved, MECHANICAL, Numerics(grid=grid))


def scalars(problem: Problem) -> dict[str, float]:
    result = solved(problem)
    assert result.converged, result.reason
    return result.coupled.scalars


@pytest.mark.slow
@pytest.mark.parametrize("case", reference("relaxing_spheres")["cases"][::3],
                         ids=lambda case: str(case["input"]["retardation_length_over_a"]))
def test_spheres_of_a_prototype(case: dict) -> None:
    given, expected = case["input"], case["result"]
    a, radius, load = given["relaxed_hertz_radius_mm"] * 1e-3, given["radius_combined_mm"] * 1e-3, given["normal_N"]
    shear, friction = given["glassy_shear_modulus_MPa"] * 1e6, given["friction"]
    body = one_time(given["relaxed_over_glassy_compliance"], given["retardation_length_over_a"] * a,
                    body=Material(2.0 * shear * (1.0 + given["poisson_ratio"]), given["poisson_ratio"]))
    both = Geometry(2.0 * radius, 2.0 * radius, 2.0 * radius, 2.0 * radius)
    unit = friction * a / radius
    spin = friction / radius
    for name, motion in (("x", {"creepage_x": 0.5 * unit}), ("spin", {"spin": 0.6 * spin}),
                         ("combined", {"creepage_x": 0.3 * unit, "creepage_y": -0.2 * unit, "spin": -0.3 * spin})):
        found = scalars(roller(body, body, friction=friction, load=load, geometry=both, speed=1.0, grid=(32, 32), **motion))
        forces = found["force_x_N"] / friction / load, found["force_y_N"] / friction / load
        assert forces == pytest.approx(expected["force_over_muW"][name], abs=2e-3)
    arm = found["rolling_resistance_moment_Nmm"] / load
    assert arm == pytest.approx(expected["rolling_resistance_moment_over_W_mm"], rel=2e-3)
    assert found["pressure_max_MPa"] == pytest.approx(expected["pressure_max_MPa"], rel=3e-3)
    assert found["approach_um"] == pytest.approx(1e3 * expected["approach_mm"], rel=1e-3)
    # Whole elements, of first order: extrapolated.
    area = 2.0 * expected["area_mm2"] - expected["at_half_the_grid"]["area_mm2"]
    assert found["contact_area_mm2"] == pytest.approx(area, rel=3e-2)


@pytest.mark.parametrize(("ratio", "length", "grid", "within"), [
    (10.0, 10.0, (64, 16), (3e-3, 5e-3, 5e-3)),
    *(pytest.param(ratio, 1.0, (192, 64), [at_most("verification", "middle of a long contact", which=i) for i in (0, 2, 3)],
                   marks=pytest.mark.slow) for ratio in (3.0, 10.0))])
def test_the_middle_of_a_long_contact_is_hunters(
    ratio: float, length: float, grid: tuple[int, int], within: tuple[float, float, float]
) -> None:
    radius, glassy = 0.05, GLASSY
    relaxed = glassy.plane_strain_modulus / ratio
    along = hertz_contact(1.0 / radius, 1.0 / (9000.0 * radius), relaxed, 1000.0)
    a = along.semi_axis_x
    geometry = Geometry(radius, 9000.0 * radius, math.inf, math.inf)
    problem = roller(Material(1e18, 0.3), one_time(ratio, length * a, body=glassy), friction=0.0, grid=grid, load=1000.0,
                     geometry=geometry, speed=1.0)
    state = solved(problem).coupled
    column = state.fields["pressure"].shape[1] // 2
    line, size = state.fields["pressure"][:, column], float(state.x[1] - state.x[0])
    per_length = float(line.sum()) * size
    half = math.sqrt(4.0 * per_length * radius / (math.pi * relaxed))
    exact = hunter(ratio, length * a / half)
    assert float((line * state.x).sum()) * size / per_length / half == pytest.approx(exact.moment, rel=within[0])
    width = 0.5 * float(state.fields["covered"][:, column].sum()) * size
    assert width / half == pytest.approx(exact.half_width, rel=within[1])
    largest = exact.pressure(np.linspace(-1.0, 1.0, 2001)).max() * 2.0 * per_length / (math.pi * half)
    assert line.max() == pytest.approx(largest, rel=within[2])


@pytest.mark.slow
def test_the_limits_are_elastic_bodies() -> None:
    """Rolled through far faster and far slower than the body relaxes."""
    remaining = 1.0 - sum(share for share, _ in TREAD.relaxation)
    for speed, modulus in ((1e-9, 2.4e9 * remaining), (1e9, 2.4e9)):
        elastic = replace(TREAD, youngs_modulus=modulus, relaxation=())
        limit = scalars(roller(upper=replace(elastic), creepage_x=0.004, speed=speed))
        found = scalars(roller(creepage_x=0.004, speed=speed))
        for name in ("force_x_N", "pressure_max_MPa", "contact_area_mm2", "approach_um"):
            assert found[name] == pytest.approx(limit[name], rel=2e-3), name
        assert found["rolling_resistance_N"] < 1e-5 * found["force_x_N"]


@pytest.mark.slow
def test_exchange_of_the_bodies() -> None:
    """What one body does to the other, the other does to it: creepages, forces and spin change their signs."""
    motion = {"creepage_x": 0.003, "creepage_y": -0.001, "spin": 0.4}
    exchanged = Geometry(WHEEL.upper_radius_x, WHEEL.upper_radius_y, WHEEL.lower_radius_x, WHEEL.lower_radius_y)
    one = scalars(roller(**motion))
    other = scalars(roller(TREAD, STEEL, geometry=exchanged, **{name: -value for name, value in motion.items()}))
    for name in ("force_x_N", "force_y_N", "spin_moment_Nmm"):
        assert other[name] == pytest.approx(-one[name], rel=1e-5)
    for name in ("hysteresis_W", "rolling_resistance_moment_Nmm", "Q_F_W", "contact_area_mm2", "pressure_max_MPa"):
        assert other[name] == pytest.approx(one[name], rel=1e-5)


@pytest.mark.slow
def test_scales_of_length_and_time() -> None:
    """Ten times as large and ten times as fast under a hundred times the load: the same pressure. Half as fast with times
    twice as long: the same."""
    large = Geometry(math.inf, math.inf, 10.0 * WHEEL.upper_radius_x, 10.0 * WHEEL.upper_radius_y)
    slower = replace(TREAD, relaxation=tuple((share, 2.0 * time) for share, time in TREAD.relaxation))
    one = scalars(roller(creepage_x=0.003))
    for factor, power, other in ((10.0, 10.0, scalars(roller(geometry=large, load=5e4, speed=10.0 * SPEED, creepage_x=0.003))),
                                 (1.0, 0.5, scalars(roller(upper=slower, speed=0.5 * SPEED, creepage_x=0.003)))):
        for name, expected in (("pressure_max_MPa", 1.0), ("force_x_N", factor**2), ("gamma_st", 1.0),
                               ("rolling_resistance_N", factor**2), ("rolling_resistance_moment_Nmm", factor**3),
                               ("hysteresis_W", factor**2 * power)):
            assert other[name] == pytest.approx(expected * one[name], rel=2e-6), name


@pytest.mark.parametrize("both", sampled([False, True]), ids=["unlike", "alike"])
def test_power_of_forces_and_resistance_becomes_heat(both: bool) -> None:
    """ξ F + M Ω: the moment of the pressure about the axle of each body, over its radius, needs power, too."""
    lower, geometry = (TREAD, Geometry(0.1, 0.2, 0.1, 0.2)) if both else (STEEL, WHEEL)
    problem = roller(lower, creepage_x=0.004, creepage_y=0.001, geometry=geometry, grid=(48, 48))
    found = scalars(problem)
    resistance = found["rolling_resistance_moment_Nmm"] * 1e-3 * problem.geometry.curvature_x
    by_forces = 0.004 * found["force_x_N"] + 0.001 * found["force_y_N"]
    total = (found["Q_F_W"] + found["hysteresis_W"]) / SPEED
    assert by_forces + resistance == pytest.approx(total, rel=2e-3)
    assert found["power_balance_error"] < 2e-3
    assert found["hysteresis_W"] > 0.0


def test_without_friction_the_resistance_is_the_moment_over_the_radius() -> None:
    found = scalars(roller(friction=0.0))
    assert found["rolling_resistance_N"] == pytest.approx(found["rolling_resistance_moment_Nmm"] / 50.0, rel=3e-3)
    assert found["Q_F_W"] == 0.0


@pytest.mark.parametrize("length", [0.03, 1.0])
def test_moment_and_dissipation_agree_where_the_memory_is_shorter_than_an_element(length: float) -> None:
    """With loads that are fitted to the border they differed by 9 %. What is left is that the border lies between elements."""
    a, both = 2e-3, Geometry(0.1, 0.1, math.inf, math.inf)
    body = one_time(30.0, length * a)
    found = scalars(roller(Material(1e18, 0.3), body, friction=0.0, load=4.0 / 90.0 * body.plane_strain_modulus * a**3 / 0.1,
                           geometry=both, speed=1.0))
    assert found["rolling_resistance_N"] == pytest.approx(found["rolling_resistance_moment_Nmm"] / 100.0, rel=4e-2)
    assert found["power_balance_error"] < 3e-2


def test_a_force_that_is_given() -> None:
    found = scalars(roller(creepage_x=None, force_x=60.0))
    again = scalars(roller(creepage_x=found["creepage_longitudinal"]))
    assert again["force_x_N"] == pytest.approx(60.0, rel=2e-3)
    assert found["hysteresis_W"] == pytest.approx(again["hysteresis_W"], rel=1e-3)


def test_bodies_that_relax_alike_but_for_their_times_are_unlike() -> None:
    derived = DerivedQuantities(roller(one_time(3.0, 1e-3), one_time(3.0, 1e-3)))
    assert not derived.dissimilar
    other = DerivedQuantities(roller(one_time(3.0, 1e-3), one_time(3.0, 5e-3)))
    assert other.dissimilar
    assert "elastic coupling" in make_plan(other.problem).run


@pytest.mark.slow
def test_incompressible_bodies_have_heat() -> None:
    """Nothing is singular at a Poisson's ratio of one half."""
    hot = {"conductivity": 0.25, "expansion": 1e-4, "diffusivity": 1.2e-7}
    found = []
    for ratio in (0.49999, 0.5):
        problem = roller(replace(STEEL, **hot), replace(TREAD, poisson_ratio=ratio, **hot), creepage_x=0.003, load=20.0)
        found.append(scalars(replace(problem, heating=Heating())))
    for name in ("temperature_rise_max_upper_K", "hysteresis_W", "contact_area_mm2"):
        assert found[1][name] == pytest.approx(found[0][name], rel=2e-3), name
    assert found[1]["force_x_N"] == pytest.approx(found[0]["force_x_N"], abs=1e-3 * problem.traction_limit)


def test_elastic_bodies_pay_nothing() -> None:
    """No memory is asked for, and influence tables have real symbols."""
    for upper in (replace(TREAD, relaxation=()), on_steel(replace(TYRE, relaxation=()))):
        derived = DerivedQuantities(roller(upper=upper, creepage_x=0.003))
        grid = Discretisation(derived, (16, 16), 2.2)
        assert not derived.bodies.relaxes
        assert grid.pressure.solver._kernel.dtype == np.float64


def test_crowned_rollers_relax() -> None:
    """A logarithmic crown: the contact leads, and its pressure rises at no end."""
    geometry = Geometry(math.inf, math.inf, 0.05, math.inf, upper_profile=Profile(length=0.02, drop=1e-4))
    found = scalars(roller(friction=0.0, geometry=geometry, load=800.0))
    assert found["rolling_resistance_N"] == pytest.approx(found["rolling_resistance_moment_Nmm"] / 50.0, rel=1e-2)


@pytest.mark.parametrize(("ratio", "length", "resolved"), [
    (30.0, 1.0, 96), pytest.param(3.0, 0.3, 96, marks=pytest.mark.slow)])
def test_a_maximum_at_the_leading_edge_is_in_the_estimate(ratio: float, length: float, resolved: int) -> None:
    """Rolled through a relaxation time in a few elements or less, the largest pressure was up to 21 % off and known to 5 %.
    Where the middle of the contact has the largest pressure there is nothing to warn of."""
    a, both = 2e-3, Geometry(0.1, 0.1, math.inf, math.inf)
    body = one_time(ratio, length * a)
    load = 4.0 / 3.0 * body.plane_strain_modulus / ratio * a**3 / 0.1
    problem = roller(Material(1e18, 0.3), body, friction=0.0, load=load, geometry=both, speed=1.0)
    fine = solved(replace(problem, numerics=Numerics(grid=(resolved, resolved)))).coupled.scalars
    for side in (16, 32):
        coarse = solved(replace(problem, numerics=Numerics(grid=(side, side))))
        for name in ("pressure_max_MPa", "contact_area_mm2"):
            value, exact = coarse.coupled.scalars[name], fine[name]
            assert abs(value - exact) < relative(coarse)[name] * value, (side, name)
        # Over the pressure of the same grid without what acts back, of which there is none.
        assert coarse.coupled.scalars["gamma_p"] == 1.0 and relative(coarse)["gamma_p"] < 1e-4
        assert "pressure_max_MPa" in missed_accuracy(relative(coarse), coarse.summary(), accurate_to(1e-3, coarse.problem))
        told = [line for line in coarse.warnings if "behind the leading edge" in line]
        assert len(told) == (ratio > 3.0), coarse.warnings


def test_the_work_is_that_of_elastic_bodies() -> None:
    """Applications of the operators, against a contact without a closed form: an elastic one with a profile."""
    y = np.linspace(-0.03, 0.03, 201)
    profile = Profile(points=tuple((float(place), float(-place**2 / 0.4)) for place in y))
    flat = Geometry(math.inf, math.inf, 0.05, math.inf, upper_profile=profile)
    soft = replace(TREAD, youngs_modulus=1.2e9, relaxation=())
    work = {}
    for name, problem in (("elastic", roller(upper=soft, geometry=flat, friction=0.3, creepage_x=0.004)),
                          ("relaxing", roller(creepage_x=0.004))):
        derived = DerivedQuantities(problem)
        grid = Discretisation(derived, (32, 32), 2.2)
        assert grid.isothermal_pressure.converged
        work[name] = grid.pressure.solver.applications
    assert work["relaxing"] <= 2.0 * work["elastic"]


def test_beyond_what_converges_the_reason_says_so() -> None:
    """A relaxed compliance a thousand times the instantaneous one, rolled through in the worst length."""
    body, both = one_time(1000.0, 1.5e-3), Geometry(0.1, 0.1, 0.1, 0.1)
    load = 4.0 / 3.0 * 0.5e-3 * body.plane_strain_modulus * 5e-3**3 / 0.05
    result = solved(roller(body, body, friction=0.0, load=load, geometry=both, speed=1.0, grid=(32, 32)))
    assert not result.converged
    assert "relax to 1e+03 times their instantaneous compliance" in result.reason


def test_doubts_are_said() -> None:
    """Large strains, and heat that temperatures do not contain; nothing of the kind for steel."""
    hot = {"conductivity": 0.25, "expansion": 1e-4, "diffusivity": 1.2e-7}
    warm = roller(replace(STEEL, **hot), replace(TREAD, **hot), creepage_x=0.003, grid=(16, 16), load=2e4)
    warnings = " ".join(solved(replace(warm, heating=Heating(deformation=False))).warnings)
    assert "the mean strain, about half-width over radius, is 0.1" in warnings
    assert "% of all heat" in warnings
    elastic = replace(warm, upper=replace(TREAD, relaxation=(), **hot), heating=Heating(deformation=False))
    assert not {word for word in ("strain", "of all heat") if word in " ".join(solved(elastic).warnings)}


CASE = """
geometry = {lower_radius_x_mm = inf, lower_radius_y_mm = inf, upper_radius_x_mm = 50.0, upper_radius_y_mm = 200.0}
load = {normal_N = 500.0, friction_coefficient = 0.3}
rolling.speed_m_s = 2.0
numerics.grid = 16
material.lower = {youngs_modulus_GPa = 210.0, poisson_ratio = 0.3}
material.upper = {youngs_modulus_GPa = 2.4, poisson_ratio = 0.38, relaxation = [[0.30, 1e-4], [0.25, 1e-3], [0.20, 1e-2]]}
"""


def test_case_files() -> None:
    case = parse(CASE)
    assert case.problem.upper == TREAD
    assert case.problem.relaxes
    facts = make_plan(case.problem).facts
    assert facts["felt_modulus_GPa"] == pytest.approx(1.75, rel=0.02)
    half = 0.5e-3 * facts["contact_length_mm"]
    lengths = [facts[f"retardation_length_{n}_upper_over_a"] for n in (1, 2, 3)]
    assert lengths == pytest.approx([SPEED * time / half for _, time in TREAD.retardation], rel=1e-6)


def test_friction_that_falls_with_slip() -> None:
    """Laws of friction ask for the compliance of a single element."""
    law = "[creepage]\nlongitudinal = 0.02\n[friction]\nlaw = \"exponential\"\nlimit_coefficient = 0.1\nhalf_slip_m_s = 0.02\n"
    found = scalars(parse(CASE + law).problem)
    assert 50.0 < found["force_x_N"] < 150.0
    assert found["falling_friction_criterion"] > 0.0


# --- layers ------------------------------------------------------------------------------------------------------
TYRE = Layer(3e-3, 50e6, 0.45, relaxation=((0.6, 1e-3),))


def on_steel(*layers: Layer) -> Material:
    return replace(STEEL, layers=layers)


@pytest.mark.parametrize("case", reference("relaxing_layer")["cases"][::3],
                         ids=lambda case: f"{case['thickness_mm']}-{case['speed_m_s']}")
def test_a_sphere_on_a_layer_of_an_independent_program(case: dict) -> None:
    body, expected = on_steel(replace(TYRE, thickness=case["thickness_mm"] * 1e-3)), case["N128"]
    problem = roller(Material(1e18, 0.3), body, friction=0.0, load=8.0, geometry=Geometry(0.05, 0.05, math.inf, math.inf),
                     speed=case["speed_m_s"], grid=(24, 24))
    found = scalars(problem)
    assert found["rolling_resistance_moment_Nmm"] / (8.0 * 50.0) == pytest.approx(expected["resistance_over_load"], rel=1e-2)
    assert found["rolling_resistance_N"] / 8.0 == pytest.approx(expected["resistance_over_load"], rel=1e-2)
    assert found["pressure_max_MPa"] == pytest.approx(expected["pressure_max_MPa"], rel=5e-3)
    assert found["contact_area_mm2"] == pytest.approx(expected["area_mm2"], rel=1.5e-2)


@pytest.mark.slow
def test_a_thick_layer_is_the_body() -> None:
    soft = Material(TYRE.youngs_modulus, TYRE.poisson_ratio, relaxation=TYRE.relaxation)
    thick, body = (scalars(roller(upper=upper, load=10.0, creepage_x=0.01)) for upper in (
        on_steel(replace(TYRE, thickness=0.3)), soft))
    for name in ("rolling_resistance_N", "rolling_resistance_moment_Nmm", "force_x_N", "pressure_max_MPa", "contact_area_mm2"):
        assert thick[name] == pytest.approx(body[name], rel=4e-3), name


def on_core(modulus: float, young: float = 2.4e9, relaxation: Series = ((0.5, 1e-3),)) -> Material:
    return Material(modulus, 0.45, layers=(Layer(500e-6, young, 0.38, relaxation=relaxation),))


@pytest.mark.slow
def test_a_layer_that_is_rolled_fast_loses_what_its_elastic_contact_stores() -> None:
    """Far faster than it relaxes, the resistance is R = 2 s/(V τ) d/d ln J ∫ δ dW of the elastic contact whose layer has the
    compliance J, whatever lies below: the memory trails behind the contact over many of its lengths."""
    core, geometry, load, speed, change = 0.05e9, Geometry(math.inf, math.inf, 0.05, 0.2), 2.0, 300.0, 0.05

    def stored(young: float) -> float:
        """∫ δ dW by Gauss's rule over the cube root of the load, in which δ is smooth."""
        nodes, weights = np.polynomial.legendre.leggauss(3)
        root, weights = 0.5 * (1.0 + nodes), 0.5 * weights
        approach = [scalars(roller(upper=on_core(core, young, ()), friction=0.0, load=load * u**3, grid=(24, 24),
                                   geometry=geometry))["approach_um"] for u in root]
        return float(weights @ (3.0 * root**2 * load * np.array(approach) * 1e-6))

    slope = (stored(2.4e9 / (1.0 + change)) - stored(2.4e9 / (1.0 - change))) / math.log((1.0 + change) / (1.0 - change))
    found = scalars(roller(upper=on_core(core), friction=0.0, load=load, grid=(24, 24), geometry=geometry, speed=speed))
    assert found["rolling_resistance_N"] == pytest.approx(2.0 * 0.5 / 1e-3 * slope / speed, rel=3e-3)


@pytest.mark.slow
def test_a_layer_that_is_rolled_slowly_resists_in_proportion_to_the_speed() -> None:
    """Everything but the last, linear, part of its memory has relaxed: R/V is a constant, as of whole bodies."""
    over_speed = [scalars(roller(upper=on_core(0.24e9), friction=0.0, load=2.0, speed=speed,
                                 geometry=Geometry(math.inf, math.inf, 0.05, 0.2)))["rolling_resistance_N"] / speed
                  for speed in (1e-6, 1e-3)]
    assert over_speed[0] > 0.0
    assert over_speed[1] == pytest.approx(over_speed[0], rel=1e-3)


def test_power_of_a_layer_that_relaxes_is_balanced() -> None:
    one = scalars(roller(upper=on_steel(TYRE), load=10.0, creepage_x=0.01, creepage_y=0.004))
    resistance = one["rolling_resistance_moment_Nmm"] * 1e-3 / 0.05
    by_forces = 0.01 * one["force_x_N"] + 0.004 * one["force_y_N"]
    assert by_forces + resistance == pytest.approx((one["Q_F_W"] + one["hysteresis_W"]) / SPEED, rel=5e-3)

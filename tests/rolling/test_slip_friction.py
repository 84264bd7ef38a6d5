"""Friction that falls with slip, its memory and a layer between the bodies: laws, derivatives, exact and peer solutions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.errors import relative
from tests.support.scenes import reference
from thermoroll_cli import Case
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.rolling.slip_friction import SlipFriction
from thermoroll_cli.problem.friction import Friction, FrictionLaw, Interlayer
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

FALLING, WINKLER, SLOPE, BRANCHES = (
    reference(f"friction_{name}") for name in ("falling", "winkler", "layer_slope", "branches"))
STEEL, RADIUS, LOAD = Material(210e9, 0.28), 0.05, 100.0
LAWS = {
    "exponential": FrictionLaw("exponential", 0.4, 0.5),
    "rational": FrictionLaw("rational", 0.3, 0.2),
    "linear": FrictionLaw("linear", 0.5, 0.4),
    "table": FrictionLaw("table", table=((0.0, 1.0), (0.3, 0.7), (1.0, 0.5))),
}


def spheres(grid: int, **changes: object) -> Problem:
    problem = Problem(STEEL, STEEL, Geometry(*(RADIUS,) * 4), LOAD, Friction(0.3), Motion(1.0, differential_slip=False),
                      Heating(heat=False), Numerics(grid=(grid, grid)))
    return replace(problem, **changes)  # type: ignore[arg-type]


def case(inputs: dict, grid: int) -> Problem:
    """The problem of one case of the reference data."""
    friction, law = inputs["friction"], None
    if "law" in inputs:
        given = inputs["law"]
        if given["kind"] == "table":
            law = FrictionLaw("table", table=tuple((s, mu / friction) for s, mu in zip(*given["table"], strict=True)))
        else:
            law = FrictionLaw(given["kind"], given["limit"] / friction, given["half_m_s"])
        law = replace(law, memory=inputs.get("memory_um", 0.0) * 1e-6)
    x, y, spin = inputs["creepage"]
    yields = inputs["yield_MPa"] * 1e6 if "yield_MPa" in inputs else None
    interlayer = Interlayer(inputs.get("layer_um_GPa", 0.0) * 1e-15, yields)
    force = inputs.get("force_N")
    material = Material(inputs["E_GPa"] * 1e9, inputs["nu"])
    return Problem(
        material, material, Geometry(*(float(r) * 1e-3 for r in inputs["radii_mm"])), inputs["normal_N"],
        Friction(friction, law),
        Motion(inputs["speed_m_s"], x if force is None else None, y, spin * 1e3, force_x=force, differential_slip=False),
        Heating(heat=False), Numerics(grid=(grid, grid)), interlayer=interlayer)


@pytest.mark.parametrize("kind", LAWS)
def test_laws_begin_at_one_and_fall_to_their_limit(kind: str) -> None:
    law = LAWS[kind]
    factor, slope = law.factor(np.array([0.0, 0.1, 1e9]))
    assert factor[0] == 1.0 and factor[2] == pytest.approx(1.0 - law.fall()) and (slope <= 0.0).all()
    step = 1e-7
    assert slope[1] == pytest.approx((law.factor(np.array([0.1 + step]))[0][0] - factor[1]) / step, rel=1e-5)
    assert -slope[0] <= law.steepest


@pytest.mark.parametrize(("over_time", "rolls"), [(False, True), (True, True), (True, False)])
@pytest.mark.parametrize(("kind", "memory"), [("exponential", 0.0), ("rational", 1e-6), ("linear", 1e-4), ("table", 1e-6)])
def test_the_derivative_is_that_of_the_factor(kind: str, memory: float, *, over_time: bool, rolls: bool) -> None:
    generator = np.random.default_rng(1)
    slip, change = 0.05 + 0.1 * generator.random((12, 5)), generator.normal(size=(12, 5))
    covered = np.ones((12, 5))
    covered[0], covered[-1], covered[6, 2] = 0.3, 0.7, 0.0
    past = (0.8 + 0.1 * generator.random((12, 5)), 3e4, rolls) if over_time else ()
    friction = SlipFriction(replace(LAWS[kind], memory=memory), 2.0, 1e-5, covered, *past)
    step = 1e-7
    found = friction.response(slip).change(change)
    difference = (friction.response(slip + step * change).factor - friction.response(slip - step * change).factor) / (2 * step)
    inside = covered > 0.0
    assert np.allclose(found[inside], difference[inside], rtol=1e-5, atol=1e-6)


def test_long_memory_keeps_friction_and_short_memory_follows_the_law() -> None:
    slip, covered = np.full((20, 3), 0.1), np.ones((20, 3))
    law = LAWS["exponential"]
    value = law.factor(np.array([0.1]))[0][0]
    long, short = (SlipFriction(replace(law, memory=m), 1.0, 1e-5, covered).response(slip).factor for m in (1e3, 1e-12))
    assert np.allclose(long, 1.0) and np.allclose(short, value)


@pytest.mark.parametrize("table", [((0.0, 1.0), (1e-3, 1.1), (2e-3, 4.0)), ((0.0, 1.0), (1e-3, 3.0), (9e-3, 3.1)),
                                   ((0.0, 1.0), (1e-3, 2.0), (9e-3, 0.5))], ids=["convex", "concave", "Stribeck"])  # fmt: skip
def test_one_slip_belongs_to_each_sum_of_traction_and_slip(table: tuple) -> None:
    slip, bound = np.geomspace(1e-6, 1e-2, 60).reshape(12, 5), np.full((12, 5), 3e8)
    friction = SlipFriction(FrictionLaw("table", table=table), speed=2.0, dx=1e-5, covered=np.ones((12, 5)))
    for stiffness in (np.full((12, 5), 1.2e11), np.full((12, 5), 1e13)):
        assert friction.outweighed_by(stiffness, bound)
        total = bound * friction.response(slip).factor + stiffness * slip
        np.testing.assert_allclose(friction.resolvent(total, stiffness, bound), slip, rtol=1e-8)
        assert (friction.resolvent(0.9 * bound, stiffness, bound) == 0.0).all()


def close_to_reference(result: Result, name: str) -> None:
    inputs, expected = FALLING["cases"][name]["input"], FALLING["cases"][name]["expected"]
    limit = inputs["friction"] * inputs["normal_N"]
    assert result.converged, result.reason
    for scalar, wanted in expected.items():
        tolerance = wanted["tolerance"]
        if scalar.startswith("force"):
            tolerance = max(tolerance, 4e-4 * limit)
        assert result.coupled.scalars[scalar] == pytest.approx(wanted["value"], abs=tolerance), scalar


@pytest.mark.parametrize("name", sorted(FALLING["cases"])[::2])
def test_falling_friction_agrees_with_fine_solutions(name: str) -> None:
    inputs = FALLING["cases"][name]["input"]
    result = solve(case(inputs, 128 if "layer_um_GPa" in inputs else 64))
    close_to_reference(result, name)


def test_a_layer_that_yields_carries_so_much() -> None:
    """∬ min(μp, τ_c) below a Hertz pressure is μW (3k − k³)/2, k = τ_c/μp₀."""
    inputs = FALLING["cases"]["yield_perfect"]["input"]
    sliding = case({**inputs, "creepage": [0.5, 0.0, 0.0]}, 32)
    hertz = DerivedQuantities(sliding).hertz
    k = inputs["yield_MPa"] * 1e6 / (sliding.friction.coefficient * hertz.peak_pressure)
    carried = 0.5 * (3.0 * k - k**3) * sliding.traction_limit
    state = solve(sliding).coupled
    assert state.scalars["force_x_N"] == pytest.approx(carried, rel=1e-3)
    for strength in (10e6, 60e6):  # far below μp₀ it matters which part of a border element yields
        k = strength / (sliding.friction.coefficient * hertz.peak_pressure)
        weak = solve(replace(sliding, interlayer=Interlayer(0.0, strength))).coupled.scalars["force_x_N"]
        assert weak == pytest.approx(0.5 * (3.0 * k - k**3) * sliding.traction_limit, rel=5e-4)
    k = inputs["yield_MPa"] * 1e6 / (sliding.friction.coefficient * hertz.peak_pressure)
    assert (state.fields["shear_x"] <= inputs["yield_MPa"] * 1e6 * (1.0 + 1e-5)).all()
    with pytest.raises(Unsolvable, match=f"it carries {carried:.6g} N at most"):
        solve(case({**inputs, "force_N": 1.02 * carried}, 16))
    # Bodies of unlike materials have another pressure, known only when it is solved: only a force far above is refused at once.
    unlike = replace(sliding, upper=replace(sliding.upper, youngs_modulus=1.2 * sliding.upper.youngs_modulus))
    k = unlike.interlayer.yield_stress / (unlike.friction.coefficient * DerivedQuantities(unlike).hertz.peak_pressure)
    carried = 0.5 * (3.0 * k - k**3) * unlike.traction_limit
    with pytest.raises(Unsolvable, match="the interlayer yields: it carries"):
        solve(replace(case({**inputs, "force_N": 1.04 * carried}, 16), upper=unlike.upper))
    too_much = solve(replace(case({**inputs, "force_N": 1.01 * carried}, 10), upper=unlike.upper))
    assert not too_much.converged and "the interlayer yields" in too_much.reason
    with pytest.raises(Unsolvable, match="unless friction has memory"):
        solve(replace(sliding, friction=Friction(0.3, LAWS["linear"]), interlayer=Interlayer(1e-14)))
    with pytest.raises(Unsolvable, match="is not computed with it"):
        solve(replace(sliding, friction=Friction(0.3, LAWS["linear"])))


@pytest.mark.parametrize("name", WINKLER["cases"])
def test_a_soft_layer_alone_is_a_winkler_foundation(name: str) -> None:
    """Polach's formula without spin; a fine simplified theory with it."""
    wanted = WINKLER["cases"][name]
    problem = spheres(64)
    geometry = problem.geometry
    hertz = hertz_contact(geometry.curvature_x, geometry.curvature_y, problem.contact_modulus, LOAD)
    a = hertz.semi_axis_x
    layer = 1e6 * a * 2.0 * (1.0 - STEEL.poisson_ratio) / STEEL.shear_modulus
    unit = layer * problem.friction.coefficient * hertz.peak_pressure / a
    motion = Motion(1.0, wanted["kappa_x"] * unit, wanted["kappa_y"] * unit, wanted["kappa_spin"] * unit / a,
                    differential_slip=False)
    scalars = solve(replace(problem, interlayer=Interlayer(layer), motion=motion)).coupled.scalars
    limit = problem.traction_limit
    found = (scalars["force_x_N"] / limit, scalars["force_y_N"] / limit, scalars["spin_moment_Nmm"] * 1e-3 / limit / a)
    assert found == pytest.approx((wanted["Fx"], wanted["Fy"], wanted["Mz"]), abs=3e-4)
    assert scalars["Q_F_W"] / limit / unit == pytest.approx(wanted["Q"], abs=5e-4)


def rising_strips(reach: float, rise: float, steps: int = 1000, strips: int = 200) -> float:
    """F/μ₀W on springs L with the friction μ₀ (1 + rise σ), σ the slip over the unit Lμ₀p₀/a, at `reach` units of creepage:
    τ' = (ξ − s)/L along each strip, τ = μ(s)p where it slips, by implicit steps."""
    half = np.sqrt(1.0 - ((np.arange(strips) + 0.5) / strips) ** 2)
    step, traction, force = 2.0 * half / steps, np.zeros(strips), 0.0
    for i in range(steps):
        bound = np.sqrt(np.maximum(half**2 - (step * (i + 0.5) - half) ** 2, 0.0))
        slip = np.maximum((traction + reach * step - bound) / (step + rise * bound), 0.0)
        traction = traction + (reach - slip) * step
        force += float((traction * step).sum())
    return force / strips / (math.pi / 3.0)


@pytest.mark.slow
def test_friction_that_rises_over_a_soft_interlayer() -> None:
    """An ordinary differential equation along each strip; no memory is needed. Friction that falls and rises again has
    several creepages for one force."""
    problem = spheres(32)
    hertz = DerivedQuantities(problem).hertz
    layer = 1e6 * hertz.semi_axis_x * 2.0 * (1.0 - STEEL.poisson_ratio) / STEEL.shear_modulus
    unit = layer * 0.3 * hertz.peak_pressure / hertz.semi_axis_x
    law = FrictionLaw("table", table=((0.0, 1.0), (100.0 * unit, 31.0)))
    rising = replace(problem, interlayer=Interlayer(layer), friction=Friction(0.3, law),
                     motion=Motion(1.0, 1.5 * unit, differential_slip=False))
    result = solve(rising)
    assert result.converged
    assert result.coupled.scalars["force_x_N"] / rising.traction_limit == pytest.approx(rising_strips(1.5, 0.3), abs=2e-3)
    again = FrictionLaw("table", table=((0.0, 1.0), (0.1, 0.8), (1.0, 1.2)))
    with pytest.raises(Unsolvable, match="at several creepages"):
        solve(replace(problem, friction=Friction(0.3, again), motion=Motion(1.0, None, force_x=20.0)))


@pytest.mark.slow
def test_friction_that_rises_carries_more_than_without_slip_at_second_order() -> None:
    law = FrictionLaw("table", table=((0.0, 1.0), (2e-3, 1.5), (1e-2, 1.7)))
    motion = Motion(1.0, 0.0012, 5e-4, differential_slip=False)
    forces = [solve(spheres(n, friction=Friction(0.3, law), motion=motion)).coupled.scalars["force_x_N"] for n in (16, 32, 128)]
    assert abs(forces[1] - forces[2]) < 0.1 * abs(forces[0] - forces[2]) and abs(forces[1] - forces[2]) < 1e-4 * 30.0
    forced = solve(spheres(32, friction=Friction(0.3, law), motion=Motion(1.0, None, force_x=36.0, differential_slip=False)))
    assert forced.converged and not forced.warnings
    assert forced.coupled.scalars["force_x_N"] == pytest.approx(36.0, rel=1e-5)
    with pytest.raises(Unsolvable, match="= 51 N"):
        solve(spheres(16, friction=Friction(0.3, law), motion=Motion(1.0, None, force_x=51.0)))


@pytest.mark.parametrize("slip", [1e-4, 3e-6])
def test_friction_that_rises_steeply_costs_as_much_as_a_constant_one(slip: float) -> None:
    """The limit of a rise within no slip is a larger constant. Newton's steps would be short, and steeper rises than the first
    unsolved, with the bound that belongs to the slip of each iterate."""
    law = FrictionLaw("table", table=((0.0, 1.0), (0.3 * slip, 1.4), (slip, 3.0)))
    motion = Motion(1.0, 0.003, 1e-3, differential_slip=False)
    constant, rising = (solve(spheres(32, friction=friction, motion=motion))
                        for friction in (Friction(0.9), Friction(0.3, law)))
    assert rising.converged
    assert rising.work["levels"][-1]["applications"] <= 1.5 * constant.work["levels"][-1]["applications"]
    assert rising.coupled.scalars["force_x_N"] == pytest.approx(constant.coupled.scalars["force_x_N"], rel=20.0 * slip)


@pytest.mark.slow
def test_small_creepages_over_a_layer() -> None:
    """Half-space and layer together, in linear theory: not springs in series."""
    geometry = spheres(48).geometry
    hertz = hertz_contact(geometry.curvature_x, geometry.curvature_y, spheres(48).contact_modulus, LOAD)
    a = hertz.semi_axis_x
    unit = 8.0 * a / (3.0 * STEEL.shear_modulus * SLOPE["C"][0])
    motions = {"longitudinal": Motion(1.0, 1e-6, differential_slip=False),
               "lateral": Motion(1.0, 0.0, 1e-6, differential_slip=False),
               "spin_lateral_force": Motion(1.0, 0.0, 0.0, 1e-6 / a, differential_slip=False)}
    for name, motion in motions.items():
        scalar = "force_x_N" if name == "longitudinal" else "force_y_N"
        problem = spheres(48, friction=Friction(10.0), motion=motion)
        without = solve(problem).coupled.scalars[scalar]
        for i in (0, 2, 4):
            softer = solve(replace(problem, interlayer=Interlayer(SLOPE["L_over_L1"][i] * unit))).coupled.scalars[scalar]
            assert softer / without == pytest.approx(SLOPE[name][i], abs=3e-3)


@pytest.mark.slow
def test_memory_makes_steep_laws_converge_at_second_order() -> None:
    law = FrictionLaw("exponential", 2 / 3, 1e-3, memory=1e-7)
    forces = [solve(spheres(n, friction=Friction(0.6, law), motion=Motion(1.0, 0.00135, differential_slip=False)))
              .coupled.scalars["force_x_N"] for n in (16, 32, 64, 128)]
    errors = [abs(force - forces[-1]) for force in forces[:-1]]
    assert np.log2(errors[0] / errors[2]) / 2.0 > 1.5


@pytest.mark.slow
def test_the_coefficient_is_that_of_the_tractions_though_newton_stalls() -> None:
    """So steep a law is solved by the fixed point on its coefficients."""
    steep = Friction(0.3, FrictionLaw("exponential", 0.3, 1e-6, memory=1e-7))
    state = solve(spheres(16, friction=steep, motion=Motion(1.0, 0.001, differential_slip=False))).coupled
    slides = np.hypot(state.fields["slip_x"], state.fields["slip_y"]) > 0.0
    x, y, pressure, friction = (
        state.fields[name][slides] for name in ("shear_x", "shear_y", "pressure", "friction_coefficient"))
    assert slides.any()
    np.testing.assert_allclose(friction * pressure, np.hypot(x, y), rtol=1e-3)
    assert 0.09 < state.scalars["friction_mean"] < 0.2


@pytest.mark.parametrize(("at_rest", "slip", "creepage", "force"), [
    (0.0, 0.1, 0.002, 0.5985), (1e-6, 0.1, 0.002, 0.5986), (0.001, 0.001, 0.001, 9.3990), (0.01, 0.001, 0.002, 9.4650)])
def test_friction_that_begins_near_zero(at_rest: float, slip: float, creepage: float, force: float) -> None:
    """Friction is scaled by its largest coefficient, and beside differential slip it is that of the slip: values of N = 128."""
    top = 0.1 if at_rest == 0.01 else 0.3
    body = "".join(f"{body}_radius_{axis}_mm = {30.0 if body + axis == 'uppery' else 20.0}\n"
                   for body in ("lower", "upper") for axis in "xy")
    case = Case.parse(
        f"[material]\nyoungs_modulus_GPa = 210.0\npoisson_ratio = 0.28\n[geometry]\n{body}[load]\nnormal_N = 100.0\n"
        f"friction_coefficient = {at_rest!r}\n[rolling]\nspeed_m_s = 1.0\n[creepage]\nlongitudinal = {creepage}\n"
        f'[thermal]\nheat = false\n[friction]\nlaw = "table"\ntable = [[0.0, {at_rest!r}], [{slip}, {top}], [1e3, {top}]]\n'
        "[numerics]\ngrid = 32\n")
    result = solve(case.problem)
    assert result.converged and case.problem.traction_limit == pytest.approx(100.0 * top)
    allowed = (1e-5 if slip == 0.1 else 2e-4) * case.problem.traction_limit
    assert result.coupled.scalars["force_x_N"] == pytest.approx(force, abs=allowed)


def test_a_small_force_is_found_beyond_a_threshold_where_stick_creeps_against_it() -> None:
    """A ball in a close groove: with stick, differential slip alone makes more force than the one that is prescribed."""
    law = FrictionLaw("table", table=((0.0, 0.0), (0.02, 0.0), (0.04, 1.0), (1e3, 1.0)))
    result = solve(Problem(
        STEEL, STEEL, Geometry(0.02, -0.022, math.inf, 0.02), 100.0, Friction(0.3, law), Motion(1.0, None, force_x=1.0),
        Heating(heat=False), Numerics(grid=(8, 8))))
    assert result.converged, result.reason
    assert result.coupled.scalars["force_x_N"] == pytest.approx(1.0, rel=1e-4)
    # A thirtieth of the largest friction, and differential slip.
    assert result.coupled.scalars["creepage_longitudinal"] == pytest.approx(0.0206, rel=0.01)


def test_a_force_is_found_beyond_a_threshold_of_slip() -> None:
    """Below it no force answers to a creepage, and none is found."""
    law = FrictionLaw("table", table=((0.0, 0.0), (0.02, 0.0), (0.04, 1.0), (1e3, 1.0)))
    result = solve(Problem(
        STEEL, STEEL, Geometry(0.02, 0.02, 0.02, 0.03), 100.0, Friction(0.3, law), Motion(1.0, None, force_x=6.0),
        Heating(heat=False), Numerics(grid=(24, 24))))
    assert result.converged, result.reason
    assert result.coupled.scalars["force_x_N"] == pytest.approx(6.0, rel=1e-4)
    # A fifth of the largest friction, and little elastic slip.
    assert result.coupled.scalars["creepage_longitudinal"] == pytest.approx(0.024, rel=0.01)
    below = solve(replace(result.problem, motion=Motion(1.0, 0.01)))
    assert below.converged, below.reason
    assert below.coupled.scalars["force_x_N"] == 0.0


def test_the_end_of_stick_converges_at_first_order_with_steep_friction() -> None:
    """Friction that doubles over 1e-5 m/s; the limit of γ_st is 0.856."""
    law = FrictionLaw("table", table=((0.0, 0.5), (1e-5, 1.0), (1.0, 1.0)))
    result = solve(Problem(
        STEEL, STEEL, Geometry(0.02, 0.02, 0.02, 0.03), 100.0, Friction(0.6, law), Motion(1.0, 0.001),
        Heating(heat=False), Numerics(grid=(64, 64))))
    assert 0.3 * relative(result)["gamma_st"] < result.coupled.scalars["gamma_st"] - 0.856 < 1.5 * relative(result)["gamma_st"]


@pytest.mark.parametrize("branch", BRANCHES["branches"][:1], ids=lambda branch: str(branch["force_over_mu0W"]))
def test_a_force_below_the_maximum_belongs_to_two_creepages(branch: dict) -> None:
    limit = BRANCHES["input"]["friction"] * BRANCHES["input"]["normal_N"]
    result = solve(case({**BRANCHES["input"], "force_N": branch["force_over_mu0W"] * limit}, 48))
    assert result.converged
    assert result.coupled.scalars["creepage_longitudinal"] == pytest.approx(branch["creepage_low"], rel=1e-3)
    assert result.of_problem["creepage_falling_branch"] == pytest.approx(branch["creepage_high"], rel=5e-3)
    assert result.of_problem["creep_force_max_N"] == pytest.approx(BRANCHES["max_force_over_mu0W"] * limit, abs=5e-4 * limit)
    assert result.of_problem["creepage_at_creep_force_max"] == pytest.approx(BRANCHES["creepage_at_max"], rel=0.02)
    assert any("falling branch" in warning for warning in result.warnings)


def test_the_falling_branch_may_begin_between_two_points_of_the_curve() -> None:
    motion = Motion(1.0, None, force_x=27.5, differential_slip=False)
    problem = spheres(12, friction=Friction(0.3, FrictionLaw("rational", 0.5, 0.005, memory=1e-6)), motion=motion)
    rising = solve(problem)
    falling = rising.of_problem["creepage_falling_branch"]
    there = solve(replace(problem, motion=Motion(1.0, falling, differential_slip=False)))
    assert rising.converged and falling > 1.5 * rising.coupled.scalars["creepage_longitudinal"]
    assert there.coupled.scalars["force_x_N"] == pytest.approx(27.5, rel=2e-3)


def test_a_force_above_the_maximum_is_told_at_bounded_cost() -> None:
    """The reason names the maximum and its creepage; the whole takes less work than fifteen solutions."""
    inputs = BRANCHES["input"]
    solver, points = ContactSolver(), []
    problem = case({**inputs, "force_N": 0.97 * inputs["friction"] * inputs["normal_N"]}, 32)
    result = solver.solve(problem, report=lambda stage, info: points.append(info.get("applications", 0)))
    one = solver.solve(case(inputs, 32))
    assert not result.converged and "is 32" in result.reason and "at a creepage of 0.017" in result.reason
    # Coarser grids of a solution cost about a third of the finest one.
    assert sum(points) < 15 * sum(level["applications"] for level in one.work["levels"])
    assert result.problem.prescribed_force == problem.prescribed_force


@pytest.mark.slow
def test_forces_along_one_creep_curve_share_it() -> None:
    inputs, solver = BRANCHES["input"], ContactSolver()
    first, second = (case({**inputs, "force_N": share * inputs["friction"] * inputs["normal_N"]}, 32) for share in (0.7, 0.72))
    solver.solve(first)
    followed = len(solver._followed)
    warm, cold = solver.solve(second), ContactSolver().solve(second)
    assert followed >= 10 and len(solver._followed) - followed < followed / 2
    for name in ("creep_force_max_N", "creepage_at_creep_force_max", "creepage_falling_branch"):
        assert warm.of_problem[name] == pytest.approx(cold.of_problem[name], rel=1e-4)

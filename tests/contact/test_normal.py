"""Normal solver against Hertz and Shtaerman, at a load and at an approach; its order, cost, and independence of first guess
and units."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tests.support.profiles import CROWN, below
from tests.support.sampling import sampled
from tests.support.scenes import ellipse, order, rolling
from thermoroll_cli.exact.hertz import HertzContact, element_averages
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.physics.contact.active_set import Approach
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.problem import Layer, Material

ASPECTS = [1.0, 0.1, 10.0]
SIDES = [16, 32, 64, 128, 256]


class Contact:
    """A Hertz contact on a grid: exact solution, undeformed gap, solver."""

    def __init__(self, aspect: float, n: int, extent: float = 2.2, scale: float = 1.0, stiffness: float = 1.0) -> None:
        derived = DerivedQuantities(rolling(geometry=ellipse(aspect)))
        h = derived.hertz
        self.force = h.normal_force * scale**2 * stiffness
        self.hertz = HertzContact(h.semi_axis_x * scale, h.semi_axis_y * scale, h.peak_pressure * stiffness, h.approach * scale,
                                  h.curvature_x / scale, h.curvature_y / scale, h.contact_modulus * stiffness, self.force)
        self.grid = Grid.over((n, n), extent * self.hertz.semi_axis_x, extent * self.hertz.semi_axis_y)
        self.x, self.y = self.grid.x[:, None], self.grid.y[None, :]
        self.gap = self.hertz.undeformed_gap(self.x, self.y)
        edges = [np.append(c - 0.5 * d, c[-1] + 0.5 * d) for c, d in ((self.grid.x, self.grid.dx), (self.grid.y, self.grid.dy))]
        self.exact, self.covered = element_averages(self.hertz, *edges)
        self.solver = NormalSolver(self.grid, Bodies(self.hertz.contact_modulus))

    def solve(self, start=None, **options):
        return self.solver.solve(self.gap, self.force, self.exact if start is None else start, **options)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_hertz_is_met_at_128(aspect):
    """p_max within 2e-4, contact area within 0.5 %, displacement field and approach against the closed form."""
    contact = Contact(aspect, 128)
    solution, hertz = contact.solve(), contact.hertz
    assert solution.converged
    assert solution.pressure.max() == pytest.approx(hertz.peak_pressure, rel=2e-4)
    area = np.count_nonzero(solution.contact) * contact.grid.element_area
    assert area == pytest.approx(hertz.area, rel=5e-3)
    assert solution.approach == pytest.approx(hertz.approach, rel=5e-5)
    error = np.abs(solution.displacement - hertz.displacement(contact.x, contact.y)).max()
    assert error < 5e-4 * hertz.approach


@pytest.mark.parametrize("aspect", sampled(ASPECTS[::-1], 3))
def test_errors_against_hertz_fall_at_the_expected_order(aspect):
    """Mean |p| error with order 3/2 (the border's root), peak pressure and approach with order 2."""
    mean, peak, approach = [], [], []
    for n in SIDES:
        contact = Contact(aspect, n)
        solution, hertz = contact.solve(), contact.hertz
        mean.append(np.abs(solution.pressure - contact.exact).mean() / hertz.mean_pressure)
        peak.append(solution.pressure.max() / contact.exact.max() - 1.0)
        approach.append(solution.approach / hertz.approach - 1.0)
    assert order(SIDES, mean) > 1.35
    assert order(SIDES, peak) > 1.5
    assert order(SIDES, approach) > 1.5
    assert mean[3] < 1e-3


@pytest.mark.parametrize(("aspect", "limit"), [(1.0, 15), (0.1, 22), (10.0, 22)])
def test_work_hardly_grows_with_the_grid(aspect, limit):
    """Conjugate-gradient iterations from Hertz, to 1e-9."""
    iterations = [Contact(aspect, n).solve().iterations for n in (32, 128)]
    assert max(iterations) <= limit
    assert iterations[-1] <= iterations[0] + 6


@pytest.mark.parametrize("aspect", ASPECTS)
def test_any_first_guess_leads_to_the_same_pressure(aspect):
    """None at all, load everywhere, and load on the wrong side."""
    contact = Contact(aspect, 64)
    wanted = contact.solve()
    aside = np.zeros(contact.grid.shape)
    aside[:9, :20] = 1.0
    for start in (np.zeros(contact.grid.shape), np.ones(contact.grid.shape), aside):
        solution = contact.solve(start)
        assert solution.converged
        assert solution.iterations <= 40
        np.testing.assert_array_equal(solution.contact, wanted.contact)
        assert np.abs(solution.pressure - wanted.pressure).max() < 1e-6 * contact.hertz.peak_pressure


@pytest.mark.parametrize("aspect", [1.0, 0.2])
def test_contact_conditions_hold(aspect):
    """p ≥ 0, h ≥ 0, p·h = 0, ∬p = W, and the gap is what Eq. 1 says."""
    contact = Contact(aspect, 96)
    s = contact.solve()
    assert s.pressure.min() == 0.0 and s.gap.min() >= -1e-9 * contact.hertz.approach
    assert not (s.pressure * s.gap).any()
    assert (s.pressure[s.contact] > 0.0).all() and not s.pressure[~s.contact].any()
    assert s.pressure.sum() * contact.grid.element_area == pytest.approx(contact.force, rel=1e-12)
    gap = contact.gap + s.displacement - s.approach
    assert np.abs(gap - s.gap).max() < 1e-8 * contact.hertz.approach
    np.testing.assert_allclose(s.displacement, contact.solver.displacement(s.pressure), rtol=1e-12)


def test_solution_is_symmetric():
    contact = Contact(0.5, 60)
    p = contact.solve().pressure
    for image in (p[::-1], p[:, ::-1]):
        assert np.abs(p - image).max() < 1e-9 * contact.hertz.peak_pressure


def test_a_constant_in_the_gap_moves_the_bodies_and_nothing_else():
    contact = Contact(1.0, 48)
    one, shift = contact.solve(), 0.7 * contact.hertz.approach
    other = contact.solver.solve(contact.gap + shift, contact.force, contact.exact)
    assert other.approach - shift == pytest.approx(one.approach, rel=1e-10)
    assert np.abs(other.pressure - one.pressure).max() < 1e-9 * contact.hertz.peak_pressure


@pytest.mark.parametrize(("scale", "stiffness"), [(2.0**-10, 2.0**12), (1e3, 1.0), (1e-6, 1e-5), (37.0, 1e6)])
def test_units_do_not_matter(scale, stiffness):
    """Lengths and moduli changed by decades: the same contact, iterations included."""
    one, other = Contact(0.3, 64), Contact(0.3, 64, scale=scale, stiffness=stiffness)
    first, second = one.solve(), other.solve()
    assert second.iterations == first.iterations
    np.testing.assert_allclose(second.pressure / stiffness, first.pressure, atol=1e-10 * one.hertz.peak_pressure)
    np.testing.assert_allclose(second.gap / scale, first.gap, atol=1e-10 * one.hertz.approach)


def test_quartic_punch_matches_shtaerman():
    """h = A r⁴: W = 64/15 E* A a⁵, δ = 8/3 A a⁴, p = 64 E* A a³/(9π) (r²/a² + ½) sqrt(1 − r²/a²); peak off the centre."""
    modulus, a, n = 1e11, 1e-4, 128
    amplitude = 1e7
    force, approach = 64 / 15 * modulus * amplitude * a**5, 8 / 3 * amplitude * a**4
    grid = Grid.over((n, n), 2.4 * a, 2.4 * a)
    rr = (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) / a**2
    solution = NormalSolver(grid, Bodies(modulus)).solve(amplitude * a**4 * rr**2, force, np.ones(grid.shape))
    scale = 64 * modulus * amplitude * a**3 / (9 * math.pi)
    expected = scale * (rr + 0.5) * np.sqrt(np.maximum(1.0 - rr, 0.0))
    assert solution.converged
    assert solution.approach == pytest.approx(approach, rel=3e-4)
    assert np.count_nonzero(solution.contact) * grid.element_area == pytest.approx(math.pi * a**2, rel=0.01)
    assert np.abs(solution.pressure - expected)[rr < 0.8].max() < 2e-3 * expected.max()
    assert solution.pressure.max() == pytest.approx(expected.max(), rel=2e-3)


def test_a_rough_gap_has_several_contacts_and_still_satisfies_its_conditions():
    contact = Contact(1.0, 80, extent=4.0)
    a = contact.hertz.semi_axis_x
    waves = np.cos(9.0 * contact.x / a) * np.cos(7.0 * contact.y / a)
    gap = contact.gap + 0.3 * contact.hertz.approach * waves
    s = contact.solver.solve(gap, contact.force, contact.exact)
    other = contact.solver.solve(gap, contact.force, np.zeros(contact.grid.shape))
    assert s.converged and other.converged
    assert s.pressure.min() == 0.0 and s.gap.min() >= -1e-9 * contact.hertz.approach
    np.testing.assert_array_equal(s.contact, other.contact)
    holes = ~s.contact & (np.hypot(contact.x, contact.y) < 0.8 * a)
    assert holes.any()


def test_running_out_of_iterations_is_told():
    solution = Contact(1.0, 32).solve(np.ones((32, 32)), max_iterations=2)
    assert not solution.converged
    assert solution.iterations == 2


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("n", [32, 64, 128])
def test_a_refined_border_brings_area_and_pressure_closer_to_hertz(aspect, n):
    """Covered fractions give the area within 3e-3 (1e-3 from N = 64), averages come out at least three times closer."""
    contact = Contact(aspect, n)
    solution = contact.solve()
    refined = contact.solver.refine(solution, contact.gap, contact.force)
    area = refined.covered.sum() * contact.grid.element_area
    assert area == pytest.approx(contact.hertz.area, rel=3e-3 if n < 64 else 1e-3)
    before, after = (np.abs(s.pressure - contact.exact).mean() for s in (solution, refined))
    assert after < before / 3.0
    assert refined.pressure.sum() * contact.grid.element_area == pytest.approx(contact.force, rel=1e-10)
    assert refined.pressure.min() >= 0.0 and refined.gap.min() >= 0.0
    assert refined.covered.min() >= 0.0 and refined.covered.max() <= 1.0
    np.testing.assert_array_equal(refined.pressure > 0.0, refined.covered > 0.0)


def quartic_area(n: int) -> float:
    """Refined area of Shtaerman's contact h = A r⁴ over the exact one, minus 1: p² is far from a paraboloid."""
    modulus, a, amplitude = 1e11, 1e-4, 1e7
    grid = Grid.over((n, n), 2.2 * a, 2.2 * a)
    gap = amplitude * (grid.x[:, None] ** 2 + grid.y[None, :] ** 2) ** 2
    force = 64 / 15 * modulus * amplitude * a**5
    solver = NormalSolver(grid, Bodies(modulus))
    refined = solver.refine(solver.solve(gap, force, np.ones(grid.shape)), gap, force)
    return float(refined.covered.sum()) * grid.element_area / (math.pi * a**2) - 1.0


@pytest.mark.parametrize(("n", "limit"), [(32, 4e-3), (64, 1e-3), (128, 3e-4)])
def test_a_refined_border_is_found_where_the_pressure_is_not_that_of_hertz(n, limit):
    """Whole elements are off by 2e-2, 7e-3 and 3e-3, paraboloids continued from the inside by 6e-2, 2e-2 and 3e-3."""
    assert abs(quartic_area(n)) < limit


def test_the_refined_area_follows_the_load_without_jumps():
    """While the border moves through two rows of elements, the area over Hertz's stays within 2e-3 and changes smoothly."""
    contact = Contact(1.0, 48)
    ratios = []
    for scale in np.linspace(0.9, 0.98, 33):
        force = contact.force * scale**3
        solution = contact.solver.solve(contact.gap, force, contact.exact)
        covered = contact.solver.refine(solution, contact.gap, force).covered
        ratios.append(covered.sum() * contact.grid.element_area / (contact.hertz.area * scale**2) - 1.0)
    assert np.abs(ratios).max() < 2e-3
    assert np.abs(np.diff(ratios)).max() < 1e-3


def test_a_contact_too_small_to_have_an_inside_is_left_as_it_is():
    contact = Contact(1.0, 32)
    force = contact.force * 1e-4
    solution = contact.solver.solve(contact.gap, force, contact.exact)
    assert np.count_nonzero(solution.contact) <= 9
    refined = contact.solver.refine(solution, contact.gap, force)
    np.testing.assert_array_equal(refined.covered > 0.0, solution.contact)
    assert refined.pressure.sum() * contact.grid.element_area == pytest.approx(force, rel=1e-10)


@pytest.mark.parametrize("aspect", sampled(ASPECTS, 3))
def test_the_load_is_that_of_hertz_to_second_order_for_the_work_of_a_given_load(aspect):
    errors = []
    for n in SIDES:
        contact = Contact(aspect, n)
        solution = contact.solver.solve(contact.gap, Approach(contact.hertz.approach), contact.exact)
        assert solution.converged and solution.approach == contact.hertz.approach
        errors.append(contact.solver.load(solution.pressure) / contact.force - 1.0)
        assert solution.iterations <= 4 + 1.2 * contact.solve().iterations
    assert order(SIDES, errors) > 1.5


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e3])
def test_the_first_guess_does_not_matter(factor):
    contact = Contact(0.4, 48)
    wanted = contact.solver.solve(contact.gap, Approach(contact.hertz.approach), np.zeros(contact.grid.shape))
    aside = np.zeros(contact.grid.shape)
    aside[:3, :3] = 1.0
    for start in (contact.exact * factor, np.full(contact.grid.shape, factor), aside):
        found = contact.solver.solve(contact.gap, Approach(contact.hertz.approach), start)
        assert found.converged and found.iterations <= 40
        np.testing.assert_allclose(found.pressure, wanted.pressure, atol=1e-7 * contact.hertz.peak_pressure)


def layered() -> Discretisation:
    steel, coating = Material(210e9, 0.3), Layer(50e-6, 1000e9, 0.2)
    problem = dataclasses.replace(rolling(grid=48), lower=dataclasses.replace(steel, layers=(coating,)), upper=steel)
    return Discretisation(DerivedQuantities(problem), (48, 48), 2.2)


def crowned() -> Discretisation:
    problem = rolling(grid=48, geometry=below(CROWN, 0.01), load=800.0)
    return Discretisation(DerivedQuantities(problem), (48, 48), 2.2)


@pytest.mark.parametrize("scene", [layered, crowned])
def test_load_and_approach_lead_to_each_other(scene):
    """Below stiff layers, and for profiles."""
    pressure = scene().pressure
    gap, solver, load = pressure.undeformed_gap / pressure.cosine, pressure.solver, pressure._derived.problem.normal_force
    there = solver.solve(gap, load, pressure.isothermal.start, 1e-10)
    back = solver.solve(gap, Approach(there.approach), np.zeros(gap.shape), 1e-10)
    assert back.converged
    assert solver.load(back.pressure) == pytest.approx(load, rel=1e-7)
    np.testing.assert_allclose(back.pressure, there.pressure, atol=1e-7 * there.pressure.max())


def test_bodies_that_do_not_touch_carry_nothing():
    contact = Contact(1.0, 16)
    for depth in (0.0, -1e-6):
        solution = contact.solver.solve(contact.gap, Approach(depth), contact.exact)
        inside = contact.gap < depth
        assert solution.converged and not solution.pressure.any() and not (solution.contact & ~inside).any()


@pytest.mark.parametrize("given", [Approach(1e-6), 10.0])
def test_a_gap_that_is_no_number_ends_at_once(given):
    contact = Contact(1.0, 16)
    gap = np.where(contact.gap < np.median(contact.gap), np.nan, contact.gap)
    solution = contact.solver.solve(gap, given, contact.exact)
    assert not solution.converged and solution.iterations <= 1

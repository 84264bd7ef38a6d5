"""Normal contact with its own heat inside: exact states, order of convergence, cost, and contacts that must not wander."""

import numpy as np
import pytest

from tests.support.scenes import order, reference, rolling
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.physics.contact import heated_contact
from thermoroll_cli.physics.contact.active_set import Approach
from thermoroll_cli.physics.contact.heated_contact import HeatedContactSolver
from thermoroll_cli.physics.heat.heat_response import DividedHeat
from thermoroll_cli.physics.numerics.grid import peak_value
from thermoroll_cli.problem.problem import Heating

CASES = {case["Q_F_W"]: case for case in reference("heated_sphere")["cases"]}


def heated(heat, grid):
    """Solver of the exact case on a grid: full sliding, sources at rest, `heat` W; with its Hertz pressure."""
    problem = rolling(grid=grid, friction=1e-4, creepage=(1.0, 0.0), heating=Heating(peclet="stationary"))
    discretisation = Discretisation(DerivedQuantities(problem), (grid, grid), 2.2)
    response = discretisation.responses.response(discretisation.derived, (1.0, 0.0), np.zeros((2, grid, grid)))

    def expand(pressure, contact):
        return response.displacement(DividedHeat(heat / problem.normal_force * pressure, 0.5))

    gap, hertz = discretisation.pressure.undeformed_gap, discretisation.isothermal_pressure
    return HeatedContactSolver(discretisation.pressure.solver, expand, gap, problem.normal_force), hertz


@pytest.mark.parametrize("heat", CASES)
def test_exact_states_from_a_cold_start(heat):
    """On whole elements: the peak to second order in the elements across the contact, with a cost that hardly grows."""
    solver, hertz = heated(heat, 64)
    found = solver.continued(hertz.pressure, 1e-8)
    assert found.converged and found.reached == 1.0
    across = 64 / 1.1 * CASES[heat]["radius_over_a0"]
    assert peak_value(found.pressure) / hertz.peak == pytest.approx(CASES[heat]["gamma_p"], rel=1.5 / across**2 + 1e-4)
    assert solver.applications <= (40 if heat <= 40 else 130)
    assert found.pressure.min() == 0.0
    assert found.pressure.sum() == pytest.approx(hertz.pressure.sum(), rel=1e-3)


def test_order_of_convergence():
    grids = [16, 32, 64]
    errors = []
    for grid in grids:
        solver, hertz = heated(11.28, grid)
        errors.append(peak_value(solver.continued(hertz.pressure, 1e-8).pressure) / hertz.peak - CASES[11.28]["gamma_p"])
    assert order(grids, errors) > 1.5


def test_raising_the_heat_is_what_finds_strong_states():
    """Straight from a contact that is much too large the active sets wander; that is seen early and given up."""
    solver, hertz = heated(160, 32)
    at_once = solver.solve(hertz.pressure, 1e-8)
    assert not at_once.converged and at_once.active_sets <= 4
    raised = solver.continued(hertz.pressure, 1e-8)
    assert raised.converged and raised.raised
    assert solver.solve(raised.pressure, 1e-8).active_sets == 1


def test_what_was_not_reached_is_not_claimed(monkeypatch):
    """Too few active sets are allowed: the state returned is one at less heat, and says so."""
    solver, hertz = heated(160, 32)
    monkeypatch.setattr(heated_contact, "MOST_ACTIVE_SETS", 3)
    monkeypatch.setattr(heated_contact, "SMALLEST_STEP", 0.2)
    found = solver.continued(hertz.pressure, 1e-8)
    assert not found.converged and found.reached < 1.0
    less = heated(160 * found.reached, 32)[0].solve(found.pressure, 1e-3)
    assert less.converged and less.active_sets == 1


def test_without_heat_it_is_the_elastic_contact():
    solver, hertz = heated(0.0, 32)
    found = solver.solve(hertz.pressure, 1e-9)
    discretisation = Discretisation(DerivedQuantities(rolling(grid=32)), (32, 32), 2.2)
    elastic = discretisation.pressure.solver.solve(discretisation.pressure.undeformed_gap, 65.0, hertz.pressure, 1e-9)
    assert np.abs(found.pressure - elastic.pressure).max() < 1e-6 * hertz.peak
    assert not found.expansion.any()


def test_a_gap_that_is_no_number_ends_the_search():
    solver, hertz = heated(40, 16)
    solver._gap = np.where(hertz.pressure == hertz.pressure.max(), np.nan, solver._gap)
    found = solver.solve(hertz.pressure, 1e-8)
    assert not found.converged and found.active_sets == 1


@pytest.mark.parametrize("heat", [11.28, 160])
def test_a_heated_contact_at_the_approach_of_a_load(heat):
    at_load, hertz = heated(heat, 32)
    there = at_load.continued(hertz.pressure, 1e-8)
    closing = at_load._closing(there.pressure, there.pressure > 0.0, 1.0) + at_load._gap
    approach = float(closing[there.pressure > 0.0].mean())
    at_approach = HeatedContactSolver(at_load._normal, at_load._expand, at_load._gap, Approach(approach))
    back = at_approach.continued(1.1 * there.pressure, 1e-8)
    assert back.converged
    assert np.abs(back.pressure - there.pressure).max() < 1e-5 * there.pressure.max()

"""Numerical options reach the solvers: every idea that an experiment takes away is worth something, and nothing is patched."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from scripts.benchmark.cases import FIRST_ORDER, NO_CONTINUATION, UNPRECONDITIONED, WITHOUT_EXTRAPOLATION
from tests.support.errors import relative
from tests.support.scenes import article_4_1, on_grid, reference_problem
from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.refinement.neighbours import predicted
from thermoroll_cli.one_contact.refinement.plan import grid_sequence
from thermoroll_cli.one_contact.refinement.refine import carried, first_guess
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.one_contact.steady_state.fixed_point import fixed_point
from thermoroll_cli.one_contact.steady_state.iteration import iterate
from thermoroll_cli.physics.numerics.grid import Domain
from thermoroll_cli.physics.rolling.rolling_gradient import RollingOptions
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

CASE = reference_problem("article_3_1_case_5", 32)


@pytest.fixture(scope="module")
def standard() -> Result:
    return solve(CASE)


def force(result: Result) -> float:
    return result.coupled.scalars["force_x_N"] / result.problem.traction_limit


def applications(result: Result) -> int:
    return result.work["levels"][-1]["applications"]


def test_the_grids_before_the_last_one_save_work_and_give_the_estimate(standard: Result) -> None:
    alone = solve(CASE, options=NO_CONTINUATION)
    assert len(alone.work["levels"]) == 1 and len(standard.work["levels"]) == len(grid_sequence(CASE)) == 3
    assert math.isnan(relative(alone)["Q_F_W"]) and relative(standard)["Q_F_W"] < 0.01
    assert applications(alone) > 1.5 * applications(standard)
    assert force(alone) == pytest.approx(force(standard), abs=5e-3)


def test_extrapolation_changes_integrals_alone(standard: Result) -> None:
    plain = solve(CASE, options=WITHOUT_EXTRAPOLATION)
    assert plain.work["extrapolated"] == [] and standard.work["extrapolated"]
    assert plain.coupled.scalars["gamma_st"] == standard.coupled.scalars["gamma_st"]
    assert 0.0 < abs(force(plain) - force(standard)) < 5e-3


def test_first_order_is_ten_times_as_far_from_the_limit(standard: Result) -> None:
    fine, crude = force(solve(on_grid(CASE, 128))), solve(CASE, options=FIRST_ORDER)
    assert crude.converged
    assert abs(force(crude) - fine) > 10.0 * abs(force(standard) - fine)


def test_the_preconditioner_saves_most_of_the_work(standard: Result) -> None:
    without = solve(CASE, options=UNPRECONDITIONED)
    assert without.converged and force(without) == pytest.approx(force(standard), abs=1e-4)
    assert applications(without) > 2.5 * applications(standard)


def test_options_of_the_rolling_solver_reach_newton() -> None:
    """A factor of ρ that lets elements alternate between stick and slip takes more work."""
    problem = on_grid(CASE, 48)
    work = {}
    for factor in (RollingOptions.relaxation, 3.0):
        options = SolverOptions(rolling=RollingOptions(relaxation=factor))
        discretisation = Discretisation(DerivedQuantities(problem), (48, 48), 2.2, options=options)
        start = first_guess(discretisation, None, hot=False)
        work[factor] = fixed_point(discretisation, start, options.tolerances).applications
    assert work[3.0] > 1.2 * work[RollingOptions.relaxation]


# --- the fixed point -------------------------------------------------------------------------------------------------


def test_a_state_is_its_own_turn() -> None:
    """What a turn makes of the converged state is that state, and what is returned goes together."""
    problem = article_4_1(24)
    discretisation = Discretisation(DerivedQuantities(problem), (24, 24), 2.2)
    tolerances = SolverOptions().tolerances
    isothermal = fixed_point(discretisation, first_guess(discretisation, None, hot=False), tolerances)
    assert not isothermal.acts_back and isothermal.converged and isothermal.residual == 0.0
    coupled = fixed_point(discretisation, first_guess(discretisation, isothermal.contact, hot=True), tolerances)
    assert coupled.converged and coupled.acts_back and coupled.residual == coupled.history[-1] <= tolerances.coupling
    after = iterate(discretisation, coupled.contact, tolerances)
    approach = discretisation.derived.hertz.approach
    assert abs(after.expansion - coupled.contact.expansion).max() < 10.0 * tolerances.coupling * approach
    assert after.normal.peak == pytest.approx(coupled.contact.normal.peak, rel=1e-5)


def test_the_best_state_is_returned_with_its_residual_where_iterations_run_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("thermoroll_cli.one_contact.steady_state.fixed_point.MOST_ITERATIONS", 3)
    options = SolverOptions()
    discretisation = Discretisation(DerivedQuantities(article_4_1(24)), (24, 24), 2.2, options=options)
    isothermal = fixed_point(discretisation, first_guess(discretisation, None, hot=False), options.tolerances).contact
    stopped = fixed_point(discretisation, first_guess(discretisation, isothermal, hot=True), options.tolerances)
    assert not stopped.converged and stopped.iterations == len(stopped.history) == 3
    assert stopped.residual in stopped.history and stopped.residual > options.tolerances.coupling
    result = solve(article_4_1(16), options=options)
    assert not result.converged and "thermal coupling with all of the heat stopped after 3 iterations" in result.reason


# --- starts ----------------------------------------------------------------------------------------------------------


def test_a_contact_between_the_elements_of_a_larger_domain_starts_without_heat() -> None:
    derived = DerivedQuantities(article_4_1(24))
    discretisation, a = Discretisation(derived, (24, 24), 2.2), derived.hertz.semi_axis_x
    small = Discretisation(derived, (24, 24), 2.2, followed=Domain(0.01 * a, 0.01 * a, 0.0, 0.0))
    contact = fixed_point(small, first_guess(small, None, hot=False), SolverOptions().tolerances).contact
    inside = np.zeros(small.grid.shape)
    inside[11:13, 11:13] = 1e9
    contact = replace(contact, normal=replace(contact.normal, pressure=inside), expansion=inside * 1e-15)
    start = first_guess(discretisation, carried(discretisation, small, contact), hot=True)
    assert np.array_equal(start.normal.pressure, discretisation.isothermal_pressure.pressure)


@pytest.fixture(scope="module")
def neighbours() -> list[list[Level]]:
    """Levels of the coupled states of two neighbouring problems."""
    solver, levels = ContactSolver(), []
    for speed in (150.0, 165.0):
        solver.solve(article_4_1(32, speed=speed))
        levels.append(solver.last[1])
    return levels


@pytest.mark.slow
def test_the_coarser_grid_corrects_the_start_from_the_last_problem(neighbours: list[list[Level]]) -> None:
    """The start of the finest grid is several times closer to the state with what the coarser grid has found of the change."""
    before, now = neighbours
    coarse, finest = (next(level for level in now if level.here.grid.nx == size) for size in (16, 32))
    alone, corrected = (errors_of_start(finest, *start) for start in ((None, before), (coarse, before)))
    assert (corrected < [0.4, 0.8, 0.8] * alone).all()


def errors_of_start(level: Level, coarse: Level | None, levels: Sequence[Level]) -> np.ndarray:
    """Largest errors of expansion, pressure and tractions in what these levels predict of the state of `level`."""
    start, state = predicted(level.here, coarse, levels), level.contact
    assert start is not None
    return np.array([float(abs(one - other).max()) for one, other in (
        (start.expansion, state.expansion), (start.normal.pressure, state.normal.pressure),
        (start.tangential.traction, state.tangential.traction))])


@pytest.mark.slow
def test_what_a_coarser_grid_has_learnt_saves_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its secants, and its first residual in place of the largest one."""
    work = [solve(article_4_1(64)).work["levels"][-1]]
    monkeypatch.setattr("thermoroll_cli.one_contact.refinement.refine.learnt", lambda *known: None)
    work.append(solve(article_4_1(64)).work["levels"][-1])
    assert work[0]["coupling_iterations"] < work[1]["coupling_iterations"]
    assert work[0]["coupled_applications"] < 0.8 * work[1]["coupled_applications"]

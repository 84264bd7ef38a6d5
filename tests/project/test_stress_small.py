"""A small part of `make stress`: random valid cases, each checked by what must hold of any result."""

from __future__ import annotations

import numpy as np
import pytest

from scripts.stress.estimate_coverage import STRONG, pairs_of
from scripts.stress.stress import CONVERGED_SHARE, LARGE_WORK, MEDIAN_WORK, Outcome, outcome_of, told
from scripts.stress.stress_cases import BELOW_LIMIT, StressCase, stress_case
from scripts.stress.stress_friction import AGREE, OTHERS, broken_by
from scripts.stress.stress_friction import missed as missed_falling
from scripts.stress.stress_friction import outcome as falling_outcome
from scripts.stress.stress_layers import grid_changes
from scripts.stress.stress_layers import run_seed as run_layers_seed
from scripts.stress.stress_neighbours import FIRST as FIRST_NEIGHBOURS
from scripts.stress.stress_neighbours import differences
from scripts.stress.stress_profiles import run_seed as run_profile_seed
from tests.support.command_line import THERMAL
from thermoroll_cli.files.case import Case

CASES = 80
FALLING = range(0, 20)
BEYOND = (18, 48)
"""Seeds beyond the limit that have a steady state all the same."""
HOT = THERMAL.replace("grid = 16", "grid = 8").replace("speed_m_s = 1.0", "speed_m_s = 2e3")


@pytest.fixture(scope="module")
def cases() -> list[StressCase]:
    return [stress_case(seed, small=True) for seed in range(CASES)]


@pytest.fixture(scope="module")
def outcomes(cases: list[StressCase]) -> list[Outcome]:
    return [outcome_of(case) for case in cases if case.below_limit or case.seed in BEYOND]


def test_a_case_beyond_the_limit_keeps_the_invariants() -> None:
    case = Case.parse(HOT + '[thermal]\npeclet = "stationary"\n')
    done = outcome_of(StressCase(-1, case, case.problem, 1.0))
    assert not done.converged and not done.broken, told(done)
    assert "thermoroll sweep CASE --over rolling.speed_m_s=" in done.reason


def test_nothing_crashes_and_no_invariant_breaks(outcomes: list[Outcome]) -> None:
    assert [told(o) for o in outcomes if o.broken] == []


def test_falling_friction_converges_to_one_solution() -> None:
    outcomes = [falling_outcome(seed, 16) for seed in FALLING]
    assert missed_falling(outcomes) == [] and sum(o.difference <= AGREE for o in outcomes) == 2


def test_layers_that_yield_keep_the_invariants() -> None:
    assert [fault for kind in OTHERS for seed in range(8) for fault in broken_by(kind, seed, 16)] == []


def test_strength_and_wear_have_estimates_that_cover_their_errors() -> None:
    pairs = [pair for seed in (3, 5) for pair in pairs_of(STRONG, seed, 16)]
    assert len(pairs) > 20 and np.mean([pair.shortfall <= 1.0 for pair in pairs]) > 0.85


def test_what_does_not_converge_has_a_reason(outcomes: list[Outcome]) -> None:
    assert all(o.converged or o.reason for o in outcomes)


def test_cases_below_the_thermoelastic_limit_converge(outcomes: list[Outcome]) -> None:
    below = [o for o in outcomes if o.below_limit]
    assert len(below) > 60
    failed = [told(o) for o in below if not o.converged]
    assert len(failed) <= max(1.0, (1.0 - CONVERGED_SHARE) * len(below)), failed


def test_tractions_take_little_work(outcomes: list[Outcome]) -> None:
    work = [o.work for o in outcomes if o.work]
    assert np.median(work) <= MEDIAN_WORK
    assert np.percentile(work, 99) <= LARGE_WORK


@pytest.mark.parametrize("seed", range(FIRST_NEIGHBOURS, FIRST_NEIGHBOURS + 6))
def test_problems_that_start_from_their_neighbours_have_the_same_solution(seed: int) -> None:
    assert list(differences(seed)) == []


def test_a_seed_always_gives_the_same_case_and_a_file_that_can_be_read() -> None:
    for seed in range(5):
        case = stress_case(seed)
        assert stress_case(seed) == case
        assert Case.parse(case.case.to_toml()).problem == case.problem


def test_cases_are_spread_over_what_can_be_written(cases: list[StressCase]) -> None:
    problems = [case.problem for case in cases]
    assert {p.heating.peclet for p in problems if p.heating.heat} == {"rolling", "sliding", "stationary"}
    assert any(p.heating.partition == "matched" for p in problems)
    assert any(p.motion.force_x is not None for p in problems) and any(p.motion.spin for p in problems)
    assert any(p.lower != p.upper for p in problems)
    loads = [p.normal_force for p in problems]
    assert np.log10(max(loads) / min(loads)) > 12
    bulges = [case.bulge for case in cases]
    assert max(bulges) > BELOW_LIMIT and 0.0 in bulges


@pytest.mark.parametrize("seed", [4, 5, 6, 7, 18, 24, 44, 83])
def test_random_profiles_keep_the_invariants(seed: int) -> None:
    """Two of each kind that `make stress` draws, some with prescribed forces, on grids that need not be square."""
    done = run_profile_seed(seed)
    assert done.converged and not done.broken, told(done)


@pytest.mark.parametrize("seed", [1, 3, 7, 10, 16, 18])
def test_random_layers_keep_the_invariants(seed: int) -> None:
    """Thin and thick, stiff and soft ones, on one body and on both; a finer grid changes less than the estimates."""
    done = run_layers_seed(seed, 16)
    assert done.converged and not done.broken, told(done)
    changes = grid_changes(seed, 16)
    assert len(changes) >= 4 and max(changes.values()) < 1.0, changes

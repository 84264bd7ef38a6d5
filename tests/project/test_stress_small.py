"""A case or two of each population of `make stress`: they are drawn and checked, and the driver reports them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scripts.stress.__main__ import main, missed
from scripts.stress.checks import carries_less
from scripts.stress.populations import POPULATIONS, run_seed
from scripts.stress.random_cases import BELOW_LIMIT, StressCase, stress_case
from scripts.stress.random_profiles import friction_across
from tests.support.command_line import THERMAL
from thermoroll_cli.files.case import Case
from thermoroll_cli.problem.problem import Numerics
from thermoroll_cli.python_api import solve

CASES, SOLVED = 50, 3
BEYOND = 18
"""A seed beyond the limit that has a steady state all the same."""
HOT = THERMAL.replace("grid = 16", "grid = 8").replace("speed_m_s = 1.0", "speed_m_s = 2e3")
COARSE = Numerics((16, 16))


@pytest.fixture(scope="module")
def cases() -> list[StressCase]:
    return [stress_case(seed, small=True) for seed in range(CASES)]


@pytest.mark.slow
def test_a_case_beyond_the_limit_keeps_the_invariants() -> None:
    case = Case.parse(HOT + '[thermal]\npeclet = "stationary"\n')
    done = POPULATIONS["contacts"].check(StressCase(-1, case, case.problem, 1.0))
    assert done.excused and not done.converged and not done.broken, done
    assert "thermoroll sweep CASE --over rolling.speed_m_s=" in done.reason


@pytest.mark.slow
def test_a_force_is_excused_where_friction_across_carries_less_alone() -> None:
    """One that friction carries is not, whatever the result says."""
    too_much = friction_across(660192)
    outcome = run_seed("friction across", 660192)
    assert outcome.excused and not outcome.converged and not outcome.broken and "friction across" in outcome.reason
    assert too_much.motion.force_x is not None
    less = solve(replace(too_much, motion=replace(too_much.motion, force_x=0.1 * too_much.motion.force_x)))
    assert less.converged and not carries_less(replace(less, converged=False, reason=outcome.reason))
    assert carries_less(replace(less, problem=too_much))


@pytest.mark.slow
def test_contacts_converge_with_little_work_and_keep_the_invariants(cases: list[StressCase]) -> None:
    solved = [*(case for case in cases[:SOLVED] if case.below_limit), cases[BEYOND]]
    outcomes = [POPULATIONS["contacts"].check(case) for case in solved]
    assert [outcome.broken for outcome in outcomes if outcome.broken] == [] and missed(outcomes) == []
    assert sum(not outcome.excused for outcome in outcomes) > 2


@pytest.mark.parametrize(("population", "seeds"), [
    ("falling friction", (2,)),  # one solution from every start
    ("rising friction", (0,)),
    ("yielding interlayers", (0,)),
    ("bodies that relax", (0,)),
    *(pytest.param(*row, marks=pytest.mark.slow) for row in (
        ("friction from zero", (500, 508)), ("coatings", (1,)))),  # one that stays below the slip from which friction rises
])
def test_coarse_contacts_converge_and_keep_the_invariants(population: str, seeds: tuple[int, ...]) -> None:
    chosen = POPULATIONS[population]
    outcomes = [chosen.check(replace(chosen.draw(seed), numerics=COARSE)) for seed in seeds]
    assert all(not outcome.broken and (outcome.converged or outcome.excused) for outcome in outcomes), outcomes


@pytest.mark.parametrize(("population", "seeds"), [
    ("profiles", (18,)),  # one with prescribed forces, on a grid that is not square
    ("kinks and ends", (2,)), ("wear", (4,)), ("wheelsets", (1,)), ("friction across", (0,)), ("rollers", (3,)),
    ("given approaches", (660167,)),
    ("damaged files of profiles", tuple(range(8))),
    ("rising friction", (40000115,)),  # elements that slip alone between sticking ones
])  # fmt: skip
def test_drawn_cases_converge_and_keep_the_invariants(population: str, seeds: tuple[int, ...]) -> None:
    outcomes = [run_seed(population, seed) for seed in seeds]
    assert all(outcome.converged and not outcome.broken for outcome in outcomes), list(map(str, outcomes))


@pytest.mark.slow
def test_one_driver_reports_every_population_in_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What a file keeps is not solved again; what misses a target is told, and is the exit code."""
    kept = tmp_path / "outcomes.jsonl"
    arguments = ["profiles", "rising", "--first", "4", "--count", "2", "--store", str(kept), "--jobs", "1"]
    assert main(arguments) == 0
    table = capsys.readouterr().out
    assert [line.split(" | ")[:6] for line in table.splitlines()[2:4]] == [
        ["| profiles", "2", "2", "0", "0", "0"], ["| rising friction", "2", "2", "0", "0", "0"]]  # fmt: skip
    kept.write_text(kept.read_text().replace('"broken": []', '"broken": ["as if"]', 1))
    assert main(arguments) == 1
    told = capsys.readouterr()
    assert "profiles 4" in told.err and "as if" in told.err and "missed: profiles: 1 cases are broken" in told.err
    assert told.out.splitlines()[3:] == table.splitlines()[3:]


def test_a_case_that_takes_too_long_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(POPULATIONS, "contacts", replace(POPULATIONS["contacts"], limit=1e-3))
    assert run_seed("contacts", 0).broken[0].startswith("OutOfTime")


def test_a_seed_always_gives_the_same_case_and_a_file_that_can_be_read() -> None:
    for seed in range(5):
        case = stress_case(seed)
        assert stress_case(seed) == case
        assert Case.parse(case.case.to_toml()).problem == case.problem


@pytest.mark.slow
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

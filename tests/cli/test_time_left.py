"""How long a single run will go on: told on terminals, from the stages that are done."""

from __future__ import annotations

import math
import re
import types

import pytest

from tests.support.command_line import THERMAL
from thermoroll_cli.cli.progress import Progress, duration
from thermoroll_cli.cli.time_left import TimeLeft, relative_cost
from thermoroll_cli.files.case import Case
from thermoroll_cli.refinement.plan import make_plan
from thermoroll_cli.refinement.solve import solve

GRIDS = ((32, 32), (64, 64), (128, 128))
STEPS = [(stage, grid) for grid in GRIDS for stage in ("tangential", "coupling")]


def test_stages_that_scale_with_their_transforms_are_predicted_exactly() -> None:
    """tangential takes 1, coupling 3 times the transforms of its grid."""
    now, left = 100.0, TimeLeft(STEPS, 100.0)
    takes = [(1.0 if stage == "tangential" else 3.0) * relative_cost(grid) * 1e-6 for stage, grid in STEPS]
    assert math.isnan(left.seconds(now))
    for number, (step, seconds) in enumerate(zip(STEPS, takes, strict=True), start=1):
        now += seconds
        left.done(*step, now)
        if number > 1:  # both stages have been seen
            assert left.seconds(now) == pytest.approx(sum(takes[number:]))
    assert left.seconds(now) == 0.0


def test_the_time_is_counted_down_and_never_negative() -> None:
    left = TimeLeft([("tangential", (32, 32)), ("tangential", (64, 64))], 0.0)
    left.done("tangential", (32, 32), 2.0)
    whole = left.seconds(2.0)
    assert left.seconds(3.0) == whole - 1.0
    assert left.seconds(1e6) == 0.0


def test_what_is_in_no_plan_has_no_estimate() -> None:
    left = TimeLeft(STEPS, 0.0)
    left.done("tangential", (20, 20), 1.0)
    assert math.isnan(left.seconds(1.0))


@pytest.mark.parametrize("hot", [False, True])
def test_steps_of_the_plan_are_what_is_reported(hot: bool) -> None:
    values = {"numerics.grid": 32, "thermal.peclet": "stationary", "rolling.speed_m_s": 50.0 if hot else 1e-3}
    problem = Case.parse(THERMAL).with_values(values).problem
    reported: list[tuple[str, tuple[int, ...]]] = []
    solve(problem, report=lambda stage, info: reported.append((stage, tuple(info["grid"]))))
    assert reported == make_plan(problem).steps
    assert any(stage == "coupling" for stage, _ in reported) == hot


def test_a_terminal_shows_the_time_left_even_where_it_is_narrow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("thermoroll_cli.cli.streams.is_terminal", lambda stream: True)
    monkeypatch.setenv("COLUMNS", "50")
    clock = iter([0.0, 10.0, 10.2, 50.0])
    monkeypatch.setattr("thermoroll_cli.cli.progress.time", types.SimpleNamespace(monotonic=lambda: next(clock)))
    progress = Progress("a case with a long name", steps=lambda: STEPS, at_most=True)
    progress("tangential", {"grid": [32, 32], "applications": 38, "residual": 1e-5})
    progress.close()
    (shown,) = re.findall(r"\x1b\[K([^\r]+)", capsys.readouterr().err)
    assert len(shown) < 50 and shown.startswith("a case with")
    assert re.search(r", at most about \d+ min \d+ s left$", shown)


def test_durations() -> None:
    assert [duration(seconds) for seconds in (0.2, 45.4, 200.0, 7500.0)] == ["1 s", "45 s", "3 min 20 s", "2 h 5 min"]

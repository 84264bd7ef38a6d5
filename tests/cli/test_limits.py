"""Limits of scalars: `--limit` of `run` and `sweep`, its exit codes, lines and records."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, call
from thermoroll_cli.problem.limits import Limit, states_of

HERTZ = 1.5e-6 * 65.0 / (math.pi * (0.75 * 65.0 * 0.015 * 2.0 * (1.0 - 0.28**2) / 210e9) ** (2.0 / 3.0))
"""Peak pressure of two steel spheres, R 30 mm, under 65 N in MPa: 3W/(2πa²) with a = (3WR'/4E*)^⅓."""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "spheres.toml").write_text(MECHANICAL)
    return tmp_path / "spheres.toml"


@pytest.mark.parametrize(("limits", "code", "met"), [
    (["pressure_max_MPa<1200"], 0, [True]), (["pressure_max_MPa<1200", "pressure_max_MPa <= 880"], 6, [True, False]),
    (["Q_F_W>=1"], 6, [False]), (["uncertainty.force_x_N<1e3"], 0, [True]), (["force_x_N>0"], 0, [True]),
])
def test_a_run_keeps_its_limits_or_ends_with_6(
    limits: list[str], code: int, met: list[bool], case: Path, tmp_path: Path
) -> None:
    options = [word for limit in limits for word in ("--limit", limit)]
    done = call("run", case, "-o", tmp_path / "out", "--no-plots", "--json", *options)
    record = json.loads(done.stdout)
    assert (done.returncode, [one["met"] for one in record["limits"]]) == (code, met)
    assert [one["limit"] for one in record["limits"]] == [limit.replace(" ", "") for limit in limits]
    assert ("NOT MET" in done.stderr) == (code == 6)
    printed = call("run", case, "-o", tmp_path / "out", "--no-plots", *options)
    assert printed.returncode == code and all(limit.replace(" ", "") in printed.stdout for limit in limits)


def test_a_value_with_its_error_counts_and_the_worst_of_many_states() -> None:
    states = [{"a": 1.0}, {"pressure_max_MPa": 1190.0, "uncertainty.pressure_max_MPa": 20.0},
              {"pressure_max_MPa": 1195.0, "uncertainty.pressure_max_MPa": 1.0}, {"pressure_max_MPa": math.nan}]
    judged = Limit.parse("pressure_max_MPa<1200").judged(states)
    assert judged is not None and (judged.met, judged.value) == (False, 1190.0)
    judged = Limit.parse("pressure_max_MPa>1189").judged(states)
    assert judged is not None and (judged.met, judged.value) == (False, 1190.0)
    judged = Limit.parse("pressure_max_MPa<1211").judged(states)
    assert judged is not None and judged.met
    force = states_of({"force_x_N": 88.0, "friction_limit_N": 100.0, "uncertainty": {"force_x_N": 3.0}})
    judged = Limit.parse("force_x_over_friction_limit<0.9").judged(force)
    assert judged is not None and (judged.met, judged.error) == (False, 0.03)
    unknown = Limit.parse("pressure_max_MPa<1200").judged([{"pressure_max_MPa": 1190.0}])
    assert unknown is not None and unknown.met and not unknown.known


@pytest.mark.parametrize("scalar", ["von_mises_max_lower_MPa", "force_x_N_mm"])
def test_a_limit_on_what_a_result_lacks_is_wrong_usage(scalar: str, case: Path, tmp_path: Path) -> None:
    for command in (("run", case), ("sweep", case, "--over", "load.normal_N=50,60")):
        done = call(*command, "-o", tmp_path / command[0], "--no-plots", "-q", "--limit", f"{scalar}<1")
        assert done.returncode == 2 and f"this result has no {scalar}" in " ".join(done.stderr.split())


def test_a_sweep_has_a_column_for_each_limit(case: Path, tmp_path: Path) -> None:
    over = ("--over", "load.normal_N=50,65,100", "--no-plots", "-o", tmp_path / "out")
    done = call("sweep", case, *over, "--limit", "pressure_max_MPa<1000")
    assert done.returncode == 6 and "pressure_max_MPa<1000: NOT MET at 1 of 3 points: spheres_0003 (103" in done.stdout
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert [row["pressure_max_MPa<1000"] for row in rows] == ["met", "met", "not met"]
    done = call("sweep", case, *over, "--limit", "pressure_max_MPa<1200", "--json")
    assert done.returncode == 0
    assert [json.loads(line)["limits"][0]["met"] for line in done.stdout.splitlines()] == [True] * 3


def test_the_worst_row_of_a_history_decides_in_a_run_and_in_a_sweep(case: Path, tmp_path: Path) -> None:
    """Over a load of 40, 65 and 40 N the pressure is largest in the middle: Hertz's, without friction that acts back."""
    case.write_text(MECHANICAL.replace("grid = 16", "grid = 12") + """[history]
distance_mm = [0.0, 0.1, 0.2]
steps = 4
values = { "load.normal_N" = [40.0, 65.0, 40.0] }
""")
    swept = ("sweep", case, "--over", "creepage.longitudinal=0.001,0.002", "--no-plots", "-q", "-o", tmp_path / "out")
    for limit, code in ((f"pressure_max_MPa<{HERTZ - 40.0}", 6), (f"pressure_max_MPa<{HERTZ + 40.0}", 0),
                        (f"pressure_max_MPa>{HERTZ * (40.0 / 65.0) ** (1.0 / 3.0) - 40.0}", 0),
                        (f"pressure_max_MPa>{HERTZ - 40.0}", 6)):
        assert (done := call(*swept, "--limit", limit, "--resume")).returncode == code, limit
    for limit, code in ((f"pressure_max_MPa<{HERTZ - 40.0}", 6), (f"pressure_max_MPa<{HERTZ + 40.0}", 0)):
        assert call("run", case, "--no-plots", "-q", "-o", tmp_path / "run", "--limit", limit).returncode == code
    assert "NOT MET at spheres_0001 (76" in done.stderr

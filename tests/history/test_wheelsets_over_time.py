"""Wheelsets over time: the same contacts over time in the balance of a wheelset."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from tests.support.command_line import call
from tests.support.soft_wheel import RADIUS, SOFT, WHEEL, wheel
from thermoroll_cli import Case, solve
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.many_contacts.history.course import OF_WHEELSETS, SHIFTS, VARIED

CASES = Path(__file__).parents[2] / "cases"
BALL: dict[str, Any] = {
    "material": SOFT,
    "geometry": {"lower_radius_x_mm": math.inf, "lower_radius_y_mm": math.inf, "upper_radius_x_mm": RADIUS,
                 "upper_radius_y_mm": RADIUS},
    "load": {"approach_um": 220.1, "friction_coefficient": 0.4},
    "creepage": {"longitudinal": -0.004},
    "rolling": {"speed_m_s": 1.0, "differential_slip": False},
    "numerics": {"grid": 16},
    "history": {"distance_mm": [0, 10], "steps": 5, "begin": "pressed"},
}


LINE = {**BALL, "geometry": {**BALL["geometry"], "upper_radius_y_mm": math.inf},
        "load": {"normal_N_mm": 4.0, "friction_coefficient": 0.4}, "history": {**BALL["history"], "length_mm": 30.0}}


def column(case: dict[str, Any], name: str) -> np.ndarray[Any, Any]:
    history = solve(case).history
    assert history is not None
    return np.array(history[name])


def test_a_wheel_is_the_contact_that_it_has() -> None:
    here, there = column(wheel(), "track_force_x_N"), column(BALL, "force_x_N")
    assert np.abs(np.abs(here) - np.abs(there)).max() < 0.01 * np.abs(there).max()
    assert here[0] == 0.0 and np.abs(here[-1]) > np.abs(here[1]) > 0.0


@pytest.mark.slow
def test_constant_inputs_stay_in_the_steady_state_and_end_there() -> None:
    steady = solve({key: table for key, table in WHEEL.items() if key != "history"})["track_force_x_N"]
    stays = solve(wheel(history={"begin": "steady", "steps": 3}))
    assert stays.history is not None and stays.converged
    change = np.abs(np.array(stays.history["track_force_x_N"]) - steady)
    assert (change < np.array(stays.history["uncertainty.track_force_x_N"])).all()
    assert np.ptp(stays.history["track_force_x_N"]) < 1e-3 * abs(steady)
    ends = solve(wheel(history={"distance_mm": [0, 60], "steps": 12}))
    assert abs(ends["track_force_x_N"] - steady) < ends.uncertainty["track_force_x_N"] < 0.15 * abs(steady)


@pytest.mark.slow
def test_the_path_is_mirrored_with_the_wheel() -> None:
    """Also of a wheel that carries a load and rolls freely on a path: its velocity across is that of the path."""
    free = {"height_mm": None, "vertical_N": 237.0, "angular_velocity_rad_s": None}
    path = {"begin": "steady", "distance_mm": [0, 8, 16], "steps": 4}

    def forces(side: str, sign: float) -> list[float]:
        values = {"wheelset.yaw_mrad": [0.0, 2.0 * sign, 0.0], "wheelset.lateral_shift_mm": [0.0, 0.01 * sign, 0.02 * sign]}
        return column(wheel(wheelset=free | {"wheels": side}, track={"right": None, side: {"origin_mm": [0.0, 0.0]}},
                            history=path | {"values": values}, numerics={"grid": 12}), "track_force_y_N").tolist()

    right = forces("right", 1.0)
    assert forces("left", -1.0) == pytest.approx([-force for force in right], rel=1e-4)
    assert np.ptp(right) > 1.0


@pytest.mark.slow
def test_a_patch_that_wanders_across_the_rail() -> None:
    """A domain of all rows reaches beyond the ends that the patch's surfaces have at one of them. Each row is far from the one
    before, and the steady state of its place."""
    case = json.loads(Case.read(CASES / "manchester.toml").to_json())
    case |= {"thermal": {"heat": False}, "numerics": {"grid": 12}}
    wheelset = case["wheelset"] | {"wheels": "left", "yaw_mrad": 0.0, "vertical_N": 10e3, "angular_velocity_rad_s": 4.35}
    path = {"distance_mm": [0.0, 1e4], "steps": 2, "values": {"wheelset.lateral_shift_mm": [1.5, 0.0]}}
    over_time = solve(case | {"wheelset": wheelset, "history": path})
    assert over_time.converged and over_time.history is not None
    middle = solve(case | {"wheelset": wheelset | {"lateral_shift_mm": 0.75, "lateral_velocity_mm_s": -0.3}})
    for name in ("track_force_x_N", "track_force_y_N"):
        assert over_time.history[name][1] == pytest.approx(middle[name], abs=100.0)


def test_patches_that_appear_on_the_way_are_heated() -> None:
    """From the tread to the flange by steps that are far longer than a contact: the last row is the steady state."""
    wheel = Case.read(CASES / "manchester.toml").with_values({
        "wheelset.wheels": "right", "wheelset.yaw_mrad": 0.0, "wheelset.roll_mrad": 0.0,
        "wheelset.angular_velocity_rad_s": 4.36, "wheelset.vertical_N": 10e3, "numerics.grid": 12})
    moves = solve(wheel.with_values({"history": {
        "distance_mm": [0.0, 2000.0], "steps": 2, "values": {"wheelset.lateral_shift_mm": [0.0, 4.0]}}}))
    steady = solve(wheel.with_values({"wheelset.lateral_velocity_mm_s": 4.0}))
    assert moves.converged
    assert moves["Q_F_right_W"] == pytest.approx(steady["Q_F_right_W"], rel=1e-3)
    assert moves["temperature_rise_max_lower_K"] == pytest.approx(steady["temperature_rise_max_lower_K"], rel=0.05)


def test_rows_beyond_friction_have_a_reason_and_spoil_no_other(tmp_path: Path) -> None:
    """Friction carries 95 N: of 0 to 120 N in three rows the last one is too much."""
    free = {"height_mm": None, "vertical_N": 237.0, "angular_velocity_rad_s": None}
    history = {"begin": "steady", "steps": 2, "values": {"wheelset.traction_N": [0.0, 120.0]}}
    (tmp_path / "pulls.toml").write_text(tomli_w.dumps(wheel(wheelset=free, history=history)))
    ended = call("run", tmp_path / "pulls.toml", "-o", tmp_path, "--no-plots")
    assert ended.returncode == 4 and "1 of 3 rows were not solved, the first one at 0.01 s" in ended.stdout
    table = read_table(tmp_path / "pulls_history.csv")
    assert list(table["status"]) == ["converged"] * 2 + ["not_converged"]
    assert "friction carries" in table["reason"][-1]
    errors = np.array(table["uncertainty.track_force_x_N"])
    assert (errors[:-1] < 5.0).all() and np.isnan(errors[-1])


def test_rows_without_friction_have_no_error_of_friction() -> None:
    """The rails feel no force along the track there, and ± of other rows are no larger than μN besides the force."""
    slippery = {"distance_mm": [0, 4, 8], "steps": 2, "values": {"load.friction_coefficient": [0.0, 1e-3, 0.4]}}
    found = solve(wheel(history=slippery)).history
    assert found is not None
    for name in ("track_force_x_N", "track_force_x_right_N", "Q_F_W", "shear_max_MPa"):
        assert found[name][0] == found[f"uncertainty.{name}"][0] == 0.0 < found[f"uncertainty.{name}"][2]
    limit = 1e-3 * found["track_force_z_N"][1]
    assert abs(found["track_force_x_N"][1]) <= limit and found["uncertainty.track_force_x_N"][1] <= 2.0 * limit


def test_a_file_goes_on_where_it_ended(tmp_path: Path) -> None:
    coarse = {"grid": 8}
    whole = column(wheel(history={"distance_mm": [0, 4], "steps": 4}, numerics=coarse), "track_force_x_N")
    for name, begin in (("first", "pressed"), ("second", "first.h5")):
        half = wheel(history={"distance_mm": [0, 2], "steps": 2, "begin": begin}, numerics=coarse)
        (tmp_path / f"{name}.toml").write_text(tomli_w.dumps(half))
    for name in ("first", "second"):
        ended = call("run", tmp_path / f"{name}.toml", "-o", tmp_path, "--plots", "all" if name == "second" else "none")
        assert ended.returncode == 0, ended.stderr
    parts = [read_table(tmp_path / f"{name}_history.csv")["track_force_x_N"] for name in ("first", "second")]
    assert parts[0][-1] == pytest.approx(parts[1][0], rel=1e-4)
    # The first step from a file knows one state alone, and is of first order.
    assert [*parts[0], *parts[1][1:]] == pytest.approx(whole, abs=0.02 * abs(whole[-1]))
    assert {f"second_{kind}.png" for kind in ("section", "patches", "history")} <= {path.name for path in tmp_path.iterdir()}
    last = read_result(tmp_path / "second.h5")
    assert last.assembly == "wheelset" and last["track_force_x_N"] == pytest.approx(parts[1][-1])


@pytest.mark.parametrize(("base", "keys"), [
    (BALL, [key for key in VARIED if not key.endswith("N_mm") and key not in SHIFTS]),
    (LINE, ["load.normal_N_mm", "force.longitudinal_N_mm", "force.lateral_N_mm"]), (WHEEL, list(OF_WHEELSETS)),
], ids=["contact", "line", "wheelset"])  # fmt: skip
def test_a_value_over_time_means_what_its_key_means(base: dict[str, Any], keys: list[str]) -> None:
    """A history makes its problems of values by a mapping of its own: it agrees with that of cases, key by key."""
    for key in keys:
        table, _, name = key.partition(".")
        tables = {other: given for other, given in base.items() if (table, other) != ("force", "creepage")}
        tables |= {"thermal": {"partition": "matched", "heat": False}} if table == "thermal" else {}
        if name in ("normal_N", "approach_um", "vertical_N"):  # exclude another key of the case
            rest = {other: value for other, value in base[table].items() if other not in ("approach_um", "height_mm")}
            tables[table] = {**rest, name: 80.0}
        elif key == "wheelset.traction_N":
            tables[table] = {other: value for other, value in base[table].items() if other != "angular_velocity_rad_s"}
        value = {"wheelset.height_mm": 0.19, "wheelset.angular_velocity_rad_s": 9.9}.get(key, 0.7)
        history = {**base["history"], "begin": "steady", "values": {key: [value, value]}}
        over = Case.from_dict({**tables, "history": history}).task
        alone = Case.from_dict({name: table for name, table in tables.items() if name != "history"}).with_values({key: value})
        assert replace(over.problem_at(0.0), **({"length": math.inf} if base is LINE else {})) == alone.task, key

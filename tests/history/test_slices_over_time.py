"""Tracks that change and wheels that are not round, over time: beside plain tracks, steady wheels at the same places, exact
geometry, mirror images and histories in two parts."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.soft_wheel import CROWN, RADIUS, column, wheel
from thermoroll_cli import Case, Result, solve
from thermoroll_cli.many_contacts.history.wheelset_over_time import warnings_over_time
from thermoroll_cli.many_contacts.wheelset.first_contact import touching

FAR = np.arange(-500.0, 501.0, 100.0)
PLACES = np.arange(-60.0, 61.0, 20.0)


def rail(z: float = 0.0, y: float = 0.0) -> list[list[float]]:
    return [[across + y, down + z] for across, down in CROWN[::8]]


def sections(places: Any, outlines: list[list[list[float]]]) -> dict[str, Any]:
    return {"sections": [{"at": float(at), "points_mm": points} for at, points in zip(places, outlines, strict=True)],
            "flip": False, "points_mm": None}  # fmt: skip


ASIDE = sections(PLACES, [rail(-0.02 * s, 0.1 * s) for s in PLACES])
"""A rail that rises 1:50 and moves aside by 1:10."""
STEPS: dict[str, Any] = {"distance_mm": [0, 3], "steps": 1}


def case_of(
    profile: dict[str, Any], history: dict[str, Any] | None = STEPS, side: str = "right", **wheelset: Any
) -> dict[str, Any]:
    """A wheel under a load on a rail with a profile, which turns freely but for .4 %."""
    other = {"left": "right", "right": "left"}[side]
    loaded = {"height_mm": None, "vertical_N": 237.0, "wheels": side, **wheelset}
    case = wheel(track={"rail_profile": profile, other: None, side: {"origin_mm": [0.0, 0.0]}}, wheelset=loaded,
                 numerics={"grid": 8, "extent": 3.2}, history=history or {})
    return case if history else {name: table for name, table in case.items() if name != "history"}


def rolled(*given: Any, **wheelset: Any) -> Result:
    result: Result = solve(Case.from_dict(case_of(*given, **wheelset)))
    assert result.converged, result.reason
    return result


@cache
def aside() -> Result:
    return rolled(ASIDE)


@pytest.mark.parametrize(("profile", "near"), [
    (sections(PLACES, 7 * [rail()]), 1e-9),
    pytest.param(sections(FAR, [rail(float(abs(s) == 500.0)) for s in FAR]), 0.015, marks=pytest.mark.slow)],
    ids=["everywhere", "far away"])  # fmt: skip
def test_slices_that_are_all_the_same_are_the_plain_track_over_time(profile: dict[str, Any], near: float) -> None:
    """To rounding; and as nearly as 8 elements show where they differ far away alone."""
    plain, sliced = rolled({"points_mm": rail()}), rolled(profile)
    for name in ("height_mm", "pressure_max_MPa", "track_force_x_N", "contact_area_mm2"):
        np.testing.assert_allclose(column(sliced, name), column(plain, name), rtol=near, atol=1e-12, err_msg=name)


@pytest.mark.slow
def test_rows_far_apart_are_steady_wheels_at_their_places() -> None:
    over_time = rolled(ASIDE, {"distance_mm": [0, 40], "steps": 1, "begin": "steady"}, position_mm=-20.0)
    np.testing.assert_allclose(column(over_time, "position_mm"), [-20.0, 20.0], atol=1e-9)
    np.testing.assert_allclose(column(over_time, "rotation_deg"), [0.0, math.degrees(0.996 * 40.0 / RADIUS)], atol=1e-9)
    for row, place in enumerate((-20.0, 20.0)):
        steady = rolled(ASIDE, None, position_mm=place)
        for name, near in (("height_mm", 0.01), ("pressure_max_MPa", 5e-3), ("track_force_x_N", 0.03)):
            assert column(over_time, name)[row] == pytest.approx(steady[name], rel=near), (name, place)


def test_a_rail_that_is_placed_by_gauge_and_top_stays_where_it_lay() -> None:
    case = case_of(ASIDE)
    case["track"] |= {"right": None, "gauge_mm": 1435.0, "gauge_height_mm": 1.0}
    task = Case.from_dict({**case, "track": {name: table for name, table in case["track"].items() if table is not None}}).task
    here, there = (task.problem_at(place).rails["right"].samples[:2] for place in (0.0, 3e-3))
    assert there[1].min() - here[1].min() == pytest.approx(-0.02 * 3e-3, abs=1e-8)
    assert there[0].mean() - here[0].mean() == pytest.approx(0.1 * 3e-3, abs=1e-8)


@pytest.mark.slow
def test_a_history_goes_on_where_the_one_before_ended(tmp_path: Path) -> None:
    """A rail that rises evenly is the same all along: the tractions go on as they were. The first step after a file is of first
    order, on any track."""
    rising = sections((-100.0, 0.0, 100.0), [rail(-0.02 * s) for s in (-100.0, 0.0, 100.0)])
    whole = rolled(rising, {"distance_mm": [0, 6], "steps": 2})
    rolled(rising).save(tmp_path / "first.h5")
    second = rolled(rising, {"distance_mm": None, "time_s": [0, 3e-3], "steps": 1, "begin": str(tmp_path / "first.h5")})
    assert column(second, "position_mm") == pytest.approx([3.0, 6.0], abs=1e-9)
    assert column(second, "track_force_x_N")[0] == pytest.approx(column(whole, "track_force_x_N")[1], rel=1e-5)
    for name, near in (("pressure_max_MPa", 1e-3), ("height_mm", 1e-3), ("contact_area_mm2", 1e-3)):
        np.testing.assert_allclose(column(second, name), column(whole, name)[1:], rtol=near, err_msg=name)


def test_a_wheel_with_a_flat_comes_down_by_its_chord_once_a_turn() -> None:
    """A rigid one: by R(1 − cos φ) when the edge stands φ from below the axle, and the same after a turn of 2πR."""
    half, degrees = math.asin(10.0 / RADIUS), np.concatenate((np.linspace(-12.0, 12.0, 97), np.arange(20.0, 341.0, 20.0)))
    radii = np.where(np.abs(np.radians(degrees)) < half, RADIUS * math.cos(half) / np.cos(np.radians(degrees)), RADIUS)
    flat = sections(degrees, [[[40.0, float(r) - RADIUS], [-40.0, float(r) - RADIUS]] for r in radii])
    case = case_of({"points_mm": rail()}, {"distance_mm": [0, 700], "steps": 100}, wheel_profile=flat, rotation_deg=-6.0,
                   angular_velocity_rad_s=10.0)
    task = Case.from_dict(case).task
    turn = 2.0 * math.pi * RADIUS
    for edge in (0.0, 0.5 * half, half, 1.5 * half):
        rolled_mm = RADIUS * (math.radians(6.0) - half + edge)
        lower = RADIUS * (1.0 - math.cos(min(edge, 2.0 * half - edge)))
        for distance in (rolled_mm, rolled_mm + turn):
            position = touching(task.problem_at(1e-3 * distance))["right"].position
            assert 1e3 * position.z == pytest.approx(lower, abs=6e-3), (edge, distance)
    (warning,) = [each for each in warnings_over_time(task) if "waves" in each and "steps" in each]
    assert "steps of 7 mm are long beside waves of" in warning and "of the right wheel" in warning


@pytest.mark.slow
def test_a_surface_on_a_rail_that_changes_lifts_the_wheel_once() -> None:
    """Heights that are the same everywhere, over slices."""
    level = {"kind": "wave", "amplitude_um": 100.0, "wavelength_mm": 1e6}
    smooth, case = aside(), case_of(ASIDE)
    case["track"]["surface"] = level
    lifted = solve(Case.from_dict(case))
    assert lifted.converged, lifted.reason
    np.testing.assert_allclose(column(smooth, "height_mm") - column(lifted, "height_mm"), 0.1, atol=1e-3)
    np.testing.assert_allclose(column(lifted, "pressure_max_MPa"), column(smooth, "pressure_max_MPa"), rtol=5e-3)


def test_the_command_follows_a_track_that_changes(tmp_path: Path) -> None:
    (tmp_path / "track.toml").write_text(Case.from_dict(case_of(ASIDE)).to_toml())
    shown = json.loads(call("show", tmp_path / "track.toml", "--json").stdout)
    assert "first_contact_height_mm" in str(shown)
    call("run", tmp_path / "track.toml", "-o", tmp_path / "out")
    header, *rows = (tmp_path / "out" / "track_history.csv").read_text().splitlines()
    assert "position_mm" in header and "rotation_deg" in header and len(rows) == 2
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"track.h5", "track_history.h5", "track_gap.png", "track_history.png"} <= written

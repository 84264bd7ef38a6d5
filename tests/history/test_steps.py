"""Contacts over time: references, closed forms, the order, and what must not change."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.problems import elastic, rolling, spheres
from tests.support.sampling import sampled
from thermoroll_cli.exact.cattaneo_mindlin import cattaneo_mindlin
from thermoroll_cli.many_contacts.history.course import Begin, Course, History
from thermoroll_cli.many_contacts.history.solve import HistorySolver
from thermoroll_cli.many_contacts.history.steps import Moment, Steps
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.arrays import Array

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "transient_creepages.json").read_text())
WEIGHT, MU, RADIUS = 0.4705, 0.4, 0.16873
RUBBER = elastic(0.28, 2.56e6)  # G = 1 MPa
ALONG, ACROSS, SPIN = "creepage.longitudinal", "creepage.lateral", "creepage.spin_rad_mm"
DISTANCES = 1e-3 * np.array(REFERENCE["s_mm"])


def ball(grid: int = 24, **motion: object) -> Problem:
    return rolling(grid=grid, geometry=Geometry(math.inf, math.inf, RADIUS, RADIUS), body=RUBBER, load=WEIGHT, friction=MU,
                   **motion)  # type: ignore[arg-type]


def history(problem: Problem, places: Sequence[float], values: Mapping[str, Sequence[float]], *, by_distance: bool = True,
            begin: Begin = "steady", rows: Array | None = None) -> list[Moment]:
    """The moments of a history on the grid of the problem, at its `rows` (by default the places)."""
    course = Course(tuple(places), {key: tuple(given) for key, given in values.items()}, by_distance, begin=begin)
    assert problem.numerics.grid is not None
    return list(Steps(History(problem, course), problem.numerics.grid).moments(course.rows if rows is None else rows))


def column(moments: Sequence[Moment], name: str) -> Array:
    return np.array([moment.reported.scalars[name] for moment in moments])


def forces(moments: Sequence[Moment]) -> Array:
    return np.stack([column(moments, "force_x_N"), column(moments, "force_y_N")], axis=1)


def inputs(name: str, rows: Array) -> tuple[Sequence[float], dict[str, Sequence[float]]]:
    if name == "wave":
        return tuple(rows), {ALONG: tuple(0.0015 + 0.001 * np.sin(2.0 * math.pi * rows / 7e-3))}
    if name == "step":
        return (0.0, 0.0, 14e-3), {ALONG: (0.001, 0.003, 0.003)}
    return (0.0, 0.0, 14e-3), {ACROSS: (0.0, 0.001, 0.001), SPIN: (0.0, -0.0006, -0.0006)}


@cache
def of_reference(name: str) -> list[Moment]:
    """A case of the reference on 32 × 32 elements, which several tests look at."""
    return history(ball(32), *inputs(name, DISTANCES), rows=DISTANCES)


# --- references and closed forms -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sampled(REFERENCE["cases"], 3))
def test_creepages_that_change(name: str) -> None:
    moments = of_reference(name)
    assert all(moment.converged for moment in moments)
    difference = forces(moments) / (MU * WEIGHT) - REFERENCE["cases"][name]["force"]
    assert math.sqrt((difference**2).sum(axis=1).mean()) < 1.8e-3
    assert np.mean([moment.applications for moment in moments[1:]]) < 18


@pytest.mark.slow
def test_the_order_is_two() -> None:
    """Halving the elements and the steps of smooth inputs divides the error by about four."""
    coarse = history(ball(16), *inputs("wave", DISTANCES[::2]), rows=DISTANCES[::2])
    exact = MU * WEIGHT * np.array(REFERENCE["cases"]["wave"]["force"])[::2, 0]
    errors = [np.abs(column(moments, "force_x_N") - exact).mean() for moments in (coarse, of_reference("wave")[::2])]
    assert errors[0] / errors[1] > 3.0


def test_shift_by_a_force() -> None:
    """Cattaneo and Mindlin, who leave out slip across the force: good to some 1e-3."""
    force = 0.7 * MU * WEIGHT
    moments = history(ball(32, force=(0.0, None), speed=0.0), (0.0, 1.0), {"force.longitudinal_N": (0.0, force)},
                      by_distance=False, begin="pressed", rows=np.linspace(0.0, 1.0, 5))
    last = moments[-1].reported.scalars
    radius = (0.75 * WEIGHT * RADIUS * 0.72 / 1e6) ** (1.0 / 3.0)
    exact = cattaneo_mindlin(radius, 1.5 * WEIGHT / math.pi / radius**2, MU, force)
    assert last["shift_x_um"] == pytest.approx(2e6 * exact.shift(1e6, 0.28), rel=3e-3)
    assert last["gamma_st"] == pytest.approx((exact.stick_radius / radius) ** 2, rel=0.05)
    assert last["force_x_N"] == pytest.approx(force, rel=1e-4)
    assert math.isnan(last["creepage_longitudinal"])
    # A given shift needs the same force.
    shift = last["shift_x_um"]
    back = history(ball(32, speed=0.0), (0.0, 1.0), {"shift.longitudinal_um": (0.0, shift)}, by_distance=False, begin="pressed",
                   rows=np.linspace(0.0, 1.0, 5))
    assert column(back, "force_x_N")[-1] == pytest.approx(force, rel=1e-3)


def test_slip_narrower_than_an_element_is_covered() -> None:
    """A tenth of the largest force: slip is a quarter of an element wide, and the exact stick (1 − q)^(2/3) of the area."""
    course = Course((0.0, 1.0), {"force.longitudinal_N": (0.0, 0.1 * MU * WEIGHT)}, steps=3, begin="pressed")
    found = HistorySolver().solve(History(ball(16, force=(0.0, None), speed=0.0), course))
    away = abs(found["gamma_st"] - 0.9 ** (2.0 / 3.0))
    assert 0.5 < away / found.uncertainty["gamma_st"] < 1.0


@pytest.mark.slow
def test_a_cycle_of_the_force() -> None:
    """Johnson, Contact Mechanics, Sec. 7.4: the energy of a loop; the second one repeats the first."""
    q, steps = 0.7, 6
    force = q * MU * WEIGHT
    moments = history(ball(24, force=(0.0, None), speed=0.0), (0.0, 1.0, 3.0, 5.0, 7.0, 9.0),
                      {"force.longitudinal_N": (0.0, force, -force, force, -force, force)}, by_distance=False, begin="pressed",
                      rows=np.linspace(0.0, 9.0, 9 * steps + 1))
    radius = (0.75 * WEIGHT * RADIUS * 0.72 / 1e6) ** (1.0 / 3.0)
    exact = 1.8 * (MU * WEIGHT) ** 2 / radius * 1.72e-6 * (
        1.0 - (1.0 - q) ** (5 / 3) - 5.0 * q / 6.0 * (1.0 + (1.0 - q) ** (2 / 3)))
    heat, shift = column(moments, "heat_J"), column(moments, "shift_x_um")
    assert heat[5 * steps] - heat[steps] == pytest.approx(exact, rel=0.03)
    assert heat[9 * steps] - heat[5 * steps] == pytest.approx(heat[5 * steps] - heat[steps], rel=1e-3)
    assert np.allclose(shift[5 * steps :], shift[steps : 5 * steps + 1], atol=1e-3 * np.abs(shift).max())
    work = column(moments, "work_J")
    assert work[9 * steps] - work[5 * steps] == pytest.approx(exact, rel=0.03)


def test_rows_pass_over_no_turning_point_without_rolling() -> None:
    """The path alone counts: a force that turns back between two rows has reached its largest value."""
    force = 0.7 * MU * WEIGHT
    ends = [column(history(ball(16, force=(0.0, None), speed=0.0), (0.0, 1.0, 2.0), {"force.longitudinal_N": (0.0, force, 0.0)},
                           by_distance=False, begin="pressed", rows=rows), "shift_x_um")[-1]
            for rows in (np.linspace(0.0, 2.0, 5), np.array([0.0, 0.6, 1.4, 2.0]))]
    assert ends[0] > 0.0 and ends[1] == pytest.approx(ends[0], rel=1e-3)


def test_from_a_shift_to_rolling() -> None:
    """A force that has shifted the bodies drives them when they roll: it ends in steady rolling."""
    force = 0.657 * MU * WEIGHT
    problem = ball(16, force=(0.0, None))
    rows = np.concatenate([np.linspace(0.0, 1.0, 4), 1.0 + np.linspace(0.0, 14.0, 29)[1:]])
    moments = history(problem, (0.0, 1.0, 1.0, 15.0), {
        "rolling.speed_m_s": (0.0, 0.0, 1e-3, 1e-3), "force.longitudinal_N": (0.0, force, force, force)},
        by_distance=False, begin="pressed", rows=rows)
    steady = history(problem, (0.0, 1.0), {"force.longitudinal_N": (force, force)})[0]
    found = column(moments, "creepage_longitudinal")
    assert found[-1] == pytest.approx(steady.reported.scalars["creepage_longitudinal"], rel=3e-3)
    assert 0.5 < found[4] / found[-1] < 0.7 and np.isnan(found[:4]).all()
    assert moments[-1].distance == pytest.approx(14e-3) and moments[3].distance == 0.0


# --- energy ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sampled(REFERENCE["cases"], 3))
def test_energy_is_conserved(name: str) -> None:
    """Work is heat and elastic energy, step by step, to the error of the step."""
    moments = of_reference(name)
    stored, work, heat = (column(moments, scalar) for scalar in ("elastic_energy_J", "work_J", "heat_J"))
    assert np.abs(work - heat - (stored - stored[0])).max() < 3e-3 * np.ptp(work)
    assert (np.diff(heat) >= 0.0).all()


# --- what changes nothing ----------------------------------------------------------------------------------------------


UNLIKE = {"lower": elastic(0.2, 2.56e6), "upper": elastic(0.45, 8e6)}
EVERYTHING = {ALONG: (0.001, 0.001), ACROSS: (-0.0005, -0.0005), SPIN: (2e-4, 2e-4)}


@pytest.mark.parametrize("unlike", [False, True])
def test_the_steady_state_stays(unlike: bool) -> None:
    problem = replace(ball(20), **UNLIKE) if unlike else ball(20)
    moments = history(problem, (0.0, 14e-3), EVERYTHING, rows=np.array([0.0, 1e-5, 3e-4, 1e-3, 1.1e-3, 14e-3]))
    found = forces(moments)
    assert np.abs(found - found[0]).max() < 1e-4 * MU * WEIGHT
    assert [moment.applications for moment in moments[1:]] == pytest.approx([6] * 5, abs=6)


LOADED = {"load.normal_N": (WEIGHT, 1.4 * WEIGHT, 0.7 * WEIGHT), ALONG: (0.0, 0.001, -0.001), ACROSS: (0.0005, 0.0, 0.001),
          SPIN: (0.0, -4e-4, 4e-4)}
PLACES, ROWS = (0.0, 3e-3, 6e-3), np.linspace(0.0, 6e-3, 9)


@pytest.mark.slow
def test_mirror_and_exchange() -> None:
    """On any grid."""
    problem = replace(ball(10), **UNLIKE)
    found = forces(history(problem, PLACES, LOADED, rows=ROWS))
    mirrored = {key: [-value for value in given] if key in (ACROSS, SPIN) else given for key, given in LOADED.items()}
    other = forces(history(problem, PLACES, mirrored, rows=ROWS))
    assert np.allclose(found * (1, -1), other, atol=1e-4 * MU * WEIGHT)
    # The other body is looked at from the other side: creepages along change their signs, and so do forces along.
    geometry = problem.geometry
    assert isinstance(geometry, Geometry)
    exchanged = replace(problem, lower=problem.upper, upper=problem.lower,
                        geometry=Geometry(RADIUS, RADIUS, math.inf, math.inf))
    given = {key: [-value for value in given] if key in (ALONG, ACROSS, SPIN) else given for key, given in LOADED.items()}
    other = forces(history(exchanged, PLACES, given, rows=ROWS))
    assert np.allclose(found, -other, atol=1e-4 * MU * WEIGHT)


def test_half_the_speed_takes_twice_the_time() -> None:
    slow, fast = (history(ball(12, speed=speed), [time / speed for time in PLACES], LOADED, by_distance=False,
                          rows=ROWS / speed) for speed in (0.5, 1.0))
    assert np.array_equal(forces(slow), forces(fast))
    assert [moment.time for moment in slow] == [2.0 * moment.time for moment in fast]
    assert column(slow, "Q_F_W") == pytest.approx(0.5 * column(fast, "Q_F_W"))
    assert column(slow, "heat_J") == pytest.approx(column(fast, "heat_J"))


def test_a_speed_that_changes_is_felt_by_time_alone() -> None:
    """The distance at a time, and the time at a distance, are integrals of the speed; forces depend on distance alone."""
    steady = history(ball(12), PLACES, LOADED, rows=ROWS)
    moved = history(ball(12), PLACES, {**LOADED, "rolling.speed_m_s": (1.0, 3.0, 0.5)}, rows=ROWS)
    assert np.allclose(forces(steady), forces(moved), atol=1e-12)
    assert moved[-1].time == pytest.approx(3e-3 * (math.log(3.0) / 2.0 + math.log(6.0) / 2.5))
    by_time = history(ball(12), (0.0, 2.0), {"rolling.speed_m_s": (0.0, 1e-3), ALONG: (0.0, 0.0)}, by_distance=False,
                      begin="pressed", rows=np.array([0.0, 1.0, 2.0]))
    assert [moment.distance for moment in by_time] == pytest.approx([0.0, 0.25e-3, 1e-3])


def test_a_history_goes_on_from_a_result() -> None:
    """From the result of its own steady state nothing changes, on its grid and on another one."""
    problem = replace(ball(24), motion=replace(ball().motion, creepage_x=0.001, creepage_y=-0.0005, spin=0.2))
    steady = solve(problem)
    for n, close in ((24, 1e-3), (20, 2e-2)):
        moments = history(replace(problem, numerics=ball(n).numerics), (0.0, 2e-3), {ALONG: (0.001, 0.001)}, begin=steady,
                          rows=np.array([0.0, 1e-3, 2e-3]))
        found = forces(moments)
        assert np.abs(found - found[0]).max() < close * MU * WEIGHT


def test_a_state_from_another_grid_keeps_its_force() -> None:
    """Its tractions are interpolated: a warning says how much was lost on the way, and errors count it."""

    def shifted(n: int, begin: Begin, *shifts: float) -> Result:
        course = Course((0.0, 1.0), {"shift.longitudinal_um": shifts}, steps=3, begin=begin)
        return HistorySolver().solve(History(ball(n, speed=0.0), course))

    first = shifted(16, "pressed", 0.0, 6.0)
    found, whole = shifted(20, first, 6.0, 9.0), shifted(20, "pressed", 0.0, 9.0)
    assert found.history is not None and found.history["force_x_N"][0] == pytest.approx(first["force_x_N"], rel=1e-9)
    assert "4.2 % of its force was lost" in found.warnings[-1] and not whole.warnings
    away = abs(found["force_x_N"] - whole["force_x_N"])
    assert 0.1 < away / found.uncertainty["force_x_N"] < 1.0


@pytest.mark.slow
def test_loads_that_change() -> None:
    """Elements and steps halved: the forces agree with those of the finer ones to second order."""
    wave = 1.0 + 0.3 * np.sin(2.0 * math.pi * np.linspace(0.0, 14e-3, 57) / 7e-3)
    found = []
    for n, steps in ((8, 14), (16, 28)):
        moments = history(ball(n), np.linspace(0.0, 14e-3, 57), {"load.normal_N": WEIGHT * wave, ALONG: [0.0015] * 57},
                          rows=np.linspace(0.0, 14e-3, steps + 1))
        assert column(moments, "normal_N") == pytest.approx(WEIGHT * wave[:: 56 // steps])
        found.append(forces(moments)[:: steps // 14, 0])
    assert np.abs(found[1] - found[0]).max() < 2.5e-2 * MU * WEIGHT
    by_approach = history(ball(16), (0.0, 7e-3), {"load.approach_um": (70.0, 90.0), ALONG: (0.0015, 0.0015)},
                          rows=np.linspace(0.0, 7e-3, 5))
    assert column(by_approach, "normal_N") == pytest.approx(
        column(by_approach, "normal_N")[0] * (np.linspace(70.0, 90.0, 5) / 70.0) ** 1.5, rel=1e-6)


@pytest.mark.slow
def test_rows_change_nothing_but_the_steps() -> None:
    """A jump between two rows is a step of its own, and both parities of the grid, and one that is not square, agree."""
    places, values = (0.0, 1.1e-3, 1.1e-3, 6e-3), {ALONG: (0.001, 0.001, 0.003, 0.003)}
    rows = np.linspace(0.0, 6e-3, 25)
    finest = forces(history(ball(25), places, values, rows=rows))
    for grid in (24, (30, 20)):
        problem = rolling(grid=grid, geometry=spheres(2.0 * RADIUS), body=RUBBER, load=WEIGHT, friction=MU)
        assert np.abs(forces(history(problem, places, values, rows=rows)) - finest).max() < 5e-3 * MU * WEIGHT
    assert finest[4, 0] == pytest.approx(finest[0, 0], abs=1e-4 * MU * WEIGHT) and finest[5, 0] > 1.01 * finest[0, 0]


def test_a_step_costs_what_a_steady_state_costs() -> None:
    """Applications of a step and of the steady state on this grid alone."""
    steps = [moment.applications for moment in of_reference("step")]
    assert np.mean(steps[1:]) <= 1.3 * steps[0]
    assert all(one >= 1 for one, _ in itertools.pairwise(steps))

"""Line contacts over time: shifts without rolling after Cattaneo, rolling that starts and ends in Carter's, and what the length
of the contact changes."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.documents import at_most
from tests.support.problems import MECHANICAL, elastic
from tests.support.sampling import sampled
from thermoroll_cli import Case, read_result
from thermoroll_cli.exact.hertz import line_contact
from thermoroll_cli.exact.rolling_cylinders import saturation_creepage
from thermoroll_cli.many_contacts.history.course import Course, History
from thermoroll_cli.many_contacts.history.solve import HistorySolver
from thermoroll_cli.many_contacts.history.steps import Steps
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

STEEL = elastic(0.28)
LOAD, FRICTION, LENGTH = 3e5, 0.3, 0.01
LIMIT = FRICTION * LOAD
ROLLS = Problem(STEEL, STEEL, Geometry(0.04, math.inf, 0.06, math.inf), LOAD, Friction(FRICTION), Motion(1.0, 0.0, 0.0),
                MECHANICAL, Numerics((32, 1)), length=LENGTH)
HERTZ = line_contact(ROLLS.geometry.curvature_x, ROLLS.contact_modulus, LOAD)
HALF, ALL_SLIDES = HERTZ.half_width, saturation_creepage(HERTZ, FRICTION)
FORCE = "force.longitudinal_N_mm"


def over_time(course: Course, motion: Motion, grid: int = 32, **others: object) -> Result:
    settings = {"numerics": Numerics((grid, 1)), **others}
    return HistorySolver().solve(History(replace(ROLLS, motion=motion, **settings), course))


def test_displacements_are_those_in_the_middle_of_the_length() -> None:
    bodies = Bodies(1.0, ShearCompliance(1.0, 0.4), length=50.0)
    for strip, rectangle in zip(*(bodies.shear_tables(6, 1, 0.1, dy)[:2] for dy in (math.inf, 50.0)), strict=True):
        np.testing.assert_allclose(strip.quadrant, rectangle.quadrant, rtol=1e-4)


@pytest.mark.parametrize("share", sampled([0.6, 0.3, 0.9], 3))
def test_a_shift_without_rolling_is_that_of_cattaneo(share: float) -> None:
    force = share * LIMIT
    result = over_time(Course((0.0, 1.0), {FORCE: (0.0, 1e-3 * force)}, steps=2, begin="pressed"), Motion(0.0, None, 0.0), 128)
    sticks, compliance = math.sqrt(1.0 - share), DerivedQuantities(ROLLS).bodies.shear

    def shift(carried: float, half: float) -> float:
        """Of a semi-elliptic traction with this sum, in the middle of the length."""
        return 2.0 * carried * (compliance.isotropic * (math.log(2.0 * LENGTH / half) + 0.5) + compliance.directional)

    wanted = shift(LIMIT, HALF) - shift(LIMIT - force, sticks * HALF)
    assert result.converged and result["gamma_st"] == pytest.approx(sticks, abs=0.01)
    assert result["shift_x_um"] * 1e-6 == pytest.approx(wanted, rel=1e-4)
    assert abs(result["shift_x_um"] * 1e-6 - wanted) < 1e-6 * result.uncertainty["shift_x_um"]


def test_heat_of_slip_that_no_element_shows_is_not_nothing() -> None:
    """2 % of μW: all of 16 elements stick, and 64 show that the border slips. Heat and power were the rounding of work, and so
    were their errors; now these are a few percent of the work."""
    course = Course((0.0, 1.0), {FORCE: (0.0, 0.02e-3 * LIMIT)}, steps=4, begin="pressed")
    coarse, fine = (over_time(course, Motion(0.0, None, 0.0), grid) for grid in (16, 64))
    assert coarse["gamma_st"] == 1.0 > fine["gamma_st"]
    for name in ("heat_J_mm", "Q_F_W_mm"):
        assert 1e-3 * fine["work_J_mm"] > fine[name] > 3e2 * abs(coarse[name])
        assert fine[name] < coarse.uncertainty[name] < 0.05 * fine["work_J_mm"]


def test_powers_at_rest_are_compared_over_the_same_time() -> None:
    """A force that is there at once, falls and turns. The mean power since the row before is another one with every second row,
    by half of the largest; where all elements stick, what slips unseen is bounded by what more elements show."""
    course = Course((0.0, 1.0, 2.0), {FORCE: (-0.3e-3 * LIMIT, 0.0, 0.2e-3 * LIMIT)}, steps=6, begin="pressed")
    fine = np.array([0.0, 3.64679e-7, 2.09776e-8, 5.88326e-8, 7.10089e-8, 1.05291e-7, 1.46807e-7])  # W/mm, on 512 elements
    for numerics, widest in ((Numerics((64, 1)), 0.25), (Numerics(accuracy=0.05, grid=None), 0.05)):
        result = over_time(course, Motion(0.0, None, 0.0), numerics=numerics)
        power, errors = (np.array(result.history[prefix + "Q_F_W_mm"]) for prefix in ("", "uncertainty."))
        assert result.converged
        assert (abs(power - fine) <= errors).all() and errors.max() <= widest * fine.max()


@pytest.fixture(scope="module")
def started() -> Result:
    """Rolling at half the creepage of full sliding, from nothing."""
    rest = {"creepage.lateral": (0.0, 0.0)}
    return over_time(Course((0.0, 20.0 * HALF), rest, True, 20, "pressed"), Motion(1.0, 0.5 * ALL_SLIDES, 0.0))


@pytest.mark.slow
def test_a_start_ends_in_carter(started: Result) -> None:
    forces = np.array(started.history["force_x_N_mm"]) / (1e-3 * LIMIT)
    assert started.converged and forces[0] == 0.0 and (np.diff(forces[:15]) > 0.0).all()
    assert forces[-1] == pytest.approx(0.75, abs=at_most("line_contacts", "rolling that starts", "largest difference"))
    assert set(started.uncertainty) >= {"work_J_mm", "heat_J_mm"} and "work_J" not in started.history
    work, heat, stored = (np.array(started.history[name]) for name in ("work_J_mm", "heat_J_mm", "elastic_energy_J_mm"))
    np.testing.assert_allclose(work - heat, stored, atol=0.02 * work[-1])


def test_errors_of_a_start_are_estimated(started: Result) -> None:
    fine = [0.0, 17.998, 32.820, 43.494, 51.104, 56.412, 60.065, 62.549, 64.218, 65.334, 66.073, 66.565, 66.890, 67.103, 67.243,
            67.335, 67.395, 67.435, 67.461, 67.478, 67.490]  # 64 elements, 80 steps
    error = np.array(started.history["force_x_N_mm"]) - fine
    assert (np.abs(error) <= np.array(started.history["uncertainty.force_x_N_mm"])).mean() > 0.95
    allowed = at_most("line_contacts", "rolling that starts", "largest difference", 1)
    assert np.sqrt(np.mean(error**2)) <= allowed * 1e-3 * LIMIT


def test_a_steady_state_stays_steady() -> None:
    constant = {"creepage.longitudinal": (0.5 * ALL_SLIDES,) * 2}
    forces = over_time(Course((0.0, 5.0 * HALF), constant, True, 4), Motion(1.0, 0.5 * ALL_SLIDES, 0.0)).history["force_x_N_mm"]
    assert np.ptp(forces) < 1e-6 * forces[0]


@pytest.mark.slow
def test_under_a_force_the_length_changes_the_shift_alone() -> None:
    """And the steps are as many as they are solved in: with short steps, too."""
    course = Course((0.0, 4.0 * HALF), {FORCE: (0.2e-3 * LIMIT, 0.75e-3 * LIMIT)}, True, 12, "pressed")
    short, long = (over_time(course, Motion(1.0, None, 0.0), length=length) for length in (5e-3, 1.0))
    assert short.converged and long.converged
    for name in ("shear_x", "pressure"):
        np.testing.assert_allclose(short.fields[name], long.fields[name], atol=5e-5 * short.fields[name].max())
    assert long["creepage_longitudinal"] > 1.1 * short["creepage_longitudinal"]


@pytest.mark.parametrize("body", sampled([
    replace(STEEL, layers=(Layer(0.3 * HALF, 600e9, 0.25), Layer(0.5 * HALF, 80e9, 0.3))), elastic(0.33, 72e9)]))
def test_unlike_and_coated_bodies_start_too(body: Material) -> None:
    creeping = {"creepage.longitudinal": (0.5 * ALL_SLIDES,) * 2}
    other = replace(ROLLS, lower=body, motion=Motion(1.0, 0.5 * ALL_SLIDES, 0.0))
    moments = list(Steps(History(other, Course((0.0, 40.0 * HALF), creeping, True, 10, "pressed")), (32, 1)).moments(
        np.linspace(0.0, 40.0 * HALF, 11)))
    steady = solve(other)["force_x_N_mm"]
    assert all(moment.converged for moment in moments)
    assert moments[-1].reported.scalars["force_x_N"] == pytest.approx(1e3 * steady, rel=2e-3)


def test_heat_builds_up_to_the_steady_one() -> None:
    warm = Material(206e9, 0.28, 46.6, 11.7e-6, 12.5e-6)
    hot = replace(ROLLS, lower=warm, upper=replace(warm, conductivity=20.0), motion=Motion(0.05, 3.0 * ALL_SLIDES, 0.0),
                  heating=Heating(True, True, "rolling", "matched"), numerics=Numerics((16, 1)))
    course = Course((0.0, 40.0 * HALF), {"creepage.longitudinal": (3.0 * ALL_SLIDES,) * 2}, True, 8, "pressed")
    *_, last = Steps(History(hot, course), (16, 1)).moments(course.rows)
    steady = solve(hot)
    for body in ("lower", "upper"):
        assert last.reported.scalars[f"temperature_rise_max_{body}_K"] == pytest.approx(
            steady[f"temperature_rise_max_{body}_K"], rel=1e-3)
    expansion = "thermal_displacement_max_um"
    assert last.reported.scalars[expansion] == pytest.approx(steady[expansion], rel=0.02)


CASE: dict[str, Any] = {
    "material": {"youngs_modulus_GPa": 206.0, "poisson_ratio": 0.3},
    "geometry": {"lower_radius_x_mm": 10.0, "upper_radius_x_mm": 15.0},
    "load": {"normal_N_mm": 12.5, "friction_coefficient": 0.06}, "rolling": {"speed_m_s": 3.0}, "numerics": {"grid": 16},
    "history": {"distance_mm": [0.0, 0.2], "steps": 8, "fields_every": 4, "length_mm": 20.0,
                "values": {"creepage.longitudinal": [0.0001, 0.0002], "load.normal_N_mm": [8.0, 12.5]}},
}


def test_a_case_writes_rows_fields_and_pictures(tmp_path: Path) -> None:
    (tmp_path / "teeth.toml").write_text(Case.from_dict(CASE).to_toml())
    done = call("run", "teeth.toml", "-o", "out", "--plots", "summary", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "teeth_history.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 9 and float(rows[0]["load.normal_N_mm"]) == 8.0 and float(rows[-1]["normal_N_mm"]) == 12.5
    assert {"force_x_N_mm", "work_J_mm", "uncertainty.force_x_N_mm"} <= {*rows[0]} and "force_x_N" not in rows[0]
    animated = call("plot", "out/teeth_history.h5", "--animate", "distance_mm", "-o", "out", cwd=tmp_path, painted=True)
    assert animated.returncode == 0 and list((tmp_path / "out").glob("*.gif")), animated.stderr
    assert (tmp_path / "out" / "teeth_history.png").exists()
    # Another case goes on from its end.
    further = {"begin": str(tmp_path / "out" / "teeth.h5"), "steps": 2, "fields_every": 0, "values": {FORCE: [0.5, 0.6]}}
    content = {**CASE, "history": {**CASE["history"], **further}}
    (tmp_path / "next.toml").write_text(Case.from_dict(content).to_toml())
    done = call("run", "next.toml", "-o", "out", "--no-plots", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert read_result(tmp_path / "out" / "next.h5")["force_x_N_mm"] == pytest.approx(0.6)


def test_a_line_that_is_shorter_than_its_contact_is_wide_is_none() -> None:
    with pytest.raises(ValueError, match="short beside a contact"):
        solve({**CASE, "history": {**CASE["history"], "length_mm": 0.1}})

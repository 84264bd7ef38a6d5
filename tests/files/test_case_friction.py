"""Case files with friction that falls with slip, memory, and a layer between the bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.command_line import MECHANICAL
from tests.support.scenes import reference
from thermoroll_cli import Case, solve
from thermoroll_cli.files.case_source import Override
from thermoroll_cli.plots.pictures import figure

EUROSPRINTER = Path(__file__).parents[2] / "cases" / "eurosprinter.toml"
LAW = '\n[friction]\nlaw = "exponential"\nlimit_coefficient = 0.1\nhalf_slip_m_s = 0.5\n'


def test_the_map_of_friction_lies_between_both_coefficients() -> None:
    result = solve(Case.parse(MECHANICAL + LAW, overrides=[Override.parse("numerics.grid=16")]).problem)
    picture = figure(result, "friction")
    assert picture is not None
    drawn = np.asarray(picture.axes[0].get_images()[0].get_array())
    assert 0.1 <= drawn.min() < drawn.max() <= result.problem.friction.coefficient
    assert figure(solve(Case.parse(MECHANICAL, overrides=[Override.parse("numerics.grid=16")]).problem), "friction") is None


@pytest.mark.slow
def test_measured_creep_forces_of_a_locomotive() -> None:
    """Parameters were fitted to these points by others: this checks the form of the model and the program, not a prediction."""
    measured = reference("friction_eurosprinter_measured")
    case = Case.read(EUROSPRINTER).with_values({"numerics.grid": 32})
    creepages = measured["ours"]["creepage"][::2]
    forces = [solve(case.with_values({"creepage.longitudinal": c})).coupled.scalars["force_x_N"] / 106700 for c in creepages]
    points = np.array(measured["points"])
    model = np.interp(points[:, 0], creepages, forces)
    assert np.sqrt(np.mean((points[:, 1] - model) ** 2)) <= 0.030
    assert forces == pytest.approx(measured["ours"]["Fx_over_W"][::2], abs=4e-4)

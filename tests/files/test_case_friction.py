"""Case files with friction that falls with slip, memory, and a layer between the bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.command_line import MECHANICAL
from tests.support.scenes import reference
from thermoroll_cli import Case, solve
from thermoroll_cli.files.case_source import Override
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.plots.pictures import figure

EUROSPRINTER = Path(__file__).parents[2] / "cases" / "eurosprinter.toml"
LAW = '\n[friction]\nlaw = "exponential"\nlimit_coefficient = 0.1\nhalf_slip_m_s = 0.5\n'


@pytest.mark.parametrize(("text", "words"), [
    ("\n[friction]\nmemory_um = 2.0\n", ["friction.memory_um has no effect"]),
    ('\n[friction]\nlaw = "table"\ntable = [[0.0, 0.3], [1.0, 0.4]]\n\n[layer]\ncompliance_um_GPa = 2.0\n', []),
    (LAW + "memory_um = 2.0\n", []),
    (LAW + "memory_um = 1e-6\n\n[layer]\ncompliance_um_GPa = 100.0\n", ["is shorter than the shear of the interlayer"]),
    (LAW + "memory_um = 1e3\n\n[layer]\ncompliance_um_GPa = 100.0\n", []),
])
def test_memory_that_does_nothing_or_too_little_is_warned_of(text: str, words: list[str]) -> None:
    warnings = make_plan(Case.parse(MECHANICAL + text).problem).warnings
    assert len(warnings) == len(words) and all(word in warning for word, warning in zip(words, warnings, strict=True))


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

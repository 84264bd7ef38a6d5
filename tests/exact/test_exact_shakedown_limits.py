"""Elastic and shakedown limits of ideal contacts against computed stresses, and the map that shows them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.support.scenes import strong_circle
from thermoroll_cli.exact.shakedown_limits import CIRCLE_ELASTIC, CIRCLE_SHAKEDOWN, FRICTION, line_shakedown, line_shear
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.problem import Strength
from thermoroll_cli.python_api import solve


@pytest.mark.parametrize(("friction", "johnson"), [(0.0, 4.0), (0.2, 3.2024), (0.35, 2.7665), (0.4, 2.5)])
def test_limits_of_a_line_contact_are_johnsons(friction: float, johnson: float) -> None:
    assert line_shakedown(friction) == pytest.approx(johnson, rel=2e-5)


def test_shear_below_a_line_contact_carries_the_traction() -> None:
    """σ_xz at the surface is the traction, and on every plane its integral is the tangential force."""
    x = np.linspace(-400.0, 400.0, 400001)
    force = sum(line_shear(float(place), 0.7, 0.3) for place in x[::40]) * 40 * (x[1] - x[0])
    assert abs(line_shear(0.3, 1e-9, 0.3)) == pytest.approx(0.3 * np.sqrt(1.0 - 0.09), rel=1e-6)
    assert abs(force) == pytest.approx(0.3 * np.pi / 2.0, rel=3e-3)


@pytest.mark.parametrize("friction", [pytest.param(0.1, marks=pytest.mark.slow), 0.3])
def test_limits_of_a_circular_contact_are_those_of_computed_stresses(friction: float) -> None:
    result = solve(strong_circle(friction, 24))
    kept, p0 = result.bodies["lower"].strength, result.of_problem["hertz_p0_MPa"] * 1e6
    for name, curve in (("elastic_limit_k", CIRCLE_ELASTIC), ("shakedown_k", CIRCLE_SHAKEDOWN)):
        needed = float(kept[name][1:].max())
        assert p0 / needed == pytest.approx(np.interp(friction, FRICTION, curve), rel=6e-3), name


def test_the_map_has_the_point_of_the_case_and_names_the_criteria() -> None:
    problem = strong_circle(0.2, 12)
    result = solve(dataclasses.replace(problem, subsurface=dataclasses.replace(problem.subsurface, layers=8)))
    picture = figure(result, "shakedown_map")
    assert picture is not None
    words = [text.get_text() for text in picture.legends[0].get_texts()]
    assert [word for word in words if "von Mises" in word or "Tresca" in word] == words[:-1] and words[-1] == "lower body"
    (x,), (y,) = picture.axes[0].get_lines()[-1].get_data()
    assert x == pytest.approx(0.2, rel=1e-3)
    assert y == pytest.approx(result.of_problem["hertz_p0_MPa"] / 200.0, rel=1e-3)
    known = result.of_problem
    for longer, curves in ((4.0, []), (0.25, ["line"]), (1.5, ["circle", "circle", "line"])):
        other = dataclasses.replace(result, of_problem=known | {"hertz_a_mm": longer * known["hertz_b_mm"]})
        drawn = figure(other, "shakedown_map").axes[0].get_lines()
        assert [line.get_label().split(":")[0] for line in drawn[:-1]] == curves
    assert figure(result, "strength_lower") is not None and figure(result, "strength_upper") is None
    unknown = dataclasses.replace(result.problem.subsurface, lower_strength=Strength())
    result = dataclasses.replace(result, problem=dataclasses.replace(result.problem, subsurface=unknown))
    assert figure(result, "shakedown_map") is None and figure(result, "strength_lower") is not None

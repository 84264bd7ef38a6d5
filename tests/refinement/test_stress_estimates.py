"""Estimates of the largest stresses, held against closed forms and finer grids: neither too small nor of no use."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scripts.stress.populations import POPULATIONS
from tests.support.errors import relative
from tests.support.scenes import MECHANICAL, elastic, rolling
from thermoroll_cli.problem.problem import Numerics, Problem, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

RANGE = "orthogonal_shear_range_max_lower_MPa"


def below(grid: int | tuple[int, int], problem: Problem) -> Result:
    shape = (grid, grid) if isinstance(grid, int) else grid
    return solve(replace(problem, numerics=Numerics(shape), subsurface=SubsurfaceRequest(("lower",))))


def value_and_error(result: Result) -> tuple[float, float]:
    """The range of σ_xz and its estimated error, over the largest pressure."""
    assert result.subsurface is not None
    return result.subsurface.scalars[RANGE] / result.of_problem["hertz_p0_MPa"], relative(result)[RANGE]


@pytest.mark.slow
@pytest.mark.parametrize("grid", [24])
@pytest.mark.parametrize("friction", [0.6])
def test_range_of_a_sliding_contact_is_known_as_its_traction(grid: int, friction: float) -> None:
    """At the surface σ_xz is μp, at most μp₀. The estimate was 0.1 to 0.2 p₀, as if it grew like √s from the border."""
    value, error = value_and_error(below(grid, rolling(friction=friction, creepage=(5.0, 0.0), heating=MECHANICAL)))
    assert abs(value - friction) <= error < 0.05


@pytest.mark.parametrize("grid", [16, pytest.param(24, marks=pytest.mark.slow)])
def test_range_below_a_frictionless_contact(grid: int) -> None:
    """What is largest at the last depth that counts as the surface grows on into the body: it is no peak that could exceed the
    one below. The estimate was 0.03 to 0.7 p₀."""
    value, error = value_and_error(below(grid, rolling(body=elastic(0.3), friction=0.0, heating=MECHANICAL)))
    assert abs(value - 0.42777) <= error < 0.05 * (16 / grid) ** 2


@pytest.mark.slow
def test_edges_that_long_elements_do_not_see() -> None:
    """Beside the leading edge of a contact eight times as long as wide σ_xz is largest at a depth of a quarter of the length
    of these elements: 0.151 p₀ on them, 0.1658 on elements a sixteenth as long."""
    value, error = value_and_error(below(32, POPULATIONS["coverage below the surface"].draw(338)))
    assert 0.01 < abs(value - 0.1658) <= error < 0.1


@pytest.mark.slow
def test_a_peak_at_the_surface_is_no_peak_of_a_polynomial() -> None:
    """Stresses fall from the surface to the first depth, which lies far above the next ones: through these a polynomial rose to
    0.508 p₀. It is 0.474 on 160 elements."""
    value, error = value_and_error(below(32, POPULATIONS["coverage below the surface"].draw(312)))
    assert value == pytest.approx(0.474, abs=0.003)
    assert error < 0.07


def test_alternating_plasticity_on_few_elements() -> None:
    """States of single elements bound the ball: what 16 elements miss of it, 0.0045 p₀, was estimated as 0.0024."""
    problem = POPULATIONS["coverage of histories"].draw(207)
    result, name = solve(replace(problem, numerics=Numerics((16, 16)))), "alternating_k_below_lower_MPa"
    assert result.subsurface is not None
    off = abs(result.subsurface.scalars[name] / result.of_problem["hertz_p0_MPa"] - 0.2012)
    assert 0.004 < off <= relative(result)[name] < 0.02


def test_what_lies_between_depths_is_known_better_than_from_every_second_one() -> None:
    """Without friction the strength needed below the surface is known to 1e-6, estimated as 3.6e-3 from 16 depths."""
    problem = POPULATIONS["coverage of histories"].draw(200)
    result = solve(replace(problem, numerics=Numerics((24, 24))))
    assert result.subsurface is not None
    assert relative(result)["shakedown_k_below_lower_MPa"] < 1.8e-3

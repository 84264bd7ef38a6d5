"""The search for a root of smooth, steep, flat and jumping functions; values between elements."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from thermoroll_cli.physics.numerics.grid import Grid, value_at
from thermoroll_cli.physics.numerics.roots import RisingRoot


def found(root: RisingRoot, function: Callable[[float], float], tolerance: float) -> int:
    """Number of values until one is below the `tolerance`, or the bracket is."""
    for count in range(1, 80):
        value = function(root.place)
        if abs(value) <= tolerance or root.width <= tolerance:
            return count
        root.move(value)
    raise AssertionError("no root")


@pytest.mark.parametrize(("function", "most"), [
    (lambda x: x - 0.3, 4), (lambda x: x**3 - 0.027, 12), (lambda x: math.tanh(40.0 * (x - 0.3)), 16),
    (lambda x: max(x - 0.2, 0.0) ** 1.5 - 0.001, 16), (lambda x: x - 0.3 + 0.2 * math.sin(3.0 * x) - 0.2 * math.sin(0.9), 12),
])  # fmt: skip
@pytest.mark.parametrize("start", [0.0, 0.29, 0.9])
def test_roots_are_found_from_anywhere_in_the_bracket(function, most, start):
    root = RisingRoot(start, 1.0, 0.25, 0.0, 1.0)
    assert found(root, function, 1e-9) <= 2 * most
    assert abs(function(root.place)) <= 1e-9


def test_the_bracket_closes_around_a_jump():
    root = RisingRoot(0.9, 1.0, 0.25, 0.0, 1.0)
    found(root, lambda x: -1.0 if x < 0.3 else 1.0, 1e-9)
    assert root.width <= 1e-9 and root.place == pytest.approx(0.3, abs=1e-8)


GRID = Grid.over((16, 16), 1.0, 1.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_beside_a_steep_edge_a_value_is_none_of_its_neighbours_exceed(sign: float) -> None:
    edge = sign * np.where(GRID.x > 0.0, 1.0, 0.0)[:, None] * np.ones(16)
    values = [sign * value_at(GRID, edge, x, 0.01) for x in np.linspace(-0.3, 0.3, 41)]
    assert min(values) == 0.0 and max(values) == 1.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_top_of_a_paraboloid_lies_above_its_elements(sign: float) -> None:
    bowl = sign * (GRID.x[:, None] ** 2 + 0.3 * GRID.y**2)
    assert value_at(GRID, bowl, 0.0, 0.0) == pytest.approx(0.0, abs=1e-15)
    assert value_at(GRID, bowl, 0.3, 0.02) == pytest.approx(sign * (0.09 + 0.3 * 4e-4), rel=1e-12)

"""The search for a root: smooth, steep, flat and jumping functions."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

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

"""Values between elements."""

from __future__ import annotations

import numpy as np
import pytest

from thermoroll_cli.physics.numerics.grid import Grid, value_at

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

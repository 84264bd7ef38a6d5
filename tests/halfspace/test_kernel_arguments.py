"""Tables of influence refuse impossible arguments, and name them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress
from thermoroll_cli.physics.halfspace.subsurface_thermal import thermal_stress
from thermoroll_cli.physics.halfspace.thermal import advected_expansion, displacement_table, temperature_table
from thermoroll_cli.physics.halfspace.variable_peclet import variable_peclet_tables
from thermoroll_cli.physics.numerics.convolution import Convolution, quadrant_symbol

ONE = np.zeros(1)


@pytest.mark.parametrize(("function", "arguments", "named"), [
    *((table, arguments, named) for table in (temperature_table, displacement_table) for arguments, named in (
        ((0, 4, 1.0, 1.0), "at least one element"), ((4, 0, 1.0, 1.0), "at least one element"), ((4, 4, 0.0, 1.0), "aspect"),
        ((4, 4, math.nan, 1.0), "aspect"), ((4, 4, 1.0, math.inf), "Péclet numbers must be finite"))),
    (advected_expansion, (ONE, ONE, 1.0, 0.0), "infinite without motion"),
    (variable_peclet_tables, (0, 4, 1.0, 1.0, "temperature"), "at least one element"),
    (variable_peclet_tables, (4, 4, -1.0, 1.0, "temperature"), "aspect"),
    (variable_peclet_tables, (4, 4, 1.0, -1.0, "temperature"), "largest Péclet"),
    (variable_peclet_tables, (4, 4, 1.0, math.inf, "temperature"), "Péclet numbers must be finite"),
    (pressure_stress, (ONE, ONE, -1.0, 1.0, 0.28), "depth"),
    (traction_x_stress, (ONE, ONE, 1.0, 0.0, 0.28), "aspect"),
    (thermal_stress, (ONE, ONE, np.array([1.0, 0.5]), 1.0, 1.0, 0.0, 0.28), "ascend"),
    (thermal_stress, (ONE, ONE, ONE, 1.0, math.inf, 0.0, 0.28), "finite"),
    (Convolution(6, 9).spectrum, (np.zeros((11, 16)),), r"\(11, 17\)"),
    (Convolution(6, 9, before=1).spectrum, (np.zeros((11, 17)),), "shape"),
    (quadrant_symbol, (np.ones((5, 5)), (9, 8)), r"even period, got \(9, 8\)"),
])  # fmt: skip
def test_bad_input_is_named(function: Callable[..., object], arguments: tuple, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        function(*arguments)

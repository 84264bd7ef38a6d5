"""Closed forms and tables of influence refuse impossible arguments, and name them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from thermoroll_cli.exact import moving_sources, spence
from thermoroll_cli.exact.cattaneo_mindlin import cattaneo_mindlin
from thermoroll_cli.exact.heated_sphere import heated_sphere
from thermoroll_cli.exact.hertz import hertz_contact, line_contact
from thermoroll_cli.exact.kalker import creepage_coefficients, fastsim, polach
from thermoroll_cli.exact.moving_sources import rim_temperature
from thermoroll_cli.exact.rolling_cylinders import carter
from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress
from thermoroll_cli.physics.halfspace.subsurface_thermal import thermal_stress
from thermoroll_cli.physics.halfspace.thermal import advected_expansion, displacement_table, temperature_table
from thermoroll_cli.physics.halfspace.variable_peclet import variable_peclet_tables
from thermoroll_cli.physics.numerics.convolution import Convolution, quadrant_symbol

ELLIPSE = (1e-3, 1e-3, 82e9)
ONE = np.zeros(1)


@pytest.mark.parametrize(("function", "arguments", "named"), [
    *((hertz_contact, tuple(value if place == at else 1.0 for place in range(4)), name)
      for value in (0.0, -1.0, math.nan, math.inf)
      for at, name in enumerate(("curvature_x", "curvature_y", "contact_modulus", "normal_force"))
      if (name, value) != ("curvature_y", 0.0)),  # that of a line contact
    (line_contact, (40.0, 1e11, -1.0), "load_per_length"),
    (carter, (line_contact(40.0, 1e11, 2e5), 0.0, 1e-3), "friction must be"),
    (carter, (line_contact(40.0, 1e11, 2e5), 0.3, math.nan), "creepage"),
    (cattaneo_mindlin, (1e-3, 1e9, 0.3, 1e9), "friction limit"),
    (cattaneo_mindlin, (1e-3, 1e9, 0.3, math.nan), "friction limit"),
    (cattaneo_mindlin, (1e-3, 0.0, 0.3, 0.0), "peak_pressure"),
    (spence.spence_contact, (0.95, 0.3), "stick_ratio"),
    (spence.uncoupled_friction, (0.5, 0.0), "dundurs_beta"),
    (heated_sphere, (0.0, 1.0, 1.0, 1.0), "contact_modulus"),
    (heated_sphere, (1.0, 1.0, 1.0, -1.0), "heating"),
    (heated_sphere, (1e11, 50.0, 65.0, 1e6), r"smaller than 0\.02"),
    (creepage_coefficients, (0.0, 0.3), "aspect_ratio"),
    (creepage_coefficients, (1.0, 0.6), "poisson_ratio"),
    (fastsim, (creepage_coefficients(1.0, 0.3), *ELLIPSE, 0.0, 1e-3), "limit must be positive"),
    (polach, (creepage_coefficients(1.0, 0.3), *ELLIPSE, 0.0, 1e-3), "limit must be positive"),
    (moving_sources.rectangle_maximum, (1.0, 1.0, 1.0, 1.0, 1.0, -1.0), "speed"),
    (moving_sources.rectangle_temperature, (0.0, 0.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0), "half_width"),
    (moving_sources.ellipse_temperature, (1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0), "not inside"),
    (moving_sources.ellipse_maximum, (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, "gauss"), "shape"),
    (moving_sources.circle_mean_temperature, (0.0, 1.0, 1.0, 1.0, 1.0), "radius"),
    (moving_sources.band_temperature, (0.0, 1.0, 1.0, 1.0, 1.0, 1.0, "paraboloid"), "shape"),
    (moving_sources.tian_kennedy_maximum, (1.0, 1.0, 1.0, 1.0, 1.0, "band"), "shape"),
    (rim_temperature, (0.0, 1e-3, 1e6, 0.01, 50.0, 1e-5, 1.0, 0.0), "convection"),
    (rim_temperature, (0.0, 1.0, 1e6, 0.01, 50.0, 1e-5, 1.0, 1.0), "half of the rim"),
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

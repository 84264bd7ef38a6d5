"""Largest values where single elements stand out: at the ends of a crown, whose pressure falls within an element."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.command_line import MECHANICAL
from thermoroll_cli.files.case import Case
from thermoroll_cli.numerics.grid import between_sides
from thermoroll_cli.refinement.solve import solve

CROWN = '[geometry.upper_profile]\nkind = "logarithmic"\nlength_mm = 10.0\ndrop_um = 1.0\n[load]'


def roller(grid: int) -> Case:
    text = MECHANICAL.replace("upper_radius_y_mm = 30.0\n", "").replace("lower_radius_x_mm = 30.0", "lower_radius_x_mm = inf")
    text = text.replace("lower_radius_y_mm = 30.0", "lower_radius_y_mm = inf").replace("upper_radius_x_mm = 30.0",
                                                                                      "upper_radius_x_mm = 10.0")
    text = text.replace("normal_N = 65.0", "normal_N = 2000.0").replace("coefficient = 0.3", "coefficient = 0.1")
    text = text.replace("longitudinal = 0.003", "longitudinal = 0.0007").replace("grid = 16", f"grid = {grid}")
    return Case.parse(text.replace("[load]", CROWN))


@pytest.mark.parametrize("grid", [32, 64])
def test_the_ends_of_a_roller_are_not_where_it_is_hottest(grid: int) -> None:
    """The heat flux has a ridge along the roller; elements at its ends showed up to a fourth more on any grid."""
    result = solve(roller(grid).problem)
    flux = result.coupled.fields["heat_flux"] * 1e-6
    middle = float(flux[:, grid // 4 : -grid // 4].max())
    assert flux.max() > 1.05 * middle, "nothing stands out: another roller is needed"
    reported, error = result.coupled.scalars["heat_flux_max_W_mm2"], result.error["heat_flux_max_W_mm2"]
    assert reported == pytest.approx(middle, rel=0.02)
    assert reported == pytest.approx(0.09997, rel=error)  # on 256 × 256 elements


def test_a_patch_of_few_elements_keeps_its_top() -> None:
    pressure = np.array([[0.0, 0.3, 1.0, 0.3, 0.0, 0.0, 0.9, 0.9, 0.8, 0.7, 0.1]])
    assert between_sides(pressure, pressure, (False, False)).max() == 1.0
    assert between_sides(pressure, pressure, (False, False))[0, 6] == 0.0
    assert between_sides(pressure, pressure, (False, True))[0, 9] == 0.0
    at_end = np.array([[0.0, 0.5, 0.6, 0.7, 0.9]])
    assert between_sides(at_end, at_end, (False, True))[0, -1] == 0.9
    assert between_sides(at_end, at_end, (False, False))[0, -1] == 0.0
    assert np.array_equal(between_sides(at_end[:, -1:], at_end[:, -1:], (False, False)), at_end[:, -1:])

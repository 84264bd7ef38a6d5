"""The cases with transverse profiles: surfaces above the pressure between them."""

from __future__ import annotations

import pathlib

from scripts.figures.figures_drawing import Numbers, rounded, solve_case, write
from thermoroll_cli.plots.pictures import figure

CASES = ("crowned_roller", "worn_rail", "two_point")


def profiles(folder: pathlib.Path, grid: int) -> Numbers:
    """Heights of both surfaces and the pressure of each case; its forces and patches."""
    numbers: Numbers = {}
    for name in CASES:
        result = solve_case(name, grid=grid)
        picture = figure(result, "profile")
        assert picture is not None
        write(picture, folder, f"surfaces_{name}")
        numbers[name] = {key: rounded(result.coupled.scalars[key]) for key in ("force_x_N", "Q_F_W", "pressure_max_MPa")}
        numbers[name]["patches"] = [{key: rounded(value) for key, value in patch.items()} for patch in result.patches]
    return numbers


FIGURES = {"surfaces": profiles}

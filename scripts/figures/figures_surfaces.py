"""Pictures as a run draws them: the cases with transverse profiles, and stresses below a hot contact."""

from __future__ import annotations

import pathlib

from scripts.figures.figures_drawing import Numbers, rounded, solve_case, write
from thermoroll_cli.plots.pictures import figure

PICTURES = {"crowned_roller": "profile", "worn_rail": "profile", "two_point": "profile", "hot_sliding": "subsurface_upper"}
SCALARS = ("force_x_N", "Q_F_W", "pressure_max_MPa")


def pictures(folder: pathlib.Path, grid: int) -> Numbers:
    """A picture of each case; its forces and patches."""
    numbers: Numbers = {}
    for name, kind in PICTURES.items():
        result = solve_case(name, grid=grid)
        picture = figure(result, kind)
        assert picture is not None
        write(picture, folder, f"surfaces_{name}" if kind == "profile" else "subsurface")
        numbers[name] = {key: rounded(result.coupled.scalars[key]) for key in SCALARS}
        numbers[name]["patches"] = [{key: rounded(value) for key, value in patch.items()} for patch in result.patches]
    return numbers


FIGURES = {"surfaces": pictures}

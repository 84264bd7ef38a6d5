"""Pictures of runs: the animation of the README, cases with transverse profiles, stresses below a hot contact."""

from __future__ import annotations

import pathlib
from typing import Any

from scripts.figures.figures_drawing import (
    ROOT,
    Numbers,
    rounded,
    solve_case,
    write,
)
from thermoroll_cli import Case, solve
from thermoroll_cli.plots.animation import draw_animation
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.plots.sweep_figures import sweep_figure

Folder = pathlib.Path


PICTURES = {"worn_rail": "profile", "two_point": "profile", "hot_sliding": "subsurface_upper"}
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
        numbers[name]["patches"] = [{key: rounded(value) for key, value in patch.items()} for patch in result.records]
    return numbers


EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "wheel_rail": ("traction", {}), "coated_ball": ("subsurface_upper", {"creepage.spin_rad_mm": 0.005})}


def examples(folder: pathlib.Path, grid: int) -> Numbers:
    """A picture of each worked example; the scalars that docs/examples.md holds against a calculation by hand."""
    numbers: Numbers = {}
    for name, (kind, changes) in EXAMPLES.items():
        result = solve_case(name, changes, grid=grid)
        picture = figure(result, kind)
        assert picture is not None
        write(picture, folder, f"example_{name}")
        numbers[name] = {key: rounded(result.coupled.scalars[key]) for key in SCALARS}
    return numbers


def rolling_start(folder: Folder, grid: int) -> Numbers:
    """Rolling that starts: the stick border, creep force and temperature over the distance."""
    case = Case.read(ROOT / "cases" / "rolling_start.toml")
    history = solve(case.with_values({"numerics.grid": min(grid, 64)})).history
    assert history is not None
    places = [history["distance_mm"][row] for row in history.states]
    draw_animation(folder / "rolling_start.gif", list(history.states.values()), "distance_mm", places)
    return {name: rounded(max(history[name])) for name in ("force_x_N", "temperature_rise_max_lower_K")}


def dent(folder: Folder, grid: int) -> Numbers:
    """A ball that rolls over a dent: pressure, force and stress below over the distance."""
    history = solve(Case.read(ROOT / "cases" / "dent.toml").with_values({"numerics.grid": min(grid, 64)})).history
    assert history is not None
    columns = ("pressure_max_MPa", "force_x_N", "von_mises_max_lower_MPa")
    write(sweep_figure(history, ["distance_mm"], only=columns), folder, "dent")
    return {name: [rounded(min(history[name])), rounded(max(history[name]))] for name in columns}


FIGURES = {"rolling_start": rolling_start, "surfaces": pictures, "examples": examples, "dent": dent}

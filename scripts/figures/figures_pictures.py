"""Pictures of runs: the one at the top of the README, cases with transverse profiles, stresses below a hot contact."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
from matplotlib.colors import Normalize

from scripts.figures.figures_drawing import (
    MAIN,
    ROOT,
    Numbers,
    Panel,
    field_of,
    new_figure,
    rounded,
    solve_case,
    some,
    view_of,
    write,
)
from thermoroll_cli import Case, Solver
from thermoroll_cli.plots.animation import draw_animation
from thermoroll_cli.plots.maps import draw_arrows, draw_map
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.plots.style import add_axes, few_ticks

Folder = pathlib.Path


def overview(folder: Folder, grid: int) -> Numbers:
    """The picture at the top of the README: one contact with creepage, spin and heat."""
    result = solve_case("article_4_1", {"creepage.longitudinal": 0.002, "creepage.spin_rad_mm": 0.01}, grid=grid)
    view = view_of(result)
    pressure, shear, rise = (field_of(view, 1, name) for name in ("pressure", "shear", "temperature_rise_lower"))
    fields = ((pressure / view.peak_pressure, "pressure $p/p_0$", "viridis", False),
              (shear / view.peak_pressure, r"shear traction $|\tau|/p_0$", "viridis", True),
              (rise, "temperature rise (K)", "inferno", False))
    figure, all_axes = _strip(len(fields))
    for axes, (values, words, colours, arrows) in zip(all_axes, fields, strict=True):
        _strip_panel(figure, axes, Panel(view, 1, values, words, arrows), colours)
    write(figure, folder, "overview")
    return some(result.coupled.scalars, *MAIN)


def _strip(count: int) -> tuple[Any, list[Any]]:
    side, step = 2.2, 3.12
    figure = new_figure(0.5 + count * step - 0.2, side + 0.72)
    return figure, [add_axes(figure, 0.5 + i * step, 0.42, side, side) for i in range(count)]


def _strip_panel(figure: Any, axes: Any, panel: Panel, colours: str) -> None:
    frame = panel.view.frame
    image = draw_map(axes, frame, frame.last, panel.values,
                     {"cmap": colours, "norm": Normalize(0.0, float(panel.values.max()))}, open_ended=colours == "inferno")
    if panel.arrows:
        draw_arrows(axes, frame, frame.last, (2.2, 2.2))
    axes.set_title(panel.words, y=1.0, pad=4.0)
    axes.set_xlabel(r"$x/a_0$", labelpad=2.0)
    axes.set_ylabel(r"$y/b_0$", labelpad=1.0)
    few_ticks(axes, 4, 4)
    box = axes.get_position()
    bar = figure.add_axes((box.x1 + 0.008, box.y0, 0.011, box.height))
    figure.colorbar(image, cax=bar)
    few_ticks(bar, y=5)


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


def creep_animation(folder: Folder, grid: int) -> Numbers:
    """The stick border that retreats along the creep curve while the temperature rises."""
    case = Case.read(ROOT / "cases" / "article_4_1.toml").with_values({"numerics.grid": grid})
    creepages = [float(creepage) for creepage in np.linspace(5e-4, 6e-3, 16)]
    solver = Solver()
    results = [solver.solve(case.with_values({"creepage.longitudinal": creepage})) for creepage in creepages]
    draw_animation(folder / "creep.gif", results, "creepage.longitudinal", creepages)
    return {"creepage": [creepages[0], creepages[-1]]}


FIGURES = {"overview": overview, "creep_animation": creep_animation, "surfaces": pictures, "examples": examples}

"""Figs. 4 and 5 of Yu & Suh: shear tractions of five cases, and the temperature under a moving square source."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from scripts.figures.figures_drawing import (
    COUPLED,
    DASHED,
    ISOTHERMAL,
    ROOT,
    Numbers,
    Panel,
    Row,
    diagrams,
    field_of,
    map_figure,
    plain,
    rounded,
    solve_case,
    some,
    table,
    view_of,
    write,
)
from thermoroll_cli.exact.moving_sources import rectangle_maximum, rectangle_temperature, tian_kennedy_maximum
from thermoroll_cli.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.plots.style import few_ticks

Folder = pathlib.Path


def shear_cases(folder: Folder, grid: int) -> Numbers:
    """Fig. 4: shear traction of the five cases of Sec. 3.1, and of the fifth with its spin reversed."""
    cases: list[tuple[str, str, str, dict[str, Any]]] = [
        ("a", r"$\xi_x = 0.00135$", "article_3_1_case_1", {}),
        ("b", r"$\xi_x = \xi_y = 0.00135$", "article_3_1_case_2", {}),
        ("c", r"$\xi_\phi = 0.02$", "article_3_1_case_3", {}),
        ("d", r"$\xi_x = 0.00135$, $\xi_\phi = 0.01$", "article_3_1_case_4", {}),
        ("e", r"$\xi_x = \xi_y = 0.00135$, $\xi_\phi = 0.01$", "article_3_1_case_5", {}),
        ("e′", r"the same, $\xi_\phi = -0.01$", "article_3_1_case_5", {"creepage.spin_rad_mm": -0.01}),
    ]
    panels, numbers = [], {}
    for mark, words, name, changes in cases:
        result = solve_case(name, changes, grid=grid)
        view = view_of(result)
        shear = field_of(view, 0, "shear")
        assert shear is not None
        panels.append(Panel(view, 0, shear / view.peak_pressure, f"({mark}) {words}", arrows=True))
        numbers[mark] = some(result.coupled.scalars, "force_x_N", "force_y_N", "spin_moment_Nmm", "gamma_st", "Q_F_W",
                             "shear_max_MPa")
    rows = [Row(panels[:3], 0.6, r"$|\tau|/p_0$", "viridis"), Row(panels[3:], 0.6, r"$|\tau|/p_0$", "viridis")]
    write(map_figure(rows, 1.95, legend=True), folder, "fig_04_shear_cases")
    return {"runs": numbers, "table": _beside_contact(numbers)}


def _beside_contact(numbers: Numbers) -> Numbers:
    """Forces, moment and stick fraction with CONTACT's, whose spin in cases 3 and 4 has the other sign: mirrored here."""
    theirs = json.loads((ROOT / "tests" / "reference" / "contact_rolling.json").read_text())["cases"]
    names = ("force_x_N", "force_y_N", "spin_moment_Nmm", "stick_fraction")
    rows = []
    for mark, ours in numbers.items():
        name = "article_3_1_case_5_spin_reversed" if mark == "e′" else f"article_3_1_case_{'abcde'.index(mark) + 1}"
        other = [theirs[name]["extrapolated"][key] for key in names]
        if theirs[name]["input"]["spin_rad_mm"] * (-1.0 if mark == "e′" else 1.0) < 0.0:
            other[1], other[2] = -other[1], -other[2]
        mine = [ours[key] for key in ("force_x_N", "force_y_N", "spin_moment_Nmm", "gamma_st")]
        rows.append([f"({mark})", *(f"{plain(a)} / {plain(b)}" for a, b in zip(mine, other, strict=True))])
    return table(["case", "F_x (N)", "F_y (N)", "spin moment (N mm)", "γ_st"], rows)


def moving_source(folder: Folder, grid: int) -> Numbers:
    """Fig. 5: temperature on the centre line of a moving square source, in both definitions of the Péclet number."""
    per_side = grid // 2
    mesh = Grid.over((3 * per_side, per_side), 6.0, 2.0)
    x = mesh.x + 1.0  # one semi-axis of room ahead of the source, three behind it
    flux = np.zeros(mesh.shape)
    flux[np.abs(x) < 1.0] = 1.0
    figure, (axes,) = diagrams(1, 1, (4.3, 2.6))
    numbers: Numbers = {}
    definitions = ((r"$V a_0/\kappa = 18.8$", 18.8, ISOTHERMAL), (r"$V a_0/2\kappa = 18.8$", 37.6, COUPLED))
    for words, speed, colour in definitions:
        body = HeatedBody(1.0, 1.0, 1.0, speed)
        rise, _ = HeatResponse(mesh, body, body).temperatures(DividedHeat(flux, 1.0))
        line = rise[:, mesh.ny // 2]
        exact = rectangle_temperature(x, 0.5 * mesh.dy, 1.0, 1.0, 1.0, 1.0, 1.0, speed)
        top = rectangle_maximum(1.0, 1.0, 1.0, 1.0, 1.0, speed)
        theirs = tian_kennedy_maximum(1.0, 1.0, 1.0, 1.0, speed)
        axes.plot(x, line, color=colour, label=f"this program, {words}")
        axes.plot(x[3::6], exact[3::6], "o", color=colour, markersize=2.6, markerfacecolor="white", markeredgewidth=0.7)
        axes.plot([-1.0, 1.0], [theirs, theirs], color=colour, linestyle=DASHED, linewidth=1.0)
        numbers[f"V a0/kappa = {speed}"] = {"exact_maximum": rounded(top.temperature, 5), "at_x": rounded(top.x),
                          "tian_kennedy_maximum": rounded(theirs, 5), "elements_across_source": per_side,
                          "largest_error_over_maximum": rounded(float(np.abs(line - exact).max()) / top.temperature, 2)}
    axes.axvspan(-1.0, 1.0, color="0.95", zorder=0)
    axes.set_xlim(-2.0, 4.0)
    axes.set_ylim(0.0, 0.4)
    few_ticks(axes, 6, 5)
    axes.set_xlabel(r"$x/a_0$")
    axes.set_ylabel(r"temperature rise $k\,\Delta T/(q\,a_0)$ on $y=0$")
    handles = axes.get_legend_handles_labels()[0]
    handles += [
        Line2D([], [], marker="o", color="0.3", linestyle="none", markersize=2.6, markerfacecolor="white", label="exact"),
        Line2D([], [], color="0.3", linestyle=DASHED, linewidth=1.0, label="maximum after Tian & Kennedy"),
    ]
    axes.legend(handles=handles, loc="upper right", handlelength=2.2)
    write(figure, folder, "fig_05_moving_source")
    return numbers


FIGURES = {"4": shear_cases, "5": moving_source}

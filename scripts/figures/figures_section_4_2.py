"""Figs. 11 and 12 of Yu & Suh: combinations of creepages, and spin."""

from __future__ import annotations

import pathlib

import numpy as np
from matplotlib.lines import Line2D

from scripts.figures.figures_drawing import (
    DASHED,
    DOTTED,
    MAIN,
    Array,
    Numbers,
    Panel,
    Row,
    View,
    diagrams,
    field_of,
    letter,
    map_figure,
    on_centreline,
    plain,
    rounded,
    solve_case,
    some,
    table,
    view_of,
    write,
)
from thermoroll_cli.plots.style import few_ticks
from thermoroll_cli.refinement.solve import Solver

Folder = pathlib.Path


LINEAR = (0.001, 0.002, 0.003, 0.004, 0.005)


def linear_creepages(folder: Folder, grid: int) -> Numbers:
    """Fig. 11: pressure and shear traction on the centre line for combinations of linear creepages."""
    from matplotlib import colormaps

    figure, (left, right) = diagrams(1, 2, (3.0, 2.5), bottom=0.78)
    solver = Solver()
    numbers: Numbers = {}
    for family, other, dashes in (("longitudinal", "lateral", "solid"), ("lateral", "longitudinal", DASHED)):
        for number, creepage in enumerate(LINEAR):
            changes = {f"creepage.{family}": creepage, f"creepage.{other}": 0.001}
            result = solve_case("article_4_2_linear", changes, grid=grid, solver=solver)
            view = view_of(result)
            colour = colormaps["viridis"](0.88 * number / (len(LINEAR) - 1))
            x = view.x / view.semi_axes[0]
            for axes, field in ((left, "pressure"), (right, "shear")):
                line = on_centreline(view, field_of(view, 1, field)) / view.peak_pressure
                axes.plot(x, line, color=colour, linestyle=dashes, linewidth=1.1)
            numbers.setdefault(family, {})[f"{creepage:g}"] = some(result.coupled.scalars, *MAIN[:7]) | {
                "Q_F_without_W": rounded(result.isothermal.scalars["Q_F_W"])}
    hertz = np.sqrt(np.maximum(1.0 - x**2, 0.0))
    left.plot(x, hertz, color="0.45", linewidth=0.9, linestyle=DOTTED)
    for axes, mark, label in ((left, "(a)", r"$p/p_0$"), (right, "(b)", r"$|\tau|/p_0$")):
        axes.set_xlim(-1.05, 1.05)
        axes.set_ylim(0.0, axes.get_ylim()[1])
        axes.set_xlabel(r"$x/a_0$", labelpad=2.0)
        axes.set_ylabel(label)
        few_ticks(axes, 4, 6)
        letter(axes, mark)
    handles = [Line2D([], [], color=colormaps["viridis"](0.88 * i / (len(LINEAR) - 1)), label=f"{c:g}")
               for i, c in enumerate(LINEAR)]
    handles += [Line2D([], [], color="0.25", label=r"$\xi_x$ varies, $\xi_y = 0.001$"),
                Line2D([], [], color="0.25", linestyle=DASHED, label=r"$\xi_y$ varies, $\xi_x = 0.001$"),
                Line2D([], [], color="0.45", linestyle=DOTTED, linewidth=0.9, label="Hertz")]
    figure.legend(handles=handles, loc="lower center", ncols=8, handlelength=1.9, columnspacing=1.1, borderpad=0.2)
    write(figure, folder, "fig_11_linear_creepages")
    return {"runs": numbers}


def spin(folder: Folder, grid: int) -> Numbers:
    """Fig. 12: pressure and shear traction under spin."""
    cases = (("low", r"$\xi_\phi = -0.01$"), ("high", r"$\xi_\phi = -0.03$"),
             ("combined", r"$\xi_x = \xi_y = 0.001$, $\xi_\phi = -0.03$"))
    upper, lower, numbers = [], [], {}
    for number, (name, words) in enumerate(cases):
        result = solve_case(f"article_4_2_spin_{name}", grid=grid)
        view = view_of(result)
        for panels, mark, field in ((upper, "abc", "pressure"), (lower, "def", "shear")):
            values = field_of(view, 1, field) / view.peak_pressure
            panels.append(Panel(view, 1, values, f"({mark[number]}) {words}", arrows=field == "shear"))
        numbers[name] = some(result.coupled.scalars, *MAIN) | {
            "asymmetry_in_y": rounded(_asymmetry(field_of(view, 1, "pressure")), 2),
            "pressure_peak_at_y": rounded(_peak_y(view, "pressure")), "shear_peak_at_y": rounded(_peak_y(view, "shear")),
            "gamma_st_without": rounded(result.isothermal.scalars["gamma_st"]),
            "Q_F_without_W": rounded(result.isothermal.scalars["Q_F_W"])}
    reversed_spin = solve_case("article_4_2_spin_combined", {"creepage.spin_rad_mm": 0.03}, grid=grid)
    numbers["combined, spin reversed"] = some(reversed_spin.coupled.scalars, *MAIN) | {
        "gamma_st_without": rounded(reversed_spin.isothermal.scalars["gamma_st"]),
        "Q_F_without_W": rounded(reversed_spin.isothermal.scalars["Q_F_W"])}
    rows = [Row(upper, max(float(p.values.max()) for p in upper), r"$p/p_0$", "viridis"),
            Row(lower, max(float(p.values.max()) for p in lower), r"$|\tau|/p_0$", "viridis")]
    write(map_figure(rows, 1.95, legend=True), folder, "fig_12_spin")
    labels = ("(a, d) ξ_φ = −0.01", "(b, e) ξ_φ = −0.03", "(c, f) ξ_x = ξ_y = 0.001, ξ_φ = −0.03", "the same, ξ_φ = 0.03")
    keys = ("force_x_N", "force_y_N", "gamma_st", "gamma_c", "gamma_p", "Q_F_W")
    lines = [[words, *(plain(n[key]) for key in keys)] for words, n in zip(labels, numbers.values(), strict=True)]
    return {"runs": numbers, "table": table(["case", "F_x (N)", "F_y (N)", "γ_st", "γ_c", "γ_p", "Q_F (W)"], lines)}


def _asymmetry(values: Array) -> float:
    """Largest difference from the mirror image in y, over the largest value."""
    return float(np.abs(values - values[:, ::-1]).max() / values.max())


def _peak_y(view: View, name: str) -> float:
    """|y|/b0 of the largest value, in whole elements."""
    values = field_of(view, 1, name)
    return float(abs(view.y[np.unravel_index(np.argmax(values), values.shape)[1]]) / view.semi_axes[1])


FIGURES = {"11": linear_creepages, "12": spin}

"""The figures of Yu & Suh, from the cases in cases/: each function draws one and returns the numbers that go with it."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import Any

import numpy as np
from figures_drawing import (
    COUPLED,
    DASHED,
    DOTTED,
    ISOTHERMAL,
    THEIRS,
    THIRD,
    Array,
    Numbers,
    Panel,
    Row,
    diagrams,
    edges_on_centreline,
    letter,
    map_figure,
    rounded,
    solve_case,
    some,
    views,
    write,
)
from matplotlib.lines import Line2D

from thermoroll_cli.exact.moving_sources import rectangle_maximum, rectangle_temperature
from thermoroll_cli.exact.source_limits import tian_kennedy_maximum
from thermoroll_cli.files.case import CaseError
from thermoroll_cli.kernels.grid import Grid
from thermoroll_cli.pipeline.result import Result
from thermoroll_cli.pipeline.solve import Solver
from thermoroll_cli.plots.centreline import on_centreline
from thermoroll_cli.plots.sheet import few_ticks
from thermoroll_cli.plots.view import RunView
from thermoroll_cli.solvers.heat import DividedHeat, HeatedBody, HeatResponse

Folder = pathlib.Path

STATES = ("(a) without thermal deformation", "(b) with thermal deformation")
MAIN = ("Q_F_W", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K", "force_x_N", "force_y_N",
        "spin_moment_Nmm")


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
        view, frame = views(result)
        shear = view.states[0].magnitude("shear")
        assert shear is not None
        panels.append(Panel(view, frame, 0, shear / view.peak_pressure, f"({mark}) {words}", arrows=True))
        numbers[mark] = some(result.coupled.scalars, "force_x_N", "force_y_N", "spin_moment_Nmm", "gamma_st", "Q_F_W",
                             "shear_max_MPa")
    rows = [Row(panels[:3], 0.6, r"$|\tau|/p_0$", "viridis"), Row(panels[3:], 0.6, r"$|\tau|/p_0$", "viridis")]
    write(map_figure(rows, 1.95, legend="one"), folder, "fig_04_shear_cases")
    return numbers


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
        rise, _ = HeatResponse(mesh, body, body).temperatures(DividedHeat.evenly(flux, 1.0))
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


def thermal_deformation(folder: Folder, grid: int) -> Numbers:
    """Figs. 6–10: heat flux, temperature, pressure and shear traction of Sec. 4.1 without and with thermal deformation."""
    result = solve_case("article_4_1", grid=grid)
    view, frame = views(result)
    fields = (
        ("fig_06_heat_flux", "heat_flux", view.heat_scale, r"$q\,\alpha l/k$", "inferno"),
        ("fig_07_temperature", "temperature_rise_lower", 1.0, r"$\Delta T$ (K)", "inferno"),
        ("fig_08_pressure", "pressure", view.peak_pressure, r"$p/p_0$", "viridis"),
        ("fig_09_shear", "shear", view.peak_pressure, r"$|\tau|/p_0$", "viridis"),
    )
    for name, field, scale, label, colours in fields:
        values = [_field(view, state, field) / scale for state in (0, 1)]
        top = max(float(v.max()) for v in values)
        arrows = field == "shear"
        panels = [Panel(view, frame, state, values[state], f"{STATES[state]}, max {values[state].max():.3g}", arrows)
                  for state in (0, 1)]
        clipped = field != "temperature_rise_lower"
        write(map_figure([Row(panels, top, label, colours, clipped)], 2.6, legend="two"), folder, name)
    _centrelines(view, folder, fields)
    scales = {f"{speed:g} m/s": _heat_scale(solve_case("article_4_1", {"rolling.speed_m_s": speed}, grid=grid))
              for speed in (120.5, 200.0)}
    return {"by speed": scales, "other velocities of the heat source": _other_velocities(grid)}


def _field(view: RunView, state: int, name: str) -> Array:
    values = view.states[state].magnitude(name) if name == "shear" else view.states[state].field(name)
    assert values is not None
    return values


def _centrelines(view: RunView, folder: Folder, fields: Any) -> None:
    figure, all_axes = diagrams(2, 2, (2.75, 1.75), gap=(0.75, 0.16), bottom=0.72)
    x = view.x / view.semi_axes[0]
    for axes, mark, (_, field, scale, label, _) in zip(all_axes, "abcd", fields, strict=True):
        for state, (colour, dashes) in enumerate(((ISOTHERMAL, "solid"), (COUPLED, DASHED))):
            axes.plot(x, on_centreline(view, _field(view, state, field) / scale), color=colour, linestyle=dashes)
        axes.set_xlim(-1.1, 1.1)
        axes.set_ylim(0.0, axes.get_ylim()[1])
        axes.set_ylabel(label)
        few_ticks(axes, 4, 5)
        axes.tick_params(labelbottom=mark in "cd")
        if mark in "cd":
            axes.set_xlabel(r"$x/a_0$", labelpad=2.0)
        letter(axes, f"({mark})")
    pressure = all_axes[2]
    pressure.axvline(-0.88, **THEIRS)
    pressure.axhline(1.26, **THEIRS)
    handles = [Line2D([], [], color=ISOTHERMAL, label="without thermal deformation"),
               Line2D([], [], color=COUPLED, linestyle=DASHED, label="with thermal deformation"),
               Line2D([], [], label="leading edge and peak in the article", **THEIRS)]
    figure.legend(handles=handles, loc="lower center", ncols=3, handlelength=2.6, borderpad=0.2)
    write(figure, folder, "fig_10_centreline")


def _heat_scale(result: Result) -> Numbers:
    """The numbers of Sec. 4.1: without → with thermal deformation."""
    view, frame = views(result)
    out: Numbers = {}
    for state, words, scalars in ((0, "without", result.isothermal.scalars), (1, "with", result.coupled.scalars)):
        lead, slip, trail = edges_on_centreline(frame, state)
        flux = float(_field(view, state, "heat_flux").max()) / view.heat_scale
        out[words] = some(scalars, *MAIN[:5]) | {
            "leading_edge": rounded(lead), "trailing_edge": rounded(trail), "slip_begins": rounded(slip),
            "slip_length": rounded(trail - slip), "slip_share_of_length": rounded((trail - slip) / (trail - lead)),
            "heat_flux_max": rounded(flux),
        }
    pressure = on_centreline(view, _field(view, 1, "pressure"))
    above = view.x[pressure > view.peak_pressure] / view.semi_axes[0]
    out["with"] |= {"pressure_peak_at": rounded(float(view.x[np.argmax(pressure)]) / view.semi_axes[0]),
                    "above_p0_from": rounded(float(above[0])), "above_p0_to": rounded(float(above[-1]))}
    out["heat_flux_ratio"] = rounded(out["with"]["heat_flux_max"] / out["without"]["heat_flux_max"])
    return out


def _other_velocities(grid: int) -> Numbers:
    """What the other two meanings of the Péclet number make of the same case."""
    out: Numbers = {}
    for mode in ("rolling", "sliding"):
        for name in ("table1", "article_4_1"):
            try:
                # Accuracy 1e-5 asks for the deformation even where it is too small to matter.
                result = solve_case(name, {"thermal.peclet": mode}, grid=grid)
            except (ValueError, CaseError) as cause:
                out[f"{mode}, {name}"] = str(cause).splitlines()[0]
                continue
            iso, coupled = result.isothermal.scalars, result.coupled.scalars
            out[f"{mode}, {name}"] = some(coupled, *MAIN[:5], "approach_um", "thermal_displacement_max_um") | {
                "bulge_over_approach": rounded(iso["thermal_displacement_max_um"] / iso["approach_um"]),
                "skipped": result.work["skipped"].get("deformation", ""),
            }
    return out


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
            view, _ = views(result)
            colour = colormaps["viridis"](0.88 * number / (len(LINEAR) - 1))
            x = view.x / view.semi_axes[0]
            for axes, field in ((left, "pressure"), (right, "shear")):
                line = on_centreline(view, _field(view, 1, field)) / view.peak_pressure
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
    return numbers


def spin(folder: Folder, grid: int) -> Numbers:
    """Fig. 12: pressure and shear traction under spin."""
    cases = (("low", r"$\xi_\phi = -0.01$"), ("high", r"$\xi_\phi = -0.03$"), ("combined", r"$\xi_x = \xi_y = 0.001$, $\xi_\phi = -0.03$"))
    upper, lower, numbers = [], [], {}
    for number, (name, words) in enumerate(cases):
        result = solve_case(f"article_4_2_spin_{name}", grid=grid)
        view, frame = views(result)
        for panels, mark, field in ((upper, "abc", "pressure"), (lower, "def", "shear")):
            values = _field(view, 1, field) / view.peak_pressure
            panels.append(Panel(view, frame, 1, values, f"({mark[number]}) {words}", arrows=field == "shear"))
        numbers[name] = some(result.coupled.scalars, *MAIN) | {
            "asymmetry_in_y": rounded(_asymmetry(_field(view, 1, "pressure")), 2),
            "pressure_peak_at_y": rounded(_peak_y(view)),
            "gamma_st_without": rounded(result.isothermal.scalars["gamma_st"]),
            "Q_F_without_W": rounded(result.isothermal.scalars["Q_F_W"])}
    reversed_spin = solve_case("article_4_2_spin_combined", {"creepage.spin_rad_mm": 0.03}, grid=grid)
    numbers["combined, spin reversed"] = some(reversed_spin.coupled.scalars, *MAIN)
    rows = [Row(upper, max(float(p.values.max()) for p in upper), r"$p/p_0$", "viridis"),
            Row(lower, max(float(p.values.max()) for p in lower), r"$|\tau|/p_0$", "viridis")]
    write(map_figure(rows, 1.95, legend="two"), folder, "fig_12_spin")
    return numbers


def _asymmetry(values: Array) -> float:
    """Largest difference from the mirror image in y, over the largest value."""
    return float(np.abs(values - values[:, ::-1]).max() / values.max())


def _peak_y(view: RunView) -> float:
    pressure = _field(view, 1, "pressure")
    return float(abs(view.y[np.unravel_index(np.argmax(pressure), pressure.shape)[1]]) / view.semi_axes[1])


SPEEDS = tuple(float(v) for v in range(20, 201, 20))
CONFORMITIES: tuple[tuple[str, str, str, dict[str, float]], ...] = (
    ("non-conformal", "article_4_3_non_conformal", ISOTHERMAL, {}),
    ("flat", "article_4_3_flat", THIRD, {}),
    ("conformal, groove 36.7 mm", "article_4_3_conformal", "#cc79a7", {"geometry.lower_radius_y_mm": -110.0 / 3.0}),
    ("conformal, groove 32 mm", "article_4_3_conformal", COUPLED, {}),
)


def speed_and_conformity(folder: Folder, grid: int) -> Numbers:
    """Fig. 13: heat, temperature, areas and peak pressure against rolling speed for bodies of different conformity."""
    figure, (heat, hot, contact, peak) = diagrams(2, 2, (2.75, 1.95), gap=(0.75, 0.5), bottom=0.85)
    stick = _lower_half(figure, contact)
    numbers: Numbers = {}
    for words, name, colour, changes in CONFORMITIES:
        solver = Solver()
        results = [solve_case(name, {**changes, "rolling.speed_m_s": v}, grid=grid, solver=solver) for v in SPEEDS]
        curvature = results[0].problem.geometry.curvature_y
        columns = {key: np.array([r.coupled.scalars[key] for r in results])
                   for key in (*MAIN[:5], "creepage_longitudinal")}
        marked = {"color": colour, "marker": "o", "markersize": 2.2, "linewidth": 1.1}
        heat.plot(SPEEDS, columns["Q_F_W"], **marked, label=rf"{words}: $R'_y = {1e3 / curvature:.0f}$ mm")
        hot.plot(SPEEDS, columns["temperature_rise_max_lower_K"], **marked)
        contact.plot(SPEEDS, columns["gamma_c"], **marked)
        stick.plot(SPEEDS, columns["gamma_st"], **marked)
        peak.plot(SPEEDS, columns["gamma_p"], **marked)
        iso = results[-1].isothermal.scalars
        numbers[words] = {
            "R_y_mm": rounded(1e3 / curvature), **{k: rounded(v) for k, v in results[0].hertz.items()},
            "speeds_m_s": list(SPEEDS), **{k: [rounded(float(v), 5) for v in column] for k, column in columns.items()},
            "isothermal_at_last": some(iso, *MAIN[:5], "creepage_longitudinal"),
        }
    labels = ("total frictional heat $Q_F$ (W)", "maximum temperature rise (K)", r"$\gamma_c$", r"$\gamma_{st}$", r"$\gamma_p$")
    for axes, mark, label in zip((heat, hot, contact, stick, peak), ("(a)", "(b)", "", "(c)", "(d)"), labels, strict=True):
        axes.set_xlim(0.0, 208.0)
        axes.set_ylabel(label)
        few_ticks(axes, 5, 3 if axes in (contact, stick) else 5)
        letter(axes, mark)
        if axes is not contact:
            axes.set_xlabel("rolling speed (m/s)", labelpad=2.0)
    contact.tick_params(labelbottom=False)
    heat.set_ylim(bottom=0.0)
    hot.set_ylim(bottom=0.0)
    handles, words = heat.get_legend_handles_labels()
    figure.legend(handles, words, loc="lower center", ncols=2, handlelength=2.6, borderpad=0.2)
    write(figure, folder, "fig_13_speed_conformity")
    return numbers


def _lower_half(figure: Any, axes: Any) -> Any:
    """Leave `axes` the upper half of its place and return new axes in the lower one."""
    box = axes.get_position()
    half = 0.47 * box.height
    axes.set_position((box.x0, box.y1 - half, box.width, half))
    lower = figure.add_axes((box.x0, box.y0, box.width, half))
    lower.grid(color="0.92", linewidth=0.5)
    lower.set_axisbelow(True)
    return lower


def overview(folder: Folder, grid: int) -> Numbers:
    """The picture at the top of the README: one contact with creepage, spin and heat."""
    result = solve_case("article_4_1", {"creepage.longitudinal": 0.002, "creepage.spin_rad_mm": 0.01}, grid=grid)
    view, frame = views(result)
    pressure, shear, rise = (_field(view, 1, name) for name in ("pressure", "shear", "temperature_rise_lower"))
    fields = ((pressure / view.peak_pressure, "pressure $p/p_0$", "viridis", False),
              (shear / view.peak_pressure, r"shear traction $|\tau|/p_0$", "viridis", True),
              (rise, "temperature rise (K)", "inferno", False))
    figure, all_axes = _strip(len(fields))
    for axes, (values, words, colours, arrows) in zip(all_axes, fields, strict=True):
        _strip_panel(figure, axes, Panel(view, frame, 1, values, words, arrows), colours)
    write(figure, folder, "overview")
    return some(result.coupled.scalars, *MAIN)


def _strip(count: int) -> tuple[Any, list[Any]]:
    from figures_drawing import DPI

    from thermoroll_cli.plots.sheet import add_axes, new_figure

    side, step = 2.2, 3.12
    figure = new_figure(0.5 + count * step - 0.2, side + 0.72)
    figure.set_dpi(DPI)
    return figure, [add_axes(figure, 0.5 + i * step, 0.42, side, side) for i in range(count)]


def _strip_panel(figure: Any, axes: Any, panel: Panel, colours: str) -> None:
    from thermoroll_cli.plots.maps import draw_arrows, draw_map

    frame = dataclasses.replace(panel.frame, window=(-1.08, 1.08, -1.08, 1.08))
    top = float(panel.values.max())
    image = draw_map(axes, frame, panel.values, state=1, colours=colours, limits=(0.0, top),
                     clipped=colours != "inferno")
    if panel.arrows:
        draw_arrows(axes, panel.view, frame, 1, (2.2, 2.2))
    axes.set_title(panel.words, y=1.0, pad=4.0)
    axes.set_xlabel(r"$x/a_0$", labelpad=2.0)
    axes.set_ylabel(r"$y/b_0$", labelpad=1.0)
    few_ticks(axes, 4, 4)
    box = axes.get_position()
    bar = figure.add_axes((box.x1 + 0.008, box.y0, 0.011, box.height))
    figure.colorbar(image, cax=bar)
    few_ticks(bar, y=5)


FIGURES = {
    "overview": overview,
    "4": shear_cases,
    "5": moving_source,
    "6-10": thermal_deformation,
    "11": linear_creepages,
    "12": spin,
    "13": speed_and_conformity,
}


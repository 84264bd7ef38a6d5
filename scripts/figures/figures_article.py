"""The figures of Yu & Suh: shear tractions and moving sources (4, 5), one contact without and with thermal deformation (6–10),
combinations of creepages and spin (11, 12), rolling speed and conformity at a given force (13)."""

from __future__ import annotations

import dataclasses
import json
import math
import pathlib
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from scripts.figures.figures_drawing import (
    COUPLED,
    DASHED,
    DOTTED,
    ISOTHERMAL,
    MAIN,
    ROOT,
    THEIRS,
    Array,
    Numbers,
    Panel,
    Row,
    View,
    diagrams,
    edges_on_centreline,
    field_of,
    letter,
    map_figure,
    on_centreline,
    plain,
    rounded,
    solve_case,
    solve_problem,
    some,
    table,
    view_of,
    write,
)
from thermoroll_cli import Case, sweep
from thermoroll_cli.exact.moving_sources import rectangle_maximum, rectangle_temperature, tian_kennedy_maximum
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatedBody, HeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.plots.style import few_ticks
from thermoroll_cli.problem.problem import Numerics, PecletMode
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver

Folder = pathlib.Path


def shear_cases(folder: Folder, grid: int) -> Numbers:
    """Fig. 4: shear traction of the five cases of Sec. 3.1, and of the fifth with its spin reversed."""
    cases: list[tuple[str, str, str, dict[str, Any]]] = [
        ("a", r"$\xi_x = 0.00135$", "article_3_1_case_1", {}),
        ("b", r"$\xi_{x,y} = 0.00135$", "article_3_1_case_2", {}),
        ("c", r"$\xi_\phi = 0.02$", "article_3_1_case_3", {}),
        ("d", r"$\xi_x = 0.00135$, $\xi_\phi = 0.01$", "article_3_1_case_4", {}),
        ("e", r"$\xi_{x,y} = 0.00135$, $\xi_\phi = 0.01$", "article_3_1_case_5", {}),
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
    write(map_figure(rows, 1.6, legend=True), folder, "fig_04_shear_cases")
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


PICTURES = {"fig_06_heat_flux": "heat_flux", "fig_07_temperature": "temperature", "fig_08_pressure": "pressure",
            "fig_09_shear": "traction", "fig_10_centreline": "centreline"}  # fmt: skip
LEADING_EDGE, PEAK = -0.88, 1.26
"""Values of the article, over a₀ and p₀."""


def thermal_deformation(folder: Folder, grid: int) -> Numbers:
    """Figs. 6–10: heat flux, temperature, pressure and shear traction of Sec. 4.1 without and with thermal deformation, as the
    program draws them in the article's normalisation."""
    result = solve_case("article_4_1", grid=grid)
    for name, kind in PICTURES.items():
        picture = figure(result, kind, normalised=True)
        assert picture is not None
        if kind == "centreline":
            (pressure,) = (axes for axes in picture.axes if axes.get_ylabel().startswith("pressure"))
            pressure.axvline(LEADING_EDGE, **THEIRS)
            pressure.axhline(PEAK, **THEIRS)
        write(picture, folder, name)
    scales = {f"{speed:g} m/s": _heat_scale(solve_case("article_4_1", {"rolling.speed_m_s": speed}, grid=grid))
              for speed in (120.5, 200.0)}
    others = _other_velocities(grid)
    return {"by speed": scales, "other velocities of the heat source": others, "table": _section_4_1(scales),
            "velocities": _velocity_table(others)}


def _heat_scale(result: Result) -> Numbers:
    """The numbers of Sec. 4.1: without → with thermal deformation."""
    view = view_of(result)
    out: Numbers = {}
    for state, words, scalars in ((0, "without", result.isothermal.scalars), (1, "with", result.coupled.scalars)):
        lead, slip, trail = edges_on_centreline(view, state)
        flux = float(field_of(view, state, "heat_flux").max()) / view.heat_scale
        out[words] = some(scalars, *MAIN[:5]) | {
            "leading_edge": rounded(lead), "trailing_edge": rounded(trail), "slip_begins": rounded(slip),
            "slip_length": rounded(trail - slip), "slip_share_of_length": rounded((trail - slip) / (trail - lead)),
            "heat_flux_max": rounded(flux),
        }
    pressure = on_centreline(view, field_of(view, 1, "pressure"))
    flux = on_centreline(view, field_of(view, 1, "heat_flux"))
    above = view.x[pressure > view.peak_pressure] / view.semi_axes[0]
    out["with"] |= {"pressure_peak_at": rounded(float(view.x[np.argmax(pressure)]) / view.semi_axes[0]),
                    "heat_flux_peak_at": rounded(float(view.x[np.argmax(flux)]) / view.semi_axes[0]),
                    "above_p0_from": rounded(float(above[0])), "above_p0_to": rounded(float(above[-1]))}
    out["heat_flux_ratio"] = rounded(out["with"]["heat_flux_max"] / out["without"]["heat_flux_max"])
    return out


def _section_4_1(scales: Numbers) -> Numbers:
    """Sec. 4.1 line by line: the article, and both heat scales."""
    lines = (
        ("total frictional heat Q_F (W)", "6.8 → 5.6", "Q_F_W", "{:.2f}"),
        ("largest pressure γ_p", "1 → 1.26", "gamma_p", "{:.3f}"),
        ("leading edge x/a₀ on y = 0", "−1.0 → −0.88", "leading_edge", "{:.3f}"),
        ("contact area γ_c", "not stated", "gamma_c", "{:.3f}"),
        ("stick area γ_st", "not stated", "gamma_st", "{:.3f}"),
        ("largest heat flux q α l/k", "0.102 → 0.132", "heat_flux_max", "{:.4f}"),
        ("slip length over contact length", "0.78 → 0.5", "slip_share_of_length", "{:.3f}"),
        ("largest temperature rise (K)", "\"did not differ significantly\"", "temperature_rise_max_lower_K", "{:.0f}"),
    )
    rows = []
    for words, article, key, form in lines:
        cells = (f"{form.format(s['without'][key])} → {form.format(s['with'][key])}" for s in scales.values())
        rows.append([words, article, *(cell.replace("-", "−") for cell in cells)])
    return table(["quantity, without → with thermal deformation", "article", *(f"V = {speed}" for speed in scales)], rows)


def _velocity_table(others: Numbers) -> Numbers:
    rows = []
    for name, n in others.items():
        mode, case = name.split(", ")
        rows.append([f'`"{mode}"`', "1" if case == "table1" else "200", f"{n['Q_F_W']:.4g}",
                     f"{n['temperature_rise_max_lower_K']:.3g}",
                     f"{n['bulge_over_approach']:.1e}", f"{n['gamma_p']:.3f}", f"{n['gamma_c']:.3f}",
                     "skipped" if n["skipped"] else "solved"])
    return table(["`thermal.peclet`", "V (m/s)", "Q_F (W)", "ΔT_max (K)", "bulge / approach", "γ_p", "γ_c",
                  "feedback on the gap"], rows)


def _other_velocities(grid: int) -> Numbers:
    """The same case with the other two meanings of the Péclet number."""
    out: Numbers = {}
    modes: tuple[PecletMode, ...] = ("rolling", "sliding", "stationary")
    for mode in modes:
        for name in ("table1", "article_4_1"):
            base = Case.read(ROOT / "cases" / f"{name}.toml").problem
            heating = dataclasses.replace(base.heating, peclet=mode)
            numerics = Numerics(grid=(grid, grid), extent=base.numerics.extent)
            result = solve_problem(dataclasses.replace(base, heating=heating, numerics=numerics))
            iso, coupled = result.isothermal, result.coupled.scalars
            inside = iso.fields["state"] > 0
            bulge = float(np.ptp(iso.fields["displacement_thermal"][inside])) * 1e6
            out[f"{mode}, {name}"] = some(coupled, *MAIN[:5]) | {
                "bulge_over_approach": rounded(bulge / iso.scalars["approach_um"]),
                "skipped": result.work["skipped"].get("deformation", ""),
            }
    return out


LINEAR = {0.001: "#000000", 0.002: "#3b3f9e", 0.003: "#0072b2", 0.004: "#a5538f", 0.005: "#d55e00"}
"""Creepages of Fig. 11 and their colours, all dark enough on white."""


def linear_creepages(folder: Folder, grid: int) -> Numbers:
    """Fig. 11: pressure and shear traction on the centre line for combinations of linear creepages."""
    figure, (left, right) = diagrams(1, 2, (2.75, 2.3), bottom=0.78)
    solver = Solver()
    numbers: Numbers = {}
    for family, other, dashes in (("longitudinal", "lateral", "solid"), ("lateral", "longitudinal", DASHED)):
        for creepage, colour in LINEAR.items():
            changes = {f"creepage.{family}": creepage, f"creepage.{other}": 0.001}
            result = solve_case("article_4_2_linear", changes, grid=grid, solver=solver)
            view = view_of(result)
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
    handles = [Line2D([], [], color=colour, label=f"{creepage:g}") for creepage, colour in LINEAR.items()]
    handles += [Line2D([], [], color="0.25", label=r"$\xi_x$ varies, $\xi_y = 0.001$"),
                Line2D([], [], color="0.25", linestyle=DASHED, label=r"$\xi_y$ varies, $\xi_x = 0.001$"),
                Line2D([], [], color="0.45", linestyle=DOTTED, linewidth=0.9, label="Hertz")]
    figure.legend(handles=handles, loc="lower center", ncols=4, handlelength=1.9, columnspacing=1.1, borderpad=0.2)
    write(figure, folder, "fig_11_linear_creepages")
    return {"runs": numbers}


def spin(folder: Folder, grid: int) -> Numbers:
    """Fig. 12: pressure and shear traction under spin."""
    cases = (("low", r"$\xi_\phi = -0.01$"), ("high", r"$\xi_\phi = -0.03$"),
             ("combined", r"$\xi_{x,y} = 0.001$, $\xi_\phi = -0.03$"))
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
    write(map_figure(rows, 1.6, legend=True), folder, "fig_12_spin")
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


SPEEDS = tuple(float(v) for v in range(20, 201, 20))
RADII = {"non-conformal": 30.0, "flat": math.inf, "conformal, groove 36.7 mm": -110.0 / 3.0, "conformal, groove 32 mm": -32.0}
"""Lateral radius of the lower body in mm; the upper one is a sphere of 30 mm."""
SCALARS = ("Q_F_W", "temperature_rise_max_lower_K", "gamma_c", "gamma_st", "gamma_p")


LABELS = ("$Q_F$ (W)", r"$\Delta T_{max}$ (K)", r"$\gamma_c$", r"$\gamma_{st}$", r"$\gamma_p$")


def speed_and_conformity(folder: pathlib.Path, grid: int) -> Numbers:
    """Fig. 13: a sweep without differential slip, which the article's equations do not have."""
    case = Case.read(ROOT / "cases" / "article_4_3_conformal.toml").with_values(
        {"rolling.differential_slip": False, "numerics.grid": grid})
    rows = sweep(case, {"geometry.lower_radius_y_mm": list(RADII.values()), "rolling.speed_m_s": list(SPEEDS)})
    figure, axes = diagrams(2, 3, (1.75, 1.6), gap=(0.62, 0.34), bottom=0.42)
    runs: Numbers = {}
    for number, (words, radius) in enumerate(RADII.items()):
        own = rows[number * len(SPEEDS) : (number + 1) * len(SPEEDS)]
        assert all(row["status"] == "converged" for row in own), words
        for place, name in zip(axes, SCALARS, strict=False):
            place.plot(SPEEDS, [row[name] for row in own], color=f"C{number}", marker="o", markersize=2.0, label=words)
            place.plot(SPEEDS, [row["isothermal"][name] for row in own], color=f"C{number}", linestyle=DASHED, linewidth=0.8)
        runs[words] = {"R_y_mm": rounded(1.0 / (1.0 / 30.0 + 1.0 / radius)), "speeds_m_s": list(SPEEDS),
                       **{name: [rounded(row[name], 5) for row in own] for name in (*SCALARS, "creepage_longitudinal")}}
    for number, (place, label) in enumerate(zip(axes, LABELS, strict=False)):
        place.set_ylabel(label)
        place.tick_params(labelbottom=number > 1)
        place.set_xlabel("rolling speed (m/s)" if number > 1 else "")
        few_ticks(place, 4, 5)
    axes[5].set_axis_off()
    handles = [*axes[0].get_legend_handles_labels()[0],
               Line2D([], [], color="0.2", linestyle=DASHED, linewidth=0.8, label="without thermal\ndeformation")]
    axes[5].legend(handles=handles, loc="center", title="lower body")
    write(figure, folder, "fig_13_speed_conformity")
    return {"runs": runs, "table": _trends(runs)}


def _trends(runs: Numbers) -> Numbers:
    """First and last speed of each body."""
    forms = ("{:.3g}", "{:.3g}", "{:.4f}", "{:.4f}", "{:.4f}")
    rows = [[words, f"{n['R_y_mm']:g}", *(f"{form} → {form}".format(n[name][0], n[name][-1])
                                           for name, form in zip(SCALARS, forms, strict=True))]
            for words, n in runs.items()]
    return table(["bodies", "R′_y (mm)", "Q_F (W)", "ΔT_max (K)", "γ_c", "γ_st", "γ_p"], rows)


FIGURES = {"4": shear_cases, "5": moving_source, "6-10": thermal_deformation, "11": linear_creepages, "12": spin,
           "13": speed_and_conformity}

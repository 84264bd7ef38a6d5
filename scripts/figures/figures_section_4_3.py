"""Fig. 13 of Yu & Suh: rolling speed and conformity at a given force."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

from scripts.figures.figures_drawing import (
    COUPLED,
    ISOTHERMAL,
    MAIN,
    THIRD,
    Numbers,
    diagrams,
    letter,
    rounded,
    solve_case,
    some,
    table,
    write,
)
from thermoroll_cli.plots.style import few_ticks
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import Solver

Folder = pathlib.Path


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
        # The article's equations have no differential slip.
        changes = {**changes, "rolling.differential_slip": False}
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
            "bulge_over_approach_at_last": rounded(_bulge(results[-1])),
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
    peak.set_ylim(bottom=1.0)
    handles, words = heat.get_legend_handles_labels()
    figure.legend(handles, words, loc="lower center", ncols=2, handlelength=2.6, borderpad=0.2)
    write(figure, folder, "fig_13_speed_conformity")
    return {"runs": numbers, "table": _trends(numbers)}


def _bulge(result: Result) -> float:
    """Variation of the thermal expansion over the contact, over the approach without it."""
    inside = result.coupled.fields["state"] > 0
    return float(np.ptp(result.coupled.fields["displacement_thermal"][inside])) * 1e6 / result.isothermal.scalars["approach_um"]


def _trends(numbers: Numbers) -> Numbers:
    """First and last speed of each body."""
    rows = []
    for words, n in numbers.items():
        ends = [{key: n[key][i] for key in (*MAIN[:5], "creepage_longitudinal")} for i in (0, -1)]
        first, last = ends
        rows.append([
            words, f"{n['R_y_mm']:g}",
            *(f"{first[key]:.3g} → {last[key]:.3g}" for key in ("Q_F_W", "temperature_rise_max_lower_K")),
            *(f"{first[key]:.4f} → {last[key]:.4f}" for key in ("gamma_c", "gamma_st", "gamma_p")),
        ])
    return table(["bodies", "R′_y (mm)", "Q_F (W)", "ΔT_max (K)", "γ_c", "γ_st", "γ_p"], rows)


def _lower_half(figure: Any, axes: Any) -> Any:
    """Leave `axes` the upper half of its place and return new axes in the lower one."""
    box = axes.get_position()
    half = 0.47 * box.height
    axes.set_position((box.x0, box.y1 - half, box.width, half))
    lower = figure.add_axes((box.x0, box.y0, box.width, half))
    lower.grid(color="0.92", linewidth=0.5)
    lower.set_axisbelow(True)
    return lower


FIGURES = {"13": speed_and_conformity}

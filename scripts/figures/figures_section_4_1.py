"""Figs. 6–10 of Yu & Suh: one contact without and with thermal deformation, at two heat scales."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np

from scripts.figures.figures_drawing import (
    MAIN,
    ROOT,
    THEIRS,
    Numbers,
    edges_on_centreline,
    field_of,
    on_centreline,
    rounded,
    solve_case,
    solve_problem,
    some,
    table,
    view_of,
    write,
)
from thermoroll_cli import Case
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.problem import Numerics, PecletMode
from thermoroll_cli.problem.result import Result

Folder = pathlib.Path


PICTURES = {"fig_06_heat_flux": "heat_flux", "fig_07_temperature": "temperature", "fig_08_pressure": "pressure",
            "fig_09_shear": "traction", "fig_10_centreline": "centreline"}  # fmt: skip
LEADING_EDGE, PEAK = -0.88, 1.26
"""Of the article, over a₀ and p₀."""


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
    """What the other two meanings of the Péclet number make of the same case."""
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


FIGURES = {"6-10": thermal_deformation}

"""Fig. 13 of Yu & Suh: rolling speed and conformity at a given force."""

from __future__ import annotations

import math
import pathlib
import tempfile

from scripts.figures.figures_drawing import ROOT, Numbers, rounded, table
from thermoroll_cli import Case, sweep
from thermoroll_cli.cli.main import main

SPEEDS = tuple(float(v) for v in range(20, 201, 20))
RADII = {"non-conformal": 30.0, "flat": math.inf, "conformal, groove 36.7 mm": -110.0 / 3.0, "conformal, groove 32 mm": -32.0}
"""Lateral radius of the lower body in mm; the upper one is a sphere of 30 mm."""
SCALARS = ("Q_F_W", "temperature_rise_max_lower_K", "gamma_c", "gamma_st", "gamma_p")


def speed_and_conformity(folder: pathlib.Path, grid: int) -> Numbers:
    """Fig. 13 as a sweep, without differential slip, which the article's equations do not have."""
    case = Case.read(ROOT / "cases" / "article_4_3_conformal.toml").with_values(
        {"rolling.differential_slip": False, "numerics.grid": grid})
    over = {"geometry.lower_radius_y_mm": list(RADII.values()), "rolling.speed_m_s": list(SPEEDS)}
    with tempfile.TemporaryDirectory() as place:
        rows = sweep(case, over, place)
        if main(["plot", f"{place}/sweep.csv", "-o", place]) != 0:
            raise RuntimeError("the sweep is not drawn")
        pathlib.Path(place, "sweep.png").replace(folder / "fig_13_speed_conformity.png")
    runs: Numbers = {}
    for number, (words, radius) in enumerate(RADII.items()):
        own = rows[number * len(SPEEDS) : (number + 1) * len(SPEEDS)]
        assert all(row["status"] == "converged" for row in own), words
        runs[words] = {"R_y_mm": rounded(1.0 / (1.0 / 30.0 + 1.0 / radius)), "speeds_m_s": list(SPEEDS),
                       **{name: [rounded(row[name], 5) for row in own] for name in (*SCALARS, "creepage_longitudinal")}}
    return {"runs": runs, "table": _trends(runs)}


def _trends(runs: Numbers) -> Numbers:
    """First and last speed of each body."""
    forms = ("{:.3g}", "{:.3g}", "{:.4f}", "{:.4f}", "{:.4f}")
    rows = [[words, f"{n['R_y_mm']:g}", *(f"{form} → {form}".format(n[name][0], n[name][-1])
                                           for name, form in zip(SCALARS, forms, strict=True))]
            for words, n in runs.items()]
    return table(["bodies", "R′_y (mm)", "Q_F (W)", "ΔT_max (K)", "γ_c", "γ_st", "γ_p"], rows)


FIGURES = {"13": speed_and_conformity}

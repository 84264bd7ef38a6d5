"""The Manchester contact benchmark beside CONTACT's results."""

from __future__ import annotations

import pathlib

from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, Numbers, diagrams, solve_problem, table, write
from scripts.manchester import case_beside, contact_results

HEADER = ("displacement (mm)", "largest pressure (MPa)", "approach (μm)", "F_x (N)", "F_y (N)")


def manchester(folder: pathlib.Path, grid: int) -> Numbers:
    """Largest pressure, approach and forces over the lateral displacement; "here / CONTACT" in each cell of the table."""
    theirs = contact_results()
    here = [solve_problem(case_beside(result).problem).coupled.scalars for result in theirs]
    at = [result["lateral_displacement_mm"] for result in theirs]
    figure, (left, right) = diagrams(1, 2, (2.75, 1.9))
    left.plot(at, [s["pressure_max_MPa"] for s in here], color=ISOTHERMAL, label="thermoroll")
    circles = {"fillstyle": "none", "markersize": 4}
    left.plot(at, [r["pressure_max_MPa"] for r in theirs], "o", color=ISOTHERMAL, label="CONTACT", **circles)
    left.set_ylabel("largest pressure (MPa)")
    left.legend(loc="lower right")
    limits = [0.3 * r["normal_N"] for r in theirs]
    for own, other, colour, label in (("force_x_N", "force_x_N", ISOTHERMAL, "x"), ("force_y_N", "force_s_N", COUPLED, "y")):
        values = [s[own] / limit for s, limit in zip(here, limits, strict=True)]
        right.plot(at, values, color=colour, label=rf"$F_{label}/\mu W$")
        right.plot(at, [r[other] / limit for r, limit in zip(theirs, limits, strict=True)], "o", color=colour, **circles)
    right.legend(loc="center right")
    for axes in (left, right):
        axes.set_xlabel("lateral displacement (mm)")
    write(figure, folder, "manchester")
    rows = [[f"{r['lateral_displacement_mm']:g}", f"{s['pressure_max_MPa']:.0f} / {r['pressure_max_MPa']:.0f}",
             f"{s['approach_um']:.1f} / {1e3 * r['approach_mm']:.1f}", f"{s['force_x_N']:.0f} / {r['force_x_N']:.0f}",
             f"{s['force_y_N']:.0f} / {r['force_s_N']:.0f}"]
            for s, r in zip(here, theirs, strict=True) if r["lateral_displacement_mm"] in (0.0, 2.0, 4.0, 6.0, 8.0, 10.0)]
    return {"table": table(HEADER, rows)}


FIGURES = {"manchester": manchester}

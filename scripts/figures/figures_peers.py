"""Beside CONTACT and measurements: the Manchester contact benchmark, and creep forces of a locomotive."""

from __future__ import annotations

import json
import pathlib
from dataclasses import replace

import numpy as np

from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, ROOT, Numbers, diagrams, solve_problem, table, write
from scripts.manchester import case_beside, contact_results
from thermoroll_cli import Case
from thermoroll_cli.problem.friction import Interlayer
from thermoroll_cli.problem.problem import Problem

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


REFERENCE = ROOT / "tests" / "reference"
GRID = 64
DEVIATIONS = ("", "rms of measured less computed force over W", "mean")


def eurosprinter(folder: pathlib.Path, grid: int) -> Numbers:
    """Creep curves over the points; deviations of the points from both curves."""
    measured = np.array(json.loads((REFERENCE / "friction_eurosprinter_measured.json").read_text())["points"]).T
    theirs = json.loads((REFERENCE / "friction_tractcurv.json").read_text())["series"]
    model = Case.read(ROOT / "cases" / "eurosprinter.toml").problem
    model = replace(model, numerics=replace(model.numerics, grid=(min(grid, GRID),) * 2))
    constant = replace(model, friction=replace(model.friction, law=None), interlayer=Interlayer())
    curves = {"layer_falling_memory": ("layer, falling friction, memory", model, COUPLED),
              "constant_friction": ("constant friction", constant, ISOTHERMAL)}
    figure, (axes,) = diagrams(1, 1, (5.0, 2.6))
    axes.plot(*measured, ".", color="0.6", markersize=3.5, label="measured (Engel, Beck, Alders 1998)")
    rows = []
    for name, (label, problem, colour) in curves.items():
        at = np.array(theirs[name]["creepage"])
        force = np.array([_force(problem, float(creepage)) for creepage in at])
        axes.plot(at, force, color=colour, label=label)
        forces = problem.friction.coefficient * np.array(theirs[name]["force_x_over_mu0W"])
        axes.plot(at, forces, "o", color=colour, fillstyle="none",
                  markersize=3.5, label="CONTACT" if name == "constant_friction" else "_")
        apart = measured[1] - np.interp(measured[0], at, force)
        rows.append([label, f"{np.sqrt(np.mean(apart**2)):.3f}", f"{np.mean(apart):+.3f}".replace("-", "−")])
    axes.set(xlabel="longitudinal creepage", ylabel=r"$F_x/W$", xlim=(0.0, 0.26), ylim=(0.0, None))
    axes.legend(loc="lower right")
    write(figure, folder, "eurosprinter")
    return {"table": table(DEVIATIONS, rows)}


def _force(problem: Problem, creepage: float) -> float:
    result = solve_problem(replace(problem, motion=replace(problem.motion, creepage_x=creepage)))
    return float(result.coupled.scalars["force_x_N"] / problem.normal_force)


FIGURES = {"manchester": manchester, "eurosprinter": eurosprinter}

"""Measured creep forces of a locomotive beside the model, constant friction, and CONTACT's results of both."""

from __future__ import annotations

import json
import pathlib
from dataclasses import replace

import numpy as np

from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, ROOT, Numbers, diagrams, solve_problem, table, write
from thermoroll_cli import Case
from thermoroll_cli.problem.problem import Problem

REFERENCE = ROOT / "tests" / "reference"
GRID = 64
HEADER = ("", "rms of measured less computed force over W", "mean")


def eurosprinter(folder: pathlib.Path, grid: int) -> Numbers:
    """Creep curves over the points; deviations of the points from both curves."""
    measured = np.array(json.loads((REFERENCE / "friction_eurosprinter_measured.json").read_text())["points"]).T
    theirs = json.loads((REFERENCE / "friction_tractcurv.json").read_text())["series"]
    model = Case.read(ROOT / "cases" / "eurosprinter.toml").problem
    model = replace(model, numerics=replace(model.numerics, grid=(min(grid, GRID),) * 2))
    constant = replace(model, friction_law=None, layer=0.0)
    curves = {"layer_falling_memory": ("layer, falling friction, memory", model, COUPLED),
              "constant_friction": ("constant friction", constant, ISOTHERMAL)}
    figure, (axes,) = diagrams(1, 1, (5.0, 2.6))
    axes.plot(*measured, ".", color="0.6", markersize=3.5, label="measured (Engel, Beck, Alders 1998)")
    rows = []
    for name, (label, problem, colour) in curves.items():
        at = np.array(theirs[name]["creepage"])
        force = np.array([_force(problem, float(creepage)) for creepage in at])
        axes.plot(at, force, color=colour, label=label)
        axes.plot(at, problem.friction * np.array(theirs[name]["force_x_over_mu0W"]), "o", color=colour, fillstyle="none",
                  markersize=3.5, label="CONTACT" if name == "constant_friction" else "_")
        apart = measured[1] - np.interp(measured[0], at, force)
        rows.append([label, f"{np.sqrt(np.mean(apart**2)):.3f}", f"{np.mean(apart):+.3f}".replace("-", "−")])
    axes.set(xlabel="longitudinal creepage", ylabel=r"$F_x/W$", xlim=(0.0, 0.26), ylim=(0.0, None))
    axes.legend(loc="lower right")
    write(figure, folder, "eurosprinter")
    return {"table": table(HEADER, rows)}


def _force(problem: Problem, creepage: float) -> float:
    result = solve_problem(replace(problem, motion=replace(problem.motion, creepage_x=creepage)))
    return float(result.coupled.scalars["force_x_N"] / problem.normal_force)


FIGURES = {"eurosprinter": eurosprinter}

"""Creep curves from a table beside direct solves."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np

from scripts.figures.figures_drawing import COUPLED, DPI, ISOTHERMAL, ROOT, THIRD, Numbers, new_figure, rounded, write
from thermoroll_cli import Case, CreepForceTable
from thermoroll_cli.plots.style import add_axes, few_ticks
from thermoroll_cli.problem.problem import Motion, Numerics
from thermoroll_cli.python_api import Solver

SPINS = ((0.0, ISOTHERMAL), (0.5, THIRD), (1.5, COUPLED))
"""Spin φ' of each curve."""
MOST = 2.0


def creep_table(folder: pathlib.Path, grid: int) -> Numbers:
    """F_x over ξ' and F_y over η' of a circle at three spins: the table as curves, solves on a fine grid as dots."""
    table = CreepForceTable.read(ROOT / "cases" / "creep_forces_circle.h5")
    case = Case.read(ROOT / "cases" / "table1.toml").with_values({"thermal.heat": False})
    problem = dataclasses.replace(case.problem, numerics=Numerics(grid=(grid, grid)))
    solver = Solver()
    hertz = solver.solve(problem).of_problem
    mean = hertz["hertz_a_mm"] * 1e-3
    unit = problem.traction_limit / (problem.lower.shear_modulus * mean**2)
    contact = {"semi_axes": (1.0, 1.0), "shear_modulus": 1.0, "friction": 1.0, "load": 1.0}
    figure = new_figure(7.2, 2.7)
    figure.set_dpi(DPI)
    curve, dots = np.linspace(0.0, MOST, 200), np.linspace(0.0, MOST, 9)[1:]
    largest = 0.0
    for panel, (name, words) in enumerate((("force_x", "F_x"), ("force_y", "F_y"))):
        axes = add_axes(figure, 0.6 + 3.5 * panel, 0.5, 2.9, 2.0)
        for spin, colour in SPINS:
            along = (curve, 0.0, spin) if panel == 0 else (0.0, curve, spin)
            axes.plot(curve, getattr(table.forces(*along, **contact), name), color=colour, label=rf"$\varphi' = {spin:g}$")
            found = []
            for dot in dots:
                x, y = (dot, 0.0) if panel == 0 else (0.0, dot)
                motion = Motion(1.0, x * unit, y * unit, spin * unit / mean, differential_slip=False)
                result = solver.solve(dataclasses.replace(problem, motion=motion))
                found.append(result.coupled.scalars[f"{name}_N"] / problem.traction_limit)
            axes.plot(dots, found, "o", color=colour, markersize=3.5, fillstyle="none")
            own = getattr(table.forces(*((dots, 0.0, spin) if panel == 0 else (0.0, dots, spin)), **contact), name)
            largest = max(largest, float(np.abs(own - found).max()))
        axes.set_xlabel(r"$\xi'$" if panel == 0 else r"$\eta'$")
        axes.set_ylabel(rf"${words}/\mu W$")
        few_ticks(axes, 5, 5)
        axes.legend(loc="lower right", frameon=False)
    write(figure, folder, "creep_table")
    return {"largest difference over μW": rounded(largest, 2)}


FIGURES = {"creep_table": creep_table}

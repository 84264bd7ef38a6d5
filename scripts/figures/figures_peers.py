"""Beside CONTACT and measurements: the Manchester contact benchmark, and creep forces of a locomotive."""

from __future__ import annotations

import json
import pathlib
from dataclasses import replace

import numpy as np

from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, ROOT, Numbers, diagrams, solve_problem, table, write
from scripts.manchester import SHIFTS, contact_results, wheelset_at
from thermoroll_cli import Case, conicity
from thermoroll_cli.plots.conicity_figure import draw_conicity
from thermoroll_cli.problem.friction import Interlayer
from thermoroll_cli.problem.problem import Problem

HEADER = ("shift (mm)", "roll (mrad)", "angular velocity (rad/s)", "F_x left (N)", "F_y left (N)", "F_x right (N)",
          "F_y right (N)", "left wheel (K)", "right wheel (K)")


def manchester(folder: pathlib.Path, grid: int) -> Numbers:
    """Forces on both rails over the displacement; "here / CONTACT" in each cell of the table, and the temperatures."""
    theirs = contact_results()
    here = {shift: wheelset_at(shift, min(grid, WHEELSET_GRID)) for shift in SHIFTS}
    figure, panels = diagrams(1, 2, (2.75, 1.9))
    circles = {"fillstyle": "none", "markersize": 4}
    rows = []
    for axes, side in zip(panels, ("left", "right"), strict=True):
        for number, (name, colour) in enumerate((("x", ISOTHERMAL), ("y", COUPLED))):
            axes.plot(SHIFTS, [1e-3 * here[shift].scalars[f"track_force_{name}_{side}_N"] for shift in SHIFTS], color=colour,
                      label=f"along {name}")
            axes.plot(SHIFTS, [1e-3 * theirs[side, shift]["contact"]["force_rail_track_N"][number] for shift in SHIFTS], "o",
                      color=colour, **circles)
        axes.set(xlabel="shift (mm)", ylabel=f"force on the {side} rail (kN)")
    panels[1].legend(loc="upper left")
    write(figure, folder, "manchester")
    for shift in SHIFTS:
        scalars = here[shift].scalars
        inputs = theirs["left", shift]["input"]
        forces = [f"{scalars[f'track_force_{name}_{side}_N']:.0f} / "
                  f"{theirs[side, shift]['contact']['force_rail_track_N'][number]:.0f}"
                  for side in ("left", "right") for number, name in enumerate("xy")]
        hottest = [max(patch.record["temperature_rise_max_lower_K"] for patch in here[shift].contacts
                    if patch.record["side"] == side)
                   for side in ("left", "right")]
        rows.append([f"{shift:g}", f"{scalars['roll_mrad']:.4f} / {1e3 * inputs['roll']:.4f}",
                     f"{scalars['angular_velocity_rad_s']:.4f} / {-inputs['omega']:.4f}", *forces,
                     *(f"{rise:.1f}" for rise in hottest)])
    return {"table": table(HEADER, rows)}


WHEELSET_GRID = 48
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


def equivalent_conicity(folder: pathlib.Path, grid: int) -> Numbers:
    """The picture of `thermoroll conicity`, which needs no grid."""
    draw_conicity(folder / "conicity.png", conicity(ROOT / "cases" / "manchester.toml"), "Manchester benchmark")
    return {}


FIGURES = {"manchester": manchester, "eurosprinter": eurosprinter, "conicity": equivalent_conicity}

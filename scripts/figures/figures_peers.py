"""Beside CONTACT: the Manchester contact benchmark, and equivalent conicity."""

from __future__ import annotations

import pathlib

from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, ROOT, Numbers, diagrams, table, write
from scripts.manchester import SHIFTS, contact_results, wheelset_at
from thermoroll_cli import conicity
from thermoroll_cli.plots.conicity_figure import draw_conicity

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


def equivalent_conicity(folder: pathlib.Path, grid: int) -> Numbers:
    """The picture of `thermoroll conicity`, which needs no grid."""
    draw_conicity(folder / "conicity.png", conicity(ROOT / "cases" / "manchester.toml"), "Manchester benchmark")
    return {}


FIGURES = {"manchester": manchester, "conicity": equivalent_conicity}

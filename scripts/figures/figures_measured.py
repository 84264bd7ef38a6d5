"""Measured creep forces: a roller rig and a twin disc, beside what is fitted to them and what is predicted."""

from __future__ import annotations

import pathlib

import numpy as np
from matplotlib.axes import Axes

from scripts.figures.figures_drawing import COUPLED, DOTTED, ISOTHERMAL, THIRD, Numbers, diagrams, table, write
from scripts.measured import (
    DISC_SMOOTH,
    RIG_SMOOTH,
    Comparison,
    model,
    rising,
    roller_rig,
    roller_rig_angles,
    smooth,
    twin_disc,
)

GRID = 64
DEVIATIONS = ("", "fitted", "rms of measured less computed force over W")


def _points(axes: Axes, found: Comparison, scale: float = 1.0) -> None:
    at, value, half = found.points.T
    axes.errorbar(scale * at, value, half, fmt=".", color="0.55", markersize=4, elinewidth=0.6, label="measured")


def _curve(axes: Axes, found: Comparison, colour: str, label: str, scale: float = 1.0, *, dotted: bool = False) -> None:
    at = found.at[-1] * np.linspace(0.0, 1.0, 400) ** 2
    axes.plot(scale * at, found.between(at), color=colour, label=label, linestyle=DOTTED if dotted else "-")


def _row(words: str, fitted: str, found: Comparison) -> list[str]:
    return [words, fitted, f"{found.rms:.4f}"]


def roller(folder: pathlib.Path, grid: int) -> Numbers:
    """The creep curve, fitted, and the force over the angle of attack, predicted."""
    rig = model("vt_fra_roller_rig", min(grid, GRID))
    straight = {name: roller_rig(problem) for name, problem in (
        ("smooth", smooth(rig, RIG_SMOOTH)), ("interlayer", rig), ("rising", rising(rig)))}
    angles = {name: roller_rig_angles(problem) for name, problem in (("interlayer", rig), ("rising", rising(rig)))}
    figure, (left, right) = diagrams(1, 2, (3.3, 2.5))
    _points(left, straight["smooth"], 100.0)
    _curve(left, straight["smooth"], ISOTHERMAL, "smooth bodies, fitted (1)", 100.0, dotted=True)
    _curve(left, straight["interlayer"], COUPLED, "interlayer, fitted (2)", 100.0)
    _curve(left, straight["rising"], THIRD, "rising friction, fitted (3)", 100.0)
    left.set(xlabel="longitudinal creepage (%)", ylabel=r"$F_x/W$", xlim=(0.0, 2.05), ylim=(0.0, 0.6))
    _points(right, angles["interlayer"])
    _curve(right, angles["interlayer"], COUPLED, "interlayer, predicted")
    _curve(right, angles["rising"], THIRD, "rising friction, predicted")
    right.set(xlabel="angle of attack (°)", ylabel=r"$F_x/F_x(0)$", xlim=(0.0, 1.02), ylim=(0.7, 1.04))
    left.legend(loc="lower right")
    right.legend(loc="lower left")
    write(figure, folder, "measured_roller_rig")
    rows = [_row("creep curve, smooth bodies", "friction", straight["smooth"]),
            _row("creep curve, interlayer", "friction, interlayer", straight["interlayer"]),
            _row("creep curve, interlayer and rising friction", "friction, its rise, interlayer", straight["rising"]),
            _row("angle of attack, interlayer", "nothing (over F(0))", angles["interlayer"]),
            _row("angle of attack, interlayer and rising friction", "nothing (over F(0))", angles["rising"])]
    return {"table": table(DEVIATIONS, rows)}


def discs(folder: pathlib.Path, grid: int) -> Numbers:
    """Tractions of the twin disc: up to 3 % slip the fit, beyond it the same curve."""
    disc = model("twin_disc_lewis", min(grid, GRID))
    bare, layered = twin_disc(smooth(disc, DISC_SMOOTH)), twin_disc(disc)
    figure, (axes,) = diagrams(1, 1, (5.0, 2.5))
    _points(axes, layered, 100.0)
    _curve(axes, bare, ISOTHERMAL, "smooth bodies, friction fitted (1)", 100.0, dotted=True)
    _curve(axes, layered, COUPLED, "interlayer, fitted up to 3 % (2)", 100.0)
    axes.set(xlabel="longitudinal creepage (%)", ylabel=r"$F_x/W$", xscale="symlog", xlim=(0.0, 25.0), ylim=(0.0, 0.55))
    axes.set_xticks([0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0], ["0", "0.2", "0.5", "1", "2", "5", "10", "20"])
    axes.legend(loc="lower right")
    write(figure, folder, "measured_twin_disc")
    rows = [_row("smooth bodies", "friction", bare), _row("interlayer", "friction, interlayer", layered)]
    return {"table": table(DEVIATIONS, rows)}


FIGURES = {"measured_roller_rig": roller, "measured_twin_disc": discs}

"""Measured creep forces beside what `fit` finds for them, and what is predicted: a roller rig, a twin disc, a locomotive."""

from __future__ import annotations

import json
import math
import pathlib

import numpy as np
from matplotlib.axes import Axes
from scipy.interpolate import PchipInterpolator

from scripts.figures.figures_drawing import COUPLED, DOTTED, ISOTHERMAL, THIRD, Numbers, diagrams, table, write
from scripts.measured import (
    FRICTION,
    INTERLAYER,
    REFERENCE,
    RISING,
    SMOOTH,
    Array,
    at_angles,
    case,
    fitted,
    forces,
    locomotive,
    roller_rig,
    roller_rig_angles,
    twin_disc,
)
from thermoroll_cli import Case
from thermoroll_cli.studies.sweeps.fit import Fit

GRID = 32
HEADER = ("", "friction", "interlayer (µm/GPa)", "rms of computed less measured force over W")


def _points(axes: Axes, points: Array, scale: float = 1.0) -> None:
    at, value, half = points
    axes.errorbar(scale * at, value, half, fmt=".", color="0.55", markersize=4, elinewidth=0.6, label="measured")


def _curve(axes: Axes, model: Case, last: float, colour: str, label: str, *, dotted: bool = False) -> None:
    """Force over creepage in percent."""
    at = np.geomspace(1e-4, last, 30)
    smooth = PchipInterpolator(np.append(0.0, at), np.append(0.0, forces(model, {"creepage.longitudinal": at.tolist()})))
    places = last * np.linspace(0.0, 1.0, 400) ** 2
    axes.plot(1e2 * places, smooth(places), color=colour, label=label, linestyle=DOTTED if dotted else "-")


def _value(found: Fit, key: str) -> str:
    one = found.parameters[key]
    if not math.isfinite(one.uncertainty_95):
        return f"{one.value:.3g}, not determined"
    digits = max(0, 1 - math.floor(math.log10(one.uncertainty_95)))
    return f"{one.value:.{digits}f} ± {one.uncertainty_95:.{digits}f}"


def _row(words: str, found: Fit, friction: str = "", interlayer: str = "none") -> list[str]:
    interlayer = _value(found, INTERLAYER) if INTERLAYER in found.parameters else interlayer
    return [words, friction or _value(found, FRICTION), interlayer, f"{found.rms['force_x_over_load']:.4f}"]


def roller(folder: pathlib.Path, grid: int) -> Numbers:
    """The creep curve, fitted, and the force over the angle of attack, predicted."""
    rig, points, angles = case("vt_fra_roller_rig", min(grid, GRID)), roller_rig(), roller_rig_angles()
    smooth = fitted(rig.with_values(SMOOTH), points, FRICTION)
    layered = fitted(rig, points, FRICTION, INTERLAYER)
    rising = fitted(rig.with_values(RISING), points, INTERLAYER)
    figure, (left, right) = diagrams(1, 2, (3.3, 2.5))
    _points(left, points, 1e2)
    _points(right, angles)
    _curve(left, smooth.case, 0.0205, ISOTHERMAL, "smooth bodies, fitted", dotted=True)
    rows = [_row("creep curve, smooth bodies", smooth), _row("creep curve, interlayer", layered),
            _row("creep curve, rising friction", rising, "0.462 + 0.031 per % of slip, given")]
    for found, colour, words in ((layered, COUPLED, "interlayer"), (rising, THIRD, "rising friction")):
        _curve(left, found.case, 0.0205, colour, f"{words}, fitted")
        predicted = at_angles(found.case, angles[0])
        places = np.linspace(0.0, angles[0, -1], 200)
        right.plot(places, PchipInterpolator(angles[0], predicted)(places), color=colour, label=f"{words}, predicted")
        rows.append([f"angle of attack, {words}", "that of the creep curve", "likewise",
                     f"{np.sqrt(np.mean((predicted - angles[1]) ** 2)):.4f} (over F(0))"])
    left.set(xlabel="longitudinal creepage (%)", ylabel=r"$F_x/W$", xlim=(0.0, 2.05), ylim=(0.0, 0.6))
    right.set(xlabel="angle of attack (°)", ylabel=r"$F_x/F_x(0)$", xlim=(0.0, 1.02), ylim=(0.7, 1.04))
    left.legend(loc="lower right")
    right.legend(loc="lower left")
    write(figure, folder, "measured_roller_rig")
    return {"table": table(HEADER, rows), "correlation": f"{layered.correlation[FRICTION][INTERLAYER]:.2f}"}


def discs(folder: pathlib.Path, grid: int) -> Numbers:
    """Tractions of two discs, with friction and interlayer fitted."""
    disc, points = case("twin_disc_lewis", min(grid, GRID)), twin_disc()
    smooth, layered = fitted(disc.with_values(SMOOTH), points, FRICTION), fitted(disc, points, FRICTION, INTERLAYER)
    figure, (axes,) = diagrams(1, 1, (5.0, 2.4))
    _points(axes, points, 1e2)
    _curve(axes, smooth.case, 0.25, ISOTHERMAL, "smooth bodies, fitted", dotted=True)
    _curve(axes, layered.case, 0.25, COUPLED, "interlayer, fitted")
    axes.set(xlabel="longitudinal creepage (%)", ylabel=r"$F_x/W$", xscale="symlog", xlim=(0.0, 25.0), ylim=(0.0, 0.55))
    axes.set_xticks([0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0], ["0", "0.2", "0.5", "1", "2", "5", "10", "20"])
    axes.legend(loc="lower right")
    write(figure, folder, "measured_twin_disc")
    return {"table": table(HEADER, [_row("smooth bodies", smooth), _row("interlayer", layered)])}


def eurosprinter(folder: pathlib.Path, grid: int) -> Numbers:
    """Creep curves of a locomotive beside its points and CONTACT: with the parameters of others, and fitted."""
    model, points = case("eurosprinter", min(grid, GRID)), locomotive()
    theirs = json.loads((REFERENCE / "friction_tractcurv.json").read_text(encoding="utf-8"))["series"]
    others = {"layer_falling_memory": ("layer, falling friction, memory", model, COUPLED), "constant_friction": (
        "constant friction, no layer", model.with_values({"friction.limit_coefficient": 0.33, **SMOOTH}), ISOTHERMAL)}
    figure, (axes,) = diagrams(1, 1, (5.0, 2.6))
    axes.plot(*points, ".", color="0.6", markersize=3.5, label="measured (Engel, Beck, Alders 1998)")
    rows = []
    for name, (words, one, colour) in others.items():
        at = np.array(theirs[name]["creepage"])
        force = forces(one, {"creepage.longitudinal": at.tolist()})
        axes.plot(at, force, color=colour, label=words)
        axes.plot(at, 0.33 * np.array(theirs[name]["force_x_over_mu0W"]), "o", color=colour, fillstyle="none", markersize=3.5,
                  label="CONTACT" if name == "constant_friction" else "_")
        apart = np.interp(points[0], at, force) - points[1]
        settings = one.settings
        rows.append([words + ", given", "0.33, falls to 0.14" if name == "layer_falling_memory" else "0.33",
                     f"{settings.layer.compliance_um_GPa:.0f}" if name == "layer_falling_memory" else "none",
                     f"{np.sqrt(np.mean(apart**2)):.4f}"])
    found = fitted(model, points, FRICTION, INTERLAYER)
    rows.append(_row("layer, falling friction, memory, fitted", found, f"{_value(found, FRICTION)}, falls to 0.14"))
    axes.set(xlabel="longitudinal creepage", ylabel=r"$F_x/W$", xlim=(0.0, 0.26), ylim=(0.0, None))
    axes.legend(loc="lower right")
    write(figure, folder, "eurosprinter")
    return {"table": table(HEADER, rows)}


FIGURES = {"measured_roller_rig": roller, "measured_twin_disc": discs, "eurosprinter": eurosprinter}

"""Strength: the yield stress that a body needs over depth, Dang Van's stress below the contact, and the shakedown map."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from thermoroll_cli.exact.shakedown_limits import CIRCLE_ELASTIC, CIRCLE_SHAKEDOWN, FRICTION, line_shakedown
from thermoroll_cli.plots.run_frame import RunFrame
from thermoroll_cli.plots.style import (
    AFTER,
    ALERT,
    BEFORE,
    DASHED,
    DOTTED,
    DOUBLE,
    MM,
    SINGLE,
    add_headline,
    add_legend,
    few_ticks,
    new_figure,
)
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result

LEVELS = 24


def strength_figure(frame: RunFrame, body: str) -> Figure | None:
    """The shear yield stress needed to stay elastic and to shake down over depth, beside that of the body where it is known,
    and Dang Van's stress over y and depth; None where the strength of this body is not asked for."""
    stresses = frame.result.bodies.get(body)
    if stresses is None or not stresses.strength:
        return None
    kept, (_, across) = stresses.strength, frame.lengths
    z = stresses.depths * across.factor
    figure = new_figure(DOUBLE, 72.0 * MM)
    needed, fatigue = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    lines = [("elastic_limit_k", "elastic (von Mises)", BEFORE, DASHED), ("shakedown_k", "shakedown", AFTER, "solid")]
    if np.abs(kept["elastic_shakedown_k"] - kept["shakedown_k"]).max() > 1e-3 * kept["shakedown_k"].max():
        lines.append(("elastic_shakedown_k", "shakedown without thermal stresses", AFTER, DOTTED))
    for name, label, colour, dashes in lines:
        needed.plot(kept[name] * 1e-6, z, color=colour, linestyle=dashes, label=label)
    strength = getattr(frame.result.problem.subsurface, f"{body}_strength")
    if strength is not None and strength.shear_yield is not None:
        needed.axvline(strength.shear_yield * 1e-6, color=ALERT, linewidth=0.9, label="shear yield stress k of the body")
    needed.set(xlabel="shear yield stress needed (MPa)", ylabel=across.label.replace("y", "z"), ylim=(z[-1], 0.0))
    needed.set_xlim(left=0.0)
    needed.grid(visible=True)
    few_ticks(needed, 5, 5)
    stress = kept["dang_van"] * 1e-6
    image = fatigue.contourf(frame.last.state.y * across.factor, z, stress, levels=LEVELS, cmap="viridis")
    fatigue.set(xlabel=across.label, ylabel=across.label.replace("y", "z"), ylim=(z[-1], 0.0))
    few_ticks(fatigue, 5, 5)
    bar = figure.colorbar(image, ax=fatigue, label="Dang Van's stress (MPa)", pad=0.02)
    few_ticks(bar.ax, y=6)
    add_headline(figure, ", ".join(filter(None, (frame.result.problem.title, f"{body} body"))), frame.result.converged)
    add_legend(figure, needed.get_legend_handles_labels()[0])
    return figure


def shakedown_map_figure(frame: RunFrame) -> Figure | None:
    """p₀/k against the utilised friction |F|/W, with elastic and shakedown limits of ideal contacts; None where no body's
    shear yield stress is known."""
    points = {body: load for body in BODIES if (load := _pressure_over_yield(frame.result, body)) is not None}
    if not points:
        return None
    scalars = frame.result.coupled.scalars
    utilised = math.hypot(scalars["force_x_N"], scalars["force_y_N"]) / frame.result.problem.normal_force
    figure = new_figure(1.3 * SINGLE, 85.0 * MM)
    axes = figure.subplots()
    axes.plot(FRICTION, CIRCLE_ELASTIC, color="0.4", linestyle=DASHED, label="circle: elastic, von Mises")
    axes.plot(FRICTION, CIRCLE_SHAKEDOWN, color=AFTER, label="circle: shakedown, von Mises")
    shares = np.linspace(FRICTION[0], FRICTION[-1], 61)
    axes.plot(shares, [line_shakedown(share) for share in shares], color=BEFORE, linestyle=DOTTED,
              label="line: shakedown, Tresca (Johnson)")
    for (body, load), marker in zip(points.items(), "os", strict=False):
        axes.plot([utilised], [load], marker, color=ALERT, markeredgecolor="black", label=f"{body} body")
    axes.set(xlabel="utilised friction |F|/W", ylabel=r"largest pressure $p_0/k$", xlim=(0.0, FRICTION[-1]))
    axes.set_ylim(0.0, max(5.0, 1.1 * max(points.values())))
    axes.grid(visible=True)
    add_headline(figure, frame.result.problem.title, frame.result.converged)
    add_legend(figure, axes.get_legend_handles_labels()[0])
    return figure


def _pressure_over_yield(result: Result, body: str) -> float | None:
    """p₀/k of a body whose shear yield stress is given."""
    strength = getattr(result.problem.subsurface, f"{body}_strength", None)
    if strength is None or strength.shear_yield is None:
        return None
    return float(result.coupled.scalars["pressure_max_MPa"] * 1e6 / strength.shear_yield)

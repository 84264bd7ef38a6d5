"""Below the surface: the plane through the largest stress, lines into the depth, the yield stress a body needs, Dang Van's
stress, and the shakedown map."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from thermoroll_cli.exact.shakedown_limits import CIRCLE_ELASTIC, CIRCLE_SHAKEDOWN, FRICTION, line_shakedown
from thermoroll_cli.physics.stress.strength import principal_and_shear, shear_yields
from thermoroll_cli.plots import style
from thermoroll_cli.plots.maps import flow_label
from thermoroll_cli.plots.run_frame import TEMPERATURE, Array, AxisScale, RunFrame, unit_for
from thermoroll_cli.problem.names import STRESSES
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import BodyStresses

LEVELS = 24


def subsurface_figure(frame: RunFrame, body: str) -> Figure | None:
    """The von Mises stress on the plane of rolling through its maximum, the temperature on that through the hottest point, if
    it is kept, and both along lines into the depth below the most stressed and the hottest point; of layers shear and largest
    stresses around the interfaces. None where the problem does not ask for this body.

    Elastic stresses stand beside the total where heat changes it visibly."""
    stresses = frame.result.bodies.get(body)
    if stresses is None:
        return None
    _, _, over, note = _of_stress(frame, stresses)
    stress, interfaces = _von_mises(frame, stresses), _interfaces(frame, body)
    rows = 1 + (stresses.hottest is not None) + bool(interfaces)
    figure = style.new_figure(style.DOUBLE, (58.0 * rows + 15.0) * style.MM)
    grid = figure.subplots(rows, 2, squeeze=False, width_ratios=(1.15, 1.0))
    x, y = frame.lengths[0], stress_map_on(grid[0, 0], frame, body)
    _draw_lines(grid[0, 1], frame, stresses, "von_mises", stress)
    grid[0, 1].set_xlim(left=0.0)
    if stresses.hottest is not None:
        hottest = stresses.hottest.y
        place, warm_plane = _plane(frame, stresses, "temperature_rise", hottest)
        rise = frame.scale(TEMPERATURE, float(np.abs(warm_plane).max()))
        _draw_plane(grid[1, 0], frame, stresses, warm_plane, "inferno", rise)
        off = warm_plane.max() < 0.95 * stresses.hottest.value
        if off or not math.isclose(place, y):
            words = f", hottest at {frame.place_words(hottest)}" if off else ""
            grid[1, 0].set_title(frame.place_words(place) + words)
        _draw_lines(grid[1, 1], frame, stresses, "temperature_rise", rise)
        # 1.25 times the depth that heat reaches: behind a fast source a skin of the depth of the stresses.
        heated = np.abs(stresses.plane["temperature_rise"]).max(axis=1)
        warm = int(np.flatnonzero(heated > 0.01 * heated.max()).max(initial=1))
        deepest = stresses.depths[min(warm + 1, stresses.depths.size - 1)]
        for axes in grid[1]:
            axes.set_ylim(float(min(stresses.depths[-1], 1.25 * deepest)) * x.factor, 0.0)
    if interfaces:
        # The shear stress that interfaces carry over x and depth, and largest stresses of the plane over depth.
        left, right = grid[-1]
        shear = np.hypot(stresses.plane["stress_xz"], stresses.plane["stress_yz"])
        principal, _ = principal_and_shear(np.stack([stresses.plane[name] for name in STRESSES]))
        _draw_plane(left, frame, stresses, shear, "viridis", replace(stress, words="shear stress", symbol=rf"$|\tau_z|{over}$"))
        for name, values, colour, dashes in (("von Mises stress", stresses.plane["von_mises"], style.AFTER, style.DASHED),
                                             ("shear stress", shear, style.BEFORE, "solid"),
                                             ("principal stress", principal, style.ALERT, style.DOTTED)):
            right.plot(values.max(axis=1) * stress.factor, stresses.depths * x.factor, color=colour, linestyle=dashes,
                       label=f"largest over x: {name}")
        right.set(xlabel=replace(stress, words="largest stress over x,", symbol=rf"$\sigma{over}$").label,
                  ylabel=x.label.replace("x", "z"))
        style.few_ticks(right, 5, 5, grid=True)
        for axes, colour in zip(grid[[0, -1]].flat, ("white", "0.3") * 2, strict=True):
            for depth in interfaces:
                axes.axhline(depth * x.factor, color=colour, linewidth=0.7, label="interfaces")
        for axes in grid[-1]:
            axes.set_ylim(min(2.0 * interfaces[-1], stresses.depths[-1]) * x.factor, 0.0)
    frame.add_headline(figure, ", ".join(filter(None, (f"{body} body", frame.place_words(y), note))))
    style.add_legend(figure, [handle for axes in grid.flat for handle in axes.get_legend_handles_labels()[0]])
    return figure


def stress_map_on(axes: Axes, frame: RunFrame, body: str) -> float:
    """Draw the von Mises stress on the plane of rolling through its maximum, or the one that is kept, on `axes`, with a colour
    bar and the largest stress marked; returns the plane's y. Raises ValueError where the problem does not ask for this body."""
    stresses, x = frame.result.bodies.get(body), frame.lengths[0]
    if stresses is None:
        raise ValueError(f"there are no stresses in the {body} body: the case has no table [subsurface], or not this body")
    y, plane = _plane(frame, stresses, "von_mises",
                      stresses.plane_y if _interfaces(frame, body) else stresses.most_stressed.y)
    _draw_plane(axes, frame, stresses, plane, "viridis", _von_mises(frame, stresses))
    peak = stresses.most_stressed
    axes.plot(peak.x * x.factor, peak.z * x.factor, "x", color="white", markersize=5.0, markeredgewidth=1.2, clip_on=False,
              label="largest stress", path_effects=[withStroke(linewidth=2.6, foreground="black")])
    return y


def _interfaces(frame: RunFrame, body: str) -> list[float]:
    """Depths of interfaces between layers that the picture reaches."""
    return [face for face in getattr(frame.result.problem, body).interfaces if face < frame.result.bodies[body].depths[-1]]


def _von_mises(frame: RunFrame, stresses: BodyStresses) -> AxisScale:
    factor, unit, over, _ = _of_stress(frame, stresses)
    return AxisScale(factor, unit, "von Mises stress", rf"$\sigma_\mathrm{{vM}}{over}$")


def _of_stress(frame: RunFrame, stresses: BodyStresses) -> tuple[float, str, str, str]:
    """How stresses are drawn: factor and unit, and in normalised pictures over Hertz's peak pressure, or the largest pressure
    of bodies with profiles, by what a symbol is divided, and a note of it."""
    if not frame.normalised:
        return *unit_for("Pa", float(stresses.plane["von_mises"].max())), "", ""
    hertz, largest = frame.result.of_problem["hertz_p0_MPa"], frame.result.coupled.scalars["pressure_max_MPa"]
    pressure, index, words = (hertz, "p_0", "p₀") if math.isfinite(hertz) else (largest, r"p_\mathrm{max}", "largest pressure")
    return 1e-6 / pressure, "", f"/{index}", f"{words} = {pressure:.4g} MPa"


def _plane(frame: RunFrame, stresses: BodyStresses, name: str, y: float) -> tuple[float, Array]:
    """Place of a plane and a field (nz, nx) on it: nearest to `y` where the field is kept everywhere, else the plane kept."""
    if name not in stresses.fields:
        return stresses.plane_y, stresses.plane[name]
    rows = frame.result.y
    row = int(np.argmin(np.abs(rows - y)))
    return 0.0 if abs(y) < 0.01 * (rows[1] - rows[0]) else float(rows[row]), stresses.fields[name][:, :, row]


def _draw_plane(
    axes: Axes, frame: RunFrame, stresses: BodyStresses, values: Array, colours: str, scale: AxisScale
) -> None:
    """A map over x and depth with isolines and its colour bar."""
    lengths = frame.lengths[0]
    x, z, shown = frame.result.x * lengths.factor, stresses.depths * lengths.factor, values * scale.factor
    top = float(shown.max())
    levels = np.linspace(min(0.0, float(shown.min())), top if top > 0.0 else 1.0, LEVELS + 1)
    image = axes.contourf(x, z, shown, levels=levels, cmap=colours)
    axes.contour(x, z, shown, levels=levels[2:-1:2], colors="white", linewidths=0.35, alpha=0.7)
    axes.set_ylim(z[-1], 0.0)
    axes.set(xlabel=flow_label(frame), ylabel=lengths.label.replace("x", "z"))
    style.few_ticks(axes, 5, 5)
    bar = axes.figure.colorbar(image, ax=axes, label=scale.label, pad=0.02)
    style.few_ticks(bar.ax, y=6)


def _draw_lines(axes: Axes, frame: RunFrame, stresses: BodyStresses, name: str, scale: AxisScale) -> None:
    """A field and its elastic part along the lines into the depth."""
    lengths = frame.lengths[0]
    z = stresses.depths * lengths.factor
    for fields, colour, place in ((stresses.below_stressed, style.AFTER, "below the largest stress"),
                                  (stresses.below_heated, style.BEFORE, "below the hottest point")):
        if name in fields:
            axes.plot(fields[name] * scale.factor, z, color=colour, label=place)
        elastic = fields.get(f"{name}_elastic")
        if elastic is not None and np.abs(elastic - fields[name]).max() > style.VISIBLE * np.abs(fields[name]).max():
            axes.plot(elastic * scale.factor, z, color=colour, linestyle=style.DASHED)
            axes.plot([], [], color="0.3", linestyle=style.DASHED, label="without thermal stresses")
    axes.set_ylim(z[-1], 0.0)
    axes.set(xlabel=scale.label, ylabel=lengths.label.replace("x", "z"))
    style.few_ticks(axes, 5, 5, grid=True)


def strength_figure(frame: RunFrame, body: str) -> Figure | None:
    """The shear yield stress needed to stay elastic and to shake down over depth, beside that of the body where it is known,
    and Dang Van's stress over y and depth; None where the strength of this body is not asked for."""
    stresses = frame.result.bodies.get(body)
    if stresses is None or not stresses.strength:
        return None
    kept, (along, across) = stresses.strength, frame.lengths
    across = replace(along, words="y") if frame.line else across
    z = stresses.depths * across.factor
    figure = style.new_figure(style.DOUBLE, 72.0 * style.MM)
    needed, fatigue = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    lines = [("elastic_limit_k", "elastic (von Mises)", style.BEFORE, style.DASHED),
             ("shakedown_k", "shakedown", style.AFTER, "solid")]
    if np.abs(kept["elastic_shakedown_k"] - kept["shakedown_k"]).max() > 1e-3 * kept["shakedown_k"].max():
        lines.append(("elastic_shakedown_k", "shakedown without thermal stresses", style.AFTER, style.DOTTED))
    for name, label, colour, dashes in lines:
        needed.plot(kept[name] * 1e-6, z, color=colour, linestyle=dashes, label=label)
    strength, material = (getattr(owner, name) for owner, name in (
        (frame.result.problem.subsurface, f"{body}_strength"), (frame.result.problem, body)))
    if strength is not None and strength.shear_yield is not None:
        yields = shear_yields(material, strength.shear_yield, stresses.depths)
        yields[np.isinf(yields)] = np.nan
        needed.plot(yields * 1e-6, z, color=style.ALERT, linewidth=0.9, label="shear yield stress k of the body")
    needed.set(xlabel="shear yield stress needed (MPa)", ylabel=across.label.replace("y", "z"), ylim=(z[-1], 0.0))
    # Layers may have yields far beyond the diagram.
    right = 1.1e-6 * max(kept["elastic_limit_k"].max(), strength.shear_yield or 0.0) if material.layers else None
    needed.set_xlim(0.0, right)
    style.few_ticks(needed, 5, 5, grid=True)
    stress = kept["dang_van"] * 1e-6
    fatigue.set(ylabel=across.label.replace("y", "z"), ylim=(z[-1], 0.0))
    if frame.line:
        fatigue.plot(stress, z, color=style.AFTER)
        fatigue.set_xlabel("Dang Van's stress (MPa)")
    else:
        image = fatigue.contourf(frame.last.state.y * across.factor, z, stress, levels=LEVELS, cmap="viridis")
        fatigue.set_xlabel(across.label)
        style.few_ticks(figure.colorbar(image, ax=fatigue, label="Dang Van's stress (MPa)", pad=0.02).ax, y=6)
    style.few_ticks(fatigue, 5, 5, grid=frame.line)
    for axes, face in itertools.product((needed, fatigue), material.interfaces):
        axes.axhline(face * across.factor, color="0.3" if axes is needed else "white", linewidth=0.7)
    frame.add_headline(figure, f"{body} body")
    style.add_legend(figure, needed.get_legend_handles_labels()[0])
    return figure


def shakedown_map_figure(frame: RunFrame) -> Figure | None:
    """p₀/k against the utilised friction ∫|τ|/W, which is |F|/W unless tractions turn over the contact as with spin, and limits
    of ideal contacts: a circle's beside ellipses up to 2:1, a line's unless the contact is longer than that along rolling. None
    where no homogeneous body's shear yield stress is known."""
    problem, scalars = frame.result.problem, frame.result.coupled.scalars
    strengths = {body: getattr(problem.subsurface, f"{body}_strength", None) for body in BODIES}
    points = {body: 1e6 * scalars["pressure_max_MPa"] / strength.shear_yield for body, strength in strengths.items()
              if strength is not None and strength.shear_yield is not None and not getattr(problem, body).layers}
    if not points:
        return None
    fields = frame.result.coupled.fields
    utilised = float(np.hypot(fields["shear_x"], fields["shear_y"]).sum() / fields["pressure"].sum())
    known = frame.result.of_problem
    longer = known["hertz_a_mm"] / known.get("hertz_b_mm", math.inf)
    figure = style.new_figure(1.3 * style.SINGLE, 85.0 * style.MM)
    axes = figure.subplots()
    if not (longer < 0.5 or longer > 2.0):
        axes.plot(FRICTION, CIRCLE_ELASTIC, color="0.4", linestyle=style.DASHED, label="circle: elastic, von Mises")
        axes.plot(FRICTION, CIRCLE_SHAKEDOWN, color=style.AFTER, label="circle: shakedown, von Mises")
    if not longer > 2.0:
        shares = np.linspace(FRICTION[0], FRICTION[-1], 61)
        axes.plot(shares, [line_shakedown(share) for share in shares], color=style.BEFORE, linestyle=style.DOTTED,
                  label="line: shakedown, Tresca (Johnson)")
    # A ring around a square: two points at one place are both seen.
    for (body, load), (marker, size, face) in zip(points.items(), (("o", 10.0, "none"), ("s", 4.5, style.ALERT)), strict=False):
        axes.plot([utilised], [load], marker, markersize=size, markerfacecolor=face, markeredgecolor=style.ALERT,
                  linestyle="none", label=f"{body} body")
    axes.set(xlabel=r"utilised friction $\int|\tau|\,dA\,/\,W$", ylabel=r"largest pressure $p_0/k$", xlim=(0.0, FRICTION[-1]))
    axes.set_ylim(0.0, max(5.0, 1.1 * max(points.values())))
    axes.grid(visible=True)
    frame.add_headline(figure, note="no limits are known of contacts this long" if longer > 2.0 else "")
    style.add_legend(figure, axes.get_legend_handles_labels()[0])
    return figure

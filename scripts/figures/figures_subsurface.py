"""Below the surface: what friction and heat do to the largest stress."""

from __future__ import annotations

import pathlib

import numpy as np

from scripts.figures.figures_drawing import (
    COUPLED,
    ISOTHERMAL,
    THIRD,
    Numbers,
    add_axes,
    new_figure,
    rounded,
    solve_case,
    write,
)
from thermoroll_cli.plots.style import few_ticks
from thermoroll_cli.problem.result import Result

CASE, BODY = "hot_sliding", "upper"
VARIANTS: tuple[tuple[str, dict[str, object], str], ...] = (
    ("no friction", {"load.friction_coefficient": 0.0}, THIRD),
    ("friction alone", {"subsurface.thermal": False, "thermal.deformation": False}, ISOTHERMAL),
    ("friction and heat", {}, COUPLED),
)
WIDTH, HEIGHT = 2.1, 1.9
LEFT, BOTTOM, TOP, GAP = 0.55, 0.45, 0.3, 0.2
LAST_GAP, BAR = 0.75, 0.1


def subsurface(folder: pathlib.Path, grid: int) -> Numbers:
    """Von Mises stress of one body on y = 0 with less and with all of its loads, and below its largest value."""
    results = [solve_case(CASE, changes, grid=min(grid, 96)) for _, changes, _ in VARIANTS]
    top = max(result.subsurface.bodies[BODY].plane["von_mises"].max() / _peak(result) for result in results)
    width = LEFT + 4 * WIDTH + 2 * GAP + BAR + LAST_GAP + 0.65
    figure = new_figure(width, BOTTOM + HEIGHT + TOP)
    lines = add_axes(figure, width - WIDTH - 0.15, BOTTOM, WIDTH, HEIGHT)
    numbers: Numbers = {}
    for place, (result, (label, _, colour)) in enumerate(zip(results, VARIANTS, strict=True)):
        body, unit = result.subsurface.bodies[BODY], result.hertz["hertz_a_mm"] * 1e-3
        x, z = result.x / unit, body.depths / unit
        axes = add_axes(figure, LEFT + place * (WIDTH + GAP), BOTTOM, WIDTH, HEIGHT)
        image = axes.contourf(x, z, body.plane["von_mises"] / _peak(result), levels=np.linspace(0.0, top, 25), cmap="viridis")
        axes.plot([body.most_stressed.x / unit], [body.most_stressed.z / unit], "x", color="#e8262a", clip_on=False)
        axes.set(xlim=(-1.08, 1.08), ylim=(2.0, 0.0), xlabel="$x/a$", title=label)
        few_ticks(axes, 4, 4)
        axes.tick_params(labelleft=place == 0)
        if place == 0:
            axes.set_ylabel("$z/a$")
        lines.plot(body.below_stressed["von_mises"] / _peak(result), z, color=colour, label=label)
        numbers[label] = {"largest": rounded(body.most_stressed.value / _peak(result)),
                          "depth": rounded(body.most_stressed.z / unit)}
    bar = add_axes(figure, LEFT + 3 * WIDTH + 2 * GAP + 0.08, BOTTOM, BAR, HEIGHT)
    figure.colorbar(image, cax=bar)
    bar.set_title(r"$\sigma_{\mathrm{vM}}/p_0$", pad=5.0)
    few_ticks(bar, y=6)
    lines.set(xlim=(0.0, None), ylim=(2.0, 0.0), xlabel=r"$\sigma_{\mathrm{vM}}/p_0$")
    few_ticks(lines, 4, 4)
    lines.legend(loc="lower right")
    write(figure, folder, "subsurface")
    return numbers


def _peak(result: Result) -> float:
    return float(result.hertz["hertz_p0_MPa"]) * 1e6


FIGURES = {"subsurface": subsurface}

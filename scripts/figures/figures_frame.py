"""The frame of the program: from the side, from above and from below."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
from matplotlib.patches import Arc, Circle, Ellipse, FancyArrowPatch

from scripts.figures.figures_drawing import Numbers, new_figure, write
from thermoroll_cli.plots import style

LOWER, UPPER, FLOW = style.BEFORE, style.AFTER, "0.35"
RADIUS, BORDER = 0.95, 0.62
"""Radii of the upper body and of the contact in the drawings."""


def frame(folder: pathlib.Path, grid: int) -> Numbers:
    """Three views of one contact with its axes, and the signs of creepage and spin."""
    figure = new_figure(7.6, 2.95)
    side, above, below = (figure.add_axes((left, 0.02, 0.32, 0.88)) for left in (0.0, 0.34, 0.67))
    for axes in (side, above, below):
        axes.set(xlim=(-1.5, 1.5), ylim=(-1.35, 1.35), aspect="equal")
        axes.axis("off")
    _side(side)
    _surface(above, across=-1.0)
    _surface(below, across=1.0)
    for axes, words in ((side, "from the side"), (above, "from above, along z"), (below, "from below, as maps are drawn")):
        axes.set_title(words, fontsize=9)
    write(figure, folder, "frame")
    return {}


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float], words: str, colour: str = "black",
           at: tuple[float, float] | None = None, bend: float = 0.0) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9.0, color=colour, linewidth=1.1, shrinkA=0.0,
                                   shrinkB=0.0, connectionstyle=f"arc3,rad={bend}"))
    place = at or (end[0] + 0.1 * np.sign(end[0] - start[0]), end[1] + 0.12 * np.sign(end[1] - start[1]))
    axes.text(*place, words, color=colour, ha="center", va="center", fontsize=8)


def _out_or_in(axes: Any, place: tuple[float, float], words: str, *, towards: bool) -> None:
    """An axis towards the reader (a dot) or away (a cross)."""
    axes.add_patch(Circle(place, 0.07, facecolor="white", edgecolor="black", linewidth=1.1, zorder=4))
    axes.plot(*place, "." if towards else "x", color="black", markersize=3.0 if towards else 4.5, zorder=5)
    axes.text(place[0] - 0.18, place[1], words, ha="center", va="center", fontsize=8, zorder=5)


def _side(axes: Any) -> None:
    axes.add_patch(Circle((0.0, RADIUS), RADIUS, facecolor=UPPER, alpha=0.25))
    axes.fill_between([-1.5, 1.5], -1.35, 0.0, color=LOWER, alpha=0.25, linewidth=0)
    axes.text(0.0, 1.02, "upper body (2)", ha="center", fontsize=8)
    axes.text(-0.75, -0.95, "lower body (1)", ha="center", fontsize=8)
    axes.add_patch(Arc((0.0, RADIUS), 1.2, 1.2, theta1=200.0, theta2=335.0, color=FLOW, linewidth=1.1))
    _arrow(axes, (0.52, 0.66), (0.56, 0.74), "", FLOW)
    _arrow(axes, (-1.3, -0.22), (-0.5, -0.22), "material of both\nflows at V", FLOW, at=(-0.9, -0.46))
    _arrow(axes, (0.0, 0.0), (1.2, 0.0), "x", at=(1.3, 0.0))
    _arrow(axes, (0.0, 0.0), (0.0, -1.1), "z", at=(0.14, -1.1))
    axes.add_patch(Circle((0.0, 0.0), 0.07, facecolor="white", edgecolor="black", linewidth=1.1, zorder=4))
    axes.plot(0.0, 0.0, ".", color="black", markersize=3.0, zorder=5)
    axes.text(0.16, -0.17, "y", fontsize=8)
    _arrow(axes, (-0.95, 1.15), (-1.4, 1.15), "travel", UPPER, at=(-1.2, 1.28))


def _surface(axes: Any, across: float) -> None:
    """The contact; y points upwards (`across` = 1) or downwards (−1)."""
    axes.add_patch(Ellipse((0.0, 0.0), 2.0 * BORDER, 2.4 * BORDER, facecolor="0.88", edgecolor="black", linewidth=1.0))
    axes.text(-1.08, 0.0, "leading\nedge", ha="center", va="center", fontsize=8)
    axes.text(0.9, 0.3 * across, "trailing\nedge", ha="left", va="center", fontsize=8)
    _arrow(axes, (0.0, 0.0), (1.2, 0.0), "x", at=(1.3, 0.0))
    _arrow(axes, (0.0, 0.0), (0.0, 1.05 * across), "y", at=(0.14, 1.05 * across))
    _out_or_in(axes, (0.0, 0.0), "z", towards=across > 0.0)
    _arrow(axes, (-1.4, -1.0 * across), (-0.6, -1.0 * across), "material", FLOW, at=(-1.0, -1.17 * across))
    _arrow(axes, (0.4, -0.06 * across), (-0.05, 0.4 * across), r"$\xi_\varphi>0$", LOWER, at=(0.78, 0.74 * across),
           bend=0.45 * across)
    _arrow(axes, (-0.22, -0.32 * across), (0.3, -0.32 * across), r"$\xi_x>0$", LOWER, at=(0.05, -0.5 * across))


FIGURES = {"frame": frame}

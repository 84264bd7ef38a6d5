"""A sweep as an animation: tractions and stick border of one point after the other, beside the curves of the sweep."""

from __future__ import annotations

import io
import math
import pathlib
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D
from PIL import Image

from thermoroll_cli.plots import style
from thermoroll_cli.plots.maps import draw_borders
from thermoroll_cli.plots.run_frame import borders_of
from thermoroll_cli.plots.sweep_figures import words_of
from thermoroll_cli.problem.names import known_as, unit_of
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.problem.scalar_errors import FORCES
from thermoroll_cli.tools.arrays import AnyArray
from thermoroll_cli.tools.atomic import write_bytes

LEVELS = 5
"""Lines of equal height of a surface that rolls through."""


def draw_animation(path: pathlib.Path, results: Sequence[Result | State], key: str, values: Sequence[float]) -> pathlib.Path:
    """Write a GIF with a frame for each of the `results`, in the order of the `values` of the swept `key`.

    All frames have the same axes and colours. Raises ValueError for what has no tractions to show, OSError."""
    if any("shear_x" not in result.fields for result in results):
        raise ValueError("an animation shows tractions of one contact, which these points have not")
    order, at = np.argsort(values, kind="stable"), np.asarray(values, dtype=float)
    largest = max(float(_shear(each).max()) for each in results)
    along, across = (known_as(name, results[0].scalars) for name in FORCES)
    force = np.array([math.hypot(each.scalars[along], each.scalars[across]) for each in results])
    rise = np.array([max(each.scalars.get(f"temperature_rise_max_{body}_K", np.nan) for body in BODIES) for each in results])
    images = []
    with style.applied():
        for current in map(int, order):
            result, canvas = results[current], FigureCanvasAgg(Figure(figsize=(150.0 * style.MM, 66.0 * style.MM), dpi=100))
            contact = style.add_axes(canvas.figure, 0.55, 0.45, 2.1, 1.9)
            forces = style.add_axes(canvas.figure, 3.45, 0.45, 1.75, 1.9)
            (_map if len(result.y) else _line)(contact, result, results, largest)
            style.few_ticks(contact, 4, 4)
            _curve(forces, at[order], force[order], at[current], force[current], style.BEFORE)
            forces.set(xlabel=words_of(key), ylabel=f"creep force ({unit_of(along)})")
            if np.isfinite(rise).all():
                right = forces.twinx()
                _curve(right, at[order], rise[order], at[current], rise[current], style.AFTER)
                right.set_ylabel("temperature rise (K)", color=style.AFTER)
                forces.yaxis.label.set_color(style.BEFORE)
            style.few_ticks(forces, 3, 5)
            canvas.draw()
            images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    # One palette for all, of the frame with most colours and that with the largest traction: else each frame brings its own,
    # and colours flicker. A GIF may have 256 colours; fewer make it small.
    highest = int(np.argmax([_shear(results[place]).max() for place in order]))
    fullest = max(images, key=lambda image: len(image.getcolors(1 << 20) or ()))
    palette = Image.fromarray(np.vstack([np.asarray(image) for image in (fullest, images[highest])])).quantize(128)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    content = io.BytesIO()
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], loop=0, optimize=True,
                   duration=[160] * (len(frames) - 1) + [1200])  # fmt: skip
    write_bytes(path, content.getvalue())
    return path


def _map(axes: Axes, result: Result | State, results: Sequence[Result | State], largest: float) -> None:
    """Shear traction of a `result` up to the `largest`, with borders, on the domains of all `results`."""
    image = axes.imshow(_shear(result).T, origin="lower", extent=_extent(result), vmin=0.0, vmax=largest, cmap="viridis",
                        interpolation="bilinear")
    borders, in_mm = borders_of(result.x, result.y, result.fields), Affine2D().scale(1e3)
    sides = np.array([_extent(each) for each in results])
    if borders.outline is not None:
        image.set_clip_path(borders.outline, transform=in_mm + axes.transData)
    draw_borders(axes, borders, in_mm, times=1.6)
    heights, title = result.fields.get("surface_height"), "shear traction; light blue: stick border"
    if heights is not None:
        # The same levels in all frames: they move with the surface.
        ends = [[each.fields["surface_height"].min(), each.fields["surface_height"].max()] for each in results]
        levels = np.linspace(np.min(ends), np.max(ends), LEVELS + 2)[1:-1]
        if np.ptp(heights) > 0.0 and levels[0] < levels[-1]:
            axes.contour(1e3 * result.x, 1e3 * result.y, heights.T, levels, colors="0.85", linewidths=0.4)
            title += ", grey: heights"
    axes.set(xlim=(sides[:, 0].min(), sides[:, 1].max()), ylim=(sides[:, 2].min(), sides[:, 3].max()), aspect="equal",
             xlabel="x (mm), material flow →", ylabel="y (mm)", facecolor="0.2")
    axes.set_title(title)


def _line(axes: Axes, result: Result | State, results: Sequence[Result | State], largest: float) -> None:
    """Shear traction of a line contact over x."""
    axes.plot(1e3 * result.x, 1e-6 * _shear(result))
    axes.set(xlim=(min(1e3 * each.x[0] for each in results), max(1e3 * each.x[-1] for each in results)),
             ylim=(0.0, 1.06e-6 * largest), xlabel="x (mm), material flow →", ylabel="shear traction (MPa)")


def _shear(result: Result | State) -> AnyArray:
    return np.hypot(result.fields["shear_x"], result.fields["shear_y"])


def _extent(result: Result | State) -> tuple[float, float, float, float]:
    """Sides of the domain in mm."""
    (left, right), (low, high) = (
        (1.5 * at[0] - 0.5 * at[1], 1.5 * at[-1] - 0.5 * at[-2]) for at in (1e3 * result.x, 1e3 * result.y))
    return float(left), float(right), float(low), float(high)


def _curve(axes: Axes, x: AnyArray, y: AnyArray, at: float, height: float, colour: str) -> None:
    """The whole curve, thin, and what of it the current point has reached."""
    reached = x <= at
    axes.plot(x, y, color=colour, linewidth=0.6, alpha=0.5)
    axes.plot(x[reached], y[reached], color=colour)
    axes.plot([at], [height], "o", color=colour)
    axes.set_ylim(0.0, 1.06 * float(y.max()) or 1.0)

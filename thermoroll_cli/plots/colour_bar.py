"""The bar that tells what the colours of a map mean. As axes of its own it would cost as much as the map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from thermoroll_cli.plots.sheet import round_numbers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINT = 1.0 / 72.0
"""In inches, which all places on a figure are given in here."""


def draw_colour_bar(
    figure: Figure, place: tuple[float, float, float, float], colours: str, limits: tuple[float, float], intervals: int,
    label: str = "",
) -> None:
    """A bar at `place` (left, bottom, width, height in inches) over `limits`, with round numbers on its right, at most
    `intervals` of them apart, and `label` behind them; it looks as matplotlib's own does."""
    from matplotlib import rcParams
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize
    from matplotlib.image import BboxImage
    from matplotlib.patches import Rectangle
    from matplotlib.transforms import Bbox, TransformedBbox

    from thermoroll_cli.plots.lettering import width_of

    left, bottom, width, height = place
    low, high = limits if limits[1] > limits[0] else (limits[0] - 0.05, limits[0] + 0.05)
    inches = figure.dpi_scale_trans
    image = BboxImage(TransformedBbox(Bbox.from_bounds(*place), inches), cmap=colours, norm=Normalize(0.0, 1.0), origin="lower",
                      interpolation="nearest")
    image.set_data(np.linspace(0.0, 1.0, 256)[:, None])
    figure.add_artist(image)
    line, size = rcParams["axes.linewidth"], rcParams["ytick.labelsize"]
    figure.add_artist(Rectangle((left, bottom), width, height, transform=inches, fill=False, linewidth=line, edgecolor="black"))
    numbers, words, power = round_numbers(low, high, intervals)
    right, heights = left + width, bottom + height * (np.array(numbers) - low) / (high - low)
    end = right + rcParams["ytick.major.size"] * POINT
    figure.add_artist(LineCollection([[(right, y), (end, y)] for y in heights], colors="black", transform=inches,
                                     linewidths=rcParams["ytick.major.width"]))
    start = end + rcParams["ytick.major.pad"] * POINT
    for y, word in zip(heights, words, strict=True):
        figure.text(start, y, word, transform=inches, fontsize=size, va="center_baseline", parse_math=False)
    if power:
        figure.text(left, bottom + height + 3.0 * POINT, power, transform=inches, fontsize=size, va="bottom")
    if label:
        beyond = start + (max(width_of(word) for word in words) * size + rcParams["axes.labelpad"]) * POINT
        figure.text(beyond, bottom + height / 2.0, label, transform=inches, fontsize=rcParams["axes.labelsize"], rotation=90.0,
                    rotation_mode="anchor", ha="center", va="top")

"""The bar that tells what the colours of a map mean. As axes of its own it would cost as much as the map."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import BboxImage
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox, TransformedBbox

from thermoroll_cli.plots.ticks import draw_ticks


def draw_colour_bar(
    figure: Figure, place: tuple[float, float, float, float], colours: str, limits: tuple[float, float], intervals: int,
    label: str = "",
) -> None:
    """A bar at `place` (left, bottom, width, height in inches) over `limits`, with round numbers on its right, at most
    `intervals` of them apart, and `label` behind them; it looks as matplotlib's own does."""

    left, bottom, width, height = place
    low, high = limits if limits[1] > limits[0] else (limits[0] - 0.05, limits[0] + 0.05)
    inches = figure.dpi_scale_trans
    image = BboxImage(TransformedBbox(Bbox.from_bounds(*place), inches), cmap=colours, norm=Normalize(0.0, 1.0), origin="lower",
                      interpolation="nearest")
    image.set_data(np.linspace(0.0, 1.0, 256)[:, None])
    figure.add_artist(image)
    figure.add_artist(Rectangle((left, bottom), width, height, transform=inches, fill=False, edgecolor="black",
                                linewidth=rcParams["axes.linewidth"]))
    draw_ticks(figure, place, "right", (low, high), intervals, label=label)

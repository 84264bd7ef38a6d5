"""Round numbers along the sides of maps, diagrams and colour bars. matplotlib's own axes make a dozen objects for every
number, and measure each of them: that took half of a picture's time. These look alike."""

from __future__ import annotations

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from thermoroll_cli.plots.lettering import width_of
from thermoroll_cli.plots.sheet import ROUND

POINT = 1.0 / 72.0
"""In inches, which all places on a figure are given in here."""
POWER_PAD = 3.0
"""Points between a side and the power of ten of its numbers."""


def round_numbers(low: float, high: float, intervals: int) -> tuple[list[float], list[str], str]:
    """Round numbers from `low` to `high` (low < high) with at most `intervals` between them; how they are written, and the
    power of ten that stands beside them all, "" in most cases."""

    # A single number tells no scale: on a short side the outermost two of several stand alone.
    locator, formatter = MaxNLocator(intervals if intervals > 1 else 4, steps=ROUND, min_n_ticks=2), ScalarFormatter()
    near = 1e-9 * (high - low)
    numbers = [float(number) for number in locator.tick_values(low, high) if low - near <= number <= high + near]
    if intervals == 1 and len(numbers) > 2:
        numbers = [numbers[0], numbers[-1]]
    formatter.create_dummy_axis()
    assert formatter.axis is not None
    formatter.axis.set_view_interval(low, high)
    formatter.axis.set_data_interval(low, high)
    return numbers, formatter.format_ticks(numbers), formatter.get_offset()


def draw_ticks(
    figure: Figure, place: tuple[float, float, float, float], side: str, limits: tuple[float, float], intervals: int, *,
    numbered: bool = True, label: str = "", pad: float | None = None,
) -> list[float]:
    """Ticks outside the `side` (bottom, left or right) of the box at `place` (left, bottom, width, height in inches) that
    reaches over `limits` (rising), with at most `intervals` between them, their numbers, and the `label` `pad` points behind
    these. Returns the numbers."""


    left, bottom, width, height = place
    upright, out = side != "bottom", 1.0 if side == "right" else -1.0
    start, length = (bottom, height) if upright else (left, width)
    edge = {"bottom": bottom, "left": left, "right": left + width}[side]
    low, high = limits
    numbers, words, power = round_numbers(low, high, intervals)
    stops = [start + length * (number - low) / (high - low) for number in numbers]

    def at(along: float, away: float) -> tuple[float, float]:
        return (away, along) if upright else (along, away)

    # The style has the same ticks on all sides.
    inches, size = figure.dpi_scale_trans, rcParams["ytick.labelsize"]
    end = edge + out * rcParams["ytick.major.size"] * POINT
    figure.add_artist(LineCollection([[at(stop, edge), at(stop, end)] for stop in stops], colors="black", transform=inches,
                                     linewidths=rcParams["ytick.major.width"]))
    if not numbered:
        return numbers
    first = end + out * rcParams["ytick.major.pad"] * POINT
    across, along = {"bottom": "center", "left": "right", "right": "left"}[side], "center_baseline" if upright else "top"
    for stop, word in zip(stops, words, strict=True):
        figure.text(*at(stop, first), word, transform=inches, fontsize=size, ha=across, va=along, parse_math=False)
    last = first + out * size * POINT * (max((width_of(word) for word in words), default=0.0) if upright else 1.0)
    if power and upright:
        figure.text(left, bottom + height + POWER_PAD * POINT, power, transform=inches, fontsize=size)
    elif power:
        figure.text(left + width, last - POWER_PAD * POINT, power, transform=inches, fontsize=size, va="top", ha="right")
    if label:
        beyond = last + out * (rcParams["axes.labelpad"] if pad is None else pad) * POINT
        figure.text(*at(start + 0.5 * length, beyond), label, transform=inches, fontsize=rcParams["axes.labelsize"],
                    rotation=90.0 if upright else 0.0, rotation_mode="anchor", ha="center",
                    va="bottom" if side == "left" else "top")
    return numbers


def draw_sides(
    axes: Axes, intervals: tuple[int, int], *, numbered: tuple[bool, bool] = (True, True), labels: tuple[str, str] = ("", ""),
    pad: float | None = None, grid: bool = False,
) -> None:
    """Ticks, numbers and labels below `axes` and to the left of them, whose limits are set, in place of matplotlib's own; with
    a `grid`, also lines from all ticks."""

    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    left, bottom, width, height = (float(pixels) / figure.dpi for pixels in axes.bbox.bounds)
    for number, (side, axis, limits) in enumerate(
            (("bottom", axes.xaxis, axes.get_xlim()), ("left", axes.yaxis, axes.get_ylim()))):
        axis.set_visible(False)
        ticks = draw_ticks(figure, (left, bottom, width, height), side, limits, intervals[number], numbered=numbered[number],
                           label=labels[number], pad=pad)
        if grid:
            upright = side == "bottom"
            lines = [[(tick, 0.0), (tick, 1.0)] if upright else [(0.0, tick), (1.0, tick)] for tick in ticks]
            place = axes.get_xaxis_transform() if upright else axes.get_yaxis_transform()
            axes.add_collection(LineCollection(lines, colors="0.9", linewidths=0.5, transform=place, zorder=0.5), autolim=False)

"""Pictures of a wheelset: its cross-section to scale with the pressure as combs, the maps of its patches side by side to
scale, and the quantities of a sweep over its shift."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator
from matplotlib.transforms import Affine2D

from thermoroll_cli.plots import style
from thermoroll_cli.plots.maps import draw_borders, kinds_of_borders
from thermoroll_cli.plots.run_frame import Borders, borders_of
from thermoroll_cli.plots.sweep_figures import words_of
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.arrays import Array

PLACE, DIFFERENCE = ".y_rail_mm", "rolling_radius_difference_mm"
"""Columns that a sweep draws besides forces: of each patch, and of the wheelset."""
WINDOW = (56.0, -26.0, 40.0)
"""Half-width of a cross-section about the middle of the rail, and its highest and lowest z, in mm."""

FROM_ABOVE = "seen from above"
GAPS = (-0.1, 0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Limits (mm) of the classes of gaps in a track from above."""
FLAT = 0.3
"""Maps of less height over width stand above each other."""
FAR = 5.0
"""Distance (mm) across of nearest places that follow each other along the track, from which on they are of other bodies."""


def section_figure(result: Result) -> Figure:
    """Rails and wheels across the track, to scale, seen from behind, and the largest pressure on each line of rolling as a comb
    on the rail."""
    sides = [name.removeprefix("rail_") for name in result.lines if name.startswith("rail_")]
    width, high, low = WINDOW
    figure = style.new_figure(style.DOUBLE, style.DOUBLE * (low - high) / (2.0 * width * len(sides)) + 26.0 * style.MM)
    peak = max((patch["pressure_max_MPa"] for patch in result.contacts), default=1.0)
    for axes, side in zip(figure.subplots(1, len(sides), squeeze=False)[0], sides, strict=True):
        rail, wheel = (1e3 * result.lines[f"{body}_{side}"] for body in ("rail", "wheel"))
        axle = result.lines.get(f"axle_{side}")
        axes.plot(*rail, color=style.BEFORE, label="rail" if axle is None else f"roller, radius {1e3 * axle[1, 0]:.4g} mm")
        axes.plot(*wheel, color=style.AFTER, label="wheel")
        words = []
        for patch in (patch for patch in result.contacts if patch.record["side"] == side):
            record = patch.record
            tip = _draw_comb(axes, patch, peak)
            axes.annotate(str(record["number"]), tip, ha="center", va="bottom", xytext=(0.0, 1.0), textcoords="offset points")
            words.append(f"patch {record['number']}: {1e-3 * record['normal_N']:.3g} kN, {record['pressure_max_MPa']:.0f} MPa, "
                         f"angle {record['angle_mrad']:.0f} mrad".replace("-", "−"))
        middle = 0.5 * (rail[0].min() + rail[0].max())
        axes.set(xlim=(middle - width, middle + width), ylim=(low, high), aspect="equal", xlabel="y (mm)")
        axes.set_title("\n".join([f"{side} wheel", *(words or ["no contact" if result.converged else "no patch was solved"])]))
        style.few_ticks(axes, 6, 5, grid=True)
    figure.axes[0].set_ylabel("z (mm)")
    scale = f", largest pressure {peak:.0f} MPa" if result.contacts else ""
    style.add_headline(figure, result.problem.title, result.converged, f"seen from behind{scale}")
    # Another wheel may have no contact, and therefore no comb.
    handles = [axes.get_legend_handles_labels()[0] for axes in figure.axes]
    style.add_legend(figure, max(handles, key=len))
    return figure


def _draw_comb(axes: Axes, patch: Result, peak: float) -> tuple[float, float]:
    """Teeth along the normals into the wheel, 1.6 mm apart and as long as the largest pressure of each line of rolling (14 mm
    for the `peak`); the tip of the longest."""
    highest = 1e-6 * np.asarray(patch.fields["pressure"]).max(axis=0)
    loaded = np.flatnonzero(highest > 0.0)
    step = 0.5 * (patch.y[1] - patch.y[0])
    # From edge to edge, with as many teeth between as can be told apart.
    places = np.concatenate(([patch.y[loaded[0]] - step], patch.y[loaded], [patch.y[loaded[-1]] + step]))
    pressures = np.concatenate(([0.0], highest[loaded], [0.0]))
    teeth = np.linspace(places[0], places[-1], max(int(1e3 * np.ptp(places) / 1.6), 1) + 1)[1:-1]

    def ends(at: Array) -> tuple[Array, Array]:
        y, z, angle = (np.interp(at, patch.y, line) for line in patch.lines["surface"])
        foot, length = 1e3 * np.stack((y, z), axis=1), 14.0 * np.interp(at, places, pressures) / peak
        return foot, foot + length[:, None] * np.stack((np.sin(angle), -np.cos(angle)), axis=1)

    axes.add_collection(LineCollection(np.stack(ends(teeth), axis=1).tolist(), colors="0.35", linewidths=0.5))
    feet, envelope = ends(places)
    named = len(axes.get_legend_handles_labels()[0]) > 2
    axes.fill(*np.concatenate((envelope, feet[::-1])).T, color="0.88", linewidth=0.0, zorder=0.9)
    axes.plot(*envelope.T, color="0.35", linewidth=0.8, label="_" if named else "largest pressure")
    longest = int(np.argmax(pressures))
    return float(envelope[longest, 0]), float(envelope[longest, 1])


def patches_figure(result: Result) -> Figure | None:
    """Pressure of all patches side by side on one scale, of a wheelset seen from above: x along travel upwards, y to the
    right along the surface. None without a patch."""
    return pressure_maps(result, FROM_ABOVE, _names(result))


def gap_figure(result: Result) -> Figure | None:
    """The gap between rail and wheel around the axle, seen from above, with the contacts and the line on which the bodies are
    nearest; None where they are the same all along."""
    places = {float(name.split("_")[3]) for name in result.lines if name.startswith("top_")}
    if not places:
        return None
    sides = [name.removeprefix("rail_") for name in result.lines if name.startswith("rail_")]
    x = np.array(sorted(places))
    gaps, ends = dict[str, tuple[Array, Array]](), dict[str, tuple[float, float]]()
    for side in sides:
        top, bottom = (np.array([1e3 * result.lines[f"{body}_{side}_at_{at:g}_mm"] for at in x]) for body in ("top", "bottom"))
        y, gap = gaps[side] = top[0, 0], top[:, 1] - bottom[:, 1]
        near = y[(gap < GAPS[-1]).any(axis=0)]
        ends[side] = (near.min() - 5.0, near.max() + 5.0) if len(near) else (y.min(), y.max())
    page = style.DOUBLE if len(sides) > 1 else style.SINGLE
    # As tall as maps to scale are that fill the width, which labels and colour bars leave.
    per_mm = (page / style.MM / len(sides) - 40.0) / max(high - low for low, high in ends.values())
    figure = style.new_figure(page, min((per_mm * np.ptp(x) + 26.0) * style.MM, 1.4 * style.SINGLE))
    figure.set_layout_engine("compressed")
    for axes, side in zip(figure.subplots(1, len(sides), squeeze=False)[0], sides, strict=True):
        y, gap = gaps[side]
        image = axes.contourf(y, x, gap, levels=GAPS, cmap="cividis_r", extend="max",
                              norm=BoundaryNorm(GAPS, 256, extend="max"))
        lowest = np.where(np.isnan(gap), np.inf, gap)
        nearest = y[lowest.argmin(axis=1)]
        jumps = np.flatnonzero(np.abs(np.diff(nearest)) > FAR) + 1
        axes.plot(np.insert(nearest, jumps, np.nan), np.insert(x, jumps, np.nan), color=style.AFTER, linewidth=1.0,
                  linestyle=style.DASHED, label="least gap across")
        for patch in (patch for patch in result.contacts if patch.record["side"] == side):
            *_, borders, place = _cropped(patch, np.zeros(np.shape(patch.coupled.fields["pressure"])))
            centre = patch.record["y_mm"], patch.record["x_mm"]
            draw_borders(axes, borders, Affine2D(np.array(place.get_matrix())).translate(*centre))
            axes.annotate(str(patch.record["number"]), centre, xytext=(9.0, 5.0), textcoords="offset points",
                          bbox={"facecolor": "white", "linewidth": 0.0, "pad": 1.0})
        axes.axhline(0.0, color="0.6", linewidth=0.6)
        axes.set(xlabel="y (mm)", title=f"{side} rail", aspect="equal", ylim=(x[0], x[-1]), xlim=ends[side], facecolor="0.93")
        figure.colorbar(image, ax=axes, label="gap (mm)")
    figure.axes[0].set_ylabel("x along travel from the axle (mm)")
    style.add_headline(figure, result.problem.title, result.converged, FROM_ABOVE)
    style.add_legend(figure, figure.axes[0].get_legend_handles_labels()[0])
    return figure


def _names(result: Result) -> list[str]:
    return [patch.name.replace("_", " ") for patch in result.shown]


def pressure_maps(result: Result, note: str, titles: Sequence[str]) -> Figure | None:
    """The pressure of the contacts that are `shown`, with `titles`, on one scale, and a `note` on how. None without any."""
    pressures = [1e-6 * np.asarray(patch.coupled.fields["pressure"]) for patch in result.shown]
    return _maps(result, pressures, 0.0, "pressure (MPa)", note, titles)


def friction_figure(result: Result) -> Figure | None:
    """The local coefficient of friction in the same way. None where it is the same everywhere."""
    values = []
    for patch in result.contacts:
        fields = patch.coupled.fields
        # A patch in which friction is the same everywhere has no field of it.
        whole = patch["friction_limit_N"] / patch["normal_N"]
        values.append(np.where(np.asarray(fields["pressure"]) > 0.0, fields.get("friction_coefficient", whole), np.nan))
    low, high = (float(min(map(np.nanmin, values), default=0.0)), max(map(np.nanmax, values), default=0.0))
    if high <= low * (1.0 + 1e-9):
        return None
    return _maps(result, values, low, "coefficient of friction μ", FROM_ABOVE, _names(result))


def _maps(
    result: Result, values: Sequence[Array], lowest: float, words: str, note: str, titles: Sequence[str]
) -> Figure | None:
    """`values` (nx, ny) of all patches on one scale of lengths, from the `lowest` on; nan is left empty."""
    if not result.shown:
        return None
    shown = [_cropped(patch, value) for patch, value in zip(result.shown, values, strict=True)]
    boxes = [(y[0], y[-1], x[0], x[-1]) for x, y, *_ in shown]
    widths, middles = [right - left for left, right, _, _ in boxes], [0.5 * (low + high) for *_, low, high in boxes]
    height = max(high - low for *_, low, high in boxes)
    # Flat ones stand above each other. No patch of a wheel is blown up; those of balls, of tenths of a millimetre, fill their
    # column.
    flat = height < FLAT * max(widths) and len(shown) > 1
    columns, rows, width = (1, len(shown), max(widths)) if flat else (len(shown), 1, sum(widths))
    beside, largest = 24.0 + 14.0 * columns, min(75.0 / height, max(8.0, (110.0 if flat else 55.0) / max(widths)))
    narrow = width <= 1.4 * height if len(shown) == 1 else largest * width + beside <= style.SINGLE / style.MM
    page = style.SINGLE if narrow else style.DOUBLE
    per_mm = min((page / style.MM - beside) / width, largest)
    figure = style.new_figure(page, (rows * (per_mm * height + 8.0) + 22.0) * style.MM)
    figure.set_layout_engine("compressed")
    norm = Normalize(lowest, max(float(np.nanmax(value)) for value in values))
    colours = ScalarMappable(norm, matplotlib.colormaps["viridis"])
    panels = figure.subplots(rows, columns, squeeze=False, sharex=flat, width_ratios=None if flat else widths).ravel()
    ends = min(left for left, *_ in boxes), max(right for _, right, *_ in boxes)
    # Labels across take more room than those along: at least so many mm from tick to tick.
    across, along = (MaxNLocator(max(4, int(per_mm * length / room)), steps=[1, 2, 5, 10]).tick_values(0.0, length)[1]
                     for length, room in ((max(widths), 9.0), (height, 6.0)))
    for axes, title, (x, y, value, borders, place), box, middle in zip(panels, titles, shown, boxes, middles, strict=True):
        (dx, dy) = (0.5 * (axis[1] - axis[0]) for axis in (x, y))
        image = axes.imshow(value, norm=norm, cmap=colours.cmap, origin="lower",
                            interpolation="nearest" if np.isnan(value).any() else "bilinear",
                            extent=(y[0] - dy, y[-1] + dy, x[0] - dx, x[-1] + dx))
        if borders.outline is not None:
            image.set_clip_path(borders.outline, transform=place + axes.transData)
        draw_borders(axes, borders, place)
        axes.set(xlim=ends if flat else box[:2], ylim=(middle - 0.5 * height, middle + 0.5 * height),
                 xlabel="y (mm)" if axes in panels[-columns:] else "", title=title)
        axes.xaxis.set_major_locator(MultipleLocator(across))
        axes.yaxis.set_major_locator(MultipleLocator(along))
    for axes in panels[::columns]:
        axes.set_ylabel("x along travel (mm)" if note == FROM_ABOVE else "x (mm)")
    figure.colorbar(colours, ax=list(panels), label=words, pad=0.06)
    style.add_headline(figure, result.problem.title, result.converged, note)
    style.add_legend(figure, kinds_of_borders(borders for *_, borders, _ in shown))
    return figure


def _cropped(patch: Result, value: Array) -> tuple[Array, Array, Array, Borders, Affine2D]:
    """x and y (mm, about the centre of pressure) and `value` of a patch up to 1.5 mm, or an element, around its contact, seen
    from above; its borders in m, and the way from these to a map of it."""
    # The axes of a patch of a wheelset are turned against those of the track.
    sides = {"left": (-1e3, 1e3), "right": (-1e3, -1e3)}
    state, (along, across) = patch.coupled, sides.get(patch.record.get("side", ""), (1e3, 1e3))
    x, y = along * state.x, across * state.y
    pressure = np.asarray(state.fields["pressure"])
    centre = [float(pressure.sum(axis=1 - axis) @ places / pressure.sum()) for axis, places in ((0, x), (1, y))]
    x, y = x - centre[0], y - centre[1]
    rows, columns = (np.flatnonzero(pressure.any(axis=axis)) for axis in (1, 0))
    keep_x, keep_y = ((axis > axis[some].min() - room) & (axis < axis[some].max() + room)
                      for axis, some in ((x, rows), (y, columns)) for room in [max(1.5, 1.5 * abs(axis[1] - axis[0]))])
    order = np.argsort(y[keep_y])
    up = np.argsort(x[keep_x])
    seen = np.ix_(np.flatnonzero(keep_x)[up], np.flatnonzero(keep_y)[order])
    place = Affine2D([[0.0, across, -centre[1]], [along, 0.0, -centre[0]], [0.0, 0.0, 1.0]])
    return x[keep_x][up], y[keep_y][order], value[seen], borders_of(state.x, state.y, state.fields), place


def wheelset_sweep_figure(columns: Mapping[str, Sequence[Any]], over: str, title: str) -> Figure:
    """Over a swept key: places of the contacts on both rails, difference of the rolling radii, and forces on both rails.
    `columns` are those of the table of a sweep."""
    order = np.argsort(np.asarray(columns[over], dtype=float), kind="stable")
    table = {name: np.asarray(column, dtype=float)[order] for name, column in columns.items()
             if name in (over, DIFFERENCE) or name.endswith((PLACE, ".normal_N")) or name.startswith("track_force_")}
    at = table[over]
    figure = style.new_figure(style.DOUBLE, 1.6 * style.SINGLE)
    places, radii, forces = figure.subplots(3, 1, sharex=True)
    # Contacts of both rails may lie at one place: open squares show the discs inside.
    for side, colour, marker, filled in (("left", style.BEFORE, "o", True), ("right", style.AFTER, "s", False)):
        face = {"color": colour, "linewidths": 0.0} if filled else {"facecolors": "none", "edgecolors": colour}
        names = [name.removesuffix(PLACE) for name in table if name.startswith(side) and name.endswith(PLACE)]
        largest = max((float(np.nanmax(table[f"{name}.normal_N"])) for name in names), default=1.0)
        for name in names:
            size = 4.0 + 32.0 * np.nan_to_num(table[f"{name}.normal_N"]) / largest
            places.scatter(at, table[name + PLACE], s=size if filled else 1.6 * size, marker=marker, **face)
        places.plot([], [], marker, color=colour, fillstyle="full" if filled else "none", label=f"{side} rail")
        for direction, line in (("y", "-"), ("x", "--")):
            if (force := f"track_force_{direction}_{side}_N") in table:
                forces.plot(at, 1e-3 * table[force], line, marker=".", color=colour, label=f"{side}, along {direction}")
    if DIFFERENCE in table:
        radii.plot(at, table[DIFFERENCE], color="0.2", marker=".")
    places.set_ylabel("y on the rail (mm),\narea: load")
    radii.set_ylabel("difference of\nrolling radii (mm)")
    forces.set(ylabel="force on the rail (kN)", xlabel=words_of(over))
    for axes in (places, radii, forces):
        style.few_ticks(axes, 10, 5, grid=True)
    style.add_headline(figure, title, all(status == "converged" for status in columns["status"]))
    style.add_legend(figure, [*places.get_legend_handles_labels()[0], *forces.get_legend_handles_labels()[0]])
    return figure

"""Scalars against the swept quantities: curves, creep curves beside simplified theories, heat maps (the article's Fig. 13)."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from thermoroll_cli.exact.kalker import THEORIES, CreepageCoefficients, fastsim, linear_creep_forces, polach
from thermoroll_cli.plots import style
from thermoroll_cli.plots.run_frame import WITHOUT
from thermoroll_cli.problem.columns import CASE
from thermoroll_cli.problem.names import ALL_SCALARS, DIAGRAMS, ISOTHERMAL, UNCERTAINTY, UNITS, unit_end
from thermoroll_cli.problem.scalar_errors import ANY_FORCES, FORCES, STEADY, finite, is_steady, worth_showing

Column = NDArray[np.float64]
Table = Mapping[str, Sequence[Any]]
Numbers = Mapping[str, Column]
"""The columns of a table as numbers, nan for all else."""


THEORY_COLUMNS = ("hertz_a_mm", "hertz_b_mm", "shear_modulus_GPa", "friction_limit_N", "kalker_C11", "kalker_C22", "kalker_C23",
                  "creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm")  # fmt: skip
"""Columns that the creep forces of these theories depend on."""

ENDLESS: dict[str, Any] = {"marker": "o", "markersize": 4.5, "markerfacecolor": "white", "linestyle": "none"}
"""Look of a peak that has no limit."""
MAXIMUM: dict[str, Any] = {"marker": "v", "markersize": 5.0, "markeredgecolor": "black", "linestyle": "none"}
"""Look of the maximum of a creep curve."""
LINE: dict[str, Any] = {"marker": "o", "markersize": 2.2}
"""Look of a line of few points."""
COLD: dict[str, Any] = {"linestyle": style.DASHED, "linewidth": 0.9}
"""Look of the state without thermal deformation."""
APART: dict[str, Any] = {"linestyle": "none", "markersize": 3.5}
"""What points over words have in place of a line, which would join what nothing lies between."""
UPPER: dict[str, Any] = {"linestyle": (0, (6.0, 1.2, 1.4, 1.2)), "markerfacecolor": "white", "markersize": 3.2}
"""Look of the upper body beside the lower one."""
THEORY_LOOKS: dict[str, tuple[Any, str]] = {
    "linear": (style.DOTTED, "1"), "fastsim": ((0, (5.0, 1.4, 1.0, 1.4)), "2"),
    "polach": ((0, (5.0, 1.4, 1.0, 1.4, 1.0, 1.4)), "3")}
"""Dashes of a theory's curve, and its marker where points stand apart."""


class Line(NamedTuple):
    """The rows of one combination of the further swept quantities, in the order of the first one, and the places of those that
    did not converge."""

    rows: NDArray[np.int_]
    missed: Column
    label: str
    colour: str


def sweep_figure(
    table: Table, over: Sequence[str], *, title: str = "", compare: Sequence[str] = (), only: Sequence[str] = (),
    also: Sequence[Artist] = (), ax: Axes | None = None,
) -> Figure:
    """The scalars of `table` (a column per name, a value per point) against the first quantity of `over`.

    There is one line for each combination of the further quantities, with a band of ± the estimated error; two quantities of
    many values are drawn as maps. What differs visibly between the bodies is drawn of both. Columns with the prefix
    `isothermal.` are dashed where they differ visibly. Points whose `status` is not "converged" are left out and marked. The
    axis is logarithmic where the values are spaced so. Quantities that do not change or were not computed get no diagram. Creep
    forces stand beside those of the theories to `compare` with. Columns that are named are drawn `only`, a diagram each, those
    without a number left out, one alone also on axes of the caller, `ax`. The legend has the artists `also`.

    Raises ValueError: nothing swept, an unknown theory, or a table that lacks what it needs, or all that is to be drawn.
    """
    if not over or any(name not in table for name in over):
        raise ValueError(f"a sweep figure needs the swept quantities as columns, got {list(over)}")
    x, words = places(table[over[0]])
    # Points that did not converge have no scalars, or those of another state than the one asked for.
    failed = np.array([status != "converged" for status in table.get("status", ["converged"] * x.size)], dtype=bool)
    if not np.any(np.isfinite(x) & ~failed) or (words and over[0] == "status"):
        raise ValueError(f"the column {over[0]} holds no numbers")
    columns = {name: numbers(column) for name, column in table.items()}
    good = {name: column if name in over else np.where(failed, math.nan, column) for name, column in columns.items()}
    scalars = rows_of(good)
    diagrams = [(label, _of_bodies(good, names)) for label, names in DIAGRAMS.items() if _worth_drawing(scalars, names, over)]
    if only:
        diagrams = [(_label_of(name), {"": name}) for name in only if np.isfinite(good.get(name, np.empty(0))).any()]
        if not diagrams:
            raise ValueError(f"{', '.join(only)}: not computed at any point")
    counts = [np.unique(column[np.isfinite(column)]).size for column in (good[name] for name in over)]
    # Two quantities of five values or more each, and a point for most pairs.
    maps = len(over) == 2 and min(counts) >= 5 and x.size >= 0.8 * counts[0] * counts[1]
    if maps:
        diagrams = [(f"{label}, {words}" if words else label, {words: name})
                    for label, names in diagrams for words, name in names.items()]
    figure, grid, lowest = _grid(len(diagrams) or 1) if ax is None else (cast(Figure, ax.figure), [ax], [True])
    if maps:
        for axes, (label, names) in zip(grid, diagrams, strict=False):
            (name,) = names.values()
            _draw_map(axes, good, name, over, failed)
            axes.set_title(label)
    else:
        lines = list(_lines_of(table, over, x, failed))
        theories = {theory: [_theory_curve(columns, theory, x, line, words) for line in lines] for theory in compare}
        # Some ten of many lines.
        handles: list[Artist] = [Line2D([], [], color=line.colour, label=line.label)
                                 for line in lines[:: -(-len(lines) // 10)] if len(lines) > 1]
        if any(line.missed.size for line in lines):
            handles.append(Line2D([], [], color="0.2" if len(lines) > 1 else style.ALERT, linestyle="none", marker="x",
                                  markersize=4.0, label=style.NOT_CONVERGED))
        for axes, (label, names), has_words in zip(grid, diagrams, lowest, strict=False):
            for body, name in names.items():
                endless = np.array([name in str(cell).split() for cell in table.get("unbounded", [""] * x.size)])
                handles += _draw_curves(axes, x, good, name, endless, lines, upper=body == UPPER_BODY, apart=bool(words))
                if body:
                    look = LINE | (UPPER if body == UPPER_BODY else {})
                    colour = "0.2" if len(lines) > 1 else style.AFTER if body == UPPER_BODY else lines[0].colour
                    handles.append(Line2D([], [], color=colour, label=body, **look))
            handles += _draw_diagram(axes, x, good, [*names.values()], lines, theories, apart=bool(words))
            axes.set_ylabel(label if "$" in label else textwrap.fill(label, 28))
            _finish(axes, x, words, words_of(over[0]) if has_words else "")
        # Only the lowest have numbers, also where one of them knows fewer points.
        ends = np.array([axes.get_xlim() for axes in grid])
        for axes in grid:
            axes.set_xlim(ends[:, 0].min(), ends[:, 1].max())
        if ax is None:
            style.add_legend(figure, [*handles, *also])
        elif named := {str(handle.get_label()): handle for handle in (*handles, *also)}:
            ax.legend(handles=[*named.values()])
    if ax is None:
        style.add_headline(figure, title, note="theories: smooth bodies, constant friction" if compare else "")
    return figure


def _grid(count: int) -> tuple[Figure, list[Axes], list[bool]]:
    """A figure with axes for `count` diagrams in rows of three or two, or of one alone, which all fill the width; and whether
    no row of as many is below each, with which it shares its axis."""
    in_row = [len(part) for part in np.array_split(np.arange(count), -(-count // 3))]
    figure = style.new_figure((style.SINGLE, style.SINGLE * 1.5, style.DOUBLE)[in_row[0] - 1],
                              (44.0 * len(in_row) + 20.0) * style.MM)
    shares = [(wide, in_row.count(wide)) for wide in dict.fromkeys(in_row)]
    parts = figure.subfigures(len(shares), 1, squeeze=False, height_ratios=[rows for _, rows in shares])[:, 0]
    axes, lowest = list[Axes](), list[bool]()
    for part, (wide, rows) in zip(parts, shares, strict=True):
        axes += [*part.subplots(rows, wide, squeeze=False).flat]
        lowest += [False] * (wide * (rows - 1)) + [True] * wide
    return figure, axes, lowest


def _label_of(name: str) -> str:
    """What stands beside the axis of a column that is drawn alone."""
    scalar = ALL_SCALARS.get(name)
    if scalar is None:
        return style.readable(words_of(name))
    alone = scalar.diagram if len(DIAGRAMS.get(scalar.diagram, ())) == 1 else ""
    words = scalar.brief or scalar.meaning
    return alone or "\n".join(textwrap.wrap(f"{words} ({scalar.unit})" if scalar.unit else words, 34))


LOWER_BODY, UPPER_BODY = "lower body", "upper body"


def _of_bodies(table: Numbers, names: Sequence[str]) -> dict[str, str]:
    """The scalars of a diagram by the body that they are of, where both differ visibly; else the one that is known, by ""."""
    known = [name for name in names if np.isfinite(table.get(name, np.empty(0))).any()]
    if len(known) < 2:
        return {"": known[0]}
    difference = float(np.nanmax(np.abs(table[known[0]] - table[known[1]]), initial=0.0))
    alike = difference <= style.VISIBLE * float(np.nanmax(np.abs(table[known[0]])))
    return {"": known[0]} if alike else dict(zip((LOWER_BODY, UPPER_BODY), known, strict=True))


def is_logarithmic(values: Column) -> bool:
    """Whether positive values over at least a factor 5 are spaced more evenly in their logarithms."""
    points = np.unique(values[np.isfinite(values)])
    if points.size < 3 or points[0] <= 0.0 or points[-1] < 5.0 * points[0]:
        return False

    def unevenness(positions: Column) -> float:
        steps = np.diff(positions)
        return float(steps.std() / steps.mean())

    return unevenness(np.log(points)) < unevenness(points)


def _worth_drawing(points: Sequence[Mapping[str, Any]], names: Sequence[str], over: Sequence[str]) -> bool:
    """Whether one of the scalars is worth showing, and not 0 everywhere; a creepage, a shift or a number of spots if it
    changes, a ratio to Hertz's contact if it changes and is not 1 within its error everywhere: without anything that acts back
    it shows the grid alone. A force that is 0 within a small error everywhere is that of a symmetry, as the grid has it."""
    ratio = names[0].startswith(("gamma_c", "gamma_p"))
    wanting = ratio or names[0].startswith(("creepage", "shift", "contact_spots"))

    def says_nothing(name: str) -> bool:
        values, errors = finite(name, points), finite(UNCERTAINTY + name, points)

        def is_everywhere(known: float) -> bool:
            return len(errors) == len(values) and all(abs(value - known) <= error
                                                      for value, error in zip(values, errors, strict=True))

        if name in ANY_FORCES:
            limits = finite(_limit_of(name), points)
            return is_everywhere(0.0) and max(errors, default=0.0) <= style.VISIBLE * max(limits, default=0.0)
        return wanting and (is_steady(values) or (ratio and is_everywhere(1.0)))

    return any(worth_showing(name, points, over) and any(finite(name, points)) and not says_nothing(name) for name in names)


def _limit_of(force: str) -> str:
    """The friction limit of a creep force, of which a sweep over contacts and line contacts has both."""
    return "friction_limit_N_mm" if force.endswith("_mm") else "friction_limit_N"


def _lines_of(table: Table, over: Sequence[str], x: Column, failed: NDArray[np.bool_]) -> Iterator[Line]:
    """A line for each combination of the further quantities, in the order in which they are given."""
    keys = [tuple(table[name][row] for name in over[1:]) for row in range(x.size)]
    distinct = list(dict.fromkeys(keys))
    # The colours of the style as far as they go, or in order from a map, but not to its end: its yellow hardly shows on white.
    colours = [f"C{place}" for place in range(len(distinct))] if len(distinct) <= 8 else [
        to_hex(colormaps["viridis"](0.92 * place)) for place in np.linspace(0.0, 1.0, len(distinct))]
    for key, colour in zip(distinct, colours, strict=True):
        own = np.array([other == key for other in keys]) & np.isfinite(x)
        rows = np.flatnonzero(own & ~failed)
        label = ", ".join(with_value(name, value) for name, value in zip(over[1:], key, strict=True))
        yield Line(rows[np.argsort(x[rows], kind="stable")], np.unique(x[own & failed]), label, colour)


def _draw_curves(
    axes: Axes, x: Column, table: Numbers, name: str, endless: NDArray[np.bool_], lines: list[Line], *, upper: bool,
    apart: bool,
) -> list[Artist]:
    """The curves of a scalar, or points `apart` where places are words, that of the `upper` body as such, in a colour of its
    own where lines need none; returns handles for the legend of all but the lines themselves."""
    lines = [lines[0]._replace(colour=style.AFTER)] if upper and len(lines) == 1 else lines
    values, error = table[name], errors(table, name)
    handles: list[Artist] = []
    cold = table.get(ISOTHERMAL + name)
    largest, look = float(np.nanmax(np.abs(values))), LINE | (UPPER if upper else {}) | (APART if apart else {})
    cold_look = COLD | ({**APART, "marker": "D", "markerfacecolor": "white"} if apart else {})
    share, positive = name == "gamma_st", _positive(table, name)
    falling = table.get("falling_friction_criterion", np.full(len(values), math.nan)) > 0.0
    for line in lines:
        rows = line.rows[np.isfinite(values[line.rows])]
        axes.plot(x[rows], values[rows], color=line.colour, **(look if rows.size <= 30 or apart else {**look, "marker": ""}))
        if error[rows].any():
            band = values[rows] - error[rows], values[rows] + error[rows]
            if positive:
                band = np.maximum(band[0], 0.0), np.minimum(band[1], 1.0 if share else math.inf)
            if apart:
                axes.vlines(x[rows], *band, color=line.colour, linewidth=0.7)
            else:
                axes.fill_between(x[rows], *band, color=line.colour, alpha=0.25, linewidth=0.0)
        if cold is not None and np.nanmax(np.abs(cold[rows] - values[rows]), initial=0.0) > style.VISIBLE * largest:
            axes.plot(x[rows], cold[rows], color=line.colour, **cold_look)
            handles += [Line2D([], [], color="0.2", **cold_look, label=WITHOUT)]
        if endless[rows].any():
            axes.plot(x[rows][endless[rows]], values[rows][endless[rows]], **ENDLESS, color=line.colour)
            handles += [Line2D([], [], color="0.2", **ENDLESS, label="no limit")]
        if name in ANY_FORCES and (top := _maximum(x[rows], values[rows], falling[rows])) is not None:
            axes.plot(*top, **MAXIMUM, color=line.colour)
            handles += [Line2D([], [], color="0.2", **MAXIMUM, label="maximum, where friction falls")]
    return handles


def _positive(table: Numbers, name: str) -> bool:
    """Whether a scalar is nowhere below 0, as no share and no maximum of what is positive is."""
    return name == "gamma_st" or "_depth_" in name or ("_max_" in name and float(np.nanmin(table[name])) >= 0.0)


def _draw_diagram(
    axes: Axes, x: Column, table: Numbers, names: Sequence[str], lines: list[Line],
    theories: dict[str, list[dict[str, Column]]], *, apart: bool,
) -> list[Artist]:
    """What stands beside the curves, or points `apart`, of a diagram: theories, the points that failed, limits and a second
    axis; returns handles for the legend."""
    handles, error = list[Artist](), max(float(errors(table, name).max(initial=0.0)) for name in names)
    # The linear theory goes on without limit, and alone is cut off by the diagram.
    for theory, curves in sorted(theories.items(), key=lambda each: each[0] == "linear"):
        if theory == "linear":
            style.not_closer_than(axes, error)
        dashes, marker = THEORY_LOOKS[theory]
        look = {**APART, "marker": marker, "markersize": 8.0} if apart else {"linestyle": dashes, "linewidth": 0.9}
        for line, curve in zip(lines, curves, strict=True) if names[0] in ANY_FORCES else ():
            axes.plot(curve["place"], curve[names[0]], color=line.colour, **look)
            handles += [Line2D([], [], color="0.2", label=THEORIES[theory], **look)]
    style.not_closer_than(axes, error)
    if all(_positive(table, name) for name in names):
        low, high = axes.get_ylim()
        high = min(high, 1.05) if names[0] == "gamma_st" else high
        axes.set_ylim(max(low, -0.04 * high), high)
    # A point that failed has no value: it is marked at the foot, above each other where several lines fail at one place.
    failed = [line for line in lines if line.missed.size]
    for place, line in enumerate(failed):
        height = 0.04 + 0.3 * place / max(len(failed), 6)
        axes.plot(line.missed, np.full(line.missed.size, height), "x", markersize=4.0,
                  color=line.colour if len(lines) > 1 else style.ALERT, transform=axes.get_xaxis_transform())
    limits = table.get(_limit_of(names[0]), np.empty(0))
    limits = limits[np.isfinite(limits)]
    if names[0] in ANY_FORCES and limits.size and 0.0 <= np.ptp(limits) <= STEADY * limits[0]:
        # An axis at the right with the force over μW, which is the same for all points.
        limit: Any = limits[0]
        right = axes.secondary_yaxis("right", functions=(lambda force: np.divide(force, limit),
                                                         lambda share: np.multiply(share, limit)))
        right.set_ylabel(rf"$F_{names[0][6]}/(\mu W)$")
    return handles


def _theory_curve(table: Numbers, theory: str, x: Column, line: Line, words: list[str]) -> dict[str, Column]:
    """Places on a line between its points, and the forces of a theory there: what they depend on is interpolated."""
    known = x[line.rows]
    if not known.size:
        return dict.fromkeys(("place", *FORCES), known)
    steps = np.arange(known.size) if words else np.linspace(0.0, known.size - 1.0, 12 * (known.size - 1) + 1)
    to, back = (np.log, np.exp) if is_logarithmic(x) else (np.asarray, np.asarray)
    place = back(np.interp(steps, np.arange(known.size), to(known)))
    between = {name: np.interp(place, known, table[name][line.rows]) for name in THEORY_COLUMNS if name in table}
    return {"place": place, **theory_forces(between, theory)}


def _maximum(x: Column, force: Column, falling: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Where the force has its largest size (a parabola through three points), if friction falls with slip and the force does
    beyond."""
    top = int(np.abs(force).argmax()) if force.size else 0
    if not (0 < top < force.size - 1 and falling.all()):
        return None
    at = np.log(x[top - 1 : top + 2]) if is_logarithmic(x) else x[top - 1 : top + 2]
    a, b, c = np.polyfit(at - at[1], force[top - 1 : top + 2], 2)
    place = at[1] - 0.5 * b / a
    return float(np.exp(place) if is_logarithmic(x) else place), float(c - 0.25 * b * b / a)


def _draw_map(axes: Axes, table: Numbers, name: str, over: Sequence[str], failed: NDArray[np.bool_]) -> None:
    """A quantity over two swept ones as a map; crosses where points failed."""
    x, y, values = table[over[0]], table[over[1]], table[name]
    columns, rows = (np.unique(axis_values[np.isfinite(axis_values)]) for axis_values in (x, y))
    cells = np.full((rows.size, columns.size), math.nan)
    cells[np.searchsorted(rows, y), np.searchsorted(columns, x)] = np.where(failed, math.nan, values)
    low, high = float(np.nanmin(cells)), float(np.nanmax(cells))
    # Colours of changes below 0.02 of the largest value look alike.
    wide = max(0.5 * (high - low), 0.01 * max(abs(low), abs(high)))
    image = axes.pcolormesh(columns, rows, cells, shading="nearest", cmap="viridis", rasterized=True,
                            vmin=0.5 * (low + high) - wide, vmax=0.5 * (low + high) + wide)
    for set_scale, axis, marks in ((axes.set_xscale, axes.xaxis, columns), (axes.set_yscale, axes.yaxis, rows)):
        if is_logarithmic(marks):
            set_scale("log")
            _few_decades(axis, marks)
    axes.plot(x[failed], y[failed], "x", color=style.ALERT, markersize=4.0)
    axes.set(xlabel=words_of(over[0]), ylabel=words_of(over[1]))
    bar = axes.figure.colorbar(image, ax=axes, pad=0.02)
    style.few_ticks(bar.ax, y=5)


def _finish(axes: Axes, x: Column, words: list[str], label: str) -> None:
    """Ticks and label of the swept axis, which diagrams above each other share."""
    if words:
        axes.set_xticks(range(len(words)), words, parse_math=False)
        axes.set_xlim(-0.5, len(words) - 0.5)
        style.few_ticks(axes, y=6)
    elif is_logarithmic(x):
        axes.set_xscale("log")
        _few_decades(axes.xaxis, x)
        style.few_ticks(axes, y=6)
    else:
        style.few_ticks(axes, 4, 6)
    axes.grid(visible=True)
    axes.tick_params(labelbottom=bool(label))
    axes.set_xlabel(label, parse_math=False)


def _few_decades(axis: Axis, values: Column) -> None:
    """Numbers at 1, 2, 5 of each decade, at 1 and 3 or at 1 alone, as many as have room."""
    decades = math.log10(float(np.nanmax(values)) / float(np.nanmin(values)))
    few = 1.8 if np.nanmin(values) >= 0.01 else 1.3  # small numbers are long
    steps = (1.0, 2.0, 5.0) if decades < few else (1.0, 3.0) if decades < 2.6 else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=7))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def numbers(values: Sequence[Any]) -> Column:
    """The column as numbers, nan for words and what is not finite."""
    array = np.array([value if isinstance(value, int | float) else math.nan for value in values], dtype=float)
    return np.where(np.isfinite(array), array, math.nan)


def places(values: Sequence[Any]) -> tuple[Column, list[str]]:
    """Swept values as places on an axis: the numbers, or for words 0, 1, … and the words there."""
    array = numbers(values)
    if np.isfinite(array).any() or not values:
        return array, []
    words = list(dict.fromkeys(str(value) for value in values))
    return np.array([float(words.index(str(value))) for value in values]), words


def rows_of(table: Numbers) -> list[dict[str, float]]:
    """The rows of the table, each with what it has a number of: of several cases one may have it per length."""
    known = [name for name, column in table.items() if np.isfinite(column).any()]
    return [{name: value for name, value in zip(known, values, strict=True) if math.isfinite(value)}
            for values in zip(*(table[name].tolist() for name in known), strict=True)]


def errors(table: Numbers, name: str) -> Column:
    """Estimated errors of a scalar in its own unit; 0 where there is none."""
    return np.nan_to_num(table.get(UNCERTAINTY + name, np.zeros(len(table[name]))))


def theory_forces(table: Numbers, theory: str) -> dict[str, Column]:
    """Creep forces of one of `THEORIES` at every point, by column. Raises ValueError for another one, and where the table lacks
    what it needs."""
    if theory not in THEORIES:
        raise ValueError(f"creep forces can be compared with {', '.join(THEORIES)}, not {theory!r}")
    columns = [table.get(name, np.empty(0)) for name in THEORY_COLUMNS]
    if any(not np.isfinite(column).any() for column in columns):
        missing = next(name for name, column in zip(THEORY_COLUMNS, columns, strict=True) if not np.isfinite(column).any())
        raise ValueError(f"{THEORIES[theory]} needs an elliptic contact with friction: the table has no numbers in {missing}")
    forces = np.full((2, columns[0].size), math.nan)
    for row in np.flatnonzero(np.isfinite(columns).all(axis=0)):
        a, b, modulus, limit, c11, c22, c23, along, lateral, spin = (float(column[row]) for column in columns)
        contact = (CreepageCoefficients(c11, c22, c23, math.nan), a * 1e-3, b * 1e-3, modulus * 1e9)
        creepage = (along, lateral, spin * 1e3)
        made = (linear_creep_forces(*contact, *creepage) if theory == "linear"
                else {"fastsim": fastsim, "polach": polach}[theory](*contact, limit, *creepage))
        forces[:, row] = made.force_x, made.force_y
    return dict(zip(FORCES, forces, strict=True))


def with_value(key: str, value: Any) -> str:
    """A case key with its value: `rolling.speed_m_s` and 5 become "rolling speed = 5 m/s"."""
    if key == CASE:
        return str(value)
    words, _, unit = words_of(key).partition(" (")
    if value == math.inf:
        return f"{words} = ∞"
    if isinstance(value, int | float):
        value = style.readable(f"{value:.{6 if abs(value) >= 1.0 else 4}g}")
    return f"{words} = {value} {unit.removesuffix(')')}".rstrip()


def words_of(key: str) -> str:
    """A case key as an axis label: `rolling.speed_m_s` becomes "rolling speed (m/s)"."""
    section, _, name = key.rpartition(".")
    suffix = unit_end(name)
    words = name.removesuffix(suffix).replace("_", " ")
    if section in ("creepage", "force") and words != "spin":
        words = f"{words} {section}"
    elif words in ("normal", "vertical", "axial", "radial"):
        words = f"{words} load"
    elif section == "rolling":
        words = f"{section} {words}"
    return f"{words} ({UNITS[suffix]})" if suffix else words

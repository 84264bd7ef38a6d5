"""What the figures share: solving cases with changes, panels of maps in rows, curves in diagrams."""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from thermoroll_cli import Case
from thermoroll_cli.plots.maps import border_handles, draw_arrows, draw_map
from thermoroll_cli.plots.run_frame import TRACTION, RunFrame, frame_of, on_line
from thermoroll_cli.plots.style import add_axes, few_ticks
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver

Array = NDArray[np.float64]
Numbers = dict[str, Any]

ROOT = pathlib.Path(__file__).resolve().parents[2]
DPI = 140

MAIN = ("Q_F_W", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K", "force_x_N", "force_y_N",
        "spin_moment_Nmm")
"""Scalars that are written down for most runs."""

ISOTHERMAL, COUPLED, THIRD = "#0072b2", "#d55e00", "#009e73"
"""Colours that the colour-blind can tell apart."""
DASHED, DOTTED = (0, (4.0, 1.6)), (0, (1.0, 1.5))
THEIRS = {"color": "0.45", "linewidth": 0.9, "linestyle": DOTTED}
"""Look of what the article states."""


# --- solving ---------------------------------------------------------------------------------------------------------


def solve_case(name: str, changes: Mapping[str, Any] | None = None, *, grid: int = 0, solver: Solver | None = None) -> Result:
    """Result of cases/`name`.toml with other values for some keys, and on another grid if one is given."""
    case = Case.read(ROOT / "cases" / f"{name}.toml")
    if changes:
        case = case.with_values(changes)
    problem = case.problem
    if grid:
        problem = dataclasses.replace(problem, numerics=Numerics(grid=(grid, grid), extent=problem.numerics.extent))
    return solve_problem(problem, solver)


def solve_problem(problem: Problem, solver: Solver | None = None) -> Result:
    """Raises RuntimeError if it does not converge: no figure shows what is no steady state."""
    result = (solver or Solver()).solve(problem)
    if not result.converged:
        raise RuntimeError(f"{problem.title}: {result.reason}")
    return result


def rounded(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def plain(value: float) -> str:
    """Four digits, with a real minus sign; rounding noise is zero."""
    return "0" if abs(value) < 1e-5 else f"{value:.4g}".replace("-", "−")


def some(scalars: Mapping[str, float], *names: str) -> Numbers:
    return {name: rounded(scalars[name]) for name in names}


@dataclass(frozen=True)
class View:
    """A result with what the article's figures relate its fields to; lengths in m."""

    frame: RunFrame

    @property
    def x(self) -> Array:
        return self.frame.result.x

    @property
    def y(self) -> Array:
        return self.frame.result.y

    @property
    def semi_axes(self) -> tuple[float, float]:
        return self.frame.result.of_problem["hertz_a_mm"] * 1e-3, self.frame.result.of_problem["hertz_b_mm"] * 1e-3

    @property
    def peak_pressure(self) -> float:
        return self.frame.result.of_problem["hertz_p0_MPa"] * 1e6

    @property
    def heat_scale(self) -> float:
        return self.frame.heat_scale


# --- what lies on y = 0 ----------------------------------------------------------------------------------------------


def crossings(lines: Sequence[Array]) -> list[float]:
    """Where polylines (points, 2) cross y = 0, in ascending order."""
    found: list[float] = []
    for line in lines:
        x, y = line[:, 0], line[:, 1]
        for i in np.flatnonzero(y[:-1] * y[1:] < 0.0):
            found.append(float(x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i])))
    return sorted(found)


def on_centreline(view: View, values: Array, state: int = -1) -> Array:
    """`values` of a state along y = 0."""
    return on_line(view.frame.states[state].state.y, values, 0.0)


def edges_on_centreline(view: View, state: int) -> tuple[float, float, float]:
    """Leading edge, beginning of slip and trailing edge on y = 0, over a₀."""
    borders = view.frame.states[state].borders
    contact, stick = ([x / view.semi_axes[0] for x in crossings(lines)] for lines in (borders.contact, borders.stick))
    inside = [x for x in stick if contact[0] < x < contact[-1]]
    return contact[0], inside[-1] if inside else contact[0], contact[-1]


# --- maps ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Panel:
    """One map: a state of a run, a field of it, the words above."""

    view: View
    state: int
    values: Array
    words: str
    arrows: bool = False


def field_of(view: View, state: int, name: str) -> Array:
    """A field of a state in SI units; `shear` is the magnitude of the traction."""
    drawn = view.frame.states[state]
    values = drawn.values(TRACTION) if name == "shear" else drawn.state.fields[name]
    assert values is not None
    return values


def view_of(result: Result) -> View:
    """All panels of a figure show the same window over the semi-axes, so that contacts of different size can be compared."""
    view = View(frame_of(result, normalised=True))
    window = tuple(WINDOW * sign * axis for axis in view.semi_axes for sign in (-1.0, 1.0))
    return View(dataclasses.replace(view.frame, window=window, turned=False))


@dataclass(frozen=True)
class Row:
    """Panels that share a scale: `top` is its upper end, `label` and `colours` those of its bar."""

    panels: Sequence[Panel]
    top: float
    label: str
    colours: str
    clipped: bool = True


WINDOW = 1.08
LEFT, BOTTOM, GAP, TITLE, BAR_GAP, BAR, BAR_LABELS = 0.55, 0.45, 0.14, 0.26, 0.12, 0.12, 0.62
LEGEND = 0.2


def map_figure(rows: Sequence[Row], side: float, *, legend: bool = False) -> Figure:
    """Rows of square maps in the article's normalisation, one colour bar to each row."""
    columns = max(len(row.panels) for row in rows)
    bottom = BOTTOM + (LEGEND if legend else 0.0)
    width = LEFT + columns * side + (columns - 1) * GAP + BAR_GAP + BAR + BAR_LABELS
    height = bottom + len(rows) * (side + TITLE)
    figure = new_figure(width, height)
    for number, row in enumerate(rows):
        floor = bottom + (len(rows) - 1 - number) * (side + TITLE)
        image = None
        for column, panel in enumerate(row.panels):
            axes = add_axes(figure, LEFT + column * (side + GAP), floor, side, side)
            frame = panel.view.frame
            drawn = frame.states[panel.state]
            image = draw_map(axes, frame, drawn, panel.values,
                             {"cmap": row.colours, "norm": Normalize(0.0, row.top)}, open_ended=not row.clipped)
            if panel.arrows:
                draw_arrows(axes, frame, drawn, (side, side))
            axes.set_title(panel.words, y=1.0, pad=3.5)
            few_ticks(axes, 4, 4)
            lowest = number == len(rows) - 1
            axes.tick_params(labelbottom=lowest, labelleft=column == 0)
            axes.set_xlabel(r"$x/a_0$" if lowest else "", labelpad=2.0)
            axes.set_ylabel(r"$y/b_0$" if column == 0 else "", labelpad=2.0)
        bar = add_axes(figure, LEFT + columns * side + (columns - 1) * GAP + BAR_GAP, floor, BAR, side)
        figure.colorbar(image, cax=bar, label=row.label)
        few_ticks(bar, y=6)
    if legend:
        handles = max((border_handles(panel.view.frame) for panel in rows[0].panels), key=len)
        figure.legend(handles=handles, loc="lower center", ncols=len(handles), bbox_to_anchor=(0.5, 0.0))
    return figure


# --- diagrams --------------------------------------------------------------------------------------------------------


def diagrams(rows: int, columns: int, size: tuple[float, float], *, gap: tuple[float, float] = (0.72, 0.5),
             left: float = 0.62, bottom: float = 0.45, top: float = 0.14, right: float = 0.14) -> tuple[Figure, list[Axes]]:
    """A figure of rows × columns diagrams of one size (inches), and its axes row by row."""
    width = left + columns * size[0] + (columns - 1) * gap[0] + right
    height = bottom + rows * size[1] + (rows - 1) * gap[1] + top
    figure = new_figure(width, height)
    axes = []
    for row in range(rows):
        for column in range(columns):
            place = (left + column * (size[0] + gap[0]), bottom + (rows - 1 - row) * (size[1] + gap[1]))
            axes.append(add_axes(figure, *place, *size))
            axes[-1].grid(color="0.92", linewidth=0.5)
            axes[-1].set_axisbelow(True)
    return figure, axes


def letter(axes: Axes, text: str, *, right: bool = False, low: bool = False) -> None:
    """(a), (b), … inside the axes."""
    axes.text(0.97 if right else 0.03, 0.05 if low else 0.95, text, transform=axes.transAxes, weight="bold",
              ha="right" if right else "left", va="bottom" if low else "top")


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches."""
    return Figure(figsize=(width, height), dpi=DPI)


def write(figure: Figure, folder: pathlib.Path, name: str) -> None:
    """Save `figure` as small as PNG can be, without dates: the same figure is the same file."""
    figure.savefig(folder / f"{name}.png", dpi=DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> dict[str, list[Any]]:
    """A table for the documents (see figures.py)."""
    return {"header": list(header), "rows": [list(row) for row in rows]}

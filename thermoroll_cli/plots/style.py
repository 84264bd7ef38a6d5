"""Sizes, look and file formats of all pictures."""

from __future__ import annotations

import io
import pathlib
import re
import textwrap
import warnings
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from thermoroll_cli.tools.atomic import write_bytes

MM = 1.0 / 25.4
"""A millimetre in inches."""
SINGLE, DOUBLE = 90.0 * MM, 180.0 * MM
"""Widths of pictures: one or two columns of a journal."""

DPI = 200
"""Dots per inch of PNG files, unless asked for otherwise."""

FORMATS = ("png", "svg", "pdf")
WITHOUT_DATES: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Two files of the same picture are equal."""

BEFORE, AFTER = "#0072b2", "#d55e00"
"""Colours of the states without and with thermal deformation, and of the lower and the upper body: distinct for the
colour-blind and in print without colour."""
DASHED, DOTTED = (0, (4.0, 1.6)), (0, (1.0, 1.4))
VISIBLE = 1e-2
"""Share of a diagram by which two curves differ at least to be drawn both."""
NOT_CONVERGED = "not converged"
ALERT = "#c00000"


def applied() -> AbstractContextManager[None]:
    """The package's own style, whatever the user's matplotlibrc says: pictures look alike everywhere."""
    look = matplotlib.rc_params_from_file(pathlib.Path(__file__).with_name("thermoroll.mplstyle"))
    # The backend is the user's; it alone would stay changed.
    return matplotlib.rc_context({name: value for name, value in look.items() if name != "backend"})


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` × `height` inches, made without pyplot, that finds room for labels by itself."""
    return Figure(figsize=(width, height), layout="constrained")


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a fixed place (inches from the lower left corner): layouts that are known need no search, which costs as much as
    drawing."""
    across, up = figure.get_size_inches()
    return figure.add_axes((left / across, bottom / up, width / across, height / up))


def add_headline(figure: Figure, title: str, converged: bool = True, note: str = "") -> None:
    """The title of the case above the picture with a `note`; in red, if the state is not steady, that it has not converged."""
    width, height = (float(size) for size in figure.get_size_inches())
    # An inch surely holds 14 letters.
    room = int(14 * width) - len(note) - (0 if converged else 2 * len(NOT_CONVERGED))
    text = ", ".join(filter(None, (one_line(title, max(room, 8)), note)))
    top = 1.0 - 0.03 / height
    if text or not converged:
        # A constrained layout leaves room for a title that it places itself.
        place = {} if figure.get_layout_engine() else {"y": top}
        figure.suptitle(text or " ", x=0.01, ha="left", color="0.25", parse_math=False, **place)
    if not converged:
        figure.text(0.99, top, NOT_CONVERGED.upper(), ha="right", va="top", color=ALERT, weight="bold")


def legend_columns(handles: Sequence[Artist], width: float) -> int:
    """As many columns of a legend as `width` inches surely hold, each as wide as its longest label: 19 letters an inch."""
    widths = [0.46 + max(map(len, str(handle.get_label()).split("\n"))) / 19 for handle in handles]
    fitting = (columns for columns in range(len(widths), 1, -1)
               if sum(float(max(column)) for column in np.array_split(widths, columns)) <= width)
    return next(fitting, 1)


def legend_height(handles: Sequence[Artist], width: float) -> float:
    """Height (inches) of a legend of `width` inches."""
    return 4.0 * MM * -(-len(handles) // legend_columns(handles, width)) if handles else 0.0


def add_legend(figure: Figure, handles: Sequence[Artist], *, at: tuple[float, float] | None = None, width: float = 0.0) -> None:
    """One legend below all diagrams of a figure, or at most `width` wide with the middle of its foot `at` a place (inches):
    each label once, and literally, since a label may hold any word."""
    handles = list({str(handle.get_label()): handle for handle in handles}.values())
    if not handles:
        return
    sizes = figure.get_size_inches()
    legend = figure.legend(
        handles=handles, loc="outside lower center" if at is None else "lower center", borderaxespad=0.3,
        ncols=legend_columns(handles, width or float(sizes[0])), bbox_to_anchor=None if at is None else tuple(at / sizes))
    for text in legend.get_texts():
        text.set_parse_math("$" in text.get_text() and text.get_text().count("$") == 2)


def few_ticks(axes: Axes, x: int = 0, y: int = 0, *, grid: bool = False) -> None:
    """Round ticks, at most this many intervals on each axis (0 leaves an axis as it is), with a `grid` or without."""
    for axis, intervals in ((axes.xaxis, x), (axes.yaxis, y)):
        if intervals:
            axis.set_major_locator(MaxNLocator(intervals, steps=[1, 2, 2.5, 5, 10], min_n_ticks=2))
    if grid:
        axes.grid(visible=True)


def one_line(text: str, length: int) -> str:
    """`text` on one line of at most `length` characters."""
    flat = " ".join("".join(character if character.isprintable() else " " for character in text).split())
    return flat if len(flat) <= length else textwrap.shorten(flat, length, placeholder=" …") if " " in flat[:length] else (
        flat[: length - 1] + "…")


def readable(text: str) -> str:
    """A number as print has it: a minus sign in place of a hyphen, `× 10⁻⁵` in place of `e-5`."""
    raised = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    text = re.sub(r"e[+]?(-?)0*(\d+)", lambda match: " × 10" + "".join(match.groups()).translate(raised), text)
    return text.replace("-", "−")


def not_closer_than(axes: Axes, error: float = 0.0) -> None:
    """Let the vertical axis span three times the `error` of the numbers on each side at least, and a thousandth of them:
    smaller changes mean nothing."""
    low, high = axes.get_ylim()
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), 3.0 * error, 5e-4 * max(abs(low), abs(high)))
    axes.set_ylim(middle - half, middle + half)


def save(figure: Figure, path: pathlib.Path, dpi: float | None = None) -> pathlib.Path:
    """Write `figure` in the format of the file name's ending, complete or not at all.

    Raises WriteError (an OSError), ValueError (unknown format).
    """
    image_format = path.suffix[1:]
    if image_format not in FORMATS:
        raise ValueError(f"pictures can be {', '.join(FORMATS)}, not {image_format!r}")
    content = io.BytesIO()
    with warnings.catch_warnings():
        # A title in a script that the font lacks shows boxes; that is no reason to fail or to fill the terminal.
        warnings.filterwarnings("ignore", message=r"Glyph \d+", category=UserWarning)
        if image_format == "png":
            # savefig draws everything twice, the first time to find the layout, and packs transparency, which no picture has.
            figure.set_dpi(dpi or DPI)
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
            # Packed lightly, which takes half of the time.
            image.save(content, "PNG", dpi=(figure.dpi, figure.dpi), compress_level=1)
        else:
            figure.savefig(content, format=image_format, dpi=dpi or DPI, metadata=WITHOUT_DATES[image_format])
    write_bytes(path, content.getvalue())
    return path

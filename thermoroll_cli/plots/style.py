"""Sizes, look and file formats of all pictures."""

from __future__ import annotations

import contextlib
import io
import os
import pathlib
import re
import secrets
import textwrap
import warnings
from collections.abc import Iterator
from typing import Any

import matplotlib
import matplotlib.style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

STYLE = pathlib.Path(__file__).with_name("thermoroll.mplstyle")

MM = 1.0 / 25.4
"""A millimetre in inches."""
SINGLE, DOUBLE = 90.0 * MM, 180.0 * MM
"""Widths of pictures: one or two columns of a journal."""

DPI = 200
"""Dots per inch of PNG files, unless asked for otherwise."""

FORMATS = ("png", "svg", "pdf")
FILE_OPTIONS: dict[str, dict[str, Any]] = {
    "png": {"pil_kwargs": {"compress_level": 3}},
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
}
"""PNG packed lightly, which takes a third of the time; without dates, two files of the same picture are equal."""

BEFORE, AFTER = "#0072b2", "#d55e00"
"""Colours of the states without and with thermal deformation, and of the lower and the upper body: distinct for the
colour-blind and in print without colour."""
DASHED, DOTTED = (0, (4.0, 1.6)), (0, (1.0, 1.4))
NOT_CONVERGED = "not converged"
ALERT = "#c00000"

TITLE_LETTERS = 14
"""Letters of a title that an inch surely holds."""


@contextlib.contextmanager
def style() -> Iterator[None]:
    """The package's own style, whatever the user's matplotlibrc says: pictures look alike everywhere."""
    with matplotlib.style.context(["default", STYLE], after_reset=True):
        yield


def new_figure(width: float, height: float, layout: Any = "constrained") -> Figure:
    """An empty figure of `width` × `height` inches, made without pyplot."""
    return Figure(figsize=(width, height), layout=layout)


def add_headline(figure: Figure, title: str, converged: bool = True, note: str = "") -> None:
    """The title of the case above the picture with a `note`; in red, if the state is not steady, that it has not converged."""
    width = float(figure.get_size_inches()[0])
    room = int(width * TITLE_LETTERS) - len(note) - (0 if converged else 2 * len(NOT_CONVERGED))
    text = ", ".join(filter(None, (one_line(title, max(room, 8)), note)))
    if text or not converged:
        figure.suptitle(text or " ", x=0.01, ha="left", color="0.25", parse_math=False)
    if not converged:
        figure.text(0.99, 1.0 - 0.03 / float(figure.get_size_inches()[1]), NOT_CONVERGED.upper(), ha="right", va="top",
                    color=ALERT, weight="bold")


def add_legend(figure: FigureBase, handles: list[Artist], columns: int = 0) -> None:
    """One legend below all diagrams of a figure, each label once; literally, since a label may hold any word."""
    once = {str(handle.get_label()): handle for handle in handles}
    if not once:
        return
    legend = figure.legend(handles=list(once.values()), loc="outside lower center", ncols=columns or min(len(once), 4))
    for text in legend.get_texts():
        text.set_parse_math("$" in text.get_text() and text.get_text().count("$") == 2)


def few_ticks(axes: Axes, x: int = 0, y: int = 0) -> None:
    """Round ticks, at most this many intervals on each axis (0 leaves an axis as it is)."""
    for axis, intervals in ((axes.xaxis, x), (axes.yaxis, y)):
        if intervals:
            axis.set_major_locator(MaxNLocator(intervals, steps=[1, 2, 2.5, 5, 10], min_n_ticks=2))


def one_line(text: str, length: int) -> str:
    """`text` on one line of at most `length` characters."""
    flat = " ".join("".join(character if character.isprintable() else " " for character in text).split())
    return flat if len(flat) <= length else textwrap.shorten(flat, length, placeholder=" …") if " " in flat[:length] else (
        flat[: length - 1] + "…")


def readable(text: str) -> str:
    """A number as print has it: a minus sign in place of a hyphen, `× 10⁻⁵` in place of `e-5`."""
    raised = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    text = re.sub(r"e[+]?(-?)0*(\d+)", lambda found: " × 10" + "".join(found.groups()).translate(raised), text)
    return text.replace("-", "−")


def save(figure: Figure, path: pathlib.Path, dpi: float | None = None) -> pathlib.Path:
    """Write `figure` in the format of the file name's ending, complete or not at all.

    Raises OSError (the file cannot be written), ValueError (unknown format).
    """
    image_format = path.suffix[1:]
    if image_format not in FORMATS:
        raise ValueError(f"pictures can be {', '.join(FORMATS)}, not {image_format!r}")
    content = io.BytesIO()
    with warnings.catch_warnings():
        # A title in a script that the font lacks shows boxes; that is no reason to fail or to fill the terminal.
        warnings.filterwarnings("ignore", message=r"Glyph \d+", category=UserWarning)
        figure.savefig(content, format=image_format, dpi=dpi or DPI, **FILE_OPTIONS[image_format])
    temporary = path.with_name(f".thermoroll-{secrets.token_hex(8)}.part")
    try:
        temporary.write_bytes(content.getvalue())
        os.replace(temporary, path)
    except BaseException as cause:
        temporary.unlink(missing_ok=True)
        if isinstance(cause, OSError):
            raise OSError(cause.errno, f"cannot write {path}: {cause.strerror or cause}") from cause
        raise
    return path

"""A figure of explicit measures in inches, drawn without pyplot, and the way it gets into a file."""

from __future__ import annotations

import contextlib
import io
import os
import pathlib
import secrets
import textwrap
import warnings
from collections.abc import Iterator
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from thermoroll_cli.interruption import import_in_steps, safe_point

DPI = 200

FORMATS = ("png", "svg", "pdf")

ROUND = [1, 2, 2.5, 5, 10]
"""Steps of round numbers, up to powers of ten."""

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.direction": "out",
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 6),
    "svg.hashsalt": "thermoroll",
}

# What would make two files of the same picture differ.
_NO_DATES = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


@contextlib.contextmanager
def style() -> Iterator[None]:
    """The package's own style, whatever the user's matplotlibrc says: pictures look alike everywhere."""
    import_in_steps("numpy", "matplotlib")

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        # Of any type, since matplotlib's own stubs know its keys by heart and each version has others.
        parameters: Any = matplotlib.rcParams
        parameters.update(STYLE)
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` × `height` inches."""
    import_in_steps("matplotlib", "matplotlib.backends.backend_agg", "matplotlib.figure")

    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in inches. Automatic layouts draw every picture twice; these measures are known."""
    safe_point()
    total_width, total_height = figure.get_size_inches()
    rectangle = (left / total_width, bottom / total_height, width / total_width, height / total_height)
    return figure.add_axes(rectangle)


def add_text(figure: Figure, left: float, bottom: float, text: str, **options: Any) -> None:
    """Text at a place given in inches, taken literally: a case title may contain `$` or `_`."""
    total_width, total_height = figure.get_size_inches()
    figure.text(left / total_width, bottom / total_height, text, parse_math=False, **options)


def few_ticks(axes: Axes, x: int = 0, y: int = 0) -> None:
    """Round ticks, at most this many intervals on each axis (0 leaves an axis as it is). Few of them, also because they are
    what a picture spends most of its time on."""

    for axis, intervals in ((axes.xaxis, x), (axes.yaxis, y)):
        if intervals:
            axis.set_major_locator(MaxNLocator(intervals, steps=ROUND, min_n_ticks=2))


def one_line(text: str, length: int) -> str:
    """`text` on one line of at most `length` characters."""
    flat = " ".join("".join(character if character.isprintable() else " " for character in text).split())
    return flat if len(flat) <= length else flat[: length - 1].rstrip() + "…"


def even_lines(text: str, length: int) -> list[str]:
    """`text` on as few lines of at most `length` characters as there need be, and these about equally long."""
    count = len(textwrap.wrap(text, length))
    even = next(width for width in range(-(-len(text) // max(count, 1)), length + 1)
                if len(textwrap.wrap(text, width)) <= count or width == length)
    return textwrap.wrap(text, even)


def real_minus(text: str) -> str:
    """Numbers as the ticks have them, with a minus sign in place of a hyphen."""
    return text.replace("-", "−")


def save(figure: Figure, path: pathlib.Path) -> pathlib.Path:
    """Write `figure` in the format of the file name's ending, complete or not at all.

    Raises OSError (the file cannot be written), ValueError (unknown format).
    """
    image_format = path.suffix[1:]
    if image_format not in FORMATS:
        raise ValueError(f"pictures can be {', '.join(FORMATS)}, not {image_format!r}")
    safe_point()
    with warnings.catch_warnings():
        # A title in a script that the font lacks shows boxes; that is no reason to fail or to fill the terminal.
        warnings.filterwarnings("ignore", message=r"Glyph \d+", category=UserWarning)
        content = _content(figure, image_format)
    temporary = path.with_name(f".thermoroll-{secrets.token_hex(8)}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except BaseException as cause:
        temporary.unlink(missing_ok=True)
        if isinstance(cause, OSError):
            raise OSError(cause.errno, f"cannot write {path}: {cause.strerror or cause}") from cause
        raise
    return path


def _content(figure: Figure, image_format: str) -> bytes:
    """The file of this format that shows `figure`."""
    file = io.BytesIO()
    if image_format == "png":

        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        # Without opacity, since paper is white, and packed lightly: files a tenth smaller take several times as long.
        image = Image.frombuffer("RGBA", canvas.get_width_height(), canvas.buffer_rgba())
        image.convert("RGB").save(file, "png", compress_level=1, dpi=(figure.dpi, figure.dpi))
    else:
        figure.savefig(file, format=image_format, metadata=_NO_DATES[image_format])
    return file.getvalue()

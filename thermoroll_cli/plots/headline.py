"""The line above every picture: the case's title, and a warning where the result is not a steady state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from thermoroll_cli.plots.sheet import add_text, one_line
from thermoroll_cli.plots.view import RunView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHARACTERS_PER_INCH = 13


def add_headline(figure: Figure, view: RunView, addition: str = "") -> None:
    """Write the case's title at the top left, `addition` behind it, and at the top right whether to trust it."""
    width, height = (float(size) for size in figure.get_size_inches())
    warning = "" if view.converged else "NOT CONVERGED"
    room = int(width * CHARACTERS_PER_INCH) - len(addition) - 2 * len(warning)
    text = one_line(view.title, max(room, 8)) + addition
    add_text(figure, 0.1, height - 0.08, text, va="top", color="0.25")
    if warning:
        add_text(figure, width - 0.1, height - 0.08, warning, va="top", ha="right", color="#c00000", weight="bold")

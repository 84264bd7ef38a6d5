"""The line above every picture: the case's title, and a warning where the result is not a steady state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from thermoroll_cli.plots.sheet import add_text, one_line
from thermoroll_cli.plots.view import RunView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHARACTERS_PER_INCH = 12
"""A careful guess for text of unknown letters; measuring it would cost a drawing."""

NOTE: dict[str, Any] = {"color": "0.45", "fontsize": 7.0}
WARNING: dict[str, Any] = {"color": "#c00000", "weight": "bold"}


def add_headline(figure: Figure, view: RunView, addition: str = "", note: str = "") -> None:
    """Write the case's title at the top left with `addition` behind it, at the top right a `note` and, in red, whether
    the result is no steady state."""
    width, height = (float(size) for size in figure.get_size_inches())
    right = [(text, look) for text, look in ((note, NOTE), ("" if view.converged else "NOT CONVERGED", WARNING)) if text]
    taken = sum(len(text) + 3 for text, _ in right) + len(addition)
    text = one_line(view.title, max(int(width * CHARACTERS_PER_INCH) - taken, 8)) + addition
    add_text(figure, 0.1, height - 0.08, text, va="top", color="0.25")
    place = width - 0.1
    for text, look in reversed(right):
        add_text(figure, place, height - 0.08, text, va="top", ha="right", **look)
        place -= (len(text) + 2) / CHARACTERS_PER_INCH

"""The line above every picture: the case's title, and a warning where the result is not a steady state."""

from __future__ import annotations

from matplotlib.figure import Figure

from thermoroll_cli.plots.sheet import add_text, one_line
from thermoroll_cli.plots.view import RunView

CHARACTERS_PER_INCH = 12
"""A careful guess for text of unknown letters; measuring it would cost a drawing."""

WARNING = "NOT CONVERGED"
NOTE_ROOM = 0.15
"""Height of a second line, for a note."""


def add_headline(figure: Figure, view: RunView, addition: str = "", note: str = "") -> None:
    """Write the case's title at the top left with `addition` behind it and a `note` below, and at the top right, in
    red, whether the result is no steady state."""
    width, height = (float(size) for size in figure.get_size_inches())
    taken = len(addition) + (0 if view.converged else 2 * len(WARNING))
    text = one_line(view.title, max(int(width * CHARACTERS_PER_INCH) - taken, 8)) + addition
    add_text(figure, 0.1, height - 0.08, text, va="top", color="0.25")
    if note:
        add_text(figure, 0.1, height - 0.08 - NOTE_ROOM, note, va="top", color="0.45", fontsize=7.0)
    if not view.converged:
        add_text(figure, width - 0.1, height - 0.08, WARNING, va="top", ha="right", color="#c00000", weight="bold")

"""Columns of a table as one shape each. matplotlib places and draws every letter of a text by itself, and a sheet has two
thousand: they took longer than all maps."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.ft2font import FT2Font
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D

POINTS_PER_INCH = 72.0
OUTLINE_SIZE = 1000.0
"""Size in points at which outlines are taken: hinting moves them by a point there, which nobody sees at a hundredth of it."""
MIDDLE = 0.36
"""Height above the baseline, over the size, that stands in the middle of a line: half that of a capital letter."""


def width_of(text: str) -> float:
    """Width of a line of text in units of its size."""
    return float(sum(_letter(letter)[0] for letter in text))


class Column(Text):
    """Lines of text below each other, each `pitch` inches from the next, from the top left or right of it. A shape among
    pixels; text in files that can hold text."""

    def __init__(self, x: float, y: float, text: str, *, size: float, pitch: float, **options: Any) -> None:
        spacing = pitch * POINTS_PER_INCH / size
        super().__init__(x, y, text, va="top", fontsize=size, linespacing=spacing, parse_math=False, **options)
        self._size, self._spacing = size, spacing

    def draw(self, renderer: Any) -> None:
        """Draw it where it is on the figure."""
        figure = self.get_figure()
        if not isinstance(renderer, RendererAgg) or figure is None:
            super().draw(renderer)
            return
        shape = _shape(self.get_text().split("\n"), self.get_horizontalalignment() == "right", self._spacing)
        x, y = self.get_transform().transform(self.get_position())
        scale = self._size * figure.dpi / POINTS_PER_INCH
        letters = renderer.new_gc()
        letters.set_linewidth(0.0)
        renderer.draw_path(letters, shape, Affine2D().scale(scale).translate(x, y), (0.0, 0.0, 0.0, 1.0))
        letters.restore()


def _shape(lines: list[str], to_the_right: bool, pitch: float) -> Path:
    """The outlines of all letters in units of the size, from the upper left or right corner of the lines."""
    vertices, codes = [np.zeros((0, 2))], [np.zeros(0, dtype=np.uint8)]
    for number, line in enumerate(lines):
        letters = [_letter(letter) for letter in line]
        ends = np.cumsum([0.0, *(width for width, _, _ in letters)])
        starts = ends - ends[-1] if to_the_right else ends
        height = -(number + 0.5) * pitch - MIDDLE
        vertices += [outline + np.array([start, height]) for start, (_, outline, _) in zip(starts, letters, strict=False)]
        codes += [kinds for _, _, kinds in letters]
    return Path(np.concatenate(vertices), np.concatenate(codes))


@cache
def _letter(letter: str) -> tuple[float, Any, Any]:
    """How far a letter moves on, and its outline with its codes, in units of the size."""
    font = _font()
    glyph = font.load_char(ord(letter))
    outline, codes = font.get_path()
    return glyph.horiAdvance / 64.0 / OUTLINE_SIZE, np.asarray(outline).reshape(-1, 2) / OUTLINE_SIZE, codes


@cache
def _font() -> FT2Font:
    font = FT2Font(findfont(FontProperties(family="DejaVu Sans")))
    font.set_size(OUTLINE_SIZE, POINTS_PER_INCH)
    return font

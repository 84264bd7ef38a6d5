"""Ticks, numbers and labels drawn by ourselves stand where matplotlib's own do."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axis import Tick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.ndimage import distance_transform_edt

from tests.support import synthetic
from thermoroll_cli.plots import sheet
from thermoroll_cli.plots.maps import frame_of
from thermoroll_cli.plots.summary_sheet import summary_figure
from thermoroll_cli.plots.ticks import draw_sides, round_numbers
from thermoroll_cli.plots.view import view_of

NEAR = 3.0
"""Pixels, of 200 to an inch, by which a letter may stand elsewhere."""


def drawn(limits: tuple[tuple[float, float], tuple[float, float]], numbered: tuple[bool, bool], *, own: bool) -> Figure:
    """A small diagram with a grid and its labels where there are numbers."""
    figure = sheet.new_figure(3.0, 2.4)
    axes = sheet.add_axes(figure, 0.9, 0.7, 1.8, 1.4)
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])
    labels = "x (mm)" if numbered[0] else "", "pressure p" if numbered[1] else ""
    if own:
        draw_sides(axes, (4, 5), numbered=numbered, labels=labels, grid=True)
        return figure
    sheet.few_ticks(axes, 4, 5)
    axes.tick_params(labelbottom=numbered[0], labelleft=numbered[1])
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.grid(color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    return figure


@pytest.mark.parametrize("numbered", [(True, True), (False, True), (True, False)])
@pytest.mark.parametrize("limits", [((-0.2, 0.2), (0.0, 1130.0)), ((-4.4, 12.0), (-0.07, 0.31)), ((0.0, 1.0), (0.0, 7e8)),
                                    ((-3e-6, 3e-6), (-1.0, 1.0))])
def test_they_stand_where_matplotlib_has_them(limits: tuple[tuple[float, float], tuple[float, float]],
                                              numbered: tuple[bool, bool]) -> None:
    for darkest in (128, 250):  # letters and ticks; the grid as well
        ink = []
        with sheet.style():
            for own in (True, False):
                canvas = FigureCanvasAgg(drawn(limits, numbered, own=own))
                canvas.draw()
                ink.append(np.asarray(canvas.buffer_rgba())[:, :, 0] < darkest)
        for one, other in (ink, ink[::-1]):
            assert distance_transform_edt(~one)[other].max() <= NEAR


def test_a_short_side_has_two_numbers_and_no_others() -> None:
    with sheet.style():
        numbers, words, power = round_numbers(-0.21, 0.23, 1)
        assert numbers == pytest.approx([-0.2, 0.2]) and words == ["−0.2", "0.2"] and power == ""
        assert round_numbers(0.0, 1.0, 5)[0] == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
        assert round_numbers(0.0, 7e8, 3)[2] == "1e8"


def test_the_sheet_has_no_ticks_of_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    """They would take a third of its time."""
    monkeypatch.setattr(sheet, "DPI", 40)
    seen: list[Tick] = []
    monkeypatch.setattr(Tick, "draw", lambda tick, renderer: seen.append(tick))
    view = view_of(synthetic.result((16, 16)))
    with sheet.style():
        figure = summary_figure(view, frame_of(view, False), False)
        figure.canvas.draw()
    assert len(figure.axes) == 6 and seen == []

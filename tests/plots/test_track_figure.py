"""The picture of temperatures across the track: there where a body brings heat back, and only there."""

import numpy as np

from tests.support.scenes import solved
from tests.support.tracks import wheel_on_rail
from thermoroll_cli.plots.sheet import style
from thermoroll_cli.plots.track_figure import track_figure
from thermoroll_cli.plots.view import view_of


def test_shows_both_bodies_where_one_returns():
    result = solved(wheel_on_rail(16, bulk_lower=20.0, bulk_upper=20.0))
    with style():
        figure = track_figure(view_of(result), False)
    (axes,) = figure.axes
    lines = {line.get_label(): np.asarray(line.get_ydata(), dtype=float) for line in axes.lines}
    assert set(lines) == {"lower: hottest along rolling", "upper: hottest along rolling", "upper: as it enters",
                          "upper: mean of the surface"}
    s = result.coupled.scalars
    assert abs(lines["upper: hottest along rolling"].max() - s["surface_temperature_max_upper_K"]) < 2.0
    assert abs(lines["upper: as it enters"].max() - s["entry_temperature_max_upper_K"]) < 1.0
    assert lines["lower: hottest along rolling"].min() >= 20.0


def test_without_a_track_there_is_no_picture():
    with style():
        assert track_figure(view_of(solved(wheel_on_rail(16, upper_track=None))), False) is None

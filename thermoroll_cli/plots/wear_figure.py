"""How profiles wear: heights and line load across rolling, over the distance rolled."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from thermoroll_cli.arrays import Array
from thermoroll_cli.plots.style import DOUBLE, add_headline, new_figure, save, style

HEIGHT = 0.42
"""Height of a row of the picture over its width."""
TOUCHED = 1e-3
"""Over the largest line load: what lies outside places with more was never in contact."""


def draw_wear(
    path: pathlib.Path, title: str, y: Array, profiles: Mapping[str, Array], loads: Array, distances: Array, *,
    converged: bool = True,
) -> pathlib.Path:
    """Write the picture to `path`: worn `profiles` (m, by body, (snapshots, points)) at `y` (m), `loads` (N/m) and the
    `distances` (m) of the snapshots. Raises OSError."""
    worn = {body: heights for body, heights in profiles.items() if np.ptp(heights, axis=0).any()}
    touched = np.flatnonzero((loads > TOUCHED * loads.max()).any(axis=0))
    margin = max(1, len(touched) // 10)
    shown = slice(max(touched[0] - margin, 0), touched[-1] + margin + 1)
    kilometres = 1e-3 * distances
    colours = ScalarMappable(Normalize(kilometres[0], kilometres[-1]), matplotlib.colormaps["viridis"])
    with style():
        figure = new_figure(DOUBLE, HEIGHT * DOUBLE * (len(worn) + 1) / 2)
        axes = figure.subplots(len(worn) + 1, 1, sharex=True, squeeze=False)[:, 0]
        for axis, (body, heights) in zip(axes, worn.items(), strict=False):
            for distance, line in zip(kilometres, heights, strict=True):
                axis.plot(1e3 * y[shown], 1e6 * line[shown], color=colours.to_rgba(distance))
            axis.set_ylabel(f"height (µm),\n{body} body")
        for distance, line in zip(kilometres, loads, strict=True):
            axes[-1].plot(1e3 * y[shown], 1e-3 * line[shown], color=colours.to_rgba(distance))
        axes[-1].set(xlabel="y (mm)", ylabel="line load (N/mm)", ylim=(0.0, None))
        figure.colorbar(colours, ax=list(axes), label="distance rolled (km)")
        add_headline(figure, title, converged)
        return save(figure, path, None)

"""The surfaces that a contact over time rolls over, with its path."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.plots import style
from thermoroll_cli.problem.problem import BODIES

AROUND = 1.6
"""Half the width that is shown, in half-widths of the contact."""
ALONG, ACROSS = 1200, 160
"""Points of a map."""
SLENDER = 6.0
"""Ratio of the sides of a map above which its scales along and across differ."""


def surface_figure(history: Any) -> Figure | None:
    """A map of the heights of each body of a `History` that has some, over the distance and y (of a line contact over the
    distance alone), with the contact of the largest load at the beginning and at the end, and the path of its middle; None
    without any."""
    bodies = [(body, surface) for body, surface in zip(BODIES, history.surfaces, strict=True) if surface is not None]
    if not bodies:
        return None
    scales, distances = DerivedQuantities(history.largest).scales, history.clock(history.course.rows)[1]
    line, (a, b), centre = history.problem.line, (scales.semi_axis_x, scales.semi_axis_y), scales.centre
    starts = history.begins_at(float(distances[0]))
    length = 2.0 * AROUND * a + float(np.ptp(distances))
    true_to_scale = not line and length <= SLENDER * 2.0 * AROUND * b
    # Ticks, labels and the scale of heights take some fifth of the width.
    tall = 0.5 + min(0.74 * style.DOUBLE * 2.0 * AROUND * b / length, 3.0) if true_to_scale else 1.7
    picture = style.new_figure(style.DOUBLE, 0.5 + tall * len(bodies))
    axes_of = picture.subplots(len(bodies), 1, squeeze=False)[:, 0]
    for axes, (body, surface) in zip(axes_of, bodies, strict=True):
        first = starts[BODIES.index(body)][0]
        last = first + float(np.ptp(distances))
        along = np.linspace(first - AROUND * a, last + AROUND * a, ALONG + 1)
        across = np.array([-np.inf, np.inf]) if line else centre + AROUND * b * np.linspace(-1.0, 1.0, ACROSS + 1)
        heights = surface.over(along, across)
        if line:
            axes.plot(5e2 * (along[1:] + along[:-1]), 1e6 * heights[:, 0], color="0.3")
            axes.set(ylabel="height (µm)", xlim=(1e3 * along[0], 1e3 * along[-1]))
        else:
            image = axes.imshow(1e6 * heights.T, origin="lower", cmap="cividis",
                                aspect="equal" if true_to_scale else "auto",
                                extent=(1e3 * along[0], 1e3 * along[-1], 1e3 * across[0], 1e3 * across[-1]))
            picture.colorbar(image, ax=axes, label="height (µm)")
            for place in (first, last):
                axes.add_patch(Ellipse((1e3 * place, 1e3 * centre), 2e3 * a, 2e3 * b, fill=False, color="white", linewidth=1.0))
            axes.plot([1e3 * first, 1e3 * last], [1e3 * centre] * 2, color="white", linewidth=0.8, linestyle=style.DASHED)
            axes.set_ylabel("y (mm)")
        axes.set_xlabel("distance along the surface, as it comes into the contact (mm)")
        axes.set_title(f"{body} body")
    style.add_headline(picture, history.problem.title)
    return picture

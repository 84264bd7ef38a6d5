"""All pictures of one run."""

from __future__ import annotations

import pathlib

from matplotlib.figure import Figure

from thermoroll_cli.interruption import safe_point
from thermoroll_cli.plots.centreline import centreline_figure
from thermoroll_cli.plots.field_figures import heat_flux_figure, pressure_figure, temperature_figure, traction_figure
from thermoroll_cli.plots.maps import frame_of
from thermoroll_cli.plots.profile_figure import profile_figure
from thermoroll_cli.plots.sheet import FORMATS, save, style
from thermoroll_cli.plots.subsurface_figure import subsurface_figure
from thermoroll_cli.plots.summary_sheet import summary_figure
from thermoroll_cli.plots.track_figure import track_figure
from thermoroll_cli.plots.view import RunView, view_of
from thermoroll_cli.problem.result import Result

PICTURES = (
    "pressure",
    "profile",
    "traction",
    "heat_flux",
    "temperature",
    "centreline",
    "track",
    "summary",
    "subsurface_lower",
    "subsurface_upper",
)
"""What the pictures of a run are called: STEM_pressure.png, …"""


def write_figures(
    result: Result, stem: pathlib.Path, *, image_format: str = "png", normalised: bool = False
) -> list[pathlib.Path]:
    """Write the pictures of `result` as `STEM_pressure.png`, … (`PICTURES`), and return their paths. What was not computed, or
    is zero everywhere, has no picture.

    `normalised` draws the article's dimensionless quantities: p/p0, |τ|/p0, q α l/k (l = 1 mm), x/a0, y/b0.

    Raises ValueError for an unknown `image_format`, OSError where a file cannot be written.
    """
    if image_format not in FORMATS:
        raise ValueError(f"pictures can be {', '.join(FORMATS)}, not {image_format!r}")
    view = view_of(result)
    written = []
    with style():
        frame = frame_of(view, normalised)
        drawing = (
            lambda: pressure_figure(view, frame, normalised),
            lambda: profile_figure(view),
            lambda: traction_figure(view, frame, normalised),
            lambda: heat_flux_figure(view, frame, normalised),
            lambda: temperature_figure(view, frame, normalised),
            lambda: centreline_figure(view, normalised),
            lambda: track_figure(view, normalised),
            lambda: summary_figure(view, frame, normalised),
            lambda: _below(view, "lower", normalised),
            lambda: _below(view, "upper", normalised),
        )
        for name, draw in zip(PICTURES, drawing, strict=True):
            safe_point()
            figure = draw()
            if figure is not None:
                written.append(save(figure, stem.with_name(f"{stem.name}_{name}.{image_format}")))
    return written


def _below(view: RunView, body: str, normalised: bool) -> Figure | None:
    """The picture of what is below the surface of `body`, if the case asked for it."""
    if body not in view.subsurface:
        return None

    return subsurface_figure(view, body, normalised)

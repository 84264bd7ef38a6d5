"""Picture of the wear of a wheelset: outlines new and worn, and curves over the distance."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import ERROR
from thermoroll_cli.wheelset.curves import Points, curve
from thermoroll_cli.wheelset.wheelset_problem import SIDES

MANY = 1000.0
"""Distance in km from which on the axis counts thousands."""
LARGER = 10.0
"""Factor of the drawn depth."""
CURVES = {"depth_max_": "largest depth (µm)", "worn_mass_wheel_": "mass off a wheel (kg)",
          "flange_thickness_": "flange thickness (mm)", "flange_height_": "flange height (mm)",
          "flange_qR_": "qR (mm)", "conicity_3mm": "conicity at 3 mm",
          "T_gamma_N": "mean $T_γ$ (N)", "lateral_over_vertical_": "largest Y/Q"}  # fmt: skip
"""Columns that are drawn, and the labels of their axes."""
STYLES = {"left": "--", "right": "-"}


class _Drawn(Protocol):
    @property
    def case(self) -> Any: ...
    @property
    def rows(self) -> Sequence[Mapping[str, Any]]: ...
    @property
    def outlines(self) -> Mapping[str, tuple[Points, Points]]: ...
    @property
    def converged(self) -> bool: ...


def draw_service(path: pathlib.Path, done: _Drawn) -> pathlib.Path:
    """Write the picture to `path`. Raises OSError."""
    sides = [side for side in SIDES if f"wheel_{side}" in done.outlines]
    thousands = done.rows[-1]["distance_km"] >= MANY
    distance = [row["distance_km"] / (1000.0 if thousands else 1.0) for row in done.rows]
    with style.applied():
        figure = style.new_figure(style.DOUBLE, 1.25 * style.DOUBLE)
        axes = figure.subplots(6, 2)
        for body, column in (("wheel", 0), ("rail", 1)):
            grid = axes[0, 0].get_gridspec()
            for row in (0, 1):
                axes[row, column].remove()
            shown = figure.add_subplot(grid[0:2, column])
            for side in sides:
                new, worn = done.outlines[f"{body}_{side}"]
                y, z, exaggerated = _exaggerated(new, worn)
                shown.plot(y, z, color="0.5", linewidth=0.8)
                colour = style.BEFORE if body == "rail" else style.AFTER
                shown.plot(exaggerated[0], exaggerated[1], STYLES[side], color=colour)
            shown.set(xlabel="y to the field side (mm)", ylabel="z (mm)", title=f"{body}, depth ten times")
            shown.invert_yaxis()
        for axis, (prefix, label) in zip(axes[2:].flat, CURVES.items(), strict=True):
            for name in done.rows[0]:
                values = np.array([row.get(name, np.nan) for row in done.rows])
                if not name.startswith(prefix) or name.endswith(ERROR) or np.isnan(values).all():
                    continue
                side = next((side for side in sides if side in name), "right")
                colour = style.BEFORE if "rail" in name else style.AFTER
                axis.plot(distance, values, STYLES[side], color=colour)
                error = np.array([row.get(f"{name}{ERROR}", np.nan) for row in done.rows])
                axis.fill_between(distance, values - error, values + error, color=colour, alpha=0.15, linewidth=0.0)
            axis.set_ylabel(label)
            axis.grid(visible=True)
        for axis in axes[-1]:
            axis.set_xlabel("distance (1000 km)" if thousands else "distance (km)")
        style.add_headline(figure, done.case.settings.title, done.converged,
                           note="left side dashed; bands: estimated errors" if len(sides) > 1 else "")
        return style.save(figure, path, None)


def _exaggerated(new: Points, worn: Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """y and z of the new outline in mm, and (2, n) of it with the depth LARGER times."""
    samples = 1e3 * curve(new).samples[:2]
    if worn is new:
        return samples[0], samples[1], samples
    points = 1e3 * np.array(worn).T
    nearest = np.array([int(np.argmin(np.hypot(*(samples - point[:, None])))) for point in points.T])
    at = samples[:, nearest]
    return samples[0], samples[1], at + LARGER * (points - at)

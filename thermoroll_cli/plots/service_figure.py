"""Picture of the wear of a wheelset: outlines new and worn, and curves over the distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from thermoroll_cli.many_contacts.wheelset.curves import Points, curve
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES
from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import UNCERTAINTY

CURVES = {"depth_max_": "largest depth (µm)", "worn_mass_wheel_": "mass off a wheel (kg)",
          "flange_thickness_": "flange thickness (mm)", "flange_height_": "flange height (mm)",
          "flange_qR_": "qR (mm)", "conicity_3mm": "conicity at 3 mm",
          "T_gamma_N": "mean $T_γ$ (N)", "lateral_over_vertical_": "largest Y/Q"}  # fmt: skip
"""Columns that are drawn, and the labels of their axes."""
STYLES = {"left": "--", "right": "-"}


def service_figure(
    title: str, rows: Sequence[Mapping[str, Any]], outlines: Mapping[str, tuple[Points, Points]], *, converged: bool
) -> Figure:
    """New and worn `outlines` (m) by name, and columns of the `rows`, one per step."""
    sides = [side for side in SIDES if f"wheel_{side}" in outlines]
    thousands = rows[-1]["distance_km"] >= 1000.0
    distance = [row["distance_km"] / (1000.0 if thousands else 1.0) for row in rows]
    with style.applied():
        figure = style.new_figure(style.DOUBLE, 1.25 * style.DOUBLE)
        curves = np.reshape(list(CURVES), (-1, 2)).tolist()
        axes = figure.subplot_mosaic([["wheel", "rail"], ["wheel", "rail"], *curves])
        for body in ("wheel", "rail"):
            shown = axes[body]
            for side in sides:
                new, worn = outlines[f"{body}_{side}"]
                samples = exaggerated = 1e3 * curve(new).samples[:2]
                if worn is not new:  # with ten times the depth
                    points = 1e3 * np.array(worn).T
                    nearest = [int(np.argmin(np.hypot(*(samples - point[:, None])))) for point in points.T]
                    exaggerated = samples[:, nearest] + 10.0 * (points - samples[:, nearest])
                shown.plot(*samples, color="0.5", linewidth=0.8)
                shown.plot(*exaggerated, STYLES[side], color=style.BEFORE if body == "rail" else style.AFTER)
            shown.set(xlabel="y to the field side (mm)", ylabel="z (mm)", title=f"{body}, depth ten times")
            shown.invert_yaxis()
        for prefix, label in CURVES.items():
            axis = axes[prefix]
            for name in rows[0]:
                values = np.array([row.get(name, np.nan) for row in rows])
                if not name.startswith(prefix) or name.startswith(UNCERTAINTY) or np.isnan(values).all():
                    continue
                side = next((side for side in sides if side in name), "right")
                colour = style.BEFORE if "rail" in name else style.AFTER
                axis.plot(distance, values, STYLES[side], color=colour)
                error = np.array([row.get(f"{UNCERTAINTY}{name}", np.nan) for row in rows])
                axis.fill_between(distance, values - error, values + error, color=colour, alpha=0.15, linewidth=0.0)
            style.not_closer_than(axis)
            axis.set_ylabel(label)
            axis.grid(visible=True)
        for prefix in curves[-1]:
            axes[prefix].set_xlabel("distance (1000 km)" if thousands else "distance (km)")
        style.add_headline(figure, title, converged,
                           note="left side dashed; bands: estimated errors" if len(sides) > 1 else "")
        return figure

"""The surfaces that a contact over time rolls over, with its path."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from thermoroll_cli.plots import style
from thermoroll_cli.problem.result import Result

SLENDER = 6.0
"""Ratio of the sides of a map above which its scales along and across differ."""


def surface_figure(result: Result) -> Figure | None:
    """A map of the heights of each surface of a result over the distance and y, of a line contact over the distance alone, with
    the contact at the beginning and at the end, and the path of its middle; None without any."""
    maps = result.surfaces
    if not maps:
        return None
    # Ticks, labels and the scale of heights take some fifth of the width.
    shares = [(each.across[-1] - each.across[0]) / (each.along[-1] - each.along[0]) if len(each.across) else 0.0
              for each in maps.values()]
    true_to_scale = min(shares) >= 1.0 / SLENDER
    tall = 0.5 + min(0.74 * style.DOUBLE * max(shares), 3.0) if true_to_scale else 1.7
    picture = style.new_figure(style.DOUBLE, 0.5 + tall * len(maps))
    axes_of = picture.subplots(len(maps), 1, squeeze=False)[:, 0]
    for axes, (name, each) in zip(axes_of, maps.items(), strict=True):
        ends = 1e3 * each.along[0], 1e3 * each.along[-1]
        if not len(each.across):
            axes.plot(5e2 * (each.along[1:] + each.along[:-1]), 1e6 * each.heights[:, 0], color="0.3")
            axes.set(ylabel="height (µm)", xlim=ends)
        else:
            image = axes.imshow(1e6 * each.heights.T, origin="lower", cmap="cividis",
                                aspect="equal" if true_to_scale else "auto",
                                extent=(*ends, 1e3 * each.across[0], 1e3 * each.across[-1]))
            picture.colorbar(image, ax=axes, label="height (µm)")
            for place in each.path:
                axes.add_patch(Ellipse((1e3 * place, 1e3 * each.centre), 2e3 * each.half[0], 2e3 * each.half[1], fill=False,
                                       color="white", linewidth=1.0))
            axes.plot([1e3 * place for place in each.path], [1e3 * each.centre] * 2, color="white", linewidth=0.8,
                      linestyle=style.DASHED)
            axes.set_ylabel("y (mm)")
        axes.set_xlabel("distance along the surface, as it comes into the contact (mm)")
        axes.set_title(name if " " in name else f"{name} body")
    style.add_headline(picture, result.problem.title)
    return picture

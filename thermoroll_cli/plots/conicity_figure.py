"""Picture of an equivalent conicity: rolling radii over the shift, conicity over the amplitude, and which places of both
profiles touch."""

from __future__ import annotations

import pathlib

import numpy as np

from thermoroll_cli.many_contacts.wheelset.conicity import NEIGHBOURS, NOMINAL, Conicity
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, sign_of
from thermoroll_cli.plots import style

CLOSE = 0.09
"""Labels closer than this share of half of the width of a section touch."""


def draw_conicity(path: pathlib.Path, found: Conicity, title: str, dpi: float | None = None) -> pathlib.Path:
    """Write the picture to `path`. Raises OSError."""
    with style.applied():
        figure = style.new_figure(style.DOUBLE, 0.78 * style.DOUBLE)
        (radii, conicity), profiles = figure.subplots(2, 2)
        shown = np.abs(found.shifts) <= found.amplitudes.max() + 1e-9
        radii.plot(1e3 * found.shifts[shown], 1e3 * found.radius_difference[shown], color=style.AFTER)
        radii.set(xlabel="lateral shift (mm)", ylabel="difference of the rolling radii,\nright less left (mm)")
        amplitudes, values = 1e3 * found.amplitudes, found.conicity
        conicity.plot(amplitudes, values, color=style.AFTER)
        words: list[str] = []
        at, nominal = 1e3 * NOMINAL, found.conicity_at(NOMINAL)
        if np.isfinite(nominal):
            conicity.plot([at], [nominal], "o", color=style.BEFORE)
            words.append(f"{nominal:.3f} at {at:g} mm")
        if np.isfinite(found.nonlinearity):
            ends = [found.conicity_at(amplitude) for amplitude in NEIGHBOURS]
            conicity.plot([1e3 * amplitude for amplitude in NEIGHBOURS], ends, color=style.BEFORE, linestyle="--")
            words.append(f"nonlinearity {1e-3 * found.nonlinearity:.3f} per mm".replace("-", "−"))
        conicity.text(0.03, 0.96, "\n".join(words), transform=conicity.transAxes, va="top")
        high = np.nanmax(values, initial=0.1) if np.isfinite(values).any() else 1.0
        known = amplitudes[np.isfinite(values)] if np.isfinite(values).any() else amplitudes
        conicity.set(xlabel="amplitude (mm)", ylabel="equivalent conicity", ylim=(0.0, 1.35 * high),
                     xlim=(min(float(known.min()), at), max(float(known.max()), at)))
        for axes in (radii, conicity):
            style.few_ticks(axes, 6, 6, grid=True)
        # Each rail, the wheel of a centred wheelset 12 mm above it, and a line between the places that touch at each whole
        # millimetre; some 10 mm beside these, from 22 mm above to 24 mm below the top of the rail.
        for axes, side in zip(profiles, SIDES, strict=True):
            problem, sign = found.problem, sign_of(side)
            rail, wheel = 1e3 * problem.rails[side].samples[:2], 1e3 * problem.wheels[side].samples[:2]
            drop = 1e3 * problem.wheels[side].radius + 12.0
            axes.plot(sign * wheel[0], wheel[1] - drop, color=style.AFTER, label="wheel")
            axes.plot(sign * rail[0], rail[1], color=style.BEFORE, label="rail")
            most = 1e3 * float(found.amplitudes.max())
            touched, heads = list[float](), dict[int, tuple[float, float]]()
            for whole in range(-int(most), int(most) + 1) if found.contacts else ():
                k = int(np.argmin(np.abs(1e3 * found.shifts - whole)))
                if abs(1e3 * found.shifts[k] - whole) > 0.1:
                    continue
                touching = found.contacts[k][side]
                foot = sign * 1e3 * touching.y, 1e3 * touching.z
                head = sign * 1e3 * touching.y_wheel, 1e3 * touching.radius - drop
                axes.plot(*zip(foot, head, strict=True), color="0.35", linewidth=0.6, marker=".", markersize=2.5,
                          label="places that touch at each mm of the shift" if not touched else "_")
                if whole % 2 == 0:
                    heads[whole] = head
                touched += [foot[0], head[0]]
            touched = touched or [sign * float(rail[0][int(np.argmin(rail[1]))])]
            middle = 0.5 * (min(touched) + max(touched))
            half = max(0.5 * (max(touched) - min(touched)) + 10.0, 23.0)
            named: list[float] = []
            for whole, head in sorted(heads.items(), key=lambda each: abs(each[0])):
                # Places that lie close together share the label of the smallest shift.
                if all(abs(head[0] - other) > CLOSE * half for other in named):
                    axes.annotate(f"{whole}".replace("-", "−"), head, ha="center", va="bottom", fontsize=6, xytext=(0.0, 2.0),
                                  textcoords="offset points")
                    named.append(head[0])
            axes.set(xlim=(middle - half, middle + half), ylim=(24.0, -22.0), aspect="equal", xlabel="y (mm)", ylabel="z (mm)",
                     title=f"{side} wheel")
            style.few_ticks(axes, 5, 5, grid=True)
        style.add_headline(figure, title, note="equivalent conicity after EN 15302")
        style.add_legend(figure, profiles[0].get_legend_handles_labels()[0])
        return style.save(figure, path, dpi)

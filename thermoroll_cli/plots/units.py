"""Which unit a picture uses: the usual one of the field where numbers stay readable, else the nearest SI multiple."""

from __future__ import annotations

import math
from dataclasses import dataclass

from thermoroll_cli.plots.view import RunView
from thermoroll_cli.problem.names import MULTIPLES, QUANTITIES, Quantity

READABLE = (0.03, 1e4)
"""The usual unit is kept while the largest number lies in here."""


LONGEST_ASPECT = 6.0
"""Maps whose sides differ by more are drawn with this ratio instead of the true one."""


@dataclass(frozen=True)
class Scale:
    """`factor` turns SI values into what is drawn, `unit` names it ("" for dimensionless)."""

    factor: float
    unit: str

    def label(self, text: str) -> str:
        return f"{text} ({self.unit})" if self.unit else text


PRESSURE, TRACTION, HEAT_FLUX, TEMPERATURE = (
    QUANTITIES[name] for name in ("pressure", "traction", "heat_flux", "temperature")
)


def scale_of(quantity: Quantity, view: RunView, maximum: float, normalised: bool) -> tuple[Scale, str]:
    """The scale and the axis label for values up to `maximum` (SI); `normalised` by the divisors of the article."""
    divisor = {"Pa": view.peak_pressure, "W/m2": view.heat_scale}.get(quantity.unit, math.nan) if normalised else math.nan
    if math.isfinite(divisor) and divisor > 0.0:
        return Scale(1.0 / divisor, ""), f"{quantity.words} {quantity.normalised}"
    scale = unit_for(quantity.unit, maximum)
    return scale, scale.label(f"{quantity.words} {quantity.symbol}")


def unit_for(unit: str, maximum: float) -> Scale:
    """The multiple of the SI `unit` in which `maximum` reads well."""
    usual, ladder = MULTIPLES[unit]
    name, size = ladder[usual]
    if maximum > 0.0 and math.isfinite(maximum) and not READABLE[0] <= maximum / size < READABLE[1]:
        name, size = next((step for step in reversed(ladder) if maximum >= step[1]), ladder[0])
    return Scale(1.0 / size, name)


def axes_scales(view: RunView, normalised: bool) -> tuple[tuple[float, str], tuple[float, str]]:
    """Factor and label of the x and the y axis: each over its Hertz semi-axis, or in one unit for both unless the
    domain is so long that it cannot be drawn to scale anyway."""
    if normalised and math.isfinite(view.semi_axes[0]):
        return (1.0 / view.semi_axes[0], "x/a₀"), (1.0 / view.semi_axes[1], "y/b₀")
    sizes = [max(float(abs(axis).max()) for axis in axes) for axes in zip(*((s.x, s.y) for s in view.states), strict=True)]
    if max(sizes) < LONGEST_ASPECT * min(sizes):
        sizes = [max(sizes)] * 2
    x, y = (unit_for("m", size) for size in sizes)
    return (x.factor, x.label("x")), (y.factor, y.label("y"))

"""Temperature by heat that changes linearly along x within its element: what makes temperatures second order.

Fast material remembers heat like 1/sqrt(distance). With the heat flux taken as constant in each element the temperature then
errs by h^(3/2) q', which is most of its error where heat is made in a slip zone a few elements long. A slope in each element,
q(ξ) = q + s ξ with ξ from −½ to ½, removes it: its response is that of `temperature_table` with the cell average

    g(x; τ, 1) = ∫ G(x − ξ) dξ      replaced by      m(x; τ) = ∫ ξ G(x − ξ) dξ = x g + 2τ² [G(x + ½) − G(x − ½)],

G being the Gaussian exp(−x²/4τ²)/(2τ sqrt(π)) to which heat released at once has spread.
"""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.halfspace.thermal import (
    SERIES_FROM,
    SLOW,
    between_corners,
    cell_average,
    extent,
    mirrored,
    offsets,
    stationary_temperature,
    time_integral,
)


def temperature_slope_table(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Surface temperature around one element heated with q = s ξ, ξ = x'/dx from −½ to ½, in s dx/k.

    Arguments, shape (2nx−1, 2ny−1) and errors raised are those of `temperature_table`."""
    x, y = offsets(nx, ny, aspect, peclet_x, peclet_y)
    if math.hypot(peclet_x, peclet_y) * extent(x, y, aspect) < SLOW:
        table = _stationary_slope(x, y, aspect)
    else:
        integral = time_integral(x, y, aspect, peclet_x, peclet_y, power=0, depths=np.zeros(1), along=_cell_moment)
        table = 2.0 / math.sqrt(math.pi) * integral[0]
    return mirrored(table, ny)


def slopes(flux: Array) -> Array:
    """Change of the element averages `flux` ≥ 0, (nx, ny), along x from one end of each element to the other, same unit.

    Central differences; one-sided at the ends of the heated rows, so that nothing leaks out of them. Nowhere in an element may
    the flux be negative."""
    heated = flux > 0.0
    step = np.diff(flux, axis=0)
    inside = heated[1:] & heated[:-1]
    total, count = np.zeros_like(flux), np.zeros_like(flux)
    for side in (np.s_[1:], np.s_[:-1]):
        total[side] += step * inside
        count[side] += inside
    return np.asarray(np.clip(total / np.maximum(count, 1.0), -2.0 * flux, 2.0 * flux))


def _cell_moment(centres: Array, length: float, speed: float, tau: Array) -> Array:
    """m at each time and offset, for elements of unit `length`; shape (times, offsets)."""
    t = tau[:, None]
    x = centres - speed * t**2
    right, left = (x + 0.5) / (2.0 * t), (x - 0.5) / (2.0 * t)
    if tau[0] < SERIES_FROM * length:
        ends = np.exp(-(right**2)) - np.exp(-(left**2))
        return np.asarray(x * cell_average(centres, length, speed, tau) + t / math.sqrt(math.pi) * ends)
    # Taylor series: −G'/12 − G'''/480 − G⁽⁵⁾/53760, with the derivatives of exp(−a²) as Hermite polynomials.
    a, h2 = x / (2.0 * t), 1.0 / (4.0 * t**2)
    a2 = a * a
    series = 1.0 / 12.0 + h2 * ((4.0 * a2 - 6.0) / 480.0 + h2 * ((16.0 * a2 - 80.0) * a2 + 60.0) / 53760.0)
    return np.asarray(series * 2.0 * a * np.exp(-a2) / (4.0 * t**2 * math.sqrt(math.pi)))


def _stationary_slope(x: Array, y: Array, aspect: float) -> Array:
    """ξ/2πr integrated over the element: x times its plain integral, less that of (x − ξ)/r = ∂r/∂x."""

    def corner(xi: Array, eta: Array) -> Array:
        return 0.5 * (eta * np.hypot(xi, eta) + xi**2 * np.arcsinh(eta / np.abs(xi)))

    plain = x[:, None] * stationary_temperature(x, y, aspect)
    return np.asarray(plain - between_corners(corner, x, y, aspect) / (2.0 * math.pi))

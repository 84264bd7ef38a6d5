"""Steady surface temperature of moving point and rectangular heat sources on an insulated half-space.

Jaeger (1942); Carslaw & Jaeger, Conduction of Heat in Solids (1959), Sec. 10.7. The material moves with speed V towards
+x under a source at rest; conductivity k, diffusivity κ, v = V/κ. A point source of power Q gives

    T = Q/(2πkr) exp[−v(r − x)/2],    r² = x² + y² + z².

A uniform flux q over |x| < l, |y| < b is an integral over the time since the heat was released, τ = sqrt(κ·time), and
separates into one factor per direction:

    T(x, y) = (2/√π)(q/k) ∫_0^∞ g(x − vτ², l; τ) g(y, b; τ) dτ,
    g(x, l; τ) = ½ {erf[(x + l)/2τ] − erf[(x − l)/2τ]}.

Maxima in dimensionless form θ = kT/(ql) depend on the Péclet number P = V l/κ only. Circles and ellipses are in
`moving_ellipse`, fast and slow limits and handbook formulas in `source_limits`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.special import erf, erfc, wrightomega

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class TemperatureMaximum:
    """Maximum `temperature` rise (K) under a source and its position `x` (m) on the line y = 0."""

    temperature: float
    x: float


def point_source_temperature(
    x: ArrayLike, y: ArrayLike, z: ArrayLike, power: float, conductivity: float, diffusivity: float, speed: float
) -> FloatArray:
    """Temperature rise of a point source on the surface z = 0 (equation in the module's docstring), infinite at r = 0.

    Parameters: positions (m, broadcast), power Q (W), conductivity (W/mK), diffusivity (m²/s), speed V ≥ 0 (m/s).

    Raises ValueError for a conductivity or diffusivity that is not positive, or a negative speed.
    """
    check_medium(conductivity, diffusivity, speed)
    px, py, pz = np.asarray(x, dtype=float), np.asarray(y, dtype=float), np.asarray(z, dtype=float)
    across = py**2 + pz**2
    r = np.sqrt(px**2 + across)
    # r − x cancels downstream, where r + x does not
    behind = np.where(px > 0.0, across / np.where(px > 0.0, r + px, 1.0), r - px)
    with np.errstate(divide="ignore"):
        return np.asarray(power / (2.0 * math.pi * conductivity * r) * np.exp(-0.5 * speed / diffusivity * behind))


def rectangle_temperature(
    x: ArrayLike,
    y: ArrayLike,
    half_length: float,
    half_width: float,
    flux: float,
    conductivity: float,
    diffusivity: float,
    speed: float,
) -> FloatArray:
    """Surface temperature rise of a uniform rectangular source, to about 1e-14 of the maximum, for any speed ≥ 0.

    The integral over τ in the module's docstring by the trapezoidal rule in u = ln(sτ) + sτ, s ∝ v, which resolves both
    the logarithmic scales of τ → 0 and the fronts of width 1/v that pass the point.

    Parameters: positions on the surface (m, broadcast), half-length l along x and half-width b (m), flux q (W/m²),
    conductivity (W/mK), diffusivity (m²/s), speed V (m/s).

    Raises ValueError for sizes, conductivity or diffusivity that are not positive, or a negative speed.
    """
    check_medium(conductivity, diffusivity, speed)
    check_positive(half_length=half_length, half_width=half_width)
    px, py = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    flat_x, flat_y = px.ravel(), py.ravel()
    result = np.zeros(flat_x.shape)
    v = speed / diffusivity
    reach = float(max(half_length, half_width, np.abs(flat_x).max(initial=0.0), np.abs(flat_y).max(initial=0.0)))
    tau, weight = _time_nodes(min(half_length, half_width), reach, flat_x.max(initial=0.0) + half_length, v)
    chunk = max(1, 200_000 // tau.size)
    for start in range(0, flat_x.size, chunk):
        part = slice(start, start + chunk)
        along = _box(flat_x[part, None] - v * tau**2, half_length, tau)
        result[part] = (along * _box(flat_y[part, None], half_width, tau)) @ weight
    return np.asarray(2.0 / math.sqrt(math.pi) * flux / conductivity * result.reshape(px.shape))


def rectangle_maximum(
    half_length: float, half_width: float, flux: float, conductivity: float, diffusivity: float, speed: float
) -> TemperatureMaximum:
    """Maximum temperature rise under a uniform rectangular source, on y = 0 between its centre and trailing edge.

    Parameters and errors as for `rectangle_temperature`. A square at P = 1, 10, 100: θ = 0.91143, 0.47269, 0.15856.
    """

    def temperature(x: float) -> float:
        return float(rectangle_temperature(x, 0.0, half_length, half_width, flux, conductivity, diffusivity, speed))

    return find_maximum(temperature, 0.0, half_length)


def find_maximum(temperature: Callable[[float], float], low: float, high: float) -> TemperatureMaximum:
    """Maximum of a function with one peak in [low, high].

    The position is good to about 1e-7 of the interval (the peak is flat), the value to rounding.
    """
    found = minimize_scalar(lambda x: -temperature(x), bounds=(low, high), method="bounded",
                            options={"xatol": 1e-8 * (high - low)})
    return TemperatureMaximum(-float(found.fun), float(found.x))


def check_medium(conductivity: float, diffusivity: float, speed: float) -> None:
    """Raise ValueError unless conductivity and diffusivity are positive and the speed is not negative."""
    check_positive(conductivity=conductivity, diffusivity=diffusivity)
    if not (math.isfinite(speed) and speed >= 0.0):
        raise ValueError(f"speed must be finite and not negative (material moves towards +x), got {speed!r}")


def check_positive(**values: float) -> None:
    """Raise ValueError naming the first value that is not positive and finite."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, got {value!r}")


def _time_nodes(smallest: float, reach: float, front: float, v: float) -> tuple[FloatArray, FloatArray]:
    """Nodes τ and weights of ∫_0^∞ dτ for features between the lengths `smallest` and `reach`; the source has passed
    a point `front` behind its leading edge when vτ² = front."""
    step, fronts_per_node, margin = 0.125, 0.5, 6.3
    s = max(v * step / fronts_per_node, 1e-25 / reach)
    # ends: the integrand is bounded below and falls as τ^-2, or with the last front, above
    first, last = 1e-17 * smallest, 1e17 * reach
    if v > 0.0:
        last = min(last, (margin + math.sqrt(margin**2 + v * max(front, 0.0))) / v)
    # fast sources: nothing is left after the last front, so there is no point in going below it
    first = min(first, 1e-17 * last)
    u = np.arange(math.log(s * first) + s * first, math.log(s * last) + s * last + step, step)
    tau = wrightomega(u) / s
    return tau, step * tau / (1.0 + s * tau)


def _box(x: FloatArray, half_length: float, tau: FloatArray) -> FloatArray:
    """g(x, l; τ) of the module's docstring, with full relative accuracy ahead of and behind the box."""
    # far outside both error functions are ±1: mirror to x ≥ 0 and subtract their complements
    x = np.abs(x)
    near, far = (x - half_length) / (2.0 * tau), (x + half_length) / (2.0 * tau)
    return np.asarray(0.5 * np.where(near > 0.5, erfc(near) - erfc(far), erf(far) - erf(near)))

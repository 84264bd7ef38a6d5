"""Limits and handbook formulas for the temperature under moving heat sources.

Fast sources (P = V l/κ → ∞): heat flows straight down; with the effusivity β = sqrt(kρc) = k/sqrt(κ)

    T(x) = 1/(β sqrt(πV)) ∫_{−l}^x q(x') / sqrt(x − x') dx' = (q0/β) sqrt(l/V) Θ(x/l)

    uniform band        Θ(X) = (2/√π) sqrt(1 + X)                                     max 2 sqrt(2/π) = 1.59577 at X = 1
    semi-elliptic band  Θ(X) = (2√2/(3√π)) [(1 − X) K(m) + 2X E(m)], m = (1 + X)/2    max 1.23462 at X = 0.65223

(inside; behind the source `band_temperature` has the continuation). Static circles (P = 0) are closed forms in q0 a/k.
Tian & Kennedy (J. Tribol. 116, 1994) interpolate between both limits.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipe, ellipk, ellipkm1

from thermoroll_cli.exact.moving_sources import TemperatureMaximum, check_medium, check_positive

BandShape = Literal["uniform", "hertz"]

BAND_MAXIMUM = {"uniform": (2.0 * math.sqrt(2.0 / math.pi), 1.0), "hertz": (1.2346198310, 0.6522295)}
"""Maximum Θ of fast bands, and where (x/l). Flux "hertz" is q0 sqrt(1 − x²/l²)."""

STATIC_CIRCLE_MAXIMUM = {"uniform": 1.0, "hertz": math.pi / 4.0, "paraboloid": 2.0 / 3.0}
"""k T_max/(q0 a) of circular sources at rest, q0 the peak flux."""

STATIC_CIRCLE_MEAN = {"uniform": 8.0 / (3.0 * math.pi), "hertz": 3.0 * math.pi / 16.0}
"""k T_mean/(q0 a) of circular sources at rest, mean over the area, q0 the peak flux."""

_TIAN_KENNEDY = {"square": (2.0, 1.011), "circle": (2.0, 1.273), "hertz": (2.32, 1.234)}


def effusivity(conductivity: float, diffusivity: float) -> float:
    """β = sqrt(kρc) = k/sqrt(κ) in W s^½/(m² K)."""
    return conductivity / math.sqrt(diffusivity)


def band_temperature(
    x: ArrayLike,
    half_length: float,
    peak_flux: float,
    conductivity: float,
    diffusivity: float,
    speed: float,
    shape: BandShape = "uniform",
) -> NDArray[np.float64]:
    """Surface temperature rise of a fast band source, zero ahead of it (equations in the module's docstring).

    Shape of x. Its maximum is 1 % above that of a circle or square at P = 100 and 10 % above at P = 10.

    Parameters: positions (m), half-length l (m), peak flux q0 (W/m²), conductivity (W/mK), diffusivity (m²/s), speed
    V > 0 (m/s), `shape` of the flux along x.

    Raises ValueError for constants that are not positive or an unknown shape.
    """
    check_medium(conductivity, diffusivity, speed)
    check_positive(half_length=half_length, speed=speed)
    position = np.asarray(x, dtype=float) / half_length
    if shape == "uniform":
        theta = np.sqrt(np.maximum(position + 1.0, 0.0)) - np.sqrt(np.maximum(position - 1.0, 0.0))
        theta = 2.0 / math.sqrt(math.pi) * theta
    elif shape == "hertz":
        inside = np.clip(position, -1.0, 1.0)
        # ellipkm1 takes the complement (1 − X)/2 and stays exact at the trailing edge, where K is infinite but 0·K = 0
        complement = np.maximum(0.5 * (1.0 - inside), np.finfo(float).tiny)
        under = 2.0 * complement * ellipkm1(complement) + 2.0 * inside * ellipe(0.5 * (1.0 + inside))
        far = np.maximum(position, 1.0 + np.finfo(float).eps)
        m = 2.0 / (far + 1.0)
        behind = np.sqrt(0.5 * (far + 1.0)) * (2.0 * far * ellipe(m) - 2.0 * (far - 1.0) * ellipk(m))
        theta = 2.0 * math.sqrt(2.0) / (3.0 * math.sqrt(math.pi)) * np.where(position > 1.0, behind, under)
    else:
        raise ValueError(f"shape must be 'uniform' or 'hertz', got {shape!r}")
    scale = peak_flux / effusivity(conductivity, diffusivity) * math.sqrt(half_length / speed)
    return np.asarray(np.where(position > -1.0, scale * theta, 0.0))


def band_maximum(
    half_length: float,
    peak_flux: float,
    conductivity: float,
    diffusivity: float,
    speed: float,
    shape: BandShape = "uniform",
) -> TemperatureMaximum:
    """Maximum temperature rise of a fast band source; parameters and errors as for `band_temperature`."""
    check_medium(conductivity, diffusivity, speed)
    check_positive(half_length=half_length, speed=speed)
    if shape not in BAND_MAXIMUM:
        raise ValueError(f"shape must be 'uniform' or 'hertz', got {shape!r}")
    theta, position = BAND_MAXIMUM[shape]
    scale = peak_flux / effusivity(conductivity, diffusivity) * math.sqrt(half_length / speed)
    return TemperatureMaximum(temperature=scale * theta, x=position * half_length)


def tian_kennedy_maximum(
    half_length: float,
    mean_flux: float,
    conductivity: float,
    diffusivity: float,
    speed: float,
    shape: Literal["square", "circle", "hertz"] = "square",
) -> float:
    """Tian & Kennedy's closed form of the maximum temperature rise, C q̄ l / (k sqrt(π(D + Pe))) (K).

    C, D = 2, 1.011 (square of half-side l); 2, 1.273 (circle of radius l); 2.32, 1.234 (Hertz-shaped circle). Within
    2.7 % of the exact maxima. Mind two conventions: the flux is the **mean** flux (2/3 of the peak for "hertz"), and
    their Péclet number is **Pe = V l/(2κ)**, half of P = V l/κ used in this program. It is computed here from V, so no
    one has to convert.

    Raises ValueError for constants that are not positive, a negative speed, or an unknown shape.
    """
    check_medium(conductivity, diffusivity, speed)
    check_positive(half_length=half_length)
    if shape not in _TIAN_KENNEDY:
        raise ValueError(f"shape must be one of {', '.join(_TIAN_KENNEDY)}, got {shape!r}")
    numerator, offset = _TIAN_KENNEDY[shape]
    their_peclet = 0.5 * speed * half_length / diffusivity
    return numerator * mean_flux * half_length / (conductivity * math.sqrt(math.pi * (offset + their_peclet)))

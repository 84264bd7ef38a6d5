"""Temperature of a rotating cylinder with a heat source on its rim and convection: the exact series in Bessel functions.

A solid cylinder of radius R turns under a band source that stays where it is; its surface moves with speed V towards +x along
the rim, and loses heat by convection h. With q(x) cos λy spread over the rim (x = Rφ, λ = 0: a plane problem),

    V ∂T/∂x = κ ∇²T,      k ∂T/∂r + hT = q  at r = R,
    T = cos λy Σ_n q_n e^{inx/R} / [k s_n I_n'(s_n R)/I_n(s_n R) + h],      s_n² = λ² + i n V/(κR)

(Carslaw & Jaeger, 7.4; DesRuisseaux & Zerkle 1970 for the plane case). A source q₀ √(1 − x²/l²) on |x| < l has
q_n = q₀ l/(2R) · J₁(z)/z, z = nl/R. The series includes the heat of all earlier revolutions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ive, j1

from thermoroll_cli.arrays import Array
from thermoroll_cli.exact.hertz import check_positive

HIGHEST_WAVE = 2000.0
"""n l/R up to which the series is summed; its terms fall like n⁻²."""
ASYMPTOTE_FROM = 60.0
"""|n² + z²|^½ from which I_n'/I_n = p/z − z/2p² (Debye, p² = n² + z²) is good to 1e-4 of the term after it."""


def rim_temperature(
    x: ArrayLike, half_length: float, peak_flux: float, radius: float, conductivity: float, diffusivity: float, speed: float,
    convection: float, wavenumber: float = 0.0
) -> Array:
    """Temperature of the rim at y = 0 above that of the surroundings in K, at places x (m) along it; shape of x.

    Parameters: half-length l (m) and peak flux q₀ (W/m²) of the source, radius R (m), conductivity (W/mK), diffusivity (m²/s),
    speed V > 0 (m/s), convection h > 0 (W/m²K), wavenumber λ along the axis (1/m).

    Raises ValueError for values that are not positive (`wavenumber` may be 0), and for a source longer than the rim.
    """
    check_positive(half_length=half_length, radius=radius, conductivity=conductivity, diffusivity=diffusivity, speed=speed,
                   convection=convection)
    if half_length > np.pi * radius:
        raise ValueError(f"half_length = {half_length} is more than half of the rim")
    n = np.arange(1, int(np.ceil(HIGHEST_WAVE * radius / half_length)) + 1)
    z = n * (half_length / radius)
    source = peak_flux * half_length / (2.0 * radius) * j1(z) / z
    response = 1.0 / (conductivity * _slope(n, wavenumber, radius, speed / (diffusivity * radius)) + convection)
    mean = conductivity * float(_slope(np.zeros(1), wavenumber, radius, 0.0)[0].real) + convection
    steady = peak_flux * half_length / (4.0 * radius) / mean
    x = np.asarray(x, dtype=float)
    waves = np.exp(1j / radius * x.reshape(-1, 1) * n)
    return np.asarray((steady + 2.0 * (waves @ (source * response)).real).reshape(x.shape))


def _slope(n: NDArray[np.generic], wavenumber: float, radius: float, turning: float) -> NDArray[np.complex128]:
    """s I_n'(sR)/I_n(sR) in 1/m, s² = λ² + i n `turning`."""
    order = np.asarray(n, dtype=float)
    z = np.sqrt(wavenumber**2 + 1j * order * turning) * radius
    p = np.sqrt(order**2 + z**2)
    slope = p - z**2 / (2.0 * np.where(p == 0.0, 1.0, p) ** 2)
    few = np.abs(p) < ASYMPTOTE_FROM
    # z I_n'/I_n = z I_{n+1}/I_n + n
    slope[few] = order[few] + z[few] * ive(order[few] + 1.0, z[few]) / ive(order[few], z[few])
    return np.asarray(slope / radius)

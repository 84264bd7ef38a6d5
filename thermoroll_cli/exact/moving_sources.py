"""Steady surface temperature under moving heat sources: rectangles, ellipses and fast bands on an insulated half-space,
a band on a cooled cylinder that turns.

The material moves with speed V towards +x under a source at rest; conductivity k, diffusivity κ, v = V/κ.

**Rectangles** (Jaeger 1942; Carslaw & Jaeger, Conduction of Heat in Solids, 1959, Sec. 10.7). A point source of
power Q gives

    T = Q/(2πkr) exp[−v(r − x)/2],    r² = x² + y² + z².

A uniform flux q over |x| < l, |y| < b is an integral over the time since the heat was released, τ = sqrt(κ·time), and
separates into one factor per direction:

    T(x, y) = (2/√π)(q/k) ∫_0^∞ g(x − vτ², l; τ) g(y, b; τ) dτ,
    g(x, l; τ) = ½ {erf[(x + l)/2τ] − erf[(x − l)/2τ]}.

Maxima in dimensionless form θ = kT/(ql) depend on the Péclet number P = V l/κ only.

**Circles and ellipses.** The flux is q(x, y) = q0 (1 − x²/a² − y²/b²)^n: uniform (n = 0), Hertz-shaped (n = ½) or a paraboloid
(n = 1); q0 is the peak. In polar coordinates around a point inside the source the 1/r of the point source cancels:

    T = 1/(2πk) ∫_0^2π ∫_0^R(φ) q(x − r cos φ, y − r sin φ) exp[−v r (1 − cos φ)/2] dr dφ,

R(φ) the distance to the rim. Along a ray, 1 − x²/a² − y²/b² = Q (R − r)(r + R'), Q = cos²φ/a² + sin²φ/b². Both
integrals use the double-exponential rule, which does not mind the rim's root or the thin plume around φ = 0. Averages over a
circle are single integrals over the wavenumber, with Carlson's R_F for the direction:

    T̄ = 1/(π² k ∫∫w) ∫_0^∞ q^(z/a) w^(z/a) R_F(0, z² − iPz, z² + iPz) z dz/a,     P = V a/κ.

**Limits.** Under fast sources (P → ∞) heat flows straight down; with the effusivity β = sqrt(kρc) = k/sqrt(κ)

    T(x) = 1/(β sqrt(πV)) ∫_{−l}^x q(x') / sqrt(x − x') dx' = (q0/β) sqrt(l/V) Θ(x/l)

    uniform band        Θ(X) = (2/√π) sqrt(1 + X)                                     max 2 sqrt(2/π) = 1.59577 at X = 1
    semi-elliptic band  Θ(X) = (2√2/(3√π)) [(1 − X) K(m) + 2X E(m)], m = (1 + X)/2    max 1.23462 at X = 0.65223

(inside; behind the source `band_temperature` has the continuation). Static circles (P = 0) are closed forms in q0 a/k.
Tian & Kennedy (J. Tribol. 116, 1994) interpolate between both limits.

**Rotating cylinder.** A solid cylinder of radius R turns under a band source that stays where it is; its surface moves with
speed V towards +x along the rim, and loses heat by convection h. With q(x) cos λy spread over the rim (x = Rφ, λ = 0: a plane
problem),

    V ∂T/∂x = κ ∇²T,      k ∂T/∂r + hT = q  at r = R,
    T = cos λy Σ_n q_n e^{inx/R} / [k s_n I_n'(s_n R)/I_n(s_n R) + h],      s_n² = λ² + i n V/(κR)

(Carslaw & Jaeger, 7.4; DesRuisseaux & Zerkle 1970 for the plane case). A source q₀ √(1 − x²/l²) on |x| < l has
q_n = q₀ l/(2R) · J₁(z)/z, z = nl/R. The series includes the heat of all earlier revolutions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.special import ellipe, ellipk, ellipkm1, elliprf, erf, erfc, ive, j1, jv, wrightomega

from thermoroll_cli.exact.hertz import check_positive
from thermoroll_cli.tools.arrays import Array


class TemperatureMaximum(NamedTuple):
    """Maximum `temperature` rise (K) under a source and its position `x` (m) on the line y = 0."""

    temperature: float
    x: float


def rectangle_temperature(
    x: ArrayLike, y: ArrayLike, half_length: float, half_width: float, flux: float, conductivity: float, diffusivity: float,
    speed: float
) -> Array:
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
    minimum = minimize_scalar(lambda x: -temperature(x), bounds=(low, high), method="bounded",
                            options={"xatol": 1e-8 * (high - low)})
    return TemperatureMaximum(-float(minimum.fun), float(minimum.x))


def check_medium(conductivity: float, diffusivity: float, speed: float) -> None:
    """Raise ValueError unless conductivity and diffusivity are positive and the speed is not negative."""
    check_positive(conductivity=conductivity, diffusivity=diffusivity)
    if not (math.isfinite(speed) and speed >= 0.0):
        raise ValueError(f"speed must be finite and not negative (material moves towards +x), got {speed!r}")


def _time_nodes(smallest: float, reach: float, front: float, v: float) -> tuple[Array, Array]:
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


def _box(x: Array, half_length: float, tau: Array) -> Array:
    """g(x, l; τ) of the module's docstring, with full relative accuracy ahead of and behind the box."""
    # far outside both error functions are ±1: mirror to x ≥ 0 and subtract their complements
    x = np.abs(x)
    near, far = (x - half_length) / (2.0 * tau), (x + half_length) / (2.0 * tau)
    return np.asarray(0.5 * np.where(near > 0.5, erfc(near) - erfc(far), erf(far) - erf(near)))


Shape = Literal["uniform", "hertz", "paraboloid"]

EXPONENTS: dict[str, float] = {"uniform": 0.0, "hertz": 0.5, "paraboloid": 1.0}
"""Exponent n of each flux shape; its mean flux is q0/(n + 1)."""


def ellipse_temperature(
    x: float, y: float, semi_axis_x: float, semi_axis_y: float, peak_flux: float, conductivity: float, diffusivity: float,
    speed: float, shape: Shape = "uniform"
) -> float:
    """Surface temperature rise at one point inside an elliptic source (K).

    Relative accuracy about 1e-12 for V a/κ ≤ 1e4 and moderate aspect ratios.

    Parameters: position (m), semi-axes a along x and b (m), peak flux q0 (W/m²), conductivity (W/mK), diffusivity
    (m²/s), speed V (m/s), `shape` of the flux.

    Raises ValueError for sizes, conductivity or diffusivity that are not positive, a negative speed, an unknown shape,
    or a point that is not inside the source.
    """
    check_medium(conductivity, diffusivity, speed)
    check_positive(semi_axis_x=semi_axis_x, semi_axis_y=semi_axis_y)
    exponent = _exponent(shape)
    inside = 1.0 - (x / semi_axis_x) ** 2 - (y / semi_axis_y) ** 2
    if not inside > 0.0:
        raise ValueError(f"the point ({x!r}, {y!r}) is not inside the source")
    sigma, rest, d_sigma = _double_exponential()
    # four quadrants apart: the rays turn quickly at φ = 0 and, close to the rim, around π/2
    total = 0.0
    for sign in (1.0, -1.0):
        if sign < 0.0 and y == 0.0:
            total *= 2.0
            break
        for first, span in ((0.0, 0.5 * math.pi), (math.pi, -0.5 * math.pi)):
            phi = first + span * sigma
            cos, sin = np.cos(phi), sign * np.sin(phi)
            one_minus_cos = 2.0 * np.sin(0.5 * phi) ** 2
            q = (cos / semi_axis_x) ** 2 + (sin / semi_axis_y) ** 2
            lean = x * cos / semi_axis_x**2 + y * sin / semi_axis_y**2
            root = np.sqrt(lean**2 + q * inside)
            # distances to the rim ahead and behind; of lean ± root one cancels, their product does not
            ahead = np.where(lean > 0.0, root + lean, inside * q / (root - np.minimum(lean, 0.0))) / q
            behind = inside / (q * ahead)
            decay = 0.5 * speed / diffusivity * one_minus_cos * ahead
            if exponent == 0.0:
                ray = ahead * np.where(decay > 0.0, -np.expm1(-decay) / np.where(decay > 0.0, decay, 1.0), 1.0)
            else:
                profile = (q * ahead)[:, None] * rest * (ahead[:, None] * sigma + behind[:, None])
                ray = ahead * ((profile**exponent * np.exp(-decay[:, None] * sigma)) @ d_sigma)
            total += abs(span) * float(ray @ d_sigma)
    return peak_flux / (2.0 * math.pi * conductivity) * total


def ellipse_maximum(
    semi_axis_x: float, semi_axis_y: float, peak_flux: float, conductivity: float, diffusivity: float, speed: float,
    shape: Shape = "uniform"
) -> TemperatureMaximum:
    """Maximum temperature rise under an elliptic source, on y = 0 between its centre and trailing edge.

    Parameters and errors as for `ellipse_temperature`. Circle at P = V a/κ = 1, 10, 100: kT/(q0 a) = 0.82876, 0.45270,
    0.15775 (uniform), 0.66146, 0.35350, 0.12226 (Hertz-shaped).
    """

    def temperature(x: float) -> float:
        return ellipse_temperature(x, 0.0, semi_axis_x, semi_axis_y, peak_flux, conductivity, diffusivity, speed, shape)

    return find_maximum(temperature, 0.0, semi_axis_x)


def circle_mean_temperature(
    radius: float, peak_flux: float, conductivity: float, diffusivity: float, speed: float, shape: Shape = "uniform",
    weight: Shape = "uniform"
) -> float:
    """Mean temperature rise over a circular source, weighted with the profile `weight` (K).

    `weight="uniform"` is the mean over the area; `weight=shape` is weighted with the flux, the mean that decides how
    two bodies share the heat. Relative accuracy about 1e-10 for V a/κ ≤ 100, 1e-6 at 1e4.

    Parameters and errors as for `ellipse_temperature`.
    """
    check_medium(conductivity, diffusivity, speed)
    check_positive(radius=radius)
    n, m = _exponent(shape), _exponent(weight)
    peclet = speed * radius / diffusivity
    # Gauss panels of half a period of the Bessel product, graded towards z = 0 and P; z = s² removes the root there
    panel = 0.5 * math.pi
    end = 4000.0 * panel
    node, gauss = leggauss(8)
    edges = np.sqrt(np.concatenate(([0.0], panel * 2.0 ** np.arange(-60.0, 0.0), np.arange(1.0, 4001.0) * panel)))
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (node + 1.0)).ravel()
    ds = (half * gauss).ravel()
    z = s**2
    shift = 1j * peclet * z
    direction = elliprf(0.0, z**2 - shift, z**2 + shift).real
    integral = float(np.sum(_disc_transform(n, z) * _disc_transform(m, z) * direction * z * 2.0 * s * ds))
    # beyond the end the product of Bessel functions is cos((n − m)π/2)/(πz) on average, R_F = π/(2z)
    power = n + m + 2.0
    integral += _disc_factor(n) * _disc_factor(m) * 0.5 * math.cos(0.5 * math.pi * (n - m)) / (power * end**power)
    weight_volume = math.pi / (m + 1.0)
    return peak_flux * radius / (conductivity * math.pi**2 * weight_volume) * integral


def _exponent(shape: str) -> float:
    if shape not in EXPONENTS:
        raise ValueError(f"shape must be one of {', '.join(EXPONENTS)}, got {shape!r}")
    return EXPONENTS[shape]


def _disc_factor(n: float) -> float:
    return 2.0 * math.pi * 2.0**n * math.gamma(n + 1.0)


def _disc_transform(n: float, z: Array) -> Array:
    """Fourier transform of (1 − r²)^n over the unit disc at wavenumber z: 2π 2^n Γ(n+1) J_{n+1}(z)/z^(n+1)."""
    return np.asarray(_disc_factor(n) * jv(n + 1.0, z) / z ** (n + 1.0))


def _double_exponential() -> tuple[Array, Array, Array]:
    """Nodes σ, 1 − σ and weights of ∫_0^1 dσ, σ = 1/(1 + exp(−π sinh t)) with equal steps in t."""
    step = 1.0 / 32.0
    t = np.arange(-3.4, 3.4 + 0.5 * step, step)
    swing = math.pi * np.sinh(t)
    sigma, rest = 1.0 / (1.0 + np.exp(-swing)), 1.0 / (1.0 + np.exp(swing))
    return sigma, rest, step * math.pi * np.cosh(t) * sigma * rest


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
    x: ArrayLike, half_length: float, peak_flux: float, conductivity: float, diffusivity: float, speed: float,
    shape: BandShape = "uniform"
) -> Array:
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


def tian_kennedy_maximum(
    half_length: float, mean_flux: float, conductivity: float, diffusivity: float, speed: float, shape: Literal["square",
    "circle", "hertz"] = "square"
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
    response = 1.0 / (conductivity * _rim_slope(n, wavenumber, radius, speed / (diffusivity * radius)) + convection)
    mean = conductivity * float(_rim_slope(np.zeros(1), wavenumber, radius, 0.0)[0].real) + convection
    steady = peak_flux * half_length / (4.0 * radius) / mean
    x = np.asarray(x, dtype=float)
    waves = np.exp(1j / radius * x.reshape(-1, 1) * n)
    return np.asarray((steady + 2.0 * (waves @ (source * response)).real).reshape(x.shape))


def _rim_slope(n: NDArray[np.generic], wavenumber: float, radius: float, turning: float) -> NDArray[np.complex128]:
    """s I_n'(sR)/I_n(sR) in 1/m, s² = λ² + i n `turning`."""
    order = np.asarray(n, dtype=float)
    z = np.sqrt(wavenumber**2 + 1j * order * turning) * radius
    p = np.sqrt(order**2 + z**2)
    slope = p - z**2 / (2.0 * np.where(p == 0.0, 1.0, p) ** 2)
    few = np.abs(p) < ASYMPTOTE_FROM
    # z I_n'/I_n = z I_{n+1}/I_n + n
    slope[few] = order[few] + z[few] * ive(order[few] + 1.0, z[few]) / ive(order[few], z[few])
    return np.asarray(slope / radius)

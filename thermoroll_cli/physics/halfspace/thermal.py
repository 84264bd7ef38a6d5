"""Influence coefficients of a moving heat source: temperature and thermal expansion of the surface.

One element of dx × dy carries a uniform heat flux q; the half-space material moves past it, its surface otherwise
insulated, and the state is steady (Eqs. 19-20). Lengths are in dx, ``aspect`` b = dy/dx, and the velocity of the
material is the Péclet number P = V dx/κ, with a component along x and one along y. A table holds the response at the
offsets X, bY = observation point − centre of the source element, X = −(nx−1)..nx−1 and Y = −(ny−1)..ny−1.

In time τ² = κt/dx² the heat released at once spreads to a Gaussian and drifts by Pτ². Both axes separate:

    g(x; τ, ℓ) = ½[erf((x + ℓ/2)/2τ) − erf((x − ℓ/2)/2τ)],   gx = g(X − Px τ²; τ, 1),   gy = g(bY − Py τ²; τ, b)
    T(P) = (2/√π) ∫ gx gy dτ                                                       in q dx/k
    U(P) = (4/π) ∫ sech³y Φ(P sech²y) dy,   Φ(P) = 2 ∫ τ gx gy dτ,   y from 0 to ∞   in (1+ν) α q dx²/k

T is Green's function of the moving medium. U comes from û = 2/(w'(w + w')), w'² = w² + i(m Px + n Py), by the Laplace
transform 1/(w'(w + w')) = ∫ exp(−(w'² − w²)t) erfc(w√t) dt and erfc(w√t) = (2/π) ∫ exp(−w²t/cos²θ) dθ over a
quarter turn, with t = τ²cos²θ and cos θ = sech y: both components of P are scaled alike, so any direction is allowed.
At every node of a quadrature over τ the table is an outer product of two vectors, and a table a matrix product.

Heat that changes linearly along x within its element (`temperature_slope_table`) makes temperatures second order.
On fast material the temperature falls like 1/sqrt(distance) behind a source. With a constant heat flux in each element its
error is h^(3/2) q', which is most of the error if the slip zone is a few elements long. A slope in each element,
q(ξ) = q + s ξ with ξ from −½ to ½, removes it. Its response is that of `temperature_table` with the cell average

    g(x; τ, 1) = ∫ G(x − ξ) dξ      replaced by      m(x; τ) = ∫ ξ G(x − ξ) dξ = x g + 2τ² [G(x + ½) − G(x − ½)],

with the Gaussian G = exp(−x²/4τ²)/(2τ sqrt(π)) to which heat released at once has spread.

With b = inf the element is a strip without ends, of a line contact, and the grid has one element across: gy is 1. T is then
e^{Px/2} K₀(|P x|/2)/π of a moving line source, integrated over the element, and U, up to a constant, (2/P)(e^{−z} I₀(z) − 1) at
z = |P x|/2 upstream and 0 downstream, since Φ = e^{P min(x, 0)}/P. Material at rest has no steady state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from scipy.special import erf, i0e, i1e, wrightomega

from thermoroll_cli.tools.arrays import Array

Spread = Callable[[Array, float, float | Array, Array], Array]
"""Share of the heat of an element that is at each centre, (times, centres), from centres, element length, speed (or one of each
time) and times."""

GAUSSIAN_CUTOFF = 4.6
"""Gaussians are cut off where their argument reaches this: erfc(4.6) = 8e-11."""
LOG_STEP = 0.21
"""Step of the τ rule relative to τ, for small τ."""
DRIFT_STEP = 0.63
"""Step of the τ rule times P, for large τ; the integrand is a Gaussian in Pτ of unit width there."""
ANGLE_STEP = 0.3
"""Step of the rule over y in U."""
SERIES_FROM = 3.0
"""τ in element widths from which the cell average of a Gaussian is a series; its first missing term is below 3e-11."""
STILL_INSIDE = 1e-3
"""Heat that varies within its element changes temperatures before it leaves: the τ rule starts earlier by this factor."""
NODES_TOGETHER = 48
"""τ nodes taken together: few enough for narrow windows, enough for an efficient matrix product."""
STATIONARY_PECLET = 1e-11
"""P × table size below which the limit P → 0 is exact to rounding."""


def temperature_table(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Surface temperature around one heated element on moving material, Eq. 19 in real space.

    ``nx``, ``ny`` are the elements of the grid per side, ``aspect`` is dy/dx, ``peclet_x`` and ``peclet_y`` are
    V dx/κ of the material's velocity (either sign). Returns the temperature in q dx/k, shape (2nx−1, 2ny−1), with the
    source at [nx−1, ny−1]. Good to 1e-10 of the coefficient of the element on itself. Raises ValueError for an empty
    grid, an aspect that is not positive, or a Péclet number that is not finite.
    """
    x, y = offsets(nx, ny, aspect, peclet_x, peclet_y)
    return mirrored(temperature_at(x, y, aspect, peclet_x, peclet_y), ny)


def temperature_at(x: Array, y: Array, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Temperature in q dx/k at the grid of ascending offsets x × y from the source, in dx; shape (len(x), len(y)).

    Offsets need not be whole elements, but must not lie on the lines through the edges of the source element.
    """
    return temperature_at_depths(x, y, np.zeros(1), aspect, peclet_x, peclet_y)[0]


def temperature_at_depths(x: Array, y: Array, depths: Array, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Temperature in q dx/k at the depths z ≥ 0 (in dx) below the offsets x × y; shape (len(depths), len(x), len(y)).

    The integrand of T over time gains the factor exp(−z²/4τ²)."""
    if math.hypot(peclet_x, peclet_y) * extent(x, y, aspect) < STATIONARY_PECLET:
        check_moving(aspect)
        return np.stack([stationary_temperature(x, y, aspect, float(z)) for z in depths])
    return 2.0 / math.sqrt(math.pi) * time_integral(x, y, aspect, peclet_x, peclet_y, power=0, depths=depths)


def displacement_table(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Thermal expansion of the surface (outward) around one heated element on moving material, Eq. 20 in real space.

    Arguments, shape and errors raised are those of `temperature_table`; units (1+ν) α q dx²/k. Good to 3e-8 of the
    coefficient of the element on itself. Without motion the displacement is defined up to a constant: P = 0 gives
    −ln(r)/2π integrated over the element. With P → 0 the table rises without bound, by −b ln(P)/2π everywhere.
    """
    x, y = offsets(nx, ny, aspect, peclet_x, peclet_y)
    peclet, size = math.hypot(peclet_x, peclet_y), extent(x, y, aspect)
    if math.isinf(aspect):
        return _strip_displacement(x, peclet_x)
    if peclet * size < STATIONARY_PECLET:
        table = stationary_displacement(x, y, aspect)
        if peclet > 0.0:
            table += aspect / (2.0 * math.pi) * (math.log(16.0) - math.log(peclet) - np.euler_gamma - 1.0)
        return mirrored(table, ny)
    nodes, weights, last = angle_rule(peclet * size)
    table = np.zeros((len(x), len(y)))
    phi = table
    for node, weight in zip(nodes[: last + 1], weights, strict=False):
        slowing = 1.0 / math.cosh(node) ** 2
        phi = advected_expansion(x, y, aspect, peclet_x * slowing, peclet_y * slowing)
        table += weight * phi
    # Beyond the last node Φ has reached its limit for slow motion and grows by −(b/2π) ln(sech²y).
    growth = aspect / math.pi * (np.log(np.cosh(nodes[last + 1 :])) - math.log(math.cosh(nodes[last])))
    table += weights[last + 1 :].sum() * phi + weights[last + 1 :] @ growth
    return mirrored(table, ny)


def _strip_displacement(x: Array, peclet: float) -> Array:
    """U of a strip at the offsets x (n,), (n, 1), up to a constant: ∫ e^{−z} I₀(z) dz = z e^{−z} (I₀ + I₁)."""
    if abs(peclet) * float(np.abs(x).max()) < STATIONARY_PECLET:
        check_moving(math.inf)

    def integral(upstream: Array) -> Array:
        """∫ u dx from the source to a place so far upstream."""
        z = 0.5 * abs(peclet) * np.maximum(upstream, 0.0)
        return np.asarray((2.0 / peclet) ** 2 * z * (i0e(z) + i1e(z) - 1.0))

    upstream = -math.copysign(1.0, peclet) * x
    return np.asarray(integral(upstream + 0.5) - integral(upstream - 0.5))[:, None]


def check_moving(aspect: float) -> None:
    """Raises ValueError for a strip on material at rest."""
    if math.isinf(aspect):
        raise ValueError("material at rest has no steady temperature below a source without ends")


def angle_rule(reach: float, step: float = ANGLE_STEP) -> tuple[Array, Array, int]:
    """Trapezoidal rule for U = Σ weight Φ(P sech²y), given P × table size.

    Returns nodes y, weights (4/π) sech³y dy, and the index of the last node at which Φ differs from its limit for
    slow motion by more than the accuracy of U. The integrand is smooth and even in y, so that the rule converges
    exponentially.
    """
    last = math.ceil(max(4.2, 0.5 * math.log(4.0 * reach) + 2.3) / step)
    count = last + math.ceil(12.0 / step)
    nodes = np.linspace(0.0, step * (count - 1), count)
    weights = 4.0 / math.pi * step / np.cosh(nodes) ** 3
    weights[0] *= 0.5
    return nodes, weights, last


def advected_expansion(x: Array, y: Array, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Φ(P) = 2 ∫ τ gx gy dτ: exp(P·r/2) K0(|P|r/2)/2π integrated over the element, at offsets x × y.

    For P → 0 it is −ln(r)/2π plus (b/2π)(ln(4/P) − γ). Raises ValueError at P = 0, where it is infinite.
    """
    peclet = math.hypot(peclet_x, peclet_y)
    if peclet == 0.0:
        raise ValueError("Φ is infinite without motion")
    if peclet * extent(x, y, aspect) < STATIONARY_PECLET:
        constant = aspect / (2.0 * math.pi) * (math.log(4.0) - math.log(peclet) - np.euler_gamma)
        return stationary_displacement(x, y, aspect) + constant
    return 2.0 * time_integral(x, y, aspect, peclet_x, peclet_y, power=1, depths=np.zeros(1))[0]


def stationary_temperature(x: Array, y: Array, aspect: float, z: float = 0.0) -> Array:
    """1/2π√(r² + z²) integrated over the element, in q dx/k: [ξ asinh(η/√(ξ²+z²)) + η asinh(ξ/√(η²+z²)) − z atan(ξη/zρ)]/2π
    between the corners ξ, η, with ρ² = ξ² + η² + z²."""

    def corner(xi: Array, eta: Array) -> Array:
        surface = xi * np.arcsinh(eta / np.hypot(xi, z)) + eta * np.arcsinh(xi / np.hypot(eta, z))
        return surface - z * np.arctan(xi * eta / (z * np.sqrt(xi**2 + eta**2 + z * z))) if z else surface

    return between_corners(corner, x, y, aspect) / (2.0 * math.pi)


def stationary_displacement(x: Array, y: Array, aspect: float) -> Array:
    """−ln(r)/2π integrated over the element: −[ξη(ln r − 3/2) + ½ξ² atan(η/ξ) + ½η² atan(ξ/η)]/2π at the corners."""

    def corner(xi: Array, eta: Array) -> Array:
        log_r = 0.5 * np.log(xi**2 + eta**2)
        return xi * eta * (log_r - 1.5) + 0.5 * xi**2 * np.arctan(eta / xi) + 0.5 * eta**2 * np.arctan(xi / eta)

    return between_corners(corner, x, y, aspect) / (-2.0 * math.pi)


def between_corners(corner: Callable[[Array, Array], Array], x: Array, y: Array, aspect: float) -> Array:
    """Differences of a primitive function of both coordinates over the element, at every offset."""
    left, right = (x - 0.5)[:, None], (x + 0.5)[:, None]
    low, high = (y - 0.5 * aspect)[None, :], (y + 0.5 * aspect)[None, :]
    return corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low)


def offsets(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float) -> tuple[Array, Array]:
    """Offsets at which a table has to be computed: half the lateral ones if the response is even in y."""
    if nx < 1 or ny < 1:
        raise ValueError(f"a grid needs at least one element per side, not {nx} × {ny}")
    if not (aspect > 0.0 and (math.isfinite(aspect) or ny == 1)):
        raise ValueError(f"the aspect dy/dx must be positive, and finite for more than one element across, not {aspect}")
    if not (math.isfinite(peclet_x) and math.isfinite(peclet_y)):
        raise ValueError(f"Péclet numbers must be finite, not {peclet_x}, {peclet_y}")
    if math.isinf(aspect):
        return np.arange(1.0 - nx, nx), np.zeros(1)
    first = 0 if peclet_y == 0.0 else 1 - ny
    return np.arange(1.0 - nx, nx), aspect * np.arange(float(first), ny)


def mirrored(table: Array, ny: int) -> Array:
    return table if table.shape[1] == 2 * ny - 1 else np.concatenate((table[:, :0:-1], table), axis=1)


def extent(x: Array, y: Array, aspect: float) -> float:
    along = float(np.abs(x).max()) + 0.5
    return along if math.isinf(aspect) else max(along, float(np.abs(y).max()) + 0.5 * aspect)


def time_integral(
    x: Array, y: Array, aspect: float, peclet_x: float, peclet_y: float, power: int, depths: Array, along: Spread | None = None
) -> Array:
    """∫ τ^power exp(−z²/4τ²) gx gy dτ over all times, at offsets x × y and at each of `depths`; `along` replaces gx."""
    reaches = float(np.abs(x).max()) + 0.5, float(np.abs(y).max()) + 0.5 * aspect
    tau, weights = _time_rule(reaches, aspect, (peclet_x, peclet_y), power, depths, 1.0 if along is None else STILL_INSIDE)
    table = np.zeros((len(weights), len(x), len(y)))
    for some, rows, columns in windows(x, y, aspect, np.full(len(tau), peclet_x), np.full(len(tau), peclet_y), tau):
        lengthwise = (along or cell_average)(x[rows], 1.0, peclet_x, tau[some])
        across = cell_average(y[columns], aspect, peclet_y, tau[some])
        for layer, arrived in zip(table, weights[:, some], strict=True):
            layer[rows, columns] += lengthwise.T @ (across * arrived[:, None])
    return table


def windows(
    x: Array, y: Array, aspect: float, along: Array, across: Array, tau: Array, together: int = NODES_TOGETHER
) -> Iterator[tuple[slice, slice, slice]]:
    """Groups of `together` of the rising nodes `tau`, and the offsets along x and y that their Gaussians reach at the speeds
    `along` and `across` of each."""
    breaks = np.searchsorted(tau, [SERIES_FROM, SERIES_FROM * aspect])
    starts = np.unique(np.concatenate((np.arange(0, len(tau), together), breaks, [len(tau)])))
    for some in map(slice, starts[:-1], starts[1:]):
        yield some, _window(x, 1.0, along[some], tau[some]), _window(y, aspect, across[some], tau[some])


def _time_rule(
    reaches: tuple[float, float], aspect: float, peclets: tuple[float, float], power: int, depths: Array, onset: float
) -> tuple[Array, Array]:
    """Nodes, and for each depth weights, of ∫ τ^power exp(−z²/4τ²) … dτ: trapezoidal in u = ln(sτ) + sτ, with s ∝ P.

    Steps are proportional to τ while the Gaussians only spread, and constant once they drift.
    """
    sides = [(length, abs(speed), reach) for length, speed, reach in zip((1.0, aspect), peclets, reaches, strict=True)
             if math.isfinite(length)]
    first = onset * min(float(first_time(length, speed)) for length, speed, _ in sides)
    last = min(float(last_time(reach, speed)) for _, speed, reach in sides)
    scale = math.hypot(*peclets) * LOG_STEP / DRIFT_STEP
    start = math.log(scale * first) + scale * first
    stop = math.log(scale * last) + scale * last
    # Before `first` the heat has not left its element: those nodes differ only by their weights.
    early = math.ceil((36.0 + max(start, 0.0)) / LOG_STEP)
    count = early + max(math.ceil((stop - start) / LOG_STEP), 0) + 1
    scaled = wrightomega(start + LOG_STEP * (np.arange(count) - early))
    tau = scaled / scale
    # At the surface the factor is 1. Deep below it squares would overflow, and the weight is zero.
    arrived = np.exp(-np.minimum(0.5 * depths[:, None] / tau, 30.0) ** 2)
    weights = arrived * (LOG_STEP * tau ** (1 + power) / (1.0 + scaled))
    weights[:, early] = weights[:, : early + 1].sum(axis=1)
    return tau[early:], weights[:, early:]


def first_time(length: float, speed: float | Array) -> Array:
    """τ up to which heat has not left its element of a `length`, at speeds ≥ 0 of its material."""
    return np.asarray(length / (2.0 * GAUSSIAN_CUTOFF + np.sqrt(4.0 * GAUSSIAN_CUTOFF**2 + 2.0 * speed * length)))


def last_time(reach: float | Array, speed: float | Array) -> Array:
    """τ from which heat has left all offsets within `reach`, at speeds ≥ 0 of its material; inf at rest."""
    moving, left = np.asarray(speed) > 0.0, GAUSSIAN_CUTOFF + np.sqrt(GAUSSIAN_CUTOFF**2 + speed * reach)
    return np.where(moving, left / np.where(moving, speed, 1.0), math.inf)


def _window(centres: Array, length: float, speed: Array, tau: Array) -> slice:
    """The offsets that any of the Gaussians at times ``tau`` reaches."""
    drift, spread = speed * tau**2, 2.0 * GAUSSIAN_CUTOFF * tau + 0.5 * length
    low, high = np.searchsorted(centres, [(drift - spread).min(), (drift + spread).max()])
    return slice(int(low), int(high))


def cell_average(centres: Array, length: float, speed: float | Array, tau: Array) -> Array:
    """g at each time and offset: the share of a drifting element's heat, in one direction; shape (times, offsets)."""
    drift, tau = (speed * tau**2)[:, None], tau[:, None]
    half = length / (4.0 * tau)
    middle = (centres - drift) / (2.0 * tau)
    if tau[0, 0] < SERIES_FROM * length:
        return 0.5 * (erf(middle + half) - erf(middle - half))
    # Taylor series of the difference about its middle (derivatives of exp(−a²) are Hermite polynomials).
    a2 = middle * middle
    h2 = half * half
    series = (((64.0 * a2 - 480.0) * a2 + 720.0) * a2 - 120.0) * (h2**3 / 5040.0)
    series += ((16.0 * a2 - 48.0) * a2 + 12.0) * (h2 * h2 / 120.0)
    series += (4.0 * a2 - 2.0) * (h2 / 6.0) + 1.0
    series *= np.exp(-a2)
    series *= 2.0 / math.sqrt(math.pi) * half
    return series


def temperature_slope_table(nx: int, ny: int, aspect: float, peclet_x: float, peclet_y: float = 0.0) -> Array:
    """Surface temperature around one element heated with q = s ξ, ξ = x'/dx from −½ to ½, in s dx/k.

    Arguments, shape (2nx−1, 2ny−1) and errors raised are those of `temperature_table`."""
    x, y = offsets(nx, ny, aspect, peclet_x, peclet_y)
    if math.hypot(peclet_x, peclet_y) * extent(x, y, aspect) < STATIONARY_PECLET:
        check_moving(aspect)
        table = _stationary_slope(x, y, aspect)
    else:
        integral = time_integral(x, y, aspect, peclet_x, peclet_y, power=0, depths=np.zeros(1), along=cell_moment)
        table = 2.0 / math.sqrt(math.pi) * integral[0]
    return mirrored(table, ny)


def slopes(flux: Array) -> Array:
    """Change of the element averages `flux` ≥ 0, (nx, ny), along x from one end of each element to the other, same unit.

    Central differences; one-sided at the ends of the heated rows, so that elements without heat keep none. Limited so that the
    flux is nowhere negative within an element."""
    heated = flux > 0.0
    step = np.diff(flux, axis=0)
    inside = heated[1:] & heated[:-1]
    total, count = np.zeros_like(flux), np.zeros_like(flux)
    for side in (np.s_[1:], np.s_[:-1]):
        total[side] += step * inside
        count[side] += inside
    return np.asarray(np.clip(total / np.maximum(count, 1.0), -2.0 * flux, 2.0 * flux))


def cell_moment(centres: Array, length: float, speed: float | Array, tau: Array) -> Array:
    """m at each time and offset, for elements of unit `length`; shape (times, offsets)."""
    t = tau[:, None]
    x = centres - (speed * tau**2)[:, None]
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

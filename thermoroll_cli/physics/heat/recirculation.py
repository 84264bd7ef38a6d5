"""Recirculating heat: temperature and bulge on the track of a turning body from earlier revolutions.

**One wavenumber.** A track receives an equal amount of heat at each pass, P apart. A wave across the track (wavenumber λ,
ε = κλ²P) has decayed by exp(−nε) n passes later, and its surface temperature falls like n^{−1/2}. The sums
over all n ≥ 1 less the integrals that represent the mean in time,

    D(ε) = Σ n^{−1/2} e^{−nε} − √(π/ε) = Li_{1/2}(e^{−ε}) − √(π/ε),          D(0) = ζ(½) = −1.46035…
    S(ε) = Σ erfc √(nε) − 1/(2ε),                                             S(0) = −½

have, by their Mellin transforms, the series (|ε| < 2π)

    D = Σ_k ζ(½ − k) (−ε)^k/k!,      S = −½ − Σ_k (−1)^k ζ(−½ − k) ε^{k+½} / (√π k! (k + ½)).

**One track** (`Track`). The body is a solid cylinder of radius R and width B that turns at the speed V of its surface, cooled
on rim and ends by convection h, or as a whole through a thermal resistance. Each of its Z contacts per revolution puts
the energy e(y) = ∫ q dx / V per area on the track, P = 2πR/(ZV) apart in time; q̄ = e/P is its mean flux over the rim. Across
the width

    convection h:     cos λy with λ tan(λB/2) = h/k,  sin λy with −λ cot(λB/2) = h/k     (exact: rim and ends)
    resistance R_th:  cos λy and sin λy of an insulated body, λ = jπ/B; the mean, j = 0, is R_th times the heat of all contacts

and mode by mode, with ρ = I₁(λR)/I₀(λR), ε = κλ²P, β = k/√κ, ρc = k/κ,

    T_m = q̄_m [1/(kλρ + h) + √(P/π)/β · D(ε)]
    u_m = (1 + ν)α q̄_m [c(λR)/(λ(kλρ + h)) + 2P/ρc · S(ε)].

A body that is concave along rolling is the rim of a bore of radius R in a large body: ρ = K₁(λR)/K₀(λR), with the c that
belongs to it. The cooling and the thickness of such a ring do not follow from R, so its mean needs a resistance.

T and u are the recirculating parts at the contact; there they depend on y alone, except for a share of about a/(2πR) of T.
The present pass adds the half-space's response. For large ε both terms cancel: heat has spread before it recirculates.

**Both bodies** (`RecirculatingResponse`): the half-space's response to the present pass, plus their tracks'.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike
from scipy.special import erfc, factorial, i0e, i1e, k0e, k1e, zeta

from thermoroll_cli.physics.heat.heat_response import DividedHeat, ThermalResponse
from thermoroll_cli.physics.numerics.convolution import Convolution, Spectrum
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.tools.arrays import Array, Mask

SERIES_UP_TO = 1.0
"""ε below which the series is summed, above the passes themselves."""
SERIES_TERMS = 24
"""Terms of either series: the last one is below 1e-17 at ε = 1."""
MOST_PASSES = 40
"""Passes summed for ε > 1: nε above which they have no effect, e^{−40}."""


def pass_sum(epsilon: ArrayLike) -> Array:
    """D(ε) for ε ≥ 0: surface temperature by earlier passes, less its mean in time; shape of ε."""
    k = np.arange(SERIES_TERMS)
    coefficients = zeta(0.5 - k) * (-1.0) ** k / factorial(k, exact=True).astype(float)
    return _either(
        epsilon, lambda few: polyval(few, coefficients),
        lambda many: _over_passes(many, lambda n, eps: np.exp(-n * eps) / math.sqrt(n)) - np.sqrt(math.pi / many))


def bulge_sum(epsilon: ArrayLike) -> Array:
    """S(ε) for ε ≥ 0: thermal expansion by earlier passes, less its mean in time; shape of ε."""
    k = np.arange(SERIES_TERMS)
    coefficients = zeta(-0.5 - k) * (-1.0) ** k / (factorial(k, exact=True).astype(float) * math.sqrt(math.pi) * (k + 0.5))
    return _either(
        epsilon, lambda few: -0.5 - np.sqrt(few) * polyval(few, coefficients),
        lambda many: _over_passes(many, lambda n, eps: erfc(np.sqrt(n * eps))) - 0.5 / many)


def _over_passes(epsilon: Array, term: Callable[[int, Array], Array]) -> Array:
    """Sum over all passes n of `term`(n, ε), which falls like e^{−nε} at least."""
    total = np.zeros_like(epsilon)
    for n in range(1, MOST_PASSES + 1):
        felt = n * epsilon < MOST_PASSES
        total[felt] += term(n, epsilon[felt])
    return total


def _either(epsilon: ArrayLike, series: Callable[[Array], Array], passes: Callable[[Array], Array]) -> Array:
    """The `series` in ε up to `SERIES_UP_TO`, the sum over `passes` beyond; shape of ε."""
    eps = np.asarray(epsilon, dtype=float)
    small = eps <= SERIES_UP_TO
    out = np.empty(eps.shape)
    out[small], out[~small] = series(eps[small]), passes(eps[~small])
    return out


def surface_slope(argument: ArrayLike, *, bore: bool = False) -> Array:
    """ρ = I₁(λR)/I₀(λR): slope over value of T = I₀(λr) at the rim, in units of λ; shape of λR ≥ 0. For the rim of a `bore`,
    around which T = K₀(λr), it is K₁(λR)/K₀(λR), λR > 0."""
    x = np.asarray(argument, dtype=float)
    return np.asarray(k1e(x) / k0e(x) if bore else i1e(x) / i0e(x))


def cylinder_factor(argument: ArrayLike, poisson_ratio: float, *, bore: bool = False) -> Array:
    """c(λR): radial displacement of a solid, traction-free cylinder with T = I₀(λr) cos λy, over that of a half-space with the
    same temperature at its surface, (1 + ν)αT/λ; shape of λR > 0.

    Goodier's potential m r I₁(λr)/2λ cos λy, m = (1 + ν)α/(1 − ν), plus Love's two solutions, which free the rim of stress:

        c = ρ x²(1 − ρ²) / [x²(1 − ρ²) − 2(1 − ν)ρ²],     x = λR,  ρ = I₁(x)/I₀(x)

    It is 1 + (3/2 − 2ν)/x for large x; for small x it is x/(1 + ν), the free expansion αRT of the whole cylinder.
    Around a `bore` K₀ and −K₁ replace I₀ and I₁, and the surface moves the other way: the same with ρ = −K₁/K₀ and a minus
    sign, 1 − (3/2 − 2ν)/x for large x.
    """
    x = np.asarray(argument, dtype=float)
    rho = surface_slope(x, bore=bore)
    # 1 − ρ² cancels for large x, where it is ±(1/x + 1/(8x³)).
    far, sign = np.maximum(x, 1.0), -1.0 if bore else 1.0
    rest = x**2 * np.where(x > 1e3, sign * (1.0 / far + 0.125 / far**3), 1.0 - rho**2)
    return np.asarray(rho * rest / (rest - 2.0 * (1.0 - poisson_ratio) * rho**2))


SPREAD_EPSILON = 36.0
"""ε above which the mean and the passes cancel: e^{−36}."""
FLAT_BODY_FROM = 100.0
"""λR and kλ/h above which the curvature and the cooling of the body no longer affect a wave."""
FINEST_WAVE = 6.0 * math.pi
"""λ dy above which the elements do not resolve a wave."""
EACH_MODE, PANEL, PANEL_POINTS = 4096, 0.25, 8
"""Modes that are counted one by one, length of a panel of further ones over their number, and points in it."""
ROOT_STEPS = 60
"""Newton steps at most, for all roots at once."""


@dataclass(frozen=True)
class TurningBody:
    """A body that turns (SI): `radius` R > 0 along rolling, `width` B, `passes` Z per revolution, speed of its surface; either
    `convection` h (W/m²K) or `resistance` R_th (K/W); its thermal constants with `free_expansion` (1 + ν)α. The track of a
    `ring` lies in its bore; it takes a resistance."""

    radius: float
    width: float
    passes: int
    speed: float
    conductivity: float
    diffusivity: float
    free_expansion: float
    poisson_ratio: float
    convection: float | None = None
    resistance: float | None = None
    ring: bool = False

    @property
    def period(self) -> float:
        """P in s."""
        return 2.0 * math.pi * self.radius / (self.passes * self.speed)

    @property
    def biot(self) -> float:
        """hR/k; nan with a resistance."""
        return math.nan if self.convection is None else self.convection * self.radius / self.conductivity

    @property
    def spreading(self) -> float:
        """√(κP) in m: distance that heat spreads across the track between passes."""
        return math.sqrt(self.diffusivity * self.period)

    @property
    def crown_per_heat(self) -> float:
        """Curvature of the thermal crown in 1/m over ∫ q dx of one contact in W/m, if heat does not spread: (1 + ν)α q̄/k."""
        return self.free_expansion * self.passes / (2.0 * math.pi * self.radius * self.conductivity)

    @property
    def mean_resistance(self) -> float:
        """Mean surface temperature over the heat of all contacts in K/W: 1/(hA) with rim and ends, where all heat leaves."""
        if self.resistance is not None:
            return self.resistance
        assert self.convection is not None
        return 1.0 / (self.convection * 2.0 * math.pi * self.radius * (self.width + self.radius))

    @property
    def warm_up_time(self) -> float:
        """ρc · volume · R_th in s; nan for a ring, whose volume is not known."""
        if self.ring:
            return math.nan
        capacity = self.conductivity / self.diffusivity * math.pi * self.radius**2 * self.width
        return capacity * self.mean_resistance

    def modes(self, highest: float, reach: float) -> tuple[Array, Array, Mask]:
        """Wavenumbers λ in 1/m up to `highest` (at least two), weights of the modes over ∫φ² dy in 1/m, and which are odd.

        Of a wide body only the first `EACH_MODE` are counted one by one. Within `reach` (m) of the middle products of further
        ones, and their gains, change smoothly with their number: a few stand for all of a panel, by Gauss's rule."""
        count = max(2, math.ceil(highest * self.width / math.pi) + 1)
        number = np.arange(min(count, EACH_MODE), dtype=float)
        weight, odd = np.ones_like(number), number % 2 == 1
        if count > EACH_MODE:
            longest = self.width / (math.pi * reach)
            ends = [float(EACH_MODE)]
            while ends[-1] < count:
                ends.append(ends[-1] + min(PANEL * ends[-1], longest))
            half = 0.5 * np.diff(ends)[:, None]
            nodes, shares = np.polynomial.legendre.leggauss(PANEL_POINTS)
            panels = (np.array(ends[:-1])[:, None] + half * (1.0 + nodes)).ravel()
            # Every second one is even: that at n stands for those from n − 1 to n + 1.
            number = np.concatenate((number, panels - 1.0, panels))
            weight = np.concatenate((weight, *(2 * [(0.5 * half * shares).ravel()])))
            odd = np.concatenate((odd, np.repeat([False, True], panels.size)))
        biot = 0.5 * (self.convection or 0.0) * self.width / self.conductivity
        z = robin_roots(number, biot)
        # ∫φ² = ½B (1 ± sin 2z/2z) with the tangent of the root; the mean of a body that does not cool is 1.
        square = z**2 + biot**2
        norm = 0.5 * self.width * (1.0 + np.divide(biot, square, out=np.ones_like(z), where=square > 0.0))
        return z * (2.0 / self.width), weight / norm, odd


class Track:
    """Response of a `TurningBody`'s track at the columns of a grid to heat fluxes on that grid, as matrices.

    `temperature` (K per W/m²) and `bulge` (m per W/m², up to a constant), both (ny, ny), act on the sum of the flux into the
    body over the rows of the grid."""

    def __init__(self, body: TurningBody, grid: Grid) -> None:
        self.body, self.grid = body, grid
        highest = max(math.sqrt(SPREAD_EPSILON) / body.spreading, FLAT_BODY_FROM / body.radius,
                      FLAT_BODY_FROM * (body.convection or 0.0) / body.conductivity)
        wave, share, odd = body.modes(min(highest, FINEST_WAVE / grid.dy), float(np.abs(grid.y).max()))
        shape = np.empty((grid.ny, len(wave)))
        # cos λy and sin λy, real parts that turn by λ dy from one column to the next.
        phase, turn = np.exp(1j * grid.y[0] * wave), np.exp(1j * grid.dy * wave)
        phase[odd] *= -1j
        for column in shape:
            column[:] = phase.real
            phase *= turn
        # Elements carry uniform flux: integral of each mode over an element, and q̄ = dx Z/2πR of the sum over rows.
        element = grid.dy * np.sinc(wave * (0.5 * grid.dy / math.pi)) * share
        weight = element * (grid.dx * body.passes / (2.0 * math.pi * body.radius))
        self.temperature, self.bulge = (np.asarray((shape * (gain * weight)) @ shape.T) for gain in mode_gains(body, wave))

    def entry_temperature(self, flux: Array) -> Array:
        """T_rec(y) in K, (ny,), with which the track re-enters the contact, by the heat `flux` (W/m², (nx, ny)) into the
        body."""
        return np.asarray(self.temperature @ flux.sum(axis=0))

    def entry_bulge(self, flux: Array) -> Array:
        """u_rec(y) > 0 outwards in m, (ny,), up to a constant."""
        return np.asarray(self.bulge @ flux.sum(axis=0))

    def crown(self, flux: Array, curvature: float) -> float:
        """(1 + ν)α q̄(0)/(k/R'_y): curvature of the thermal crown over the relative `curvature` 1/R'_y (1/m) of the gap."""
        middle = slice((self.grid.ny - 1) // 2, self.grid.ny // 2 + 1)
        line = float(flux[:, middle].sum(axis=0).mean()) * self.grid.dx
        return line * self.body.crown_per_heat / curvature

    def bulk_temperature(self, flux: Array) -> float:
        """Mean temperature of the body's surface in K above its surroundings: R_th times the heat of all contacts."""
        r = self.body
        return r.mean_resistance * r.passes * float(flux.sum()) * self.grid.element_area


def mode_gains(body: TurningBody, wave: Array) -> tuple[Array, Array]:
    """T_m/q̄_m in K per W/m² and u_m/q̄_m in m per W/m² (see the module's docstring) of the modes with wavenumbers `wave`."""
    r, period, k = body, body.period, body.conductivity
    # The mean has the wavenumber 0 where it leaves through a resistance. It would only add a constant to the bulge.
    argument = np.where(wave > 0.0, wave, 1.0) * r.radius
    loss = k * wave * surface_slope(argument, bore=r.ring) + (r.convection or 0.0)
    if r.resistance is not None:
        loss[0] = 1.0 / (r.resistance * 2.0 * math.pi * r.radius * r.width)
    bulging = (wave > 0.0) * cylinder_factor(argument, r.poisson_ratio, bore=r.ring) / (argument / r.radius) / loss
    epsilon = r.diffusivity * wave**2 * period
    return (1.0 / loss + math.sqrt(period * r.diffusivity / math.pi) / k * pass_sum(epsilon),
            r.free_expansion * (bulging + 2.0 * period * r.diffusivity / k * bulge_sum(epsilon)))


def robin_roots(number: Array, biot: float) -> Array:
    """z = nπ/2 + atan(Bi/z) for each n ≥ 0 of `number`, which begins with 0: z tan z = Bi for even n, −z cot z = Bi for odd n,
    by Newton's method.

    The function z − nπ/2 − atan(Bi/z) grows and bends down, so that Newton's steps from below stay below the root."""
    base = 0.5 * math.pi * number
    if biot == 0.0:
        return base
    z = base + np.arctan(biot / (base + 0.5 * math.pi))
    # tan z ≤ z/(1 − 4z²/π²) bounds the first one.
    z[0] = math.sqrt(biot / (1.0 + 4.0 * biot / math.pi**2))
    for _ in range(ROOT_STEPS):
        step = (z - base - np.arctan(biot / z)) / (1.0 + biot / (z**2 + biot**2))
        z -= step
        if np.abs(step).max() <= 1e-15 * z.max():
            break
    return np.asarray(z)


Tracks = tuple[Track | None, Track | None]
"""Tracks of the lower and the upper body; None for a body without recirculating heat."""


def entry_temperatures(tracks: Tracks, heat: DividedHeat) -> tuple[Array, Array]:
    """Temperatures in K, (ny,), with which the tracks enter the contact, above the surroundings of each body; 0 without a
    track."""
    lower, upper = (
        np.zeros(flux.shape[1]) if track is None else track.entry_temperature(flux)
        for track, flux in zip(tracks, (heat.lower, heat.upper), strict=True)
    )
    return lower, upper


class RecirculatingResponse:
    """`passing` response of the present pass, and the `tracks` of lower and upper body (None: no recirculating heat).

    With `bulging` false the displacement does not include the tracks' thermal crown."""

    def __init__(self, passing: ThermalResponse, tracks: Tracks, *, bulging: bool = True) -> None:
        self.passing, self.tracks, self.bulging = passing, tracks, bulging

    @property
    def matched_share(self) -> float | None:
        """As `ThermalResponse`: the tracks of equal bodies must be equal as well."""
        lower, upper = self.tracks
        alike = lower is upper if lower is None or upper is None else lower.body == upper.body
        return self.passing.matched_share if alike else None

    @property
    def likely_share(self) -> float:
        """As `ThermalResponse`, of the present pass."""
        return self.passing.likely_share

    def displacement(self, heat: DividedHeat) -> Array:
        expansion = self.passing.displacement(heat)
        if self.bulging:
            for track, flux in zip(self.tracks, (heat.lower, heat.upper), strict=True):
                if track is not None:
                    expansion += track.entry_bulge(flux)
        return expansion

    def temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        """As `ThermalResponse`, above the surroundings of each body: the recirculating part is a function of y alone."""
        lower, upper = self.passing.temperatures(heat)
        before, above = entry_temperatures(self.tracks, heat)
        return lower + before, upper + above

    def temperature_difference(self, exchange: Array) -> Array:
        sums, gap = exchange.sum(axis=0), self.passing.temperature_difference(exchange)
        return gap + sum(track.temperature for track in self.tracks if track is not None) @ sums

    def difference_symbol(self) -> tuple[Convolution, Spectrum]:
        """As `ThermalResponse`, of the present pass; to precondition the part of the tracks as well saves no time."""
        return self.passing.difference_symbol()

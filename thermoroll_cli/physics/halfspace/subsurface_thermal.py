"""Temperature and thermal stresses inside a half-space under one heated element on moving material.

The element of dx × dy carries a uniform heat flux q into the body; the surface is free of traction and otherwise insulated, and
the state is steady. Lengths are in dx, P = V dx/κ along x and along y, ``aspect`` b = dy/dx, z ≥ 0 points into the body.
With w² = k_x² + k_y² and s² = w² + i(k_x P_x + k_y P_y) the response to q is, per wavenumber (Goodier's potential plus the
isothermal correction that frees the surface),

    T = e^(−sz)/s                                in q dx/k
    H = 2 e^(−wz)/(w s (s+w)),   Ψ = e^(−wz) z² (s−w) φ(X)/(s (s+w)),   φ(X) = (e^(−X) − 1 + X)/X²,   X = (s−w)z
    σ_xx = −T + ∂_xx Ψ − (∂_xx + ν ∂_yy) H       σ_zz = −(∂_xx + ∂_yy) Ψ       in Eα/(1−ν) · q dx/k
    σ_xy = ∂_xy Ψ − (1−ν) ∂_xy H                 σ_xz = ∂_x ∂_z Ψ              and σ_yy, σ_yz by x ↔ y.

Samples in wavenumbers would have errors of some per cent by periodic images. In real space both potentials are
superpositions of Gaussians of variance 2u that have drifted by Pt,

    H = ∫∫ 2 erfc(a) G dt du,   Ψ = ∫∫ [(z²/2u) erfc(a) − erf(a) + (2/√π) a exp(−a²)] G dt du,   0 < t < u < ∞,
    G = exp(−z²/4u)/√(πu) · gx(X − P_x t; u) gy(Y − P_y t; u),   a² = z² t/(4u(u − t)),

with gx and gy the integrals over the element of a Gaussian each. The Gaussians do not depend on the depth. At each node u of
the outer rule the inner one gives a function of x alone for each depth, so that a table is a product of two matrices.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import erf, erfc

from thermoroll_cli.physics.halfspace.subsurface_elastic import EXCHANGED_AXES, Corner, between_corners
from thermoroll_cli.physics.halfspace.thermal import STATIONARY_PECLET, check_moving, extent, temperature_at_depths
from thermoroll_cli.tools.arrays import Array

GAUSSIAN_CUTOFF = 5.4
"""Gaussians are cut off where their argument reaches this: exp(−5.4²) = 2e-13."""
TOLERANCE = 1e-10
"""Allowed remainders beyond the last node and within the first one, in Eα/(1−ν) · q dx/k."""


OUTER_STEP, INNER_STEP, PASSING = 0.46, 0.56, 1.75
"""Steps of the two rules: in the logarithm of u, in that of t/(u−t), and the longest one in units of √u/P, where Gaussians of
width √u pass by. Good to 1e-5 of the largest stress of the element (measured for P from 0 to 1e4): grids leave more than 1e-4.
Errors fall exponentially with them, to 1e-9 with 0.22, 0.32 and 1."""

Function = Callable[[Array], Array]


def outer_rule(reach: float, length: float, peclet: tuple[float, float]) -> tuple[Array, Array]:
    """Nodes u and weights of ∫ … du: trapezoidal in v = ln u + c√π τ₁ erf(√u/τ₁), with steps as short as the drift requires.

    `reach` is the farthest offset downstream, `length` the shorter side of the element. Before the first node no heat has left
    the element; beyond the last, less than TOLERANCE follows."""
    along = math.hypot(*peclet)
    shortest = length / (2.0 * GAUSSIAN_CUTOFF + math.sqrt(4.0 * GAUSSIAN_CUTOFF**2 + 2.0 * along * length))
    edge = (2.0 * GAUSSIAN_CUTOFF + math.sqrt(4.0 * GAUSSIAN_CUTOFF**2 + 4.0 * along * reach)) / (2.0 * along)
    rim, density = 1.5 * edge, 1.5 * along * OUTER_STEP / PASSING
    first, last = 2.0 * math.log(shortest), max(-math.log(12.0 * along * TOLERANCE), 2.0 * math.log(edge) + 4.0)

    def mapped(log_u: Array) -> Array:
        tau = np.exp(0.5 * log_u)
        return np.asarray(log_u + density * math.sqrt(math.pi) * rim * erf(tau / rim))

    def slope(log_u: Array) -> Array:
        tau = np.exp(0.5 * log_u)
        return np.asarray(1.0 + density * tau * np.exp(-((tau / rim) ** 2)))

    log_u = _equal_steps(mapped, slope, first, last, OUTER_STEP)
    u = np.exp(log_u)
    return u, OUTER_STEP * u / slope(log_u)


def inner_rule(u: float, furthest: float, peclet: float) -> tuple[Array, Array, Array, int, int]:
    """Nodes of ∫ … dt from 0 to u: trapezoidal in v = ζ + c t/u with t/(u−t) = e^ζ and c ∝ P√u.

    Returns t/(u−t), t, weights, and the first and last node that need a Gaussian of their own. Nodes end at `furthest`."""
    drift = peclet * math.sqrt(u) * INNER_STEP / PASSING

    def mapped(zeta: Array) -> Array:
        return np.asarray(zeta + drift / (1.0 + np.exp(-zeta)))

    def slope(zeta: Array) -> Array:
        return np.asarray(1.0 + drift / (2.0 + np.exp(zeta) + np.exp(-zeta)))

    share = furthest / u
    end = 36.0 if share >= 1.0 - 1e-15 else min(math.log(share) - math.log1p(-share), 36.0)
    zeta = _equal_steps(mapped, slope, -36.0, end, INNER_STEP)
    odds = np.exp(zeta)
    t = u * odds / (1.0 + odds)
    alone = math.log(math.sqrt(TOLERANCE / max(drift, 1.0)))
    first, last = int(np.searchsorted(zeta, alone)), int(np.searchsorted(zeta, -alone))
    first = min(first, len(zeta) - 1)
    return odds, t, INNER_STEP * t / (1.0 + odds) / slope(zeta), first, max(min(last, len(zeta) - 1), first)


def _equal_steps(mapped: Function, slope: Function, first: float, last: float, step: float) -> Array:
    """Arguments from `first` to `last` whose images under the monotonous `mapped`, of slope `slope`, are `step` apart."""
    rough = np.linspace(first, last, 400)
    image = mapped(rough)
    wanted = np.arange(image[0], image[-1] + step, step)
    nodes = np.interp(wanted, image, rough)
    for _ in range(4):
        nodes = nodes + (wanted - mapped(nodes)) / slope(nodes)
    return np.asarray(nodes)


INNER_NODES_TOGETHER = 48
"""Inner nodes taken together: few enough for narrow windows."""
OUTER_NODES_TOGETHER = 64
"""Outer nodes taken together: enough for efficient matrix products, few enough for their memory."""


def thermal_stress(
    x: Array, y: Array, depths: Array, aspect: float, peclet_x: float, peclet_y: float, poisson_ratio: float
) -> Array:
    """Thermal stresses under one heated element, in Eα/(1−ν) · q dx/k.

    `x`, `y` are ascending offsets from the element's centre in steps of 1 and of `aspect`, none of them on its edges;
    `depths` ascend. Returns (len(depths), 6, len(x), len(y)), components xx yy zz xy xz yz, good to 1e-5 of the
    largest. Raises ValueError for a depth that is negative or a Péclet number that is not finite.
    """
    _check(depths, peclet_x, peclet_y)
    if math.hypot(peclet_x, peclet_y) * extent(x, y, aspect) < STATIONARY_PECLET:
        check_moving(aspect)
        return np.stack([stationary_stress(x, y, float(z), aspect, poisson_ratio) for z in depths])
    if math.isinf(aspect):
        peclet_y = 0.0  # a strip looks alike from everywhere along it
    if abs(peclet_y) > abs(peclet_x):
        # The inner rule follows the motion along x: exchange the axes, in units of dy.
        turned = thermal_stress(y / aspect, x / aspect, depths / aspect, 1.0 / aspect, peclet_y * aspect, peclet_x * aspect,
                                poisson_ratio)
        return aspect * turned.transpose(0, 1, 3, 2)[:, list(EXCHANGED_AXES)]
    if peclet_x < 0.0:
        mirrored = thermal_stress(-x[::-1], y, depths, aspect, -peclet_x, peclet_y, poisson_ratio)[:, :, ::-1]
        return mirrored * np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])[:, None, None]
    stress = _Superposition(x, y, depths, aspect, (peclet_x, peclet_y), poisson_ratio).sum()
    temperature = temperature_at_depths(x, y, depths, aspect, peclet_x, peclet_y)
    stress[:, 0] -= temperature
    stress[:, 1] -= temperature
    return stress


def stationary_stress(x: Array, y: Array, z: float, aspect: float, poisson_ratio: float) -> Array:
    """The limit P → 0, where σ_zz, σ_xz and σ_yz vanish (Sternberg and McDowell 1957); (6, len(x), len(y)).

    1/2π times the differences between the element's corners of σ_xx = −(1−ν)[y L_y − z A_y] and
    σ_xy = (1−ν)[r − z ln(r+z)], with L and A of `subsurface_elastic`; σ_yy by x ↔ y."""
    def primitive(corner: Corner) -> Array:
        flipped, r = corner.twisted, corner.r
        zero = np.zeros_like(r)
        return (1.0 - poisson_ratio) * np.stack([
            z * flipped.angle() - corner.y * flipped.inverse_sine(),
            z * corner.angle() - corner.x * corner.inverse_sine(),
            zero, r - z * np.log(r + z), zero, zero,
        ])

    return between_corners(x, y, z, aspect, primitive)


def _check(depths: Array, peclet_x: float, peclet_y: float) -> None:
    if not (math.isfinite(peclet_x) and math.isfinite(peclet_y)):
        raise ValueError(f"Péclet numbers must be finite, not {peclet_x}, {peclet_y}")
    if not (np.isfinite(depths).all() and (depths >= 0.0).all() and (np.diff(depths) > 0.0).all()):
        raise ValueError("depths must ascend from 0 or deeper")


@dataclass(frozen=True)
class _Superposition:
    """The double integral over the Gaussians, without −T: P_x > 0."""

    x: Array
    y: Array
    depths: Array
    aspect: float
    peclet: tuple[float, float]
    poisson_ratio: float

    def sum(self) -> Array:
        """(depths, 6, len(x), len(y))."""
        total = np.zeros((len(self.depths), 6, len(self.x), len(self.y)))
        u, weights = outer_rule(self._reach(), min(1.0, self.aspect), self.peclet)
        for start, stop in pairwise([*range(0, len(u), OUTER_NODES_TOGETHER), len(u)]):
            # No heat has arrived at larger depths yet.
            active = int(np.searchsorted(self.depths, 2.0 * GAUSSIAN_CUTOFF * math.sqrt(u[stop - 1]), side="right"))
            self._add(total[:active], u[start:stop], weights[start:stop], self.depths[:active])
        return total

    def _reach(self) -> float:
        """Largest offset downstream, at least one element."""
        return max(float(self.x[-1]) + 0.5, 1.0)

    def _add(self, total: Array, u: Array, weights: Array, depths: Array) -> None:
        """Add the contributions of the outer nodes `u` to the first depths."""
        along, across = [], []
        for variance, weight in zip(u, weights, strict=True):
            times, of_times = self._inner(float(variance), float(weight), depths)
            shifts, shares = self._lateral(float(variance), times)
            along.append(self._along(float(variance), times, of_times, shares))
            across += [_cell(self.y - shift, self.aspect, float(variance)) for shift in shifts]
        # (terms, depths, nodes, x) and (orders, nodes, y); with lateral motion every node u counts once for each shift.
        f = np.concatenate(along, axis=2)
        g = np.stack(across, axis=1)
        nu = self.poisson_ratio
        h0, h2, psi0, psi2, mixed, shear_x, shear_y = f
        for layer in range(len(depths)):
            xx = np.concatenate([psi2[layer] - h2[layer], -nu * h0[layer]])
            yy = np.concatenate([psi0[layer] - h0[layer], -nu * h2[layer]])
            zz = np.concatenate([-psi2[layer], -psi0[layer]])
            even, odd = np.concatenate([g[0], g[2]]), np.concatenate([g[2], g[0]])
            total[layer, 0] += xx.T @ even
            total[layer, 1] += yy.T @ odd
            total[layer, 2] += zz.T @ even
            total[layer, 3] += mixed[layer].T @ g[1]
            total[layer, 4] += shear_x[layer].T @ g[0]
            total[layer, 5] += shear_y[layer].T @ g[1]

    def _inner(self, u: float, weight: float, depths: Array) -> tuple[Array, Array]:
        """Nodes t of the inner rule at one u, and the weights (3, depths, nodes) of H, Ψ and ∂_z Ψ with all factors of
        gx gy."""
        furthest = (self._reach() + 2.0 * GAUSSIAN_CUTOFF * math.sqrt(u)) / self.peclet[0]
        odds, t, dt, first, last = inner_rule(u, furthest, self.peclet[0])
        # a = z √(t/(4u(u−t))); `odds` is t/(u−t) to full precision at both ends.
        rate = np.sqrt(odds / (4.0 * u))
        z = depths[:, None]
        a = z * rate
        gauss, tail = np.exp(-a * a), erfc(a)
        ratio = z * z / (2.0 * u)
        psi = ratio * tail - erf(a) + 2.0 / math.sqrt(math.pi) * a * gauss
        slope = z / (2.0 * u) * (2.0 * tail - psi) - 2.0 / math.sqrt(math.pi) * (2.0 * a * a + ratio) * rate * gauss
        every = np.stack([2.0 * tail, psi, slope]) * dt
        every *= (np.exp(-0.5 * ratio) * (weight / math.sqrt(math.pi * u)))
        # If the Gaussians no longer move, nodes differ only by their weights.
        kept = every[:, :, first : last + 1].copy()
        kept[:, :, 0] += every[:, :, :first].sum(axis=2)
        kept[:, :, -1] += every[:, :, last + 1 :].sum(axis=2)
        return t[first : last + 1], kept

    def _along(self, u: float, nodes: Array, of_nodes: Array, shares: Array) -> Array:
        """Inner sums (7, depths, shifts, len(x)): of H and Ψ without and with ∂_xx, ∂_x of Ψ − (1−ν)H, and ∂_x ∂_z Ψ, ∂_z Ψ."""
        h, psi, slope = (part[:, None, :] * shares for part in of_nodes)
        mixed = psi - (1.0 - self.poisson_ratio) * h
        by_order = (np.stack([h, psi, slope]), np.stack([mixed, slope]), np.stack([h, psi]))
        targets = ([0, 2, 6], [4, 5], [1, 3])
        out = np.zeros((7, *h.shape[:2], len(self.x)))
        speed = self.peclet[0]
        spread = 2.0 * GAUSSIAN_CUTOFF * math.sqrt(u) + 0.5
        for start in range(0, len(nodes), INNER_NODES_TOGETHER):
            times = nodes[start : start + INNER_NODES_TOGETHER]
            low, high = np.searchsorted(self.x, [speed * times[0] - spread, speed * times[-1] + spread])
            if low == high:
                continue
            gx = _cell(self.x[None, low:high] - speed * times[:, None], 1.0, u)
            for order, (weights, target) in enumerate(zip(by_order, targets, strict=True)):
                out[target, :, :, low:high] += weights[..., start : start + INNER_NODES_TOGETHER] @ gx[order]
        return out

    def _lateral(self, u: float, t: Array) -> tuple[Array, Array]:
        """Shifts along y and the share of each inner node that belongs to each: interpolation in the lateral drift P_y t.

        Without lateral motion there is one shift, zero. If a body moves much faster along x, the drift is short against
        the width 2√u of the Gaussians, so that a few Chebyshev points suffice."""
        speed = self.peclet[1]
        if speed == 0.0 or len(t) == 1:
            return speed * t[:1], np.ones((1, len(t)))
        centre, half = 0.5 * speed * (t[0] + t[-1]), 0.5 * speed * (t[-1] - t[0])
        count = 4 + math.ceil(6.0 * abs(half) / math.sqrt(u))
        angle = (np.arange(count) + 0.5) * math.pi / count
        nodes = np.cos(angle)
        place = np.clip((speed * t - centre) / half, -1.0, 1.0)
        # Σ_m T_m(place) T_m(node): the interpolating polynomial of each node in Chebyshev's basis.
        orders = np.arange(count)
        basis = np.cos(orders[:, None] * np.arccos(place)[None, :])
        basis[0] *= 0.5
        return centre + half * nodes, 2.0 / count * np.cos(angle[:, None] * orders[None, :]) @ basis


def _cell(centres: Array, length: float, u: float) -> Array:
    """A Gaussian of variance 2u integrated over the element, and its first two derivatives: (3, …) as `centres`, whose last
    axis ascends in steps of `length`; of a strip, which has no end, 1 and 0."""
    if math.isinf(length):
        return np.stack([np.ones_like(centres), np.zeros_like(centres), np.zeros_like(centres)])
    edges = np.concatenate([centres - 0.5 * length, centres[..., -1:] + 0.5 * length], axis=-1)
    width = 2.0 * math.sqrt(u)
    scaled = edges / width
    density = np.exp(-scaled * scaled) / (math.sqrt(math.pi) * width)
    primitives = np.stack([0.5 * erf(scaled), density, scaled * density * (-2.0 / width)])
    return np.asarray(np.diff(primitives, axis=-1))

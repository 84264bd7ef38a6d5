"""Elastic half-spaces with bonded layers: compliance in wave numbers, and its difference to a half-space of the top material.

Wave vector k along x, z into the body: u_x = iV, u_z = W, σ_xz = iT, σ_zz = S, all real. In a layer, downward solutions carry
e^{−kz} and upward ones e^{−kζ}, ζ from its lower face, so nothing grows:

    (V, W) = D_u N(kz) α,   (T, S)/2k = D_s N(kz) α,   N(t) = [[1, t], [0, 1]],   upward: mirrored by R = diag(1, −1).

Impedances (T, S)/2k = Z (V, W) are carried from the substrate to the surface. The surface compliance is returned as the
difference to the half-space of the top material, so that equal materials give exactly zero and nothing cancels. Across the wave
vector the problem is scalar. Source: the stiffness-matrix method for layered media (Kausel & Roësset 1981), in reflection form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import Layer

MIRROR = np.diag([1.0, -1.0])


@dataclass(frozen=True)
class SurfaceCompliance:
    """k times the surface compliance in 1/Pa at each wave number: u_x = i(tt q + tn p), u_z = tn q + nn p for tractions i q
    along the wave vector and pressure p; `ss` across it."""

    tt: Array
    tn: Array
    nn: Array
    ss: Array


def halfspace_compliance(youngs_modulus: float, poisson_ratio: float) -> SurfaceCompliance:
    """The compliance of a homogeneous half-space, which does not depend on the wave number (Johnson, Contact Mechanics, 3)."""
    shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio)
    normal = np.array((1.0 - poisson_ratio) / shear_modulus)
    return SurfaceCompliance(normal, np.array(0.5 * (1.0 - 2.0 * poisson_ratio) / shear_modulus), normal,
                             np.array(1.0 / shear_modulus))


@dataclass(frozen=True)
class _Constants:
    """Shear modulus, D_u, D_s, and the impedances of downward and of upward solutions, of one material."""

    shear_modulus: float
    displacement: Array
    stress: Array
    down: Array
    up: Array

    @classmethod
    def of(cls, youngs_modulus: float, poisson_ratio: float) -> _Constants:
        shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio)
        displacement = np.array([[1.0, 0.0], [-1.0, 4.0 * poisson_ratio - 3.0]])
        stress = shear_modulus * np.array([[-1.0, 2.0 * poisson_ratio - 1.0], [1.0, 2.0 * (1.0 - poisson_ratio)]])
        downward = stress @ np.linalg.inv(displacement)
        return cls(shear_modulus, displacement, stress, downward, -MIRROR @ downward @ MIRROR)


@dataclass(frozen=True)
class _Reflections:
    """A layer on what lies below it, at all wave numbers: N at its lower face, `decay` e^{−kh} across it, the `reflection` of
    downward solutions at its lower face (without decay), their `echo` as displacements at its upper face."""

    own: _Constants
    propagation: Array
    decay: Array
    reflection: Array
    echo: Array


def _reflections(layers: Sequence[Layer], substrate: tuple[float, float], wave_numbers: Array) -> list[_Reflections]:
    """All layers, from the surface down."""
    count = wave_numbers.size
    found: list[_Reflections] = []
    impedance = np.broadcast_to(_Constants.of(*substrate).down, (count, 2, 2))
    for layer in reversed(layers):
        own = _Constants.of(layer.youngs_modulus, layer.poisson_ratio)
        phase = wave_numbers * layer.thickness
        propagation = np.tile(np.eye(2), (count, 1, 1))
        propagation[:, 0, 1] = phase
        downward, upward = own.displacement @ propagation, MIRROR @ own.displacement
        reflection = -np.linalg.inv(upward) @ np.linalg.solve(own.up - impedance, own.down - impedance) @ downward
        echo = upward @ propagation @ reflection * np.exp(-2.0 * phase)[:, None, None]
        impedance = own.down + (own.up - own.down) @ echo @ np.linalg.inv(own.displacement + echo)
        found.insert(0, _Reflections(own, propagation, np.exp(-phase)[:, None, None], reflection, echo))
    return found


def difference_compliance(layers: Sequence[Layer], substrate: tuple[float, float], wave_numbers: Array) -> SurfaceCompliance:
    """k times (compliance of the layered half-space − compliance of a half-space of the top material), at `wave_numbers` (n,).

    `layers` from the surface down; `substrate` has Young's modulus (Pa) and Poisson's ratio."""
    antiplane = np.full(wave_numbers.size, _Constants.of(*substrate).shear_modulus)
    for layer in reversed(layers):
        shear_modulus = 0.5 * layer.youngs_modulus / (1.0 + layer.poisson_ratio)
        mismatch = (shear_modulus - antiplane) / (shear_modulus + antiplane) * np.exp(-2.0 * wave_numbers * layer.thickness)
        antiplane = shear_modulus * (1.0 - mismatch) / (1.0 + mismatch)
    top = _reflections(layers, substrate, wave_numbers)[0]
    own, echo = top.own, top.echo
    compliance = -0.5 * (np.eye(2) - np.linalg.solve(own.down, own.up)) @ echo @ np.linalg.inv(own.stress + own.up @ echo)
    across = 2.0 * mismatch / (1.0 - mismatch) / shear_modulus
    return SurfaceCompliance(compliance[:, 0, 0], compliance[:, 0, 1], compliance[:, 1, 1], across)


def layer_waves(
    layers: Sequence[Layer], substrate: tuple[float, float], wave_numbers: Array
) -> tuple[list[tuple[Array, Array]], Array]:
    """Coefficients of downward and upward solutions in each layer, and of those in the substrate: (n, 2, 2) each, the last axis
    for unit tractions (T, S)/2k on the surface."""
    found: list[tuple[Array, Array]] = []
    face = np.empty(0)
    for number, layer in enumerate(_reflections(layers, substrate, wave_numbers)):
        own = layer.own
        down = np.asarray(np.linalg.solve(own.displacement + layer.echo, face) if number
                          else np.linalg.inv(own.stress + own.up @ layer.echo))
        up = np.asarray(layer.reflection @ down * layer.decay)
        face = own.displacement @ layer.propagation @ down * layer.decay + MIRROR @ own.displacement @ up
        found.append((down, up))
    return found, np.asarray(np.linalg.inv(_Constants.of(*substrate).displacement) @ face)


STEP = 0.02
"""Step of the logarithmic grids of wave numbers and radii."""
FIRST_WAVE_NUMBER, LAST_WAVE_NUMBER = 1e-9, 1e6
"""Smallest wave number times the total thickness: without its limit the symbol is proportional to k there. Largest wave number
times the thinnest layer: radii begin at its inverse, and the area within the first of them does not count."""


@dataclass(frozen=True)
class RadialDifference:
    """The difference of point-load displacements H(r) = ∫ b(k) J_m(kr) dk/2π of `order` m: r H as a spline over ln r, and the
    spline of ∫_0^R H r dr, between the radii `ends`. Before them H is even, beyond them it decays like 1/r."""

    order: int
    weighted: scipy.interpolate.BSpline
    primitive: scipy.interpolate.BSpline
    ends: tuple[float, float]

    def __call__(self, r: Array) -> Array:
        inside = np.clip(r, *self.ends)
        return np.asarray(self.weighted(np.log(inside)) / np.where(r < self.ends[0], inside, r))

    def integral(self, r: Array) -> Array:
        """∫_0^r H r dr."""
        inside = np.clip(r, *self.ends)
        weighted = self.weighted(np.log(inside))
        within = np.minimum(r, self.ends[0])
        return np.asarray(self.primitive(np.log(inside)) + weighted * (0.5 * within**2 / self.ends[0] * (r < self.ends[0])
                                                                      + np.maximum(r - self.ends[1], 0.0)))


def _radial(order: int, wave_numbers: Array, symbol: Array, depth: float) -> RadialDifference:
    """Hankel transform of `symbol` (k times compliance) by FFTLog (Hamilton 2000, MNRAS 312).

    Its limit b₀ at small k, which decays like 1/r, is taken out as b₀ e^{−kz}, z = `depth`, whose transform is closed form."""
    limit = symbol[0]
    r = 1.0 / wave_numbers[::-1]
    transform = scipy.fft.fht(symbol - limit * np.exp(-wave_numbers * depth), STEP, order)
    distance = np.hypot(r, depth)
    closed = {0: 1.0 / distance, 1: r / (distance * (distance + depth)),
              2: (r / (distance + depth)) ** 2 / distance}[order]
    weighted = (transform + limit * r * closed) / (2.0 * np.pi)
    log_r = np.log(r)
    spline = scipy.interpolate.make_interp_spline(log_r, weighted, 5)
    primitive = scipy.interpolate.make_interp_spline(log_r, weighted * r, 5).antiderivative()
    return RadialDifference(order, spline, primitive, (float(r[0]), float(r[-1])))


NEAR = 3.5
"""Offsets in elements up to which an element is integrated in polar coordinates about the point where it is seen."""
ANGLES = 24
"""Gauss points on each of the two far sides of a corner."""
GAUSS = ((60.0, 2), (14.0, 3), (6.0, 4), (NEAR, 6))
"""Beyond so many elements so many Gauss points per side."""
WEIGHTS: dict[str, Callable[[Array], Array]] = {
    "even": np.ones_like, "cos": np.cos,
    "cos2": lambda t: np.asarray(np.cos(2.0 * t)), "sin2": lambda t: np.asarray(np.sin(2.0 * t)),
}
"""Angular factors of point-load displacements."""


def element_integral(radial: RadialDifference, angular: str, shape: tuple[int, int], dx: float, dy: float) -> Array:
    """∬ H(r) w(θ) over one dx × dy element, seen from element centres at offsets (i dx, j dy), i < nx, j < ny: (nx, ny).

    `angular` names w: 1, cos θ, cos 2θ or sin 2θ, with θ the direction from the load to the point."""
    table = np.empty(shape)
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    far = np.maximum(i * dx, j * dy) / max(dx, dy)
    last = np.inf
    for start, points in GAUSS:
        here = (far > start) & (far <= last)
        last = start
        nodes, weights = np.polynomial.legendre.leggauss(points)
        x = (i[here][:, None, None] + 0.5 * nodes[:, None]) * dx
        y = (j[here][:, None, None] + 0.5 * nodes) * dy
        values = radial(np.hypot(x, y)) * WEIGHTS[angular](np.arctan2(y, x))
        table[here] = 0.25 * dx * dy * np.einsum("nij,i,j->n", values, weights, weights)
    near = np.argwhere(far <= NEAR)
    if near.size:
        count_x, count_y = near.max(axis=0) + 1
        corner = _corner_integrals(radial, angular, count_x, count_y, dx, dy)
        element = corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]
        table[near[:, 0], near[:, 1]] = element[near[:, 0], near[:, 1]]
    return table


def _corner_integrals(radial: RadialDifference, angular: str, count_x: int, count_y: int, dx: float, dy: float) -> Array:
    """∬ from the origin to the corners ((i − ½) dx, (j − ½) dy), i ≤ count_x, j ≤ count_y: (count_x + 1, count_y + 1)."""
    odd_x, odd_y = {"even": (1, 1), "cos2": (1, 1), "cos": (0, 1), "sin2": (0, 0)}[angular]
    nodes, weights = np.polynomial.legendre.leggauss(ANGLES)
    x, y = (np.abs(np.arange(n + 1) - 0.5) * d for n, d in ((count_x, dx), (count_y, dy)))
    ratio = y[None, :] / x[:, None]
    corner = np.zeros(ratio.shape)
    # Along the far side r = x cosh u with sinh u = tan θ: as smooth in u where elements are long.
    for near, most, turned in ((x[:, None, None], np.arcsinh(ratio), False), (y[None, :, None], np.arcsinh(1.0 / ratio), True)):
        u = 0.5 * most[..., None] * (1.0 + nodes)
        angle = np.arctan(np.sinh(u))
        factor = WEIGHTS[angular](0.5 * np.pi - angle if turned else angle)
        corner += 0.5 * most * ((radial.integral(near * np.cosh(u)) * factor / np.cosh(u)) @ weights)
    corner[0, :] *= -1.0 if odd_x else 1.0
    corner[:, 0] *= -1.0 if odd_y else 1.0
    return corner


@dataclass(frozen=True)
class LayeredBody:
    """A half-space of `substrate` (Young's modulus in Pa, Poisson's ratio) under `layers` from the surface down, one at least.

    Tables are displacements (m/Pa, (nx, ny), offsets ≥ 0) of a uniformly loaded element of dx × dy (m) less those on a
    half-space of the top material."""

    layers: tuple[Layer, ...]
    substrate: tuple[float, float]

    @property
    def thickness(self) -> float:
        return sum(layer.thickness for layer in self.layers)

    @cached_property
    def _wave_numbers(self) -> Array:
        thinnest = min(layer.thickness for layer in self.layers)
        low, high = np.log(FIRST_WAVE_NUMBER / self.thickness), np.log(LAST_WAVE_NUMBER / thinnest)
        return np.exp(np.arange(low, high, STEP))

    @cached_property
    def _compliance(self) -> SurfaceCompliance:
        return difference_compliance(self.layers, self.substrate, self._wave_numbers)

    @cached_property
    def _radials(self) -> dict[str, RadialDifference]:
        """Point-load displacements: u_z under p, the two parts of u under q, u_x under p."""
        c = self._compliance
        symbols = {"normal": (0, c.nn), "isotropic": (0, 0.5 * (c.tt + c.ss)), "directional": (2, 0.5 * (c.tt - c.ss)),
                   "coupling": (1, c.tn)}
        return {name: _radial(order, self._wave_numbers, symbol, self.thickness) for name, (order, symbol) in symbols.items()}

    def _integral(self, radial: str, angular: str, shape: tuple[int, int], dx: float, dy: float) -> Array:
        return element_integral(self._radials[radial], angular, shape, dx, dy)

    def normal_table(self, shape: tuple[int, int], dx: float, dy: float) -> Array:
        """u_z under p."""
        return self._integral("normal", "even", shape, dx, dy)

    def shear_tables(self, shape: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array, Array]:
        """u_x under q_x, u_y under q_y, u_x under q_y."""
        even = self._integral("isotropic", "even", shape, dx, dy)
        along, cross = (self._integral("directional", angular, shape, dx, dy) for angular in ("cos2", "sin2"))
        return even - along, even + along, -cross

    def coupling_tables(self, shape: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array]:
        """u_x and u_y under p."""
        along = -self._integral("coupling", "cos", shape, dx, dy)
        if shape[0] == shape[1] and dx == dy:
            return along, along.T
        return along, -self._integral("coupling", "cos", shape[::-1], dy, dx).T

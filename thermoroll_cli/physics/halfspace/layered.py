"""Elastic half-spaces with bonded layers: compliance in wave numbers, and its difference to a half-space of the top material.

Wave vector k along x, z into the body: u_x = iV, u_z = W, σ_xz = iT, σ_zz = S, all real. In a layer, downward solutions carry
e^{−kz} and upward ones e^{−kζ}, ζ from its lower face, so nothing grows:

    (V, W) = D_u N(kz) α,   (T, S)/2k = D_s N(kz) α,   N(t) = [[1, t], [0, 1]],   upward: mirrored by R = diag(1, −1).

Impedances (T, S)/2k = Z (V, W) are carried from the substrate to the surface. The surface compliance is returned as the
difference to the half-space of the top material, so that equal materials give exactly zero and nothing cancels. Across the wave
vector the problem is scalar. Source: the stiffness-matrix method for layered media (Kausel & Roësset 1981), in reflection form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import accumulate
from typing import Literal, NamedTuple

import numpy as np
import scipy

from thermoroll_cli.physics.halfspace.oscillations import strip_response, up_to_a_constant
from thermoroll_cli.physics.numerics.quadrature import gauss_points
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.tools.arrays import AnyArray, Array

MIRROR = np.diag([1.0, -1.0])
TableKind = Literal["normal", "shear", "coupling"]


class SurfaceCompliance(NamedTuple):
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
class Constants:
    """Shear modulus, D_u, D_s, and the impedances of downward and of upward solutions, of one material."""

    shear_modulus: float
    displacement: Array
    stress: Array
    down: Array
    up: Array

    @classmethod
    def of(cls, youngs_modulus: float, poisson_ratio: float) -> Constants:
        shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio)
        displacement = np.array([[1.0, 0.0], [-1.0, 4.0 * poisson_ratio - 3.0]])
        stress = np.multiply.outer(shear_modulus, [[-1.0, 2.0 * poisson_ratio - 1.0], [1.0, 2.0 * (1.0 - poisson_ratio)]])
        downward = stress @ np.linalg.inv(displacement)
        return cls(shear_modulus, displacement, stress, downward, -MIRROR @ downward @ MIRROR)


class _Reflections(NamedTuple):
    """A layer on the layers below it, at all wave numbers: N at its lower face, `decay` e^{−kh} across it, the `reflection` of
    downward solutions at its lower face (without decay), their `echo` as displacements at its upper face."""

    own: Constants
    propagation: Array
    decay: Array
    reflection: Array
    echo: Array


def _reflections(layers: Sequence[Layer], substrate: tuple[float, float], wave_numbers: Array) -> list[_Reflections]:
    """All layers, from the surface down."""
    count = wave_numbers.size
    stack: list[_Reflections] = []
    impedance = np.broadcast_to(Constants.of(*substrate).down, (count, 2, 2))
    for layer in reversed(layers):
        own = Constants.of(layer.youngs_modulus, layer.poisson_ratio)
        phase = wave_numbers * layer.thickness
        propagation = np.tile(np.eye(2), (count, 1, 1))
        propagation[:, 0, 1] = phase
        downward, upward = own.displacement @ propagation, MIRROR @ own.displacement
        reflection = -np.linalg.inv(upward) @ np.linalg.solve(own.up - impedance, own.down - impedance) @ downward
        echo = upward @ propagation @ reflection * np.exp(-2.0 * phase)[:, None, None]
        impedance = own.down + (own.up - own.down) @ echo @ np.linalg.inv(own.displacement + echo)
        stack.insert(0, _Reflections(own, propagation, np.exp(-phase)[:, None, None], reflection, echo))
    return stack


def difference_compliance(layers: Sequence[Layer], substrate: tuple[float, float], wave_numbers: Array) -> SurfaceCompliance:
    """k times (compliance of the layered half-space − compliance of a half-space of the top material), at `wave_numbers` (n,).

    `layers` from the surface down; `substrate` has Young's modulus (Pa) and Poisson's ratio."""
    antiplane = np.full(wave_numbers.size, Constants.of(*substrate).shear_modulus)
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
    coefficients: list[tuple[Array, Array]] = []
    face = np.empty(0)
    for number, layer in enumerate(_reflections(layers, substrate, wave_numbers)):
        own = layer.own
        down = np.asarray(np.linalg.solve(own.displacement + layer.echo, face) if number
                          else np.linalg.inv(own.stress + own.up @ layer.echo))
        up = np.asarray(layer.reflection @ down * layer.decay)
        face = own.displacement @ layer.propagation @ down * layer.decay + MIRROR @ own.displacement @ up
        coefficients.append((down, up))
    return coefficients, np.asarray(np.linalg.inv(Constants.of(*substrate).displacement) @ face)


STEP = 0.02
"""Step of the logarithmic grids of wave numbers and radii."""
FIRST_WAVE_NUMBER, LAST_WAVE_NUMBER = 1e-9, 1e6
"""Smallest wave number times the total thickness, or the depth: without its limit the symbol is proportional to k there.
Largest wave number times the thinnest layer: radii begin at its inverse."""


@dataclass(frozen=True)
class RadialFunctions:
    """Responses to point loads H(r) = ∫ b(k) J_m(kr) dk/2π by name: r H as splines over ln r, and the splines of ∫ H r dr,
    between the radii `ends`. Before them H is even, beyond them it decays like 1/r."""

    names: tuple[str, ...]
    weighted: scipy.interpolate.BSpline
    primitive: scipy.interpolate.BSpline
    ends: tuple[float, float]

    @classmethod
    def of(cls, symbols: Mapping[str, tuple[int, Array]], wave_numbers: Array, depth: float) -> RadialFunctions:
        """Hankel transforms of orders m and symbols b, by name, by FFTLog (Hamilton 2000, MNRAS 312).

        The limit b₀ at small k, which decays like 1/r, is taken out as b₀ e^{−kz}, z = `depth`, whose transform is closed
        form."""
        r, columns = 1.0 / wave_numbers[::-1], []
        distance = np.hypot(r, depth)
        for order, symbol in symbols.values():
            transform = scipy.fft.fht(symbol - symbol[0] * np.exp(-wave_numbers * depth), STEP, order)
            columns.append((transform + symbol[0] * r * (r / (distance + depth)) ** order / distance) / (2.0 * np.pi))
        weighted, log_r = np.stack(columns, axis=1), np.log(r)
        return cls(tuple(symbols), scipy.interpolate.make_interp_spline(log_r, weighted, 5),
                   scipy.interpolate.make_interp_spline(log_r, weighted * r[:, None], 5).antiderivative(),
                   (float(r[0]), float(r[-1])))

    def only(self, names: Sequence[str]) -> RadialFunctions:
        """Those of the `names`, in their order."""
        columns = [self.names.index(name) for name in names]
        weighted, primitive = (scipy.interpolate.BSpline(spline.t, spline.c[:, columns], spline.k)
                               for spline in (self.weighted, self.primitive))
        return RadialFunctions(tuple(names), weighted, primitive, self.ends)

    def __call__(self, r: Array) -> Array:
        """H, (…, functions)."""
        inside = np.clip(r, *self.ends)
        return np.asarray(self.weighted(np.log(inside)) / np.where(r < self.ends[0], inside, r)[..., None])

    def integral(self, r: Array) -> Array:
        """∫_0^r H r dr, (…, functions)."""
        inside = np.clip(r, *self.ends)
        first, beyond = self.weighted(np.log(self.ends[0])), np.maximum(r - self.ends[1], 0.0)[..., None]
        within = 0.5 * np.minimum(r, self.ends[0]) ** 2 / self.ends[0]
        return np.asarray(self.primitive(np.log(inside)) + first * within[..., None]
                          + (self.weighted(np.log(inside)) * beyond if beyond.any() else 0.0))


DEEPEST = 30.0
"""Wave number times the thickness of the uppermost layer above which its material is all there is."""

NEAR = 3.5
"""Offsets in elements up to which an element is integrated in polar coordinates about the point where it is seen."""
ANGLES = 24
"""Gauss points on each of the two far sides of a corner."""
GAUSS = ((60.0, 2), (14.0, 3), (6.0, 4), (NEAR, 6))
"""Distances in elements, and the Gauss points per side beyond each."""
WEIGHTS: dict[str, Callable[[Array, Array], Array]] = {
    "even": lambda c, s: np.ones_like(c), "cos": lambda c, s: c, "sin": lambda c, s: s,
    "cos2": lambda c, s: c * c - s * s, "sin2": lambda c, s: 2.0 * s * c,
    "cos3": lambda c, s: c * (c * c - 3.0 * s * s), "sin3": lambda c, s: s * (3.0 * c * c - s * s),
}
"""Angular factors of the response to a point load, from cos θ and sin θ."""


def element_integrals(
    radial: RadialFunctions, parts: Sequence[tuple[str, str]], shape: tuple[int, int], dx: float, dy: float
) -> list[Array]:
    """∬ H(r) w(θ) over one dx × dy element, seen from element centres at offsets (i dx, j dy), i < nx, j < ny: (nx, ny) each.

    `parts` name H in `radial` and w in `WEIGHTS`, with θ the direction from the load to the point."""
    names = list(dict.fromkeys(name for name, _ in parts))
    radial, pairs = radial.only(names), [(names.index(name), angular) for name, angular in parts]
    tables = [np.empty(shape) for _ in parts]
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    far = np.maximum(i * dx, j * dy) / max(dx, dy)
    last = np.inf
    for start, points in GAUSS:
        here = (far > start) & (far <= last)
        last = start
        nodes, weights = gauss_points(points)
        x = (i[here][:, None, None] + 0.5 * nodes[:, None]) * dx
        y = (j[here][:, None, None] + 0.5 * nodes) * dy
        r = np.hypot(x, y)
        values, c, s = radial(r) * (0.25 * dx * dy * np.outer(weights, weights)[..., None]), x / r, y / r
        for table, (number, angular) in zip(tables, pairs, strict=True):
            table[here] = np.einsum("nij,nij->n", values[..., number], WEIGHTS[angular](c, s))
    near = np.argwhere(far <= NEAR)
    if near.size:
        count_x, count_y = near.max(axis=0) + 1
        corners = _corner_integrals(radial, pairs, count_x, count_y, dx, dy)
        for table, corner in zip(tables, corners, strict=True):
            element = corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]
            table[near[:, 0], near[:, 1]] = element[near[:, 0], near[:, 1]]
    return tables


def _corner_integrals(
    radial: RadialFunctions, parts: Sequence[tuple[int, str]], count_x: int, count_y: int, dx: float, dy: float
) -> Array:
    """∬ from the origin to ((i − ½) dx, (j − ½) dy), i ≤ count_x, j ≤ count_y: (parts, count_x + 1, count_y + 1)."""
    nodes, weights = gauss_points(ANGLES)
    x, y = (np.abs(np.arange(n + 1) - 0.5) * d for n, d in ((count_x, dx), (count_y, dy)))
    ratio = y[None, :] / x[:, None]
    corners = np.zeros((len(parts), *ratio.shape))
    # Along the far side r = x cosh u with sinh u = tan θ, which is smooth in u for long elements, too.
    for near, most, turned in ((x[:, None, None], np.arcsinh(ratio), False), (y[None, :, None], np.arcsinh(1.0 / ratio), True)):
        u = 0.5 * most[..., None] * (1.0 + nodes)
        cosine, sine = 1.0 / np.cosh(u), np.tanh(u)
        values = radial.integral(near / cosine) * (0.5 * most[..., None] * cosine * weights)[..., None]
        for corner, (number, angular) in zip(corners, parts, strict=True):
            corner += (values[..., number] * WEIGHTS[angular](*((sine, cosine) if turned else (cosine, sine)))).sum(axis=-1)
    for corner, (_, angular) in zip(corners, parts, strict=True):
        # Integrals of even functions are odd.
        corner[0, :] *= 1.0 if angular in ("cos", "cos3", "sin2") else -1.0
        corner[:, 0] *= 1.0 if angular.startswith("sin") else -1.0
    return corners


@dataclass(frozen=True)
class LayeredBody:
    """A half-space of `substrate` (Young's modulus in Pa, Poisson's ratio) under `layers` from the surface down, one at least.

    Tables are displacements (m/Pa, (nx, ny), offsets ≥ 0) of a uniformly loaded element of dx × dy (m) less those on a
    half-space of the top material."""

    layers: tuple[Layer, ...]
    substrate: tuple[float, float]

    @staticmethod
    @lru_cache(maxsize=16)
    def of(material: Material) -> LayeredBody:
        """The layers of `material` on their body."""
        return LayeredBody(material.layers, (material.youngs_modulus, material.poisson_ratio))

    @property
    def thickness(self) -> float:
        return sum(layer.thickness for layer in self.layers)

    @cached_property
    def interfaces(self) -> tuple[float, ...]:
        """Depth of the lower face of each layer."""
        return tuple(accumulate(layer.thickness for layer in self.layers))

    def wave_numbers(self, depth: float = 0.0) -> Array:
        """Nodes of transforms in 1/m, for responses down to a `depth` (m)."""
        thinnest = min(layer.thickness for layer in self.layers)
        low, high = np.log(FIRST_WAVE_NUMBER / max(self.thickness, depth)), np.log(LAST_WAVE_NUMBER / thinnest)
        return np.exp(np.arange(low, high, STEP))

    @cached_property
    def _radials(self) -> RadialFunctions:
        """Point-load displacements: u_z under p, the two parts of u under q, u_x under p."""
        c = difference_compliance(self.layers, self.substrate, self.wave_numbers())
        symbols = {"normal": (0, c.nn), "isotropic": (0, 0.5 * (c.tt + c.ss)), "directional": (2, 0.5 * (c.tt - c.ss)),
                   "coupling": (1, c.tn)}
        return RadialFunctions.of(symbols, self.wave_numbers(), self.thickness)

    @lru_cache(maxsize=32)  # noqa: B019 - points of a sweep share them, and few bodies are kept
    def tables(self, kind: TableKind, shape: tuple[int, int], dx: float, dy: float) -> tuple[Array, ...]:
        """u_z under p ("normal"); u_x under q_x, u_y under q_y, u_x under q_y ("shear"); u_x and u_y under p ("coupling")."""
        if math.isinf(dy):
            return self._strip_tables(kind, shape, dx)
        parts = {"normal": [("normal", "even")], "coupling": [("coupling", "cos"), ("coupling", "sin")],
                 "shear": [("isotropic", "even"), ("directional", "cos2"), ("directional", "sin2")]}[kind]
        integrals = element_integrals(self._radials, parts, shape, dx, dy)
        if kind == "shear":
            even, along, cross = integrals
            return even - along, even + along, -cross
        return tuple(integrals) if kind == "normal" else tuple(-table for table in integrals)

    def _strip_tables(self, kind: TableKind, shape: tuple[int, int], dx: float) -> tuple[Array, ...]:
        """Those of a strip without ends, beside which there is no other; what moves the body as a whole is left out."""
        names, count = {"normal": (("nn",), 1), "shear": (("tt", "ss"), 3), "coupling": (("tn",), 2)}[kind]

        def symbols(k: Array) -> AnyArray:
            waves = np.maximum(k, FIRST_WAVE_NUMBER / self.thickness)
            compliance = difference_compliance(self.layers, self.substrate, waves)
            parts = np.stack([getattr(compliance, name) for name in names], axis=1) / k[:, None]
            return parts * 1j if kind == "coupling" else parts

        ahead = strip_response(symbols, shape[0], dx, DEEPEST / self.layers[0].thickness)[shape[0] - 1 :]
        if kind == "coupling":
            ahead[0] = 0.0
        else:
            ahead = up_to_a_constant(ahead)
        tables = np.zeros((count, *shape))
        tables[: len(names), :, 0] = ahead.T
        return tuple(tables)

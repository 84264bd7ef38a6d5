"""Influence tables of bodies that relax while they pass the contact: what their memory adds to the instantaneous tables.

Material flows along x with the speed V. A surface whose compliance grows as J(t) = J₀ [1 + Σ cⱼ (1 − e^{−t/θⱼ})] under constant
Poisson's ratio moves, in every component, by

    u(x) = J₀ [u₁(x) + Σ cⱼ ∫₀^∞ e^{−s/lⱼ} u₁(x − s) ds/lⱼ],      lⱼ = V θⱼ,

where J₀ u₁ is the displacement of the elastic surface. So each influence table T has the further part J₀ Σ cⱼ T̃ⱼ with the
one-sided exponential mean T̃ of T. Between elements u₁ is the cubic through its next four values, whose mean is exact:

    T̃(x + h) = q T̃(x) + Σ wₖ T(x + kh),  k = −1 … 2,      q = e^{−h/l},

begun upstream from a quadrature of the far field. As a filter of waves e^{iθx/h} this is Σ wₖ e^{i(k−1)θ}/(1 − q e^{−iθ}).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from thermoroll_cli.physics.halfspace.coatings import UNCOUPLED, Coatings
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, coupling_tables, rectangle_integrals
from thermoroll_cli.physics.halfspace.oscillations import strip_response, up_to_a_constant
from thermoroll_cli.physics.halfspace.relaxing_layers import Part, RelaxingLayers, added_by_memory
from thermoroll_cli.physics.numerics.quadrature import gauss_points
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.problem.relaxation import modulus_at
from thermoroll_cli.tools.arrays import AnyArray, Array, Spectrum

STENCIL = (-1, 0, 1, 2)
"""Rows, from the one upstream of the interval, through which the displacement is interpolated."""
_LAGRANGE = np.linalg.inv(np.vander(np.array(STENCIL, dtype=np.float64), increasing=True))
"""Coefficients of tʲ (rows) of the cubics that are 1 at one place of the stencil (columns)."""
_NODES, _WEIGHTS = gauss_points(8)
BORDER, TOLERABLE_LOSS = 4.0, 0.5
"""Elements along x over which a border is fitted, and the loss tangent in the time they take at which half of the fit counts.
Without: at ten times the compliance and l = a it adds 7 % to the largest pressure on 64 elements (with it 0.3 %)."""
EDGES = 0.5 ** np.arange(2, 18)
"""Places behind the leading edge, over the half-length of the contact, where a maximum of the pressure is looked for."""
FADED = 40.0
"""Lengths of memory after which nothing is left of it."""

Kernel = Callable[[Array, Array, float], Array]
POINT_LOADS: dict[str, tuple[int, Kernel]] = {
    "xx": (1, lambda x, y, z: (x * x + z * z) / _distance(x, y, z) ** 3),
    "yy": (1, lambda x, y, z: (y * y + z * z) / _distance(x, y, z) ** 3),
    "xy": (-1, lambda x, y, z: x * y / _distance(x, y, z) ** 3),
    "x": (-1, lambda x, y, z: _radial(x, y, z) * x),
    "y": (1, lambda x, y, z: _radial(x, y, z) * y),
    "blob": (1, lambda x, y, z: z / _distance(x, y, z) ** 3),
}
"""Parity along x, and integrand, of the integrals I_xx, I_yy, I_xy, J_x and J_y of `elastic` at z = 0. With a depth z their
transforms have the factor (1 + kz) e^{−kz}; that of the blob, for z > 0 alone, is 2π e^{−kz}."""


def _distance(x: Array, y: Array, z: float) -> Array:
    return np.asarray(np.hypot(np.hypot(x, y), z))


def _radial(x: Array, y: Array, z: float) -> Array:
    distance = _distance(x, y, z)
    return 1.0 / (distance * (distance + z)) + z / distance**3


def weights(ratio: float) -> tuple[float, Array]:
    """q and the four wₖ for `ratio` = h/l."""
    # Moments a ∫₀¹ e^{−a(1 − t)} tʲ dt: by quadrature for small a, where their recursion loses digits.
    if ratio < FADED:
        nodes, gauss = gauss_points(48)
        t = 0.5 * (1.0 + nodes)
        moments = np.array([float(np.sum(0.5 * gauss * ratio * np.exp(-ratio * (1.0 - t)) * t**j)) for j in range(4)])
    else:
        moments = np.ones(4)
        for j in range(1, 4):
            moments[j] = 1.0 - j / ratio * moments[j - 1]
    return math.exp(-ratio), moments @ _LAGRANGE


def filter_of(ratio: float, theta: Array) -> AnyArray:
    """The mean as a factor of waves, complex, for `ratio` = h/l and phases `theta` per element."""
    q, w = weights(ratio)
    terms = (weight * np.exp(1j * (k - 1) * theta) for k, weight in zip(STENCIL, w, strict=True))
    return np.asarray(sum(terms) / (1.0 - q * np.exp(-1j * theta)))


def one_sided_means(
    kind: str, rows: int, columns: int, dx: float, dy: float, lengths: Array, depth: float = 0.0
) -> Array:
    """The means over `lengths` (m) of an integral of `POINT_LOADS` over an element, or of its integrand at a `depth` (m) times
    the element's area, at offsets −(rows − 1) … rows − 1 by 0 … columns − 1, in m (the blob: in 1): (lengths, 2 rows − 1,
    columns)."""
    along, kernel = POINT_LOADS[kind]
    place = rows + 1, columns, dx, dy
    if depth:
        quadrant = dx * dy * kernel(dx * np.arange(rows + 1.0)[:, None], dy * np.arange(float(columns)), depth)
    elif len(kind) == 2:
        quadrant = dict(zip(("xx", "yy", "xy"), rectangle_integrals(*place), strict=True))[kind]
    else:
        quadrant = dict(zip(("x", "y"), coupling_tables(*place), strict=True))[kind]
    table = np.concatenate([along * quadrant[:0:-1], quadrant])
    means = np.empty((len(lengths), 2 * rows - 1, columns))
    for mean, length in zip(means, lengths, strict=True):
        q, w = weights(dx / length)
        mean[0] = _upstream(kernel, (rows - 1) * dx, columns, dx, dy, float(length), depth)
        count = len(mean) - 1
        mean[1:] = sum(weight * table[1 + k : 1 + k + count] for k, weight in zip(STENCIL, w, strict=True))
        for i in range(count):
            mean[i + 1] += q * mean[i]
    return means


def _upstream(kernel: Kernel, distance: float, columns: int, dx: float, dy: float, length: float, depth: float) -> Array:
    """The mean at the offset −`distance` along x, where the element is far away; (columns,)."""
    # Panels that double from the smaller of both scales.
    first = 0.5 * min(distance, length)
    edges = np.append(0.0, first * 2.0 ** np.arange(math.ceil(math.log2(FADED * length / first)) + 1))
    half = 0.5 * np.diff(edges)[:, None]
    s = edges[:-1, None] + half * (1.0 + _NODES)
    weight = (half * _WEIGHTS * np.exp(-s / length)).ravel() / length
    x, y = -distance - s.ravel(), dy * np.arange(columns)
    points = (1, 1) if depth else (2, min(2 + math.ceil(3.0 * dy / distance), 64))
    (u, along), (v, across) = (gauss_points(n) for n in points)
    total = np.zeros(columns)
    for shift_x, part_x in zip(0.5 * dx * u, along, strict=True):
        for shift_y, part_y in zip(0.5 * dy * v, across, strict=True):
            total += part_x * part_y * (weight @ kernel(x[:, None] + shift_x, y + shift_y, depth))
    return 0.25 * dx * dy * total


class Memory(NamedTuple):
    """One retardation time of one body, or of both: `length` l (m), and c times the compliances of the body (1/Pa): normal
    1/(πE*), the tangential ones of `ShearCompliance`, and that of the coupling with its sign in `elastic.coupling_constant`."""

    length: float
    normal: float
    isotropic: float
    directional: float
    coupling: float


def _memories(body: Material, sign: float, speed: float) -> list[Memory]:
    """Those of the surface of one body, whose coupling has a `sign`."""
    top = body.surface
    shear, nu = 2.0 * math.pi * top.shear_modulus, top.poisson_ratio
    return [Memory(speed * time, c / (math.pi * top.plane_strain_modulus), c * (1.0 - nu) / shear, c * nu / shear,
                   0.5 * sign * c * (1.0 - 2.0 * nu) / shear) for c, time in top.retardation]


def _means(
    memories: list[Memory], factors: dict[str, str], rows: int, columns: int, dx: float, dy: float, depth: float = 0.0
) -> Array:
    """Sum of the means of integrals times the named compliances of each memory, (2 rows − 1, columns)."""
    lengths = np.array([memory.length for memory in memories])
    total = np.zeros((2 * rows - 1, columns))
    for kind, names in factors.items():
        factor = np.array([sum(getattr(memory, name) for name in names.split()) for memory in memories])
        if factor.any():
            total += np.tensordot(factor, one_sided_means(kind, rows, columns, dx, dy, lengths, depth), 1)
    return total


OF_STRIPS = {"nn": "nn", "xx": "tt", "yy": "ss", "x": "tn"}
"""Tables of strips that are not zero, and the compliance of each."""
EVEN = {"nn": "nn", "xx": "tt", "yy": "tt"}
"""Tables with a part by layers that are compressed and sheared evenly, and its name in `RelaxingLayers.even`."""


@dataclass(frozen=True)
class Relaxing:
    """Both bodies of a contact without thermal constants. At least one of them relaxes."""

    lower: Material
    upper: Material
    speed: float

    @classmethod
    def of(cls, lower: Material, upper: Material, speed: float) -> Relaxing | None:
        """None if nothing relaxes."""
        if not (lower.surface.relaxation or upper.surface.relaxation):
            return None
        first, second = (Material(body.youngs_modulus, body.poisson_ratio, layers=body.elastic_layers,
                                  relaxation=body.relaxation) for body in (lower, upper))
        return cls(first, second, speed)

    @property
    def memories(self) -> list[Memory]:
        """All of them; equal lengths of both bodies are one."""
        found: dict[float, Memory] = {}
        for body, sign in self._bodies:
            for memory in _memories(body, sign, self.speed):
                before = found.get(memory.length)
                found[memory.length] = memory if before is None else Memory(memory.length, *(
                    one + other for one, other in zip(before[1:], memory[1:], strict=True)))
        return list(found.values())

    @property
    def _bodies(self) -> list[tuple[Material, float]]:
        """Both with the signs of their coupling."""
        return [(self.lower, 1.0), (self.upper, -1.0)]

    @property
    def _layered(self) -> list[tuple[Material, float]]:
        return [(body, sign) for body, sign in self._bodies if body.surface.relaxation and body.layers]

    def _table(self, factors: dict[str, str], name: str, rows: int, columns: int, dx: float, dy: float) -> Array:
        """Sum of the means of integrals times the named compliances of each memory, (2 rows − 1, columns); of layers less their
        images, and with what remains in the table `name`."""
        if math.isinf(dy):
            return self._strip_table(name, rows, columns, dx)
        place = rows, columns, dx, dy
        total = _means(self.memories, factors, *place)
        for body, sign in self._layered:
            layers = RelaxingLayers.of(body, self.speed)
            total -= _means(_memories(body, sign, self.speed), factors, *place, layers.depth(dx, dy))
            part: Part = "normal" if name == "nn" else "shear" if len(name) == 2 else "coupling"
            total += (sign if part == "coupling" else 1.0) * layers.remaining_tables(part, *place)[name]
            for layer in body.layers if name in EVEN else ():
                blobs = np.array([c * layers.even(layer)[EVEN[name]] / (2.0 * math.pi) for c, _ in layer.retardation])
                lengths = np.array([self.speed * time for _, time in layer.retardation])
                if blobs.any():
                    total += np.tensordot(blobs, one_sided_means("blob", *place, lengths, layers.depth(dx, dy)), 1)
        return total

    def _strip_table(self, name: str, rows: int, columns: int, dx: float) -> Array:
        """`_table` of a strip without ends, from its response to waves; what moves the bodies as a whole is left out."""
        table, part = np.zeros((2 * rows - 1, columns)), OF_STRIPS.get(name)
        if part is None:
            return table

        def symbol(k: Array) -> AnyArray:
            lower, upper = (added_by_memory(body, self.speed, k)[part] for body, _ in self._bodies)
            return np.asarray((-1j * (lower - upper) if part == "tn" else lower + upper) / k)

        response = strip_response(symbol, rows, dx)
        table[:, 0] = response if part == "tn" else up_to_a_constant(response)
        return table

    def normal_table(self, rows: int, columns: int, dx: float, dy: float) -> Array:
        """To be added to `elastic.normal_table`, at offsets −(rows − 1) … rows − 1 along x."""
        return self._table({"xx": "normal", "yy": "normal"}, "nn", rows, columns, dx, dy)

    def shear_tables(self, rows: int, columns: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
        """To be added to `elastic.shear_tables`, at the same offsets."""
        place = rows, columns, dx, dy
        return (self._table({"xx": "isotropic directional", "yy": "isotropic"}, "xx", *place),
                self._table({"xx": "isotropic", "yy": "isotropic directional"}, "yy", *place),
                self._table({"xy": "directional"}, "xy", *place))

    def coupling_tables(self, rows: int, columns: int, dx: float, dy: float) -> tuple[Array, Array]:
        """To be added to K times `elastic.coupling_tables`, at the same offsets."""
        place = rows, columns, dx, dy
        return self._table({"x": "coupling"}, "x", *place), self._table({"y": "coupling"}, "y", *place)

    def relaxed_modulus(self, contact_modulus: float) -> float:
        """E* (Pa) of both surfaces together after a long time, from the instantaneous one."""
        return 1.0 / (1.0 / contact_modulus + math.pi * sum(memory.normal for memory in self.memories))

    def periodic_symbol(self, symbol: Array, padded: tuple[int, int], dx: float, dy: float, modulus: float) -> Spectrum:
        """The symbol of the normal displacement on a periodic plane, complex, from the instantaneous one; `modulus` is E* (Pa)
        of the surfaces."""
        theta = np.asarray(2.0 * np.pi * np.fft.fftfreq(padded[0]), dtype=np.float64)
        layered = [RelaxingLayers.of(body, self.speed) for body, _ in self._layered]
        half_spaces = [memory for body, sign in self._bodies if not body.layers for memory in _memories(body, sign, self.speed)]
        factor = np.ones(theta.size, dtype=np.complex128)
        for memory in half_spaces:
            factor += math.pi * modulus * memory.normal * filter_of(dx / memory.length, theta)
        if not layered:
            return np.asarray(symbol * factor)
        theta_y = np.asarray(2.0 * np.pi * np.fft.rfftfreq(padded[1])[:, None] * math.isfinite(dy), dtype=np.float64)
        x, y = theta / dx, theta_y / dy
        longest = padded[0] * dx if math.isinf(dy) else max(padded[0] * dx, padded[1] * dy)
        k = np.maximum(np.hypot(x, y), np.pi / longest)
        added = np.stack([2.0 / modulus * (factor - 1.0) * np.ones_like(k), *(layers.whole(x, y) for layers in layered)])
        return np.asarray(symbol + added.sum(axis=0) / k * np.sinc(0.5 * theta / np.pi) * np.sinc(0.5 * theta_y / np.pi))

    def felt(self, length: float) -> tuple[tuple[Material, Material], float]:
        """Elastic bodies that stand for these within a `length` (m) along x, with the moduli |E| at the frequency V/length, and
        the larger loss tangent of both surfaces there."""
        bodies, loss = [], 0.0
        for body in (self.lower, self.upper):
            own = surface = modulus_at(body.relaxation, self.speed / length)
            layers: list[Layer] = []
            for layer in reversed(body.layers):
                surface = modulus_at(layer.relaxation, self.speed / length)
                layers.insert(0, replace(layer, youngs_modulus=layer.youngs_modulus * abs(surface), relaxation=()))
            bodies.append(replace(body, youngs_modulus=body.youngs_modulus * abs(own), layers=tuple(layers), relaxation=()))
            loss = max(loss, surface.imag / surface.real)
        return (bodies[0], bodies[1]), loss

    def near_border(self, dx: float, dy: float, interlayer: float = 0.0) -> ShearCompliance:
        """Half-spaces that describe the bodies within an element of dx × dy (m): with the moduli at the frequency V/dx. Where
        much is lost in the time in which a few elements pass, no modulus does."""
        near = Coatings(*self.felt(dx)[0]).near_border(dx, dy, interlayer)
        trust = near.trust / (1.0 + (self.felt(BORDER * dx)[1] / TOLERABLE_LOSS) ** 4)
        return replace(near, trust=trust)

    @property
    def surface_modulus(self) -> float:
        """E* of the surfaces' materials in Pa, instantaneous."""
        return Coatings(self.lower, self.upper).surface_modulus

    def softening(self, length: float) -> float:
        """Compliance of both surfaces together within a `length` (m) along x over the instantaneous one."""
        return self.surface_modulus / Coatings(*self.felt(length)[0]).surface_modulus

    def leading_edge(self, half: float) -> tuple[float, float]:
        """Place (m behind the leading edge of a contact of length 2 `half`, m) and height, over the pressure in the middle, of
        the maximum that material not yet relaxed makes there.

        Far behind the edge p ≈ p_m √(2s/a); within s of it the modulus is that of the frequency V/s, in place of V/a."""
        places = half * EDGES
        heights = [math.sqrt(2.0 * place / half) * self.softening(half) / self.softening(place) for place in places]
        highest = int(np.argmax(heights))
        return float(places[highest]), heights[highest]

    def dundurs_beta(self, constant: float, contact_modulus: float) -> float:
        """The largest β (`DerivedQuantities.dundurs_beta`) of any time scale, the bodies relaxed as far as it allows; from the
        instantaneous K (1/Pa) and E* (Pa)."""
        largest, coupling, normal = math.pi * contact_modulus * constant, constant, 1.0 / (math.pi * contact_modulus)
        for memory in sorted(self.memories, key=lambda memory: memory.length):
            coupling, normal = coupling + memory.coupling, normal + memory.normal
            largest = max(largest, coupling / normal, key=abs)
        return 0.0 if abs(largest) <= UNCOUPLED else largest

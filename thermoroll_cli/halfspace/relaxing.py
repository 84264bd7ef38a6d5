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

import numpy as np

from thermoroll_cli.arrays import AnyArray, Array, Spectrum
from thermoroll_cli.halfspace.coatings import UNCOUPLED, Coatings, NearBorder
from thermoroll_cli.halfspace.elastic import coupling_tables, rectangle_integrals
from thermoroll_cli.problem.problem import Layer, Material
from thermoroll_cli.problem.relaxation import modulus_at

STENCIL = (-1, 0, 1, 2)
"""Rows, from the one upstream of the interval, through which the displacement is interpolated."""
_LAGRANGE = np.linalg.inv(np.vander(np.array(STENCIL, dtype=np.float64), increasing=True))
"""Coefficients of tʲ (rows) of the cubics that are 1 at one place of the stencil (columns)."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
BORDER, TOLERABLE_LOSS = 4.0, 0.5
"""Elements along x over which a border is fitted, and the loss tangent in the time they take at which half of the fit counts.
Without: at ten times the compliance and l = a it adds 7 % to the largest pressure on 64 elements (with it 0.3 %)."""
FADED = 40.0
"""Lengths of memory after which nothing is left of it."""

Kernel = Callable[[Array, Array], Array]
POINT_LOADS: dict[str, tuple[int, int, Kernel]] = {
    "xx": (1, 1, lambda x, y: x * x / np.hypot(x, y) ** 3),
    "yy": (1, 1, lambda x, y: y * y / np.hypot(x, y) ** 3),
    "xy": (-1, -1, lambda x, y: x * y / np.hypot(x, y) ** 3),
    "x": (-1, 1, lambda x, y: x / (x * x + y * y)),
    "y": (1, -1, lambda x, y: y / (x * x + y * y)),
}
"""Parities along x and y, and integrand, of the integrals I_xx, I_yy, I_xy, J_x and J_y of `elastic`."""


def weights(ratio: float) -> tuple[float, Array]:
    """q and the four wₖ for `ratio` = h/l."""
    # Moments a ∫₀¹ e^{−a(1 − t)} tʲ dt: by quadrature for small a, where their recursion loses digits.
    if ratio < FADED:
        nodes, gauss = np.polynomial.legendre.leggauss(48)
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


def one_sided_means(kind: str, rows: int, columns: int, dx: float, dy: float, lengths: Array) -> Array:
    """The means over `lengths` (m) of an integral of `POINT_LOADS` at offsets −(rows − 1) … rows − 1 by 0 … columns − 1, in m:
    (lengths, 2 rows − 1, columns)."""
    along, _, kernel = POINT_LOADS[kind]
    place = rows + 1, columns, dx, dy
    quadrant = (dict(zip(("xx", "yy", "xy"), rectangle_integrals(*place), strict=True)) if len(kind) == 2
                else dict(zip(("x", "y"), coupling_tables(*place), strict=True)))[kind]
    table = np.concatenate([along * quadrant[:0:-1], quadrant])
    means = np.empty((len(lengths), 2 * rows - 1, columns))
    for mean, length in zip(means, lengths, strict=True):
        q, w = weights(dx / length)
        mean[0] = _upstream(kernel, (rows - 1) * dx, columns, dx, dy, float(length))
        count = len(mean) - 1
        mean[1:] = sum(weight * table[1 + k : 1 + k + count] for k, weight in zip(STENCIL, w, strict=True))
        for i in range(count):
            mean[i + 1] += q * mean[i]
    return means


def _upstream(kernel: Kernel, distance: float, columns: int, dx: float, dy: float, length: float) -> Array:
    """The mean at the offset −`distance` along x, where the element is far away; (columns,)."""
    # Panels that double from the smaller of both scales.
    first = 0.5 * min(distance, length)
    edges = np.append(0.0, first * 2.0 ** np.arange(math.ceil(math.log2(FADED * length / first)) + 1))
    half = 0.5 * np.diff(edges)[:, None]
    s = edges[:-1, None] + half * (1.0 + _NODES)
    weight = (half * _WEIGHTS * np.exp(-s / length)).ravel() / length
    x, y = -distance - s.ravel(), dy * np.arange(columns)
    points = 2, min(2 + math.ceil(3.0 * dy / distance), 64)
    (u, along), (v, across) = (np.polynomial.legendre.leggauss(n) for n in points)
    total = np.zeros(columns)
    for shift_x, part_x in zip(0.5 * dx * u, along, strict=True):
        for shift_y, part_y in zip(0.5 * dy * v, across, strict=True):
            total += part_x * part_y * (weight @ kernel(x[:, None] + shift_x, y + shift_y))
    return 0.25 * dx * dy * total


@dataclass(frozen=True)
class Memory:
    """One retardation time of one body, or of both: `length` l (m), and c times the compliances of the body (1/Pa): normal
    1/(πE*), the tangential ones of `ShearCompliance`, and that of the coupling with its sign in `elastic.coupling_constant`."""

    length: float
    normal: float
    isotropic: float
    directional: float
    coupling: float


@dataclass(frozen=True)
class Relaxing:
    """Both bodies of a contact, of which one relaxes at least; `lower` and `upper` are the materials of their surfaces."""

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
        for body, sign in ((self.lower.surface, 1.0), (self.upper.surface, -1.0)):
            shear, nu = body.shear_modulus, body.poisson_ratio
            for c, time in body.retardation:
                length, before = self.speed * time, found.get(self.speed * time, Memory(0.0, 0.0, 0.0, 0.0, 0.0))
                found[length] = Memory(
                    length, before.normal + c / (math.pi * body.plane_strain_modulus),
                    before.isotropic + c * (1.0 - nu) / (2.0 * math.pi * shear),
                    before.directional + c * nu / (2.0 * math.pi * shear),
                    before.coupling + sign * c * (1.0 - 2.0 * nu) / (4.0 * math.pi * shear))
        return list(found.values())

    def _table(self, factors: dict[str, str], rows: int, columns: int, dx: float, dy: float) -> Array:
        """Sum of the means of integrals times the named compliances of each memory, (2 rows − 1, columns)."""
        memories = self.memories
        lengths = np.array([memory.length for memory in memories])
        total = np.zeros((2 * rows - 1, columns))
        for kind, names in factors.items():
            factor = np.array([sum(getattr(memory, name) for name in names.split()) for memory in memories])
            if factor.any():
                total += np.tensordot(factor, one_sided_means(kind, rows, columns, dx, dy, lengths), 1)
        return total

    def normal_table(self, rows: int, columns: int, dx: float, dy: float) -> Array:
        """To be added to `elastic.normal_table`, at offsets −(rows − 1) … rows − 1 along x."""
        return self._table({"xx": "normal", "yy": "normal"}, rows, columns, dx, dy)

    def shear_tables(self, rows: int, columns: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
        """To be added to `elastic.shear_tables`, at the same offsets."""
        place = rows, columns, dx, dy
        return (self._table({"xx": "isotropic directional", "yy": "isotropic"}, *place),
                self._table({"xx": "isotropic", "yy": "isotropic directional"}, *place),
                self._table({"xy": "directional"}, *place))

    def coupling_tables(self, rows: int, columns: int, dx: float, dy: float) -> tuple[Array, Array]:
        """To be added to K times `elastic.coupling_tables`, at the same offsets."""
        place = rows, columns, dx, dy
        return self._table({"x": "coupling"}, *place), self._table({"y": "coupling"}, *place)

    def relaxed_modulus(self, contact_modulus: float) -> float:
        """E* (Pa) of both surfaces together after a long time, from the instantaneous one."""
        return 1.0 / (1.0 / contact_modulus + math.pi * sum(memory.normal for memory in self.memories))

    def normal_factor(self, columns: int, dx: float, contact_modulus: float) -> Spectrum:
        """The normal compliance over its instantaneous part at the phases of `columns` rows on a periodic plane."""
        theta = np.asarray(2.0 * np.pi * np.fft.fftfreq(columns), dtype=np.float64)
        factor = np.ones(columns, dtype=np.complex128)
        for memory in self.memories:
            factor += math.pi * contact_modulus * memory.normal * filter_of(dx / memory.length, theta)
        return factor

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

    def near_border(self, dx: float, dy: float, interlayer: float = 0.0) -> NearBorder:
        """Half-spaces that describe the bodies within an element of dx × dy (m): with the moduli at the frequency V/dx. Where
        much is lost in the time in which a few elements pass, no modulus does."""
        near = Coatings(*self.felt(dx)[0]).near_border(dx, dy, interlayer)
        trust = near.trust / (1.0 + (self.felt(BORDER * dx)[1] / TOLERABLE_LOSS) ** 4)
        return replace(near, trust=trust, compliance=replace(near.compliance, trust=trust))

    @property
    def surface_modulus(self) -> float:
        """E* of the surfaces' materials in Pa, instantaneous."""
        return Coatings(self.lower, self.upper).surface_modulus

    def softening(self, length: float) -> float:
        """Compliance of both surfaces together within a `length` (m) along x over the instantaneous one."""
        return self.surface_modulus / Coatings(*self.felt(length)[0]).surface_modulus

    def dundurs_beta(self, constant: float, contact_modulus: float) -> float:
        """The largest β (`DerivedQuantities.dundurs_beta`) of any time scale, the bodies relaxed as far as it allows; from the
        instantaneous K (1/Pa) and E* (Pa)."""
        largest, coupling, normal = math.pi * contact_modulus * constant, constant, 1.0 / (math.pi * contact_modulus)
        for memory in sorted(self.memories, key=lambda memory: memory.length):
            coupling, normal = coupling + memory.coupling, normal + memory.normal
            largest = max(largest, coupling / normal, key=abs)
        return 0.0 if abs(largest) <= UNCOUPLED else largest

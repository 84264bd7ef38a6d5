"""Both bodies of a contact: what pressure and shear on one element move, for homogeneous, coated and relaxing bodies alike.

`bodies_of` chooses the model; solvers ask `Bodies` and know no model. Homogeneous half-spaces are the closed forms of
`elastic`, to which coated bodies add what their layers change (`coatings`), and bodies that relax what their memory adds
(`relaxing`). A further model is a further class, with what differs from these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from thermoroll_cli.physics.halfspace import elastic
from thermoroll_cli.physics.halfspace.coatings import Coatings
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.halfspace.relaxing import Relaxing
from thermoroll_cli.physics.numerics.convolution import both_sides, half_plane_symbol, quadrant_symbol
from thermoroll_cli.problem.problem import Material, compliance_shares
from thermoroll_cli.tools.arrays import AnyArray, Array


class Influence(NamedTuple):
    """Displacement under a unit load on one element in m/Pa, even or odd (`parity` 1 or −1) in both offsets: the `quadrant` at
    offsets ≥ 0, (nx, ny), and what `trails` behind the load in bodies that relax, at offsets −(nx − 1) … nx − 1 along x,
    (2 nx − 1, ny)."""

    quadrant: Array
    parity: int = 1
    trails: Array | None = None

    def symbol(self, padded: tuple[int, int]) -> AnyArray:
        """The spectrum (py//2+1, px) on a plane of `padded` elements, complex where something trails."""
        symbol = quadrant_symbol(self.quadrant, padded, self.parity)
        return symbol if self.trails is None else symbol + half_plane_symbol(self.trails, padded, self.parity)

    def rows(self, offsets: tuple[int, ...]) -> Array:
        """The rows at these offsets along x, (len(offsets), ny)."""
        rows = self.quadrant[np.abs(offsets)]
        return rows if self.trails is None else rows + self.trails[len(self.trails) // 2 + np.array(offsets)]


Shear = tuple[Influence, Influence, Influence]
"""u_x under τ_x, u_y under τ_y, and each under the other."""
Coupling = tuple[list[tuple[float, Array]], list[tuple[float, Array]]]
"""u_x and u_y under pressure: factors (1/Pa) and tables (m) at all offsets, (2 nx − 1, 2 ny − 1), of which each is the sum."""


UNSHEARED = ShearCompliance(0.0, 0.0)
"""Of bodies of which only the normal contact is asked for."""


@dataclass(frozen=True)
class Bodies:
    """Two homogeneous elastic half-spaces, and what lies between them.

    Parameters:

    - `contact_modulus`: E* of the surfaces' materials in Pa, at once;
    - `shear`: their tangential compliance, with that of an interlayer;
    - `coupling_constant`: K in 1/Pa of the surfaces' materials (`elastic.coupling_constant`);
    - `shares`: w₁ and w₂ of the lower and the upper body in the normal compliance, far below the surface;
    - `length`: of a line contact in m (`shear_tables`)."""

    contact_modulus: float
    shear: ShearCompliance = UNSHEARED
    coupling_constant: float = 0.0
    shares: tuple[float, float] = (0.5, 0.5)
    length: float = math.inf

    relaxes = False
    """Whether a surface relaxes: it then loses power, and nothing is even along x."""
    dispersive = False
    """Whether the elastic compliance depends on the wave number."""

    @classmethod
    def of_shear(cls, shear: ShearCompliance) -> Bodies:
        """Half-spaces without coupling that have this tangential compliance."""
        return cls(shear.contact_modulus, shear)

    @property
    def at_once(self) -> Bodies:
        """These bodies as they respond before anything relaxes."""
        return self

    # --- tables --------------------------------------------------------------------------------------------------

    def normal_table(self, nx: int, ny: int, dx: float, dy: float) -> Influence:
        """u_z under pressure (Eq. 6)."""
        return Influence(elastic.normal_table(nx, ny, dx, dy, self.contact_modulus))

    def shear_tables(self, nx: int, ny: int, dx: float, dy: float) -> Shear:
        """Displacements under shear (Eq. 15). Those of a strip are known up to a constant: with a `length` they are those
        in the middle of a rectangle as long as that."""
        xx, yy, xy = self._shear_quadrants(nx, ny, dx, dy)
        if math.isinf(dy) and math.isfinite(self.length):
            for table, long in zip((xx, yy), self._shear_quadrants(nx, 1, dx, self.length), strict=False):
                table[:, 0] += long[0, 0] - table[0, 0]
        return Influence(xx), Influence(yy), Influence(xy, -1)

    def _shear_quadrants(self, nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
        return elastic.shear_tables(nx, ny, dx, dy, self.shear)

    def coupling_tables(self, nx: int, ny: int, dx: float, dy: float) -> Coupling:
        """Tangential displacements under pressure (`elastic.coupling_tables`)."""
        x, y = elastic.coupling_tables(nx, ny, dx, dy)
        return [(self.coupling_constant, _all_offsets(x, -1, 1))], [(self.coupling_constant, _all_offsets(y, 1, -1))]

    @property
    def sheared_across(self) -> bool:
        """True if τ_x also moves the surface along y, and τ_y along x."""
        return bool(self.shear.directional)

    # --- wave numbers --------------------------------------------------------------------------------------------

    def compliance(self, wave_numbers: Array) -> dict[str, Array]:
        """k times the elastic compliance in 1/Pa: for pressure ("nn"), for shear along ("tt") and across ("ss") the wave
        vector."""
        parts = {"nn": 2.0 / self.contact_modulus, "tt": self.shear.along, "ss": self.shear.across}
        return {name: np.full_like(wave_numbers, part) for name, part in parts.items()}

    def normal_symbol(self, table: Influence, period: tuple[int, int], dx: float, dy: float) -> AnyArray:
        """Symbol of the normal displacement (py//2+1, px) on a plane of that `period`, for preconditioners; `table` is the
        `normal_table` on it."""
        return quadrant_symbol(table.quadrant, period)

    def shear_symbols(self, period: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array, Array]:
        """Elastic symbols of the `shear_tables`, likewise."""
        xx, yy, xy = self.at_once.shear_tables(period[0] // 2 + 1, period[1] // 2 + 1, dx, dy)
        return xx.symbol(period), yy.symbol(period), xy.symbol(period)

    # --- one number for the contact ------------------------------------------------------------------------------

    def near_border(self, dx: float, dy: float) -> Bodies:
        """The half-spaces that stand for the bodies within an element of dx × dy (m) at a border; `shear.trust` says how
        well."""
        return self

    def shares_of(self, half_x: float, half_y: float) -> tuple[float, float]:
        """w₁ and w₂ of both bodies in the compliance of a contact with these half-lengths (m)."""
        return self.shares

    @property
    def softest(self) -> float:
        """E* of the surfaces' materials after a long time, in Pa."""
        return self.contact_modulus

    @property
    def largest_coupling(self) -> float:
        """K (1/Pa) at the wave number where it is largest, of the elastic bodies."""
        return self.coupling_constant

    @property
    def dundurs_beta(self) -> float:
        """β = πE*K, the largest one of all wave numbers and times, with E* of the surfaces' materials."""
        return math.pi * self.contact_modulus * self.largest_coupling

    def felt_shear(self, radius: float, half: float) -> tuple[float, float]:
        """Compliance to shear along and across waves (1/Pa) as long as a contact of this mean `radius`, of which `half` (m) is
        the half-length along x."""
        return self.shear.along, self.shear.across

    def softening(self, length: float) -> float:
        """Compliance of both surfaces together within a `length` (m) along x over that at once."""
        return 1.0

    def loss(self, length: float) -> float:
        """Larger loss tangent of both surfaces within a `length` (m) along x."""
        return 0.0

    def leading_edge(self, half: float) -> tuple[float, float]:
        """Place (m behind the leading edge of a contact of length 2 `half`, m) and height, over the pressure in the middle, of
        the maximum that material not yet relaxed makes there; of elastic bodies none."""
        return half, 0.0


@dataclass(frozen=True, kw_only=True)
class CoatedBodies(Bodies):
    """Two elastic bodies of which one is coated at least."""

    coatings: Coatings
    dispersive = True

    def normal_table(self, nx: int, ny: int, dx: float, dy: float) -> Influence:
        return Influence(super().normal_table(nx, ny, dx, dy).quadrant + self.coatings.normal_table(nx, ny, dx, dy))

    def _shear_quadrants(self, nx: int, ny: int, dx: float, dy: float) -> tuple[Array, Array, Array]:
        xx, yy, xy = super()._shear_quadrants(nx, ny, dx, dy)
        more_xx, more_yy, more_xy = self.coatings.shear_tables(nx, ny, dx, dy)
        return xx + more_xx, yy + more_yy, xy + more_xy

    def coupling_tables(self, nx: int, ny: int, dx: float, dy: float) -> Coupling:
        (x, y), (more_x, more_y) = super().coupling_tables(nx, ny, dx, dy), self.coatings.coupling_tables(nx, ny, dx, dy)
        return [*x, (1.0, _all_offsets(more_x, -1, 1))], [*y, (1.0, _all_offsets(more_y, 1, -1))]

    @property
    def sheared_across(self) -> bool:
        return True

    def compliance(self, wave_numbers: Array) -> dict[str, Array]:
        return self.coatings.compliance(wave_numbers)

    def normal_symbol(self, table: Influence, period: tuple[int, int], dx: float, dy: float) -> AnyArray:
        return self.coatings.periodic_symbols(period, dx, dy)[0]

    def shear_symbols(self, period: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array, Array]:
        _, xx, yy, xy = self.coatings.periodic_symbols(period, dx, dy)
        return xx + self.shear.interlayer, yy + self.shear.interlayer, xy

    def near_border(self, dx: float, dy: float) -> Bodies:
        return Bodies.of_shear(self.coatings.near_border(dx, dy, self.shear.interlayer))

    def shares_of(self, half_x: float, half_y: float) -> tuple[float, float]:
        return self.coatings.shares(half_x, half_y)

    @property
    def largest_coupling(self) -> float:
        return self.coatings.coupling_constant

    def felt_shear(self, radius: float, half: float) -> tuple[float, float]:
        felt = self.compliance(np.array([1.0 / radius]))
        return float(felt["tt"][0]), float(felt["ss"][0])


@dataclass(frozen=True, kw_only=True)
class RelaxingBodies(Bodies):
    """Two bodies of which the surface of one relaxes at least: what moves `at_once`, and what their `memory` adds."""

    elastic: Bodies
    memory: Relaxing
    relaxes = True

    @property
    def at_once(self) -> Bodies:
        return self.elastic

    @property
    def dispersive(self) -> bool:  # type: ignore[override]
        return self.elastic.dispersive

    def normal_table(self, nx: int, ny: int, dx: float, dy: float) -> Influence:
        return self.elastic.normal_table(nx, ny, dx, dy)._replace(trails=self.memory.normal_table(nx, ny, dx, dy))

    def shear_tables(self, nx: int, ny: int, dx: float, dy: float) -> Shear:
        xx, yy, xy = (own._replace(trails=trails) for own, trails in zip(
            self.elastic.shear_tables(nx, ny, dx, dy), self.memory.shear_tables(nx, ny, dx, dy), strict=True))
        return xx, yy, xy

    def coupling_tables(self, nx: int, ny: int, dx: float, dy: float) -> Coupling:
        (x, y), (more_x, more_y) = self.elastic.coupling_tables(nx, ny, dx, dy), self.memory.coupling_tables(nx, ny, dx, dy)
        return [*x, (1.0, both_sides(more_x, 1))], [*y, (1.0, both_sides(more_y, -1))]

    @property
    def sheared_across(self) -> bool:
        return self.elastic.sheared_across

    def compliance(self, wave_numbers: Array) -> dict[str, Array]:
        return self.elastic.compliance(wave_numbers)

    def normal_symbol(self, table: Influence, period: tuple[int, int], dx: float, dy: float) -> AnyArray:
        symbol = self.elastic.normal_symbol(table, period, dx, dy)
        return self.memory.periodic_symbol(symbol, period, dx, dy, self.contact_modulus)

    def shear_symbols(self, period: tuple[int, int], dx: float, dy: float) -> tuple[Array, Array, Array]:
        return self.elastic.shear_symbols(period, dx, dy)

    def near_border(self, dx: float, dy: float) -> Bodies:
        return Bodies.of_shear(self.memory.near_border(dx, dy, self.shear.interlayer))

    def shares_of(self, half_x: float, half_y: float) -> tuple[float, float]:
        return self.elastic.shares_of(half_x, half_y)

    @property
    def softest(self) -> float:
        return self.memory.relaxed_modulus(self.contact_modulus)

    @property
    def dundurs_beta(self) -> float:
        return self.memory.dundurs_beta(self.elastic.largest_coupling, self.contact_modulus)

    def felt_shear(self, radius: float, half: float) -> tuple[float, float]:
        (along, across), softer = self.elastic.felt_shear(radius, half), self.softening(half)
        return along * softer, across * softer

    def softening(self, length: float) -> float:
        return self.memory.softening(length)

    def loss(self, length: float) -> float:
        return self.memory.felt(length)[1]

    def leading_edge(self, half: float) -> tuple[float, float]:
        return self.memory.leading_edge(half)


def bodies_of(lower: Material, upper: Material, speed: float, interlayer: float = 0.0, length: float = math.inf) -> Bodies:
    """The model of two bodies of these materials at a rolling `speed` (m/s), with the compliance of an `interlayer` (m/Pa)
    between them; `length` (m) as of `Bodies`."""
    surfaces = [(body.surface.shear_modulus, body.surface.poisson_ratio) for body in (lower, upper)]
    modulus = 1.0 / (1.0 / lower.surface.plane_strain_modulus + 1.0 / upper.surface.plane_strain_modulus)
    shear = ShearCompliance.of(*surfaces, interlayer=interlayer)
    constants = modulus, shear, elastic.coupling_constant(*surfaces), compliance_shares(lower, upper), length
    coatings, memory = Coatings.of(lower, upper), Relaxing.of(lower, upper, speed)
    at_once = Bodies(*constants) if coatings is None else CoatedBodies(*constants, coatings=coatings)
    return at_once if memory is None else RelaxingBodies(*constants, elastic=at_once, memory=memory)


def _all_offsets(quadrant: Array, parity_x: int, parity_y: int) -> Array:
    """(n, m) at offsets ≥ 0 -> (2n−1, 2m−1) at all offsets, for a kernel even (1) or odd (−1) along each axis."""
    right = np.concatenate((parity_x * quadrant[:0:-1], quadrant))
    return both_sides(right, parity_y)

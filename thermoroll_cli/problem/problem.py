"""The problem to be solved: two bodies, a load, creepages and heat, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any, ClassVar, Literal

import numpy as np

from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.friction import Friction, Interlayer
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.kinds import Task
from thermoroll_cli.problem.relaxation import Series, retardation
from thermoroll_cli.tools.arrays import Array

Deformation = bool | Literal["always"]
PecletMode = Literal["rolling", "sliding", "stationary"]
Partition = float | Literal["matched"]
BodyName = Literal["lower", "upper"]
Place = Literal["origin", "contact"]
KeptFields = Literal["plane", "von_mises", "full"]
BODIES: tuple[BodyName, ...] = ("lower", "upper")

STANDARD_ACCURACY = 1e-3
"""Relative accuracy of a case that asks for none."""

LEFT_OUT_SHARE = 0.25
"""A stage may be left out if its effect is below this share of the requested accuracy; the rest is for the grid and other
stages."""


@dataclass(frozen=True)
class Layer:
    """A bonded layer of the coating of a body: `thickness` (m), constants and relaxation as those of `Material`, and shear
    yield stress (Pa; None if it does not yield)."""

    thickness: float
    youngs_modulus: float
    poisson_ratio: float
    conductivity: float | None = None
    expansion: float | None = None
    diffusivity: float | None = None
    shear_yield: float | None = None
    relaxation: Series = ()

    @property
    def retardation(self) -> Series:
        """As that of `Material`."""
        return retardation(self.relaxation)


@dataclass(frozen=True)
class Material:
    """An isotropic body: `youngs_modulus` (Pa), `poisson_ratio`, `conductivity` (W/mK), `expansion` (1/K) and `diffusivity`
    (m²/s), with a coating of bonded `layers`, from the surface down. Thermal constants are None in a purely mechanical
    problem. With `relaxation`, pairs of a share of the modulus and a time (s), `youngs_modulus` is the instantaneous one. The
    `density` (kg/m³) counts in bearings and for worn masses."""

    youngs_modulus: float
    poisson_ratio: float
    conductivity: float | None = None
    expansion: float | None = None
    diffusivity: float | None = None
    layers: tuple[Layer, ...] = ()
    relaxation: Series = ()
    density: float | None = None

    @property
    def elastic_layers(self) -> tuple[Layer, ...]:
        """`layers` without those at the bottom that have the elastic constants of the body below, which have no effect."""
        count = len(self.layers)
        while count and (self.layers[count - 1].youngs_modulus, self.layers[count - 1].poisson_ratio,
                         self.layers[count - 1].relaxation) == (self.youngs_modulus, self.poisson_ratio, self.relaxation):
            count -= 1
        return self.layers[:count]

    @property
    def interfaces(self) -> tuple[float, ...]:
        """Depth of the lower face of each layer of the coating in m."""
        return tuple(accumulate(layer.thickness for layer in self.layers))

    @property
    def surface(self) -> Material:
        """The material of the surface: that of the first layer, or of the whole body."""
        top = self.elastic_layers[:1]
        return Material(top[0].youngs_modulus, top[0].poisson_ratio, relaxation=top[0].relaxation) if top else self

    @property
    def retardation(self) -> Series:
        """The pairs (cⱼ, θⱼ in s) of the creep compliance over its instantaneous value."""
        return retardation(self.relaxation)

    @property
    def shear_modulus(self) -> float:
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def plane_strain_modulus(self) -> float:
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)


def compliance_shares(lower: Material, upper: Material) -> tuple[float, float]:
    """Shares w₁ and w₂ of two bodies in the compliance of their contact, with the sum 1; of coated bodies those of their
    substrates, which very thin coatings do not change."""
    moduli = lower.plane_strain_modulus, upper.plane_strain_modulus
    return moduli[1] / sum(moduli), moduli[0] / sum(moduli)


@dataclass(frozen=True)
class Motion:
    """Rolling speed in m/s, creepages and prescribed forces.

    Creepages are dimensionless, spin is in rad/m. They are those at the origin of the frame or, `at` the "contact", at the
    centre of its pressure; the latter contain the slip and the spin of the shapes. A prescribed force (N) replaces the creepage
    of its direction, which is then None and becomes an unknown. With `differential_slip` the rolling radii vary across the
    contact as the surfaces curve, unless that has no effect (`differential_slip.resolved`). `turning` is the velocity with
    which one body rolls over the other, over that of the mean speed, V (1/R_x1 + 1/R_x2): the shapes slip with it.
    """

    speed: float
    creepage_x: float | None = 0.0
    creepage_y: float | None = 0.0
    spin: float = 0.0
    force_x: float | None = None
    force_y: float | None = None
    differential_slip: bool = True
    at: Place = "origin"
    turning: float = 1.0


@dataclass(frozen=True)
class ReturningTrack:
    """A body that turns and whose heated track returns to the contact: its `width` (m), contacts per revolution, and either
    `convection` (W/m²K) on rim and ends or the thermal `resistance` (K/W) of the whole body."""

    width: float
    passes: int = 1
    convection: float | None = None
    resistance: float | None = None


@dataclass(frozen=True)
class Heating:
    """How frictional heat is treated.

    `deformation`: whether thermal expansion acts back on the gap. With True it is left out if its effect is below the accuracy,
    with "always" it is always computed.
    `partition` is the share of the lower body, or "matched": divided from point to point so that both surfaces are equally
    warm inside the contact. Bulk temperatures (K) are those of the bodies far from the contact, above the temperature to
    which the coefficient of friction belongs; with a matched partition their difference drives heat through the contact.
    `lower_track`, `upper_track`: cooling of a body that turns (None: no recirculating heat); its bulk temperature is then that
    of its surroundings.
    """

    heat: bool = True
    deformation: Deformation = True
    peclet: PecletMode = "rolling"
    partition: Partition = 0.5
    bulk_lower: float = 0.0
    bulk_upper: float = 0.0
    lower_track: ReturningTrack | None = None
    upper_track: ReturningTrack | None = None

    @property
    def recirculates(self) -> bool:
        """True if a body has recirculating heat."""
        return self.heat and (self.lower_track is not None or self.upper_track is not None)

    @property
    def bulk_difference(self) -> float:
        """Bulk temperature of the upper body less that of the lower one in K."""
        return self.bulk_upper - self.bulk_lower

    @property
    def conducts(self) -> bool:
        """Whether heat flows between the bodies even without friction."""
        return self.partition == "matched" and self.bulk_difference != 0.0


@dataclass(frozen=True)
class Numerics:
    """Discretisation: either a grid (elements per side) or a relative accuracy, and the domain side in Hertz semi-axes
    (`extent` = domain side / semi-axis, so 2.2 covers the contact with a margin of 5 % on each side). `across` are the ends (m)
    of the domain across rolling; None: they follow the contact. `accuracy_of` names the scalars, or groups of them
    (`names.GROUPS`), that have to be as accurate; none: all that are usual."""

    grid: tuple[int, int] | None = None
    accuracy: float | None = None
    extent: float = 2.2
    across: tuple[float, float] | None = None
    accuracy_of: tuple[str, ...] = ()

    @property
    def negligible(self) -> float:
        """Relative change of the scalars below which a stage is left out; the bound of it is part of their errors."""
        return STANDARD_ACCURACY if self.accuracy is None else LEFT_OUT_SHARE * self.accuracy


@dataclass(frozen=True)
class Strength:
    """Strength of a body: shear yield stress k (Pa; None: not known), and the weight of the hydrostatic stress in Dang Van's
    criterion."""

    shear_yield: float | None = None
    dang_van_coefficient: float = 0.0


@dataclass(frozen=True)
class SubsurfaceRequest:
    """Requested stresses below the surface.

    - `bodies`: those whose stresses are computed;
    - `depth`: the largest one in m, `layers`: the number of depths; None: by the size of the contact and of the heated skin;
    - `thermal`: whether thermal stresses are added if there is heat;
    - `fields`: those that are kept;
    - `lower_strength`, `upper_strength`: of bodies whose shakedown and fatigue are requested, None without.
    """

    bodies: tuple[BodyName, ...] = BODIES
    depth: float | None = None
    layers: int | None = None
    thermal: bool = True
    fields: KeptFields = "plane"
    lower_strength: Strength | None = None
    upper_strength: Strength | None = None


@dataclass(frozen=True)
class WornBody:
    """A body that wears by Archard's law: specific wear `rate` κ in 1/Pa (m²/N: worn volume per sliding distance and load), and
    the `track_length` (m) rolled between two passages of a point.

    κ may depend on the local T = T_γ/A = μp|s|/V, the work per area and distance rolled: `rate` is then a table of (T in Pa,
    κ), T increasing. Up to the first T and beyond the last κ is constant; between them the wear κT is linear in T, so that it
    never jumps."""

    rate: float | tuple[tuple[float, float], ...] = 0.0
    track_length: float = math.inf

    @property
    def regimes(self) -> tuple[float, ...]:
        """The T (Pa) at which one regime of wear ends and the next begins; none for a constant rate."""
        return tuple(place for place, _ in self.rate) if isinstance(self.rate, tuple) else ()

    @property
    def wears(self) -> bool:
        """Whether any material is worn off."""
        return any(rate > 0.0 for _, rate in self.rate) if isinstance(self.rate, tuple) else self.rate > 0.0

    def rate_at(self, work: Array) -> tuple[Array, Array]:
        """κ (1/Pa) and d ln(κT)/d ln T at the local T (Pa)."""
        if not isinstance(self.rate, tuple):
            return np.full_like(work, self.rate), np.ones_like(work)
        places, rates = np.array(self.rate).T
        outside = np.where(work <= places[0], rates[0], rates[-1])
        between = (work > places[0]) & (work < places[-1])
        if not between.any():
            return outside, np.ones_like(work)
        wear = np.interp(work, places, places * rates)
        slope = np.diff(places * rates) / np.diff(places)
        slope = slope[np.clip(np.searchsorted(places, work) - 1, 0, len(slope) - 1)]
        rate = np.where(between, wear / np.where(between, work, 1.0), outside)
        return rate, np.where(between & (wear > 0.0), slope * work / np.where(wear > 0.0, wear, 1.0), 1.0)


@dataclass(frozen=True)
class Wear:
    """How both bodies wear, and how far an evolution goes: until `distance` (m) is rolled or one body is worn by `depth` (m),
    in steps of at most `step_fraction` of the approach, with `snapshots` of the profiles. Profiles of wheelsets wear by at most
    `step` (m) at once, smoothed over the wavelength `smoothing` (m), of material with a `density` (kg/m³)."""

    lower: WornBody = WornBody()
    upper: WornBody = WornBody()
    distance: float = math.inf
    depth: float = math.inf
    step_fraction: float = 0.1
    snapshots: int = 20
    step: float = 20e-6
    smoothing: float = 5e-3
    density: float = 7850.0

    @property
    def bodies(self) -> dict[BodyName, WornBody]:
        return {"lower": self.lower, "upper": self.upper}


@dataclass(frozen=True)
class Problem(Task):
    """A complete steady-state rolling contact problem in SI units. It is immutable (`dataclasses.replace`) and checks nothing.

    Parameters:

    - `lower`, `upper`: materials of the bodies (`Material`);
    - `geometry`: radii (m) and profiles (`Geometry`), or a `CurvedPatch`;
    - `normal_force`: W in N, of a line contact in N per m of length; with a given `approach` (m) the load that it needs, in a
      problem about the one without heat and shear (`pressed_to`), in a result the one found, as of a conformal contact with a
      given `vertical` force (N) of pressure and traction along z;
    - `friction`: coefficient and laws (`Friction`);
    - `motion`: speed (m/s), creepages, spin (rad/m), prescribed forces (N) (`Motion`);
    - `heating`: frictional heat, its partition, bulk temperatures (K) (`Heating`);
    - `numerics`: elements per side or accuracy (`Numerics`);
    - `title`: of tables and pictures;
    - `interlayer`: the third body between the surfaces (`Interlayer`);
    - `subsurface`, `wear`: requests beyond the contact (`SubsurfaceRequest`, `Wear`), None without;
    - `length`: of a line contact over time in m: displacements grow with its logarithm. Steady states do not know it (inf);
    - `heights`: what rolls through the contact and closes the gap besides the shapes of `geometry`, over places along x and y
      (`surface.Closing`), None: nothing;
    - `hertz_pressure`: the pressure (Pa) that `normal_force` was chosen for, None if it was not.

    `solve` raises ValueError for a problem that has no steady state.
    """

    kind: ClassVar[str] = "contact"

    lower: Material
    upper: Material
    geometry: Geometry | CurvedPatch
    normal_force: float
    friction: Friction
    motion: Motion
    heating: Heating = Heating()
    numerics: Numerics = Numerics()
    title: str = ""
    interlayer: Interlayer = field(default_factory=Interlayer)
    subsurface: SubsurfaceRequest | None = None
    wear: Wear | None = None
    approach: float | None = None
    vertical: float | None = None
    length: float = math.inf
    heights: Any = None
    hertz_pressure: float | None = None

    @property
    def smooth(self) -> Problem:
        """This problem without what closes its gap beside smooth shapes, which files of results do not keep."""
        geometry = replace(self.geometry, heights=None) if isinstance(self.geometry, CurvedPatch) else self.geometry
        return replace(self, geometry=geometry, heights=None)

    @property
    def load_is_given(self) -> bool:
        """Whether the normal load is given, and not found."""
        return self.approach is None and self.vertical is None

    @property
    def contact_modulus(self) -> float:
        """E* with 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ in Pa; of coated bodies that of the surfaces' materials."""
        return 1.0 / (1.0 / self.lower.surface.plane_strain_modulus + 1.0 / self.upper.surface.plane_strain_modulus)

    @property
    def compliance_shares(self) -> tuple[float, float]:
        """Shares w₁ and w₂ of the lower and the upper body in the compliance of the contact."""
        return compliance_shares(self.lower, self.upper)

    @property
    def relaxes(self) -> bool:
        """Whether the surface of a body relaxes."""
        return bool(self.lower.surface.relaxation or self.upper.surface.relaxation)

    @property
    def line(self) -> bool:
        """Whether the bodies are cylinders with parallel axes across rolling: a line contact in plane strain. Forces and powers
        are then per m of length."""
        return self.geometry.elliptic and self.geometry.curvature_y == 0.0

    @property
    def contact(self) -> Problem:
        """This problem, as of an assembly the one that its contacts share."""
        return self

    @property
    def friction_varies(self) -> bool:
        """Whether the coefficient of friction depends on the temperature."""
        return self.friction.coefficient > 0.0 and self.friction.slope != 0.0 and self.heating.heat

    @property
    def traction_limit(self) -> float:
        """μ₀W in N, the scale of tangential forces; the most that they can be if friction rises neither with slip nor with
        temperature."""
        return self.friction.coefficient * self.normal_force

    def force_text(self, force: float) -> str:
        """A `force` (N, of a line contact N/m) as messages have it."""
        return f"{1e-3 * force:.6g} N/mm" if self.line else f"{force:.6g} N"

    @property
    def prescribed_force(self) -> float:
        """Magnitude of the prescribed tangential force in N."""
        return math.hypot(self.motion.force_x or 0.0, self.motion.force_y or 0.0)


def planar(problem: Problem) -> Geometry:
    """The geometry of a problem whose profiles are known. Raises Unsolvable for one on a curved common surface."""
    if isinstance(problem.geometry, Geometry):
        return problem.geometry
    raise Unsolvable("the evolution of wear is not computed for conformal contacts", "geometry.conformal")

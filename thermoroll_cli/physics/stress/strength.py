"""Strength: equivalent stresses, the yield stress that keeps a body elastic after the first passages, and where cracks start.

In steady rolling the residual stresses do not depend on x. By Melan's theorem a body shakes down if some residual stress
brings all stress states below yield. The family ρ_xx(z), ρ_yy(z), ρ_xy(z) is exact where every y is rolled over, and a safe
lower bound for a single track. With the deviator in the metric of von Mises,

    q = (σzz − ½(σxx + σyy), (√3/2)(σxx − σyy), √3 σxy, √3 σxz, √3 σyz),      |q| = von Mises stress,

the residual stresses shift the first three components, and the shear yield stress that a depth needs is k = R/√3 with the
smallest ball R² = min over c of max |q₁₋₃ − c|² + q₄² + q₅² around its states, the unloaded one included.

Alternating plasticity is excluded, whatever the residual stress, if k ≥ R₅/√3 with the smallest ball in all five components
along each line of rolling. Dang Van's criterion (Dang Van et al. 1989) takes the centre of that ball as the mesoscopic
residual stress: its stress is the largest of τ + a_DV σ_h along the line, with the Tresca shear stress τ of the deviator less
the centre and the hydrostatic stress σ_h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import numpy as np

from thermoroll_cli.physics.numerics.convolution import unfolded
from thermoroll_cli.physics.stress.smallest_ball import Balls, smallest_balls
from thermoroll_cli.problem.names import STRENGTH_FIELDS, SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import Material, Strength
from thermoroll_cli.problem.result import Peak, within_layers
from thermoroll_cli.problem.scalar_errors import FORCES
from thermoroll_cli.tools.arrays import AnyArray, Array

SQRT3 = math.sqrt(3.0)
OF_LINES = "alternating_k", "dang_van"
"""Fields of each line of rolling."""
PARABOLA = 3
"""Depths through which the largest strength goes (`largest_over_depth`)."""


def von_mises(stress: AnyArray) -> AnyArray:
    """√(½[(σxx−σyy)² + (σyy−σzz)² + (σzz−σxx)²] + 3[σxy² + σxz² + σyz²]) of stresses (6, …), xx yy zz xy xz yz."""
    xx, yy, zz, xy, xz, yz = stress
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (xy * xy + xz * xz + yz * yz)))


def principal_and_shear(stress: AnyArray) -> tuple[AnyArray, AnyArray]:
    """The largest principal stress (tension positive) of stresses (6, …), and the largest shear stress, half of Tresca's.

    The roots of the characteristic polynomial by the cosine of its angle (Smith 1961), from the deviator: largest and smallest
    differ by 2 √3 r sin(θ + π/3)."""
    xx, yy, zz, xy, xz, yz = stress
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    half_square = (a * a + b * b + c * c) / 6.0 + (xy * xy + xz * xz + yz * yz) / 3.0
    radius = np.sqrt(half_square)
    half_determinant = 0.5 * (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz))
    cube = np.maximum(radius * half_square, np.finfo(radius.dtype).tiny)
    angle = np.arccos(np.clip(half_determinant / cube, -1.0, 1.0)) / 3.0
    return np.asarray(mean + 2.0 * radius * np.cos(angle)), np.asarray(SQRT3 * radius * np.sin(angle + math.pi / 3.0))


def deviator(stress: AnyArray) -> Array:
    """The five components q (…, 5) of stresses (6, …), xx yy zz xy xz yz; |q| is the von Mises stress."""
    xx, yy, zz, xy, xz, yz = np.asarray(stress, dtype=float)
    return np.stack([zz - 0.5 * (xx + yy), 0.5 * SQRT3 * (xx - yy), SQRT3 * xy, SQRT3 * xz, SQRT3 * yz], axis=-1)


def shakedown_at_depth(stress: AnyArray, *, mirrored: bool = False) -> tuple[float, tuple[float, float, float]]:
    """Shear yield stress k (Pa) that one depth with stresses (6, nx, ny) in Pa needs, and the residual stresses xx, yy, xy (Pa)
    for which this suffices. A `mirrored` state, even in y, is given for y > 0 only; by symmetry ρ_xy = 0 in it."""
    q = deviator(stress).reshape(-1, 5)
    free = 2 if mirrored else 3
    unloaded = np.zeros((1, free + 1))
    states = np.vstack([np.column_stack([q[:, :free], (q[:, free:] ** 2).sum(axis=1)]), unloaded])[None]
    ball = smallest_balls(states[..., :free], states[..., free])
    c1, c2, c3 = (*ball.centres[0], 0.0)[:3]
    return math.sqrt(ball.squared_radii[0] / 3.0), (c1 - c2 / SQRT3, c1 + c2 / SQRT3, -c3 / SQRT3)


def line_fatigue(stress: AnyArray, dang_van_coefficient: float, start: Balls | None = None) -> tuple[Array, Array, Balls]:
    """Alternating plasticity k and Dang Van's stress, both (ny,) in Pa, of every line of rolling of a depth with stresses
    (6, nx, ny) in Pa, and the balls, to start from at the next depth.

    `dang_van_coefficient` weighs the hydrostatic stress, positive in tension; `start` are the balls of a depth nearby."""
    history = deviator(stress).transpose(1, 0, 2)
    history = np.concatenate([history, np.zeros_like(history[:, :1])], axis=1)
    balls = smallest_balls(history, start=start)
    hydrostatic = np.zeros(history.shape[:2])
    hydrostatic[:, :-1] = np.asarray(stress[0] + stress[1] + stress[2], dtype=float).T / 3.0
    shear = tresca_shear(history - balls.centres[:, None])
    return np.sqrt(balls.squared_radii / 3.0), (shear + dang_van_coefficient * hydrostatic).max(axis=1), balls


def tresca_shear(q: Array) -> Array:
    """Half the difference of the largest and the smallest principal stress of deviators (…, 5).

    The principal deviators are (2/3)|q| cos(θ + 2πn/3) with cos 3θ = 27 det/(2|q|³) (Lode's angle)."""
    size = np.sqrt(np.einsum("...d,...d->...", q, q))
    zz = q[..., 0] * (2.0 / 3.0)
    half, difference = -q[..., 0] / 3.0, q[..., 1] / SQRT3
    xx, yy = half + difference, half - difference
    xy, xz, yz = (q[..., i] / SQRT3 for i in (2, 3, 4))
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    cosine = 13.5 * determinant / np.maximum(size**3, np.finfo(float).tiny)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return np.asarray(size * np.sin(angle + math.pi / 3.0) / SQRT3)


def largest_over_depth(depths: Array, values: Array) -> tuple[float, float]:
    """Largest of `values` (nz,) below the surface and its depth, by the parabola through the largest value and its neighbours.

    The surface, at depth 0, serves only as a neighbour: with friction it converges more slowly and has a scalar of its own.
    If the values fall from the surface downwards, they are largest at the first depth below it."""
    first = int(depths[0] == 0.0)
    top = int(np.argmax(values[first:])) + first
    falls = first and values[top] <= values[top - 1]
    if falls or top in (0, len(values) - 1):
        return float(values[top]), float(depths[top])
    z, v = depths[top - 1 : top + 2] - depths[top], values[top - 1 : top + 2]
    bend, slope, _ = np.polyfit(z, v, 2)
    if bend >= 0.0:
        return float(values[top]), float(depths[top])
    shift = min(max(-0.5 * slope / bend, z[0]), z[2])
    return float(v[1] + shift * (slope + bend * shift)), float(depths[top] + shift)


@dataclass
class StrengthCollector:
    """Collects the depths of one body from the surface down; `columns` along y hold y > 0 of a `mirrored` state.

    Stresses in a coating count as much as the body's shear yield stress exceeds theirs, and not at all where its layer does
    not yield; Dang Van's stress is that of the `body` below them. `values` are those of `STRENGTH_FIELDS`: over z, or of lines
    of rolling (`OF_LINES`) over z and y."""

    strength: Strength
    body: Material
    depths: Array
    columns: int
    mirrored: bool
    thermal: bool
    values: dict[str, Array] = field(init=False)
    _above: Balls | None = None

    def __post_init__(self) -> None:
        count = len(self.depths)
        self.values = {name: np.empty((count, self.columns) if name in OF_LINES else count) for name in STRENGTH_FIELDS}

    def take(self, index: int, elastic: AnyArray, total: AnyArray) -> None:
        """One depth: elastic and total stresses (6, nx, columns) in Pa, the same array without thermal stresses."""
        needed, (xx, yy, xy) = shakedown_at_depth(total, mirrored=self.mirrored)
        cold = shakedown_at_depth(elastic, mirrored=self.mirrored)[0] if self.thermal else needed
        alternating, dang_van, self._above = line_fatigue(total, self.strength.dang_van_coefficient, self._above)
        found: dict[str, Any] = {
            "shakedown_k": needed, "elastic_shakedown_k": cold, "elastic_limit_k": float(von_mises(total).max()) / SQRT3,
            "residual_xx": xx, "residual_yy": yy, "residual_xy": xy, "alternating_k": alternating, "dang_van": dang_van}
        for name, value in found.items():
            self.values[name][index] = value

    def profiles(self) -> dict[str, Array]:
        """Largest values (Pa) of each depth, (nz,)."""
        bonded = self.depths <= (-1.0, *self.body.interfaces)[-1]
        own = self.strength.shear_yield or 1.0
        counted = own / shear_yields(self.body, own, self.depths)
        return {"shakedown_k": counted * self.values["shakedown_k"],
                "elastic_shakedown_k": counted * self.values["elastic_shakedown_k"],
                "alternating_k": counted * self.values["alternating_k"].max(axis=1),
                "dang_van_max": np.where(bonded, 0.0, self.values["dang_van"].max(axis=1))}

    def peaks(self, every: int = 1) -> dict[str, tuple[Peak, Peak]]:
        """Largest values (Pa) at the surface and below it, from every depth or only every `every`-th one and the first below
        the surface."""
        parts = [np.arange(part.stop)[part] for part in within_layers(self.depths)]
        parts = [np.union1d(part[::every], part[1:2]) for part in parts]
        peaks = {}
        for name, values in self.profiles().items():
            largest = [largest_over_depth(self.depths[part], values[part]) for part in parts]
            below, depth = max(largest, key=lambda value_at: value_at[0])
            peaks[name] = Peak(float(values[0]), 0.0, 0.0, 0.0), Peak(below, 0.0, 0.0, depth)
        return peaks

    def scalars(self, body: str, every: int = 1) -> dict[str, float]:
        """Scalars in the units of their names (`SUBSURFACE_SCALARS`), nan where no depth counts."""
        scalars: dict[str, float] = {}
        for name, (surface, below) in self.peaks(every).items():
            strongest = max(below, surface, key=attrgetter("value"))  # below the surface if both are equal
            scalars[f"{name}_{body}_MPa"] = strongest.value * 1e-6 or math.nan
            if not name.startswith("elastic"):
                scalars[f"{name}_below_{body}_MPa"] = below.value * 1e-6 or math.nan
                scalars[f"{name}_surface_{body}_MPa"] = surface.value * 1e-6 or math.nan
            if (depth := depth_name(name, body)) in SUBSURFACE_SCALARS:
                scalars[depth] = strongest.z * 1e3 if strongest.value else math.nan
        return scalars

    def at_surface(self, body: str, near: float) -> set[str]:
        """Names of the scalars whose largest value lies at the surface, no deeper than `near` (m)."""
        names = set()
        for name, (surface, below) in self.peaks().items():
            names |= {f"{name}_surface_{body}_MPa"}
            if below.z <= near:
                names |= {f"{name}_below_{body}_MPa"}
            if max(below, surface, key=attrgetter("value")).z <= near:
                names |= {f"{name}_{body}_MPa", depth_name(name, body)}
        return names

    def fields(self) -> dict[str, AnyArray]:
        """The kept fields over z, or over z and y, on both sides of a mirror (names of `STRENGTH_FIELDS`)."""
        return {name: unfolded(values[:, None, :], 1)[:, 0] if self.mirrored and name in OF_LINES else values
                for name, values in self.values.items()}


def shear_yields(body: Material, own: float, depths: Array) -> Array:
    """Shear yield stress of a body at `depths`, its `own` below its coatings; infinite in coatings that do not yield."""
    yields = np.full(len(depths), own)
    for face, layer in reversed(list(zip(body.interfaces, body.layers, strict=True))):
        yields[depths <= face] = layer.shear_yield or math.inf
    return yields


def depth_name(quantity: str, body: str) -> str:
    """Name of the scalar that is the depth of a quantity."""
    return f"{quantity.rsplit('_', 1)[0]}_depth_{body}_mm"


def strength_scalars(
    body: str, shear_yield: float, load: float, needed: float, error: float, summary: Mapping[str, Any],
    surface_yield: float,
) -> tuple[dict[str, float], dict[str, float]]:
    """Shakedown factor and surface fatigue index of a body with a `shear_yield` stress k under a `load` W, and their errors.

    `needed` is the shear yield stress needed for shakedown, `surface_yield` that of the surface (nan where it does not yield),
    all in MPa, W in N, the `error` of `needed` over the largest pressure. `summary` has the scalars of the surface. The index
    is FI = |F|/W − k/p₀ (Ekberg, Kabo & Andersson 2002: μ_util − 2πabk/(3W) for a Hertz contact): surface fatigue is
    predicted above zero."""
    pressure = summary["pressure_max_MPa"]
    # A force that is prescribed has no error.
    uncertain = math.hypot(*(np.nan_to_num(summary["uncertainty"][force]) for force in FORCES))
    names = f"shakedown_factor_{body}", f"fatigue_index_surface_{body}"
    values = shear_yield / needed, math.hypot(*(summary[force] for force in FORCES)) / load - surface_yield / pressure
    of_pressure = summary["uncertainty"]["pressure_max_MPa"] / pressure
    errors = error * pressure / needed, uncertain / load + surface_yield / pressure * of_pressure
    return dict(zip(names, values, strict=True)), dict(zip(names, errors, strict=True))

"""Strength of one body, layer by layer: yield stress needed for shakedown, alternating plasticity and Dang Van's stress."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray, Array
from thermoroll_cli.numerics.convolution import unfolded
from thermoroll_cli.problem.error_scale import FORCES, absolute_error
from thermoroll_cli.problem.names import SUBSURFACE_SCALARS
from thermoroll_cli.problem.problem import Strength
from thermoroll_cli.problem.result import Peak
from thermoroll_cli.stress.invariants import von_mises
from thermoroll_cli.stress.shakedown import LineFatigue, largest_over_depth, layer_shakedown, line_fatigue


@dataclass
class StrengthCollector:
    """Collects the layers of one body from the surface down; `columns` along y hold y > 0 of a `mirrored` state."""

    strength: Strength
    depths: Array
    columns: int
    mirrored: bool
    thermal: bool
    shakedown_k: Array = field(init=False)
    elastic_k: Array = field(init=False)
    limit_k: Array = field(init=False)
    residual: Array = field(init=False)
    alternating_k: Array = field(init=False)
    dang_van: Array = field(init=False)
    _above: LineFatigue | None = None

    def __post_init__(self) -> None:
        layers = len(self.depths)
        self.shakedown_k, self.elastic_k, self.limit_k = np.empty(layers), np.empty(layers), np.empty(layers)
        self.residual = np.empty((layers, 3))
        self.alternating_k, self.dang_van = np.empty((layers, self.columns)), np.empty((layers, self.columns))

    def take(self, layer: int, elastic: AnyArray, total: AnyArray) -> None:
        """One layer: elastic and total stresses (6, nx, columns) in Pa, the same array without thermal stresses."""
        needed = layer_shakedown(total, mirrored=self.mirrored)
        self.shakedown_k[layer], self.residual[layer] = needed.k, needed.residual
        self.elastic_k[layer] = layer_shakedown(elastic, mirrored=self.mirrored).k if self.thermal else needed.k
        self.limit_k[layer] = float(von_mises(total).max()) / math.sqrt(3.0)
        start = None if self._above is None else self._above.balls
        self._above = line_fatigue(total, self.strength.dang_van_coefficient, start)
        self.alternating_k[layer], self.dang_van[layer] = self._above.alternating_k, self._above.dang_van

    def peaks(self, every: int = 1) -> dict[str, tuple[Peak, Peak]]:
        """Largest values (Pa) at the surface and below it, from every layer or only every `every`-th one. Those below are nan
        where values only fall from the surface."""
        found = {}
        for name, values in (("shakedown_k", self.shakedown_k), ("elastic_shakedown_k", self.elastic_k),
                             ("alternating_k", self.alternating_k.max(axis=1)), ("dang_van_max", self.dang_van.max(axis=1))):
            below, depth = largest_over_depth(self.depths[::every], values[::every])
            found[name] = Peak(float(values[0]), 0.0, 0.0, 0.0), Peak(below, 0.0, 0.0, depth)
        return found

    def scalars(self, body: str, every: int = 1) -> dict[str, float]:
        """Scalars in the units of their names (`SUBSURFACE_SCALARS`)."""
        scalars: dict[str, float] = {}
        for name, (surface, below) in self.peaks(every).items():
            strongest = stronger(surface, below)
            scalars[f"{name}_{body}_MPa"] = strongest.value * 1e-6
            if not name.startswith("elastic"):
                scalars[f"{name}_below_{body}_MPa"] = below.value * 1e-6
                scalars[f"{name}_surface_{body}_MPa"] = surface.value * 1e-6
            if (depth := depth_name(name, body)) in SUBSURFACE_SCALARS:
                scalars[depth] = strongest.z * 1e3
        return scalars

    def at_surface(self, body: str) -> set[str]:
        """Names of the scalars whose largest value lies at the surface."""
        names = set()
        for name, (surface, below) in self.peaks().items():
            names |= {f"{name}_surface_{body}_MPa"}
            if stronger(surface, below) is surface:
                names |= {f"{name}_{body}_MPa", depth_name(name, body)}
        return names

    def fields(self) -> dict[str, AnyArray]:
        """The kept fields over z, or over z and y, on both sides of a mirror (names of `STRENGTH_FIELDS`)."""
        lines = {"alternating_k": self.alternating_k, "dang_van": self.dang_van}
        return {
            "shakedown_k": self.shakedown_k, "elastic_shakedown_k": self.elastic_k, "elastic_limit_k": self.limit_k,
            **{f"residual_{name}": self.residual[:, i] for i, name in enumerate(("xx", "yy", "xy"))},
            **{name: unfolded(values[:, None, :], 1)[:, 0] if self.mirrored else values for name, values in lines.items()},
        }


def stronger(surface: Peak, below: Peak) -> Peak:
    """The larger of two peaks; the one below the surface if both are equal."""
    return below if below.value >= surface.value else surface


def depth_name(quantity: str, body: str) -> str:
    """Name of the scalar that is the depth of a quantity."""
    return f"{quantity.rsplit('_', 1)[0]}_depth_{body}_mm"


def strength_scalars(
    body: str, shear_yield: float, load: float, needed: float, error: float, summary: Mapping[str, Any]
) -> tuple[dict[str, float], dict[str, float]]:
    """Shakedown factor and surface fatigue index of a body with a `shear_yield` stress k under a `load` W, and their errors.

    `needed` is the shear yield stress needed for shakedown; both in MPa, W in N, the `error` of `needed` over the largest
    pressure. `summary` has the scalars of the surface. The index is FI = |F|/W − k/p₀ (Ekberg, Kabo & Andersson 2002: μ_util −
    2πabk/(3W) for a Hertz contact): surface fatigue is predicted above zero."""
    pressure = summary["pressure_max_MPa"]
    # A force that is prescribed has no error.
    uncertain = math.hypot(*(np.nan_to_num(absolute_error(force, summary)) for force in FORCES))
    names = f"shakedown_factor_{body}", f"fatigue_index_surface_{body}"
    values = shear_yield / needed, math.hypot(*(summary[force] for force in FORCES)) / load - shear_yield / pressure
    errors = error * pressure / needed, uncertain / load + shear_yield / pressure * summary["error"]["pressure_max_MPa"]
    return dict(zip(names, values, strict=True)), dict(zip(names, errors, strict=True))

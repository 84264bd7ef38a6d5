"""Strength of one body, layer by layer: yield stress needed for shakedown, alternating plasticity and Dang Van's stress."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from thermoroll_cli.arrays import AnyArray, Array
from thermoroll_cli.numerics.mirror import unfolded
from thermoroll_cli.problem.problem import Strength
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

    def scalars(self, body: str, every: int = 1) -> dict[str, float]:
        """Scalars in the units of their names (`SUBSURFACE_SCALARS`), from every layer or only every `every`-th one."""
        found: dict[str, float] = {}
        depths = self.depths[::every]
        for name, values in (("shakedown_k", self.shakedown_k), ("alternating_k", self.alternating_k.max(axis=1)),
                             ("dang_van_max", self.dang_van.max(axis=1))):
            layers = values[::every]
            below, depth = largest_over_depth(depths, layers)
            found[f"{name}_{body}_MPa"] = float(np.fmax(below, layers[0])) * 1e-6
            found[f"{name}_below_{body}_MPa"] = below * 1e-6
            found[f"{name}_surface_{body}_MPa"] = float(layers[0]) * 1e-6
            if name != "alternating_k":
                found[f"{name.rsplit('_', 1)[0]}_depth_{body}_mm"] = depth * 1e3 if below >= layers[0] else 0.0
        elastic = self.elastic_k[::every]
        found[f"elastic_shakedown_k_{body}_MPa"] = float(np.fmax(largest_over_depth(depths, elastic)[0], elastic[0])) * 1e-6
        return found

    def at_surface(self, body: str) -> set[str]:
        """Names of the scalars whose largest value lies at the surface."""
        names = {f"{name}_surface_{body}_MPa" for name in ("shakedown_k", "alternating_k", "dang_van_max")}
        for name in ("shakedown_k", "alternating_k", "dang_van_max", "elastic_shakedown_k"):
            values = {"shakedown_k": self.shakedown_k, "elastic_shakedown_k": self.elastic_k,
                      "alternating_k": self.alternating_k.max(axis=1), "dang_van_max": self.dang_van.max(axis=1)}[name]
            if values[0] >= values[1:].max():
                names |= {f"{name}_{body}_MPa", f"{name.rsplit('_', 1)[0]}_depth_{body}_mm"}
        return names

    def fields(self) -> dict[str, AnyArray]:
        """The kept fields over z, or over z and y, on both sides of a mirror (names of `STRENGTH_FIELDS`)."""
        lines = {"alternating_k": self.alternating_k, "dang_van": self.dang_van}
        return {
            "shakedown_k": self.shakedown_k, "elastic_shakedown_k": self.elastic_k, "elastic_limit_k": self.limit_k,
            **{f"residual_{name}": self.residual[:, i] for i, name in enumerate(("xx", "yy", "xy"))},
            **{name: unfolded(values[:, None, :], 1)[:, 0] if self.mirrored else values for name, values in lines.items()},
        }


def strength_scalars(body: str, shear_yield: float, needed: float, pressure: float, utilised: float) -> dict[str, float]:
    """Shakedown factor and surface fatigue index of a body with a `shear_yield` stress k (Pa).

    `needed` is the shear yield stress needed for shakedown (MPa), `pressure` the largest pressure (MPa), `utilised` |F|/W. The
    index is FI = |F|/W − k/p₀ (Ekberg, Kabo & Andersson 2002: μ_util − 2πabk/(3W) for a Hertz contact): surface fatigue is
    predicted above zero."""
    return {f"shakedown_factor_{body}": shear_yield * 1e-6 / needed,
            f"fatigue_index_surface_{body}": utilised - shear_yield * 1e-6 / pressure}

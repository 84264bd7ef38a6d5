"""The content of a table: its axes, the solved values, and their errors."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.creep_table.scaling import directions, magnitude

LARGEST_MAGNITUDE = 1e4
"""Stands for full sliding, u = 1: what is left of the elastic creep there is of the order of its inverse."""

DEFAULT_ASPECTS = (0.05, 0.075, 0.11, 0.155, 0.21, 0.27, 0.33, 0.39, 0.455, 0.53, 0.615, 0.84, 1.0, 1.42, 2.2, 3.6, 5.0, 10.0,
                   20.0)
"""Closest where forces change most with a/b: around 1/2, where spin turns from hindering to helping the lateral force."""
DEFAULT_MAGNITUDES, DEFAULT_DIRECTIONS, DEFAULT_SPINS = 25, 13, 41
DEFAULT_POISSON = 0.28
FEWEST = 5
"""Nodes that a cubic spline with free ends needs."""


@dataclass(frozen=True)
class Axes:
    """`aspect_ratios` a/b, increasing; numbers of evenly spaced `magnitudes` u, `directions` v and `spins` w (`scaling`)."""

    aspect_ratios: tuple[float, ...] = DEFAULT_ASPECTS
    magnitudes: int = DEFAULT_MAGNITUDES
    directions: int = DEFAULT_DIRECTIONS
    spins: int = DEFAULT_SPINS

    def __post_init__(self) -> None:
        ratios = self.aspect_ratios
        if not ratios or not all(math.isfinite(r) and r > 0.0 for r in ratios):
            raise ValueError(f"aspect ratios a/b must be positive and finite, got {_listed(ratios)}")
        if any(later <= earlier for earlier, later in itertools.pairwise(ratios)):
            raise ValueError(f"aspect ratios a/b must increase, got {_listed(ratios)}")
        for name in ("magnitudes", "directions", "spins"):
            if getattr(self, name) < FEWEST:
                raise ValueError(f"at least {FEWEST} {name} are needed, got {getattr(self, name)}")
        if self.spins % 2 == 0:
            raise ValueError(f"the number of spins must be odd, so that no spin is among them, got {self.spins}")

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the values of one ellipse."""
        return self.magnitudes, self.directions, self.spins

    @property
    def points(self) -> int:
        """To be solved for one ellipse: not those without creepage."""
        return (self.magnitudes - 1) * self.directions * self.spins

    @property
    def u(self) -> Array:
        return np.linspace(0.0, 1.0, self.magnitudes)

    @property
    def v(self) -> Array:
        return np.linspace(0.0, 1.0, self.directions)

    @property
    def w(self) -> Array:
        return np.linspace(-1.0, 1.0, self.spins)

    def scaled(self, first: int, last: int) -> Array:
        """(X, Y, Z) of the points first … last − 1 of one ellipse, (3, n)."""
        with np.errstate(divide="ignore"):
            sizes = np.minimum(magnitude(self.u[1:-1]), LARGEST_MAGNITUDE)
        sizes = np.append(sizes, LARGEST_MAGNITUDE)
        level, v, w = np.unravel_index(np.arange(first, last), (self.magnitudes - 1, self.directions, self.spins))
        return np.asarray(sizes[level] * directions(self.v[v], self.w[w]))


@dataclass(frozen=True)
class Quality:
    """Errors of forces over μW: those of the solver, estimated over all points, and differences between table and solver at
    `points` random ones that are not in the table (nan: not measured)."""

    solver_rms: float = math.nan
    solver_max: float = math.nan
    points: int = 0
    rms: float = math.nan
    largest: float = math.nan


@dataclass(frozen=True)
class TableValues:
    """`values` (ellipses, 4, magnitudes, directions, spins) of `QUANTITIES`, nan where a point has no solution (a hole);
    `errors` of the forces, the same without the quantities; Poisson's ratio and the accuracy that was asked for."""

    axes: Axes
    poisson_ratio: float
    accuracy: float
    values: Array
    errors: Array
    quality: Quality = field(default_factory=Quality)

    @property
    def holes(self) -> int:
        return int(np.isnan(self.values[:, 0]).sum())


def _listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values) or "none"

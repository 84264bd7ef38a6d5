"""What comes out of each body below the surface."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import AnyArray


@dataclass(frozen=True)
class Peak:
    """A largest value and where it is (SI)."""

    value: float = math.nan
    x: float = math.nan
    y: float = math.nan
    z: float = math.nan


@dataclass(frozen=True)
class BodyStresses:
    """One body: `fields` (nz, nx, ny) as asked for, `plane` (nz, nx) at y = `plane_y`, `below_stressed` and `below_heated`
    (nz,), lines into the depth below the most stressed and the hottest point of the surface (SI, names of
    `SUBSURFACE_FIELDS`), in single precision, at `depths` (nz,). `most_stressed` is the largest von Mises stress."""

    depths: NDArray[np.float64]
    plane_y: float
    plane: Mapping[str, AnyArray]
    most_stressed: Peak
    hottest: Peak | None
    below_stressed: Mapping[str, AnyArray]
    below_heated: Mapping[str, AnyArray] = field(default_factory=dict)
    fields: Mapping[str, AnyArray] = field(default_factory=dict)


@dataclass(frozen=True)
class Subsurface:
    """Stresses below the surface: the `bodies`, all `scalars` and their `error` (names of `SUBSURFACE_SCALARS`; errors as
    `error_scale` says), and what a person should know, `warnings`."""

    bodies: Mapping[str, BodyStresses]
    scalars: Mapping[str, float]
    error: Mapping[str, float]
    warnings: tuple[str, ...] = ()

"""Below the surface: what is asked for, and what comes out of each body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.kernels.arrays import AnyArray

BodyName = Literal["lower", "upper"]
KeptFields = Literal["plane", "von_mises", "full"]

BODIES: tuple[BodyName, ...] = ("lower", "upper")

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_xz", "stress_yz")

SUBSURFACE_FIELDS: dict[str, tuple[str, str]] = {
    "von_mises": ("Pa", "von Mises stress"),
    "von_mises_elastic": ("Pa", "von Mises stress without thermal stresses"),
    "temperature_rise": ("K", "temperature rise"),
    "stress_xx": ("Pa", "normal stress along x"),
    "stress_yy": ("Pa", "normal stress along y"),
    "stress_zz": ("Pa", "normal stress along z"),
    "stress_xy": ("Pa", "shear stress xy"),
    "stress_xz": ("Pa", "shear stress xz, z into the body"),
    "stress_yz": ("Pa", "shear stress yz, z into the body"),
}
"""Fields of one body, with SI unit and long name; tension is positive, z points into the body."""

_QUANTITIES = {
    "von_mises_max_{}_MPa": "largest von Mises stress",
    "von_mises_depth_{}_mm": "its depth",
    "von_mises_x_{}_mm": "its place along x",
    "von_mises_y_{}_mm": "its place along y",
    "orthogonal_shear_range_max_{}_MPa": "largest range of σ_xz along a line of rolling",
    "orthogonal_shear_range_depth_{}_mm": "its depth",
    "tensile_stress_max_{}_MPa": "largest first principal stress",
}

SUBSURFACE_SCALARS: dict[str, str] = {
    f"{prefix}{name.format(body)}": f"{meaning}{without}, {body} body"
    for body in BODIES
    for prefix, without in (("", ""), ("elastic_", " without thermal stresses"))
    for name, meaning in _QUANTITIES.items()
}
"""Scalars of both bodies, in the units of their names, in the order they are reported."""


@dataclass(frozen=True)
class SubsurfaceRequest:
    """What to compute below the surface (SI): the bodies, the `depth` of the last layer and the number of `layers` (None: by
    the size of the contact and of the heated skin), whether `thermal` stresses are added, and which fields are kept."""

    bodies: tuple[BodyName, ...] = BODIES
    depth: float | None = None
    layers: int | None = None
    thermal: bool = True
    fields: KeptFields = "plane"


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

"""The depths at which stresses are computed."""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import SubsurfaceRequest
from thermoroll_cli.steady_state.derived import DerivedQuantities

FIRST, RATIO, DEPTH = 0.05, 1.157, 2.2
"""Depth of the first layer below the surface, in the smaller semi-axis of the contact; ratio of one layer to the next above;
depth of the last. 28 layers: the largest von Mises stress of round and line contacts lies at 0.48 and 0.70."""
SKIN = 0.3
"""First layer in thicknesses of the heated skin."""


def skin_depth(semi_axis: float, peclet: float) -> float:
    """Depth 2a/√Pe to which heat spreads while the material passes the contact, in m; infinite without motion."""
    return 2.0 * semi_axis / math.sqrt(peclet) if peclet > 0.0 else math.inf


def layer_depths(width: float, depth: float | None = None, layers: int | None = None, skin: float = math.inf) -> Array:
    """Depths in m: the surface, then a geometric sequence down to `depth` (default 2.2 of `width`).

    `width` is the smaller semi-axis of the contact. The first layer lies at 0.05 of it, or at 0.3 `skin` if heat enters
    less; where so many `layers` reach that by equal steps, steps are equal. Without a number of layers there are as many as
    a ratio of 1.157 takes."""
    last = DEPTH * width if depth is None else depth
    first = min(FIRST * width, SKIN * skin, 0.5 * last)
    if layers is None:
        layers = 2 + math.ceil(math.log(last / first) / math.log(RATIO) - 1e-9)
    first = min(first, last / (layers - 1))
    if layers == 2:
        return np.array([0.0, last])
    if first * (layers - 1) >= last * (1.0 - 1e-12):
        return np.linspace(0.0, last, layers)
    return np.concatenate([[0.0], np.geomspace(first, last, layers - 1)])


def depths_of(request: SubsurfaceRequest, derived: DerivedQuantities, *, heated: bool) -> Array:
    """Depths of the layers of a problem in m, with thermal stresses or without (`heated`)."""
    width = min(derived.scales.semi_axis_x, derived.scales.semi_axis_y)
    skin = math.inf
    if heated and derived.problem.heating.peclet == "rolling":
        materials = {"lower": derived.problem.lower, "upper": derived.problem.upper}
        skin = min(skin_depth(derived.scales.semi_axis_x, derived.peclet(materials[body])) for body in request.bodies)
    return layer_depths(width, request.depth, request.layers, skin)

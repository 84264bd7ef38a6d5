"""Surfaces with heights on rails and wheels: by how much they lift a wheel, and what they leave to its patches.

Heights of a rail are upwards, those of a wheel along its radius: along normals they close the gap by their part cos α. They
lift the rail by what makes the wheel touch their highest place around first contact, and what they lack of that there closes
the gap of each patch. A patch then has an approach above 0 wherever surfaces meet: an edge of a flat, a crest. How high the
rail is lifted beyond that changes nothing but what the search for patches begins with."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.many_contacts.wheelset.curves import curve
from thermoroll_cli.many_contacts.wheelset.placement import RailSide, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.problem.surface import Heights
from thermoroll_cli.tools.arrays import Array

FARTHEST, ACROSS, CELLS = 0.04, 3e-3, (201, 7)
"""Distances (m) from first contact along and across up to which the highest place is looked for, and how many cells."""

Standing = dict[str, tuple[Heights, float, float]]
"""Surfaces of a "rail" and a "wheel", each with its place u (m) in the middle of a contact, and the y (m) of its outline."""


def standing(facing: Facing, x: float, on_rail: int, on_wheel: int) -> Standing:
    """The surfaces of rail and wheel at a place `x` (m) ahead of the axle, at samples of their outlines."""
    rail, wheel = facing.rail, facing.wheel
    sides: dict[str, tuple[RailSide | WheelSide, float, int]] = {
        "rail": (rail, rail.along, on_rail), "wheel": (wheel, wheel.radius * wheel.turned, on_wheel)}
    return {name: (side.surface, there + x, float(curve(side.profile).samples[0][number]))
            for name, (side, there, number) in sides.items() if side.surface is not None}


def lift(facing: Facing) -> float:
    """By how much (m) the surfaces of rail and wheel lift the wheel: max(h − x²/2R) around first contact."""
    if facing.rail.surface is None and facing.wheel.surface is None:
        return 0.0
    k = int(np.argmin(facing.gap))
    on_rail, on_wheel = (round(outline.index[k]) for outline in facing.outlines)
    there = standing(facing, float(facing.ahead[k]), on_rail, on_wheel).values()
    # Further away the wheel has risen by more than heights differ.
    reach = min(math.sqrt(2.0 * facing.wheel.radius * sum(surface.texture.range for surface, *_ in there)), FARTHEST)
    along, across = (np.linspace(-size, size, count + 1) for size, count in zip((reach, ACROSS), CELLS, strict=True))
    heights = np.sum([surface.over(u + along, y + across) for surface, u, y in there], axis=0)
    risen = (0.5 * (along[1:] + along[:-1])) ** 2 / (2.0 * facing.wheel.radius)
    return float((heights - risen[:, None]).max())


@dataclass(frozen=True)
class OnPatch:
    """Heights that close the gap of a patch, whose y rises against that of its `surfaces`; less what has `lifted` (m) the rail.
    The surface in which the bodies touch has the `cosine` of its inclination at the places `across` (m)."""

    surfaces: tuple[tuple[Heights, float, float], ...]
    lifted: float
    across: tuple[float, ...]
    cosine: tuple[float, ...]

    def over(self, along: Array, across: Array) -> Array:
        """As `surface.Closing.over`."""
        heights = np.sum([surface.over((u - along)[::-1], (y - across)[::-1])[::-1, ::-1] for surface, u, y in self.surfaces],
                         axis=0)
        return np.asarray((heights - self.lifted) * np.interp(0.5 * (across[1:] + across[:-1]), self.across, self.cosine))

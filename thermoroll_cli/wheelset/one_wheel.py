"""Wheels on their rails under a vertical force: their height, and how the patches share the load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.wheelset.indentation import Indentation
from thermoroll_cli.wheelset.patch_surface import PatchSurface
from thermoroll_cli.wheelset.search import Facing

SAME_PATCH = 4e-3
"""Patches of two positions are the same if they lie closer than this (m) on the rail: they are tracked by place, since their
number changes."""
SHARE_ROUNDS = 12
"""Rounds in which patches that press each other apart share the load."""
SHARED = 1e-5
"""Change of the displacement by neighbours over the overlap at which they have shared it."""
HEIGHT_ROUNDS = 40
BALANCED = 1e-5
"""Departure of the vertical force, relative, with which a height is found: the coarse grid moves it by ten times as much."""
DEEPEST = 1e-3
"""Largest lowering (m) of a wheel beyond first contact: deeper than any elastic contact."""


class NoHeight(ArithmeticError):
    """Wheels carry their force at no height: the largest force is `largest` (N), at the height `z` (m), with the patches
    `bearings` of all of them."""

    def __init__(self, largest: float, z: float, bearings: Sequence[Bearing]) -> None:
        super().__init__(f"the largest vertical force at any height is {largest:.4g} N")
        self.largest, self.z, self.bearings = largest, z, bearings


@dataclass(frozen=True)
class Solved:
    """Results of a patch on a fine grid about y = `place` (m) on the rail: its vertical force over its load, and its approach
    over that of the coarse grid at the same load."""

    place: float
    vertical: float
    approach: float = 1.0


@dataclass(frozen=True)
class Bearing:
    """A patch that carries `load` (N) with an approach `sunk` (m): its overlap less the displacement by its neighbours.
    `vertical` is the vertical force over the load, `over_coarse` the approach over that of the coarse grid, as they were
    known."""

    patch: PatchSurface
    load: float
    sunk: float
    vertical: float
    over_coarse: float

    @property
    def lateral(self) -> float:
        """Lateral force over the load, as of a right wheel, without the forces along the track: friction makes up the
        difference of `vertical` from the vertical part of the load."""
        angle = self.patch.region.place.angle
        sine, cosine = math.sin(angle), math.cos(angle)
        return (self.vertical - cosine) * cosine / sine - sine


@dataclass(frozen=True)
class WheelOnRail:
    """A right wheel over its rail, `facing` at any height, with the modulus of contact (Pa) and what is known from fine
    grids, `solved`."""

    facing: Facing
    contact_modulus: float
    solved: tuple[Solved, ...] = ()
    curved: bool = True

    def bearings(self, lowered: float) -> list[Bearing]:
        """The patches that carry load when the wheel is lower by this height (m).

            δ_i(W_i) + Σ_j≠i W_j/(π E* d_ij) = overlap_i

        with the displacement by neighbours as of point loads. A patch that its neighbours have pressed out of its overlap
        carries nothing."""
        facing = self.facing.lowered(lowered)
        patches = [PatchSurface(facing, region, self.curved) for region in facing.regions()]
        patches = [patch for patch in patches if patch.faces]
        indentations = [Indentation(patch, self.contact_modulus) for patch in patches]
        known = [self._known(patch) for patch in patches]
        apart = np.zeros(len(patches))
        loads = np.zeros(len(patches))
        for _ in range(SHARE_ROUNDS):
            before = apart.copy()
            for k, (indentation, solved) in enumerate(zip(indentations, known, strict=True)):
                # Planes are there to compare with programs in which each patch is alone.
                apart[k] = self._displaced(patches, loads, k) if self.curved else 0.0
                loads[k] = indentation.load(apart[k], solved.approach)
            if len(patches) < 2 or np.abs(apart - before).max() <= SHARED * max(patch.overlap[0] for patch in patches):
                break
        return [Bearing(patch, float(load), patch.overlap[0] - float(by_others), solved.vertical,
                        solved.approach)
                for patch, load, by_others, solved in zip(patches, loads, apart, known, strict=True) if load > 0.0]

    def _known(self, patch: PatchSurface) -> Solved:
        place = patch.region.place
        near = min(self.solved, key=lambda solved: abs(solved.place - place.y), default=None)
        if near is not None and abs(near.place - place.y) < SAME_PATCH:
            return near
        return Solved(place.y, math.cos(place.angle))

    def _displaced(self, patches: Sequence[PatchSurface], loads: np.ndarray, k: int) -> float:
        here = patches[k].region.place
        away = [math.dist((here.x, here.y, here.z), (p.region.place.x, p.region.place.y, p.region.place.z)) for p in patches]
        return float(sum(load / (math.pi * self.contact_modulus * d)
                         for j, (load, d) in enumerate(zip(loads, away, strict=True)) if j != k))


def height_of(wheels: Sequence[WheelOnRail], vertical: float, start: float | None = None) -> tuple[float, list[list[Bearing]]]:
    """Lowering (m) with which `wheels` together carry the `vertical` force (N), and the patches of each there; `start` is a
    guess.

    A secant on F^⅔, which is linear for one patch, in a bracket from first contact on. Raises NoHeight."""
    first = min(wheel.facing.clearance for wheel in wheels)
    low, high = first, math.inf
    before = first, -(vertical ** (2.0 / 3.0))
    z = start if start is not None and start > first else first + _depth(vertical, wheels[0])
    largest, highest, there = -math.inf, z, []
    for _ in range(HEIGHT_ROUNDS):
        bearings = [wheel.bearings(z) for wheel in wheels]
        force = sum(bearing.load * bearing.vertical for patches in bearings for bearing in patches)
        if force > largest:
            largest, highest, there = force, z, [bearing for patches in bearings for bearing in patches]
        if abs(force - vertical) <= BALANCED * vertical or high - low < BALANCED * (z - first):
            return z, bearings
        low, high = (z, high) if force < vertical else (low, z)
        value = math.copysign(abs(force) ** (2.0 / 3.0), force) - vertical ** (2.0 / 3.0)
        step = -value * (z - before[0]) / (value - before[1]) if value != before[1] else math.inf
        before = z, value
        limit = 0.5 * (low + high) if math.isfinite(high) else low + 2.0 * (low - first)
        z = z + step if low < z + step < min(high, first + 8.0 * (z - first)) else limit
        if z - first > DEEPEST:
            break
    raise NoHeight(largest, highest, there)


def _depth(vertical: float, wheel: WheelOnRail) -> float:
    """Approach of a sphere as large as the wheel."""
    return float((9.0 * vertical**2 / (16.0 * wheel.contact_modulus**2 * wheel.facing.wheel.radius)) ** (1.0 / 3.0))

"""Wheels on their rails under a vertical force: their height, and how the patches share the load."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from thermoroll_cli.many_contacts.wheelset.indentation import Indentation
from thermoroll_cli.many_contacts.wheelset.patch_surface import PatchSurface, patches_of
from thermoroll_cli.many_contacts.wheelset.placement import Position
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.many_contacts.wheelset.varying import varying_patch
from thermoroll_cli.physics.numerics.roots import RisingRoot
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.tools.arrays import Array

Found = TypeVar("Found")

SAME_PATCH = 4e-3
"""Patches of two positions are the same if they lie closer than this (m) on the rail: they are tracked by place, since their
number changes."""
SHARE_ROUNDS = 12
"""Steps of Newton's method in which patches that press each other apart share the load: two or three are usual."""
HARDLY, CLOSELY = 3e-2, 300.0
"""A wheel keeps its patches while it moves by less than the one share of its overlap, and than the other times the departure
with which a height is found. A patch that appears within the former carries no more than 5e-3 of the load. Gaps change by the
motion along their normals but for a few per cent of it: where the surface turns by 0.8 rad across a patch, forces would move by
5e-3 of the load with the former alone, else by 6e-5."""
HEIGHT_ROUNDS = 40
BALANCED = 1e-5
"""Departure of the vertical force, relative, with which a height is found, of the displacement by neighbours over the overlap,
and of the gap over the elastic displacement: the coarse grid moves them by ten times as much."""
STIFFENING = 1.5
"""Exponent of the load over the approach, of Hertz's contact."""
JOINED = 0.1
"""Where a force lies between those of two patches and of the one that they become, both are one already while the gap between
them is below this share of the overlap. As two they displace each other like point loads: the force of a worn wheel on its
rail jumps by 3 %, which is 2 % of the overlap."""
DEEPEST = 1e-3
"""Largest approach (m) along the normal of first contact: deeper than any elastic contact."""


def deepest(facing: Facing) -> float:
    """Largest lowering (m) of the wheel of `facing` beyond first contact: on a flange the approach is a small part of it."""
    return DEEPEST / math.cos(float(facing.angle[int(np.argmin(facing.gap))]))


class NoHeight(ArithmeticError):
    """Wheels carry their force at no height: the largest force is `largest` (N), at the height `z` (m), with the patches
    that are `carrying` it."""

    def __init__(self, largest: float, z: float, carrying: Sequence[CarryingPatch]) -> None:
        super().__init__(f"the largest vertical force at any height is {largest:.4g} N")
        self.largest, self.z, self.carrying = largest, z, carrying


@dataclass(frozen=True)
class CarryingPatch:
    """A patch that carries `load` (N) with an approach `sunk` (m): its overlap less the displacement by its neighbours.
    `vertical` is the vertical force over the load, `over_coarse` the approach over that of the coarse grid, as they are
    known from a fine grid; without one, as without friction."""

    patch: PatchSurface
    load: float
    sunk: float
    vertical: float
    over_coarse: float

    @property
    def lateral(self) -> float:
        """Lateral force over the load, as of a right wheel, without the forces along the track: friction makes up the
        difference of `vertical` from the vertical part of the load."""
        angle = self.patch.angle
        sine, cosine = math.sin(angle), math.cos(angle)
        return (self.vertical - cosine) * cosine / sine - sine


class WheelOnRail:
    """A right wheel over its rail, of the materials of a `contact`. Its patches are kept while it hardly moves."""

    def __init__(self, contact: Problem, *, curved: bool) -> None:
        self.contact_modulus, self.curved = contact.contact_modulus, curved
        self._shares = contact.compliance_shares
        self._joined = 0.0
        self._facing: Facing | None = None
        self._indentations: list[Indentation] = []
        self._loads = np.zeros(0)

    def over(self, facing: Facing) -> Facing:
        """`facing`, or the same one that was there last, whose outlines are known."""
        if facing != self._facing:
            if self._facing is not None and (facing.rail, facing.wheel) != (self._facing.rail, self._facing.wheel):
                # Other surfaces stand here.
                self._indentations = []
            self._facing = facing
        return self._facing

    def join(self) -> bool:
        """Let overlaps be one patch a little before they meet, from now on; False where they are already."""
        before, self._joined, self._indentations = self._joined, JOINED, []
        return not before

    def carrying(
        self, facing: Facing, lowered: float, solved: Sequence[CarryingPatch], within: float = BALANCED
    ) -> list[CarryingPatch]:
        """The patches that carry load when the wheel of `facing` is lower by this height (m), with what is known of them from
        those that were `solved`.

            δ_i(W_i) + Σ_j≠i W_j/(π E* d_ij) = overlap_i

        with the displacement by neighbours as of point loads, by Newton's method with dW_i/dδ_i = 1.5 W_i/δ_i. A patch that its
        neighbours have pressed out of its overlap carries nothing."""
        position = replace(facing.position, z=facing.position.z + lowered)
        moved = [indentation.moved(position) for indentation in self._indentations]
        deepest = max((indentation.overlap() for indentation in self._indentations), default=-1.0)
        if not moved or max(math.hypot(*way) for way in moved) > min(HARDLY, CLOSELY * within) * deepest:
            self._find(facing, position)
            moved = [(0.0, 0.0)] * len(self._indentations)
        known = [_known(indentation.patch, solved) for indentation in self._indentations]
        overlap = np.array([indentation.overlap(way) for indentation, way in zip(self._indentations, moved, strict=True)])
        # Planes serve comparisons with programs in which no patch feels another.
        by_others = self._compliance() if self.curved else np.zeros((len(overlap), len(overlap)))
        apart = by_others @ self._loads
        for _ in range(SHARE_ROUNDS):
            sunk = overlap - apart
            self._loads = np.array([
                indentation.load(way, depth, each[1], within)
                for indentation, way, depth, each in zip(self._indentations, moved, sunk.tolist(), known, strict=True)])
            missed = apart - by_others @ self._loads
            if not by_others.any() or np.abs(missed).max() <= within * overlap.max():
                break
            stiffness = STIFFENING * self._loads / np.where(sunk > 0.0, sunk, 1.0)
            apart = apart - np.linalg.solve(np.eye(len(overlap)) + by_others * stiffness, missed)
        return [CarryingPatch(indentation.patch, float(load), float(depth), *ratios)
                for indentation, load, depth, ratios in zip(self._indentations, self._loads, sunk, known, strict=True)
                if load > 0.0]

    def _find(self, facing: Facing, position: Position) -> None:
        """The patches at a `position` of the wheel."""
        lowered = facing.lowered(position.z - facing.position.z)
        found = patches_of(lowered, curved=self.curved, shares=self._shares, joined=self._joined * max(-lowered.clearance, 0.0),
                           make=varying_patch)
        patches = [patch for patch in found if patch.faces and patch.overlap[0] > 0.0]
        before = self._indentations if len(patches) == len(self._indentations) else [None] * len(patches)
        self._indentations = [Indentation(patch, self.contact_modulus, None if last is None else last.pressure)
                              for patch, last in zip(patches, before, strict=True)]
        if len(self._loads) != len(patches):
            self._loads = np.zeros(len(patches))

    def _compliance(self) -> Array:
        """1/(π E* d_ij) between the patches in m/N, (n, n); 0 of each to itself."""
        patches = [indentation.patch for indentation in self._indentations]
        points = np.array([(patch.x, patch.y, patch.z) for patch in patches]).reshape(-1, 3)
        away = np.linalg.norm(points[:, None] - points, axis=-1)
        away[np.diag_indices(len(points))] = math.inf
        return np.asarray(1.0 / (math.pi * self.contact_modulus * away))


def same_patch(patches: Iterable[Found], y: float, place: Callable[[Found], float]) -> Found | None:
    """The nearest of the `patches` to y (m) on their rail, by the `place` of each, if it is the same one."""
    near = min(patches, key=lambda each: abs(place(each) - y), default=None)
    return None if near is None or abs(place(near) - y) >= SAME_PATCH else near


def _known(patch: PatchSurface, solved: Sequence[CarryingPatch]) -> tuple[float, float]:
    """Vertical force over the load, and approach over that of the coarse grid, of the nearest of those `solved`; without one
    near it, as without friction."""
    near = same_patch(solved, patch.y, lambda carrying: carrying.patch.y)
    level = math.cos(patch.angle) * math.cos(patch.position.tilt)
    return (level, 1.0) if near is None else (near.vertical, near.over_coarse)


Placed = tuple[WheelOnRail, Facing, Sequence[CarryingPatch]]
"""A wheel at its place except for its height, and what is known of its patches."""


def height_of(wheels: Sequence[Placed], vertical: float, start: float | None,
              within: float) -> tuple[float, list[list[CarryingPatch]]]:
    """Lowering (m) with which `wheels` together carry the `vertical` force (N), and the patches of each there; `start` is a
    guess, from first contact on. The force is met `within` a share.

    A secant on F^⅔, which is linear for one patch, in a bracket from first contact on. Raises NoHeight."""
    first = min(facing.clearance for _, facing, _ in wheels)
    wheel, facing, _ = wheels[0]
    # The approach of a sphere as large as the wheel.
    depth = (9.0 * vertical**2 / (16.0 * wheel.contact_modulus**2 * facing.wheel.radius)) ** (1.0 / 3.0)
    power = vertical ** (2.0 / 3.0)
    most = max(deepest(facing) for _, facing, _ in wheels if facing.clearance - first <= DEEPEST)
    root = RisingRoot(first + (start or depth), power / depth, most / 4.0, first, first + most, (first, -power))
    largest, highest, there, counts = -math.inf, root.place, [], {True: [0] * len(wheels), False: [0] * len(wheels)}
    for _ in range(HEIGHT_ROUNDS):
        z = root.place
        carrying = [wheel.carrying(facing, z, solved, within) for wheel, facing, solved in wheels]
        force = sum(patch.load * patch.vertical for patches in carrying for patch in patches)
        if force > largest:
            largest, highest, there = force, z, [patch for patches in carrying for patch in patches]
        counts[force > vertical] = [len(patches) for patches in carrying]
        jumps = root.width < within * (z - first)
        if jumps and any([wheel.join() for (wheel, _, _), above, below in zip(wheels, counts[True], counts[False], strict=True)
                          if 0 < above < below]):
            return height_of(wheels, vertical, z - first, within)
        if abs(force - vertical) <= within * vertical or (jumps and largest > vertical):
            return z, carrying
        if jumps:
            break
        root.move(math.copysign(abs(force) ** (2.0 / 3.0), force) - power)
    raise NoHeight(largest, highest, there)

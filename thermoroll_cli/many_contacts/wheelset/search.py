"""An undeformed wheel over its rail, as outlines across the track."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from thermoroll_cli.many_contacts.wheelset.curves import STEP, Outline, outline
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide, locus
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.tools.arrays import Array


@dataclass(frozen=True)
class Facing:
    """A right wheel over a right rail, both as outlines over the same places y; the height of `position` counts. `other` is the
    same wheel at another height, whose locus and outline only move on a straight rail."""

    rail: RailSide
    wheel: WheelSide
    position: Position
    other: Facing | None = None

    @cached_property
    def locus(self) -> Array:
        """Rows x, y, z, dy/ds, dz/ds as of `placement.locus`."""
        if self.other is None:
            return locus(self.wheel, self.position, self.rail.roller)
        lower = self.position.z - self.other.position.z
        return np.asarray(self.other.locus + lower * np.array([[0.0], [0.0], [1.0], [0.0], [0.0]]))

    @cached_property
    def outlines(self) -> tuple[Outline, Outline]:
        """Highest surface of the rail and lowest of the wheel over the y that both have. Raises Unsolvable if there is none."""
        if self.other is not None:
            top, bottom = self.other.outlines
            return top, replace(bottom, z=bottom.z + self.position.z - self.other.position.z)
        rail, wheel = self.rail.samples, self.locus
        low, high = max(rail[0].min(), np.nanmin(wheel[1])), min(rail[0].max(), np.nanmax(wheel[1]))
        if not low < high:
            clearance, where = max(low - high, 0.0), "beside" if np.nanmin(wheel[1]) > rail[0].max() else "between"
            raise Unsolvable(f"the wheel lies {where} the rails: it misses its rail by {1e3 * clearance:.3g} mm",
                             "wheelset.lateral_shift_mm")
        at = np.linspace(low, high, max(int((high - low) / STEP), 2))
        return outline(rail[0], rail[1], at, lowest=False), outline(wheel[1], wheel[2], at, lowest=True)

    @cached_property
    def ahead(self) -> Array:
        """x (m) of the places at which wheel and rail are nearest, over the places of the outlines."""
        return self.outlines[1].of(self.locus[0])

    @cached_property
    def gap(self) -> Array:
        """z of the rail less that of the wheel in m, over the places of the outlines; inf where one of them is missing."""
        rail, wheel = self.outlines
        gap = rail.z - wheel.z
        return np.asarray(np.where(np.isnan(gap), np.inf, gap))

    @cached_property
    def angle(self) -> Array:
        """Inclination of the rail over the places of the outlines in rad."""
        rail = self.outlines[0]
        across, down = (rail.of(slope) for slope in self.rail.samples[2:])
        return np.arctan2(np.where(across < 0.0, -down, down), np.abs(across))

    def lowered(self, by: float) -> Facing:
        """The same wheel lower by this height (m)."""
        other = None if self.rail.roller else self.other or self
        return replace(self, position=replace(self.position, z=self.position.z + by), other=other)

    @property
    def clearance(self) -> float:
        """Height by which the wheel must go down to touch the rail, in m."""
        return float(self.gap.min())

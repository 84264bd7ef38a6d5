"""The shape of a body across the rolling direction where a lateral radius is not enough: points, or a logarithmic crown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Interpolation = Literal["cubic", "linear"]


@dataclass(frozen=True)
class Profile:
    """Height of a surface over the lateral coordinate, positive out of the body, in m; beyond its ends there is no material.

    Either `points` (y, height), y increasing, joined by a C² spline ("cubic") or by straight lines ("linear"); or, without
    points, a crown of `length` that is flat over `flat` in the middle and falls to both ends by

        drop · ln(1 − ((2|y| − flat)/(length − flat))²)

    (Lundberg's crown without a flat part). The shape is tilted by `tilt` (rad, a rise towards +y) about its own origin and then
    shifted by `offset` along y. How it is evaluated: `surface`.
    """

    points: tuple[tuple[float, float], ...] = ()
    interpolation: Interpolation = "cubic"
    length: float = 0.0
    drop: float = 0.0
    flat: float = 0.0
    offset: float = 0.0
    tilt: float = 0.0

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest y with material, in m."""
        half = 0.5 * self.length
        low, high = (self.points[0][0], self.points[-1][0]) if self.points else (-half, half)
        return low + self.offset, high + self.offset

"""The root of a function that rises, where each value costs a solution: the secant method inside a bracket."""

from __future__ import annotations

import math


class RisingRoot:
    """Where to look next for the root of a rising function, from the values at the places before.

    It begins at `place` with an assumed `slope`, or with the secant through a place and its value that are `known`; no step is
    longer than `longest`. Values may jump: then the bracket from `low` to `high` closes around the jump."""

    def __init__(
        self, place: float, slope: float, longest: float, low: float = -math.inf, high: float = math.inf,
        known: tuple[float, float] | None = None,
    ) -> None:
        self.place, self.slope, self._longest = place, slope, longest
        self._low, self._high = low, high
        self._last = known

    @property
    def width(self) -> float:
        """Width of the bracket."""
        return self._high - self._low

    def move(self, value: float) -> None:
        """Go on to the next place, from the `value` at the last one."""
        if value < 0.0:
            self._low = self.place
        else:
            self._high = self.place
        if self._last is not None and self._last[0] != self.place:
            slope = (value - self._last[1]) / (self.place - self._last[0])
            # Where it is flat the next step is twice as long.
            self.slope = slope if slope > 0.0 else 0.5 * self.slope
        self._last = self.place, value
        wanted = self.place + min(max(-value / self.slope, -self._longest), self._longest)
        if not self._low < wanted < self._high:
            wanted = (0.5 * (self._low + self._high) if math.isfinite(self.width)
                      else self.place - math.copysign(self._longest, value))
        self.place = wanted

"""The load of a contact whose approach is given."""

from __future__ import annotations

import math
from dataclasses import replace

from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.steady_state.derived import DerivedQuantities

HERTZ_EXPONENT = 1.5
"""d ln W/d ln δ below an elliptic contact (Johnson, Sec. 4.2c), the first guess below any other."""
COARSE = 1e-4
"""Relative accuracy of a load that is only a start: that of the coarse solutions behind it."""
MOST_LOADS = 30
"""Loads tried: the secant takes three to five."""


def with_coarse_load(problem: Problem) -> Problem:
    """`problem` with about the load that its given approach needs without heat and shear: exact for Hertz's contact, else from
    coarse solutions. Raises Unsolvable where there is no contact."""
    assert problem.approach is not None
    secant = LoadSecant(problem.approach)
    for _ in range(MOST_LOADS):
        approach = DerivedQuantities(problem).scales.approach
        if abs(approach / problem.approach - 1.0) < COARSE:
            break
        problem = replace(problem, normal_force=secant.next(problem.normal_force, approach))
    return problem


class LoadSecant:
    """The secant method for ln W(ln δ), which is nearly a straight line."""

    def __init__(self, wanted: float) -> None:
        self.exponent = HERTZ_EXPONENT
        self._wanted, self._last = wanted, (math.nan, math.nan)

    def next(self, load: float, approach: float) -> float:
        """The next load (N) to try, after `load` gave the `approach` (m)."""
        here = math.log(load), math.log(approach)
        change = here[1] - self._last[1]
        if abs(change) > 1e-9:  # false for the first load, whose predecessor is nan
            self.exponent = min(max((here[0] - self._last[0]) / change, 0.5), 3.0)
        self._last = here
        return load * (self._wanted / approach) ** self.exponent

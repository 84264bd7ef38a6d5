"""The thermal responses of one grid, kept until the bodies' speeds or cooling change."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.heat_response import HeatResponse, ThermalResponse
from thermoroll_cli.heat.recirculation import RecirculatingResponse, Roller, Track
from thermoroll_cli.heat.sliding_heat import SlidingHeatResponse, SlidingKernels
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.heated_bodies import crown_matters, heated_bodies, rollers


class HeatResponses:
    """Makes the responses of one grid; kernels are kept, and built again only when speeds change."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._last: HeatResponse | None = None
        self._tracks: dict[Roller, Track] = {}
        self._recirculating: RecirculatingResponse | None = None

    @cached_property
    def sliding(self) -> SlidingKernels:
        return SlidingKernels(self.grid)

    def response(self, derived: DerivedQuantities, creepage: tuple[float, float], slip: Array) -> ThermalResponse:
        """Thermal response of both bodies at the given creepages and `slip` s/V (2, nx, ny), which only matters where the
        Péclet number is made with it."""
        problem = derived.problem
        lower, upper = heated_bodies(problem, *creepage)
        if problem.heating.peclet == "sliding":
            return SlidingHeatResponse(self.sliding, lower, upper, problem.motion.speed * np.hypot(slip[0], slip[1]))
        if self._last is None or self._last.bodies != (lower, upper):
            self._last = HeatResponse(self.grid, lower, upper)
        if problem.heating.recirculates:
            return self._with_tracks(self._last, derived, creepage[0])
        return self._last

    def _with_tracks(self, passing: HeatResponse, derived: DerivedQuantities, creepage: float) -> RecirculatingResponse:
        """`passing`, and the heat that the tracks of turning bodies bring back."""
        both = rollers(derived.problem, creepage)
        self._tracks = {r: self._tracks.get(r) or Track(r, self.grid) for r in both if r is not None}
        lower, upper = (None if r is None else self._tracks[r] for r in both)
        found = RecirculatingResponse(passing, (lower, upper), bulging=crown_matters(derived))
        if self._recirculating is None or not self._recirculating.is_like(found):
            self._recirculating = found
        return self._recirculating

    @property
    def transforms(self) -> int:
        total = self.sliding.transforms if "sliding" in self.__dict__ else 0
        return total + (self._last.transforms if self._last is not None else 0)

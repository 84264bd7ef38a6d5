"""A state on one grid of a plan, and the domain that follows its heated contact.

Strong heat concentrates the contact to a fraction of Hertz's, and moves it to where the bodies are hot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.fixed_point import SteadyState
from thermoroll_cli.physics.numerics.grid import Domain
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.result import State
from thermoroll_cli.tools.arrays import Array

ROOM = 0.125
"""Room on each side of a contact in a domain that follows it, over what it measures along that axis."""
WAY = 0.25
"""Additional room on sides that the contact has touched: it moves towards them. Without: strong heat on coarse grids is not
balanced."""
WORTH = 0.5
"""A domain whose area is this much smaller, or less, is worth solving on again: as is one for half as many elements.
Without: scalars of small hot contacts change by up to 2.5 of their estimates."""
SMALLEST = 0.02
"""Side of a domain over Hertz's semi-axis, below which it does not follow: the iteration has lost its contact. Without: a hot
contact of 80 shrinks until the coordinates of its elements no longer differ, and the run does not end in minutes."""


@dataclass(frozen=True)
class Level:
    """A `state` on the grid of `here`, in its `reported` form, with the `transforms` and the `seconds` that it took."""

    here: Discretisation
    state: SteadyState
    reported: State
    transforms: int
    seconds: float

    @property
    def contact(self) -> Contact:
        return self.state.contact

    @property
    def touches_rim(self) -> bool:
        """Whether the contact was found to reach the edge of a domain that a larger one may replace."""
        return self.state.touches_rim and self.here.followed is None

    @property
    def elements_across(self) -> float:
        """Elements over 1.1 diameters of the contact, which is the side of the usual domain; of a grid that is not square those
        of its coarser direction."""
        shape, inside = self.here.grid.shape, float(self.contact.normal.covered.sum())
        if self.here.derived.problem.line:
            return max(1.0, 1.1 * inside)
        return max(1.0, 2.2 * math.sqrt(inside / math.pi * min(shape) / max(shape)))

    @property
    def stays_balanced(self) -> bool:
        """Whether the next grid begins with pressures in balance with their heat. A contact that slides as a whole needs that
        on coarse grids alone: mixing goes on from there for a tenth of the work."""
        sticking = self.contact.tangential.stick & self.contact.normal.contact
        return self.state.balanced and self.state.converged and bool(sticking.any())


def begun_on(usual: Discretisation, coarse: Level | None) -> Discretisation:
    """Where a grid begins from the `coarse` one: on its `usual` domain, or around a contact that has been followed."""
    if coarse is None or coarse.here.followed is None:
        return usual
    domain = _around(coarse.here, coarse.state) if coarse.state.converged else coarse.here.followed
    return usual if domain is None else _on_domain(usual, domain)


def better_domain(here: Discretisation, state: SteadyState, *, smaller: bool) -> Discretisation | None:
    """A domain fitted to a contact that leaves its own or, with `smaller`, fills too little of it; None if it stays."""
    domain = _around(here, state)
    # A smaller one must save enough elements, or make them small enough, to be solved on again.
    area = here.grid.element_area * here.grid.nx * here.grid.ny
    if domain is None or not (state.touches_rim or (smaller and domain.area <= WORTH * area)):
        return None
    return _on_domain(here, domain)


def returns(usual: Discretisation, here: Discretisation, state: SteadyState) -> bool:
    """Whether the contact of `state`, which has left the `usual` domain on its way, has come back there for good."""
    if here is usual or not state.converged or (domain := _around(here, state)) is None:
        return False
    grid, inside = here.grid, state.contact.normal.contact
    fits = all(low < places[there].min() and places[there].max() < high for places, there, (low, *_, high) in (
        (grid.x, inside.any(axis=1), usual.grid.x), (grid.y, inside.any(axis=0), usual.grid.y))[: len(grid.sides)])
    area = usual.grid.element_area * usual.grid.nx * usual.grid.ny
    return fits and domain.area > WORTH * area


def _on_domain(like: Discretisation, domain: Domain) -> Discretisation:
    """A discretisation of the same problem with as many elements over another `domain`."""
    scales = like.derived.scales
    sides = domain.side_x / scales.semi_axis_x, domain.side_y / scales.semi_axis_y
    extent = max(side for side in sides if math.isfinite(side))
    return Discretisation(like.derived, like.grid.shape, extent, like.threads, like.options, domain)


def _around(here: Discretisation, state: SteadyState) -> Domain | None:
    """The domain around the contact of `state`; None where it does not follow."""
    derived, grid, inside = here.derived, here.grid, state.contact.normal.contact
    if derived.hertz is None or not inside.any():
        # The pressure, with which that of the heated contact is compared, is known everywhere for Hertz's contact alone.
        return None
    low_x, high_x = _span(grid.x, grid.dx, np.flatnonzero(inside.any(axis=1)))
    if derived.problem.line:
        return Domain(high_x - low_x, math.inf, 0.0, 0.5 * (low_x + high_x)) if (
            high_x - low_x >= SMALLEST * derived.scales.semi_axis_x) else None
    low_y, high_y = _span(grid.y, grid.dy, np.flatnonzero(inside.any(axis=0)))
    if high_x - low_x < SMALLEST * derived.scales.semi_axis_x or high_y - low_y < SMALLEST * derived.scales.semi_axis_y:
        return None
    if derived.kinematics.mirror is not None and derived.kinematics.heat_mirrors:
        # But for rounding it is its own mirror image, and is solved as such.
        high_y = max(high_y, -low_y)
        low_y = -high_y
    return Domain(high_x - low_x, high_y - low_y, 0.5 * (low_y + high_y), 0.5 * (low_x + high_x))


def _span(centres: Array, size: float, places: NDArray[np.intp]) -> tuple[float, float]:
    """Lowest and highest coordinate (m) of a domain around the elements of `size` at `places` among those with the given
    `centres`."""
    low, high = float(centres[places[0]]) - 0.5 * size, float(centres[places[-1]]) + 0.5 * size
    length = high - low
    return (low - (ROOM + WAY * (places[0] == 0)) * length, high + (ROOM + WAY * (places[-1] == centres.size - 1)) * length)

"""The coupled state on a domain that follows its contact: strong heat concentrates it to a fraction of Hertz's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermoroll_cli.refinement.starts import Starts
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import SteadyState, fixed_point
from thermoroll_cli.steady_state.turn import Tolerances

FIT = 2.5
"""Side of a domain that follows, over the half-width of the contact: a quarter more than the contact takes."""
WORTH = 0.7
"""A domain this much smaller, or less, is worth solving on again: elements are then half as large in area."""
MOST_MOVES = 5
"""Domains tried on one grid."""


@dataclass(frozen=True)
class FollowedState:
    """A coupled state with the `discretisation` it lives on, and the transforms spent on domains that were left."""

    discretisation: Discretisation
    state: SteadyState
    left_behind: int


def followed_state(starts: Starts, home: Discretisation, isothermal: SteadyState, tolerances: Tolerances) -> FollowedState:
    """The coupled state on `home` or, where its contact takes too little of that domain, on smaller ones around it.

    The domain stays centred, as the problem is, and never gets larger than that of the isothermal state (`starts`).
    """
    before = None if starts.coarser is None else starts.coarser.coupled
    balanced = before is not None and before.balanced and before.converged
    state = fixed_point(home, starts.coupled(isothermal.contact, home), tolerances, balanced=balanced)
    left_behind, grown = 0, False
    for _ in range(MOST_MOVES):
        # Where a contact turns out larger than it seemed, all the room there is is given to it, for good.
        extent = starts.discretisation.extent if state.touches_rim else _fitting_extent(home, state)
        if extent == home.extent or (grown and not state.touches_rim):
            break
        grown = grown or state.touches_rim
        moved = Discretisation(home.derived, home.grid.shape, extent, home.threads, home.options)
        state = fixed_point(moved, starts.moved(moved, home, state.contact), tolerances,
                            balanced=state.balanced and state.converged)
        if home is not starts.discretisation:
            left_behind += home.transforms
        home = moved
    return FollowedState(home, state, left_behind)


def _fitting_extent(home: Discretisation, state: SteadyState) -> float:
    """Extent on which the contact of `state` is solved well; that of `home` where it is."""
    if home.derived.problem.geometry.has_profile:
        # Its isothermal pressure, with which fields are compared, is known on its own domain alone.
        return home.extent
    grid, scales, inside = home.grid, home.derived.scales, state.contact.normal.contact
    along = float(np.abs(grid.x[inside.any(axis=1)]).max()) / scales.semi_axis_x
    across = float(np.abs(grid.y[inside.any(axis=0)]).max()) / scales.semi_axis_y
    extent = FIT * max(along + home.extent / grid.nx, across + home.extent / grid.ny)
    return extent if extent < WORTH * home.extent else home.extent

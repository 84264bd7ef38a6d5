"""The coupled state on a domain that follows its contact: strong heat concentrates it to a fraction of Hertz's, and moves it to
where the bodies are hot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.grid import Domain
from thermoroll_cli.refinement.refinement_level import FollowedState
from thermoroll_cli.refinement.starts import Starts
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.fixed_point import SteadyState, fixed_point
from thermoroll_cli.steady_state.solver_options import Tolerances

ROOM = 0.125
"""Room on each side of a contact in a domain that follows it, over what it measures along that axis."""
WAY = 0.25
"""More of it on sides that the contact has touched: it is on its way there."""
WORTH = 0.5
"""A domain whose area is this much smaller, or less, is worth solving on again: as is one for half as many elements."""
SMALLEST = 0.02
"""Side of a domain over Hertz's semi-axis, below which it does not follow: the iteration has lost its contact, and soon the
coordinates of its elements would not differ."""


def followed_state(starts: Starts, home: Discretisation, isothermal: SteadyState, tolerances: Tolerances) -> FollowedState:
    """The coupled state on `home` or, where its contact leaves that domain or takes too little of it, on one around it."""
    before = None if starts.coarser is None else starts.coarser.coupled
    # A contact that slides as a whole needs balancing on coarse grids alone: mixing goes on from there for a tenth of the work.
    balanced = (before is not None and before.balanced and before.converged
                and bool((before.contact.tangential.stick & before.contact.normal.contact).any()))
    state = fixed_point(home, starts.coupled(isothermal.contact, home), tolerances, balanced=balanced)
    left_behind, smaller, settled = 0, False, False
    for _ in range(home.options.most_moves):
        # Where a contact turns out larger than it seemed, it keeps the room that it then gets.
        settled = settled or (smaller and state.touches_rim)
        domain = _around(home, state)
        if domain is None or not (state.touches_rim or (not settled and _is_worth(domain, home))):
            break
        smaller = not state.touches_rim
        moved = _on_domain(home, domain)
        state = fixed_point(moved, starts.moved(moved, home, state.contact), tolerances,
                            balanced=state.balanced and state.converged)
        if home is not starts.discretisation:
            left_behind += home.transforms
        home = moved
    return FollowedState(home, state, left_behind)


def next_home(starts: Starts) -> Discretisation:
    """Where the coupled state of a grid is begun: on its own domain, or around the contact that it is started from if that has
    been followed."""
    discretisation, source = starts.discretisation, starts.of_coupled
    if source is None or source.coupled is None or source.home is source.discretisation:
        return discretisation
    around = source.home.followed
    if source is starts.coarser and source.coupled.converged:
        around = _around(source.home, source.coupled)
    return discretisation if around is None else _on_domain(discretisation, around)


def _on_domain(like: Discretisation, domain: Domain) -> Discretisation:
    """A discretisation of the same problem with as many elements over another `domain`."""
    scales = like.derived.scales
    extent = max(domain.side_x / scales.semi_axis_x, domain.side_y / scales.semi_axis_y)
    return Discretisation(like.derived, like.grid.shape, extent, like.threads, like.options, domain)


def _is_worth(domain: Domain, home: Discretisation) -> bool:
    """Whether a smaller domain saves enough elements, or makes them small enough, to be solved on again."""
    return domain.side_x * domain.side_y <= WORTH * home.grid.element_area * home.grid.nx * home.grid.ny


def _around(home: Discretisation, state: SteadyState) -> Domain | None:
    """The domain around the contact of `state`; None where it does not follow."""
    derived, grid, inside = home.derived, home.grid, state.contact.normal.contact
    if derived.problem.geometry.has_profile or not inside.any():
        # The pressure of a profile, with which that of the heated contact is compared, is known on its own domain alone.
        return None
    low_x, high_x = _span(grid.x, grid.dx, np.flatnonzero(inside.any(axis=1)))
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

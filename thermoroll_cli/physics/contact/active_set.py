"""The active set of a contact: elements under tension leave it, elements that overlap join it, until none does.

On the set A p = δ − h is solved, under a given load ∬p = W or for a given approach δ. `settle` needs two functions of the
bodies: their displacement by a pressure on a contact, and the step that closes the gap on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from thermoroll_cli.tools.arrays import Array, Mask

SOLVED_SHARE = 0.5
"""The gap is closed to this share of the tolerance, so that the iteration ends when the set no longer changes."""
PATIENCE = 8
"""Active sets without fewer changes after which elements are only dropped: two may swap for ever on a symmetric border."""


class Approach(NamedTuple):
    """Given in place of a load: the bodies approach each other by `depth` (m), and the load follows."""

    depth: float


Given = float | Approach
"""The sum of all pressures (Pa), or the approach."""


def approach_of(given: Given, residual: float) -> float:
    """δ in m, where elastic displacement and gap together have the mean `residual` (m) on the active set."""
    return given.depth if isinstance(given, Approach) else residual


def carrying(given: Given, pressure: Array) -> Array:
    """`pressure` (Pa, not all zero) at a given load, or as it is."""
    return pressure if isinstance(given, Approach) else pressure * (given / float(pressure.sum()))


class Closed(NamedTuple):
    """The gap closed on one active set: `pressure` (Pa), its `displacement` (m), the `approach` (m), the rms `error` of the gap
    that remains over the mean elastic displacement `scale` (m), the `iterations` it took."""

    pressure: Array
    displacement: Array
    approach: float
    error: float
    scale: float
    iterations: int


Close = Callable[[Mask, Array, Array, float, float, int], Closed]
"""(contact, pressure, displacement, tolerance, reduction, most iterations) → the gap closed on this contact down to the
`tolerance` or by the factor `reduction`."""


@dataclass(frozen=True)
class NormalSolution:
    """The last `pressure` (Pa) with its active set `contact`, its `displacement` and the `gap` that it leaves (m), the
    `approach` (m) and the rms `error` of the gap on the contact over the elastic displacement; active `sets` tried, and
    iterations on all of them. `covered` is the part of each element in contact: all or nothing until the border is resolved
    inside elements. At an approach that does not close the gap there is no contact."""

    pressure: Array
    displacement: Array
    gap: Array
    approach: float
    error: float
    contact: Mask
    covered: Array
    sets: int
    iterations: int
    converged: bool


def settle(
    displacement_by: Callable[[Array, Mask], Array], close: Close, gap: Array, given: Given, start: Array, tolerance: float, *,
    reduction: float, most_sets: int, most_iterations: int, wandering: float = np.inf,
    hand_over: Callable[[Array, Mask, Mask], Array] | None = None,
) -> NormalSolution:
    """The pressure of surfaces `gap` apart (m, (nx, ny); up to a constant if a load is given), from the active set and the
    values of `start` (Pa).

    On the first sets the gap is closed by the factor `reduction` each. A set that would gain the share `wandering` of its
    elements while it also loses some, or that would lose all, ends the iteration. `hand_over`(pressure, dropped, contact) gives
    the pressure on the next set."""
    contact, pressure, displacement = _first(displacement_by, gap, given, start)
    approach, error, sets, iterations, stalled, fewest = approach_of(given, 0.0), 0.0, 0, 0, 0, contact.size
    converged = not contact.any()
    while not converged and sets < most_sets and iterations < most_iterations:
        sets += 1
        state = close(contact, pressure, displacement, SOLVED_SHARE * tolerance, reduction, most_iterations - iterations)
        pressure, displacement, approach, error = state.pressure, state.displacement, state.approach, state.error
        iterations += state.iterations
        opening = displacement + gap - approach
        drop, add = contact & (pressure < 0.0), ~contact & (opening < -tolerance * state.scale)
        dropped, added, size = (int(np.count_nonzero(mask)) for mask in (drop, add, contact))
        if not np.isfinite(error):
            break
        if dropped + added == 0:
            converged = error <= tolerance
            reduction = min(reduction, tolerance / max(error, 1e-300))
            continue
        if wandering < np.inf and dropped and (added > wandering * size or dropped == size):
            break
        stalled = stalled + 1 if dropped + added >= fewest else 0
        fewest = min(fewest, dropped + added)
        contact = contact & ~drop
        if stalled < PATIENCE or not dropped:
            contact |= add
        pressure = np.where(contact, pressure if hand_over is None else hand_over(pressure, drop, contact), 0.0)
        if pressure.any():
            pressure = carrying(given, pressure)
        elif not isinstance(given, Approach):
            # A thermal bulge has moved the contact away from the first guess: restart where the bodies are closest.
            contact |= opening == opening.min()
            pressure = carrying(given, contact.astype(float))
        elif not contact.any():
            contact = gap < given.depth
            converged = not contact.any()
        displacement = displacement_by(pressure, contact)
    left = np.where(contact, 0.0, displacement + gap - approach)
    return NormalSolution(
        pressure, displacement, left, float(approach), error, contact, contact.astype(float), sets, iterations, converged)


def _first(
    displacement_by: Callable[[Array, Mask], Array], gap: Array, given: Given, start: Array
) -> tuple[Mask, Array, Array]:
    """The first active set, its pressure and displacement. For an approach the pressure is scaled such that the gap vanishes in
    its mean over the pressure; where such a pressure would pull, the first set is the overlap of the undeformed bodies."""
    contact = start > 0.0
    if not contact.any():
        contact = gap < given.depth if isinstance(given, Approach) else gap == gap.min()
        start = contact.astype(float)
    pressure = np.where(contact, start, 0.0)
    if not isinstance(given, Approach):
        pressure = carrying(given, pressure)
        return contact, pressure, displacement_by(pressure, contact)
    if contact.any() and float(np.vdot(pressure, given.depth - gap)) <= 0.0:
        contact = gap < given.depth
        pressure = contact.astype(float)
    displacement = displacement_by(pressure, contact)
    work = float(np.vdot(pressure, displacement))
    factor = float(np.vdot(pressure, given.depth - gap)) / work if work > 0.0 else 1.0
    return contact, factor * pressure, factor * displacement

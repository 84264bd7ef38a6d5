"""Places at which the surfaces turn within an element: kinks, the last part of a crown, patches of a few elements; and those at
which friction changes within one.

A turn by the angle Δ inside a contact raises the pressure by E*Δ/(2π) times the logarithm of the distance to it (a blunt wedge;
Johnson, Contact Mechanics, 5.2), so at a kink it has no bound, and each doubling of the grid adds E*Δ ln 2/(2π). A crown turns
by as much within an element if its last part is narrower; its pressure is bounded, but by a peak that this grid does not show.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.numerics.grid import patches_across
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import ContactGeometry
from thermoroll_cli.problem.names import of_kind
from thermoroll_cli.steady_state.discretisation import Discretisation

PEAKS = of_kind("peak", "peak flux", "peak pressure", "relative peak pressure")
"""Scalars that such places decide."""
RUBBED, STEP = of_kind("peak", "peak flux"), 0.1
"""Scalars that a step of friction decides, and its size over the largest friction of the contact from which it does: tractions
next to it depend on where in its element it lies, and those of a narrow stripe are averaged over the element."""
GROWTH = 0.01
"""Growth of the largest pressure per doubling of the grid, relative, from which a kink counts as unbounded; below it the
difference of the grids contains it. With 0 every point of a profile that is joined by straight lines would count."""
BORDER = 2
"""Columns beside the border whose pressure depends on where in its element the border lies."""
SLOPE_STEP = 0.1
"""Half of the distance over the size of an element at which a gap without slopes is differentiated."""
NARROWEST = 2 * BORDER + 1
"""Columns or rows of a patch below which its largest pressure is that of its border elements."""


@dataclass(frozen=True)
class SharpPlaces:
    """Names of scalars without a limit (`unbounded`) or with a peak that the grid does not resolve (`unresolved`), and the
    warnings that say where."""

    unbounded: tuple[str, ...] = ()
    unresolved: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def sharp_places(discretisation: Discretisation, contact: Contact) -> SharpPlaces:
    """The sharp places in the `contact` of a grid. A free end that is loaded is unbounded as well (`ContactScales.ends`)."""
    derived, grid, normal = discretisation.derived, discretisation.grid, contact.normal
    geometry, ends = derived.problem.geometry, derived.scales.reaches_an_end
    line = normal.pressure.max(axis=0)
    steps = tuple(_steps(derived.problem.friction, discretisation, line))
    rubbed = RUBBED if steps else ()
    if geometry.elliptic:
        return SharpPlaces((), rubbed, steps)
    unit = derived.problem.contact_modulus * math.log(2.0) / (2.0 * math.pi * normal.peak)
    kinks = list[str]()
    for body, profile in geometry.profiles:
        columns = ((round((y - grid.y[0]) / grid.dy), y, turn) for y, turn in profile.kinks if turn * unit > GROWTH)
        inside = [(turn, y) for column, y, turn in columns if 0 <= column < grid.ny and line[column] > 0.0]
        if inside:
            turn, worst = max(inside, key=lambda place: place[0])
            more = f" ({len(inside)} such kinks)" if len(inside) > 1 else ""
            kinks.append(f"the surface of the {body} body has a kink of {1e3 * turn:.3g} mrad at y = {1e3 * worst:.4g} mm in "
                         f"the contact{more}: the pressure there has no upper bound and grows by {100 * turn * unit:.2g} % "
                         'with every doubling of the grid; round it, or join the points by interpolation = "cubic"')
    peaks = tuple(_narrow(geometry, discretisation, normal.pressure, normal.covered.max(axis=0), unit))
    return SharpPlaces(PEAKS if kinks or ends else (), (*(PEAKS if peaks else ()), *rubbed), (*kinks, *peaks, *steps))


def _steps(friction: Friction, discretisation: Discretisation, line: Array) -> Iterator[str]:
    if not friction.across or not line.any():
        return
    y = discretisation.grid.y[line > 0.0]
    places, shares = np.array(friction.across).T
    changed = np.append(0.0, np.cumsum(np.abs(np.diff(shares))))
    ends = y[:, None] + 0.5 * discretisation.grid.dy * np.array([-1.0, 1.0])
    changes = np.diff(np.interp(ends, places, changed))[:, 0]
    inside = shares[(places > ends[0, 0]) & (places < ends[-1, 1])]
    largest = float(np.append(np.interp(ends, places, shares), inside).max())
    worst = int(changes.argmax())
    if changes[worst] > STEP * largest:
        yield (f"friction changes by {100.0 * changes[worst] / largest:.0f} % of its largest value within an element, at y = "
               f"{1e3 * y[worst]:.4g} mm: the largest shear traction and heat flux have no error estimate; set a larger "
               "numerics.grid, or let it change over the width of several elements")


def _narrow(
    geometry: ContactGeometry, discretisation: Discretisation, pressure: Array, covered: Array, unit: float
) -> Iterator[str]:
    """Ends of patches that could carry more than the largest pressure found, and patches of a few elements."""
    grid, free = discretisation.grid, discretisation.derived.scales.ends
    line = pressure.max(axis=0)
    peak = float(line.max())
    few: list[tuple[int, str, int, float]] = []
    parted: list[tuple[float, float]] = []
    for columns in patches_across(pressure):
        rows = int(np.count_nonzero(pressure[:, columns].max(axis=1) > 0.0))
        if min(len(columns), rows) < NARROWEST:
            if float(line[columns].max()) > 0.5 * peak:
                y = 1e3 * float(grid.y[columns].mean())
                few.append((*min((len(columns), "wide", grid.ny), (rows, "long", grid.nx)), y))
            continue
        kept = columns[BORDER:-BORDER]
        # A peak at an end lies within an eighth of the patch, and within elements that do not show it.
        reach = min(max(BORDER, len(columns) // 8), 2 * BORDER)
        for side, last in ((-1.0, int(columns[0])), (1.0, int(columns[-1]))):
            if free[0 if side < 0.0 else 1]:
                continue
            near = kept[:reach + 1] if side < 0.0 else kept[-reach - 1:]
            top = int(near[np.argmax(line[near])])
            inner = float(line[top])
            border = grid.y[last] + side * (float(covered[last]) - 0.5) * grid.dy
            rise = _turn(geometry, border, grid.dy, side) * unit * peak
            # A pressure whose maximum lies away from the end has no peak there.
            if abs(last - top) > reach or rise <= GROWTH * peak or inner + rise <= peak:
                continue
            parted.append((rise, 1e3 * border))
    # The rough lobes of a measured profile are many: the worst one of a kind is named.
    if few:
        count, way, of, y = min(few)
        yield (f"the patch at y = {y:.4g} mm is {count} elements {way}, too few for its largest pressure{_more(few)}: set "
               f"numerics.grid = {2 * NARROWEST * of // count} or more")
    if parted:
        yield (f"the surfaces part within an element at y = {max(parted)[1]:.4g} mm{_more(parted)}: the pressure there may "
               f"exceed the largest one of this grid, which has no error estimate; try numerics.grid = {2 * grid.ny}")


def _more(places: Sequence[Any]) -> str:
    return f" ({len(places)} such places)" if len(places) > 1 else ""


def _turn(geometry: ContactGeometry, border: float, size: float, side: float) -> float:
    """Angle by which both surfaces turn away from each other over the last `size` (m) of a contact that ends at `border`."""
    low, high = geometry.limits
    places = np.clip(np.array([border - side * size, border]), low, high)
    slopes = sum((slope(places) for slope in geometry.slopes), np.zeros(2))
    if not geometry.slopes:
        ends = np.clip(places[:, None] + SLOPE_STEP * size * np.array([-1.0, 1.0]), low, high)
        slopes = -np.diff(geometry.across(ends.ravel()).reshape(ends.shape))[:, 0] / np.diff(ends)[:, 0]
    return float(max(-side * (slopes[1] - slopes[0]), 0.0))

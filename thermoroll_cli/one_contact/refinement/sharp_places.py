"""Places at which the surfaces turn within an element: kinks, the last part of a crown, patches of a few elements; and those at
which friction changes within one.

A turn by the angle Δ inside a contact raises the pressure by E*Δ/(2π) times the logarithm of the distance to it (a blunt wedge;
Johnson, Contact Mechanics, 5.2), so at a kink it has no bound, and each doubling of the grid adds E*Δ ln 2/(2π). A crown turns
by as much within an element if its last part is narrower; its pressure is bounded, but by a peak that this grid does not show.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.physics.numerics.grid import patches_across
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import ContactGeometry
from thermoroll_cli.problem.names import of_kind
from thermoroll_cli.tools.arrays import Array, Mask

PEAKS = of_kind("peak", "peak flux", "peak pressure", "relative peak pressure")
"""Scalars that such places decide."""
RUBBED, STEP = of_kind("peak", "peak flux"), 0.1
"""Scalars that a step of friction decides, and its size over the largest friction of the contact from which it does: tractions
next to it depend on where in its element it lies, and those of a narrow stripe are averaged over the element."""
PRESSED = of_kind("peak pressure", "relative peak pressure")
WARMED = tuple(name for name in of_kind("diffused") if "_max_" in name)
"""Scalars that a step decides, too: these if bodies are unlike enough, those if no element has the largest friction."""
TURNED = 1e-3
"""The same as `GROWTH` for a step of friction, of which the grids do not show how the pressure grows."""
GROWTH = 0.01
"""Growth of the largest pressure per doubling of the grid, relative, from which a kink counts as unbounded; below it the
difference of the grids contains it. With 0 every point of a profile that is joined by straight lines would count."""
BORDER = 2
"""Columns beside the border whose pressure depends on where in its element the border lies."""
SLOPE_STEP = 0.1
"""Half of the distance over the size of an element at which a gap without slopes is differentiated."""
NARROWEST = 2 * BORDER + 1
"""Columns or rows of a patch below which its largest pressure is that of its border elements."""
DECIDES = 0.5
"""Largest pressure of a patch over that of the contact from which its size decides what the whole contact does."""


def sharp_places(
    discretisation: Discretisation, contact: Contact
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """The sharp places in the `contact` of a grid: names of scalars without a limit, of those with a peak that the grid does
    not resolve, and warnings that say where. A free end that is loaded is unbounded as well (`ContactScales.ends`)."""
    derived, grid, normal = discretisation.derived, discretisation.grid, contact.normal
    geometry, ends = derived.problem.geometry, derived.scales.reaches_an_end
    line = normal.pressure.max(axis=0)
    rubbed, steps = _steps(discretisation, contact, line)
    if geometry.elliptic:
        return (), rubbed, steps
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
    return PEAKS if kinks or ends else (), (*(PEAKS if peaks else ()), *rubbed), (*kinks, *peaks, *steps)


def _changes(friction: Friction, discretisation: Discretisation, loaded: Mask) -> tuple[Array, float]:
    """By how much friction changes within each of the `loaded` columns, on its way up and down, over its largest value in
    them, and that value over the coefficient."""
    y, dy = discretisation.grid.y[loaded], discretisation.grid.dy
    places, shares = np.array(friction.across).T
    changed = np.append(0.0, np.cumsum(np.abs(np.diff(shares))))
    ends = y[:, None] + 0.5 * dy * np.array([-1.0, 1.0])
    largest = float(np.interp(_nodes(places, y, dy), places, shares).max())
    return np.diff(np.interp(ends, places, changed))[:, 0] / (largest or 1.0), largest


def _nodes(places: Array, y: Array, dy: float) -> Array:
    """Ends of the columns at `y` (m) and those of `places` between them."""
    ends = np.append(y - 0.5 * dy, y[-1] + 0.5 * dy)
    return np.append(ends, places[(places > ends[0]) & (places < ends[-1])])


def _steps(discretisation: Discretisation, contact: Contact, line: Array) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Scalars that friction decides within single elements, and the warning that says where; nothing where it changes over
    several. Where no element has the largest μp, none has the largest temperature. Tractions across that jump by Δ turn the
    surfaces of unlike bodies by 2βΔ/E*, as a kink does; heat that jumps makes them expand in a step as wide as heat is deep."""
    derived, loaded = discretisation.derived, np.asarray(line > 0.0)
    friction, expansion = derived.problem.friction, contact.expansion
    if not friction.across or not loaded.any():
        return (), ()
    (changes, most), y = _changes(friction, discretisation, loaded), discretisation.grid.y[loaded]
    if changes.max() <= STEP:
        return (), ()
    places, shares = np.array(friction.across).T
    nodes = _nodes(places, y, discretisation.grid.dy)
    largest = float((np.interp(nodes, y, line[loaded]) * np.interp(nodes, places, shares)).max())
    hidden = float((line[loaded] * friction.mean_share(y, discretisation.grid.dy)).max()) < (1.0 - STEP) * largest
    turn = abs(derived.dundurs_beta) * friction.coefficient * most * changes.max() * math.log(2.0) / math.pi
    bulge = 0.0 if expansion is None else float(np.ptp(expansion[contact.normal.contact]))
    pressed = turn > TURNED or bulge > GROWTH * derived.scales.approach
    names = (*RUBBED, *(PRESSED if pressed else ()), *(WARMED if hidden else ()))
    what = ["the largest shear traction and heat flux", *(["the largest pressure"] if pressed else []),
            *(["the largest temperatures and worn depths"] if hidden else [])]
    return names, (f"friction changes by {100.0 * changes.max():.0f} % of its largest value within an element, at y = "
                   f"{1e3 * y[changes.argmax()]:.4g} mm: {', '.join(what)} have no error estimate; set a larger "
                   "numerics.grid, or let it change over the width of several elements",)


def uneven_friction(discretisation: Discretisation, contact: Contact) -> tuple[float, float]:
    """Errors by friction that changes within an element, which has its mean: of forces over μW, and of the area that sticks
    over that of the contact.

    Where all slides the mean is right. Tractions that differ from it by δμ p, over the width of an element, change the slip as
    far as this around them. They move the end of stick about as far, and there the tractions are in error: by the mean of δμ
    above it, half of its mean amount, times the pressure there and the square of the width. Elements that stick with more than
    the least friction in them carries are in error by up to as much, in proportion. All are by a pressure that is not even in
    them: (η² − 1/12)/2 of its second difference at the distance η from the middle over the width."""
    friction, grid, normal = discretisation.derived.problem.friction, discretisation.grid, contact.normal
    loaded = np.asarray(normal.contact.any(axis=0))
    if not friction.across or not loaded.any():
        return 0.0, 0.0
    mean = friction.mean_share(grid.y, grid.dy)
    off = 0.5 * friction.mean_of(lambda share, strip, offset: np.abs(share - mean[strip]), grid.y, grid.dy)
    off[loaded] *= _changes(friction, discretisation, loaded)[0] > STEP
    if not off.any():
        return 0.0, 0.0
    # Where stick ends along a line of rolling, there or beside it.
    stick, pressure = contact.tangential.stick & normal.contact, normal.pressure
    ends = (stick[1:] ^ stick[:-1]) & normal.contact[1:] & normal.contact[:-1]
    there = np.pad((ends, ends * np.minimum(pressure[1:], pressure[:-1])), ((0, 0), (0, 0), (1, 1))).sum(axis=1)
    count, at_ends = np.maximum.reduce([there[:, :-2], there[:, 1:-1], there[:, 2:]])
    carried = np.hypot(*contact.tangential.traction) / friction.coefficient * stick
    least = np.minimum(friction.share(grid.y - 0.5 * grid.dy), friction.share(grid.y + 0.5 * grid.dy))
    above = np.maximum(carried - least * pressure * stick, 0.0).sum(axis=0)
    bent = np.abs(np.diff(pressure.sum(axis=0), 2, prepend=0.0, append=0.0)) / 6.0
    part = off / np.maximum(mean - least, np.maximum(off, 1e-300))
    lost = (off * (at_ends * grid.dy + bent * grid.dx) + part * above * grid.dx) * grid.dy
    moved = off / np.maximum(mean, 1e-300) * count * grid.dy**2
    return (float(lost.sum() / (pressure.sum() * grid.element_area)),
            float(moved.sum() / (normal.covered.sum() * grid.element_area)))


def unseen_stick(discretisation: Discretisation, contact: Contact, sticking: float) -> float:
    """Share of the contact that may stick beyond the share `sticking` that is seen: where that is 0, elements in which the slip
    would vanish if it fell, towards one side, as it does between them and a neighbour, each by the part that is missing.

    An interlayer sticks along the leading edge as well, a compliant one alone over a share 1/(1 + κ²) of it, with κ the slip
    times the length of the contact over the displacement by which the interlayer shears."""
    derived, inside = discretisation.derived, contact.normal.covered > 0.0
    if not derived.kinematics.has_traction or not inside.any():
        return 0.0
    slip, size, patch = contact.tangential.slip, np.hypot(*contact.tangential.slip), 0.0
    if not sticking:
        change = np.zeros(inside.shape)
        for axis in (0, 1):
            one, other = (tuple(part if i == axis else slice(None) for i in (0, 1)) for part in (slice(1, None), slice(-1)))
            step = np.hypot(*(slip[:, *one] - slip[:, *other])) * (inside[one] & inside[other])
            for side in (one, other):
                change[side] = np.maximum(change[side], step)
        falls = inside & (size < change)
        patch = float((1.0 - size[falls] / change[falls]).sum() / inside.sum())
    full = derived.interlayer_shear / derived.scales.semi_axis_x
    strip = float(np.mean(full**2 / (full**2 + size[inside] ** 2))) if full else 0.0
    # No more than a line of elements across rolling.
    return max(0.0, min(max(patch, strip), 1.0 / float(inside.sum(axis=0).max())) - sticking)


def has_thin_patch(discretisation: Discretisation, pressure: Array) -> bool:
    """Whether a patch of fewer than `NARROWEST` columns or rows decides. Its elements are about as wide as it is: how far it
    gives way to its load, and so its share of all, depends on them."""
    return not discretisation.derived.problem.geometry.elliptic and any(
        min(len(columns), rows) < NARROWEST and pressure[:, columns].max() > DECIDES * pressure.max()
        for columns, rows in _sizes(pressure))


class Between(NamedTuple):
    """Errors by what the surfaces do between the columns of elements: of the largest pressure and of that in the centre, over
    them, and of the area of the contact."""

    peak: float = 0.0
    centre: float = 0.0
    area: float = 0.0


def between_columns(discretisation: Discretisation, contact: Contact) -> Between:
    """What the gap does not say that is taken in the middle of columns.

    Between two of them it departs by h from the cubic through four. Waves of that amplitude and of two columns' length, the
    shortest that elements carry, press with E* π h/(2 dy) (Johnson, Contact Mechanics, 13.2): so much may be missing in both
    columns, also where another one has the largest pressure. Elements that carry less may touch in half of them alone."""
    derived, grid, pressure = discretisation.derived, discretisation.grid, contact.normal.pressure
    geometry, line, loaded = derived.problem.geometry, pressure.max(axis=0), pressure > 0.0
    if geometry.elliptic or not loaded.any():
        return Between()
    gap = geometry.across(np.linspace(grid.y[0] - grid.dy, grid.y[-1] + grid.dy, 2 * grid.ny + 3))
    at, halfway = gap[::2], gap[3:-3:2]
    with np.errstate(invalid="ignore"):  # beyond the ends of profiles there is no gap
        departure = np.abs(halfway - (9.0 * (at[1:-2] + at[2:-1]) - at[:-3] - at[3:]) / 16.0)
    departure = np.where(np.isfinite(departure), departure, 0.0)
    missing = derived.problem.contact_modulus * math.pi / (2.0 * grid.dy) * np.maximum(
        np.append(departure, 0.0), np.append(0.0, departure))
    near = contact.normal.covered.sum(axis=0)
    j = int(np.abs(grid.y - float(near @ grid.y) / float(near.sum())).argmin())
    return Between(float((line + missing)[line > 0.0].max() / line.max() - 1.0),
                   float(missing[j] / line[j]) if line[j] > 0.0 else 0.0,
                   0.5 * float((pressure < missing)[loaded].mean()))


def _sizes(pressure: Array) -> Iterator[tuple[NDArray[np.intp], int]]:
    """Columns of each patch, and the number of rows in which it is loaded."""
    for columns in patches_across(pressure):
        yield columns, int(np.count_nonzero(pressure[:, columns].max(axis=1) > 0.0))


def _narrow(
    geometry: ContactGeometry, discretisation: Discretisation, pressure: Array, covered: Array, unit: float
) -> Iterator[str]:
    """Ends of patches that could carry more than the largest pressure found, and patches of a few elements."""
    grid, free = discretisation.grid, discretisation.derived.scales.ends
    line = pressure.max(axis=0)
    peak = float(line.max())
    few: list[tuple[int, str, int, float]] = []
    parted: list[tuple[float, float]] = []
    for columns, rows in _sizes(pressure):
        if min(len(columns), rows) < NARROWEST:
            if float(line[columns].max()) > DECIDES * peak:
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
            ends = columns[:BORDER] if side < 0.0 else columns[-BORDER:]
            # A pressure whose maximum lies away from the end has no peak there, unless that of the end is the largest.
            hidden = abs(last - top) <= reach and rise > GROWTH * peak and inner + rise > peak
            if hidden or float(line[ends].max()) == peak:
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

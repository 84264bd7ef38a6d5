"""Border lines of contact and stick, placed between the element centres where the fields put them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.plots.view import StateView

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Lines = list[Array]
"""Polylines, each of shape (points, 2) in m."""

SMOOTHINGS = 3
"""Passes of a three-point average along borders; they move a smooth curve by a few percent of an element."""

TAIL = 6
"""Points at the end of a line that decide where it goes on."""

REACH = 3.0
"""How many elements it goes on."""

RINGS = 3
"""Elements over which fields are continued: the border is at most this far from an element that it does not cut."""


@dataclass(frozen=True)
class Borders:
    """Border of the contact (closed lines) and between stick and slip (to be clipped by the contact)."""

    contact: Lines
    stick: Lines


def borders_of(x: Array, y: Array, state: StateView) -> Borders:
    """Border lines of one state on the grid `x`, `y`.

    Pressure falls like the square root of the distance to the contact's border, and slip like that of the distance to
    the stick border; their squares are linear, so extrapolating them to zero finds the border inside an element.
    """
    pressure = state.field("pressure")
    if pressure is None or not np.any(pressure > 0.0):
        return Borders([], [])
    contact = pressure > 0.0
    # Elements that the border cuts hold averages over their covered part, and slip where they ought to stick.
    trusted = contact & _surrounded(contact)
    if not np.any(trusted):
        trusted = contact
    element = float(np.hypot(x[1] - x[0], y[1] - y[0]))
    # Hertz's p² is a paraboloid; slip has no such form, and parabolas would make more of its noise.
    heights = _continued(pressure**2, trusted, contact, curved=True)
    lines = [_smoothed(line) for line in _zero_lines(x, y, heights)]
    slip = state.magnitude("slip")
    labels = state.field("state")
    if slip is None or labels is None or not np.any(labels == 1) or not np.any(labels == 2):
        return Borders(lines, [])
    slipping = (labels == 2) & trusted
    heights = np.ma.masked_array(_continued(slip**2, slipping, slipping, curved=False), mask=~np.pad(trusted, RINGS))
    return Borders(lines, [_to_the_border(_smoothed(line), element) for line in _zero_lines(x, y, heights)])


def _surrounded(mask: Mask) -> Mask:
    """Elements whose eight neighbours are all in `mask`."""
    for axis in (0, 1):
        mask = mask & _shifted(mask, 1, axis) & _shifted(mask, -1, axis)
    return mask


def _continued(strength: Array, trusted: Mask, inside: Mask, *, curved: bool) -> Array:
    """`strength` (positive on the `trusted` elements, falling to its border) continued over the next elements, through
    zero: by parabolas if `curved`, otherwise by straight lines. Elements further off count as what `inside` says. The
    field gets RINGS elements around."""
    values, known, inside = np.pad(strength, RINGS), np.pad(trusted, RINGS), np.pad(inside, RINGS)
    top = max(float(strength.max()), 1e-300)
    far = np.where(inside, np.maximum(values, 1e-12 * top), -top)
    values = np.where(known, values, 0.0)
    for _ in range(RINGS):
        total, count = np.zeros_like(values), np.zeros(values.shape)
        for axis in (0, 1):
            for step in (1, -1):
                use = ~known & _shifted(known, step, axis) & _shifted(known, 2 * step, axis)
                one, two, three = (_shifted(values, number * step, axis) for number in (1, 2, 3))
                bend = np.where(_shifted(known, 3 * step, axis), one - 2 * two + three, 0.0) if curved else 0.0
                total += np.where(use, 2 * one - two + bend, 0.0)
                count += use
        values = np.where(count > 0, total / np.maximum(count, 1.0), values)
        known = known | (count > 0)
    return np.where(known, values, far)


def _smoothed(line: Array) -> Array:
    """`line` without the wobble of single elements."""
    closed = bool(np.array_equal(line[0], line[-1]))
    for _ in range(SMOOTHINGS):
        middle = line.copy()
        middle[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
        if closed:
            middle[0] = middle[-1] = 0.25 * line[-2] + 0.5 * line[0] + 0.25 * line[1]
        line = middle
    return line


def _to_the_border(line: Array, element: float) -> Array:
    """An open stick border continued at its ends, far enough to reach the contact's border, where it is cut off: slip
    is not known well in the last elements before that."""
    if np.array_equal(line[0], line[-1]) or len(line) < 4 * TAIL:
        return line
    line = line[TAIL // 2 : -(TAIL // 2)]
    ends = []
    for end, inner in ((line[0], line[TAIL]), (line[-1], line[-TAIL - 1])):
        direction = end - inner
        ends.append(end + direction * (REACH * element / max(float(np.hypot(*direction)), 1e-300)))
    return np.vstack([ends[0], line, ends[1]])


def _shifted(values: NDArray, step: int, axis: int) -> NDArray:
    """`values` of the element `step` further along `axis`; zero beyond the rim."""
    result = np.zeros_like(values)
    length = values.shape[axis]
    if abs(step) >= length:
        return result
    source, target = [slice(None)] * 2, [slice(None)] * 2
    source[axis] = slice(max(step, 0), length + min(step, 0))
    target[axis] = slice(max(-step, 0), length + min(-step, 0))
    result[tuple(target)] = values[tuple(source)]
    return result


def _zero_lines(x: Array, y: Array, padded: Array) -> Lines:
    from contourpy import contour_generator

    generator = contour_generator(_ringed(x), _ringed(y), padded.T, name="serial")
    lines: Lines = [np.asarray(line) for line in generator.lines(0.0)]
    return lines


def _ringed(axis: Array) -> Array:
    """Element centres with RINGS more on each side."""
    step = axis[1] - axis[0]
    beyond = step * np.arange(1, RINGS + 1)
    return np.concatenate([axis[0] - beyond[::-1], axis, axis[-1] + beyond])

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
"""Passes of a three-point average along stick borders; they move a smooth curve by a few percent of an element."""

TAIL = 6
"""Points at the end of a line that decide where it goes on."""


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
    lines = _zero_lines(x, y, _continued(pressure**2, contact))
    slip = state.magnitude("slip")
    labels = state.field("state")
    if slip is None or labels is None or not np.any(labels == 1) or not np.any(labels == 2):
        return Borders(lines, [])
    heights = np.ma.masked_array(_continued(slip**2, labels == 2), mask=~np.pad(contact, 1))
    step = float(np.hypot(x[1] - x[0], y[1] - y[0]))
    return Borders(lines, [_tidied(line, step) for line in _zero_lines(x, y, heights)])


def _continued(strength: Array, inside: Mask) -> Array:
    """`strength` (positive inside, falling linearly to its border) continued linearly to negative values outside,
    with one more ring of elements around. The zero lines are the border."""
    strength, inside = np.pad(strength, 1), np.pad(inside, 1)
    top = strength.max()
    result = np.where(inside, np.maximum(strength, 1e-12 * top), -top)
    total, count = np.zeros_like(strength), np.zeros_like(strength)
    for axis in (0, 1):
        for step in (1, -1):
            near, far = _shifted(strength, step, axis), _shifted(strength, 2 * step, axis)
            near_inside, far_inside = _shifted(inside, step, axis), _shifted(inside, 2 * step, axis)
            guess = np.where(far_inside, 2 * near - far, -near)
            # An element outside must stay outside, however the field is curved.
            use = ~inside & near_inside
            total += np.where(use, np.minimum(guess, -0.02 * near), 0.0)
            count += use
    return np.where(count > 0, np.divide(total, count, where=count > 0, out=np.zeros_like(total)), result)


def _tidied(line: Array, element: float) -> Array:
    """A stick border without the wobble of single elements. Where an open one comes near the contact's border, slip is
    known in one or two elements only: there it is replaced by its own continuation, long enough to reach the border.
    """
    closed = np.array_equal(line[0], line[-1])
    for _ in range(SMOOTHINGS):
        middle = line.copy()
        middle[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
        if closed:
            middle[0] = middle[-1] = 0.25 * line[-2] + 0.5 * line[0] + 0.25 * line[1]
        line = middle
    if closed or len(line) < 4 * TAIL:
        return line
    line = line[TAIL // 2 : -(TAIL // 2)]
    ends = []
    for end, inner in ((line[0], line[TAIL]), (line[-1], line[-TAIL - 1])):
        direction = end - inner
        ends.append(end + direction * (3.0 * element / max(float(np.hypot(*direction)), 1e-300)))
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
    """Element centres with one more on each side."""
    step = axis[1] - axis[0] if axis.size > 1 else 1.0
    return np.concatenate([[axis[0] - step], axis, [axis[-1] + step]])

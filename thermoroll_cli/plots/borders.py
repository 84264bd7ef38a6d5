"""Border lines of contact and stick, placed between the element centres where the fields put them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from contourpy import contour_generator
from numpy.typing import NDArray

from thermoroll_cli.plots.view import StateView

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Lines = list[Array]
"""Polylines, each of shape (points, 2) in m."""

SMOOTHINGS = 3
"""Passes of a three-point average along borders; they move a smooth curve by a few percent of an element."""

CUT, TAIL, REACH = 4, 6, 4.0
"""Ends of open stick borders: points taken off, points that decide where the line goes on, elements it goes on."""

SHORTEST = 5.0
"""An open stick border of fewer elements is a scrap of a slip zone too narrow to be placed."""

NOTHING = 1e-9
"""Share of the largest pressure below which an element carries nothing: rounding is no contact."""

RINGS = 2
"""Elements over which fields are continued: no border is further from the elements that it leaves whole."""

WINDOW, FEWEST = 4, 6
"""Elements up to this far away are fitted, and fewer are not fitted at all."""


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
    contact = pressure > NOTHING * float(pressure.max())
    # Elements that the border cuts hold averages over their covered part, and slip where they ought to stick.
    trusted = contact & _surrounded(contact)
    if not np.any(trusted):
        trusted = contact
    element = np.array([x[1] - x[0], y[1] - y[0]])
    # Hertz's p² is a paraboloid; slip has no such form, and curvature would only make more of its noise.
    heights = _continued(pressure**2, trusted, contact, stiffness=1e-3)
    lines = [_smoothed(line) for line in _zero_lines(x, y, heights)]
    slip = state.magnitude("slip")
    labels = state.field("state")
    if slip is None or labels is None or not np.any(labels == 1) or not np.any(labels == 2):
        return Borders(lines, [])
    slipping = (labels == 2) & trusted
    heights = np.ma.masked_array(_continued(slip**2, slipping, slipping, stiffness=1.0), mask=~np.pad(trusted, RINGS))
    stick = [_smoothed(line) for line in _zero_lines(x, y, heights)]
    stick = [line for line in stick if _is_closed(line) or _length(line, element) > SHORTEST]
    return Borders(lines, [_to_the_border(line, element) for line in stick])


def _surrounded(mask: Mask) -> Mask:
    """Elements whose eight neighbours are all in `mask`."""
    for axis in (0, 1):
        mask = mask & _shifted(mask, 1, axis) & _shifted(mask, -1, axis)
    return mask


def _continued(strength: Array, trusted: Mask, inside: Mask, stiffness: float) -> Array:
    """`strength` (positive on the `trusted` elements, falling to their border) continued through zero.

    To each element near the trusted ones a paraboloid is fitted to those around it, nearer ones counting more;
    `stiffness` holds its curvature down. Elements further off count as what `inside` says, and what is not inside
    stays below zero. The field gets RINGS elements around.
    """
    values, known, inside = np.pad(strength, RINGS), np.pad(trusted, RINGS), np.pad(inside, RINGS)
    top = max(float(strength.max()), 1e-300)
    result = np.where(known, values, np.where(inside, 1e-12 * top, -top))
    near = known
    for _ in range(RINGS):
        near = ~_surrounded(~near)
    rows, columns = np.nonzero(near & ~known)
    steps = np.arange(-WINDOW, WINDOW + 1)
    u, v = (offsets.ravel() for offsets in np.meshgrid(steps, steps, indexing="ij"))
    weights_of_offset = 1.0 / np.maximum(u**2 + v**2, 1) ** 2
    i, j = rows[:, None] + u, columns[:, None] + v
    valid = (i >= 0) & (i < values.shape[0]) & (j >= 0) & (j < values.shape[1])
    i, j = np.clip(i, 0, values.shape[0] - 1), np.clip(j, 0, values.shape[1] - 1)
    weights = np.where(valid & known[i, j], weights_of_offset, 0.0)
    enough = np.count_nonzero(weights, axis=1) >= FEWEST
    rows, columns, weights = rows[enough], columns[enough], weights[enough]
    s, t = u / WINDOW, v / WINDOW
    basis = np.stack([np.ones(s.size), s, t, s * s, s * t, t * t], axis=1)
    # One matrix product for all the little least-squares problems.
    products = (basis[:, :, None] * basis[:, None, :]).reshape(s.size, -1)
    normal = (weights @ products).reshape(-1, 6, 6)
    stiff = weights.sum(axis=1)[:, None, None] * np.diag([1e-9, 1e-6, 1e-6, stiffness, stiffness, stiffness])
    right = (weights * values[i[enough], j[enough]]) @ basis
    result[rows, columns] = np.linalg.solve(normal + stiff, right[:, :, None])[:, 0, 0]
    return np.where(inside, result, np.minimum(result, -1e-6 * top))


def _smoothed(line: Array) -> Array:
    """`line` without the wobble of single elements."""
    closed = _is_closed(line)
    for _ in range(SMOOTHINGS):
        middle = line.copy()
        middle[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
        if closed:
            middle[0] = middle[-1] = 0.25 * line[-2] + 0.5 * line[0] + 0.25 * line[1]
        line = middle
    return line


def _is_closed(line: Array) -> bool:
    return bool(np.array_equal(line[0], line[-1]))


def _length(line: Array, element: Array) -> float:
    """Length of `line`, in elements."""
    steps = np.diff(line, axis=0) / element
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())


def _to_the_border(line: Array, element: Array) -> Array:
    """An open stick border continued at its ends, far enough to reach the contact's border, where it is cut off: slip
    is not known well in the last elements before that."""
    if _is_closed(line):
        return line
    # No line goes on for longer than it is.
    reach = min(REACH, _length(line, element)) * float(np.hypot(*element))
    cut = min(CUT, len(line) // 8)
    line = line[cut : len(line) - cut]
    tail = min(TAIL, len(line) - 1)
    ends = []
    for end, inner in ((line[0], line[tail]), (line[-1], line[-tail - 1])):
        direction = end - inner
        ends.append(end + direction * (reach / max(float(np.hypot(*direction)), 1e-300)))
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

    generator = contour_generator(_ringed(x), _ringed(y), padded.T, name="serial")
    lines: Lines = [np.asarray(line) for line in generator.lines(0.0)]
    return lines


def _ringed(axis: Array) -> Array:
    """Element centres with RINGS more on each side."""
    step = axis[1] - axis[0]
    beyond = step * np.arange(1, RINGS + 1)
    return np.concatenate([axis[0] - beyond[::-1], axis, axis[-1] + beyond])

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
    squared, slipping = _extended(slip**2, labels == 2, contact)
    return Borders(lines, _zero_lines(x, y, _continued(squared, slipping)))


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


def _extended(strength: Array, inside: Mask, known: Mask) -> tuple[Array, Mask]:
    """Field and mask grown two elements beyond the `known` ones, so that the stick border runs on across the contact's
    border instead of following it."""
    for _ in range(2):
        votes, weight, total = (np.zeros_like(strength) for _ in range(3))
        for axis in (0, 1):
            for step in (1, -1):
                neighbour = _shifted(known, step, axis)
                member = neighbour & _shifted(inside, step, axis)
                votes += neighbour
                weight += member
                total += np.where(member, _shifted(strength, step, axis), 0.0)
        new = ~known & (votes > 0)
        grown = new & (2 * weight > votes)
        strength = np.where(grown, total / np.maximum(weight, 1.0), strength)
        inside, known = inside | grown, known | new
    return strength, inside


def _shifted(values: NDArray, step: int, axis: int) -> NDArray:  # type: ignore[type-arg]
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

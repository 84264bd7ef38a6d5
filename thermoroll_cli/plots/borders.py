"""Borders of the contact and between stick and slip, from the shares of elements that results store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from contourpy import contour_generator
from matplotlib.path import Path
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

Array = NDArray[np.float64]
Lines = list[Array]
"""Polylines, each of shape (points, 2) in m."""

SMOOTHING = 1.2
"""Width in elements of the bell by which covered shares are averaged: the border runs between the elements, without steps."""
STICK_SMOOTHING = 0.7
"""Width of the bell for distances from the border of stick."""
RIM = 4
"""Elements added around the grid, for contacts that reach its rim."""
REACH = 15.0
"""Largest distance from the border of stick in elements: borders nearly along x advance by one row in so many elements."""
SMALLEST, SHORTEST = 6.0, 4.0
"""Areas within closed stick borders in elements, and lengths of open ones: smaller ones are too small to be placed."""


@dataclass(frozen=True)
class Borders:
    """Border of the contact (closed lines) and between stick and slip (to be clipped by the contact)."""

    contact: Lines
    stick: Lines

    @property
    def outline(self) -> Path | None:
        """The contact as one path to clip by; None without contact."""
        return Path.make_compound_path(*(Path(line, closed=True) for line in self.contact)) if self.contact else None


def borders_of(x: Array, y: Array, fields: Mapping[str, NDArray[Any]]) -> Borders:
    """Borders of a state with these fields at the element centres `x`, `y`: where half of an averaged element is in the
    contact, and where sticking ends along x. Files that lack the shares of elements have those of whole elements."""
    covered = np.pad(np.asarray(fields.get("covered", fields["state"] > 0), dtype=float), RIM)
    sticking = np.pad(np.asarray(fields.get("stick_share", fields["state"] == 1), dtype=float), RIM)
    axes = (_widened(x), _widened(y))
    contact = _contours(axes, gaussian_filter(covered, SMOOTHING, mode="constant", truncate=RIM / SMOOTHING) - 0.5)
    if not sticking.any() or np.array_equal(sticking, covered):
        return Borders(contact, [])
    distance = gaussian_filter(_distance_from_slip(sticking, covered), STICK_SMOOTHING, mode="nearest")
    element = np.array([x[1] - x[0], y[1] - y[0]])
    return Borders(contact, [line for line in _contours(axes, distance) if _is_shown(line / element)])


def _distance_from_slip(sticking: Array, covered: Array) -> Array:
    """Distance along x from the border between stick and slip, in elements, negative where surfaces slip.

    Shares know that border within an element along x only. The distance is linear across it, so that a contour of zero is
    straight between neighbouring rows, where a contour of the shares would have a step for each row."""
    nearest = distance_transform_edt(covered == 0.0, return_distances=False, return_indices=True)
    share = (sticking / np.where(covered > 0.0, covered, 1.0))[tuple(nearest)]
    sticks, place = share > 0.5, np.arange(share.shape[0], dtype=float)[:, None]
    border = place[:-1] + 0.5 + np.where(sticks[:-1], 1.0, -1.0) * (share[:-1] + share[1:] - 1.0)
    there, far = sticks[1:] != sticks[:-1], np.full((1, share.shape[1]), np.inf)
    before = np.maximum.accumulate(np.vstack([-far, np.where(there, border, -np.inf)]))
    after = np.minimum.accumulate(np.vstack([np.where(there, border, np.inf), far])[::-1])[::-1]
    return np.asarray(np.where(sticks, 1.0, -1.0) * np.clip(np.minimum(place - before, after - place), 0.0, REACH))


def _contours(axes: tuple[Array, Array], values: Array) -> Lines:
    """Lines where `values` are zero."""
    return [np.asarray(line) for line in contour_generator(*axes, values.T, name="serial").lines(0.0)]


def _is_shown(line: Array) -> bool:
    """Whether a stick border, in elements, is large enough to be placed."""
    if np.array_equal(line[0], line[-1]):
        x, y = line.T
        return bool(0.5 * abs(x[:-1] @ y[1:] - x[1:] @ y[:-1]) > SMALLEST)
    return bool(np.hypot(*np.diff(line, axis=0).T).sum() > SHORTEST)


def _widened(axis: Array) -> Array:
    """Element centres with RIM more on each side."""
    step = axis[1] - axis[0]
    return axis[0] + step * np.arange(-RIM, axis.size + RIM)

"""Borders of the contact and between stick and slip: contours of the shares of elements that results store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from contourpy import contour_generator
from matplotlib.path import Path
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
Lines = list[Array]
"""Polylines, each of shape (points, 2) in m."""

SMOOTHING = 1.2
"""Width in elements of the bell by which shares are averaged: borders of shares run between the elements, without steps."""
RIM = 4
"""Elements added around the grid, for contacts that reach its rim."""
KNOWN = 1e-3
"""Averaged covered share from which on stick has a share of it."""
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
    contact, and where half of its covered share sticks. Files that lack these shares have those of whole elements."""
    covered = np.asarray(fields.get("covered", fields["state"] > 0), dtype=float)
    sticking = np.asarray(fields.get("stick_share", covered * (fields["state"] == 1)), dtype=float)
    axes = (_widened(x), _widened(y))
    inside = gaussian_filter(np.pad(covered, RIM), SMOOTHING, mode="constant", truncate=RIM / SMOOTHING)
    contact = _contours(axes, inside)
    if not sticking.any() or np.array_equal(sticking, covered):
        return Borders(contact, [])
    share = gaussian_filter(np.pad(sticking, RIM), SMOOTHING, mode="constant", truncate=RIM / SMOOTHING)
    ratio = np.ma.masked_where(inside < KNOWN, share / np.maximum(inside, KNOWN))
    element = np.array([x[1] - x[0], y[1] - y[0]])
    return Borders(contact, [line for line in _contours(axes, ratio) if _is_shown(line / element)])


def _contours(axes: tuple[Array, Array], share: Array) -> Lines:
    return [np.asarray(line) for line in contour_generator(*axes, share.T, name="serial").lines(0.5)]


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

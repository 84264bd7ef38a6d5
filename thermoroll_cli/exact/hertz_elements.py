"""Hertz pressure averaged over the elements of a grid, and the part of each element that the contact covers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.exact.gauss import gauss_legendre
from thermoroll_cli.exact.hertz import HertzContact

Array = NDArray[np.float64]

# Gauss points across each row. The outermost row meets a square-root end point; six leave 1e-4 of that row's load.
ROW_POINTS = 6


def element_averages(hertz: HertzContact, x_edges: Array, y_edges: Array) -> tuple[Array, Array]:
    """Element averages of p in Pa and covered fractions, both (nx, ny), for elements between the given edges (m).

    Both are integrated in closed form along x and by Gauss points across each row.
    """
    a, b = hertz.semi_axis_x, hertz.semi_axis_y
    nodes, weights = gauss_legendre(ROW_POINTS)
    low = np.clip(y_edges[:-1], -b, b)
    high = np.clip(y_edges[1:], -b, b)
    share = (high - low) / np.diff(y_edges)  # part of each row's width inside the ellipse
    y = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * nodes
    chord = np.sqrt(np.maximum(1.0 - (y / b) ** 2, 0.0))  # half-chord over a, (ny, points)
    safe = np.where(chord > 0.0, chord, 1.0)
    ratio = np.clip(x_edges[:, None, None] / (a * safe), -1.0, 1.0)
    # Antiderivative of sqrt(c² − ξ²) in ξ = x/a.
    area = 0.5 * chord**2 * (ratio * np.sqrt(1.0 - ratio**2) + np.arcsin(ratio))
    mean = (np.diff(area, axis=0) @ (0.5 * weights)) * share
    pressure = hertz.peak_pressure * mean * (a / np.diff(x_edges))[:, None]
    inside = np.clip(x_edges[:, None, None] / a, -chord, chord)
    covered = (np.diff(inside, axis=0) @ (0.5 * weights)) * share * (a / np.diff(x_edges))[:, None]
    covered[covered > 1.0 - 1e-12] = 1.0
    return pressure, np.where(pressure > 0.0, covered, 0.0)

"""How far the scalars below the surface may be from those of infinitely fine grids and layers."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from thermoroll_cli.problem.error_scale import error_scale
from thermoroll_cli.problem.subsurface import Peak

SAFETY, BEFORE = 1.5, 1.0 / 8.0
"""Of the change over the last doubling of the grid, over 2^p − 1 with the order p that is seen; not less than this share of the
change before, for two values may agree by accident."""
SURFACE_ORDER, SURFACE_SAFETY = 0.5, 1.0
"""Stresses that are largest at the surface are so at the border of contact, where they rise like the square root of the
distance: their errors fall like the square root of the element."""
LAYERS = 1.0 / 8.0
"""Part of the change from every second layer to all of them: five layers tell the maximum between them to fifth order, and
are exact where it lies on one."""
FLOOR = 2e-5


def error_of(
    grids: Sequence[Mapping[str, float]], half_the_layers: Mapping[str, float], reference: Mapping[str, float],
    at_surface: Collection[str],
) -> dict[str, float]:
    """Estimated error of each scalar of the last of `grids` (coarse to fine, each side doubled) over its `error_scale`.

    `half_the_layers` are the scalars of the last grid from every second layer, `reference` those of the state and of the
    inputs, which tell the scales; `at_surface` names those whose maximum lies at the surface. nan with one grid alone."""
    return {
        name: _error([grid[name] for grid in grids], half_the_layers[name], error_scale(name, reference), name in at_surface)
        for name in grids[-1]
    }


def errors_with_rivals(
    name: str, error: Mapping[str, float], strongest: Peak, rivals: Sequence[tuple[Peak, Peak]], reference: Mapping[str, float]
) -> dict[str, float]:
    """Errors of the largest von Mises stress and of its place, where it may lie elsewhere on a finer grid.

    `rivals` are the largest stresses of the surface and of what lies below it, grid by grid; the surface's may still grow like
    a square root. `name` makes the scalars' names from a quantity and a unit."""
    top = name.format("max", "MPa")
    if len(rivals) < 2 or math.isnan(error[top]):
        return {}
    scale = error_scale(top, reference) * 1e6
    surface, below = rivals[-1]
    at_surface = _error([grid[0].value for grid in rivals], surface.value, scale, True) * scale
    own = max(error[top] * scale, surface.value + at_surface - strongest.value if strongest.z > 0.0 else at_surface)
    found = {top: own / scale}
    rival = below if strongest.z == 0.0 else surface
    if rival.value + (at_surface if rival is surface else 0.0) >= strongest.value - error[top] * scale:
        for quantity, axis in (("depth", "z"), ("x", "x"), ("y", "y")):
            place = name.format(quantity, "mm")
            distance = abs(getattr(strongest, axis) - getattr(rival, axis)) * 1e3
            found[place] = error[place] + distance / error_scale(place, reference)
    return found


def _error(values: list[float], coarse_layers: float, scale: float, at_surface: bool) -> float:
    if len(values) < 2:
        return math.nan
    last = abs(values[-1] - values[-2])
    before = abs(values[-2] - values[-3]) if len(values) > 2 else 4.0 * last
    if at_surface:
        by_grid = SURFACE_SAFETY * max(last, BEFORE * before) / (2.0**SURFACE_ORDER - 1.0)
    else:
        order = min(max(math.log2(before / last), 1.0), 2.0) if before > 0.0 and last > 0.0 else 2.0
        by_grid = SAFETY * max(last / (2.0**order - 1.0), BEFORE * before)
    return max((by_grid + LAYERS * abs(coarse_layers - values[-1])) / scale, FLOOR)

"""A contact whose strength is asked for."""

from __future__ import annotations

from thermoroll_cli.problem.problem import (
    Geometry,
    Heating,
    Material,
    Motion,
    Numerics,
    Problem,
    Strength,
    SubsurfaceRequest,
)


def strong_circle(friction: float, grid: int = 64) -> Problem:
    """Two steel spheres that slide as a whole, with the strength of the lower one asked for."""
    steel = Material(210e9, 0.3)
    return Problem(
        steel, steel, Geometry(*(0.03,) * 4), 65.0, friction, Motion(1.0, 0.1), Heating(heat=False),
        Numerics(grid=(grid, grid)),
        subsurface=SubsurfaceRequest(("lower",), layers=28, lower_strength=Strength(200e6, 0.3)))

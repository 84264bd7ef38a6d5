"""Rolling of cylinders as one row of long elements, and the tangential solver by itself."""

from __future__ import annotations

import numpy as np

from tests.support.scenes import elastic
from thermoroll_cli.exact.hertz import line_contact
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.physics.rolling.rolling_solver import RollingSolver, TangentialSolution

CYLINDERS = line_contact(20.0, 1.0 / (2.0 * (1.0 - 0.28**2) / 210e9), 3e5)


def solve_cell(
    gradient: RollingGradient, cell: TangentialProblem, tolerance: float, start: np.ndarray | None = None
) -> TangentialSolution:
    """The solver by itself, from zero traction unless told otherwise."""
    first = np.zeros((2, *cell.traction_bound.shape)) if start is None else start
    return RollingSolver(gradient).solve(cell, [(first, (0.0, 0.0))], tolerance)


def carter_row(n: int, offset: float, share: float, lateral: bool = False) -> tuple[RollingGradient, TangentialProblem]:
    """One row of elements, `offset` elements off the centre, long enough to be two-dimensional; `share` of saturation.

    The lateral problem is Carter's with the anti-plane compliance."""
    a, friction, g = CYLINDERS.half_width, 0.3, elastic(0.28).shear_modulus
    dx, length = 2.2 * a / n, 1e4 * a
    edges = (np.arange(n + 1) - 0.5 * n + offset) * dx
    t = np.clip(edges / a, -1.0, 1.0)
    pressure = np.diff(t * np.sqrt(1.0 - t * t) + np.arcsin(t)) * 0.5 * a / dx * CYLINDERS.peak_pressure
    covered = np.maximum(np.minimum(edges[1:], a) - np.maximum(edges[:-1], -a), 0.0) / dx
    exact = carter(CYLINDERS, friction, share * saturation_creepage(CYLINDERS, friction))
    compliance = ShearCompliance.of((g, 0.28), (g, 0.28))
    direction = 1 if lateral else 0
    rigid = np.zeros((2, n, 1))
    rigid[direction] = exact.creepage * (compliance.across / compliance.along if lateral else 1.0)
    cell = TangentialProblem(friction * pressure[:, None], np.minimum(covered, 1.0)[:, None], rigid, dx * length)
    return RollingGradient((n, 1), dx, length, Bodies.of_shear(compliance)), cell


def carter_strip(n: int, offset: float, share: float, lateral: bool) -> tuple[float, TangentialSolution]:
    """Force error over μN of `carter_row`, and its solution."""
    gradient, cell = carter_row(n, offset, share, lateral)
    solution = solve_cell(gradient, cell, 1e-9)
    assert solution.converged
    exact = carter(CYLINDERS, 0.3, share * saturation_creepage(CYLINDERS, 0.3))
    limit = 0.3 * CYLINDERS.load_per_length
    return float(solution.traction[int(lateral)].sum()) * gradient.dx / limit - exact.force / limit, solution

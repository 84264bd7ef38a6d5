"""What a transverse profile makes doubtful: told before solving."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.problem.surface import lateral_gap, surfaces
from thermoroll_cli.steady_state.derived import DerivedQuantities

STEEPEST = 0.1
"""Slope across the contact from which the half-space is a doubtful model: cosines differ from one by 0.5 %."""
WIDEST = 1.0 / 3.0
"""Width of a patch over the radius of curvature in it, likewise; where that varies, the angle by which the surface turns across
the patch."""
SAMPLES = 513
"""Places across the contact at which the radii of a profile are looked up."""


def profile_warnings(derived: DerivedQuantities) -> list[str]:
    """Where half-space theory is doubtful, and where the pressure has no upper bound."""
    scales, geometry = derived.scales, derived.problem.geometry
    y = scales.centre + scales.semi_axis_y * np.linspace(-1.0, 1.0, SAMPLES)[1:-1]
    y = y[lateral_gap(geometry, y) < scales.approach]
    out = []
    for body, surface in zip(("lower", "upper"), surfaces(geometry), strict=True):
        slope = float(np.abs(surface.slope(y)).max())
        if slope > STEEPEST:
            out.append(f"the surface of the {body} body is inclined by up to {slope:.2f} in the contact: the half-space "
                       f"assumption is doubtful above {STEEPEST:g}")
        # Along each patch by itself.
        patches = np.split(y, np.flatnonzero(np.diff(y) > 1.5 * (y[1] - y[0])) + 1)
        conformity = max(float(np.ptp(surface.slope(part))) for part in patches)
        if conformity > WIDEST:
            out.append(f"the contact is {conformity:.2f} times as wide as the radius of curvature of the {body} body in it: "
                       f"the half-space assumption is doubtful above {WIDEST:.2g}")
    if scales.reaches_an_end:
        out.append(FREE_END)
    return out


FREE_END = ("the contact reaches the end of a profile: the pressure there has no upper bound, so pressure_max_MPa, gamma_p and "
            "shear_max_MPa grow with every refinement and have no error estimate")
"""Told wherever a free end is loaded."""

"""Different thermal expansion also moves the surfaces along each other: how much, and when it must not be left out.

Heat makes a free surface rise by u_z and stretch along itself: the surface displacement of a thermoelastic half-space (quasi-
static, Goodier's potential plus Boussinesq's correction, m and n the wavenumbers along x and y, w = sqrt(m² + n²)) is

    û_z = 2(1+ν)α T^/(w + w')      û_x = −(i m/w) û_z      û_y = −(i n/w) û_z       w'² = w² + i m s/κ,

which for material moving with speed s along x, since 1/(w + w') = κ (w' − w)/(i m s), is in real space

    ∂u_x/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂x,      ∂u_y/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂y

with T_0 the temperature that the same heat would make in material at rest (where the strains add up to (1+ν)αT). Bodies
alike in all this stretch alike, and their slip does not feel it; the difference of two other bodies belongs into the slip
equation, ṡ/V = ξ − ∂u/∂x, but is left out of it: in realistic cases it is below one per cent of the creepage at
which the contact slides (docs/dissimilar.md). This module finds out where it is not.
"""

from __future__ import annotations

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.problem import Material
from thermoroll_cli.steady_state.derived import DerivedQuantities

WORTH_TELLING = 0.02
"""Part of the saturation creepage from which the estimate is told; the true gradient may be 2–3 times as large locally."""


def tangential_expansion(derived: DerivedQuantities, rise_lower: Array, rise_upper: Array) -> float:
    """Estimate of the largest |∂u/∂x| between the surfaces by their thermal expansion, from their temperature rises in K.

    Of each body (1+ν)α T · 2w/|w + w'| with w = 1/a0, that is 2/(1 + (1 + P²)^¼): within a factor of two of the closed
    form above for smooth heat and Péclet numbers P = V a0/κ up to 5000."""
    lower, upper = derived.problem.lower, derived.problem.upper
    difference = _strain_per_kelvin(derived, lower) * rise_lower - _strain_per_kelvin(derived, upper) * rise_upper
    return float(np.abs(difference).max())


def _strain_per_kelvin(derived: DerivedQuantities, body: Material) -> float:
    # Only in rolling mode does every point of the material pass at the same known speed.
    peclet = derived.peclet(body) if derived.problem.heating.peclet == "rolling" else 0.0
    assert body.expansion is not None
    return (1.0 + body.poisson_ratio) * body.expansion * 2.0 / (1.0 + (1.0 + peclet**2) ** 0.25)


def tangential_expansion_warning(derived: DerivedQuantities, rise_lower: Array, rise_upper: Array) -> str:
    """A warning where the surfaces of different bodies stretch so differently that the slip would feel it, or an empty text."""
    share = tangential_expansion(derived, rise_lower, rise_upper) / derived.saturation_creepage
    if not share > WORTH_TELLING:
        return ""
    return (f"the heated surfaces stretch along each other by about {100 * share:.0f} % of the saturation creepage: the slip "
            "equation does not contain this part of the thermal expansion")

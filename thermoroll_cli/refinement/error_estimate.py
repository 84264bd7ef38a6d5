"""Discretisation error of every scalar, and better values of some, from the grids that were solved on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from thermoroll_cli.assessment.scalars import input_scalars
from thermoroll_cli.model.derived import DerivedQuantities
from thermoroll_cli.model.error_scale import error_scale
from thermoroll_cli.model.result import SCALARS

Levels = Sequence[Mapping[str, float]]

ERROR_SCALARS = ("Q_F_W", "force_x_N", "force_y_N", "creepage_longitudinal", "creepage_lateral", "gamma_c", "gamma_st",
                 "gamma_p", "temperature_rise_max_lower_K", "temperature_rise_max_upper_K")
"""Scalars whose error has to fall below `numerics.accuracy` (those that are given have none)."""

EXTRAPOLATED = ("Q_F_W", "T_gamma_N", "force_x_N", "force_y_N", "spin_moment_Nmm", "creepage_longitudinal",
                "creepage_lateral")
"""Integrals over the contact converge smoothly, at second order: Richardson extrapolation is worth another digit. So do the
creepages that are found for forces."""

FLOOR = 2e-5
"""No estimate is smaller: rounding and solver tolerances are of this order."""

UNCHANGED = 1e-6
"""What changes by less than this from grid to grid is given or vanishes by symmetry."""

WEIGHTS = {
    "Q_F_W": (0.52, 1.0 / 16.0),
    "T_gamma_N": (0.52, 1.0 / 16.0),
    "force_x_N": (0.52, 1.0 / 8.0),
    "force_y_N": (0.52, 1.0 / 8.0),
    "spin_moment_Nmm": (0.52, 1.0 / 8.0),
    "gamma_c": (1.0, 1.0 / 16.0),
    "contact_area_mm2": (1.0, 1.0 / 16.0),
    "gamma_st": (1.0, 1.0 / 8.0),
    "gamma_p": (1.0, 1.0 / 16.0),
    "temperature_rise_max_lower_K": (1.0, 1.0 / 8.0),
    "temperature_rise_max_upper_K": (1.0, 1.0 / 8.0),
    "surface_temperature_max_lower_K": (1.0, 1.0 / 8.0),
    "surface_temperature_max_upper_K": (1.0, 1.0 / 8.0),
}
"""Safety factor, and weight of the change between the two coarser grids, of each estimate. Calibrated on random cases
(round and elliptic, creepage and spin, a third of them coupled, N = 32 and 64 against N = 256 extrapolated); the test of
honesty uses others. Anything not named here scatters more and takes `OTHERWISE`."""
OTHERWISE = (1.5, 1.0 / 8.0)

STICK_BORDER = 0.015
"""The border of stick and slip is located to a few hundredths of an element, but not where stick begins behind slip or the
border runs along the rolling direction: the stick fraction scatters by about this over N."""
UNSEEN = 1.5
"""A single element's share of the contact, times N²: a slip zone, or the stick around the pole of the spin, may be smaller."""
CONTACT_BORDER = 0.025
"""The contact border is located to a few hundredths of an element: where the contact is not Hertz's, its area scatters by about
this over N."""
FIRST_ORDER = 0.002
"""What is left of first order in integrals, over N: two changes can be smaller by accident. Round and wide contacts have none;
elements longer than twice their width keep some (`EdgeCompliance`)."""
FIRST_ORDER_DISSIMILAR = 0.1
"""The same between different bodies, whose tractions begin like √s ln s (two cases up to N = 512)."""


UNBOUNDED = {"pressure_max_MPa", "gamma_p", "shear_max_MPa", "heat_flux_max_W_mm2"}
"""Scalars that grow with every refinement where the contact reaches the end of a profile: there is no error to estimate."""


def unbounded(derived: DerivedQuantities) -> set[str]:
    """Scalars without a limit in this problem."""
    return UNBOUNDED if derived.problem.geometry.has_profile and derived.scales.reaches_an_end else set()


def estimates(levels: Levels, derived: DerivedQuantities, elements: int) -> dict[str, float]:
    """Estimated error of each reported scalar on the last of `levels` (coarse to fine, each side doubled), over its
    `error_scale`. nan for what is given.

    The change over the last doubling, over 2^p − 1 with the order p that the last three grids show (between 1 and 2), but not
    less than a share of the change before: two values may agree by accident. `elements` is the number per side of the last
    grid. nan for one grid alone.
    """
    summary = {**levels[-1], **input_scalars(derived)}
    given = _given(derived)
    return {
        name: math.nan if name in given else _estimate(
            name, [level.get(name, math.nan) for level in levels], error_scale(name, summary), derived, elements)
        for name in SCALARS
    }


def _given(derived: DerivedQuantities) -> set[str]:
    """Scalars that the case gives, which therefore have no error; and the one that is a measure of error itself."""
    motion, heating = derived.problem.motion, derived.problem.heating
    given = {"creepage_spin_rad_mm", "power_balance_error"}
    given |= unbounded(derived)
    given |= {"force_x_N"} if motion.force_x is not None else {"creepage_longitudinal"}
    given |= {"force_y_N"} if motion.force_y is not None else {"creepage_lateral"}
    return given if heating.partition == "matched" else given | {"partition_mean"}


def reported(levels: Levels, derived: DerivedQuantities) -> dict[str, float]:
    """Scalars of the last of `levels`, those in `EXTRAPOLATED` by Richardson where the last three grids converge one way."""
    values = dict(levels[-1])
    motion = derived.problem.motion
    given = {"force_x_N": motion.force_x, "force_y_N": motion.force_y}
    if len(levels) < 3:
        return values
    for name in EXTRAPOLATED:
        before, middle, last = (level[name] for level in levels[-3:])
        if given.get(name) is None and (last - middle) * (middle - before) > 0.0 and abs(last - middle) < abs(middle - before):
            values[name] = last + (last - middle) / 3.0
    return values


def _estimate(name: str, values: list[float], scale: float, derived: DerivedQuantities, elements: int) -> float:
    if len(values) < 2 or math.isnan(values[-1]) or math.isnan(values[-2]):
        return math.nan
    if scale == 0.0:
        return 0.0
    last = abs(values[-1] - values[-2])
    before = abs(values[-2] - values[-3]) if len(values) > 2 and not math.isnan(values[-3]) else 4.0 * last
    order = min(max(math.log2(before / last), 1.0), 2.0) if before > 0.0 and last > 0.0 else 2.0
    safety, share = WEIGHTS.get(name, OTHERWISE)
    error = safety * max(last / (2.0**order - 1.0), share * before) / scale
    if name == "gamma_st":
        if 0.0 < values[-1] < 1.0:
            error = max(error, STICK_BORDER / elements)
        elif values[-1] >= 1.0 or derived.problem.motion.spin != 0.0:
            error = max(error, UNSEEN / elements**2)
    # Hertz's area is exact, but for the quadrature of covered fractions.
    if name in ("gamma_c", "contact_area_mm2") and last + before > FLOOR * scale:
        error = max(error, CONTACT_BORDER / elements)
    if name in EXTRAPOLATED and last + before > UNCHANGED * scale:
        error = max(error, (FIRST_ORDER_DISSIMILAR if derived.dissimilar else FIRST_ORDER) / elements)
    return max(error, FLOOR)

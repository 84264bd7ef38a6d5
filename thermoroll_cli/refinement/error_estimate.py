"""Discretisation error of every scalar, and better values of some, from the grids that were solved on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from thermoroll_cli.exact.kalker import combined_constants, full_slip_creepages
from thermoroll_cli.problem.error_scale import FORCES, error_scale
from thermoroll_cli.problem.names import SCALARS
from thermoroll_cli.refinement.estimate_weights import OTHERWISE, WEIGHTS
from thermoroll_cli.refinement.scalars import input_scalars
from thermoroll_cli.steady_state.derived import DerivedQuantities

Levels = Sequence[Mapping[str, float]]

ERROR_SCALARS = ("Q_F_W", "force_x_N", "force_y_N", "creepage_longitudinal", "creepage_lateral", "gamma_c", "gamma_st",
                 "gamma_p", "temperature_rise_max_lower_K", "temperature_rise_max_upper_K")
"""Scalars whose error has to fall below `numerics.accuracy` (those that are given have none)."""

EXTRAPOLATED = ("Q_F_W", "T_gamma_N", "heat_into_lower_W", "heat_into_upper_W", "heat_conducted_W", "force_x_N", "force_y_N",
                "spin_moment_Nmm", "creepage_longitudinal", "creepage_lateral")
"""Integrals over the contact converge smoothly, at second order: Richardson extrapolation is worth another digit. So do the
creepages that are found for forces."""

FLOOR = 1.5e-5
"""No estimate is smaller: rounding and solver tolerances are of this order."""

UNCHANGED = 1e-6
"""What changes by less than this from grid to grid is given, known in closed form, or vanishes by symmetry."""

BETWEEN_ELEMENTS = ("gamma_st", "stick_area_mm2", "temperature_rise_max_lower_K", "temperature_rise_max_upper_K",
                    "surface_temperature_max_lower_K", "surface_temperature_max_upper_K")
"""Scalars that need not change while a zone of slip or stick stays smaller than an element."""

RELATIVE = ("Q_F_W", "T_gamma_N", "heat_into_lower_W", "heat_into_upper_W")
"""Those of them that count against themselves, however small they are."""

RESULTANTS = (*FORCES, "spin_moment_Nmm")

FEW, STRIP = 2.0, 0.7
"""Elements in a row that slip, below which the zone of slip may not be seen; and what strip theory's share of it is worth."""

PATCH = 8.0
"""The largest share of the contact that sticks, times c², where spin is c times the saturation creepage; times c for
differential slip."""

SURE = 1.5
"""Times the creepage of full slip: neither pressure peaks of heat nor slip across the traction change that so much."""

WIDER = 1.5
"""Where there is one coarser grid only, nothing tells how fast a value converges: its estimate is made this much wider."""

USUAL = 32.0
"""Estimates fall with 1/sqrt(N) more than the signs of error do, since convergence is the more regular the finer a grid is: of
extrapolated values from this N, at which their weights hold; of others from twice as many elements."""

HEAT_INTO = ("heat_into_lower_W", "heat_into_upper_W")

EXPANSIONS = ("thermal_displacement_max_um", "recirculation_bulge_um")

GAP = 5e-9
"""Times the approach: what is left of expansions that cancel, as those of bodies that exchange heat, is no more accurate, since
gaps are solved to 1e-7 of the approach."""

BESIDE = 0.05
"""Of the share of the contact between a patch of stick as it is found and as it is: how much lower the traction is there."""

EXCHANGED = 0.25
"""Over N: bodies of unlike temperatures exchange much of their heat at the border of the contact, whose place is known to a
part of an element."""

TOP = 8.0
"""Times 1/N⁴: error of the largest pressure, as the parabola through the highest elements of a smooth top finds it."""

SETTLED = 0.5
"""A value is extrapolated if the last doubling changed it by less than this part of itself."""


UNBOUNDED = {"pressure_max_MPa", "gamma_p", "shear_max_MPa", "heat_flux_max_W_mm2"}
"""Scalars that grow with every refinement where the contact reaches the end of a profile: there is no error to estimate."""


def unbounded(derived: DerivedQuantities) -> set[str]:
    """Scalars without a limit in this problem."""
    return UNBOUNDED if derived.problem.geometry.has_profile and derived.scales.reaches_an_end else set()


def estimates(levels: Levels, derived: DerivedQuantities, elements: float, *, extrapolated: bool = True) -> dict[str, float]:
    """Estimated error of each reported scalar on the last of `levels` (coarse to fine, each side doubled), over its
    `error_scale`: the sum of the signs of error that `Weights` lists. nan for what is given, and for one grid alone.

    `elements` is the number of elements over 1.1 diameters of the contact, `extrapolated` whether integrals are.
    """
    summary = {**levels[-1], **input_scalars(derived)}
    given = _given(derived)
    if len(levels) < 2:
        return dict.fromkeys(SCALARS, math.nan)
    common = _common_signs(levels, summary, derived, elements)
    errors = {name: math.nan if name in given else _estimate(name, levels, summary, common, elements, extrapolated)
              for name in SCALARS}
    if summary["gamma_st"] == 0.0 and not common["missed"]:
        errors |= {"gamma_st": FLOOR, "stick_area_mm2": FLOOR}
    known = {name for name, error in errors.items() if not math.isnan(error)}
    errors |= {name: _of_heat_into(name, errors, summary, derived, elements) for name in known.intersection(HEAT_INTO)}
    errors |= {name: errors[name] + _of_the_gap(name, summary) for name in known.intersection(EXPANSIONS)}
    top = TOP / elements**4
    if _slides_at_the_top(summary, derived, top):
        # The border of the patch of stick about the pole of spin may lie at the top.
        of_stick = BESIDE * errors["gamma_st"] if summary["gamma_st"] > 0.0 and derived.problem.motion.spin else 0.0
        of_pressure = errors["pressure_max_MPa"]
        errors["shear_max_MPa"] = max(FLOOR, top + of_stick + (0.0 if math.isnan(of_pressure) else of_pressure))
    return errors


def _of_heat_into(
    name: str, errors: Mapping[str, float], summary: Mapping[str, float], derived: DerivedQuantities, elements: float
) -> float:
    """Error of the heat into one body, which has part in that of the heat that is made, and of what bodies exchange."""
    if derived.problem.heating.partition != "matched":
        # Each body takes its share of the heat, and exchanges none with the other.
        return errors["Q_F_W"]
    exchanged = sum(abs(summary[body]) for body in HEAT_INTO) - summary["Q_F_W"]
    made = errors["Q_F_W"] * error_scale("Q_F_W", summary) / 2.0
    at_the_border = EXCHANGED / elements * max(exchanged, 0.0) / 2.0
    return errors[name] + _over(made + at_the_border, summary[name])


def _of_the_gap(name: str, summary: Mapping[str, float]) -> float:
    """What the accuracy of the gap leaves of that of an expansion, which may be many times smaller than the approach."""
    return _over(GAP * summary["approach_um"], summary[name])


def _over(error: float, value: float) -> float:
    return error / abs(value) if value else 0.0


def _slides_at_the_top(summary: Mapping[str, float], derived: DerivedQuantities, tolerance: float) -> bool:
    """Whether the largest traction is the friction coefficient times the largest pressure, and as well known."""
    problem = derived.problem
    if problem.friction_slope != 0.0 or not derived.kinematics.has_traction or math.isnan(summary["pressure_max_MPa"]):
        return False
    return abs(summary["shear_max_MPa"] / (problem.friction * summary["pressure_max_MPa"]) - 1.0) < tolerance


def _given(derived: DerivedQuantities) -> set[str]:
    """Scalars that the case gives, which therefore have no error; and the one that is a measure of error itself."""
    motion, heating = derived.problem.motion, derived.problem.heating
    given = {"creepage_spin_rad_mm", "power_balance_error", "warm_up_time_lower_s", "warm_up_time_upper_s"}
    given |= unbounded(derived)
    given |= {"force_x_N"} if motion.force_x is not None else {"creepage_longitudinal"}
    given |= {"force_y_N"} if motion.force_y is not None else {"creepage_lateral"}
    for body, track in (("lower", heating.lower_track), ("upper", heating.upper_track)):
        given |= {f"bulk_temperature_{body}_K", f"entry_temperature_max_{body}_K"} if track is None else set()
    given |= set() if heating.conducts else {"heat_conducted_W"}
    return given if heating.partition == "matched" else given | {"partition_mean"}


def reported(levels: Levels, derived: DerivedQuantities) -> dict[str, float]:
    """Scalars of the last of `levels`, those in `EXTRAPOLATED` by Richardson where the last three grids converge one way."""
    values = dict(levels[-1])
    motion = derived.problem.motion
    given = {"force_x_N": motion.force_x, "force_y_N": motion.force_y}
    if len(levels) < 3:
        return values
    for name in EXTRAPOLATED:
        before, middle, last = (level.get(name, math.nan) for level in levels[-3:])
        if given.get(name) is None and _extrapolates(name, middle - before, last - middle, abs(last)):
            values[name] = last + (last - middle) / 3.0
    return values


def _extrapolates(name: str, before: float, last: float, size: float) -> bool:
    """Whether a scalar of that `size` is extrapolated after these two changes, in the same unit."""
    settled = name not in RELATIVE or abs(last) < SETTLED * size
    return name in EXTRAPOLATED and settled and converges_one_way(before, last)


def converges_one_way(before: float, last: float) -> bool:
    """Whether of two changes in a row the second goes on in the direction of the first, and less far."""
    return last * before > 0.0 and abs(last) < abs(before)


def _slides_for_sure(derived: DerivedQuantities) -> bool:
    """Whether the creepage is so far beyond that of full slip that no grid can find a place that sticks."""
    problem, motion = derived.problem, derived.problem.motion
    if not derived.kinematics.has_traction:
        return True  # nothing resists: there is no stick to be found
    if motion.creepage_x is None or motion.creepage_y is None or derived.dissimilar or problem.geometry.has_profile:
        return False
    lower, upper = problem.lower, problem.upper
    constants = combined_constants(lower.shear_modulus, lower.poisson_ratio, upper.shear_modulus, upper.poisson_ratio)
    along, across = full_slip_creepages(derived.hertz, problem.friction, *constants)
    varies = sum(derived.kinematics.creepage_variation) / min(along, across)
    return math.hypot(motion.creepage_x / along, motion.creepage_y / across) - varies > SURE


def _common_signs(
    levels: Levels, summary: Mapping[str, float], derived: DerivedQuantities, elements: float
) -> dict[str, float]:
    """The signs of error that all scalars of a state share (names of `Weights`)."""
    motion, scales = derived.problem.motion, derived.scales
    limit = derived.problem.traction_limit
    changes = [abs(levels[-1][name] - levels[-2][name]) / error_scale(name, summary) for name in RESULTANTS] if limit else [0.0]
    carried = math.hypot(summary["force_x_N"], summary["force_y_N"]) / limit if limit else 0.0
    forced = motion.force_x is not None or motion.force_y is not None
    peak = 1.0 if math.isnan(summary["gamma_p"]) else summary["gamma_p"]
    return {
        "forces": max(changes),
        "first": 1.0 / elements,
        "second": 1.0 / elements**2,
        "dissimilar": 1.0 / elements if derived.dissimilar else 0.0,
        "pole": _pole(summary, derived, elements),
        "missed": _missed(summary, derived, elements),
        "profile": 1.0 / elements if derived.problem.geometry.has_profile else 0.0,
        "narrow": 1.0 / max(_slipping(summary, derived, elements), 1.0) ** 2,
        "long": max(scales.semi_axis_x / scales.semi_axis_y - 1.0, 0.0) / elements,
        "uneven": min(abs(peak - 1.0), abs(derived.dundurs_beta)) / elements if derived.dissimilar else 0.0,
        "departure": abs(peak - 1.0) / max(peak, 1.0) / elements,
        "near_limit": min(1.0, 1.0 / elements**2 / max(1.0 - carried, 1e-3)) if forced else 0.0,
    }


def _slipping(summary: Mapping[str, float], derived: DerivedQuantities, elements: float) -> float:
    """Elements in a row that slip."""
    scales, spin = derived.scales, derived.problem.motion.spin
    seen = (1.0 - summary["gamma_st"]) * elements
    if seen >= FEW or derived.problem.traction_limit == 0.0:
        return seen
    # The zone of slip may be narrower than an element: in strip theory its share is the creepage's of saturation.
    creepage = math.hypot(summary["creepage_longitudinal"], summary["creepage_lateral"], spin * scales.mean_radius)
    elongation = math.sqrt(max(scales.semi_axis_x / scales.semi_axis_y, 1.0))
    return max(seen, STRIP * min(1.0, creepage / derived.saturation_creepage * elongation) * elements)


def _missed(summary: Mapping[str, float], derived: DerivedQuantities, elements: float) -> float:
    """Share of the contact that may stick though the grid has found no such place."""
    if summary["gamma_st"] > 0.0 or _slides_for_sure(derived):
        return 0.0
    # A patch of stick is the smaller, the faster creepage grows around it: from a point with spin, else from a line.
    saturation = derived.saturation_creepage
    by_spin, by_shape = (saturation / max(saturation, part) for part in derived.kinematics.creepage_variation)
    return min(1.0 / elements, PATCH * by_spin**2, PATCH * by_shape)


def _pole(summary: Mapping[str, float], derived: DerivedQuantities, elements: float) -> float:
    """μ|β| over the elements side by side that stick about the pole of spin, where tractions turn; at least one."""
    if not (derived.kinematics.has_traction and derived.problem.motion.spin and derived.dissimilar):
        return 0.0
    return derived.problem.friction * abs(derived.dundurs_beta) / max(1.0, elements * math.sqrt(summary["gamma_st"]))


def _estimate(
    name: str, levels: Levels, summary: Mapping[str, float], common: Mapping[str, float], elements: float, extrapolated: bool
) -> float:
    values, scale = [level.get(name, math.nan) for level in levels[-3:]], error_scale(name, summary)
    if math.isnan(values[-1]) or math.isnan(values[-2]) or math.isnan(scale):
        return math.nan
    if scale == 0.0:
        return 0.0
    last = (values[-1] - values[-2]) / scale
    known = len(values) > 2 and not math.isnan(values[0])
    before = (values[-2] - values[-3]) / scale if known else 0.0
    if abs(last) + abs(before) < UNCHANGED and name not in BETWEEN_ELEMENTS:
        return FLOOR
    if extrapolated and _extrapolates(name, before, last, abs(values[-1]) / scale):
        own = {"extrapolated": abs(4.0 * last - before) / 3.0, "smooth": abs(last)}
    else:
        ratio = min(1.0, abs(last / before)) if before else 1.0
        own = {"steady": abs(last) * ratio, "last": abs(last), "before": abs(before)}
    weights = WEIGHTS.get(name, OTHERWISE)
    total = sum(getattr(weights, sign) * size for sign, size in {**own, **common}.items())
    finer = math.sqrt(USUAL / elements if name in EXTRAPOLATED else min(1.0, 2.0 * USUAL / elements))
    return max(total * finer * (1.0 if known else WIDER), FLOOR)

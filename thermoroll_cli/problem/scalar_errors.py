"""Errors of scalars: the scale by which they are judged, and the digits of a number that they leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from thermoroll_cli.problem.kinds import contact_name
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    ASSEMBLY_SCALARS,
    GROUPS,
    ISOTHERMAL,
    OVER_LIMIT,
    PER_LENGTH,
    SCALARS,
    STATES,
    UNCERTAINTY,
    holds,
    known_as,
)
from thermoroll_cli.problem.problem import BODIES, Numerics, Problem
from thermoroll_cli.tools.arrays import Array

FORCES, CREEPAGES, TEMPERATURES, MISMATCHES = (
    tuple(name for name, scalar in SCALARS.items() if scalar.scale == scale)
    for scale in ("force", "creepage", "temperature", "mismatch")
)

ANY_FORCES = (*FORCES, *(PER_LENGTH[force] for force in FORCES))
"""Creep forces of contacts, and of line contacts."""


def error_scale(name: str, summary: Mapping[str, Any]) -> float:
    """The scale of a scalar: `numerics.accuracy` bounds its estimated error over this, and so results are compared.

    | scalar | its error is judged over |
    | --- | --- |
    | `force_x_N`, `force_y_N` | μW |
    | `spin_moment_Nmm` | μW sqrt(a0 b0) |
    | temperatures and their rises | the largest temperature difference of the problem: rises and bulk temperatures |
    | `creepage_longitudinal`, `creepage_lateral`, where found | the magnitude of the creepage, spin counted at sqrt(a0 b0) |
    | `contact_force_y_N`, `contact_force_z_N` | their resultant |
    | `axial_displacement_um`, `radial_displacement_*um` | their resultant |
    | `track_force_*_N`; `height_mm` | the vertical force on the track; the largest approach |
    | `gamma_st`, `power_balance_error`, `lateral_over_vertical_*`; `stick_area_mm2` | 1 (absolute); the contact area |
    | `roll_mrad`, `rolling_radius_difference_mm` | 1 (absolute) |
    | stresses below the surface; places and depths | the largest pressure; the smaller Hertz semi-axis |
    | anything else | its value |

    `summary` has the scalars of one state and those of the problem (`SCALARS` and `PROBLEM_SCALARS`), as in
    `Result.summary()`. nan if a scalar that the scale needs is missing.
    """
    match ALL_SCALARS[name].scale if name in ALL_SCALARS else "value":
        case "force":
            return _number(summary, "friction_limit_N")
        case "moment":
            return _number(summary, "friction_limit_N") * mean_semi_axis(summary)
        case "temperature":
            return temperature_difference(summary)
        case "creepage":
            spin = summary.get("creepage_spin_rad_mm", 0.0) * mean_semi_axis(summary)
            return math.hypot(*(_number(summary, direction) for direction in CREEPAGES), spin)
        case "share" | "mismatch":
            return 1.0
        case "vertical":
            return abs(_number(summary, "track_force_z_N"))
        case "approach":
            return _number(summary, "approach_max_um") * 1e-3
        case "resultant":
            return math.hypot(_number(summary, "contact_force_y_N"), _number(summary, "contact_force_z_N"))
        case "displacement":
            return math.hypot(*(_number(summary, name) for name in ALL_SCALARS if ALL_SCALARS[name].scale == "displacement"))
        case "stick area":
            return _number(summary, "contact_area_mm2")
        case "stress below":
            return _number(summary, "pressure_max_MPa")
        case "place below":
            axes = min(_number(summary, "hertz_a_mm"), _number(summary, "hertz_b_mm"))
            return mean_semi_axis(summary) if math.isnan(axes) else axes
    return abs(_number(summary, name))


def passed_on(errors: ArrayLike, sensitivities: ArrayLike) -> Array:
    """Errors (…) of quantities from the `errors` (n,) of what they depend on and their derivatives with respect to that
    (…, n). Signs are unknown, so magnitudes add: Σ |∂q/∂xᵢ| eᵢ. What a quantity does not depend on may be unknown."""
    shares = np.abs(sensitivities)
    return np.asarray(np.where(shares == 0.0, 0.0, shares * np.asarray(errors)).sum(axis=-1))


# --- an error that is not known is nan: so is what contains it, and no accuracy bounds it ------------------------------


def worst(errors: Iterable[float]) -> float:
    """The largest of `errors`, 0 of none; nan if one of them is not known."""
    return float(np.max([0.0, *errors]))


def together(
    name: str, contacts: Iterable[Mapping[str, Any]], join: Callable[[Iterable[float]], float] = max
) -> tuple[float, float]:
    """A scalar of several contacts together, nan if none has it, and its error in the scalar's unit, from their summaries:
    sums have the sum of the errors, all else (`join`) the largest of them."""
    mine = [contact for contact in contacts if computed(contact.get(name))]
    errors = [contact["uncertainty"].get(name, math.nan) for contact in mine]
    return join(contact[name] for contact in mine) if mine else math.nan, (math.fsum if join is math.fsum else worst)(errors)


def missed(errors: Mapping[str, float], accuracy: float | None) -> dict[str, float]:
    """Those of `errors` that an `accuracy` does not bound, in its measure; none where no accuracy is asked for."""
    return {} if accuracy is None else {name: error for name, error in errors.items() if not error <= accuracy}


def not_reached(accuracy: float | None, errors: Mapping[str, float], where: str, remedy: str) -> str:
    """Why a result is not as accurate as was asked for, from the `errors` that miss it: one that is not known, or the
    largest."""
    name = max(errors, key=lambda each: math.inf if math.isnan(errors[each]) else errors[each])
    known = f"is good to {errors[name]:.1e}" if computed(errors[name]) else "has no error estimate"
    return f"accuracy {accuracy:g} not reached {where}: {name} {known}; {remedy}"


def missed_by_whole(
    whole: Mapping[str, float], errors: Mapping[str, float], numerics: Numerics, judged: Iterable[str],
    scale: Callable[[str, Mapping[str, float]], float] = error_scale,
) -> str:
    """Why an assembly is not as accurate as was asked for though each of its contacts is, "" if it is, from its scalars and
    their `errors`: those of `numerics.accuracy_of` that no contact has, or those that are `judged` if it names none, over their
    `scale`. What is given has no entry in `errors`; what is 0 is so by symmetry."""
    asked = {name for each in numerics.accuracy_of for name in GROUPS.get(each, (each,))} or {*judged}
    over = {name: errors[name] / scale(name, whole) for name in ASSEMBLY_SCALARS
            if name in asked and name in errors and computed(whole.get(name)) and whole[name]}
    found = missed(over, numerics.accuracy)
    return not_reached(numerics.accuracy, found, "by the whole, though each contact has it",
                       "name what has to be accurate in numerics.accuracy_of, or set numerics.grid") if found else ""


def temperature_difference(summary: Mapping[str, Any]) -> float:
    """The largest temperature difference of the problem in K: a rise, or that of both bodies far from the contact."""
    rises = [_number(summary, f"temperature_rise_max_{body}_K") for body in BODIES]
    surfaces = [_number(summary, f"surface_temperature_max_{body}_K") for body in BODIES]
    bulk = [surface - rise for surface, rise in zip(surfaces, rises, strict=True)]
    return max(*rises, abs(bulk[1] - bulk[0]))


def mean_semi_axis(summary: Mapping[str, Any]) -> float:
    """sqrt(a0 b0) in mm; for surfaces without a Hertz ellipse the radius of a circle of the same contact area; a0 of a line
    contact, or half of its width."""
    if known_as("contact_area_mm2", summary) != "contact_area_mm2":
        half = _number(summary, "hertz_a_mm")
        return 0.5 * _number(summary, "contact_area_mm2") if math.isnan(half) else half
    axes = _number(summary, "hertz_a_mm") * _number(summary, "hertz_b_mm")
    if math.isinf(axes):
        return _number(summary, "hertz_a_mm")
    return math.sqrt(_number(summary, "contact_area_mm2") / math.pi if math.isnan(axes) else axes)


def _number(summary: Mapping[str, Any], name: str) -> float:
    """A scalar, or in a line contact that per length; nan where it is missing or, in JSON, null."""
    value = summary.get(known_as(name, summary))
    return math.nan if value is None else float(value)


SIGNIFICANT_DIGITS = 5
"""Digits of a value without an error."""
MISMATCH_DIGITS = 2
"""Digits of a scalar that is an error itself."""
NEGLIGIBLE_ERROR = 1e-9
"""Errors below this share of their value do not limit its digits: those of rounding."""
PLAIN = 1e6
"""Numbers below this are written without a power of ten."""
ROUNDING = 1e-12
"""Values below this, with errors that are, too, are zero but for rounding in the units of names (mm, N, mrad, …): displacements
of nanometres and wear rates of 1e-10 mm³/Nm are far above."""
SYMMETRY_NOISE = 1e-6
"""Forces, moments and creepages below this share of their whole are zero by symmetry but for rounding."""
STEADY = 1e-6
"""Values that differ by no more than this share of the largest one are the same."""


def row_of(summary: Mapping[str, Any]) -> dict[str, Any]:
    """A summary (`Result.summary()`) as a row, by the names that columns of tables have: of the state without thermal
    deformation `isothermal.NAME`, of estimated errors `uncertainty.NAME`, of patches of an assembly `left_1.NAME`."""
    row = dict(summary)
    parts = {state: row.pop(state, {}) for state in STATES}
    for patch in summary.get("patches", ()):
        if whole := contact_name(patch):
            parts |= {whole: {name: value for name, value in patch.items() if isinstance(value, float)},
                      f"{whole}.uncertainty": patch["uncertainty"]}
    return row | {f"{part}.{name}": value for part, values in parts.items() for name, value in values.items()}


def listed_scalars(row: Mapping[str, Any], problem: Problem) -> list[str]:
    """Names of the computed scalars in a short table (`Scalar.listed`), those of an assembly alone first."""
    return [name for name, scalar in (ASSEMBLY_SCALARS | ALL_SCALARS).items()
            if computed(row.get(name)) and holds(scalar.listed, problem)]


def scalar_text(name: str, row: Mapping[str, Any]) -> str:
    """A scalar of a result with its estimated error, in its own unit: `11.07 ± 0.02`. A force or moment that symmetry makes
    zero is `0`. `row` is that of a result."""
    if name in MISMATCHES:
        return number(row[name], MISMATCH_DIGITS)
    return "0" if is_noise(name, row) else with_error(row[name], _number(row, UNCERTAINTY + name))


def isothermal_text(name: str, row: Mapping[str, Any]) -> str:
    """The same scalar without thermal deformation, with the same number of digits; "" if that state does not have it."""
    if f"{ISOTHERMAL}{name}" not in row:
        return ""
    isothermal = {**row, **{key.removeprefix(ISOTHERMAL): value for key, value in row.items() if key.startswith(ISOTHERMAL)}}
    if name in MISMATCHES:
        return number(isothermal[name], MISMATCH_DIGITS)
    # The error is that of the coupled state, which in a failed one may exceed all that is known of this.
    error = min(_number(row, UNCERTAINTY + name), 0.1 * abs(isothermal[name]))
    return "0" if is_noise(name, isothermal) else rounded(isothermal[name], error)


def with_error(value: float, error: float) -> str:
    """`11.07 ± 0.02`: the error with one digit (two if it starts with 1), the value with as many decimals. No ± without an
    error (nan)."""
    if not math.isfinite(error) or error == 0.0 or max(abs(value), error) < ROUNDING:
        return number(value)
    if error < NEGLIGIBLE_ERROR * abs(value):
        return f"{number(value)} ± {error:.0e}"
    power, decimals = _digits(value, error)
    if round(value / 10.0**power, decimals) == 0.0:
        return f"0 ± {error:.1g}" if power else f"0 ± {_fixed(error, power, decimals)}"
    text = f"{_fixed(value, power, decimals)} ± {_fixed(error, power, decimals)}"
    return f"({text})e{power}" if power else text


def rounded(value: float, error: float) -> str:
    """`value` with the digits that `with_error` shows of it."""
    if not (math.isfinite(value) and math.isfinite(error)) or abs(value) < ROUNDING or error <= NEGLIGIBLE_ERROR * abs(value):
        return number(value)
    power, decimals = _digits(value, error)
    if round(value / 10.0**power, decimals) == 0.0:
        return "0"
    return _fixed(value, power, decimals) + (f"e{power}" if power else "")


def _digits(value: float, error: float) -> tuple[int, int]:
    """Power of ten to factor out of numbers too small or too large to be written plainly, and the number of decimals."""
    size = max(abs(value), error)
    power = 0 if 1e-3 <= size < PLAIN else math.floor(math.log10(size))
    leading = math.floor(math.log10(error / 10.0**power))
    return power, -leading + (1 if error / 10.0 ** (power + leading) < 1.95 else 0)


def _fixed(value: float, power: int, decimals: int) -> str:
    return f"{round(value / 10.0**power, decimals) + 0.0:.{max(decimals, 0)}f}"


def number(value: float | None, digits: int = SIGNIFICANT_DIGITS) -> str:
    """A number with the digits worth reading, 0 for what rounding left of it; a dash for one that was not computed."""
    if value is None or not math.isfinite(value):
        return "–"
    text = "0" if abs(value) < ROUNDING else f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(float(text)) < PLAIN else text


def computed(value: Any) -> bool:
    """Whether a scalar has a value."""
    return isinstance(value, int | float) and math.isfinite(value)


def meaning_in(row: Mapping[str, Any], name: str) -> str:
    """What the scalar `name` means in a result with this `row`, of a contact of Hertz or not; a line has widths for areas, and
    the powers of a wheelset are those of its patches and of the rails."""
    scalar = ALL_SCALARS[name]
    hertz = computed(row.get("hertz_a_mm", 0.0)) or not scalar.without_hertz
    meaning = scalar.meaning if hertz else scalar.without_hertz
    if name.startswith("temperature_rise_") and computed(row.get("flash_temperature_max_lower_K")):  # heat comes back
        meaning = meaning.replace("temperature rise", "rise above the surroundings")
    if name == "power_balance_error" and "track_force_z_N" in row:
        return "relative mismatch of the heat of all patches and the wheelset's power"
    return meaning.replace(" area", " width") if "contact_width_mm" in row else meaning


def repeats(name: str, row: Mapping[str, Any]) -> bool:
    """Whether a stress without thermal stresses is worth no row: it reads like the one with them."""
    whole = name.removeprefix("elastic_")
    return whole != name and whole in row and scalar_text(name, row) == scalar_text(whole, row)


def is_noise(name: str, scalars: Mapping[str, Any]) -> bool:
    """Whether a force or moment is zero by symmetry but for rounding, or as it is given: nothing beside what friction carries,
    and within its error."""
    forces = [known_as(force, scalars) for force in FORCES]
    if name not in (*forces, "spin_moment_Nmm"):
        return False
    scale = math.hypot(*(scalars.get(force, 0.0) for force in forces))
    limit = min(SYMMETRY_NOISE * _number(scalars, "friction_limit_N"), _number(scalars, UNCERTAINTY + name))
    if name == "spin_moment_Nmm":
        scale, limit = scale * mean_semi_axis(scalars), 0.0
    size = abs(scalars.get(name, 0.0))
    return size <= SYMMETRY_NOISE * scale or size <= limit


# --- the points of a sweep -------------------------------------------------------------------------------------------


def worth_showing(name: str, points: Sequence[Mapping[str, Any]], swept: Collection[str]) -> bool:
    """Whether a scalar says more about the `points` (rows) than the `swept` keys do.

    These say nothing: a scalar that was not computed; a shift where everything rolls; rounding noise; one
    of the upper body that reads like that of the lower one; a creepage that is swept; a creepage or a force that is given,
    so that it stays the same while the other changes; the pressure over a single Hertz pressure, which γ_p is."""
    partners = dict(zip(ANY_FORCES, 2 * CREEPAGES, strict=True)) | {
        creepage: next((known_as(force, point) for point in points), force)
        for creepage, force in zip(CREEPAGES, FORCES, strict=True)}
    if not finite(name, points) or all(_is_nothing(name, point) for point in points if computed(point.get(name))):
        return False
    lower = name.replace("_upper_", "_lower_")
    if lower != name and all(number(point.get(name), 4) == number(point.get(lower), 4) for point in points):
        return False
    if name.startswith("shift_"):
        return any(finite(name, points))
    if name == "pressure_max_MPa":
        return not is_steady(finite("hertz_p0_MPa", points))
    if name not in partners:
        return True
    creepage = name if name in CREEPAGES else partners[name]
    if any(key.endswith("." + creepage.removeprefix("creepage_")) for key in swept):
        return name in ANY_FORCES
    other = finite(partners[name], points)
    return not (is_steady(finite(name, points)) and other and not is_steady(other))


def _is_nothing(name: str, scalars: Mapping[str, Any]) -> bool:
    noise = name in CREEPAGES and abs(scalars[name]) <= SYMMETRY_NOISE * error_scale(name, scalars)
    return noise or is_noise(known_as(OVER_LIMIT[name], scalars) if name in OVER_LIMIT else name, scalars)


def finite(name: str, points: Sequence[Mapping[str, Any]]) -> list[float]:
    """The values of a scalar at the points where it was computed."""
    return [point[name] for point in points if computed(point.get(name))]


def is_steady(values: Sequence[float]) -> bool:
    """Whether there are values, and all are the same."""
    return bool(values) and max(values) - min(values) <= STEADY * max(map(abs, values))

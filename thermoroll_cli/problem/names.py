"""Scalars and fields of a result, each declared once: name, unit, meaning, what its error is relative to, and how it is drawn.

Files, tables, comparison, exports, sweeps and pictures take them from here. The unit of a scalar is the end of its name; fields
are in SI units.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeVar

from thermoroll_cli.problem.kinds import scalars_of_contact
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.tools.arrays import Array

Scale = Literal["value", "share", "stick area", "force", "moment", "temperature", "creepage", "spin", "mismatch",
                "stress below", "place below", "resultant", "vertical", "approach", "displacement"]  # fmt: skip
"""Scales of the errors and differences of scalars: see `error_scale`."""

Kind = Literal["", "creepage", "resultant", "integral", "exchanged heat", "first order", "area", "relative area",
               "stick", "peak", "peak flux", "peak pressure", "relative peak pressure", "pressure", "diffused", "diffused mean",
               "worn", "expansion"]  # fmt: skip
"""Kinds of scalars whose errors arise alike (`error_estimates`). `SCALARS` says which scalar is of which kind."""

Condition = bool | Callable[[Problem], bool]
"""Something that holds always, never, or for the problems for which the function is true."""

PER_REVOLUTION = "_per_revolution_"
"""What names of scalars of a disc that turns have in them."""


def holds(condition: Condition, problem: Problem) -> bool:
    return condition(problem) if callable(condition) else condition


@dataclass(frozen=True)
class Scalar:
    """A number that a result reports, and all that depends on which one it is.

    - `scale`: what its error is relative to; `kind`: how its error arises.
    - `given`: the problem gives it, or it is a measure of error itself: its error is not estimated.
    - `vanishes`: rolling along or across which makes it zero if bodies and motion are their own mirror image across y = 0.
    - `accurate`: its error has to fall below `numerics.accuracy` unless `numerics.accuracy_of` names others: forces, heat,
      temperatures and pressure. What hardly sticks carries hardly anything, and may be known as badly.
    - `listed`: `run` prints it without `-v`.
    - `diagram`: the label of its diagram in the picture of a sweep, which it may share; it has a column in the printed table.
    - `brief`: a meaning for narrow terminals; `without_hertz`: the meaning if there is no Hertz contact to compare with, for
      profiles and coatings."""

    name: str
    meaning: str
    scale: Scale = "value"
    listed: Condition = False
    kind: Kind = ""
    given: Condition = False
    vanishes: Literal["", "along", "across"] = ""
    accurate: bool = False
    diagram: str = ""
    brief: str = ""
    without_hertz: str = ""

    @property
    def unit(self) -> str:
        """As people write it, "" for a pure number."""
        return unit_of(self.name)

    @property
    def together(self) -> Callable[[Iterable[float]], float] | None:
        """The value of all patches of an assembly from those of each; None if there is none."""
        if PER_REVOLUTION in self.name:
            return None
        if self.kind in ("integral", "exchanged heat", "worn", "area", "stick") and self.unit:
            return math.fsum
        if self.name.startswith("shakedown_factor"):
            return min
        largest = "_max_" in self.name or self.scale == "stress below" or self.name.startswith("fatigue_index")
        return max if largest else None


class Field(NamedTuple):
    """An array that a result holds, with its SI unit. Differences of fields of one `family` are measured by the same scale:
    components of a vector (`_x`, `_y`), and temperatures of both bodies, one of which may stay cold. A field with a `symbol`
    is drawn as it is (`QUANTITIES`)."""

    name: str
    unit: str
    meaning: str
    family: str = ""
    symbol: str = ""


@dataclass(frozen=True)
class Quantity:
    """The quantity of a map or a curve: a field, the length of the vector of two `fields`, or a field of each body.

    `maximum` is the scalar that reports the largest value ("{}" stands for the body), `normalised` the symbol of the article's
    dimensionless quantity, `colours` a perceptually uniform colour map. With `from_zero` the scale begins at 0, which means
    something.
    """

    name: str
    fields: tuple[str, ...]
    words: str
    symbol: str
    normalised: str
    colours: str = "inferno"
    maximum: str = ""
    from_zero: bool = True

    @property
    def unit(self) -> str:
        return FIELDS[self.fields[0]].unit


UNITS = {
    "creepage_s": "", "_rad_s": "rad/s", "_mm3_Nm": "mm³/(N m)", "_mm3_m": "mm³/m", "_mm3": "mm³", "_um2": "µm²", "_nm": "nm",
    "_W_mm": "W/mm", "_J_mm": "J/mm", "_mm2_m": "mm²/m",
    "_mrad_s": "mrad/s", "_um_GPa": "µm/GPa", "_MPa_um": "MPa/µm",
    "_mm_s": "mm/s", "_N_mm": "N/mm", "_km": "km", "_kg_m3": "kg/m³",
    "_kg_m": "kg/m", "_kg": "kg", "_cm3": "cm³", "_mm2_s": "mm²/s", "_um_mK": "µm/(m K)", "_W_m2K": "W/(m² K)",
    "_W_mK": "W/(m K)", "_W_mm2": "W/mm²", "_rad_mm": "rad/mm", "_mrad": "mrad", "_m_s": "m/s", "_GPa": "GPa", "_MPa": "MPa",
    "_N_um": "N/µm", "_Mrev": "Mrev", "_rpm": "rpm", "_deg": "deg", "_Nm": "N m", "_1_K": "1/K", "_K_W": "K/W", "_Nmm": "N mm",
    "_mm2": "mm²", "_mm": "mm", "_um": "µm", "_N": "N", "_K": "K", "_W": "W", "_J": "J", "_s": "s",
    "_m": "m", "_h": "h",
}  # fmt: skip
"""Ends of names of scalars and case keys, longer ones first, and the units they stand for."""

MULTIPLES: dict[str, tuple[int, tuple[tuple[str, float], ...]]] = {
    "m": (2, (("nm", 1e-9), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0))),
    "Pa": (2, (("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9))),
    "W/m2": (2, (("W/m²", 1.0), ("kW/m²", 1e3), ("W/mm²", 1e6), ("kW/mm²", 1e9), ("MW/mm²", 1e12))),
    "K": (2, (("µK", 1e-6), ("mK", 1e-3), ("K", 1.0), ("kK", 1e3), ("MK", 1e6))),
    "N": (0, (("N", 1.0), ("kN", 1e3), ("MN", 1e6))),
    "m/s": (3, (("nm/s", 1e-9), ("µm/s", 1e-6), ("mm/s", 1e-3), ("m/s", 1.0))),
}
"""Multiples of the SI units of fields in rising order, and the place of the one that this field of engineering uses."""


COLUMN_UNITS = {"Pa": ("MPa", 1e-6), "m": ("um", 1e6), "m/s": ("m_s", 1.0), "W/m2": ("W_mm2", 1e-6), "K": ("K", 1.0)}
"""SI unit of a field → the unit at the end of a column's name, as of scalars, and the factor of its values."""


ISOTHERMAL, UNCERTAINTY = "isothermal.", "uncertainty."
"""How the columns of the state without thermal deformation, and those of estimated errors, begin."""
STATES = {"isothermal": "without thermal deformation: ", "uncertainty": "estimated error: "}
"""Mappings of a summary by the names of scalars, and words before the meanings of their columns."""

ERROR = "_error"
"""End of the name of a column with the error of another one, in its unit: standard deviations of measured values."""


def unit_end(name: str) -> str:
    """The end of the name of a scalar or a case key that stands for its unit; "" for a pure number."""
    return next((end for end in UNITS if name.endswith(end)), "")


def unit_of(name: str) -> str:
    """The unit of a scalar or a case key, from its name, as people write it; "" for a pure number."""
    return UNITS.get(unit_end(name), "")


Declared = TypeVar("Declared", Field, Scalar)


def _named(*declared: Declared) -> dict[str, Declared]:
    return {each.name: each for each in declared}


def _of_both(name: str, meaning: str, scale: Scale = "value", *, brief: str = "", **others: Any) -> Iterator[Scalar]:
    """A scalar of each body; {} in its name is replaced."""
    for body in BODIES:
        yield Scalar(name.format(body), f"{meaning}, {body} body", scale, brief=f"{brief}, {body} body" if brief else "",
                     **others)


def _untracked(body: str) -> Condition:
    return lambda problem: getattr(problem.heating, f"{body}_track") is None


def _of_tracks(name: str, meaning: str, brief: str = "", **others: Any) -> Iterator[Scalar]:
    """A temperature of each body that is given unless its heat recirculates."""
    for body in BODIES:
        yield Scalar(name.format(body), f"{meaning}, {body} body", "temperature", kind="diffused", given=_untracked(body),
                     brief=f"{brief}, {body} body" if brief else "", **others)


def _still(problem: Problem) -> bool:
    return problem.motion.speed == 0.0


def _falling(problem: Problem) -> bool:
    return problem.friction.law is not None


def _leads_or_lags(problem: Problem) -> bool:
    """Whether the pressure is unsymmetric along rolling for more than heat."""
    lower, upper = problem.lower.surface, problem.upper.surface
    return problem.relaxes or (lower.shear_modulus, lower.poisson_ratio) != (upper.shear_modulus, upper.poisson_ratio)


FIELDS = _named(
    Field("pressure", "Pa", "contact pressure"),
    Field("shear_x", "Pa", "shear traction along x", "shear"),
    Field("shear_y", "Pa", "shear traction along y", "shear"),
    Field("slip_x", "m/s", "slip velocity along x", "slip"),
    Field("slip_y", "m/s", "slip velocity along y", "slip"),
    Field("state", "1", "0 out of contact, 1 stick, 2 slip"),
    Field("covered", "1", "share of the element inside the contact"),
    Field("stick_share", "1", "share of the element that sticks"),
    Field("friction_coefficient", "1", "local coefficient of friction, at the temperature and slip of the contact"),
    Field("yield_stress", "Pa", "yield stress of an interlayer that hardens, by the plastic slip so far", symbol="$\\tau_c$"),
    Field("heat_flux", "W/m2", "frictional heat flux into both bodies"),
    Field("heat_flux_lower", "W/m2", "heat flux into the lower body, friction and conduction"),
    Field("temperature_rise_lower", "K", "surface temperature rise of the lower body", "temperature_rise"),
    Field("temperature_rise_upper", "K", "surface temperature rise of the upper body", "temperature_rise"),
    Field("entry_temperature_lower", "K", "temperature with which the track enters the contact, lower body"),
    Field("entry_temperature_upper", "K", "temperature with which the track enters the contact, upper body"),
    Field("displacement_elastic", "m", "normal elastic displacement, sum of both bodies; of a line contact above its least"),
    Field("displacement_thermal", "m", "thermal expansion towards each other, sum of both bodies"),
    Field("gap", "m", "distance between the deformed surfaces"),
    Field("surface_height", "m", "height of both surfaces over their smooth shapes"),
)
"""Fields of a state."""

SCALARS = _named(
    Scalar("Q_F_W", "total frictional heat", listed=True, kind="integral", accurate=True, brief="frictional heat",
           diagram="frictional heat $Q_F$ (W)"),
    Scalar("gamma_c", "contact area / Hertz area", listed=True, kind="relative area", brief="area/Hertz area",
           diagram=r"contact area ratio $\gamma_\mathrm{c}$", without_hertz="contact area / cold area"),
    Scalar("gamma_st", "stick area / contact area", "share", listed=True, kind="stick", brief="stick/contact",
           diagram=r"stick area ratio $\gamma_\mathrm{st}$"),
    Scalar("gamma_p", "maximum pressure / Hertz peak pressure", listed=True, kind="relative peak pressure",
           diagram=r"pressure ratio $\gamma_\mathrm{p}$", brief="p_max/p0", without_hertz="maximum pressure / cold one"),
    *_of_both("temperature_rise_max_{}_K", "maximum temperature rise", "temperature", listed=True, kind="diffused",
              accurate=True, brief="maximum temperature rise", diagram=r"max. rise $\Delta T$ (K)"),
    *_of_both("temperature_rise_mean_{}_K", "temperature rise, mean over the contact", "temperature",
              kind="diffused mean", brief="mean temperature rise"),
    *_of_both("temperature_rise_centre_{}_K", "temperature rise at the centre of the contact", "temperature",
              kind="diffused", brief="temperature rise at the centre"),
    *_of_both("surface_temperature_max_{}_K", "hottest surface temperature", "temperature", kind="diffused",
              listed=lambda problem: bool(problem.heating.bulk_lower or problem.heating.bulk_upper)),
    *_of_both("temperature_interface_max_{}_K", "hottest place below the top layer of a coating", "temperature", listed=True,
              kind="diffused", brief="hottest below the top coating"),
    *_of_tracks("bulk_temperature_{}_K", "bulk temperature, the mean of the whole surface", listed=True,
                 brief="bulk temperature"),
    *_of_tracks("entry_temperature_max_{}_K", "hottest entering track"),
    *_of_both("flash_temperature_max_{}_K", "flash temperature, the rise of this pass", "temperature", listed=True,
              kind="diffused", brief="flash temperature"),
    Scalar("heat_into_lower_W", "heat into the lower body", kind="exchanged heat"),
    Scalar("heat_into_upper_W", "heat into the upper body", kind="exchanged heat"),
    Scalar("heat_conducted_W", "heat conducted to the colder body", kind="exchanged heat",
           listed=lambda problem: problem.heating.conducts, given=lambda problem: not problem.heating.conducts),
    Scalar("recirculation_bulge_um", "thermal crown over the contact", kind="expansion"),
    Scalar("thermal_crown_ratio", "curvatures of thermal crown / gap", kind="first order"),
    *_of_both("warm_up_time_{}_s", "warm-up time", given=True),
    Scalar("force_x_N", "longitudinal creep force", "force", listed=True, kind="resultant", accurate=True,
           given=lambda problem: problem.motion.force_x is not None, vanishes="across", diagram="creep force $F_x$ (N)"),
    Scalar("force_y_N", "lateral creep force", "force", listed=True, kind="resultant", accurate=True,
           given=lambda problem: problem.motion.force_y is not None, vanishes="along", diagram="creep force $F_y$ (N)"),
    Scalar("spin_moment_Nmm", "spin moment", "moment", listed=True, kind="resultant", vanishes="along",
           diagram="spin moment $M_z$ (N mm)"),
    Scalar("contact_y_mm", "lateral place of the centre of pressure", "place below", listed=True, vanishes="along",
           brief="centre of pressure, y"),
    Scalar("spin_moment_at_contact_Nmm", "spin moment about the place of the contact", "moment", listed=True, vanishes="along",
           brief="spin moment at the contact"),
    Scalar("contact_force_y_N", "lateral resultant of pressure and traction on the upper body", "resultant", listed=True,
           vanishes="along", brief="lateral resultant"),
    Scalar("contact_force_z_N", "resultant of pressure and traction on the upper body along z", "resultant", listed=True,
           given=lambda problem: problem.vertical is not None, brief="resultant along z"),
    Scalar("T_gamma_N", "wear number Tγ, frictional heat over rolling speed", kind="integral", brief="wear number Tγ"),
    Scalar("T_gamma_without_spin_N", "wear number of the creep forces alone, |F_x ξ_x| + |F_y ξ_y|", kind="integral",
           brief="wear number Tγ without spin"),
    Scalar("creepage_longitudinal", "longitudinal creepage", "creepage", kind="creepage", accurate=True,
           listed=lambda problem: problem.motion.creepage_x is None, given=lambda problem: problem.motion.force_x is None,
           diagram=r"creepage $\xi_x$"),
    Scalar("creepage_lateral", "lateral creepage", "creepage", kind="creepage", accurate=True,
           listed=lambda problem: problem.motion.creepage_y is None, given=lambda problem: problem.motion.force_y is None,
           diagram=r"creepage $\xi_y$"),
    Scalar("creepage_spin_rad_mm", "spin", "spin", given=True),
    Scalar("normal_N", "normal load", kind="pressure",
           listed=lambda problem: not problem.load_is_given or problem.hertz_pressure is not None,
           given=lambda problem: problem.load_is_given),
    Scalar("pressure_max_MPa", "maximum pressure", listed=True, kind="peak pressure", accurate=True,
           diagram="max. pressure (MPa)"),
    Scalar("pressure_centre_MPa", "pressure at the centre of the contact", kind="pressure"),
    Scalar("shear_max_MPa", "maximum shear traction of the surface", listed=True, kind="peak"),
    Scalar("heat_flux_max_W_mm2", "maximum heat flux", kind="peak flux"),
    Scalar("approach_um", "rigid-body approach", kind="pressure", given=lambda problem: problem.approach is not None),
    Scalar("contact_area_mm2", "contact area", listed=True, kind="area"),
    Scalar("stick_area_mm2", "stick area", "stick area", kind="stick"),
    Scalar("thermal_displacement_max_um", "thermal displacement, variation over the contact (sum of both bodies)", listed=True,
           kind="expansion", brief="thermal displacement, both bodies"),
    Scalar("partition_mean", "share of the frictional heat that enters the lower body", kind="first order",
           listed=lambda problem: problem.heating.partition == "matched",
           given=lambda problem: problem.heating.partition != "matched", brief="heat share of the lower body"),
    *_of_both("wear_area_{}_um2", "area worn off per passage", listed=True, kind="worn"),
    *_of_both("wear_depth_max_{}_nm", "largest depth worn off per passage", listed=True, kind="diffused",
              brief="depth worn off per passage"),
    *_of_both("wear_rate_{}_mm3_m", "volume worn off per distance rolled", kind="worn", brief="volume worn per distance"),
    *_of_both(f"wear{PER_REVOLUTION}{{}}_mm3", "volume worn off in one revolution", listed=True, kind="worn",
              brief="volume worn per revolution"),
    *_of_both(f"heat{PER_REVOLUTION}{{}}_J", "frictional heat in one revolution", listed=True, kind="integral",
              brief="frictional heat per revolution"),
    Scalar("friction_mean", "mean coefficient of friction where surfaces slide, by pressure",
           listed=lambda problem: problem.friction.law is not None or bool(problem.friction.across),
           brief="mean coefficient of sliding friction"),
    Scalar("falling_friction_criterion", "steepness of falling friction over the stiffness of an element",
           brief="fall of friction / element stiffness"),
    Scalar("hysteresis_W", "power that bodies lose inside as they relax", listed=True, kind="integral", accurate=True,
           brief="loss inside the bodies", diagram="loss inside the bodies (W)"),
    Scalar("rolling_resistance_N", "rolling resistance, that power over the rolling speed", listed=True, kind="integral",
           brief="rolling resistance", diagram="rolling resistance (N)"),
    Scalar("rolling_resistance_moment_Nmm", "moment of the pressure about the middle of the undeformed contact",
           listed=_leads_or_lags, kind="integral", brief="moment of the pressure"),
    Scalar("expansion_power_W", "power that thermal expansion under pressure gives to the rolling", kind="integral",
           brief="power of the expansion"),
    Scalar("power_balance_error", "share of the frictional heat in slip zones narrower than an element", "mismatch", given=True,
           brief="heat of unresolved slip"),
)  # fmt: skip
"""Scalars of a state, in the order they are reported."""

QUANTITIES = {quantity.name: quantity for quantity in (
    Quantity("pressure", ("pressure",), "pressure", "p", "p/p₀", "viridis", "pressure_max_MPa"),
    Quantity("traction", ("shear_x", "shear_y"), "shear traction", "|τ|", "|τ|/p₀", "viridis", "shear_max_MPa"),
    Quantity("heat_flux", ("heat_flux",), "heat flux", "q", "q α l/k", "inferno", "heat_flux_max_W_mm2"),
    Quantity("temperature", ("temperature_rise_lower", "temperature_rise_upper"), "temperature rise", "ΔT", "ΔT", "inferno",
             "temperature_rise_max_{}_K", from_zero=False),
    Quantity("friction", ("friction_coefficient",), "coefficient of friction", "μ", "μ", "viridis", from_zero=False),
    Quantity("surface_height", ("surface_height",), "height of the surfaces", "h", "h", "cividis", from_zero=False),
    *(Quantity(field.name, (field.name,), field.name.replace("_", " "), field.symbol, field.symbol) for field in FIELDS.values()
      if field.symbol),
)}  # fmt: skip
"""Quantities that the pictures of a run show, in their order."""

PROBLEM_SCALARS = _named(
    Scalar("hertz_a_mm", "Hertz semi-axis along x"),
    Scalar("hertz_b_mm", "Hertz semi-axis along y"),
    Scalar("hertz_p0_MPa", "Hertz peak pressure"),
    Scalar("friction_limit_N", "friction limit μW"),
    *_of_both("peclet_{}", "Péclet number v a0/κ"),
    Scalar("kalker_C11", "Kalker's longitudinal creepage coefficient"),
    Scalar("kalker_C22", "Kalker's lateral creepage coefficient"),
    Scalar("kalker_C23", "Kalker's coefficient of spin and lateral force"),
    Scalar("shear_modulus_GPa", "combined shear modulus of both bodies"),
    Scalar("creep_force_max_N", "maximum of the creep curve, where friction falls with slip", listed=_falling,
           brief="maximum of the creep curve"),
    Scalar("creepage_at_creep_force_max", "creepage at the maximum of the creep curve", listed=_falling),
    Scalar("creepage_falling_branch", "creepage of the same force beyond the maximum"),
)
"""Scalars that belong to the problem and not to a state: of Hertz's contact, of Kalker's theory, of the creep curve."""

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_xz", "stress_yz")

SUBSURFACE_FIELDS = _named(
    Field("von_mises", "Pa", "von Mises stress"),
    Field("von_mises_elastic", "Pa", "von Mises stress without thermal stresses"),
    Field("temperature_rise", "K", "temperature rise"),
    Field("stress_xx", "Pa", "normal stress along x"),
    Field("stress_yy", "Pa", "normal stress along y"),
    Field("stress_zz", "Pa", "normal stress along z"),
    Field("stress_xy", "Pa", "shear stress xy"),
    Field("stress_xz", "Pa", "shear stress xz, z into the body"),
    Field("stress_yz", "Pa", "shear stress yz, z into the body"),
)
"""Fields inside a body; tension is positive, z points into the body."""

STRENGTH_FIELDS = _named(
    Field("shakedown_k", "Pa", "shear yield stress that shakedown needs"),
    Field("elastic_shakedown_k", "Pa", "shear yield stress that shakedown needs without thermal stresses"),
    Field("elastic_limit_k", "Pa", "shear yield stress that no von Mises stress exceeds"),
    Field("residual_xx", "Pa", "residual stress along x of the shakedown state"),
    Field("residual_yy", "Pa", "residual stress along y of the shakedown state"),
    Field("residual_xy", "Pa", "residual shear stress xy of the shakedown state"),
    Field("alternating_k", "Pa", "shear yield stress below which plastic strain alternates"),
    Field("dang_van", "Pa", "Dang Van's stress"),
)
"""Shakedown and fatigue of a body over depth, and over depth and y."""

STRENGTH_SCALARS = _named(*(
    Scalar(name.format(body), f"{meaning}, {body} body", scale, listed)  # type: ignore[arg-type]
    for body in BODIES
    for name, meaning, scale, listed in (
        ("shakedown_k_{}_MPa", "shear yield stress that shakedown needs", "stress below", True),
        ("shakedown_k_below_{}_MPa", "the same below the surface", "stress below", False),
        ("shakedown_k_surface_{}_MPa", "the same at the surface", "stress below", False),
        ("shakedown_depth_{}_mm", "depth that governs shakedown", "place below", True),
        ("elastic_shakedown_k_{}_MPa", "shear yield stress that shakedown needs without thermal stresses", "stress below",
         False),
        ("shakedown_factor_{}", "shear yield stress over the one that shakedown needs", "value", True),
        ("alternating_k_{}_MPa", "shear yield stress below which plastic strain alternates", "stress below", True),
        ("alternating_k_below_{}_MPa", "the same below the surface", "stress below", False),
        ("alternating_k_surface_{}_MPa", "the same at the surface", "stress below", False),
        ("dang_van_max_{}_MPa", "largest Dang Van stress", "stress below", True),
        ("dang_van_max_below_{}_MPa", "the same below the surface", "stress below", False),
        ("dang_van_max_surface_{}_MPa", "the same at the surface", "stress below", False),
        ("dang_van_depth_{}_mm", "depth of the largest Dang Van stress", "place below", True),
        ("fatigue_index_surface_{}", "surface fatigue index, utilised friction less k/p₀", "share", True),
    )
))  # fmt: skip

BOND_SCALARS = _named(*(
    Scalar(f"{name}_max_{body}_MPa", f"{meaning}, {body} body", "stress below", True)
    for body in BODIES
    for name, meaning in (
        ("interface_shear", "largest shear stress of an interface below or in a coating"),
        ("interface_tension", "largest tension across such an interface"),
        ("layer_tension", "largest first principal stress in the coating"),
    )
))  # fmt: skip
"""Stresses that detach or crack coatings."""

SUBSURFACE_SCALARS = STRENGTH_SCALARS | BOND_SCALARS | _named(*(
    Scalar(f"{prefix}{name.format(body)}", f"{meaning}{without}, {body} body",
           "stress below" if name.endswith("_MPa") else "place below", listed, diagram="" if prefix else diagram)
    for body in BODIES
    for prefix, without in (("", ""), ("elastic_", " without thermal stresses"))
    for name, meaning, listed, diagram in (
        ("von_mises_max_{}_MPa", "largest von Mises stress", not prefix, "max. von Mises stress (MPa)"),
        ("von_mises_depth_{}_mm", "its depth", not prefix, "depth of max. von Mises stress (mm)"),
        ("von_mises_x_{}_mm", "its place along x", False, ""),
        ("von_mises_y_{}_mm", "its place along y", False, ""),
        ("orthogonal_shear_range_max_{}_MPa", "largest range of σ_xz along a line of rolling", not prefix, ""),
        ("orthogonal_shear_range_depth_{}_mm", "its depth", False, ""),
        ("tensile_stress_max_{}_MPa", "largest first principal stress", not prefix, "max. tensile stress (MPa)"),
        ("tresca_shear_max_{}_MPa", "largest shear stress in any plane, half of Tresca's stress", not prefix, ""),
        ("tresca_shear_depth_{}_mm", "its depth", not prefix, ""),
    )
))  # fmt: skip
"""Scalars of the stresses inside both bodies, in the order they are reported."""

_SIDES = ("left", "right")

TOGETHER = {name: scalar for name, scalar in (SCALARS | SUBSURFACE_SCALARS).items() if scalar.together is not None}
"""Scalars of a contact that an assembly has, too: the sum, or the largest, of those of its patches."""


ALSO_LISTED = ("T_gamma_N", "power_balance_error")
"""Scalars that are listed besides the others for an assembly."""


def of_side(name: str, side: str) -> str:
    """The name of a scalar of one side: `Q_F_left_W`."""
    end = unit_end(name)
    return f"{name.removesuffix(end)}_{side}{end}"


WHEELSET_SCALARS = _named(
    Scalar("height_mm", "place of the axle below its nominal one", "approach", listed=True),
    Scalar("roll_mrad", "roll, right wheel down", "share", listed=True, diagram="roll (mrad)"),
    Scalar("angular_velocity_rad_s", "angular velocity, forward", listed=True, diagram="angular velocity (rad/s)"),
    *(Scalar(f"track_force_{axis}_{side}_N", f"{direction} force on the {side} rail", "vertical", listed=True,
             diagram=f"lateral force, {side} rail (N)" if axis == "y" else "")
      for side in _SIDES for axis, direction in (("x", "longitudinal"), ("y", "lateral"), ("z", "vertical"))),
    *(Scalar(f"track_force_{axis}_N", f"{direction} force on both rails", "vertical", listed=True)
      for axis, direction in (("x", "longitudinal"), ("y", "lateral"), ("z", "vertical"))),
    *(Scalar(f"lateral_over_vertical_{side}", f"lateral over vertical force on the {side} rail", "share", listed=True)
      for side in _SIDES),
    *(Scalar(f"rolling_radius_{side}_mm", f"distance of the {side} patch with the largest load from the axle", listed=True)
      for side in _SIDES),
    Scalar("position_mm", "place of the axle along a track that changes", given=True),
    Scalar("rotation_deg", "angle by which wheels that change around themselves have turned", given=True),
    *(Scalar(f"surface_height_{side}_um", f"by how much the surfaces lift the {side} wheel at first contact", given=True,
             diagram=f"lift by surfaces, {side} wheel (µm)") for side in _SIDES),
    *(Scalar(f"contact_spots_{side}", f"parts of the contacts of the {side} wheel that hang together", given=True,
             diagram=f"spots of the contacts, {side} wheel") for side in _SIDES),
    Scalar("approach_max_um", "largest approach of a wheel and a rail", listed=True),
    Scalar("rolling_radius_difference_mm", "rolling radius, right less left", "share", listed=True,
           diagram="rolling radius difference (mm)"),
    Scalar("temperature_rise_max_K", "maximum temperature rise of all patches", listed=True,
           diagram=r"max. rise $\Delta T$ (K)"),
    *(Scalar(of_side(scalar.name, side), f"{scalar.meaning}, {side} wheel",
             listed=scalar.listed or scalar.name in ALSO_LISTED)
      for scalar in TOGETHER.values() if scalar.together is math.fsum for side in _SIDES),
)  # fmt: skip
"""Scalars of a wheelset besides `TOGETHER` and `power_balance_error`."""

BEARING_SCALARS = _named(
    Scalar("axial_displacement_um", "axial displacement of the inner ring, from the middle", "displacement", listed=True,
           diagram="axial displacement (µm)"),
    Scalar("radial_displacement_um", "displacement of the inner ring towards ball 1", "displacement", listed=True,
           diagram="radial displacement (µm)"),
    Scalar("radial_displacement_across_um", "displacement of the inner ring across the radial load", "displacement"),
    Scalar("tilt_mrad", "tilt of the inner ring, which presses ball 1 axially", listed=True, diagram="tilt (mrad)"),
    Scalar("tilt_across_mrad", "tilt of the inner ring about the radial load"),
    Scalar("cage_speed_rad_s", "speed of the cage, mean of the balls", listed=True, diagram="speed of the cage (rad/s)"),
    Scalar("cage_speed_rpm", "speed of the cage in turns per minute", listed=True),
    Scalar("torque_Nmm", "torque by the friction of the contacts, without film, cage and seals", listed=True,
           diagram="torque of friction (N mm)", brief="torque of the contacts' friction"),
    Scalar("torque_from_forces_Nmm", "the same from forces, not from heat", listed=True),
    Scalar("axial_stiffness_N_um", "axial stiffness", listed=True, diagram="axial stiffness (N/µm)"),
    Scalar("radial_stiffness_N_um", "radial stiffness", listed=True, diagram="radial stiffness (N/µm)"),
    Scalar("life_L10r_Mrev", "reference rating life after ISO/TS 16281", listed=True, diagram="life $L_{10r}$ (Mrev)"),
    Scalar("life_L10r_h", "reference rating life in hours, at the speed of the rings against each other", listed=True),
)  # fmt: skip
"""Scalars of a ball bearing besides `TOGETHER`."""

BALL_SCALARS = _named(
    Scalar("normal_N", "normal force", listed=True),
    Scalar("contact_angle_deg", "contact angle", listed=True),
    Scalar("rolling_speed_m_s", "rolling speed", listed=True),
    Scalar("creepage_longitudinal", "longitudinal creepage", listed=True),
    Scalar("creepage_lateral", "lateral creepage", listed=True),
    Scalar("creepage_spin_rad_mm", "spin", listed=True),
    Scalar("spin_to_roll", "spin over rolling", listed=True),
    Scalar("ball_pitch_deg", "pitch of the ball's axis", listed=True),
    Scalar("ball_yaw_deg", "yaw of the ball's axis"),
    Scalar("ball_speed_rad_s", "angular velocity of the ball in the frame of the cage"),
    Scalar("cage_speed_rad_s", "speed at which the ball goes round"),
)  # fmt: skip
BALL_SCALARS |= {name: scalar for name, scalar in (SCALARS | SUBSURFACE_SCALARS).items() if name not in BALL_SCALARS}
"""Scalars of a contact of a ball bearing: those of its ball, and those of any contact."""

ASSEMBLY_SCALARS = WHEELSET_SCALARS | BEARING_SCALARS

ACROSS = ("approach_um", "spin_moment_Nmm", "contact_y_mm", "spin_moment_at_contact_Nmm", "contact_force_y_N",
          "contact_force_z_N", "T_gamma_without_spin_N", "creepage_spin_rad_mm", "recirculation_bulge_um",
          "thermal_crown_ratio", "hertz_b_mm", "kalker_C11", "kalker_C22", "kalker_C23",
          *(name.format(body) for body in BODIES for name in (
              "bulk_temperature_{}_K", "entry_temperature_max_{}_K", "flash_temperature_max_{}_K", "warm_up_time_{}_s",
              "wear_area_{}_um2", "von_mises_y_{}_mm", "elastic_von_mises_y_{}_mm")))  # fmt: skip
"""Scalars that a line contact does not have: no approach, and nothing that varies across."""


def _of_length(name: str) -> str:
    """The name of a scalar of a line contact, per mm of length if it is a force, a power, an energy, an area or a volume; "" if
    it has none."""
    if name in ACROSS:
        return ""
    ends = {"_area_mm2": "_width_mm", "_mm3_m": "_mm2_m", "_mm3": "_mm2", "_Nmm": "_N", "_N": "_N_mm", "_W": "_W_mm",
            "_J": "_J_mm"}
    end = next((end for end in ends if name.endswith(end)), "")
    return name.removesuffix(end) + ends.get(end, "")


IN_CONTACT = {"force_s_N": "force_y_N", "moment_n_Nmm": "spin_moment_Nmm"}
"""Scalars of a patch in the axes of the track by their names in the contact, where these differ."""

PATCH_SCALARS = _named(
    Scalar("x_mm", "place of the centre of pressure, along the track", listed=True),
    Scalar("y_mm", "place of the centre of pressure, across the track", listed=True),
    Scalar("z_mm", "place of the centre of pressure, downwards"),
    Scalar("angle_mrad", "contact angle", listed=True),
    Scalar("y_rail_mm", "place in the profile of the rail", listed=True),
    Scalar("y_wheel_mm", "place in the profile of the wheel", listed=True),
    Scalar("normal_N", "normal force on the rail", listed=True),
    Scalar("force_x_N", "longitudinal force on the rail", listed=True),
    Scalar("force_s_N", "force on the rail along the lateral direction of the patch", listed=True),
    Scalar("moment_n_Nmm", "moment on the rail about the normal"),
    Scalar("creepage_x", "longitudinal creepage", listed=True),
    Scalar("creepage_s", "lateral creepage", listed=True),
    Scalar("spin_rad_mm", "spin", listed=True),
)  # fmt: skip
PATCH_SCALARS |= {name: replace(scalar, listed=scalar.listed or name in ALSO_LISTED)
                  for name, scalar in (SCALARS | SUBSURFACE_SCALARS).items()
                  if not (scalar.vanishes or scalar.scale in ("force", "moment", "resultant", "creepage", "spin"))
                  and name not in PATCH_SCALARS}
"""Scalars of a patch of a wheelset, in track axes, in the order they are reported: those of a contact but for signs that depend
on its own axes."""

PLACES = _named(Scalar("distance_mm", "distance rolled"), Scalar("time_s", "time"))
"""Columns of a history that say when."""

HISTORY_SCALARS = _named(
    Scalar("shift_x_um", "longitudinal shift without rolling", listed=_still,
           diagram="longitudinal shift (µm)"),
    Scalar("shift_y_um", "lateral shift without rolling", listed=_still, diagram="lateral shift (µm)"),
    Scalar("elastic_energy_J", "elastic energy of the shear tractions"),
    Scalar("work_J", "work of the tractions since the start", listed=True),
    Scalar("heat_J", "frictional heat since the start", listed=True),
    Scalar("contact_spots", "parts of the contact that hang together", listed=True, given=True, diagram="spots of the contact"),
    Scalar("pressure_max_smooth_MPa", "maximum pressure of the same load without heights", listed=True, given=True),
    *(Scalar(f"surface_{body}_{axis}_mm", f"distance that the surface of the {body} body has moved {way}", given=True)
      for body in BODIES for axis, way in (("x", "along rolling"), ("y", "across rolling"))),
)  # fmt: skip
"""Scalars of a contact over time besides those of its state."""

PER_LENGTH = {name: of_length for declared in (SCALARS, PROBLEM_SCALARS, HISTORY_SCALARS) for name in declared
              if (of_length := _of_length(name)) not in ("", name)}
"""Scalars of which a line contact has a value per mm of length: their name → the name of that."""

_OF_LINES = {of_length: replace(
    scalar, name=of_length, diagram=re.sub(r"\((N|W)\)$", r"(\1/mm)", scalar.diagram),
    meaning=scalar.meaning.replace(" area", " width") if "_width" in of_length else f"{scalar.meaning}, per length")
    for declared in (SCALARS, PROBLEM_SCALARS, HISTORY_SCALARS) for name, scalar in declared.items()
    if (of_length := PER_LENGTH.get(name, ""))}

LINE_SCALARS, LINE_PROBLEM_SCALARS = (
    _named(*(_OF_LINES.get(of_length, scalar) for name, scalar in declared.items() if (of_length := _of_length(name))))
    for declared in (SCALARS, PROBLEM_SCALARS))
"""What a line contact has in place of `SCALARS` and `PROBLEM_SCALARS`."""

ALL_SCALARS = _named(*(each for name, scalar in (SCALARS | HISTORY_SCALARS | PROBLEM_SCALARS).items()
                       for each in (scalar, _OF_LINES.get(PER_LENGTH.get(name, ""))) if each)
                     ) | SUBSURFACE_SCALARS | ASSEMBLY_SCALARS


Numbers = TypeVar("Numbers", float, Array)


def per_length(scalars: Mapping[str, Numbers]) -> dict[str, Numbers]:
    """The `scalars` of a line contact, numbers or columns, per m of length under the names of others, under its own names per
    mm."""
    known = {name: PER_LENGTH.get(name, name) for name in scalars}
    return {of: scalars[name] * (1.0 if of == name else 1e-3) for name, of in known.items() if of not in ACROSS}


def known_as(name: str, row: Iterable[str]) -> str:
    """The name under which `row` has a scalar: its own, or in a line contact that per length."""
    of_length = PER_LENGTH.get(name, name)
    return of_length if of_length in row and name not in row else name


WEAR_COLUMNS = {
    "distance_km": "distance rolled", "cycles_": "passages", "depth_max_": "largest worn depth",
    "worn_area_": "worn cross-section", "worn_volume_": "worn volume", "worn_mass_": "worn mass", "half_width_mm":
    "half-width of the contact", "line_load_max_N_mm": "largest line load", "flange_height_": "flange height Sh",
    "flange_thickness_": "flange thickness Sd", "flange_qR_": "flange gradient qR",
    "conicity_3mm": "equivalent conicity at 3 mm", "elements": "elements of the largest grid of a patch",
}  # fmt: skip
"""Columns of an evolution besides scalars of results, or how their names begin, with their meanings."""

OVER_LIMIT = {"force_x_over_friction_limit": "force_x_N", "force_y_over_friction_limit": "force_y_N"}
"""Creep forces over μW, as railway engineers plot them: column of a table → scalar in N."""


def check_scalar(name: str, said: str = "") -> None:
    """Raises ValueError where no scalar is called `name`: names the one that is meant, and quotes what was `said`."""
    names = (*OVER_LIMIT, *ALL_SCALARS)
    if name not in names:
        near = difflib.get_close_matches(name, names, 1)
        raise ValueError(f"{said}no scalar is called {name}" + (f"; did you mean {near[0]}?" if near else ""))


def over_limit(scalars: Mapping[str, Any]) -> dict[str, float]:
    """The columns `OVER_LIMIT` of a state, with their errors if the row has those of the forces."""
    limit = scalars.get(known_as("friction_limit_N", scalars), math.nan)
    if not limit > 0.0:
        return {}
    of_forces = {f"{prefix}{name}": f"{prefix}{known_as(force, scalars)}"
                 for prefix in ("", UNCERTAINTY) for name, force in OVER_LIMIT.items()}
    return {name: scalars[force] / limit for name, force in of_forces.items() if scalars.get(force) is not None}


DIAGRAMS: dict[str, tuple[str, ...]] = {
    label: tuple(name for name, scalar in ALL_SCALARS.items() if scalar.diagram == label)
    for label in dict.fromkeys(scalar.diagram for scalar in ALL_SCALARS.values()) if label
}
"""Labels of the diagrams of a sweep and the scalars that each shows: one, or that of the lower and that of the upper body."""


def column_of(name: str, keys: Collection[str] = ()) -> tuple[str, str]:
    """Unit and meaning of a column of a table in which `keys` vary: one of them, a scalar, that of a state or of a patch
    (`uncertainty.NAME`, `left_1.NAME`), or one of `WEAR_COLUMNS`."""
    *parts, own = name.split(".")
    patch, state = (next((part for part in parts if (part in STATES) == known), "") for known in (False, True))
    scalars = scalars_of_contact(patch) if patch else PLACES | ALL_SCALARS
    if name in keys and name not in PLACES:
        return unit_of(name), f"varied key {name}"
    if own in scalars:
        return scalars[own].unit or "1", (f"patch {patch}: " if patch else "") + STATES.get(state, "") + scalars[own].meaning
    base = next((base for base in WEAR_COLUMNS if own == base or (base.endswith("_") and own.startswith(base))), None)
    if base is None:
        return "", name
    whose = own.removeprefix(base).removesuffix(unit_end(own))
    body, _, side = whose.partition("_")
    what = f"{side} {body}" if side else f"{body} body" if body in BODIES else body
    return unit_of(own) or "1", STATES.get(state, "") + WEAR_COLUMNS[base] + (f", {what}" if what else "")


def of_kind(*kinds: Kind) -> tuple[str, ...]:
    """Names of the scalars of a state of one of these kinds."""
    return tuple(name for name, scalar in SCALARS.items() if scalar.kind in kinds)


OF_PRESSURE = "rolling_resistance_moment_Nmm", "expansion_power_W"
"""What the pressure does as it is not symmetric along rolling. It may be next to nothing, so no group asks for its accuracy."""


def _group(scalar: Scalar) -> str:
    """The group of scalars that `numerics.accuracy_of` names, to which one belongs; "" if to none."""
    if scalar.name.startswith("wear_"):
        return "wear"
    if scalar.scale == "temperature":
        return "temperatures"
    if scalar.name in OF_PRESSURE:
        return ""
    if scalar.kind in ("integral", "exchanged heat") or scalar.name.startswith("torque_"):
        return "heat"
    if scalar.name.endswith("_MPa"):
        return "stresses"
    if scalar.kind in ("relative area", "relative peak pressure", "stick", "area"):
        return "shares"
    of_forces = scalar.kind in ("resultant", "creepage", "pressure") or scalar.scale in ("vertical", "approach")
    return "forces" if of_forces or scalar.name in ("angular_velocity_rad_s", "roll_mrad") else ""


GROUPS: dict[str, tuple[str, ...]] = {
    group: tuple(name for name, scalar in (SCALARS | SUBSURFACE_SCALARS | ASSEMBLY_SCALARS).items()
                 if group in (_group(scalar), "all"))
    for group in ("forces", "heat", "temperatures", "stresses", "shares", "wear", "all")}
"""Groups of scalars whose accuracy may be asked for together."""


def of_contacts(asked: Iterable[str]) -> frozenset[str]:
    """Scalars of a contact that scalars and groups in `asked` stand for. Those of an assembly stand for the ones that they come
    from: a sum of one wheel for its scalar, torques for heat, places and forces on rails for the forces of the contacts."""
    whole = {of_length: name for name, of_length in PER_LENGTH.items()}
    names = {whole.get(name, name) for each in asked for name in GROUPS.get(each, (each,))}
    own = {name for name in names if name in SCALARS or name in SUBSURFACE_SCALARS}
    sums = {of_side(scalar, side): scalar for side in _SIDES for scalar in TOGETHER}
    own |= {scalar for name, scalar in sums.items() if name in names}
    if any(name.startswith("torque_") for name in names):
        own.add("Q_F_W")
    others = {name for name in names - own - sums.keys() if not name.startswith("torque_")}
    return frozenset(own | ({*GROUPS["forces"]} & {*SCALARS} if others else set()))
